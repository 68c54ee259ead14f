//! One intraclass correlation for everything that was counted of the same clusters, and with it the
//! interval of a count that cannot tell how alike its trials are: 0 of n, n of n, or a total without its
//! clusters.
//!
//! # Definition
//! For columns `c` of counts of the same `k` clusters, each with a rate of its own and all with one
//! correlation, and `l_c` the logarithm of the beta-binomial likelihood ([`mod@crate::beta_binomial`]),
//!
//! ```text
//! l(rho) = w sum over c of max over mu of l_c(mu, rho),   w = C / sum over c, d of r_cd^2
//! loss(rho) = 2 (max l - l(rho))
//! D(rho) = 1 + rho (sum n_i (n_i - 1) / N) (q + rho (1 - q)),   q = n / N       (design effect of n of N trials)
//! interval = { p : min over rho of [ z(p; n / D(rho))^2 + loss(rho) ] <= k ln(1 + t^2/(k - 1)) }
//! ```
//!
//! with the limit of [`mod@crate::beta_binomial`], `C` the columns that tell (neither 0 of n nor n of n), `r_cd` the correlation of two columns' residuals
//! `s_i - p n_i` over clusters, and `z(p; n)` the standard normal deviate of the observed rate in `n` independent
//! trials at rate `p`: of the score test towards the middle of the range, of the exact binomial test towards its
//! end, as in [`mod@crate::clustered`]. So what is not known of the correlation widens the interval.
//!
//! `w C` is the number of independent columns that tell as much: a column and its complement count once, and so
//! do failures of one kind that always come with those of another. The trials of a total are taken to be spread
//! over the clusters at random, but with the same correlation: if 50 of 100 attempts met a precondition, then
//! some people met it oftener.
//!
//! # Source
//! D. A. Williams (1975) for the likelihood; C. Varin, N. Reid and D. Firth, "An overview of composite
//! likelihood methods" (2011), for a sum over dependent parts and its weight; F. E. Satterthwaite (1946) for the
//! weight's form; E. B. Wilson (1927) for the score; L. Kish (1965) for `D` at `q = 1`.
//!
//! # Deviation
//! `rho` runs over 61 values, between which nothing is sought. Where no column tells, `rho` may be 1: one
//! trial for each cluster.
//!
//! # Assumes
//! All columns have one correlation, which is not tested. Clusters are independent of each other, with beta-distributed
//! rates, and were fixed in number; the trials of a total are spread over them at random.
//!
//! # Guarantee
//! Asymptotic in the number of clusters, *if* the columns have one correlation; that is an assumption, said
//! wherever it is used. Cost: some thousand likelihoods for each column, once.
//!
//! Coverage in percent and, in brackets, mean width of 95 % intervals over 500 draws for each row, beside three columns
//! of rates 0.12, 0.05 and 0.03 (measured by `tests/integration/cluster_coverage.rs`, which also has a correlation of 0.1). *By
//! cluster*: with this interval where all outcomes are the same, and else by the column's own correlation, whose exact
//! coverage [`mod@crate::clustered`] has: 93.4 % and more. *Of a total*: this interval, clusters unknown: 94.2 % and more (a
//! figure's standard error is about 1). *Independent*: Wilson's, clusters ignored. *Each once*: by cluster,
//! but one trial for each where all outcomes are the same.
//!
//! | clusters x trials | rate | correlation | by cluster | of a total | independent | each once |
//! |---|---|---|---|---|---|---|
//! | 5 x 5 | 0.005 | 0 | 99.8 (0.25) | 100.0 (0.24) | 88.2 (0.14) | 99.8 (0.43) |
//! | 5 x 5 | 0.005 | 0.3 | 99.4 (0.33) | 99.2 (0.34) | 90.8 (0.14) | 99.4 (0.43) |
//! | 5 x 5 | 0.005 | 0.5 | 99.2 (0.39) | 98.8 (0.39) | 93.6 (0.14) | 99.2 (0.44) |
//! | 5 x 5 | 0.03 | 0 | 100.0 (0.30) | 100.0 (0.27) | 96.4 (0.17) | 100.0 (0.40) |
//! | 5 x 5 | 0.03 | 0.3 | 98.4 (0.37) | 98.6 (0.37) | 90.0 (0.17) | 98.4 (0.43) |
//! | 5 x 5 | 0.03 | 0.5 | 98.6 (0.41) | 98.6 (0.42) | 87.4 (0.16) | 98.6 (0.45) |
//! | 5 x 5 | 0.12 | 0 | 99.6 (0.39) | 100.0 (0.37) | 97.2 (0.25) | 99.6 (0.40) |
//! | 5 x 5 | 0.12 | 0.3 | 98.8 (0.44) | 99.8 (0.47) | 92.6 (0.24) | 98.8 (0.46) |
//! | 5 x 5 | 0.12 | 0.5 | 99.0 (0.48) | 99.0 (0.53) | 89.2 (0.23) | 99.0 (0.50) |
//! | 5 x 5 | 0.5 | 0 | 98.8 (0.49) | 99.0 (0.55) | 95.6 (0.36) | 98.8 (0.49) |
//! | 5 x 5 | 0.5 | 0.3 | 97.0 (0.58) | 97.8 (0.65) | 82.4 (0.35) | 97.0 (0.58) |
//! | 5 x 5 | 0.5 | 0.5 | 96.6 (0.63) | 98.4 (0.70) | 74.8 (0.35) | 96.6 (0.63) |
//! | 10 x 10 | 0.005 | 0 | 99.2 (0.08) | 98.8 (0.06) | 93.0 (0.04) | 99.2 (0.22) |
//! | 10 x 10 | 0.005 | 0.3 | 99.4 (0.15) | 99.0 (0.15) | 90.6 (0.04) | 99.4 (0.26) |
//! | 10 x 10 | 0.005 | 0.5 | 99.8 (0.20) | 99.4 (0.20) | 91.6 (0.04) | 99.8 (0.27) |
//! | 10 x 10 | 0.03 | 0 | 98.6 (0.11) | 98.2 (0.09) | 96.6 (0.07) | 98.6 (0.12) |
//! | 10 x 10 | 0.03 | 0.3 | 98.8 (0.18) | 98.8 (0.18) | 88.4 (0.07) | 98.8 (0.22) |
//! | 10 x 10 | 0.03 | 0.5 | 99.0 (0.21) | 99.0 (0.23) | 85.6 (0.06) | 99.0 (0.25) |
//! | 10 x 10 | 0.12 | 0 | 96.8 (0.16) | 97.0 (0.15) | 94.2 (0.13) | 96.8 (0.16) |
//! | 10 x 10 | 0.12 | 0.3 | 96.4 (0.26) | 98.6 (0.27) | 70.8 (0.12) | 96.6 (0.26) |
//! | 10 x 10 | 0.12 | 0.5 | 96.2 (0.29) | 99.0 (0.32) | 61.4 (0.12) | 96.2 (0.29) |
//! | 10 x 10 | 0.5 | 0 | 97.8 (0.23) | 98.6 (0.23) | 94.6 (0.19) | 97.8 (0.23) |
//! | 10 x 10 | 0.5 | 0.3 | 96.2 (0.37) | 97.4 (0.42) | 68.4 (0.19) | 96.2 (0.37) |
//! | 10 x 10 | 0.5 | 0.5 | 96.4 (0.44) | 96.0 (0.49) | 57.2 (0.19) | 96.4 (0.44) |
//! | 20 x 5 | 0.005 | 0 | 98.8 (0.06) | 98.8 (0.05) | 91.0 (0.04) | 98.8 (0.13) |
//! | 20 x 5 | 0.005 | 0.3 | 98.6 (0.09) | 98.6 (0.09) | 87.0 (0.04) | 98.6 (0.14) |
//! | 20 x 5 | 0.005 | 0.5 | 98.6 (0.11) | 99.2 (0.12) | 86.0 (0.04) | 98.6 (0.15) |
//! | 20 x 5 | 0.03 | 0 | 99.4 (0.09) | 99.4 (0.08) | 98.4 (0.07) | 99.4 (0.09) |
//! | 20 x 5 | 0.03 | 0.3 | 97.8 (0.12) | 97.6 (0.13) | 89.4 (0.07) | 97.8 (0.13) |
//! | 20 x 5 | 0.03 | 0.5 | 98.2 (0.14) | 98.8 (0.15) | 85.0 (0.07) | 98.2 (0.15) |
//! | 20 x 5 | 0.12 | 0 | 97.6 (0.14) | 97.8 (0.14) | 96.2 (0.13) | 97.6 (0.14) |
//! | 20 x 5 | 0.12 | 0.3 | 95.8 (0.20) | 96.6 (0.21) | 84.6 (0.13) | 95.8 (0.20) |
//! | 20 x 5 | 0.12 | 0.5 | 95.2 (0.22) | 97.0 (0.24) | 76.8 (0.12) | 95.6 (0.22) |
//! | 20 x 5 | 0.5 | 0 | 98.2 (0.21) | 97.4 (0.22) | 95.6 (0.19) | 98.2 (0.21) |
//! | 20 x 5 | 0.5 | 0.3 | 93.4 (0.29) | 94.2 (0.31) | 81.6 (0.19) | 93.4 (0.29) |
//! | 20 x 5 | 0.5 | 0.5 | 95.2 (0.33) | 95.2 (0.36) | 74.4 (0.19) | 95.2 (0.33) |

