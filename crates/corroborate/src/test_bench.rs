//! The handover's bench with the one test that all its episodes enact, at points of a space of settings.

use crate::technique::simulation::{load_engine, scenario_problem};
use diagnostic::{Problem, Source};
use handover::HandoverBench;
use host::BuildId;
use host::store::Inputs;
use std::path::Path;
use stimulus::{Space, Stimulus};
use testbench::SimError;

/// A test with the settings of a point of `space`.
pub fn stimulus_at(test: &Stimulus, space: &Space, unit: &[f64]) -> Result<Stimulus, Problem> {
    space
        .stimulus(&test.test, &space.at(unit))
        .map_err(|error| Problem::new("bad-settings", error.to_string()))
}

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
    /// The same bench in the fast physics, if there is one: for searching.
    pub fn in_fast_physics(&self) -> Option<Self> {
        Some(Self {
            bench: self.bench.in_fast_physics()?,
            test: self.test.clone(),
            engine: format!("{}, fast physics", self.engine),
            scenario_text: self.scenario_text.clone(),
            parameters_text: self.parameters_text.clone(),
        })
    }

    /// Loads the engine and checks scenario and parameters.
    pub fn new(
        scenario: &Source,
        parameters: &Source,
        test: &str,
        library: Option<&Path>,
    ) -> Result<Self, Problem> {
        let engine = load_engine(library)?;
        let bench =
            HandoverBench::new(&engine, &scenario.text, &parameters.text).map_err(|error| {
                let names = format!("{}, {}", scenario.name, parameters.name);
                scenario_problem(&names, &error)
            })?;
        let test = bench
            .own_test(test)
            .map_err(|error| scenario_problem(&scenario.name, &error))?;
        Ok(Self {
            engine: format!("MuJoCo {}", engine.version()),
            bench,
            test,
            scenario_text: scenario.text.clone(),
            parameters_text: parameters.text.clone(),
        })
    }

    /// What every episode depends on, besides its seed and its settings.
    pub fn inputs(&self, inputs: &mut Inputs, build: &BuildId) -> Result<(), Problem> {
        inputs
            .add("scenario", self.scenario_text.as_bytes())
            .add("parameters", self.parameters_text.as_bytes())
            .add("engine", self.engine.as_bytes())
            .add("program", build.as_str().as_bytes())
            .add("test", self.test.test.name.as_bytes());
        Ok(())
    }

    /// The test with the settings of a point of `space`.
    pub fn stimulus(&self, space: &Space, unit: &[f64]) -> Result<Stimulus, Problem> {
        stimulus_at(&self.test, space, unit)
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
