//! Compliant people: parts of the body with masses that are held where the person wants them, and give way to what pushes them.
//!
//! # Definition
//! Each part is a rigid body with the effective mass `m` of its region. It is held at a place `x'` that moves with `v'` as
//! `person.rs` says:
//!
//! ```text
//! F = k (x' - x) + c (v' - v),   c = 2 zeta sqrt(k m),   |F| at most the strength;   besides, its weight is borne
//! ```
//!
//! and likewise turned, with `k r^2` and its moments of inertia, `r` half its length. Robots and things that are bodies touch it
//! through its skin: of a penetration `d` that grows with `d'` the normal force is
//!
//! ```text
//! N = K d max(0, 1 + a d')
//! ```
//!
//! where of `n` substeps in which the engine keeps a force `d` is that after `(n - 1) / 2n` of a time step, with which the spring
//! neither gains nor loses energy. The spring is of the part, not of what touches it: of several shapes that press on it from one side,
//! with normals `u` and penetrations `d`, each has the share `d_i / sum max(0, u_i u_j) d_j`, so that two fingers beside each other are as
//! stiff as one, and what presses from opposite sides is a spring on each. Friction against a sliding speed `s` is `mu N s / (s + s0)`. What pushes the whole body with
//! more than its balance, over the time between two moves, makes the person step back.
//!
//! # Source
//! ISO/TS 15066:2016, annex A: robot and region of the body as two masses with a spring between them, with the effective
//! masses and spring constants by region. A free impact then has the largest force `v sqrt(K mu)`, `mu` the reduced mass, and
//! a clamped part bears what the robot presses with. `a`: K. H. Hunt and F. R. E. Crossley, "Coefficient of restitution
//! interpreted as damping in vibroimpact" (1975). The order of `k` of an arm: F. A. Mussa-Ivaldi, N. Hogan and E. Bizzi,
//! "Neural, mechanical, and geometric factors subserving arm posture in humans" (1985).
//!
//! # Deviation
//! Parts hang on where the person stands and not on each other, as the annex has a mass for each region and no joints: an arm
//! that is pushed aside does not pull its hand along. What is fixed to the world and other people touch a part hard, as the
//! engine has it. Where shares shift between shapes the spring is not conservative. Forces are those at the beginning of a time step, so that steps have to be short for the skin
//! ([`Compliant::longest_step_secs`]).
//!
//! # Guarantee
//! The same forces in every engine at the same places and velocities. Of a free impact and of a clamped hand within 5 % of theory
//! (tested in both engines).

use stimulus::Distribution;

use super::build::BuiltPerson;
use super::data::{BodyRegion, Compliance, Person, REGIONS};
use super::draws::Draws;
use crate::geometry::{
    Pose, Vector, add, cross, cylinder_inertia, dot, inverse, norm, rotate, rotation_between,
    scale, subtract, turned_by,
};
use crate::physics::{Form, Inertia, Layout, Physics, Touch, Twist};

/// Below this speed friction falls with the speed.
const SLIDING_M_S: f64 = 0.01;
/// A step may be this share of the time in which the skin over a mass swings by one radian.
const SHARE_OF_A_SWING: f64 = 0.5;

/// What holds a person's parts, and what they feel.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Compliant {
    parts: Vec<Held>,
    dissipation_s_m: f64,
    pub(super) balance_newtons: f64,
    /// When the parts are where they are wanted.
    goal_secs: f64,
    /// Horizontal impulse of what pushed the body since the person moved last.
    pushed_ns: [f64; 2],
}

/// A part.
#[derive(Debug, Clone, PartialEq)]
struct Held {
    body: usize,
    shape: usize,
    mass_kg: f64,
    moments_kg_m2: Vector,
    stiffness_n_m: f64,
    damping_ns_m: f64,
    /// About the axis through the part's length last.
    turn_stiffness_nm: Vector,
    turn_damping_nms: Vector,
    strength_newtons: f64,
    skin_n_m: f64,
    /// A sphere about the part.
    reach_m: f64,
    goal: Option<(Pose, Twist)>,
}

