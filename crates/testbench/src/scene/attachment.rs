//! Things that are attached to a robot's link for a time: by a suction cup, by a tool changer, by a declared simplification.
//!
//! Definition: the thing is held at the pose that it had in the link's frame when it was attached, by a spring and a damper in
//! all six directions. At its centre of mass acts `F = M g + k e + d e'`, `e` the way to where it is to be, and the torque
//! `T = k_r r + d_r r'` about it with the weight's own moment; on the link act `-F` at the same point and `-T`, so that momentum
//! and angular momentum are kept. With the time step `h` and the reduced mass `m` of thing and link it is
//! `k = m (p / h)^2`, `d = 2 m p / h`, with `p` = [`STIFFNESS`]: as stiff as an explicit force may be and critically damped, so
//! that it settles within some ten time steps. The same in both engines, which know nothing of it.
//!
//! What is not modelled: a weld has no give. Here a load of `N` newtons besides the weight moves the thing by `N / k`.

use crate::geometry::{Pose, Vector, add, cross, norm, rotate, rotation_between, scale, subtract};
use crate::physics::{Layout, Motion, Physics};

/// The natural frequency times the time step. From 0.6 on a held force of this kind gains energy.
const STIFFNESS: f64 = 0.3;
/// Over which time the force is averaged that is told and that tears something off.
const AVERAGED_SECS: f64 = 0.01;

/// A rigid piece: mass, least moment of inertia; without end for what is fixed to the world.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Inert {
    mass_kg: f64,
    moment_kg_m2: f64,
}

/// Something attached.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Attachment {
    /// The link's body, and that of the thing's root.
    pub(super) holder: usize,
    pub(super) held: usize,
    /// Where the thing is to be in the link's frame.
    at: Pose,
    /// The thing's bodies: mass and centre of mass.
    bodies: Vec<(usize, f64, Vector)>,
    centre_m: Vector,
    holder_centre_m: Vector,
    stiffness: [f64; 2],
    damping: [f64; 2],
    gravity_m_s2: f64,
    step_secs: f64,
    /// The mean force on the thing, in the world.
    pub(super) force_newtons: Vector,
}

impl Attachment {
    /// Attaches a thing where it is.
    pub(super) fn new(layout: &Layout, physics: &dyn Physics, holder: usize, held: usize) -> Self {
        let (link, thing) = (inert(layout, holder), inert(layout, held));
        let reduced = |a: f64, b: f64| if a.is_finite() { a * b / (a + b) } else { b };
        let step_secs = layout.time_step_secs;
        let inertias = [
            reduced(link.mass_kg, thing.mass_kg),
            reduced(link.moment_kg_m2, thing.moment_kg_m2),
        ];
        let rate = STIFFNESS / step_secs;
        let bodies = below(layout, held);
        let mass_kg: f64 = bodies.iter().map(|(_, mass_kg, _)| mass_kg).sum();
        let centre = |body: usize| {
            layout.bodies[body]
                .inertia
                .map_or([0.0; 3], |it| it.centre_m)
        };
        Self {
            holder,
            held,
            at: physics
                .body_pose(held)
                .seen_from(&physics.body_pose(holder)),
            centre_m: centre(held),
            holder_centre_m: centre(holder),
            stiffness: inertias.map(|it| it * rate * rate),
            damping: inertias.map(|it| 2.0 * it * rate),
            gravity_m_s2: layout.gravity_m_s2,
            step_secs,
            force_newtons: [0.0, 0.0, mass_kg * layout.gravity_m_s2],
            bodies,
        }
    }

