//! Groups of joints that are commanded together, and their trajectories, in a scene's file.

use schemars::JsonSchema;
use serde::Deserialize;

use super::{ActuatorFault, key_of, number_within};
use crate::bench::ScenarioError;

/// Joints of a robot that are commanded together, as MoveIt and ros2_control have them. A controller commands all of them by one
/// name; what they do is recorded as `/group/NAME`.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// Its name, by which a controller commands it: one field for each joint, by the joint's name.
    pub name: String,
    /// The robot it belongs to.
    pub robot: String,
    /// Its joints, in the order in which lists below and waypoints give numbers. No other group or actuator drives them.
    pub joints: Vec<String>,
    /// What commands mean.
    pub mode: GroupMode,
    /// Torque (Nm) or force (N) for each rad or m of error, of `position` and `impedance`; for all joints, or one for each.
    pub stiffness: Option<PerJoint>,
    /// Torque or force for each rad/s or m/s: against the speed of `position` and `impedance`, for the error of `velocity`.
    pub damping: Option<PerJoint>,
    /// The largest torque (Nm) or force (N); the description's effort limits if left out.
    pub torque_limit: Option<PerJoint>,
    /// The highest speed (rad/s or m/s); the description's velocity limits if left out.
    pub velocity_limit: Option<PerJoint>,
    /// The largest acceleration (rad/s² or m/s²) with which goals and trajectories are reached. A URDF has none.
    pub acceleration_limit: Option<PerJoint>,
    /// The largest jerk (rad/s³ or m/s³), for the profile `jerk_limited`. On a straight line of the tool point it holds for the
    /// joints' part along the line, not for what its bends add.
    pub jerk_limit: Option<PerJoint>,
    /// How a commanded position is reached; at once, as far as the drives can, if left out. With a profile commands are goals.
    pub profile: Option<ProfileKind>,
    /// The point of the robot that Cartesian goals are for: one of the scene's `tool_point`s. With it, and with a profile, a
    /// controller can command a pose: fields `x`, `y`, `z`, `roll`, `pitch`, `yaw` and `line`.
    pub tool_point: Option<String>,
    /// The highest speed of the tool point on straight lines.
    #[serde(default = "quarter")]
    pub line_speed_m_s: f64,
    /// The largest acceleration of the tool point on straight lines.
    #[serde(default = "one")]
    pub line_acceleration_m_s2: f64,
    /// Faults of all its drives together that may occur.
    #[serde(default, rename = "fault")]
    pub faults: Vec<ActuatorFault>,
}

/// What a group's commands mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GroupMode {
    /// Positions, which a servo holds: torque = stiffness · (command - position) - damping · (speed - the command's speed).
    Position,
    /// Speeds: torque = damping · (command - speed).
    Velocity,
    /// Torques or forces.
    Torque,
    /// Positions that a spring and a damper lead to, with the weight of the robot's own links borne besides: joint impedance
    /// control. What the robot carries it does not know.
    Impedance,
}

/// How a position is reached. All joints begin and end together and go on a straight way in joint space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProfileKind {
    /// Limited speed and acceleration: the fastest is a trapezoid of speed.
    Trapezoid,
    /// Limited jerk besides: the double S.
    JerkLimited,
}

/// A number for all joints of a group, or one for each.
#[derive(Debug, Clone, PartialEq, JsonSchema, Deserialize)]
#[serde(untagged)]
pub enum PerJoint {
    /// For all.
    All(f64),
    /// For each, in the group's order.
    Each(Vec<f64>),
}

/// Waypoints of a group, one after another: a scripted robot without a controller. The test begins it by sending its name
/// (`send_signal = "NAME"`); `NAME.done` can be awaited. All waypoints are tried when it is begun, from where the group then is:
/// where one is out of reach the group stays, and `NAME.failed` comes instead.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trajectory {
    /// Its name.
    pub name: String,
    /// The group that goes along it; it has a `profile`.
    pub group: String,
    /// The share of the group's highest speeds that is used.
    #[serde(default = "one")]
    pub velocity_scaling: f64,
    /// The share of the group's largest accelerations that is used.
    #[serde(default = "one")]
    pub acceleration_scaling: f64,
    /// Where it goes; it rests at each.
    #[serde(rename = "waypoint")]
    pub waypoints: Vec<GroupWaypoint>,
}

