//! Actuators at work: from commands to the targets of drives and to forces.

use std::collections::BTreeMap;
use std::ops::Range;

use super::build::{Built, BuiltRobot, Models};
use super::data::{Actuator, ActuatorKind, GripperKind, GroupMode, JointGroup, SceneData};
use super::draws::Draws;
use super::drive_errors::DriveErrors;
use super::gripping::Gripping;
use super::grouping::{Ended, Grouping};
use super::measure::yaw_of;
use crate::controller::{Port, PortField};
use crate::physics::Physics;

/// An actuator in an episode.
#[derive(Debug, Clone)]
pub(super) struct Actuating {
    pub(super) name: String,
    pub(super) robot: usize,
    pub(super) fields: Vec<PortField>,
    /// What is commanded, in the order of the fields.
    pub(super) commanded: Vec<f64>,
    drives: Range<usize>,
    /// The strength that its drives have in the engine.
    strength: f64,
    pub(super) errors: DriveErrors,
    /// Whether a fault was on when it was last written down.
    pub(super) was_faulty: bool,
    lefts: usize,
    root: usize,
    kind: ActuatorKind,
    /// Limits of acceleration and deceleration, for a differential drive.
    accelerations: [f64; 2],
    /// Speed and turn rate on the way to the commanded ones.
    ramp: [f64; 2],
    /// What a group or a gripper is at.
    pub(super) group: Option<Box<Grouping>>,
    pub(super) gripper: Option<Box<Gripping>>,
    /// Fields that were commanded since the last step.
    told: Vec<bool>,
    /// What it acted on in the step before.
    heard: Vec<f64>,
}

impl Actuating {
    pub(super) fn new(
        actuator: &Actuator,
        index: usize,
        robot: usize,
        (data, models, built): (&SceneData, &Models, &Built),
        draws: Draws,
    ) -> Self {
        let BuiltRobot { added, .. } = &built.robots[robot];
        let (group, gripper) = arms_of(actuator, robot, data, models, built);
        let drawn = |field: &str, d| draws.of("actuator", &actuator.name, field, d);
        let (lefts, accelerations) = match &actuator.kind {
            ActuatorKind::DifferentialDrive {
                left_joints,
                acceleration_m_s2,
                deceleration_m_s2,
                ..
            } => (
                left_joints.len(),
                [
                    drawn("acceleration_m_s2", acceleration_m_s2),
                    drawn("deceleration_m_s2", deceleration_m_s2),
                ],
            ),
            _ => (0, [0.0; 2]),
        };
        let fields = fields_of(&actuator.kind);
        // A position drive holds where its joint begins.
        let commanded = match &actuator.kind {
            ActuatorKind::Position { joint, .. } => {
                let joint = added.joints.get(joint);
                let start = built.robots[robot].start.iter();
                let start = start.rev().find(|(j, _)| Some(j) == joint);
                vec![start.map_or(0.0, |(_, position)| *position)]
            }
            ActuatorKind::JointGroup(_) => {
                let start = group.as_ref().map(|group| group.start(&built.layout));
                start.unwrap_or_else(|| vec![0.0; fields.len()])
            }
            ActuatorKind::Gripper(_) => {
                let start = gripper.as_ref().map(|gripper| gripper.start());
                start.unwrap_or_else(|| vec![0.0; fields.len()])
            }
            _ => vec![0.0; fields.len()],
        };
        Self {
            name: actuator.name.clone(),
            robot,
            errors: DriveErrors::new(actuator, &commanded, holds(&actuator.kind), draws),
            was_faulty: false,
            heard: commanded.clone(),
            commanded,
            told: vec![false; fields.len()],
            group,
            gripper,
            fields,
            strength: 1.0,
            drives: built.drives[index].clone(),
            lefts,
            root: added.root,
            kind: actuator.kind.clone(),
            accelerations,
            ramp: [0.0; 2],
        }
    }

