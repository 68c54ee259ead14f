//! What links bear, of which Rapier's reduced coordinates know nothing: from momenta.
//!
//! Definition: let `P` and `L` be the momentum and the angular momentum about the world's origin of a body and all that hangs on it.
//! By Newton and Euler the body's parent exerts on it, in a time step `h`,
//!
//! ```text
//! F = (P' - P) / h - m g - sum f,     T = (L' - L) / h - c x m g - sum (p x f + t)
//! ```
//!
//! where `f`, `t` are the forces and torques that are applied to these bodies, and those of contacts with all others. Rapier keeps the
//! impulses of a step for each point of contact: along the normal their sum, across it their sum in a basis of its own, and of the last
//! substep the vector in the world, by which that basis is found again.
//!
//! Deviation: velocities are those at the step's ends, contacts act where they were found. Between loose bodies, which are no part of
//! any machine, friction is known of the last substep alone; no link touches so.
//!
//! Guarantee: none of its own; held against theory and against MuJoCo in tests.

use rapier3d_f64::prelude as r;

use super::RapierPhysics;
use super::build::moves;
use crate::geometry::{Pose, Vector, add, cross, dot, inverse, rotate, scale, subtract};
use crate::physics::layout::Layout;
use crate::physics::{Physics, Touch};

/// A body whose wrench is asked for.
#[derive(Debug, Clone)]
pub(super) struct Borne {
    body: usize,
    /// It and all that hangs on it.
    bodies: Vec<usize>,
}

/// Momentum, angular momentum about the world's origin, and the sum of masses times places.
type Momenta = [Vector; 3];

impl Borne {
    /// Those of a layout that move; what is fixed to the world has no joint to bear anything.
    pub(super) fn of(layout: &Layout) -> Vec<Self> {
        let is_carried = |body: usize| {
            let above = std::iter::successors(Some(body), |it| layout.bodies[*it].parent);
            above.take(layout.bodies.len()).any(|it| moves(layout, it))
        };
        let asked = layout.wrenches.iter().filter(|it| is_carried(**it));
        asked
            .map(|body| {
                let mut bodies = vec![*body];
                // Bodies come after their parents.
                for (index, plan) in layout.bodies.iter().enumerate().skip(*body) {
                    if plan.parent.is_some_and(|parent| bodies.contains(&parent)) {
                        bodies.push(index);
                    }
                }
                Self {
                    body: *body,
                    bodies,
                }
            })
            .collect()
    }

    pub(super) fn body(&self) -> usize {
        self.body
    }

    /// Before or after a step.
    pub(super) fn momenta(&self, physics: &RapierPhysics) -> (Pose, Momenta) {
        let mut sum = [[0.0; 3]; 3];
        for body in &self.bodies {
            let Some(inertia) = physics.layout.bodies[*body].inertia else {
                continue;
            };
            let (pose, twist) = (physics.body_pose(*body), physics.body_twist(*body));
            let arm = rotate(pose.orientation, inertia.centre_m);
            let centre = add(pose.position_m, arm);
            let velocity = add(twist.linear_m_s, cross(twist.angular_rad_s, arm));
            let momentum = scale(inertia.mass_kg, velocity);
            let own = rotate(inverse(pose.orientation), twist.angular_rad_s);
            let [xx, yy, zz, xy, xz, yz] = inertia.moments_kg_m2;
            let spin = [
                dot([xx, xy, xz], own),
                dot([xy, yy, yz], own),
                dot([xz, yz, zz], own),
            ];
            let spin = rotate(pose.orientation, spin);
            sum[0] = add(sum[0], momentum);
            sum[1] = add(sum[1], add(cross(centre, momentum), spin));
            sum[2] = add(sum[2], scale(inertia.mass_kg, centre));
        }
        (physics.body_pose(self.body), sum)
    }

    /// Force and torque about the body's origin, in its frame, of the step that began with these momenta.
    pub(super) fn wrench(
        &self,
        physics: &RapierPhysics,
        (pose, before): &(Pose, Momenta),
    ) -> [Vector; 2] {
        let (_, after) = self.momenta(physics);
        let per_sec = 1.0 / physics.layout.time_step_secs;
        let rate = |place: usize| scale(per_sec, subtract(after[place], before[place]));
        let (mut force, mut torque) = (rate(0), rate(1));
        let mass_kg: f64 = self
            .bodies
            .iter()
            .filter_map(|it| physics.layout.bodies[*it].inertia)
            .map(|it| it.mass_kg)
            .sum();
        let down = [0.0, 0.0, -physics.layout.gravity_m_s2];
        force = subtract(force, scale(mass_kg, down));
        let weighs = cross(scale(0.5, add(before[2], after[2])), down);
        torque = subtract(torque, weighs);
        for body in &self.bodies {
            let [applied, turned] = physics.applied(*body);
            let centre_m = physics.layout.bodies[*body]
                .inertia
                .map_or([0.0; 3], |it| it.centre_m);
            let at = physics.body_pose(*body);
            let at = add(at.position_m, rotate(at.orientation, centre_m));
            force = subtract(force, applied);
            torque = subtract(torque, add(cross(at, applied), turned));
        }
        for (touch, friction) in physics.world.touches.iter().zip(&physics.world.frictions) {
            let [first, second] = touch.shapes.map(|shape| self.has(&physics.layout, shape));
            if first == second {
                continue;
            }
            let on_first = subtract(*friction, scale(touch.normal_newtons, touch.normal));
            let pushed = scale(if first { 1.0 } else { -1.0 }, on_first);
            force = subtract(force, pushed);
            torque = subtract(torque, cross(touch.point_m, pushed));
        }
        let back = inverse(pose.orientation);
        let torque = subtract(torque, cross(pose.position_m, force));
        [force, torque].map(|it| rotate(back, it))
    }

    fn has(&self, layout: &Layout, shape: usize) -> bool {
        let body = layout.shapes.get(shape).and_then(|it| it.body);
        body.is_some_and(|body| self.bodies.contains(&body))
    }
}

/// The friction on the first shape of a point of contact, in newtons. `normal` leads from the first to the second.
pub(super) fn friction_of(
    point: &r::ContactData,
    normal: r::Vector,
    touch: &Touch,
    step_secs: f64,
) -> Vector {
    let last = point.warmstart_tangent_impulse;
    let world = point.warmstart_tangent_world;
    let size = last[0] * last[0] + last[1] * last[1];
    if size <= f64::MIN_POSITIVE {
        return [0.0; 3];
    }
    let whole = point.tangent_impulse;
    if whole[0] == 0.0 && whole[1] == 0.0 {
        // Of loose bodies: the last substep's for all.
        let along = super::of_vector(world);
        let length = world.length();
        return scale(touch.tangential_newtons / length, along);
    }
    let first = -normal;
    let across = (world * last[0] - first.cross(world) * last[1]) / size;
    let total = across * whole[0] + first.cross(across) * whole[1];
    scale(1.0 / step_secs, super::of_vector(total))
}
