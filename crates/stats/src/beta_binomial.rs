//! Clustered counts by the beta-binomial model: each cluster has a rate of its own.
//!
//! Cluster `i` has `s_i` successes and `f_i` failures in `n_i` trials at a rate drawn from
//! `Beta(mu/theta, (1-mu)/theta)`: mean `mu`, intraclass correlation `rho = theta/(1 + theta)`.
//!
//! ```text
//! l(mu, rho) = sum_i [ s_i ln mu + f_i ln(1-mu) + R(s_i, mu/theta) + R(f_i, (1-mu)/theta) - R(n_i, 1/theta) ]
//! R(k, a)    = ln( a (a+1) ... (a+k-1) / a^k )
//! LR         = 2 (max l(mu, rho) - max l(mu, 0)),   p = P(chi-squared_1 > LR) / 2
//! interval   = { mu : 2 (max l - max over rho of l(mu, rho)) <= k ln(1 + t^2/(k-1)) },  t of Student's, k - 1 degrees
//! ```
//!
//! Source: J. G. Skellam, "A probability distribution derived from the binomial distribution"
//! (1948); D. A. Williams, "The analysis of binary responses from toxicological experiments"
//! (1975), for clusters; S. G. Self and K.-Y. Liang (1987) for halving the p-value, because `rho`
//! lies at the end of its range; for the limit of the likelihood Student (1908), as a likelihood ratio J. Neyman and
//! E. S. Pearson (1928): of the mean of `k` normal numbers of unknown variance twice the logarithm of the ratio is
//! `k ln(1 + t^2/(k-1))`, so the limit is exact where clusters are so large that each tells its own rate, and these
//! are normal. The chi-squared limit `z^2` takes the variance between few clusters for known: with five clusters of ten
//! it covers 89.7 % at least, with a factor of `k/(k-1)` 93.1 %, and this one 94.6 % (`t^2` itself 97.9 %: too wide).
//! Deviations: `R` is formed from Stirling errors and deviances, so that a
//! cluster costs the same at 5 and at 10^8 trials, and of up to 64 outcomes from the factors, which all clusters share;
//! clusters alike are counted once. Where all
//! outcomes are the same the interval is that of `k` trials, one for each cluster, since `rho` may
//! then be 1. Cost: some thousands of likelihoods. Guarantee: asymptotic in the number of clusters;
//! measured coverage and false alarms are in `tests/integration/calibration.rs`.
//!
//! # Assumes
//! Clusters are independent draws of one population, as many as were fixed in advance, and trials of one are independent
//! given its rate. Rates have a beta distribution, which few clusters cannot show to be wrong: [`mod@crate::clustered`] has
//! the errors under another law. Sizes tell nothing of rates.

use crate::clustered_tail::tails;
use crate::counts::{Confidence, EffectiveSample, Interval, Sample, StatsError};
use crate::heterogeneity::pool;
use crate::special::{
    chi_squared_sf, deviance_of_sum, stirling_error, student_t_quantile, student_t_sf,
};
use std::collections::BTreeMap;

/// What the beta-binomial model makes of clustered counts.
#[derive(Clone, Debug, PartialEq)]
pub struct BetaBinomial {
    /// All trials together.
    pub total: Sample,
    /// Number of clusters that have trials.
    pub clusters: usize,
    /// The most likely mean of the clusters' rates.
    pub mean: f64,
    /// The most likely intraclass correlation, from 0 (independent trials) to below 1.
    pub intraclass_correlation: f64,
    /// Twice the logarithm of the likelihood ratio against independent trials.
    pub statistic: f64,
    /// p-value of "trials are independent": small when clusters differ beyond chance.
    pub p_value: f64,
    /// The number of independent trials that say as much about the mean.
    pub effective_size: f64,
    most_likely: f64,
    model: Model,
}

