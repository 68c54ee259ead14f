//! The scenario: everything about the robot, the object, the human and the sensors that is data.
//!
//! [`Scenario`] is what stays the same between parameter sets; [`Parameters`] is what tuning
//! changes. Both are TOML, both refuse unknown keys, and both are checked when parsed, so that an
//! episode cannot fail over a misspelt joint.

mod abstract_test;
mod parameters;
mod parts;

use std::collections::{BTreeMap, BTreeSet};

use schemars::JsonSchema;
use serde::Deserialize;
use testbench::ScenarioError;

pub use abstract_test::{AbstractTest, Action, HumanParameters, HumanSignal, RobotSignal};
pub use parameters::{
    ArmParameters, HandParameters, HumanDraws, InertiaSource, ObjectParameters, Parameters,
    PlannerParameters, TrackingParameters,
};
pub use parts::{
    Body, Drive, HandPositions, Human, Joint, JointAngles, Object, Pedestal, Programme, Rates,
    Robot, SensorRule, Sensors, Shape, SimulationSettings, TrackingVolume, TruthRules,
};

/// A scenario as its TOML file gives it. Units are in the names of the fields.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// What the scenario is called in reports.
    pub name: String,
    /// Time step and solver.
    pub simulation: SimulationSettings,
    /// How often things happen.
    pub rates: Rates,
    /// Hand, fingers, poses.
    pub robot: Robot,
    /// What the robot's code does, and when.
    pub programme: Programme,
    /// How the robot judges the human.
    pub sensors: Sensors,
    /// Where tracking glitches go.
    pub tracking: TrackingVolume,
    /// How the truth is judged.
    pub truth: TruthRules,
    /// The object to hand over.
    pub object: Object,
    /// What the object stands on.
    pub pedestal: Pedestal,
    /// The human.
    pub human: Human,
    /// The tests the human can enact.
    #[serde(rename = "abstract_test")]
    pub abstract_tests: Vec<AbstractTest>,
    /// The robot's links, parents before children.
    #[serde(rename = "body")]
    pub bodies: Vec<Body>,
}

impl Scenario {
    /// Parses and checks a scenario.
    ///
    /// # Errors
    /// [`ScenarioError`] with the place and what to do about it.
    pub fn parse(text: &str) -> Result<Self, ScenarioError> {
        let scenario: Self = toml::from_str(text).map_err(|error| ScenarioError::Syntax {
            reason: error.to_string(),
        })?;
        scenario.check()?;
        Ok(scenario)
    }

    /// As [`Scenario::parse`], of a table that is read already.
    ///
    /// # Errors
    /// As [`Scenario::parse`], without lines.
    pub fn from_table(table: toml::Table) -> Result<Self, ScenarioError> {
        let scenario: Self = table.try_into().map_err(|error: toml::de::Error| {
            let reason = error.to_string();
            ScenarioError::Syntax { reason }
        })?;
        scenario.check()?;
        Ok(scenario)
    }

    /// The abstract test called `name`.
    #[must_use]
    pub fn abstract_test(&self, name: &str) -> Option<&AbstractTest> {
        self.abstract_tests.iter().find(|test| test.name == name)
    }

    /// The joints, in the order of their bodies: name of the body and the joint.
    pub fn joints(&self) -> impl Iterator<Item = (&str, &Joint)> {
        self.bodies
            .iter()
            .filter_map(|body| Some((body.name.as_str(), body.joint.as_ref()?)))
    }

    fn check(&self) -> Result<(), ScenarioError> {
        self.simulation.check()?;
        self.rates.check(self.simulation.time_step_secs)?;
        self.programme.check()?;
        self.object.check()?;
        self.human.check()?;
        self.check_tree()?;
        self.check_names()?;
        self.abstract_tests
            .iter()
            .try_for_each(AbstractTest::check)?;
        if self.abstract_tests.is_empty() {
            return Err(ScenarioError::value(
                "abstract_test",
                "is missing: give at least one",
            ));
        }
        Ok(())
    }

    /// Parents come before children, names are unique and usable in MJCF.
    fn check_tree(&self) -> Result<(), ScenarioError> {
        let mut known = BTreeSet::from(["world"]);
        for body in &self.bodies {
            body.check()?;
            if !known.contains(body.parent.as_str()) {
                return Err(ScenarioError::UnknownName {
                    key: format!("body.{}.parent", body.name),
                    name: body.parent.clone(),
                });
            }
            if !known.insert(&body.name) {
                return Err(ScenarioError::value(
                    &format!("body.{}", body.name),
                    "is given twice",
                ));
            }
        }
        Ok(())
    }

    /// Every joint that is named exists and has the drive it needs.
    fn check_names(&self) -> Result<(), ScenarioError> {
        let drives: BTreeMap<&str, Drive> = self
            .joints()
            .map(|(name, joint)| (name, joint.drive))
            .collect();
        let require = |key: &str, name: &str, drive: Drive| {
            if drives.get(name) == Some(&drive) {
                Ok(())
            } else {
                Err(ScenarioError::UnknownName {
                    key: key.to_owned(),
                    name: name.to_owned(),
                })
            }
        };
        for name in &self.robot.fingers {
            require("robot.fingers", name, Drive::Hand)?;
        }
        for name in &self.programme.reset_joints {
            require("programme.reset_joints", name, Drive::Arm)?;
        }
        for (pose, joints) in self.robot.poses.named() {
            for name in joints.keys() {
                require(&format!("robot.poses.{pose}"), name, Drive::Arm)?;
            }
        }
        for (position, joints) in self.robot.hand_positions.named() {
            for name in joints.keys() {
                require(
                    &format!("robot.hand_positions.{position}"),
                    name,
                    Drive::Hand,
                )?;
            }
        }
        if self.bodies.iter().all(|body| body.name != self.robot.hand) {
            return Err(ScenarioError::UnknownName {
                key: "robot.hand".to_owned(),
                name: self.robot.hand.clone(),
            });
        }
        Ok(())
    }
}
