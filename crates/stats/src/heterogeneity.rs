//! Whether several proportions can be one, and what they are when combined.
//!
//! With `s_i` successes and `f_i` failures, log-odds and their variances
//!
//! ```text
//! y_i = ln((s_i + 1/2)/(f_i + 1/2)),   v_i = 1/(s_i + 1/2) + 1/(f_i + 1/2),   w_i = 1/v_i
//! pooled  = sum w_i y_i / sum w_i,     variance 1 / sum w_i       (fixed effect)
//! Q       = sum w_i (y_i - pooled)^2   ~ chi-squared, k - 1 degrees of freedom
//! I^2     = max(0, (Q - (k-1)) / Q)
//! tau^2   = max(0, (Q - (k-1)) / (sum w - sum w^2 / sum w))       (between samples)
//! ```
//!
//! and the random-effects combination has weights `1/(v_i + tau^2)`. The chi-squared test of
//! homogeneity compares the 2 by k table of counts with its margins.
//!
//! Source: W. G. Cochran (1954); J. B. S. Haldane and F. J. Anscombe (1956) for the halves, which
//! keep the variance finite at 0 of n and n of n; J. Higgins and S. Thompson (2002) for I
//! squared; R. DerSimonian and N. Laird (1986) for tau squared; K. Pearson (1900). Deviation:
//! the halves are added to every sample always, so that a result never jumps when one count
//! reaches an end. Cost: linear. Guarantee: asymptotic.
//!
//! # Assumes
//! Samples are independent of each other, of independent trials or at their effective size. Log-odds are taken as normal
//! with known variances; the random effects take true log-odds as scattered about one mean.

use crate::counts::{Confidence, EffectiveSample, Interval, Sample, StatsError};
use crate::special::{chi_squared_sf, normal_quantile};

/// Cochran's test and what goes with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heterogeneity {
    /// Cochran's Q.
    pub statistic: f64,
    /// Degrees of freedom, the number of samples less one.
    pub degrees: usize,
    /// `P(chi-squared > Q)`.
    pub p_value: f64,
    /// The share of the variation that is beyond chance, 0 to 1.
    pub i_squared: f64,
    /// The variance of the true log-odds between samples.
    pub tau_squared: f64,
    /// The combination when one true rate is assumed.
    pub fixed: Combined,
    /// The combination when true rates scatter with variance `tau_squared`.
    pub random: Combined,
}

/// A combined proportion, on the scale of log-odds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Combined {
    /// The combined log-odds.
    pub log_odds: f64,
    /// Their standard error.
    pub standard_error: f64,
}

impl Combined {
    /// The combined rate.
    #[must_use]
    pub fn rate(&self) -> f64 {
        logistic(self.log_odds)
    }

    /// The interval of the rate, by normal theory for the log-odds.
    #[must_use]
    pub fn interval(&self, confidence: Confidence) -> Interval {
        let half_width = -normal_quantile(0.5 * confidence.alpha()) * self.standard_error;
        Interval {
            low: logistic(self.log_odds - half_width),
            high: logistic(self.log_odds + half_width),
        }
    }
}

fn logistic(log_odds: f64) -> f64 {
    1.0 / (1.0 + (-log_odds).exp())
}

/// Cochran's Q, I squared and both combinations of two or more samples.
///
/// # Errors
/// [`StatsError::TooFew`] below two samples, [`StatsError::NoTrials`] when one carries no
/// information.
pub fn heterogeneity<S: Into<EffectiveSample> + Copy>(
    samples: &[S],
) -> Result<Heterogeneity, StatsError> {
    let samples = informative(samples)?;
    let (log_odds, variances) = log_odds_and_variances(&samples);
    let fixed = combine(&log_odds, &variances, 0.0);
    let statistic: f64 = log_odds
        .iter()
        .zip(&variances)
        .map(|(y, v)| (y - fixed.log_odds).powi(2) / v)
        .sum();
    let degrees = samples.len() - 1;
    let excess = statistic - degrees as f64;
    let total: f64 = variances.iter().map(|v| 1.0 / v).sum();
    let squares: f64 = variances.iter().map(|v| 1.0 / (v * v)).sum();
    let tau_squared = (excess / (total - squares / total)).max(0.0);
    Ok(Heterogeneity {
        statistic,
        degrees,
        p_value: chi_squared_sf(statistic, degrees as f64),
        i_squared: if excess > 0.0 {
            excess / statistic
        } else {
            0.0
        },
        tau_squared,
        fixed,
        random: combine(&log_odds, &variances, tau_squared),
    })
}

/// All successes over all trials: what the samples say together if they were drawn alike.
///
/// # Errors
/// [`StatsError::NoTrials`] when there are none at all, [`StatsError::OutOfRange`] when the sum
/// does not fit, [`StatsError::MoreSuccessesThanTrials`] when a sample contradicts itself.
pub fn pool(samples: &[Sample]) -> Result<Sample, StatsError> {
    let mut pooled = Sample {
        successes: 0,
        trials: 0,
    };
    for sample in samples {
        Sample::new(sample.successes, sample.trials)?;
        // Each has at most 2^53, so that the sums fit; they are looked at, too.
        let successes = pooled.successes + sample.successes;
        pooled = Sample::new(successes, pooled.trials + sample.trials)?;
    }
    if pooled.trials == 0 {
        Err(StatsError::NoTrials)
    } else {
        Ok(pooled)
    }
}

/// A chi-squared statistic with its p-value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiSquared {
    /// The statistic.
    pub statistic: f64,
    /// Degrees of freedom.
    pub degrees: usize,
    /// `P(chi-squared > statistic)`.
    pub p_value: f64,
    /// The smallest expected count of a cell; below 5 the p-value is rough.
    pub smallest_expected: f64,
}

