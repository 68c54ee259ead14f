//! The whole model in either engine. What only short cuts ask for is asked of MuJoCo's ([`Body`]) itself, which alone has them.

use testbench::geometry::Vector;
use testbench::{EngineError, SimError};

use super::body::{Blueprint, Body, Configuration};
use super::joints::DrivenJoint;
use super::rapier::RapierBody;
use super::{Grip, ObjectState};
use crate::model::Part;
use crate::physics::Physics;

/// The whole model.
pub(super) enum Whole {
    Mujoco(Body),
    Rapier(Box<RapierBody>),
}

/// The same question to either engine.
macro_rules! of_engine {
    ($whole:expr, $body:ident => $asked:expr) => {
        match $whole {
            Whole::Mujoco($body) => $asked,
            Whole::Rapier($body) => $asked,
        }
    };
}

impl Whole {
    /// Builds the model. `part` says how it is written for MuJoCo.
    pub(super) fn new(
        blueprint: &Blueprint,
        joints: &[DrivenJoint],
        part: Part,
    ) -> Result<Self, SimError> {
        Ok(match &blueprint.physics {
            Physics::Mujoco(engine) => Self::Mujoco(Body::new(engine, blueprint, joints, part)?),
            Physics::Rapier if part.is_lean => {
                return Err(SimError::Engine(EngineError::Model {
                    reason: "the fast physics stands in for MuJoCo's alone, and Rapier has none: leave `simulation.fast` out"
                        .to_owned(),
                }));
            }
            Physics::Rapier => Self::Rapier(Box::new(RapierBody::new(blueprint)?)),
        })
    }

    /// The same once more, in exactly the same state.
    pub(super) fn duplicate(&self) -> Result<Self, SimError> {
        Ok(match self {
            Self::Mujoco(body) => Self::Mujoco(body.duplicate()?),
            Self::Rapier(body) => Self::Rapier(Box::new(body.duplicate()?)),
        })
    }

    /// Begins from a configuration at rest, in which the object stands where the model has it.
    pub(super) fn start(&mut self, now: &Configuration, joints: &[DrivenJoint]) {
        match self {
            Self::Mujoco(body) => {
                body.set(now);
                body.set_controls(joints);
                body.forward();
            }
            Self::Rapier(body) => body.start(now, joints),
        }
    }

    /// Advances by one time step towards the joints' setpoints, with a force (N) and a torque (N m)
    /// on the object.
    pub(super) fn step(&mut self, joints: &[DrivenJoint], force: Vector, torque: Vector) {
        of_engine!(self, body => body.step(joints, force, torque));
    }

    /// The angle of a joint that moves here.
    pub(super) fn position_rad(&self, joint: usize) -> Option<f64> {
        match self {
            Self::Mujoco(body) => body.position_rad(joint),
            Self::Rapier(body) => Some(body.position_rad(joint)),
        }
    }

    /// The hand's frame, before the last step.
    pub(super) fn hand(&self) -> ObjectState {
        of_engine!(self, body => body.hand())
    }

    /// The object, before the last step.
    pub(super) fn object(&self) -> ObjectState {
        of_engine!(self, body => body.object())
    }

    /// How the hand held the object in the last step.
    pub(super) fn grip(&self) -> Grip {
        of_engine!(self, body => body.grip())
    }

    /// The contacts of the grip.
    #[cfg(test)]
    pub(super) fn grip_contacts(&self) -> Vec<super::GripContact> {
        of_engine!(self, body => body.grip_contacts())
    }

    /// Appends what the last step was given: setpoints, then force and torque on the object.
    pub(super) fn inputs(&self, inputs: &mut Vec<f64>) {
        of_engine!(self, body => body.inputs(inputs));
    }

    /// Steps with inputs as [`Self::inputs`] gives them, and nothing else; their number.
    pub(super) fn steps_with(&mut self, inputs: &[f64]) -> u64 {
        of_engine!(self, body => body.steps_with(inputs))
    }

    /// Positions and velocities, bit for bit.
    pub(super) fn bits(&self) -> Vec<u64> {
        of_engine!(self, body => body.bits())
    }

    /// Warnings of the physics engine: 0 in a sound run.
    pub(super) fn warning_count(&self) -> u64 {
        of_engine!(self, body => body.warning_count())
    }
}
