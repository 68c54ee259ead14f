//! Rapier as a [`Physics`]: a second engine, made by others with other methods than MuJoCo.
//!
//! Definition: bodies that hang on joints are multibodies in reduced coordinates, loose ones are
//! rigid bodies; contacts are soft constraints at velocities, solved by projected Gauss-Seidel in
//! substeps (TGS soft). A step of the layout is four substeps, or what the layout's solver says.
//!
//! Source: the crate `rapier3d-f64` (Crozet and contributors); reduced coordinates after Featherstone,
//! "Rigid Body Dynamics Algorithms" (2008); soft constraints after Catto, "Solver2D" (2024).
//!
//! Deviation from the layout: an ellipsoid is a polyhedron inscribed in it ([`shapes::ELLIPSOID_EDGES`]);
//! contacts have Rapier's own stiffness and damping, not MuJoCo's; where a link of a tree touches,
//! Rapier always uses its model `Coulomb` (see `parameters`), whose error was measured for a loose
//! block only; friction has no torsional part; couplings of joints are linear and within one tree.
//! What is not carried over is refused with its name, never left out. What links bear follows from momenta ([`wrenches`]).
//!
//! Guarantee: the same bits at any number of threads, after saving and restoring, and in a used or a
//! fresh world (tested). Rapier is built with `enhanced-determinism`, for which its authors promise
//! the same bits on any machine that keeps IEEE 754; that was not tested here, and a scene's own
//! sines and cosines are the platform's.

mod build;
mod joints;
mod shapes;
mod touching;
mod wrenches;

use std::sync::Arc;

use rapier3d_f64::prelude as r;

use self::build::{Bodies, Placed};
use self::joints::Joints;
use self::touching::Apart;
use self::wrenches::Borne;
use super::layout::{Layout, Motion, Spring};
use super::{DriveState, Hit, JointState, Nearest, Physics, PhysicsState, Touch, Twist};
use crate::bench::SimError;
use crate::geometry::{Pose, Vector};

/// The release of Rapier that is built in, as `Cargo.toml` pins it.
pub const VERSION: &str = "0.36.1";

/// Iterations in a substep where a coupling carries forces. Rapier solves drives, couplings and contacts one after another and
/// keeps no coupling's impulse, so that a single pass leaves what the last drive added to one finger: fingers of 15 g that were to press
/// with 40 N pressed with 60 to 70 N and shook the part off. Four passes leave 41 N, ten 40.0 N.
const CARRYING_ITERATIONS: usize = 16;

/// Everything of Rapier that determines the future.
#[derive(Clone, Default)]
struct World {
    islands: r::IslandManager,
    broad_phase: r::BroadPhaseBvh,
    narrow_phase: r::NarrowPhase,
    bodies: r::RigidBodySet,
    colliders: r::ColliderSet,
    impulse_joints: r::ImpulseJointSet,
    multibodies: r::MultibodyJointSet,
    soft_bodies: r::SoftBodySet,
    ccd: r::CCDSolver,
    steps: u64,
    is_sound: bool,
    /// Force and torque on each body of the layout.
    applied: Vec<[Vector; 2]>,
    /// Targets of drives.
    targets: Vec<f64>,
    /// The shares of their gains and limits that they have.
    strengths: Vec<f64>,
    touches: Vec<Touch>,
    /// The friction on the first shape of each.
    frictions: Vec<Vector>,
    /// What bodies bore in the last step of which it is asked.
    wrenches: Vec<[Vector; 2]>,
}

/// A scene in Rapier.
pub struct RapierPhysics {
    layout: Arc<Layout>,
    parameters: r::IntegrationParameters,
    pipeline: r::PhysicsPipeline,
    placed: Bodies,
    joints: Joints,
    shapes: Vec<shapes::Shape>,
    apart: Apart,
    borne: Vec<Borne>,
    world: World,
}

/// A saved state, with the layout that it is of.
struct Saved {
    layout: Arc<Layout>,
    world: World,
}

