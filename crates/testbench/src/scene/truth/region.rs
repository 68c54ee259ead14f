//! Regions, and how deep points and bodies lie in them.
//!
//! Definition: a region is an intersection of half-spaces `n . p <= d` in its frame: six of a cuboid, two and [`SIDES`] of a
//! cylinder, which is a prism around it (its sides are at most 1 - cos(pi / 360) = 4e-5 of the radius too far out). The depth of
//! a point is the least `d - n . p`; a convex body with the support function `h` is wholly in it if `h(n) <= d` for all of them.

use std::f64::consts::TAU;

use crate::geometry::{Pose, Vector, dot, inverse, norm, rotate, subtract};
use crate::physics::{Form, ShapePlan};
use crate::scene::data::Region;

/// Sides of the prism that stands for a cylinder.
const SIDES: usize = 360;

/// A direction and how far the region extends along it.
type HalfSpace = (Vector, f64);

fn half_spaces(region: &Region) -> Vec<HalfSpace> {
    let upright = |radius_m: f64, length_m: f64| {
        let around = (0..SIDES).map(|side| {
            let (sine, cosine) = (TAU * side as f64 / SIDES as f64).sin_cos();
            ([cosine, sine, 0.0], radius_m)
        });
        let ends = [1.0, -1.0].map(|up| ([0.0, 0.0, up], length_m / 2.0));
        around.chain(ends).collect()
    };
    match (region.box_m, region.radius_m, region.length_m) {
        (Some(edges_m), _, _) => (0..6)
            .map(|side| {
                let mut normal = [0.0; 3];
                normal[side / 2] = if side % 2 == 0 { 1.0 } else { -1.0 };
                (normal, edges_m[side / 2] / 2.0)
            })
            .collect(),
        (None, radius_m, length_m) => {
            // The check of the data has seen to it that both are there.
            upright(radius_m.unwrap_or(0.0), length_m.unwrap_or(0.0))
        }
    }
}

/// A region as episodes need it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sides(Vec<HalfSpace>);

impl Sides {
    pub(super) fn new(region: &Region) -> Self {
        Self(half_spaces(region))
    }

    /// How far a point is from the nearest side, negative outside. `frame` is the region's, all in the world.
    pub(super) fn depth_m(&self, frame: &Pose, point_m: Vector) -> f64 {
        let back = inverse(frame.orientation);
        let local = rotate(back, subtract(point_m, frame.position_m));
        let depths = self.0.iter().map(|(normal, far)| far - dot(*normal, local));
        depths.fold(f64::INFINITY, f64::min)
    }

    /// Whether a shape with a frame lies in it as a whole.
    pub(super) fn holds(&self, frame: &Pose, shape: &ShapePlan, at: &Pose) -> bool {
        let local = at.seen_from(frame);
        self.0.iter().all(|(normal, far)| {
            let along = rotate(inverse(local.orientation), *normal);
            dot(*normal, local.position_m) + support_m(&shape.form, along) <= *far
        })
    }
}

/// How far a form extends from its origin along a direction of unit length.
fn support_m(form: &Form, along: Vector) -> f64 {
    let [x, y, z] = along;
    match form {
        Form::Ground => f64::INFINITY,
        Form::Box { edges_m } => {
            let [a, b, c] = *edges_m;
            (x.abs() * a + y.abs() * b + z.abs() * c) / 2.0
        }
        Form::Sphere { radius_m } => *radius_m,
        Form::Capsule { radius_m, length_m } => radius_m + z.abs() * length_m / 2.0,
        Form::Cylinder { radius_m, length_m } => x.hypot(y) * radius_m + z.abs() * length_m / 2.0,
        Form::Ellipsoid { radii_m } => {
            let [a, b, c] = *radii_m;
            norm([x * a, y * b, z * c])
        }
        Form::Hull { points_m } => {
            let far = points_m.iter().map(|point| dot(*point, along));
            far.fold(f64::NEG_INFINITY, f64::max)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{IDENTITY, about};
    use crate::physics::{Surface, Touches};
    use std::f64::consts::FRAC_PI_4;

    fn region(text: &str) -> Region {
        toml::from_str(&format!("name = \"r\"\n{text}")).unwrap()
    }

    fn at(position_m: Vector) -> Pose {
        Pose {
            position_m,
            orientation: IDENTITY,
        }
    }

    #[test]
    fn depth_is_the_distance_to_the_nearest_side() {
        let cuboid = Sides::new(&region("box_m = [2.0, 4.0, 6.0]"));
        assert!((cuboid.depth_m(&at([1.0, 0.0, 0.0]), [1.3, 0.5, 0.0]) - 0.7).abs() < 1e-12);
        assert!((cuboid.depth_m(&at([0.0; 3]), [0.0, 2.5, 0.0]) + 0.5).abs() < 1e-12);
        let can = Sides::new(&region("radius_m = 0.5\nlength_m = 1.0"));
        let deep = can.depth_m(&at([0.0; 3]), [0.3, 0.2, 0.0]);
        assert!((deep - (0.5 - 0.3_f64.hypot(0.2))).abs() < 0.5 * 4e-5);
    }

    #[test]
    fn a_turned_box_needs_the_room_of_its_diagonal() {
        let shape = ShapePlan {
            name: "part".to_owned(),
            body: None,
            pose: at([0.0; 3]),
            form: Form::Box {
                edges_m: [1.0, 1.0, 1.0],
            },
            friction: 0.5,
            touches: Touches::All,
            surface: Surface::default(),
        };
        let turned = Pose {
            position_m: [0.0; 3],
            orientation: about([0.0, 0.0, 1.0], FRAC_PI_4),
        };
        let tray = |edge: f64| Sides::new(&region(&format!("box_m = [{edge}, {edge}, 1.01]")));
        assert!(tray(1.01).holds(&at([0.0; 3]), &shape, &at([0.0; 3])));
        assert!(!tray(1.40).holds(&at([0.0; 3]), &shape, &turned));
        assert!(tray(1.42).holds(&at([0.0; 3]), &shape, &turned));
        // In the frame of a tray that is turned as the part is, it fits again.
        assert!(tray(1.01).holds(&turned, &shape, &turned));
    }
}
