//! A scene as its TOML file gives it.
//!
//! Units stand in the names of the keys. A [`Distribution`] may stand wherever a number is drawn for
//! an episode; each such number has a random stream of its own, named by its key, so that setting
//! one changes no other.

mod actuator;
mod arms;
mod body;
mod capture;
mod compliance;
mod drawn;
mod gripper;
mod group;
mod person;
mod sensor;
mod solver;
mod truth;

use std::collections::{BTreeMap, BTreeSet};

use schemars::JsonSchema;
use serde::Deserialize;
use stimulus::{AbstractTest, Distribution};
use toml::Table;

pub use actuator::{ActuatorFault, ActuatorFaultKind};
pub use body::{Actuator, ActuatorKind, JointGroup, Object, PlaceKeys, Robot};
pub use capture::{Capture, CaptureAxis, CaptureNames, CaptureUnit};
pub use compliance::Compliance;
pub(super) use compliance::{REGIONS, Region as BodyRegion};
pub(super) use drawn::resolve;
pub use gripper::{Attach, Gripper, GripperKind};
pub use group::{Group, GroupMode, GroupWaypoint, PerJoint, ProfileKind, Trajectory};
pub use person::{
    Activity, ArmAngles, ArmPose, Avoidance, Hesitation, Person, PersonBody, Reaction,
    ReactionKind, Takes, Waypoint,
};
pub(super) use sensor::key_with_unit;
pub use sensor::{Fault, FaultKind, Sensor, SensorKind};
pub use solver::{ConeKind, Material, MujocoKeys, RapierKeys};
pub use truth::{Region, ToolPoint, TruthKeys};

use crate::bench::ScenarioError;

/// A scene: robots, objects, people, sensors, actuators, controllers and tests.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneData {
    /// What the scene is called in recordings.
    pub name: String,
    /// Time, gravity, ends.
    pub simulation: Simulation,
    /// The floor; there is none without it.
    pub ground: Option<Ground>,
    /// Robots.
    #[serde(default, rename = "robot")]
    pub robots: Vec<Robot>,
    /// Other things, fixed or loose.
    #[serde(default, rename = "object")]
    pub objects: Vec<Object>,
    /// People.
    #[serde(default, rename = "person")]
    pub people: Vec<Person>,
    /// Drives.
    #[serde(default, rename = "actuator")]
    pub actuators: Vec<Actuator>,
    /// Joints that are commanded together.
    #[serde(default, rename = "group")]
    pub groups: Vec<Group>,
    /// Waypoints of groups, for robots without a controller.
    #[serde(default, rename = "trajectory")]
    pub trajectories: Vec<Trajectory>,
    /// Grippers and tool changers.
    #[serde(default, rename = "gripper")]
    pub grippers: Vec<Gripper>,
    /// Sensors.
    #[serde(default, rename = "sensor")]
    pub sensors: Vec<Sensor>,
    /// Robots' code.
    #[serde(default, rename = "controller")]
    pub controllers: Vec<ControllerData>,
    /// What surfaces are made of.
    #[serde(default, rename = "material")]
    pub materials: Vec<Material>,
    /// Places in which things can be.
    #[serde(default, rename = "region")]
    pub regions: Vec<Region>,
    /// Points of links that signals can speak of.
    #[serde(default, rename = "tool_point")]
    pub tool_points: Vec<ToolPoint>,
    /// What counts as what in truth signals.
    #[serde(default)]
    pub truth: TruthKeys,
    /// The tests that can be enacted; the first is the one that a study runs.
    #[serde(default, rename = "abstract_test")]
    pub abstract_tests: Vec<AbstractTest>,
}

