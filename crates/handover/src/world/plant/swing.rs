//! Fingers so heavy for their dry friction that they swing.

use testbench::geometry::norm;

use super::body::Blueprint;
use super::joints::{DrivenJoint, fingers};
use crate::model;
use crate::scenario::Body as Link;

/// Whether fingers swing when the arm speeds up as fast as its drives do: what that takes, at an arm's
/// length from a joint, is more than half the dry friction of their drives.
pub(super) fn fingers_swing(blueprint: &Blueprint, joints: &[DrivenJoint]) -> bool {
    const REACH_M: f64 = 1.0;
    let parameters = &blueprint.parameters;
    let taken_nm = |link: &Link| {
        let turning_kg_m2 = turning_kg_m2(blueprint, link);
        let lever_m = norm(link.shape_position_m);
        (turning_kg_m2 + link.mass_kg * lever_m * REACH_M) * parameters.arm.acceleration_rad_s2
    };
    let most_nm = of_fingers(blueprint, joints)
        .map(taken_nm)
        .fold(0.0, f64::max);
    most_nm > parameters.hand.friction_loss_nm / 2.0
}

/// How long a finger that was bent takes to be back: twice the time constant with which what its servo
/// brings it back from fades, `2 I / D` if it swings and `D / K` if it creeps.
pub(super) fn fades_secs(blueprint: &Blueprint, joints: &[DrivenJoint]) -> f64 {
    let servo = &blueprint.parameters.hand;
    let constant_secs = |link: &Link| {
        let lever_m = norm(link.shape_position_m);
        let inertia_kg_m2 = turning_kg_m2(blueprint, link) + link.mass_kg * lever_m * lever_m;
        (2.0 * inertia_kg_m2 / servo.damping_nms_rad)
            .max(servo.damping_nms_rad / servo.stiffness_nm_rad)
    };
    let links = of_fingers(blueprint, joints);
    2.0 * links.map(constant_secs).fold(0.0, f64::max)
}

fn of_fingers<'a>(
    blueprint: &'a Blueprint,
    joints: &'a [DrivenJoint],
) -> impl Iterator<Item = &'a Link> {
    let is_finger = |link: &&Link| fingers(joints).any(|index| joints[index].name == link.name);
    blueprint.scenario.bodies.iter().filter(is_finger)
}

/// The largest moment of inertia of a link about its centre.
fn turning_kg_m2(blueprint: &Blueprint, link: &Link) -> f64 {
    let moments = model::link_inertia_kg_m2(&blueprint.parameters, link);
    moments.into_iter().fold(0.0, f64::max)
}
