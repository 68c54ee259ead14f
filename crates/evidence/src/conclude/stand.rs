//! How one piece of evidence stands to a threshold.

use super::CERTAINTY;
use crate::compare::Belief;
use crate::compare::words::{p_value, percent, probability};
use crate::{Direction, Threshold};
use stats::{Confidence, EffectiveSample, Interval, binomial_test_above, binomial_test_below};

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
        Belief::Counts { effective, .. } => doubts_of_counts(*effective, value),
        Belief::Distribution { posterior, .. } => (posterior.cdf(value), posterior.sf(value)),
        Belief::Known { bounds, .. } => return doubts_of_known(bounds, threshold),
    };
    match direction {
        Direction::AtLeast => (at_least, at_most),
        Direction::AtMost => (at_most, at_least),
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
fn doubts_of_counts(sample: EffectiveSample, threshold: f64) -> (f64, f64) {
    let below = if threshold >= 1.0 {
        1.0
    } else {
        binomial_test_above(sample, threshold)
    };
    let at_least = if threshold <= 0.0 {
        1.0
    } else {
        binomial_test_below(sample, threshold)
    };
    (below, at_least)
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
                _ if met <= missed => format!("p = {} for missing it", p_value(met)),
                _ => format!("p = {} for meeting it", p_value(missed)),
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
