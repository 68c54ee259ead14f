//! A scene as a campaign's bench: its files, its test, its controllers.

use super::place::{problem_of, span_of};
use super::process::Process;
use super::ros2::{self, Domains, Join, Ros2Controller};
use diagnostic::{Problem, Source, did_you_mean};
use evidence::{Asset, AssetRole, DescriptionGap};
use host::Cancel;
use host::store::{Inputs, hash_of};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use stimulus::{AbstractTest, Stimulus};
use study::Study;
use testbench::controller::{Controller, ControllerError, RemoteController};
use testbench::scene::{
    BuildPhysics, ControllerData, SceneBench, SceneGap, StartController, mujoco,
};
use testbench::{Bench, Engine, Recorded, SimError, Watch};

/// A scene and the test that is enacted in it.
pub struct SceneCampaign {
    bench: SceneBench,
    stimulus: Stimulus,
    text: String,
    /// The files that the scene consists of.
    assets: Vec<Asset>,
    gaps: Vec<DescriptionGap>,
}

impl SceneCampaign {
    /// Reads a scene of a study, with everything that it names. `test` is one
    /// of the scene's own tests, the first if it is not named.
    pub fn new(
        study: &Study,
        scene: &Path,
        test: Option<&str>,
        engine: &Engine,
    ) -> Result<Self, Problem> {
        Self::with_physics(study, scene, test, mujoco(engine))
    }

    /// The same with any physics engine.
    pub fn with_physics(
        study: &Study,
        scene: &Path,
        test: Option<&str>,
        physics: BuildPhysics,
    ) -> Result<Self, Problem> {
        let path = study.folder.join(scene);
        let source = host::files::read_source(&path)?;
        let folder = path.parent().unwrap_or(Path::new(".")).to_owned();
        let files = Mutex::new(BTreeMap::new());
        let read = |address: &str| {
            let local = address.strip_prefix("file://").unwrap_or(address);
            let bytes = std::fs::read(folder.join(local)).map_err(|e| e.to_string())?;
            let mut files = files.lock().unwrap_or_else(PoisonError::into_inner);
            files.insert(address.to_owned(), hash_of(&bytes));
            Ok(bytes)
        };
        ros2::check_text(&source.text).map_err(|(key, reason)| {
            let problem = Problem::new("bad-scene", format!("{key}: {reason}"));
            match span_of(&source.text, &key) {
                Some(span) => problem.at(&source, span),
                None => problem,
            }
        })?;
        let start = starter(&folder);
        let made = SceneBench::new(&source.text, &read, physics, start);
        let (bench, gaps) = made.map_err(|error| scene_problem(&source, &error))?;
        let stimulus = Stimulus::of(chosen(&bench, test, &source)?);
        for controller in &bench.data().controllers {
            // What of the command is a file is part of what is tested.
            for name in controller.command.iter().chain(&controller.files) {
                if folder.join(name).is_file() {
                    read(name).map_err(|error| Problem::new("bad-scene", error))?;
                }
            }
        }
        let files = files.into_inner().unwrap_or_else(PoisonError::into_inner);
        let beside = scene.parent().unwrap_or(Path::new(""));
        let assets = files.into_iter().map(|(path, hash)| Asset {
            role: AssetRole::SystemModel,
            path: plain(&beside.join(path)),
            hash,
        });
        Ok(Self {
            bench,
            stimulus,
            text: source.text,
            assets: assets.collect(),
            gaps: gaps.into_iter().map(|gap| in_study(beside, gap)).collect(),
        })
    }

    /// The bench itself, which takes any stimulus.
    pub fn bench(&self) -> &SceneBench {
        &self.bench
    }

    /// What an episode's trace depends on.
    pub fn inputs(&self, inputs: &mut Inputs) {
        inputs
            .add("scene", self.text.as_bytes())
            .add("test", self.stimulus.to_json().as_bytes())
            .add_json("files", &self.assets);
    }

    /// The files that the scene names, by their paths in the study.
    pub fn assets(&self) -> &[Asset] {
        &self.assets
    }

    /// What of the robots' descriptions is not carried over.
    pub fn gaps(&self) -> &[DescriptionGap] {
        &self.gaps
    }

