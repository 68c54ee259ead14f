//! Intervals of a rate whose trials come in clusters, without a model of how clusters differ.
//!
//! With `k` clusters of `n_i` trials and `s_i` successes, `N` and `S` in all, `p = S/N`,
//!
//! ```text
//! V        = k/(k-1) sum (s_i - p n_i)^2 / N^2                       (variance between clusters)
//! robust   : logit(p) +- t V^(1/2) / (p (1-p)),                        t of Student, k - 1 degrees
//! n*       = p (1-p) / V ((z / t)^2),  z of the normal distribution, at most N
//! adjusted : Clopper and Pearson's interval of p n* successes in n*
//! ```
//!
//! Source: K.-Y. Liang and S. L. Zeger, "Longitudinal data analysis using generalized linear
//! models" (1986), with the correction k/(k-1); E. L. Korn and B. I. Graubard, "Confidence
//! intervals for proportions with small expected number of positive counts estimated from survey
//! data" (1998). Deviations: the ratio of squared quantiles in `n*` is that of the normal and
//! Student's distribution, because a trial's own variance is known; where the clusters' rates do
//! not differ at all (0 of n and n of n among them), `V` says nothing and `n*` is `k`, one trial
//! for each cluster. Cost: linear. Guarantee: asymptotic in the number of clusters; measured
//! coverage is in `tests/integration/calibration.rs`.
//!
//! # Assumes
//! Clusters are independent of each other and were fixed in number; sizes tell nothing of rates. How trials of one hang
//! together is left open. The log-odds of the rate are taken as normal (of the adjusted interval its count as binomial).

use crate::counts::{Confidence, EffectiveSample, Interval, Sample, StatsError};
use crate::heterogeneity::pool;
use crate::interval::clopper_pearson;
use crate::special::{normal_quantile, student_t_quantile};

/// A rate with its variance between clusters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClusterRobust {
    /// All trials together.
    pub total: Sample,
    /// Number of clusters that have trials.
    pub clusters: usize,
    /// The variance of the rate; 0 where the clusters' rates do not differ.
    pub variance: f64,
}

impl ClusterRobust {
    /// The rate of the clusters, one sample each; those without trials are skipped.
    ///
    /// # Errors
    /// [`StatsError::MoreSuccessesThanTrials`] for a contradictory count, [`StatsError::TooFew`]
    /// below two clusters.
    ///
    /// ```
    /// use stats::{ClusterRobust, Confidence, Sample};
    /// let subjects = [9, 10, 8, 7, 9, 10, 10, 6, 9, 10].map(|successes| Sample { successes, trials: 10 });
    /// let rate = ClusterRobust::of(&subjects)?;
    /// assert_eq!(rate.interval(Confidence::P95).to_string(), "[0.7398, 0.9498]");
    /// # Ok::<(), stats::StatsError>(())
    /// ```
    pub fn of(clusters: &[Sample]) -> Result<Self, StatsError> {
        let total = pool(clusters)?;
        let counted = || clusters.iter().filter(|cluster| cluster.trials > 0);
        let found = counted().count();
        if found < 2 {
            return Err(StatsError::TooFew {
                what: "clusters",
                found,
                needed: 2,
            });
        }
        let (trials, k) = (total.trials as f64, found as f64);
        let rate = total.successes as f64 / trials;
        let squares: f64 = counted()
            .map(|c| (c.successes as f64 - rate * c.trials as f64).powi(2))
            .sum();
        // Rounding of p n_i must not pass for a difference between clusters.
        let rounding = trials * f64::EPSILON;
        let squares = if squares <= k * rounding * rounding {
            0.0
        } else {
            squares
        };
        Ok(Self {
            total,
            clusters: found,
            variance: k / (k - 1.0) * squares / (trials * trials),
        })
    }

    /// The rate of all trials.
    #[must_use]
    pub fn rate(&self) -> f64 {
        self.total.successes as f64 / self.total.trials as f64
    }

    /// The number of independent trials that would leave the same variance, at most the trials
    /// there are; the number of clusters where their rates do not differ.
    #[must_use]
    pub fn effective_size(&self) -> f64 {
        let (trials, rate) = (self.total.trials as f64, self.rate());
        if self.variance <= 0.0 {
            return self.clusters as f64;
        }
        (rate * (1.0 - rate) / self.variance).min(trials)
    }

