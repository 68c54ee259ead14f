//! Positive form: a formula whose negations stand at atoms, for engines that compute one number.
//!
//! In positive form every operator is monotone, so the least value that a formula can have follows
//! from the least values of its atoms (negated: the greatest), and the greatest likewise, each by
//! the same computation over single numbers instead of bounds.
//!
//! `Just before` is what `rise` needs: rise f = f & just before !f. The rules are those of De Morgan
//! and the duals of [`super::semantics`]. `<=>` doubles its operands, so the size is limited.

use super::ast::{Formula, Interval, Window};
use super::settings::{CompileError, TimeModel};

/// The most operators of a positive form.
const MAX_SIZE: usize = 20_000;

/// A formula in positive form.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Positive {
    Constant(f64),
    Literal {
        atom: usize,
        negated: bool,
    },
    /// The least of the operands.
    And(Vec<Positive>),
    /// The greatest of the operands.
    Or(Vec<Positive>),
    /// The operand just before, and `first` at the beginning.
    JustBefore {
        first: f64,
        inner: Box<Positive>,
    },
    Timed {
        operator: Timed,
        window: Window,
        left: Box<Positive>,
        right: Box<Positive>,
    },
}

/// Operators of time with two operands; those with one have a constant left operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Timed {
    Until,
    Release,
    Since,
    /// Dual of since.
    Trigger,
}

/// The positive form of a formula, for one model of time.
pub(super) fn positive(formula: &Formula, time: TimeModel) -> Result<Positive, CompileError> {
    let mut builder = Builder { time, size: 0 };
    builder.build(formula, false)
}

impl Positive {
    /// The same with the ends of all windows in seconds rounded to multiples of a resolution.
    pub(super) fn with_resolution(&self, resolution_nanos: i64) -> Self {
        let again = |inner: &Positive| inner.with_resolution(resolution_nanos);
        match self {
            Positive::Constant(_) | Positive::Literal { .. } => self.clone(),
            Positive::And(operands) => Positive::And(operands.iter().map(again).collect()),
            Positive::Or(operands) => Positive::Or(operands.iter().map(again).collect()),
            Positive::JustBefore { first, inner } => Positive::JustBefore {
                first: *first,
                inner: Box::new(again(inner)),
            },
            Positive::Timed {
                operator,
                window,
                left,
                right,
            } => Positive::Timed {
                operator: *operator,
                window: window.with_resolution(resolution_nanos),
                left: Box::new(again(left)),
                right: Box::new(again(right)),
            },
        }
    }
}

struct Builder {
    time: TimeModel,
    size: usize,
}

impl Builder {
    fn build(&mut self, formula: &Formula, negated: bool) -> Result<Positive, CompileError> {
        self.size += 1;
        if self.size > MAX_SIZE {
            return Err(CompileError::TooDeep);
        }
        match formula {
            Formula::True => Ok(constant(!negated)),
            Formula::False => Ok(constant(negated)),
            Formula::Atom(atom) => Ok(Positive::Literal {
                atom: atom.0,
                negated,
            }),
            Formula::Not(inner) => self.build(inner, !negated),
            Formula::And(operands) | Formula::Or(operands) => {
                let and = matches!(formula, Formula::And(_)) != negated;
                let parts = operands.iter().map(|operand| self.build(operand, negated));
                Ok(join(and, parts.collect::<Result<_, _>>()?))
            }
            Formula::Implies(left, right) => {
                let parts = vec![self.build(left, !negated)?, self.build(right, negated)?];
                Ok(join(negated, parts))
            }
            Formula::Iff(left, right) => self.equivalence(left, right, negated),
            Formula::Next(_) | Formula::Previous(_) => Err(CompileError::SamplesInDenseTime {
                what: "\"next\" or \"previous\"".to_owned(),
            }),
            Formula::Rise(inner) => self.becomes(inner, true, negated),
            Formula::Fall(inner) => self.becomes(inner, false, negated),
            _ => self.timed(formula, negated),
        }
    }

