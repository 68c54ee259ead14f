//! Rational functions with infinities, as the numbers that properties are made of.

use std::cmp::Ordering;

use prism_lang::{Arithmetic, Number, Rational};

use super::function::RationalFunction;
use crate::amount::Amount;
use crate::answer::AnswerValue;
use crate::rounding::Bounds;

/// A rational function, or none.
#[derive(Debug, Clone)]
pub(crate) enum FunctionAmount {
    Finite(RationalFunction),
    Infinite,
    MinusInfinite,
    Undefined,
    /// Depends on which of two functions is greater, which is not the same everywhere.
    Open,
}

use FunctionAmount::{Finite, Infinite, MinusInfinite, Open, Undefined};

impl FunctionAmount {
    /// The sign, if it is the same everywhere.
    fn sign(&self) -> Option<Ordering> {
        match self {
            Finite(value) => value.partial_cmp(&RationalFunction::zero()),
            MinusInfinite => Some(Ordering::Less),
            Infinite => Some(Ordering::Greater),
            Undefined | Open => None,
        }
    }

    fn unbounded(sign: Option<Ordering>) -> Self {
        match sign {
            None => Open,
            Some(Ordering::Less) => MinusInfinite,
            Some(Ordering::Equal) => Undefined,
            Some(Ordering::Greater) => Infinite,
        }
    }

    /// The sign of a product.
    fn sign_with(&self, other: &Self) -> Option<Ordering> {
        let (a, b) = (self.sign()?, other.sign()?);
        Some(match (a, b) {
            (Ordering::Equal, _) | (_, Ordering::Equal) => Ordering::Equal,
            _ if a == b => Ordering::Greater,
            _ => Ordering::Less,
        })
    }
}

impl PartialEq for FunctionAmount {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Finite(a), Finite(b)) => a == b,
            (Infinite, Infinite) | (MinusInfinite, MinusInfinite) | (Undefined, Undefined) => true,
            _ => false,
        }
    }
}

impl Amount for FunctionAmount {
    type Entry = RationalFunction;

    fn literal(number: &Number) -> Self {
        match number.exact() {
            Some(exact) => Finite(RationalFunction::constant(exact.clone())),
            None => Rational::from_float(number.to_f64())
                .map_or(Undefined, |value| Finite(RationalFunction::constant(value))),
        }
    }

    fn entry(entry: &RationalFunction, _: f64) -> Self {
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
            (Finite(a), Finite(b)) => Finite(a.add(b)),
            (Open, _) | (_, Open) => Open,
            (Undefined, _) | (_, Undefined) => Undefined,
            (Infinite, MinusInfinite) | (MinusInfinite, Infinite) => Undefined,
            (Finite(_), infinite) | (infinite, _) => infinite.clone(),
        }
    }

    fn sub(&self, other: &Self) -> Self {
        self.add(&match other {
            Finite(value) => Finite(RationalFunction::zero().sub(value)),
            Infinite => MinusInfinite,
            MinusInfinite => Infinite,
            Undefined => Undefined,
            Open => Open,
        })
    }

    fn mul(&self, other: &Self) -> Self {
        match (self, other) {
            (Finite(a), Finite(b)) => Finite(a.mul(b)),
            (Open, _) | (_, Open) => Open,
            (Undefined, _) | (_, Undefined) => Undefined,
            _ => Self::unbounded(self.sign_with(other)),
        }
    }

    fn div(&self, other: &Self) -> Self {
        match (self, other) {
            (Open, _) | (_, Open) => Open,
            (Undefined, _) | (_, Undefined) => Undefined,
            (Finite(a), Finite(b)) => match a.div(b) {
                Some(quotient) => Finite(quotient),
                None => Self::unbounded(self.sign()),
            },
            (Finite(_), _) => Finite(RationalFunction::zero()),
            (_, Finite(b)) if b.is_zero() => Self::unbounded(self.sign()),
            (_, Finite(_)) => Self::unbounded(self.sign_with(other)),
            _ => Undefined,
        }
    }

    fn pow(&self, exponent: &Self) -> Option<Self> {
        match (self, exponent) {
            (Finite(a), Finite(b)) => Arithmetic::pow(a, b).map(Finite),
            (Open, _) | (_, Open) => Some(Open),
            _ => Some(Undefined),
        }
    }

    fn log(&self, _: &Self) -> Option<Self> {
        None
    }

    fn floor(&self) -> Option<Self> {
        Some(match self {
            Finite(value) => match value.as_constant() {
                Some(value) => Finite(RationalFunction::constant(value.floor())),
                None => Open,
            },
            other => other.clone(),
        })
    }

    fn least(&self, other: &Self) -> Self {
        match (self.compare(other), self, other) {
            (Some(Ordering::Greater), ..) => other.clone(),
            (Some(_), ..) => self.clone(),
            (None, Undefined, _) | (None, _, Undefined) => Undefined,
            _ => Open,
        }
    }

    fn greatest(&self, other: &Self) -> Self {
        match (self.compare(other), self, other) {
            (Some(Ordering::Less), ..) => other.clone(),
            (Some(_), ..) => self.clone(),
            (None, Undefined, _) | (None, _, Undefined) => Undefined,
            _ => Open,
        }
    }

    fn compare(&self, other: &Self) -> Option<Ordering> {
        match (self, other) {
            (Undefined | Open, _) | (_, Undefined | Open) => None,
            (Finite(a), Finite(b)) => a
                .partial_cmp(b)
                .or_else(|| b.partial_cmp(a)?.reverse().into()),
            _ if self == other => Some(Ordering::Equal),
            (Infinite, _) | (_, MinusInfinite) => Some(Ordering::Greater),
            _ => Some(Ordering::Less),
        }
    }

    fn is_undefined(&self) -> bool {
        matches!(self, Undefined)
    }

    /// Functions are exact: probabilities need no bound.
    fn at_most_one(&self) -> Self {
        self.clone()
    }

    fn mean<'a>(
        reward: Option<&Self>,
        transitions: impl Iterator<Item = (&'a RationalFunction, &'a Self)>,
        _: f64,
    ) -> Self {
        let start = reward.cloned().unwrap_or_else(Self::zero);
        transitions.fold(start, |sum, (p, x)| match x {
            // A transition has a positive probability.
            Infinite | MinusInfinite => sum.add(x),
            _ => sum.add(&Finite(p.clone()).mul(x)),
        })
    }

    fn bounds(&self) -> Bounds {
        match self {
            Finite(value) => Bounds::exactly(value.to_f64()),
            Infinite => Bounds::exactly(f64::INFINITY),
            MinusInfinite => Bounds::exactly(f64::NEG_INFINITY),
            Undefined | Open => Bounds::exactly(f64::NAN),
        }
    }

    fn answer(&self) -> AnswerValue {
        match self {
            Finite(value) => match value.as_constant() {
                Some(value) => AnswerValue::Exact(value.clone()),
                None => AnswerValue::Number(f64::NAN),
            },
            other => AnswerValue::Number(other.bounds().low),
        }
    }
}