/// Time and gravity.
#[derive(Debug, Clone, Copy, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Simulation {
    /// Length of a time step.
    #[serde(default = "two_milliseconds")]
    pub time_step_secs: f64,
    /// Gravity, downwards.
    #[serde(default = "earth")]
    pub gravity_m_s2: f64,
    /// The planned length of an episode: what has not happened by then has not happened.
    pub duration_secs: f64,
    /// How long an episode goes on after all controllers have finished.
    #[serde(default)]
    pub end_after_secs: f64,
    /// How often the truth is recorded.
    #[serde(default = "fifty")]
    pub record_hz: f64,
    /// How often people move, at least the rate of the fastest sensor that sees them.
    #[serde(default = "hundred")]
    pub people_hz: f64,
    /// Distances of more than this are recorded as this.
    #[serde(default = "ten")]
    pub longest_distance_m: f64,
    /// How MuJoCo solves contacts.
    #[serde(default)]
    pub mujoco: MujocoKeys,
    /// How Rapier solves contacts.
    #[serde(default)]
    pub rapier: RapierKeys,
}

/// The floor, at z = 0.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ground {
    /// Its Coulomb friction.
    pub friction: Distribution,
    /// What it is made of: one of the scene's materials.
    pub material: Option<String>,
}

/// A robot's code and how it is joined.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerData {
    /// Its name in the scene.
    pub name: String,
    /// The robot whose sensors and actuators it has.
    pub robot: String,
    /// The program and its arguments, for a controller that is a process; run by the caller.
    #[serde(default)]
    pub command: Vec<String>,
    /// How it is joined over topics of ROS 2 instead; read by the caller, as this crate knows no
    /// networks.
    #[schemars(with = "Option<BTreeMap<String, schemars::Schema>>")]
    pub ros2: Option<Table>,
    /// Files that the program consists of, besides those that `command` names.
    #[serde(default)]
    pub files: Vec<String>,
    /// Simulated time from tick to tick.
    pub period_secs: f64,
    /// How long an answer of the process may take on the wall clock, before the caller ends it.
    #[serde(default = "half_a_minute")]
    pub answer_within_secs: f64,
    /// How long its commands take to take effect.
    #[serde(default = "zero")]
    pub latency_secs: Distribution,
    /// What it is told at the beginning; numbers may be distributions.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, schemars::Schema>")]
    pub settings: Table,
}

fn half_a_minute() -> f64 {
    30.0
}
fn two_milliseconds() -> f64 {
    0.002
}
fn earth() -> f64 {
    9.81
}
fn fifty() -> f64 {
    50.0
}
fn hundred() -> f64 {
    100.0
}
fn ten() -> f64 {
    10.0
}

/// Zero, for what is left out.
pub(super) fn zero() -> Distribution {
    Distribution::Constant(0.0)
}

/// A key with an index or a name in it.
pub(super) fn key_of(list: &str, name: &str, field: &str) -> String {
    format!("{list}.{name}.{field}")
}

/// Checks a distribution and its range.
pub(super) fn within(
    key: &str,
    distribution: &Distribution,
    low: f64,
    high: f64,
) -> Result<(), ScenarioError> {
    distribution.check().map_err(|error| {
        ScenarioError::value(key, &format!("must be a number or a distribution: {error}"))
    })?;
    let [smallest, largest] = distribution.support();
    if smallest < low || largest > high {
        let problem = format!(
            "must lie between {low} and {high}; a normal distribution can be cut with `low` and `high`"
        );
        return Err(ScenarioError::value(key, &problem));
    }
    Ok(())
}

/// Checks a plain number's range.
pub(super) fn number_within(
    key: &str,
    value: f64,
    low: f64,
    high: f64,
) -> Result<(), ScenarioError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let problem = format!("must lie between {low} and {high} (got {value})");
    Err(ScenarioError::value(key, &problem))
}

/// Checks that a name is known.
pub(super) fn known<'a>(
    key: &str,
    name: &str,
    mut names: impl Iterator<Item = &'a str>,
) -> Result<(), ScenarioError> {
    if names.any(|known| known == name) {
        return Ok(());
    }
    Err(ScenarioError::UnknownName {
        key: key.to_owned(),
        name: name.to_owned(),
    })
}

