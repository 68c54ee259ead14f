//! What several counts say together about one rate.
//!
//! *Power prior*: each count enters with a weight `w_i` from 0 (left out) to 1 (in full):
//!
//! ```text
//! p ~ Beta(1/2 + sum w_i s_i, 1/2 + sum w_i f_i)
//! ```
//!
//! *Random effects*, for rates that scatter: log-odds `y_i` with variances `v_i / w_i` (see
//! [`mod@crate::heterogeneity`]) about true ones that are normal with mean `m` and standard deviation `t`;
//! `m` has a flat prior, `t` a half-normal one of scale [`BETWEEN`]:
//!
//! ```text
//! p(t | y) ~ exp(-t^2 / (2 s^2)) prod (v_i/w_i + t^2)^(-1/2) V^(1/2) exp(-sum (y_i - M)^2 / (v_i/w_i + t^2) / 2)
//! p(m | y) = integral of Normal(m; M, V) p(t | y) over t,   1/V = sum 1/(v_i/w_i + t^2),  M their weighted mean
//! ```
//!
//! The integral over `t` is a sum over 250 nodes, even in `ln t`.
//!
//! Source: J. G. Ibrahim and M.-H. Chen, "Power prior distributions for regression models" (2000);
//! A. Gelman, "Prior distributions for variance parameters in hierarchical models" (2006) for a half-normal
//! prior; T. Friede, C. Roever, S. Wandel and B. Neuenschwander, "Meta-analysis of few small studies in orphan
//! diseases" (2017) for its scale of 0.5 on log-odds. Deviation: a weight divides the information of a sample
//! in the random effects, too. With two or three samples the interval of Hartung and Knapp, which asks
//! only the samples how much they scatter, reaches from nearly 0 to nearly 1.
//! Cost: linear. Guarantee: the power prior covers on average over its prior when the rates are one; the
//! random effects' interval is of the mean of the rates, on average over the prior, and its log-odds are
//! taken as normal.
//!
//! # Assumes
//! Samples are independent of each other given their rates, of independent trials or at their effective size; weights were
//! declared without looking at the counts. The power prior: all have one rate. Random effects: true log-odds are
//! exchangeable and normal, and scatter as the prior has it ([`ScatteredRate::is_beyond_the_prior`] tells where not).

use crate::counts::{Confidence, EffectiveSample, Interval, StatsError};
use crate::heterogeneity::log_odds_and_variances;
use crate::posterior::BetaPosterior;
use crate::special::normal_cdf;

/// The scale of the prior of the standard deviation between the log-odds of samples: rates of 0.9 that
/// differ between 0.78 and 0.96 are as far apart as it expects at most.
pub const BETWEEN: f64 = 0.5;

/// What the prior gives 0.3 % to be exceeded.
pub const MOST_BETWEEN: f64 = 3.0 * BETWEEN;

/// Nodes of the integral over that standard deviation.
const NODES: usize = 250;

/// The part of the posterior that a node may leave out.
const NEGLIGIBLE: f64 = 1e-15;

/// The standard deviation up to which is integrated, in scales of its prior.
const FARTHEST: f64 = 12.0;

/// The mean of rates that scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScatteredRate {
    /// Its posterior median.
    pub rate: f64,
    /// Its credible interval, equal-tailed.
    pub interval: Interval,
    /// Posterior median of the standard deviation between the log-odds.
    pub between: f64,
}

impl ScatteredRate {
    /// Whether the samples are further apart than the prior says that they can be ([`MOST_BETWEEN`]). Then the prior
    /// holds them together against their counts, and the interval is far too narrow: nothing may be said of a mean.
    #[must_use]
    pub fn is_beyond_the_prior(&self) -> bool {
        self.between > MOST_BETWEEN
    }
}

