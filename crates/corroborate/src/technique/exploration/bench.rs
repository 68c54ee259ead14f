//! A bench of a study that takes any stimulus: the handover world, a scene, or another simulator.

use super::command_bench::CommandBench;
use crate::technique::campaign::is_of_physics;
use crate::technique::simulation::{load_engine, scenario_problem, scenario_source};
use diagnostic::Problem;
use handover::HandoverBench;
use host::Cancel;
use host::store::Inputs;
use rig::SceneCampaign;
use std::path::Path;
use stimulus::{AbstractTest, Stimulus};
use study::{BenchFiles, CommandText, Entry, Simulated, Study};
use testbench::{Bench, Drawn, End, Engine, Failure, Part, Recorded, SimError, Unwatched, Watch};
use trace::Trace;

/// A bench that is ready to run, with the files that it is made of.
pub struct OpenBench {
    world: World,
    /// What it is made of.
    pub files: BenchFiles,
    /// The version of the physics engine.
    pub engine: String,
}

enum World {
    Handover {
        bench: Box<HandoverBench>,
        tests: Vec<AbstractTest>,
    },
    Scene(Box<SceneCampaign>),
    Command(Box<CommandBench>),
}

impl OpenBench {
    /// The bench of a ledger's entry.
    pub fn of_entry(study: &Study, entry: &Entry, library: Option<&Path>) -> Result<Self, Problem> {
        Self::of_files(study, &Self::files_of(entry)?, library)
    }

    /// The files of the bench of a ledger's entry.
    pub fn files_of(entry: &Entry) -> Result<BenchFiles, Problem> {
        let shown = |path: &Path| Some(path.display().to_string());
        let mut files = BenchFiles {
            evidence: entry.id.clone(),
            ..BenchFiles::default()
        };
        match entry.work.simulated() {
            Some(Simulated::Handover {
                scenario,
                parameters,
            }) => {
                files.scenario = shown(scenario);
                files.parameters = shown(parameters);
            }
            Some(Simulated::Scene { scene, .. }) => files.scene = shown(scene),
            Some(Simulated::Command(_)) => {}
            None => {
                return Err(Problem::new(
                    "not-a-simulation",
                    format!("`{}` is no simulation that takes tests", entry.id),
                )
                .remedy("name an entry of the ledger with a scenario, a scene or a command"));
            }
        }
        Ok(files)
    }

    /// The bench that is made of these files of the study.
    pub fn of_files(
        study: &Study,
        files: &BenchFiles,
        library: Option<&Path>,
    ) -> Result<Self, Problem> {
        if let Some(command) = command_of(study, files) {
            let bench = CommandBench::new(study, command)?;
            return Ok(Self {
                engine: format!("`{}`", bench.name()),
                world: World::Command(Box::new(bench)),
                files: files.clone(),
            });
        }
        let engine = load_engine(library)?;
        let world = match (&files.scenario, &files.parameters, &files.scene) {
            (Some(scenario), Some(parameters), None) => {
                handover(study, &engine, scenario, parameters)?
            }
            (None, None, Some(scene)) => {
                let scene = SceneCampaign::new(study, Path::new(scene), None, &engine)?;
                World::Scene(Box::new(scene))
            }
            _ => {
                return Err(Problem::new(
                    "bad-finding",
                    "a bench is a scenario with parameters, a scene, or an entry of the ledger with a command",
                )
                .remedy("name `scenario` and `parameters`, or `scene`, or neither for a command"));
            }
        };
        Ok(Self {
            world,
            files: files.clone(),
            engine: format!("MuJoCo {}", engine.version()),
        })
    }

    /// The same bench in a fast, approximate physics, if it has one: for searching. What is found there is to be
    /// shown by the bench itself, which is always that of the full physics.
    pub fn in_fast_physics(&self) -> Option<Self> {
        let World::Handover { bench, tests } = &self.world else {
            return None;
        };
        Some(Self {
            world: World::Handover {
                bench: Box::new(bench.in_fast_physics()?),
                tests: tests.clone(),
            },
            files: self.files.clone(),
            engine: format!("{}, fast physics", self.engine),
        })
    }

    /// Whether it is a simulator of others: it shows no bodies and does not say what it draws.
    pub fn is_outside(&self) -> bool {
        matches!(self.world, World::Command(_))
    }

    /// The tests that the bench's own files have.
    pub fn own_tests(&self) -> &[AbstractTest] {
        match &self.world {
            World::Handover { tests, .. } => tests,
            World::Scene(scene) => scene.bench().tests(),
            World::Command(command) => command.tests(),
        }
    }

    /// The channels of every recording, without rows. Another simulator is run for them.
    pub fn layout(&self, interrupt: &Cancel) -> Result<Trace, Problem> {
        let layout = match &self.world {
            World::Handover { bench, .. } => bench.layout(),
            World::Scene(scene) => scene.bench().layout(),
            World::Command(command) => return command.layout(interrupt),
        };
        layout.map_err(|error| failed(&error))
    }

    /// The bench's data, on which settings act.
    pub fn data(&self) -> &toml::Table {
        match &self.world {
            World::Handover { bench, .. } => bench.data(),
            World::Scene(scene) => scene.bench().table(),
            World::Command(command) => command.data(),
        }
    }

