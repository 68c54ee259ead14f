//! Rational numbers of a state, as quotients of two 64-bit integers.
//!
//! Definition: `+ - * /`, `min`, `max` and `?:` on `n/d` with `d > 0`; reduced when a part exceeds 31 bits. The
//! value is exact; `None` where a part exceeds 64 bits or a divisor is 0, so that the caller evaluates slowly.
//! Converting to a double rounds once: both parts are exact doubles below 2^53, and IEEE division rounds its
//! exact quotient. Cost: a few machine instructions per operation.

use std::cmp::Ordering;

use num_traits::ToPrimitive;
use prism_lang::ast::{BinaryOp, Type, UnaryOp};
use prism_lang::{Arithmetic, Expr, ExprKind, Function};

use super::code::{Code, Compiler};
use super::command::Rounded;
use crate::state_space::Field;

/// An expression whose values are rational.
#[derive(Clone, Debug)]
pub(crate) enum Quotient {
    Constant(Small),
    Integer(Code),
    Operation(BinaryOp, Box<Quotient>, Box<Quotient>),
    Extreme(Ordering, Vec<Quotient>),
    Choice(Code, Box<Quotient>, Box<Quotient>),
}

/// `n/d` with `d > 0`, not always reduced.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Small {
    n: i64,
    d: i64,
}

impl Compiler<'_> {
    /// Compiles a number, if all of it has a fast form.
    pub(super) fn quotient(self, expr: &Expr) -> Option<Quotient> {
        if expr.ty == Type::Int {
            return match self.code(expr) {
                Code::Slow(_) => None,
                code => Some(Quotient::Integer(code)),
            };
        }
        let boxed = |e| self.quotient(e).map(Box::new);
        Some(match &expr.kind {
            ExprKind::Double(number) => {
                let exact = number.exact()?;
                let (n, d) = (exact.numer().to_i64()?, exact.denom().to_i64()?);
                Quotient::Constant(Small { n, d })
            }
            ExprKind::Unary(UnaryOp::Minus, a) => {
                let zero = Quotient::Constant(Small { n: 0, d: 1 });
                Quotient::Operation(BinaryOp::Minus, Box::new(zero), boxed(a)?)
            }
            ExprKind::Binary(operator, a, b) if *operator != BinaryOp::Power => {
                Quotient::Operation(*operator, boxed(a)?, boxed(b)?)
            }
            ExprKind::IfThenElse(c, a, b) => Quotient::Choice(self.code(c), boxed(a)?, boxed(b)?),
            ExprKind::Call(function @ (Function::Min | Function::Max), arguments) => {
                let wanted = match function {
                    Function::Min => Ordering::Less,
                    _ => Ordering::Greater,
                };
                let parts = arguments.iter().map(|a| self.quotient(a));
                Quotient::Extreme(wanted, parts.collect::<Option<_>>()?)
            }
            _ => return None,
        })
    }
}

impl Quotient {
    /// The value in a state; `None` if it must be found slowly.
    pub(super) fn value(&self, state: &[u64]) -> Option<Small> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Integer(code) => Some(Small {
                n: code.value(state)?,
                d: 1,
            }),
            Self::Operation(operator, a, b) => a.value(state)?.operate(*operator, b.value(state)?),
            Self::Choice(c, a, b) => {
                let chosen = if c.value(state)? != 0 { a } else { b };
                chosen.value(state)
            }
            Self::Extreme(wanted, parts) => {
                let (first, rest) = parts.split_first()?;
                let mut best = first.value(state)?;
                for part in rest {
                    let value = part.value(state)?;
                    if value.compare(best) == *wanted {
                        best = value;
                    }
                }
                Some(best)
            }
        }
    }

    pub(super) fn for_each_field(&self, visit: &mut dyn FnMut(Field)) {
        match self {
            Self::Constant(_) => {}
            Self::Integer(code) => code.for_each_field(visit),
            Self::Operation(_, a, b) => [a, b].iter().for_each(|p| p.for_each_field(visit)),
            Self::Extreme(_, parts) => parts.iter().for_each(|p| p.for_each_field(visit)),
            Self::Choice(c, a, b) => {
                c.for_each_field(visit);
                [a, b].iter().for_each(|p| p.for_each_field(visit));
            }
        }
    }
}

