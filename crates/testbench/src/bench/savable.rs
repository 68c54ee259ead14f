//! Runs that are saved in the middle and continued.

use stimulus::Stimulus;
use trace::Trace;

use super::{Bench, Cancel, End, Recorded, SimError, Watch};

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
