//! Forms of a layout as Rapier's shapes, and distances between them.

use std::f64::consts::{FRAC_PI_2, PI};

use rapier3d_f64::parry::query;
use rapier3d_f64::prelude as r;

use super::build::refused;
use super::{of_vector, to_vector};
use crate::bench::SimError;
use crate::physics::Nearest;
use crate::physics::layout::{Form, Layout, ShapePlan};

/// Edges around an ellipsoid's polyhedron, and half as many from pole to pole: its surface lies at
/// most 0.5 % of a radius inside the ellipsoid's.
pub(super) const ELLIPSOID_EDGES: usize = 48;

/// A form as Rapier has it: a cylinder lies along its y.
pub(super) struct Shape {
    pub(super) form: r::SharedShape,
    /// The frame of Rapier's form in the layout's.
    pub(super) turn: r::Pose,
}

/// All shapes, in the layout's order.
pub(super) fn of(layout: &Layout) -> Result<Vec<Shape>, SimError> {
    let shapes = layout.shapes.iter();
    shapes
        .map(|shape| {
            check_surface(shape)?;
            let form = form(&shape.form)
                .ok_or_else(|| refused("shape", &shape.name, "it has no volume"))?;
            let turn = match shape.form {
                Form::Cylinder { .. } => r::Pose::rotation(r::Vector::X * FRAC_PI_2),
                _ => r::Pose::IDENTITY,
            };
            Ok(Shape { form, turn })
        })
        .collect()
}

/// Rapier has one softness for all contacts, and friction along surfaces alone.
fn check_surface(shape: &ShapePlan) -> Result<(), SimError> {
    let surface = &shape.surface;
    let reason = if surface.softness.is_some() {
        "its material has a softness of its own, and contacts are equally stiff here: set `simulation.rapier`"
    } else if surface.torsional_m.is_some() || surface.rolling_m.is_some() {
        "its material has friction against turning or rolling, which is not known here"
    } else {
        return Ok(());
    };
    Err(refused("shape", &shape.name, reason))
}

/// `None` where the measures span no volume.
fn form(form: &Form) -> Option<r::SharedShape> {
    let is_solid = match form {
        Form::Box { edges_m } => edges_m.iter().all(|edge| *edge > 0.0),
        Form::Ellipsoid { radii_m } => radii_m.iter().all(|radius| *radius > 0.0),
        Form::Sphere { radius_m } => *radius_m > 0.0,
        Form::Capsule { radius_m, length_m } => *radius_m > 0.0 && *length_m >= 0.0,
        Form::Cylinder { radius_m, length_m } => *radius_m > 0.0 && *length_m > 0.0,
        Form::Ground | Form::Hull { .. } => true,
    };
    if !is_solid {
        return None;
    }
    Some(match form {
        Form::Ground => r::SharedShape::halfspace(r::Vector::Z),
        Form::Box { edges_m } => {
            let [x, y, z] = edges_m.map(|edge| edge / 2.0);
            r::SharedShape::cuboid(x, y, z)
        }
        Form::Sphere { radius_m } => r::SharedShape::ball(*radius_m),
        Form::Capsule { radius_m, length_m } => {
            r::SharedShape::capsule_z(length_m / 2.0, *radius_m)
        }
        Form::Cylinder { radius_m, length_m } => {
            r::SharedShape::cylinder(length_m / 2.0, *radius_m)
        }
        Form::Ellipsoid { radii_m } => r::SharedShape::convex_hull(&ellipsoid(*radii_m))?,
        Form::Hull { points_m } => {
            let points: Vec<r::Vector> = points_m.iter().map(|point| to_vector(*point)).collect();
            r::SharedShape::convex_hull(&points)?
        }
    })
}

/// Points on an ellipsoid, by longitude and latitude.
fn ellipsoid(radii_m: [f64; 3]) -> Vec<r::Vector> {
    let [a, b, c] = radii_m;
    let half = ELLIPSOID_EDGES / 2;
    let mut points = vec![r::Vector::new(0.0, 0.0, c), r::Vector::new(0.0, 0.0, -c)];
    for ring in 1..half {
        let (across, up) = (PI * ring as f64 / half as f64).sin_cos();
        for edge in 0..ELLIPSOID_EDGES {
            let (y, x) = (2.0 * PI * edge as f64 / ELLIPSOID_EDGES as f64).sin_cos();
            points.push(r::Vector::new(a * across * x, b * across * y, c * up));
        }
    }
    points
}

/// Distance between two surfaces, negative when they overlap; `None` if Rapier cannot say.
pub(super) fn distance_m(a: &Shape, at_a: &r::Pose, b: &Shape, at_b: &r::Pose) -> Option<f64> {
    let (form_a, form_b) = (a.form.as_ref(), b.form.as_ref());
    let apart_m = query::distance(at_a, form_a, at_b, form_b).ok()?.distance;
    if apart_m > 0.0 {
        return Some(apart_m);
    }
    let contact = query::contact(at_a, form_a, at_b, form_b, 0.0).ok()?;
    Some(contact.map_or(0.0, |contact| contact.dist.min(0.0)))
}

/// Where two surfaces are nearest within a distance; `None` beyond it, or if Rapier cannot say.
pub(super) fn nearest(
    a: &Shape,
    at_a: &r::Pose,
    b: &Shape,
    at_b: &r::Pose,
    longest_m: f64,
) -> Option<Nearest> {
    let (form_a, form_b) = (a.form.as_ref(), b.form.as_ref());
    let contact = query::contact(at_a, form_a, at_b, form_b, longest_m).ok()??;
    Some(Nearest {
        distance_m: contact.dist,
        points_m: [contact.point1, contact.point2].map(of_vector),
        normal: of_vector(contact.normal1),
    })
}
