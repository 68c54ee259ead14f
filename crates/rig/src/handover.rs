//! The handover as a rig: a scenario and a parameter set, whose robot is code of the crate `handover`.

mod readings;

use super::command::OutsideCommand;
use super::place::problem_in;
use super::rest::{Link, Pace, Rest};
use super::rig::{Rig, episode_name, failed, secs_of};
use super::saving::Resumable;
use ::handover::{
    HandoverBench, Outside, OutsideReadings, Parameters, Physics, Scenario, run_episode_with,
};
use diagnostic::{Problem, Problems, Source};
use evidence::{Asset, DescriptionGap, Tool};
use host::store::Inputs;
use host::{BuildId, Cancel};
use readings::{Input, ReadingsLink, SharedReadings};
use serde::Deserialize;
use std::ops::ControlFlow;
use std::sync::Arc;
use stimulus::{AbstractTest, Stimulus};
use testbench::{Bench, Drawn, Recorded, ScenarioError, SimError, Watch};
use toml::Table;
use trace::Trace;

/// The handover, with the test that its episodes enact.
#[derive(Clone)]
pub struct HandoverRig {
    bench: HandoverBench,
    scenario: Scenario,
    scenario_text: String,
    parameters_text: String,
    tests: Vec<AbstractTest>,
    stimulus: Stimulus,
    /// The physics engine's name and version.
    engine: (&'static str, String),
    is_fast: bool,
}

/// The texts of a handover, and how their mistakes are told.
pub struct HandoverTexts<'a> {
    /// The scenario.
    pub scenario: &'a Source,
    /// The parameter set.
    pub parameters: &'a Source,
    /// What stands between their names where a mistake is told of both; without it, it is told of the one that has it.
    pub joined: Option<&'a str>,
}

impl HandoverRig {
    /// The handover of these texts, in the physics that `physics` loads once they are needed. `test` is one of the
    /// scenario's own tests, the first if it is not named.
    ///
    /// # Errors
    /// `fast-physics-as-evidence`, `bad-scenario`, `simulation-failed`, and what `physics` says.
    pub fn new(
        texts: &HandoverTexts<'_>,
        test: Option<&str>,
        physics: &dyn Fn() -> Result<Physics, Problem>,
    ) -> Result<Self, Problem> {
        in_full_physics(texts.scenario)?;
        let (bench, engine) = texts.bench(physics)?;
        let of_scenario = |error: SimError| scenario_problem(&texts.scenario.name, &error);
        let scenario = Scenario::parse(&texts.scenario.text);
        let scenario = scenario.map_err(|error| of_scenario(error.into()))?;
        let tests = tests_of(&bench, &texts.scenario.name)?;
        let first = tests.first().map(|test| test.name.as_str());
        let stimulus = bench.own_test(test.or(first).unwrap_or_default());
        Ok(Self {
            stimulus: stimulus.map_err(of_scenario)?,
            bench,
            scenario,
            scenario_text: texts.scenario.text.clone(),
            parameters_text: texts.parameters.text.clone(),
            tests,
            engine,
            is_fast: false,
        })
    }
}

impl HandoverTexts<'_> {
    /// The bench, and its engine's name and version.
    fn bench(
        &self,
        physics: &dyn Fn() -> Result<Physics, Problem>,
    ) -> Result<(HandoverBench, (&'static str, String)), Problem> {
        let (scenario, parameters) = (self.scenario, self.parameters);
        if self.joined.is_none() {
            let mut found = Problems::new();
            let read = Scenario::parse(&scenario.text);
            found.keep(read.map_err(|it| problem_in::<Scenario>("bad-scenario", scenario, &it)));
            let read = Parameters::parse(&parameters.text);
            found
                .keep(read.map_err(|it| problem_in::<Parameters>("bad-scenario", parameters, &it)));
            found.or(())?;
        }
        let physics = physics()?;
        let bench = HandoverBench::new(&physics, &scenario.text, &parameters.text);
        let bench = bench.map_err(|error| match self.joined {
            Some(joined) => {
                let files = format!("{}{joined}{}", scenario.name, parameters.name);
                scenario_problem(&files, &error)
            }
            None => Problem::new("simulation-failed", error.to_string()),
        })?;
        Ok((bench, (physics.name(), physics.version())))
    }
}

fn tests_of(bench: &HandoverBench, file: &str) -> Result<Vec<AbstractTest>, Problem> {
    let tests = bench.data()["scenario"].get("abstract_test").cloned();
    let tests = tests.unwrap_or_else(|| toml::Value::Array(Vec::new()));
    tests
        .try_into()
        .map_err(|error| Problem::new("bad-scenario", format!("{file}: {error}")))
}