/// A waypoint of a group: positions of its joints, or a place of its tool point.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroupWaypoint {
    /// Positions of the joints in the group's order, in rad or m.
    pub joints: Option<Vec<f64>>,
    /// Where the tool point is to be, in the world; with `y_m` and `z_m`.
    #[allow(missing_docs, reason = "names carry quantity and unit")]
    pub x_m: Option<f64>,
    /// See `x_m`.
    pub y_m: Option<f64>,
    /// See `x_m`.
    pub z_m: Option<f64>,
    /// How it is to be turned, in the world: about the fixed x axis, then y, then z. As it comes if all three are left out.
    pub roll_rad: Option<f64>,
    /// See `roll_rad`.
    pub pitch_rad: Option<f64>,
    /// See `roll_rad`.
    pub yaw_rad: Option<f64>,
    /// Whether the tool point goes there on a straight line; else the joints go the fastest way.
    #[serde(default)]
    pub line: bool,
    /// The speed on the line; the group's `line_speed_m_s` if left out.
    pub speed_m_s: Option<f64>,
    /// How long it rests there.
    #[serde(default)]
    pub wait_secs: f64,
}

fn one() -> f64 {
    1.0
}
fn quarter() -> f64 {
    0.25
}

impl PerJoint {
    /// The number of a joint.
    pub(in crate::scene) fn of(&self, joint: usize) -> f64 {
        match self {
            Self::All(number) => *number,
            Self::Each(numbers) => numbers.get(joint).copied().unwrap_or(f64::NAN),
        }
    }

    fn check(&self, key: &str, joints: usize, low: f64) -> Result<(), ScenarioError> {
        if let Self::Each(numbers) = self
            && numbers.len() != joints
        {
            let problem = format!(
                "lists {} where the group has {joints} joints; give a number for each, or one for all",
                numbers.len()
            );
            return Err(ScenarioError::value(key, &problem));
        }
        (0..joints).try_for_each(|joint| number_within(key, self.of(joint), low, 1e9))
    }
}

impl Group {
    fn key(&self, field: &str) -> String {
        key_of("group", &self.name, field)
    }

    /// What is wrong with it, everything at once.
    pub(super) fn check(&self) -> Vec<ScenarioError> {
        let mut wrong = Vec::new();
        let mut tell = |field: &str, problem: &str| {
            wrong.push(ScenarioError::value(&self.key(field), problem));
        };
        if self.joints.is_empty() {
            tell("joints", "must name at least one joint");
        }
        for (place, joint) in self.joints.iter().enumerate() {
            if self.joints[..place].contains(joint) {
                tell(
                    &format!("joints.{place}"),
                    &format!("names `{joint}` twice"),
                );
            }
        }
        let tool_fields = super::super::actuating::TOOL_FIELDS;
        let is_field = |joint: &String| tool_fields.iter().any(|(name, _)| name == joint);
        if let (Some(_), Some(joint)) =
            (&self.tool_point, self.joints.iter().find(|it| is_field(it)))
        {
            tell(
                "tool_point",
                &format!("has the field `{joint}`, which is a joint's name, too; rename the joint"),
            );
        }
        self.check_mode(&mut tell);
        if self.profile.is_some() && self.acceleration_limit.is_none() {
            tell(
                "acceleration_limit",
                "is missing: a profile needs it, and descriptions have none",
            );
        }
        if self.profile == Some(ProfileKind::JerkLimited) && self.jerk_limit.is_none() {
            tell(
                "jerk_limit",
                "is missing: the profile `jerk_limited` needs it",
            );
        }
        for (field, numbers, low) in [
            ("stiffness", &self.stiffness, 1e-9),
            ("damping", &self.damping, 0.0),
            ("torque_limit", &self.torque_limit, 1e-9),
            ("velocity_limit", &self.velocity_limit, 1e-9),
            ("acceleration_limit", &self.acceleration_limit, 1e-9),
            ("jerk_limit", &self.jerk_limit, 1e-9),
        ] {
            let numbers = numbers.as_ref();
            let checked = numbers.map(|it| it.check(&self.key(field), self.joints.len(), low));
            wrong.extend(checked.and_then(Result::err));
        }
        for (field, value) in [
            ("line_speed_m_s", self.line_speed_m_s),
            ("line_acceleration_m_s2", self.line_acceleration_m_s2),
        ] {
            wrong.extend(number_within(&self.key(field), value, 1e-6, 1e3).err());
        }
        wrong
    }

