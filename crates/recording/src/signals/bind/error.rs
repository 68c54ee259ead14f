//! Why a signal cannot be had from a recording.

use std::fmt;

/// A signal cannot be read from a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BindError {
    /// The signal.
    pub signal: String,
    /// The line of its entry in the topic map, from 1; 0 if it has none.
    pub line: usize,
    /// What is wrong, and what to do about it.
    pub message: String,
    /// Whether the recording has nothing of this name, which another recording may have.
    pub is_lacking: bool,
}

impl fmt::Display for BindError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "the signal {}", self.signal)?;
        if self.line > 0 {
            write!(out, " (line {} of the topic map)", self.line)?;
        }
        write!(out, " cannot be read: {}", self.message)
    }
}

impl std::error::Error for BindError {}
