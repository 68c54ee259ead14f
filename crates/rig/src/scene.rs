//! A scene as a rig: its files, its test, its controllers.

mod rest;
mod truth;

use super::command::OutsideCommand;
use super::consent::Consent;
use super::place::{problem_of, span_of};
use super::process::{self, Process};
use super::rest::Rest;
use super::rig::{Rig, episode_name, failed, secs_of};
use super::ros2::{self, Domains, Join, Ros2Controller};
use super::saving::Resumable;
use diagnostic::{Problem, Source, did_you_mean};
use evidence::{Asset, AssetRole, DescriptionGap, Tool};
use host::files::read_file;
use host::reach::{OUTSIDE, REMEDY};
use host::store::{Inputs, hash_of};
use host::{BuildId, Cancel, Host};
use rest::SceneRest;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use stimulus::{AbstractTest, Stimulus};
use study::Study;
use testbench::controller::{Controller, ControllerError, RemoteController};
use testbench::physics::RAPIER_VERSION;
use testbench::scene::{
    BuildPhysics, Caution, ControllerData, Gripper, GripperKind, SceneBench, SceneGap,
    StartController, TruthVocabulary, mujoco, rapier,
};
use testbench::{Bench, Drawn, Engine, Recorded, SimError, Watch};
use toml::Table;
use trace::Trace;

/// What gives scenes their physics.
pub struct ScenePhysics {
    name: &'static str,
    version: String,
    build: BuildPhysics,
}

impl ScenePhysics {
    /// MuJoCo.
    pub fn mujoco(engine: &Engine) -> Self {
        Self {
            name: "MuJoCo",
            version: engine.version(),
            build: mujoco(engine),
        }
    }

    /// Rapier, which is built in.
    pub fn rapier() -> Self {
        Self {
            name: "Rapier",
            version: RAPIER_VERSION.to_owned(),
            build: rapier(),
        }
    }
}

/// A scene and the test that is enacted in it.
pub struct SceneRig {
    bench: Arc<SceneBench>,
    stimulus: Stimulus,
    text: String,
    /// The engine's name and version.
    engine: (&'static str, String),
    /// The files that the scene consists of.
    assets: Vec<Asset>,
    gaps: Vec<DescriptionGap>,
    checked: Vec<String>,
    /// Signals of truth that the study reads and a scene does not record of itself.
    truth: Vec<String>,
}

/// The files of a scene, as they are read, with their hashes.
struct SceneFiles<'s> {
    study: &'s Study,
    /// The scene's.
    folder: &'s Path,
    read: Mutex<BTreeMap<String, String>>,
    /// The first address that leads out of reach: a reader may try others, and say only that none is there.
    refused: Mutex<Option<String>>,
}

/// What stands behind an address that leads out of reach.
const REFUSED: &str = " is not opened: ";

impl<'s> SceneFiles<'s> {
    fn of(study: &'s Study, folder: &'s Path) -> Self {
        Self {
            study,
            folder,
            read: Mutex::default(),
            refused: Mutex::default(),
        }
    }

    /// The bytes at an address, which is relative to the scene, or why there are none.
    fn bytes(&self, address: &str) -> Result<Vec<u8>, String> {
        let path = address.strip_prefix("file://").unwrap_or(address);
        let path = self.folder.join(path);
        let why = self.study.reach.refuses(&path);
        if let Some(why) = why.filter(|_| path.exists()) {
            let mut refused = self.refused.lock().unwrap_or_else(PoisonError::into_inner);
            let why = format!("{address}{REFUSED}{why}");
            return Err(refused.get_or_insert(why).clone());
        }
        let bytes = read_file(&path, u64::MAX - 1);
        let bytes = bytes.map_err(|problem| problem.message().to_owned())?;
        self.keep(address, &bytes);
        Ok(bytes)
    }

    /// Hashes a file of a controller, wherever it lies: it was allowed with the controller.
    fn hash(&self, name: &str) -> Result<(), Problem> {
        let bytes = read_file(&self.folder.join(name), u64::MAX - 1)?;
        self.keep(name, &bytes);
        Ok(())
    }

    fn keep(&self, address: &str, bytes: &[u8]) {
        let mut read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        read.insert(address.to_owned(), hash_of(bytes));
    }

    fn refused(&self) -> Option<String> {
        let refused = self.refused.lock().unwrap_or_else(PoisonError::into_inner);
        refused.clone()
    }

    /// What was read, by address.
    fn read(&self) -> BTreeMap<String, String> {
        let read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        read.clone()
    }
}

