//! What would follow if trials that are taken as independent were alike within groups: the intraclass correlation at which
//! a decision changes.
//!
//! # Definition
//! `N` trials in groups of `m` with the intraclass correlation `rho` tell as much as
//!
//! ```text
//! n(rho) = N / (1 + (m - 1) rho)
//! ```
//!
//! independent ones. For a decision that is a function of `n`, the *critical correlation* is the least `rho` in `(0, 1]`
//! at which it is another than at `rho = 0`.
//!
//! # Source
//! L. Kish, "Survey sampling" (1965), for the design effect `1 + (m - 1) rho`. That the least correlation is given at which
//! a conclusion falls follows J. Cornfield et al. (1959), who gave the least confounding that would explain an association.
//!
//! # Guarantee
//! The correlation is sought on [`STEPS`] equal steps of `1 / (1 + (m - 1) rho)`, and halved between two of them to
//! 1e-4; a decision that changes and changes back within one step is not seen. Cost: [`STEPS`] decisions at most and
//! twenty more.

/// Steps on which a change is sought.
pub const STEPS: u32 = 48;

/// The design effect of groups of `group_size` trials: the variance of a rate relative to that of independent trials.
///
/// ```
/// assert_eq!(stats::kish_design_effect(10.0, 0.1), 1.9);
/// ```
#[must_use]
pub fn kish_design_effect(group_size: f64, correlation: f64) -> f64 {
    1.0 + (group_size - 1.0).max(0.0) * correlation
}

/// The least correlation at which a decision on the effective share of trials (1 at `rho = 0`) changes; `None` if it is
/// the same up to 1.
///
/// ```
/// // A decision that needs half of the trials.
/// let found = stats::critical_correlation(11.0, |share| share >= 0.5).unwrap();
/// assert!((found - 0.1).abs() < 1e-4);
/// assert_eq!(stats::critical_correlation(2.0, |share| share >= 0.5), None);
/// ```
#[must_use]
pub fn critical_correlation<D: PartialEq>(
    group_size: f64,
    decide: impl Fn(f64) -> D,
) -> Option<f64> {
    if group_size <= 1.0 {
        return None;
    }
    let alone = decide(1.0);
    let least = 1.0 / kish_design_effect(group_size, 1.0);
    let share = |step: u32| 1.0 - (1.0 - least) * f64::from(step) / f64::from(STEPS);
    let changed = (1..=STEPS).find(|step| decide(share(*step)) != alone)?;
    let correlation = |share: f64| (1.0 / share - 1.0) / (group_size - 1.0);
    let (mut holds, mut fails) = (correlation(share(changed - 1)), correlation(share(changed)));
    while fails - holds > 1e-5 {
        let middle = 0.5 * (holds + fails);
        match decide(1.0 / kish_design_effect(group_size, middle)) == alone {
            true => holds = middle,
            false => fails = middle,
        }
    }
    Some(fails.min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Confidence, EffectiveSample, Sample, wilson};

    /// Wilson's lower limit in closed form, solved for the number of trials at which it is the threshold.
    #[test]
    fn the_correlation_is_the_one_at_which_the_limit_meets_the_threshold() {
        let sample = Sample {
            successes: 190,
            trials: 200,
        };
        let (rate, threshold, z) = (0.95, 0.9, 1.959_963_984_540_054_f64);
        // (rate - threshold)^2 = z^2 threshold (1 - threshold) / n at the limit.
        let n = z * z * threshold * (1.0 - threshold) / (rate - threshold).powi(2_i32);
        let expected = (200.0 / n - 1.0) / 19.0;
        let found = critical_correlation(20.0, |share| {
            let sample = EffectiveSample::at_size(sample, 200.0 * share).expect("a size");
            wilson(sample, Confidence::P95).low > threshold
        });
        assert!(
            (found.expect("a change") - expected).abs() < 1e-4,
            "{found:?} {expected}"
        );
    }

    #[test]
    fn single_trials_have_no_clustering() {
        assert_eq!(critical_correlation(1.0, |share| share > 0.99), None);
    }
}
