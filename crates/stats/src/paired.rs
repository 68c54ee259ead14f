//! Two proportions on the same trials: matched pairs.
//!
//! # Definition
//! Of `n` pairs, `b` succeed only the first time and `c` only the second. The difference of the
//! proportions is `(c - b)/n`. Its interval adds half a pair to each of the four cells and is
//! Wald's from then on: with `N = n + 2`, `d = (c - b)/N`, `d ± z sqrt((b + c + 1)/N - d^2) / sqrt(N)`.
//! The test is exact: given `b + c`, `b` is binomial with one half if nothing differs.
//!
//! Source: A. Agresti, Y. Min, "Simple improved confidence intervals for comparing matched
//! proportions", Statistics in Medicine 24 (2005), 729-740; Q. McNemar, Psychometrika 12 (1947),
//! 153-157. Cost: that of one binomial test. Guarantee: the interval is approximate, from few
//! pairs on (their coverage study begins at n = 10); the test is exact up to rounding.

use crate::binomial::binomial_test_two_sided;
use crate::counts::{Confidence, Interval, Sample};
use crate::special::normal_quantile;

/// How matched pairs came out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pairs {
    /// Pairs in all.
    pub pairs: u64,
    /// Success only the first time.
    pub only_first: u64,
    /// Success only the second time.
    pub only_second: u64,
}

impl Pairs {
    /// Second minus first.
    #[must_use]
    pub fn difference(&self) -> Option<f64> {
        let change = self.only_second as f64 - self.only_first as f64;
        (self.pairs > 0).then(|| change / self.pairs as f64)
    }

    /// An interval of the difference, second minus first; all of `[-1, 1]` without pairs.
    ///
    /// ```
    /// use stats::{Confidence, paired::Pairs};
    /// let pairs = Pairs { pairs: 100, only_first: 3, only_second: 13 };
    /// assert_eq!(pairs.interval(Confidence::P95).to_string(), "[0.0211, 0.1749]");
    /// ```
    #[must_use]
    pub fn interval(&self, confidence: Confidence) -> Interval {
        if self.pairs == 0 {
            return Interval {
                low: -1.0,
                high: 1.0,
            };
        }
        let n = self.pairs as f64 + 2.0;
        let (b, c) = (self.only_first as f64, self.only_second as f64);
        let difference = (c - b) / n;
        let variance = ((b + c + 1.0) / n - difference * difference).max(0.0) / n;
        let half = -normal_quantile(0.5 * confidence.alpha()) * variance.sqrt();
        Interval {
            low: (difference - half).max(-1.0),
            high: (difference + half).min(1.0),
        }
    }

    /// The two-sided exact p-value of "nothing differs".
    #[must_use]
    pub fn p_value(&self) -> f64 {
        let sample = Sample {
            successes: self.only_second,
            trials: self.only_first + self.only_second,
        };
        binomial_test_two_sided(sample, 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::Pairs;
    use crate::Confidence;

    #[test]
    fn exact_p_values_are_scipys() {
        // scipy.stats.binomtest(13, 16, 0.5).pvalue, and statsmodels' mcnemar(exact=True).
        let pairs = Pairs {
            pairs: 100,
            only_first: 3,
            only_second: 13,
        };
        assert!((pairs.p_value() - 0.021270751953125).abs() < 1e-15);
        let same = Pairs {
            pairs: 50,
            ..Pairs::default()
        };
        assert_eq!(same.p_value(), 1.0);
    }

    #[test]
    fn no_difference_in_few_pairs_is_not_certain() {
        let of = |pairs| Pairs {
            pairs,
            ..Pairs::default()
        };
        let width = |pairs| {
            let interval = of(pairs).interval(Confidence::P95);
            interval.high - interval.low
        };
        assert!(width(10) > 0.25 && width(1000) < 0.005 && width(0) == 2.0);
        assert_eq!(of(0).difference(), None);
    }

    /// Agresti and Min's coverage: near the level for matched pairs of known cells.
    #[test]
    fn the_interval_covers() {
        let (n, first, second) = (30_u64, 0.1_f64, 0.25_f64);
        let truth = second - first;
        let mut covered = 0.0;
        for b in 0..=n {
            for c in 0..=n - b {
                let pairs = Pairs {
                    pairs: n,
                    only_first: b,
                    only_second: c,
                };
                let interval = pairs.interval(Confidence::P95);
                if interval.low <= truth && truth <= interval.high {
                    covered += trinomial(n, b, c, first, second);
                }
            }
        }
        assert!((0.93..0.98).contains(&covered), "{covered}");
    }

    fn trinomial(n: u64, b: u64, c: u64, p: f64, q: f64) -> f64 {
        let log_factorial = |k: u64| (1..=k).map(|i| (i as f64).ln()).sum::<f64>();
        let rest = n - b - c;
        let coefficient =
            log_factorial(n) - log_factorial(b) - log_factorial(c) - log_factorial(rest);
        let power = |k: u64, p: f64| k as f64 * p.ln();
        (coefficient + power(b, p) + power(c, q) + power(rest, 1.0 - p - q)).exp()
    }
}
