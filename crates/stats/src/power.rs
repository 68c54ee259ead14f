//! How many trials it takes to show that two proportions agree, or that they differ.
//!
//! With `se = sqrt(p1 q1/n1 + p2 q2/n2)`, `z` the normal quantile of `1 - alpha` (equivalence) or
//! `1 - alpha/2` (difference), and `d = p1 - p2`, the power of
//!
//! ```text
//! equivalence within m:  max(0, Phi((m-d)/se - z) + Phi((m+d)/se - z) - 1)
//! a difference:          Phi(|d|/se - z) + Phi(-|d|/se - z)
//! ```
//!
//! and for `d = 0` equivalence takes `n = 2 p q (z_(1-alpha) + z_((1+power)/2))^2 / m^2` an arm.
//!
//! Source: S.-C. Chow, J. Shao and H. Wang, "Sample size calculations in clinical research"
//! (2008), sections 4.2.2 and 4.2.3. Deviation: unequal true rates and arms of unequal size are
//! allowed, by searching for the smallest size with the power. Cost: a few dozen evaluations.
//! Guarantee: planning figures by normal theory, not exact powers.
//!
//! # Assumes
//! The rates given are the true ones. Trials are independent, and so are the arms; the test is that of normal theory at one
//! look.

use crate::counts::{Confidence, EffectiveSample, StatsError};
use crate::special::{normal_cdf, normal_quantile};

/// Sizes beyond which a plan counts as impossible.
const MOST_TRIALS: u64 = 1_000_000_000_000;

/// One side of a comparison that is being planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arm {
    /// The rate that is taken for true.
    pub rate: f64,
    /// The variance of one trial that is taken for true.
    pub spread: f64,
    /// Independent trials so far; infinite when the rate is known.
    pub trials: f64,
}

impl Arm {
    /// A rate that is known exactly, as from a sound model.
    #[must_use]
    pub fn known(rate: f64) -> Self {
        Self::with_size(rate, f64::INFINITY)
    }

    /// A rate with the uncertainty that `trials` independent trials would leave.
    #[must_use]
    pub fn with_size(rate: f64, trials: f64) -> Self {
        Self {
            rate,
            spread: rate * (1.0 - rate),
            trials,
        }
    }

    /// An arm with the rate of a sample. Its variance is that of the rate after one success and
    /// one failure are added (Agresti and Caffo), so that a plan never rests on a variance of
    /// zero. An empty sample plans for 1/2.
    #[must_use]
    pub fn of(sample: impl Into<EffectiveSample>) -> Self {
        let sample = sample.into();
        let Some(rate) = sample.rate() else {
            return Self::with_size(0.5, 0.0);
        };
        let shrunken = (sample.successes + 1.0) / (sample.trials + 2.0);
        Self {
            rate,
            spread: shrunken * (1.0 - shrunken),
            trials: sample.trials,
        }
    }

    fn after(&self, further: u64) -> Self {
        Self {
            trials: self.trials + further as f64,
            ..*self
        }
    }

    fn variance(&self) -> f64 {
        if self.trials > 0.0 {
            self.spread / self.trials
        } else {
            f64::INFINITY
        }
    }
}

/// What a study is asked to show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// That the rates differ by less than this margin (TOST).
    Equivalence {
        /// The margin, as a difference of proportions.
        margin: f64,
    },
    /// That the rates differ (two-sided).
    Difference,
}

impl Goal {
    /// The probability of showing it when the arms' rates are the true ones, at significance
    /// level `1 - confidence`.
    #[must_use]
    pub fn power(&self, first: Arm, second: Arm, confidence: Confidence) -> f64 {
        let difference = first.rate - second.rate;
        let error = (first.variance() + second.variance()).sqrt();
        if error.is_infinite() {
            return 0.0;
        }
        match self {
            Self::Equivalence { margin } => {
                let z = -normal_quantile(confidence.alpha());
                let side = |room: f64| pass(room, error, z);
                (side(margin - difference) + side(margin + difference) - 1.0).max(0.0)
            }
            Self::Difference => {
                let z = -normal_quantile(0.5 * confidence.alpha());
                pass(difference.abs(), error, z) + pass(-difference.abs(), error, z)
            }
        }
    }
}

/// `Phi(room / error - z)`, continued to an error of zero.
fn pass(room: f64, error: f64, z: f64) -> f64 {
    match (error > 0.0, room > 0.0) {
        (true, _) => normal_cdf(room / error - z),
        (false, true) => 1.0,
        (false, false) => 0.0,
    }
}

/// Trials for each of two arms to show `goal` with probability `power`, when the true rates are
/// the two given; `None` when no number would do.
///
/// # Errors
/// [`StatsError::OutOfRange`] unless `0 < power < 1` and both rates are in `[0, 1]`.
pub fn trials_per_arm(
    goal: Goal,
    rates: (f64, f64),
    confidence: Confidence,
    power: f64,
) -> Result<Option<u64>, StatsError> {
    check(power, "power")?;
    for rate in [rates.0, rates.1] {
        if !(0.0..=1.0).contains(&rate) {
            let expected = "a number from 0 to 1";
            return Err(StatsError::OutOfRange {
                what: "rate",
                value: rate,
                expected,
            });
        }
    }
    let (first, second) = (Arm::with_size(rates.0, 0.0), Arm::with_size(rates.1, 0.0));
    Ok(smallest(|n| {
        goal.power(first.after(n), second.after(n), confidence) >= power
    }))
}