    /// What a controller is told of it.
    pub(super) fn port(&self) -> Port {
        let mut facts = BTreeMap::new();
        if let ActuatorKind::DifferentialDrive {
            longest_speed_m_s,
            longest_turn_rate_rad_s,
            ..
        }
        | ActuatorKind::PlanarVelocity {
            longest_speed_m_s,
            longest_turn_rate_rad_s,
            ..
        } = &self.kind
        {
            facts.insert("longest_speed_m_s".to_owned(), *longest_speed_m_s);
            facts.insert(
                "longest_turn_rate_rad_s".to_owned(),
                *longest_turn_rate_rad_s,
            );
        }
        facts.extend(facts_of(&self.kind));
        Port {
            name: self.name.clone(),
            kind: kind_name(&self.kind).to_owned(),
            fields: self.fields.clone(),
            facts,
        }
    }

    /// A field is commanded.
    pub(super) fn command(&mut self, field: usize, value: f64) {
        self.commanded[field] = value;
        self.told[field] = true;
    }

    /// Whether something was commanded since the last step.
    pub(super) fn is_told(&self) -> bool {
        self.told.contains(&true)
    }

    /// Brings the drives on their way for the next step, which begins now; how a trajectory ended, if one did.
    pub(super) fn act(
        &mut self,
        physics: &mut dyn Physics,
        now_secs: f64,
        step_secs: f64,
    ) -> Option<Ended> {
        let mut ended = None;
        let strength = self.errors.strength(now_secs);
        let is_sound = !self.errors.is_faulty(now_secs);
        let wanted = self.errors.act_on(&self.commanded, now_secs);
        if strength != self.strength {
            self.strength = strength;
            for drive in self.drives.clone() {
                physics.set_drive_strength(drive, strength);
            }
        }
        match &self.kind {
            ActuatorKind::Position { .. }
            | ActuatorKind::Velocity { .. }
            | ActuatorKind::Effort { .. } => {
                for drive in self.drives.clone() {
                    physics.set_drive(drive, wanted[0]);
                }
            }
            ActuatorKind::DifferentialDrive {
                wheel_radius_m,
                wheel_separation_m,
                longest_speed_m_s,
                longest_turn_rate_rad_s,
                turn_acceleration_rad_s2,
                ..
            } => {
                let speed = wanted[0].clamp(-longest_speed_m_s, *longest_speed_m_s);
                let turn = wanted[1].clamp(-longest_turn_rate_rad_s, *longest_turn_rate_rad_s);
                let [faster, slower] = self.accelerations;
                self.ramp[0] = ramped(self.ramp[0], speed, faster, slower, step_secs);
                let most = *turn_acceleration_rad_s2;
                self.ramp[1] = ramped(self.ramp[1], turn, most, most, step_secs);
                let half_m_s = self.ramp[1] * wheel_separation_m / 2.0;
                for (place, drive) in self.drives.clone().enumerate() {
                    let side = if place < self.lefts { -1.0 } else { 1.0 };
                    let rim_m_s = self.ramp[0] + side * half_m_s;
                    physics.set_drive(drive, rim_m_s / wheel_radius_m);
                }
            }
            ActuatorKind::PlanarVelocity { .. } => {
                push(physics, self.root, &self.kind, wanted, strength);
            }
            ActuatorKind::JointGroup(data) => {
                if let Some(group) = &mut self.group {
                    let joints = data.group.joints.len();
                    // A fault can keep a command back, or change it later.
                    let changed = wanted.iter().zip(&self.heard).zip(&self.told);
                    let new: Vec<bool> = changed
                        .map(|((now, before), told)| (*told && is_sound) || now != before)
                        .collect();
                    if new.contains(&true) {
                        group.command(wanted, new[joints..].contains(&true));
                    }
                    self.heard.copy_from_slice(wanted);
                    ended = group.act(physics, self.drives.clone(), wanted, now_secs);
                }
            }
            ActuatorKind::Gripper(_) => {
                if let Some(gripper) = &mut self.gripper {
                    let drives = self.drives.clone();
                    gripper.act(physics, drives, wanted, strength, step_secs);
                }
            }
        }
        self.told.fill(false);
        ended
    }
}

