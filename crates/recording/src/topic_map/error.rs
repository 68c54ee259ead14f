//! What is wrong with a topic map, and where.

use std::fmt;
use std::ops::Range;

/// A mistake in a topic map, with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TopicMapError {
    /// The file.
    pub file: String,
    /// The place in it, in bytes; empty at 0 if the file could not be read.
    pub span: Range<usize>,
    /// The line of the place, from 1.
    pub line: usize,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
}

impl TopicMapError {
    pub(super) fn new(
        file: &str,
        text: &str,
        span: Range<usize>,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        let before = text.get(..span.start).unwrap_or("");
        TopicMapError {
            file: file.to_owned(),
            line: 1 + before.matches('\n').count(),
            span,
            message: message.into(),
            remedy: remedy.into(),
        }
    }

    pub(super) fn unreadable(file: &str, error: &trace::FileError) -> Self {
        TopicMapError {
            file: file.to_owned(),
            span: 0..0,
            line: 1,
            message: error.source.to_string(),
            remedy: "check the path and that it is a text file".to_owned(),
        }
    }
}

impl fmt::Display for TopicMapError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "{}:{}: {}; {}",
            self.file, self.line, self.message, self.remedy
        )
    }
}

impl std::error::Error for TopicMapError {}
