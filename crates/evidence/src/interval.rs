//! The serialised form of an interval.
//!
//! `stats` computes intervals and knows nothing of files; this is how one is
//! written down.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A closed interval of probabilities or of their differences.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// The least interval that has this one and the value. Of one in which the truth lies with some probability, it lies
    /// there with no less.
    pub fn with(self, value: f64) -> Self {
        Self {
            low: self.low.min(value),
            high: self.high.max(value),
        }
    }

    /// Whether the value lies in the interval, ends included.
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }
}
