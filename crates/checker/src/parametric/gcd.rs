//! Greatest common divisors of polynomials.
//!
//! *Method.* First modulo a prime: for each parameter, all others are set to fixed numbers, and the greatest
//! common divisor of the two images is found by Euclid's algorithm. Where a leading coefficient does not vanish,
//! its degree bounds that of the true one in this parameter from above (Brown 1971, "On Euclid's Algorithm and
//! the Computation of Polynomial Greatest Common Divisors"), so degree 0 everywhere *proves* that there is no common
//! divisor, which is the usual case. Then division is tried; what is left is done by primitive remainder sequences in
//! one parameter, with contents found recursively (Knuth, The Art of Computer Programming, volume 2, section 4.6.1).
//!
//! Cost: the images are kept with each factor; a test is quadratic in the degrees. Guarantee: exact.

use num_traits::{One, ToPrimitive};

use super::monomial::MOST_PARAMETERS;
use super::polynomial::Polynomial;

/// A prime (Mersenne's ninth).
const PRIME: u64 = (1 << 61) - 1;

/// A polynomial in one parameter modulo [`PRIME`], lowest power first, without leading zeros.
type Image = Vec<u64>;

/// A polynomial's images, one for each parameter that occurs.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Images {
    parameters: u32,
    images: Vec<(usize, usize, Image)>,
}

impl Images {
    pub fn new(of: &Polynomial) -> Self {
        let parameters = of.parameters();
        let occurs = |p: &usize| parameters >> p & 1 == 1;
        let image = |p: usize| (p, of.degree_in(p), image(of, p));
        Self {
            parameters,
            images: (0..MOST_PARAMETERS).filter(occurs).map(image).collect(),
        }
    }

    /// An upper bound, for each parameter, of the degree of a common divisor.
    fn bounds(&self, other: &Self) -> [usize; MOST_PARAMETERS] {
        let mut bounds = [0; MOST_PARAMETERS];
        for (parameter, degree, image) in &self.images {
            let found = other.images.iter().find(|i| i.0 == *parameter);
            let Some((_, other_degree, other_image)) = found else {
                continue;
            };
            let leading_kept = image.len() == degree + 1 || other_image.len() == other_degree + 1;
            bounds[*parameter] = match leading_kept {
                true => euclid(image.clone(), other_image.clone()).saturating_sub(1),
                false => *degree.min(other_degree),
            };
        }
        bounds
    }

    /// Whether it is certain that there is no common divisor.
    pub fn are_coprime(&self, other: &Self) -> bool {
        self.parameters & other.parameters == 0
            || self.bounds(other).iter().all(|degree| *degree == 0)
    }
}

fn multiply(a: u64, b: u64) -> u64 {
    (u128::from(a) * u128::from(b) % u128::from(PRIME)) as u64
}

fn power(mut base: u64, mut exponent: u64) -> u64 {
    let mut result = 1;
    while exponent > 0 {
        if exponent & 1 == 1 {
            result = multiply(result, base);
        }
        base = multiply(base, base);
        exponent >>= 1;
    }
    result
}

