//! Equivalence of two proportions by score tests.
//!
//! Each one-sided test takes the variance at the rates that are most likely when the difference is
//! exactly the margin, instead of the rates seen. With `q1 - q2 = d0`, `d0 = -m` and `d0 = m`,
//!
//! ```text
//! z = (p1 - p2 - d0) / sqrt(q1 (1-q1)/n1 + q2 (1-q2)/n2),   p-value = max of the two tails
//! ```
//!
//! and `q1` is the middle root of a cubic, in closed form.
//!
//! Source: C. P. Farrington and G. Manning, "Test statistics and sample size formulae for
//! comparative binomial trials with null hypothesis of non-zero risk difference" (1990); the root
//! by O. Miettinen and M. Nurminen, "Comparative analysis of two rates" (1985), appendix.
//! Deviation: none. Cost: constant. Guarantee: asymptotic; [`crate::exact_equivalence()`] keeps its level. The larger of this p-value and that of
//! [`crate::tost`] with Agresti and Caffo's variance errs at most 5.5 % of the time at a level of
//! 5 %, over margins of 5, 10 and 20 points and 30 to 1000 trials a side (summed over all counts at
//! rates in steps of a point); alone, the two err up to 6.3 % and 8.9 %. With 5 to 29 trials on one
//! side and 5 to 100 on the other it never shows a margin of 5 points, and errs at most 5.8 % at 10
//! points, 6.9 % at 20, 7.6 % at 30 and 8.4 % at 40 and 50 (rates in steps of a quarter of a point);
//! at margins of 70 points and more, up to 19 %. It is no exact test: of one success in one trial on
//! either side and a margin of 99 points it is 0.005, where rates that far apart have that outcome
//! with probability 0.01.
//!
//! # Assumes
//! Trials of each sample are independent with one rate, the samples are independent of each other, and sizes were fixed in
//! advance. Counts are large: the errors above say what few of them do.

use crate::counts::EffectiveSample;
use crate::special::normal_sf;

/// The p-value of "the rates differ by `margin` or more"; `None` when either sample carries no
/// information or the margin is not between 0 and 1.
///
/// ```
/// use stats::{Sample, score_equivalence};
/// let (experiment, simulation) = (Sample::new(88, 100)?, Sample::new(439, 500)?);
/// assert!(score_equivalence(experiment, simulation, 0.05) > Some(0.05));
/// assert!(score_equivalence(experiment, simulation, 0.10) < Some(0.05));
/// # Ok::<(), stats::StatsError>(())
/// ```
#[must_use]
pub fn score_equivalence(
    first: impl Into<EffectiveSample>,
    second: impl Into<EffectiveSample>,
    margin: f64,
) -> Option<f64> {
    let (first, second) = (first.into(), second.into());
    let valid = first.is_informative() && second.is_informative() && margin > 0.0;
    if !valid || margin >= 1.0 {
        return None;
    }
    let not_below = normal_sf(score(first, second, -margin));
    let not_above = normal_sf(-score(first, second, margin));
    Some(not_below.max(not_above))
}

/// The standardised distance of the difference seen from `difference`.
fn score(first: EffectiveSample, second: EffectiveSample, difference: f64) -> f64 {
    let (p1, p2) = (
        first.successes / first.trials,
        second.successes / second.trials,
    );
    let q1 = restricted_rate(
        (first.successes, first.trials),
        (second.successes, second.trials),
        difference,
    );
    let q2 = (q1 - difference).clamp(0.0, 1.0);
    let variance = q1 * (1.0 - q1) / first.trials + q2 * (1.0 - q2) / second.trials;
    let distance = p1 - p2 - difference;
    if variance > 0.0 {
        distance / variance.sqrt()
    } else if distance == 0.0 {
        0.0
    } else {
        distance.signum() * f64::INFINITY
    }
}

