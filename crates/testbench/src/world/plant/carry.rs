//! The hand with the object aloft: fingers and object in the hand's frame, the arm by itself.
//!
//! While the object is clear of its supports nothing but the hand touches it. Fingers, object and
//! their contacts are then integrated by the physics engine in the hand's frame, with what follows
//! from the frame's motion ([`super::moving_frame`]), and the arm by itself ([`super::arm`]) under
//! the object's weight, inertia and pull. So 16 instead of 22 velocities are coupled by the contacts,
//! which is what a step's time goes with.
//!
//! Where the arm rests, nobody pulls, no finger is told to move or being read, and object and fingers
//! hardly move against the hand, they sleep: their state stays as it is until one of these changes.
//!
//! Deviation from the full physics: the arm bears the object's load as if it were fixed to the hand,
//! so slipping does not shake the arm, nor do the fingers' own movements; one step's delay. At
//! 8500 N m/rad and 0.8 m a newton moves the hand by less than 0.1 mm.

use super::ObjectState;
use super::arm::{Arm, Load};
use super::body::{Blueprint, Body, Configuration};
use super::clearance::clear_of_supports;
use super::joints::DrivenJoint;
use super::moving_frame::FrameMotion;
use crate::geometry::{Vector, add, cross, inverse, rotate, subtract};
use crate::model::object_inertia_kg_m2;
use crate::world::human::Wrench;

/// The object is aloft from so far above its supports, and is so until it is closer than half of that.
const ALOFT_M: f64 = 0.004;

/// Slower than this against the hand, at the ends of two windows, object and fingers sleep. They
/// creep at some 5 to 20 micrometres and 0.4 mrad a second; in the 5 s for which the handover waits
/// what is left out is less than 0.25 mm and 2.5 mrad.
const SLEEPS_M_S: f64 = 5e-5;
const SLEEPS_RAD_S: f64 = 5e-4;
const WINDOW_STEPS: u32 = 20;

/// The hand with the object.
pub(super) struct Carry {
    body: Body,
    arm: Arm,
    mass_kg: f64,
    moments_kg_m2: Vector,
    weight_newtons: f64,
    arm_moved: bool,
    /// Steps since something happened, and since then without movement.
    quiet_steps: u32,
    sleeps: bool,
}

impl Carry {
    /// Whether the object is so far from its supports that it can be carried.
    pub(super) fn can_begin(blueprint: &Blueprint, object: &ObjectState) -> bool {
        clear_of_supports(&blueprint.scenario, &object.pose, ALOFT_M)
    }

    /// Goes on from a configuration; `body` is the hand's part of the model.
    pub(super) fn begin(
        blueprint: &Blueprint,
        joints: &[DrivenJoint],
        mut body: Body,
        now: &Configuration,
        is_held: bool,
    ) -> Self {
        let mass_kg = blueprint.draws.object_mass_kg;
        let arm = Arm::new(blueprint, joints, now, is_held.then_some(mass_kg));
        let mut inner = now.clone();
        inner.object = now.object.seen_from(&arm.hand());
        body.set(&inner);
        Self {
            arm,
            body,
            mass_kg,
            moments_kg_m2: object_inertia_kg_m2(
                &blueprint.scenario,
                &blueprint.parameters,
                mass_kg,
            ),
            weight_newtons: mass_kg * blueprint.scenario.simulation.gravity_m_s2,
            arm_moved: true,
            quiet_steps: 0,
            sleeps: false,
        }
    }

    /// The same once more, in exactly the same state.
    pub(super) fn duplicate(&self) -> Result<Self, crate::mujoco::EngineError> {
        Ok(Self {
            body: self.body.duplicate()?,
            arm: self.arm.clone(),
            ..*self
        })
    }

    /// Whether the object is still clear of its supports.
    pub(super) fn may_go_on(&self, blueprint: &Blueprint) -> bool {
        clear_of_supports(&blueprint.scenario, &self.object().pose, ALOFT_M / 2.0)
    }

    /// One time step under a wrench (world frame, about the object's centre). Where `is_watched`
    /// small movements of the fingers matter.
    pub(super) fn step(
        &mut self,
        joints: &[DrivenJoint],
        wrench: &Wrench,
        is_watched: bool,
        step_secs: f64,
    ) {
        let is_quiet = !is_watched
            && *wrench == Wrench::default()
            && self.arm.rests()
            && joints.iter().all(DrivenJoint::is_at_rest);
        if !self.falls_asleep(is_quiet) {
            self.integrate(joints, wrench, step_secs);
        }
    }

