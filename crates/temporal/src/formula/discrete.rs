//! The engine for discrete time: judges a formula sample by sample, in one pass.
//!
//! # What it computes
//! Exactly what [`super::semantics`] defines, for every beginning of a trace: after each step,
//! [`DiscreteJudge::verdict`] is what the definition says of the samples so far with
//! [`Ending::Inconclusive`], and [`DiscreteJudge::finish`] gives the verdict and the bounds of
//! the robustness for the ending that was asked for. (One exception: where a past operator has an
//! operand that speaks of the future, a verdict may come later, but not after that future is seen.)
//!
//! # How
//! The formula becomes a list of nodes without negations ([`program`]). Truth and robustness are
//! computed apart, since they become final in different ways: [`truth`] says what is determined as
//! soon as it is, in any order; [`robustness`] goes in order, by folds over sliding windows. Windows
//! are counted in samples or measured by the samples' times ([`timeline`]).
//!
//! # Cost
//! Amortised O(1) for each sample and operator, independent of the windows; nothing is allocated in a
//! step once the queues have grown to the windows' size. Truth needs memory for the changes of truth
//! within the windows, robustness for the samples within them.

mod judge;
mod program;
mod robustness;
mod runs;
mod timeline;
mod truth;

pub use judge::{DiscreteJudge, DiscreteMonitor};

/// A truth value of Kleene's logic, ordered so that conjunction is the minimum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Truth {
    /// False.
    False,
    /// Either.
    Unknown,
    /// True.
    True,
}

impl Truth {
    #[inline]
    fn negated(self) -> Self {
        match self {
            Truth::False => Truth::True,
            Truth::Unknown => Truth::Unknown,
            Truth::True => Truth::False,
        }
    }

    #[inline]
    fn negated_if(self, negate: bool) -> Self {
        if negate { self.negated() } else { self }
    }

    /// That of an atom with this robustness; a robustness of 0 is compatible with both.
    #[inline]
    fn of_robustness(value: f64) -> Self {
        if value > 0.0 {
            Truth::True
        } else if value < 0.0 {
            Truth::False
        } else {
            Truth::Unknown
        }
    }

    #[inline]
    fn of(value: Option<bool>) -> Self {
        match value {
            Some(true) => Truth::True,
            Some(false) => Truth::False,
            None => Truth::Unknown,
        }
    }
}
