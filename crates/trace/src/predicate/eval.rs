//! Evaluation: truth, numbers and robustness of bound trees, as defined at
//! [`Predicate`](super::Predicate), where sources and guarantees stand too.
//!
//! Within, a missing number is NaN. Truth and robustness are computed together, so that what an
//! unknown operand does to the one it does to the other.
//!
//! Cost: each node of the tree is visited at most once, and without allocation.

use super::parser::{Comparison, Operator};
use crate::signal::{SignalIndex, SignalValues};
use crate::units::Conversion;

/// Something true, false or unknown.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Truth {
    Constant(bool),
    Signal(SignalIndex),
    Not(Box<Truth>),
    And(Box<Truth>, Box<Truth>),
    Or(Box<Truth>, Box<Truth>),
    Same(Box<Truth>, Box<Truth>),
    Compare(Box<Compared>),
    /// Indices of names are equal; there is no distance between names.
    SameName(Amount, Amount),
}

/// A comparison of numbers in one unit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Compared {
    pub(super) comparison: Comparison,
    pub(super) left: Amount,
    pub(super) right: Amount,
    /// From the unit of the comparison to that of the robustness.
    pub(super) to_si: Conversion,
}

/// A number, NaN where it is missing.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Amount {
    Constant(f64),
    Signal(SignalIndex),
    Negate(Box<Amount>),
    Arithmetic(Operator, Box<Amount>, Box<Amount>),
    Abs(Box<Amount>),
    Min(Vec<Amount>),
    Max(Vec<Amount>),
    Norm(Vec<Amount>),
    /// The amount in another unit.
    Convert(Box<Amount>, Conversion),
    /// The difference of two angles, brought between plus and minus half a turn.
    AngleDifference {
        left: Box<Amount>,
        right: Box<Amount>,
        /// A whole turn in the unit of both.
        turn: f64,
    },
}

impl Truth {
    pub(super) fn eval<V: SignalValues + ?Sized>(&self, values: &V) -> Option<bool> {
        match self {
            Truth::Constant(value) => Some(*value),
            Truth::Signal(signal) => values.value(*signal).map(|value| value != 0.0),
            Truth::Not(inner) => inner.eval(values).map(|value| !value),
            Truth::And(left, right) => match left.eval(values) {
                Some(false) => Some(false),
                Some(true) => right.eval(values),
                None => right.eval(values).filter(|&value| !value),
            },
            Truth::Or(left, right) => match left.eval(values) {
                Some(true) => Some(true),
                Some(false) => right.eval(values),
                None => right.eval(values).filter(|&value| value),
            },
            Truth::Same(left, right) => Some(left.eval(values)? == right.eval(values)?),
            Truth::Compare(compared) => {
                let Compared { left, right, .. } = &**compared;
                compare(compared.comparison, left.eval(values), right.eval(values))
            }
            Truth::SameName(left, right) => {
                compare(Comparison::Equal, left.eval(values), right.eval(values))
            }
        }
    }

    /// The truth together with its robustness; `None` where the truth is unknown.
    pub(super) fn judge<V: SignalValues + ?Sized>(&self, values: &V) -> Option<Judged> {
        match self {
            Truth::Not(inner) => inner.judge(values).map(Judged::negated),
            Truth::And(left, right) => {
                let (left, right) = (left.judge(values), right.judge(values));
                conjunction(left, right)
            }
            Truth::Or(left, right) => {
                let left = left.judge(values).map(Judged::negated);
                let right = right.judge(values).map(Judged::negated);
                conjunction(left, right).map(Judged::negated)
            }
            Truth::Same(left, right) => {
                let (left, right) = (left.judge(values)?, right.judge(values)?);
                let both = left.robustness.min(right.robustness);
                let neither = (-left.robustness).min(-right.robustness);
                Some(Judged {
                    truth: left.truth == right.truth,
                    robustness: both.max(neither),
                })
            }
            Truth::Compare(compared) => compared.judge(values),
            Truth::Constant(_) | Truth::Signal(_) | Truth::SameName(..) => {
                let truth = self.eval(values)?;
                Some(Judged {
                    truth,
                    robustness: if truth {
                        f64::INFINITY
                    } else {
                        f64::NEG_INFINITY
                    },
                })
            }
        }
    }
}

/// A truth value and how far the values are from changing it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judged {
    pub(super) truth: bool,
    /// >= 0 if true, <= 0 if false.
    pub(super) robustness: f64,
}

