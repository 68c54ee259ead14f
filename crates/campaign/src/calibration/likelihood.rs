//! The likelihood of a rate from counts whose trials come in clusters (persons, sessions).
//!
//! Definition. Cluster `i` has `k_i` occurrences in `n_i` opportunities. Each cluster has a rate of
//! its own, beta distributed around `p` with intraclass correlation `r`, so its count is beta
//! binomial with `a = p (1 - r) / r`, `b = (1 - p) (1 - r) / r`. The correlation is unknown; its
//! prior is Beta(1, 9) (mean 0.1), and it is integrated out:
//!
//! ```text
//! L(p) = integral of product over i of BetaBinomial(k_i; n_i, p, r) dPrior(r)
//! ```
//!
//! Counts without clusters are binomial, `r = 0`.
//!
//! Source: J. G. Skellam, "A probability distribution derived from the binomial distribution by
//! regarding the probability of success as variable between the sets of trials", JRSS B 10 (1948);
//! the form as a product, which has no limit to take at `r = 0`, by D. A. Griffiths, "Maximum
//! likelihood estimation for the beta-binomial distribution", Biometrics 29 (1973). Deviation: the
//! integral is a mean over the prior's quantiles, and `ln L` is tabulated over `logit p` and
//! interpolated. Cost: nodes times correlations times trials, once. Guarantee: the interpolation's
//! error in `ln L` is below `trials / 8 * STEP^2`, 0.02 for a hundred trials.

use super::inference::{Counted, Observed};

/// Quantiles of the correlation's prior over which the likelihood is averaged.
const CORRELATIONS: usize = 12;

/// The second parameter of the correlation's prior; the first is 1.
const PRIOR_SHAPE: f64 = 9.0;

/// Between neighbouring nodes, in logits.
const STEP: f64 = 0.04;

/// The table goes from minus to plus this, in logits: rates from 1e-12 on.
const REACH: f64 = 27.6;

/// What counts of one way to fail say about its rate.
#[derive(Debug, Clone)]
pub(super) struct Likelihood {
    /// Equally probable values of the intraclass correlation; 0 alone without clusters.
    correlations: Vec<f64>,
    /// For each node, `ln L` at each correlation.
    table: Vec<Vec<f64>>,
    /// For each node, `ln L` averaged over the correlations.
    means: Vec<f64>,
}

impl Likelihood {
    /// The likelihood of what was counted; of nothing, if it is held out.
    pub(super) fn of(observed: &Observed) -> Self {
        let correlations = match observed.clusters.is_empty() {
            true => vec![0.0],
            false => prior_correlations(),
        };
        let whole = [Counted {
            occurrences: observed.occurrences,
            opportunities: observed.opportunities,
        }];
        let counts = match (observed.held_out, observed.clusters.is_empty()) {
            (true, _) => &[][..],
            (false, true) => &whole[..],
            (false, false) => &observed.clusters[..],
        };
        let table: Vec<Vec<f64>> = (0..nodes())
            .map(|node| {
                let of = |correlation: &f64| ln_all(counts, node_rate(node), *correlation);
                correlations.iter().map(of).collect()
            })
            .collect();
        let means = table.iter().map(|row| super::inference::ln_mean(row));
        Self {
            means: means.collect(),
            correlations,
            table,
        }
    }

    /// `ln L(rate)`, up to a constant.
    pub(super) fn ln(&self, rate: f64) -> f64 {
        let (node, share) = place(rate);
        self.means[node] * (1.0 - share) + self.means[node + 1] * share
    }

    /// The intraclass correlations with their posterior probabilities at a node's rate.
    pub(super) fn correlations(&self, node: usize) -> impl Iterator<Item = (f64, f64)> {
        let row = &self.table[node];
        let most = row.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = row.iter().map(|ln| (ln - most).exp()).sum();
        let weights = row.iter().map(move |ln| (ln - most).exp() / total);
        self.correlations.iter().copied().zip(weights)
    }
}

/// How many nodes the tables have.
pub(super) fn nodes() -> usize {
    (2.0 * REACH / STEP).round() as usize + 1
}

/// The rate at a node.
pub(super) fn node_rate(node: usize) -> f64 {
    1.0 / (1.0 + (REACH - node as f64 * STEP).exp())
}

/// The node below a rate, and how far the rate lies towards the next, 0 to 1.
pub(super) fn place(rate: f64) -> (usize, f64) {
    let logit = (rate / (1.0 - rate)).ln().clamp(-REACH, REACH);
    let at = (logit + REACH) / STEP;
    let node = (at.max(0.0) as usize).min(nodes() - 2);
    (node, (at - node as f64).clamp(0.0, 1.0))
}

fn prior_correlations() -> Vec<f64> {
    (0..CORRELATIONS)
        .map(|i| (i as f64 + 0.5) / CORRELATIONS as f64)
        .map(|u| 1.0 - (1.0 - u).powf(1.0 / PRIOR_SHAPE))
        .collect()
}