/// The posterior of one common rate, each sample entering with its weight.
///
/// # Errors
/// [`StatsError::OutOfRange`] for a weight outside `[0, 1]`, [`StatsError::NoTrials`] when no
/// sample carries information at a positive weight.
///
/// ```
/// use stats::{Confidence, Sample, power_prior};
/// let ours = Sample::new(88, 100)?;
/// let theirs = Sample::new(439, 500)?;
/// let half = power_prior(&[(ours.into(), 1.0), (theirs.into(), 0.5)])?;
/// assert_eq!(half.parameters(), (308.0, 43.0));
/// # Ok::<(), stats::StatsError>(())
/// ```
pub fn power_prior(samples: &[(EffectiveSample, f64)]) -> Result<BetaPosterior, StatsError> {
    let (mut successes, mut failures) = (0.0, 0.0);
    for (sample, weight) in samples {
        check_weight(*weight)?;
        if sample.is_informative() {
            successes += weight * sample.successes;
            failures += weight * sample.failures();
        }
    }
    if successes + failures <= 0.0 {
        return Err(StatsError::NoTrials);
    }
    BetaPosterior::new(0.5 + successes, 0.5 + failures)
}

/// The mean rate of samples whose true rates scatter, each with its weight; those of weight 0 and without
/// trials are left out.
///
/// # Errors
/// [`StatsError::OutOfRange`] for a weight outside `[0, 1]`, [`StatsError::TooFew`] if less than two samples
/// are left.
///
/// ```
/// use stats::{Confidence, Sample, scattered_rate};
/// let samples = [(Sample::new(455, 500)?.into(), 1.0), (Sample::new(470, 500)?.into(), 1.0)];
/// let mean = scattered_rate(&samples, Confidence::P95)?;
/// assert!(mean.interval.low > 0.85 && mean.interval.high < 0.965);
/// # Ok::<(), stats::StatsError>(())
/// ```
pub fn scattered_rate(
    samples: &[(EffectiveSample, f64)],
    confidence: Confidence,
) -> Result<ScatteredRate, StatsError> {
    let mut kept = Vec::new();
    let mut weights = Vec::new();
    for (sample, weight) in samples {
        check_weight(*weight)?;
        if *weight > 0.0 && sample.is_informative() {
            kept.push(*sample);
            weights.push(*weight);
        }
    }
    if kept.len() < 2 {
        return Err(StatsError::TooFew {
            what: "samples",
            found: kept.len(),
            needed: 2,
        });
    }
    let (log_odds, mut variances) = log_odds_and_variances(&kept);
    for (variance, weight) in variances.iter_mut().zip(&weights) {
        *variance /= weight;
    }
    let mean = Mixture::new(&log_odds, &variances);
    let logistic = |log_odds: f64| 1.0 / (1.0 + (-log_odds).exp());
    let tail = 0.5 * confidence.alpha();
    Ok(ScatteredRate {
        rate: logistic(mean.quantile(0.5)),
        interval: Interval {
            low: logistic(mean.quantile(tail)),
            high: logistic(mean.quantile(1.0 - tail)),
        },
        between: mean.median_between(),
    })
}

/// The posterior of the mean log-odds: normal distributions with weights that sum to 1.
struct Mixture {
    parts: Vec<Part>,
}

struct Part {
    /// The standard deviation between the log-odds.
    between: f64,
    weight: f64,
    mean: f64,
    deviation: f64,
}