    /// Whether nothing moves any more. What sleeps stays exactly as it is, speeds included, until
    /// something happens.
    fn falls_asleep(&mut self, is_quiet: bool) -> bool {
        if !is_quiet {
            self.quiet_steps = 0;
            self.sleeps = false;
        } else if !self.sleeps {
            self.quiet_steps += 1;
            if self.quiet_steps.is_multiple_of(WINDOW_STEPS)
                && self.body.moves(SLEEPS_M_S, SLEEPS_RAD_S)
            {
                self.quiet_steps = 0;
            }
            self.sleeps = self.quiet_steps > 2 * WINDOW_STEPS;
        }
        self.sleeps
    }

    fn integrate(&mut self, joints: &[DrivenJoint], wrench: &Wrench, step_secs: f64) {
        let hand = self.arm.hand();
        let inner = self.body.object_now();
        let weight = [0.0, 0.0, -self.weight_newtons];
        let force = add(wrench.force_newtons, weight);
        let load = (self.body.contact_count() > 0).then(|| Load {
            at_m: hand.pose.then(&inner.pose).position_m,
            force_newtons: force,
            torque_nm: wrench.torque_nm,
        });
        self.arm.step(joints, load.as_ref(), step_secs);
        let own = |vector| rotate(inverse(hand.pose.orientation), vector);
        let mut force = own(force);
        let mut torque = own(wrench.torque_nm);
        if !self.arm.rests() {
            let motion = FrameMotion::between(&hand, &self.arm.hand(), step_secs);
            let acts = motion.acts_on(self.mass_kg, self.moments_kg_m2, &inner);
            force = add(force, acts[0]);
            torque = add(torque, acts[1]);
            self.body.move_frame(Some(&motion));
        } else if self.arm_moved {
            self.body.move_frame(None);
        }
        self.arm_moved = !self.arm.rests();
        self.body.set_looks_ahead(self.arm_moved);
        self.body.step(joints, force, torque);
    }

    /// The angle of a joint.
    pub(super) fn position_rad(&self, joint: usize) -> Option<f64> {
        let of_arm = self.arm.position_rad(joint);
        of_arm.or_else(|| self.body.position_rad(joint))
    }

    /// The hand's frame, as it was before the last step.
    pub(super) fn hand(&self) -> ObjectState {
        self.arm.hand_before()
    }

    /// The object, as it was before the last step.
    pub(super) fn object(&self) -> ObjectState {
        self.body.object().carried_by(&self.arm.hand_before())
    }

    /// The hand's part of the model.
    pub(super) fn body(&self) -> &Body {
        &self.body
    }

    /// Ends it: the whole configuration as it is now, and the hand's part of the model.
    pub(super) fn end(self, joints: usize) -> (Configuration, Body) {
        let mut now = Configuration {
            positions_rad: vec![0.0; joints],
            velocities_rad_s: vec![0.0; joints],
            object: self.body.object_now(),
        };
        self.body.get(&mut now);
        self.arm.get(&mut now);
        now.object = now.object.carried_by(&self.arm.hand());
        (now, self.body)
    }
}

impl ObjectState {
    /// Something that stands still.
    pub(super) fn at_rest(pose: crate::geometry::Pose) -> Self {
        Self {
            pose,
            velocity_m_s: [0.0; 3],
            spin_rad_s: [0.0; 3],
        }
    }

    /// The motion in the world of what moves so in a frame that moves itself.
    pub(super) fn carried_by(&self, frame: &Self) -> Self {
        let out = |vector| rotate(frame.pose.orientation, vector);
        let lever = out(self.pose.position_m);
        let with_frame = add(frame.velocity_m_s, cross(frame.spin_rad_s, lever));
        Self {
            pose: frame.pose.then(&self.pose),
            velocity_m_s: add(with_frame, out(self.velocity_m_s)),
            spin_rad_s: add(frame.spin_rad_s, out(self.spin_rad_s)),
        }
    }

    /// The motion in a frame that moves itself of what moves so in the world.
    pub(super) fn seen_from(&self, frame: &Self) -> Self {
        let own = |vector| rotate(inverse(frame.pose.orientation), vector);
        let lever = subtract(self.pose.position_m, frame.pose.position_m);
        let with_frame = add(frame.velocity_m_s, cross(frame.spin_rad_s, lever));
        Self {
            pose: self.pose.seen_from(&frame.pose),
            velocity_m_s: own(subtract(self.velocity_m_s, with_frame)),
            spin_rad_s: own(subtract(self.spin_rad_s, frame.spin_rad_s)),
        }
    }
}
