//! The empty hand on its way, while the object rests elsewhere.
//!
//! Where hand and object are apart and the object rests, nothing acts between them: the object stays
//! where it is, the fingers stay where they are told to be, or swing if they are so heavy for their dry
//! friction, and the arm follows its servos ([`super::arm`]), until hand and object come within reach of
//! each other ([`super::clearance`]) or the fingers are told to move.
//!
//! Cost and deviation from the full physics: those of the arm, and what is left of the settling of the
//! object, and of fingers that do not swing, when it begins (slower than the limits below).

use testbench::geometry::norm;

use super::arm::Arm;
use super::body::{Blueprint, Body, Configuration};
use super::clearance::Clearance;
use super::joints::{DrivenJoint, fingers};
use super::{Grip, ObjectState};

/// Nearer than this the fingers of an empty hand stay where they are: speed times their servos' time
/// constant. It is a third of what dry friction lets them rest away from where they were sent.
const FINGERS_REST_RAD: f64 = 4e-3;
/// Slower than this an object that nothing holds rests.
const RESTS_M_S: f64 = 1e-4;
const RESTS_RAD_S: f64 = 1e-3;

/// The empty hand on its way.
#[derive(Debug, Clone)]
pub(super) struct Apart {
    arm: Arm,
    /// Whether the fingers' drives rest, where it matters.
    fingers_rest: Option<bool>,
    began: Configuration,
    clearance: Clearance,
}

impl Apart {
    /// Begins from the state `now` of `body`, if the hand is empty and all but the arm rests; whether
    /// they are apart says [`Self::may_go_on`].
    pub(super) fn begin(
        blueprint: &Blueprint,
        joints: &[DrivenJoint],
        body: &Body,
        now: &Configuration,
        fingers_swing: bool,
    ) -> Option<Self> {
        let object = &now.object;
        let servo = &blueprint.parameters.hand;
        let constant_secs = servo.damping_nms_rad / servo.stiffness_nm_rad;
        let has_come =
            |index: usize| now.velocities_rad_s[index].abs() * constant_secs < FINGERS_REST_RAD;
        let with_fingers = fingers_swing || !fingers_rest(joints);
        let rests = (with_fingers || fingers(joints).all(has_come))
            && norm(object.velocity_m_s) < RESTS_M_S
            && norm(object.spin_rad_s) < RESTS_RAD_S
            && body.grip() == Grip::default();
        if !rests {
            return None;
        }
        let arm = Arm::new(blueprint, joints, now, with_fingers)?;
        let clearance = Clearance::of(blueprint, joints, now, arm.tree().0);
        Some(Self {
            arm,
            fingers_rest: (!fingers_swing).then_some(!with_fingers),
            began: now.clone(),
            clearance,
        })
    }

    /// Whether the next step may be taken, given whether the drives are about to change their speed.
    pub(super) fn may_go_on(&self, joints: &[DrivenJoint], arm_accelerates: bool) -> bool {
        (self.fingers_rest).is_none_or(|rest| rest == fingers_rest(joints))
            && !self.arm.is_lost()
            && (self.arm.rests() && !arm_accelerates || self.clearance.is_clear(self.arm.tree().1))
    }

    /// One time step.
    pub(super) fn step(&mut self, joints: &[DrivenJoint], time_step_secs: f64) {
        self.arm.step(joints, time_step_secs);
    }

    /// The angle of a joint.
    pub(super) fn position_rad(&self, joint: usize) -> f64 {
        let fixed = || self.began.positions_rad[joint];
        self.arm.position_rad(joint).unwrap_or_else(fixed)
    }

    /// The hand's frame, as it was before the last step.
    pub(super) fn hand(&self) -> ObjectState {
        self.arm.hand_before()
    }

    /// The object.
    pub(super) fn object(&self) -> ObjectState {
        self.began.object
    }

    /// The whole configuration as it is now.
    pub(super) fn configuration(&self) -> Configuration {
        let mut now = self.began.clone();
        now.velocities_rad_s.fill(0.0);
        self.arm.get(&mut now);
        now
    }
}

fn fingers_rest(joints: &[DrivenJoint]) -> bool {
    fingers(joints).all(|index| joints[index].is_at_rest())
}