use crate::beta_binomial::{Model, boundary, correlation_at, likelihood_drop};
use crate::clustered::{ClusterMethod, ClusteredRate, as_wide_as};
use crate::counts::{Confidence, EffectiveSample, Interval, Sample, StatsError};
use crate::heterogeneity::pool;
use crate::interval::wilson;
use crate::special::{beta_cdf, normal_quantile};

/// Steps of the correlation, dense near 0.
const STEPS: u32 = 60;

/// The correlation that columns of the same clusters have in common.
#[derive(Clone, Debug, PartialEq)]
pub struct CommonCorrelation {
    /// The most likely correlation; 0 where no column tells.
    pub estimate: f64,
    /// Columns that tell: neither 0 of n nor n of n, with clusters of more than one trial.
    pub columns: usize,
    /// Independent columns that tell as much.
    pub effective_columns: f64,
    /// Clusters that have trials.
    pub clusters: usize,
    /// Correlations, each with twice the fall of the likelihood from its maximum.
    losses: Vec<(f64, f64)>,
}

impl CommonCorrelation {
    /// What columns of the same clusters tell, one sample for each cluster in each column.
    ///
    /// # Errors
    /// [`StatsError::MoreSuccessesThanTrials`] for a contradictory count.
    ///
    /// ```
    /// use stats::{CommonCorrelation, Confidence, Sample};
    /// let column = |counts: [u64; 10]| counts.map(|successes| Sample { successes, trials: 10 });
    /// let done = column([9, 10, 8, 7, 9, 10, 10, 6, 9, 10]);
    /// let pulled_too_weakly = column([1, 0, 1, 2, 0, 0, 0, 2, 1, 0]);
    /// let common = CommonCorrelation::of(&[&done, &pulled_too_weakly])?;
    /// assert!(common.effective_columns < 1.5, "the second explains much of the first");
    /// // 0 of 100 is not as sure as of a hundred people, but surer than of ten.
    /// let never = common.rate(Sample { successes: 0, trials: 100 }, &[10; 10], Confidence::P95)?;
    /// assert!(never.worth.trials > 15.0 && never.worth.trials < 60.0);
    /// # Ok::<(), stats::StatsError>(())
    /// ```
    pub fn of<C: AsRef<[Sample]>>(columns: &[C]) -> Result<Self, StatsError> {
        let mut clusters = 0;
        let mut telling: Vec<&[Sample]> = Vec::new();
        for column in columns.iter().map(AsRef::as_ref) {
            let total = pool(column)?;
            let with_trials = column.iter().filter(|c| c.trials > 0).count();
            clusters = clusters.max(with_trials);
            let varies = total.successes > 0 && total.failures() > 0;
            if varies && with_trials >= 2 && total.trials as usize > with_trials {
                telling.push(column);
            }
        }
        let models: Vec<Model> = telling.iter().map(|c| Model::new(c)).collect();
        let effective_columns = effective_columns(&telling);
        let weight = effective_columns / telling.len().max(1) as f64;
        let mut losses: Vec<(f64, f64)> = (0..=STEPS)
            .map(|step| correlation_at(f64::from(step) / f64::from(STEPS)))
            .map(|rho| (rho, models.iter().map(|m| m.at_correlation(rho)).sum()))
            .collect();
        let best = losses.iter().fold((0.0, f64::NEG_INFINITY), |best, new| {
            if new.1 > best.1 { *new } else { best }
        });
        for (_, loss) in &mut losses {
            *loss = 2.0 * weight * (best.1 - *loss);
        }
        Ok(Self {
            estimate: best.0,
            columns: telling.len(),
            effective_columns,
            clusters,
            losses,
        })
    }