/// A shape of a robot or a thing that a person may be touched by.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Toucher {
    shape: usize,
    body: usize,
    /// A sphere about it.
    reach_m: f64,
    /// Centre of mass in the body's frame.
    centre_m: Vector,
}

impl Compliant {
    /// The parts of a person, in their order; bodies and shapes come from these places on.
    pub(super) fn new(
        person: &Person,
        parts: &[(&'static str, Form)],
        (first_body, first_shape): (usize, usize),
        draws: Draws,
    ) -> Self {
        let of = person.compliance.clone().unwrap_or_default();
        let drawn = |field: &str, distribution: &Distribution| {
            let field = format!("compliance.{field}");
            draws.of("person", &person.name, &field, distribution)
        };
        let damping_ratio = drawn("damping_ratio", &of.damping_ratio);
        let held = parts.iter().enumerate().map(|(place, (part, form))| {
            let region = region_of(part);
            let (mass_kg, skin_n_mm) = own(&of, &region, &drawn);
            let (stiffness_n_m, strength_newtons) = match region.is_arm {
                true => (
                    drawn("arm_n_m", &of.arm_n_m),
                    drawn("arm_strength_newtons", &of.arm_strength_newtons),
                ),
                false => (
                    drawn("posture_n_m", &of.posture_n_m),
                    drawn("posture_strength_newtons", &of.posture_strength_newtons),
                ),
            };
            let (radius_m, length_m) = match form {
                Form::Capsule { radius_m, length_m } => (*radius_m, length_m + 2.0 * radius_m),
                Form::Sphere { radius_m } => (*radius_m, 2.0 * radius_m),
                _ => unreachable!("a person's parts are spheres and capsules"),
            };
            let moments = cylinder_inertia(mass_kg, length_m, radius_m);
            let damping =
                |stiffness: f64, inertia: f64| 2.0 * damping_ratio * (stiffness * inertia).sqrt();
            let turn = [length_m, length_m, 2.0 * radius_m];
            let turn = turn.map(|length_m| stiffness_n_m * (length_m / 2.0).powi(2));
            Held {
                body: first_body + place,
                shape: first_shape + place,
                mass_kg,
                moments_kg_m2: moments,
                stiffness_n_m,
                damping_ns_m: damping(stiffness_n_m, mass_kg),
                turn_stiffness_nm: turn,
                turn_damping_nms: std::array::from_fn(|axis| damping(turn[axis], moments[axis])),
                strength_newtons,
                skin_n_m: 1000.0 * skin_n_mm,
                reach_m: length_m.max(2.0 * radius_m) / 2.0,
                goal: None,
            }
        });
        Self {
            parts: held.collect(),
            dissipation_s_m: drawn("dissipation_s_m", &of.dissipation_s_m),
            balance_newtons: drawn("balance_newtons", &of.balance_newtons),
            goal_secs: 0.0,
            pushed_ns: [0.0; 2],
        }
    }

    /// The mass of a part.
    pub(super) fn inertia(&self, part: usize) -> Inertia {
        let held = &self.parts[part];
        let [xx, yy, zz] = held.moments_kg_m2;
        Inertia {
            mass_kg: held.mass_kg,
            centre_m: [0.0; 3],
            moments_kg_m2: [xx, yy, zz, 0.0, 0.0, 0.0],
        }
    }

    /// The longest time step with which the force of every part's skin is sound.
    pub(super) fn longest_step_secs(&self) -> f64 {
        let swing = |held: &Held| (held.mass_kg / held.skin_n_m).sqrt();
        SHARE_OF_A_SWING * self.parts.iter().map(swing).fold(f64::INFINITY, f64::min)
    }

    /// The parts are wanted at these places at a time, `secs` after the places before; `None` at first.
    pub(super) fn want(&mut self, poses: &[Pose], then_secs: f64, secs: Option<f64>) {
        self.goal_secs = then_secs;
        for (held, pose) in self.parts.iter_mut().zip(poses) {
            let twist = match (&held.goal, secs) {
                (Some((before, _)), Some(secs)) => Twist {
                    angular_rad_s: scale(
                        1.0 / secs,
                        rotation_between(before.orientation, pose.orientation),
                    ),
                    linear_m_s: scale(1.0 / secs, subtract(pose.position_m, before.position_m)),
                },
                _ => Twist::default(),
            };
            held.goal = Some((*pose, twist));
        }
    }

    /// The mean horizontal force that pushed the body within `secs`, which are then forgotten.
    pub(super) fn pushed_newtons(&mut self, secs: f64) -> [f64; 2] {
        let pushed_ns = std::mem::take(&mut self.pushed_ns);
        pushed_ns.map(|impulse| impulse / secs)
    }

    /// Holds the parts and lets their skin be touched in the coming time step. What is applied to bodies is added to; touches
    /// are appended.
    pub(super) fn act(
        &mut self,
        physics: &mut dyn Physics,
        layout: &Layout,
        touchers: &[Toucher],
        touches: &mut Vec<Touch>,
    ) {
        let now_secs = physics.time_secs();
        let at: Vec<Vector> = touchers
            .iter()
            .map(|it| it.middle(physics, layout))
            .collect();
        for held in &self.parts {
            let pose = physics.body_pose(held.body);
            held.hold(physics, layout, &pose, now_secs - self.goal_secs);
            let mut overlaps = Vec::new();
            for (toucher, middle_m) in touchers.iter().zip(&at) {
                let reach_m = held.reach_m + toucher.reach_m;
                if norm(subtract(*middle_m, pose.position_m)) > reach_m {
                    continue;
                }
                overlaps.extend(held.overlap(physics, layout, toucher));
            }
            for overlap in &overlaps {
                let share = overlap.share(&overlaps);
                let touch = held.press(
                    physics,
                    layout,
                    overlap,
                    share * held.skin_n_m,
                    self.dissipation_s_m,
                );
                for (pushed, force) in self.pushed_ns.iter_mut().zip(touch.on_part) {
                    *pushed += force * layout.time_step_secs;
                }
                touches.push(touch.touch);
            }
        }
    }

    /// Bodies of the parts.
    pub(super) fn bodies(&self) -> impl Iterator<Item = usize> + '_ {
        self.parts.iter().map(|held| held.body)
    }
}

/// A shape that overlaps a part.
struct Overlap<'a> {
    toucher: &'a Toucher,
    /// From the part into the shape.
    normal: Vector,
    point_m: Vector,
    depth_m: f64,
    approach_m_s: f64,
    /// Velocity of the part against the shape along the surface.
    sliding_m_s: Vector,
}

