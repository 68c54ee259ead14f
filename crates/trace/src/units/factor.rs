//! Exact factors between units: rational numbers times a power of pi.

use std::f64::consts::PI;

/// A positive rational number, in lowest terms, times a power of pi.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Factor {
    numerator: u128,
    denominator: u128,
    pi_power: i8,
}

impl Factor {
    /// The factor that changes nothing.
    pub const ONE: Factor = Factor {
        numerator: 1,
        denominator: 1,
        pi_power: 0,
    };

    /// `numerator / denominator * pi^pi_power`; `None` if one of the two numbers is 0.
    #[must_use]
    pub fn new(numerator: u128, denominator: u128, pi_power: i8) -> Option<Self> {
        if numerator == 0 || denominator == 0 {
            return None;
        }
        let common = greatest_common_divisor(numerator, denominator);
        Some(Factor {
            numerator: numerator / common,
            denominator: denominator / common,
            pi_power,
        })
    }

    /// Numerator, denominator and power of pi.
    #[must_use]
    pub fn parts(self) -> (u128, u128, i8) {
        (self.numerator, self.denominator, self.pi_power)
    }

    /// The product; `None` if it is out of range.
    #[must_use]
    pub fn times(self, other: Factor) -> Option<Self> {
        // Reduced crosswise first, the products are in lowest terms and as small as can be.
        let left = Factor::new(self.numerator, other.denominator, 0)?;
        let right = Factor::new(other.numerator, self.denominator, 0)?;
        Some(Factor {
            numerator: left.numerator.checked_mul(right.numerator)?,
            denominator: left.denominator.checked_mul(right.denominator)?,
            pi_power: self.pi_power.checked_add(other.pi_power)?,
        })
    }

    /// One divided by this.
    fn inverse(self) -> Option<Self> {
        Some(Factor {
            numerator: self.denominator,
            denominator: self.numerator,
            pi_power: self.pi_power.checked_neg()?,
        })
    }

    /// The quotient; `None` if it is out of range.
    #[must_use]
    pub fn divided_by(self, other: Factor) -> Option<Self> {
        self.times(other.inverse()?)
    }

    /// The power `exponent`; `None` if it is out of range.
    #[must_use]
    pub fn power(self, exponent: i8) -> Option<Self> {
        let base = if exponent < 0 { self.inverse()? } else { self };
        let times = u32::from(exponent.unsigned_abs());
        Some(Factor {
            numerator: base.numerator.checked_pow(times)?,
            denominator: base.denominator.checked_pow(times)?,
            pi_power: self.pi_power.checked_mul(exponent)?,
        })
    }

    /// k if this is 10^k.
    pub(super) fn power_of_ten(self) -> Option<i32> {
        let exponent = |number: u128| {
            let exponent = number.checked_ilog10()?;
            (10_u128.checked_pow(exponent)? == number).then_some(exponent as i32)
        };
        match (self.numerator, self.denominator, self.pi_power) {
            (numerator, 1, 0) => exponent(numerator),
            (1, denominator, 0) => exponent(denominator).map(|it| -it),
            _ => None,
        }
    }

    /// This as something that can be applied to numbers.
    #[must_use]
    pub fn conversion(self) -> Conversion {
        Conversion {
            multiplier: self.numerator as f64 * PI.powi(i32::from(self.pi_power)),
            divisor: self.denominator as f64,
        }
    }
}

pub(super) fn greatest_common_divisor(mut left: u128, mut right: u128) -> u128 {
    while right != 0 {
        (left, right) = (right, left % right);
    }
    left
}

/// How numbers in one unit become numbers in another: times a multiplier, divided by a divisor.
///
/// Between units whose factor is a whole number or one divided by a whole number, as between m and
/// mm, the result is rounded once and so is the double nearest to the exact one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conversion {
    multiplier: f64,
    divisor: f64,
}

impl Conversion {
    /// That which changes nothing.
    pub const NONE: Conversion = Conversion {
        multiplier: 1.0,
        divisor: 1.0,
    };

    /// Whether numbers stay as they are.
    #[must_use]
    pub fn is_none(self) -> bool {
        self == Conversion::NONE
    }

    /// `value` in the other unit.
    #[must_use]
    pub fn apply(self, value: f64) -> f64 {
        value * self.multiplier / self.divisor
    }
}
