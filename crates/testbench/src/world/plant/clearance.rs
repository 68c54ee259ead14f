//! Whether hand and object are so far apart that they cannot touch within the next steps.
//!
//! The hand's shapes are covered by capsules in the hand's frame (a box by slices along its longest
//! edge), the object is the capsule that fingers touch. Two capsules are apart when the distance of
//! their axes exceeds the sum of their radii; a margin covers the way of several time steps.

use super::body::{Blueprint, Body};
use crate::geometry::{
    IDENTITY, Pose, Vector, add, distance_of_pieces, inverse, norm, rotate, scale, subtract,
};
use crate::scenario::Shape;

/// Apart by less than this, hand and object may touch soon: the way of ten steps at 0.5 m/s.
const MARGIN_M: f64 = 0.01;

/// A capsule: the ends of its axis and its radius.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Capsule {
    ends_m: [Vector; 2],
    radius_m: f64,
}

/// The hand's shapes in its frame, and the object in the world.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Clearance {
    hand: Vec<Capsule>,
    /// A ball around all of these, of no length: mostly that is clear.
    around: Capsule,
    object: Capsule,
}

impl Clearance {
    /// `shapes` are the hand's, each with the pose of its centre in the hand's frame; the object is
    /// a cylinder along its z axis.
    fn new(
        shapes: impl Iterator<Item = (Shape, Pose)>,
        object: &Pose,
        length_m: f64,
        radius_m: f64,
    ) -> Self {
        let half = length_m / 2.0;
        let end = |z: f64| add(object.position_m, rotate(object.orientation, [0.0, 0.0, z]));
        let hand: Vec<Capsule> = shapes
            .flat_map(|(shape, pose)| cover(&shape, &pose))
            .collect();
        Self {
            around: ball_around(&hand),
            hand,
            object: Capsule {
                ends_m: [end(-half), end(half)],
                radius_m,
            },
        }
    }

    /// The hand of `body`, with its frame at `hand`, against the object.
    pub(super) fn of(blueprint: &Blueprint, body: &Body, hand: &Pose, object: &Pose) -> Self {
        let shapes = blueprint.scenario.bodies.iter().filter_map(|link| {
            let pose = body.link(&link.name)?.seen_from(hand);
            let centre = pose.then(&Pose {
                position_m: link.shape_position_m,
                orientation: IDENTITY,
            });
            Some((link.contact_shape?, centre))
        });
        let size = &blueprint.scenario.object;
        Self::new(shapes, object, size.length_m, size.radius_m)
    }

    /// Whether nothing can touch soon with the hand at this pose.
    pub(super) fn is_clear(&self, hand: &Pose) -> bool {
        let back = inverse(hand.orientation);
        let object_m = self
            .object
            .ends_m
            .map(|end| rotate(back, subtract(end, hand.position_m)));
        let is_clear = |part: &Capsule| {
            let apart_m = distance_of_pieces(part.ends_m, object_m);
            apart_m > part.radius_m + self.object.radius_m + MARGIN_M
        };
        is_clear(&self.around) || self.hand.iter().all(is_clear)
    }
}

/// A ball that holds all capsules.
fn ball_around(parts: &[Capsule]) -> Capsule {
    let ends = || parts.iter().flat_map(|part| part.ends_m);
    let sum_m = ends().fold([0.0; 3], add);
    let centre_m = scale(1.0 / (2 * parts.len()).max(1) as f64, sum_m);
    let reach_m = |part: &Capsule| {
        let far_m = part.ends_m.map(|end| norm(subtract(end, centre_m)));
        far_m[0].max(far_m[1]) + part.radius_m
    };
    Capsule {
        ends_m: [centre_m; 2],
        radius_m: parts.iter().map(reach_m).fold(0.0, f64::max),
    }
}