impl SceneRig {
    /// Reads what a scene names, whose own text is `source` and whose path in the study is `scene`. `test` is one of the
    /// scene's own tests, the first if it is not named.
    ///
    /// # Errors
    /// `bad-scene`, `controller-failed`, `unknown-test`, `not-trusted`, each with its place where there is one.
    pub fn new(
        study: &Study,
        scene: &Path,
        source: &Source,
        (test, physics): (Option<&str>, ScenePhysics),
        host: &Host,
    ) -> Result<Self, Problem> {
        let path = study.folder.join(scene);
        let folder = path.parent().unwrap_or(Path::new(".")).to_owned();
        let files = SceneFiles::of(study, &folder);
        let read = |address: &str| files.bytes(address);
        check_ros2(source)?;
        let consent = Consent::to_scene(study, scene, source, host)?;
        let made = SceneBench::new(
            &source.text,
            &read,
            physics.build,
            starter(&folder, host.python_path.as_deref(), consent),
        );
        let (bench, gaps) = made.map_err(|error| match files.refused() {
            Some(why) => out_of_reach(source, &why),
            None => scene_problem(source, &error),
        })?;
        // What is missing may be a gap of the description only; what was refused is not.
        if let Some(why) = files.refused() {
            return Err(out_of_reach(source, &why));
        }
        let (bench, truth) = truth::declared(bench, study, source)?;
        let stimulus = Stimulus::of(chosen(&bench, test, source)?);
        for controller in &bench.data().controllers {
            // What of the command is a file is part of what is tested.
            for name in controller.command.iter().chain(&controller.files) {
                if folder.join(name).is_file() {
                    files.hash(name)?;
                }
            }
        }
        let files = files.read();
        let checked = bench.checked().iter();
        let checked = checked.map(|it| match line_of(source, &it.key) {
            Some((line, column)) => format!("{}:{line}:{column}: {}", plain(scene), it.what),
            None => format!("{}: {}", plain(scene), it.what),
        });
        let checked = checked.collect();
        let mut declared = attaching(scene, source, &bench.data().grippers);
        declared.extend(minded(scene, source, bench.cautions()));
        let beside = scene.parent().unwrap_or(Path::new(""));
        let assets = files.into_iter().map(|(path, hash)| Asset {
            role: AssetRole::SystemModel,
            path: plain(&beside.join(path)),
            hash,
        });
        Ok(Self {
            bench: Arc::new(bench),
            stimulus,
            text: source.text.clone(),
            engine: (physics.name, physics.version),
            assets: assets.collect(),
            gaps: gaps
                .into_iter()
                .map(|gap| in_study(beside, gap))
                .chain(declared)
                .collect(),
            checked,
            truth,
        })
    }

    /// What an episode depends on of the scene's own.
    fn scene_inputs(&self, inputs: &mut Inputs) {
        inputs
            .add("scene", self.text.as_bytes())
            .add("test", self.stimulus.to_json().as_bytes())
            .add_json("files", &self.assets);
        if !self.truth.is_empty() {
            inputs.add_json("truth", &self.truth);
        }
    }
}

impl Rig for SceneRig {
    fn engine(&self) -> String {
        format!("{} {}", self.engine.0, self.engine.1)
    }

    fn tool(&self) -> Tool {
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
        Tool {
            name: self.engine.0.to_owned(),
            version: self.engine.1.clone(),
            settings,
        }
    }

    fn is_outside(&self) -> bool {
        false
    }

    fn assets(&self) -> &[Asset] {
        &self.assets
    }

    fn gaps(&self) -> &[DescriptionGap] {
        &self.gaps
    }

    fn checked(&self) -> &[String] {
        &self.checked
    }

    fn truth(&self) -> Option<TruthVocabulary> {
        Some(self.bench.truth())
    }

    fn stimulus(&self) -> &Stimulus {
        &self.stimulus
    }

    fn tests(&self) -> &[AbstractTest] {
        self.bench.tests()
    }

    fn data(&self) -> &Table {
        self.bench.table()
    }

    fn time_step_key(&self) -> Option<&'static str> {
        Some("simulation.time_step_secs")
    }

    fn ends_by_secs(&self) -> Option<f64> {
        secs_of(self.data().get("simulation")?.get("duration_secs")?)
    }

    fn own_inputs(&self, inputs: &mut Inputs) {
        let (name, version) = &self.engine;
        inputs.add("engine", version.as_bytes());
        if *name != "MuJoCo" {
            inputs.add("engine_name", name.as_bytes());
        }
        self.scene_inputs(inputs);
    }

    fn inputs(&self, inputs: &mut Inputs) {
        inputs
            .add("engine", self.engine().as_bytes())
            .add("bench", self.data().to_string().as_bytes());
        self.scene_inputs(inputs);
    }

    fn test_inputs(&self, build: &BuildId, inputs: &mut Inputs) {
        self.scene_inputs(inputs);
        inputs
            .add("engine", self.engine().as_bytes())
            .add("program", build.as_str().as_bytes());
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
        match self.bench.drawn(stimulus, 0) {
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
        None
    }

    fn resumable(&self) -> Option<&dyn Resumable> {
        Some(self.bench.as_ref())
    }

    fn rest(&self, is_outside: &dyn Fn(&[String]) -> bool) -> Option<Arc<dyn Rest>> {
        let (bench, stimulus) = (Arc::clone(&self.bench), self.stimulus.clone());
        Some(Arc::new(SceneRest::new(bench, stimulus, is_outside)))
    }

    fn leaves(&self) -> Option<&OutsideCommand> {
        None
    }
}

