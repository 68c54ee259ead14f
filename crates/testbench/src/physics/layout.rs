//! What is in a scene, in plain numbers, for any engine.

use crate::geometry::{Pose, Vector};

/// Everything an engine is built from. Bodies come after their parents.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Layout {
    /// Length of a time step.
    pub time_step_secs: f64,
    /// Gravity, downwards.
    pub gravity_m_s2: f64,
    /// Bodies; the world itself is not among them.
    pub bodies: Vec<BodyPlan>,
    /// Shapes of bodies and of the world.
    pub shapes: Vec<ShapePlan>,
    /// Joints; those of one body apply in this order, from the parent outwards.
    pub joints: Vec<JointPlan>,
    /// Drives of joints.
    pub drives: Vec<DrivePlan>,
    /// Joints that follow others.
    pub couplings: Vec<CouplingPlan>,
    /// Bodies whose wrench somebody asks for; an engine need not know that of others.
    pub wrenches: Vec<usize>,
    /// Pairs of bodies that never touch.
    pub no_contact: Vec<[usize; 2]>,
    /// How each engine solves contacts.
    pub solver: Solver,
}

/// How each engine solves contacts; an engine reads its own.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Solver {
    /// In MuJoCo.
    pub mujoco: MujocoSolver,
    /// In Rapier.
    pub rapier: RapierSolver,
}

/// MuJoCo's settings; `None` leaves its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MujocoSolver {
    /// Most iterations in a step.
    pub iterations: Option<u32>,
    /// Improvement below which iterations end.
    pub tolerance: Option<f64>,
    /// The form of the cone of friction.
    pub cone: Cone,
    /// How much harder friction is than contact along the normal.
    pub impratio: f64,
    /// Iterations after the solver that hold friction hard.
    pub no_slip_iterations: u32,
}

impl Default for MujocoSolver {
    fn default() -> Self {
        Self {
            iterations: None,
            tolerance: None,
            cone: Cone::Elliptic,
            impratio: 10.0,
            no_slip_iterations: 0,
        }
    }
}

/// The form of the cone within which the force of a contact lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Cone {
    /// Coulomb's.
    #[default]
    Elliptic,
    /// A pyramid in it: faster, and friction depends on its direction.
    Pyramidal,
}

/// Rapier's settings; `None` leaves its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RapierSolver {
    /// Substeps of the solver in a time step.
    pub substeps: usize,
    /// How stiff contacts are: the natural frequency of their springs.
    pub contact_frequency_hz: Option<f64>,
    /// How damped contacts are; 1 is critical.
    pub contact_damping_ratio: Option<f64>,
    /// The same of contacts with what is fixed, where these are others.
    pub fixed_contact: Option<Spring>,
    /// Passes over drives, stops, dry friction and contacts in a substep.
    pub iterations: Option<usize>,
}

/// A spring and a damper that act on the mass that they meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// Its natural frequency, undamped.
    pub frequency_hz: f64,
    /// How damped it is; 1 is critical.
    pub damping_ratio: f64,
}

impl Default for RapierSolver {
    fn default() -> Self {
        Self {
            substeps: 4,
            contact_frequency_hz: None,
            contact_damping_ratio: None,
            fixed_contact: None,
            iterations: None,
        }
    }
}

/// A rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyPlan {
    /// Its name, unique among bodies.
    pub name: String,
    /// The body that it hangs on; `None` for the world.
    pub parent: Option<usize>,
    /// Its frame in the parent's frame (before the joint moves it).
    pub pose: Pose,
    /// How it may move against its parent.
    pub motion: Motion,
    /// Its mass; `None` where its shapes weigh nothing (fixed or led bodies).
    pub inertia: Option<Inertia>,
}

/// How a body may move against its parent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// Not at all.
    Fixed,
    /// Freely; its parent is the world.
    Free,
    /// By its joints, which are in the layout's list of joints.
    Jointed,
    /// As it is placed, whatever pushes it; its parent is the world. It pushes others.
    Led,
}

/// Mass and how it is spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia {
    /// Mass.
    pub mass_kg: f64,
    /// Centre of mass in the body's frame.
    pub centre_m: Vector,
    /// xx, yy, zz, xy, xz, yz about the centre, along the body's axes.
    pub moments_kg_m2: [f64; 6],
}

/// A shape that others can touch and rays can meet.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapePlan {
    /// Its name, unique among shapes.
    pub name: String,
    /// The body it belongs to; `None` for the world.
    pub body: Option<usize>,
    /// Its frame in the body's.
    pub pose: Pose,
    /// Its form.
    pub form: Form,
    /// Coulomb friction; of two shapes the smaller holds.
    pub friction: f64,
    /// What it touches. Rays meet it in any case.
    pub touches: Touches,
    /// What its surface is like besides its friction.
    pub surface: Surface,
}

/// A surface besides its Coulomb friction. Of two shapes that of the smaller friction holds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Surface {
    /// Friction against turning about the normal, in metres: the torque over the normal force.
    pub torsional_m: Option<f64>,
    /// Friction against rolling, in metres.
    pub rolling_m: Option<f64>,
    /// How soft it is.
    pub softness: Option<Softness>,
}