/// Capsules that cover a shape at `pose`.
fn cover(shape: &Shape, pose: &Pose) -> Vec<Capsule> {
    let place = |point| add(pose.position_m, rotate(pose.orientation, point));
    let along = |axis: usize, half: f64, offset: Vector, radius_m: f64| {
        let mut end = [0.0; 3];
        end[axis] = half;
        Capsule {
            ends_m: [place(subtract(offset, end)), place(add(offset, end))],
            radius_m,
        }
    };
    match *shape {
        Shape::Sphere { sphere_radius_m } => vec![along(0, 0.0, [0.0; 3], sphere_radius_m)],
        Shape::Capsule {
            capsule_length_m,
            capsule_radius_m,
        } => {
            let half = capsule_length_m / 2.0 - capsule_radius_m;
            vec![along(1, half, [0.0; 3], capsule_radius_m)]
        }
        Shape::Cylinder {
            cylinder_length_m,
            cylinder_radius_m,
        } => vec![along(
            2,
            cylinder_length_m / 2.0,
            [0.0; 3],
            cylinder_radius_m,
        )],
        Shape::Box { box_m } => slices(box_m)
            .map(|(axis, half, offset, radius_m)| along(axis, half, offset, radius_m))
            .collect(),
    }
}

/// How many slices cover a box across its longest edge.
const SLICES: usize = 4;

/// A box as capsules along its longest edge, side by side along its second: axis, half length,
/// offset of the centre, radius.
fn slices(box_m: Vector) -> impl Iterator<Item = (usize, f64, Vector, f64)> {
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| box_m[*b].total_cmp(&box_m[*a]));
    let [long, wide, thin] = axes;
    let width = box_m[wide] / SLICES as f64;
    (0..SLICES).map(move |slice| {
        let mut offset = [0.0; 3];
        offset[wide] = (slice as f64 + 0.5) * width - box_m[wide] / 2.0;
        let radius_m = (width / 2.0).hypot(box_m[thin] / 2.0);
        (long, box_m[long] / 2.0, offset, radius_m)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::about;

    fn at(position_m: Vector) -> Pose {
        Pose {
            position_m,
            orientation: IDENTITY,
        }
    }

    #[test]
    fn a_finger_is_clear_until_the_margin() {
        let finger = Shape::Capsule {
            capsule_length_m: 0.06,
            capsule_radius_m: 0.005,
        };
        let parts = [(finger, at([0.1, 0.0, 0.0]))];
        let clearance = Clearance::new(parts.into_iter(), &at([1.0, 0.0, 0.0]), 0.4, 0.03);
        // The hand at x: the finger's axis at x + 0.1, the object's at 1; radii 0.035, margin 0.01.
        assert!(clearance.is_clear(&at([0.85, 0.0, 0.0])));
        assert!(!clearance.is_clear(&at([0.86, 0.0, 0.0])));
        assert!(clearance.is_clear(&at([0.86, 0.0, 0.5])), "above it");
    }

    #[test]
    fn a_ball_around_a_hand_holds_all_of_it() {
        let stick = |ends_m, radius_m| Capsule { ends_m, radius_m };
        let hand = [
            stick([[0.0; 3], [0.1, 0.0, 0.0]], 0.02),
            stick([[0.05, 0.2, 0.0], [0.05, 0.2, 0.1]], 0.01),
        ];
        let ball = ball_around(&hand);
        for part in &hand {
            for end in part.ends_m {
                let far_m = norm(subtract(end, ball.ends_m[0])) + part.radius_m;
                assert!(far_m <= ball.radius_m + 1e-15, "{far_m}");
            }
        }
        // It is not the whole of space: the farthest skin lies on it.
        assert!(ball.radius_m < 0.17, "{}", ball.radius_m);
    }

    #[test]
    fn slices_cover_a_box_wholly() {
        let shape = Shape::Box {
            box_m: [0.085, 0.03, 0.08],
        };
        let pose = Pose {
            position_m: [0.3, -0.2, 0.1],
            orientation: about([1.0, 2.0, 0.5], 0.9),
        };
        let parts = cover(&shape, &pose);
        for corner in 0..8 {
            let sign = |bit: usize| if corner >> bit & 1 == 0 { -0.5 } else { 0.5 };
            let point = [0.085 * sign(0), 0.03 * sign(1), 0.08 * sign(2)];
            let point = add(pose.position_m, rotate(pose.orientation, point));
            let inside = parts.iter().any(|part| {
                distance_of_pieces(part.ends_m, [point, point]) <= part.radius_m + 1e-12
            });
            assert!(inside, "{corner}");
        }
    }
}
