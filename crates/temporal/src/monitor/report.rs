//! What a monitor found in one trace.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The outcome of one monitor on one trace, over all its instances:
/// `triggered = passed + failed + pending + inconclusive`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MonitorReport {
    /// Instances begun.
    pub triggered: u64,
    /// Instances that met all postconditions.
    pub passed: u64,
    /// Instances that did not.
    pub failed: u64,
    /// Instances under way at the end that are neither (at most 1).
    pub pending: u64,
    /// Instances that could not be judged because a proposition was unknown.
    pub inconclusive: u64,
    /// Triggers that began nothing because an instance was under way.
    pub overlapping: u64,
    /// Samples at which the precondition was unknown.
    pub when_unknown: u64,
    /// The first failure in time.
    pub first_failure: Option<Failure>,
    /// The conclusion for the trace.
    pub verdict: Verdict,
}

/// Where and how an instance failed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// Time of the sample that shows the failure, in seconds of the trace's clock.
    pub time_secs: f64,
    /// Position of the stage that failed, from 0.
    pub stage: usize,
    /// The proposition that should have been true.
    pub proposition: String,
    /// Time at which the instance began, in seconds of the trace's clock.
    pub triggered_at_secs: f64,
    /// From when on the proposition was seen to be false, in seconds of the trace's clock: where it had to
    /// be true at that sample, from there, and where it had to become true, from the beginning of the stage.
    pub false_from_secs: f64,
    /// Until when; not behind the deadline, since a proposition may come too late.
    pub false_to_secs: f64,
    /// How it failed.
    pub reason: FailureReason,
}

/// How an instance failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureReason {
    /// An asserted proposition was false.
    AssertedFalse,
    /// A proposition that had to hold was false.
    HoldBroken,
    /// The time allowed for a stage ran out.
    Deadline,
    /// The trace ended first, and the monitor counts that as a failure.
    EndOfTrace,
}

/// The conclusion of a monitor for one trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The precondition was never seen to trigger.
    NotCovered,
    /// Every instance passed, and the trace is complete or no further instance can begin.
    Satisfied,
    /// Some instance failed.
    Violated,
    /// No instance failed, but not all are known to have passed.
    Inconclusive,
}

/// A sample came with a time that is not finite, or not after the last one.
#[derive(Debug, Clone, PartialEq)]
pub struct StepError {
    /// Time of the sample before, in seconds; minus infinity if there was none.
    pub last_secs: f64,
    /// The time that was given, in seconds.
    pub time_secs: f64,
}

impl fmt::Display for StepError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "a monitor was given a sample at {} s after one at {} s; give it one sample for each \
             time, in order",
            self.time_secs, self.last_secs
        )
    }
}

impl std::error::Error for StepError {}
