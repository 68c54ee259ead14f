//! Physics engines behind one small face.
//!
//! A scene is laid out as a [`Layout`]: bodies, shapes, joints and drives in plain numbers, each
//! known by its place in a list. An engine builds itself from it and is then a [`Physics`]. The
//! scene sees nothing else of the engine, so that the same scene runs on another one.
//!
//! All lengths are in metres, angles in radians, forces in newtons, torques in newton metres; poses
//! and velocities are in the world frame unless a name says otherwise.

mod layout;
mod mjcf;
mod mujoco;
mod rapier;

pub use layout::{
    BodyPlan, Cone, CouplingPlan, DriveKind, DrivePlan, Form, Inertia, JointKind, JointPlan,
    Layout, Motion, MujocoSolver, RapierSolver, ShapePlan, Softness, Solver, Spring, Surface,
    Touches,
};
pub use mjcf::mjcf_of;
pub use mujoco::MujocoPhysics;
pub use rapier::{RapierPhysics, VERSION as RAPIER_VERSION};

use std::any::Any;
use std::sync::Arc;

use crate::geometry::{Pose, Vector};

/// Position and velocity of a joint: rad and rad/s of a hinge, m and m/s of a slide.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointState {
    /// Angle or displacement from the layout's configuration; of a wheel with all its turns.
    pub position: f64,
    /// Its rate.
    pub velocity: f64,
}

/// What a drive is told.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveState {
    /// What it is to reach; see [`Physics::set_drive`].
    pub target: f64,
    /// See [`Physics::set_drive_strength`].
    pub strength: f64,
}

/// How a body moves: velocities of the origin of its frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist {
    /// Angular velocity in rad/s.
    pub angular_rad_s: Vector,
    /// Linear velocity in m/s.
    pub linear_m_s: Vector,
}

/// Two shapes that touch, with the force between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// Places in the layout's list of shapes.
    pub shapes: [usize; 2],
    /// Normal force, at least 0.
    pub normal_newtons: f64,
    /// Size of the friction force.
    pub tangential_newtons: f64,
    /// Where they touch, in the world, at the beginning of the step.
    pub point_m: Vector,
    /// Unit vector from the first shape to the second, in the world.
    pub normal: Vector,
}

/// Where two shapes are nearest to each other, or overlap the deepest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Distance of the surfaces, negative where they overlap.
    pub distance_m: f64,
    /// A point of each surface, in the world.
    pub points_m: [Vector; 2],
    /// Unit vector along which the second shape moves away from the first, in the world.
    pub normal: Vector,
}

/// What a ray meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance from the ray's start.
    pub distance_m: f64,
    /// Place in the layout's list of shapes.
    pub shape: usize,
}

/// Everything that determines how an engine goes on; its meaning is the engine's own. Clones share
/// it.
#[derive(Clone)]
pub struct PhysicsState(Arc<dyn Any + Send + Sync>);

impl PhysicsState {
    /// What an engine keeps.
    #[must_use]
    pub fn new<T: Any + Send + Sync>(kept: T) -> Self {
        Self(Arc::new(kept))
    }

    /// What was kept; `None` if it is another engine's.
    #[must_use]
    pub fn of<T: Any + Send + Sync>(&self) -> Option<&T> {
        self.0.downcast_ref()
    }
}

/// A physics engine with a scene in it. Indices are places in the [`Layout`]'s lists; one that does
/// not exist is ignored or gives what nothing would give.
pub trait Physics: Send {
    /// The engine's name and version.
    fn engine(&self) -> (&'static str, String);
    /// In how many equal parts a time step is integrated, while what is applied stays the same.
    fn substeps(&self) -> usize;
    /// Advances by one time step of the layout.
    fn step(&mut self);
    /// Recomputes what follows from where things were placed, without advancing time.
    fn refresh(&mut self);
    /// Simulated time in seconds.
    fn time_secs(&self) -> f64;
    /// A joint's state.
    fn joint(&self, joint: usize) -> JointState;
    /// Places a joint, at rest; takes effect with [`Physics::refresh`] or the next step.
    fn set_joint(&mut self, joint: usize, position: f64);
    /// What a drive is to reach: an angle or a displacement, a velocity, or a torque or force.
    fn set_drive(&mut self, drive: usize, target: f64);
    /// The share of its gains and of its limit that a drive has, from 0 to 1, until changed.
    fn set_drive_strength(&mut self, drive: usize, strength: f64);
    /// What a drive was told last, and the share of its gains and of its limit that it has.
    fn drive(&self, drive: usize) -> DriveState;
    /// Applies a force and a torque at a body's centre of mass, until changed.
    fn apply(&mut self, body: usize, force_newtons: Vector, torque_nm: Vector);
    /// What is applied to a body: force and torque at its centre of mass.
    fn applied(&self, body: usize) -> [Vector; 2];
    /// Where a body's frame is.
    fn body_pose(&self, body: usize) -> Pose;
    /// How it moves.
    fn body_twist(&self, body: usize) -> Twist;
    /// Places a body whose motion is [`Motion::Led`].
    fn lead(&mut self, body: usize, pose: &Pose);
    /// The touches found in the last step, appended to `touches`.
    fn touches(&self, touches: &mut Vec<Touch>);
    /// The force (N) and the torque (N m, about the origin of the body's frame) that a body's parent
    /// exerted on it in the last step, in the body's frame. `None` if the engine does not know
    /// them, or the body is not among the layout's [`wrenches`](Layout::wrenches).
    fn wrench(&self, body: usize) -> Option<[Vector; 2]>;
    /// The first shape that a ray meets within `longest_m` and that `seen` does not deny.
    /// `direction` has unit length.
    fn ray(
        &self,
        from_m: Vector,
        direction: Vector,
        longest_m: f64,
        seen: &dyn Fn(usize) -> bool,
    ) -> Option<Hit>;
    /// Distance between two shapes' surfaces, negative when they overlap, at most `longest_m`.
    fn distance_m(&mut self, a: usize, b: usize, longest_m: f64) -> f64;
    /// Where two shapes are nearest; `None` if they are more than `longest_m` apart, or just touch, so that there is no
    /// direction.
    fn nearest(&mut self, a: usize, b: usize, longest_m: f64) -> Option<Nearest>;
    /// Whether all numbers so far are sound.
    fn is_sound(&self) -> bool;
    /// Everything that determines the future.
    fn save(&self) -> PhysicsState;
    /// Returns to a saved state of the same layout and goes on bit for bit as from there; `false`
    /// if the state is of another layout.
    fn restore(&mut self, saved: &PhysicsState) -> bool;
}
