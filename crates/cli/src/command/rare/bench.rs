//! The handover world of a study, ready for campaigns over its stimuli.

use crate::problem::{Problem, Source};
use crate::store::{Inputs, program_hash};
use std::path::Path;
use stimulus::{Space, Stimulus};
use testbench::{Engine, HandoverBench, SimError};

/// A bench with the test that its episodes enact.
pub struct TestBench {
    pub bench: HandoverBench,
    /// The test, without settings.
    pub test: Stimulus,
    /// The engine's name and version.
    pub engine: String,
    scenario_text: String,
    parameters_text: String,
}

impl TestBench {
    /// Loads the engine and checks scenario and parameters.
    pub fn new(
        scenario: &Source,
        parameters: &Source,
        test: &str,
        library: Option<&Path>,
    ) -> Result<Self, Problem> {
        let Some(library) = library else {
            let message = "simulations need the MuJoCo library, whose place is not known";
            return Err(Problem::new("no-physics-library", message).remedy(
                "start the program as `./corroborate`, which fetches it, or set CORROBORATE_MUJOCO to its path",
            ));
        };
        let engine = Engine::load(library).map_err(|error| {
            Problem::new("no-physics-library", error.to_string())
                .remedy("run `tools/mujoco`, which fetches the version that is needed")
        })?;
        let bench =
            HandoverBench::new(&engine, &scenario.text, &parameters.text).map_err(|error| {
                let names = format!("{}, {}", scenario.name, parameters.name);
                Problem::new("bad-scenario", format!("{names}: {error}"))
            })?;
        let test = bench
            .own_test(test)
            .map_err(|error| Problem::new("bad-scenario", format!("{}: {error}", scenario.name)))?;
        Ok(Self {
            engine: format!("MuJoCo {}", engine.version()),
            bench,
            test,
            scenario_text: scenario.text.clone(),
            parameters_text: parameters.text.clone(),
        })
    }

    /// What every episode depends on, besides its seed and its settings.
    pub fn inputs(&self, inputs: &mut Inputs) -> Result<(), Problem> {
        inputs
            .add("scenario", self.scenario_text.as_bytes())
            .add("parameters", self.parameters_text.as_bytes())
            .add("engine", self.engine.as_bytes())
            .add("program", program_hash()?.as_bytes())
            .add("test", self.test.test.name.as_bytes());
        Ok(())
    }

    /// The test with the settings of a point of `space`.
    pub fn stimulus(&self, space: &Space, unit: &[f64]) -> Result<Stimulus, Problem> {
        space
            .stimulus(&self.test.test, &space.at(unit))
            .map_err(|error| Problem::new("bad-settings", error.to_string()))
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
