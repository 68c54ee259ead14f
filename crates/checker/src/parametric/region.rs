//! Boxes of values of parameters, and the sign that a polynomial has on them.
//!
//! *Definition.* A region is the set of points strictly between a lower and an upper bound for each parameter. A
//! polynomial that is written in Bernstein's basis of the box has coefficients between whose least and greatest its
//! values lie; if none is negative and one is not 0, it is positive at every point of the region, since the basis is
//! (Garloff 1986, "Convergent Bounds for the Range of Multivariate Polynomials"). Cost: the product of the
//! degrees plus one, times the number of parameters and the greatest degree. Guarantee: exact; "not known" is an answer.

use std::fmt;

use num_bigint::BigInt;
use num_traits::{One, Zero};
use prism_lang::Rational;

use super::function::RationalFunction;
use super::monomial::MOST_PARAMETERS;
use super::polynomial::Polynomial;

/// Larger tables of coefficients are not made: the sign is not known then.
const MOST_COEFFICIENTS: usize = 100_000;

/// A range for each parameter of a model, in the model's order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Region {
    /// The least and the greatest value of each parameter; points of the region lie strictly between.
    pub ranges: Vec<(Rational, Rational)>,
}

/// The sign of a function on a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Positive at every point.
    Positive,
    /// Negative at every point.
    Negative,
    /// 0 at every point.
    Zero,
    /// Not known: different at different points, or close to it.
    Unknown,
}

impl Sign {
    fn times(self, other: Self) -> Self {
        match (self, other) {
            (Self::Zero, _) | (_, Self::Zero) => Self::Zero,
            (Self::Unknown, _) | (_, Self::Unknown) => Self::Unknown,
            _ if self == other => Self::Positive,
            _ => Self::Negative,
        }
    }

    fn of(value: &Rational) -> Self {
        match value.cmp(&Rational::zero()) {
            std::cmp::Ordering::Less => Self::Negative,
            std::cmp::Ordering::Equal => Self::Zero,
            std::cmp::Ordering::Greater => Self::Positive,
        }
    }
}

impl Region {
    /// All parameters between 0 and 1.
    pub fn unit(parameters: usize) -> Self {
        Self {
            ranges: vec![(Rational::zero(), Rational::one()); parameters],
        }
    }

    /// The point in the middle.
    pub fn centre(&self) -> Vec<Rational> {
        let two = Rational::from_integer(2.into());
        let middle = |(low, high): &(Rational, Rational)| (low + high) / &two;
        self.ranges.iter().map(middle).collect()
    }

    /// The size relative to that of another region, in which it lies.
    pub fn share_of(&self, whole: &Self) -> Rational {
        let pairs = self.ranges.iter().zip(&whole.ranges);
        pairs.fold(Rational::one(), |share, (part, all)| {
            share * (&part.1 - &part.0) / (&all.1 - &all.0)
        })
    }

    /// The two halves, cut where it is longest relative to `whole`.
    pub fn halves(&self, whole: &Self) -> [Self; 2] {
        let length = |p: &usize| {
            let ((low, high), (first, last)) = (&self.ranges[*p], &whole.ranges[*p]);
            (high - low) / (last - first)
        };
        let mut longest = 0;
        for parameter in 1..self.ranges.len() {
            if length(&parameter) > length(&longest) {
                longest = parameter;
            }
        }
        let mut halves = [self.clone(), self.clone()];
        if let Some(middle) = self.centre().get(longest) {
            halves[0].ranges[longest].1 = middle.clone();
            halves[1].ranges[longest].0 = middle.clone();
        }
        halves
    }

    /// The sign of a function, and with it that it has no pole.
    pub fn sign(&self, function: &RationalFunction) -> Sign {
        let Some(known) = &function.known else {
            return Sign::Unknown;
        };
        let mut sign = Sign::of(&known.coefficient);
        for (factor, exponent) in &known.product {
            let own = self.sign_of_polynomial(factor.polynomial());
            let power = match own {
                // A pole, or not known.
                Sign::Zero | Sign::Unknown => Sign::Unknown,
                _ if exponent % 2 == 0 => Sign::Positive,
                own => own,
            };
            sign = sign.times(power);
        }
        sign
    }

    pub(super) fn sign_of_polynomial(&self, polynomial: &Polynomial) -> Sign {
        let Some(coefficients) = self.bernstein(polynomial) else {
            return Sign::Unknown;
        };
        let zero = Rational::zero();
        let least = coefficients.iter().min().unwrap_or(&zero);
        let greatest = coefficients.iter().max().unwrap_or(&zero);
        match (Sign::of(least), Sign::of(greatest)) {
            (Sign::Zero, Sign::Zero) => Sign::Zero,
            (Sign::Zero | Sign::Positive, _) => Sign::Positive,
            (_, Sign::Zero | Sign::Negative) => Sign::Negative,
            _ => Sign::Unknown,
        }
    }

