//! Rational functions of a model's open constants.
//!
//! *Definition.* `c f_1^e_1 f_2^e_2 ...` with a rational number `c` and a product in which nothing can be cancelled
//! ([`super::factors`]); no function is written with common divisors, but one function may be written in several
//! ways (`(x-1)(x+1)` and `x^2-1`), so that equality is decided by subtraction. Cost: a product looks for common
//! divisors of factors of one side with those of the other; a sum expands what the two do not have in common.
//! Guarantee: exact. A function that would take too much memory becomes "too large", and stays it.

use std::cmp::Ordering;

use num_traits::{Pow, ToPrimitive};
use prism_lang::{Arithmetic, Number, Rational};

use super::factors::{Factor, Product, expanded, in_common, product_of, times};
use super::monomial::MOST_PARAMETERS;
use super::polynomial::Polynomial;

/// Exponents beyond this are given up.
const MOST_EXPONENT: i64 = 10_000;

/// A quotient of two polynomials in a model's parameters with integer coefficients, without common divisors.
#[derive(Clone, Debug)]
pub struct RationalFunction {
    /// `None`: too large.
    pub(super) known: Option<Factored>,
}

/// `coefficient` times a product of powers of polynomials.
#[derive(Clone, Debug)]
pub(super) struct Factored {
    /// 0 for the function 0, whose product is empty.
    pub coefficient: Rational,
    pub product: Product,
}

impl RationalFunction {
    pub(super) const TOO_LARGE: Self = Self { known: None };

    /// A function that is the same everywhere.
    pub fn constant(value: Rational) -> Self {
        Self::factored(value, Vec::new())
    }

    pub(super) fn factored(coefficient: Rational, product: Product) -> Self {
        let product = if coefficient.is_zero() {
            Vec::new()
        } else {
            product
        };
        Self {
            known: Some(Factored {
                coefficient,
                product,
            }),
        }
    }

    /// A polynomial over an integer.
    fn from_polynomial(polynomial: Polynomial, below: Rational) -> Self {
        if polynomial.is_zero() {
            return Self::constant(Rational::zero());
        }
        let content = Rational::from_integer(polynomial.content());
        Self::factored(content / below, product_of(polynomial.primitive()))
    }

    /// Whether computing it was given up because it takes too much memory.
    pub fn is_too_large(&self) -> bool {
        self.known.is_none()
    }

    /// The value, if it is the same everywhere.
    pub fn as_constant(&self) -> Option<&Rational> {
        let known = self.known.as_ref()?;
        known.product.is_empty().then_some(&known.coefficient)
    }

    /// Numerator and denominator, expanded, with integer coefficients; `None` if that is too large.
    pub(super) fn quotient(&self) -> Option<(Polynomial, Polynomial)> {
        let known = self.known.as_ref()?;
        let side = |sign: i32| -> Product {
            let part = known.product.iter().filter(|p| p.1 * sign > 0);
            part.map(|(f, e)| (f.clone(), e * sign)).collect()
        };
        let (up, down) = (expanded(&side(1))?, expanded(&side(-1))?);
        let coefficient = &known.coefficient;
        Some((
            up.scaled(coefficient.numer()),
            down.scaled(coefficient.denom()),
        ))
    }

    /// The value at a point; `None` where the denominator is 0 (or the function too large).
    ///
    /// # Panics
    /// Never; parameters without a value in `point` make it `None`.
    pub fn at(&self, point: &[Rational]) -> Option<Rational> {
        let known = self.known.as_ref()?;
        let mut value = known.coefficient.clone();
        for (factor, exponent) in &known.product {
            let polynomial = factor.polynomial();
            if polynomial.parameters() >> point.len().min(31) != 0 {
                return None;
            }
            let base = polynomial.at(point);
            if base.is_zero() && *exponent < 0 {
                return None;
            }
            value *= Pow::pow(base, *exponent);
        }
        Some(value)
    }

    /// The derivative by the parameter of this index: the product times the sum of `e_i f_i' / f_i`.
    pub fn derivative(&self, parameter: usize) -> Self {
        let Some(known) = &self.known else {
            return Self::TOO_LARGE;
        };
        let mut sum = Self::constant(Rational::zero());
        for (factor, exponent) in &known.product {
            let slope = factor.polynomial().derivative(parameter);
            if slope.is_zero() {
                continue;
            }
            let below = Self::factored(Rational::one(), vec![(factor.clone(), -1)]);
            let exponent = Rational::new(1.into(), (*exponent).into());
            sum = sum.add(&Self::from_polynomial(slope, exponent).mul(&below));
        }
        self.mul(&sum)
    }

    /// The parameters that occur.
    pub fn parameters(&self) -> Vec<usize> {
        let known = self.known.iter().flat_map(|k| &k.product);
        let set = known.fold(0, |set, (f, _)| set | f.polynomial().parameters());
        (0..MOST_PARAMETERS).filter(|p| set >> p & 1 == 1).collect()
    }

    /// The number of terms of all its factors: how large it is.
    pub fn size(&self) -> usize {
        let known = self.known.iter().flat_map(|k| &k.product);
        known.map(|(f, _)| f.polynomial().terms.len()).sum()
    }
}

