//! The robot's body and the object in the physics engine.
//!
//! The whole model is the reference, in MuJoCo or in Rapier. In MuJoCo, with `simulation.fast`, less than that stands in for it: the arm
//! alone while hand and object are [`apart`], and [`glide`]s between bursts of the whole model while
//! the motion is steady ([`Plant::may_glide`] says where contacts allow for them).

mod apart;
mod approach;
mod arm;
mod body;
mod branches;
mod chain;
mod clearance;
mod coriolis;
mod glide;
mod inertia;
mod joints;
mod rapier;
mod seen;
mod swing;
mod tree;
mod whole;

#[cfg(test)]
mod tests;
mod yielding;

use std::sync::Arc;

use super::human::Wrench;
use crate::model::{self, Contacts, Part, PhysicalDraws};
use crate::physics::Physics;
use crate::robot::Commands;
use crate::scenario::{Drive, Parameters, Scenario};

use apart::Apart;
use body::{Blueprint, Body, Configuration};
use glide::Glide;
use joints::{DrivenJoint, driven_joints};
use testbench::SimError;
use testbench::geometry::{Pose, Vector};
use whole::Whole;

pub(crate) use joints::arm_joint_names;

/// What touches the object.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Grip {
    /// Contacts between hand and object that carry force.
    pub(crate) contacts: usize,
    /// Sum of their normal forces.
    pub(crate) normal_newtons: f64,
}

/// A contact between hand and object.
#[cfg(test)]
#[derive(Debug, Clone, Copy)]
pub(crate) struct GripContact {
    pub(crate) normal_newtons: f64,
    pub(crate) friction_newtons: f64,
    /// Unit vector along which it pushes the object, in the world.
    pub(crate) pushes: Vector,
}

/// Position, velocity and spin of the object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ObjectState {
    pub(crate) pose: Pose,
    pub(crate) velocity_m_s: Vector,
    pub(crate) spin_rad_s: Vector,
}

/// What is integrated.
enum Regime {
    /// The whole model.
    Whole,
    /// The empty hand on its way, the object at rest.
    Apart(Box<Apart>),
}

/// How often it is asked whether less than the whole model will do.
const LOOK_SECS: f64 = 0.04;

/// The physics of one episode.
pub(crate) struct Plant {
    blueprint: Arc<Blueprint>,
    is_fast: bool,
    /// Whether the fingers swing when the arm speeds up.
    fingers_swing: bool,
    /// How long that takes to fade, and the steps since a pull last bent fingers that held the object.
    fade_steps: u64,
    unbent_steps: u64,
    steps: u64,
    look_steps: u64,
    joints: Vec<DrivenJoint>,
    finger_joints: Vec<usize>,
    regime: Regime,
    whole: Whole,
    /// Steady motion of the whole model.
    glide: Glide,
    /// Whether the hand held the object after the last step of the whole model.
    is_held: bool,
    in_regime_steps: u64,
    /// Whether a drive of the arm changed its speed in the last step.
    arm_accelerates: bool,
}

impl Plant {
    /// Builds the model and puts the arm at the neutral pose with the hand open.
    pub(crate) fn new(
        physics: &Physics,
        scenario: &Scenario,
        parameters: &Parameters,
        draws: &PhysicalDraws,
        contacts: Contacts,
    ) -> Result<Self, SimError> {
        let joints = driven_joints(scenario, &parameters.arm);
        let blueprint = Blueprint {
            physics: physics.clone(),
            scenario: scenario.clone(),
            parameters: parameters.clone(),
            draws: *draws,
        };
        let is_fast = scenario.simulation.fast && model::hand_is_separable(scenario);
        let fingers_swing = swing::fingers_swing(&blueprint, &joints);
        let part = Part {
            is_lean: is_fast,
            contacts,
            is_without_human: true,
        };
        let whole = Whole::new(&blueprint, &joints, part)?;
        let index = |name: &String| joints.iter().position(|joint| &joint.name == name);
        let step_secs = scenario.simulation.time_step_secs;
        let mut plant = Self {
            is_fast,
            fingers_swing,
            fade_steps: (swing::fades_secs(&blueprint, &joints) / step_secs).ceil() as u64,
            unbent_steps: u64::MAX,
            steps: 0,
            look_steps: (LOOK_SECS / step_secs).round().max(1.0) as u64,
            finger_joints: scenario.robot.fingers.iter().filter_map(index).collect(),
            regime: Regime::Whole,
            whole,
            glide: Glide::new(&blueprint, &joints, fingers_swing),
            is_held: false,
            in_regime_steps: 0,
            arm_accelerates: false,
            joints,
            blueprint: Arc::new(blueprint),
        };
        plant.set_start();
        Ok(plant)
    }

