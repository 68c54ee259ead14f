//! What is known of a basic event.

use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};
use stats::{Confidence, IntervalMethod, Sample};

use crate::decimal::decimal;
use crate::enclosure::Enclosure;

/// What is known of how probable a basic event is. Basic events are independent of each other.
#[derive(Clone, Debug, PartialEq)]
pub enum EventData {
    /// A probability, exactly as it is written.
    Probability(BigRational),
    /// A constant failure rate and the time under way without repair: `1 - exp(-rate * time)`. Both in units that belong
    /// together, for example 1/h and h.
    Rate {
        /// Failures per unit of time.
        rate: BigRational,
        /// The mission time.
        time: BigRational,
    },
    /// A probability that is somewhere between two numbers.
    Interval {
        /// The least probability.
        lower: BigRational,
        /// The greatest probability.
        upper: BigRational,
    },
    /// Occurrences counted in independent trials; an interval by Clopper and Pearson stands for them.
    Counts {
        /// How often the event occurred.
        occurrences: u64,
        /// Of how many trials.
        trials: u64,
    },
}

impl EventData {
    /// A probability from decimal text; `None` if it is none between 0 and 1.
    pub fn probability(text: &str) -> Option<Self> {
        let value = decimal(text)?;
        (value <= BigRational::one()).then_some(Self::Probability(value))
    }

    /// An interval from decimal texts; `None` if they are not probabilities in this order.
    pub fn interval(lower: &str, upper: &str) -> Option<Self> {
        let (lower, upper) = (decimal(lower)?, decimal(upper)?);
        let fits = lower <= upper && upper <= BigRational::one();
        fits.then_some(Self::Interval { lower, upper })
    }

    /// A rate and a mission time from decimal texts; `None` if they are not numbers of at least 0.
    pub fn rate(rate: &str, time: &str) -> Option<Self> {
        let (rate, time) = (decimal(rate)?, decimal(time)?);
        Some(Self::Rate { rate, time })
    }

    /// Counts; `None` without trials, or with more occurrences than trials.
    pub fn counts(occurrences: u64, trials: u64) -> Option<Self> {
        let fits = trials > 0 && occurrences <= trials;
        fits.then_some(Self::Counts {
            occurrences,
            trials,
        })
    }

    /// What is wrong with it, if anything: data can be put together without the functions above.
    pub fn mistake(&self) -> Option<&'static str> {
        let is_probability =
            |it: &BigRational| *it >= BigRational::zero() && *it <= BigRational::one();
        match self {
            Self::Probability(it) if !is_probability(it) => {
                Some("a probability is between 0 and 1")
            }
            Self::Rate { rate, time }
                if *rate < BigRational::zero() || *time < BigRational::zero() =>
            {
                Some("a rate and a mission time are at least 0")
            }
            Self::Interval { lower, upper }
                if !is_probability(lower) || !is_probability(upper) || lower > upper =>
            {
                Some("an interval has two probabilities, the lower one first")
            }
            Self::Counts {
                occurrences,
                trials,
            } if *trials == 0 || occurrences > trials => {
                Some("counts need at least one trial, and no more occurrences than trials")
            }
            _ => None,
        }
    }

    /// The double that is nearest to a probability that is written as such; `None` of rates, intervals and counts.
    pub fn value(&self) -> Option<f64> {
        match self {
            Self::Probability(value) => value.to_f64(),
            Self::Rate { .. } | Self::Interval { .. } | Self::Counts { .. } => None,
        }
    }

    /// Whether it is a range of probabilities, and not one.
    pub(crate) fn is_range(&self) -> bool {
        match self {
            Self::Probability(_) | Self::Rate { .. } => false,
            Self::Interval { lower, upper } => lower < upper,
            Self::Counts { .. } => true,
        }
    }

    /// The exact probability, where it is a rational number that is known.
    pub(crate) fn exact(&self) -> Option<BigRational> {
        match self {
            Self::Probability(value) => Some(value.clone()),
            Self::Interval { lower, upper } if lower == upper => Some(lower.clone()),
            Self::Rate { rate, time } if rate.is_zero() || time.is_zero() => {
                Some(BigRational::zero())
            }
            Self::Rate { .. } | Self::Interval { .. } | Self::Counts { .. } => None,
        }
    }

    /// An interval that holds the probability; for counts, with the confidence.
    pub(crate) fn enclosure(&self, confidence: Confidence) -> Enclosure {
        match self {
            Self::Probability(value) => Enclosure::of(value),
            Self::Rate { rate, time } => Enclosure::of(&(rate * time)).one_minus_exp(),
            Self::Interval { lower, upper } => Enclosure {
                lower: Enclosure::of(lower).lower,
                upper: Enclosure::of(upper).upper,
            },
            Self::Counts {
                occurrences,
                trials,
            } => {
                let sample = Sample {
                    successes: *occurrences,
                    trials: *trials,
                };
                let interval = IntervalMethod::ClopperPearson.interval(sample, confidence);
                Enclosure {
                    lower: interval.low,
                    upper: interval.high,
                }
            }
        }
    }
}
