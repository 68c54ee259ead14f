//! What is found of rare events.

use evidence::{EpisodeFailures, FailureKind};
use schemars::JsonSchema;
use serde::Serialize;

/// Below this, counting and splitting contradict each other.
pub(super) const CONTRADICTION: f64 = 0.01;

/// How rare events are.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RareReport {
    /// Version of this form.
    pub format: String,
    /// The physics engine with its version.
    pub engine: String,
    /// The level of the intervals.
    pub confidence: f64,
    /// The events, in the order of the file.
    pub events: Vec<EventReport>,
}

impl RareReport {
    /// Whether counting plain episodes contradicts an estimate.
    pub fn is_contradicted(&self) -> bool {
        let mut plain = self.events.iter().filter_map(|event| event.plain.as_ref());
        plain.any(PlainReport::contradicts)
    }

    /// Whether every event was reached.
    pub fn is_complete(&self) -> bool {
        let mut events = self.events.iter();
        events.all(|event| event.relative_error.is_some())
    }
}

/// One event.
#[derive(Debug, Serialize, JsonSchema)]
pub struct EventReport {
    /// Its name.
    pub name: String,
    /// What it means.
    pub meaning: String,
    /// What the estimate rests on.
    pub guarantee: String,
    /// The score that is the event.
    pub limit: f64,
    /// The probability that it happens in an episode.
    pub probability: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Standard error over estimate; none if it was never reached.
    pub relative_error: Option<f64>,
    /// The estimate of each replication.
    pub replications: Vec<f64>,
    /// What it cost, in episodes until the time looked at.
    pub episode_equivalents: f64,
    /// Plain episodes that would give the same relative error.
    pub plain_episodes_for_the_same_error: Option<f64>,
    /// Runs, continuations among them, that the robot's program or the physics ended by failing. An
    /// event that such a run had not come to has not happened in it.
    pub failures: Vec<RunFailures>,
    /// Plain episodes counted beside it.
    pub plain: Option<PlainReport>,
}

/// How many runs one kind of failure ended. Runs that came near the event are continued many times, so
/// this is no rate of episodes; plain episodes give that.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RunFailures {
    /// What failed.
    pub kind: FailureKind,
    /// Runs that it ended.
    pub count: u64,
    /// All runs.
    pub runs: u64,
}

/// Plain episodes, for comparison.
#[derive(Debug, Serialize, JsonSchema)]
pub struct PlainReport {
    /// Episodes in which the event happened.
    pub count: u64,
    /// Episodes.
    pub episodes: u64,
    /// Lower end of the rate's interval (Clopper and Pearson).
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Probability of a difference as great as that between counting and
    /// splitting if both are right.
    pub p_value: f64,
    /// Episodes among them that did not end by themselves, which count up to there.
    pub failures: Vec<EpisodeFailures>,
}

impl PlainReport {
    /// Whether counting contradicts splitting.
    pub fn contradicts(&self) -> bool {
        self.p_value < CONTRADICTION
    }
}