/// Pearson's chi-squared test that all samples have one true rate, without continuity correction.
///
/// # Errors
/// [`StatsError::TooFew`] below two samples, [`StatsError::NoTrials`] when one carries no
/// information, [`StatsError::Constant`] when all trials had the same outcome.
pub fn chi_squared_homogeneity<S: Into<EffectiveSample> + Copy>(
    samples: &[S],
) -> Result<ChiSquared, StatsError> {
    let samples = informative(samples)?;
    let trials: f64 = samples.iter().map(|s| s.trials).sum();
    let rate = samples.iter().map(|s| s.successes).sum::<f64>() / trials;
    if rate <= 0.0 || rate >= 1.0 {
        return Err(StatsError::Constant { what: "outcomes" });
    }
    let statistic = samples
        .iter()
        .map(|s| (s.successes - s.trials * rate).powi(2) / (s.trials * rate * (1.0 - rate)))
        .sum();
    let smallest = samples
        .iter()
        .map(|s| s.trials)
        .fold(f64::INFINITY, f64::min);
    let degrees = samples.len() - 1;
    Ok(ChiSquared {
        statistic,
        degrees,
        p_value: chi_squared_sf(statistic, degrees as f64),
        smallest_expected: smallest * rate.min(1.0 - rate),
    })
}

fn informative<S: Into<EffectiveSample> + Copy>(
    samples: &[S],
) -> Result<Vec<EffectiveSample>, StatsError> {
    if samples.len() < 2 {
        return Err(StatsError::TooFew {
            what: "samples",
            found: samples.len(),
            needed: 2,
        });
    }
    let samples: Vec<EffectiveSample> = samples.iter().map(|s| (*s).into()).collect();
    if samples.iter().all(EffectiveSample::is_informative) {
        Ok(samples)
    } else {
        Err(StatsError::NoTrials)
    }
}

/// Log-odds and their variances, with half a success and half a failure added.
pub(crate) fn log_odds_and_variances(samples: &[EffectiveSample]) -> (Vec<f64>, Vec<f64>) {
    samples
        .iter()
        .map(|sample| {
            let (successes, failures) = (sample.successes + 0.5, sample.failures() + 0.5);
            (
                (successes / failures).ln(),
                1.0 / successes + 1.0 / failures,
            )
        })
        .unzip()
}

fn combine(log_odds: &[f64], variances: &[f64], tau_squared: f64) -> Combined {
    let (mut total, mut weighted) = (0.0, 0.0);
    for (value, variance) in log_odds.iter().zip(variances) {
        let weight = 1.0 / (variance + tau_squared);
        total += weight;
        weighted += weight * value;
    }
    Combined {
        log_odds: weighted / total,
        standard_error: (1.0 / total).sqrt(),
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

    fn close(found: f64, expected: f64) {
        assert!(
            (found / expected - 1.0).abs() < 1e-11,
            "found {found:e}, expected {expected:e}"
        );
    }

    #[test]
    fn reference_values_of_cochran() {
        // statsmodels 0.14: combine_effects(y, v, method_re="chi2") with y and v as defined.
        let found = heterogeneity(&samples(&[(80, 100), (88, 100), (439, 500)])).unwrap();
        close(found.statistic, 4.656052914366967);
        close(found.p_value, 0.09748795401419158);
        close(found.i_squared, 0.5704516171135657);
        close(found.tau_squared, 0.06533447633899578);
        close(found.fixed.log_odds, 1.8449219597554531);
        close(found.fixed.standard_error, 0.11094503836337534);
        close(found.random.log_odds, 1.7837912574534491);
        close(found.random.standard_error, 0.19532762097537817);
    }

    #[test]
    fn reference_values_of_pearson() {
        // scipy 1.16: chi2_contingency([[80, 20], [88, 12], [439, 61]], correction=False)
        let found = chi_squared_homogeneity(&samples(&[(80, 100), (88, 100), (439, 500)])).unwrap();
        close(found.statistic, 4.568209597704202);
        close(found.p_value, 0.10186521115578737);
        close(found.smallest_expected, 13.285714285714286);
        assert_eq!(found.degrees, 2);
    }

    #[test]
    fn rates_of_zero_and_one_have_a_finite_variance() {
        let found = heterogeneity(&samples(&[(0, 5), (5, 5)])).unwrap();
        assert!(found.p_value < 0.05 && found.statistic.is_finite());
        let same = heterogeneity(&samples(&[(9, 9), (50, 50)])).unwrap();
        assert!(same.p_value > 0.3 && same.fixed.rate() < 1.0);
        assert!(
            same.fixed
                .interval(Confidence::P95)
                .contains(same.fixed.rate())
        );
        assert!(chi_squared_homogeneity(&samples(&[(5, 5), (7, 7)])).is_err());
        assert!(heterogeneity(&samples(&[(1, 2)])).is_err());
        assert!(heterogeneity(&samples(&[(1, 2), (0, 0)])).is_err());
    }

    #[test]
    fn pooling_adds_up() {
        let pooled = pool(&samples(&[(80, 100), (0, 0), (439, 500)])).unwrap();
        assert_eq!(
            pooled,
            Sample {
                successes: 519,
                trials: 600
            }
        );
        assert_eq!(pool(&[]), Err(StatsError::NoTrials));
        assert!(pool(&samples(&[(2, 1)])).is_err());
        assert!(pool(&samples(&[(1, u64::MAX), (1, 1)])).is_err());
    }
}
