//! Whether two proportions are the same within a margin, and whether they differ.
//!
//! Two one-sided tests (TOST): with `d = p1 - p2` and its standard error `se`,
//!
//! ```text
//! p-value = max( P(Z > (d + m)/se), P(Z > (m - d)/se) )
//! ```
//!
//! and equivalence within the margin `m` is shown at level `alpha` when it is at most `alpha`.
//! Wald's variance is `p1 q1/n1 + p2 q2/n2`; Agresti and Caffo's adds one success and one
//! failure to each sample, for the estimates and for the variance.
//!
//! The interval of a difference is put together from an interval `[l_i, u_i]` for each side, of
//! whatever kind (MOVER; with Wilson's intervals it is Newcombe's hybrid score interval):
//!
//! ```text
//! d - sqrt((p1 - l1)^2 + (u2 - p2)^2)   to   d + sqrt((u1 - p1)^2 + (p2 - l2)^2)
//! ```
//!
//! Source: D. J. Schuirmann, "A comparison of the two one-sided tests procedure and the power
//! approach" (1987); A. Agresti and B. Caffo, "Simple and effective confidence intervals for
//! proportions and differences of proportions" (2000); R. G. Newcombe, "Interval estimation for
//! the difference between independent proportions" (1998), method 10; G. Y. Zou and A. Donner,
//! "Construction of confidence limits about effect measures" (2008). Deviation: none. Cost: constant.
//! Guarantee: asymptotic level; Wald's variance is zero at 0 of n and n of n and must not be
//! used there, Agresti and Caffo's is close to its level from about 10 trials on.
//!
//! # Assumes
//! Trials of each sample are independent with one rate, the samples are independent of each other, and sizes were fixed in
//! advance. The difference is taken as normal; [`difference_interval`] needs two independent sides alone, each with an
//! interval that holds.

use crate::counts::{Confidence, EffectiveSample, Interval};
use crate::special::{normal_quantile, normal_sf};

/// How the variance of a difference of two proportions is estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DifferenceVariance {
    /// The plug-in variance; degenerate when a rate is 0 or 1.
    Wald,
    /// With one success and one failure added to each sample; the default for reporting.
    AgrestiCaffo,
}

/// A difference of two proportions, first minus second, with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// First rate minus second rate.
    pub estimate: f64,
    /// Standard error of the estimate.
    pub standard_error: f64,
}

/// The result of the two one-sided tests of equivalence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tost {
    /// The difference that was tested.
    pub difference: Difference,
    /// The margin of equivalence, as a difference of proportions.
    pub margin: f64,
    /// p-value against "the first is lower by the margin or more".
    pub p_low: f64,
    /// p-value against "the first is higher by the margin or more".
    pub p_high: f64,
}

impl Tost {
    /// The p-value of the whole procedure, the larger of the two.
    #[must_use]
    pub fn p_value(&self) -> f64 {
        self.p_low.max(self.p_high)
    }
}

impl Difference {
    /// The difference of two samples; `None` when either carries no information.
    #[must_use]
    pub fn between(
        first: impl Into<EffectiveSample>,
        second: impl Into<EffectiveSample>,
        variance: DifferenceVariance,
    ) -> Option<Self> {
        let (first, second) = (first.into(), second.into());
        let (first_rate, first_variance) = estimate(first, variance)?;
        let (second_rate, second_variance) = estimate(second, variance)?;
        Some(Self {
            estimate: first_rate - second_rate,
            standard_error: (first_variance + second_variance).sqrt(),
        })
    }

    /// Normal-theory interval of the difference, within `[-1, 1]`.
    #[must_use]
    pub fn interval(&self, confidence: Confidence) -> Interval {
        let half_width = -normal_quantile(0.5 * confidence.alpha()) * self.standard_error;
        Interval {
            low: (self.estimate - half_width).max(-1.0),
            high: (self.estimate + half_width).min(1.0),
        }
    }

    /// Two-sided p-value of "no difference".
    #[must_use]
    pub fn p_value(&self) -> f64 {
        (2.0 * upper_tail(self.estimate.abs(), self.standard_error)).min(1.0)
    }

    /// The two one-sided tests of equivalence within `margin`.
    #[must_use]
    pub fn tost(&self, margin: f64) -> Tost {
        Tost {
            difference: *self,
            margin,
            p_low: upper_tail(self.estimate + margin, self.standard_error),
            p_high: upper_tail(margin - self.estimate, self.standard_error),
        }
    }
}

/// The two one-sided tests of equivalence of two samples within `margin`; `None` when either
/// carries no information.
#[must_use]
pub fn tost(
    first: impl Into<EffectiveSample>,
    second: impl Into<EffectiveSample>,
    margin: f64,
    variance: DifferenceVariance,
) -> Option<Tost> {
    Some(Difference::between(first, second, variance)?.tost(margin))
}

