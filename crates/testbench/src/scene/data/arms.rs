//! Groups, trajectories and grippers of a scene together: what is wrong among them, and what of them is an actuator.

use std::collections::BTreeMap;

use super::{
    Actuator, ActuatorKind, GripperKind, JointGroup, SceneData, SensorKind, key_of, known,
};
use crate::bench::ScenarioError;

/// Who drives a joint: its list, its name and its place there.
type Driver<'a> = (&'static str, &'a str, String);

impl SceneData {
    /// What is wrong with groups, trajectories and grippers, everything at once.
    pub(super) fn wrong_arms(&self) -> Vec<ScenarioError> {
        let mut wrong = Vec::new();
        for group in &self.groups {
            wrong.extend(self.check_robot("group", &group.name, &group.robot).err());
            wrong.extend(group.check());
            let point = group.tool_point.as_deref();
            wrong.extend(point.and_then(|point| {
                let key = key_of("group", &group.name, "tool_point");
                self.check_point(&key, point, &group.robot).err()
            }));
        }
        for trajectory in &self.trajectories {
            let group = self.groups.iter().find(|it| it.name == trajectory.group);
            wrong.extend(trajectory.check(group));
        }
        for gripper in &self.grippers {
            wrong.extend(
                self.check_robot("gripper", &gripper.name, &gripper.robot)
                    .err(),
            );
            wrong.extend(gripper.check());
            wrong.extend(gripper.tool_point().and_then(|point| {
                let key = key_of("gripper", &gripper.name, "tool_point");
                self.check_point(&key, point, &gripper.robot).err()
            }));
            wrong.extend(self.wrong_tools(&gripper.name, &gripper.kind));
        }
        wrong.extend(self.driven_twice());
        wrong.extend(self.read_wrongly());
        wrong
    }

    /// Sensors of groups and grippers name those of their robot.
    fn read_wrongly(&self) -> Vec<ScenarioError> {
        let read = self.sensors.iter().filter_map(|sensor| {
            let key = |field: &str| key_of("sensor", &sensor.name, field);
            match &sensor.kind {
                SensorKind::Goal { group } => {
                    let own = self.groups.iter().filter(|it| it.robot == sensor.robot);
                    known(&key("group"), group, own.map(|it| it.name.as_str())).err()
                }
                SensorKind::Grip { gripper } => {
                    let own = self.grippers.iter().filter(|it| it.robot == sensor.robot);
                    known(&key("gripper"), gripper, own.map(|it| it.name.as_str())).err()
                }
                _ => None,
            }
        });
        read.collect()
    }

    fn check_point(&self, key: &str, point: &str, robot: &str) -> Result<(), ScenarioError> {
        let points = self.tool_points.iter().filter(|it| it.robot == robot);
        known(key, point, points.map(|it| it.name.as_str()))
    }

    fn wrong_tools(&self, name: &str, kind: &GripperKind) -> Vec<ScenarioError> {
        let GripperKind::ToolChanger { tools, .. } = kind else {
            return Vec::new();
        };
        let mut wrong = Vec::new();
        for (place, tool) in tools.iter().enumerate() {
            let key = key_of("gripper", name, &format!("tools.{place}"));
            let robot = self.robots.iter().find(|it| it.name == *tool);
            let object = self.objects.iter().find(|it| it.name == *tool);
            let is_fixed = robot.is_some_and(|it| it.fixed)
                || object.is_some_and(|it| it.fixed || (it.file.is_none() && it.mass_kg.is_none()));
            if robot.is_none() && object.is_none() {
                wrong.push(ScenarioError::UnknownName {
                    key,
                    name: tool.clone(),
                });
            } else if is_fixed {
                let problem = format!("names `{tool}`, which is fixed to the world");
                wrong.push(ScenarioError::value(&key, &problem));
            }
        }
        wrong
    }