impl PartialEq for RationalFunction {
    fn eq(&self, other: &Self) -> bool {
        self.partial_cmp(other) == Some(Ordering::Equal)
    }
}

/// Functions compare only where their difference is the same everywhere.
impl PartialOrd for RationalFunction {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        let (a, b) = (self.known.as_ref()?, other.known.as_ref()?);
        if a.product == b.product && a.coefficient == b.coefficient {
            return Some(Ordering::Equal);
        }
        if let (Some(a), Some(b)) = (self.as_constant(), other.as_constant()) {
            return Some(a.cmp(b));
        }
        if other.as_constant().is_some_and(Arithmetic::is_zero) {
            return None;
        }
        let difference = self.sub(other);
        difference.as_constant().map(|d| d.cmp(&Rational::zero()))
    }
}

impl Arithmetic for RationalFunction {
    const EXACT: bool = true;

    fn zero() -> Self {
        Self::constant(Rational::zero())
    }

    fn one() -> Self {
        Self::constant(Rational::one())
    }

    fn from_i64(value: i64) -> Self {
        Self::constant(Rational::from_integer(value.into()))
    }

    fn from_literal(number: &Number) -> Option<Self> {
        number.exact().cloned().map(Self::constant)
    }

    fn parameter(index: usize) -> Option<Self> {
        let factor = || Factor::new(Polynomial::parameter(index));
        (index < MOST_PARAMETERS).then(|| Self::factored(Rational::one(), vec![(factor(), 1)]))
    }

    fn to_f64(&self) -> f64 {
        self.as_constant()
            .map_or(f64::NAN, prism_lang::rational_to_f64)
    }

    fn add(&self, other: &Self) -> Self {
        self.sum(other).unwrap_or(Self::TOO_LARGE)
    }

    fn sub(&self, other: &Self) -> Self {
        let minus = Self::constant(-Rational::one());
        self.add(&other.mul(&minus))
    }

    fn mul(&self, other: &Self) -> Self {
        let (Some(a), Some(b)) = (&self.known, &other.known) else {
            return Self::TOO_LARGE;
        };
        let coefficient = &a.coefficient * &b.coefficient;
        if coefficient.is_zero() {
            return Self::zero();
        }
        let product = match (a.product.is_empty(), b.product.is_empty()) {
            (true, _) => Some(b.product.clone()),
            (_, true) => Some(a.product.clone()),
            _ => times(&a.product, &b.product),
        };
        product.map_or(Self::TOO_LARGE, |p| Self::factored(coefficient, p))
    }

    fn div(&self, other: &Self) -> Option<Self> {
        let Some(below) = &other.known else {
            return Some(Self::TOO_LARGE);
        };
        if below.coefficient.is_zero() {
            return None;
        }
        let turned = (below.product.iter().map(|(f, e)| (f.clone(), -e))).collect();
        Some(self.mul(&Self::factored(below.coefficient.recip(), turned)))
    }

    fn pow(&self, exponent: &Self) -> Option<Self> {
        let exponent = exponent.as_constant()?;
        let Some(known) = &self.known else {
            return Some(Self::TOO_LARGE);
        };
        let coefficient = Arithmetic::pow(&known.coefficient, exponent)?;
        let power = exponent.to_i64().filter(|e| e.abs() <= MOST_EXPONENT)?;
        if power == 0 {
            return Some(Self::one());
        }
        let raised = |(factor, e): &(Factor, i32)| {
            let exponent = e.checked_mul(power as i32)?;
            Some((factor.clone(), exponent))
        };
        let product = known.product.iter().map(raised).collect::<Option<_>>();
        Some(product.map_or(Self::TOO_LARGE, |p| Self::factored(coefficient, p)))
    }

    fn log(&self, _: &Self) -> Option<Self> {
        None
    }

    fn floor(&self) -> Option<i64> {
        Arithmetic::floor(self.as_constant()?)
    }

    fn is_zero(&self) -> bool {
        self.as_constant().is_some_and(Arithmetic::is_zero)
    }

    /// Of a function that is not the same everywhere, this depends on the point: see [`super::Conditions`].
    fn is_non_negative(&self) -> bool {
        (self.as_constant()).is_none_or(Arithmetic::is_non_negative)
    }
}

impl RationalFunction {
    fn sum(&self, other: &Self) -> Option<Self> {
        let (a, b) = (self.known.as_ref()?, other.known.as_ref()?);
        if a.coefficient.is_zero() {
            return Some(other.clone());
        }
        if b.coefficient.is_zero() {
            return Some(self.clone());
        }
        if a.product == b.product {
            let sum = &a.coefficient + &b.coefficient;
            return Some(Self::factored(sum, a.product.clone()));
        }
        let [common, left, right] = in_common(&a.product, &b.product);
        let (left, right) = (expanded(&left)?, expanded(&right)?);
        let (x, y) = (&a.coefficient, &b.coefficient);
        let sum = left.combined(&(x.numer() * y.denom()), &right, &(y.numer() * x.denom()));
        let below = Rational::from_integer(x.denom() * y.denom());
        let sum = Self::from_polynomial(sum, below);
        if sum.is_zero() {
            return Some(sum);
        }
        let new = sum.known?;
        Some(Self::factored(
            new.coefficient,
            times(&new.product, &common)?,
        ))
    }
}
