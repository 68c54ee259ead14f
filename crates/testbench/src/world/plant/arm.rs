//! The arm by itself: joints that follow their servos, and where that takes the hand.
//!
//! Definition: angles `q`, speeds `v` and setpoints `u` of the arm's joints obey
//!
//! ```text
//! M(q) v' = K (u - q) - D v - c(q, v)     K stiffness, D damping, M inertia of the arm,
//!                                         c Coriolis and centrifugal torques (super::coriolis)
//! ```
//!
//! with each servo's torque limited to its range. They are integrated as the engine's `implicitfast`
//! does: semi-implicit Euler with the damping taken implicitly, `(M + h D) dv = h (...)`,
//! `v += dv`, `q += h v`. `M` is computed by composite bodies (Featherstone, "Rigid Body Dynamics
//! Algorithms", 2008, chapter 6), anew every [`RENEWED_STEPS`] steps.
//!
//! Deviation from the full physics: fingers do not push the arm. Cost: some thousand operations a
//! step, nothing when the arm rests.

use super::ObjectState;
use super::body::{Blueprint, Configuration};
use super::chain::{Chain, Frames};
use super::coriolis::take_off;
use super::inertia::{Composite, segments};
use super::joints::DrivenJoint;
use crate::geometry::{cross, dot, subtract};
use crate::scenario::Drive;

/// How long one inertia in the world is used: 0.008 s at 2 ms, in which no joint turns by more than
/// 0.004 rad.
const RENEWED_STEPS: u32 = 4;
/// Slower than this, with less torque left than this, the joints rest.
const RESTS_RAD_S: f64 = 1e-6;
const RESTS_NM: f64 = 5e-3;

/// One joint of the arm.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Servo {
    joint: usize,
    stiffness_nm_rad: f64,
    damping_nms_rad: f64,
    torque_limit_nm: f64,
    armature_kg_m2: f64,
    position_rad: f64,
    velocity_rad_s: f64,
}

/// The arm in motion.
#[derive(Debug, Clone)]
pub(super) struct Arm {
    servos: Vec<Servo>,
    chain: Chain,
    /// What turns with each joint and not with the next, in the frame behind it and in the world.
    segments: Vec<Composite>,
    placed: Vec<Composite>,
    /// Frames of the joints and the hand now, and the hand's before the last step: what is asked of
    /// the engine after a step belongs to the time before it.
    frames: Frames,
    hand_before: ObjectState,
    /// Lower triangular factor of `M + h D`, by rows.
    factor: Vec<f64>,
    factor_age: u32,
    right: Vec<f64>,
    rests: bool,
}

impl Arm {
    /// Takes over from a configuration.
    pub(super) fn new(blueprint: &Blueprint, joints: &[DrivenJoint], now: &Configuration) -> Self {
        let chain = Chain::to_hand(&blueprint.scenario, joints);
        let servos: Vec<Servo> = (chain.joints())
            .filter_map(|joint| servo(blueprint, joints, now, joint))
            .collect();
        let frames =
            chain.follow(|index| (servos[index].position_rad, servos[index].velocity_rad_s));
        let segments = segments(blueprint, joints, now);
        Self {
            factor: vec![0.0; servos.len() * servos.len()],
            factor_age: RENEWED_STEPS,
            placed: Vec::with_capacity(servos.len()),
            right: vec![0.0; servos.len()],
            hand_before: frames.hand,
            rests: false,
            frames,
            segments,
            chain,
            servos,
        }
    }

    /// One time step towards the setpoints.
    pub(super) fn step(&mut self, joints: &[DrivenJoint], step_secs: f64) {
        self.hand_before = self.frames.hand;
        self.torques(joints);
        let is_still = |(servo, torque_nm): (&Servo, &f64)| {
            servo.velocity_rad_s.abs() < RESTS_RAD_S
                && torque_nm.abs() < RESTS_NM
                && joints[servo.joint].is_at_target()
        };
        let rested = self.rests;
        self.rests = self.servos.iter().zip(&self.right).all(is_still);
        if self.rests && rested {
            return;
        }
        if self.rests {
            (self.servos.iter_mut()).for_each(|servo| servo.velocity_rad_s = 0.0);
        } else {
            self.accelerate(step_secs);
        }
        let servos = &self.servos;
        let state = |index: usize| (servos[index].position_rad, servos[index].velocity_rad_s);
        self.chain.follow_into(state, &mut self.frames);
    }

