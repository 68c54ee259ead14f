//! Bounds on probabilities that hold in spite of rounding.
//!
//! All formulas here add, multiply and divide numbers that are not negative, and never subtract.
//! Then relative errors only add up: with `u = 2^-53`, a result of `m` operations on operands of
//! relative error at most `e` has a relative error below `e + m u` to first order. The exact factor
//! is between `(1 - u)^m` and `(1 + u)^m`; [`Bounds::widened`] covers the higher orders by taking
//! twice the first-order term.
//!
//! *Underflow.* The relative bound needs results in the normal range. Probabilities below
//! [`SMALLEST_VALUE`] are reported as between 0 and that number, and models with transition
//! probabilities below [`SMALLEST_ENTRY`] are refused.
//!
//! *Entries.* Transition probabilities of the model are themselves rounded;
//! [`crate::state_space::StateSpace::relative_error`] says by how much at most. One rounding is always
//! allowed for, since the rows of a matrix of floating-point numbers hardly ever sum to 1 exactly.
//!
//! Source: Higham 2002, sections 3.1 and 3.4; the bounds for linear systems are in the files that use them.

/// Half the distance from 1 to the next number: the largest relative error of one operation.
pub const UNIT: f64 = f64::EPSILON / 2.0;

/// Least relative error of transition probabilities that is allowed for.
pub const LEAST_ENTRY_ERROR: f64 = 2.0 * UNIT;

/// Values below this are only known to be below it.
pub const SMALLEST_VALUE: f64 = 1e-150;

/// Smallest transition probability for which floating point is used.
pub const SMALLEST_ENTRY: f64 = 1e-150;

/// A bound of the relative error that this many roundings leave; infinite if their number is not known.
pub fn error_of_roundings(roundings: Option<u32>) -> f64 {
    match roundings {
        None => f64::INFINITY,
        Some(0) => 0.0,
        Some(n) => {
            let nu = f64::from(n) * UNIT;
            (nu / (1.0 - nu)).next_up().next_up()
        }
    }
}

/// An interval that contains a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// At most the number.
    pub low: f64,
    /// At least the number.
    pub high: f64,
}

impl Bounds {
    /// Exactly 0.
    pub const ZERO: Self = Self::exactly(0.0);
    /// Exactly 1.
    pub const ONE: Self = Self::exactly(1.0);

    /// A number known exactly.
    pub const fn exactly(value: f64) -> Self {
        Self {
            low: value,
            high: value,
        }
    }

    /// Exactly 1 if `holds`, else exactly 0.
    pub const fn indicator(holds: bool) -> Self {
        if holds { Self::ONE } else { Self::ZERO }
    }

    /// Whether the number is known exactly.
    pub fn is_exact(&self) -> bool {
        self.low == self.high
    }

    /// Whether `value` lies between the bounds.
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// The number in the middle.
    pub fn middle(&self) -> f64 {
        if self.is_exact() {
            self.low
        } else if self.low.is_nan() || self.high.is_nan() {
            f64::NAN
        } else {
            (self.low + (self.high - self.low) / 2.0).clamp(self.low, self.high)
        }
    }

    /// Distance of the bounds relative to the lower one; infinite if that is 0 and the upper is not.
    pub fn relative_width(&self) -> f64 {
        if self.is_exact() {
            0.0
        } else {
            (self.high - self.low) / self.low
        }
    }

    /// Bounds of a positive probability, from bounds that were computed with a relative error of at
    /// most `relative_error` (to first order; twice that is allowed for).
    #[must_use]
    pub fn widened(self, relative_error: f64) -> Self {
        // Twice the first-order term covers the higher orders only up to here; also not a number ends here.
        if relative_error.is_nan() || relative_error > 1.0 {
            return Self {
                low: 0.0,
                high: 1.0,
            };
        }
        let margin = 2.0 * relative_error + 4.0 * UNIT;
        let low = (self.low * (1.0 - margin)).next_down();
        let high = (self.high.max(SMALLEST_VALUE) * (1.0 + margin)).next_up();
        Self {
            low: if low < SMALLEST_VALUE {
                0.0
            } else {
                low.min(1.0)
            },
            high: high.min(1.0),
        }
    }

    /// Bounds of a probability and of its complement, each improved by the other.
    #[must_use]
    pub fn with_complement(self, complement: Self) -> (Self, Self) {
        if self == Self::ZERO || complement == Self::ONE {
            return (Self::ZERO, Self::ONE);
        }
        if self == Self::ONE || complement == Self::ZERO {
            return (Self::ONE, Self::ZERO);
        }
        let improved = |one: Self, other: Self| Self {
            low: one.low.max((1.0 - other.high).next_down()),
            high: one.high.min((1.0 - other.low).next_up()),
        };
        (improved(self, complement), improved(complement, self))
    }
}

/// By how much the upper bounds exceed the lower ones, relatively, at most; infinite if one is 0 and its upper bound not.
///
/// What is monotone and homogeneous of degree 1 in numbers that are not negative can be computed from the lower bounds alone:
/// the upper results exceed the lower ones by no more.
pub(crate) fn spread<'a>(mut all: impl Iterator<Item = &'a Bounds>) -> f64 {
    all.try_fold(0.0_f64, |spread, bounds| match bounds.is_exact() {
        true => Some(spread),
        false if bounds.low > 0.0 => Some(spread.max(bounds.relative_width())),
        false => None,
    })
    .map_or(f64::INFINITY, |spread| spread * (1.0 + 4.0 * UNIT))
}

/// Spreads up to here hardly widen what is computed from lower bounds alone.
pub(crate) const SMALL_SPREAD: f64 = 1e-12;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widening_covers_the_error_and_stays_a_probability() {
        let bounds = Bounds::exactly(0.5).widened(1e-10);
        assert!(bounds.low <= 0.5 * (1.0 - 1e-10) && bounds.high >= 0.5 * (1.0 + 1e-10));
        assert!(bounds.relative_width() < 5e-10);
        assert_eq!(Bounds::ONE.widened(1e-10).high, 1.0);
        let tiny = Bounds::exactly(1e-200).widened(1e-10);
        assert!(tiny.low == 0.0 && tiny.high >= 1e-200);
    }

    #[test]
    fn the_spread_covers_all_bounds() {
        let near = Bounds {
            low: 3.0,
            high: 3.0 * (1.0 + 1e-13),
        };
        let all = [Bounds::ZERO, Bounds::ONE, near];
        let spread = spread(all.iter());
        assert!(near.high <= near.low * (1.0 + spread) && spread < 1.01e-13);
        let open = Bounds {
            low: 0.0,
            high: 1e-300,
        };
        assert_eq!(super::spread([near, open].iter()), f64::INFINITY);
    }

    #[test]
    fn complements_improve_each_other() {
        let rough = Bounds {
            low: 0.9,
            high: 1.0,
        };
        let tiny = Bounds {
            low: 1e-53,
            high: 2e-53,
        };
        let (value, complement) = rough.with_complement(tiny);
        assert!(value.low >= 1.0 - 2.0 * f64::EPSILON && value.contains(1.0));
        assert_eq!(complement, tiny);
    }
}