impl Rig for HandoverRig {
    fn engine(&self) -> String {
        let physics = match self.is_fast {
            true => ", fast physics",
            false => "",
        };
        format!("{} {}{physics}", self.engine.0, self.engine.1)
    }

    fn tool(&self) -> Tool {
        Tool {
            name: self.engine.0.to_owned(),
            version: self.engine.1.clone(),
            settings: format!("time step {} s", self.scenario.simulation.time_step_secs),
        }
    }

    fn is_outside(&self) -> bool {
        false
    }

    fn assets(&self) -> &[Asset] {
        &[]
    }

    fn gaps(&self) -> &[DescriptionGap] {
        &[]
    }

    fn checked(&self) -> &[String] {
        &[]
    }

    fn truth(&self) -> Option<testbench::scene::TruthVocabulary> {
        None
    }

    fn stimulus(&self) -> &Stimulus {
        &self.stimulus
    }

    fn tests(&self) -> &[AbstractTest] {
        &self.tests
    }

    fn data(&self) -> &Table {
        self.bench.data()
    }

    fn time_step_key(&self) -> Option<&'static str> {
        Some("scenario.simulation.time_step_secs")
    }

    fn ends_by_secs(&self) -> Option<f64> {
        let simulation = self.data().get("scenario")?.get("simulation")?;
        secs_of(simulation.get("longest_secs")?)
    }

    fn own_inputs(&self, inputs: &mut Inputs) {
        let (name, version) = &self.engine;
        inputs.add("engine", version.as_bytes());
        if *name != "MuJoCo" {
            inputs.add("engine_name", name.as_bytes());
        }
        inputs
            .add("scenario", self.scenario_text.as_bytes())
            .add("parameters", self.parameters_text.as_bytes());
    }

    fn inputs(&self, inputs: &mut Inputs) {
        inputs
            .add("engine", self.engine().as_bytes())
            .add("bench", self.data().to_string().as_bytes());
    }

    fn test_inputs(&self, build: &BuildId, inputs: &mut Inputs) {
        inputs
            .add("scenario", self.scenario_text.as_bytes())
            .add("parameters", self.parameters_text.as_bytes())
            .add("engine", self.engine().as_bytes())
            .add("program", build.as_str().as_bytes())
            .add("test", self.stimulus.test.name.as_bytes());
    }

    fn reading_inputs(&self, _: &mut Inputs) {}

    fn recording_name(&self, number: u64) -> String {
        episode_name(number)
    }

    fn layout(&self, _: &Cancel) -> Result<Trace, Problem> {
        self.bench.layout().map_err(|error| failed(&error))
    }

    fn drawn(&self, stimulus: &Stimulus, seed: u64) -> Result<Option<Vec<Drawn>>, SimError> {
        self.bench.drawn(stimulus, seed).map(Some)
    }

    fn refuses(&self, stimulus: &Stimulus) -> Option<String> {
        match self.bench.world(stimulus, 0) {
            Err(SimError::Stimulus { reason }) => Some(reason),
            _ => None,
        }
    }

    fn run(
        &self,
        stimulus: &Stimulus,
        seed: u64,
        watch: &mut dyn Watch,
        cancel: &Cancel,
    ) -> Result<Recorded, SimError> {
        self.bench.run(stimulus, seed, watch, cancel)
    }

    fn in_fast_physics(&self) -> Option<Box<dyn Rig>> {
        Some(Box::new(Self {
            bench: self.bench.in_fast_physics()?,
            is_fast: true,
            ..self.clone()
        }))
    }

    fn resumable(&self) -> Option<&dyn Resumable> {
        Some(&self.bench)
    }

    fn rest(&self, is_outside: &dyn Fn(&[String]) -> bool) -> Option<Arc<dyn Rest>> {
        let inputs = Input::from_outside(is_outside);
        Some(Arc::new(HandoverRest {
            rig: self.clone(),
            readings: SharedReadings::new(&inputs),
            inputs,
        }))
    }

    fn leaves(&self) -> Option<&OutsideCommand> {
        None
    }
}

/// The handover's robot and person without what comes from outside.
struct HandoverRest {
    rig: HandoverRig,
    inputs: Vec<Input>,
    readings: SharedReadings,
}

