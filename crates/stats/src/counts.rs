//! Counts, intervals and confidence levels: the nouns that every other module speaks.
//!
//! A count that carries no information (no trials, more successes than trials, or more trials than
//! [`MOST_TRIALS`]) never leads to a claim: its intervals are `[0, 1]` and its p-values are 1.

use std::fmt;

/// More trials are not counted: beyond this a `f64` does not tell a number from the next, and what is computed of it would be
/// of another count.
pub const MOST_TRIALS: u64 = 1 << 53;

/// What was counted: `successes` among `trials` independent trials of the same kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Sample {
    /// Number of trials that succeeded, at most `trials`.
    pub successes: u64,
    /// Number of trials.
    pub trials: u64,
}

impl Sample {
    /// `successes` among `trials`.
    ///
    /// # Errors
    /// [`StatsError::MoreSuccessesThanTrials`] when `successes > trials`, [`StatsError::OutOfRange`] beyond [`MOST_TRIALS`].
    pub fn new(successes: u64, trials: u64) -> Result<Self, StatsError> {
        if successes > trials {
            return Err(StatsError::MoreSuccessesThanTrials { successes, trials });
        }
        if trials > MOST_TRIALS {
            return Err(StatsError::OutOfRange {
                what: "number of trials",
                value: trials as f64,
                expected: "at most 2^53 trials (9e15)",
            });
        }
        Ok(Self { successes, trials })
    }

    /// Number of trials that failed (0 when the counts contradict each other).
    #[must_use]
    pub fn failures(&self) -> u64 {
        self.trials.saturating_sub(self.successes)
    }

    /// The share of successes, or `None` without trials.
    #[must_use]
    pub fn rate(&self) -> Option<f64> {
        EffectiveSample::from(*self).rate()
    }

    /// Whether the counts say anything: at least one trial, at most [`MOST_TRIALS`], and no more successes than trials.
    #[must_use]
    pub fn is_informative(&self) -> bool {
        (1..=MOST_TRIALS).contains(&self.trials) && self.successes <= self.trials
    }
}

impl fmt::Display for Sample {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}/{}", self.successes, self.trials)
    }
}

/// A count whose size may be a fraction: what a clustered [`Sample`] is worth in independent
/// trials (see [`clustered_rate`](crate::clustered_rate)). Every [`Sample`] converts into one of the same size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectiveSample {
    /// Successes, in independent trials.
    pub successes: f64,
    /// Independent trials.
    pub trials: f64,
}

impl EffectiveSample {
    /// The rate of `sample` at the size of `trials` independent trials.
    ///
    /// # Errors
    /// [`StatsError::OutOfRange`] when `trials` is not positive and finite, or when the sample
    /// has no rate.
    pub fn at_size(sample: Sample, trials: f64) -> Result<Self, StatsError> {
        let rate = sample.rate().ok_or(StatsError::NoTrials)?;
        if !(trials.is_finite() && trials > 0.0) {
            return Err(StatsError::OutOfRange {
                what: "effective sample size",
                value: trials,
                expected: "a positive number",
            });
        }
        Ok(Self {
            successes: rate * trials,
            trials,
        })
    }

    /// Of the contrary: failures in place of successes.
    #[must_use]
    pub fn complement(&self) -> Self {
        Self {
            successes: self.failures(),
            trials: self.trials,
        }
    }

    /// Failures, in independent trials.
    #[must_use]
    pub fn failures(&self) -> f64 {
        self.trials - self.successes
    }

    /// The share of successes, or `None` when the counts carry no information.
    #[must_use]
    pub fn rate(&self) -> Option<f64> {
        self.is_informative().then(|| self.successes / self.trials)
    }

    /// Whether the counts say anything: a positive size, at most [`MOST_TRIALS`], and `0 <= successes <= trials`.
    #[must_use]
    pub fn is_informative(&self) -> bool {
        self.trials > 0.0
            && self.trials <= MOST_TRIALS as f64
            && self.successes >= 0.0
            && self.successes <= self.trials
    }
}

