//! What can be wrong with a predicate, and where.

use std::fmt;
use std::ops::Range;

use crate::units::UnitErrorKind;

/// Something wrong in the text of a predicate, a quantity or an entry of a vocabulary.
#[derive(Debug, Clone, PartialEq)]
pub struct PredicateError {
    /// The text in which the place lies.
    pub text: String,
    /// The name of the vocabulary's entry whose text it is, if it is one.
    pub entry: Option<String>,
    /// The place in `text`: byte offsets, half open.
    pub span: Range<usize>,
    /// What is wrong.
    pub kind: PredicateErrorKind,
}

/// What is wrong with a predicate.
#[derive(Debug, Clone, PartialEq)]
pub enum PredicateErrorKind {
    /// The text does not continue as it may.
    Unexpected {
        /// What stands there.
        found: String,
        /// What may stand there.
        expected: &'static str,
    },
    /// A quoted name has no closing quote.
    Unterminated,
    /// Comparisons are chained, as in `a < b < c`.
    ChainedComparison,
    /// The text is nested, or grows by its names, beyond what can be evaluated.
    TooLarge,
    /// There is no such signal in the trace.
    UnknownSignal {
        /// The signal, `/topic.field`.
        name: String,
        /// A signal of the trace with a similar name.
        similar: Option<String>,
    },
    /// There is no such entry in the vocabulary.
    UnknownName {
        /// The name.
        name: String,
        /// An entry with a similar name.
        similar: Option<String>,
    },
    /// There is no such function.
    UnknownFunction {
        /// The name.
        name: String,
        /// A function with a similar name.
        similar: Option<String>,
    },
    /// A function has the wrong number of arguments.
    ArgumentCount {
        /// The function.
        function: &'static str,
        /// How it is called.
        usage: &'static str,
    },
    /// A function needs values of more than one moment.
    NotInstantaneous {
        /// The name.
        name: String,
    },
    /// Something is wrong with a unit.
    Unit(UnitErrorKind),
    /// Two amounts of different dimensions are compared, added or the like.
    Dimensions {
        /// What the one is, for example `a length in m`.
        left: String,
        /// What the other is.
        right: String,
    },
    /// A number with a unit meets a signal whose unit is not declared, so that it cannot be
    /// converted.
    UndeclaredUnit {
        /// The signal.
        signal: String,
        /// The unit of the number.
        unit: String,
    },
    /// A number or signal without a unit meets signals of several units, so that it has none.
    AmbiguousNumber {
        /// The units of the signals.
        units: Vec<String>,
    },
    /// Components in different coordinate frames are compared, added or the like.
    Frames(Box<FrameMismatch>),
    /// Something is used as an angle but is not known to be one.
    NoAngle {
        /// What it is.
        found: String,
    },
    /// An enumeration has no value of that name.
    UnknownValue {
        /// The value.
        value: String,
        /// The names that the enumeration has.
        known: Vec<String>,
    },
    /// Something is of another type than it must be here.
    Type {
        /// What it is.
        found: String,
        /// What it must be.
        expected: &'static str,
    },
    /// Two things are compared that cannot be.
    Incomparable {
        /// What stands on the left.
        left: String,
        /// What stands on the right.
        right: String,
    },
    /// An entry of the vocabulary refers to itself.
    Cycle {
        /// The names along the cycle, with the first one repeated at the end.
        names: Vec<String>,
    },
    /// An entry of the vocabulary has a name that cannot be referred to.
    BadName {
        /// The name.
        name: String,
    },
    /// Two entries of the vocabulary have one name.
    DuplicateName {
        /// The name.
        name: String,
    },
}

/// Two signals that meet, but are expressed in different coordinate frames.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameMismatch {
    /// A signal.
    pub left: String,
    /// Its frame.
    pub left_frame: String,
    /// Another signal.
    pub right: String,
    /// Its frame.
    pub right_frame: String,
}

impl PredicateError {
    /// The column at which the place begins, in letters from 1.
    #[must_use]
    pub fn column(&self) -> usize {
        self.text
            .get(..self.span.start)
            .map_or(1, |before| before.chars().count() + 1)
    }
}

