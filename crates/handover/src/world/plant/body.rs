//! The physics of the whole model or of a part of it, in MuJoCo.

use testbench::geometry::{Pose, Quaternion, Vector, inverse, rotate};
use testbench::{BodyId, Engine, EngineError, GeomId, Simulation};

use super::joints::DrivenJoint;
use super::{Grip, ObjectState};
use crate::model::{self, Part, PhysicalDraws};
use crate::physics::Physics;
use crate::scenario::{Parameters, Scenario};

/// What every part of the model is written from.
#[derive(Debug)]
pub(super) struct Blueprint {
    pub(super) physics: Physics,
    pub(super) scenario: Scenario,
    pub(super) parameters: Parameters,
    pub(super) draws: PhysicalDraws,
}

/// Where everything is and how it moves.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Configuration {
    pub(super) positions_rad: Vec<f64>,
    pub(super) velocities_rad_s: Vec<f64>,
    pub(super) object: ObjectState,
}

/// A model, or a part of one, in the physics engine.
pub(super) struct Body {
    simulation: Simulation,
    /// For each joint of the whole model its place in this one, if it moves here.
    places: Vec<Option<usize>>,
    hand: BodyId,
    object: BodyId,
    /// The object's weight, where the model leaves it to the caller.
    weight_newtons: f64,
    object_geom: Option<GeomId>,
    skin: Vec<GeomId>,
}

impl Body {
    /// Builds a part of the model.
    pub(super) fn new(
        engine: &Engine,
        blueprint: &Blueprint,
        joints: &[DrivenJoint],
        part: Part,
    ) -> Result<Self, EngineError> {
        let Blueprint {
            scenario,
            parameters,
            draws,
            ..
        } = blueprint;
        let text = model::mjcf_of_part(scenario, parameters, draws, &part);
        let simulation = engine.compile(&text)?;
        let places: Vec<_> = (0..joints.len()).map(Some).collect();
        let find = |name: &str| {
            let missing = || EngineError::Model {
                reason: format!("it has no body {name}"),
            };
            simulation.body(name).ok_or_else(missing)
        };
        let skin = scenario.bodies.iter().filter_map(|body| {
            simulation.geom(&format!("{}{}", model::CONTACT_GEOM_PREFIX, body.name))
        });
        Ok(Self {
            skin: skin.collect(),
            hand: find(&scenario.robot.hand)?,
            object: find(model::OBJECT_BODY)?,
            weight_newtons: if part.is_weightless(scenario) {
                draws.object_mass_kg * scenario.simulation.gravity_m_s2
            } else {
                0.0
            },
            object_geom: simulation.geom(model::OBJECT_GEOM),
            places,
            simulation,
        })
    }

    /// The same once more, in exactly the same state.
    pub(super) fn duplicate(&self) -> Result<Self, EngineError> {
        Ok(Self {
            simulation: self.simulation.duplicate()?,
            places: self.places.clone(),
            skin: self.skin.clone(),
            ..*self
        })
    }

    /// Advances by one time step towards the joints' setpoints, with a force (N) and a torque (N m)
    /// on the object.
    pub(super) fn step(&mut self, joints: &[DrivenJoint], force: Vector, torque: Vector) {
        self.set_controls(joints);
        let [x, y, z] = force;
        let force = [x, y, z - self.weight_newtons];
        self.simulation
            .set_applied_force(self.object, force, torque);
        self.simulation.step();
    }

    /// Turns the object's acceleration from which the solver starts the next step: that of a motion
    /// which has gone on elsewhere.
    pub(super) fn turn_start(&mut self, turned: Quaternion) {
        let joints = self.places.len();
        let start = self.simulation.warm_start_mut();
        if let Some(linear) = start.get_mut(joints..joints + 3) {
            let now = rotate(turned, [linear[0], linear[1], linear[2]]);
            linear.copy_from_slice(&now);
        }
    }

    /// Sends the joints to their setpoints.
    pub(super) fn set_controls(&mut self, joints: &[DrivenJoint]) {
        let controls = self.simulation.controls_mut();
        for (joint, place) in joints.iter().zip(&self.places) {
            if let Some(place) = *place {
                controls[place] = joint.setpoint.position_rad();
            }
        }
    }

    /// Recomputes what follows from the present configuration.
    pub(super) fn forward(&mut self) {
        self.simulation.forward();
    }

    /// Takes over a configuration, as far as its parts move here.
    pub(super) fn set(&mut self, now: &Configuration) {
        let positions = self.simulation.positions_mut();
        let mut joints = 0;
        for (place, position) in self.places.iter().zip(&now.positions_rad) {
            if let Some(place) = *place {
                positions[place] = *position;
                joints = joints.max(place + 1);
            }
        }
        let Pose {
            position_m,
            orientation,
        } = now.object.pose;
        positions[joints..joints + 3].copy_from_slice(&position_m);
        positions[joints + 3..joints + 7].copy_from_slice(&orientation);
        let velocities = self.simulation.velocities_mut();
        for (place, velocity) in self.places.iter().zip(&now.velocities_rad_s) {
            if let Some(place) = *place {
                velocities[place] = *velocity;
            }
        }
        // Of a free joint the engine wants the spin in the body's frame.
        let spin = rotate(inverse(orientation), now.object.spin_rad_s);
        velocities[joints..joints + 3].copy_from_slice(&now.object.velocity_m_s);
        velocities[joints + 3..joints + 6].copy_from_slice(&spin);
    }

