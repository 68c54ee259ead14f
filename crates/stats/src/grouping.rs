//! Whether trials are alike that stand near each other: in groups that a label forms, or one after the other.
//!
//! # Definition
//! Rows `i` of a table have `s_i` successes in `n_i` trials, with `r = sum s / sum n` and residuals `e_i = s_i - n_i r`.
//!
//! ```text
//! by labels   T = sum over labels g of (sum of e_i in g)^2 / (sum of n_i in g)
//! in order    T = sum of e_i e_(i+1)
//! ```
//!
//! The p-value is the share of permutations of the rows (of `s_i` and `n_i` together) whose `T` is at least as large,
//! the observed order counted as one of them.
//!
//! # Source
//! B. Phipson and G. K. Smyth, "Permutation p-values should never be zero" (2010), for the count of the observed order;
//! A. Wald and J. Wolfowitz, "An exact test for randomness in the non-parametric case based on serial correlation"
//! (1943), for the order.
//!
//! # Assumes
//! Under the hypothesis rows are exchangeable, successes with their trials: no label and no place in the order goes with a
//! rate. A trend, or a label that says the conditions, is found as likeness, too.
//!
//! # Guarantee
//! If the rows are exchangeable (independent of labels and order), the p-value is at most `a` with a probability of at
//! most `a`, for every `a`, whatever the rates and sizes of the rows, on average over the permutations that are drawn.
//! These follow from a fixed seed, so that the same rows have the same p-value; by that, a p-value of `p` is off by about
//! `sqrt(p / PERMUTATIONS)`. Those below `1 / (1 + PERMUTATIONS)` are not told apart. Cost: rows times permutations.

use crate::counts::Sample;
use crate::heterogeneity::pool;

/// Permutations that are drawn.
pub const PERMUTATIONS: usize = 9999;

/// Fewer rows have too few orders to tell.
const FEWEST_ROWS: usize = 6;

/// Relative differences of two statistics that are rounding.
const ROUNDING: f64 = 1e-9;

/// The p-value of "rows of one label are no more alike than rows of different labels"; `None` where nothing can be told:
/// fewer than six rows, one outcome only, one label, or a label of its own for each row.
///
/// ```
/// use stats::{Sample, alike_by_label};
/// let rows: Vec<Sample> = (0..20).map(|i| Sample { successes: if i % 4 == 0 { 3 } else { 9 }, trials: 10 }).collect();
/// let days: Vec<usize> = (0..20).map(|i| i % 4).collect();
/// assert!(alike_by_label(&rows, &days).unwrap() < 1e-3);
/// let others: Vec<usize> = (0..20).map(|i| i / 4).collect();
/// assert!(alike_by_label(&rows, &others).unwrap() > 0.5);
/// ```
#[must_use]
pub fn alike_by_label(rows: &[Sample], labels: &[usize]) -> Option<f64> {
    let residuals = residuals(rows)?;
    let groups = labels.iter().max()? + 1;
    let mut sizes = vec![0; groups];
    labels.iter().for_each(|label| sizes[*label] += 1);
    let used = sizes.iter().filter(|size| **size > 0).count();
    if labels.len() != rows.len() || used < 2 || used == rows.len() {
        return None;
    }
    let mut sums = vec![(0.0, 0.0); groups];
    let statistic = |order: &[usize]| {
        sums.fill((0.0, 0.0));
        for (place, label) in order.iter().zip(labels) {
            sums[*label].0 += residuals[*place];
            sums[*label].1 += rows[*place].trials as f64;
        }
        let counted = sums.iter().filter(|(_, trials)| *trials > 0.0);
        counted.map(|(sum, trials)| sum * sum / trials).sum()
    };
    Some(p_value(rows.len(), statistic))
}

/// The p-value of "rows are no more alike than their neighbours in the order of the table"; `None` where nothing can be
/// told: fewer than six rows, or one outcome only.
///
/// ```
/// use stats::{Sample, alike_in_order};
/// let drifted: Vec<Sample> = (0..16).map(|i| Sample { successes: if i < 8 { 9 } else { 5 }, trials: 10 }).collect();
/// assert!(alike_in_order(&drifted).unwrap() < 1e-3);
/// let mixed: Vec<Sample> = (0..16).map(|i| Sample { successes: if i % 2 == 0 { 9 } else { 5 }, trials: 10 }).collect();
/// assert!(alike_in_order(&mixed).unwrap() > 0.9);
/// ```
#[must_use]
pub fn alike_in_order(rows: &[Sample]) -> Option<f64> {
    let residuals = residuals(rows)?;
    let statistic = |order: &[usize]| {
        let pairs = order.windows(2);
        pairs
            .map(|pair| residuals[pair[0]] * residuals[pair[1]])
            .sum()
    };
    Some(p_value(rows.len(), statistic))
}

