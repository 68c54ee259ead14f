//! One episode: a world and a seed give one trace, bit for bit.

use testbench::{Cancel, End, Recorded, SimError, Unwatched, Watch};
use trace::Trace;

use super::judge::Outcome;
use super::run::Run;
use super::setup::World;
use crate::outside::{Nothing, Outside};

/// What an episode gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Episode {
    /// Everything recorded.
    pub trace: Trace,
    /// How it ended, in short.
    pub outcome: Outcome,
    /// Physics steps taken.
    pub steps: u64,
    /// Simulated time.
    pub sim_secs: f64,
    /// Why it ended.
    pub end: End,
}

impl From<Episode> for Recorded {
    fn from(episode: Episode) -> Self {
        Self {
            trace: episode.trace,
            steps: episode.steps,
            sim_secs: episode.sim_secs,
            end: episode.end,
            // Its controller is code of this crate, which has no way to fail.
            failure: None,
        }
    }
}

/// Runs one episode.
///
/// # Errors
/// [`SimError::Cancelled`] when `cancel` is set, [`SimError::Unstable`] when the physics fails.
pub fn run_episode(world: &World, seed: u64, cancel: &Cancel) -> Result<Episode, SimError> {
    run(world, seed, &mut Unwatched, cancel, &mut Nothing)
}

/// Runs one episode that `watch` looks at and may end early.
///
/// # Errors
/// As [`run_episode`].
pub fn watch_episode(
    world: &World,
    seed: u64,
    watch: &mut dyn Watch,
    cancel: &Cancel,
) -> Result<Episode, SimError> {
    run(world, seed, watch, cancel, &mut Nothing)
}

/// Runs one episode that is joined to `outside`.
///
/// # Errors
/// [`SimError::Cancelled`] when `cancel` is set or `outside` breaks off, [`SimError::Unstable`]
/// when the physics fails.
pub fn run_episode_with(
    world: &World,
    seed: u64,
    cancel: &Cancel,
    outside: &mut dyn Outside,
) -> Result<Episode, SimError> {
    run(world, seed, &mut Unwatched, cancel, outside)
}

fn run(
    world: &World,
    seed: u64,
    watch: &mut dyn Watch,
    cancel: &Cancel,
    outside: &mut dyn Outside,
) -> Result<Episode, SimError> {
    let mut run = Run::new(world, seed)?;
    while run.ended().is_none() {
        run.check(cancel)?;
        run.from_outside = outside.readings();
        run.advance(watch)?;
        if outside.step(run.now_secs(), run.so_far()).is_break() {
            return Err(SimError::Cancelled);
        }
    }
    run.finish(watch)
}
