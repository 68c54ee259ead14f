//! Rational functions made ready to be evaluated at many points.
//!
//! *Definition.* Each factor is a polynomial in Horner's form: by powers of its first parameter, the coefficients
//! likewise by the next. In floating point the value comes with a bound: every operation on a number `x` known to within
//! `e` adds its rounding `u |x|`, and errors are propagated to first order with their products (running error analysis;
//! Higham 2002, "Accuracy and Stability of Numerical Algorithms", section 3.3), all computed upwards. Cost: one
//! multiplication and one addition for each coefficient. Guarantee: the bounds contain the exact value at the point.

use prism_lang::{Rational, rational_to_f64};

use super::function::RationalFunction;
use super::monomial::MOST_PARAMETERS;
use super::polynomial::Polynomial;
use crate::rounding::Bounds;

/// The unit roundoff, with room for the bounds' own roundings.
const UNIT: f64 = 1.2e-16;

/// A function that is evaluated fast.
#[derive(Clone, Debug)]
pub struct Compiled {
    coefficient: Rough,
    factors: Vec<(Horner, i32)>,
}

/// `sum c_k x^k`, lowest first, or a number.
#[derive(Clone, Debug)]
enum Horner {
    Number(Rough),
    Powers(usize, Vec<Horner>),
}

/// A number known to within an absolute error.
#[derive(Clone, Copy, Debug)]
struct Rough {
    value: f64,
    error: f64,
}

impl Rough {
    const ZERO: Self = Self {
        value: 0.0,
        error: 0.0,
    };

    fn literal(exact: &Rational) -> Self {
        let value = rational_to_f64(exact);
        let is_exact = Rational::from_float(value).as_ref() == Some(exact);
        let error = if is_exact { 0.0 } else { value.abs() * UNIT };
        Self { value, error }.checked()
    }

    fn plus(self, other: Self) -> Self {
        let value = self.value + other.value;
        let error = (self.error + other.error + value.abs() * UNIT) * (1.0 + 4.0 * UNIT);
        Self { value, error }
    }

    fn times(self, other: Self) -> Self {
        let value = self.value * other.value;
        let parts = self.value.abs() * other.error
            + self.error * other.value.abs()
            + self.error * other.error;
        let error = (parts + value.abs() * UNIT) * (1.0 + 8.0 * UNIT) + f64::MIN_POSITIVE;
        Self { value, error }
    }

    /// One over it; not a number if it may be 0.
    fn inverse(self) -> Self {
        let value = 1.0 / self.value;
        let least = self.value.abs() - self.error;
        let error = match least > 0.0 {
            true => (self.error / least * value.abs() + value.abs() * UNIT) * (1.0 + 8.0 * UNIT),
            false => f64::INFINITY,
        };
        Self { value, error }
    }

    fn checked(self) -> Self {
        match self.value.is_finite() {
            true => self,
            false => Self {
                value: 0.0,
                error: f64::INFINITY,
            },
        }
    }
}

impl RationalFunction {
    /// Makes it ready to be evaluated at many points; `None` if it is too large.
    pub fn compiled(&self) -> Option<Compiled> {
        let known = self.known.as_ref()?;
        let factor = |(factor, exponent): &(super::factors::Factor, i32)| {
            (Horner::new(factor.polynomial(), 0), *exponent)
        };
        Some(Compiled {
            coefficient: Rough::literal(&known.coefficient),
            factors: known.product.iter().map(factor).collect(),
        })
    }
}

impl Compiled {
    /// The value at a point (one number for each parameter), between bounds; they are infinite where the function may
    /// have a pole, or a number exceeds floating point.
    ///
    /// ```
    /// use checker::parametric::RationalFunction;
    /// use prism_lang::Arithmetic;
    /// let p = RationalFunction::parameter(0).unwrap();
    /// let odds = p.div(&RationalFunction::one().sub(&p)).unwrap().compiled().unwrap();
    /// let bounds = odds.at(&[0.75]);
    /// assert!(bounds.low <= 3.0 && 3.0 <= bounds.high && bounds.high - bounds.low < 1e-13);
    /// assert_eq!(odds.at(&[1.0]).high, f64::INFINITY);
    /// ```
    pub fn at(&self, point: &[f64]) -> Bounds {
        let mut product = self.coefficient;
        for (factor, exponent) in &self.factors {
            let base = factor.at(point);
            let base = if *exponent < 0 { base.inverse() } else { base };
            for _ in 0..exponent.unsigned_abs() {
                product = product.times(base);
            }
        }
        let (low, high) = (product.value - product.error, product.value + product.error);
        match low.is_finite() && high.is_finite() {
            true if product.error == 0.0 => Bounds::exactly(product.value),
            true => Bounds {
                low: low.next_down(),
                high: high.next_up(),
            },
            false => Bounds {
                low: f64::NEG_INFINITY,
                high: f64::INFINITY,
            },
        }
    }
}

impl Horner {
    fn new(polynomial: &Polynomial, from: usize) -> Self {
        let occurs = |p: &usize| polynomial.degree_in(*p) > 0;
        match (from..MOST_PARAMETERS).find(occurs) {
            None => {
                let value = Rational::from_integer(polynomial.as_constant().unwrap_or_default());
                Self::Number(Rough::literal(&value))
            }
            Some(parameter) => {
                let coefficients = polynomial.coefficients(parameter);
                let parts = coefficients.iter().map(|c| Self::new(c, parameter + 1));
                Self::Powers(parameter, parts.collect())
            }
        }
    }

    fn at(&self, point: &[f64]) -> Rough {
        match self {
            Self::Number(number) => *number,
            Self::Powers(parameter, parts) => {
                let x = Rough {
                    value: point.get(*parameter).copied().unwrap_or(f64::NAN),
                    error: 0.0,
                };
                let last_first = parts.iter().rev();
                last_first.fold(Rough::ZERO, |sum, part| sum.times(x).plus(part.at(point)))
            }
        }
    }
}