    /// The object as it is now; [`Self::object`] is as it was before the last step.
    pub(super) fn object_now(&self) -> ObjectState {
        let moving = self.places.iter().flatten().count();
        object_at(&self.simulation, moving)
    }

    /// Writes what moves here into a configuration.
    pub(super) fn get(&self, now: &mut Configuration) {
        let (positions, velocities) = (self.simulation.positions(), self.simulation.velocities());
        for (joint, place) in self.places.iter().enumerate() {
            if let Some(place) = *place {
                now.positions_rad[joint] = positions[place];
                now.velocities_rad_s[joint] = velocities[place];
            }
        }
        now.object = self.object_now();
    }

    /// The angle of a joint that moves here.
    pub(super) fn position_rad(&self, joint: usize) -> Option<f64> {
        let place = (*self.places.get(joint)?)?;
        self.simulation.positions().get(place).copied()
    }

    /// The hand's frame.
    pub(super) fn hand(&self) -> ObjectState {
        self.moving(self.hand)
    }

    /// The object.
    pub(super) fn object(&self) -> ObjectState {
        self.moving(self.object)
    }

    fn moving(&self, body: BodyId) -> ObjectState {
        let (spin_rad_s, velocity_m_s) = self.simulation.body_velocity(body);
        ObjectState {
            pose: Pose {
                position_m: self.simulation.body_position(body),
                orientation: self.simulation.body_quaternion(body),
            },
            velocity_m_s,
            spin_rad_s,
        }
    }

    /// How the hand holds the object.
    pub(super) fn grip(&self) -> Grip {
        let mut grip = Grip::default();
        let Some(object_geom) = self.object_geom else {
            return grip;
        };
        for contact in self.simulation.contacts() {
            let [a, b] = contact.geoms;
            let held = (a == object_geom && self.skin.contains(&b))
                || (b == object_geom && self.skin.contains(&a));
            if held && contact.normal_newtons > 0.0 {
                grip.contacts += 1;
                grip.normal_newtons += contact.normal_newtons;
            }
        }
        grip
    }

    /// The contacts of the grip.
    #[cfg(test)]
    pub(super) fn grip_contacts(&self) -> Vec<super::GripContact> {
        let contacts = self.simulation.contacts();
        let of_object = contacts.filter_map(|contact| {
            let [a, b] = contact.geoms;
            let sign = match self.object_geom {
                Some(object) if a == object && self.skin.contains(&b) => -1.0,
                Some(object) if b == object && self.skin.contains(&a) => 1.0,
                _ => return None,
            };
            Some(super::GripContact {
                normal_newtons: contact.normal_newtons,
                friction_newtons: contact.tangential_newtons,
                pushes: contact.normal.map(|along| sign * along),
            })
        });
        of_object.collect()
    }

    /// Appends what the last step was given: setpoints, then force and torque on the object.
    pub(super) fn inputs(&self, inputs: &mut Vec<f64>) {
        inputs.extend(self.simulation.controls());
        inputs.extend(self.simulation.applied_force(self.object));
    }

    /// Steps with inputs as [`Self::inputs`] gives them, and nothing else; their number.
    pub(super) fn steps_with(&mut self, inputs: &[f64]) -> u64 {
        let setpoints = self.simulation.controls().len();
        let mut steps = 0;
        for input in inputs.chunks_exact(setpoints + 6) {
            let (controls, wrench) = input.split_at(setpoints);
            self.simulation.controls_mut().copy_from_slice(controls);
            let three = |at: usize| std::array::from_fn(|axis| wrench[at + axis]);
            self.simulation
                .set_applied_force(self.object, three(0), three(3));
            self.simulation.step();
            steps += 1;
        }
        steps
    }

    /// Positions and velocities, bit for bit.
    pub(super) fn bits(&self) -> Vec<u64> {
        let (positions, velocities) = (self.simulation.positions(), self.simulation.velocities());
        let numbers = positions.iter().chain(velocities);
        numbers.map(|number| number.to_bits()).collect()
    }

    /// Warnings of the physics engine: 0 in a sound run.
    pub(super) fn warning_count(&self) -> u64 {
        self.simulation.warning_count()
    }
}

/// The object, whose free joint comes after `joints` others.
fn object_at(simulation: &Simulation, joints: usize) -> ObjectState {
    let (positions, velocities) = (simulation.positions(), simulation.velocities());
    let three = |numbers: &[f64], at: usize| std::array::from_fn(|i| numbers[at + i]);
    let orientation = std::array::from_fn(|i| positions[joints + 3 + i]);
    ObjectState {
        pose: Pose {
            position_m: three(positions, joints),
            orientation,
        },
        velocity_m_s: three(velocities, joints),
        spin_rad_s: rotate(orientation, three(velocities, joints + 3)),
    }
}
