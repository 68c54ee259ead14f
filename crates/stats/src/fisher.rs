//! Fisher's exact test that two proportions are equal, two-sided.
//!
//! Given all margins of the table `(s1, n1 - s1; s2, n2 - s2)`, `s1` is hypergeometric when the
//! proportions are equal. The p-value is the probability of all tables that are no more likely
//! than the one observed.
//!
//! Source: R. A. Fisher, "Statistical Methods for Research Workers" (5th ed., 1934), section
//! 21.02; two-sided rule as in SAS and R. Deviation: densities are Loader's, and each tail is
//! summed outwards by the ratio of neighbours until the rest cannot change it, so that the cost
//! is O(sqrt(n)), not O(n). Guarantee: exact up to rounding, hence conservative.
//!
//! # Assumes
//! Trials of each sample are independent with one rate, the samples are independent of each other, and sizes were fixed in
//! advance.

use crate::binomial::{EQUAL_LIKELIHOOD, first_at_most};
use crate::counts::Sample;
use crate::special::hypergeometric_pmf;

/// The two-sided exact p-value of two samples having the same true proportion; 1 when either
/// carries no information.
#[must_use]
pub fn fisher_exact(first: Sample, second: Sample) -> f64 {
    let table = match Table::new(first, second) {
        Some(table) => table,
        None => return 1.0,
    };
    let observed = first.successes;
    let limit = table.pmf(observed) * (1.0 + EQUAL_LIKELIHOOD);
    let mode = table.mode();
    if table.pmf(mode) <= limit {
        return 1.0;
    }
    let tails = if observed < mode {
        let other = first_at_most(mode, table.high, limit, &|k| table.pmf(k));
        table.tail_down(observed) + other.map_or(0.0, |k| table.tail_up(k))
    } else {
        let span = mode - table.low;
        let other = first_at_most(0, span, limit, &|down| table.pmf(mode - down));
        table.tail_up(observed) + other.map_or(0.0, |down| table.tail_down(mode - down))
    };
    tails.min(1.0)
}

/// The margins of a two by two table: `marked` successes in all, of `total` trials, `drawn` of
/// which belong to the first sample; its successes lie in `low..=high`.
pub(crate) struct Table {
    marked: u64,
    drawn: u64,
    total: u64,
    pub(crate) low: u64,
    pub(crate) high: u64,
}

impl Table {
    fn new(first: Sample, second: Sample) -> Option<Self> {
        if !first.is_informative() || !second.is_informative() {
            return None;
        }
        // Neither has more than 2^53, so that sums fit.
        let total = first.trials + second.trials;
        let marked = first.successes + second.successes;
        Some(Self::with_margins(marked, first.trials, total))
    }

    /// `drawn` trials in the first sample, of `total`, of which `marked` succeeded.
    pub(crate) fn with_margins(marked: u64, drawn: u64, total: u64) -> Self {
        Self {
            marked,
            drawn,
            total,
            low: (marked + drawn).saturating_sub(total),
            high: marked.min(drawn),
        }
    }

    pub(crate) fn pmf(&self, hits: u64) -> f64 {
        hypergeometric_pmf(hits, self.marked, self.drawn, self.total)
    }

    fn mode(&self) -> u64 {
        let product = (self.marked as u128 + 1) * (self.drawn as u128 + 1);
        let mode = (product / (self.total as u128 + 2)) as u64;
        mode.clamp(self.low, self.high)
    }

    /// `pmf(hits + 1) / pmf(hits)`.
    pub(crate) fn ratio(&self, hits: u64) -> f64 {
        let rest = self.total - self.marked;
        let numerator = (self.marked - hits) as f64 * (self.drawn - hits) as f64;
        let misses_left = (rest + hits + 1 - self.drawn) as f64;
        numerator / ((hits + 1) as f64 * misses_left)
    }

    /// `P(X >= from)`, for `from` at or above the mode.
    fn tail_up(&self, from: u64) -> f64 {
        let mut term = self.pmf(from);
        let mut sum = term;
        for hits in from..self.high {
            term *= self.ratio(hits);
            let next = sum + term;
            if next == sum {
                break;
            }
            sum = next;
        }
        sum
    }

    /// `P(X <= to)`, for `to` at or below the mode.
    fn tail_down(&self, to: u64) -> f64 {
        let mut term = self.pmf(to);
        let mut sum = term;
        for hits in (self.low..to).rev() {
            term /= self.ratio(hits);
            let next = sum + term;
            if next == sum {
                break;
            }
            sum = next;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn p(a: u64, n: u64, b: u64, m: u64) -> f64 {
        fisher_exact(
            Sample {
                successes: a,
                trials: n,
            },
            Sample {
                successes: b,
                trials: m,
            },
        )
    }

    fn close(found: f64, expected: f64) {
        assert!(
            (found / expected - 1.0).abs() < 1e-10,
            "found {found:e}, expected {expected:e}"
        );
    }

    #[test]
    fn reference_values() {
        // scipy 1.16: fisher_exact([[a, n - a], [b, m - b]]).pvalue
        close(p(80, 100, 88, 100), 0.17633957302387296);
        close(p(20, 100, 3, 100), 0.00022398367242939325);
        close(p(88, 98, 446, 446), 2.4333929594399973e-08);
        close(p(1, 10, 9, 30), 0.4010837968380663);
        close(p(0, 5, 5, 6), 0.01515151515151515);
        close(p(439, 500, 88, 100), 1.0);
        close(p(70000, 100000, 70500, 100000), 0.014657435528437054);
    }

    #[test]
    fn it_does_not_depend_on_the_order_or_on_the_name_of_success() {
        for (a, n, b, m) in [
            (3, 7, 9, 11),
            (0, 5, 3, 8),
            (80, 100, 88, 100),
            (5, 5, 0, 9),
        ] {
            close(p(a, n, b, m), p(b, m, a, n));
            close(p(a, n, b, m), p(n - a, n, m - b, m));
        }
    }

    #[test]
    fn the_ends_and_nothing() {
        assert_eq!(p(0, 0, 3, 4), 1.0);
        assert_eq!(p(5, 5, 9, 9), 1.0);
        assert_eq!(p(0, 5, 0, 9), 1.0);
        // 2 / C(10, 5)
        close(p(5, 5, 0, 5), 2.0 / 252.0);
    }

    /// Every table with margins up to 9, against the definition.
    #[test]
    fn exhaustively_equal_to_the_definition_for_small_tables() {
        for n in 1..=9_u64 {
            for m in 1..=9_u64 {
                for a in 0..=n {
                    for b in 0..=m {
                        let table = |k: u64| hypergeometric_pmf(k, a + b, n, n + m);
                        let limit = table(a) * (1.0 + 1e-7);
                        let sum: f64 = (0..=n).map(table).filter(|&q| q <= limit).sum();
                        assert!((p(a, n, b, m) - sum).abs() < 1e-12, "{a}/{n} {b}/{m}");
                    }
                }
            }
        }
    }
}
