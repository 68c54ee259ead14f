//! The robot's body and the object in the physics engine.

use std::collections::BTreeMap;

use super::drives::{Limits, Setpoint};
use super::human::{HAND_ATTITUDE, Wrench};
use crate::geometry::{Pose, Vector};
use crate::model::{self, PhysicalDraws};
use crate::mujoco::{BodyId, Engine, EngineError, GeomId, Simulation};
use crate::robot::{Commands, HandCommand};
use crate::scenario::{Drive, JointAngles, Parameters, Scenario};

/// One joint as the plant drives it.
#[derive(Debug, Clone)]
struct DrivenJoint {
    name: String,
    drive: Drive,
    range_rad: [f64; 2],
    speed_limit_rad_s: f64,
    speed_rad_s: f64,
    setpoint: Setpoint,
    target_rad: f64,
}

/// What touches the object.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Grip {
    /// Contacts between hand and object that carry force.
    pub(crate) contacts: usize,
    /// Sum of their normal forces.
    pub(crate) normal_newtons: f64,
}

/// Position, velocity and spin of the object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ObjectState {
    pub(crate) pose: Pose,
    pub(crate) velocity_m_s: Vector,
    pub(crate) spin_rad_s: Vector,
}

/// The physics of one episode.
pub(crate) struct Plant {
    simulation: Simulation,
    time_step_secs: f64,
    steps: u64,
    joints: Vec<DrivenJoint>,
    finger_joints: Vec<usize>,
    hand_positions: [JointAngles; 3],
    arm: crate::scenario::ArmParameters,
    hand: BodyId,
    object: BodyId,
    object_geom: GeomId,
    skin: Vec<GeomId>,
}

impl Plant {
    /// Builds the model and puts the arm at the neutral pose with the hand open.
    pub(crate) fn new(
        engine: &Engine,
        scenario: &Scenario,
        parameters: &Parameters,
        draws: &PhysicalDraws,
    ) -> Result<Self, EngineError> {
        let simulation = engine.compile(&model::mjcf(scenario, parameters, draws))?;
        let joints = driven_joints(scenario);
        let find_body = |name: &str| {
            let missing = || EngineError::Model {
                reason: format!("it has no body {name}"),
            };
            simulation.body(name).ok_or_else(missing)
        };
        let (hand, object) = (
            find_body(&scenario.robot.hand)?,
            find_body(model::OBJECT_BODY)?,
        );
        let object_geom =
            simulation
                .geom(model::OBJECT_GEOM)
                .ok_or_else(|| EngineError::Model {
                    reason: "the object has no shape".to_owned(),
                })?;
        let skin = scenario
            .bodies
            .iter()
            .filter_map(|body| {
                simulation.geom(&format!("{}{}", model::CONTACT_GEOM_PREFIX, body.name))
            })
            .collect();
        let index = |name: &String| joints.iter().position(|joint| &joint.name == name);
        let finger_joints = scenario.robot.fingers.iter().filter_map(index).collect();
        let positions = &scenario.robot.hand_positions;
        let mut plant = Self {
            simulation,
            time_step_secs: scenario.simulation.time_step_secs,
            steps: 0,
            joints,
            finger_joints,
            hand_positions: [
                positions.open.clone(),
                positions.pregrasp.clone(),
                positions.grasp.clone(),
            ],
            arm: parameters.arm.clone(),
            hand,
            object,
            object_geom,
            skin,
        };
        plant.set_start();
        Ok(plant)
    }

    /// The same plant once more, in exactly the same state.
    pub(crate) fn duplicate(&self) -> Result<Self, EngineError> {
        Ok(Self {
            simulation: self.simulation.duplicate()?,
            joints: self.joints.clone(),
            finger_joints: self.finger_joints.clone(),
            hand_positions: self.hand_positions.clone(),
            arm: self.arm.clone(),
            skin: self.skin.clone(),
            ..*self
        })
    }

    /// Joints start at their setpoints, at rest.
    fn set_start(&mut self) {
        let start: Vec<f64> = self
            .joints
            .iter()
            .map(|joint| joint.setpoint.position_rad())
            .collect();
        self.simulation.positions_mut()[..start.len()].copy_from_slice(&start);
        self.simulation.controls_mut().copy_from_slice(&start);
        self.simulation.forward();
    }

    /// Takes over the robot's commands.
    pub(crate) fn command(&mut self, commands: &Commands) {
        let hand = match commands.hand {
            HandCommand::Open => &self.hand_positions[0],
            HandCommand::Pregrasp => &self.hand_positions[1],
            HandCommand::Grasp => &self.hand_positions[2],
        };
        for joint in &mut self.joints {
            let target = match joint.drive {
                Drive::Arm => {
                    joint.speed_rad_s = if commands.restricted {
                        joint.speed_limit_rad_s.min(self.arm.restricted_speed_rad_s)
                    } else {
                        self.arm.reset_speed_rad_s
                    };
                    // An arm drive refuses to leave its range; a finger is driven on to its stop.
                    let [low, high] = joint.range_rad;
                    commands
                        .arm_target_rad
                        .get(&joint.name)
                        .map(|angle| angle.clamp(low, high))
                }
                Drive::Hand => hand.get(&joint.name).copied(),
            };
            joint.target_rad = target.unwrap_or(joint.target_rad);
        }
    }