    /// Adds the forces of the coming step to what is applied to both.
    pub(super) fn pull(&mut self, physics: &mut dyn Physics) {
        let (link, thing) = (physics.body_pose(self.holder), physics.body_pose(self.held));
        let (moves, moved) = (
            physics.body_twist(self.holder),
            physics.body_twist(self.held),
        );
        let wanted = link.then(&self.at);
        let centre_of = |pose: &Pose| add(pose.position_m, rotate(pose.orientation, self.centre_m));
        let centre = centre_of(&thing);
        let velocity_at = |of: &crate::physics::Twist, origin: Vector| {
            let arm = subtract(centre, origin);
            add(of.linear_m_s, cross(of.angular_rad_s, arm))
        };
        let way = subtract(centre_of(&wanted), centre);
        let speed = subtract(
            velocity_at(&moves, link.position_m),
            velocity_at(&moved, thing.position_m),
        );
        let turn = rotation_between(thing.orientation, wanted.orientation);
        let turning = subtract(moves.angular_rad_s, moved.angular_rad_s);
        let [weight, moment] = self.weight(physics, centre);
        let law = |kind: usize, way: Vector, speed: Vector| {
            add(
                scale(self.stiffness[kind], way),
                scale(self.damping[kind], speed),
            )
        };
        let force = add(weight, law(0, way, speed));
        let torque = add(moment, law(1, turn, turning));
        let link_centre = add(
            link.position_m,
            rotate(link.orientation, self.holder_centre_m),
        );
        let arm = subtract(centre, link_centre);
        put(physics, self.held, force, torque);
        let back = scale(-1.0, force);
        put(
            physics,
            self.holder,
            back,
            subtract(cross(arm, back), torque),
        );
        let share = (self.step_secs / AVERAGED_SECS).min(1.0);
        let change = subtract(force, self.force_newtons);
        self.force_newtons = add(self.force_newtons, scale(share, change));
    }

    /// What bears the thing's weight: the force, and its moment about a point.
    fn weight(&self, physics: &dyn Physics, about: Vector) -> [Vector; 2] {
        let mut sums = [[0.0; 3]; 2];
        for (body, mass_kg, centre_m) in &self.bodies {
            let pose = physics.body_pose(*body);
            let centre = add(pose.position_m, rotate(pose.orientation, *centre_m));
            let up = [0.0, 0.0, mass_kg * self.gravity_m_s2];
            sums[0] = add(sums[0], up);
            sums[1] = add(sums[1], cross(subtract(centre, about), up));
        }
        sums
    }

    /// What it is pulled with besides its weight: the force on the holder, in the world.
    pub(super) fn pull_newtons(&self) -> Vector {
        let mass_kg: f64 = self.bodies.iter().map(|(_, mass_kg, _)| mass_kg).sum();
        let weight = [0.0, 0.0, mass_kg * self.gravity_m_s2];
        subtract(weight, self.force_newtons)
    }

    /// How stiff its spring is.
    pub(super) fn stiffness_n_m(&self) -> f64 {
        self.stiffness[0]
    }

    /// The size of the force by which it is held.
    pub(super) fn newtons(&self) -> f64 {
        norm(self.force_newtons)
    }
}

fn put(physics: &mut dyn Physics, body: usize, force: Vector, torque: Vector) {
    let [known, turned] = physics.applied(body);
    physics.apply(body, add(known, force), add(turned, torque));
}

/// A body and all that hangs on it: mass and centre of mass.
fn below(layout: &Layout, root: usize) -> Vec<(usize, f64, Vector)> {
    let mut is_below = vec![false; layout.bodies.len()];
    let mut found = Vec::new();
    // Bodies come after their parents.
    for (index, body) in layout.bodies.iter().enumerate() {
        is_below[index] = index == root || body.parent.is_some_and(|parent| is_below[parent]);
        if let Some(inertia) = body.inertia.filter(|_| is_below[index]) {
            found.push((index, inertia.mass_kg, inertia.centre_m));
        }
    }
    found
}

/// The rigid piece that a body is part of.
fn inert(layout: &Layout, mut body: usize) -> Inert {
    const FIXED: Inert = Inert {
        mass_kg: f64::INFINITY,
        moment_kg_m2: f64::INFINITY,
    };
    while layout.bodies[body].motion == Motion::Fixed {
        match layout.bodies[body].parent {
            Some(parent) => body = parent,
            None => return FIXED,
        }
    }
    if layout.bodies[body].motion == Motion::Led {
        return FIXED;
    }
    let mut is_part = vec![false; layout.bodies.len()];
    let mut sum = Inert {
        mass_kg: 0.0,
        moment_kg_m2: 0.0,
    };
    for (index, plan) in layout.bodies.iter().enumerate() {
        let hangs = plan.parent.is_some_and(|parent| is_part[parent]);
        is_part[index] = index == body || (plan.motion == Motion::Fixed && hangs);
        if let Some(inertia) = plan.inertia.filter(|_| is_part[index]) {
            let inertial = robot_model::Inertial {
                mass_kg: inertia.mass_kg,
                centre_m: inertia.centre_m,
                tensor_kg_m2: inertia.moments_kg_m2,
            };
            sum.mass_kg += inertia.mass_kg;
            sum.moment_kg_m2 += inertial.principal_moments_kg_m2()[0].max(0.0);
        }
    }
    sum
}
