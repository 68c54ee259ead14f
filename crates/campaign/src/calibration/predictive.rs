//! What a posterior predicts, beside what was counted.
//!
//! Definition. The predicted count of a way to fail in `n` opportunities is binomial with the rate
//! of each point of the posterior, mixed by weight; of opportunities in clusters, the sum of beta
//! binomials with the correlations that the fitted counts leave probable (the prior's, of a way to
//! fail that was held out). The p-value is twice the smaller of `P(K <= k)` and `P(K >= k)`, half of
//! `P(K = k)` counted in each (mid-p), at most 1. For what was held out it tests the simulator; for
//! what was fitted it only shows whether the simulator could be brought to reproduce it.
//!
//! Source: G. E. P. Box (1980); A. Gelman, X.-L. Meng and H. Stern (1996); mid-p by H. O. Lancaster
//! (1961). Cost: nodes with weight times `n`, with clusters times `n^2`. Guarantee: that of the
//! posterior; rates are gathered at nodes 0.04 logits apart.

use super::inference::{Counted, Observed};
use super::likelihood::{Likelihood, cluster_masses, node_rate, nodes, place};
use super::posterior::Posterior;

/// Nodes with less weight than this share of the whole are left out of sums.
const NEGLIGIBLE: f64 = 1e-6;

/// Predicted against counted.
#[derive(Debug, Clone, PartialEq)]
pub struct Predictive {
    /// What was counted.
    pub observed: Observed,
    /// The mean predicted rate.
    pub rate: f64,
    /// The posterior mean of the intraclass correlation; `None` without clusters.
    pub correlation: Option<f64>,
    /// Of what was counted (all of it fitted, or all of it held out).
    pub counted: Prediction,
    /// Of the runs that were held out; `None` if there are none.
    pub held_out_runs: Option<Prediction>,
}

/// A count beside its prediction.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// What was counted.
    pub occurrences: u64,
    /// Of so many.
    pub opportunities: u64,
    /// Counts between which at least 95 % of the predictions lie.
    pub low: u64,
    /// Upper end.
    pub high: u64,
    /// Two-sided predictive mid-p-value; `None` without opportunities.
    pub p_value: Option<f64>,
}

impl Predictive {
    pub(super) fn of(observed: &Observed, posterior: &Posterior, mode: usize) -> Self {
        let likelihood = Likelihood::of(observed);
        let rates = gathered(posterior, mode);
        let mean = posterior.rates(mode).map(|(rate, w)| rate * w).sum();
        let predicted = |counts: &[Counted], clustered: bool| {
            let masses = masses(&likelihood, &rates, counts, clustered);
            Prediction::of(counts, &masses)
        };
        let clustered = !observed.clusters.is_empty();
        let whole = [Counted {
            occurrences: observed.occurrences,
            opportunities: observed.opportunities,
        }];
        let counts = match clustered {
            true => &observed.clusters[..],
            false => &whole[..],
        };
        let held_out = &observed.held_out_runs;
        Self {
            observed: observed.clone(),
            rate: mean,
            correlation: clustered.then(|| mean_correlation(&likelihood, &rates)),
            counted: predicted(counts, clustered),
            held_out_runs: (!held_out.is_empty()).then(|| predicted(held_out, clustered)),
        }
    }
}

impl Prediction {
    fn of(counts: &[Counted], masses: &[f64]) -> Self {
        let opportunities = counts.iter().map(|it| it.opportunities).sum();
        let occurrences: u64 = counts.iter().map(|it| it.occurrences).sum();
        let k = occurrences as usize;
        let (below, above): (f64, f64) = (
            masses[..k].iter().sum(),
            masses[(k + 1).min(masses.len())..].iter().sum(),
        );
        let tail = below.min(above) + 0.5 * masses.get(k).copied().unwrap_or(0.0);
        Self {
            occurrences,
            opportunities,
            low: quantile(masses, 0.025),
            high: quantile(masses, 0.975),
            p_value: (opportunities > 0).then(|| (2.0 * tail).min(1.0)),
        }
    }
}

/// The weights of the posterior's rates at the nodes, those that count.
fn gathered(posterior: &Posterior, mode: usize) -> Vec<(usize, f64)> {
    let mut weights = vec![0.0; nodes()];
    for (rate, weight) in posterior.rates(mode) {
        let (node, share) = place(rate);
        weights[node] += weight * (1.0 - share);
        weights[node + 1] += weight * share;
    }
    let kept = weights.into_iter().enumerate();
    let kept: Vec<(usize, f64)> = kept.filter(|(_, weight)| *weight > NEGLIGIBLE).collect();
    let total: f64 = kept.iter().map(|(_, weight)| weight).sum();
    kept.into_iter().map(|(n, w)| (n, w / total)).collect()
}

fn mean_correlation(likelihood: &Likelihood, rates: &[(usize, f64)]) -> f64 {
    let at = |node: usize| -> f64 { likelihood.correlations(node).map(|(r, w)| r * w).sum() };
    rates.iter().map(|(node, weight)| weight * at(*node)).sum()
}

/// Probabilities of all counts.
fn masses(
    likelihood: &Likelihood,
    rates: &[(usize, f64)],
    counts: &[Counted],
    clustered: bool,
) -> Vec<f64> {
    let total: u64 = counts.iter().map(|it| it.opportunities).sum();
    let mut sum = vec![0.0; total as usize + 1];
    for (node, weight) in rates {
        let correlations: Vec<(f64, f64)> = match clustered {
            true => likelihood.correlations(*node).collect(),
            false => vec![(0.0, 1.0)],
        };
        for (correlation, share) in correlations {
            let masses = sum_of_clusters(counts, node_rate(*node), correlation);
            let parts = sum.iter_mut().zip(masses);
            parts.for_each(|(sum, mass)| *sum += weight * share * mass);
        }
    }
    sum
}

/// Probabilities of the sum of independent clusters' counts.
fn sum_of_clusters(counts: &[Counted], rate: f64, correlation: f64) -> Vec<f64> {
    let mut all = vec![1.0];
    for cluster in counts {
        let one = cluster_masses(cluster.opportunities, rate, correlation);
        let mut next = vec![0.0; all.len() + one.len() - 1];
        for (i, a) in all.iter().enumerate() {
            let places = next[i..].iter_mut().zip(&one);
            places.for_each(|(sum, b)| *sum += a * b);
        }
        all = next;
    }
    all
}

/// The least count with at least this probability up to it.
fn quantile(masses: &[f64], probability: f64) -> u64 {
    let mut sum = 0.0;
    let found = masses.iter().position(|mass| {
        sum += mass;
        sum >= probability - 1e-12
    });
    found.unwrap_or(masses.len().saturating_sub(1)) as u64
}
