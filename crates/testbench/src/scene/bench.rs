//! A scene as a [`Bench`].

use std::collections::BTreeSet;
use std::sync::Arc;

use stimulus::{AbstractTest, Distribution, Settings, Stimulus};
use toml::{Table, Value};
use trace::Trace;

use super::build::{Built, Models, build, check_engine};
use super::capture::{Files, read_all};
use super::cautions::{Caution, cautions};
use super::data::{ActuatorKind, ControllerData, Robot, SceneData, Trajectory, resolve};
use super::draws::Draws;
use super::gaps::SceneGap;
use super::grouping::Grouping;
use super::recorder::Recorder;
use super::run::{Run, known, unsuitable};
use super::truth::{Declared, TruthVocabulary, UnknownTruth};
use crate::bench::ScenarioError;
use crate::bench::{Bench, Cancel, Drawn, End, Failure, Recorded, SimError, Watch};
use crate::controller::{Controller, ControllerError, Description};
use crate::mujoco::Engine;
use crate::physics::{Layout, MujocoPhysics, Physics, RapierPhysics};

/// How many steps pass between looks at the cancel flag.
const CANCEL_CHECK_STEPS: u64 = 256;

/// Starts a controller of the scene; called once for each episode, from any thread.
pub type StartController =
    Arc<dyn Fn(&ControllerData) -> Result<Box<dyn Controller>, ControllerError> + Send + Sync>;

/// Builds a layout in a physics engine; called once for each episode, from any thread.
pub type BuildPhysics = Arc<dyn Fn(&Layout) -> Result<Box<dyn Physics>, SimError> + Send + Sync>;

/// MuJoCo as an engine for scenes.
#[must_use]
pub fn mujoco(engine: &Engine) -> BuildPhysics {
    let engine = engine.clone();
    Arc::new(move |layout| Ok(Box::new(MujocoPhysics::new(&engine, layout)?)))
}

/// Rapier, which is built in, as an engine for scenes.
#[must_use]
pub fn rapier() -> BuildPhysics {
    Arc::new(|layout| Ok(Box::new(RapierPhysics::new(layout)?)))
}

/// A scene that is ready for episodes.
pub(super) struct Prepared {
    pub(super) data: SceneData,
    /// Whether plain numbers are to be drawn for each episode.
    undrawn: bool,
    pub(super) models: Arc<Models>,
    /// Recordings of people, by file.
    captures: Arc<Files>,
    pub(super) physics: BuildPhysics,
    pub(super) controllers: StartController,
    /// Names of truth that is recorded because somebody reads it.
    pub(super) truth: Arc<BTreeSet<String>>,
}

/// A scene: one stimulus and one seed give one recording.
pub struct SceneBench {
    table: Table,
    prepared: Arc<Prepared>,
    descriptions: Vec<Description>,
    declared: Declared,
    built: Built,
    checked: Vec<Checked>,
    cautions: Vec<Caution>,
}

/// What was checked of a scene before anything runs, and what could not be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Checked {
    /// The key in the scene's file.
    pub key: String,
    /// In a sentence that begins with what the key names.
    pub what: String,
}

impl SceneBench {
    /// The bench of a scene in TOML. `file` gives the bytes of each file that the scene names and
    /// that those name (meshes), by its path relative to the scene's file.
    ///
    /// Controllers are started once, to learn what they send and report. What of the descriptions is
    /// not simulated comes with the bench.
    ///
    /// # Errors
    /// [`SimError::Scenario`] for data that cannot be used, [`SimError::Controller`] for a
    /// controller that cannot be started, [`SimError::Engine`] when the physics engine refuses the
    /// scene.
    pub fn new(
        scene: &str,
        file: &dyn Fn(&str) -> Result<Vec<u8>, String>,
        physics: BuildPhysics,
        controllers: StartController,
    ) -> Result<(Self, Vec<SceneGap>), SimError> {
        let table: Table = toml::from_str(scene).map_err(|error| ScenarioError::Syntax {
            reason: error.to_string(),
        })?;
        let mut data = SceneData::from_table(table.clone())?;
        let (models, gaps) = super::load::load(&data, file)?;
        let captures = read_all(&data, file)?;
        data.complete(&models, &captures)?;
        let mut descriptions = Vec::new();
        for controller in &data.controllers {
            let mut started = controllers(controller)?;
            descriptions.push(started.describe().clone());
            started.end()?;
        }
        let built = build(&data, &models, Draws { seed: 0 })?;
        let mut engine = physics(&built.layout)?;
        check_engine(&data, &built.layout, engine.as_ref())?;
        let cautions = cautions(&data, &built, engine.as_mut());
        check_tool_points(&data, &built)?;
        let checked = check_waypoints(&data, &models, &built)?;
        let truth: BTreeSet<String> = data.truth.record.iter().cloned().collect();
        let none = Declared::new(&data, &built, &Trace::new(), &BTreeSet::new());
        let none = none.map_err(|unknown| of_scene(&unknown))?;
        let known = known(&data, &descriptions);
        for test in &data.abstract_tests {
            known.check(test).map_err(|problem| {
                let key = format!("abstract_test.{}", test.name);
                ScenarioError::value(&key, &format!("cannot be enacted: {problem}"))
            })?;
        }
        let bench = Self {
            prepared: Arc::new(Prepared {
                data,
                undrawn: is_undrawn(&table),
                models: Arc::new(models),
                captures: Arc::new(captures),
                physics,
                controllers,
                truth: Arc::new(BTreeSet::new()),
            }),
            table,
            descriptions,
            declared: none,
            built,
            checked,
            cautions,
        };
        match bench.declare(truth)? {
            Ok(bench) => Ok((bench, gaps)),
            Err(unknown) => Err(of_scene(&unknown).into()),
        }
    }