impl BetaBinomial {
    /// The most likely model of the clusters, one sample each; those without trials are skipped.
    ///
    /// # Errors
    /// [`StatsError::MoreSuccessesThanTrials`] for a contradictory count, [`StatsError::TooFew`]
    /// below two clusters.
    ///
    /// ```
    /// use stats::{Confidence, Sample, BetaBinomial};
    /// let subjects = [9, 10, 8, 7, 9, 10, 10, 6, 9, 10].map(|successes| Sample { successes, trials: 10 });
    /// let fit = BetaBinomial::fit(&subjects)?;
    /// assert!((fit.mean - 0.88).abs() < 1e-3 && fit.effective_size < 100.0);
    /// // Wider than the interval of 100 independent trials, [0.802, 0.930].
    /// let interval = fit.interval(Confidence::P95);
    /// assert!(interval.low < 0.80 && interval.high > 0.93);
    /// # Ok::<(), stats::StatsError>(())
    /// ```
    pub fn fit(clusters: &[Sample]) -> Result<Self, StatsError> {
        let total = pool(clusters)?;
        let model = Model::new(clusters);
        if model.clusters < 2 {
            return Err(StatsError::TooFew {
                what: "clusters",
                found: model.clusters,
                needed: 2,
            });
        }
        let (mean, correlation, most_likely) = model.maximum(total);
        let independent = model.ln_likelihood(total.successes as f64 / total.trials as f64, 0.0);
        let statistic = (2.0 * (most_likely - independent)).max(0.0);
        Ok(Self {
            total,
            clusters: model.clusters,
            mean,
            intraclass_correlation: correlation,
            statistic,
            p_value: if statistic > 0.0 {
                0.5 * chi_squared_sf(statistic, 1.0)
            } else {
                1.0
            },
            effective_size: model.effective_size(total, correlation),
            most_likely,
            model,
        })
    }

    /// The profile-likelihood interval of the mean rate.
    #[must_use]
    pub fn interval(&self, confidence: Confidence) -> Interval {
        let allowed = 0.5 * likelihood_drop(confidence, self.clusters);
        let excluded = |mean: f64| self.most_likely - self.model.profile(mean).1 > allowed;
        Interval {
            low: boundary(0.0, self.mean, excluded),
            high: boundary(1.0, self.mean, excluded),
        }
    }

    /// P-values of the mean being at most the threshold (a small value is evidence that it is above) and at least the
    /// threshold (evidence that it is below): the greater of those by the ratio of likelihoods, of which the one is 2.5 % at
    /// an end of the 95 % [`interval`](Self::interval), and of the probabilities of a better count at the threshold, with the
    /// correlation that is most likely there and half of the probability of this count, where that has few enough outcomes to be summed.
    #[must_use]
    pub fn threshold_tests(&self, threshold: f64) -> (f64, f64) {
        // Certainty is excluded by one outcome to the contrary.
        if threshold <= 0.0 || threshold >= 1.0 {
            return self.likelihood_tests(threshold);
        }
        let (correlation, likelihood) = self.model.profile(threshold);
        let (above, below) = self.by_ratio(self.deviate_of(threshold, likelihood));
        let (higher, lower) =
            tails(&self.model.counts, threshold, correlation).unwrap_or((0.0, 0.0));
        (above.max(higher), below.max(lower))
    }

    /// Those by the ratio of likelihoods alone.
    #[must_use]
    pub fn likelihood_tests(&self, threshold: f64) -> (f64, f64) {
        self.by_ratio(self.deviate(threshold))
    }

    fn by_ratio(&self, deviate: f64) -> (f64, f64) {
        let degrees = self.clusters as f64 - 1.0;
        (
            student_t_sf(deviate, degrees),
            student_t_sf(-deviate, degrees),
        )
    }

    /// What Student's deviate of normal cluster means with this ratio of likelihoods would be: positive where the mean is
    /// above the threshold.
    fn deviate(&self, threshold: f64) -> f64 {
        // Certainty is excluded by one outcome to the contrary.
        match threshold <= 0.0 || threshold >= 1.0 {
            true if threshold == self.mean => 0.0,
            true => f64::INFINITY.copysign(self.mean - threshold),
            false => self.deviate_of(threshold, self.model.profile(threshold).1),
        }
    }

