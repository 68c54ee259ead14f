//! Intervals and one-sided limits for one proportion.
//!
//! With `s` successes in `n` trials, `p = s/n` and `z` the normal quantile of the tail `t`
//! (`t = alpha/2` for an interval, `alpha` for a one-sided limit):
//!
//! * Wilson (1927): the `p0` with `(p - p0)^2 <= z^2 p0 (1-p0) / n`;
//! * Agresti and Coull (1998): `p' +- z sqrt(p'(1-p')/n')`, `n' = n + z^2`, `p' = (s + z^2/2)/n'`;
//! * Clopper and Pearson (1934): the `p0` that the exact binomial test does not reject,
//!   `Beta(s, n-s+1)` at `t` and `Beta(s+1, n-s)` at `1 - t`;
//! * Jeffreys: quantiles of `Beta(s + 1/2, n-s + 1/2)`, with 0 and 1 as ends when `s = 0` and
//!   `s = n` (Brown, Cai and DasGupta, "Interval estimation for a binomial proportion", 2001).
//!
//! Deviation: Wilson's ends are formed from the product of the roots, so that they are exactly 0
//! and 1 at `s = 0` and `s = n` and keep their digits near them. Fractional counts are accepted,
//! for effective sample sizes. Guarantee: Clopper-Pearson covers at least at its level; the
//! others cover at their level on average over p.
//!
//! # Assumes
//! Trials are independent with one rate, and their number was fixed in advance. Fractional counts stand for trials that are
//! alike: of these no method here covers exactly.

use crate::counts::{Confidence, EffectiveSample, Interval};
use crate::special::{beta_quantile, beta_quantile_upper, normal_quantile};

/// How an interval for a proportion is formed; see the module documentation for definitions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum IntervalMethod {
    /// Wilson's score interval: the default for reporting.
    Wilson,
    /// Agresti and Coull's adjusted interval, with z squared trials added.
    AgrestiCoull,
    /// Clopper and Pearson's exact interval: never covers less than its level.
    ClopperPearson,
    /// The equal-tailed interval of the posterior under Jeffreys' prior.
    Jeffreys,
}

impl IntervalMethod {
    /// All methods, in the order of their definition.
    pub const ALL: [Self; 4] = [
        Self::Wilson,
        Self::AgrestiCoull,
        Self::ClopperPearson,
        Self::Jeffreys,
    ];

    /// The customary name, as a reader of a report expects it.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Wilson => "Wilson",
            Self::AgrestiCoull => "Agresti-Coull",
            Self::ClopperPearson => "Clopper-Pearson",
            Self::Jeffreys => "Jeffreys",
        }
    }

    /// The two-sided interval at `confidence`.
    #[must_use]
    pub fn interval(&self, sample: impl Into<EffectiveSample>, confidence: Confidence) -> Interval {
        self.limits(sample.into(), 0.5 * confidence.alpha())
    }

    /// The one-sided lower limit: with `confidence`, the proportion is at least this.
    #[must_use]
    pub fn lower_limit(&self, sample: impl Into<EffectiveSample>, confidence: Confidence) -> f64 {
        self.limits(sample.into(), confidence.alpha()).low
    }

    /// The one-sided upper limit: with `confidence`, the proportion is at most this.
    #[must_use]
    pub fn upper_limit(&self, sample: impl Into<EffectiveSample>, confidence: Confidence) -> f64 {
        self.limits(sample.into(), confidence.alpha()).high
    }

    /// Limits that leave the probability `tail` on each side.
    fn limits(&self, sample: EffectiveSample, tail: f64) -> Interval {
        if !sample.is_informative() {
            return Interval::VACUOUS;
        }
        match self {
            Self::Wilson => wilson_limits(sample, tail),
            Self::AgrestiCoull => agresti_coull_limits(sample, tail),
            Self::ClopperPearson => clopper_pearson_limits(sample, tail),
            Self::Jeffreys => jeffreys_limits(sample, tail),
        }
    }
}

/// Wilson's score interval; short for [`IntervalMethod::Wilson`]`.interval(..)`.
#[must_use]
pub fn wilson(sample: impl Into<EffectiveSample>, confidence: Confidence) -> Interval {
    IntervalMethod::Wilson.interval(sample, confidence)
}

/// Agresti and Coull's interval; short for [`IntervalMethod::AgrestiCoull`]`.interval(..)`.
#[must_use]
pub fn agresti_coull(sample: impl Into<EffectiveSample>, confidence: Confidence) -> Interval {
    IntervalMethod::AgrestiCoull.interval(sample, confidence)
}

/// Clopper and Pearson's interval; short for [`IntervalMethod::ClopperPearson`]`.interval(..)`.
#[must_use]
pub fn clopper_pearson(sample: impl Into<EffectiveSample>, confidence: Confidence) -> Interval {
    IntervalMethod::ClopperPearson.interval(sample, confidence)
}

/// Jeffreys' interval; short for [`IntervalMethod::Jeffreys`]`.interval(..)`.
#[must_use]
pub fn jeffreys(sample: impl Into<EffectiveSample>, confidence: Confidence) -> Interval {
    IntervalMethod::Jeffreys.interval(sample, confidence)
}

fn wilson_limits(sample: EffectiveSample, tail: f64) -> Interval {
    let EffectiveSample {
        successes: s,
        trials: n,
    } = sample;
    let f = sample.failures();
    let z = -normal_quantile(tail);
    let square = z * z;
    let root = z * (s * f / n + 0.25 * square).sqrt();
    // Ends seen from their far side, where nothing cancels; the product of the roots of Wilson's
    // quadratic is s^2 / (n (n + z^2)), and likewise for failures.
    let high = (s + 0.5 * square + root) / (n + square);
    let high_of_failures = (f + 0.5 * square + root) / (n + square);
    let low = s * s / (n * (n + square) * high);
    let low_of_failures = f * f / (n * (n + square) * high_of_failures);
    if z < 0.0 {
        // A tail above one half swaps the roots.
        return Interval {
            low: high,
            high: low,
        };
    }
    let high = if low_of_failures < 0.5 {
        1.0 - low_of_failures
    } else {
        high
    };
    Interval { low, high }
}

fn agresti_coull_limits(sample: EffectiveSample, tail: f64) -> Interval {
    let z = -normal_quantile(tail);
    let trials = sample.trials + z * z;
    let centre = (sample.successes + 0.5 * z * z) / trials;
    let half_width = z * (centre * (1.0 - centre) / trials).sqrt();
    Interval {
        low: (centre - half_width).max(0.0),
        high: (centre + half_width).min(1.0),
    }
}

fn clopper_pearson_limits(sample: EffectiveSample, tail: f64) -> Interval {
    let (s, f) = (sample.successes, sample.failures());
    Interval {
        low: if s > 0.0 {
            beta_quantile(s, f + 1.0, tail)
        } else {
            0.0
        },
        high: if f > 0.0 {
            beta_quantile_upper(s + 1.0, f, tail)
        } else {
            1.0
        },
    }
}

fn jeffreys_limits(sample: EffectiveSample, tail: f64) -> Interval {
    let (s, f) = (sample.successes, sample.failures());
    Interval {
        low: if s > 0.0 {
            beta_quantile(s + 0.5, f + 0.5, tail)
        } else {
            0.0
        },
        high: if f > 0.0 {
            beta_quantile_upper(s + 0.5, f + 0.5, tail)
        } else {
            1.0
        },
    }
}
