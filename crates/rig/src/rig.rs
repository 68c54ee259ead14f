//! What every thing under test looks like to the engine: a rig.
//!
//! A rig turns a stimulus and a seed into a recording. It is the handover, a scene or a program of others, and nobody
//! asks which: what only some rigs can do (save a run, search in a fast physics, be the rest of a robot, leave recordings
//! of their own) is a method that gives `None` of the others. No method has a default, so that who adds a rig decides each.

use super::command::OutsideCommand;
use super::rest::Rest;
use super::saving::Resumable;
use diagnostic::Problem;
use evidence::{Asset, DescriptionGap, Tool};
use host::store::Inputs;
use host::{BuildId, Cancel};
use std::sync::Arc;
use stimulus::{AbstractTest, Stimulus};
use testbench::scene::TruthVocabulary;
use testbench::{Drawn, Recorded, SimError, Watch};
use toml::Table;
use trace::Trace;

/// Whatever turns a stimulus and a seed into a recording: the same stimulus and seed, the same bytes.
pub trait Rig: Send + Sync {
    /// The engine as reports name it, with its version; of a command, the program.
    fn engine(&self) -> String;

    /// The engine and the settings that can move a number.
    fn tool(&self) -> Tool;

    /// Whether it is a simulator of others: it shows no bodies, does not say what it draws, and runs the same whichever
    /// build of this program calls it.
    fn is_outside(&self) -> bool;

    /// The files that it names besides those that the ledger names: robots' descriptions, their code.
    fn assets(&self) -> &[Asset];

    /// What of robots' descriptions is not simulated.
    fn gaps(&self) -> &[DescriptionGap];

    /// What was checked before anything runs, and what could not be: sentences, each with its place.
    fn checked(&self) -> &[String];

    /// All truth that it can record because somebody reads it; `None` of a rig whose recordings always have the same signals.
    fn truth(&self) -> Option<TruthVocabulary>;

    /// What is done in each episode of the ledger's entry.
    fn stimulus(&self) -> &Stimulus;

    /// The tests that its own files have.
    fn tests(&self) -> &[AbstractTest];

    /// Its data, on which settings act.
    fn data(&self) -> &Table;

    /// The key of its data that is the time step of its physics; `None` if it has none that can be set.
    fn time_step_key(&self) -> Option<&'static str>;

    /// The time by which every episode ends, as its data say.
    fn ends_by_secs(&self) -> Option<f64>;

    /// What an episode of [`Rig::stimulus`] depends on, besides its seed and the build of this program. Names and order are
    /// those of results that were kept, here and in the other methods that add inputs.
    fn own_inputs(&self, inputs: &mut Inputs);

    /// What an episode of any stimulus depends on, besides that, its seed and the build of this program.
    fn inputs(&self, inputs: &mut Inputs);

    /// What an episode of [`Rig::stimulus`] with any settings depends on, besides those and its seed.
    fn test_inputs(&self, build: &BuildId, inputs: &mut Inputs);

    /// What judging its recordings depends on, besides the monitors.
    fn reading_inputs(&self, inputs: &mut Inputs);

    /// The name of an episode's recording.
    fn recording_name(&self, number: u64) -> String;

    /// The topics of every recording, without rows. A program of others is run for them.
    ///
    /// # Errors
    /// `simulation-failed`, `episode-failed`, `interrupted`.
    fn layout(&self, cancel: &Cancel) -> Result<Trace, Problem>;

    /// The numbers that an episode draws once from its seed, where no setting fixes them; `None` of a rig that does not
    /// say.
    ///
    /// # Errors
    /// [`SimError::Stimulus`].
    fn drawn(&self, stimulus: &Stimulus, seed: u64) -> Result<Option<Vec<Drawn>>, SimError>;

    /// Why a stimulus cannot be run, if it sets what the rig does not have; a program of others decides that itself.
    fn refuses(&self, stimulus: &Stimulus) -> Option<String>;

    /// Runs an episode, which `watch` may end.
    ///
    /// # Errors
    /// [`SimError::Stimulus`] for a stimulus that it does not understand, [`SimError::Cancelled`], and whatever keeps the
    /// simulation from going on. A controller that fails is no error: that is what the episode shows.
    fn run(
        &self,
        stimulus: &Stimulus,
        seed: u64,
        watch: &mut dyn Watch,
        cancel: &Cancel,
    ) -> Result<Recorded, SimError>;

    /// The same in a fast, approximate physics, if there is one: for searching. What is found there is to be shown by the
    /// rig itself, which is always that of the full physics.
    fn in_fast_physics(&self) -> Option<Box<dyn Rig>>;

    /// Its runs as ones that can be saved and continued, if they can.
    fn resumable(&self) -> Option<&dyn Resumable>;

    /// Its episodes as the simulated rest of a robot, if they can keep step with somebody. `is_outside` says whether one of
    /// these signals comes from outside.
    fn rest(&self, is_outside: &dyn Fn(&[String]) -> bool) -> Option<Arc<dyn Rest>>;

    /// The command, of a rig whose episodes leave recordings of their own.
    fn leaves(&self) -> Option<&OutsideCommand>;
}

/// The file name of an episode's recording that this program writes.
#[must_use]
pub fn episode_name(number: u64) -> String {
    format!("episode-{number:05}.mcap")
}

/// A failure of a rig, as the user is told.
#[must_use]
pub fn failed(error: &SimError) -> Problem {
    match error {
        SimError::Cancelled => Problem::interrupted(),
        other => Problem::new("simulation-failed", other.to_string()),
    }
}

/// A number of seconds in data, written with or without a point.
pub(crate) fn secs_of(value: &toml::Value) -> Option<f64> {
    value
        .as_float()
        .or_else(|| value.as_integer().map(|secs| secs as f64))
}
