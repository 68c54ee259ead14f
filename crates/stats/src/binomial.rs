//! The exact binomial test of a proportion against a threshold.
//!
//! ```text
//! P(X <= s) = I_(1-p0)(n-s, s+1),   P(X >= s) = I_p0(s, n-s+1),   X ~ Binomial(n, p0)
//! ```
//!
//! The two-sided p-value is the probability of all outcomes that are no more likely than the
//! one observed. Source: C. J. Clopper and E. S. Pearson (1934); the two-sided rule is that of
//! the method of small p-values (J. D. Gibbons and J. W. Pratt, 1975). Deviation: the one-sided
//! tests accept fractional counts, as the beta integral does, so that they can be used at an
//! effective sample size; two-sided tails are sums of densities outwards, ended when the rest
//! cannot change them. Cost: O(sqrt(n)). Guarantee: exact up to rounding; conservative.
//!
//! # Assumes
//! Trials are independent with one rate, and their number was fixed in advance. Counts at an effective size stand for
//! trials that are alike: of these no test here is exact ([`mod@crate::clustered`] has its errors).

use crate::counts::{EffectiveSample, Sample};
use crate::special::{beta_cdf, beta_sf, binomial_pmf};

/// Outcomes whose probabilities differ by less than this share count as equally likely: the
/// rounding error of a density must not exclude the observed outcome's twin.
pub(crate) const EQUAL_LIKELIHOOD: f64 = 1e-7;

/// `P(X <= successes)` when the true proportion is `threshold`: a small value is evidence that
/// the proportion is below the threshold.
#[must_use]
pub fn binomial_test_below(sample: impl Into<EffectiveSample>, threshold: f64) -> f64 {
    let sample = sample.into();
    if !sample.is_informative() || sample.failures() <= 0.0 || threshold <= 0.0 {
        return 1.0;
    }
    beta_sf(sample.successes + 1.0, sample.failures(), threshold)
}

/// `P(X >= successes)` when the true proportion is `threshold`: a small value is evidence that
/// the proportion is above the threshold.
#[must_use]
pub fn binomial_test_above(sample: impl Into<EffectiveSample>, threshold: f64) -> f64 {
    let sample = sample.into();
    if !sample.is_informative() || sample.successes <= 0.0 || threshold >= 1.0 {
        return 1.0;
    }
    beta_cdf(sample.successes, sample.failures() + 1.0, threshold)
}

/// The two-sided exact p-value of the proportion being `threshold`; 1 where that is no number.
#[must_use]
pub fn binomial_test_two_sided(sample: Sample, threshold: f64) -> f64 {
    if !sample.is_informative() {
        return 1.0;
    }
    let Sample { successes, trials } = sample;
    let mean = trials as f64 * threshold;
    let mode = (((trials + 1) as f64) * threshold)
        .floor()
        .min(trials as f64) as u64;
    let pmf = |k: u64| binomial_pmf(k, trials, threshold);
    let limit = pmf(successes) * (1.0 + EQUAL_LIKELIHOOD);
    if pmf(mode) <= limit {
        return 1.0;
    }
    let other = if (successes as f64) < mean {
        let first = first_at_most(mode, trials, limit, &pmf);
        binomial_test_below(sample, threshold) + upper_tail_from(first, trials, threshold)
    } else {
        let first = first_at_most_downwards(mode, limit, &pmf);
        binomial_test_above(sample, threshold) + lower_tail_to(first, trials, threshold)
    };
    other.min(1.0)
}

/// `P(X >= first)`, where `None` stands for no outcome.
fn upper_tail_from(first: Option<u64>, trials: u64, threshold: f64) -> f64 {
    first.map_or(0.0, |successes| {
        binomial_test_above(Sample { successes, trials }, threshold)
    })
}

/// `P(X <= last)`, where `None` stands for no outcome.
fn lower_tail_to(last: Option<u64>, trials: u64, threshold: f64) -> f64 {
    last.map_or(0.0, |successes| {
        binomial_test_below(Sample { successes, trials }, threshold)
    })
}

/// The first outcome above `mode` with density at most `limit`; densities fall from the mode on.
pub(crate) fn first_at_most(
    mode: u64,
    last: u64,
    limit: f64,
    pmf: &impl Fn(u64) -> f64,
) -> Option<u64> {
    if pmf(last) > limit {
        return None;
    }
    let (mut above, mut at_most) = (mode, last);
    while at_most - above > 1 {
        let middle = above + (at_most - above) / 2;
        if pmf(middle) <= limit {
            at_most = middle
        } else {
            above = middle
        }
    }
    Some(at_most)
}

/// The first outcome below `mode`, counting down, with density at most `limit`.
fn first_at_most_downwards(mode: u64, limit: f64, pmf: &impl Fn(u64) -> f64) -> Option<u64> {
    first_at_most(0, mode, limit, &|distance| pmf(mode - distance)).map(|distance| mode - distance)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, expected: f64) {
        assert!(
            (found / expected - 1.0).abs() < 1e-11,
            "found {found:e}, expected {expected:e}"
        );
    }

    #[test]
    fn reference_values() {
        // scipy 1.16: binom.cdf(88, 100, .95), binom.sf(87, 100, .8),
        // binomtest(7, 20, .5).pvalue, binomtest(88, 100, .8).pvalue
        let sample = Sample {
            successes: 88,
            trials: 100,
        };
        close(binomial_test_below(sample, 0.95), 0.0042741824663659524);
        close(binomial_test_above(sample, 0.8), 0.02532875322139703);
        close(
            binomial_test_two_sided(
                Sample {
                    successes: 7,
                    trials: 20,
                },
                0.5,
            ),
            0.26317596435546875,
        );
        close(binomial_test_two_sided(sample, 0.8), 0.04534895995356946);
        close(
            binomial_test_two_sided(
                Sample {
                    successes: 0,
                    trials: 12,
                },
                0.3,
            ),
            0.02333065833100001,
        );
        close(
            binomial_test_two_sided(
                Sample {
                    successes: 50_010_000,
                    trials: 100_000_000,
                },
                0.5,
            ),
            0.045511062629572274,
        );
    }

    #[test]
    fn the_ends_and_nothing() {
        let none = Sample {
            successes: 0,
            trials: 0,
        };
        assert_eq!(binomial_test_below(none, 0.5), 1.0);
        assert_eq!(binomial_test_two_sided(none, 0.5), 1.0);
        let all = Sample {
            successes: 5,
            trials: 5,
        };
        close(binomial_test_above(all, 0.5), 0.03125);
        assert_eq!(binomial_test_below(all, 0.5), 1.0);
        close(binomial_test_two_sided(all, 0.5), 0.0625);
        assert_eq!(binomial_test_two_sided(all, 1.0), 1.0);
        // A rate of nothing in nothing is no number, and rejects nothing.
        let some = Sample {
            successes: 3,
            trials: 9,
        };
        assert_eq!(binomial_test_two_sided(some, f64::NAN), 1.0);
        assert_eq!(
            binomial_test_below(
                Sample {
                    successes: 4,
                    trials: 5
                },
                1.0
            ),
            0.0
        );
    }
}
