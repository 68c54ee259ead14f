//! The engine for discrete time: judges a formula sample by sample, in one pass.
//!
//! # What it computes
//! Exactly what [`super::semantics`] defines, for every beginning of a trace: after each step,
//! [`DiscreteJudge::verdict`] is what the definition says of the samples so far with
//! [`Ending::Inconclusive`](super::Ending::Inconclusive), and [`DiscreteJudge::finish`] gives the verdict and the bounds of
//! the robustness for the ending that was asked for. (One exception: where a past operator has an
//! operand that speaks of the future, the verdict may come later: when that operand is determined at
//! all samples before.)
//!
//! # How
//! The formula becomes a list of nodes without negations (`program`). Truth and robustness are
//! computed apart, since they become final in different ways: `truth` says what is determined as
//! soon as it is, in any order; `robustness` goes in order, by folds over sliding windows. Windows
//! are counted in samples or measured by the samples' times (`timeline`).
//!
//! # Cost
//! Amortised O(1) for each sample and operator, independent of the windows. Truth needs memory for the
//! changes of truth that are not decided yet, robustness for the samples within the windows;
//! unbounded operators inside each other need a few numbers (file `robustness/endless.rs`).
//!
//! Measured with `cargo bench -p corroborate-temporal` on one core of a busy cloud machine, in million samples a
//! second, triggers counted and 10,000 samples kept for explanations; from signals that change at
//! random at every sample, to idle ones:
//!
//! | formula, at every sample | truth, one by one | in columns | and robustness, one by one | in columns |
//! |---|---|---|---|---|
//! | `always (p => eventually[0, 50 samples] q)` | 11 to 12 | 19 to 125 | 5.2 to 6.0 | 11 to 25 |
//! | `always (p => eventually[0, 5000 samples] q)` | 9 to 12 | 19 to 125 | 5.2 to 6.0 | 11 to 25 |
//! | the same in seconds, of 50 and 5,000 samples | 9 to 10 | 18 to 125 | 4.2 to 4.7 | 10 to 21 |
//! | `always (p until[0, 1000 samples] q)` | 14 to 17 | 16 to 250 | 6.9 to 8.1 | 11 to 30 |
//!
//! RTAMT 0.4.10 judged the first two on the same machine, with robustness, at 0.10 and 0.009 (offline),
//! 0.03 and 0.0007 (online) million samples a second.
//!
//! A violation is reported by the step of the sample that determines it; half of all steps took less
//! than 0.11 microseconds (0.21 with robustness), 99 % less than 0.8, and the rest was the
//! machine's own scheduling, or the turn of a window of robustness (`until` only). For a window
//! of 5,000 and the busiest signal at most 2,617 runs of truth values were stored, and 5,012
//! robustness values besides; for one of 50, 44 and 58.

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