fn ln_all(counts: &[Counted], rate: f64, correlation: f64) -> f64 {
    let one = |it: &Counted| ln_one(it.occurrences, it.opportunities, rate, correlation);
    counts.iter().map(one).sum()
}

/// The logarithm of the beta-binomial probability without its binomial coefficient.
fn ln_one(occurrences: u64, opportunities: u64, rate: f64, correlation: f64) -> f64 {
    let rest = opportunities - occurrences;
    if correlation == 0.0 {
        // A rate of 0 with no occurrence is certain, not 0 times infinity.
        let part = |count: u64, ln: f64| if count == 0 { 0.0 } else { count as f64 * ln };
        return part(occurrences, rate.ln()) + part(rest, (-rate).ln_1p());
    }
    let rising = |of: f64, count: u64| -> f64 {
        let steps = (0..count).map(|j| of * (1.0 - correlation) + j as f64 * correlation);
        steps.map(f64::ln).sum()
    };
    rising(rate, occurrences) + rising(1.0 - rate, rest) - rising(1.0, opportunities)
}

/// Probabilities of `0..=opportunities` occurrences in a cluster.
pub(super) fn cluster_masses(opportunities: u64, rate: f64, correlation: f64) -> Vec<f64> {
    if correlation == 0.0 {
        let mass = |k| stats::special::binomial_pmf(k, opportunities, rate);
        return (0..=opportunities).map(mass).collect();
    }
    let (n, share) = (opportunities as f64, 1.0 - correlation);
    // Each mass from the one before; the first is a product without cancellation.
    let mut masses = vec![ln_one(0, opportunities, rate, correlation)];
    for k in 0..opportunities {
        let (j, last) = (k as f64, masses[k as usize]);
        let ratio = (n - j) / (j + 1.0) * (rate * share + j * correlation)
            / ((1.0 - rate) * share + (n - j - 1.0) * correlation);
        masses.push(last + ratio.ln());
    }
    masses.into_iter().map(f64::exp).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use stats::special::{binomial_pmf, ln_gamma};

    #[test]
    fn masses_are_those_of_the_beta_binomial_and_add_up() {
        let (n, rate, correlation) = (10_u64, 0.07, 0.15);
        let masses = cluster_masses(n, rate, correlation);
        let (a, b) = (
            rate * (1.0 - correlation) / correlation,
            (1.0 - rate) * (1.0 - correlation) / correlation,
        );
        let ln_beta = |x: f64, y: f64| ln_gamma(x) + ln_gamma(y) - ln_gamma(x + y);
        for (k, mass) in masses.iter().enumerate() {
            let (k, n) = (k as f64, n as f64);
            let choose = ln_gamma(n + 1.0) - ln_gamma(k + 1.0) - ln_gamma(n - k + 1.0);
            let exact = (choose + ln_beta(k + a, n - k + b) - ln_beta(a, b)).exp();
            assert!((mass - exact).abs() < 1e-12, "{k}: {mass} {exact}");
        }
        assert!((masses.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let mean: f64 = (0..=n).zip(&masses).map(|(k, m)| k as f64 * m).sum();
        assert!((mean - 0.7).abs() < 1e-12);
        // The variance is the binomial one times 1 + (n - 1) r.
        let second: f64 = (0..=n).zip(&masses).map(|(k, m)| (k * k) as f64 * m).sum();
        let wanted = 0.7 * 0.93 * (1.0 + 9.0 * correlation);
        assert!((second - mean * mean - wanted).abs() < 1e-12);
    }

    #[test]
    fn the_table_follows_the_exact_likelihood() {
        let observed = Observed::new("slip", 7, 98);
        let likelihood = Likelihood::of(&observed);
        for rate in [1e-4, 0.01, 0.0714, 0.3] {
            let exact = binomial_pmf(7, 98, rate).ln() - binomial_pmf(7, 98, 0.05).ln();
            let found = likelihood.ln(rate) - likelihood.ln(0.05);
            assert!((found - exact).abs() < 0.02, "{rate}: {found} {exact}");
        }
        // Nothing impossible is infinite.
        assert!(likelihood.ln(0.0).is_finite() && likelihood.ln(1.0).is_finite());
    }

    #[test]
    fn clusters_that_differ_say_less_and_are_correlated() {
        let clustered = |counts: [u64; 5]| {
            let counted = |occurrences| Counted {
                occurrences,
                opportunities: 10,
            };
            let mut observed = Observed::new("slip", 10, 50);
            observed.clusters = counts.map(counted).to_vec();
            Likelihood::of(&observed)
        };
        let (alike, apart) = (clustered([2; 5]), clustered([10, 0, 0, 0, 0]));
        let drop = |it: &Likelihood| it.ln(0.2) - it.ln(0.05);
        assert!(drop(&alike) > drop(&apart) + 1.0);
        let (node, _) = place(0.2);
        let mean = |it: &Likelihood| it.correlations(node).map(|(r, w)| r * w).sum::<f64>();
        assert!(mean(&alike) < 0.08 && mean(&apart) > 0.25);
    }
}
