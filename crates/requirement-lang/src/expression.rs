//! Boolean expressions over opaque atoms.
//!
//! ```text
//! expression ::= expression (<=> | xor) expression | expression => expression
//!              | expression or expression | expression and expression | not expression
//!              | ( expression ) | true | false | atom
//! ```
//!
//! in order of falling precedence from the last to the first; `=>` binds to the right. An *atom* is
//! everything between connectives: a name (`grasped`), a comparison (`/robot.hand_speed < 250 mm/s`)
//! or a phrase of several words, which is the name with underscores between them (`human is ready` is
//! `human_is_ready`). Its meaning is given by the study's vocabulary, not here.

use std::fmt;

use crate::diagnostic::Span;

/// A proposition whose text is given a meaning elsewhere.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Atom {
    /// Its text with single spaces; equal texts are equal propositions.
    pub text: String,
    /// Where it stands.
    pub span: Span,
}

impl Atom {
    /// Whether the text is a plain name: a letter or underscore, then letters, digits, underscores.
    #[must_use]
    pub fn is_name(&self) -> bool {
        is_name(&self.text)
    }
}

/// Whether `text` is a plain name.
pub(crate) fn is_name(text: &str) -> bool {
    let first = |letter: char| letter.is_alphabetic() || letter == '_';
    text.starts_with(first)
        && (text.chars()).all(|letter| letter.is_alphanumeric() || letter == '_')
}

/// A boolean expression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Expression {
    /// Always true.
    True,
    /// Always false.
    False,
    /// A proposition.
    Atom(Atom),
    /// Negation.
    Not(Box<Expression>),
    /// Conjunction of two or more.
    And(Vec<Expression>),
    /// Disjunction of two or more.
    Or(Vec<Expression>),
    /// Implication.
    Implies(Box<Expression>, Box<Expression>),
    /// Equivalence.
    Iff(Box<Expression>, Box<Expression>),
    /// Something that could not be read; a diagnostic says why. It has no meaning.
    Missing,
}

impl Expression {
    /// The negation; of a negation, what is negated.
    #[must_use]
    pub fn negation(self) -> Self {
        match self {
            Expression::Not(inner) => *inner,
            other => Expression::Not(Box::new(other)),
        }
    }

    /// The operands.
    pub fn operands(&self) -> impl Iterator<Item = &Expression> {
        let (several, pair): (&[Expression], [Option<&Expression>; 2]) = match self {
            Expression::Not(inner) => (&[], [Some(inner), None]),
            Expression::And(all) | Expression::Or(all) => (all, [None, None]),
            Expression::Implies(left, right) | Expression::Iff(left, right) => {
                (&[], [Some(left), Some(right)])
            }
            _ => (&[], [None, None]),
        };
        several.iter().chain(pair.into_iter().flatten())
    }

    /// The atoms from left to right, with repetitions.
    #[must_use]
    pub fn atoms(&self) -> Vec<&Atom> {
        match self {
            Expression::Atom(atom) => vec![atom],
            other => other.operands().flat_map(Expression::atoms).collect(),
        }
    }

    /// Whether some part could not be read.
    #[must_use]
    pub fn is_incomplete(&self) -> bool {
        *self == Expression::Missing || self.operands().any(Expression::is_incomplete)
    }

    /// Its truth where `truth` gives that of the atoms by their text. A missing part is false.
    #[must_use]
    pub fn eval(&self, truth: &dyn Fn(&str) -> bool) -> bool {
        match self {
            Expression::True => true,
            Expression::False | Expression::Missing => false,
            Expression::Atom(atom) => truth(&atom.text),
            Expression::Not(inner) => !inner.eval(truth),
            Expression::And(all) => all.iter().all(|one| one.eval(truth)),
            Expression::Or(all) => all.iter().any(|one| one.eval(truth)),
            Expression::Implies(left, right) => !left.eval(truth) || right.eval(truth),
            Expression::Iff(left, right) => left.eval(truth) == right.eval(truth),
        }
    }

    /// How strongly it binds when printed; atoms bind most.
    fn binding(&self) -> u8 {
        match self {
            Expression::Iff(..) => 0,
            Expression::Implies(..) => 1,
            Expression::Or(_) => 2,
            Expression::And(_) => 3,
            Expression::Not(_) => 4,
            _ => 5,
        }
    }
}

/// Canonical text, which parses to the same expression.
impl fmt::Display for Expression {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Expression::True => out.write_str("true"),
            Expression::False => out.write_str("false"),
            Expression::Missing => out.write_str("..."),
            Expression::Atom(atom) => out.write_str(&atom.text),
            Expression::Not(inner) => {
                out.write_str("not ")?;
                operand(out, inner, needs_parentheses(inner))
            }
            Expression::And(all) => joined(out, all, " and ", 3),
            Expression::Or(all) => joined(out, all, " or ", 2),
            Expression::Implies(left, right) => {
                operand(out, left, left.binding() <= 1)?;
                out.write_str(" => ")?;
                operand(out, right, right.binding() < 1)
            }
            Expression::Iff(left, right) => {
                operand(out, left, left.binding() == 0)?;
                out.write_str(" <=> ")?;
                operand(out, right, right.binding() == 0)
            }
        }
    }
}

/// `not` binds tighter than a comparison looks, so that comparisons are shown in parentheses.
fn needs_parentheses(inner: &Expression) -> bool {
    match inner {
        Expression::Atom(atom) => !atom.is_name(),
        other => other.binding() < 4,
    }
}

fn operand(out: &mut fmt::Formatter<'_>, inner: &Expression, parentheses: bool) -> fmt::Result {
    if parentheses {
        write!(out, "({inner})")
    } else {
        write!(out, "{inner}")
    }
}

fn joined(
    out: &mut fmt::Formatter<'_>,
    all: &[Expression],
    between: &str,
    binding: u8,
) -> fmt::Result {
    for (index, one) in all.iter().enumerate() {
        if index > 0 {
            out.write_str(between)?;
        }
        operand(out, one, one.binding() <= binding)?;
    }
    Ok(())
}