impl Small {
    fn operate(self, operator: BinaryOp, other: Self) -> Option<Self> {
        let (a, b) = (self, other);
        let sum = |b: Self, sign: i64| {
            if a.d == b.d {
                return Some(Self {
                    n: a.n.checked_add(b.n.checked_mul(sign)?)?,
                    d: a.d,
                });
            }
            let right = b.n.checked_mul(a.d)?.checked_mul(sign)?;
            Some(Self {
                n: a.n.checked_mul(b.d)?.checked_add(right)?,
                d: a.d.checked_mul(b.d)?,
            })
        };
        let result = match operator {
            BinaryOp::Plus => sum(b, 1)?,
            BinaryOp::Minus => sum(b, -1)?,
            BinaryOp::Times => Self {
                n: a.n.checked_mul(b.n)?,
                d: a.d.checked_mul(b.d)?,
            },
            BinaryOp::Divide if b.n != 0 => Self {
                n: a.n.checked_mul(b.d)?.checked_mul(b.n.signum())?,
                d: a.d.checked_mul(b.n.checked_abs()?)?,
            },
            _ => return None,
        };
        result.reduced()
    }

    /// Reduced, if it is large.
    fn reduced(self) -> Option<Self> {
        if self.n.unsigned_abs() | self.d.unsigned_abs() < 1 << 31 {
            return Some(self);
        }
        let (mut a, mut b) = (self.n.checked_abs()?, self.d);
        while b != 0 {
            (a, b) = (b, a % b);
        }
        Some(Self {
            n: self.n / a,
            d: self.d / a,
        })
    }

    pub(super) fn compare(self, other: Self) -> Ordering {
        let left = i128::from(self.n) * i128::from(other.d);
        left.cmp(&(i128::from(other.n) * i128::from(self.d)))
    }

    pub(super) fn is_negative(self) -> bool {
        self.n < 0
    }

    pub(super) fn rounded(self, function: Function) -> Option<i64> {
        match function {
            Function::Floor => Some(self.n.div_euclid(self.d)),
            Function::Ceil => self.n.checked_neg()?.div_euclid(self.d).checked_neg(),
            // Halves go up.
            Function::Round => {
                let twice = self.n.checked_mul(2)?.checked_add(self.d)?;
                Some(twice.div_euclid(self.d.checked_mul(2)?))
            }
            _ => None,
        }
    }

    /// The number in the domain, rounded once; `None` if its parts are too large for that.
    pub(super) fn number<N: Arithmetic>(self) -> Option<Rounded<N>> {
        const EXACT_DOUBLES: u64 = 1 << 53;
        if self.n.unsigned_abs() > EXACT_DOUBLES || self.d.unsigned_abs() > EXACT_DOUBLES {
            return None;
        }
        let value = N::from_i64(self.n).div(&N::from_i64(self.d))?;
        let is_exact = N::EXACT
            || self.d == 1
            // The remainder of the division, which a fused operation rounds once.
            || value.to_f64().mul_add(self.d as f64, -(self.n as f64)) == 0.0;
        Some(Rounded {
            value,
            roundings: Some(u32::from(!is_exact)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_that_outgrow_64_bits_give_up_and_others_are_exact() {
        let small = |n, d| Small { n, d };
        let third = small(1, 3).operate(BinaryOp::Plus, small(1, 6)).unwrap();
        assert_eq!(third.compare(small(1, 2)), Ordering::Equal);
        assert!(
            small(i64::MAX, 1)
                .operate(BinaryOp::Times, small(2, 1))
                .is_none()
        );
        assert!(small(1, 2).operate(BinaryOp::Divide, small(0, 1)).is_none());
        let minus = small(1, 2).operate(BinaryOp::Divide, small(-3, 1)).unwrap();
        assert_eq!((minus.n, minus.d), (-1, 6));
        for (n, d, floor, ceil, round) in [(-7, 2, -4, -3, -3), (7, 2, 3, 4, 4), (5, 4, 1, 2, 1)] {
            let of = |f| small(n, d).rounded(f).unwrap();
            let all = (of(Function::Floor), of(Function::Ceil), of(Function::Round));
            assert_eq!(all, (floor, ceil, round));
        }
    }

    #[test]
    fn doubles_are_rounded_once_and_it_is_known_whether() {
        let number = |n, d| Small { n, d }.number::<f64>().unwrap();
        assert_eq!(
            (number(3, 4).value, number(3, 4).roundings),
            (0.75, Some(0))
        );
        assert_eq!(
            (number(1, 10).value, number(1, 10).roundings),
            (0.1, Some(1))
        );
        assert_eq!(number(6, 3).roundings, Some(0));
        assert!(Small { n: 1 << 60, d: 3 }.number::<f64>().is_none());
    }
}
