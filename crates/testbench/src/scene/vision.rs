//! Cameras: whether a marker is seen and where it is, and images of depth.
//!
//! Definition: a camera looks along the x axis of its mount, y to the left, z up, through a rectangle as
//! a pinhole does. A point `(x, y, z)` in its frame is in view if `x > 0`, `|y| <= x tan(w / 2)` and
//! `|z| <= x tan(h / 2)` for the views `w` and `h`. A marker there is seen if it is moreover within range,
//! its face (if it has one) turned to the camera by no more than its widest angle, no shape stands on the
//! line between, and a draw says that it was detected. Shapes of the link that carries the camera, and
//! of the body that carries the marker, do not stand between: what is on the far side of a body says
//! so by its face. Every other shape does, the robot's own arm included.
//!
//! An image of depth has a ray through the middle of each of its pixels, which are evenly spread over
//! the rectangle; its numbers are distances along the camera's axis, as depth cameras give them, and not
//! along the rays.
//!
//! Deviation: an image is taken at one instant, without blur, distortion or light; a marker is a
//! point, so it is never seen in part.

use super::build::Built;
use super::measure::{Mount, Scenery, pose_of};
use crate::geometry::{Pose, Vector, add, compose, dot, inverse, norm, rotate, scale, subtract};
use crate::physics::Layout;
use crate::random::Stream;

/// How far before a marker a shape has to be to hide it.
const SURFACE_M: f64 = 1e-4;

/// What a camera can see, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct View {
    /// Tangents of half the horizontal and half the vertical view.
    pub(super) half: [f64; 2],
    pub(super) shortest_m: f64,
    pub(super) longest_m: f64,
}

impl View {
    pub(super) fn new(
        horizontal_rad: f64,
        vertical_rad: f64,
        shortest_m: f64,
        longest_m: f64,
    ) -> Self {
        Self {
            half: [horizontal_rad, vertical_rad].map(|view_rad| (view_rad / 2.0).tan()),
            shortest_m,
            longest_m,
        }
    }

    /// What a controller is told of it.
    pub(super) fn facts(&self) -> [(&'static str, f64); 4] {
        let [wide, high] = self.half.map(|tangent| 2.0 * tangent.atan());
        [
            ("horizontal_view_rad", wide),
            ("vertical_view_rad", high),
            ("shortest_m", self.shortest_m),
            ("longest_m", self.longest_m),
        ]
    }

    fn has(&self, [x, y, z]: Vector) -> bool {
        let [wide, high] = self.half;
        let distance_m = norm([x, y, z]);
        x > 0.0
            && y.abs() <= x * wide
            && z.abs() <= x * high
            && (self.shortest_m..=self.longest_m).contains(&distance_m)
    }
}

/// A marker on something in the scene.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Marker {
    carrier: Carrier,
    /// The shapes of what carries it.
    shapes: Vec<usize>,
    /// Where it is in the carrier's frame.
    place_m: Vector,
    /// Where its face looks in the carrier's frame (a unit vector), and the cosine of the widest angle at
    /// which it is seen.
    face: Option<(Vector, f64)>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Carrier {
    Body(usize),
    /// Something that is fixed to the world.
    Fixed(Pose),
}

impl Marker {
    /// The marker on a part of a robot, a person or an object, or on its first body.
    pub(super) fn find(
        layout: &Layout,
        (target, part): (&str, Option<&str>),
        place_m: Vector,
        facing: Option<(Vector, f64)>,
    ) -> Option<Self> {
        let whole = part.map_or_else(|| target.to_owned(), |part| format!("{target}/{part}"));
        let within = format!("{target}/");
        let bodies = || layout.bodies.iter();
        let named = bodies().position(|body| body.name == whole).or_else(|| {
            let first = |name: &str| part.is_none() && name.starts_with(&within);
            bodies().position(|body| first(&body.name))
        });
        let carrier = match named {
            Some(body) => Carrier::Body(body),
            None => {
                let shape = format!("{target}/shape");
                let mut shapes = layout.shapes.iter();
                let fixed = shapes.find(|it| it.body.is_none() && it.name == shape);
                Carrier::Fixed(fixed.filter(|_| part.is_none())?.pose)
            }
        };
        let carries = |name: &str, body: Option<usize>| match carrier {
            Carrier::Body(carrier) => body == Some(carrier),
            Carrier::Fixed(_) => body.is_none() && name.starts_with(&within),
        };
        let shapes = layout.shapes.iter().enumerate();
        Some(Self {
            carrier,
            shapes: shapes
                .filter(|(_, shape)| carries(&shape.name, shape.body))
                .map(|(index, _)| index)
                .collect(),
            place_m,
            face: facing.map(|(face, widest_rad)| {
                (scale(1.0 / norm(face).max(1e-12), face), widest_rad.cos())
            }),
        })
    }

