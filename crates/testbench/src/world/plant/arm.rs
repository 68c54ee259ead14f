//! The arm by itself: joints that follow their servos, and where that takes the hand.
//!
//! Definition: joint `i` with angle `q`, speed `v` and setpoint `u` obeys
//!
//! ```text
//! I v' = K (u + d - q) - D v        K stiffness, D damping, I inertia about its axis
//! ```
//!
//! where `d` is the share of its deflection that a constant load causes, as found when the arm was
//! taken over. Each joint is integrated as the engine's `implicitfast` does: semi-implicit Euler
//! with the damping taken implicitly, `v += h (K (u + d - q) - D v) / (I + h D)`, `q += h v`.
//!
//! Deviation from the full physics: joints do not push each other. A neighbour's acceleration `a`
//! through a coupling inertia `M` deflects a joint by `M a / K`; with the handover's values (about
//! 1 kg m², 1 rad/s², 8500 N m/rad) by 0.1 mrad, while a profile speeds up or brakes.
//! Cost: some ten operations a joint and step; the hand's frame is computed only when asked for.

use super::ObjectState;
use super::body::{Blueprint, Configuration};
use super::joints::DrivenJoint;
use crate::geometry::{
    IDENTITY, Pose, Vector, about, add, compose, cross, dot, from_roll_pitch_yaw, inverse, norm,
    rotate, scale, subtract,
};
use crate::scenario::{Body as Link, Drive, Scenario};

/// One joint of the arm.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Servo {
    joint: usize,
    stiffness_nm_rad: f64,
    damping_nms_rad: f64,
    torque_limit_nm: f64,
    inertia_kg_m2: f64,
    deflection_rad: f64,
    position_rad: f64,
    velocity_rad_s: f64,
    /// Before the last step: what is asked of the engine after a step belongs to the time before it.
    before: [f64; 2],
}

/// The arm in motion.
#[derive(Debug, Clone)]
pub(super) struct Arm {
    servos: Vec<Servo>,
    chain: Chain,
    rests: bool,
}

impl Arm {
    /// Takes over from a configuration. With `is_loaded` the present deflections are kept up; the
    /// joints must then not be accelerating.
    pub(super) fn new(
        blueprint: &Blueprint,
        joints: &[DrivenJoint],
        now: &Configuration,
        is_loaded: bool,
    ) -> Self {
        let chain = Chain::to_hand(&blueprint.scenario, joints);
        let servos = joints.iter().enumerate().filter_map(|(index, joint)| {
            let links = &blueprint.scenario.bodies;
            let link = links.iter().find(|link| link.name == joint.name)?;
            let drive = link.joint.as_ref().filter(|it| it.drive == Drive::Arm)?;
            let (position_rad, velocity_rad_s) =
                (now.positions_rad[index], now.velocities_rad_s[index]);
            let damped = drive.damping_nms_rad * velocity_rad_s / drive.stiffness_nm_rad;
            let lag_rad = position_rad - joint.setpoint.position_rad() + damped;
            Some(Servo {
                joint: index,
                stiffness_nm_rad: drive.stiffness_nm_rad,
                damping_nms_rad: drive.damping_nms_rad,
                torque_limit_nm: drive.effort_limit_nm,
                inertia_kg_m2: inertia_about(blueprint, joints, now, link, is_loaded),
                deflection_rad: if is_loaded { lag_rad } else { 0.0 },
                position_rad,
                velocity_rad_s,
                before: [position_rad, velocity_rad_s],
            })
        });
        Self {
            servos: servos.collect(),
            chain,
            rests: false,
        }
    }

    /// One time step towards the setpoints.
    pub(super) fn step(&mut self, joints: &[DrivenJoint], time_step_secs: f64) {
        let is_still = |servo: &Servo| {
            servo.velocity_rad_s.abs() < RESTS_RAD_S && joints[servo.joint].is_at_target()
        };
        let rested = std::mem::replace(&mut self.rests, self.servos.iter().all(is_still));
        if self.rests && rested {
            return;
        }
        for servo in &mut self.servos {
            servo.before = [servo.position_rad, servo.velocity_rad_s];
            if self.rests {
                servo.velocity_rad_s = 0.0;
                continue;
            }
            let setpoint_rad = joints[servo.joint].setpoint.position_rad();
            let ahead_rad = setpoint_rad + servo.deflection_rad - servo.position_rad;
            let torque_nm = (servo.stiffness_nm_rad * ahead_rad
                - servo.damping_nms_rad * servo.velocity_rad_s)
                .clamp(-servo.torque_limit_nm, servo.torque_limit_nm);
            let inertia = servo.inertia_kg_m2 + time_step_secs * servo.damping_nms_rad;
            servo.velocity_rad_s += time_step_secs * torque_nm / inertia;
            servo.position_rad += time_step_secs * servo.velocity_rad_s;
        }
    }

    /// Whether it does not move.
    pub(super) fn rests(&self) -> bool {
        self.rests
    }

    /// The angle of a joint of the arm.
    pub(super) fn position_rad(&self, joint: usize) -> Option<f64> {
        let servo = self.servos.iter().find(|servo| servo.joint == joint)?;
        Some(servo.position_rad)
    }