    /// The same where the largest likelihood at the threshold is this.
    fn deviate_of(&self, threshold: f64, likelihood: f64) -> f64 {
        if threshold == self.mean {
            return 0.0;
        }
        let clusters = self.clusters as f64;
        let fall = 2.0 * (self.most_likely - likelihood).max(0.0);
        let size = ((clusters - 1.0) * (fall / clusters).exp_m1()).sqrt();
        size.copysign(self.mean - threshold)
    }

    /// The mean at the effective size, for tests of independent trials.
    #[must_use]
    pub fn effective_sample(&self) -> EffectiveSample {
        EffectiveSample {
            successes: self.mean * self.effective_size,
            trials: self.effective_size,
        }
    }

    /// The logarithm of the likelihood, but for a constant of the data.
    #[must_use]
    pub fn ln_likelihood(&self, mean: f64, intraclass_correlation: f64) -> f64 {
        self.model.ln_likelihood(mean, intraclass_correlation)
    }
}

/// The distinct counts of a cluster, `(successes, failures)`, each with how often it occurs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Model {
    counts: Vec<(f64, f64, f64)>,
    clusters: usize,
    /// All successes, all failures.
    outcomes: (f64, f64),
    successes: Rising,
    failures: Rising,
    trials: Rising,
}

/// The largest intraclass correlation that is tried; 1 itself has no density.
const MOST_ALIKE: f64 = 1.0 - 1e-9;

impl Model {
    pub(crate) fn new(clusters: &[Sample]) -> Self {
        let mut counts: BTreeMap<(u64, u64), u64> = BTreeMap::new();
        for cluster in clusters.iter().filter(|cluster| cluster.trials > 0) {
            *counts
                .entry((cluster.successes, cluster.failures()))
                .or_default() += 1;
        }
        let of = |outcome: fn(&(u64, u64)) -> u64| {
            Rising::new(counts.iter().map(|(each, times)| (outcome(each), *times)))
        };
        let sum = |outcome: fn(&(u64, u64)) -> u64| {
            let all = counts
                .iter()
                .map(|(each, times)| outcome(each) as f64 * *times as f64);
            all.sum()
        };
        Self {
            clusters: counts.values().sum::<u64>() as usize,
            outcomes: (sum(|(s, _)| *s), sum(|(_, f)| *f)),
            successes: of(|(s, _)| *s),
            failures: of(|(_, f)| *f),
            trials: of(|(s, f)| s + f),
            counts: counts
                .into_iter()
                .map(|((s, f), times)| (s as f64, f as f64, times as f64))
                .collect(),
        }
    }

    fn ln_likelihood(&self, mean: f64, correlation: f64) -> f64 {
        let theta = correlation / (1.0 - correlation);
        let plain = times_ln(self.outcomes.0, mean) + times_ln(self.outcomes.1, 1.0 - mean);
        plain + self.successes.ln(mean, theta) + self.failures.ln(1.0 - mean, theta)
            - self.trials.ln(1.0, theta)
    }

    /// The likelihood at a correlation, at its most likely mean.
    pub(crate) fn at_correlation(&self, correlation: f64) -> f64 {
        let rates = self.counts.iter().map(|(s, f, _)| s / (s + f));
        let (low, high) = rates.fold((1.0_f64, 0.0_f64), |(low, high), r| {
            (low.min(r), high.max(r))
        });
        let at = |mean: f64| self.ln_likelihood(mean, correlation);
        // Clusters of one rate leave no range to look in.
        maximum_between(low, high, at).1.max(at(low))
    }