    /// The same plant once more, in exactly the same state.
    pub(crate) fn duplicate(&self) -> Result<Self, SimError> {
        Ok(Self {
            blueprint: Arc::clone(&self.blueprint),
            joints: self.joints.clone(),
            finger_joints: self.finger_joints.clone(),
            regime: match &self.regime {
                Regime::Whole => Regime::Whole,
                Regime::Apart(apart) => Regime::Apart(apart.clone()),
            },
            whole: self.whole.duplicate()?,
            glide: self.glide.clone(),
            ..*self
        })
    }

    /// Joints start at their setpoints, at rest.
    fn set_start(&mut self) {
        let setpoints = self
            .joints
            .iter()
            .map(|joint| joint.setpoint.position_rad());
        let start = Configuration {
            positions_rad: setpoints.collect(),
            velocities_rad_s: vec![0.0; self.joints.len()],
            object: ObjectState {
                pose: self.blueprint.draws.object_pose,
                velocity_m_s: [0.0; 3],
                spin_rad_s: [0.0; 3],
            },
        };
        self.whole.start(&start, &self.joints);
    }

    /// Takes over the robot's commands.
    pub(crate) fn command(&mut self, commands: &Commands) {
        let hand = &self.blueprint.scenario.robot.hand_positions;
        for joint in &mut self.joints {
            joint.command(commands, hand, &self.blueprint.parameters.arm);
        }
    }

    /// Advances drives and physics by one time step under the human's force, if there is one.
    pub(crate) fn step(&mut self, wrench: Option<&Wrench>) -> Result<(), SimError> {
        let step_secs = self.blueprint.scenario.simulation.time_step_secs;
        let wrench = wrench.copied().unwrap_or_default();
        if self.is_fast {
            self.choose(wrench != Wrench::default());
        }
        self.arm_accelerates = false;
        for joint in &mut self.joints {
            let accelerates = joint.advance(step_secs);
            self.arm_accelerates |= accelerates && joint.drive == Drive::Arm;
        }
        if let Regime::Apart(apart) = &self.regime
            && (wrench != Wrench::default() || !apart.may_go_on(&self.joints, self.arm_accelerates))
        {
            self.wake();
        }
        self.unbent_steps = match self.is_held && wrench != Wrench::default() {
            true => 0,
            false => self.unbent_steps.saturating_add(1),
        };
        match &mut self.regime {
            Regime::Apart(apart) => apart.step(&self.joints, step_secs),
            Regime::Whole => self.step_whole(&wrench),
        }
        self.steps += 1;
        self.in_regime_steps += 1;
        Ok(())
    }

    /// One time step of the whole model, or of its steady motion.
    fn step_whole(&mut self, wrench: &Wrench) {
        if !self.is_fast {
            self.whole
                .step(&self.joints, wrench.force_newtons, wrench.torque_nm);
            return;
        }
        let may_glide = self.may_glide();
        let is_steady = may_glide
            && joints::fingers(&self.joints).all(|index| self.joints[index].is_at_rest())
            && self.glide.is_same(wrench)
            && self.glide.is_driven_alike(&self.joints);
        if is_steady && self.glide.step(&self.joints) {
            return;
        }
        self.land();
        if !is_steady {
            self.glide.forget();
        }
        self.whole
            .step(&self.joints, wrench.force_newtons, wrench.torque_nm);
        self.is_held = self.whole.grip() != Grip::default();
        if may_glide && let Whole::Mujoco(body) = &self.whole {
            self.glide.watch(body, &self.joints, wrench);
        }
    }

    /// Whether contacts allow for glides: what an empty hand comes upon on its way must not be missed.
    /// Fingers so heavy that they swing are on their way long after they were sent, so that it takes more
    /// than an arm that stands; and they take longer than a burst to follow a pull at what they hold.
    fn may_glide(&self) -> bool {
        if self.fingers_swing {
            return self.is_held && self.unbent_steps >= self.fade_steps;
        }
        self.is_held || joints::arm(&self.joints).all(|index| self.joints[index].is_at_target())
    }

    /// Takes a glide's state over into the whole model.
    fn land(&mut self) {
        if let (Some(landing), Whole::Mujoco(body)) = (self.glide.land(), &mut self.whole) {
            body.set(&landing.now);
            body.turn_start(landing.turned);
        }
    }

