//! The range over all schedulers of a model whose constants are uncertain: both ends with their distributions.
//!
//! # Definition
//! At constants `c` a model with choices has the range `[L(c), G(c)]`. The constants' posterior makes both ends random;
//! each is taken as the quantiles of its draws have it ([`super::uncertain`]), or as one number where it does not vary. The joint
//! distribution of both is not used: what is said of both is bounded by Bonferroni's inequality,
//!
//! ```text
//! P(low <= L and G <= high)  >=  1 - P(L < low) - P(G > high)
//! ```
//!
//! # Assumes
//! The constants have the posteriors of the counts that they were set to. Nothing of how both ends depend on each other.
//!
//! # Guarantee
//! What is said of the whole range holds with at least the posterior probability that is stated, up to the error of the
//! draws and, where two uncertain numbers are compared, what [`super::uncertain`] states. Two sides of a comparison are taken as independent.

use super::uncertain::Uncertain;
use stats::{BetaPosterior, Confidence, Interval, PosteriorPlaces};

/// One end of the range.
#[derive(Clone, Debug)]
pub(crate) enum End {
    /// It is the same at all values of the constants.
    Known(f64),
    /// Its distribution.
    Uncertain(Uncertain),
}

/// Both ends.
#[derive(Clone, Debug)]
pub(crate) struct Ends {
    /// The range with the constants as they are written.
    pub as_written: Interval,
    /// The least probability over all schedulers.
    pub least: End,
    /// The greatest.
    pub greatest: End,
    /// Whether every value between the ends is one that the model allows.
    pub is_range: bool,
}

impl End {
    /// The probability that the end is at most this.
    pub fn at_most(&self, value: f64) -> f64 {
        match self {
            Self::Known(end) => f64::from(u8::from(*end <= value)),
            Self::Uncertain(posterior) => posterior.cdf(value),
        }
    }

    /// The probability that the end is at least this.
    pub fn at_least(&self, value: f64) -> f64 {
        match self {
            Self::Known(end) => f64::from(u8::from(*end >= value)),
            Self::Uncertain(posterior) => posterior.sf(value),
        }
    }

    /// The probability that this is at least another end and `by` more.
    pub fn exceeds(&self, other: &Self, by: f64) -> f64 {
        match (self, other) {
            (_, Self::Known(other)) => self.at_least(other + by),
            (Self::Known(end), other) => other.at_most(end - by),
            (Self::Uncertain(first), Self::Uncertain(second)) => first.exceeds(second, by),
        }
    }

    /// What it lies below with this probability.
    pub fn quantile(&self, probability: f64) -> f64 {
        match self {
            Self::Known(end) => *end,
            Self::Uncertain(posterior) => posterior.quantile(probability),
        }
    }

    /// What it lies above with this probability.
    pub fn quantile_upper(&self, probability: f64) -> f64 {
        match self {
            Self::Known(end) => *end,
            Self::Uncertain(posterior) => posterior.quantile_upper(probability),
        }
    }
}

impl Ends {
    /// Where the whole range lies at this level, with the range as written.
    pub fn interval(&self, confidence: Confidence) -> Interval {
        let tail = 0.5 * confidence.alpha();
        Interval {
            low: self.least.quantile(tail).min(self.as_written.low),
            high: self.greatest.quantile_upper(tail).max(self.as_written.high),
        }
    }

    /// Where the value of the range lies that is nearest to a rate, `nearest` with the constants as written.
    pub fn interval_of_nearest(&self, nearest: f64, confidence: Confidence) -> Interval {
        let tail = 0.5 * confidence.alpha();
        let mut found = Interval {
            low: nearest.min(self.greatest.quantile(tail)),
            high: nearest.max(self.least.quantile_upper(tail)),
        };
        if nearest >= self.as_written.high {
            found.high = found.high.max(self.greatest.quantile_upper(tail));
        }
        if nearest <= self.as_written.low {
            found.low = found.low.min(self.least.quantile(tail));
        }
        found
    }
}

/// A side of a comparison, as ends.
#[derive(Clone, Debug)]
pub(super) struct Side {
    /// Its lower end.
    pub least: End,
    /// Its upper end.
    pub greatest: End,
    /// Whether every value between is one that the side allows.
    pub is_range: bool,
}

