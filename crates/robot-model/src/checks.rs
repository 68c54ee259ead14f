//! What can be seen to be wrong in a finished tree.
//!
//! A rigid body's principal moments are positive and the largest is at most the sum of the others (for a flat body,
//! equal): `I₃ <= I₁ + I₂`. A link that moves needs mass, of its own or of links rigidly fixed to it; otherwise no
//! acceleration follows from a force.

use crate::diagnostics::Place;
use crate::model::{JointKind, Model};
use crate::reader::Reader;
use crate::shape::Inertial;

/// Relative excess that rounding in descriptions explains (they print four digits or so).
const ROUNDING: f64 = 1e-4;

/// Checks one inertia at the place where it stands.
pub(crate) fn inertia(reader: &mut Reader<'_, '_>, place: &Place, link: &str, given: &Inertial) {
    if given.mass_kg < 0.0 {
        let message = format!("link {link} has a negative mass ({} kg)", given.mass_kg);
        reader.problem(place, message, "give a mass of at least 0");
        return;
    }
    let [low, middle, high] = given.principal_moments_kg_m2();
    if given.mass_kg == 0.0 && high.abs() <= 0.0 {
        return;
    }
    let moments = format!("principal moments {low:.4e}, {middle:.4e}, {high:.4e} kg m²");
    if low <= -ROUNDING * high.abs() || (low < 0.0 && high <= 0.0) {
        let message = format!("the inertia of link {link} is not positive definite ({moments})");
        let remedy = "check the signs of the products of inertia and the unit (kg m², not kg mm²)";
        reader.warn(place, message, remedy);
    } else if low + middle < high * (1.0 - ROUNDING) {
        let message = format!(
            "no rigid body has the inertia of link {link}: {moments}, the largest exceeds the sum of the others"
        );
        let remedy = "compute it again from the body's shape, or balance it when writing MJCF";
        reader.warn(place, message, remedy);
    }
}

/// Checks that what moves has mass. `places` are those of the links.
pub(crate) fn moving_masses(reader: &mut Reader<'_, '_>, model: &Model, places: &[Place]) {
    let moves = |link: usize| {
        let mut joints = model.joints_of(link);
        joints.any(|joint| joint.kind != JointKind::Fixed)
    };
    // Masses of links together with everything rigidly fixed to them, from the leaves inwards.
    let mut mass: Vec<f64> = model
        .links
        .iter()
        .map(|link| link.inertial.map_or(0.0, |inertial| inertial.mass_kg))
        .collect();
    for index in (0..model.links.len()).rev() {
        let movable = moves(index);
        if movable && mass[index] <= 0.0 && !model.links[index].kinematic {
            let message = format!("link {} moves, but has no mass", model.links[index].name);
            let remedy = "give it an inertial, or a smallest mass when writing MJCF";
            reader.warn(&places[index], message, remedy);
        }
        if let (false, Some(parent)) = (movable, model.links[index].parent) {
            mass[parent] += mass[index];
        }
    }
}