    /// The carrier's frame in the world.
    fn frame(&self, scenery: &Scenery<'_>) -> Pose {
        match self.carrier {
            Carrier::Body(body) => scenery.physics.body_pose(body),
            Carrier::Fixed(pose) => pose,
        }
    }
}

/// `seen`, and in the camera's frame the marker's place (m) and the turn of what carries it (roll, pitch
/// and yaw, rad). One draw, whether or not the marker is in view.
pub(super) fn detect(
    scenery: &Scenery<'_>,
    mount: &Mount,
    view: &View,
    marker: &Marker,
    probability: f64,
    stream: &mut Stream,
) -> [f64; 7] {
    const UNSEEN: [f64; 7] = {
        let none = f64::NAN;
        [0.0, none, none, none, none, none, none]
    };
    let is_detected = stream.chance(probability);
    let at = pose_of(scenery, mount);
    let frame = marker.frame(scenery);
    let point_m = add(frame.position_m, rotate(frame.orientation, marker.place_m));
    let back = inverse(at.orientation);
    let line = subtract(point_m, at.position_m);
    let place = rotate(back, line);
    let distance_m = norm(line).max(1e-12);
    let direction = scale(1.0 / distance_m, line);
    let is_turned_away = marker
        .face
        .is_some_and(|(face, least)| dot(rotate(frame.orientation, face), direction) > -least);
    if !is_detected || !view.has(place) || is_turned_away {
        return UNSEEN;
    }
    let own = |shape: usize| is_of(scenery.built, mount, shape) || marker.shapes.contains(&shape);
    let within_m = distance_m - SURFACE_M;
    let seen = |shape: usize| !own(shape);
    if scenery
        .physics
        .ray(at.position_m, direction, within_m, &seen)
        .is_some()
    {
        return UNSEEN;
    }
    let [roll, pitch, yaw] = angles_of(compose(back, frame.orientation));
    [1.0, place[0], place[1], place[2], roll, pitch, yaw]
}

/// An image of depth, row by row from the top left; NaN where nothing is within range.
pub(super) fn depths(
    scenery: &Scenery<'_>,
    mount: &Mount,
    view: &View,
    [columns, rows]: [usize; 2],
) -> Vec<f64> {
    let at = pose_of(scenery, mount);
    let middle = |index: usize, count: usize| 1.0 - (2 * index + 1) as f64 / count as f64;
    let seen = |shape: usize| !is_of(scenery.built, mount, shape);
    let depth_m = |pixel: usize| {
        let ray = [
            1.0,
            middle(pixel % columns, columns) * view.half[0],
            middle(pixel / columns, rows) * view.half[1],
        ];
        let longer = norm(ray);
        let direction = rotate(at.orientation, scale(1.0 / longer, ray));
        let longest_m = view.longest_m * longer;
        let hit = scenery
            .physics
            .ray(at.position_m, direction, longest_m, &seen);
        let depth_m = hit.map_or(f64::NAN, |hit| hit.distance_m / longer);
        if depth_m < view.shortest_m {
            f64::NAN
        } else {
            depth_m
        }
    };
    (0..columns * rows).map(depth_m).collect()
}

/// Whether a shape is one of the link on which the camera is mounted.
fn is_of(built: &Built, mount: &Mount, shape: usize) -> bool {
    let shape = built.layout.shapes.get(shape);
    shape.is_some_and(|shape| shape.body == Some(mount.body))
}

/// Roll, pitch and yaw: turns about the fixed x, y and z axes, in this order.
fn angles_of(orientation: crate::geometry::Quaternion) -> Vector {
    let [x, y] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|axis| rotate(orientation, axis));
    let z_z = rotate(orientation, [0.0, 0.0, 1.0])[2];
    [
        y[2].atan2(z_z),
        (-x[2]).clamp(-1.0, 1.0).asin(),
        x[1].atan2(x[0]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::from_roll_pitch_yaw;

    #[test]
    fn angles_are_those_that_an_orientation_is_made_of() {
        for angles in [[0.3, -0.7, 2.0], [-2.5, 1.2, -0.4], [0.0; 3]] {
            let found = angles_of(from_roll_pitch_yaw(angles));
            let off = norm(subtract(found, angles));
            assert!(off < 1e-12, "{angles:?} came back as {found:?}");
        }
    }

    #[test]
    fn a_view_ends_at_its_edges() {
        let view = View::new(1.0, 0.6, 0.2, 3.0);
        let at = |bearing: f64, elevation: f64| [2.0, 2.0 * bearing.tan(), 2.0 * elevation.tan()];
        assert!(view.has(at(0.499, 0.299)) && view.has(at(-0.499, -0.299)));
        assert!(!view.has(at(0.501, 0.0)) && !view.has(at(0.0, -0.301)));
        assert!(!view.has([-2.0, 0.0, 0.0]) && !view.has([0.19, 0.0, 0.0]));
        assert!(!view.has([3.01, 0.0, 0.0]) && view.has([3.0, 0.0, 0.0]));
    }
}
