//! Spearman's rank correlation.
//!
//! `rho` is Pearson's correlation of the midranks. Approximately, under independence,
//!
//! ```text
//! t = rho sqrt((n - 2) / (1 - rho^2))  ~ Student's t, n - 2 degrees of freedom
//! ```
//!
//! and exactly, the p-value is the share of all n! pairings whose `|rho|` is at least the one
//! observed, computed by a dynamic programme over the multisets of ranks already used.
//!
//! Source: C. Spearman (1904); M. G. Kendall, "Rank correlation methods" (1948). Deviation: sums
//! of products of doubled ranks are whole numbers, so that ties are compared exactly. Cost of the
//! exact test: distinct multisets times distinct sums (2048 * 2025 for eleven untied pairs);
//! larger ones are refused. Guarantee: exact up to rounding of the sum.
//!
//! # Assumes
//! Under the hypothesis pairs are independent, and the two values of a pair are, too. Student's p-value takes pairs as
//! many.

use crate::counts::StatsError;
use crate::ranks::Ranking;
use crate::special::student_t_sf;

/// Cells of the table of the exact distribution beyond which it is refused.
pub const MAX_CELLS: usize = 4_500_000;

/// Spearman's correlation with its approximate p-value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spearman {
    /// The correlation of the ranks, -1 to 1.
    pub rho: f64,
    /// Two-sided p-value by Student's t; rough below about 10 pairs.
    pub p_value: f64,
    /// Number of pairs.
    pub pairs: usize,
}

/// The rank correlation of pairs `(x[i], y[i])`.
///
/// # Errors
/// [`StatsError::LengthMismatch`], [`StatsError::TooFew`] below three pairs,
/// [`StatsError::Constant`] when x or y does not vary, [`StatsError::OutOfRange`] for a value
/// that is not a number.
pub fn spearman(x: &[f64], y: &[f64]) -> Result<Spearman, StatsError> {
    let (x, y) = rankings(x, y)?;
    let pairs = x.doubled.len();
    let n = pairs as f64;
    let variation = |ranking: &Ranking| (n.powi(3) - n - ranking.tie_sum()) / 12.0;
    let covariation = 0.25 * deviation_from_mean(&x.doubled, &y.doubled) as f64;
    let rho = (covariation / (variation(&x) * variation(&y)).sqrt()).clamp(-1.0, 1.0);
    let degrees = n - 2.0;
    let t = rho.abs() * (degrees / ((1.0 - rho) * (1.0 + rho))).sqrt();
    Ok(Spearman {
        rho,
        p_value: (2.0 * student_t_sf(t, degrees)).min(1.0),
        pairs,
    })
}

/// The exact two-sided permutation p-value of the rank correlation.
///
/// # Errors
/// Those of [`spearman`], and [`StatsError::TooManyArrangements`].
pub fn spearman_exact(x: &[f64], y: &[f64]) -> Result<f64, StatsError> {
    let (x, y) = rankings(x, y)?;
    let observed = deviation_from_mean(&x.doubled, &y.doubled).abs();
    let table = Pairings::new(&x, &y)?;
    let mean = mean_product(x.doubled.len());
    let extreme = table.last_row(&x.doubled);
    let tail: f64 = extreme
        .iter()
        .enumerate()
        .filter(|(sum, _)| (*sum as i64 - mean).abs() >= observed)
        .map(|(_, probability)| probability)
        .sum();
    Ok(tail.min(1.0))
}

fn rankings(x: &[f64], y: &[f64]) -> Result<(Ranking, Ranking), StatsError> {
    if x.len() != y.len() {
        return Err(StatsError::LengthMismatch {
            left: x.len(),
            right: y.len(),
        });
    }
    if x.len() < 3 {
        return Err(StatsError::TooFew {
            what: "pairs",
            found: x.len(),
            needed: 3,
        });
    }
    let (x, y) = (Ranking::of(x)?, Ranking::of(y)?);
    if x.classes.len() < 2 || y.classes.len() < 2 {
        return Err(StatsError::Constant {
            what: "values of one variable",
        });
    }
    Ok((x, y))
}

/// Four times the sum of products of ranks when there is no correlation: `n (n+1)^2`.
fn mean_product(pairs: usize) -> i64 {
    let n = pairs as i64;
    n * (n + 1) * (n + 1)
}

/// Four times the covariation of ranks.
fn deviation_from_mean(x: &[u64], y: &[u64]) -> i64 {
    let products: u64 = x.iter().zip(y).map(|(a, b)| a * b).sum();
    products as i64 - mean_product(x.len())
}

/// The ways of giving ranks of y to observations of x, one after the other. A multiset of ranks
/// already given is a number in mixed radix, one digit for each distinct rank.
struct Pairings {
    /// Distinct doubled ranks of y, how many there are of each, and the place value of its digit.
    digits: Vec<(u64, u64, usize)>,
    codes: usize,
    sums: usize,
}