/// Refuses what a scene says wrongly of nodes of ROS 2, before one is started.
fn check_ros2(source: &Source) -> Result<(), Problem> {
    ros2::check_text(&source.text).map_err(|(key, reason)| {
        let problem = Problem::new("bad-scene", format!("{key}: {reason}"));
        match span_of(&source.text, &key) {
            Some(span) => problem.at(source, span),
            None => problem,
        }
    })
}

/// What a scene's grippers attach instead of holding it by friction or air: simplifications that the scene declares.
fn attaching(scene: &Path, source: &Source, grippers: &[Gripper]) -> Vec<DescriptionGap> {
    let declared = grippers.iter().filter_map(|gripper| {
        let what = match &gripper.kind {
            GripperKind::Suction { .. } => "what a suction cup holds is attached to it",
            GripperKind::ToolChanger { .. } => "a tool is attached to its flange",
            _ if gripper.attaches_when_grasped() => "what is grasped is attached to the hand",
            _ => return None,
        };
        let place = line_of(source, &format!("gripper.{}", gripper.name));
        Some(DescriptionGap {
            file: plain(scene),
            line: place.map(|(line, _)| line),
            column: place.map(|(_, column)| column),
            element: format!("gripper {}", gripper.name),
            what: format!("{what}, a simplification that the scene declares"),
            effect: "contact".to_owned(),
            consequence: "whether and how firmly it is held is assumed, not shown".to_owned(),
        })
    });
    declared.collect()
}

/// What a scene asks for that the engine does, but hardly as it is meant.
fn minded(scene: &Path, source: &Source, cautions: &[Caution]) -> Vec<DescriptionGap> {
    let gap = |caution: &Caution| {
        // A joint's number may stand in a list, or be left out.
        let above = caution.key.rsplit_once('.').map(|(above, _)| above);
        let place = line_of(source, &caution.key);
        let place = place.or_else(|| above.and_then(|above| line_of(source, above)));
        DescriptionGap {
            file: plain(scene),
            line: place.map(|(line, _)| line),
            column: place.map(|(_, column)| column),
            element: caution.element.clone(),
            what: caution.what.clone(),
            effect: caution.effect.to_owned(),
            consequence: caution.consequence.clone(),
        }
    };
    cautions.iter().map(gap).collect()
}

/// Line and column of a key.
fn line_of(source: &Source, key: &str) -> Option<(u32, u32)> {
    let span = span_of(&source.text, key)?;
    let (line, column) = diagnostic::line_and_column(&source.text, span.start);
    Some((u32::try_from(line).ok()?, u32::try_from(column).ok()?))
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
    let path = parts.join("/");
    match path.strip_prefix("//") {
        Some(rest) => format!("/{rest}"),
        None => path,
    }
}

/// Starts the scene's controllers in the scene's folder: as processes, or as
/// nodes of ROS 2. Those alone whose words were allowed: settings of a test reach all of a scene's data.
fn starter(
    folder: &Path,
    python_path: Option<&OsStr>,
    consent: Option<(Consent, Vec<Vec<String>>)>,
) -> StartController {
    let (folder, python_path) = (folder.to_owned(), python_path.map(OsStr::to_owned));
    let domains = Domains::default();
    Arc::new(move |data: &ControllerData| {
        let join = Join::of(data).map_err(|message| ControllerError::Failed { message })?;
        let consent = consent_for(&data.command, consent.as_ref())
            .map_err(|reason| ControllerError::Transport { reason })?;
        if let Some(join) = join {
            let place = (folder.as_path(), python_path.as_deref());
            let node = Ros2Controller::new(join, data, place, &domains, consent);
            return Ok(Box::new(node) as Box<dyn Controller>);
        }
        let limit = Duration::from_secs_f64(data.answer_within_secs);
        let consent = consent.ok_or_else(|| ControllerError::Transport {
            reason: process::NO_COMMAND.into(),
        })?;
        let python_path = python_path.as_deref();
        let process = Process::start(&data.command, &folder, python_path, limit, consent)
            .map_err(|reason| ControllerError::Transport { reason })?;
        Ok(Box::new(RemoteController::connect(process)?) as Box<dyn Controller>)
    })
}