    /// The most likely correlation at a mean, and the likelihood there: a scan, because the
    /// profile may have a second maximum far from 0, then the best place about the best point.
    fn profile(&self, mean: f64) -> (f64, f64) {
        let at = |u: f64| self.ln_likelihood(mean, correlation_at(u));
        let best = (0..=SCAN)
            .map(|step| f64::from(step) / f64::from(SCAN))
            .map(|u| (u, at(u)))
            .fold((0.0, f64::NEG_INFINITY), |best, new| {
                if new.1 > best.1 { new } else { best }
            });
        // Trials are mostly no more alike than chance has them: then it falls from 0 on.
        if best.0 == 0.0 && at(NO_CORRELATION) < best.1 {
            return (0.0, best.1);
        }
        let step = 1.0 / f64::from(SCAN);
        let (low, high) = ((best.0 - step).max(0.0), (best.0 + step).min(1.0));
        let refined = maximum_between(low, high, at);
        let chosen = if refined.1 > best.1 { refined } else { best };
        (correlation_at(chosen.0), chosen.1)
    }

    /// The most likely correlation if this is the mean.
    pub(crate) fn most_likely_correlation(&self, mean: f64) -> f64 {
        self.profile(mean).0
    }

    /// The most likely mean and correlation, and their likelihood.
    fn maximum(&self, total: Sample) -> (f64, f64, f64) {
        if total.failures() == 0 || total.successes == 0 {
            let mean = if total.successes == 0 { 0.0 } else { 1.0 };
            return (mean, 0.0, 0.0);
        }
        let rate = total.successes as f64 / total.trials as f64;
        // The clusters' own rates bracket the mean: beyond them, each cluster speaks against it.
        let rates = self.counts.iter().map(|(s, f, _)| s / (s + f));
        let (low, high) = rates.fold((rate, rate), |(low, high), r| (low.min(r), high.max(r)));
        let (mean, value) = maximum_between(low, high, |mean| self.profile(mean).1);
        let pooled = self.profile(rate);
        if pooled.1 >= value {
            (rate, pooled.0, pooled.1)
        } else {
            let profile = self.profile(mean);
            (mean, profile.0, profile.1)
        }
    }

    fn effective_size(&self, total: Sample, correlation: f64) -> f64 {
        let trials = total.trials as f64;
        if total.failures() == 0 || total.successes == 0 {
            return self.clusters as f64;
        }
        let squares: f64 = self
            .counts
            .iter()
            .map(|(s, f, times)| times * (s + f) * (s + f))
            .sum();
        trials / (1.0 + correlation * (squares / trials - 1.0))
    }
}

/// Steps of the scan of a profile.
const SCAN: u32 = 16;

/// The place of a correlation of 1e-9, which clusters of millions of trials do not tell from none.
const NO_CORRELATION: f64 = 1e-3;

/// Correlations at `u` from 0 to 1, dense near 0 where counts decide most.
pub(crate) fn correlation_at(u: f64) -> f64 {
    u * u * u * MOST_ALIKE
}

/// `k ln x`, and 0 for no occurrence of whatever probability.
fn times_ln(k: f64, x: f64) -> f64 {
    if k > 0.0 { k * x.ln() } else { 0.0 }
}

/// Numbers of outcomes in clusters, of which a likelihood has the sum of `R(k, m / theta)`.
#[derive(Clone, Debug, PartialEq)]
struct Rising {
    /// Of the factors `1 + i theta / m`, `i` from 1, such as occur in equally many clusters, of those with few outcomes: from
    /// which on, up to which, in how many.
    runs: Vec<(u32, u32, f64)>,
    /// Sums of the powers of `i` from the first on, for factors near 1.
    powers: [f64; POWERS],
    /// More outcomes, and of how many clusters.
    many: Vec<(f64, f64)>,
}

/// Up to so many outcomes a product is formed of its factors, which all clusters have in common.
const FEW: u64 = 64;

/// Factors that are multiplied before a logarithm is taken: of 64 outcomes and any correlation their product is a number.
const AT_ONCE: usize = 8;

/// Terms of the logarithm's series, and up to which distance from 1 they are exact to rounding.
const POWERS: usize = 5;
const NEAR_ONE: f64 = 1e-3;

