//! Intervals of floating-point numbers whose ends are rounded outwards, so that they contain what is computed.
//!
//! *Definition.* Each operation is done on the ends to nearest and moved to the next number outwards; operations with 0
//! and 1 are exact and not moved, and sums are moved only to the side of their rounding error, which is computed.
//! Source: Moore 1966, "Interval Analysis"; Knuth 1969, section 4.2.2 (the error of a sum). Guarantee: containment.

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
        Self {
            low: sum(self.low, other.low).0,
            high: sum(self.high, other.high).1,
        }
    }

    pub(crate) fn sub(&self, other: &Self) -> Self {
        if other.is(0.0) {
            return *self;
        }
        if self.low == self.high && self == other && self.low.is_finite() {
            return Self::ZERO;
        }
        Self {
            low: sum(self.low, -other.high).0,
            high: sum(self.high, -other.low).1,
        }
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

/// The numbers next to a sum, below and above, or the sum itself where it is exact.
fn sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    if a.is_finite() && b.is_finite() && sum.is_infinite() {
        // More than the greatest number, but not infinite.
        return match sum > 0.0 {
            true => (f64::MAX, sum),
            false => (sum, f64::MIN),
        };
    }
    if !sum.is_finite() {
        let around = Interval::outwards(sum, sum);
        return (around.low, around.high);
    }
    let of_b = sum - a;
    let error = (a - (sum - of_b)) + (b - of_b);
    match error {
        _ if error < 0.0 => (sum.next_down(), sum),
        _ if error > 0.0 => (sum, sum.next_up()),
        _ if error == 0.0 => (sum, sum),
        // Too large to tell.
        _ => (sum.next_down(), sum.next_up()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_contain_the_exact_one_and_are_it_where_it_is_a_number() {
        let exact = |x: f64| Rational::from_float(x).unwrap();
        for (a, b) in [
            (1.0, -1.0),
            (0.1, 0.2),
            (1.0, 1e-30),
            (1e300, -3.0),
            (0.3, -0.1),
            (5e-324, -1.0),
        ] {
            let (low, high) = sum(a, b);
            let whole = exact(a) + exact(b);
            assert!(exact(low) <= whole && whole <= exact(high), "{a} + {b}");
            assert!(high <= low.next_up(), "{a} + {b}");
            assert_eq!(low == high, exact(low) == whole, "{a} + {b}");
        }
        assert_eq!(sum(f64::MAX, f64::MAX).0, f64::MAX);
    }
}