impl SceneData {
    /// The number of a person's group: the first person's place who is in it.
    pub(super) fn group_of(&self, person: &Person) -> Option<usize> {
        let group = person.group.as_ref()?;
        let mut people = self.people.iter();
        people.position(|it| it.group.as_ref() == Some(group))
    }

    /// The JSON Schema of a scene's file.
    #[must_use]
    pub fn schema() -> schemars::Schema {
        let mut schema = schemars::schema_for!(Self);
        drawn::allow_in(&mut schema);
        schema
    }

    /// Reads and checks a scene. Distributions that stand for plain numbers are checked at both
    /// ends; the data then has the lower one, and each episode its own.
    ///
    /// # Errors
    /// [`ScenarioError`] with the key and what to do about it.
    pub fn from_table(table: Table) -> Result<Self, ScenarioError> {
        let [mut low, mut high] = [table.clone(), table];
        resolve(&mut low, &mut |_, distribution| distribution.support()[0]);
        if resolve(&mut high, &mut |_, distribution| distribution.support()[1]) {
            Self::read(high)?;
        }
        Self::read(low)
    }

    /// Reads and checks a scene in which plain numbers are drawn already.
    pub(super) fn read(table: Table) -> Result<Self, ScenarioError> {
        let mut data: Self =
            table
                .try_into()
                .map_err(|error: toml::de::Error| ScenarioError::Syntax {
                    reason: error.to_string(),
                })?;
        data.check()?;
        data.add_arms();
        Ok(data)
    }

    /// What a person takes is an object that is loose.
    fn check_taken(&self, person: &Person) -> Result<(), ScenarioError> {
        let Some(takes) = &person.takes else {
            return Ok(());
        };
        let key = key_of("person", &person.name, "takes.object");
        known(
            &key,
            &takes.object,
            self.objects.iter().map(|it| it.name.as_str()),
        )?;
        let is_fixed = self.objects.iter().any(|it| {
            it.name == takes.object && (it.fixed || (it.file.is_none() && it.mass_kg.is_none()))
        });
        match is_fixed {
            true => Err(ScenarioError::value(
                &key,
                "is fixed to the world; give it `mass_kg`",
            )),
            false => Ok(()),
        }
    }

    /// The abstract test called `name`.
    #[must_use]
    pub fn abstract_test(&self, name: &str) -> Option<&AbstractTest> {
        self.abstract_tests.iter().find(|test| test.name == name)
    }

    /// The keys of plain numbers for which a scene's text gives distributions; none if it cannot be read.
    #[must_use]
    pub fn keys_of_drawn_numbers(text: &str) -> Vec<String> {
        let mut keys = Vec::new();
        if let Ok(mut table) = toml::from_str::<Table>(text) {
            resolve(&mut table, &mut |key, distribution| {
                keys.push(key.to_owned());
                distribution.support()[0]
            });
        }
        keys
    }

    /// What is wrong with it, as far as its parts are known: the first of each part, of all parts.
    ///
    /// # Errors
    /// The one mistake, or [`ScenarioError::Several`].
    pub fn check(&self) -> Result<(), ScenarioError> {
        let step_secs = self.simulation.known_step_secs();
        let mut found = vec![
            self.simulation.check(),
            self.check_names(),
            self.check_materials(),
            self.check_truth(),
            self.check_tests(),
        ];
        if let Some(ground) = &self.ground {
            found.push(within("ground.friction", &ground.friction, 0.0, 10.0));
        }
        found.extend(self.robots.iter().map(Robot::check));
        found.extend(self.objects.iter().map(Object::check));
        found.extend(self.people.iter().map(Person::check));
        found.extend(self.people.iter().map(|it| self.check_taken(it)));
        for actuator in &self.actuators {
            found.push(self.check_robot("actuator", &actuator.name, &actuator.robot));
            found.push(actuator.check(step_secs));
        }
        for sensor in &self.sensors {
            found.push(self.check_robot("sensor", &sensor.name, &sensor.robot));
            found.push(sensor.check(step_secs));
        }
        for controller in &self.controllers {
            found.push(self.check_robot("controller", &controller.name, &controller.robot));
            found.push(controller.check(step_secs));
        }
        if self.robots.len() + self.objects.len() + self.people.len() > 30 {
            let problem = "are more than 30 robots, objects and people together";
            found.push(Err(ScenarioError::value("robot, object, person", problem)));
        }
        let mut wrong: Vec<ScenarioError> = found.into_iter().filter_map(Result::err).collect();
        wrong.extend(self.wrong_arms());
        ScenarioError::all(wrong)
    }