/// How many further independent trials would probably show a goal that is not shown yet, if the
/// rates seen so far are the true ones. `None` where no number would.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FurtherTrials {
    /// In the first arm, the second staying as it is.
    pub first: Option<u64>,
    /// In the second arm, the first staying as it is.
    pub second: Option<u64>,
    /// In each of both arms.
    pub both: Option<u64>,
}

/// Further trials for `goal`, to be shown with probability `power`. Trials of an arm whose rate
/// is known change nothing, and then `first` (or `second`) is `None`.
///
/// # Errors
/// [`StatsError::OutOfRange`] unless `0 < power < 1`.
pub fn further_trials(
    goal: Goal,
    first: Arm,
    second: Arm,
    confidence: Confidence,
    power: f64,
) -> Result<FurtherTrials, StatsError> {
    check(power, "power")?;
    let enough = |a: Arm, b: Arm| goal.power(a, b, confidence) >= power;
    Ok(FurtherTrials {
        first: smallest(|n| enough(first.after(n), second)),
        second: smallest(|n| enough(first, second.after(n))),
        both: smallest(|n| enough(first.after(n), second.after(n))),
    })
}

fn check(power: f64, what: &'static str) -> Result<(), StatsError> {
    if power > 0.0 && power < 1.0 {
        return Ok(());
    }
    let expected = "a number strictly between 0 and 1, such as 0.8";
    Err(StatsError::OutOfRange {
        what,
        value: power,
        expected,
    })
}

/// The smallest positive number that is enough, when more is always enough too.
fn smallest(enough: impl Fn(u64) -> bool) -> Option<u64> {
    let mut high = 1_u64;
    while !enough(high) {
        if high >= MOST_TRIALS {
            return None;
        }
        high *= 2;
    }
    let mut low = high / 2;
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if enough(middle) {
            high = middle
        } else {
            low = middle
        }
    }
    Some(high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counts::Sample;

    fn equivalence(margin: f64, rate: f64) -> Option<u64> {
        trials_per_arm(
            Goal::Equivalence { margin },
            (rate, rate),
            Confidence::P95,
            0.8,
        )
        .unwrap()
    }

    #[test]
    fn equivalence_takes_what_the_formula_says() {
        let z = normal_quantile(0.95) + normal_quantile(0.9);
        for margin in [0.1, 0.05, 0.02, 0.01] {
            for rate in [0.5, 0.88, 0.99] {
                let formula = 2.0 * rate * (1.0 - rate) * (z / margin).powi(2);
                assert_eq!(equivalence(margin, rate), Some(formula.ceil() as u64));
            }
        }
        assert_eq!(equivalence(0.05, 1.0), Some(1));
        assert_eq!(equivalence(0.0, 0.5), None);
    }

    #[test]
    fn a_difference_takes_what_the_formula_says() {
        // (z_.975 + z_.8)^2 (p1 q1 + p2 q2) / d^2 = 7.84888 * 0.2656 / 0.0064 = 325.73; the far
        // tail of the two-sided test is negligible here.
        let found = trials_per_arm(Goal::Difference, (0.8, 0.88), Confidence::P95, 0.8).unwrap();
        assert_eq!(found, Some(326));
        let same = trials_per_arm(Goal::Difference, (0.8, 0.8), Confidence::P95, 0.8).unwrap();
        assert_eq!(same, None);
    }

    #[test]
    fn one_arm_alone_may_never_do() {
        let goal = Goal::Equivalence { margin: 0.05 };
        let experiment = Arm::of(Sample {
            successes: 88,
            trials: 100,
        });
        let simulation = Arm::of(Sample {
            successes: 439,
            trials: 500,
        });
        let found = further_trials(goal, experiment, simulation, Confidence::P95, 0.8).unwrap();
        // The experiment's own variance leaves no room for equivalence, however many simulations.
        assert_eq!(found.second, None);
        let (first, both) = (found.first.unwrap(), found.both.unwrap());
        assert!(both < first, "{both} {first}");
        let power = |n| goal.power(experiment.after(n), simulation.after(n), Confidence::P95);
        assert!(power(both) >= 0.8 && power(both - 1) < 0.8);
    }

    #[test]
    fn a_known_rate_needs_no_trials() {
        let known = Arm::known(0.88);
        let empty = Arm::with_size(0.88, 0.0);
        let goal = Goal::Equivalence { margin: 0.05 };
        let found = further_trials(goal, known, empty, Confidence::P95, 0.8).unwrap();
        assert_eq!(found.first, None);
        assert_eq!(found.second, found.both);
        assert_eq!(found.second, Some(362));
        assert_eq!(goal.power(known, known, Confidence::P95), 1.0);
    }

    #[test]
    fn powers_and_rates_outside_their_range_are_refused() {
        let goal = Goal::Difference;
        assert!(trials_per_arm(goal, (0.5, 0.4), Confidence::P95, 1.0).is_err());
        assert!(trials_per_arm(goal, (0.5, 1.4), Confidence::P95, 0.8).is_err());
    }
}
