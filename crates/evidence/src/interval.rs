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
    /// Whether the value lies in the interval, ends included.
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }
}