/// The number that a parameter is set to: fixed, and without structure.
fn number(parameter: usize) -> u64 {
    let mut x = (parameter as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    (x ^ x >> 31) % PRIME
}

fn image(of: &Polynomial, kept: usize) -> Image {
    let mut image = vec![0; of.degree_in(kept) + 1];
    let prime = num_bigint::BigInt::from(PRIME);
    for (monomial, value) in &of.terms {
        let mut residue = value % &prime;
        if num_traits::Signed::is_negative(&residue) {
            residue += &prime;
        }
        // A residue is less than 2^61.
        let mut product = residue.to_u64().unwrap_or(0);
        for parameter in (0..MOST_PARAMETERS).filter(|p| *p != kept) {
            let exponent = monomial.exponent(parameter);
            if exponent > 0 {
                product = multiply(product, power(number(parameter), u64::from(exponent)));
            }
        }
        let place = &mut image[usize::from(monomial.exponent(kept))];
        *place = (*place + product) % PRIME;
    }
    trim(&mut image);
    image
}

fn trim(image: &mut Image) {
    while image.last() == Some(&0) {
        image.pop();
    }
}

/// The number of coefficients of the greatest common divisor.
fn euclid(mut a: Image, mut b: Image) -> usize {
    while let Some(leading) = b.last() {
        let inverse = power(*leading, PRIME - 2);
        while a.len() >= b.len() {
            let shift = a.len() - b.len();
            let factor = multiply(a[a.len() - 1], inverse);
            for (place, value) in a[shift..].iter_mut().zip(&b) {
                *place = (*place + PRIME - multiply(factor, *value)) % PRIME;
            }
            trim(&mut a);
        }
        std::mem::swap(&mut a, &mut b);
    }
    a.len()
}

/// The greatest common divisor of two polynomials, primitive; `None` if it takes numbers that are too large.
pub(super) fn gcd(a: &Polynomial, b: &Polynomial) -> Option<Polynomial> {
    if a.is_zero() || b.is_zero() {
        let other = if a.is_zero() { b } else { a };
        return Some(other.clone().primitive());
    }
    let monomial = a.monomial().common(b.monomial());
    let strip = |p: &Polynomial| p.clone().without_monomial(p.monomial()).primitive();
    let found = without_monomials(strip(a), strip(b))?;
    let shift = Polynomial::term(monomial, num_bigint::BigInt::one());
    found.times(&shift)
}

fn without_monomials(a: Polynomial, b: Polynomial) -> Option<Polynomial> {
    if a == b {
        return Some(a);
    }
    if a.parameters() & b.parameters() == 0 {
        return Some(Polynomial::one());
    }
    let bounds = Images::new(&a).bounds(&Images::new(&b));
    if bounds.iter().all(|degree| *degree == 0) {
        return Some(Polynomial::one());
    }
    let all = a.parameters() | b.parameters();
    let absent = |p: &usize| all >> p & 1 == 1 && bounds[*p] == 0;
    if let Some(parameter) = (0..MOST_PARAMETERS).find(absent) {
        // It does not occur in the divisor, which therefore divides all coefficients.
        return gcd(&content(&a, parameter)?, &content(&b, parameter)?);
    }
    for (small, large) in [(&b, &a), (&a, &b)] {
        if large.over(small).is_some() {
            return Some(small.clone());
        }
    }
    let degree = |p: &usize| a.degree_in(*p).min(b.degree_in(*p));
    let common = (0..MOST_PARAMETERS).filter(|p| bounds[*p] > 0);
    let main = common.min_by_key(degree)?;
    remainders(a, b, main)
}

/// The greatest common divisor of the coefficients of the powers of a parameter.
fn content(of: &Polynomial, parameter: usize) -> Option<Polynomial> {
    let mut coefficients = of.coefficients(parameter);
    coefficients.retain(|c| !c.is_zero());
    coefficients.sort_by_key(|c| c.terms.len());
    let mut content = Polynomial::default();
    for coefficient in &coefficients {
        content = gcd(&content, coefficient)?;
        if content.is_one() {
            break;
        }
    }
    Some(content)
}

/// By a primitive remainder sequence in one parameter.
fn remainders(a: Polynomial, b: Polynomial, main: usize) -> Option<Polynomial> {
    let (a_content, b_content) = (content(&a, main)?, content(&b, main)?);
    let common = gcd(&a_content, &b_content)?;
    let (mut a, mut b) = (a.over(&a_content)?, b.over(&b_content)?);
    if a.degree_in(main) < b.degree_in(main) {
        std::mem::swap(&mut a, &mut b);
    }
    loop {
        let rest = pseudo_remainder(&a, &b, main)?;
        if rest.is_zero() {
            return common.times(&b).map(Polynomial::primitive);
        }
        if rest.degree_in(main) == 0 {
            return Some(common.primitive());
        }
        let rest_content = content(&rest, main)?;
        (a, b) = (b, rest.over(&rest_content)?.primitive());
    }
}

/// The remainder of a power of the divisor's leading coefficient times `a`.
fn pseudo_remainder(a: &Polynomial, divisor: &Polynomial, main: usize) -> Option<Polynomial> {
    let one = num_bigint::BigInt::one();
    let degree = divisor.degree_in(main);
    let leading = divisor.coefficients(main).pop()?;
    let mut rest = a.clone();
    while !rest.is_zero() && rest.degree_in(main) >= degree {
        let shift = (rest.degree_in(main) - degree) as u16;
        let top = rest.coefficients(main).pop()?;
        let power = super::monomial::Monomial::power(main, shift);
        let shifted = top.times(&Polynomial::term(power, one.clone()))?;
        let (kept, taken) = (rest.times(&leading)?, divisor.times(&shifted)?);
        rest = kept.combined(&one, &taken, &-one.clone());
    }
    Some(rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_bigint::BigInt;
    use proptest::prelude::*;

    fn polynomial(terms: &[(u16, u16, u16, i64)]) -> Polynomial {
        let one = BigInt::one();
        terms
            .iter()
            .fold(Polynomial::default(), |sum, (i, j, k, c)| {
                use crate::parametric::monomial::Monomial;
                let monomial = Monomial::power(0, *i)
                    .times(Monomial::power(1, *j))
                    .times(Monomial::power(2, *k));
                sum.combined(&one, &Polynomial::term(monomial, BigInt::from(*c)), &one)
            })
    }

    #[test]
    fn coprime_polynomials_are_told_from_others() {
        let images = |terms: &[(u16, u16, u16, i64)]| Images::new(&polynomial(terms));
        // x + y, x^2 - y^2, x - 2 y
        let (a, b) = (
            images(&[(1, 0, 0, 1), (0, 1, 0, 1)]),
            images(&[(2, 0, 0, 1), (0, 2, 0, -1)]),
        );
        let c = images(&[(1, 0, 0, 1), (0, 1, 0, -2)]);
        assert!(!a.are_coprime(&b) && a.are_coprime(&c) && b.are_coprime(&c));
    }

    proptest! {
        #[test]
        fn a_common_factor_is_found(
            common in prop::collection::vec((0u16..3, 0u16..3, 0u16..2, -4i64..5), 1..4),
            left in prop::collection::vec((0u16..3, 0u16..3, 0u16..2, -4i64..5), 1..4),
            right in prop::collection::vec((0u16..3, 0u16..2, 0u16..3, -4i64..5), 1..4),
        ) {
            let [common, left, right] = [common, left, right].map(|t| polynomial(&t));
            prop_assume!(!common.is_zero() && !left.is_zero() && !right.is_zero());
            let (a, b) = (common.times(&left).unwrap(), common.times(&right).unwrap());
            let found = gcd(&a, &b).unwrap();
            prop_assert!(a.over(&found).is_some() && b.over(&found).is_some());
            prop_assert!(found.over(&common.primitive()).is_some());
            // Nothing is left in common.
            let rest = gcd(&a.over(&found).unwrap(), &b.over(&found).unwrap()).unwrap();
            prop_assert!(rest.is_one(), "{rest:?}");
        }
    }
}