/// Twice the smaller probability of the sides having a value in common, seen from either direction.
pub(super) fn p_difference(first: &Side, second: &Side) -> f64 {
    let reaches = [
        second.greatest.exceeds(&first.least, 0.0),
        first.greatest.exceeds(&second.least, 0.0),
    ];
    (2.0 * reaches[0].min(reaches[1])).min(1.0)
}

/// The least posterior probability that two sides are less than the margin apart: two numbers wherever they are between
/// their ends; a number and some value of a range; two ranges, if each value of one has one of the other that near.
pub(super) fn probability_within(first: &Side, second: &Side, margin: f64) -> f64 {
    let outside = match (first.is_range, second.is_range) {
        (true, true) => {
            first.least.exceeds(&second.least, margin)
                + second.least.exceeds(&first.least, margin)
                + first.greatest.exceeds(&second.greatest, margin)
                + second.greatest.exceeds(&first.greatest, margin)
        }
        (true, false) => {
            first.least.exceeds(&second.least, margin)
                + second.greatest.exceeds(&first.greatest, margin)
        }
        (false, true) => {
            second.least.exceeds(&first.least, margin)
                + first.greatest.exceeds(&second.greatest, margin)
        }
        (false, false) => {
            first.greatest.exceeds(&second.least, margin)
                + second.greatest.exceeds(&first.least, margin)
        }
    };
    (1.0 - outside).max(0.0)
}

/// A side whose value or ends are uncertain, as places of their distributions: for plans, which ask the same of thousands
/// of counts.
#[derive(Clone, Debug)]
pub(super) enum PlannedSide {
    /// One number.
    Number(PosteriorPlaces),
    /// Two ends.
    Ends {
        /// The lower one.
        least: PlannedEnd,
        /// The upper one.
        greatest: PlannedEnd,
        /// Whether every value between is one that the side allows.
        is_range: bool,
    },
}

/// One end.
#[derive(Clone, Debug)]
pub(super) enum PlannedEnd {
    /// It is the same at all values of the constants.
    Known(f64),
    /// Places of its distribution.
    Uncertain(PosteriorPlaces),
}

impl From<&End> for PlannedEnd {
    fn from(end: &End) -> Self {
        match end {
            End::Known(value) => Self::Known(*value),
            End::Uncertain(posterior) => Self::Uncertain(posterior.places()),
        }
    }
}

impl PlannedEnd {
    fn exceeds(&self, counts: &BetaPosterior, by: f64) -> f64 {
        match self {
            Self::Known(end) => counts.cdf(end - by),
            Self::Uncertain(places) => places.exceed(counts, by),
        }
    }

    fn is_exceeded(&self, counts: &BetaPosterior, by: f64) -> f64 {
        match self {
            Self::Known(end) => counts.sf(end + by),
            Self::Uncertain(places) => places.are_exceeded(counts, by),
        }
    }
}

impl PlannedSide {
    /// About what [`p_difference`] says of this side and counts.
    pub fn p_difference(&self, counts: &BetaPosterior) -> f64 {
        let reaches = match self {
            Self::Number(places) => [places.exceed(counts, 0.0), places.are_exceeded(counts, 0.0)],
            Self::Ends {
                least, greatest, ..
            } => [
                greatest.exceeds(counts, 0.0),
                least.is_exceeded(counts, 0.0),
            ],
        };
        (2.0 * reaches[0].min(reaches[1])).clamp(0.0, 1.0)
    }

    /// About what [`probability_within`] says of this side and counts.
    pub fn probability_within(&self, counts: &BetaPosterior, margin: f64) -> f64 {
        let (above, below) = match self {
            Self::Number(places) => return places.within(counts, margin),
            Self::Ends {
                least,
                greatest,
                is_range: true,
            } => (least, greatest),
            Self::Ends {
                least, greatest, ..
            } => (greatest, least),
        };
        (1.0 - above.exceeds(counts, margin) - below.is_exceeded(counts, margin)).max(0.0)
    }
}

#[cfg(test)]
mod tests;
