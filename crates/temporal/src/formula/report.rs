//! What judging a formula on a trace gives.

use std::fmt;

use super::ast::AtomId;
use super::early_end::Horizon;
use crate::monitor::Verdict;

/// The least and the greatest value that a robustness can have, given what is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobustnessBounds {
    /// Not less than this; may be minus infinity.
    pub low: f64,
    /// Not more than this; may be infinity.
    pub high: f64,
}

impl RobustnessBounds {
    /// Nothing is known.
    pub const UNKNOWN: Self = RobustnessBounds {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
    };

    /// The robustness itself, if it is known.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        (self.low == self.high).then_some(self.low)
    }
}

/// The outcome of a formula on one trace.
#[derive(Debug, Clone, PartialEq)]
pub struct FormulaReport {
    /// The conclusion. [`Verdict::NotCovered`] if there is a trigger, it was never seen to trigger
    /// and the formula is not violated; but [`Verdict::Inconclusive`] if that is what is known of
    /// the formula and the trigger was unknown somewhere, so that it may have been missed.
    pub verdict: Verdict,
    /// The robustness at the first sample, if it was asked for and there was a sample.
    pub robustness: Option<RobustnessBounds>,
    /// How often the trigger was seen to become true (0 if the formula has none): it is true, and
    /// known to have been false just before, or this is the first sample.
    pub triggered: u64,
    /// Whether there is a trigger to count.
    pub has_trigger: bool,
    /// Number of samples.
    pub samples: u64,
    /// Time of the sample that determined the verdict, in seconds of the trace's clock; `None` if
    /// only its end did, or nothing.
    pub decided_at_secs: Option<f64>,
    /// The horizon of the formula, where the verdict is open only because the trace ends before it, counted from the first
    /// trigger ([`Ending::LongEnough`](super::Ending::LongEnough)).
    pub ends_before: Option<Horizon>,
    /// The horizon of the formula, where windows are pending at the end of the trace that were left out, as others were seen
    /// whole ([`Ending::LongEnough`](super::Ending::LongEnough)): [`Ending::Finite`](super::Ending::Finite) would say "violated".
    pub left_out: Option<Horizon>,
    /// Why the formula is violated, if it is, and what shows it was kept.
    pub explanation: Option<Explanation>,
}

/// A part of a trace that by itself makes a formula false at the first sample: it stays violated
/// whatever the atoms are elsewhere.
#[derive(Debug, Clone, PartialEq)]
pub struct Explanation {
    /// Where the part begins, in seconds of the trace's clock.
    pub from_secs: f64,
    /// Where it ends.
    pub to_secs: f64,
    /// The atoms responsible, by atom and time.
    pub atoms: Vec<Responsible>,
}

/// One atom whose truth over a stretch of time is part of an [`Explanation`].
#[derive(Debug, Clone, PartialEq)]
pub struct Responsible {
    /// The atom.
    pub atom: AtomId,
    /// First time, in seconds of the trace's clock: that of a sample in discrete time.
    pub from_secs: f64,
    /// Last time.
    pub to_secs: f64,
    /// What it was there.
    pub value: bool,
}

/// How far judging has come after a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// The verdict, once no continuation can change it.
    pub verdict: Option<Verdict>,
}

/// A sample that cannot be taken.
#[derive(Debug, Clone, PartialEq)]
pub enum StepError {
    /// Its time is not finite, or not after the last one.
    Time {
        /// Time of the sample before, in seconds; minus infinity if there was none.
        last_secs: f64,
        /// The time that was given, in seconds.
        time_secs: f64,
    },
    /// It does not have one value for each atom.
    AtomCount {
        /// Number of atoms of the formula.
        expected: usize,
        /// Number of values given.
        found: usize,
    },
}

impl fmt::Display for StepError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StepError::Time {
                last_secs,
                time_secs,
            } => write!(
                out,
                "a formula was given a sample at {time_secs} s after one at {last_secs} s; give it \
                 one sample for each time, in order"
            ),
            StepError::AtomCount { expected, found } => write!(
                out,
                "a formula over {expected} atoms was given {found} values; give it one for each"
            ),
        }
    }
}

impl std::error::Error for StepError {}