/// A touch, and the force on the part.
struct Felt {
    touch: Touch,
    on_part: Vector,
}

impl Held {
    /// Towards where it is wanted, so long after its goal.
    fn hold(&self, physics: &mut dyn Physics, layout: &Layout, pose: &Pose, since_secs: f64) {
        let weight = [0.0, 0.0, self.mass_kg * layout.gravity_m_s2];
        let Some((goal, wanted)) = &self.goal else {
            return push(physics, self.body, weight, [0.0; 3]);
        };
        let twist = physics.body_twist(self.body);
        let place_m = add(goal.position_m, scale(since_secs, wanted.linear_m_s));
        let error_m = subtract(place_m, pose.position_m);
        let error_m_s = subtract(wanted.linear_m_s, twist.linear_m_s);
        let force = add(
            scale(self.stiffness_n_m, error_m),
            scale(self.damping_ns_m, error_m_s),
        );
        let held = at_most(force, self.strength_newtons);
        let orientation = turned_by(goal.orientation, scale(since_secs, wanted.angular_rad_s));
        let back = inverse(pose.orientation);
        let into_part = |vector: Vector| rotate(back, vector);
        let turn = into_part(rotation_between(pose.orientation, orientation));
        let rate = into_part(subtract(wanted.angular_rad_s, twist.angular_rad_s));
        let torque: Vector = std::array::from_fn(|axis| {
            self.turn_stiffness_nm[axis] * turn[axis] + self.turn_damping_nms[axis] * rate[axis]
        });
        let torque = at_most(torque, self.strength_newtons * self.reach_m);
        push(
            physics,
            self.body,
            add(held, weight),
            rotate(pose.orientation, torque),
        );
    }