    /// A joint has one driver: a group, a gripper or an actuator.
    fn driven_twice(&self) -> Vec<ScenarioError> {
        let mut drivers: BTreeMap<(&str, &str), Driver<'_>> = BTreeMap::new();
        for actuator in &self.actuators {
            let mode = super::super::actuating::kind_name(&actuator.kind);
            for joint in actuator.kind.joints() {
                let driver = ("actuator", actuator.name.as_str(), mode.to_owned());
                drivers.insert((&actuator.robot, joint), driver);
            }
        }
        let groups = self.groups.iter().map(|it| {
            let mode = format!("{:?}", it.mode).to_lowercase();
            ("group", &it.name, &it.robot, it.joints.as_slice(), mode)
        });
        let grippers = self.grippers.iter().map(|it| {
            let mode = "grip".to_owned();
            ("gripper", &it.name, &it.robot, it.joints(), mode)
        });
        let mut wrong = Vec::new();
        for (list, name, robot, joints, mode) in groups.chain(grippers) {
            for (place, joint) in joints.iter().enumerate() {
                let driver = (list, name.as_str(), mode.clone());
                let before = drivers.insert((robot, joint), driver);
                let Some((of, who, how)) = before.filter(|(_, who, _)| who != name) else {
                    continue;
                };
                let problem = format!(
                    "names `{joint}`, which the {of} `{who}` drives, too ({how}, here {mode}): both would be commanded at once; leave it to one"
                );
                let key = key_of(list, name, &format!("joints.{place}"));
                wrong.push(ScenarioError::value(&key, &problem));
            }
        }
        wrong
    }

    /// Groups and grippers are commanded as actuators are.
    pub(super) fn add_arms(&mut self) {
        for group in &self.groups {
            let count = group.joints.len();
            let point = self.tool_points.iter().find(|point| {
                Some(&point.name) == group.tool_point.as_ref() && point.robot == group.robot
            });
            let limit = |given: &Option<super::PerJoint>, joint: usize| {
                given.as_ref().map_or(f64::NAN, |it| it.of(joint))
            };
            let kind = ActuatorKind::JointGroup(Box::new(JointGroup {
                tool: point.cloned(),
                is_slide: vec![false; count],
                torque_limit: (0..count)
                    .map(|it| limit(&group.torque_limit, it))
                    .collect(),
                velocity_limit: (0..count)
                    .map(|it| limit(&group.velocity_limit, it))
                    .collect(),
                group: group.clone(),
            }));
            let named = ("group", group.name.as_str(), group.robot.as_str());
            self.actuators
                .push(Actuator::of(named, &group.faults, kind));
        }
        for gripper in &self.grippers {
            let kind = ActuatorKind::Gripper(Box::new(gripper.clone()));
            let named = ("gripper", gripper.name.as_str(), gripper.robot.as_str());
            self.actuators
                .push(Actuator::of(named, &gripper.faults, kind));
        }
    }

    /// Fills in what groups and recorded joints have from their robots' descriptions, and what people have from recordings.
    ///
    /// # Errors
    /// All joints that a description does not have or that cannot be driven, and limits that nothing gives.
    pub(in crate::scene) fn complete(
        &mut self,
        models: &crate::scene::build::Models,
        captures: &crate::scene::capture::Files,
    ) -> Result<(), ScenarioError> {
        let mut wrong = crate::scene::capture::complete(self, captures);
        let step_secs = self.simulation.time_step_secs;
        for robot in &mut self.robots {
            let model = models.get(&robot.description());
            wrong.extend(model.into_iter().flat_map(|it| beyond_limits(robot, it)));
            let slides = |name: &&String| {
                let joint = model.and_then(|model| Some(&model.joints[model.joint(name)?]));
                joint.is_some_and(|it| it.kind == robot_model::JointKind::Prismatic)
            };
            robot.sliding_joints = robot
                .recorded_joints
                .iter()
                .filter(slides)
                .cloned()
                .collect();
        }
        let files: BTreeMap<&str, _> = self
            .robots
            .iter()
            .map(|robot| (robot.name.as_str(), robot.description()))
            .collect();
        for actuator in &mut self.actuators {
            let Some(model) = files
                .get(actuator.robot.as_str())
                .and_then(|it| models.get(it))
            else {
                continue;
            };
            match &mut actuator.kind {
                ActuatorKind::JointGroup(group) => wrong.extend(group.complete(model)),
                ActuatorKind::Gripper(gripper) => {
                    for (place, name) in gripper.joints().iter().enumerate() {
                        let key = key_of("gripper", &gripper.name, &format!("joints.{place}"));
                        wrong.extend(drivable(model, &key, name).err());
                    }
                }
                _ => continue,
            }
            // Units of fields are known only now.
            wrong.extend(actuator.check_errors(step_secs).err());
        }
        ScenarioError::all(wrong)
    }
}

