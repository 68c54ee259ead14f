//! Drives for a description's joints.

use super::super::draft::{quoted, rounded};
use robot_model::pose::{cross, length, rotate, subtract};
use robot_model::{ActuatorKind, Joint, JointKind, Model, Pose};
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// How fast a drive that the description gives no gains answers, Hz.
const ANSWERS_HZ: f64 = 3.0;

/// How far such a drive gives way under the weight of what it carries, rad or m.
const GIVES_WAY: f64 = 0.02;

const GRAVITY: f64 = 9.81;

/// A drive of a joint.
pub(super) struct Drive<'a> {
    pub(super) joint: &'a Joint,
    index: usize,
    stiffness: f64,
    damping: f64,
    limit: f64,
}

/// A drive for each joint that turns or slides and follows no other.
pub(super) fn of(model: &Model) -> Vec<Drive<'_>> {
    let poses = model
        .poses(&model.reference_positions())
        .unwrap_or_default();
    let moves = |joint: &Joint| matches!(joint.kind, JointKind::Revolute | JointKind::Prismatic);
    let follows = |index: usize| {
        model
            .couplings
            .iter()
            .any(|coupling| coupling.joint == index)
    };
    let joints = model.joints.iter().enumerate();
    joints
        .filter(|(index, joint)| moves(joint) && !follows(*index))
        .map(|(index, joint)| drive(model, &poses, index, joint))
        .collect()
}

fn drive<'a>(model: &'a Model, poses: &[Pose], index: usize, joint: &'a Joint) -> Drive<'a> {
    let load = load(model, poses, joint);
    let inertia = (load.inertia + joint.armature).max(1e-6);
    let stiffness = (inertia * (TAU * ANSWERS_HZ).powi(2)).max(load.weight / GIVES_WAY);
    let mut drive = Drive {
        joint,
        index,
        stiffness,
        damping: 1.4 * (stiffness * inertia).sqrt(),
        limit: 3.0 * load.weight + 20.0 * inertia,
    };
    let own = model
        .actuators
        .iter()
        .find(|actuator| actuator.joint == index);
    if let Some(ActuatorKind::Position { kp: Some(kp), kv }) = own.map(|own| own.kind) {
        drive.stiffness = kp.max(1e-9);
        drive.damping = kv.unwrap_or_else(|| 1.4 * (drive.stiffness * inertia).sqrt());
    }
    let force = own.and_then(|own| {
        own.force_range
            .map(|[low, high]| high.abs().max(low.abs()) * own.gear.abs())
    });
    let given = joint.effort_limit.or(force);
    drive.limit = given.filter(|limit| *limit > 0.0).unwrap_or(drive.limit);
    drive
}

/// What a joint has to move.
struct Load {
    /// About its axis, or along it: kg m² or kg.
    inertia: f64,
    /// The greatest torque or force of its weight, in whatever direction gravity acts.
    weight: f64,
}

fn load(model: &Model, poses: &[Pose], joint: &Joint) -> Load {
    let mut load = Load {
        inertia: 0.0,
        weight: 0.0,
    };
    let Some(own) = poses.get(joint.link) else {
        return load;
    };
    let (anchor, axis) = (own.apply(joint.anchor_m), rotate(own.rotation, joint.axis));
    for (at, (link, pose)) in model.links.iter().zip(poses).enumerate() {
        let Some(inertial) = link
            .inertial
            .as_ref()
            .filter(|_| hangs_on(model, at, joint.link))
        else {
            continue;
        };
        let mass = inertial.mass_kg;
        if joint.kind == JointKind::Prismatic {
            load.inertia += mass;
            load.weight += mass * GRAVITY;
            continue;
        }
        let arm = length(cross(axis, subtract(pose.apply(inertial.centre_m), anchor)));
        let [xx, yy, zz, ..] = inertial.tensor_kg_m2;
        load.inertia += mass * arm * arm + (xx + yy + zz) / 3.0;
        load.weight += mass * GRAVITY * arm;
    }
    load
}

/// Whether a link is another, or is moved with it.
fn hangs_on(model: &Model, link: usize, other: usize) -> bool {
    let mut at = Some(link);
    while let Some(index) = at {
        if index == other {
            return true;
        }
        at = model.links[index].parent;
    }
    false
}

impl Drive<'_> {
    /// Whether its joint turns without end, as a wheel does.
    pub(super) fn turns_on(&self) -> bool {
        self.joint.kind == JointKind::Revolute && self.joint.limits.is_none()
    }

    /// Where its joint stands among the model's.
    pub(super) const fn index(&self) -> usize {
        self.index
    }

    /// The entry of a scene: what turns without end is driven as a wheel is, unless it is part of an arm.
    pub(super) fn write(&self, text: &mut String, name: &str, fixed: bool) {
        let joint = quoted(&self.joint.name);
        let (damping, limit) = (rounded(self.damping), rounded(self.limit));
        let _ = write!(
            text,
            "[[actuator]]\nname = \"{name}\"\nrobot = \"robot\"\njoint = {joint}\n"
        );
        let _ = match self.turns_on() && !fixed {
            true => write!(
                text,
                "kind = \"velocity\"\ngain = {damping}\nlimit = {limit}\n\n"
            ),
            false => {
                let stiffness = rounded(self.stiffness);
                write!(
                    text,
                    "kind = \"position\"\nstiffness = {stiffness}\ndamping = {damping}\nlimit = {limit}\n\n"
                )
            }
        };
    }
}
