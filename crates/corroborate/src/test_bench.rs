//! A rig with the one test that all its episodes enact, at points of a space of settings.

use diagnostic::Problem;
use rig::Rig;
use stimulus::{Space, Stimulus};
use testbench::SimError;

/// A test with the settings of a point of `space`.
pub fn stimulus_at(test: &Stimulus, space: &Space, unit: &[f64]) -> Result<Stimulus, Problem> {
    space
        .stimulus(&test.test, &space.at(unit))
        .map_err(|error| Problem::new("bad-settings", error.to_string()))
}

/// Whether an episode of a stimulus can begin: where the rig can be stopped there, it is begun.
pub fn begins(rig: &dyn Rig, stimulus: &Stimulus) -> Result<(), SimError> {
    match rig.resumable() {
        Some(bench) => bench.start(stimulus, 0).map(drop),
        None => match rig.refuses(stimulus) {
            Some(reason) => Err(SimError::Stimulus { reason }),
            None => Ok(()),
        },
    }
}

/// A simulation's error as a problem.
pub fn simulation_problem(error: SimError, seed: u64) -> Problem {
    match error {
        SimError::Cancelled => Problem::interrupted(),
        SimError::Stimulus { reason } => Problem::new("bad-settings", reason)
            .remedy("correct the keys that the parameters of the file set"),
        other => Problem::new("simulation-failed", format!("seed {seed}: {other}")),
    }
}
