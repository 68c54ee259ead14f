//! What every thing under test looks like to a campaign: a bench.
//!
//! A bench takes a stimulus and a seed and gives a recording, bit for bit: the same stimulus and
//! seed give the same bytes, in any process and on any thread. While it runs, a [`Watch`] sees each
//! row as it is recorded and may end the run once it knows enough. A savable bench can moreover
//! be stopped anywhere and continued from there, as it was or with other random draws: that is what
//! splitting needs.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

use trace::{Trace, TraceError};

use crate::mujoco::EngineError;

/// A flag by which a caller ends an episode early, from any thread.
#[derive(Debug, Default)]
pub struct Cancel(AtomicBool);

impl Cancel {
    /// Asks running episodes to end.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether [`Cancel::cancel`] was called.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Why an episode gave no trace.
#[derive(Debug)]
pub enum SimError {
    /// The physics engine refused the model.
    Engine(EngineError),
    /// The recording could not be written, which means that the physics gave no number.
    Trace(TraceError),
    /// The physics became unstable.
    Unstable {
        /// The seed of the episode.
        seed: u64,
        /// When, in simulated seconds.
        time_secs: f64,
    },
    /// The caller cancelled the episode.
    Cancelled,
    /// There is no abstract test of this name.
    UnknownTest {
        /// The name asked for.
        name: String,
    },
    /// The bench cannot do what the stimulus asks.
    Stimulus {
        /// Which part of it, why, and what would do.
        reason: String,
    },
}

impl fmt::Display for SimError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Engine(error) => write!(f, "{error}"),
            Self::Trace(error) => write!(f, "the episode could not be recorded: {error}"),
            Self::Unstable { seed, time_secs } => write!(
                f,
                "the physics became unstable at {time_secs:.3} s in the episode with seed {seed}; shorten simulation.time_step_secs or soften the stiffest servo or contact"
            ),
            Self::Cancelled => write!(f, "the episode was cancelled"),
            Self::UnknownTest { name } => write!(
                f,
                "the scenario has no abstract test \"{name}\"; name one of its abstract_test tables"
            ),
            Self::Stimulus { reason } => {
                write!(f, "the stimulus does not fit this test bench: {reason}")
            }
        }
    }
}

impl std::error::Error for SimError {}

impl From<EngineError> for SimError {
    fn from(error: EngineError) -> Self {
        Self::Engine(error)
    }
}

impl From<TraceError> for SimError {
    fn from(error: TraceError) -> Self {
        Self::Trace(error)
    }
}

/// What a [`Watch`] wants next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    /// Go on.
    Continue,
    /// Enough has been seen: the run ends with the time step in which this is said.
    Finish,
}

/// Something that sees a run while it goes on.
pub trait Watch {
    /// A row was recorded in topic `topic_index` of the bench's layout. Times never go back; `values`
    /// are as recorded, in the order of the topic's fields.
    fn row(&mut self, topic_index: usize, time_secs: f64, values: &[f64]) -> Control;
}

/// Looks at nothing, so the run goes on to its own end.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unwatched;

impl Watch for Unwatched {
    fn row(&mut self, _: usize, _: f64, _: &[f64]) -> Control {
        Control::Continue
    }
}

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// By itself.
    Over,
    /// The longest time that the bench allows has passed.
    Longest,
    /// The [`Watch`] had seen enough.
    Watched,
}

/// What a run gives. Its trace is complete only if it ended by itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// Everything recorded.
    pub trace: Trace,
    /// Time steps taken.
    pub steps: u64,
    /// Simulated time.
    pub sim_secs: f64,
    /// Why it ended.
    pub end: End,
}
