//! What a file of rare events is estimated in.

use super::file::{CODE, RareText};
use crate::technique::simulation::{load_engine, scenario_source};
use crate::test_bench::TestBench;
use diagnostic::{Problem, Source};
use host::BuildId;
use host::store::Inputs;
use rig::SceneCampaign;
use std::path::Path;
use study::Study;

/// The bench of a file of rare events.
pub enum World {
    /// The handover.
    Handover(Box<TestBench>),
    /// A scene with any robot, and the engine's name and version.
    Scene(Box<SceneCampaign>, String),
}

impl World {
    /// Opens what the file names.
    pub fn open(
        study: &Study,
        source: &Source,
        text: &RareText,
        library: Option<&Path>,
    ) -> Result<Self, Problem> {
        match (&text.scenario, &text.parameters, &text.scene) {
            (Some(scenario), Some(parameters), None) => {
                // An estimate is a figure: it is of the full physics, however long that takes.
                let scenario = scenario_source(&study.folder.join(scenario))?;
                let parameters = host::files::read_source(&study.folder.join(parameters))?;
                let bench = TestBench::new(&scenario, &parameters, &text.test, library)?;
                Ok(Self::Handover(Box::new(bench)))
            }
            (None, None, Some(scene)) => {
                let engine = load_engine(library)?;
                let scene = SceneCampaign::new(study, scene, Some(&text.test), &engine)?;
                let engine = format!("MuJoCo {}", engine.version());
                Ok(Self::Scene(Box::new(scene), engine))
            }
            _ => Err(Problem::new(
                CODE,
                "the file names neither a scene alone nor a scenario with its parameters",
            )
            .at(source, 0..source.text.lines().next().map_or(0, str::len))
            .remedy("give `scene`, or `scenario` and `parameters`")),
        }
    }

    /// The engine's name and version.
    pub fn engine(&self) -> &str {
        match self {
            Self::Handover(bench) => &bench.engine,
            Self::Scene(_, engine) => engine,
        }
    }

    /// What every episode depends on, besides its seed and its settings.
    pub fn inputs(&self, inputs: &mut Inputs, build: &BuildId) -> Result<(), Problem> {
        match self {
            Self::Handover(bench) => bench.inputs(inputs, build),
            Self::Scene(scene, engine) => {
                scene.inputs(inputs);
                inputs
                    .add("engine", engine.as_bytes())
                    .add("program", build.as_str().as_bytes());
                Ok(())
            }
        }
    }
}