impl From<Sample> for EffectiveSample {
    fn from(sample: Sample) -> Self {
        Self {
            successes: sample.successes as f64,
            // A count just beyond rounds to the most there may be.
            trials: match sample.trials {
                0..=MOST_TRIALS => sample.trials as f64,
                _ => f64::INFINITY,
            },
        }
    }
}

/// A closed interval of a real quantity, `low <= high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// What is known of a probability before anything was observed.
    pub const VACUOUS: Self = Self {
        low: 0.0,
        high: 1.0,
    };

    /// Whether `value` lies in the interval, ends included.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// `high - low`.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.high - self.low
    }
}

impl fmt::Display for Interval {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "[{:.4}, {:.4}]", self.low, self.high)
    }
}

/// A confidence (or credibility) level strictly between 0 and 1, such as 0.95.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Confidence(f64);

impl Confidence {
    /// 0.90, the level whose two-sided interval corresponds to a TOST at 5 %.
    pub const P90: Self = Self(0.90);
    /// 0.95, the customary level.
    pub const P95: Self = Self(0.95);
    /// 0.99.
    pub const P99: Self = Self(0.99);

    /// The given level.
    ///
    /// # Errors
    /// [`StatsError::OutOfRange`] unless `0 < level < 1`.
    pub fn new(level: f64) -> Result<Self, StatsError> {
        if level > 0.0 && level < 1.0 {
            return Ok(Self(level));
        }
        Err(StatsError::OutOfRange {
            what: "confidence level",
            value: level,
            expected: "a number strictly between 0 and 1, such as 0.95",
        })
    }

    /// The level as a number.
    #[must_use]
    pub fn level(&self) -> f64 {
        self.0
    }

    /// The significance level, one minus the level.
    #[must_use]
    pub fn alpha(&self) -> f64 {
        1.0 - self.0
    }

    /// The level at which `count` statements must each hold for all of them to hold together
    /// with this confidence (Bonferroni): `1 - alpha / count`.
    #[must_use]
    pub fn simultaneous(&self, count: usize) -> Self {
        Self(1.0 - self.alpha() / count.max(1) as f64)
    }

    /// The same for statements that rest on independent samples (Z. Sidak, 1967):
    /// `(1 - alpha)^(1/count)`, a little less than [`Confidence::simultaneous`] asks for.
    #[must_use]
    pub fn simultaneous_if_independent(&self, count: usize) -> Self {
        Self(self.0.powf(1.0 / count.max(1) as f64))
    }
}

/// Why a statistic cannot be given.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum StatsError {
    /// A count of successes above its count of trials.
    MoreSuccessesThanTrials {
        /// The successes given.
        successes: u64,
        /// The trials given.
        trials: u64,
    },
    /// A statistic of nothing.
    NoTrials,
    /// A parameter outside its domain.
    OutOfRange {
        /// The name of the parameter.
        what: &'static str,
        /// The value given.
        value: f64,
        /// What would have been accepted.
        expected: &'static str,
    },
    /// Fewer groups or observations than the statistic needs.
    TooFew {
        /// What there are too few of.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many are needed.
        needed: usize,
    },
    /// Two lists that should be of one length are not.
    LengthMismatch {
        /// The length of the first.
        left: usize,
        /// The length of the second.
        right: usize,
    },
    /// All observations are equal (or one factor is), so that the statistic is 0/0.
    Constant {
        /// What does not vary.
        what: &'static str,
    },
    /// An exact distribution that would not fit in memory.
    TooManyArrangements {
        /// The number of states allowed.
        limit: usize,
    },
}

impl fmt::Display for StatsError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::MoreSuccessesThanTrials { successes, trials } => write!(
                formatter,
                "{successes} successes cannot come from {trials} trials; check the two columns"
            ),
            Self::NoTrials => {
                write!(
                    formatter,
                    "there are no trials; give at least one before asking for a rate"
                )
            }
            Self::OutOfRange {
                what,
                value,
                expected,
            } => {
                write!(formatter, "the {what} is {value}; give {expected}")
            }
            Self::TooFew {
                what,
                found,
                needed,
            } => {
                write!(
                    formatter,
                    "there are {found} {what} and {needed} are needed; add some"
                )
            }
            Self::LengthMismatch { left, right } => write!(
                formatter,
                "the lists have {left} and {right} entries; give one entry of each per observation"
            ),
            Self::Constant { what } => write!(
                formatter,
                "all {what} are equal, so that the statistic is undefined; leave it out"
            ),
            Self::TooManyArrangements { limit } => write!(
                formatter,
                "the exact distribution needs more than {limit} states; use the approximation"
            ),
        }
    }
}

