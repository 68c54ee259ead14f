//! What a link bears: force and torque at a flange, torque at joints.
//!
//! Definition: the force `F` and the torque `T` about the origin of a link's frame are what the link's
//! parent exerts on it, through the joint between them: by Newton and Euler the rate of change of
//! the momentum of the link and all that hangs on it, less gravity and whatever else pushes them. A
//! flange at `p` measures `F` and `T - p x F` in its own frame. A sensor of a joint with the axis `a`
//! through the point `c` measures `a . (T - c x F)`, of a slide `a . F`: what drive, friction and damping
//! of the joint pass on to the link. At rest a flange that carries the mass `m` bears `m g` upwards.
//!
//! The numbers are those of the last time step. MuJoCo has them of its own, Rapier by that law
//! ([`Physics::wrench`](crate::physics::Physics::wrench)).

use super::measure::{Mount, Scenery};
use crate::geometry::{Vector, cross, dot, inverse, rotate, subtract};
use crate::physics::JointKind;

/// Force (N) and torque (N m) in the frame of the mount; NaN for an engine that does not know them.
pub(super) fn at_flange(scenery: &Scenery<'_>, mount: &Mount) -> Vec<Vec<f64>> {
    let Some([force, torque]) = scenery.physics.wrench(mount.body) else {
        return vec![vec![f64::NAN; 3]; 2];
    };
    let back = inverse(mount.place.orientation);
    let there = about(torque, force, mount.place.position_m);
    [force, there].map(|it| rotate(back, it).to_vec()).to_vec()
}

/// Torques (N m) of hinges and forces (N) of slides.
pub(super) fn at_joints(scenery: &Scenery<'_>, joints: &[usize]) -> Vec<Vec<f64>> {
    let effort = |joint: &usize| {
        let plan = &scenery.built.layout.joints[*joint];
        let Some([force, torque]) = scenery.physics.wrench(plan.body) else {
            return f64::NAN;
        };
        match plan.kind {
            JointKind::Slide => dot(plan.axis, force),
            _ => dot(plan.axis, about(torque, force, plan.anchor_m)),
        }
    };
    vec![joints.iter().map(effort).collect()]
}

/// A torque about the origin as one about another point.
fn about(torque_nm: Vector, force_newtons: Vector, point_m: Vector) -> Vector {
    subtract(torque_nm, cross(point_m, force_newtons))
}