/// How soft contacts are, in MuJoCo's terms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Softness {
    /// `solref`'s time constant: within which a penetration goes back.
    pub time_constant_secs: f64,
    /// `solref`'s damping ratio; 1 is critical.
    pub damping_ratio: f64,
    /// `solimp`: least and greatest impedance (0 to 1), the penetration at which the greatest is reached, in metres, the
    /// midpoint and the power of the curve between them.
    pub impedance: Option<[f64; 5]>,
}

impl Softness {
    /// MuJoCo's `solimp` as it comes.
    const IMPEDANCE: [f64; 2] = [0.9, 0.95];

    /// The spring and damper that give way as MuJoCo's constraint does, for an engine that has these.
    ///
    /// MuJoCo's documentation ("Computation", constraint model): the acceleration is `a = (1 - d) a0 - d (b v + d k r)`, where `a0` is
    /// that without the constraint, `d` the impedance, `b = 2 / (d_max T)` and `k = 1 / (d_max T z)^2`, with the time constant `T`
    /// and the damping ratio `z`. Divided by `1 - d` this is a mass `m / (1 - d)` on a spring of `m k d^2 / (1 - d)` and a damper of
    /// `m b d / (1 - d)`. Here the mass is `m`: with a natural frequency of `d sqrt(k / (1 - d)) / (2 pi)` and a damping ratio of
    /// `z / sqrt(1 - d)` spring and damper are the same, so that what is at rest, or moves slowly, sinks in as far, and as fast.
    ///
    /// Deviation: blows are taken by a smaller mass; `d` grows with the penetration, and its mean between least and greatest is
    /// taken, so that the spring is right within a factor of 1.6 as `solimp` comes.
    #[must_use]
    pub fn spring(&self) -> Spring {
        let [least, most] = match self.impedance {
            Some([least, most, ..]) => [least, most],
            None => Self::IMPEDANCE,
        };
        let impedance = (least + most) / 2.0;
        let rate = 1.0 / (most * self.time_constant_secs * self.damping_ratio);
        let stiffer = impedance / (1.0 - impedance).sqrt();
        Spring {
            frequency_hz: stiffer * rate / (2.0 * std::f64::consts::PI),
            damping_ratio: self.damping_ratio / (1.0 - impedance).sqrt(),
        }
    }
}

/// Which other shapes a shape touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Touches {
    /// All that touch anything.
    All,
    /// All but those of the same group, 0 to 30.
    AllButGroup(u8),
    /// Those of these kinds, as bits (0 to 30), and those that touch what it is.
    Kinds {
        /// The kinds that it is of.
        is: u32,
        /// The kinds that it touches.
        touches: u32,
    },
    /// None.
    Nothing,
}

/// The form of a shape; cylinders and capsules lie along z, centred.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "names carry quantity and unit")]
pub enum Form {
    /// Everything below z = 0.
    Ground,
    Box {
        edges_m: Vector,
    },
    Sphere {
        radius_m: f64,
    },
    /// `length_m` is that of the straight part.
    Capsule {
        radius_m: f64,
        length_m: f64,
    },
    Cylinder {
        radius_m: f64,
        length_m: f64,
    },
    Ellipsoid {
        radii_m: Vector,
    },
    /// The convex hull of points.
    Hull {
        points_m: Vec<Vector>,
    },
}

/// A joint.
#[derive(Debug, Clone, PartialEq)]
pub struct JointPlan {
    /// Its name, unique among joints.
    pub name: String,
    /// The body that it moves.
    pub body: usize,
    /// Hinge or slide.
    pub kind: JointKind,
    /// A point of its axis in the body's frame.
    pub anchor_m: Vector,
    /// Its axis in the body's frame.
    pub axis: Vector,
    /// The position at which the body stands as its pose says.
    pub reference: f64,
    /// Lowest and highest position, if it is limited.
    pub range: Option<[f64; 2]>,
    /// Viscous damping, N m s/rad or N s/m.
    pub damping: f64,
    /// Dry friction, N m or N.
    pub friction_loss: f64,
    /// Inertia of its drive as seen from the joint, kg m² or kg.
    pub armature: f64,
    /// A spring, N m/rad or N/m.
    pub stiffness: f64,
    /// Where the spring rests.
    pub spring_reference: f64,
    /// How soft its stops are; as the engine has them, if it is not said.
    pub stop: Option<Softness>,
}

/// A joint that follows another: its position is a polynomial of the leader's.
#[derive(Debug, Clone, PartialEq)]
pub struct CouplingPlan {
    /// The joint that follows.
    pub joint: usize,
    /// The joint that leads; a constant if `None`.
    pub leader: Option<usize>,
    /// Coefficients, the constant first. They are of positions less the joints' references.
    pub coefficients: [f64; 5],
    /// Whether it carries forces of a mechanism, and is as stiff as the engine can have it.
    pub carries: bool,
}

/// What a joint's position is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// An angle.
    Hinge,
    /// A displacement.
    Slide,
    /// A turn in any direction; it has no single position and cannot be driven.
    Ball,
}

/// A drive of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct DrivePlan {
    /// The joint that it drives.
    pub joint: usize,
    /// What its target is.
    pub kind: DriveKind,
    /// Largest torque or force.
    pub limit: f64,
}

/// What a drive is told to reach.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs, reason = "the variants say it")]
pub enum DriveKind {
    /// A position; torque = stiffness (target - position) - damping · velocity.
    Position { stiffness: f64, damping: f64 },
    /// A velocity; torque = gain (target - velocity).
    Velocity { gain: f64 },
    /// A torque or force.
    Effort,
}
