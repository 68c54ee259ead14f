//! Rationals with infinities.

use std::cmp::Ordering;

use num_traits::Zero;
use prism_lang::{Arithmetic, Number, Rational};

use super::Amount;
use crate::answer::AnswerValue;
use crate::rounding::Bounds;

/// A rational number, or none.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Extended {
    Finite(Rational),
    Infinite,
    MinusInfinite,
    Undefined,
}

use Extended::{Finite, Infinite, MinusInfinite, Undefined};

impl Extended {
    fn sign(&self) -> Ordering {
        match self {
            Finite(value) => value.cmp(&<Rational as Zero>::zero()),
            MinusInfinite => Ordering::Less,
            _ => Ordering::Greater,
        }
    }

    fn unbounded(sign: Ordering) -> Self {
        match sign {
            Ordering::Less => MinusInfinite,
            Ordering::Equal => Undefined,
            Ordering::Greater => Infinite,
        }
    }
}

impl Amount for Extended {
    type Entry = Rational;

    fn literal(number: &Number) -> Self {
        match number.exact() {
            Some(exact) => Finite(exact.clone()),
            None => Rational::from_float(number.to_f64()).map_or(Undefined, Finite),
        }
    }

    fn entry(entry: &Rational, _: f64) -> Self {
        Finite(entry.clone())
    }

    fn infinity() -> Self {
        Infinite
    }

    fn undefined() -> Self {
        Undefined
    }

    fn add(&self, other: &Self) -> Self {
        match (self, other) {
            (Finite(a), Finite(b)) => Finite(Arithmetic::add(a, b)),
            (Undefined, _) | (_, Undefined) => Undefined,
            (Infinite, MinusInfinite) | (MinusInfinite, Infinite) => Undefined,
            (Finite(_), infinite) | (infinite, _) => infinite.clone(),
        }
    }

    fn sub(&self, other: &Self) -> Self {
        self.add(&match other {
            Finite(value) => Finite(-value),
            Infinite => MinusInfinite,
            MinusInfinite => Infinite,
            Undefined => Undefined,
        })
    }

    fn mul(&self, other: &Self) -> Self {
        match (self, other) {
            (Finite(a), Finite(b)) => Finite(Arithmetic::mul(a, b)),
            (Undefined, _) | (_, Undefined) => Undefined,
            _ if self.sign() == Ordering::Equal || other.sign() == Ordering::Equal => Undefined,
            _ if self.sign() == other.sign() => Infinite,
            _ => MinusInfinite,
        }
    }

    fn div(&self, other: &Self) -> Self {
        match (self, other) {
            (Finite(a), Finite(b)) if !Zero::is_zero(b) => Finite(a / b),
            (Undefined, _) | (_, Undefined) => Undefined,
            (_, Finite(b)) if Zero::is_zero(b) => Self::unbounded(self.sign()),
            (Finite(_), _) => Finite(<Rational as Zero>::zero()),
            (_, Finite(_)) if self.sign() == other.sign() => Infinite,
            (_, Finite(_)) => MinusInfinite,
            _ => Undefined,
        }
    }

    fn pow(&self, exponent: &Self) -> Option<Self> {
        match (self, exponent) {
            (Finite(a), Finite(b)) => Arithmetic::pow(a, b).map(Finite),
            _ => Some(Undefined),
        }
    }

    fn log(&self, _: &Self) -> Option<Self> {
        None
    }

    fn floor(&self) -> Option<Self> {
        Some(match self {
            Finite(value) => Finite(value.floor()),
            other => other.clone(),
        })
    }

    fn least(&self, other: &Self) -> Self {
        match self.compare(other) {
            Some(Ordering::Greater) => other.clone(),
            Some(_) => self.clone(),
            None => Undefined,
        }
    }

    fn greatest(&self, other: &Self) -> Self {
        match self.compare(other) {
            Some(Ordering::Less) => other.clone(),
            Some(_) => self.clone(),
            None => Undefined,
        }
    }

    fn compare(&self, other: &Self) -> Option<Ordering> {
        match (self, other) {
            (Undefined, _) | (_, Undefined) => None,
            (Finite(a), Finite(b)) => Some(a.cmp(b)),
            _ if self == other => Some(Ordering::Equal),
            (Infinite, _) | (_, MinusInfinite) => Some(Ordering::Greater),
            _ => Some(Ordering::Less),
        }
    }

    fn is_undefined(&self) -> bool {
        *self == Undefined
    }

    fn mean<'a>(
        reward: Option<&Self>,
        transitions: impl Iterator<Item = (&'a Rational, &'a Self)>,
        _: f64,
    ) -> Self {
        let start = reward.cloned().unwrap_or_else(Self::zero);
        transitions.fold(start, |sum, (p, x)| sum.add(&Finite(p.clone()).mul(x)))
    }

    fn bounds(&self) -> Bounds {
        match self {
            Finite(value) => Bounds::literal(&Number::from_rational(value.clone())),
            Infinite => Bounds::exactly(f64::INFINITY),
            MinusInfinite => Bounds::exactly(f64::NEG_INFINITY),
            Undefined => Bounds::exactly(f64::NAN),
        }
    }

    fn answer(&self) -> AnswerValue {
        match self {
            Finite(value) => AnswerValue::Exact(value.clone()),
            other => AnswerValue::Number(other.bounds().low),
        }
    }

    fn beats(&self, other: &Self, maximise: bool) -> bool {
        let wanted = if maximise {
            Ordering::Greater
        } else {
            Ordering::Less
        };
        self.compare(other) == Some(wanted)
    }
}