impl Rising {
    /// Of so many outcomes in so many clusters, each.
    fn new(clusters: impl Iterator<Item = (u64, u64)>) -> Self {
        let (mut factors, mut many) = (Vec::new(), Vec::new());
        for (k, times) in clusters {
            if k > FEW {
                many.push((k as f64, times as f64));
                continue;
            }
            let of_this = k.saturating_sub(1) as usize;
            if of_this > factors.len() {
                factors.resize(of_this, 0.0);
            }
            factors[..of_this]
                .iter_mut()
                .for_each(|it| *it += times as f64);
        }
        let mut runs: Vec<(u32, u32, f64)> = Vec::new();
        let mut powers = [0.0; POWERS];
        for (times, i) in factors.into_iter().zip(1_u32..) {
            match runs.last_mut() {
                Some(run) if run.2 == times => run.1 = i,
                _ => runs.push((i, i, times)),
            }
            let mut power = times;
            for sum in &mut powers {
                power *= f64::from(i);
                *sum += power;
            }
        }
        Self { runs, powers, many }
    }

    /// `sum_k ln prod_(i<k) (1 + i theta / m)`; of many outcomes, with `a = m / theta`,
    /// `D(a + k, a) - ln(1 + k/a)/2 + d(a + k) - d(a)` (deviance and Stirling errors).
    fn ln(&self, m: f64, theta: f64) -> f64 {
        if theta <= 0.0 || (self.runs.is_empty() && self.many.is_empty()) {
            return 0.0;
        }
        let a = m / theta;
        if a <= 0.0 {
            return f64::INFINITY;
        }
        let few = self.ln_of_few(1.0 / a);
        if self.many.is_empty() {
            return few;
        }
        let at_a = stirling_error(a);
        let each = |(k, times): &(f64, f64)| {
            times * (deviance_of_sum(*k, a) - 0.5 * (k / a).ln_1p() + stirling_error(a + k) - at_a)
        };
        few + self.many.iter().map(each).sum::<f64>()
    }

    /// That of the clusters with few outcomes, `step` being `theta / m`: the logarithms of products of factors, or where all are
    /// near 1 the logarithm's series, since `1 + x` rounds `x`.
    fn ln_of_few(&self, step: f64) -> f64 {
        let largest = self.runs.last().map_or(0.0, |run| f64::from(run.1) * step);
        if largest < NEAR_ONE {
            let (mut power, mut sum) = (-1.0, 0.0);
            for (of_power, n) in self.powers.iter().zip(1_u32..) {
                power *= -step;
                sum += power * of_power / f64::from(n);
            }
            return sum;
        }
        let of_run = |&(from, to, times): &(u32, u32, f64)| {
            let (mut product, mut sum) = (1.0_f64, 0.0);
            for (place, i) in (from..=to).enumerate() {
                product *= 1.0 + f64::from(i) * step;
                if place % AT_ONCE == AT_ONCE - 1 {
                    sum += product.ln();
                    product = 1.0;
                }
            }
            times * (sum + product.ln())
        };
        self.runs.iter().map(of_run).sum()
    }
}

/// How closely a maximum is placed; its value is then exact to the square of that.
const PLACE: f64 = 1e-7;