    /// The time by which every episode ends, as the bench's own data say;
    /// `None` of another simulator.
    pub fn ends_by_secs(&self) -> Option<f64> {
        let (simulation, key) = match &self.world {
            World::Handover { .. } => (
                self.data().get("scenario")?.get("simulation")?,
                "longest_secs",
            ),
            World::Scene(_) => (self.data().get("simulation")?, "duration_secs"),
            World::Command(_) => return None,
        };
        let secs = simulation.get(key)?;
        secs.as_float()
            .or_else(|| secs.as_integer().map(|secs| secs as f64))
    }

    /// The numbers that an episode draws once from its seed, where no setting
    /// fixes them; `None` of a bench that does not say.
    pub fn drawn(&self, stimulus: &Stimulus, seed: u64) -> Result<Option<Vec<Drawn>>, Problem> {
        let drawn = match &self.world {
            World::Handover { bench, .. } => bench.drawn(stimulus, seed),
            World::Scene(scene) => scene.bench().drawn(stimulus, seed),
            World::Command(_) => return Ok(None),
        };
        drawn.map(Some).map_err(|error| failed(&error))
    }

    /// Why a stimulus cannot be run, if it sets what the bench does not have;
    /// another simulator decides that itself.
    pub fn refuses(&self, stimulus: &Stimulus) -> Option<String> {
        let tried = match &self.world {
            World::Handover { bench, .. } => bench.world(stimulus, 0).map(drop),
            World::Scene(scene) => scene.bench().drawn(stimulus, 0).map(drop),
            World::Command(_) => Ok(()),
        };
        match tried {
            Err(SimError::Stimulus { reason }) => Some(reason),
            _ => None,
        }
    }

    /// Adds all that an episode depends on beside its seed, its stimulus and
    /// this program.
    pub fn inputs(&self, inputs: &mut Inputs) {
        inputs.add("engine", self.engine.as_bytes());
        inputs.add("bench", self.data().to_string().as_bytes());
        match &self.world {
            World::Handover { .. } => {}
            World::Scene(scene) => scene.inputs(inputs),
            World::Command(command) => command.inputs(inputs),
        }
    }

    /// Runs an episode to its end.
    pub fn run(
        &self,
        stimulus: &Stimulus,
        seed: u64,
        interrupt: &Cancel,
    ) -> Result<Recorded, SimError> {
        self.watched(stimulus, seed, &mut Unwatched, interrupt)
    }

    /// Runs an episode, which `watch` may end, as something to be shown: if its physics gave no numbers it is a
    /// simulator that failed, with a recording that has no rows, for what was recorded until then means nothing.
    pub fn again(
        &self,
        stimulus: &Stimulus,
        seed: u64,
        watch: &mut dyn Watch,
        interrupt: &Cancel,
    ) -> Result<Recorded, SimError> {
        let error = match self.watched(stimulus, seed, watch, interrupt) {
            Err(error) if is_of_physics(&error) => error,
            other => return other,
        };
        let mut trace = match &self.world {
            World::Handover { bench, .. } => bench.layout()?,
            World::Scene(scene) => scene.bench().layout()?,
            World::Command(_) => return Err(error),
        };
        trace.complete = false;
        let sim_secs = match &error {
            SimError::Unstable { time_secs, .. } => *time_secs,
            _ => 0.0,
        };
        Ok(Recorded {
            trace,
            steps: 0,
            sim_secs,
            end: End::Failed,
            failure: Some(Failure {
                part: Part::Simulator,
                is_hung: false,
                words: error.to_string(),
                in_setup: false,
            }),
        })
    }

    /// Runs an episode, which `watch` may end. Physics that gave no numbers is an error.
    pub fn watched(
        &self,
        stimulus: &Stimulus,
        seed: u64,
        watch: &mut dyn Watch,
        interrupt: &Cancel,
    ) -> Result<Recorded, SimError> {
        let cancel = &interrupt;
        match &self.world {
            World::Handover { bench, .. } => bench.run(stimulus, seed, watch, cancel),
            World::Scene(scene) => scene.bench().run(stimulus, seed, watch, cancel),
            World::Command(command) => command.run(stimulus, seed, watch, interrupt),
        }
    }
}

/// The command that a bench without files of its own is.
pub fn command_of<'s>(study: &'s Study, files: &BenchFiles) -> Option<&'s CommandText> {
    let has_files = files.scenario.is_some() || files.parameters.is_some() || files.scene.is_some();
    let entry = study.entry(&files.evidence).ok()?;
    entry.work.command().filter(|_| !has_files)
}

fn handover(
    study: &Study,
    engine: &Engine,
    scenario: &str,
    parameters: &str,
) -> Result<World, Problem> {
    let scenario = scenario_source(&study.folder.join(scenario))?;
    let parameters = host::files::read_source(&study.folder.join(parameters))?;
    let bench = HandoverBench::new(engine, &scenario.text, &parameters.text).map_err(|error| {
        let files = format!("{} with {}", scenario.name, parameters.name);
        scenario_problem(&files, &error)
    })?;
    let tests = bench.data()["scenario"].get("abstract_test").cloned();
    let tests = tests.unwrap_or_else(|| toml::Value::Array(Vec::new()));
    let tests: Vec<AbstractTest> = tests
        .try_into()
        .map_err(|error| Problem::new("bad-scenario", format!("{}: {error}", scenario.name)))?;
    let bench = Box::new(bench);
    Ok(World::Handover { bench, tests })
}

/// A failure of the bench, as the user is told.
pub fn failed(error: &SimError) -> Problem {
    match error {
        SimError::Cancelled => Problem::interrupted(),
        other => Problem::new("simulation-failed", other.to_string()),
    }
}