    /// The coefficients in Bernstein's basis; `None` if there are too many.
    fn bernstein(&self, polynomial: &Polynomial) -> Option<Vec<Rational>> {
        let occurs = |p: &usize| polynomial.degree_in(*p) > 0;
        let parameters: Vec<usize> = (0..MOST_PARAMETERS).filter(occurs).collect();
        let sizes = parameters.iter().map(|p| polynomial.degree_in(*p) + 1);
        let sizes: Vec<usize> = sizes.collect();
        let total = (sizes.iter()).try_fold(1usize, |all, size| all.checked_mul(*size))?;
        if total > MOST_COEFFICIENTS || parameters.iter().any(|p| *p >= self.ranges.len()) {
            return None;
        }
        let mut table = vec![Rational::zero(); total];
        for (monomial, value) in &polynomial.terms {
            let place = parameters.iter().zip(&sizes).fold(0, |place, (p, size)| {
                place * size + usize::from(monomial.exponent(*p))
            });
            table[place] = Rational::from_integer(value.clone());
        }
        let mut stride = total;
        for (parameter, size) in parameters.iter().zip(&sizes) {
            stride /= size;
            for start in (0..total).filter(|at| at / stride % size == 0) {
                let line = (0..*size).map(|k| table[start + k * stride].clone());
                let line = changed_basis(line.collect(), &self.ranges[*parameter]);
                for (k, value) in line.into_iter().enumerate() {
                    table[start + k * stride] = value;
                }
            }
        }
        Some(table)
    }
}

/// From powers of a parameter to Bernstein's basis over its range.
fn changed_basis(mut line: Vec<Rational>, (low, high): &(Rational, Rational)) -> Vec<Rational> {
    let degree = line.len() - 1;
    // a(low + t): repeated synthetic division.
    for first in 0..degree {
        for place in (first..degree).rev() {
            let carried = low * &line[place + 1];
            line[place] += carried;
        }
    }
    // a(low + width t), then over the binomials.
    let (width, mut power) = (high - low, Rational::one());
    for (k, value) in line.iter_mut().enumerate() {
        *value *= &power / Rational::from_integer(binomial(degree, k));
        power *= &width;
    }
    let of = |j: usize| {
        let terms = (0..=j).map(|i| Rational::from_integer(binomial(j, i)) * &line[i]);
        terms.fold(Rational::zero(), |sum, term| sum + term)
    };
    (0..=degree).map(of).collect()
}

fn binomial(n: usize, k: usize) -> BigInt {
    (0..k).fold(BigInt::one(), |value, i| value * (n - i) / (i + 1))
}

/// As PRISM writes it: `([0,1],[1/5,2/5])`.
impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let range = |(low, high): &(Rational, Rational)| format!("[{low},{high}]");
        let ranges: Vec<String> = self.ranges.iter().map(range).collect();
        write!(f, "({})", ranges.join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use prism_lang::Arithmetic;

    fn parameter(index: usize) -> RationalFunction {
        RationalFunction::parameter(index).unwrap()
    }

    #[test]
    fn signs_are_those_of_the_values() {
        let (x, y) = (parameter(0), parameter(1));
        let one = RationalFunction::one();
        let unit = Region::unit(2);
        assert_eq!(unit.sign(&x), Sign::Positive);
        assert_eq!(unit.sign(&one.sub(&x)), Sign::Positive);
        assert_eq!(unit.sign(&x.sub(&y)), Sign::Unknown);
        // (x - y)^2 is 0 on the diagonal.
        let difference = x.sub(&y);
        assert_eq!(
            unit.sign(&difference.mul(&difference).add(&x)),
            Sign::Positive
        );
        assert_eq!(unit.sign(&x.mul(&y).sub(&one)), Sign::Negative);
        let narrow = Region {
            ranges: vec![
                (
                    Rational::new(1.into(), 2.into()),
                    Rational::from_integer(1.into()),
                ),
                (
                    Rational::from_integer(0.into()),
                    Rational::new(1.into(), 2.into()),
                ),
            ],
        };
        assert_eq!(narrow.sign(&x.sub(&y)), Sign::Positive);
        assert_eq!(narrow.share_of(&unit), Rational::new(1.into(), 4.into()));
        assert_eq!(narrow.sign(&y.sub(&x).div(&x).unwrap()), Sign::Negative);
        assert_eq!(narrow.to_string(), "([1/2,1],[0,1/2])");
    }

    #[test]
    fn bernstein_coefficients_are_those_of_the_definition() {
        // 3 x^2 on (1, 3): b_0 = 3, b_1 = 9, b_2 = 27.
        let x = parameter(0);
        let (up, _) = x
            .mul(&x)
            .mul(&RationalFunction::from_i64(3))
            .quotient()
            .unwrap();
        let region = Region {
            ranges: vec![(
                Rational::from_integer(1.into()),
                Rational::from_integer(3.into()),
            )],
        };
        let expected = [3, 9, 27].map(|k| Rational::from_integer(k.into()));
        assert_eq!(region.bernstein(&up).unwrap(), expected);
    }
}
