//! The arm by itself, with fingers so heavy that they swing: joints that follow their servos, and where
//! that takes the hand.
//!
//! Definition: angles `q`, speeds `v` and setpoints `u` of the joints obey
//!
//! ```text
//! M(q) v' = K (u - q) - D v - c(q, v) + y     K stiffness, D damping, M inertia,
//!                                             c Coriolis and centrifugal torques (super::coriolis),
//!                                             y dry friction of fingers, and stops (super::yielding)
//! ```
//!
//! with each servo's torque limited to its range. They are integrated as the engine's `implicitfast`
//! does: `y` is found with these accelerations, then semi-implicit Euler with the damping of servos that
//! are not at their limit taken implicitly, `(M + h D) dv = h (...)`, `v += dv`, `q += h v`. `M` is
//! computed by composite bodies (Featherstone, "Rigid Body Dynamics Algorithms", 2008, chapter 6), anew
//! every [`RENEWED_STEPS`] steps.
//!
//! Deviation from the full physics: fingers that do not swing stay where they are and do not push the
//! arm. Cost: some thousand operations a step, three times as many with fingers, nothing at rest.

use testbench::geometry::{cross, dot, subtract};

use super::ObjectState;
use super::body::{Blueprint, Configuration};
use super::branches::Branches;
use super::coriolis::Coriolis;
use super::inertia::{Composite, segments};
use super::joints::DrivenJoint;
use super::tree::{Frames, Tree};
use super::yielding::{Limits, Yielding};
use crate::scenario::Drive;

/// How long one inertia in the world is used: 0.008 s at 2 ms, in which no joint turns by more than
/// 0.004 rad.
const RENEWED_STEPS: u32 = 4;
/// Slower than this, with less torque left than this, the joints of the arm rest.
const RESTS_RAD_S: f64 = 1e-6;
const RESTS_NM: f64 = 5e-3;
/// Slower than this fingers rest whose drives do: dry friction lets them creep.
const FINGER_RESTS_RAD_S: f64 = 1e-4;

/// One joint.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Servo {
    joint: usize,
    drive: Drive,
    stiffness_nm_rad: f64,
    damping_nms_rad: f64,
    torque_limit_nm: f64,
    armature_kg_m2: f64,
    position_rad: f64,
    velocity_rad_s: f64,
    /// Whether its torque is at its limit.
    is_at_limit: bool,
}

/// The arm in motion.
#[derive(Debug, Clone)]
pub(super) struct Arm {
    servos: Vec<Servo>,
    tree: Tree,
    branches: Branches,
    /// What turns with each joint and not with the next, in the frame behind it and in the world.
    segments: Vec<Composite>,
    placed: Vec<Composite>,
    /// Frames of the joints and the hand now, and the hand's before the last step: what is asked of
    /// the engine after a step belongs to the time before it.
    frames: Frames,
    hand_before: ObjectState,
    /// Lower triangle of `M`, by rows, and the factor of `M + h D`.
    inertia: Vec<f64>,
    factor: Vec<f64>,
    factor_age: u32,
    right: Vec<f64>,
    coriolis: Coriolis,
    yielding: Yielding,
    rests: bool,
    is_lost: bool,
}

impl Arm {
    /// Takes over from a configuration; `None` if no joint of the arm carries the hand.
    pub(super) fn new(
        blueprint: &Blueprint,
        joints: &[DrivenJoint],
        now: &Configuration,
        with_fingers: bool,
    ) -> Option<Self> {
        let scenario = &blueprint.scenario;
        let moves = |joint: &DrivenJoint| joint.drive == Drive::Arm || with_fingers;
        let tree = Tree::new(scenario, joints, now, moves)?;
        let servos = tree.nodes.iter();
        let servos: Option<Vec<Servo>> = servos
            .map(|node| servo(blueprint, joints, now, node.joint))
            .collect();
        let servos = servos?;
        let branches = Branches::new(tree.nodes.iter().map(|node| node.parent).collect());
        let count = servos.len();
        let mut arm = Self {
            segments: segments(blueprint, joints, now, &tree),
            inertia: vec![0.0; count * count],
            factor: vec![0.0; count * count],
            factor_age: RENEWED_STEPS,
            placed: Vec::with_capacity(count),
            right: vec![0.0; count],
            coriolis: Coriolis::default(),
            frames: tree.frames(),
            hand_before: now.object,
            yielding: Yielding::new(Vec::new()),
            rests: false,
            is_lost: false,
            branches,
            tree,
            servos,
        };
        arm.yielding = arm.limits(blueprint, joints);
        arm.follow();
        arm.hand_before = arm.frames.hand;
        Some(arm)
    }

    /// Dry friction of fingers, and stops.
    fn limits(&mut self, blueprint: &Blueprint, joints: &[DrivenJoint]) -> Yielding {
        let hand = &blueprint.parameters.hand;
        let count = self.servos.len();
        self.tree.follow_into(|_| (0.0, 0.0), &mut self.frames);
        self.renew_inertia();
        let mut factor = self.inertia.clone();
        self.branches.factorise(&mut factor);
        let limits = |(index, servo): (usize, &Servo)| {
            let mut inverse = vec![0.0; count];
            inverse[index] = 1.0;
            self.branches.solve(&factor, &mut inverse);
            Limits {
                friction_nm: match servo.drive {
                    Drive::Arm => 0.0,
                    Drive::Hand => hand.friction_loss_nm,
                },
                range_rad: joints[servo.joint].range_rad,
                stop_secs: hand.stop_time_constant_secs,
                inverse_inertia: inverse[index],
            }
        };
        Yielding::new(self.servos.iter().enumerate().map(limits).collect())
    }

