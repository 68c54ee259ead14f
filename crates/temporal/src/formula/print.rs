//! Formulas to text that [`super::parse`] reads back as the same formula.

use std::fmt;

use super::ast::{Bound, Formula, Interval, TimeUnit};

impl fmt::Display for Bound {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.unit {
            TimeUnit::Seconds => write!(out, "{} s", self.value),
            TimeUnit::Samples => write!(out, "{} samples", self.value),
            TimeUnit::Unstated => write!(out, "{}", self.value),
        }
    }
}

impl fmt::Display for Interval {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.high {
            Some(high) => write!(out, "[{}, {high}]", self.low),
            None => write!(out, "[{}, inf]", self.low),
        }
    }
}

/// Atom 3 is printed `p3`; with the atoms' texts, use [`Formula::display`].
impl fmt::Display for Formula {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        print(self, &|atom| format!("p{atom}"), out)
    }
}

/// A formula with the texts of its atoms, for printing.
#[derive(Debug, Clone, Copy)]
pub struct FormulaText<'f> {
    formula: &'f Formula,
    atoms: &'f [super::AtomText],
}

impl Formula {
    /// The formula as text with these texts for its atoms; an atom beyond them is printed `p3`.
    #[must_use]
    pub fn display<'f>(&'f self, atoms: &'f [super::AtomText]) -> FormulaText<'f> {
        FormulaText {
            formula: self,
            atoms,
        }
    }
}

impl fmt::Display for FormulaText<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |atom: usize| match self.atoms.get(atom) {
            Some(atom) => atom.text.clone(),
            None => format!("p{atom}"),
        };
        print(self.formula, &name, out)
    }
}

type Name<'n> = &'n dyn Fn(usize) -> String;

fn print(formula: &Formula, name: Name<'_>, out: &mut fmt::Formatter<'_>) -> fmt::Result {
    match formula {
        Formula::True => out.write_str("true"),
        Formula::False => out.write_str("false"),
        Formula::Atom(atom) => out.write_str(&name(atom.0)),
        Formula::Not(inner) => unary("not", None, inner, name, out),
        Formula::Next(inner) => unary("next", None, inner, name, out),
        Formula::Previous(inner) => unary("previous", None, inner, name, out),
        Formula::Rise(inner) => unary("rise", None, inner, name, out),
        Formula::Fall(inner) => unary("fall", None, inner, name, out),
        Formula::Eventually(interval, inner) => {
            unary("eventually", Some(interval), inner, name, out)
        }
        Formula::Always(interval, inner) => unary("always", Some(interval), inner, name, out),
        Formula::Once(interval, inner) => unary("once", Some(interval), inner, name, out),
        Formula::Historically(interval, inner) => {
            unary("historically", Some(interval), inner, name, out)
        }
        Formula::And(operands) => chain("and", "true", operands, name, out),
        Formula::Or(operands) => chain("or", "false", operands, name, out),
        Formula::Implies(left, right) => binary("=>", None, [left, right], name, out),
        Formula::Iff(left, right) => binary("<=>", None, [left, right], name, out),
        Formula::Until(interval, left, right) => {
            binary("until", Some(interval), [left, right], name, out)
        }
        Formula::WeakUntil(interval, left, right) => {
            binary("weak_until", Some(interval), [left, right], name, out)
        }
        Formula::Release(interval, left, right) => {
            binary("release", Some(interval), [left, right], name, out)
        }
        Formula::Since(interval, left, right) => {
            binary("since", Some(interval), [left, right], name, out)
        }
    }
}

fn window(interval: Option<&Interval>, out: &mut fmt::Formatter<'_>) -> fmt::Result {
    match interval {
        Some(interval) if *interval != Interval::UNBOUNDED => write!(out, "{interval}"),
        _ => Ok(()),
    }
}

fn unary(
    operator: &str,
    interval: Option<&Interval>,
    inner: &Formula,
    name: Name<'_>,
    out: &mut fmt::Formatter<'_>,
) -> fmt::Result {
    out.write_str(operator)?;
    window(interval, out)?;
    out.write_str(" ")?;
    operand(inner, name, out)
}

fn binary(
    operator: &str,
    interval: Option<&Interval>,
    [left, right]: [&Formula; 2],
    name: Name<'_>,
    out: &mut fmt::Formatter<'_>,
) -> fmt::Result {
    operand(left, name, out)?;
    write!(out, " {operator}")?;
    window(interval, out)?;
    out.write_str(" ")?;
    operand(right, name, out)
}

/// A chain of one operand or none cannot be told from other formulas; it is printed with the
/// neutral element, which means the same.
fn chain(
    operator: &str,
    neutral: &str,
    operands: &[Formula],
    name: Name<'_>,
    out: &mut fmt::Formatter<'_>,
) -> fmt::Result {
    if operands.len() < 2 {
        write!(out, "{neutral} {operator} {neutral}")?;
    }
    for (index, inner) in operands.iter().enumerate() {
        if index > 0 || operands.len() < 2 {
            write!(out, " {operator} ")?;
        }
        operand(inner, name, out)?;
    }
    Ok(())
}

fn is_plain(formula: &Formula) -> bool {
    matches!(formula, Formula::True | Formula::False | Formula::Atom(_))
}

fn operand(inner: &Formula, name: Name<'_>, out: &mut fmt::Formatter<'_>) -> fmt::Result {
    if is_plain(inner) {
        return print(inner, name, out);
    }
    out.write_str("(")?;
    print(inner, name, out)?;
    out.write_str(")")
}