impl Mixture {
    fn new(log_odds: &[f64], variances: &[f64]) -> Self {
        let smallest = variances
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min)
            .sqrt();
        let (first, last) = (
            (1e-4 * smallest.min(BETWEEN)).ln(),
            (FARTHEST * BETWEEN).ln(),
        );
        let step = (last - first) / (NODES - 1) as f64;
        let mut densities = Vec::with_capacity(NODES);
        let mut parts = Vec::with_capacity(NODES);
        for node in 0..NODES {
            let log_between = first + step * node as f64;
            let between = log_between.exp();
            let (part, log_likelihood) = at(log_odds, variances, between * between);
            let prior = -0.5 * (between / BETWEEN).powi(2);
            // The density of the logarithm; all that is below the first node lies at it.
            let below = if node == 0 {
                (1.0 / step + 0.5).ln()
            } else {
                0.0
            };
            densities.push(log_likelihood + prior + log_between + below);
            parts.push(part);
        }
        let greatest = densities.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = densities
            .iter()
            .map(|density| (density - greatest).exp())
            .sum();
        for (part, density) in parts.iter_mut().zip(&densities) {
            part.weight = (density - greatest).exp() / total;
        }
        parts.retain(|part| part.weight > NEGLIGIBLE);
        Self { parts }
    }

    fn cdf(&self, x: f64) -> f64 {
        let below = |part: &Part| part.weight * normal_cdf((x - part.mean) / part.deviation);
        self.parts.iter().map(below).sum()
    }

    /// The parts ascend in it.
    fn median_between(&self) -> f64 {
        let mut below = 0.0;
        let mut parts = self.parts.iter();
        let half = parts.find(|part| {
            below += part.weight;
            below >= 0.5
        });
        half.map_or(0.0, |part| part.between)
    }

    fn quantile(&self, level: f64) -> f64 {
        let reach = |part: &Part| {
            (
                part.mean - 9.0 * part.deviation,
                part.mean + 9.0 * part.deviation,
            )
        };
        let ends = self.parts.iter().map(reach);
        let (mut low, mut high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |all, end| {
            (all.0.min(end.0), all.1.max(end.1))
        });
        while high - low > 1e-10 * (1.0 + low.abs().min(high.abs())) {
            let middle = 0.5 * (low + high);
            if self.cdf(middle) < level {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}

/// The mean log-odds, given the variance between samples; and the logarithm of that variance's likelihood.
fn at(log_odds: &[f64], variances: &[f64], between: f64) -> (Part, f64) {
    let (mut total, mut weighted, mut log_likelihood) = (0.0, 0.0, 0.0);
    for (y, v) in log_odds.iter().zip(variances) {
        let variance = v + between;
        total += 1.0 / variance;
        weighted += y / variance;
        log_likelihood -= 0.5 * variance.ln();
    }
    let mean = weighted / total;
    for (y, v) in log_odds.iter().zip(variances) {
        log_likelihood -= 0.5 * (y - mean).powi(2) / (v + between);
    }
    let part = Part {
        between: between.sqrt(),
        weight: 0.0,
        mean,
        deviation: (1.0 / total).sqrt(),
    };
    (part, log_likelihood - 0.5 * total.ln())
}

fn check_weight(weight: f64) -> Result<(), StatsError> {
    if (0.0..=1.0).contains(&weight) {
        return Ok(());
    }
    Err(StatsError::OutOfRange {
        what: "weight",
        value: weight,
        expected: "a number from 0 to 1",
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counts::Sample;

    fn samples(counts: &[(u64, u64)]) -> Vec<Sample> {
        counts
            .iter()
            .map(|&(successes, trials)| Sample { successes, trials })
            .collect()
    }

    /// Quadrature of the posterior by scipy 1.17 (`integrate.quad` over the standard deviation between samples,
    /// piece by piece to a relative error of 1e-12, `optimize.brentq` for the quantiles).
    /// Two counts of 10^8 without a failure, or one, beside 99 of 100: with the prior against them, the mean would be
    /// said to lie above 0.9999.
    #[test]
    fn samples_that_the_prior_cannot_hold_together_are_told() {
        let of = |counts: &[(u64, u64)]| {
            let sample = |(successes, trials): &(u64, u64)| {
                let sample = crate::counts::Sample {
                    successes: *successes,
                    trials: *trials,
                };
                (sample.into(), 1.0)
            };
            let samples: Vec<(EffectiveSample, f64)> = counts.iter().map(sample).collect();
            scattered_rate(&samples, Confidence::P95).unwrap()
        };
        let far = of(&[(T, T), (T - 1, T), (99, 100)]);
        assert!(
            far.interval.low > 0.9999 && far.is_beyond_the_prior(),
            "{far:?}"
        );
        for near in [
            [(88, 100), (439, 500)],
            [(78, 100), (96, 100)],
            [(0, 5), (5, 5)],
        ] {
            let near = of(&near);
            assert!(!near.is_beyond_the_prior(), "{near:?}");
        }
    }

    const T: u64 = 100_000_000;

    #[test]
    fn reference_values() {
        let close = |found: f64, expected: f64| {
            let odds = |rate: f64| (rate / (1.0 - rate)).ln();
            assert!(
                (odds(found) - odds(expected)).abs() < 3e-4,
                "{found} {expected}"
            );
        };
        for (counts, weights, [low, rate, high]) in [
            (
                vec![(80, 100), (88, 100), (439, 500), (310, 500)],
                vec![1.0; 4],
                [0.6665946256622596, 0.8043449785114923, 0.8967805656931519],
            ),
            (
                vec![(455, 500), (470, 500)],
                vec![1.0; 2],
                [0.8595774508353277, 0.9242469739475454, 0.9616258899928978],
            ),
            (
                vec![(9900, 10000), (9930, 10000)],
                vec![1.0; 2],
                [0.9835123050778374, 0.9914975940982591, 0.9957097446644662],
            ),
            (
                vec![(100_000_000, 100_000_000), (99_999_990, 100_000_000)],
                vec![1.0; 2],
                [0.9999997987168222, 0.9999999242905293, 0.9999999845979817],
            ),
            (
                vec![(88, 100), (439, 500)],
                vec![1.0, 0.25],
                [0.7821892462007864, 0.8767779427604813, 0.9337444464355817],
            ),
            (
                vec![(0, 20), (3, 30)],
                vec![1.0; 2],
                [
                    0.023052962772070775,
                    0.08675704872043652,
                    0.25239294614408825,
                ],
            ),
        ] {
            let found = scattered_rate(&weighted(&counts, &weights), Confidence::P95).unwrap();
            close(found.interval.low, low);
            close(found.rate, rate);
            close(found.interval.high, high);
        }
    }

    fn weighted(counts: &[(u64, u64)], weights: &[f64]) -> Vec<(EffectiveSample, f64)> {
        let samples = samples(counts).into_iter().map(EffectiveSample::from);
        samples.zip(weights.iter().copied()).collect()
    }

    #[test]
    fn an_interval_of_scattered_rates_is_wider_than_of_one_and_a_discounted_sample_says_less() {
        let same = weighted(&[(88, 100), (88, 100), (440, 500)], &[1.0; 3]);
        let found = scattered_rate(&same, Confidence::P95).unwrap().interval;
        let one = power_prior(&same)
            .unwrap()
            .credible_interval(Confidence::P95);
        assert!(
            found.low < one.low && found.high > one.high,
            "{found:?} {one:?}"
        );
        let towards = |weight: f64| {
            let samples = weighted(&[(455, 500), (470, 500)], &[1.0, weight]);
            scattered_rate(&samples, Confidence::P95).unwrap().rate
        };
        assert!(towards(0.1) < towards(0.5) && towards(0.5) < towards(1.0));
        assert!(scattered_rate(&same[..1], Confidence::P95).is_err());
        assert!(
            scattered_rate(&weighted(&[(1, 2), (3, 4)], &[1.0, 0.0]), Confidence::P95).is_err()
        );
        assert!(
            scattered_rate(&weighted(&[(1, 2), (3, 4)], &[1.0, 1.5]), Confidence::P95).is_err()
        );
    }

    #[test]
    fn weights_discount_and_leave_out() {
        let (a, b) = (
            EffectiveSample {
                successes: 8.0,
                trials: 10.0,
            },
            EffectiveSample {
                successes: 1.0,
                trials: 4.0,
            },
        );
        assert_eq!(
            power_prior(&[(a, 1.0), (b, 0.0)]).unwrap().parameters(),
            (8.5, 2.5)
        );
        assert_eq!(
            power_prior(&[(a, 0.5), (b, 1.0)]).unwrap().parameters(),
            (5.5, 4.5)
        );
        assert_eq!(power_prior(&[(a, 0.0)]), Err(StatsError::NoTrials));
        assert!(power_prior(&[(a, 1.5)]).is_err() && power_prior(&[(a, f64::NAN)]).is_err());
        assert!(power_prior(&[]).is_err());
    }
}
