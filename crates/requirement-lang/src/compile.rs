//! Sentences to formulas, properties, test goals and coverage bins.
//!
//! Everything is built from two parts. The *obligation* is a formula that is to hold at a trigger
//! and looks only into the future; `body` writes it down for each timing and extent. The *frame*
//! says where the triggers are. Monitors may look into the past, so their frame is `always (trigger
//! => obligation)` ([`monitor`]). Model checkers may not, so theirs is an equivalent future formula
//! ([`property`]). That both mean what [`crate::semantics`] defines is tested on all short words.

mod body;
mod build;
pub mod coverage;
mod frame;
pub mod goal;
pub mod monitor;
pub mod property;
pub mod staged;

use std::fmt;

use crate::sentence::{Amount, Duration, Sentence};

/// Why a sentence cannot be put into a form.
#[derive(Clone, Debug, PartialEq)]
pub enum NotExpressible {
    /// Some part of the sentence could not be read.
    Incomplete,
    /// A model counts steps; without their duration, a time means nothing to it.
    NoStepDuration {
        /// The duration in the sentence.
        duration: String,
    },
    /// A time is not a whole number of steps, so that the model cannot tell when it is over.
    NotWholeSteps {
        /// The duration in the sentence.
        duration: String,
        /// The duration of a step in seconds.
        step_secs: f64,
    },
    /// The duration of a step is not a positive number.
    BadStepDuration {
        /// What was given, in seconds.
        step_secs: f64,
    },
    /// A proposition has no meaning in the model.
    Proposition {
        /// Its text.
        text: String,
    },
    /// A monitor of stages cannot say this.
    Staged {
        /// What it cannot say.
        what: String,
    },
    /// With `only`, several stages have no meaning.
    OnlyStages,
    /// A stage follows one that never ends.
    EndlessStage,
}

impl fmt::Display for NotExpressible {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotExpressible::Incomplete => {
                out.write_str("the sentence could not be read; correct the mistakes reported for it")
            }
            NotExpressible::NoStepDuration { duration } => write!(
                out,
                "the model counts steps, so {duration} means nothing to it; declare how long a step is, or a unit of continuous \
                 time (in a study, `[model] step = \"0.1 s\"`)"
            ),
            NotExpressible::NotWholeSteps { duration, step_secs } => write!(
                out,
                "{duration} is not a whole number of steps of {step_secs} s; choose a time that is, or \
                 another duration of a step"
            ),
            NotExpressible::BadStepDuration { step_secs } => write!(
                out,
                "{step_secs} s cannot be the duration of a step; give a positive number of seconds"
            ),
            NotExpressible::Proposition { text } => write!(
                out,
                "`{text}` has no meaning in the model; bind it in the vocabulary, or give it a name there"
            ),
            NotExpressible::Staged { what } => write!(
                out,
                "a monitor of stages cannot express {what}; judge it by its formula"
            ),
            NotExpressible::OnlyStages => out.write_str(
                "several stages have no meaning in a scope with `only`; write one requirement for each",
            ),
            NotExpressible::EndlessStage => out.write_str(
                "a stage follows one that never ends; use `until`, `for` or `within` in the earlier one",
            ),
        }
    }
}

impl std::error::Error for NotExpressible {}

/// Refuses what has no meaning, whether it was parsed or put together by hand.
fn check(sentence: &Sentence) -> Result<(), NotExpressible> {
    if sentence.is_incomplete() {
        return Err(NotExpressible::Incomplete);
    }
    let (_, earlier) = sentence
        .stages
        .split_last()
        .ok_or(NotExpressible::Incomplete)?;
    if sentence.scope.kind.is_only() && !earlier.is_empty() {
        return Err(NotExpressible::OnlyStages);
    }
    if earlier.iter().any(|stage| !stage.timing.completes()) {
        return Err(NotExpressible::EndlessStage);
    }
    Ok(())
}

/// How many whole steps a duration is.
fn whole_steps(duration: &Duration, step_secs: Option<f64>) -> Result<u32, NotExpressible> {
    let secs = match duration.amount {
        Amount::Steps(count) => return Ok(count),
        Amount::Missing => return Err(NotExpressible::Incomplete),
        Amount::Secs(secs) => secs,
    };
    let text = duration.text.clone();
    let step_secs = step_secs.ok_or(NotExpressible::NoStepDuration {
        duration: text.clone(),
    })?;
    if !(step_secs.is_finite() && step_secs > 0.0) {
        return Err(NotExpressible::BadStepDuration { step_secs });
    }
    // Both are decimal numbers that binary fractions only approximate: 0.3 / 0.1 is not 3.
    let steps = (secs / step_secs).round();
    let close = (steps * step_secs - secs).abs() <= 1e-9 * secs.max(step_secs);
    if close && steps <= f64::from(u32::MAX) {
        Ok(steps as u32)
    } else {
        Err(NotExpressible::NotWholeSteps {
            duration: text,
            step_secs,
        })
    }
}
