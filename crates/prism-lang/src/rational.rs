//! Sums, products and quotients of rationals in lowest terms.
//!
//! *Definition.* The numbers are kept in lowest terms, so all that an operation has to find is what its operands have in
//! common: for a sum the divisor `g` of both denominators, and that of `g` and the new numerator; for a product those of each
//! numerator and the other denominator.
//!
//! Source: Knuth, The Art of Computer Programming 2, section 4.5.1. Why not the operators of `num-rational`: they take
//! divisors of numbers as long as the result, and by a binary method that shifts and subtracts whole numbers bit by bit; in
//! exact solving nearly all of the time went there. Guarantee: exact; the same numbers as the operators give, in lowest
//! terms, with a positive denominator.

use num_bigint::{BigInt, BigUint};
use num_traits::{One, Signed, Zero};

use crate::gcd::gcd;
use crate::number::Rational;

pub(crate) fn sum(a: &Rational, b: &Rational) -> Rational {
    added(a, b, |left, right| left + right)
}

pub(crate) fn difference(a: &Rational, b: &Rational) -> Rational {
    added(a, b, |left, right| left - right)
}

fn added(a: &Rational, b: &Rational, join: impl Fn(BigInt, BigInt) -> BigInt) -> Rational {
    let common = gcd(a.denom().magnitude(), b.denom().magnitude());
    if common.is_one() {
        let numerator = join(a.numer() * b.denom(), b.numer() * a.denom());
        return Rational::new_raw(numerator, a.denom() * b.denom());
    }
    let common = BigInt::from(common);
    let (left, right) = (a.denom() / &common, b.denom() / &common);
    let numerator = join(a.numer() * &right, b.numer() * &left);
    if numerator.is_zero() {
        return Rational::zero();
    }
    let rest = gcd(numerator.magnitude(), common.magnitude());
    Rational::new_raw(without(&numerator, &rest), left * without(b.denom(), &rest))
}

pub(crate) fn product(a: &Rational, b: &Rational) -> Rational {
    multiplied(a.numer(), a.denom(), b.numer(), b.denom())
}

/// The quotient by a number other than 0.
pub(crate) fn quotient(a: &Rational, b: &Rational) -> Rational {
    let found = multiplied(a.numer(), a.denom(), b.denom(), &b.numer().abs());
    if b.is_negative() { -found } else { found }
}

/// `a / b * c / d` of positive denominators.
fn multiplied(a: &BigInt, b: &BigInt, c: &BigInt, d: &BigInt) -> Rational {
    if a.is_zero() || c.is_zero() {
        return Rational::zero();
    }
    let (outer, inner) = (
        gcd(a.magnitude(), d.magnitude()),
        gcd(c.magnitude(), b.magnitude()),
    );
    Rational::new_raw(
        without(a, &outer) * without(c, &inner),
        without(b, &inner) * without(d, &outer),
    )
}

/// A number without a divisor of it.
fn without(number: &BigInt, divisor: &BigUint) -> BigInt {
    if divisor.is_one() {
        return number.clone();
    }
    number / BigInt::from(divisor.clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::collection::vec;
    use proptest::prelude::*;

    /// Numbers of up to some 500 bits whose parts often have divisors in common.
    fn number() -> impl Strategy<Value = Rational> {
        let part = || vec(0u32..8, 0..7);
        let size = vec(any::<u32>(), 0..16);
        (part(), part(), size, any::<bool>()).prop_map(|(above, below, size, negative)| {
            let power = |of: &[u32]| {
                let primes = [2u32, 3, 5, 7, 11, 65_537, 4_294_967_291];
                let raised = of.iter().zip(primes).map(|(e, p)| BigInt::from(p).pow(*e));
                raised.fold(BigInt::one(), |a, b| a * b)
            };
            let numerator = power(&above) * BigInt::from(BigUint::new(size));
            let found = Rational::new(numerator, power(&below));
            if negative { -found } else { found }
        })
    }

    proptest! {
        #[test]
        fn operations_are_those_of_the_library(a in number(), b in number()) {
            for (ours, theirs) in [
                (sum(&a, &b), &a + &b),
                (difference(&a, &b), &a - &b),
                (product(&a, &b), &a * &b),
            ] {
                // Parts, not values: lowest terms and signs have to be the same.
                prop_assert_eq!(ours.into_raw(), theirs.into_raw());
            }
            if !b.is_zero() {
                prop_assert_eq!(quotient(&a, &b).into_raw(), (&a / &b).into_raw());
            }
        }
    }
}