impl Judged {
    fn negated(self) -> Self {
        Judged {
            truth: !self.truth,
            robustness: -self.robustness,
        }
    }
}

/// `left & right`, where an unknown one is left out if the other decides.
fn conjunction(left: Option<Judged>, right: Option<Judged>) -> Option<Judged> {
    match (left, right) {
        (Some(left), Some(right)) => Some(Judged {
            truth: left.truth && right.truth,
            robustness: left.robustness.min(right.robustness),
        }),
        (Some(known), None) | (None, Some(known)) => (!known.truth).then_some(known),
        (None, None) => None,
    }
}

fn compare(comparison: Comparison, left: f64, right: f64) -> Option<bool> {
    let order = left.partial_cmp(&right)?;
    Some(match comparison {
        Comparison::Equal => order.is_eq(),
        Comparison::NotEqual => order.is_ne(),
        Comparison::Less => order.is_lt(),
        Comparison::LessEqual => order.is_le(),
        Comparison::Greater => order.is_gt(),
        Comparison::GreaterEqual => order.is_ge(),
    })
}

impl Compared {
    fn judge<V: SignalValues + ?Sized>(&self, values: &V) -> Option<Judged> {
        let (left, right) = (self.left.eval(values), self.right.eval(values));
        let truth = compare(self.comparison, left, right)?;
        // Equal numbers may both be infinite, and their difference no number.
        let difference = if left == right {
            0.0
        } else {
            self.to_si.apply(right - left)
        };
        let robustness = match self.comparison {
            Comparison::Less | Comparison::LessEqual => difference,
            Comparison::Greater | Comparison::GreaterEqual => -difference,
            Comparison::Equal => -difference.abs(),
            Comparison::NotEqual => difference.abs(),
        };
        Some(Judged { truth, robustness })
    }
}

/// No signal has a value.
struct NoSignals;

impl SignalValues for NoSignals {
    fn raw(&self, _: SignalIndex) -> f64 {
        f64::NAN
    }
}

impl Amount {
    /// This amount, in which no signal occurs, as its value. A missing one (a division by zero)
    /// stays as it is, since NaN is not equal to itself.
    pub(super) fn folded(self) -> Self {
        let value = self.eval(&NoSignals);
        if value.is_nan() {
            self
        } else {
            Amount::Constant(value)
        }
    }

    pub(super) fn eval<V: SignalValues + ?Sized>(&self, values: &V) -> f64 {
        match self {
            Amount::Constant(value) => *value,
            Amount::Signal(signal) => values.raw(*signal),
            Amount::Negate(inner) => -inner.eval(values),
            Amount::Arithmetic(operator, left, right) => {
                arithmetic(*operator, left.eval(values), right.eval(values))
            }
            Amount::Abs(inner) => inner.eval(values).abs(),
            Amount::Min(list) => fold(list, values, f64::INFINITY, f64::min),
            Amount::Max(list) => fold(list, values, f64::NEG_INFINITY, f64::max),
            Amount::Norm(list) => fold(list, values, 0.0, |sum, value| sum + value * value).sqrt(),
            Amount::Convert(inner, conversion) => conversion.apply(inner.eval(values)),
            Amount::AngleDifference { left, right, turn } => {
                wrapped(left.eval(values) - right.eval(values), *turn)
            }
        }
    }
}

fn arithmetic(operator: Operator, left: f64, right: f64) -> f64 {
    match operator {
        Operator::Add => left + right,
        Operator::Subtract => left - right,
        Operator::Multiply => left * right,
        Operator::Divide if right != 0.0 => left / right,
        _ => f64::NAN,
    }
}

/// `angle` less a whole number of turns, in (-turn/2, turn/2]; NaN if it is not finite.
fn wrapped(angle: f64, turn: f64) -> f64 {
    // The remainder of a division is exact.
    let within = angle % turn;
    let half = turn / 2.0;
    if within > half {
        within - turn
    } else if within <= -half {
        within + turn
    } else {
        within
    }
}

/// Combines the values of `list`; NaN if one is missing.
fn fold<V: SignalValues + ?Sized>(
    list: &[Amount],
    values: &V,
    start: f64,
    combine: fn(f64, f64) -> f64,
) -> f64 {
    let mut result = start;
    for amount in list {
        let value = amount.eval(values);
        if value.is_nan() {
            return f64::NAN;
        }
        result = combine(result, value);
    }
    result
}