    /// The likelihood interval of the correlation; all of `[0, 1]` where no column tells.
    #[must_use]
    pub fn interval(&self, confidence: Confidence) -> Interval {
        if self.columns == 0 {
            return Interval::VACUOUS;
        }
        let allowed = likelihood_drop(confidence, self.clusters);
        let within = self.losses.iter().filter(|(_, loss)| *loss <= allowed);
        let (low, high) = within.fold((self.estimate, self.estimate), |(low, high), (rho, _)| {
            (low.min(*rho), high.max(*rho))
        });
        Interval { low, high }
    }

    /// The rate of a count of which it is only known that it was made in clusters of these sizes, of whose trials it
    /// may have a part.
    ///
    /// # Errors
    /// [`StatsError::NoTrials`] without any, [`StatsError::MoreSuccessesThanTrials`] for a contradictory count.
    pub fn rate(
        &self,
        total: Sample,
        sizes: &[u64],
        confidence: Confidence,
    ) -> Result<ClusteredRate, StatsError> {
        let total = Sample::new(total.successes, total.trials)?;
        if total.trials == 0 {
            return Err(StatsError::NoTrials);
        }
        let clusters = sizes.iter().filter(|size| **size > 0).count();
        let rate = |method, interval, worth| ClusteredRate {
            total,
            clusters,
            method,
            interval,
            worth,
        };
        let least = total.trials as f64 / design_effect(total, sizes, 1.0);
        if clusters < 2 || least >= total.trials as f64 {
            let interval = wilson(total, confidence);
            return Ok(rate(ClusterMethod::Independent, interval, total.into()));
        }
        if self.columns == 0 {
            let worth = EffectiveSample::at_size(total, least)?;
            let interval = wilson(worth, confidence);
            return Ok(rate(ClusterMethod::OneEach, interval, worth));
        }
        let mut interval = self.profiled(total, sizes, confidence);
        if total.successes == 0 || total.failures() == 0 {
            // Trials of a cluster can be no more alike than all the same.
            let each_once = wilson(EffectiveSample::at_size(total, least)?, confidence);
            interval.low = interval.low.max(each_once.low);
            interval.high = interval.high.min(each_once.high);
        }
        let worth = as_wide_as(interval, total, confidence)?;
        Ok(rate(ClusterMethod::Common, interval, worth))
    }

