//! Whether two tables have more rows in common than chance gives: the same trials, told twice.
//!
//! # Definition
//! `n` rows of two tables have the same keys (such as the number of a person), and `m` of them have the same content in
//! both. If the tables tell of different trials, which content comes to which key in the second is a matter of chance:
//! all `n!` ways of handing its contents out to the keys are as likely. With `M` the matches of such a way,
//!
//! ```text
//! chance = P(M >= m) <= min over k = 1 .. m of E[C(M, k)] / C(m, k)
//! E[C(M, k)] = r_k (n - k)! / n!,   r_k = coefficient of x^k in the product over contents v of
//!                                         sum over j of C(a_v, j) C(b_v, j) j! x^j
//! ```
//!
//! where `v` stands in `a_v` and `b_v` of the rows. `r_k` counts the ways to place `k` rooks on the board of equal contents.
//!
//! # Source
//! J. Riordan, "An introduction to combinatorial analysis" (1958), chapters 7 and 8, for the rook polynomial and the
//! factorial moments of matches; the inequality is Markov's, for `C(M, k)`. For all rows alike and distinct (`m = n = k`)
//! it is an equality: `1/n!`.
//!
//! # Assumes
//! Of different trials all ways in which contents come to keys are as likely. Where keys tell contents (ages, settings, a
//! plan) rows are the same without a copy.
//!
//! # Guarantee and cost
//! The bound holds for every `n` and for any contents, as long as keys do not tell contents. Rows of few values coincide by
//! chance, and are allowed for: where all rows of both tables are alike, chance is 1. At least ten rows of different
//! content are needed for a chance below 1e-6 (`1/10! = 2.8e-7`). Cost: `n` times the number of `k` that are tried, which
//! is at most 512 and less for tables of more than 30 000 rows.

use crate::special::ln_gamma;
use std::collections::BTreeMap;

/// The most `k` that are tried.
const MOST: usize = 512;

/// Rows times `k` up to which all `k` are tried.
const WORK: usize = 1 << 24;

/// How many of the rows with the same key are the same in both tables, and how likely at most chance gives as many or more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharedRows {
    /// Rows whose key both tables have.
    pub common: u64,
    /// Those of them with the same content.
    pub same: u64,
    /// The probability of as many by chance, at most.
    pub chance: f64,
}

/// Rows that are the same, of the contents of both tables in the order of their common keys.
///
/// ```
/// use stats::shared_rows;
/// let one: Vec<u32> = (0..10).collect();
/// assert!(shared_rows(&one, &one).chance < 1e-6);
/// // Nothing follows from rows that are all alike.
/// assert!(shared_rows(&[7; 1000], &[7; 1000]).chance > 1.0 - 1e-9);
/// ```
#[must_use]
pub fn shared_rows<T: Ord>(first: &[T], second: &[T]) -> SharedRows {
    let common = first.len().min(second.len());
    let pairs = first.iter().zip(second);
    let same = pairs.clone().filter(|(a, b)| a == b).count();
    let mut contents: BTreeMap<&T, [usize; 2]> = BTreeMap::new();
    for (a, b) in pairs {
        contents.entry(a).or_default()[0] += 1;
        contents.entry(b).or_default()[1] += 1;
    }
    let most = same.min(MOST).min((WORK / common.max(1)).max(32));
    let rooks = rooks(contents.into_values(), most);
    let n = common as f64;
    let ln_bound = (1..=most).map(|k| {
        let placed = rooks[k] + ln_factorial(n - k as f64) - ln_factorial(n);
        placed - ln_choose(same as f64, k as f64)
    });
    SharedRows {
        common: common as u64,
        same: same as u64,
        chance: ln_bound.fold(0.0, f64::min).exp(),
    }
}

/// The logarithms of `r_0 .. r_most`.
fn rooks(contents: impl Iterator<Item = [usize; 2]>, most: usize) -> Vec<f64> {
    let mut product = vec![f64::NEG_INFINITY; most + 1];
    product[0] = 0.0;
    let mut degree = 0;
    for [a, b] in contents {
        let own = a.min(b).min(most);
        if own == 0 {
            continue;
        }
        let (a, b) = (a as f64, b as f64);
        let factor: Vec<f64> = (0..=own)
            .map(|j| j as f64)
            .map(|j| ln_choose(a, j) + ln_choose(b, j) + ln_factorial(j))
            .collect();
        degree = (degree + own).min(most);
        for k in (1..=degree).rev() {
            let terms = (0..=own.min(k)).map(|j| product[k - j] + factor[j]);
            product[k] = ln_sum(terms);
        }
    }
    product
}