/// Positions at the beginning that are beyond a joint's limits.
fn beyond_limits(robot: &super::Robot, model: &robot_model::Model) -> Vec<ScenarioError> {
    let wrong = robot.joints.iter().filter_map(|(name, begins)| {
        let joint = &model.joints[model.joint(name)?];
        let [low, high] = joint.limits?;
        let [least, most] = begins.support();
        let slack = 1e-9 * (1.0 + low.abs().max(high.abs()));
        if least >= low - slack && most <= high + slack {
            return None;
        }
        let at = match least == most {
            true => format!("is {least}"),
            false => format!("draws from {least} to {most}"),
        };
        let problem = format!(
            "{at}, and the joint's range in {} is {low} to {high}: beyond it the limit throws the joint back; begin within (a normal distribution can be cut with `low` and `high`)",
            robot.file
        );
        let key = key_of("robot", &robot.name, &format!("joints.{name}"));
        Some(ScenarioError::value(&key, &problem))
    });
    wrong.collect()
}

/// The joint of a name that can be driven.
fn drivable<'m>(
    model: &'m robot_model::Model,
    key: &str,
    name: &str,
) -> Result<&'m robot_model::Joint, ScenarioError> {
    let Some(place) = model.joint(name) else {
        return Err(ScenarioError::UnknownName {
            key: key.to_owned(),
            name: name.to_owned(),
        });
    };
    let joint = &model.joints[place];
    let follows = model.couplings.iter().any(|it| it.joint == place);
    match joint.kind {
        _ if follows => {
            let problem = format!("names `{name}`, which follows another joint (mimic)");
            Err(ScenarioError::value(key, &problem))
        }
        robot_model::JointKind::Revolute | robot_model::JointKind::Prismatic => Ok(joint),
        other => {
            let problem = format!("names `{name}`, which is {other} and cannot be driven");
            Err(ScenarioError::value(key, &problem))
        }
    }
}

impl JointGroup {
    fn complete(&mut self, model: &robot_model::Model) -> Vec<ScenarioError> {
        let key = |field: &str| key_of("group", &self.group.name, field);
        let mut wrong = Vec::new();
        let needs_speed =
            self.group.profile.is_some() || self.group.mode == super::GroupMode::Velocity;
        for (place, name) in self.group.joints.iter().enumerate() {
            let joint = match drivable(model, &key(&format!("joints.{place}")), name) {
                Ok(joint) => joint,
                Err(error) => {
                    wrong.push(error);
                    continue;
                }
            };
            self.is_slide[place] = joint.kind == robot_model::JointKind::Prismatic;
            for (field, kept, own, needed) in [
                (
                    "torque_limit",
                    &mut self.torque_limit,
                    joint.effort_limit,
                    true,
                ),
                (
                    "velocity_limit",
                    &mut self.velocity_limit,
                    joint.velocity_limit,
                    needs_speed,
                ),
            ] {
                if kept[place].is_nan() {
                    kept[place] = own.filter(|it| *it > 0.0).unwrap_or(f64::NAN);
                }
                if needed && kept[place].is_nan() {
                    let problem = format!(
                        "is missing, and the description gives none for the joint `{name}`"
                    );
                    wrong.push(ScenarioError::value(&key(field), &problem));
                }
            }
        }
        wrong
    }
}
