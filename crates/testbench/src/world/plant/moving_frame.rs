//! What acts, in a frame that moves, besides the forces: the hand's frame on its way.
//!
//! Definition: in a frame whose origin has the acceleration `a` and which turns at the rate `w` that
//! changes by `w'`, a body of mass `m` and inertia `I` with its centre at `r`, which moves at `v` and
//! turns at `s` against the frame, obeys the equations of a frame at rest with the additional
//!
//! ```text
//! force   F = -m (a + w' x r + w x (w x r) + 2 w x v)
//! torque  T = -(I (w' + w x s) + w x I w + w x I s + s x I w)
//! ```
//!
//! Source: any textbook of mechanics, for example Goldstein, "Classical Mechanics", 3rd edition,
//! section 4.10; the torque is the rate of `I (w + s)` less `I s' + s x I s`. For the fingers `v` and
//! `s` are left out: while the hand is carried they hardly move against it. Cost: 30 operations for
//! each link.

use super::ObjectState;
use super::body::Blueprint;
use super::joints::DrivenJoint;
use crate::geometry::{Pose, Vector, add, cross, dot, inverse, norm, rotate, scale, subtract};
use crate::model::link_inertia_kg_m2;
use crate::mujoco::{BodyId, Simulation};

/// A frame's motion, in its own coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FrameMotion {
    acceleration_m_s2: Vector,
    rate_rad_s: Vector,
    rate_change_rad_s2: Vector,
}

impl FrameMotion {
    /// The motion that takes a frame from `before` to `after` in a time.
    pub(super) fn between(before: &ObjectState, after: &ObjectState, secs: f64) -> Self {
        let own = |vector| rotate(inverse(before.pose.orientation), vector);
        let rate = |from, to| own(scale(1.0 / secs, subtract(to, from)));
        Self {
            acceleration_m_s2: rate(before.velocity_m_s, after.velocity_m_s),
            rate_rad_s: own(before.spin_rad_s),
            rate_change_rad_s2: rate(before.spin_rad_s, after.spin_rad_s),
        }
    }

    /// Force and torque on a body about its centre, from its motion against the frame and its
    /// principal moments.
    pub(super) fn acts_on(&self, mass_kg: f64, moments: Vector, body: &ObjectState) -> [Vector; 2] {
        let (w, change) = (self.rate_rad_s, self.rate_change_rad_s2);
        let (r, s) = (body.pose.position_m, body.spin_rad_s);
        let turning = add(cross(change, r), cross(w, cross(w, r)));
        let against = scale(2.0, cross(w, body.velocity_m_s));
        let acceleration = add(self.acceleration_m_s2, add(turning, against));
        let inertia = |vector| {
            let inner = rotate(inverse(body.pose.orientation), vector);
            let inner = [0, 1, 2].map(|i| moments[i] * inner[i]);
            rotate(body.pose.orientation, inner)
        };
        let rate = add(
            add(inertia(add(change, cross(w, s))), cross(w, inertia(w))),
            add(cross(w, inertia(s)), cross(s, inertia(w))),
        );
        [scale(-mass_kg, acceleration), scale(-1.0, rate)]
    }
}

/// A link that hangs on the hand.
#[derive(Debug, Clone)]
struct HandLink {
    body: BodyId,
    /// The link that it hangs on, if that is not the hand.
    parent: Option<usize>,
    /// Its joint's place in the model, and the joint's unit axis.
    turns: Option<(usize, Vector)>,
    mass_kg: f64,
    centre_m: Vector,
    moments_kg_m2: Vector,
}

/// The links that hang on the hand, each after the one that it hangs on.
#[derive(Debug, Clone, Default)]
pub(super) struct HandLinks(Vec<HandLink>);

impl HandLinks {
    /// `places` says where a joint is in the model.
    pub(super) fn new(
        blueprint: &Blueprint,
        joints: &[DrivenJoint],
        places: &[Option<usize>],
        simulation: &Simulation,
    ) -> Self {
        let links = &blueprint.scenario.bodies;
        let mut open = vec![(&blueprint.scenario.robot.hand, None)];
        let mut found: Vec<HandLink> = Vec::new();
        while let Some((name, parent)) = open.pop() {
            for link in links.iter().filter(|link| link.parent == *name) {
                let Some(body) = simulation.body(&link.name) else {
                    continue;
                };
                let joint = joints.iter().position(|joint| joint.name == link.name);
                let place = joint.and_then(|joint| *places.get(joint)?);
                let axis = link.joint.as_ref().map(|joint| joint.axis);
                found.push(HandLink {
                    body,
                    parent,
                    turns: place.zip(axis.map(|axis| scale(1.0 / norm(axis), axis))),
                    mass_kg: link.mass_kg,
                    centre_m: link.shape_position_m,
                    moments_kg_m2: link_inertia_kg_m2(&blueprint.parameters, link),
                });
                open.push((&link.name, Some(found.len() - 1)));
            }
        }
        Self(found)
    }

