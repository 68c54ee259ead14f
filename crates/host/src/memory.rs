//! How much memory work may take, as a face measures it: no library looks at the process.

use diagnostic::Problem;
use std::fmt;

/// A budget of memory that somebody watches. Work asks it now and then, and ends with what it has.
pub trait MemoryBudget: fmt::Debug + Send + Sync {
    /// Whether the work must stop with what it has reached.
    fn must_stop(&self) -> bool;

    /// Whether the work must end at once, without what it has reached.
    fn must_give_up(&self) -> bool;

    /// That physics is about to be simulated: each episode takes and gives back blocks of a few hundred kilobytes. A face that
    /// owns the process may set its allocator for that; results do not depend on it.
    fn physics_begins(&self);

    /// The problem of work that was ended by it; `doing` says while what, such as ` while states were explored`, or nothing.
    fn problem(&self, doing: &str) -> Problem;
}

/// No budget.
#[derive(Clone, Copy, Debug)]
pub struct Unlimited;

impl MemoryBudget for Unlimited {
    fn must_stop(&self) -> bool {
        false
    }

    fn must_give_up(&self) -> bool {
        false
    }

    fn physics_begins(&self) {}

    fn problem(&self, doing: &str) -> Problem {
        Problem::undecided(
            "memory-limit",
            format!("the work needs more memory than there is{doing}"),
        )
    }
}
