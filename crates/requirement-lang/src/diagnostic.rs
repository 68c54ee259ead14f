//! Places in a requirement's text, and what is wrong there.

use std::fmt;

/// A half-open range of byte offsets in the text that was parsed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct Span {
    /// Offset of the first byte.
    pub start: usize,
    /// Offset just behind the last byte.
    pub end: usize,
}

impl Span {
    /// The range `start..end`.
    #[must_use]
    pub const fn new(start: usize, end: usize) -> Self {
        Self { start, end }
    }

    /// The part of `text` that this span covers; empty when the span belongs to another text.
    #[must_use]
    pub fn of(self, text: &str) -> &str {
        text.get(self.start..self.end).unwrap_or("")
    }
}

/// How grave a diagnostic is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Severity {
    /// The sentence has no meaning; nothing can be compiled from it.
    Error,
    /// The sentence has a meaning, but perhaps not the intended one.
    Warning,
}

/// One thing that is wrong (or suspicious) in a text, where, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Stable identifier of this kind of mistake, such as `unknown-name`.
    pub code: &'static str,
    /// Error or warning.
    pub severity: Severity,
    /// One sentence that says what is wrong.
    pub message: String,
    /// The place of the mistake.
    pub span: Span,
    /// What the author can do about it.
    pub remedy: Option<String>,
}

impl Diagnostic {
    /// An error with a remedy.
    pub fn error(
        code: &'static str,
        span: Span,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            code,
            severity: Severity::Error,
            message: message.into(),
            span,
            remedy: Some(remedy.into()),
        }
    }

    /// A warning with a remedy.
    pub fn warning(
        code: &'static str,
        span: Span,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            severity: Severity::Warning,
            ..Self::error(code, span, message, remedy)
        }
    }

    /// Whether this is an error.
    #[must_use]
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}", self.message)?;
        match &self.remedy {
            Some(remedy) => write!(out, " {remedy}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for Diagnostic {}

/// A tree together with everything that was found wrong while reading it.
///
/// Parsing never fails: the tree holds what could be understood, and `diagnostics` all mistakes.
#[derive(Clone, Debug, PartialEq)]
pub struct Parsed<T> {
    /// What could be understood.
    pub tree: T,
    /// All mistakes, in the order of their places.
    pub diagnostics: Vec<Diagnostic>,
}

impl<T> Parsed<T> {
    /// Whether some diagnostic is an error.
    #[must_use]
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(Diagnostic::is_error)
    }

    /// The tree if there is no error.
    ///
    /// # Errors
    /// All diagnostics, if one of them is an error.
    pub fn into_result(self) -> Result<T, Vec<Diagnostic>> {
        if self.has_errors() {
            Err(self.diagnostics)
        } else {
            Ok(self.tree)
        }
    }
}