impl RapierPhysics {
    /// Builds the layout in Rapier.
    ///
    /// # Errors
    /// When the layout asks for something that this engine does not do.
    pub fn new(layout: &Layout) -> Result<Self, SimError> {
        let mut world = World {
            is_sound: true,
            applied: vec![[[0.0; 3]; 2]; layout.bodies.len()],
            targets: vec![0.0; layout.drives.len()],
            strengths: vec![1.0; layout.drives.len()],
            wrenches: vec![[[0.0; 3]; 2]; layout.wrenches.len()],
            ..World::default()
        };
        let shapes = shapes::of(layout)?;
        let placed = Bodies::build(layout, &mut world.bodies)?;
        touching::insert(layout, &shapes, &placed, &mut world);
        let joints = Joints::build(layout, &placed, &mut world)?;
        let mut physics = Self {
            apart: Apart::new(layout, &placed),
            borne: Borne::of(layout),
            layout: Arc::new(layout.clone()),
            parameters: parameters(layout),
            pipeline: r::PhysicsPipeline::new(),
            placed,
            joints,
            shapes,
            world,
        };
        physics.refresh();
        physics.joints.finish(layout, &mut physics.world)?;
        Ok(physics)
    }

    fn rigid(&self, body: usize) -> Option<(&r::RigidBody, Placed)> {
        let placed = *self.placed.of.get(body)?;
        Some((self.world.bodies.get(placed.handle)?, placed))
    }

    /// A shape's frame in the world.
    fn shape_pose(&self, shape: usize) -> Option<r::Pose> {
        let plan = self.layout.shapes.get(shape)?;
        let own = to_pose(&plan.pose) * self.shapes.get(shape)?.turn;
        Some(match plan.body {
            None => own,
            Some(body) => to_pose(&self.body_pose(body)) * own,
        })
    }

    /// Forces on bodies and efforts of drives for the coming step.
    fn push(&mut self) {
        let World {
            bodies, applied, ..
        } = &mut self.world;
        for placed in &self.placed.of {
            if let Some(rigid) = bodies.get_mut(placed.handle) {
                rigid.reset_forces(false);
                rigid.reset_torques(false);
            }
        }
        for (index, [force, torque]) in applied.iter().enumerate() {
            if *force == [0.0; 3] && *torque == [0.0; 3] {
                continue;
            }
            let placed = self.placed.of[index];
            let Some(rigid) = bodies.get_mut(placed.handle) else {
                continue;
            };
            let inertia = self.layout.bodies[index].inertia;
            let centre = inertia.map_or([0.0; 3], |inertia| inertia.centre_m);
            let at = rigid.position() * (placed.offset * to_vector(centre));
            rigid.add_force_at_point(to_vector(*force), at, true);
            rigid.add_torque(to_vector(*torque), true);
        }
        self.joints.push(&self.layout, &mut self.world);
    }
}

/// The solver's settings; those that are not named are Rapier's own.
fn parameters(layout: &Layout) -> r::IntegrationParameters {
    let solver = &layout.solver.rapier;
    let own = r::IntegrationParameters::default();
    let soften = |mut softness: r::SpringCoefficients<f64>| {
        let own = &mut softness;
        own.natural_frequency = solver.contact_frequency_hz.unwrap_or(own.natural_frequency);
        own.damping_ratio = solver.contact_damping_ratio.unwrap_or(own.damping_ratio);
        softness
    };
    let fixed = solver.fixed_contact.map(|spring| to_softness(&spring));
    r::IntegrationParameters {
        dt: layout.time_step_secs,
        num_solver_iterations: solver.substeps,
        num_internal_pgs_iterations: match layout.couplings.iter().any(|it| it.carries) {
            true => CARRYING_ITERATIONS,
            false => solver.iterations.unwrap_or(own.num_internal_pgs_iterations),
        },
        contact_softness: soften(own.contact_softness),
        static_contact_softness: fixed.unwrap_or(soften(own.static_contact_softness)),
        // Swept collision and merged manifolds trade exactness of forces for speed.
        max_ccd_substeps: 0,
        contact_clustering: false,
        contact_recycling: false,
        // Its name notwithstanding: Rapier's model `Coulomb` solves both directions of a point's
        // friction at once and shortens the result, so that the force of a sliding point is not
        // against its velocity. A cube of 0.2 m x 0.2 m x 0.1 m slides with 0.90 of the friction.
        friction_model: r::FrictionModel::Simplified,
        ..own
    }
}

