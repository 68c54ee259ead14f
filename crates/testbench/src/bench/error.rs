//! Why a run gives no recording.

use std::fmt;

use trace::TraceError;

use super::ScenarioError;
use crate::controller::ControllerError;
use crate::mujoco::EngineError;

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
    /// The scenario or the parameters cannot be used.
    Scenario(ScenarioError),
    /// There is no abstract test of this name.
    UnknownTest {
        /// The name asked for.
        name: String,
    },
    /// A controller could not be started, failed, or gave what the bench does not take.
    Controller(ControllerError),
    /// A simulator of others could not be run or read.
    Outside {
        /// What is wrong with it.
        reason: String,
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
            Self::Scenario(error) => write!(f, "{error}"),
            Self::Trace(error) => write!(f, "the episode could not be recorded: {error}"),
            Self::Unstable { seed, time_secs } => write!(
                f,
                "the physics became unstable at {time_secs:.3} s in the episode with seed {seed}; shorten simulation.time_step_secs or soften the stiffest servo or contact"
            ),
            Self::Controller(error) => write!(f, "{error}"),
            Self::Cancelled => write!(f, "the episode was cancelled"),
            Self::UnknownTest { name } => write!(
                f,
                "the scenario has no abstract test \"{name}\"; name one of its abstract_test tables"
            ),
            Self::Outside { reason } => write!(f, "{reason}"),
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

impl From<ScenarioError> for SimError {
    fn from(error: ScenarioError) -> Self {
        Self::Scenario(error)
    }
}

impl From<TraceError> for SimError {
    fn from(error: TraceError) -> Self {
        Self::Trace(error)
    }
}