    /// Chooses, now and then, whether less than the whole model is integrated from here on.
    fn choose(&mut self, is_pulled: bool) {
        let is_time = self.in_regime_steps != 0
            && self.in_regime_steps.is_multiple_of(self.look_steps)
            && matches!(self.regime, Regime::Whole);
        if !is_time || is_pulled || (self.glide.is_going() && self.is_held) {
            return;
        }
        self.land();
        let (blueprint, joints) = (&self.blueprint, &self.joints);
        let Whole::Mujoco(body) = &self.whole else {
            return;
        };
        let now = configuration(body, joints.len());
        let begun = Apart::begin(blueprint, joints, body, &now, self.fingers_swing);
        if let Some(apart) = begun.filter(|it| it.may_go_on(joints, self.arm_accelerates)) {
            self.glide.forget();
            self.enter(Regime::Apart(Box::new(apart)));
        }
    }

    fn enter(&mut self, regime: Regime) {
        self.regime = regime;
        self.in_regime_steps = 0;
    }

    /// Goes on with the whole model.
    fn wake(&mut self) {
        let regime = std::mem::replace(&mut self.regime, Regime::Whole);
        if let (Regime::Apart(apart), Whole::Mujoco(body)) = (regime, &mut self.whole) {
            body.set(&apart.configuration());
            self.enter(Regime::Whole);
        }
    }

    /// Time steps so far.
    pub(crate) fn steps(&self) -> u64 {
        self.steps
    }

    /// Simulated time: steps times the length of a step, free of the sum's rounding.
    pub(crate) fn now_secs(&self) -> f64 {
        self.steps as f64 * self.blueprint.scenario.simulation.time_step_secs
    }

    /// The angle of a joint, by its place among the joints.
    fn position_rad(&self, joint: usize) -> f64 {
        let angle_rad = match &self.regime {
            Regime::Whole if self.glide.is_going() => self.glide.position_rad(joint),
            Regime::Whole => self.whole.position_rad(joint),
            Regime::Apart(apart) => Some(apart.position_rad(joint)),
        };
        angle_rad.unwrap_or(0.0)
    }

    /// The angle of every joint, by name.
    pub(crate) fn joints_rad(&self) -> impl Iterator<Item = (&str, f64)> {
        let joints = self.joints.iter().enumerate();
        joints.map(|(index, joint)| (joint.name.as_str(), self.position_rad(index)))
    }

    /// Arm encoders, in the order of [`arm_joint_names`].
    pub(crate) fn arm_rad(&self, readings: &mut Vec<f64>) {
        readings.clear();
        readings.extend(joints::arm(&self.joints).map(|index| self.position_rad(index)));
    }

    /// Finger encoders in counts, in the scenario's order.
    pub(crate) fn finger_counts(&self, counts_per_rad: f64, readings: &mut Vec<i64>) {
        readings.clear();
        let fingers = self.finger_joints.iter();
        readings.extend(
            fingers.map(|index| (self.position_rad(*index) * counts_per_rad).round() as i64),
        );
    }

    /// Position (m) and speed vector (m/s) of the hand's frame.
    pub(crate) fn hand(&self) -> (Vector, Vector) {
        let hand = match &self.regime {
            Regime::Whole => self.glide.hand().unwrap_or_else(|| self.whole.hand()),
            Regime::Apart(apart) => apart.hand(),
        };
        (hand.pose.position_m, hand.velocity_m_s)
    }

    /// The object.
    pub(crate) fn object(&self) -> ObjectState {
        match &self.regime {
            Regime::Whole => self.glide.object().unwrap_or_else(|| self.whole.object()),
            Regime::Apart(apart) => apart.object(),
        }
    }

    /// How the hand holds the object.
    pub(crate) fn grip(&self) -> Grip {
        match &self.regime {
            Regime::Whole => self.whole.grip(),
            Regime::Apart(_) => Grip::default(),
        }
    }

    /// The contacts of the grip.
    #[cfg(test)]
    pub(crate) fn grip_contacts(&self) -> Vec<GripContact> {
        self.whole.grip_contacts()
    }

    /// Appends what the whole model was given for its last step.
    pub(crate) fn engine_inputs(&self, inputs: &mut Vec<f64>) {
        self.whole.inputs(inputs);
    }

    /// Steps of the whole model with these inputs, and nothing else; their number.
    pub(crate) fn engine_steps(&mut self, inputs: &[f64]) -> u64 {
        self.whole.steps_with(inputs)
    }

    /// The whole model's positions and velocities, bit for bit.
    pub(crate) fn engine_state(&self) -> Vec<u64> {
        self.whole.bits()
    }

    /// Warnings of the physics engine: 0 in a sound run.
    pub(crate) fn warning_count(&self) -> u64 {
        self.whole.warning_count()
    }
}

/// The configuration of the whole model, which has so many joints.
fn configuration(body: &Body, joints: usize) -> Configuration {
    let mut now = Configuration {
        positions_rad: vec![0.0; joints],
        velocities_rad_s: vec![0.0; joints],
        object: body.object_now(),
    };
    body.get(&mut now);
    now
}