impl Pairings {
    fn new(x: &Ranking, y: &Ranking) -> Result<Self, StatsError> {
        let refused = StatsError::TooManyArrangements { limit: MAX_CELLS };
        let mut digits = Vec::new();
        let mut codes = 1_usize;
        for &(rank, size) in &y.classes {
            digits.push((rank, size, codes));
            codes = codes
                .checked_mul(size as usize + 1)
                .ok_or(refused.clone())?;
        }
        let mut ascending = (x.doubled.clone(), y.doubled.clone());
        ascending.0.sort_unstable();
        ascending.1.sort_unstable();
        let largest: u64 = ascending
            .0
            .iter()
            .zip(&ascending.1)
            .map(|(a, b)| a * b)
            .sum();
        let sums = largest as usize + 1;
        if codes.saturating_mul(sums) > MAX_CELLS {
            return Err(refused);
        }
        Ok(Self {
            digits,
            codes,
            sums,
        })
    }

    /// The distribution of the sum of products when all ranks are given.
    fn last_row(&self, x: &[u64]) -> Vec<f64> {
        let mut rows: Vec<Vec<f64>> = vec![Vec::new(); self.codes];
        rows[0] = vec![0.0; self.sums];
        rows[0][0] = 1.0;
        for code in 0..self.codes - 1 {
            let row = std::mem::take(&mut rows[code]);
            let given: usize = self.digits.iter().map(|digit| digit_of(code, digit)).sum();
            let left = (x.len() - given) as f64;
            for digit in &self.digits {
                let free = digit.1 as usize - digit_of(code, digit);
                if free > 0 {
                    let target = &mut rows[code + digit.2];
                    target.resize(self.sums, 0.0);
                    add_shifted(
                        target,
                        &row,
                        (x[given] * digit.0) as usize,
                        free as f64 / left,
                    );
                }
            }
        }
        rows.pop().unwrap_or_default()
    }
}

/// How often the rank of `digit` has been given in `code`.
fn digit_of(code: usize, digit: &(u64, u64, usize)) -> usize {
    code / digit.2 % (digit.1 as usize + 1)
}

fn add_shifted(target: &mut [f64], source: &[f64], shift: usize, factor: f64) {
    for (sum, probability) in source.iter().enumerate() {
        if *probability > 0.0 {
            target[sum + shift] += factor * probability;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, expected: f64) {
        assert!(
            (found / expected - 1.0).abs() < 1e-10,
            "found {found:e}, expected {expected:e}"
        );
    }

    #[test]
    fn reference_values() {
        // scipy 1.16: spearmanr(x, y), and brute force over all pairings.
        let (x, y) = (
            [5.0, 4.0, 6.0, 6.0, 6.0, 3.0, 3.0, 6.0, 3.0, 6.0],
            [9.0, 10.0, 8.0, 7.0, 9.0, 10.0, 10.0, 6.0, 9.0, 10.0],
        );
        let found = spearman(&x, &y).unwrap();
        close(found.rho, -0.5962401570894275);
        close(found.p_value, 0.06886690274800633);
        close(spearman_exact(&x, &y).unwrap(), 276480.0 / 3628800.0);
        let (x, y) = (
            [1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
            [2.0, 1.0, 4.0, 3.0, 6.0, 5.0],
        );
        let found = spearman(&x, &y).unwrap();
        close(found.rho, 0.8285714285714287);
        close(found.p_value, 0.04156268221574335);
        close(spearman_exact(&x, &y).unwrap(), 42.0 / 720.0);
        let (x, y) = (
            [1.0, 1.0, 2.0, 3.0, 3.0, 4.0, 7.0],
            [9.0, 1.0, 8.0, 3.0, 3.0, 2.0, 0.0],
        );
        let found = spearman(&x, &y).unwrap();
        close(found.rho, -0.5504818825631803);
        close(found.p_value, 0.20037609624592767);
        close(spearman_exact(&x, &y).unwrap(), 1024.0 / 5040.0);
    }

    #[test]
    fn a_perfect_order_of_four_by_hand() {
        let x = [1.0, 2.0, 3.0, 4.0];
        assert_eq!(spearman(&x, &x).unwrap().rho, 1.0);
        close(spearman_exact(&x, &x).unwrap(), 2.0 / 24.0);
        let reversed = [4.0, 3.0, 2.0, 1.0];
        assert_eq!(spearman(&x, &reversed).unwrap().rho, -1.0);
        assert_eq!(spearman(&x, &reversed).unwrap().p_value, 0.0);
    }

    #[test]
    fn refusals() {
        assert!(spearman(&[1.0, 2.0], &[1.0, 2.0]).is_err());
        assert!(spearman(&[1.0, 2.0, 3.0], &[1.0, 2.0]).is_err());
        assert!(spearman(&[1.0, 2.0, 3.0], &[1.0, 1.0, 1.0]).is_err());
        assert!(spearman(&[1.0, 2.0, f64::NAN], &[1.0, 2.0, 3.0]).is_err());
        let long: Vec<f64> = (0..40).map(f64::from).collect();
        let refused = spearman_exact(&long, &long);
        assert_eq!(
            refused,
            Err(StatsError::TooManyArrangements { limit: MAX_CELLS })
        );
    }
}
