//! The number domains in which expressions are evaluated.

use std::fmt::Debug;

use num_traits::{One, Pow, Signed, ToPrimitive, Zero};

use crate::number::{Number, Rational};
use crate::rational;

/// Largest size, in bits, of numerator or denominator of a rational power.
const MAX_POWER_BITS: u64 = 1 << 24;
/// Beyond this size, in bits, a [`Number`] gives up exactness: a text must not be able to exhaust the memory.
const MAX_EXACT_BITS: u64 = 1 << 17;

/// The size of a rational, in bits.
fn bits(value: &Rational) -> u64 {
    value.numer().bits().max(value.denom().bits())
}

/// A number domain: `f64` (fast, rounded), [`Rational`] (exact), [`Number`] (exact where possible), or one of
/// another crate, such as rational functions of parameters.
pub trait Arithmetic: Clone + PartialOrd + Debug + Send + Sync + 'static {
    /// Whether results are exact.
    const EXACT: bool;

    /// The number 0.
    fn zero() -> Self;
    /// The number 1.
    fn one() -> Self;
    /// An integer; rounded to nearest beyond 2^53 in `f64`.
    fn from_i64(value: i64) -> Self;
    /// A number of the model; `None` if it is irrational and the domain exact.
    fn from_literal(number: &Number) -> Option<Self>;
    /// The parameter of this index (a constant that was left open); `None` in a domain without parameters.
    fn parameter(_index: usize) -> Option<Self> {
        None
    }
    /// The nearest `f64`.
    fn to_f64(&self) -> f64;
    /// Sum.
    fn add(&self, other: &Self) -> Self;
    /// Difference.
    fn sub(&self, other: &Self) -> Self;
    /// Product.
    fn mul(&self, other: &Self) -> Self;
    /// Quotient; `None` when dividing by zero.
    fn div(&self, other: &Self) -> Option<Self>;
    /// Power; `None` when it is not a real number or not representable in this domain.
    fn pow(&self, exponent: &Self) -> Option<Self>;
    /// Logarithm to a base; `None` when it is not a real number or not representable in this domain.
    fn log(&self, base: &Self) -> Option<Self>;
    /// Largest integer not above; `None` beyond 64 bits.
    fn floor(&self) -> Option<i64>;
    /// Whether this is 0.
    fn is_zero(&self) -> bool;
    /// Whether this is finite and not negative.
    fn is_non_negative(&self) -> bool;
}

impl Arithmetic for f64 {
    const EXACT: bool = false;

    fn zero() -> Self {
        0.0
    }
    fn one() -> Self {
        1.0
    }
    fn from_i64(value: i64) -> Self {
        value as f64
    }
    fn from_literal(number: &Number) -> Option<Self> {
        Some(number.to_f64())
    }
    fn to_f64(&self) -> f64 {
        *self
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
    fn div(&self, other: &Self) -> Option<Self> {
        (*other != 0.0).then(|| self / other)
    }
    fn pow(&self, exponent: &Self) -> Option<Self> {
        Some(self.powf(*exponent)).filter(|r| r.is_finite())
    }
    fn log(&self, base: &Self) -> Option<Self> {
        Some(self.ln() / base.ln()).filter(|r| r.is_finite())
    }
    fn floor(&self) -> Option<i64> {
        let floor = f64::floor(*self);
        // 2^63 itself is representable in f64 but not in i64.
        (floor >= -(2f64.powi(63)) && floor < 2f64.powi(63)).then_some(floor as i64)
    }
    fn is_zero(&self) -> bool {
        *self == 0.0
    }
    fn is_non_negative(&self) -> bool {
        self.is_finite() && *self >= 0.0
    }
}

impl Arithmetic for Rational {
    const EXACT: bool = true;

    fn zero() -> Self {
        Zero::zero()
    }
    fn one() -> Self {
        One::one()
    }
    fn from_i64(value: i64) -> Self {
        Rational::from_integer(value.into())
    }
    fn from_literal(number: &Number) -> Option<Self> {
        number.exact().cloned()
    }
    fn to_f64(&self) -> f64 {
        crate::number::rational_to_f64(self)
    }
    fn add(&self, other: &Self) -> Self {
        rational::sum(self, other)
    }
    fn sub(&self, other: &Self) -> Self {
        rational::difference(self, other)
    }
    fn mul(&self, other: &Self) -> Self {
        rational::product(self, other)
    }
    fn div(&self, other: &Self) -> Option<Self> {
        (!Zero::is_zero(other)).then(|| rational::quotient(self, other))
    }
    fn pow(&self, exponent: &Self) -> Option<Self> {
        if !exponent.is_integer() {
            return None;
        }
        let exponent = exponent.to_i64()?;
        let size = bits(self).checked_mul(exponent.unsigned_abs())?;
        if size > MAX_POWER_BITS || (exponent < 0 && Zero::is_zero(self)) {
            return None;
        }
        Some(Pow::pow(self, i32::try_from(exponent).ok()?))
    }
    fn log(&self, _base: &Self) -> Option<Self> {
        None
    }
    fn floor(&self) -> Option<i64> {
        Rational::floor(self).to_integer().to_i64()
    }
    fn is_zero(&self) -> bool {
        Zero::is_zero(self)
    }
    fn is_non_negative(&self) -> bool {
        !self.is_negative()
    }
}

/// Exact as long as possible: a result that is irrational continues as `f64`.
///
/// Guards and roundings are decided in this domain, so that every method explores the same states.
impl Arithmetic for Number {
    const EXACT: bool = false;