fn to_softness(spring: &Spring) -> r::SpringCoefficients<f64> {
    r::SpringCoefficients::new(spring.frequency_hz, spring.damping_ratio)
}

fn to_vector(vector: Vector) -> r::Vector {
    r::Vector::new(vector[0], vector[1], vector[2])
}

fn of_vector(vector: r::Vector) -> Vector {
    [vector.x, vector.y, vector.z]
}

fn to_pose(pose: &Pose) -> r::Pose {
    let [w, x, y, z] = pose.orientation;
    let rotation = r::Rotation::from_xyzw(x, y, z, w).normalize();
    r::Pose::from_parts(to_vector(pose.position_m), rotation)
}

fn of_pose(pose: &r::Pose) -> Pose {
    let q = pose.rotation;
    Pose {
        position_m: of_vector(pose.translation),
        orientation: [q.w, q.x, q.y, q.z],
    }
}

impl Physics for RapierPhysics {
    fn engine(&self) -> (&'static str, String) {
        ("Rapier", VERSION.to_owned())
    }

    fn substeps(&self) -> usize {
        self.layout.solver.rapier.substeps
    }

    fn step(&mut self) {
        self.push();
        let before: Vec<_> = self.borne.iter().map(|it| it.momenta(self)).collect();
        let world = &mut self.world;
        self.pipeline.step(
            r::Vector::new(0.0, 0.0, -self.layout.gravity_m_s2),
            &self.parameters,
            &mut world.islands,
            &mut world.broad_phase,
            &mut world.narrow_phase,
            &mut world.bodies,
            &mut world.colliders,
            &mut world.impulse_joints,
            &mut world.multibodies,
            &mut world.soft_bodies,
            &mut world.ccd,
            &self.apart,
            &(),
        );
        world.steps += 1;
        let substeps = self.layout.solver.rapier.substeps;
        touching::collect(world, self.parameters.dt, substeps);
        world.is_sound &= world.bodies.iter().all(|(_, body)| {
            body.position().is_finite() && body.linvel().is_finite() && body.angvel().is_finite()
        });
        let borne = self.borne.iter().zip(&before);
        self.world.wrenches = borne.map(|(it, before)| it.wrench(self, before)).collect();
    }

    fn refresh(&mut self) {
        self.joints.update(&mut self.world);
    }

    fn time_secs(&self) -> f64 {
        self.world.steps as f64 * self.layout.time_step_secs
    }

    fn joint(&self, joint: usize) -> JointState {
        self.joints.state(joint, &self.world.multibodies)
    }

    fn set_joint(&mut self, joint: usize, position: f64) {
        self.joints
            .set(joint, position, &mut self.world.multibodies);
    }

    fn set_drive(&mut self, drive: usize, target: f64) {
        if let Some(kept) = self.world.targets.get_mut(drive) {
            *kept = target;
            self.joints.aim(&self.layout, drive, &mut self.world);
        }
    }

    fn set_drive_strength(&mut self, drive: usize, strength: f64) {
        if let Some(kept) = self.world.strengths.get_mut(drive) {
            *kept = strength;
            self.joints.aim(&self.layout, drive, &mut self.world);
        }
    }

    fn drive(&self, drive: usize) -> DriveState {
        DriveState {
            target: self.world.targets.get(drive).copied().unwrap_or(0.0),
            strength: self.world.strengths.get(drive).copied().unwrap_or(0.0),
        }
    }

    fn apply(&mut self, body: usize, force_newtons: Vector, torque_nm: Vector) {
        if let Some(applied) = self.world.applied.get_mut(body) {
            *applied = [force_newtons, torque_nm];
        }
    }