    /// (a & b) | (!a & !b), or its negation (!a | !b) & (a | b).
    fn equivalence(
        &mut self,
        left: &Formula,
        right: &Formula,
        negated: bool,
    ) -> Result<Positive, CompileError> {
        let same = join(
            !negated,
            vec![self.build(left, negated)?, self.build(right, negated)?],
        );
        let other = join(
            !negated,
            vec![self.build(left, !negated)?, self.build(right, !negated)?],
        );
        Ok(join(negated, vec![same, other]))
    }

    /// inner = `value` & just before inner != `value`, or its negation.
    fn becomes(
        &mut self,
        inner: &Formula,
        value: bool,
        negated: bool,
    ) -> Result<Positive, CompileError> {
        let now = self.build(inner, value == negated)?;
        let before = Positive::JustBefore {
            first: if negated {
                f64::NEG_INFINITY
            } else {
                f64::INFINITY
            },
            inner: Box::new(self.build(inner, value != negated)?),
        };
        Ok(join(!negated, vec![now, before]))
    }

    fn timed(&mut self, formula: &Formula, negated: bool) -> Result<Positive, CompileError> {
        let left_of_one = |value: bool| constant(value != negated);
        let (operator, interval, left, right): (_, &Interval, _, &Formula) = match formula {
            Formula::Eventually(interval, inner) => {
                (Timed::Until, interval, left_of_one(true), inner)
            }
            Formula::Always(interval, inner) => {
                (Timed::Release, interval, left_of_one(false), inner)
            }
            Formula::Once(interval, inner) => (Timed::Since, interval, left_of_one(true), inner),
            Formula::Historically(interval, inner) => {
                (Timed::Trigger, interval, left_of_one(false), inner)
            }
            Formula::Until(interval, left, right) => {
                (Timed::Until, interval, self.build(left, negated)?, right)
            }
            Formula::Release(interval, left, right) => {
                (Timed::Release, interval, self.build(left, negated)?, right)
            }
            Formula::Since(interval, left, right) => {
                (Timed::Since, interval, self.build(left, negated)?, right)
            }
            Formula::WeakUntil(interval, left, right) => {
                let released = self.build(right, negated)?;
                let either = join(
                    negated,
                    vec![self.build(left, negated)?, self.build(right, negated)?],
                );
                let operator = dual_if(Timed::Release, negated);
                return self.node(operator, interval, released, either);
            }
            // All others were built before.
            _ => return self.build(formula, negated),
        };
        let right = self.build(right, negated)?;
        self.node(dual_if(operator, negated), interval, left, right)
    }

    fn node(
        &self,
        operator: Timed,
        interval: &Interval,
        left: Positive,
        right: Positive,
    ) -> Result<Positive, CompileError> {
        Ok(Positive::Timed {
            operator,
            window: interval.window(self.time)?,
            left: Box::new(left),
            right: Box::new(right),
        })
    }
}

fn constant(value: bool) -> Positive {
    Positive::Constant(if value {
        f64::INFINITY
    } else {
        f64::NEG_INFINITY
    })
}

fn dual_if(operator: Timed, negated: bool) -> Timed {
    match (operator, negated) {
        (operator, false) => operator,
        (Timed::Until, true) => Timed::Release,
        (Timed::Release, true) => Timed::Until,
        (Timed::Since, true) => Timed::Trigger,
        (Timed::Trigger, true) => Timed::Since,
    }
}

/// The conjunction or disjunction, flattened.
fn join(and: bool, parts: Vec<Positive>) -> Positive {
    let mut flat = Vec::with_capacity(parts.len());
    for part in parts {
        match part {
            Positive::And(inner) if and => flat.extend(inner),
            Positive::Or(inner) if !and => flat.extend(inner),
            part => flat.push(part),
        }
    }
    if and {
        Positive::And(flat)
    } else {
        Positive::Or(flat)
    }
}