/// The largest value of a function with one maximum, and where it is: parabolas through the three best points, and golden
/// sections where these lead nowhere (R. P. Brent, "Algorithms for Minimization without Derivatives", 1973, chapter 5).
fn maximum_between(low: f64, high: f64, function: impl Fn(f64) -> f64) -> (f64, f64) {
    const GOLDEN: f64 = 0.381_966_011_250_105_15;
    let (mut low, mut high) = (low, high);
    // The best point, the second, and the one that was the second before.
    let first = low + GOLDEN * (high - low);
    let value = function(first);
    let [mut best, mut second, mut third] = [(first, value); 3];
    let (mut step, mut step_before) = (0.0_f64, 0.0_f64);
    loop {
        let middle = f64::midpoint(low, high);
        let place = PLACE * (1e-3 + best.0.abs());
        if (best.0 - middle).abs() + 0.5 * (high - low) <= 2.0 * place {
            return best;
        }
        let parabola = vertex(best, second, third);
        let is_taken = |to: &f64| {
            step_before.abs() > place
                && to.abs() < 0.5 * step_before.abs()
                && (low..high).contains(&(best.0 + to))
        };
        match parabola.filter(is_taken) {
            Some(to) => {
                step_before = step;
                let reached = best.0 + to;
                let is_at_an_end = reached - low < 2.0 * place || high - reached < 2.0 * place;
                step = if is_at_an_end {
                    place.copysign(middle - best.0)
                } else {
                    to
                };
            }
            None => {
                step_before = if best.0 < middle {
                    high - best.0
                } else {
                    low - best.0
                };
                step = GOLDEN * step_before;
            }
        }
        let at = best.0
            + if step.abs() < place {
                place.copysign(step)
            } else {
                step
            };
        let new = (at, function(at));
        let end = if new.1 >= best.1 { best.0 } else { at };
        if (new.1 >= best.1) == (at < best.0) {
            high = end;
        } else {
            low = end;
        }
        if new.1 >= best.1 {
            (third, second, best) = (second, best, new);
        } else if new.1 >= second.1 || second.0 == best.0 {
            (third, second) = (second, new);
        } else if new.1 >= third.1 || third.0 == best.0 || third.0 == second.0 {
            third = new;
        }
    }
}

/// How far the vertex of the parabola through three points is from the first; `None` where they are on a line.
fn vertex(first: (f64, f64), second: (f64, f64), third: (f64, f64)) -> Option<f64> {
    let (to_second, to_third) = (first.0 - second.0, first.0 - third.0);
    let by_third = to_second * (first.1 - third.1);
    let by_second = to_third * (first.1 - second.1);
    let divisor = 2.0 * (by_second - by_third);
    let step = (to_second * by_third - to_third * by_second) / divisor;
    (divisor != 0.0 && step.is_finite()).then_some(step)
}

/// The end of an interval between `outside`, which may be excluded, and `inside`, which is not.
pub(crate) fn boundary(end: f64, inside: f64, excluded: impl Fn(f64) -> bool) -> f64 {
    let (mut outside, mut inside) = (end, inside);
    for _ in 0..60 {
        let middle = f64::midpoint(outside, inside);
        if middle == outside || middle == inside || (outside - inside).abs() < 1e-12 {
            break;
        }
        if excluded(middle) {
            outside = middle;
        } else {
            inside = middle;
        }
    }
    outside
}

