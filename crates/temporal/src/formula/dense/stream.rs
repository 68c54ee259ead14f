//! Functions of time as runs: stretches of places with one value.

use std::collections::VecDeque;

/// A value up to, and not including, a place; it begins where the run before ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Run {
    pub(super) end: i64,
    pub(super) value: f64,
}

/// What an operator has found and its user has not taken yet.
#[derive(Debug, Clone, Default)]
pub(super) struct Stream {
    runs: VecDeque<Run>,
    /// The first place that is not known.
    known: i64,
}

impl Stream {
    pub(super) fn known(&self) -> i64 {
        self.known
    }

    /// Adds a value up to `end`.
    pub(super) fn push(&mut self, end: i64, value: f64) {
        if end <= self.known {
            return;
        }
        self.known = end;
        match self.runs.back_mut() {
            Some(last) if last.value == value => last.end = end,
            _ => self.runs.push_back(Run { end, value }),
        }
    }

    /// Forgets what is before `place`.
    pub(super) fn forget_before(&mut self, place: i64) {
        while self.runs.front().is_some_and(|run| run.end <= place) {
            self.runs.pop_front();
        }
    }

    /// The first run that is not forgotten.
    pub(super) fn first(&self) -> Option<Run> {
        self.runs.front().copied()
    }

    /// Number of runs kept.
    pub(super) fn len(&self) -> usize {
        self.runs.len()
    }
}