    /// How a shape overlaps it, if it does.
    fn overlap<'a>(
        &self,
        physics: &mut dyn Physics,
        layout: &Layout,
        toucher: &'a Toucher,
    ) -> Option<Overlap<'a>> {
        let nearest = physics.nearest(self.shape, toucher.shape, f64::MIN_POSITIVE)?;
        let depth_m = -nearest.distance_m;
        if depth_m <= 0.0 {
            return None;
        }
        let [a, b] = nearest.points_m;
        let point_m = scale(0.5, add(a, b));
        let velocity = |body: usize| {
            let arm = subtract(point_m, physics.body_pose(body).position_m);
            let twist = physics.body_twist(body);
            add(twist.linear_m_s, cross(twist.angular_rad_s, arm))
        };
        let relative = subtract(velocity(self.body), velocity(toucher.body));
        let approach_m_s = dot(relative, nearest.normal);
        let substeps = physics.substeps() as f64;
        let ahead_secs = (substeps - 1.0) / (2.0 * substeps) * layout.time_step_secs;
        Some(Overlap {
            toucher,
            normal: nearest.normal,
            point_m,
            depth_m: (depth_m + ahead_secs * approach_m_s).max(0.0),
            approach_m_s,
            sliding_m_s: subtract(relative, scale(approach_m_s, nearest.normal)),
        })
    }

    /// Its skin presses on a shape with a share of its stiffness, and the shape on it.
    fn press(
        &self,
        physics: &mut dyn Physics,
        layout: &Layout,
        overlap: &Overlap<'_>,
        skin_n_m: f64,
        dissipation_s_m: f64,
    ) -> Felt {
        let Overlap {
            toucher,
            normal,
            point_m,
            depth_m,
            approach_m_s,
            sliding_m_s,
        } = *overlap;
        let normal_newtons = skin_n_m * depth_m * (1.0 + dissipation_s_m * approach_m_s).max(0.0);
        let speed_m_s = norm(sliding_m_s);
        let shapes = &layout.shapes;
        let friction = shapes[self.shape]
            .friction
            .min(shapes[toucher.shape].friction);
        let tangential_newtons = friction * normal_newtons * speed_m_s / (speed_m_s + SLIDING_M_S);
        let along = match speed_m_s > 0.0 {
            true => scale(-tangential_newtons / speed_m_s, sliding_m_s),
            false => [0.0; 3],
        };
        let on_part = add(scale(-normal_newtons, normal), along);
        let centre_m = physics.body_pose(self.body).position_m;
        let torque = cross(subtract(point_m, centre_m), on_part);
        push(physics, self.body, on_part, torque);
        let against = scale(-1.0, on_part);
        let pose = physics.body_pose(toucher.body);
        let centre_m = add(pose.position_m, rotate(pose.orientation, toucher.centre_m));
        let torque = cross(subtract(point_m, centre_m), against);
        push(physics, toucher.body, against, torque);
        Felt {
            touch: Touch {
                shapes: [self.shape, toucher.shape],
                normal_newtons,
                tangential_newtons,
                point_m,
                normal,
            },
            on_part,
        }
    }
}

impl Overlap<'_> {
    /// The share that it has of the part's spring among all that overlap the part.
    fn share(&self, all: &[Overlap<'_>]) -> f64 {
        let same_side = all
            .iter()
            .map(|it| dot(self.normal, it.normal).max(0.0) * it.depth_m);
        let depth_m: f64 = same_side.sum();
        match depth_m > 0.0 {
            true => self.depth_m / depth_m,
            false => 1.0,
        }
    }
}