    fn check_robot(&self, list: &str, name: &str, robot: &str) -> Result<(), ScenarioError> {
        let robots = self.robots.iter().map(|robot| robot.name.as_str());
        known(&key_of(list, name, "robot"), robot, robots)
    }

    /// Materials are sound, and those that things are made of exist.
    fn check_materials(&self) -> Result<(), ScenarioError> {
        let time_step_secs = self.simulation.known_step_secs();
        for material in &self.materials {
            material.check(time_step_secs)?;
        }
        let is_known = |key: &str, name: &Option<String>| match name {
            Some(name) => known(key, name, self.materials.iter().map(|it| it.name.as_str())),
            None => Ok(()),
        };
        if let Some(ground) = &self.ground {
            is_known("ground.material", &ground.material)?;
        }
        for robot in &self.robots {
            is_known(&key_of("robot", &robot.name, "material"), &robot.material)?;
            for (link, material) in &robot.materials {
                let key = key_of("robot", &robot.name, &format!("materials.{link}"));
                is_known(&key, &Some(material.clone()))?;
            }
        }
        for object in &self.objects {
            is_known(
                &key_of("object", &object.name, "material"),
                &object.material,
            )?;
        }
        for person in &self.people {
            is_known(
                &key_of("person", &person.name, "material"),
                &person.material,
            )?;
        }
        Ok(())
    }

    /// Regions and points of tools are sound, and what they are on exists.
    fn check_truth(&self) -> Result<(), ScenarioError> {
        self.truth.check()?;
        self.regions.iter().try_for_each(Region::check)?;
        self.tool_points.iter().try_for_each(ToolPoint::check)?;
        for region in &self.regions {
            let robots = self.robots.iter().map(|it| it.name.as_str());
            let objects = self.objects.iter().map(|it| it.name.as_str());
            if let Some(on) = &region.on {
                known(
                    &key_of("region", &region.name, "on"),
                    on,
                    robots.chain(objects),
                )?;
            }
        }
        for point in &self.tool_points {
            self.check_robot("tool_point", &point.name, &point.robot)?;
        }
        Ok(())
    }

    /// Names are part of topics and of keys.
    fn check_names(&self) -> Result<(), ScenarioError> {
        let lists: [(&str, Vec<&str>); 12] = [
            (
                "robot",
                self.robots.iter().map(|x| x.name.as_str()).collect(),
            ),
            (
                "object",
                self.objects.iter().map(|x| x.name.as_str()).collect(),
            ),
            (
                "person",
                self.people.iter().map(|x| x.name.as_str()).collect(),
            ),
            (
                "actuator",
                self.actuators.iter().map(|x| x.name.as_str()).collect(),
            ),
            (
                "sensor",
                self.sensors.iter().map(|x| x.name.as_str()).collect(),
            ),
            (
                "controller",
                self.controllers.iter().map(|x| x.name.as_str()).collect(),
            ),
            (
                "material",
                self.materials.iter().map(|x| x.name.as_str()).collect(),
            ),
            (
                "region",
                self.regions.iter().map(|x| x.name.as_str()).collect(),
            ),
            (
                "tool_point",
                self.tool_points.iter().map(|x| x.name.as_str()).collect(),
            ),
            (
                "group",
                self.groups.iter().map(|x| x.name.as_str()).collect(),
            ),
            (
                "trajectory",
                self.trajectories.iter().map(|x| x.name.as_str()).collect(),
            ),
            (
                "gripper",
                self.grippers.iter().map(|x| x.name.as_str()).collect(),
            ),
        ];
        let mut seen = BTreeSet::new();
        for (list, names) in lists {
            for name in names {
                let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
                if name.is_empty() || !name.chars().all(plain) {
                    let problem = "must consist of letters, digits and underscores";
                    return Err(ScenarioError::value(&key_of(list, name, "name"), problem));
                }
                if !seen.insert(name.to_owned()) {
                    let problem = "is used twice; names must be unique";
                    return Err(ScenarioError::value(&key_of(list, name, "name"), problem));
                }
            }
        }
        Ok(())
    }

