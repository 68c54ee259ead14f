//! How one piece of evidence stands to a threshold.

use super::CERTAINTY;
use crate::compare::Belief;
use crate::compare::words::{p_value, percent, probability};
use crate::{Direction, Threshold};
use stats::{
    Confidence, EffectiveSample, Interval, binomial_test_above, binomial_test_below,
    clustered_test_above, clustered_test_below,
};

/// Whether evidence shows that a threshold is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    /// It shows that the threshold is met.
    Supports,
    /// It shows that the threshold is not met.
    Denies,
    /// It shows neither.
    Neither,
}

/// One piece's standing, with its figures.
pub(super) struct Stand {
    /// The evidence.
    pub id: String,
    pub standing: Standing,
    /// For example `E3 has 88 of 100 (p = 0.004 for meeting it)`.
    pub words: String,
}

impl Stand {
    pub fn of(id: &str, belief: &Belief, threshold: Threshold, level: Confidence) -> Self {
        let (met, missed) = doubts(belief, threshold);
        let standing = if missed <= level.alpha() {
            Standing::Denies
        } else if met <= level.alpha() {
            Standing::Supports
        } else {
            Standing::Neither
        };
        Self {
            id: id.to_owned(),
            standing,
            words: words(id, belief, threshold, met, missed),
        }
    }
}

/// How far the evidence doubts that the threshold is met, and that it is missed: p-values or
/// posterior probabilities of the contrary.
fn doubts(belief: &Belief, threshold: Threshold) -> (f64, f64) {
    let Threshold { direction, value } = threshold;
    let (at_least, at_most) = match belief {
        Belief::Counts { sample, effective } => {
            doubts_of_counts(*effective, effective.trials < sample.trials as f64, value)
        }
        Belief::Distribution { posterior, .. } => (posterior.cdf(value), posterior.sf(value)),
        Belief::Known { bounds, .. } => return doubts_of_known(bounds, threshold),
    };
    match direction {
        Direction::AtLeast => (at_least, at_most),
        Direction::AtMost => (at_most, at_least),
    }
}

/// How bounds stand to a threshold.
pub(super) fn of_bounds(bounds: &Interval, threshold: Threshold) -> Standing {
    match doubts_of_known(bounds, threshold) {
        (_, missed) if missed <= 0.0 => Standing::Denies,
        (met, _) if met <= 0.0 => Standing::Supports,
        _ => Standing::Neither,
    }
}

/// A computed probability meets a threshold, misses it, or its bounds straddle it.
fn doubts_of_known(bounds: &Interval, threshold: Threshold) -> (f64, f64) {
    let Threshold { direction, value } = threshold;
    let (met, missed) = match direction {
        Direction::AtLeast => (
            bounds.low >= value - CERTAINTY,
            bounds.high < value - CERTAINTY,
        ),
        Direction::AtMost => (
            bounds.high <= value + CERTAINTY,
            bounds.low > value + CERTAINTY,
        ),
    };
    let doubt = |shown: bool| if shown { 0.0 } else { 1.0 };
    (doubt(met), doubt(missed))
}

/// p-values of "the rate is below" and "the rate is at least the threshold". At a threshold of 1
/// no count shows the rate to be 1, and one failure shows that it is not.
fn doubts_of_counts(sample: EffectiveSample, is_clustered: bool, threshold: f64) -> (f64, f64) {
    let (test_above, test_below) = match is_clustered {
        true => (
            clustered_test_above as fn(EffectiveSample, f64) -> f64,
            clustered_test_below as fn(EffectiveSample, f64) -> f64,
        ),
        false => (
            binomial_test_above as fn(EffectiveSample, f64) -> f64,
            binomial_test_below as fn(EffectiveSample, f64) -> f64,
        ),
    };
    let below = match threshold >= 1.0 {
        true => 1.0,
        false => test_above(sample, threshold),
    };
    let at_least = match threshold <= 0.0 {
        true => 1.0,
        false => test_below(sample, threshold),
    };
    (below, at_least)
}

/// Whether counts show the rate to be below a threshold, and to be at least as high.
pub(super) fn shown_below_and_above(
    sample: EffectiveSample,
    is_clustered: bool,
    threshold: f64,
    level: Confidence,
) -> (bool, bool) {
    let (below, at_least) = doubts_of_counts(sample, is_clustered, threshold);
    (at_least <= level.alpha(), below <= level.alpha())
}