    /// The interval of the rate with the correlation profiled out.
    fn profiled(&self, total: Sample, sizes: &[u64], confidence: Confidence) -> Interval {
        let (trials, observed) = (
            total.trials as f64,
            total.successes as f64 / total.trials as f64,
        );
        let allowed = likelihood_drop(confidence, self.clusters);
        let mut interval = Interval {
            low: observed,
            high: observed,
        };
        for (rho, loss) in self.losses.iter().filter(|(_, loss)| *loss <= allowed) {
            let size = trials / design_effect(total, sizes, *rho);
            let excluded = |rate: f64| is_beyond(observed, size, rate, allowed - loss);
            // What no correlation excludes belongs to the interval: most move no end of it.
            if interval.low > 0.0 && !excluded(interval.low) {
                interval.low = boundary(0.0, interval.low, excluded);
            }
            if interval.high < 1.0 && !excluded(interval.high) {
                interval.high = boundary(1.0, interval.high, excluded);
            }
        }
        interval
    }
}

/// Whether a rate observed in `size` independent trials is farther from `rate` than `square` allows, the square of a
/// standard normal deviate.
fn is_beyond(observed: f64, size: f64, rate: f64, square: f64) -> bool {
    let variance = rate * (1.0 - rate);
    if rate == observed || variance <= 0.0 {
        return rate != observed;
    }
    if size * (observed - rate).powi(2) / variance <= square {
        return false;
    }
    let outwards = rate < observed.min(0.5) || rate > observed.max(0.5);
    if !outwards {
        return true;
    }
    // P(at least so many successes), or failures where the rate lies above.
    let (seen, at) = if rate < observed {
        (observed * size, rate)
    } else {
        ((1.0 - observed) * size, 1.0 - rate)
    };
    let tail = beta_cdf(seen, size - seen + 1.0, at);
    tail <= 0.0 || normal_quantile(tail.min(0.5)).powi(2) > square
}

