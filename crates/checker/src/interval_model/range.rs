//! An interval of transition probabilities as a number domain, so that state spaces can have it.

use prism_lang::{Arithmetic, Number};

/// Least and largest value of a transition probability.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Range {
    /// Least value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
}

impl Range {
    fn exactly(value: f64) -> Self {
        Self {
            low: value,
            high: value,
        }
    }

    /// One rounding outwards.
    fn outwards(low: f64, high: f64) -> Self {
        Self {
            low: low.next_down(),
            high: high.next_up(),
        }
    }

    /// The hull of an operation's values at all pairs of ends.
    fn hull(self, other: Self, operation: impl Fn(f64, f64) -> f64) -> Self {
        let ends = [
            operation(self.low, other.low),
            operation(self.low, other.high),
            operation(self.high, other.low),
            operation(self.high, other.high),
        ];
        let low = ends.iter().copied().fold(f64::INFINITY, f64::min);
        let high = ends.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Self::outwards(low, high)
    }
}

/// Interval arithmetic, rounded outwards. Powers and logarithms are not needed of ranges.
impl Arithmetic for Range {
    const EXACT: bool = false;

    fn zero() -> Self {
        Self::exactly(0.0)
    }
    fn one() -> Self {
        Self::exactly(1.0)
    }
    fn from_i64(value: i64) -> Self {
        Self::exactly(value as f64)
    }
    fn from_literal(number: &Number) -> Option<Self> {
        let nearest = number.to_f64();
        Some(Self::outwards(nearest, nearest))
    }
    fn to_f64(&self) -> f64 {
        f64::midpoint(self.low, self.high)
    }
    fn add(&self, other: &Self) -> Self {
        Self::outwards(self.low + other.low, self.high + other.high)
    }
    fn sub(&self, other: &Self) -> Self {
        Self::outwards(self.low - other.high, self.high - other.low)
    }
    fn mul(&self, other: &Self) -> Self {
        self.hull(*other, |a, b| a * b)
    }
    fn div(&self, other: &Self) -> Option<Self> {
        let holds_zero = other.low <= 0.0 && other.high >= 0.0;
        (!holds_zero).then(|| self.hull(*other, |a, b| a / b))
    }
    fn pow(&self, _: &Self) -> Option<Self> {
        None
    }
    fn log(&self, _: &Self) -> Option<Self> {
        None
    }
    fn floor(&self) -> Option<i64> {
        None
    }
    fn is_zero(&self) -> bool {
        self.low == 0.0 && self.high == 0.0
    }
    fn is_non_negative(&self) -> bool {
        self.low.is_finite() && self.high.is_finite() && self.low >= 0.0
    }
}