impl std::error::Error for StatsError {}

/// Whole counts near effective ones, for exact tests: both neighbours of the successes at the effective size rounded
/// down. The counts themselves where trials are independent.
#[must_use]
pub fn whole_counts(sample: Sample, effective: EffectiveSample) -> Vec<Sample> {
    if effective.trials >= sample.trials as f64 {
        return vec![sample];
    }
    let trials = effective.trials.floor().max(1.0);
    // Rounded, a rate of 1 can come out above it: no count has more successes than trials.
    let successes = (trials * effective.successes / effective.trials).min(trials);
    let whole = |successes: f64| Sample {
        successes: successes as u64,
        trials: trials as u64,
    };
    let (below, above) = (whole(successes.floor()), whole(successes.ceil()));
    if below == above {
        vec![below]
    } else {
        vec![below, above]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of samples that always succeed as of others: what was rounded is a sample, and one of its neighbours.
    #[test]
    fn whole_counts_have_no_more_successes_than_trials() {
        let sample = Sample::new(240, 240).expect("counts");
        for step in 0..4000 {
            let trials = 1.0 + f64::from(step) * 0.059_7;
            for successes in [trials, trials * (1.0 + 1e-15), trials * 0.87, 0.0] {
                let effective = EffectiveSample { successes, trials };
                for whole in whole_counts(sample, effective) {
                    assert!(whole.is_informative(), "{effective:?} {whole:?}");
                    let expected = whole.trials as f64 * (successes / trials).min(1.0);
                    assert!(
                        (whole.successes as f64 - expected).abs() <= 1.0,
                        "{whole:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn contradictory_counts_are_refused_and_carry_no_information() {
        let error = Sample::new(3, 2).unwrap_err();
        assert_eq!(
            error.to_string(),
            "3 successes cannot come from 2 trials; check the two columns"
        );
        assert!(
            !Sample {
                successes: 3,
                trials: 2
            }
            .is_informative()
        );
        assert_eq!(
            Sample {
                successes: 3,
                trials: 2
            }
            .rate(),
            None
        );
        assert_eq!(
            Sample {
                successes: 0,
                trials: 0
            }
            .rate(),
            None
        );
        assert_eq!(
            Sample {
                successes: 1,
                trials: 4
            }
            .rate(),
            Some(0.25)
        );
    }

    #[test]
    fn confidence_is_strictly_between_zero_and_one() {
        for level in [0.0, 1.0, -0.5, 95.0, f64::NAN] {
            assert!(Confidence::new(level).is_err(), "{level}");
        }
        assert_eq!(Confidence::new(0.95).unwrap(), Confidence::P95);
        assert!((Confidence::P95.simultaneous(5).level() - 0.99).abs() < 1e-15);
        let each = Confidence::P95.simultaneous_if_independent(3).level();
        assert!(
            (each.powi(3) - 0.95).abs() < 1e-15 && each < Confidence::P95.simultaneous(3).level()
        );
    }

    #[test]
    fn whole_counts_are_neighbours() {
        let sample = Sample {
            successes: 88,
            trials: 100,
        };
        let effective = EffectiveSample::at_size(sample, 55.3).unwrap();
        let whole = whole_counts(sample, effective);
        assert_eq!(
            whole,
            [
                Sample {
                    successes: 48,
                    trials: 55
                },
                Sample {
                    successes: 49,
                    trials: 55
                }
            ]
        );
        assert_eq!(whole_counts(sample, sample.into()), [sample]);
        let none = Sample {
            successes: 0,
            trials: 7,
        };
        let effective = EffectiveSample::at_size(none, 0.4).unwrap();
        assert_eq!(
            whole_counts(none, effective),
            [Sample {
                successes: 0,
                trials: 1
            }]
        );
    }
}