/// Force and torque on the root towards the commanded velocity.
fn push(
    physics: &mut dyn Physics,
    root: usize,
    kind: &ActuatorKind,
    commanded: &[f64],
    strength: f64,
) {
    let ActuatorKind::PlanarVelocity {
        longest_speed_m_s,
        longest_turn_rate_rad_s,
        gain_ns_m,
        turn_gain_nms_rad,
        force_limit_newtons,
        torque_limit_nm,
    } = kind
    else {
        return;
    };
    let limited = |value: f64, limit: f64| value.clamp(-limit, limit);
    let (sine, cosine) = yaw_of(physics.body_pose(root).orientation).sin_cos();
    let twist = physics.body_twist(root);
    let [forward, left] = [0, 1].map(|i| limited(commanded[i], *longest_speed_m_s));
    let turn = limited(commanded[2], *longest_turn_rate_rad_s);
    let wanted = [
        forward * cosine - left * sine,
        forward * sine + left * cosine,
    ];
    let [x, y] = [0, 1].map(|i| {
        strength
            * limited(
                gain_ns_m * (wanted[i] - twist.linear_m_s[i]),
                *force_limit_newtons,
            )
    });
    let torque = strength
        * limited(
            turn_gain_nms_rad * (turn - twist.angular_rad_s[2]),
            *torque_limit_nm,
        );
    physics.apply(root, [x, y, 0.0], [0.0, 0.0, torque]);
}

/// One step from `now` towards `wanted`: `slower` limits changes towards 0, `faster` all others.
fn ramped(now: f64, wanted: f64, faster: f64, slower: f64, step_secs: f64) -> f64 {
    let is_braking = (now > 0.0 && wanted < now) || (now < 0.0 && wanted > now);
    let most = if is_braking { slower } else { faster } * step_secs;
    let next = now + (wanted - now).clamp(-most, most);
    // Braking ends at rest; what goes on from there is acceleration.
    if is_braking && next * now < 0.0 {
        0.0
    } else {
        next
    }
}

/// Whether a field's neutral is where it is.
fn holds(kind: &ActuatorKind) -> bool {
    match kind {
        ActuatorKind::Position { .. } => true,
        ActuatorKind::JointGroup(group) => {
            matches!(group.group.mode, GroupMode::Position | GroupMode::Impedance)
        }
        ActuatorKind::Gripper(_) => true,
        ActuatorKind::Velocity { .. }
        | ActuatorKind::Effort { .. }
        | ActuatorKind::DifferentialDrive { .. }
        | ActuatorKind::PlanarVelocity { .. } => false,
    }
}

/// The group or the gripper that an actuator is.
fn arms_of(
    actuator: &Actuator,
    robot: usize,
    data: &SceneData,
    models: &Models,
    built: &Built,
) -> (Option<Box<Grouping>>, Option<Box<Gripping>>) {
    match &actuator.kind {
        ActuatorKind::JointGroup(group) => {
            let own = data.trajectories.iter();
            let own = own
                .filter(|it| it.group == actuator.name)
                .cloned()
                .collect();
            let model = models.get(&data.robots[robot].description());
            let at_work = model
                .map(|model| Grouping::new(group, &built.robots[robot], &built.layout, model, own));
            (at_work.map(Box::new), None)
        }
        ActuatorKind::Gripper(gripper) => {
            let at_work = Gripping::new(gripper, robot, data, built);
            (None, Some(Box::new(at_work)))
        }
        _ => (None, None),
    }
}

/// Facts of groups and grippers for controllers.
fn facts_of(kind: &ActuatorKind) -> BTreeMap<String, f64> {
    let mut facts = BTreeMap::new();
    match kind {
        ActuatorKind::JointGroup(group) => {
            for (place, joint) in group.group.joints.iter().enumerate() {
                for (what, limit) in [
                    ("torque_limit", group.torque_limit[place]),
                    ("velocity_limit", group.velocity_limit[place]),
                ] {
                    if limit.is_finite() {
                        facts.insert(format!("{joint}.{what}"), limit);
                    }
                }
            }
        }
        ActuatorKind::Gripper(gripper) => match &gripper.kind {
            GripperKind::Parallel {
                width_m,
                force_limit_newtons,
                ..
            } => {
                facts.insert("width_m".to_owned(), *width_m);
                facts.insert("force_limit_newtons".to_owned(), *force_limit_newtons);
            }
            GripperKind::UnderActuated {
                tension_limit_newtons,
                ..
            } => {
                facts.insert("tension_limit_newtons".to_owned(), *tension_limit_newtons);
            }
            GripperKind::Suction { .. } | GripperKind::ToolChanger { .. } => {}
        },
        _ => {}
    }
    facts
}

