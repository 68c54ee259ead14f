//! What a posterior predicts, beside what was counted.
//!
//! Definition. The predicted count of a way to fail in `n` opportunities is binomial with the rate
//! of each point of the posterior, mixed by weight. The p-value is twice the smaller of
//! `P(K <= k)` and `P(K >= k)`, half of `P(K = k)` counted in each (mid-p), at most 1. For modes
//! that were held out it tests the simulator; for fitted ones it only shows whether the simulator
//! could be brought to reproduce them.
//!
//! Source: G. E. P. Box (1980); A. Gelman, X.-L. Meng and H. Stern (1996); mid-p by H. O. Lancaster
//! (1961). Cost: points times `n`. Guarantee: that of the posterior.

use stats::special::binomial_pmf;

use super::inference::Observed;
use super::posterior::Posterior;

/// Points of the posterior with less weight than this share of the whole are left out of sums.
const NEGLIGIBLE: f64 = 1e-9;

/// Predicted against counted.
#[derive(Debug, Clone, PartialEq)]
pub struct Predictive {
    /// What was counted.
    pub observed: Observed,
    /// The mean predicted rate.
    pub rate: f64,
    /// Counts between which 95 % of the predictions lie.
    pub count_low: u64,
    /// Upper end.
    pub count_high: u64,
    /// Two-sided predictive mid-p-value; `None` without opportunities.
    pub p_value: Option<f64>,
}

impl Predictive {
    pub(super) fn of(observed: &Observed, posterior: &Posterior, mode: usize) -> Self {
        let n = observed.opportunities;
        let points: Vec<(f64, f64)> = (posterior.rates(mode))
            .filter(|(_, weight)| *weight > NEGLIGIBLE)
            .collect();
        let total: f64 = points.iter().map(|(_, weight)| weight).sum();
        let rate = points.iter().map(|(rate, w)| rate * w).sum::<f64>() / total;
        let mass = |k: u64| -> f64 {
            let parts = points.iter().map(|(rate, w)| w * binomial_pmf(k, n, *rate));
            parts.sum::<f64>() / total
        };
        let masses: Vec<f64> = (0..=n).map(mass).collect();
        let k = observed.occurrences as usize;
        let below: f64 = masses[..k].iter().sum();
        let above: f64 = masses[k + 1..].iter().sum();
        let tail = below.min(above) + 0.5 * masses[k];
        Self {
            observed: observed.clone(),
            rate,
            count_low: quantile(&masses, 0.025),
            count_high: quantile(&masses, 0.975),
            p_value: (n > 0).then(|| (2.0 * tail).min(1.0)),
        }
    }
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