    fn zero() -> Self {
        Self::from_i64(0)
    }
    fn one() -> Self {
        Self::from_i64(1)
    }
    fn from_i64(value: i64) -> Self {
        Number::from_i64(value)
    }
    fn from_literal(number: &Number) -> Option<Self> {
        Some(number.clone())
    }
    fn to_f64(&self) -> f64 {
        Number::to_f64(self)
    }
    fn add(&self, other: &Self) -> Self {
        self.combine(
            other,
            |a, b| Some(Arithmetic::add(a, b)),
            |a, b| Some(a + b),
        )
        .unwrap_or_else(|| Self::from_approximate(f64::NAN))
    }
    fn sub(&self, other: &Self) -> Self {
        self.combine(
            other,
            |a, b| Some(Arithmetic::sub(a, b)),
            |a, b| Some(a - b),
        )
        .unwrap_or_else(|| Self::from_approximate(f64::NAN))
    }
    fn mul(&self, other: &Self) -> Self {
        self.combine(
            other,
            |a, b| Some(Arithmetic::mul(a, b)),
            |a, b| Some(a * b),
        )
        .unwrap_or_else(|| Self::from_approximate(f64::NAN))
    }
    fn div(&self, other: &Self) -> Option<Self> {
        if Arithmetic::is_zero(other) {
            return None;
        }
        self.combine(other, Arithmetic::div, |a, b| Some(a / b))
    }
    fn pow(&self, exponent: &Self) -> Option<Self> {
        self.combine(exponent, Arithmetic::pow, |a, b| Arithmetic::pow(&a, &b))
    }
    fn log(&self, base: &Self) -> Option<Self> {
        if let Some(exponent) = self.exact().zip(base.exact()).and_then(integer_logarithm) {
            return Some(Self::from_i64(exponent));
        }
        Arithmetic::log(&self.to_f64(), &base.to_f64()).map(Self::from_approximate)
    }
    fn floor(&self) -> Option<i64> {
        match self.exact() {
            Some(exact) => Arithmetic::floor(exact),
            None => Arithmetic::floor(&self.to_f64()),
        }
    }
    fn is_zero(&self) -> bool {
        match self.exact() {
            Some(exact) => Arithmetic::is_zero(exact),
            None => self.to_f64() == 0.0,
        }
    }
    fn is_non_negative(&self) -> bool {
        match self.exact() {
            Some(exact) => Arithmetic::is_non_negative(exact),
            None => Arithmetic::is_non_negative(&self.to_f64()),
        }
    }
}

impl Number {
    /// The exact operation where both are exact and it has an exact result, else the rounded one.
    fn combine(
        &self,
        other: &Self,
        exact: impl Fn(&Rational, &Rational) -> Option<Rational>,
        rounded: impl Fn(f64, f64) -> Option<f64>,
    ) -> Option<Self> {
        if let (Some(a), Some(b)) = (self.exact(), other.exact())
            && bits(a).max(bits(b)) <= MAX_EXACT_BITS
            && let Some(result) = exact(a, b)
        {
            return Some(Self::from_rational(result));
        }
        rounded(self.to_f64(), other.to_f64()).map(Self::from_approximate)
    }
}

/// The integer `k >= 0` with `base^k = value`, if there is one: `ceil(log(1000, 10))` must be 3, not 2.99...
fn integer_logarithm((value, base): (&Rational, &Rational)) -> Option<i64> {
    let one = <Rational as One>::one();
    if !value.is_integer() || !base.is_integer() || *base <= one || *value < one {
        return None;
    }
    let (mut power, mut exponent) = (one, 0);
    while power < *value {
        power *= base;
        exponent += 1;
    }
    (power == *value).then_some(exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stay_exact_while_they_are_rational() {
        let tenth = Number::parse("0.1").unwrap();
        let three = Number::from_i64(3);
        let product = Arithmetic::mul(&tenth, &three);
        assert_eq!(product, Number::parse("0.3").unwrap());
        assert_ne!(0.1 * 3.0, 0.3);
        let root = Arithmetic::pow(&Number::from_i64(2), &Number::parse("0.5").unwrap()).unwrap();
        assert_eq!(root.exact(), None);
        assert_eq!(root.to_f64(), 2f64.sqrt());
    }

    #[test]
    fn logarithms_of_powers_are_integers() {
        let log = |x, b| Arithmetic::log(&Number::from_i64(x), &Number::from_i64(b)).unwrap();
        assert_eq!(log(1000, 10), Number::from_i64(3));
        assert_eq!(log(1, 2), Number::from_i64(0));
        assert_eq!(log(7, 2).to_f64(), 7f64.ln() / 2f64.ln());
        assert!(Arithmetic::log(&Number::from_i64(-1), &Number::from_i64(2)).is_none());
    }

    #[test]
    fn huge_powers_give_up_exactness_and_not_memory() {
        let mut number = Number::parse("1.0000001").unwrap();
        for _ in 0..40 {
            number = Arithmetic::mul(&number, &number);
        }
        assert_eq!(number.exact(), None);
        let base = Number::parse("0.999").unwrap();
        let power = Arithmetic::pow(&base, &Number::from_i64(100_000_000)).unwrap();
        assert_eq!((power.exact(), power.to_f64()), (None, 0.0));
    }

    #[test]
    fn undefined_results_are_none_in_every_domain() {
        assert_eq!(Arithmetic::div(&1.0, &0.0), None);
        let zero = <Rational as Arithmetic>::zero();
        assert_eq!(
            Arithmetic::div(&<Rational as Arithmetic>::one(), &zero),
            None
        );
        assert_eq!(Arithmetic::pow(&zero, &Rational::from_i64(-1)), None);
        assert_eq!(Arithmetic::pow(&-2.0, &0.5), None);
        assert_eq!(Arithmetic::floor(&1e300), None);
        assert_eq!(Arithmetic::floor(&-0.5), Some(-1));
    }
}
