//! How a formula is to be judged, and why it cannot be.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ast::{Formula, MAX_BOUND};

/// What time is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, Serialize, JsonSchema, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeModel {
    /// The samples are all there is: operators speak of samples (pointwise semantics).
    #[default]
    Discrete,
    /// Signals have a value at every time: from each sample on its value holds until the next
    /// one, and operators speak of all times (continuous semantics).
    Dense,
}

/// What signals are between samples, in dense time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// They keep their values.
    #[default]
    Hold,
    /// The robustness of an atom goes in a straight line (which it does if it is a linear
    /// combination of signals that do); atoms that are only true or false keep their values.
    Linear,
}

/// What is said at the end of a trace about times that were not seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, Serialize, JsonSchema, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// Nothing: a verdict is given only if no continuation can change it.
    #[default]
    Inconclusive,
    /// The benefit of the doubt: violated only if no continuation can repair it.
    Weak,
    /// No benefit: satisfied only if no continuation can spoil it.
    Strong,
    /// The trace is all there is: no time comes after it (LTLf, and MTL likewise).
    Finite,
    /// As [`Ending::Finite`] of all windows that were seen whole. Where none was, since the trace is shorter than the
    /// formula's [`Horizon`](super::Horizon) from its first trigger on, what bounded windows do not see is open; otherwise
    /// those that the end cuts are left out.
    LongEnough,
}

/// How a formula is to be judged.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Settings {
    /// What time is.
    pub time: TimeModel,
    /// What atoms are between samples, in dense time.
    pub interpolation: Interpolation,
    /// What is said about times that were not seen.
    pub ending: Ending,
    /// Whether the robustness is computed, too.
    pub robustness: bool,
    /// What counts as covering the requirement, if not the [`Formula::trigger`] of the formula.
    pub trigger: Option<Formula>,
    /// Whether samples may be missing within the trace
    /// ([`FormulaJudge::lose`](super::FormulaJudge::lose)).
    pub losses: bool,
    /// How many samples are kept, at most, to explain a violation by; with 0 none is explained.
    pub explain_samples: usize,
}

impl Settings {
    /// Discrete time with this ending, no robustness, and violations explained from up to 10,000
    /// samples.
    #[must_use]
    pub fn discrete(ending: Ending) -> Self {
        Settings {
            ending,
            explain_samples: 10_000,
            ..Settings::default()
        }
    }

    /// Dense time with this ending, no robustness, and violations explained from up to 10,000
    /// samples.
    #[must_use]
    pub fn dense(ending: Ending) -> Self {
        Settings {
            time: TimeModel::Dense,
            ..Settings::discrete(ending)
        }
    }

    /// The same, with robustness.
    #[must_use]
    pub fn with_robustness(self) -> Self {
        Settings {
            robustness: true,
            ..self
        }
    }
}

/// Why a formula cannot be judged as asked.
#[derive(Debug, Clone, PartialEq)]
pub enum CompileError {
    /// A bound is not a number from 0 to [`MAX_BOUND`].
    BadBound {
        /// The bound.
        value: f64,
    },
    /// The ends of an interval are the wrong way round.
    EmptyInterval {
        /// The interval as text.
        interval: String,
    },
    /// One end is a time, the other a number of samples.
    MixedUnits {
        /// The interval as text.
        interval: String,
    },
    /// Samples are spoken of, but time is dense.
    SamplesInDenseTime {
        /// What speaks of samples.
        what: String,
    },
    /// A number of samples is not whole.
    FractionOfSample {
        /// The number.
        value: f64,
    },
    /// The formula is nested too deeply.
    TooDeep,
}

impl fmt::Display for CompileError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CompileError::BadBound { value } => write!(
                out,
                "an interval cannot begin or end at {value}; give a number from 0 to {MAX_BOUND}"
            ),
            CompileError::EmptyInterval { interval } => write!(
                out,
                "the interval {interval} ends before it begins; write the lower end first"
            ),
            CompileError::MixedUnits { interval } => write!(
                out,
                "the interval {interval} begins in one unit and ends in another; give both ends \
                 in seconds or both in samples"
            ),
            CompileError::SamplesInDenseTime { what } => write!(
                out,
                "{what} counts samples, which dense time does not have; use seconds, or \
                 discrete time"
            ),
            CompileError::FractionOfSample { value } => write!(
                out,
                "{value} is not a number of samples; use a whole number, or write the unit of \
                 time behind it, as in \"{value} s\""
            ),
            CompileError::TooDeep => out
                .write_str("the formula is nested too deeply; name parts of it in the vocabulary"),
        }
    }
}

impl std::error::Error for CompileError {}