    /// The settings that can move a number.
    pub fn settings(&self) -> String {
        let mut settings = format!(
            "time step {} s, test {}",
            self.bench.data().simulation.time_step_secs,
            self.stimulus.test.name
        );
        let is_node = |controller: &&ControllerData| controller.ros2.is_some();
        let controllers = &self.bench.data().controllers;
        if controllers.iter().any(|it| !is_node(&it)) {
            settings.push_str(", controllers as processes, their processor time counted");
        }
        for controller in controllers.iter().filter(is_node) {
            settings.push_str(&ros2::said_of(controller));
        }
        settings
    }

    /// The topics of its recordings, without rows.
    pub fn layout(&self) -> Result<trace::Trace, SimError> {
        self.bench.layout()
    }

    /// What is done in each episode.
    pub fn stimulus(&self) -> &Stimulus {
        &self.stimulus
    }

    /// One episode.
    pub fn run(
        &self,
        seed: u64,
        watch: &mut dyn Watch,
        interrupt: &Cancel,
    ) -> Result<Recorded, SimError> {
        self.bench.run(&self.stimulus, seed, watch, interrupt)
    }
}

/// A gap, its file by its path in the study; addresses such as `package://` stay what they are.
fn in_study(beside: &Path, gap: SceneGap) -> DescriptionGap {
    let file = match gap.file.contains("://") {
        true => gap.file,
        false => plain(&beside.join(&gap.file)),
    };
    DescriptionGap {
        file,
        line: gap.place.map(|[line, _]| line),
        column: gap.place.map(|[_, column]| column),
        element: gap.element,
        what: gap.what,
        effect: gap.effect,
        consequence: gap.consequence,
    }
}

/// A path without `a/../`, with `/` between its parts.
fn plain(path: &Path) -> String {
    let mut parts: Vec<String> = Vec::new();
    for part in path.components() {
        let part = part.as_os_str().to_string_lossy().into_owned();
        match (part.as_str(), parts.last().map(String::as_str)) {
            ("..", Some(last)) if last != ".." => {
                parts.pop();
            }
            (".", _) => {}
            _ => parts.push(part),
        }
    }
    parts.join("/")
}

/// Starts the scene's controllers in the scene's folder: as processes, or as
/// nodes of ROS 2.
fn starter(folder: &Path) -> StartController {
    let folder = folder.to_owned();
    let domains = Domains::default();
    Arc::new(move |data: &ControllerData| {
        let join = Join::of(data).map_err(|message| ControllerError::Failed { message })?;
        if let Some(join) = join {
            let node = Ros2Controller::new(join, data, &folder, &domains);
            return Ok(Box::new(node) as Box<dyn Controller>);
        }
        let limit = Duration::from_secs_f64(data.answer_within_secs);
        let process = Process::start(&data.command, &folder, limit)
            .map_err(|reason| ControllerError::Transport { reason })?;
        Ok(Box::new(RemoteController::connect(process)?) as Box<dyn Controller>)
    })
}

fn chosen(
    bench: &SceneBench,
    test: Option<&str>,
    source: &Source,
) -> Result<AbstractTest, Problem> {
    let tests = bench.tests();
    let found = match test {
        None => tests.first(),
        Some(name) => tests.iter().find(|known| known.name == name),
    };
    found.cloned().ok_or_else(|| {
        let name = test.unwrap_or_default();
        let message = format!("{} has no abstract test `{name}`", source.name);
        let problem = Problem::new("unknown-test", message);
        match did_you_mean(name, tests.iter().map(|known| known.name.as_str())) {
            Some(similar) => problem.remedy(format!("did you mean `{similar}`?")),
            None => problem.remedy("name one of its [[abstract_test]] tables"),
        }
    })
}

fn scene_problem(source: &Source, error: &SimError) -> Problem {
    let code = match error {
        SimError::Controller(_) => "controller-failed",
        SimError::Scenario(error) => return problem_of(source, error),
        _ => "bad-scene",
    };
    Problem::new(code, format!("{}: {error}", source.name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_given_without_detours() {
        assert_eq!(
            plain(Path::new("simulation/../controller/a.py")),
            "controller/a.py"
        );
        assert_eq!(plain(Path::new("./simulation/a.urdf")), "simulation/a.urdf");
        assert_eq!(plain(Path::new("../../a")), "../../a");
    }
}