/// The interval of first minus second, from an estimate and an interval of each at one level.
/// It contains the difference of the estimates whenever each estimate is in its interval.
#[must_use]
pub fn difference_interval(first: (f64, Interval), second: (f64, Interval)) -> Interval {
    let ((p1, first), (p2, second)) = (first, second);
    let difference = p1 - p2;
    Interval {
        low: (difference - (p1 - first.low).hypot(second.high - p2)).max(-1.0),
        high: (difference + (first.high - p1).hypot(p2 - second.low)).min(1.0),
    }
}

/// `P(Z > x / se)`, where no standard error at all makes every positive `x` certain and proves
/// nothing about the others.
fn upper_tail(x: f64, standard_error: f64) -> f64 {
    match (standard_error > 0.0, x > 0.0) {
        (true, _) => normal_sf(x / standard_error),
        (false, true) => 0.0,
        (false, false) => 1.0,
    }
}

/// Rate and variance of one sample.
fn estimate(sample: EffectiveSample, variance: DifferenceVariance) -> Option<(f64, f64)> {
    if !sample.is_informative() {
        return None;
    }
    let (successes, trials) = match variance {
        DifferenceVariance::Wald => (sample.successes, sample.trials),
        DifferenceVariance::AgrestiCaffo => (sample.successes + 1.0, sample.trials + 2.0),
    };
    let rate = successes / trials;
    Some((rate, rate * (1.0 - rate) / trials))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counts::Sample;

    const EXPERIMENT: Sample = Sample {
        successes: 88,
        trials: 100,
    };
    const SIMULATION: Sample = Sample {
        successes: 439,
        trials: 500,
    };

    fn p(margin: f64, variance: DifferenceVariance) -> f64 {
        tost(EXPERIMENT, SIMULATION, margin, variance)
            .unwrap()
            .p_value()
    }

    fn close(found: f64, expected: f64) {
        assert!(
            (found / expected - 1.0).abs() < 1e-11,
            "found {found:e}, expected {expected:e}"
        );
    }

    #[test]
    fn reference_values() {
        // numpy and scipy 1.16: norm.sf of the formula above, both variances.
        close(
            p(0.05, DifferenceVariance::AgrestiCaffo),
            0.10125328601142825,
        );
        close(p(0.05, DifferenceVariance::Wald), 0.08902402326494924);
        close(
            p(0.1, DifferenceVariance::AgrestiCaffo),
            0.003929684870619503,
        );
        close(p(0.1, DifferenceVariance::Wald), 0.0029825363767991137);
    }

    #[test]
    fn the_order_of_the_samples_does_not_matter() {
        let forth = tost(EXPERIMENT, SIMULATION, 0.05, DifferenceVariance::Wald).unwrap();
        let back = tost(SIMULATION, EXPERIMENT, 0.05, DifferenceVariance::Wald).unwrap();
        assert_eq!(forth.p_low, back.p_high);
        assert_eq!(forth.p_value(), back.p_value());
    }

    #[test]
    fn equivalence_at_alpha_is_the_interval_at_two_alpha_inside_the_margin() {
        let difference =
            Difference::between(EXPERIMENT, SIMULATION, DifferenceVariance::AgrestiCaffo).unwrap();
        let interval = difference.interval(Confidence::P90);
        let margin = interval.high.abs().max(interval.low.abs());
        close(difference.tost(margin).p_value(), 0.05);
    }

    #[test]
    fn newcombes_examples() {
        // Newcombe (1998), table II, method 10: 56/70 - 48/80 and 10/10 - 0/20 (four decimals).
        let interval = |a, n, b, m| {
            let side = |successes, trials| {
                let sample = Sample { successes, trials };
                (
                    sample.rate().unwrap(),
                    crate::wilson(sample, Confidence::P95),
                )
            };
            difference_interval(side(a, n), side(b, m))
        };
        assert_eq!(interval(56, 70, 48, 80).to_string(), "[0.0524, 0.3339]");
        assert_eq!(interval(10, 10, 0, 20).to_string(), "[0.6791, 1.0000]");
    }

    #[test]
    fn no_variance_and_no_information() {
        let all = Sample {
            successes: 9,
            trials: 9,
        };
        let certain = tost(all, all, 0.05, DifferenceVariance::Wald).unwrap();
        assert_eq!(certain.p_value(), 0.0);
        assert!(
            tost(all, all, 0.05, DifferenceVariance::AgrestiCaffo)
                .unwrap()
                .p_value()
                > 0.3
        );
        assert_eq!(
            tost(all, all, 0.0, DifferenceVariance::Wald)
                .unwrap()
                .p_value(),
            1.0
        );
        let none = Sample {
            successes: 0,
            trials: 0,
        };
        assert_eq!(tost(all, none, 0.05, DifferenceVariance::Wald), None);
    }
}
