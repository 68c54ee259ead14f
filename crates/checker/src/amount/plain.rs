//! Plain floating point, of which nothing is known.

use std::cmp::Ordering;

use prism_lang::{Arithmetic, Number};

use super::Amount;
use crate::answer::AnswerValue;
use crate::rounding::Bounds;

impl Amount for f64 {
    type Entry = f64;

    fn literal(number: &Number) -> Self {
        number.to_f64()
    }
    fn entry(entry: &f64, _: f64) -> Self {
        *entry
    }
    fn infinity() -> Self {
        f64::INFINITY
    }
    fn undefined() -> Self {
        f64::NAN
    }
    fn add(&self, other: &Self) -> Self {
        self + other
    }
    fn sub(&self, other: &Self) -> Self {
        self - other
    }
    fn mul(&self, other: &Self) -> Self {
        self * other
    }
    fn div(&self, other: &Self) -> Self {
        self / other
    }
    fn pow(&self, exponent: &Self) -> Option<Self> {
        Some(self.powf(*exponent))
    }
    fn log(&self, base: &Self) -> Option<Self> {
        Some(self.ln() / base.ln())
    }
    fn floor(&self) -> Option<Self> {
        Some(f64::floor(*self))
    }
    fn least(&self, other: &Self) -> Self {
        if self.is_nan() || *self < *other {
            *self
        } else {
            *other
        }
    }
    fn greatest(&self, other: &Self) -> Self {
        if self.is_nan() || *self > *other {
            *self
        } else {
            *other
        }
    }
    fn compare(&self, other: &Self) -> Option<Ordering> {
        self.partial_cmp(other)
    }
    fn is_undefined(&self) -> bool {
        self.is_nan()
    }
    fn mean<'a>(
        reward: Option<&Self>,
        transitions: impl Iterator<Item = (&'a f64, &'a Self)>,
        _: f64,
    ) -> Self {
        transitions.fold(reward.copied().unwrap_or(0.0), |sum, (p, x)| sum + p * x)
    }
    fn bounds(&self) -> Bounds {
        Bounds::exactly(self.to_f64())
    }
    fn answer(&self) -> AnswerValue {
        AnswerValue::Number(*self)
    }
}