    /// The same scene, which records these signals of truth (`/truth/THING.QUANTITY`), too: those that somebody reads.
    ///
    /// # Errors
    /// [`SimError`] where the engine cannot tell one of them; inside, the first name that the scene does not have.
    pub fn record_truth(
        self,
        names: impl IntoIterator<Item = String>,
    ) -> Result<Result<Self, UnknownTruth>, SimError> {
        let known = self.prepared.truth.iter().cloned();
        let all = known.chain(names).collect();
        self.declare(all)
    }

    fn declare(mut self, truth: BTreeSet<String>) -> Result<Result<Self, UnknownTruth>, SimError> {
        if truth == *self.prepared.truth {
            return Ok(Ok(self));
        }
        let prepared = self.prepared.as_ref();
        let always = Recorder::new(&prepared.data, &[], &[])?.trace;
        let declared = match Declared::new(&prepared.data, &self.built, &always, &truth) {
            Ok(declared) => declared,
            Err(unknown) => return Ok(Err(unknown)),
        };
        let mut layout = self.built.layout.clone();
        declared.ask_wrenches(&mut layout);
        if layout.wrenches != self.built.layout.wrenches {
            let engine = (prepared.physics)(&layout)?;
            declared.check_engine(&layout, engine.as_ref())?;
        }
        self.prepared = Arc::new(Prepared {
            data: prepared.data.clone(),
            undrawn: prepared.undrawn,
            models: Arc::clone(&prepared.models),
            captures: Arc::clone(&prepared.captures),
            physics: Arc::clone(&prepared.physics),
            controllers: Arc::clone(&prepared.controllers),
            truth: Arc::new(truth),
        });
        self.declared = declared;
        Ok(Ok(self))
    }

    /// Whether a name is of truth and begins with a thing of this scene.
    #[must_use]
    pub fn tells_of(&self, name: &str) -> bool {
        self.declared.tells_of(name)
    }

    /// All truth that this scene can tell.
    #[must_use]
    pub fn truth(&self) -> TruthVocabulary {
        self.declared.vocabulary(&self.prepared.data, &self.built)
    }

    /// What was checked of trajectories before anything runs, and what could not be.
    #[must_use]
    pub fn checked(&self) -> &[Checked] {
        &self.checked
    }

    /// What the scene asks for that the engine does, but hardly as it is meant.
    #[must_use]
    pub fn cautions(&self) -> &[Caution] {
        &self.cautions
    }

    /// The scene's data, on which a stimulus's settings act.
    #[must_use]
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// The scene.
    #[must_use]
    pub fn data(&self) -> &SceneData {
        &self.prepared.data
    }

    /// The tests that the scene brings along.
    #[must_use]
    pub fn tests(&self) -> &[AbstractTest] {
        &self.prepared.data.abstract_tests
    }

    /// The scene's layout in the episode with `seed` and no settings, for a look at the model.
    ///
    /// # Errors
    /// As [`SceneBench::new`].
    pub fn layout_of(&self, seed: u64) -> Result<Layout, SimError> {
        let prepared = self.with_settings(&Settings::default(), seed)?;
        Ok(build(&prepared.data, &prepared.models, Draws { seed })?.layout)
    }