    fn check_tests(&self) -> Result<(), ScenarioError> {
        if self.abstract_tests.is_empty() {
            let problem = "is missing: give at least one, `actions = []` if nothing is to be done";
            return Err(ScenarioError::value("abstract_test", problem));
        }
        let mut seen = BTreeSet::new();
        for test in &self.abstract_tests {
            test.check().map_err(|error| {
                ScenarioError::value("abstract_test", &format!("is wrong: {error}"))
            })?;
            if !seen.insert(&test.name) {
                let key = format!("abstract_test.{}", test.name);
                return Err(ScenarioError::value(&key, "is given twice"));
            }
        }
        Ok(())
    }
}

impl Simulation {
    /// The time step; not a number if it is out of its range, so that nothing is held against it.
    fn known_step_secs(&self) -> f64 {
        match self.check_step() {
            Ok(()) => self.time_step_secs,
            Err(_) => f64::NAN,
        }
    }

    fn check_step(&self) -> Result<(), ScenarioError> {
        number_within("simulation.time_step_secs", self.time_step_secs, 1e-5, 0.05)
    }

    fn check(&self) -> Result<(), ScenarioError> {
        let key = |field: &str| format!("simulation.{field}");
        let mut found = vec![self.check_step()];
        for (field, value, low, high) in [
            ("gravity_m_s2", self.gravity_m_s2, 0.0, 100.0),
            ("duration_secs", self.duration_secs, 1e-3, 36_000.0),
            ("end_after_secs", self.end_after_secs, 0.0, 36_000.0),
            ("longest_distance_m", self.longest_distance_m, 0.1, 1e4),
        ] {
            found.push(number_within(&key(field), value, low, high));
        }
        found.extend([self.mujoco.check(), self.rapier.check()]);
        let step_secs = self.known_step_secs();
        for (field, hz) in [("record_hz", self.record_hz), ("people_hz", self.people_hz)] {
            found.push(whole_steps(&key(field), 1.0 / hz, step_secs).map(drop));
        }
        ScenarioError::all(found.into_iter().filter_map(Result::err).collect())
    }
}

impl ControllerData {
    fn check(&self, time_step_secs: f64) -> Result<(), ScenarioError> {
        let key = |field: &str| key_of("controller", &self.name, field);
        whole_steps(&key("period_secs"), self.period_secs, time_step_secs)?;
        number_within(
            &key("answer_within_secs"),
            self.answer_within_secs,
            1e-3,
            86_400.0,
        )?;
        within(&key("latency_secs"), &self.latency_secs, 0.0, 60.0)
    }
}

/// How many time steps a period has: at least one, and whole. Of a time step that is not a number it is one: what is wrong
/// with that is told by itself.
///
/// # Errors
/// [`ScenarioError::Value`] naming `key`.
pub(super) fn whole_steps(
    key: &str,
    period_secs: f64,
    time_step_secs: f64,
) -> Result<u64, ScenarioError> {
    if time_step_secs.is_nan() {
        return Ok(1);
    }
    let steps = period_secs / time_step_secs;
    let is_whole = steps.is_finite() && (steps - steps.round()).abs() < 1e-6;
    if !is_whole || !(1.0..1e9).contains(&steps.round()) {
        let problem = format!(
            "gives a period of {period_secs} s, which must be a whole number of time steps of {time_step_secs} s"
        );
        return Err(ScenarioError::value(key, &problem));
    }
    Ok(steps.round() as u64)
}