impl Rest for HandoverRest {
    fn signals(&self) -> Vec<String> {
        self.inputs.iter().flat_map(|it| it.signals()).collect()
    }

    fn link(&self, layout: &Trace) -> Result<Box<dyn Link>, Problem> {
        let link = ReadingsLink::new(&self.inputs, layout, self.readings.clone())?;
        Ok(Box::new(link))
    }

    fn period_secs(&self) -> f64 {
        1.0 / f64::from(self.rig.scenario.rates.controller_hz.max(1))
    }

    fn run(&self, seed: u64, pace: &mut dyn Pace) -> Result<(Trace, f64), SimError> {
        let world = self.rig.bench.world(&self.rig.stimulus, seed)?;
        pace.start();
        let readings = &self.readings;
        let mut outside = Paced { readings, pace };
        let episode = run_episode_with(&world, seed, &Cancel::default(), &mut outside)?;
        Ok((episode.trace, episode.sim_secs))
    }
}

/// Somebody who keeps time, as the handover's world knows it.
struct Paced<'p> {
    readings: &'p SharedReadings,
    pace: &'p mut dyn Pace,
}

impl Outside for Paced<'_> {
    fn step(&mut self, now_secs: f64, recorded: &Trace) -> ControlFlow<()> {
        self.pace.step(now_secs, recorded)
    }

    fn readings(&self) -> OutsideReadings {
        self.readings.now()
    }
}

/// The part of a scenario that says in which physics it is simulated.
#[derive(Deserialize)]
struct PhysicsText {
    simulation: Option<PhysicsOfScenario>,
}

#[derive(Deserialize)]
struct PhysicsOfScenario {
    fast: Option<toml::Spanned<bool>>,
}

/// Refuses a scenario that asks for the fast physics: what is counted would be approximate, and nothing in a count, a
/// verdict or a table of episodes shows it.
fn in_full_physics(source: &Source) -> Result<(), Problem> {
    let text: Option<PhysicsText> = toml::from_str(&source.text).ok();
    let fast = text.and_then(|text| text.simulation?.fast);
    match fast {
        Some(fast) if *fast.get_ref() => Err(Problem::new(
            "fast-physics-as-evidence",
            "evidence must be simulated in the full physics, and this scenario asks for the fast one, which is approximate",
        )
        .at(source, fast.span())
        .remedy("remove `fast`; explore, shrink and calibrate search in the fast physics by themselves (`physics`)")),
        _ => Ok(()),
    }
}

/// What is wrong with the scenario or the parameters in these files.
fn scenario_problem(files: &str, error: &SimError) -> Problem {
    let said = error.to_string();
    let problem = Problem::new("bad-scenario", format!("{files}: {}", said.trim_end()));
    match error {
        SimError::Scenario(ScenarioError::Syntax { .. }) => problem.remedy(
            "correct that place of the file; `corroborate explain scenario` and `corroborate explain parameters` say what is in it",
        ),
        _ => problem.remedy("correct it in the file (`corroborate explain bad-scenario`)"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(text: &str) -> Source {
        Source {
            name: "scenario.toml".to_owned(),
            text: text.to_owned(),
        }
    }

    #[test]
    fn an_empty_scenario_is_refused_with_what_it_lacks_and_a_remedy() {
        let (scenario, parameters) = (source(""), source(""));
        let texts = HandoverTexts {
            scenario: &scenario,
            parameters: &parameters,
            joined: None,
        };
        let physics = || -> Result<Physics, Problem> { panic!("texts are read first") };
        let refused = HandoverRig::new(&texts, None, &physics).err();
        let said = refused.expect("it is empty").to_string();
        for part in [
            "scenario.toml:1:1",
            "missing field `name`",
            "missing field `simulation`",
            "add `name = ...`",
        ] {
            assert!(said.contains(part), "{said}");
        }
    }

    #[test]
    fn a_scenario_in_the_fast_physics_is_refused_with_its_place() {
        let refused = in_full_physics(&source(
            "name = \"x\"\n[simulation]\nstep = 1\nfast = true\n",
        ));
        let refused = refused.expect_err("it is fast");
        assert_eq!(refused.code, "fast-physics-as-evidence");
        let said = refused.to_string();
        assert!(said.contains("scenario.toml:4:8"), "{said}");
        for text in [
            "[simulation]\nfast = false\n",
            "[simulation]\n",
            "",
            "not toml",
        ] {
            // What else is wrong is told elsewhere.
            assert!(in_full_physics(&source(text)).is_ok(), "{text}");
        }
    }
}
