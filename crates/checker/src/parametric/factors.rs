//! Products of powers of polynomials in which nothing can be cancelled.
//!
//! *Definition.* `f_1^e_1 f_2^e_2 ...` with primitive polynomials `f_i` that are no constants and exponents that
//! are not 0; those with a positive and those with a negative exponent have no common divisor. Source: Jansen,
//! Corzilius, Volk, Wimmer, Ábrahám, Katoen and Becker 2014, "Accelerating Parametric Probabilistic Verification",
//! section 4: quotients that arise by state elimination share most of their factors, so that their greatest common
//! divisors are found factor by factor. Deviation: factors need not be irreducible; they are split when a divisor of
//! one is found. There is no table of divisors that were found before: instead each factor keeps its images modulo a
//! prime, by which almost all pairs are proved coprime ([`super::gcd`]).

use std::cmp::Ordering;
use std::sync::Arc;

use super::gcd::{Images, gcd};
use super::monomial::MOST_PARAMETERS;
use super::polynomial::Polynomial;

/// A primitive polynomial that is no constant; shared.
#[derive(Clone, Debug)]
pub(super) struct Factor(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    polynomial: Polynomial,
    images: Images,
}

impl Factor {
    pub fn new(polynomial: Polynomial) -> Self {
        Self(Arc::new(Shared {
            images: Images::new(&polynomial),
            polynomial,
        }))
    }

    pub fn polynomial(&self) -> &Polynomial {
        &self.0.polynomial
    }

    fn images(&self) -> &Images {
        &self.0.images
    }
}

impl PartialEq for Factor {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Factor {}

impl PartialOrd for Factor {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Factor {
    fn cmp(&self, other: &Self) -> Ordering {
        if Arc::ptr_eq(&self.0, &other.0) {
            return Ordering::Equal;
        }
        let (a, b) = (self.polynomial(), other.polynomial());
        (a.terms.len().cmp(&b.terms.len())).then_with(|| a.cmp(b))
    }
}

/// A product of powers, ascending by factor.
pub(super) type Product = Vec<(Factor, i32)>;

/// The product of a primitive polynomial; parameters that divide it are factors of their own.
pub(super) fn product_of(polynomial: Polynomial) -> Product {
    let monomial = polynomial.monomial();
    let rest = polynomial.without_monomial(monomial);
    let mut product: Product = Vec::new();
    for parameter in 0..MOST_PARAMETERS {
        let exponent = i32::from(monomial.exponent(parameter));
        if exponent > 0 {
            product.push((Factor::new(Polynomial::parameter(parameter)), exponent));
        }
    }
    if rest.as_constant().is_none() {
        product.push((Factor::new(rest), 1));
    }
    product.sort();
    product
}

/// The factors with the lesser of their exponents, and what is left of each.
pub(super) fn in_common(a: &Product, b: &Product) -> [Product; 3] {
    let mut parts = [Vec::new(), Vec::new(), Vec::new()];
    each(a, b, |factor, left, right| {
        let least = left.min(right);
        for (part, exponent) in parts.iter_mut().zip([least, left - least, right - least]) {
            if exponent != 0 {
                part.push((factor.clone(), exponent));
            }
        }
    });
    parts
}

/// Calls `visit` with each factor and its exponents, ascending.
fn each(a: &Product, b: &Product, mut visit: impl FnMut(&Factor, i32, i32)) {
    let (mut a, mut b) = (a.iter().peekable(), b.iter().peekable());
    loop {
        let order = match (a.peek(), b.peek()) {
            (None, None) => return,
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (Some(a), Some(b)) => a.0.cmp(&b.0),
        };
        let left = (order != Ordering::Greater).then(|| a.next()).flatten();
        let right = (order != Ordering::Less).then(|| b.next()).flatten();
        if let Some((factor, _)) = left.or(right) {
            visit(factor, left.map_or(0, |l| l.1), right.map_or(0, |r| r.1));
        }
    }
}

/// The product of powers, none of them negative, as one polynomial; `None` if it is too large.
pub(super) fn expanded(product: &[(Factor, i32)]) -> Option<Polynomial> {
    let mut result = Polynomial::one();
    for (factor, exponent) in product {
        for _ in 0..*exponent {
            result = result.times(factor.polynomial())?;
        }
    }
    Some(result)
}

/// The product of two products; `None` if numbers become too large.
pub(super) fn times(a: &Product, b: &Product) -> Option<Product> {
    let mut merged = Vec::with_capacity(a.len() + b.len());
    each(a, b, |factor, left, right| {
        if left + right != 0 {
            let from = (u8::from(left != 0)) | (u8::from(right != 0) << 1);
            merged.push((factor.clone(), left + right, from));
        }
    });
    cancelled(merged)
}

/// Cancels what numerators and denominators have in common. Each factor comes with the sources that it is from;
/// factors of one and the same source are known to have nothing in common.
fn cancelled(mut parts: Vec<(Factor, i32, u8)>) -> Option<Product> {
    let mut again = true;
    while again {
        again = false;
        'pairs: for i in 0..parts.len() {
            for j in 0..parts.len() {
                let (up, down) = (&parts[i], &parts[j]);
                let may = up.1 > 0 && down.1 < 0 && up.2 & down.2 == 0;
                if !may || up.0.images().are_coprime(down.0.images()) {
                    continue;
                }
                let common = gcd(up.0.polynomial(), down.0.polynomial())?;
                if common.is_one() {
                    continue;
                }
                let (up, down) = (parts[i].clone(), parts[j].clone());
                let (last, first) = (i.max(j), i.min(j));
                parts.remove(last);
                parts.remove(first);
                split(&mut parts, &up, &down, common)?;
                again = true;
                break 'pairs;
            }
        }
    }
    Some(collected(parts))
}

/// Puts back two factors, of which a common divisor is taken out.
fn split(
    parts: &mut Vec<(Factor, i32, u8)>,
    up: &(Factor, i32, u8),
    down: &(Factor, i32, u8),
    common: Polynomial,
) -> Option<()> {
    for (factor, exponent, from) in [up, down] {
        let rest = factor.polynomial().over(&common)?;
        for (part, power) in product_of(rest) {
            parts.push((part, exponent * power, *from));
        }
    }
    let exponent = up.1 + down.1;
    if exponent != 0 {
        // What is left is from the side that had more.
        let from = if exponent > 0 { up.2 } else { down.2 };
        for (part, power) in product_of(common) {
            parts.push((part, exponent * power, from));
        }
    }
    Some(())
}

/// Equal factors joined.
fn collected(parts: Vec<(Factor, i32, u8)>) -> Product {
    let mut product: Product = parts.into_iter().map(|p| (p.0, p.1)).collect();
    product.sort_by(|a, b| a.0.cmp(&b.0));
    product.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    product.retain(|p| p.1 != 0);
    product
}