/// The most likely first rate when the first less the second is `difference`; of successes and trials.
pub(crate) fn restricted_rate(first: (f64, f64), second: (f64, f64), difference: f64) -> f64 {
    let ratio = second.1 / first.1;
    let (p1, p2, d) = (first.0 / first.1, second.0 / second.1, difference);
    // a q^3 + b q^2 + c q + e = 0
    let a = 1.0 + ratio;
    let b = -(1.0 + ratio + p1 + ratio * p2 + d * (ratio + 2.0));
    let c = d * d + d * (2.0 * p1 + ratio + 1.0) + p1 + ratio * p2;
    let e = -p1 * d * (1.0 + d);
    let shift = b / (3.0 * a);
    let v = shift.powi(3) - b * c / (6.0 * a * a) + e / (2.0 * a);
    let size = (shift * shift - c / (3.0 * a)).max(0.0).sqrt();
    let u = if v < 0.0 { -size } else { size };
    let root = if size > 0.0 {
        let angle = (v / u.powi(3)).clamp(-1.0, 1.0).acos();
        2.0 * u * ((std::f64::consts::PI + angle) / 3.0).cos() - shift
    } else {
        -shift
    };
    root.clamp(d.max(0.0), (1.0 + d).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counts::Sample;
    use crate::equivalence::{DifferenceVariance, tost};
    use crate::special::binomial_pmf;

    fn p(a: u64, n: u64, b: u64, m: u64, margin: f64) -> Option<f64> {
        score_equivalence(
            Sample {
                successes: a,
                trials: n,
            },
            Sample {
                successes: b,
                trials: m,
            },
            margin,
        )
    }

    /// By scipy 1.16: the restricted likelihood maximised numerically (minimize_scalar), not by the
    /// root; the larger p-value. (statsmodels 0.14 has a slip in the linear term of its cubic.)
    #[test]
    fn reference_values() {
        let cases = [
            ((88, 100, 439, 500, 0.05), 0.09566783472),
            ((88, 100, 439, 500, 0.1), 0.009067313077),
            ((20, 40, 33, 60, 0.3), 0.005117856197),
            ((40, 40, 79, 80, 0.1), 0.012348338722),
            ((0, 12, 1, 30, 0.2), 0.028893177515),
            ((5, 5, 9, 9, 0.5), 0.01267366),
        ];
        for ((a, n, b, m, margin), expected) in cases {
            let (found, back) = (
                p(a, n, b, m, margin).unwrap(),
                p(b, m, a, n, margin).unwrap(),
            );
            assert!(
                (found / expected - 1.0).abs() < 1e-6,
                "{a}/{n} {b}/{m}: {found} {expected}"
            );
            assert!((found / back - 1.0).abs() < 1e-6, "{found} {back}");
        }
    }

    #[test]
    fn what_says_nothing_shows_nothing() {
        assert_eq!(p(0, 0, 3, 4, 0.1), None);
        assert_eq!(p(3, 4, 3, 4, 0.0), None);
        assert_eq!(p(3, 4, 3, 4, f64::NAN), None);
        assert!(p(0, 10, 10, 10, 0.3).unwrap() > 0.999);
        assert!(p(10_000, 10_000, 10_000, 10_000, 0.01).unwrap() < 1e-9);
    }

    /// At the edge of the margin, together with Agresti and Caffo's variance.
    #[test]
    fn agreement_is_claimed_falsely_as_rarely_as_stated() {
        for (n, m, margin) in [(40_u64, 80_u64, 0.2), (60, 60, 0.1), (100, 200, 0.2)] {
            for (rate, other) in [
                (0.95, 0.95 - margin),
                (0.9 - margin, 0.9),
                (0.6, 0.6 - margin),
            ] {
                let mut chance = 0.0;
                for a in 0..=n {
                    for b in 0..=m {
                        let (first, second) = (
                            Sample {
                                successes: a,
                                trials: n,
                            },
                            Sample {
                                successes: b,
                                trials: m,
                            },
                        );
                        let wald = tost(first, second, margin, DifferenceVariance::AgrestiCaffo)
                            .unwrap()
                            .p_value();
                        if wald.max(p(a, n, b, m, margin).unwrap()) <= 0.05 {
                            chance += binomial_pmf(a, n, rate) * binomial_pmf(b, m, other);
                        }
                    }
                }
                assert!(chance <= 0.055, "{n} {m} {margin} {rate}: {chance}");
            }
        }
    }
}
