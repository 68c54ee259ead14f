//! The one-sided limits of a rate that belong to the tests of a threshold.
//!
//! # Definition
//! The lower limit at the level `a` is the largest threshold that the test shows to be exceeded with a p-value of at
//! most `a`; the upper limit the smallest that it shows not to be reached. For independent counts these are the limits
//! of Clopper and Pearson; for correlated ones those of the test of correlated trials; for a distribution its quantiles;
//! of a known value its bounds. Found by halving, so that limit and test are one statement.
//!
//! # Assumes
//! Those of the test. Between 0 and the estimate, and between it and 1, the test shows a threshold if it shows one nearer
//! to the estimate.
//!
//! # Guarantee
//! A threshold is shown to be met or missed exactly where it lies beyond the limit (to 1e-12).

use super::stand::{ClaimLevels, doubts};
use crate::compare::Belief;
use crate::{Direction, Interval, Threshold};

/// Halvings of an interval of rates: below the precision of a rate.
const HALVINGS: usize = 60;

/// The limits at the levels of both claims.
pub(super) fn limits(belief: &Belief, threshold: Threshold, levels: ClaimLevels) -> Interval {
    let (above, below) = match threshold.direction {
        Direction::AtLeast => (levels.met, levels.missed),
        Direction::AtMost => (levels.missed, levels.met),
    };
    match belief {
        Belief::Known { bounds, .. } => Interval {
            low: bounds.low,
            high: bounds.high,
        },
        Belief::Distribution {
            quantiles: Some(quantiles),
            ..
        } => Interval {
            low: quantiles.quantile(above),
            high: quantiles.quantile_upper(below),
        },
        Belief::Distribution { posterior, .. } => Interval {
            low: posterior.quantile(above),
            high: posterior.quantile_upper(below),
        },
        Belief::Range { ends, .. } => Interval {
            low: ends.least.quantile(above),
            high: ends.greatest.quantile_upper(below),
        },
        Belief::Counts { .. } => {
            let at_least = |value| Threshold {
                direction: Direction::AtLeast,
                value,
            };
            let doubts = |value| doubts(belief, at_least(value));
            of_tests(doubts, belief.estimate(), (above, below))
        }
    }
}

/// The limits of a rate whose p-values of "below the threshold" and "at least as high" are these, at the errors of its
/// lower and its upper limit.
pub(crate) fn of_tests(
    doubts: impl Fn(f64) -> (f64, f64),
    estimate: f64,
    (above, below): (f64, f64),
) -> Interval {
    Interval {
        low: last(|t| doubts(t).0 <= above, estimate),
        high: 1.0 - last(|rest| doubts(1.0 - rest).1 <= below, 1.0 - estimate),
    }
}

/// The last point from 0 to `high` up to which a statement holds.
fn last(holds: impl Fn(f64) -> bool, high: f64) -> f64 {
    let (mut low, mut high) = (0.0, high);
    if !holds(low) && !holds(1e-12) {
        return low;
    }
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use stats::{Confidence, EffectiveSample, IntervalMethod, Sample};

    fn of(successes: u64, trials: u64, alpha: f64) -> Interval {
        let sample = Sample { successes, trials };
        let belief = Belief::Counts {
            clusters: None,
            sample,
            effective: sample.into(),
            before: None,
            completions: None,
        };
        let threshold = Threshold {
            direction: Direction::AtLeast,
            value: 0.5,
        };
        let levels = ClaimLevels {
            met: alpha,
            missed: alpha,
        };
        limits(&belief, threshold, levels)
    }

    #[test]
    fn limits_of_counts_are_those_of_clopper_and_pearson() {
        for (successes, trials) in [
            (0, 1),
            (1, 1),
            (0, 30),
            (88, 100),
            (30, 30),
            (1, 7),
            (499, 500),
        ] {
            for level in [0.9, 0.95, 0.999] {
                let confidence = Confidence::new(level).expect("a level");
                let sample = Sample { successes, trials };
                let found = of(successes, trials, confidence.alpha());
                let (method, whole) = (
                    IntervalMethod::ClopperPearson,
                    EffectiveSample::from(sample),
                );
                let low = method.lower_limit(whole, confidence);
                let high = method.upper_limit(whole, confidence);
                assert!(
                    (found.low - low).abs() < 1e-9,
                    "{successes} {trials}: {found:?} {low}"
                );
                assert!(
                    (found.high - high).abs() < 1e-9,
                    "{successes} {trials}: {found:?} {high}"
                );
            }
        }
    }
}
