//! What several counts say together about one rate.
//!
//! *Power prior*: each count enters with a weight `w_i` from 0 (left out) to 1 (in full):
//!
//! ```text
//! p ~ Beta(1/2 + sum w_i s_i, 1/2 + sum w_i f_i)
//! ```
//!
//! *Random effects*, for rates that scatter: with log-odds `y_i`, variances `v_i`, the variance
//! between samples `tau^2` (see [`mod@crate::heterogeneity`]), `w_i = 1/(v_i + tau^2)` and their mean `m`,
//!
//! ```text
//! q = sum w_i (y_i - m)^2 / (k - 1),   interval m +- t sqrt(max(1, q) / sum w_i),  t of Student, k - 1 degrees
//! ```
//!
//! Source: J. G. Ibrahim and M.-H. Chen, "Power prior distributions for regression models" (2000);
//! J. Hartung and G. Knapp, "A refined method for the meta-analysis of controlled clinical trials
//! with binary outcome" (2001); C. Roever, G. Knapp and T. Friede (2015) for `max(1, q)`, without
//! which the interval may be narrower than for one common rate. Deviation: none. Cost: linear.
//! Guarantee: the power prior covers on average over its prior when the rates are one; the random
//! effects' interval is asymptotic, wide for two or three samples, and of the mean of the rates.

use crate::counts::{Confidence, EffectiveSample, Interval, StatsError};
use crate::heterogeneity::{Heterogeneity, log_odds_and_variances};
use crate::posterior::BetaPosterior;
use crate::special::student_t_quantile;

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
        if !(0.0..=1.0).contains(weight) {
            return Err(StatsError::OutOfRange {
                what: "weight",
                value: *weight,
                expected: "a number from 0 to 1",
            });
        }
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

/// The interval of the mean rate of samples whose true rates scatter.
///
/// `found` is the heterogeneity of the same samples.
///
/// # Errors
/// [`StatsError::TooFew`] below two samples.
pub fn random_effects_interval<S: Into<EffectiveSample> + Copy>(
    samples: &[S],
    found: &Heterogeneity,
    confidence: Confidence,
) -> Result<Interval, StatsError> {
    if samples.len() < 2 {
        return Err(StatsError::TooFew {
            what: "samples",
            found: samples.len(),
            needed: 2,
        });
    }
    let degrees = (samples.len() - 1) as f64;
    let variance = adjusted_variance(samples, found).max(found.random.standard_error.powi(2));
    let t = student_t_quantile(1.0 - 0.5 * confidence.alpha(), degrees);
    let half_width = t * variance.sqrt();
    let logistic = |log_odds: f64| 1.0 / (1.0 + (-log_odds).exp());
    Ok(Interval {
        low: logistic(found.random.log_odds - half_width),
        high: logistic(found.random.log_odds + half_width),
    })
}

/// `q / sum w`, Hartung and Knapp's variance of the combined log-odds.
fn adjusted_variance<S: Into<EffectiveSample> + Copy>(samples: &[S], found: &Heterogeneity) -> f64 {
    let samples: Vec<EffectiveSample> = samples.iter().map(|sample| (*sample).into()).collect();
    let (log_odds, variances) = log_odds_and_variances(&samples);
    let (mut total, mut squares) = (0.0, 0.0);
    for (y, v) in log_odds.iter().zip(&variances) {
        let weight = 1.0 / (v + found.tau_squared);
        total += weight;
        squares += weight * (y - found.random.log_odds).powi(2);
    }
    squares / ((samples.len() - 1) as f64 * total)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counts::Sample;
    use crate::heterogeneity::heterogeneity;

    fn samples(counts: &[(u64, u64)]) -> Vec<Sample> {
        counts
            .iter()
            .map(|&(successes, trials)| Sample { successes, trials })
            .collect()
    }

    /// statsmodels 0.14: combine_effects(y, v, method_re="chi2", use_t=True), sd_eff_w_re_hksj and,
    /// where that is below sd_eff_w_re, the latter; t by scipy 1.16.
    #[test]
    fn reference_values() {
        let scattered = samples(&[(80, 100), (88, 100), (439, 500), (310, 500)]);
        let found = heterogeneity(&scattered).unwrap();
        let error = adjusted_variance(&scattered, &found).sqrt();
        assert!((error / HKSJ - 1.0).abs() < 1e-10, "{error}");
        let interval = random_effects_interval(&scattered, &found, Confidence::P95).unwrap();
        assert!(
            (interval.low / INTERVAL.0 - 1.0).abs() < 1e-9,
            "{interval:?}"
        );
        assert!(
            (interval.high / INTERVAL.1 - 1.0).abs() < 1e-9,
            "{interval:?}"
        );
    }

    const HKSJ: f64 = 0.35219756129929725;
    const INTERVAL: (f64, f64) = (0.49279566988736667, 0.9475097380988852);

    #[test]
    fn samples_that_agree_too_well_do_not_narrow_the_interval() {
        let same = samples(&[(88, 100), (88, 100), (440, 500)]);
        let found = heterogeneity(&same).unwrap();
        let interval = random_effects_interval(&same, &found, Confidence::P95).unwrap();
        let fixed = found.fixed.interval(Confidence::P95);
        assert!(interval.low < fixed.low && interval.high > fixed.high);
        assert!(random_effects_interval(&same[..1], &found, Confidence::P95).is_err());
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