    /// The scene with a stimulus's settings in it, and what the seed draws of its plain numbers.
    pub(super) fn with_settings(
        &self,
        settings: &Settings,
        seed: u64,
    ) -> Result<Arc<Prepared>, SimError> {
        if settings.is_empty() && !self.prepared.undrawn {
            return Ok(Arc::clone(&self.prepared));
        }
        let mut drawn = self.table_with(settings)?;
        let draws = Draws { seed };
        resolve(&mut drawn, &mut |key, d| draws.number(key, d));
        let mut data = SceneData::read(drawn).map_err(|error| unsuitable(&error))?;
        let Prepared {
            models,
            captures,
            physics,
            controllers,
            truth,
            ..
        } = self.prepared.as_ref();
        data.complete(models, captures)
            .map_err(|error| unsuitable(&error))?;
        Ok(Arc::new(Prepared {
            data,
            undrawn: false,
            models: Arc::clone(models),
            captures: Arc::clone(captures),
            physics: Arc::clone(physics),
            controllers: Arc::clone(controllers),
            truth: Arc::clone(truth),
        }))
    }

    /// The numbers that the run of a stimulus and a seed draws from the scene's distributions. With
    /// all of them as settings the run is the same. Delays of the test are none of them, nor is what a
    /// sensor draws for each reading.
    ///
    /// # Errors
    /// [`SimError::Stimulus`].
    pub fn drawn(&self, stimulus: &Stimulus, seed: u64) -> Result<Vec<Drawn>, SimError> {
        let table = self.table_with(&stimulus.settings)?;
        let mut found = Vec::new();
        for (name, value) in table.iter().filter(|(name, _)| *name != "abstract_test") {
            distributions(name, value, &mut |key, distribution| {
                if name == "sensor" && key.ends_with(".latency_secs") {
                    return;
                }
                found.push(Drawn {
                    value: Draws { seed }.number(&key, distribution),
                    middle: distribution.quantile(0.5),
                    key,
                });
            });
        }
        Ok(found)
    }

    /// The scene's table with a stimulus's settings in it. A key may be absent if the scene knows
    /// it and its default.
    fn table_with(&self, settings: &Settings) -> Result<Table, SimError> {
        let mut table = self.table.clone();
        let Err(error) = stimulus::apply(&mut table, settings) else {
            return Ok(table);
        };
        let refused = |error: &stimulus::StimulusError| SimError::Stimulus {
            reason: error.to_string(),
        };
        let mut table = self.table.clone();
        stimulus::apply_declared(&mut table, settings, &|_| true)
            .map_err(|error| refused(&error))?;
        match SceneData::from_table(table.clone()) {
            Ok(_) => Ok(table),
            // An unknown key: the first error names similar ones.
            Err(ScenarioError::Syntax { .. }) => Err(refused(&error)),
            Err(other) => Err(unsuitable(&other)),
        }
    }
}

/// What a scene's own list of signals names wrongly.
fn of_scene(unknown: &UnknownTruth) -> ScenarioError {
    ScenarioError::value("truth.record", &format!("has an unknown name: {unknown}"))
}

/// Points of tools are on links that there are, and none has a link's name.
fn check_tool_points(data: &SceneData, built: &Built) -> Result<(), ScenarioError> {
    for point in &data.tool_points {
        let robot = data.robots.iter().position(|it| it.name == point.robot);
        let Some(robot) = robot.and_then(|robot| built.robots.get(robot)) else {
            continue;
        };
        let key = |field: &str| super::data::key_of("tool_point", &point.name, field);
        if let Some(link) = point
            .link
            .as_ref()
            .filter(|link| robot.body(Some(link)).is_none())
        {
            return Err(ScenarioError::UnknownName {
                key: key("link"),
                name: link.clone(),
            });
        }
        if robot.added.links.contains_key(&point.name) {
            let problem = "is the name of a link of the robot; choose another";
            return Err(ScenarioError::value(&key("name"), problem));
        }
    }
    Ok(())
}

/// Waypoints can be reached from where their robot begins, as far as that is not drawn.
fn check_waypoints(
    data: &SceneData,
    models: &Models,
    built: &Built,
) -> Result<Vec<Checked>, ScenarioError> {
    let mut wrong = Vec::new();
    let mut checked = Vec::new();
    for actuator in &data.actuators {
        let ActuatorKind::JointGroup(group) = &actuator.kind else {
            continue;
        };
        let place = data.robots.iter().position(|it| it.name == actuator.robot);
        let Some(place) = place else { continue };
        let robot = &data.robots[place];
        let stands = robot.place();
        let mut numbers = stands.fields().into_iter().map(|(_, number)| number);
        let is_drawn = |number: &Distribution| !matches!(number, Distribution::Constant(_));
        let varies = numbers.any(is_drawn) || robot.joints.values().any(is_drawn);
        let own = data.trajectories.iter();
        let own: Vec<_> = own
            .filter(|it| it.group == actuator.name)
            .cloned()
            .collect();
        checked.extend(own.iter().map(|trajectory| Checked {
            key: format!("trajectory.{}", trajectory.name),
            what: beforehand(trajectory, robot, varies),
        }));
        if varies {
            continue;
        }
        let Some(model) = models.get(&robot.description()) else {
            continue;
        };
        let at_work = Grouping::new(group, &built.robots[place], &built.layout, model, own);
        for (key, [distance_m, angle_rad]) in at_work.unreachable(&built.layout) {
            let problem = format!(
                "cannot be reached from the waypoint before: {:.1} mm and {:.2} degrees are left at the best pose found",
                1e3 * distance_m,
                angle_rad.to_degrees()
            );
            wrong.push(ScenarioError::value(&key, &problem));
        }
    }
    ScenarioError::all(wrong).map(|()| checked)
}

