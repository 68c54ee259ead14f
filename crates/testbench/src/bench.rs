//! What every thing under test looks like to a campaign: a bench.
//!
//! A bench takes a stimulus and a seed and gives a recording, bit for bit: the same stimulus and
//! seed give the same bytes, in any process and on any thread. While it runs, a [`Watch`] sees each
//! row as it is recorded and may end the run once it knows enough. A [`Savable`] bench can moreover
//! be stopped anywhere and continued from there, as it was or with other random draws: that is what
//! splitting needs.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

use stimulus::Stimulus;
use trace::{Trace, TraceError};

use crate::controller::ControllerError;
use crate::mujoco::EngineError;
use crate::scenario::ScenarioError;
use crate::viewer::Viewer;

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
    /// The scenario or the parameters cannot be used.
    Scenario(ScenarioError),
    /// There is no abstract test of this name.
    UnknownTest {
        /// The name asked for.
        name: String,
    },
    /// A controller could not be started, failed, or gave what the bench does not take.
    Controller(ControllerError),
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
    /// A row was recorded in topic `topic_index` of [`Bench::layout`]. Times never go back; `values`
    /// are as recorded, in the order of the topic's fields.
    fn row(&mut self, topic_index: usize, time_secs: f64, values: &[f64]) -> Control;

    /// What is to be told where bodies are, if anything is.
    fn viewer(&mut self) -> Option<&mut dyn Viewer> {
        None
    }
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

/// Anything that turns a stimulus and a seed into a recording.
pub trait Bench: Send + Sync {
    /// The topics and fields that every run records, without rows: what to bind monitors to.
    ///
    /// # Errors
    /// [`SimError::Trace`] when the bench's data give topics or fields that cannot be.
    fn layout(&self) -> Result<Trace, SimError>;

    /// Runs once.
    ///
    /// # Errors
    /// [`SimError::Stimulus`] for a stimulus that this bench does not understand,
    /// [`SimError::Cancelled`], and whatever keeps the simulation from going on.
    fn run(
        &self,
        stimulus: &Stimulus,
        seed: u64,
        watch: &mut dyn Watch,
        cancel: &Cancel,
    ) -> Result<Recorded, SimError>;
}

/// Where a run stands after [`Savable::advance`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// It can go on.
    Running,
    /// It has ended.
    Ended(End),
}

/// A bench whose runs can be saved in the middle and continued.
pub trait Savable: Bench {
    /// A run in progress.
    type Running: Send;
    /// Everything that determines how a run goes on, with what it has recorded so far.
    type Saved: Clone + Send + Sync;

    /// Begins a run.
    ///
    /// # Errors
    /// As [`Bench::run`].
    fn start(&self, stimulus: &Stimulus, seed: u64) -> Result<Self::Running, SimError>;

    /// Goes on until `until_secs` of simulated time or the run's end, whichever comes first.
    ///
    /// # Errors
    /// As [`Bench::run`].
    fn advance(
        &self,
        running: &mut Self::Running,
        until_secs: f64,
        watch: &mut dyn Watch,
        cancel: &Cancel,
    ) -> Result<Status, SimError>;

    /// Simulated time.
    fn now_secs(&self, running: &Self::Running) -> f64;

    /// What was recorded so far.
    fn so_far<'a>(&self, running: &'a Self::Running) -> &'a Trace;

    /// Everything that determines how the run goes on.
    ///
    /// # Errors
    /// When memory does not suffice.
    fn save(&self, running: &Self::Running) -> Result<Self::Saved, SimError>;

    /// A run that goes on from a saved one. Without a seed it continues bit for bit as that one
    /// would; with one, whatever is still to be drawn is drawn anew.
    ///
    /// # Errors
    /// As [`Bench::run`].
    fn resume(&self, saved: &Self::Saved, new_seed: Option<u64>)
    -> Result<Self::Running, SimError>;

    /// Closes the recording.
    ///
    /// # Errors
    /// [`SimError::Unstable`] when the physics has failed in the last steps.
    fn finish(&self, running: Self::Running) -> Result<Recorded, SimError>;
}
