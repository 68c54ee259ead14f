//! Places in a text, and what is wrong there.

use std::fmt;
use std::ops::Deref;

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
    pub fn new(start: usize, end: usize) -> Self {
        Self { start, end }
    }

    /// The smallest range that covers both.
    pub fn to(self, other: Self) -> Self {
        Self::new(self.start.min(other.start), self.end.max(other.end))
    }

    /// The part of `text` that this span covers; empty when the span belongs to another text.
    pub fn of(self, text: &str) -> &str {
        text.get(self.start..self.end).unwrap_or("")
    }
}

/// One-based line and column (in characters) of a byte offset.
///
/// ```
/// assert_eq!(prism_lang::line_and_column("dtmc\nmodule", 5), (2, 1));
/// ```
pub fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let bytes = &text.as_bytes()[..offset.min(text.len())];
    let line_start = bytes.iter().rposition(|&b| b == b'\n').map_or(0, |p| p + 1);
    let line = bytes.iter().filter(|&&b| b == b'\n').count() + 1;
    let is_first_byte = |b: &&u8| (**b & 0xC0) != 0x80;
    (
        line,
        bytes[line_start..].iter().filter(is_first_byte).count() + 1,
    )
}

/// How grave a diagnostic is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Severity {
    /// The text has no meaning; nothing can be computed from it.
    Error,
    /// The text has a meaning, but perhaps not the intended one.
    Warning,
}

/// One thing that is wrong (or suspicious) in a text, where, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Diagnostic {
    /// Stable identifier of this kind of mistake, such as `unknown-name`.
    pub code: &'static str,
    /// Error or warning.
    pub severity: Severity,
    /// One sentence that says what is wrong.
    pub message: String,
    /// The place of the mistake.
    pub span: Span,
    /// Other places that matter, each with a short note.
    pub related: Vec<(Span, String)>,
    /// What the author can do about it.
    pub remedy: Option<String>,
}

impl Diagnostic {
    /// An error without related places or remedy.
    pub fn error(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Self {
            code,
            severity: Severity::Error,
            message: message.into(),
            span,
            related: Vec::new(),
            remedy: None,
        }
    }

    /// A warning without related places or remedy.
    pub fn warning(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Warning,
            ..Self::error(code, span, message)
        }
    }

    /// The same diagnostic with a remedy.
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = Some(remedy.into());
        self
    }

    /// The same diagnostic with one more related place.
    pub fn related(mut self, span: Span, note: impl Into<String>) -> Self {
        self.related.push((span, note.into()));
        self
    }

    /// Whether this is an error.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.message)?;
        match &self.remedy {
            Some(remedy) => write!(f, " {remedy}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for Diagnostic {}

/// All that is wrong with a text, in the order of the places: what reading gives instead of a result. It is a slice of
/// [`Diagnostic`]s, and an error by itself.
///
/// ```
/// use prism_lang::{Constants, parse_model, resolve};
/// let text = "dtmc\nmodule m x : [0..1];\n  [] y=0 -> true; endmodule";
/// let mistakes = resolve(&parse_model(text).tree, &Constants::new()).unwrap_err();
/// assert_eq!(mistakes[0].span.of(text), "y");
/// assert!(mistakes.in_text(text).starts_with("3:6: "));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostics(Vec<Diagnostic>);

impl Diagnostics {
    /// A line for each, with the line and column (from 1) of its place in the text that was read.
    #[must_use]
    pub fn in_text(&self, text: &str) -> String {
        let lines = self.iter().map(|diagnostic| {
            let (line, column) = line_and_column(text, diagnostic.span.start);
            format!("{line}:{column}: {diagnostic}\n")
        });
        lines.collect()
    }
}

impl From<Vec<Diagnostic>> for Diagnostics {
    fn from(diagnostics: Vec<Diagnostic>) -> Self {
        Self(diagnostics)
    }
}

impl Deref for Diagnostics {
    type Target = [Diagnostic];

    fn deref(&self) -> &[Diagnostic] {
        &self.0
    }
}

impl IntoIterator for Diagnostics {
    type Item = Diagnostic;
    type IntoIter = std::vec::IntoIter<Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl<'a> IntoIterator for &'a Diagnostics {
    type Item = &'a Diagnostic;
    type IntoIter = std::slice::Iter<'a, Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, diagnostic) in self.iter().enumerate() {
            let between = if place == 0 { "" } else { "\n" };
            write!(f, "{between}{diagnostic}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostics {}

/// A tree together with everything that was found wrong while reading it.
///
/// Parsing never fails: the tree holds what could be understood, and `diagnostics` all mistakes.
#[derive(Clone, Debug)]
pub struct Parsed<T> {
    /// What could be understood.
    pub tree: T,
    /// All mistakes, in the order of their places.
    pub diagnostics: Vec<Diagnostic>,
}

impl<T> Parsed<T> {
    /// Whether some diagnostic is an error.
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(Diagnostic::is_error)
    }

    /// The tree if there is no error, else all diagnostics.
    ///
    /// # Errors
    /// All diagnostics, if one of them is an error.
    pub fn into_result(self) -> Result<T, Diagnostics> {
        if self.has_errors() {
            Err(self.diagnostics.into())
        } else {
            Ok(self.tree)
        }
    }
}