    /// Applies to the joints what follows from the motion of the hand's frame, which is the model's
    /// world.
    pub(super) fn apply(&self, motion: &FrameMotion, simulation: &mut Simulation) {
        simulation.joint_forces_mut().fill(0.0);
        // Force and moment about the origin of each link with those that hang on it.
        let mut wrenches = vec![[[0.0; 3]; 2]; self.0.len()];
        for (index, link) in self.0.iter().enumerate().rev() {
            let frame = Pose {
                position_m: simulation.body_position(link.body),
                orientation: simulation.body_quaternion(link.body),
            };
            let centre_m = add(frame.position_m, rotate(frame.orientation, link.centre_m));
            let centre = ObjectState::at_rest(Pose {
                position_m: centre_m,
                ..frame
            });
            let [force, torque] = motion.acts_on(link.mass_kg, link.moments_kg_m2, &centre);
            let moment = add(torque, cross(centre_m, force));
            wrenches[index] = [
                add(wrenches[index][0], force),
                add(wrenches[index][1], moment),
            ];
            let [force, moment] = wrenches[index];
            if let Some((place, axis)) = link.turns {
                let about = subtract(moment, cross(frame.position_m, force));
                let torque_nm = dot(rotate(frame.orientation, axis), about);
                if let Some(applied) = simulation.joint_forces_mut().get_mut(place) {
                    *applied = torque_nm;
                }
            }
            if let Some(parent) = link.parent {
                wrenches[parent][0] = add(wrenches[parent][0], force);
                wrenches[parent][1] = add(wrenches[parent][1], moment);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::IDENTITY;

    /// A body that stands still in the world circles, in a frame that turns about its origin: its
    /// acceleration there is w x (w x r), and its spin -w stays as it is.
    #[test]
    fn what_stands_still_circles_in_a_turning_frame() {
        let w = [0.3, -0.5, 0.9];
        let motion = FrameMotion {
            acceleration_m_s2: [0.0; 3],
            rate_rad_s: w,
            rate_change_rad_s2: [0.0; 3],
        };
        let r = [0.4, 0.2, -0.7];
        let body = ObjectState {
            pose: Pose {
                position_m: r,
                orientation: IDENTITY,
            },
            velocity_m_s: scale(-1.0, cross(w, r)),
            spin_rad_s: scale(-1.0, w),
        };
        let [force, torque] = motion.acts_on(2.0, [0.1; 3], &body);
        let expected = scale(2.0, cross(w, cross(w, r)));
        assert!(norm(subtract(force, expected)) < 1e-12, "{force:?}");
        assert!(norm(torque) < 1e-12, "{torque:?}");
    }

    /// A body that keeps its place in a frame that speeds up is pushed back.
    #[test]
    fn a_frame_that_speeds_up_pushes_back() {
        let at = |velocity_m_s, spin_rad_s| ObjectState {
            velocity_m_s,
            spin_rad_s,
            ..ObjectState::at_rest(crate::world::plant::chain::identity())
        };
        let motion = FrameMotion::between(
            &at([0.0; 3], [0.0; 3]),
            &at([0.02, 0.0, 0.0], [0.0, 0.0, 0.01]),
            0.01,
        );
        let still = ObjectState::at_rest(Pose {
            position_m: [0.0, 0.5, 0.0],
            orientation: IDENTITY,
        });
        // a = 2 along x, w' = 1 about z: w' x r = -0.5 along x; the torque is I w'.
        let [force, torque] = motion.acts_on(3.0, [0.1, 0.2, 0.3], &still);
        assert!(norm(subtract(force, [-4.5, 0.0, 0.0])) < 1e-9, "{force:?}");
        assert!(
            norm(subtract(torque, [0.0, 0.0, -0.3])) < 1e-9,
            "{torque:?}"
        );
    }
}