/// What of a trajectory was tried before anything runs.
fn beforehand(trajectory: &Trajectory, robot: &Robot, varies: bool) -> String {
    let Trajectory { name, group, .. } = trajectory;
    let tried = match varies {
        true => format!(
            "the waypoints of `{name}` were not tried, since where `{}` begins is drawn",
            robot.name
        ),
        false => format!(
            "the waypoints of `{name}` are in reach from where the scene lets `{group}` begin; from elsewhere they were not tried"
        ),
    };
    format!(
        "{tried}; all are tried again from where `{group}` is when `{name}` is begun, and `{name}.failed` is sent and /group/{group}.failed true if one is out of reach"
    )
}

/// Whether there are plain numbers in it that each episode draws.
fn is_undrawn(table: &Table) -> bool {
    let mut drawn = table.clone();
    resolve(&mut drawn, &mut |_, distribution| distribution.support()[0])
}

/// Each distribution below a value, with its key: entries of lists go by name, or by place.
fn distributions(key: &str, value: &Value, found: &mut dyn FnMut(String, &Distribution)) {
    match value {
        Value::Table(table) => {
            let read = value.clone().try_into::<Distribution>();
            if let Some(drawn) = read.ok().filter(|it| it.check().is_ok()) {
                return found(key.to_owned(), &drawn);
            }
            for (name, value) in table {
                distributions(&format!("{key}.{name}"), value, found);
            }
        }
        Value::Array(entries) => {
            for (place, entry) in entries.iter().enumerate() {
                let name = entry.get("name").and_then(Value::as_str);
                let name = name.map_or_else(|| place.to_string(), str::to_owned);
                distributions(&format!("{key}.{name}"), entry, found);
            }
        }
        _ => {}
    }
}

impl Bench for SceneBench {
    fn layout(&self) -> Result<Trace, SimError> {
        let blocks = self.declared.blocks();
        Ok(Recorder::new(&self.prepared.data, &self.descriptions, &blocks)?.trace)
    }

    fn run(
        &self,
        stimulus: &Stimulus,
        seed: u64,
        watch: &mut dyn Watch,
        cancel: &Cancel,
    ) -> Result<Recorded, SimError> {
        let prepared = self.with_settings(&stimulus.settings, seed)?;
        let recorded = match Run::new(Arc::clone(&prepared), stimulus, seed) {
            Ok(run) => drive(run, watch, cancel)?,
            Err(SimError::Controller(error)) => never_begun(
                (&prepared, &self.descriptions, &self.declared),
                stimulus,
                seed,
                error,
            )?,
            Err(other) => return Err(other),
        };
        // A controller that was ended with us did not fail.
        match recorded.failure.is_some() && cancel.is_cancelled() {
            true => Err(SimError::Cancelled),
            false => Ok(recorded),
        }
    }
}

/// Runs an episode to its end, be that a controller's failure.
fn drive(mut run: Run, watch: &mut dyn Watch, cancel: &Cancel) -> Result<Recorded, SimError> {
    let mut steps: u64 = 0;
    loop {
        if let Some(end) = run.end() {
            return run.finish(end, watch);
        }
        if steps.is_multiple_of(CANCEL_CHECK_STEPS) && cancel.is_cancelled() {
            return Err(SimError::Cancelled);
        }
        match run.step(watch) {
            Err(SimError::Controller(error)) => return run.fail(error, watch),
            other => other?,
        }
        steps += 1;
    }
}

/// What there is of an episode whose controller could not be started or set up: no row.
fn never_begun(
    (prepared, descriptions, declared): (&Prepared, &[Description], &Declared),
    stimulus: &Stimulus,
    seed: u64,
    error: ControllerError,
) -> Result<Recorded, SimError> {
    let failure = Failure::of_controller(&error, true);
    let mut recorder = Recorder::new(&prepared.data, descriptions, &declared.blocks())?;
    recorder.note("scene", &prepared.data.name);
    recorder.note("abstract_test", &stimulus.test.name);
    recorder.note("seed", seed);
    recorder.note("failed", failure.kind());
    recorder.trace.complete = false;
    Ok(Recorded {
        trace: recorder.trace,
        steps: 0,
        sim_secs: 0.0,
        end: End::Failed,
        failure: Some(failure),
    })
}