fn words(id: &str, belief: &Belief, threshold: Threshold, met: f64, missed: f64) -> String {
    match belief {
        Belief::Counts { sample, effective } => {
            let size = if effective.trials < sample.trials as f64 {
                format!(", worth {:.0} independent ones", effective.trials)
            } else {
                String::new()
            };
            let test = match (threshold.value, sample.failures()) {
                (1.0, 0) => "no failure".to_owned(),
                (1.0, 1) => "1 failure".to_owned(),
                (1.0, failures) => format!("{failures} failures"),
                _ if met <= missed => format!("p {} for missing it", p_value(met)),
                _ => format!("p {} for meeting it", p_value(missed)),
            };
            format!(
                "{id} has {} of {}{size} ({test})",
                sample.successes, sample.trials
            )
        }
        Belief::Known { value, .. } => format!("{id} computes {}", percent(*value)),
        Belief::Distribution { value, .. } => {
            let chance = probability(missed);
            format!(
                "{id} computes {} (probability {chance} of meeting it)",
                percent(*value)
            )
        }
    }
}

/// A threshold in words.
pub(super) fn in_words(threshold: Threshold) -> String {
    match threshold.direction {
        Direction::AtLeast if threshold.value >= 1.0 => "it asks for certainty".to_owned(),
        Direction::AtLeast => format!("it asks for at least {}", percent(threshold.value)),
        Direction::AtMost => format!("it asks for at most {}", percent(threshold.value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stats::{BetaPosterior, Sample};

    fn standing(belief: &Belief, direction: Direction, value: f64) -> Standing {
        let threshold = Threshold { direction, value };
        Stand::of("E", belief, threshold, Confidence::P95).standing
    }

    fn counts(successes: u64, trials: u64) -> Belief {
        let sample = Sample { successes, trials };
        Belief::Counts {
            sample,
            effective: sample.into(),
        }
    }

    fn known(low: f64, high: f64) -> Belief {
        Belief::Known {
            value: low,
            bounds: Interval { low, high },
        }
    }

    #[test]
    fn counts_need_the_exact_test_to_speak() {
        use Direction::{AtLeast, AtMost};
        // 0.95^59 = 0.048 and 0.95^58 = 0.051: 59 of 59 is the least that shows 95 %.
        assert_eq!(standing(&counts(59, 59), AtLeast, 0.95), Standing::Supports);
        assert_eq!(standing(&counts(58, 58), AtLeast, 0.95), Standing::Neither);
        assert_eq!(standing(&counts(0, 59), AtMost, 0.05), Standing::Supports);
        assert_eq!(standing(&counts(0, 58), AtMost, 0.05), Standing::Neither);
        assert_eq!(standing(&counts(88, 100), AtLeast, 0.95), Standing::Denies);
        assert_eq!(standing(&counts(12, 100), AtMost, 0.05), Standing::Denies);
    }

    #[test]
    fn certainty_takes_one_failure_to_deny_and_no_trials_to_show() {
        use Direction::{AtLeast, AtMost};
        assert_eq!(
            standing(&counts(1_000_000, 1_000_000), AtLeast, 1.0),
            Standing::Neither
        );
        assert_eq!(
            standing(&counts(999_999, 1_000_000), AtLeast, 1.0),
            Standing::Denies
        );
        assert_eq!(
            standing(&counts(0, 1_000_000), AtMost, 0.0),
            Standing::Neither
        );
        assert_eq!(
            standing(&counts(1, 1_000_000), AtMost, 0.0),
            Standing::Denies
        );
    }

    #[test]
    fn bounds_that_straddle_the_threshold_say_nothing() {
        use Direction::{AtLeast, AtMost};
        assert_eq!(
            standing(&known(0.94, 0.96), AtLeast, 0.95),
            Standing::Neither
        );
        assert_eq!(
            standing(&known(0.96, 0.97), AtLeast, 0.95),
            Standing::Supports
        );
        assert_eq!(
            standing(&known(0.93, 0.94), AtLeast, 0.95),
            Standing::Denies
        );
        assert_eq!(standing(&known(0.96, 0.97), AtMost, 0.95), Standing::Denies);
        assert_eq!(standing(&known(0.0, 0.0), AtMost, 0.0), Standing::Supports);
        assert_eq!(
            standing(&known(1.0 - 1e-12, 1.0), AtLeast, 1.0),
            Standing::Supports
        );
        assert_eq!(
            standing(&known(0.998, 0.998), AtLeast, 1.0),
            Standing::Denies
        );
    }

    #[test]
    fn distributions_speak_by_their_tails() {
        let posterior = BetaPosterior::new(86.7, 13.3).unwrap();
        let belief = Belief::Distribution {
            value: 0.88,
            posterior,
        };
        use Direction::AtLeast;
        assert_eq!(standing(&belief, AtLeast, 0.6), Standing::Supports);
        assert_eq!(standing(&belief, AtLeast, 0.87), Standing::Neither);
        assert_eq!(standing(&belief, AtLeast, 0.95), Standing::Denies);
        let words = Stand::of(
            "E5",
            &belief,
            Threshold {
                direction: AtLeast,
                value: 0.95,
            },
            Confidence::P95,
        )
        .words;
        assert!(
            words.starts_with("E5 computes 88 % (probability"),
            "{words}"
        );
    }
}
