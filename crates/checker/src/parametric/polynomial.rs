//! Polynomials in several parameters with integer coefficients.
//!
//! Terms are kept in descending order of their monomials, none with coefficient 0. Cost: products are formed term
//! by term (their number is the product of the numbers of terms), quotients by the leading terms. Guarantee:
//! exact; what would be too large is given up ([`Polynomial::times`] says `None`), never truncated.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use num_bigint::BigInt;
use num_integer::Integer;
use num_traits::{One, Signed, Zero};
use prism_lang::Rational;
use rustc_hash::FxHashMap;

use super::monomial::{MOST_DEGREE, MOST_PARAMETERS, Monomial};

/// More products of terms than this are not formed.
const MOST_PRODUCTS: usize = 200_000_000;
/// More terms than this are not kept.
const MOST_TERMS: usize = 3_000_000;

/// A polynomial.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Polynomial {
    pub terms: Vec<(Monomial, BigInt)>,
}

impl Polynomial {
    pub fn constant(value: BigInt) -> Self {
        Self::term(Monomial::ONE, value)
    }

    pub fn one() -> Self {
        Self::constant(BigInt::one())
    }

    pub fn parameter(index: usize) -> Self {
        Self::term(Monomial::power(index, 1), BigInt::one())
    }

    pub fn term(monomial: Monomial, coefficient: BigInt) -> Self {
        let mut terms = Vec::new();
        if !coefficient.is_zero() {
            terms.push((monomial, coefficient));
        }
        Self { terms }
    }

    pub fn is_zero(&self) -> bool {
        self.terms.is_empty()
    }

    /// The value, if no parameter occurs.
    pub fn as_constant(&self) -> Option<BigInt> {
        match &self.terms[..] {
            [] => Some(BigInt::zero()),
            [(Monomial::ONE, value)] => Some(value.clone()),
            _ => None,
        }
    }

    pub fn is_one(&self) -> bool {
        matches!(&self.terms[..], [(Monomial::ONE, value)] if value.is_one())
    }

    /// The coefficient of the leading term; 0 if there is none.
    pub fn leading(&self) -> BigInt {
        self.terms
            .first()
            .map_or_else(BigInt::zero, |t| t.1.clone())
    }

    /// The parameters that occur, as bits.
    pub fn parameters(&self) -> u32 {
        self.terms.iter().fold(0, |set, t| set | t.0.parameters())
    }

    pub fn degree_in(&self, parameter: usize) -> usize {
        let degrees = self.terms.iter().map(|t| t.0.exponent(parameter));
        usize::from(degrees.max().unwrap_or(0))
    }

    pub fn total_degree(&self) -> u64 {
        self.terms.iter().map(|t| t.0.degree()).max().unwrap_or(0)
    }

    /// `a * self + b * other`
    pub fn combined(&self, a: &BigInt, other: &Self, b: &BigInt) -> Self {
        let mut terms = Vec::with_capacity(self.terms.len() + other.terms.len());
        let (mut left, mut right) = (self.terms.iter().peekable(), other.terms.iter().peekable());
        loop {
            let next = match (left.peek(), right.peek()) {
                (None, None) => return Self { terms },
                (Some(l), Some(r)) if l.0 == r.0 => {
                    let sum = a * &l.1 + b * &r.1;
                    let monomial = l.0;
                    left.next();
                    right.next();
                    (monomial, sum)
                }
                (Some(l), r) if r.is_none_or(|r| l.0 > r.0) => {
                    let scaled = (l.0, a * &l.1);
                    left.next();
                    scaled
                }
                (_, Some(r)) => {
                    let scaled = (r.0, b * &r.1);
                    right.next();
                    scaled
                }
                // The first two cases cover what is left.
                (Some(_), None) => return Self { terms },
            };
            if !next.1.is_zero() {
                terms.push(next);
            }
        }
    }

    pub fn scaled(&self, by: &BigInt) -> Self {
        let scale = |(monomial, value): &(Monomial, BigInt)| (*monomial, value * by);
        match by.is_zero() {
            true => Self::default(),
            false => Self {
                terms: self.terms.iter().map(scale).collect(),
            },
        }
    }

