//! Constructors of formulas that leave out what makes no difference, and the numbering of atoms.

use temporal::formula::{AtomText, Bound, Formula, Interval, TimeUnit};

use crate::expression::Expression;
use crate::sentence::Amount;

/// All times from now on.
pub(super) const ALL: Interval = Interval::UNBOUNDED;

/// Atoms numbered in the order in which they are met; equal texts share a number.
#[derive(Default)]
pub(super) struct Numbering {
    pub(super) atoms: Vec<AtomText>,
}

impl Numbering {
    pub(super) fn formula(&mut self, expression: &Expression) -> Formula {
        match expression {
            Expression::True => Formula::True,
            // A missing part is refused before anything is compiled.
            Expression::False | Expression::Missing => Formula::False,
            Expression::Atom(atom) => {
                let known = self.atoms.iter().position(|known| known.text == atom.text);
                let index = known.unwrap_or_else(|| {
                    self.atoms.push(AtomText {
                        text: atom.text.clone(),
                        span: atom.span.start..atom.span.end,
                    });
                    self.atoms.len() - 1
                });
                Formula::atom(index)
            }
            Expression::Not(inner) => not(self.formula(inner)),
            Expression::And(all) => {
                and(all.iter().map(|one| self.formula(one)).collect::<Vec<_>>())
            }
            Expression::Or(all) => or(all.iter().map(|one| self.formula(one)).collect::<Vec<_>>()),
            Expression::Implies(left, right) => implies(self.formula(left), self.formula(right)),
            Expression::Iff(left, right) => {
                Formula::Iff(Box::new(self.formula(left)), Box::new(self.formula(right)))
            }
        }
    }
}

pub(super) fn not(inner: Formula) -> Formula {
    match inner {
        Formula::True => Formula::False,
        Formula::False => Formula::True,
        Formula::Not(inner) => *inner,
        inner => Formula::not(inner),
    }
}

pub(super) fn and(all: impl IntoIterator<Item = Formula>) -> Formula {
    let mut operands = Vec::new();
    for one in all {
        match one {
            Formula::True => {}
            Formula::False => return Formula::False,
            Formula::And(inner) => operands.extend(inner),
            one => operands.push(one),
        }
    }
    match operands.len() {
        0 => Formula::True,
        1 => operands.remove(0),
        _ => Formula::And(operands),
    }
}

pub(super) fn or(all: impl IntoIterator<Item = Formula>) -> Formula {
    let mut operands = Vec::new();
    for one in all {
        match one {
            Formula::False => {}
            Formula::True => return Formula::True,
            Formula::Or(inner) => operands.extend(inner),
            one => operands.push(one),
        }
    }
    match operands.len() {
        0 => Formula::False,
        1 => operands.remove(0),
        _ => Formula::Or(operands),
    }
}

pub(super) fn implies(left: Formula, right: Formula) -> Formula {
    match (left, right) {
        (Formula::True, right) => right,
        (Formula::False, _) | (_, Formula::True) => Formula::True,
        (left, Formula::False) => not(left),
        (left, right) => Formula::implies(left, right),
    }
}

pub(super) fn next(inner: Formula) -> Formula {
    Formula::Next(Box::new(inner))
}

pub(super) fn always(interval: Interval, inner: Formula) -> Formula {
    match inner {
        Formula::True => Formula::True,
        inner => Formula::always(interval, inner),
    }
}

pub(super) fn eventually(interval: Interval, inner: Formula) -> Formula {
    match inner {
        Formula::False => Formula::False,
        inner => Formula::eventually(interval, inner),
    }
}

pub(super) fn until(interval: Interval, left: Formula, right: Formula) -> Formula {
    match left {
        Formula::True => eventually(interval, right),
        left => Formula::until(interval, left, right),
    }
}

/// Weak until without a bound.
pub(super) fn weak_until(left: Formula, right: Formula) -> Formula {
    match right {
        Formula::False => always(ALL, left),
        right => Formula::WeakUntil(ALL, Box::new(left), Box::new(right)),
    }
}

pub(super) fn once(inner: Formula) -> Formula {
    Formula::Once(ALL, Box::new(inner))
}

pub(super) fn historically(inner: Formula) -> Formula {
    Formula::Historically(ALL, Box::new(inner))
}

/// At most this far away.
pub(super) fn up_to(amount: Amount) -> Interval {
    let high = bound(amount);
    Interval {
        low: Bound { value: 0.0, ..high },
        high: Some(high),
    }
}

/// Exactly this far away.
pub(super) fn at(amount: Amount) -> Interval {
    let bound = bound(amount);
    Interval {
        low: bound,
        high: Some(bound),
    }
}

fn bound(amount: Amount) -> Bound {
    match amount {
        Amount::Secs(secs) => Bound::secs(secs),
        Amount::Steps(count) => Bound::samples(count),
        // Refused before anything is compiled.
        Amount::Missing => Bound {
            value: f64::NAN,
            unit: TimeUnit::Seconds,
        },
    }
}
