//! Two proportions on the same trials: matched pairs.
//!
//! # Definition
//! Of `n` pairs, `b` succeed only the first time and `c` only the second. The difference of the
//! proportions is `(c - b)/n`. Its interval holds the differences `d` that the score test does not reject:
//! `|c - b - n d| <= z sqrt(n (2 q + d (1 - d)))`, where `q` is the most likely probability of "only the first time" if
//! the difference is `d`, the greater root of `2 n q^2 + ((2 n - c + b) d - b - c) q - b d (1 - d) = 0`. Both ends
//! are found by bisection.
//! The test is exact: given `b + c`, `b` is binomial with one half if nothing differs.
//!
//! Source: T. Tango, "Equivalence test and confidence interval for the difference in proportions for the
//! paired-sample design", Statistics in Medicine 17 (1998), 891-908; Q. McNemar, Psychometrika 12 (1947),
//! 153-157. Deviation: where the exact test does not reject "nothing differs", the interval reaches to 0, so that the two never
//! contradict each other (4 pairs of 4 that change one way have p = 0.125). Cost: that of one binomial test. Guarantee: the interval is
//! approximate; its coverage stays near the level or above it also where hardly a pair differs, where Wald's and adjusted ones fall
//! to 86 %. The test is exact up to rounding.
//!
//! # Assumes
//! Pairs are independent of each other, with the same probabilities of the four outcomes, and fixed in number. Within a
//! pair the two trials may depend on each other in any way.

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
    /// use stats::{Confidence, Pairs};
    /// let pairs = Pairs { pairs: 100, only_first: 3, only_second: 13 };
    /// assert_eq!(pairs.interval(Confidence::P95).to_string(), "[0.0244, 0.1855]");
    /// ```
    #[must_use]
    pub fn interval(&self, confidence: Confidence) -> Interval {
        if self.pairs == 0 {
            return Interval {
                low: -1.0,
                high: 1.0,
            };
        }
        let z = -normal_quantile(0.5 * confidence.alpha());
        let own = self.difference().unwrap_or(0.0);
        let (low, high) = (self.farthest(own, -1.0, z), self.farthest(own, 1.0, z));
        match self.p_value() > confidence.alpha() {
            true => Interval {
                low: low.min(0.0),
                high: high.max(0.0),
            },
            false => Interval { low, high },
        }
    }

    /// The difference nearest to `end` that is not rejected.
    fn farthest(&self, own: f64, end: f64, z: f64) -> f64 {
        let is_kept = |difference: f64| self.score(difference).abs() <= z;
        if is_kept(end) {
            return end;
        }
        let (mut kept, mut rejected) = (own, end);
        // To the precision of a double near 1.
        for _ in 0..60 {
            let middle = 0.5 * (kept + rejected);
            if is_kept(middle) {
                kept = middle;
            } else {
                rejected = middle;
            }
        }
        kept
    }

    /// Tango's score statistic of a difference, second minus first.
    fn score(&self, difference: f64) -> f64 {
        let n = self.pairs as f64;
        // Named as in the source: there the first of the two exceeds the second by the difference.
        let (b, c) = (self.only_second as f64, self.only_first as f64);
        let linear = (2.0 * n - b + c) * difference - b - c;
        let constant = -c * difference * (1.0 - difference);
        let root = (linear * linear - 8.0 * n * constant).max(0.0).sqrt();
        let q = (root - linear) / (4.0 * n);
        let variance = n * (2.0 * q + difference * (1.0 - difference));
        let excess = b - c - n * difference;
        match variance > 0.0 {
            true => excess / variance.sqrt(),
            // Without variance a difference is either the observed one or impossible.
            false if excess.abs() < 1e-12 => 0.0,
            false => f64::INFINITY.copysign(excess),
        }
    }

    /// The two-sided exact p-value of "nothing differs".
    #[must_use]
    pub fn p_value(&self) -> f64 {
        let sample = Sample {
            successes: self.only_second,
            trials: self.only_first.saturating_add(self.only_second),
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
    fn an_interval_without_zero_has_an_exact_p_value_below_its_level() {
        for pairs in [12, 40, 400] {
            for only_first in 0..=12 {
                for only_second in 0..=(12_u64.min(pairs - only_first)) {
                    let of = Pairs {
                        pairs,
                        only_first,
                        only_second,
                    };
                    let interval = of.interval(Confidence::P95);
                    let holds = interval.low <= 0.0 && interval.high >= 0.0;
                    assert_eq!(holds, of.p_value() > 0.05, "{of:?} {interval:?}");
                }
            }
        }
    }

    /// By scipy 1.17: the likelihood of the three cells maximised under each difference
    /// (`optimize.minimize_scalar`), the score test inverted by `optimize.brentq`.
    #[test]
    fn intervals_are_those_of_the_inverted_score_test() {
        for (pairs, only_first, only_second, low, high) in [
            (100, 3, 13, 0.02437633998793578, 0.18548344031489622),
            (44, 14, 1, -0.44967862836446043, -0.14497611518958042),
            (200, 0, 0, -0.01884532637726762, 0.01884532637726762),
            (200, 0, 3, -0.004128006245186566, 0.04316572879269175),
            (30, 5, 5, -0.2154715555, 0.2154715555),
        ] {
            let of = Pairs {
                pairs,
                only_first,
                only_second,
            };
            let interval = of.interval(Confidence::P95);
            assert!((interval.low - low).abs() < 1e-8, "{of:?} {interval:?}");
            assert!((interval.high - high).abs() < 1e-8, "{of:?} {interval:?}");
        }
        let all = Pairs {
            pairs: 10,
            only_first: 0,
            only_second: 10,
        };
        let interval = all.interval(Confidence::P95);
        assert!(interval.high == 1.0 && interval.low > 0.4, "{interval:?}");
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
        assert!(width(10) > 0.25 && width(1000) < 0.008 && width(0) == 2.0);
        assert_eq!(of(0).difference(), None);
    }

    /// Near the level for matched pairs of known cells, also where hardly any differ.
    #[test]
    fn the_interval_covers() {
        for (n, first, second) in [
            (30, 0.1, 0.25),
            (200, 1e-9, 0.01),
            (100, 1e-9, 0.02),
            (100, 0.005, 0.01),
            (50, 0.2, 0.2),
        ] {
            let covered = coverage(n, first, second);
            assert!(
                (0.93..0.9995).contains(&covered),
                "{n} {first} {second}: {covered}"
            );
        }
    }

    fn coverage(n: u64, first: f64, second: f64) -> f64 {
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
        covered
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