/// How far twice the logarithm of the likelihood may fall within the interval: without limit for one cluster.
pub(crate) fn likelihood_drop(confidence: Confidence, clusters: usize) -> f64 {
    if clusters < 2 {
        return f64::INFINITY;
    }
    let (clusters, degrees) = (clusters as f64, clusters as f64 - 1.0);
    let t = student_t_quantile(0.5 * confidence.alpha(), degrees);
    clusters * (t * t / degrees).ln_1p()
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

    fn close(found: f64, expected: f64, tolerance: f64) {
        assert!(
            (found / expected - 1.0).abs() < tolerance,
            "found {found:e}, expected {expected:e}"
        );
    }

    /// Mean, correlation, statistic, p-value and interval (95 %), by scipy 1.17: minimize
    /// (Nelder-Mead, five starts), minimize_scalar and brentq of the definition with betaln.
    #[test]
    fn reference_values() {
        let cohort: Vec<(u64, u64)> = [9, 10, 8, 7, 9, 10, 10, 6, 9, 10].map(|s| (s, 10)).to_vec();
        let uneven = vec![(2, 12), (11, 15), (0, 7), (30, 40), (5, 5), (18, 60)];
        let large = vec![(880, 1000), (850, 1000), (905, 1000), (790, 1000)];
        let expected = [
            [
                0.88038610273,
                0.0829082964,
                1.847573517136,
                0.087032936306,
                0.738759201821,
                0.950766983652,
            ],
            [
                0.48214683188,
                0.371490977268,
                25.491228860288,
                2.221993216e-07,
                0.202221073580,
                0.775583588319,
            ],
            [
                0.856201544542,
                0.013268717455,
                43.974019448238,
                1.6638180618e-11,
                0.757326466364,
                0.912828208017,
            ],
        ];
        for (counts, expected) in [cohort, uneven, large].iter().zip(expected) {
            let fit = BetaBinomial::fit(&samples(counts)).unwrap();
            let interval = fit.interval(Confidence::P95);
            close(fit.mean, expected[0], 1e-6);
            close(fit.intraclass_correlation, expected[1], 1e-4);
            close(fit.statistic, expected[2], 1e-8);
            close(fit.p_value, expected[3], 1e-7);
            close(interval.low, expected[4], 1e-6);
            close(interval.high, expected[5], 1e-6);
        }
    }

    #[test]
    fn at_the_ends_each_cluster_counts_once() {
        let fit = BetaBinomial::fit(&samples(&[(10, 10), (3, 3), (50, 50), (1, 1)])).unwrap();
        assert_eq!((fit.mean, fit.statistic, fit.p_value), (1.0, 0.0, 1.0));
        assert_eq!(fit.effective_size, 4.0);
        let interval = fit.interval(Confidence::P95);
        assert_eq!(interval.high, 1.0);
        // The likelihood of mean m is at most m^4, reached as the correlation goes to 1.
        let drop = likelihood_drop(Confidence::P95, 4);
        let student: f64 = 3.182_446_305_284_263;
        close(drop, 4.0 * (student.powi(2) / 3.0).ln_1p(), 1e-12);
        close(interval.low, (-drop / 8.0).exp(), 1e-6);
        let none = BetaBinomial::fit(&samples(&[(0, 10), (0, 3), (0, 50), (0, 1)])).unwrap();
        close(
            none.interval(Confidence::P95).high,
            1.0 - interval.low,
            1e-6,
        );
    }

    #[test]
    fn trials_more_alike_than_chance_between_clusters_are_independent() {
        let fit = BetaBinomial::fit(&samples(&[(5, 10), (5, 10), (5, 10)])).unwrap();
        assert_eq!((fit.intraclass_correlation, fit.p_value), (0.0, 1.0));
        close(fit.effective_size, 30.0, 1e-12);
        close(fit.mean, 0.5, 1e-7);
    }

    #[test]
    fn clusters_of_a_hundred_million_trials_are_as_quick_and_as_exact() {
        // R(k, a) directly, and by the closed form used beyond 64; several clusters at once.
        for (m, theta) in [(0.3, 1e-9), (0.3, 1e-3), (0.999, 0.7), (1e-6, 5.0)] {
            let a: f64 = m / theta;
            let of = |k: u32| -> f64 { (0..k).map(|i| (f64::from(i) / a).ln_1p()).sum() };
            for clusters in [
                vec![(2000, 1_u32)],
                vec![(0, 3), (1, 2), (7, 5), (64, 1), (65, 2), (2000, 4)],
            ] {
                let parts = clusters.iter().map(|(k, times)| f64::from(*times) * of(*k));
                let sum: f64 = parts.sum();
                let found = Rising::new(
                    clusters
                        .iter()
                        .map(|(k, times)| (u64::from(*k), u64::from(*times))),
                );
                let found = found.ln(m, theta);
                assert!((found - sum).abs() < 1e-10 * (1.0 + sum), "{found} {sum}");
            }
        }
        let n = 100_000_000;
        let fit = BetaBinomial::fit(&samples(&[
            (n / 2, n),
            (n / 2 + 100_000, n),
            (n / 2 - 70_000, n),
        ]))
        .unwrap();
        assert!(fit.p_value < 1e-9 && fit.mean > 0.499 && fit.mean < 0.501);
        assert!(fit.effective_size < 1e7);
    }

    #[test]
    fn what_cannot_be_fitted_is_refused() {
        assert!(BetaBinomial::fit(&samples(&[(3, 4)])).is_err());
        assert!(BetaBinomial::fit(&samples(&[(3, 4), (0, 0)])).is_err());
        assert!(BetaBinomial::fit(&samples(&[(4, 3), (1, 3)])).is_err());
    }
}