    /// The interval on the scale of log-odds; Korn and Graubard's where that has no variance.
    #[must_use]
    pub fn interval(&self, confidence: Confidence) -> Interval {
        let rate = self.rate();
        let spread = rate * (1.0 - rate);
        if self.variance <= 0.0 || spread <= 0.0 {
            return self.adjusted_interval(confidence);
        }
        let half_width = self.quantile(confidence) * self.variance.sqrt() / spread;
        let odds = rate / (1.0 - rate);
        let logistic = |factor: f64| odds * factor / (1.0 + odds * factor);
        Interval {
            low: logistic((-half_width).exp()),
            high: 1.0 - 1.0 / (1.0 + odds * half_width.exp()),
        }
    }

    /// Korn and Graubard's interval: Clopper and Pearson's at a size that allows for the
    /// clustering and for how few clusters it is known from.
    #[must_use]
    pub fn adjusted_interval(&self, confidence: Confidence) -> Interval {
        clopper_pearson(self.adjusted_sample(confidence), confidence)
    }

    /// The counts of [`ClusterRobust::adjusted_interval`]: what the clusters are worth in independent
    /// trials, once it is allowed for how few clusters that is known from. For tests that take
    /// independent trials; with 10 clusters it is a quarter less than the effective size.
    #[must_use]
    pub fn adjusted_sample(&self, confidence: Confidence) -> EffectiveSample {
        let size = if self.variance <= 0.0 {
            self.clusters as f64
        } else {
            let z = normal_quantile(1.0 - 0.5 * confidence.alpha());
            let shrunk = self.effective_size() * (z / self.quantile(confidence)).powi(2);
            shrunk.max(1.0).min(self.total.trials as f64)
        };
        EffectiveSample {
            successes: self.rate() * size,
            trials: size,
        }
    }

    fn quantile(&self, confidence: Confidence) -> f64 {
        student_t_quantile(1.0 - 0.5 * confidence.alpha(), (self.clusters - 1) as f64)
    }
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

    /// statsmodels 0.14: GLM(trials, ones, family=Binomial()).fit(cov_type="cluster"), groups of
    /// the cohort and of six uneven clusters, standard error of the log-odds times t of scipy.
    #[test]
    fn reference_values() {
        let cohort: Vec<(u64, u64)> = [9, 10, 8, 7, 9, 10, 10, 6, 9, 10].map(|s| (s, 10)).to_vec();
        let uneven = vec![(2, 12), (11, 15), (0, 7), (30, 40), (5, 5), (18, 60)];
        for (counts, expected) in [(cohort, COHORT), (uneven, UNEVEN)] {
            let found = ClusterRobust::of(&samples(&counts)).unwrap();
            let interval = found.interval(Confidence::P95);
            let spread = found.rate() * (1.0 - found.rate());
            for (found, expected) in [found.variance.sqrt() / spread, interval.low, interval.high]
                .into_iter()
                .zip(expected)
            {
                assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
            }
        }
    }

    const COHORT: [f64; 3] = [0.4187657563056901, 0.7398359751210527, 0.9497765224471605];
    const UNEVEN: [f64; 3] = [0.5267834273217353, 0.189241752141475, 0.7778766680761918];

    #[test]
    fn rates_that_do_not_differ_count_once_for_each_cluster() {
        for counts in [
            [(4, 4), (9, 9), (1, 1)],
            [(0, 4), (0, 9), (0, 1)],
            [(3, 6), (1, 2), (5, 10)],
        ] {
            let found = ClusterRobust::of(&samples(&counts)).unwrap();
            assert_eq!((found.variance, found.effective_size()), (0.0, 3.0));
            let interval = found.interval(Confidence::P95);
            let successes = 3.0 * found.rate();
            assert!((found.adjusted_sample(Confidence::P95).trials - 3.0).abs() < 1e-12);
            let plain = clopper_pearson(
                EffectiveSample {
                    successes,
                    trials: 3.0,
                },
                Confidence::P95,
            );
            assert_eq!(interval, plain);
        }
        assert!(ClusterRobust::of(&samples(&[(1, 4)])).is_err());
        assert!(ClusterRobust::of(&samples(&[(5, 4), (1, 2)])).is_err());
    }
}