    /// One time step towards the setpoints.
    pub(super) fn step(&mut self, joints: &[DrivenJoint], step_secs: f64) {
        self.hand_before = self.frames.hand;
        self.torques(joints);
        let is_still = |(servo, torque_nm): (&Servo, &f64)| match servo.drive {
            Drive::Arm => {
                servo.velocity_rad_s.abs() < RESTS_RAD_S
                    && torque_nm.abs() < RESTS_NM
                    && joints[servo.joint].is_at_target()
            }
            Drive::Hand => {
                servo.velocity_rad_s.abs() < FINGER_RESTS_RAD_S && joints[servo.joint].is_at_rest()
            }
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
        self.follow();
    }

    fn follow(&mut self) {
        let servos = &self.servos;
        let state = |index: usize| (servos[index].position_rad, servos[index].velocity_rad_s);
        self.tree.follow_into(state, &mut self.frames);
    }

    /// Writes the joints' torques into the right side.
    fn torques(&mut self, joints: &[DrivenJoint]) {
        for (index, servo) in self.servos.iter_mut().enumerate() {
            let ahead_rad = joints[servo.joint].setpoint.position_rad() - servo.position_rad;
            let wanted_nm =
                servo.stiffness_nm_rad * ahead_rad - servo.damping_nms_rad * servo.velocity_rad_s;
            let torque_nm = wanted_nm.clamp(-servo.torque_limit_nm, servo.torque_limit_nm);
            let is_at_limit = torque_nm != wanted_nm;
            if is_at_limit != servo.is_at_limit {
                servo.is_at_limit = is_at_limit;
                self.factor_age = RENEWED_STEPS;
            }
            self.right[index] = torque_nm;
        }
    }

    fn accelerate(&mut self, step_secs: f64) {
        if self.factor_age >= RENEWED_STEPS {
            self.renew(step_secs);
        }
        self.factor_age += 1;
        let servos = &self.servos;
        let state = |index: usize| (servos[index].position_rad, servos[index].velocity_rad_s);
        self.coriolis.take_off(
            &mut self.right,
            &self.branches,
            &self.frames.axes,
            &self.placed,
            |index| state(index).1,
        );
        let (branches, inertia) = (&self.branches, &self.inertia);
        let found = (self.yielding).push(branches, inertia, state, &mut self.right);
        self.is_lost |= !found;
        self.branches.solve(&self.factor, &mut self.right);
        for (servo, acceleration_rad_s2) in self.servos.iter_mut().zip(&self.right) {
            servo.velocity_rad_s += step_secs * acceleration_rad_s2;
            servo.position_rad += step_secs * servo.velocity_rad_s;
        }
    }

    /// Computes and factors the inertia at the present angles.
    fn renew(&mut self, step_secs: f64) {
        self.renew_inertia();
        self.factor.copy_from_slice(&self.inertia);
        let count = self.servos.len();
        for (joint, servo) in self.servos.iter().enumerate() {
            if !servo.is_at_limit {
                self.factor[joint * count + joint] += step_secs * servo.damping_nms_rad;
            }
        }
        self.branches.factorise(&mut self.factor);
        self.yielding.renew();
        self.factor_age = 0;
    }

    /// Computes the inertia at the frames as they are.
    fn renew_inertia(&mut self) {
        let placed = self.segments.iter().zip(&self.frames.joints);
        self.placed.clear();
        self.placed
            .extend(placed.map(|(segment, frame)| segment.placed(frame)));
        let count = self.servos.len();
        let mut beyond = self.placed.clone();
        for j in (0..count).rev() {
            if let Some(parent) = self.branches.parent(j) {
                let own = beyond[j];
                beyond[parent].add(&own);
            }
            let (at_m, axis) = self.frames.axes[j];
            let (momentum, about_origin) = beyond[j].momenta(axis, cross(at_m, axis));
            let along = |joint: usize| {
                let (at_m, axis) = self.frames.axes[joint];
                dot(axis, subtract(about_origin, cross(at_m, momentum)))
            };
            self.inertia[j * count + j] = along(j) + self.servos[j].armature_kg_m2;
            for i in self.branches.inwards(j) {
                self.inertia[j * count + i] = along(i);
            }
        }
    }

    /// Whether it does not move.
    pub(super) fn rests(&self) -> bool {
        self.rests
    }

    /// Whether the pushes of dry friction and stops were not found.
    pub(super) fn is_lost(&self) -> bool {
        self.is_lost
    }

    /// The joints' tree, and where they are.
    pub(super) fn tree(&self) -> (&Tree, &Frames) {
        (&self.tree, &self.frames)
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
}

fn servo(
    blueprint: &Blueprint,
    joints: &[DrivenJoint],
    now: &Configuration,
    joint: usize,
) -> Option<Servo> {
    let links = &blueprint.scenario.bodies;
    let link = links.iter().find(|link| link.name == joints[joint].name)?;
    let drive = link.joint.as_ref()?;
    let (robot, hand) = (&blueprint.scenario.robot, &blueprint.parameters.hand);
    let is_arm = drive.drive == Drive::Arm;
    let pick = |of_arm: f64, of_hand: f64| if is_arm { of_arm } else { of_hand };
    Some(Servo {
        joint,
        drive: drive.drive,
        stiffness_nm_rad: pick(drive.stiffness_nm_rad, hand.stiffness_nm_rad),
        damping_nms_rad: pick(drive.damping_nms_rad, hand.damping_nms_rad),
        torque_limit_nm: pick(drive.effort_limit_nm, hand.torque_limit_nm),
        armature_kg_m2: pick(robot.joint_armature_kg_m2, robot.finger_armature_kg_m2),
        position_rad: now.positions_rad[joint],
        velocity_rad_s: now.velocities_rad_s[joint],
        is_at_limit: false,
    })
}