    /// Writes the arm's joints into a configuration.
    pub(super) fn get(&self, now: &mut Configuration) {
        for servo in &self.servos {
            now.positions_rad[servo.joint] = servo.position_rad;
            now.velocities_rad_s[servo.joint] = servo.velocity_rad_s;
        }
    }

    /// The hand's frame, as it was before the last step.
    pub(super) fn hand(&self) -> ObjectState {
        self.chain.follow(|joint| {
            let servo = self.servos.iter().find(|servo| servo.joint == joint);
            servo.map_or([0.0; 2], |servo| servo.before)
        })
    }

    /// The hand's frame as it is now.
    pub(super) fn hand_now(&self) -> ObjectState {
        self.chain.follow(|joint| {
            let servo = self.servos.iter().find(|servo| servo.joint == joint);
            servo.map_or([0.0; 2], |servo| [servo.position_rad, servo.velocity_rad_s])
        })
    }
}

/// Slower than this at its setpoint a joint rests.
const RESTS_RAD_S: f64 = 1e-6;

/// A link of a chain: its frame in its parent's, and the axis it turns about, if it turns.
#[derive(Debug, Clone, PartialEq)]
struct ChainLink {
    pose: Pose,
    turns: Option<(usize, Vector)>,
}

/// The links from the world to the hand.
#[derive(Debug, Clone, PartialEq)]
struct Chain(Vec<ChainLink>);

impl Chain {
    fn to_hand(scenario: &Scenario, joints: &[DrivenJoint]) -> Self {
        let mut links = Vec::new();
        let mut name = scenario.robot.hand.as_str();
        while let Some(link) = scenario.bodies.iter().find(|link| link.name == name) {
            let joint = joints.iter().position(|joint| joint.name == link.name);
            links.push(ChainLink {
                pose: frame_in_parent(link),
                turns: joint.zip(link.joint.as_ref().map(|joint| joint.axis)),
            });
            name = &link.parent;
        }
        links.reverse();
        Self(links)
    }

    /// The frame at the chain's end; `state` gives a joint's angle and speed.
    fn follow(&self, state: impl Fn(usize) -> [f64; 2]) -> ObjectState {
        let mut frame = Pose {
            position_m: [0.0; 3],
            orientation: IDENTITY,
        };
        let (mut spin, mut velocity) = ([0.0; 3], [0.0; 3]);
        for link in &self.0 {
            let next = frame.then(&link.pose);
            let lever = subtract(next.position_m, frame.position_m);
            velocity = add(velocity, cross(spin, lever));
            frame = next;
            if let Some((joint, axis)) = link.turns {
                let [angle_rad, speed_rad_s] = state(joint);
                let in_world = rotate(frame.orientation, scale(1.0 / norm(axis), axis));
                spin = add(spin, scale(speed_rad_s, in_world));
                frame.orientation = compose(frame.orientation, about(axis, angle_rad));
            }
        }
        ObjectState {
            pose: frame,
            velocity_m_s: velocity,
            spin_rad_s: spin,
        }
    }
}

/// A link's frame in its parent's, at angle 0.
fn frame_in_parent(link: &Link) -> Pose {
    Pose {
        position_m: link.position_m,
        orientation: compose(
            from_roll_pitch_yaw(link.rotation_rpy_rad),
            about(link.fixed_axis, link.fixed_angle_rad),
        ),
    }
}

/// The moment of inertia about a joint's axis of everything that hangs on it, with the rotor's.
fn inertia_about(
    blueprint: &Blueprint,
    joints: &[DrivenJoint],
    now: &Configuration,
    link: &Link,
    is_loaded: bool,
) -> f64 {
    let Some(joint) = &link.joint else { return 0.0 };
    let scenario = &blueprint.scenario;
    let axis = scale(1.0 / norm(joint.axis), joint.axis);
    let here = Pose {
        position_m: [0.0; 3],
        orientation: IDENTITY,
    };
    let mut total = scenario.robot.joint_armature_kg_m2;
    // The object hangs on the last links; its weight is small against theirs, its place is the
    // hand's.
    let load_kg = f64::from(u8::from(is_loaded)) * blueprint.draws.object_mass_kg;
    let mut open = vec![(link, here)];
    while let Some((link, frame)) = open.pop() {
        let centre = frame.then(&Pose {
            position_m: link.shape_position_m,
            orientation: IDENTITY,
        });
        let moments = crate::model::link_inertia_kg_m2(&blueprint.parameters, link);
        total += link.mass_kg * norm(cross(axis, centre.position_m)).powi(2)
            + about_axis(moments, rotate(inverse(centre.orientation), axis));
        if link.name == scenario.robot.hand {
            total += load_kg * norm(cross(axis, frame.position_m)).powi(2);
        }
        for child in scenario.bodies.iter().filter(|it| it.parent == link.name) {
            let mut pose = frame.then(&frame_in_parent(child));
            let index = joints.iter().position(|joint| joint.name == child.name);
            if let (Some(index), Some(joint)) = (index, &child.joint) {
                let turn = about(joint.axis, now.positions_rad[index]);
                pose.orientation = compose(pose.orientation, turn);
            }
            open.push((child, pose));
        }
    }
    total
}

/// The moment about a unit axis in the frame of the principal moments.
fn about_axis(moments: Vector, axis: Vector) -> f64 {
    dot(moments, [0, 1, 2].map(|i| axis[i] * axis[i]))
}