impl Toucher {
    /// All shapes of bodies but those of people, if any person is compliant.
    pub(super) fn of(layout: &Layout, people: &[BuiltPerson]) -> Vec<Self> {
        if people.iter().all(|person| person.compliant.is_none()) {
            return Vec::new();
        }
        let shapes = layout.shapes.iter().enumerate();
        let of_things =
            shapes.filter(|(shape, _)| people.iter().all(|it| !it.shapes.contains(shape)));
        let touchers = of_things.filter_map(|(shape, plan)| {
            let body = plan.body?;
            let inertia = layout.bodies[body].inertia;
            Some(Self {
                shape,
                body,
                reach_m: reach_m(&plan.form)?,
                centre_m: inertia.map_or([0.0; 3], |inertia| inertia.centre_m),
            })
        });
        touchers.collect()
    }

    fn middle(&self, physics: &dyn Physics, layout: &Layout) -> Vector {
        let pose = physics.body_pose(self.body);
        pose.then(&layout.shapes[self.shape].pose).position_m
    }

    /// The body of the shape.
    pub(super) fn body(&self) -> usize {
        self.body
    }
}

/// The engine leaves to the skin what touches it.
pub(super) fn keep_apart(layout: &mut Layout, people: &[BuiltPerson]) {
    let mut bodies: Vec<usize> = Toucher::of(layout, people)
        .iter()
        .map(Toucher::body)
        .collect();
    bodies.dedup();
    for person in people {
        for part in person.compliant.iter().flat_map(Compliant::bodies) {
            layout
                .no_contact
                .extend(bodies.iter().map(|body| [part, *body]));
        }
    }
}

/// A vector, shortened to a size if it is longer.
fn at_most(vector: Vector, most: f64) -> Vector {
    let size = norm(vector);
    match size > most {
        true => scale(most / size, vector),
        false => vector,
    }
}

/// Adds to what is applied to a body.
fn push(physics: &mut dyn Physics, body: usize, force_newtons: Vector, torque_nm: Vector) {
    let [force, torque] = physics.applied(body);
    physics.apply(body, add(force, force_newtons), add(torque, torque_nm));
}

/// The radius of a sphere about a form's origin that holds it; `None` of the ground.
fn reach_m(form: &Form) -> Option<f64> {
    Some(match form {
        Form::Ground => return None,
        Form::Box { edges_m } => norm(*edges_m) / 2.0,
        Form::Sphere { radius_m } => *radius_m,
        Form::Capsule { radius_m, length_m } => radius_m + length_m / 2.0,
        Form::Cylinder { radius_m, length_m } => radius_m.hypot(length_m / 2.0),
        Form::Ellipsoid { radii_m } => radii_m.iter().copied().fold(0.0, f64::max),
        Form::Hull { points_m } => points_m.iter().map(|it| norm(*it)).fold(0.0, f64::max),
    })
}

/// The region of a part: `left_hand` is a `hand`.
fn region_of(part: &str) -> BodyRegion {
    let name = part
        .strip_prefix("left_")
        .or_else(|| part.strip_prefix("right_"))
        .unwrap_or(part);
    let found = REGIONS.iter().find(|region| region.name == name);
    *found.expect("each part of a compliant person is of a region")
}

/// Mass and skin of a region, as the scene has them or as the specification does.
fn own(
    of: &Compliance,
    region: &BodyRegion,
    drawn: &dyn Fn(&str, &Distribution) -> f64,
) -> (f64, f64) {
    let number = |table: &str, own: Option<&Distribution>, otherwise: f64| {
        own.map_or(otherwise, |own| {
            drawn(&format!("{table}.{}", region.name), own)
        })
    };
    (
        number("mass_kg", of.mass_kg.get(region.name), region.mass_kg),
        number("skin_n_mm", of.skin_n_mm.get(region.name), region.skin_n_mm),
    )
}