    /// Advances drives and physics by one time step under the human's force.
    pub(crate) fn step(&mut self, wrench: &Wrench) {
        for (joint, control) in self.joints.iter_mut().zip(self.simulation.controls_mut()) {
            let limits = Limits {
                speed_rad_s: joint.speed_rad_s,
                acceleration_rad_s2: match joint.drive {
                    Drive::Arm => self.arm.acceleration_rad_s2,
                    Drive::Hand => FINGER_ACCELERATION_RAD_S2,
                },
            };
            joint
                .setpoint
                .advance(joint.target_rad, limits, self.time_step_secs);
            *control = joint.setpoint.position_rad();
        }
        self.simulation
            .set_applied_force(self.object, wrench.force_newtons, wrench.torque_nm);
        self.simulation.step();
        self.steps += 1;
    }

    /// Shows the human's head and hand in the model.
    pub(crate) fn place_human(&mut self, head: &Pose, hand_m: Vector) {
        self.simulation
            .set_mocap(model::HUMAN_HEAD, head.position_m, head.orientation);
        self.simulation
            .set_mocap(model::HUMAN_HAND, hand_m, HAND_ATTITUDE);
    }

    /// Time steps so far.
    pub(crate) fn steps(&self) -> u64 {
        self.steps
    }

    /// Simulated time: steps times the length of a step, free of the sum's rounding.
    pub(crate) fn now_secs(&self) -> f64 {
        self.steps as f64 * self.time_step_secs
    }

    /// Arm encoders, in the order of [`arm_joint_names`].
    pub(crate) fn arm_rad(&self, readings: &mut Vec<f64>) {
        readings.clear();
        let positions = self.simulation.positions();
        let angles = self.joints.iter().zip(positions);
        readings.extend(
            angles
                .filter(|(joint, _)| joint.drive == Drive::Arm)
                .map(|(_, position)| *position),
        );
    }

    /// Finger encoders in counts, in the scenario's order.
    pub(crate) fn finger_counts(&self, counts_per_rad: f64, readings: &mut Vec<i64>) {
        let positions = self.simulation.positions();
        readings.clear();
        readings.extend(
            self.finger_joints
                .iter()
                .map(|index| (positions[*index] * counts_per_rad).round() as i64),
        );
    }

    /// Position (m) and speed vector (m/s) of the hand's frame.
    pub(crate) fn hand(&self) -> (Vector, Vector) {
        (
            self.simulation.body_position(self.hand),
            self.simulation.body_velocity(self.hand).1,
        )
    }

    /// The object.
    pub(crate) fn object(&self) -> ObjectState {
        let (spin_rad_s, velocity_m_s) = self.simulation.body_velocity(self.object);
        ObjectState {
            pose: Pose {
                position_m: self.simulation.body_position(self.object),
                orientation: self.simulation.body_quaternion(self.object),
            },
            velocity_m_s,
            spin_rad_s,
        }
    }

    /// How the hand holds the object.
    pub(crate) fn grip(&self) -> Grip {
        let mut grip = Grip::default();
        for contact in self.simulation.contacts() {
            let [a, b] = contact.geoms;
            let held = (a == self.object_geom && self.skin.contains(&b))
                || (b == self.object_geom && self.skin.contains(&a));
            if held && contact.normal_newtons > 0.0 {
                grip.contacts += 1;
                grip.normal_newtons += contact.normal_newtons;
            }
        }
        grip
    }

    /// Warnings of the physics engine: 0 in a sound run.
    pub(crate) fn warning_count(&self) -> u64 {
        self.simulation.warning_count()
    }
}

/// Fingers speed up at once, as small gear motors do.
const FINGER_ACCELERATION_RAD_S2: f64 = 20.0;

/// The joints in the engine's order, at their starting setpoints.
fn driven_joints(scenario: &Scenario) -> Vec<DrivenJoint> {
    let definitions: BTreeMap<&str, _> = scenario.joints().collect();
    let start = |name: &str| {
        let poses = [
            &scenario.robot.poses.neutral,
            &scenario.robot.hand_positions.open,
        ];
        poses
            .iter()
            .find_map(|pose| pose.get(name))
            .copied()
            .unwrap_or(0.0)
    };
    let order = model::joint_order(scenario);
    let driven = order.into_iter().filter_map(|name| {
        let joint = *definitions.get(name.as_str())?;
        let [low, high] = joint.range_rad;
        let target_rad = start(&name).clamp(low, high);
        Some(DrivenJoint {
            name,
            drive: joint.drive,
            range_rad: joint.range_rad,
            speed_limit_rad_s: joint.speed_limit_rad_s,
            speed_rad_s: joint.speed_limit_rad_s,
            setpoint: Setpoint::at(target_rad),
            target_rad,
        })
    });
    driven.collect()
}

/// Names of the arm joints, in the order of their encoder readings.
pub(crate) fn arm_joint_names(scenario: &Scenario) -> Vec<String> {
    let arm = driven_joints(scenario)
        .into_iter()
        .filter(|joint| joint.drive == Drive::Arm);
    arm.map(|joint| joint.name).collect()
}