    /// A mode has the numbers that it needs, and no others.
    fn check_mode(&self, tell: &mut dyn FnMut(&str, &str)) {
        let (needs_stiffness, needs_damping, mode) = match self.mode {
            GroupMode::Position => (true, true, "position"),
            GroupMode::Impedance => (true, true, "impedance"),
            GroupMode::Velocity => (false, true, "velocity"),
            GroupMode::Torque => (false, false, "torque"),
        };
        for (field, needed, is_given) in [
            ("stiffness", needs_stiffness, self.stiffness.is_some()),
            ("damping", needs_damping, self.damping.is_some()),
        ] {
            match (needed, is_given) {
                (true, false) => tell(field, &format!("is missing: the mode `{mode}` needs it")),
                (false, true) => tell(
                    field,
                    &format!("is not used in the mode `{mode}`; leave it out"),
                ),
                _ => {}
            }
        }
        let is_led = needs_stiffness;
        if !is_led && self.profile.is_some() {
            let problem = format!(
                "is not used in the mode `{mode}`: goals and trajectories are of `position` and `impedance`"
            );
            tell("profile", &problem);
        }
        if self.tool_point.is_some() && self.profile.is_none() {
            tell(
                "tool_point",
                "needs a `profile`, by which the tool point goes to its goals",
            );
        }
    }
}

impl Trajectory {
    /// What is wrong with it, everything at once; `group` is the group that it names.
    pub(super) fn check(&self, group: Option<&Group>) -> Vec<ScenarioError> {
        let key = |field: &str| key_of("trajectory", &self.name, field);
        let mut wrong = Vec::new();
        let Some(group) = group else {
            wrong.push(ScenarioError::UnknownName {
                key: key("group"),
                name: self.group.clone(),
            });
            return wrong;
        };
        if group.profile.is_none() {
            let problem = format!("names `{}`, which has no `profile`", group.name);
            wrong.push(ScenarioError::value(&key("group"), &problem));
        }
        for (field, value) in [
            ("velocity_scaling", self.velocity_scaling),
            ("acceleration_scaling", self.acceleration_scaling),
        ] {
            wrong.extend(number_within(&key(field), value, 1e-3, 1.0).err());
        }
        if self.waypoints.is_empty() {
            wrong.push(ScenarioError::value(&key("waypoint"), "is empty"));
        }
        for (place, waypoint) in self.waypoints.iter().enumerate() {
            let key = |field: &str| key(&format!("waypoint.{place}{field}"));
            let problem = waypoint.problem(group);
            wrong.extend(problem.map(|problem| ScenarioError::value(&key(""), &problem)));
            let secs = number_within(&key(".wait_secs"), waypoint.wait_secs, 0.0, 36_000.0);
            wrong.extend(secs.err());
            let speed_m_s = waypoint.speed_m_s.unwrap_or(1.0);
            wrong.extend(number_within(&key(".speed_m_s"), speed_m_s, 1e-6, 1e3).err());
        }
        wrong
    }
}

impl GroupWaypoint {
    /// The place of the tool point and, if it is given, how it is turned.
    pub(in crate::scene) fn place(&self) -> Option<([f64; 3], Option<[f64; 3]>)> {
        let place = [self.x_m?, self.y_m?, self.z_m?];
        let turned = [self.roll_rad, self.pitch_rad, self.yaw_rad];
        let turned = turned.iter().any(Option::is_some);
        let turn = [self.roll_rad, self.pitch_rad, self.yaw_rad].map(|it| it.unwrap_or(0.0));
        Some((place, turned.then_some(turn)))
    }

    fn problem(&self, group: &Group) -> Option<String> {
        let places = [self.x_m, self.y_m, self.z_m];
        let turns = [self.roll_rad, self.pitch_rad, self.yaw_rad];
        let given = places.iter().filter(|it| it.is_some()).count();
        let turned = turns.iter().filter(|it| it.is_some()).count();
        match (&self.joints, given) {
            (Some(joints), 0) if turned == 0 && !self.line => {
                let expected = group.joints.len();
                (joints.len() != expected).then(|| {
                    format!(
                        "lists {} where the group `{}` has {expected} joints; give a position for each",
                        joints.len(),
                        group.name
                    )
                })
            }
            (None, 3) if group.tool_point.is_none() => Some(format!(
                "is a place of a tool point, and the group `{}` names no `tool_point`",
                group.name
            )),
            (None, 3) => None,
            _ => Some(
                "needs either `joints`, or `x_m`, `y_m` and `z_m` (with `roll_rad`, `pitch_rad`, `yaw_rad` and `line` if wanted)"
                    .to_owned(),
            ),
        }
    }
}