/// That these words may be started, if there are any.
fn consent_for<'c>(
    words: &[String],
    given: Option<&'c (Consent, Vec<Vec<String>>)>,
) -> Result<Option<&'c Consent>, String> {
    match given {
        _ if words.is_empty() => Ok(None),
        Some((consent, known)) if known.iter().any(|it| it == words) => Ok(Some(consent)),
        _ => Err(format!(
            "`{}` is not a program that the scene's file names",
            words.join(" ")
        )),
    }
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
        let place = span_of(&source.text, "abstract_test").unwrap_or(0..0);
        let problem = Problem::new("unknown-test", message).at(source, place);
        match did_you_mean(name, tests.iter().map(|known| known.name.as_str())) {
            Some(similar) => problem.remedy(format!("did you mean `{similar}`?")),
            None => problem.remedy("name one of its [[abstract_test]] tables"),
        }
    })
}

/// A scene that names what it may not read, itself or by what it includes: then its first line is shown.
fn out_of_reach(source: &Source, why: &str) -> Problem {
    let address = why.split(REFUSED).next().unwrap_or_default();
    Problem::new(OUTSIDE, format!("{}: {why}", source.name))
        .at(source, study::placed::quoted(source, address))
        .remedy(REMEDY)
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
    use testbench::scene::SceneData;

    #[test]
    fn what_a_gripper_attaches_is_a_declared_simplification_with_its_place() {
        let text = r#"
name = "cell"
simulation = { duration_secs = 1.0 }
abstract_test = [{ name = "wait", actions = [] }]
[[robot]]
name = "arm"
file = "arm.urdf"
[[tool_point]]
name = "rim"
robot = "arm"
[[gripper]]
name = "hand"
robot = "arm"
kind = "parallel"
joints = ["finger"]
open = [0.04]
closed = [0.0]
width_m = 0.08
force_limit_newtons = 20.0
attach = "when-grasped"
[[gripper]]
name = "plain"
robot = "arm"
kind = "under_actuated"
joints = ["thumb"]
pulley_radii_m = [0.01]
return_stiffness = [0.1]
tension_limit_newtons = 20.0
[[gripper]]
name = "cup"
robot = "arm"
kind = "suction"
tool_point = "rim"
reach_m = 0.01
holding_force_newtons = 20.0
"#;
        let source = Source::new("cells/scene.toml", text);
        let data = SceneData::from_table(text.parse().expect("TOML")).expect("a sound scene");
        let gaps = attaching(Path::new("cells/scene.toml"), &source, &data.grippers);
        let told: Vec<(&str, Option<u32>)> = gaps
            .iter()
            .map(|it| (it.element.as_str(), it.line))
            .collect();
        assert_eq!(
            told,
            [("gripper hand", Some(11)), ("gripper cup", Some(29))]
        );
        assert!(gaps.iter().all(evidence::DescriptionGap::can_matter));
        assert!(
            gaps[0]
                .what
                .contains("what is grasped is attached to the hand, a simplification")
        );
    }

    #[test]
    fn what_is_to_be_minded_has_the_place_of_its_key_or_of_what_it_belongs_to() {
        let text = "name = \"cell\"\n[[robot]]\nname = \"arm\"\nfile = \"arm.urdf\"\n[[group]]\nname = \"joints\"\nrobot = \"arm\"\nstiffness = 4000.0\n";
        let source = Source::new("cells/scene.toml", text);
        let caution = |key: &str| Caution {
            key: key.to_owned(),
            element: "joint elbow".to_owned(),
            what: "it is told".to_owned(),
            effect: "control",
            consequence: "mind it".to_owned(),
        };
        let told = [
            caution("group.joints.stiffness"),
            caution("group.joints.damping"),
            caution("robot.arm"),
        ];
        let gaps = minded(Path::new("cells/scene.toml"), &source, &told);
        let lines: Vec<Option<u32>> = gaps.iter().map(|it| it.line).collect();
        assert_eq!(lines, [Some(8), Some(5), Some(2)]);
        assert!(gaps.iter().all(evidence::DescriptionGap::can_matter));
        assert!(
            gaps[0].to_string().contains("cells/scene.toml:8"),
            "{}",
            gaps[0]
        );
    }

    #[test]
    fn paths_are_given_without_detours() {
        assert_eq!(
            plain(Path::new("simulation/../controller/a.py")),
            "controller/a.py"
        );
        assert_eq!(plain(Path::new("./simulation/a.urdf")), "simulation/a.urdf");
        assert_eq!(plain(Path::new("../../a")), "../../a");
        assert_eq!(plain(Path::new("/opt/arm/../a.urdf")), "/opt/a.urdf");
    }
}