    /// The product; `None` if it is too large.
    pub fn times(&self, other: &Self) -> Option<Self> {
        let (short, long) = match self.terms.len() <= other.terms.len() {
            true => (self, other),
            false => (other, self),
        };
        let products = short.terms.len().checked_mul(long.terms.len())?;
        if products > MOST_PRODUCTS || self.total_degree() + other.total_degree() > MOST_DEGREE {
            return None;
        }
        if let [(monomial, value)] = &short.terms[..] {
            let shift = |t: &(Monomial, BigInt)| (t.0.times(*monomial), &t.1 * value);
            let terms = long.terms.iter().map(shift).collect();
            return Some(Self { terms });
        }
        let mut sums: FxHashMap<Monomial, BigInt> = FxHashMap::default();
        for (m, a) in &short.terms {
            for (n, b) in &long.terms {
                *sums.entry(m.times(*n)).or_default() += a * b;
            }
        }
        let mut terms: Vec<_> = sums.into_iter().filter(|t| !t.1.is_zero()).collect();
        terms.sort_unstable_by_key(|term| std::cmp::Reverse(term.0));
        (terms.len() <= MOST_TERMS).then_some(Self { terms })
    }

    /// The quotient, if it is a polynomial with integer coefficients.
    pub fn over(&self, divisor: &Self) -> Option<Self> {
        let (first, rest) = divisor.terms.split_first()?;
        for parameter in 0..MOST_PARAMETERS {
            if divisor.degree_in(parameter) > self.degree_in(parameter) {
                return None;
            }
        }
        let mut remainder: BTreeMap<Monomial, BigInt> = self.terms.iter().cloned().collect();
        let mut terms = Vec::new();
        while let Some((monomial, value)) = remainder.pop_last() {
            let (quotient, rest_of_it) = value.div_rem(&first.1);
            let shift = monomial.over(first.0)?;
            if !rest_of_it.is_zero() {
                return None;
            }
            for (m, c) in rest {
                subtract(&mut remainder, m.times(shift), &quotient * c);
            }
            terms.push((shift, quotient));
        }
        Some(Self { terms })
    }

    /// The derivative by a parameter.
    pub fn derivative(&self, parameter: usize) -> Self {
        let one = Monomial::power(parameter, 1);
        let term = |(monomial, value): &(Monomial, BigInt)| {
            let exponent = monomial.exponent(parameter);
            Some((monomial.over(one)?, value * exponent))
        };
        Self {
            terms: self.terms.iter().filter_map(term).collect(),
        }
    }

    /// The value at a point.
    pub fn at(&self, point: &[Rational]) -> Rational {
        let mut powers: Vec<Vec<Rational>> = vec![vec![Rational::one()]; point.len()];
        let mut sum = Rational::zero();
        for (monomial, value) in &self.terms {
            let mut product = Rational::from_integer(value.clone());
            for (parameter, known) in powers.iter_mut().enumerate() {
                let exponent = usize::from(monomial.exponent(parameter));
                while known.len() <= exponent {
                    let next = &known[known.len() - 1] * &point[parameter];
                    known.push(next);
                }
                if exponent > 0 {
                    product *= &known[exponent];
                }
            }
            sum += product;
        }
        sum
    }

    /// The coefficients by powers of a parameter, lowest first.
    pub fn coefficients(&self, parameter: usize) -> Vec<Self> {
        let mut found = vec![Self::default(); self.degree_in(parameter) + 1];
        for (monomial, value) in &self.terms {
            let power = usize::from(monomial.exponent(parameter));
            // Without the parameter, terms of one power keep their order.
            found[power]
                .terms
                .push((monomial.without(parameter), value.clone()));
        }
        found
    }

    /// The greatest integer that divides all coefficients, with the sign of the leading one.
    pub fn content(&self) -> BigInt {
        let mut content = BigInt::zero();
        for (_, value) in &self.terms {
            content = content.gcd(value);
            if content.is_one() {
                break;
            }
        }
        match self.leading().is_negative() {
            true => -content,
            false => content,
        }
    }

    /// Without its content: coefficients without common divisor, the leading one positive.
    pub fn primitive(mut self) -> Self {
        let content = self.content();
        if !content.is_one() && !content.is_zero() {
            for (_, value) in &mut self.terms {
                *value /= &content;
            }
        }
        self
    }

    /// The greatest monomial that divides it.
    pub fn monomial(&self) -> Monomial {
        let mut monomials = self.terms.iter().map(|t| t.0);
        let first = monomials.next().unwrap_or_default();
        monomials.fold(first, Monomial::common)
    }

    /// Divided by a monomial that divides it.
    pub fn without_monomial(mut self, by: Monomial) -> Self {
        if by != Monomial::ONE {
            for (monomial, _) in &mut self.terms {
                *monomial = monomial.over(by).unwrap_or(*monomial);
            }
        }
        self
    }
}

fn subtract(from: &mut BTreeMap<Monomial, BigInt>, monomial: Monomial, value: BigInt) {
    match from.entry(monomial) {
        Entry::Vacant(place) => {
            place.insert(-value);
        }
        Entry::Occupied(mut place) => {
            *place.get_mut() -= value;
            if place.get().is_zero() {
                place.remove();
            }
        }
    }
}