    fn applied(&self, body: usize) -> [Vector; 2] {
        let applied = self.world.applied.get(body);
        applied.copied().unwrap_or([[0.0; 3]; 2])
    }

    fn body_pose(&self, body: usize) -> Pose {
        let Some((rigid, placed)) = self.rigid(body) else {
            return of_pose(&r::Pose::IDENTITY);
        };
        of_pose(&(rigid.position() * placed.offset))
    }

    fn body_twist(&self, body: usize) -> Twist {
        let Some((rigid, placed)) = self.rigid(body) else {
            return Twist::default();
        };
        let at = (rigid.position() * placed.offset).translation;
        Twist {
            angular_rad_s: of_vector(rigid.angvel()),
            linear_m_s: of_vector(rigid.velocity_at_point(at)),
        }
    }

    /// As in MuJoCo the body is where it is placed and has no velocity of its own.
    fn lead(&mut self, body: usize, pose: &Pose) {
        let is_led = self.layout.bodies.get(body);
        if is_led.is_none_or(|plan| plan.motion != Motion::Led) {
            return;
        }
        let handle = self.placed.of[body].handle;
        if let Some(rigid) = self.world.bodies.get_mut(handle) {
            rigid.set_position(to_pose(pose), true);
        }
    }

    fn touches(&self, touches: &mut Vec<Touch>) {
        touches.extend(&self.world.touches);
    }

    /// In reduced coordinates the forces between links do not occur; they follow from momenta (`wrenches.rs`). Not known of what
    /// is fixed to the world.
    fn wrench(&self, body: usize) -> Option<[Vector; 2]> {
        let place = self.borne.iter().position(|it| it.body() == body)?;
        self.world.wrenches.get(place).copied()
    }

    fn ray(
        &self,
        from_m: Vector,
        direction: Vector,
        longest_m: f64,
        seen: &dyn Fn(usize) -> bool,
    ) -> Option<Hit> {
        let ray = r::Ray::new(to_vector(from_m), to_vector(direction));
        let mut nearest: Option<Hit> = None;
        for (shape, known) in self.shapes.iter().enumerate() {
            if !seen(shape) {
                continue;
            }
            let within_m = nearest.map_or(longest_m, |hit| hit.distance_m);
            let pose = self.shape_pose(shape)?;
            if let Some(distance_m) = known.form.cast_ray(&pose, &ray, within_m, false)
                && nearest.is_none_or(|hit| distance_m < hit.distance_m)
            {
                nearest = Some(Hit { distance_m, shape });
            }
        }
        nearest
    }

    fn distance_m(&mut self, a: usize, b: usize, longest_m: f64) -> f64 {
        let (Some(pose_a), Some(pose_b)) = (self.shape_pose(a), self.shape_pose(b)) else {
            return longest_m;
        };
        let (a, b) = (&self.shapes[a], &self.shapes[b]);
        let found_m = shapes::distance_m(a, &pose_a, b, &pose_b);
        found_m.map_or(longest_m, |found_m| found_m.min(longest_m))
    }

    fn nearest(&mut self, a: usize, b: usize, longest_m: f64) -> Option<Nearest> {
        let (pose_a, pose_b) = (self.shape_pose(a)?, self.shape_pose(b)?);
        shapes::nearest(
            &self.shapes[a],
            &pose_a,
            &self.shapes[b],
            &pose_b,
            longest_m,
        )
    }

    fn is_sound(&self) -> bool {
        self.world.is_sound
    }

    fn save(&self) -> PhysicsState {
        PhysicsState::new(Saved {
            layout: Arc::clone(&self.layout),
            world: self.world.clone(),
        })
    }

    fn restore(&mut self, saved: &PhysicsState) -> bool {
        let Some(saved) = saved.of::<Saved>() else {
            return false;
        };
        if !Arc::ptr_eq(&saved.layout, &self.layout) && saved.layout != self.layout {
            return false;
        }
        self.world = saved.world.clone();
        // What the pipeline keeps is memory for work, but it must not be of another run.
        self.pipeline = r::PhysicsPipeline::new();
        true
    }
}