fn ln_sum(terms: impl Iterator<Item = f64> + Clone) -> f64 {
    let greatest = terms.clone().fold(f64::NEG_INFINITY, f64::max);
    if greatest == f64::NEG_INFINITY {
        return greatest;
    }
    greatest + terms.map(|term| (term - greatest).exp()).sum::<f64>().ln()
}

fn ln_factorial(n: f64) -> f64 {
    ln_gamma(n + 1.0)
}

fn ln_choose(n: f64, k: f64) -> f64 {
    ln_factorial(n) - ln_factorial(k) - ln_factorial(n - k)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All ways of handing out contents, counted.
    fn exactly(first: &[u8], second: &mut Vec<u8>, from: usize, same: usize) -> (u64, u64) {
        if from == second.len() {
            let matches = first.iter().zip(&*second).filter(|(a, b)| a == b).count();
            return (u64::from(matches >= same), 1);
        }
        let (mut many, mut all) = (0, 0);
        for place in from..second.len() {
            second.swap(from, place);
            let (found, of) = exactly(first, second, from + 1, same);
            second.swap(from, place);
            (many, all) = (many + found, all + of);
        }
        (many, all)
    }

    #[test]
    fn chance_is_at_least_the_share_of_all_ways_and_exact_for_distinct_rows() {
        let cases: [(&[u8], &[u8]); 6] = [
            (&[1, 2, 3, 4, 5, 6], &[1, 2, 3, 4, 5, 6]),
            (&[1, 1, 2, 2, 3, 3, 4], &[1, 1, 2, 2, 3, 3, 4]),
            (&[1, 1, 1, 1, 2, 2, 3], &[1, 1, 1, 2, 1, 3, 2]),
            (&[1, 2, 3, 4, 5, 6, 7], &[1, 2, 3, 4, 6, 7, 5]),
            (&[1, 1, 1, 1, 1, 1, 2], &[1, 1, 1, 1, 1, 1, 2]),
            (&[1, 2, 3], &[4, 5, 6]),
        ];
        for (first, second) in cases {
            let found = shared_rows(first, second);
            let (many, all) = exactly(first, &mut second.to_vec(), 0, found.same as usize);
            let share = many as f64 / all as f64;
            assert!(found.chance >= share * (1.0 - 1e-9), "{found:?} {share}");
            assert!(found.chance <= 1.0);
            if found.same == found.common {
                // The largest k is all rows: what is left is exact.
                assert!((found.chance - share).abs() < 1e-9, "{found:?} {share}");
            }
        }
    }

    #[test]
    fn a_part_that_is_repeated_is_seen_among_many_rows_and_chance_is_not() {
        // Six values, of which each is as frequent; every third row is repeated.
        let noise = |i: u64, salt: u64| (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ salt) >> 33;
        let content = |i: u64, salt: u64| (noise(i * 7 + salt, salt * 0x1234_5678_9abc) * 6) >> 31;
        let first: Vec<u64> = (0..600).map(|i| content(i, 1)).collect();
        let other: Vec<u64> = (0..600).map(|i| content(i, 2)).collect();
        let partly: Vec<u64> = (0..600)
            .map(|i| match i % 3 {
                0 => first[i],
                _ => other[i],
            })
            .collect();
        let (by_chance, found) = (shared_rows(&first, &other), shared_rows(&first, &partly));
        assert!(by_chance.chance > 1e-3, "{by_chance:?}");
        assert!(found.chance < 1e-6 && found.same >= 200, "{found:?}");
    }

    #[test]
    fn nine_rows_are_too_few_and_no_rows_say_nothing() {
        let rows: Vec<u32> = (0..9).collect();
        assert!(shared_rows(&rows, &rows).chance > 1e-6);
        assert_eq!(shared_rows::<u32>(&[], &[]).chance, 1.0);
    }
}
