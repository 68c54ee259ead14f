//! A bench of a study that takes any stimulus: the handover world, a scene, or another simulator.

use crate::rigs::{self, Opening};
use crate::technique::campaign::is_of_physics;
use diagnostic::Problem;
use host::store::Inputs;
use host::{Cancel, Host};
use rig::Rig;
pub use rig::failed;
use std::path::Path;
use stimulus::{AbstractTest, Stimulus};
use study::{BenchFiles, CommandText, Entry, PhysicsEngine, Simulated, Study};
use testbench::{Drawn, End, Failure, Part, Recorded, SimError, Unwatched, Watch};
use toml::Table;
use trace::Trace;

/// A rig that is ready to run, with the files that it is made of.
pub struct OpenBench {
    rig: Box<dyn Rig>,
    /// What it is made of.
    pub files: BenchFiles,
    /// The version of the physics engine.
    pub engine: String,
}

impl OpenBench {
    /// The bench of a ledger's entry.
    pub fn of_entry(study: &Study, entry: &Entry, host: &Host) -> Result<Self, Problem> {
        Self::of_files(study, &Self::files_of(entry)?, host)
    }

    /// The files of the bench of a ledger's entry.
    pub fn files_of(entry: &Entry) -> Result<BenchFiles, Problem> {
        let shown = |path: &Path| Some(path.display().to_string());
        let mut files = BenchFiles {
            evidence: entry.id.clone(),
            ..BenchFiles::default()
        };
        let simulated = entry.work.simulated();
        // What is not said is MuJoCo's, as in files that were written before there was a choice.
        let engine = simulated.and_then(Simulated::engine);
        files.engine = engine.filter(|it| *it != PhysicsEngine::default());
        match simulated {
            Some(Simulated::Handover {
                scenario,
                parameters,
                ..
            }) => {
                files.scenario = shown(scenario);
                files.parameters = shown(parameters);
            }
            Some(Simulated::Scene { scene, .. }) => files.scene = shown(scene),
            Some(Simulated::Command(_)) => {}
            None => {
                return Err(Problem::new(
                    "not-a-simulation",
                    format!("`{}` is not a simulation that takes tests", entry.id),
                )
                .remedy("name an entry of the ledger with a scenario, a scene or a command"));
            }
        }
        Ok(files)
    }

    /// The bench that is made of these files of the study.
    pub fn of_files(study: &Study, files: &BenchFiles, host: &Host) -> Result<Self, Problem> {
        let simulated = command_of(study, files).map(Simulated::Command);
        let of_files = || {
            let (scenario, scene) = (files.scenario.as_deref(), files.scene.as_deref());
            let parameters = files.parameters.as_deref().map(Path::new);
            let (scenario, scene) = (scenario.map(Path::new), scene.map(Path::new));
            rigs::of_files(
                scenario,
                parameters,
                scene,
                files.engine.unwrap_or_default(),
            )
        };
        let simulated = simulated.or_else(of_files);
        let simulated = simulated.ok_or_else(|| {
            Problem::new(
                "bad-finding",
                "a bench is a scenario with parameters, a scene, or an entry of the ledger with a command",
            )
            .remedy("name `scenario` and `parameters`, or `scene`, or neither for a command")
        })?;
        let opening = Opening {
            joined: Some(" with "),
            ..Opening::new(study, host)
        };
        Ok(Self::of_rig(opening.open(simulated)?, files.clone()))
    }

    fn of_rig(rig: Box<dyn Rig>, files: BenchFiles) -> Self {
        Self {
            engine: rig.engine(),
            rig,
            files,
        }
    }

    /// The same bench in a fast, approximate physics, if it has one: for searching. What is found there is to be
    /// shown by the bench itself, which is always that of the full physics.
    pub fn in_fast_physics(&self) -> Option<Self> {
        let fast = self.rig.in_fast_physics()?;
        Some(Self::of_rig(fast, self.files.clone()))
    }

    /// Whether it is a simulator of others: it shows no bodies and does not say what it draws.
    pub fn is_outside(&self) -> bool {
        self.rig.is_outside()
    }

    /// The tests that the bench's own files have.
    pub fn own_tests(&self) -> &[AbstractTest] {
        self.rig.tests()
    }

    /// The channels of every recording, without rows. Another simulator is run for them.
    pub fn layout(&self, interrupt: &Cancel) -> Result<Trace, Problem> {
        self.rig.layout(interrupt)
    }

    /// The bench's data, on which settings act.
    pub fn data(&self) -> &Table {
        self.rig.data()
    }

    /// The time by which every episode ends, as the bench's own data say;
    /// `None` of another simulator.
    pub fn ends_by_secs(&self) -> Option<f64> {
        self.rig.ends_by_secs()
    }

    /// The numbers that an episode draws once from its seed, where no setting
    /// fixes them; `None` of a bench that does not say.
    pub fn drawn(&self, stimulus: &Stimulus, seed: u64) -> Result<Option<Vec<Drawn>>, Problem> {
        let drawn = self.rig.drawn(stimulus, seed);
        drawn.map_err(|error| failed(&error))
    }

    /// Why a stimulus cannot be run, if it sets what the bench does not have;
    /// another simulator decides that itself.
    pub fn refuses(&self, stimulus: &Stimulus) -> Option<String> {
        self.rig.refuses(stimulus)
    }

    /// Adds all that an episode depends on beside its seed, its stimulus and
    /// this program.
    pub fn inputs(&self, inputs: &mut Inputs) {
        self.rig.inputs(inputs);
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
            Err(error) if is_of_physics(&error) && !self.is_outside() => error,
            other => return other,
        };
        let Ok(mut trace) = self.layout(interrupt) else {
            return Err(error);
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
        self.rig.run(stimulus, seed, watch, interrupt)
    }
}

/// The command that a bench without files of its own is.
pub fn command_of<'s>(study: &'s Study, files: &BenchFiles) -> Option<&'s CommandText> {
    let has_files = files.scenario.is_some() || files.parameters.is_some() || files.scene.is_some();
    let entry = study.entry(&files.evidence).ok()?;
    entry.work.command().filter(|_| !has_files)
}