pub(super) fn kind_name(kind: &ActuatorKind) -> &'static str {
    match kind {
        ActuatorKind::Position { .. } => "position",
        ActuatorKind::Velocity { .. } => "velocity",
        ActuatorKind::Effort { .. } => "effort",
        ActuatorKind::DifferentialDrive { .. } => "differential_drive",
        ActuatorKind::PlanarVelocity { .. } => "planar_velocity",
        ActuatorKind::JointGroup(group) => match group.group.mode {
            GroupMode::Position => "position_group",
            GroupMode::Velocity => "velocity_group",
            GroupMode::Torque => "torque_group",
            GroupMode::Impedance => "impedance_group",
        },
        ActuatorKind::Gripper(gripper) => match gripper.kind {
            GripperKind::Parallel { .. } => "parallel_gripper",
            GripperKind::UnderActuated { .. } => "under_actuated_gripper",
            GripperKind::Suction { .. } => "suction_gripper",
            GripperKind::ToolChanger { .. } => "tool_changer",
        },
    }
}

/// A field for each joint, and those of the tool point's pose.
fn group_fields(group: &JointGroup) -> Vec<PortField> {
    let field = |name: &str, unit: &str| PortField {
        name: name.to_owned(),
        unit: unit.to_owned(),
        length: 1,
    };
    let joints = group.group.joints.iter().zip(&group.is_slide);
    let mut fields: Vec<PortField> = joints
        .map(|(joint, is_slide)| {
            let unit = match (group.group.mode, is_slide) {
                (GroupMode::Position | GroupMode::Impedance, false) => "rad",
                (GroupMode::Position | GroupMode::Impedance, true) => "m",
                (GroupMode::Velocity, false) => "rad/s",
                (GroupMode::Velocity, true) => "m/s",
                (GroupMode::Torque, false) => "Nm",
                (GroupMode::Torque, true) => "N",
            };
            field(joint, unit)
        })
        .collect();
    if group.tool.is_some() {
        for (name, unit) in TOOL_FIELDS {
            fields.push(field(name, unit));
        }
    }
    fields
}

/// Fields of a tool point's pose in the world, and whether it goes there on a straight line.
pub(super) const TOOL_FIELDS: [(&str, &str); 7] = [
    ("x", "m"),
    ("y", "m"),
    ("z", "m"),
    ("roll", "rad"),
    ("pitch", "rad"),
    ("yaw", "rad"),
    ("line", "1"),
];

pub(super) fn fields_of(kind: &ActuatorKind) -> Vec<PortField> {
    let fields: &[(&str, &str)] = match kind {
        ActuatorKind::Position { .. } => &[("position", "rad")],
        ActuatorKind::Velocity { .. } => &[("velocity", "rad/s")],
        ActuatorKind::Effort { .. } => &[("effort", "Nm")],
        ActuatorKind::DifferentialDrive { .. } => &[("speed", "m/s"), ("turn_rate", "rad/s")],
        ActuatorKind::PlanarVelocity { .. } => {
            &[("forward", "m/s"), ("left", "m/s"), ("turn_rate", "rad/s")]
        }
        ActuatorKind::JointGroup(group) => return group_fields(group),
        ActuatorKind::Gripper(gripper) => match gripper.kind {
            GripperKind::Parallel { .. } => &[("width", "m"), ("force", "N")],
            GripperKind::UnderActuated { .. } => &[("tension", "N")],
            GripperKind::Suction { .. } => &[("suction", "1")],
            GripperKind::ToolChanger { .. } => &[("lock", "1")],
        },
    };
    let field = |(name, unit): &(&str, &str)| PortField {
        name: (*name).to_owned(),
        unit: (*unit).to_owned(),
        length: 1,
    };
    fields.iter().map(field).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramps_keep_to_their_limits_and_rest_between_directions() {
        assert_eq!(ramped(0.0, 1.0, 0.5, 2.0, 0.1), 0.05);
        assert_eq!(ramped(1.0, 0.0, 0.5, 2.0, 0.1), 0.8);
        assert_eq!(ramped(0.1, -1.0, 0.5, 2.0, 0.1), 0.0);
        assert_eq!(ramped(0.0, -1.0, 0.5, 2.0, 0.1), -0.05);
        assert_eq!(ramped(-1.0, -0.9, 0.5, 2.0, 0.1), -0.9);
    }
}
