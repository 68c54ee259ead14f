//! Trials that come in clusters (subjects, sessions): how alike they are within one, and how
//! many independent trials they are worth.
//!
//! With `k` clusters of `n_i` trials, `s_i` successes, `N` trials and `S` successes in all,
//!
//! ```text
//! MSB = (sum s_i^2/n_i - S^2/N) / (k - 1)
//! MSW = (S - sum s_i^2/n_i) / (N - k)
//! n0  = (N - sum n_i^2 / N) / (k - 1)
//! icc = (MSB - MSW) / (MSB + (n0 - 1) MSW)
//! design effect = 1 + max(0, icc) (sum n_i^2 / N - 1),   effective size = N / design effect
//! ```
//!
//! Source: R. A. Fisher (1925), one-way analysis of variance; M. S. Ridout, C. G. B. Demetrio and
//! D. Firth, "Estimating intraclass correlation for binary data" (1999); L. Kish, "Survey
//! sampling" (1965), for the design effect with clusters of unequal size. Deviation: a negative
//! estimate is reported but never makes a sample larger than it is. Cost: linear. Guarantee: the
//! estimate is consistent in the number of clusters; with ten of them it is rough.
//!
//! # Assumes
//! Clusters are independent of each other, with one mean and one correlation whatever their size; trials are exchangeable
//! within one. The p-value takes cluster means as normal.

use crate::counts::{EffectiveSample, Sample, StatsError};
use crate::special::f_sf;

/// How strongly trials of one cluster resemble each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clustering {
    /// All trials together.
    pub total: Sample,
    /// Number of clusters.
    pub clusters: usize,
    /// The intraclass correlation by analysis of variance; may be negative.
    pub intraclass_correlation: f64,
    /// The variance of the rate relative to that of independent trials, at least 1.
    pub design_effect: f64,
    /// The number of independent trials that say as much.
    pub effective_size: f64,
    /// F statistic of "no difference between clusters".
    pub f_statistic: f64,
    /// `P(F > f_statistic)`, by normal theory.
    pub p_value: f64,
}

impl Clustering {
    /// The rate at the effective size.
    #[must_use]
    pub fn effective_sample(&self) -> EffectiveSample {
        let share = self.effective_size / self.total.trials as f64;
        EffectiveSample {
            successes: self.total.successes as f64 * share,
            trials: self.effective_size,
        }
    }
}

/// Clustering of trials, one sample for each cluster; clusters without trials are skipped.
///
/// # Errors
/// [`StatsError::MoreSuccessesThanTrials`] for a contradictory count, [`StatsError::TooFew`]
/// below two clusters or when each holds a single trial, [`StatsError::Constant`] when all
/// trials had the same outcome: then nothing can be learnt about clustering, and a cautious
/// effective size is the number of clusters.
pub fn clustering(clusters: &[Sample]) -> Result<Clustering, StatsError> {
    let total = crate::heterogeneity::pool(clusters)?;
    let clusters: Vec<EffectiveSample> = clusters
        .iter()
        .filter(|cluster| cluster.trials > 0)
        .map(|cluster| (*cluster).into())
        .collect();
    check(total, clusters.len())?;
    let trials = total.trials as f64;
    let size_squares: f64 = clusters.iter().map(|c| c.trials * c.trials).sum();
    let degrees = ((clusters.len() - 1) as f64, trials - clusters.len() as f64);
    let (between, within) = sums_of_squares(&clusters, total);
    let (mean_between, mean_within) = (between / degrees.0, within / degrees.1);
    let typical_size = (trials - size_squares / trials) / degrees.0;
    let icc = (mean_between - mean_within) / (mean_between + (typical_size - 1.0) * mean_within);
    let design_effect = 1.0 + icc.max(0.0) * (size_squares / trials - 1.0);
    let f_statistic = mean_between / mean_within;
    Ok(Clustering {
        total,
        clusters: clusters.len(),
        intraclass_correlation: icc,
        design_effect,
        effective_size: trials / design_effect,
        f_statistic,
        p_value: f_sf(f_statistic, degrees.0, degrees.1),
    })
}

fn check(total: Sample, clusters: usize) -> Result<(), StatsError> {
    if clusters < 2 {
        return Err(StatsError::TooFew {
            what: "clusters",
            found: clusters,
            needed: 2,
        });
    }
    if total.trials as usize == clusters {
        return Err(StatsError::TooFew {
            what: "trials beyond one for each cluster",
            found: 0,
            needed: 1,
        });
    }
    if total.successes == 0 || total.failures() == 0 {
        return Err(StatsError::Constant { what: "outcomes" });
    }
    Ok(())
}

/// Sums of squares between and within clusters.
fn sums_of_squares(clusters: &[EffectiveSample], total: Sample) -> (f64, f64) {
    let rate = total.successes as f64 / total.trials as f64;
    let between = clusters
        .iter()
        .map(|c| c.trials * (c.successes / c.trials - rate).powi(2))
        .sum();
    let within = clusters
        .iter()
        .map(|c| c.successes * c.failures() / c.trials)
        .sum();
    (between, within)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(counts: &[(u64, u64)]) -> Vec<Sample> {
        counts
            .iter()
            .map(|&(successes, trials)| Sample { successes, trials })
            .collect()
    }

    #[test]
    fn a_hand_calculated_case() {
        // Two clusters of 4 with 4 and 2 successes: SSB = 0.5, SSW = 1, MSB = 0.5, MSW = 1/6,
        // n0 = 4, icc = (1/3) / (1/2 + 1/2) = 1/3, design effect = 1 + 3/3 = 2.
        let found = clustering(&samples(&[(4, 4), (2, 4)])).unwrap();
        assert!((found.intraclass_correlation - 1.0 / 3.0).abs() < 1e-14);
        assert!((found.design_effect - 2.0).abs() < 1e-14);
        assert!((found.effective_size - 4.0).abs() < 1e-14);
        assert!((found.f_statistic - 3.0).abs() < 1e-14);
        assert!((found.effective_sample().successes - 3.0).abs() < 1e-14);
    }

    #[test]
    fn identical_trials_within_clusters_are_worth_one_each() {
        let found = clustering(&samples(&[(5, 5), (0, 5), (5, 5)])).unwrap();
        assert!((found.intraclass_correlation - 1.0).abs() < 1e-14);
        assert!((found.effective_size - 3.0).abs() < 1e-12);
        assert_eq!(found.p_value, 0.0);
    }

    #[test]
    fn a_negative_correlation_adds_nothing() {
        let found = clustering(&samples(&[(2, 4), (2, 4), (2, 4)])).unwrap();
        assert!(found.intraclass_correlation < 0.0);
        assert_eq!(found.effective_size, 12.0);
    }

    #[test]
    fn what_cannot_be_said_is_not() {
        assert!(clustering(&samples(&[(3, 4)])).is_err());
        assert!(clustering(&samples(&[(1, 1), (0, 1)])).is_err());
        assert!(clustering(&samples(&[(4, 4), (3, 3)])).is_err());
        assert!(clustering(&samples(&[(4, 3), (3, 3)])).is_err());
    }
}