/// The variance of a rate of clustered trials relative to that of as many independent ones.
fn design_effect(total: Sample, sizes: &[u64], correlation: f64) -> f64 {
    let sizes = || sizes.iter().map(|size| *size as f64);
    let all: f64 = sizes().sum();
    let others: f64 = sizes().map(|size| size * (size - 1.0)).sum::<f64>() / all;
    let part = (total.trials as f64 / all).min(1.0);
    1.0 + correlation * others.max(0.0) * (part + correlation * (1.0 - part))
}

/// The number of independent columns that tell as much as these.
fn effective_columns(columns: &[&[Sample]]) -> f64 {
    let residuals: Vec<Vec<f64>> = columns.iter().map(|column| residuals(column)).collect();
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut squares = 0.0;
    for (i, a) in residuals.iter().enumerate() {
        for (j, b) in residuals.iter().enumerate() {
            let scale = product(a, a) * product(b, b);
            squares += match (i == j, scale > 0.0) {
                (true, _) => 1.0,
                (false, true) => (product(a, b).powi(2) / scale).min(1.0),
                (false, false) => 0.0,
            };
        }
    }
    let count = columns.len() as f64;
    if squares > 0.0 {
        count * count / squares
    } else {
        0.0
    }
}

/// How far each cluster's successes lie from what the rate of all gives its trials.
fn residuals(column: &[Sample]) -> Vec<f64> {
    let (successes, trials) = column.iter().fold((0.0, 0.0), |(s, n), cluster| {
        (s + cluster.successes as f64, n + cluster.trials as f64)
    });
    let expected = |cluster: &Sample| successes / trials * cluster.trials as f64;
    let residual = |cluster: &Sample| cluster.successes as f64 - expected(cluster);
    column.iter().map(residual).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(successes: &[u64]) -> Vec<Sample> {
        let of_ten = |successes: &u64| Sample {
            successes: *successes,
            trials: 10,
        };
        successes.iter().map(of_ten).collect()
    }

    /// Success and three ways to fail of ten people with ten attempts each.
    fn people() -> CommonCorrelation {
        CommonCorrelation::of(&[
            column(&[9, 10, 8, 7, 9, 10, 10, 6, 9, 10]),
            column(&[1, 0, 1, 2, 0, 0, 0, 2, 1, 0]),
            column(&[0, 0, 1, 0, 0, 0, 0, 2, 0, 0]),
            column(&[0, 0, 0, 1, 1, 0, 0, 0, 0, 0]),
        ])
        .unwrap()
    }

    fn rate(common: &CommonCorrelation, successes: u64, trials: u64) -> ClusteredRate {
        let total = Sample { successes, trials };
        common.rate(total, &[10; 10], Confidence::P95).unwrap()
    }

    /// By the definition with scipy 1.17: betaln, minimize_scalar for each mean, bisection for each end.
    #[test]
    fn reference_values() {
        let common = people();
        let close = |found: f64, expected: f64| {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        };
        close(common.effective_columns, 2.027_890_777_2);
        close(common.estimate, 0.037_037_037);
        close(common.interval(Confidence::P95).low, 0.0);
        close(common.interval(Confidence::P95).high, 0.274_624_999_7);
        close(rate(&common, 0, 100).interval.high, 0.066_609_072_1);
        close(rate(&common, 88, 98).interval.low, 0.788_171_838_6);
        close(rate(&common, 78, 98).interval.low, 0.669_531_960_7);
        close(rate(&common, 25, 25).interval.low, 0.831_987_511_8);
        assert_eq!(rate(&common, 25, 25).interval.high, 1.0);
        assert_eq!(rate(&common, 0, 100).method, ClusterMethod::Common);
    }

    #[test]
    fn the_other_side_mirrors_and_the_end_is_looked_at_exactly() {
        let common = people();
        for (successes, trials) in [(3, 98), (88, 98), (0, 25), (25, 25), (1, 100)] {
            let one = rate(&common, successes, trials).interval;
            let other = rate(&common, trials - successes, trials).interval;
            assert!((one.low - (1.0 - other.high)).abs() < 1e-9);
            assert!((one.high - (1.0 - other.low)).abs() < 1e-9);
        }
        // Wider towards the end than the score of independent trials, and than Clopper and Pearson's.
        let few = rate(&common, 3, 98);
        let sample = Sample::new(3, 98).unwrap();
        let exact = crate::interval::clopper_pearson(sample, Confidence::P95);
        assert!(few.interval.low < exact.low && few.interval.high > exact.high);
    }

    #[test]
    fn what_says_the_same_counts_once() {
        let done = column(&[9, 10, 8, 7, 9, 10, 10, 6, 9, 10]);
        let failed = column(&[1, 0, 2, 3, 1, 0, 0, 4, 1, 0]);
        let never = column(&[0; 10]);
        let once = CommonCorrelation::of(&[&done]).unwrap();
        let thrice = CommonCorrelation::of(&[&done, &failed, &done, &never]).unwrap();
        assert_eq!((once.columns, thrice.columns), (1, 3));
        assert!((thrice.effective_columns - 1.0).abs() < 1e-12);
        let highs = [&once, &thrice].map(|common| rate(common, 0, 100).interval.high);
        assert!((highs[0] - highs[1]).abs() < 1e-9, "{highs:?}");
    }

    #[test]
    fn without_a_telling_column_each_cluster_counts_once() {
        let common = CommonCorrelation::of(&[column(&[0; 10]), column(&[10; 10])]).unwrap();
        assert_eq!(common.interval(Confidence::P95), Interval::VACUOUS);
        for trials in [100, 93, 10] {
            let found = rate(&common, trials, trials);
            assert_eq!(found.method, ClusterMethod::OneEach);
            // Ten people, of whom as many are taken to have met the precondition.
            assert!((found.worth.trials - 0.1 * trials as f64).abs() < 1e-9);
        }
        let single = common.rate(Sample::new(3, 4).unwrap(), &[1; 4], Confidence::P95);
        assert_eq!(single.unwrap().method, ClusterMethod::Independent);
        let alone = common.rate(Sample::new(3, 4).unwrap(), &[4], Confidence::P95);
        assert_eq!(alone.unwrap().method, ClusterMethod::Independent);
        assert!(
            common
                .rate(Sample::new(0, 0).unwrap(), &[4, 4], Confidence::P95)
                .is_err()
        );
    }

    #[test]
    fn people_who_are_as_different_as_can_be_are_worth_one_trial_each() {
        let each: Vec<u64> = (0..40).map(|i| if i % 2 == 0 { 10 } else { 0 }).collect();
        let common = CommonCorrelation::of(&[column(&each)]).unwrap();
        assert!(common.estimate > 0.9);
        let found = common.rate(Sample::new(0, 400).unwrap(), &[10; 40], Confidence::P95);
        assert!((39.999..44.0).contains(&found.unwrap().worth.trials));
        // Millions of trials are as quick.
        let many: Vec<Sample> = (0..6)
            .map(|i| Sample::new(500_000 + 90_000 * i, 1_000_000).unwrap())
            .collect();
        let common = CommonCorrelation::of(&[many]).unwrap();
        let none = common.rate(
            Sample::new(0, 6_000_000).unwrap(),
            &[1_000_000; 6],
            Confidence::P95,
        );
        assert!(none.unwrap().worth.trials < 400.0);
    }
}
