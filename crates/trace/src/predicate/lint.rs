//! What is allowed in a predicate but should be looked at.

use std::fmt;
use std::ops::Range;

/// Something in a text that is allowed, but of which the meaning rests on an assumption.
#[derive(Debug, Clone, PartialEq)]
pub struct PredicateLint {
    /// The text in which the place lies.
    pub text: String,
    /// The name of the vocabulary's entry whose text it is, if it is one.
    pub entry: Option<String>,
    /// The place in `text`: byte offsets, half open.
    pub span: Range<usize>,
    /// What should be looked at.
    pub kind: PredicateLintKind,
}

/// What should be looked at.
#[derive(Debug, Clone, PartialEq)]
pub enum PredicateLintKind {
    /// A number without a unit was taken in the unit of the signals.
    BareNumber {
        /// That unit.
        unit: String,
    },
    /// A signal without a unit was taken to be in the unit of the others.
    UndeclaredUnit {
        /// The signal.
        signal: String,
        /// That unit.
        unit: String,
    },
}

impl fmt::Display for PredicateLint {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "in \"{}\"", self.text)?;
        if let Some(entry) = &self.entry {
            write!(out, " (the definition of {entry})")?;
        }
        let before = self.text.get(..self.span.start).unwrap_or("");
        write!(
            out,
            ", column {}: {}",
            before.chars().count() + 1,
            self.kind
        )
    }
}

impl fmt::Display for PredicateLintKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PredicateLintKind::BareNumber { unit } => write!(
                out,
                "this number has no unit and is taken in {unit}, the signal's; write the unit, so \
                 that it stays right if the signal's changes"
            ),
            PredicateLintKind::UndeclaredUnit { signal, unit } => write!(
                out,
                "the unit of {signal} is not declared and taken to be {unit}; declare it"
            ),
        }
    }
}