/// What each row has more than the common rate gives; `None` where there are too few rows, or one outcome only.
fn residuals(rows: &[Sample]) -> Option<Vec<f64>> {
    let Sample { successes, trials } = pool(rows).ok()?;
    if rows.len() < FEWEST_ROWS || successes == 0 || successes == trials {
        return None;
    }
    let rate = successes as f64 / trials as f64;
    let residual = |row: &Sample| row.successes as f64 - rate * row.trials as f64;
    Some(rows.iter().map(residual).collect())
}

fn p_value(rows: usize, mut statistic: impl FnMut(&[usize]) -> f64) -> f64 {
    let mut order: Vec<usize> = (0..rows).collect();
    let observed = statistic(&order);
    let least = observed - ROUNDING * observed.abs() - f64::MIN_POSITIVE;
    let mut draws = Draws(0x0c0f_fee0);
    let mut as_large = 1;
    for _ in 0..PERMUTATIONS {
        for last in (1..rows).rev() {
            order.swap(last, draws.below(last + 1));
        }
        as_large += usize::from(statistic(&order) >= least);
    }
    as_large as f64 / (1 + PERMUTATIONS) as f64
}

/// SplitMix64 (G. L. Steele, D. Lea and C. H. Flood, 2014): the same permutations on every machine.
struct Draws(u64);

impl Draws {
    /// A whole number below a limit; the bias of the remainder is below 2^-40 for the rows of any table.
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % limit as u64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(outcomes: &[u64]) -> Vec<Sample> {
        let row = |successes: &u64| Sample {
            successes: *successes,
            trials: 1,
        };
        outcomes.iter().map(row).collect()
    }

    /// All orders of six outcomes, counted.
    #[test]
    fn p_values_are_the_shares_of_all_orders() {
        let outcomes = [1, 1, 1, 0, 0, 0];
        let labels = [0, 0, 0, 1, 1, 1];
        // Two of the 20 ways part them so; runs: neighbours alike in 4 of 5 pairs, as in two ways.
        let by_label = alike_by_label(&rows(&outcomes), &labels).expect("a p-value");
        assert!((by_label - 0.1).abs() < 0.01, "{by_label}");
        let in_order = alike_in_order(&rows(&outcomes)).expect("a p-value");
        assert!((in_order - 0.1).abs() < 0.01, "{in_order}");
        let mixed = alike_in_order(&rows(&[1, 0, 1, 0, 1, 0])).expect("a p-value");
        assert_eq!(mixed, 1.0);
    }

    /// Exchangeable rows of different sizes and rates: a p-value of at most 5 % in at most 5 %.
    #[test]
    fn exchangeable_rows_are_called_alike_no_oftener_than_said() {
        let mut draws = Draws(7);
        let mut below = [0, 0];
        let studies = 400;
        for _ in 0..studies {
            let rows: Vec<Sample> = (0..10)
                .map(|_| {
                    let trials = 1 + draws.below(8) as u64;
                    let rate = draws.below(100);
                    let successes = (0..trials).filter(|_| draws.below(100) < rate).count() as u64;
                    Sample { successes, trials }
                })
                .collect();
            let labels: Vec<usize> = (0..10).map(|i| i / 3).collect();
            below[0] += usize::from(alike_by_label(&rows, &labels).is_some_and(|p| p <= 0.05));
            below[1] += usize::from(alike_in_order(&rows).is_some_and(|p| p <= 0.05));
        }
        // 20 expected; 34 is beyond the 99.9 % quantile of a binomial count.
        assert!(below.iter().all(|count| *count <= 34), "{below:?}");
    }

    #[test]
    fn what_tells_nothing_has_no_p_value() {
        assert_eq!(alike_in_order(&rows(&[1; 20])), None);
        assert_eq!(alike_in_order(&rows(&[1, 0, 1])), None);
        let labels: Vec<usize> = (0..8).collect();
        assert_eq!(
            alike_by_label(&rows(&[1, 0, 1, 0, 1, 0, 1, 0]), &labels),
            None
        );
        assert_eq!(
            alike_by_label(&rows(&[1, 0, 1, 0, 1, 0, 1, 0]), &[0; 8]),
            None
        );
    }
}
