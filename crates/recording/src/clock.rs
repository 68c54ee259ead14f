//! Which time counts: that of the recorder, of the sender, of the measurement, or of a simulation.
//!
//! # Definition
//! A recording holds for each message the time at which it was received and written (*log*) and,
//! in most formats, the time at which it was sent (*publish*). Many messages hold the time of the
//! measurement in their header (*header*). In a simulation, `/clock` says how simulated time goes
//! (*clock*).
//!
//! * Log and publish time are taken as they are.
//! * Header time is the message's `header.stamp`. Messages of types without a header keep their log
//!   time, and [`SignalStream`](crate::SignalStream) says for which topics that happened. A stamp of
//!   0, as an unset one is, gives the message no time: it is left out and counted. Transforms have
//!   stamps of their own.
//! * Clock time is piecewise linear: a message logged at l between two messages of `/clock` that
//!   were logged at l_i and l_(i+1) and hold s_i and s_(i+1) has the time
//!   s_i + (l - l_i) (s_(i+1) - s_i) / (l_(i+1) - l_i). Behind the last one it is s_n, which is
//!   what a node of the simulation sees; before the first one there is no time, so these messages
//!   are left out and counted. If `/clock` goes back (a reset of the simulation), what follows is of
//!   another run, and the stream ends there.
//!
//! # Order
//! Messages come out in order of the chosen time, those of equal times in the order of the
//! recording. A message waits until `reorder_secs` of log time have passed since it was read; so
//! the order is complete if no message comes later than that behind those of later times. One that
//! comes too late is left out and counted. A stamp far in the future delays nothing but itself.
//!
//! # Cost
//! O(1) for a message that is in order already, O(log m) otherwise, with m messages waiting; at
//! most `reorder_messages` wait.

mod mapping;
mod reorder;

pub(crate) use mapping::{Mapped, SimulationClock};
pub(crate) use reorder::{Late, ReorderBuffer};

/// Which time of a message counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TimeSource {
    /// When the recorder received it.
    #[default]
    Log,
    /// When it was sent.
    Publish,
    /// When it was measured, by `header.stamp`.
    Header,
    /// When it was received, by the clock of a simulation on `/clock`.
    Clock,
}

/// Which time counts, and how long is waited for what comes late.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeSettings {
    /// Which time counts.
    pub source: TimeSource,
    /// How much later than others, in seconds of log time, a message may come to be still put in
    /// order.
    pub reorder_secs: f64,
    /// How many messages wait at most to be put in order.
    pub reorder_messages: usize,
    /// How long, in seconds, what depends on a transform waits for it.
    pub frame_wait_secs: f64,
    /// How long transforms are kept, in seconds.
    pub frame_history_secs: f64,
    /// The widest gap, in seconds, between two samples of a transform that is interpolated over.
    pub frame_gap_secs: f64,
}

impl Default for TimeSettings {
    fn default() -> Self {
        TimeSettings {
            source: TimeSource::Log,
            reorder_secs: 1.0,
            reorder_messages: 100_000,
            frame_wait_secs: 1.0,
            frame_history_secs: 10.0,
            frame_gap_secs: 1.0,
        }
    }
}

/// Seconds as whole nanoseconds, saturating.
pub(crate) fn nanos_of_secs(secs: f64) -> i64 {
    (secs * 1e9).round() as i64
}