    /// Writes the joints' torques into the right side.
    fn torques(&mut self, joints: &[DrivenJoint]) {
        for (index, servo) in self.servos.iter().enumerate() {
            let ahead_rad = joints[servo.joint].setpoint.position_rad() - servo.position_rad;
            let torque_nm = (servo.stiffness_nm_rad * ahead_rad
                - servo.damping_nms_rad * servo.velocity_rad_s)
                .clamp(-servo.torque_limit_nm, servo.torque_limit_nm);
            self.right[index] = torque_nm;
        }
    }

    fn accelerate(&mut self, step_secs: f64) {
        if self.factor_age >= RENEWED_STEPS {
            self.renew(step_secs);
        }
        self.factor_age += 1;
        let servos = &self.servos;
        take_off(&mut self.right, &self.frames.axes, &self.placed, |index| {
            servos[index].velocity_rad_s
        });
        solve(&self.factor, &mut self.right);
        for (servo, acceleration_rad_s2) in self.servos.iter_mut().zip(&self.right) {
            servo.velocity_rad_s += step_secs * acceleration_rad_s2;
            servo.position_rad += step_secs * servo.velocity_rad_s;
        }
    }

    /// Computes and factors the inertia at the present angles.
    fn renew(&mut self, step_secs: f64) {
        let placed = self.segments.iter().zip(&self.frames.joints);
        self.placed.clear();
        self.placed
            .extend(placed.map(|(segment, frame)| segment.placed(frame)));
        let count = self.servos.len();
        let mut beyond = Composite::default();
        for j in (0..count).rev() {
            beyond.add(&self.placed[j]);
            let (at_m, axis) = self.frames.axes[j];
            let (momentum, about_origin) = beyond.momenta(axis, cross(at_m, axis));
            for i in 0..=j {
                let (at_m, axis) = self.frames.axes[i];
                let inertia = dot(axis, subtract(about_origin, cross(at_m, momentum)));
                self.factor[j * count + i] = inertia;
            }
            let servo = &self.servos[j];
            self.factor[j * count + j] += servo.armature_kg_m2 + step_secs * servo.damping_nms_rad;
        }
        factorise(&mut self.factor, count);
        self.factor_age = 0;
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

    /// The hand's frame as it was before the last step.
    pub(super) fn hand_before(&self) -> ObjectState {
        self.hand_before
    }

    /// The hand's frame as it is now.
    pub(super) fn hand(&self) -> ObjectState {
        self.frames.hand
    }
}

fn servo(
    blueprint: &Blueprint,
    joints: &[DrivenJoint],
    now: &Configuration,
    joint: usize,
) -> Option<Servo> {
    let links = &blueprint.scenario.bodies;
    let link = links.iter().find(|link| link.name == joints[joint].name)?;
    let drive = link.joint.as_ref().filter(|it| it.drive == Drive::Arm)?;
    Some(Servo {
        joint,
        stiffness_nm_rad: drive.stiffness_nm_rad,
        damping_nms_rad: drive.damping_nms_rad,
        torque_limit_nm: drive.effort_limit_nm,
        armature_kg_m2: blueprint.scenario.robot.joint_armature_kg_m2,
        position_rad: now.positions_rad[joint],
        velocity_rad_s: now.velocities_rad_s[joint],
    })
}

/// Replaces the lower triangle of a symmetric positive definite matrix by its Cholesky factor.
fn factorise(matrix: &mut [f64], count: usize) {
    for row in 0..count {
        for column in 0..=row {
            let inner: f64 = (0..column)
                .map(|k| matrix[row * count + k] * matrix[column * count + k])
                .sum();
            let rest = matrix[row * count + column] - inner;
            matrix[row * count + column] = if row == column {
                rest.sqrt()
            } else {
                rest / matrix[column * count + column]
            };
        }
    }
}

/// Solves with a Cholesky factor, in place.
fn solve(factor: &[f64], right: &mut [f64]) {
    let count = right.len();
    for row in 0..count {
        let inner: f64 = (0..row).map(|k| factor[row * count + k] * right[k]).sum();
        right[row] = (right[row] - inner) / factor[row * count + row];
    }
    for row in (0..count).rev() {
        let inner: f64 = (row + 1..count)
            .map(|k| factor[k * count + row] * right[k])
            .sum();
        right[row] = (right[row] - inner) / factor[row * count + row];
    }
}
