//! The problems of these readers and writers.

use diagnostic::{MOST_SHOWN, Problem, Source};
use std::ops::Range;

/// A file that cannot be understood.
pub(crate) fn bad(message: impl Into<String>) -> Problem {
    Problem::new("bad-requirement-file", message)
}

/// A change that has no place in the format.
pub(crate) fn cannot_write(id: &str, reason: &str) -> Problem {
    let message = format!("`{id}` cannot be written: {reason}");
    Problem::new("cannot-write-requirement", message)
        .remedy("change it in the other tool, and import it again")
}

/// The mistakes of one text, of which the first ones are placed.
pub(crate) struct Mistakes<'s> {
    source: &'s Source,
    found: Vec<Problem>,
    more: usize,
}

impl<'s> Mistakes<'s> {
    pub(crate) fn new(source: &'s Source) -> Self {
        Self {
            source,
            found: Vec::new(),
            more: 0,
        }
    }

    /// Adds one.
    pub(crate) fn add(&mut self, span: Range<usize>, message: impl Into<String>, remedy: &str) {
        if self.found.len() >= MOST_SHOWN {
            self.more += 1;
            return;
        }
        let problem = bad(message).at(self.source, span).remedy(remedy);
        self.found.push(problem);
    }

    /// Fails if there are any.
    pub(crate) fn or<T>(self, value: T) -> Result<T, Problem> {
        match Problem::all(self.found) {
            Some(problem) => Err(problem.and_more(self.more)),
            None => Ok(value),
        }
    }
}