impl fmt::Display for PredicateError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "in \"{}\"", self.text)?;
        if let Some(entry) = &self.entry {
            write!(out, " (the definition of {entry})")?;
        }
        write!(out, ", column {}: {}", self.column(), self.kind)
    }
}

impl std::error::Error for PredicateError {}

impl fmt::Display for PredicateErrorKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        use PredicateErrorKind as Kind;
        match self {
            Kind::Unexpected { found, expected } => {
                write!(out, "found {found}, where {expected} must stand")
            }
            Kind::Unterminated => out.write_str("this quote is not closed; add the closing quote"),
            Kind::ChainedComparison => out.write_str(
                "comparisons cannot be chained; instead of a < b < c write a < b & b < c",
            ),
            Kind::TooLarge => out.write_str(
                "this is nested too deeply, or grows too large with the entries it refers to; \
                 split it into simpler predicates",
            ),
            Kind::UnknownSignal { name, similar } => {
                write!(out, "the trace has no signal {name}")?;
                suggest(
                    out,
                    similar.as_deref(),
                    "list its signals to see their names",
                )
            }
            Kind::UnknownName { name, similar } => {
                write!(out, "nothing is defined with the name {name}")?;
                suggest(
                    out,
                    similar.as_deref(),
                    "define it, or write signals as /topic.field",
                )
            }
            Kind::UnknownFunction { name, similar } => {
                write!(out, "there is no function {name}")?;
                suggest(
                    out,
                    similar.as_deref(),
                    "there are abs, min, max, norm, distance, angle_difference and angle_between",
                )
            }
            Kind::ArgumentCount { function, usage } => {
                write!(out, "{function} has the wrong arguments; write {usage}")
            }
            Kind::NotInstantaneous { name } => write!(
                out,
                "there is no function {name}, since a predicate sees the values of one moment \
                 only; record the rate or the like as a signal of its own, or use the operators of \
                 temporal logic around predicates"
            ),
            Kind::Unit(kind) => kind.fmt(out),
            Kind::Dimensions { left, right } => write!(
                out,
                "{left} does not go together with {right}; correct one of them, or give a number \
                 the unit that makes them alike"
            ),
            Kind::UndeclaredUnit { signal, unit } => write!(
                out,
                "the unit of {signal} is not declared, so a number in {unit} cannot be converted \
                 to it; declare the signal's unit, or write the number without one"
            ),
            Kind::AmbiguousNumber { units } => write!(
                out,
                "what has no unit is taken in that of the other signals, but there are several \
                 here ({}); write the number's unit, or declare the signal's",
                units.join(", ")
            ),
            Kind::Frames(mismatch) => write!(
                out,
                "{} is expressed in the frame {} and {} in {}; transform one of them into the \
                 frame of the other first",
                mismatch.left, mismatch.left_frame, mismatch.right, mismatch.right_frame
            ),
            Kind::NoAngle { found } => write!(
                out,
                "this is {found}, where an angle must stand; declare the signal's unit as rad or \
                 deg"
            ),
            Kind::UnknownValue { value, known } => {
                write!(
                    out,
                    "there is no value '{value}' here; there are {}",
                    quoted(known)
                )
            }
            Kind::Type { found, expected } => {
                write!(out, "this is {found}, where {expected} must stand")
            }
            Kind::Incomparable { left, right } => write!(
                out,
                "{left} cannot be compared so with {right}; compare numbers with numbers, and \
                 truth values or enumeration values only with = or != and their own kind"
            ),
            Kind::Cycle { names } => write!(
                out,
                "this definition refers to itself ({}); remove one of the references",
                names.join(" -> ")
            ),
            Kind::BadName { name } => write!(
                out,
                "\"{name}\" cannot be a name here; use letters, digits and underscores, not \
                 beginning with a digit, and no word of the language"
            ),
            Kind::DuplicateName { name } => {
                write!(
                    out,
                    "{name} is defined twice; rename or remove one of the definitions"
                )
            }
        }
    }
}

fn suggest(out: &mut fmt::Formatter<'_>, similar: Option<&str>, otherwise: &str) -> fmt::Result {
    match similar {
        Some(similar) => write!(out, "; did you mean {similar}?"),
        None => write!(out, "; {otherwise}"),
    }
}

fn quoted(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("'{name}'")).collect();
    quoted.join(", ")
}
