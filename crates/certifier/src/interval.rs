//! Intervals of floating-point numbers whose ends are rounded outwards, so that they contain what is computed.
//!
//! *Definition.* Each operation is done on the ends to nearest and moved to the next number outwards; operations with 0
//! and 1 are exact and not moved. Source: Moore 1966, "Interval Analysis". Guarantee: containment.

use prism_lang::{Number, Rational, rational_to_f64};

/// The numbers between two, both included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The least.
    pub low: f64,
    /// The greatest.
    pub high: f64,
}

impl Interval {
    /// Where nothing is known, as of what is divided by 0.
    pub(crate) const ANY: Self = Self {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
    };
    pub(crate) const ZERO: Self = Self::exactly(0.0);
    pub(crate) const ONE: Self = Self::exactly(1.0);

    pub(crate) const fn exactly(value: f64) -> Self {
        Self {
            low: value,
            high: value,
        }
    }

    pub(crate) fn of(value: &Rational) -> Self {
        let nearest = rational_to_f64(value);
        if Rational::from_float(nearest).as_ref() == Some(value) {
            return Self::exactly(nearest);
        }
        Self {
            low: nearest.next_down(),
            high: nearest.next_up(),
        }
    }

    pub(crate) fn of_number(value: &Number) -> Self {
        match value.exact() {
            Some(exact) => Self::of(exact),
            // Computed in floating point by the language: a few roundings.
            None => {
                let near = value.to_f64();
                let error = near.abs() * 1e-14 + f64::MIN_POSITIVE;
                Self {
                    low: near - error,
                    high: near + error,
                }
            }
        }
    }

    fn is(&self, value: f64) -> bool {
        self.low == value && self.high == value
    }

    pub(crate) fn add(&self, other: &Self) -> Self {
        if self.is(0.0) {
            return *other;
        }
        if other.is(0.0) {
            return *self;
        }
        Self::outwards(self.low + other.low, self.high + other.high)
    }

    pub(crate) fn sub(&self, other: &Self) -> Self {
        if other.is(0.0) {
            return *self;
        }
        if self.low == self.high && self == other && self.low.is_finite() {
            return Self::ZERO;
        }
        Self::outwards(self.low - other.high, self.high - other.low)
    }

    pub(crate) fn mul(&self, other: &Self) -> Self {
        if self.is(0.0) || other.is(1.0) {
            return *self;
        }
        if other.is(0.0) || self.is(1.0) {
            return *other;
        }
        let ends = [
            self.low * other.low,
            self.low * other.high,
            self.high * other.low,
            self.high * other.high,
        ];
        let ends = ends.map(|end| if end.is_nan() { 0.0 } else { end });
        let least = ends.iter().copied().fold(f64::INFINITY, f64::min);
        let most = ends.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let found = Self::outwards(least, most);
        match self.low >= 0.0 && other.low >= 0.0 {
            true => found.at_least(0.0),
            false => found,
        }
    }

    /// Nothing where the divisor may be 0.
    pub(crate) fn div(&self, other: &Self) -> Option<Self> {
        if other.low <= 0.0 && other.high >= 0.0 {
            return None;
        }
        if self.is(0.0) || other.is(1.0) {
            return Some(*self);
        }
        let ends = [
            self.low / other.low,
            self.low / other.high,
            self.high / other.low,
            self.high / other.high,
        ];
        if ends.iter().any(|end| end.is_nan()) {
            return None;
        }
        let least = ends.iter().copied().fold(f64::INFINITY, f64::min);
        let most = ends.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let found = Self::outwards(least, most);
        Some(match self.low >= 0.0 && other.low > 0.0 {
            true => found.at_least(0.0),
            false => found,
        })
    }

    /// One less this probability.
    pub(crate) fn contrary(&self) -> Self {
        Self::ONE.sub(self).at_least(0.0).at_most(1.0)
    }

    pub(crate) fn at_least(&self, value: f64) -> Self {
        Self {
            low: self.low.max(value),
            high: self.high.max(value),
        }
    }

    pub(crate) fn at_most(&self, value: f64) -> Self {
        Self {
            low: self.low.min(value),
            high: self.high.min(value),
        }
    }

    /// The greater, or the lesser, of the two.
    pub(crate) fn best(&self, other: &Self, maximise: bool) -> Self {
        let join = if maximise { f64::max } else { f64::min };
        Self {
            low: join(self.low, other.low),
            high: join(self.high, other.high),
        }
    }

    fn outwards(low: f64, high: f64) -> Self {
        let low = if low.is_nan() { f64::NEG_INFINITY } else { low };
        let high = if high.is_nan() { f64::INFINITY } else { high };
        Self {
            // Infinite values are what they are.
            low: if low == f64::INFINITY {
                low
            } else {
                low.next_down()
            },
            high: if high == f64::NEG_INFINITY {
                high
            } else {
                high.next_up()
            },
        }
    }
}
