//! The whole model in Rapier.
//!
//! As of MuJoCo's whole model, what is asked of hand and object after a step belongs to the time before it, and contacts are those
//! of that step: the robot's code and the human read the same moments in both engines.

use testbench::SimError;
use testbench::geometry::{Pose, Vector};
use testbench::physics::{Layout, Physics, RapierPhysics, Touch};

use super::body::{Blueprint, Configuration};
use super::joints::DrivenJoint;
use super::{Grip, ObjectState};
use crate::model;

/// The whole model as Rapier has it.
pub(super) struct RapierBody {
    layout: Layout,
    physics: RapierPhysics,
    hand: usize,
    object: usize,
    /// The object's shape that fingers touch.
    grip: usize,
    is_skin: Vec<bool>,
    /// Hand and object before the last step.
    before: [ObjectState; 2],
    touches: Vec<Touch>,
}

impl RapierBody {
    pub(super) fn new(blueprint: &Blueprint) -> Result<Self, SimError> {
        let Blueprint {
            scenario,
            parameters,
            draws,
            ..
        } = blueprint;
        let layout = model::layout(scenario, parameters, draws);
        let mut physics = RapierPhysics::new(&layout)?;
        for (link, force_newtons) in model::carried(scenario, &layout) {
            physics.apply(link, force_newtons, [0.0; 3]);
        }
        let named = |name: &str| layout.bodies.iter().position(|body| body.name == name);
        let shapes = layout.shapes.iter();
        let is_skin = shapes.map(|it| it.name.starts_with(model::CONTACT_GEOM_PREFIX));
        let is_grip = |shape: &testbench::physics::ShapePlan| shape.name == model::OBJECT_GEOM;
        let none = layout.bodies.len();
        let mut body = Self {
            hand: named(&scenario.robot.hand).unwrap_or(none),
            object: named(model::OBJECT_BODY).unwrap_or(none),
            grip: layout.shapes.iter().position(is_grip).unwrap_or(none),
            is_skin: is_skin.collect(),
            before: [ObjectState::at_rest(super::chain::identity()); 2],
            touches: Vec::new(),
            layout,
            physics,
        };
        body.look();
        Ok(body)
    }

    /// The same once more, in exactly the same state.
    pub(super) fn duplicate(&self) -> Result<Self, SimError> {
        let mut physics = RapierPhysics::new(&self.layout)?;
        physics.restore(&self.physics.save());
        Ok(Self {
            layout: self.layout.clone(),
            physics,
            is_skin: self.is_skin.clone(),
            touches: self.touches.clone(),
            ..*self
        })
    }

    /// Places joints at rest; the object stands where the model has it.
    pub(super) fn start(&mut self, now: &Configuration, joints: &[DrivenJoint]) {
        for (joint, position_rad) in now.positions_rad.iter().enumerate() {
            self.physics.set_joint(joint, *position_rad);
        }
        self.set_controls(joints);
        self.physics.refresh();
        self.look();
    }

    fn set_controls(&mut self, joints: &[DrivenJoint]) {
        for (drive, joint) in joints.iter().enumerate() {
            self.physics.set_drive(drive, joint.setpoint.position_rad());
        }
    }

    /// Advances by one time step towards the joints' setpoints, with a force (N) and a torque (N m)
    /// on the object.
    pub(super) fn step(&mut self, joints: &[DrivenJoint], force: Vector, torque: Vector) {
        self.set_controls(joints);
        self.physics.apply(self.object, force, torque);
        self.advance();
    }

    fn advance(&mut self) {
        self.look();
        self.physics.step();
        self.touches.clear();
        self.physics.touches(&mut self.touches);
    }

    fn look(&mut self) {
        self.before = [self.hand, self.object].map(|body| self.moving(body));
    }

    fn moving(&self, body: usize) -> ObjectState {
        let twist = self.physics.body_twist(body);
        ObjectState {
            pose: self.physics.body_pose(body),
            velocity_m_s: twist.linear_m_s,
            spin_rad_s: twist.angular_rad_s,
        }
    }

    pub(super) fn position_rad(&self, joint: usize) -> f64 {
        self.physics.joint(joint).position
    }

    pub(super) fn hand(&self) -> ObjectState {
        self.before[0]
    }

    pub(super) fn object(&self) -> ObjectState {
        self.before[1]
    }

    /// How the hand holds the object.
    pub(super) fn grip(&self) -> Grip {
        let mut grip = Grip::default();
        let is_skin = |shape: usize| self.is_skin.get(shape).copied().unwrap_or(false);
        for touch in &self.touches {
            let [a, b] = touch.shapes;
            let held = (a == self.grip && is_skin(b)) || (b == self.grip && is_skin(a));
            if held && touch.normal_newtons > 0.0 {
                grip.contacts += 1;
                grip.normal_newtons += touch.normal_newtons;
            }
        }
        grip
    }

    /// The contacts of the grip.
    #[cfg(test)]
    pub(super) fn grip_contacts(&self) -> Vec<super::GripContact> {
        let of_object = self.touches.iter().filter_map(|touch| {
            let [a, b] = touch.shapes;
            let sign = match () {
                () if a == self.grip && self.is_skin[b] => -1.0,
                () if b == self.grip && self.is_skin[a] => 1.0,
                () => return None,
            };
            Some(super::GripContact {
                normal_newtons: touch.normal_newtons,
                friction_newtons: touch.tangential_newtons,
                pushes: touch.normal.map(|along| sign * along),
            })
        });
        of_object.collect()
    }

    /// Appends what the last step was given: setpoints, then force and torque on the object.
    pub(super) fn inputs(&self, inputs: &mut Vec<f64>) {
        let drives = 0..self.layout.drives.len();
        inputs.extend(drives.map(|drive| self.physics.drive(drive).target));
        inputs.extend(self.physics.applied(self.object).as_flattened());
    }

    /// Steps with inputs as [`Self::inputs`] gives them, and nothing else; their number.
    pub(super) fn steps_with(&mut self, inputs: &[f64]) -> u64 {
        let setpoints = self.layout.drives.len();
        let mut steps = 0;
        for input in inputs.chunks_exact(setpoints + 6) {
            let (targets, wrench) = input.split_at(setpoints);
            for (drive, target) in targets.iter().enumerate() {
                self.physics.set_drive(drive, *target);
            }
            let three = |at: usize| std::array::from_fn(|axis| wrench[at + axis]);
            self.physics.apply(self.object, three(0), three(3));
            self.physics.step();
            steps += 1;
        }
        steps
    }

    /// Positions and velocities, bit for bit.
    pub(super) fn bits(&self) -> Vec<u64> {
        let joints = (0..self.layout.joints.len()).map(|joint| self.physics.joint(joint));
        let of_joints = joints.flat_map(|it| [it.position, it.velocity]);
        let ObjectState {
            pose: Pose {
                position_m,
                orientation,
            },
            velocity_m_s,
            spin_rad_s,
        } = self.moving(self.object);
        let of_object = position_m.into_iter().chain(orientation);
        let of_object = of_object.chain(velocity_m_s).chain(spin_rad_s);
        of_joints.chain(of_object).map(f64::to_bits).collect()
    }

    /// 0 as long as all numbers are sound.
    pub(super) fn warning_count(&self) -> u64 {
        u64::from(!self.physics.is_sound())
    }
}
