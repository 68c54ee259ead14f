//! Whether hand and object are so far apart that they cannot touch within the next steps.
//!
//! The hand's shapes are covered by capsules in their joints' frames (a box by slices along its longest
//! edge), the object is the capsule that fingers touch. Two capsules are apart when the distance of
//! their axes exceeds the sum of their radii; a margin covers the way of several time steps.

use testbench::geometry::{
    IDENTITY, Pose, Vector, add, distance_of_pieces, inverse, norm, rotate, scale, subtract,
};

use super::body::{Blueprint, Configuration};
use super::joints::DrivenJoint;
use super::tree::{Frames, Tree};
use crate::scenario::Shape;

/// Apart by less than this, hand and object may touch in the next step: the way of two at 0.5 m/s.
const MARGIN_M: f64 = 0.002;

/// A capsule: the ends of its axis and its radius.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Capsule {
    ends_m: [Vector; 2],
    radius_m: f64,
    /// Whether it is a slice of a box.
    is_of_box: bool,
}

impl Capsule {
    /// The cylinder along its z axis that fingers touch, with rounded ends beyond its own.
    fn of_object(pose: &Pose, half_length_m: f64, radius_m: f64) -> Self {
        let end = |z: f64| add(pose.position_m, rotate(pose.orientation, [0.0, 0.0, z]));
        Self {
            ends_m: [end(-half_length_m), end(half_length_m)],
            radius_m,
            is_of_box: false,
        }
    }
}

/// The hand's shapes, each in the frame of the joint that moves it, and the object in the world.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Clearance {
    hand: Vec<(usize, Capsule)>,
    /// Boxes among them: the pose in that frame and half the edges.
    boxes: Vec<(usize, Pose, Vector)>,
    /// A ball around all of these wherever their joints turn them, in the hand's frame: mostly that is
    /// clear.
    around: (usize, Capsule),
    object: Capsule,
    half_length_m: f64,
}

impl Clearance {
    /// `shapes` are the hand's, each with the node of the tree that carries it and the pose of its centre
    /// in that node's frame; the object is a cylinder along its z axis.
    fn new(
        shapes: impl Iterator<Item = (Shape, usize, Pose)>,
        tree: &Tree,
        object: &Pose,
        length_m: f64,
        radius_m: f64,
    ) -> Self {
        let shapes: Vec<(Shape, usize, Pose)> = shapes.collect();
        let boxes = shapes.iter().filter_map(|(shape, node, pose)| match shape {
            Shape::Box { box_m } => Some((*node, *pose, scale(0.5, *box_m))),
            _ => None,
        });
        let boxes = boxes.collect();
        let hand: Vec<(usize, Capsule)> = (shapes.into_iter())
            .flat_map(|(shape, node, pose)| {
                cover(&shape, &pose).into_iter().map(move |it| (node, it))
            })
            .collect();
        Self {
            around: (tree.hand.0, ball_around(&hand, tree)),
            hand,
            boxes,
            object: Capsule::of_object(object, length_m / 2.0, radius_m),
            half_length_m: length_m / 2.0,
        }
    }

    /// The hand against the object as it stands `now`.
    pub(super) fn of(
        blueprint: &Blueprint,
        joints: &[DrivenJoint],
        now: &Configuration,
        tree: &Tree,
    ) -> Self {
        let scenario = &blueprint.scenario;
        let shapes = scenario.bodies.iter().filter_map(|link| {
            let (node, pose) = tree.place_of(scenario, joints, now, link);
            let centre = pose.then(&Pose {
                position_m: link.shape_position_m,
                orientation: IDENTITY,
            });
            Some((link.contact_shape?, node?, centre))
        });
        let size = &scenario.object;
        Self::new(shapes, tree, &now.object.pose, size.length_m, size.radius_m)
    }

    /// How far each part is from the object at a pose.
    pub(super) fn gaps(&self, frames: &Frames, object: &Pose) -> impl Iterator<Item = Gap> {
        let object = Capsule::of_object(object, self.half_length_m, self.object.radius_m);
        let round = self.hand.iter().filter(|(_, part)| !part.is_of_box);
        let round = round.map(move |(node, part)| {
            let frame = &frames.joints[*node];
            let place = |end| add(frame.position_m, rotate(frame.orientation, end));
            let part = Capsule {
                ends_m: part.ends_m.map(place),
                ..*part
            };
            let axes_m = distance_of_pieces(part.ends_m, object.ends_m);
            Gap {
                node: *node,
                apart_m: axes_m - part.radius_m - object.radius_m,
                part,
            }
        });
        let boxes = self.boxes.iter().map(move |(node, pose, half_m)| {
            let pose = frames.joints[*node].then(pose);
            let part = Capsule {
                ends_m: [pose.position_m; 2],
                radius_m: norm(*half_m),
                is_of_box: true,
            };
            Gap {
                node: *node,
                apart_m: box_to_piece_m(&pose, *half_m, object.ends_m) - object.radius_m,
                part,
            }
        });
        round.chain(boxes)
    }

    /// Whether nothing can touch soon with the joints there.
    pub(super) fn is_clear(&self, frames: &Frames) -> bool {
        let are_clear = |frame: &Pose, parts: &[(usize, Capsule)]| {
            let back = inverse(frame.orientation);
            let object_m = self
                .object
                .ends_m
                .map(|end| rotate(back, subtract(end, frame.position_m)));
            parts.iter().all(|(_, part)| {
                let apart_m = distance_of_pieces(part.ends_m, object_m);
                apart_m > part.radius_m + self.object.radius_m + MARGIN_M
            })
        };
        are_clear(&frames.hand.pose, &[self.around])
            || (self.hand.chunk_by(|(a, _), (b, _)| a == b))
                .all(|parts| are_clear(&frames.joints[parts[0].0], parts))
    }
}

/// A part of the hand and how far it is from the object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gap {
    /// The node that carries it.
    pub(super) node: usize,
    /// Negative where they touch.
    pub(super) apart_m: f64,
    /// It, or what is around it, in the world.
    part: Capsule,
}

impl Gap {
    /// How far it reaches from a frame's origin.
    pub(super) fn reach_m(&self, frame: &Pose) -> f64 {
        let far_m = self
            .part
            .ends_m
            .map(|end| norm(subtract(end, frame.position_m)));
        far_m[0].max(far_m[1]) + self.part.radius_m
    }
}

/// A ball that holds all capsules, wherever the joints beyond the hand's turn them, in its frame.
fn ball_around(parts: &[(usize, Capsule)], tree: &Tree) -> Capsule {
    let (hand, pose) = &tree.hand;
    let in_hand = |point| rotate(inverse(pose.orientation), subtract(point, pose.position_m));
    // What turns with the hand has its place there; of what turns beyond it, its joint has.
    let root = |mut node: usize, mut point: Vector, mut beyond_m: f64| {
        while node != *hand
            && let Some(parent) = tree.nodes[node].parent
        {
            beyond_m += norm(point);
            point = tree.nodes[node].pose.position_m;
            node = parent;
        }
        (in_hand(point), beyond_m)
    };
    let roots: Vec<(Vector, f64)> = (parts.iter())
        .flat_map(|(node, part)| part.ends_m.map(|end| root(*node, end, part.radius_m)))
        .collect();
    let sum_m = roots.iter().fold([0.0; 3], |sum, (at, _)| add(sum, *at));
    let centre_m = scale(1.0 / roots.len().max(1) as f64, sum_m);
    let reach_m = |(at, beyond_m): &(Vector, f64)| norm(subtract(*at, centre_m)) + beyond_m;
    Capsule {
        ends_m: [centre_m; 2],
        is_of_box: false,
        radius_m: roots.iter().map(reach_m).fold(0.0, f64::max),
    }
}

/// The distance of a straight piece from a box at a pose. That of a point of the piece is a convex
/// function of its place, so the least is found by thirds.
fn box_to_piece_m(pose: &Pose, half_m: Vector, ends_m: [Vector; 2]) -> f64 {
    const THIRDS: usize = 60;
    let back = inverse(pose.orientation);
    let [from, to] = ends_m.map(|end| rotate(back, subtract(end, pose.position_m)));
    let far_m = |share: f64| {
        let point = add(from, scale(share, subtract(to, from)));
        let beyond: Vector = std::array::from_fn(|k| (point[k].abs() - half_m[k]).max(0.0));
        norm(beyond)
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..THIRDS {
        let third = (high - low) / 3.0;
        match far_m(low + third) < far_m(high - third) {
            true => high -= third,
            false => low += third,
        }
    }
    far_m((low + high) / 2.0)
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
            is_of_box: matches!(shape, Shape::Box { .. }),
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
    use testbench::geometry::about;

    fn at(position_m: Vector) -> Pose {
        Pose {
            position_m,
            orientation: IDENTITY,
        }
    }

    /// A hand of one finger joint about z at x = 0.1, in a frame that slides nowhere.
    fn tree() -> (Tree, impl Fn(Vector, f64) -> Frames) {
        let tree = Tree::of_nodes(&[(None, [0.0; 3]), (Some(0), [0.1, 0.0, 0.0])]);
        let frames = {
            let tree = tree.clone();
            move |hand_m: Vector, angle_rad: f64| {
                let mut moved = tree.clone();
                moved.nodes[0].pose.position_m = hand_m;
                let mut frames = moved.frames();
                moved.follow_into(|node| ([0.0, angle_rad][node], 0.0), &mut frames);
                frames
            }
        };
        (tree, frames)
    }

    #[test]
    fn a_finger_is_clear_until_the_margin_wherever_it_turns() {
        let finger = Shape::Capsule {
            capsule_length_m: 0.06,
            capsule_radius_m: 0.005,
        };
        let (tree, frames) = tree();
        let parts = [(finger, 1, at([0.0, 0.025, 0.0]))];
        let object = at([1.0, 0.0, 0.0]);
        let clearance = Clearance::new(parts.into_iter(), &tree, &object, 0.4, 0.03);
        // The hand at x, the finger's joint at x + 0.1, the object's axis at 1; radii 0.035, margin 0.002.
        let is_clear = |hand_m, angle_rad| clearance.is_clear(&frames(hand_m, angle_rad));
        assert!(is_clear([0.862, 0.0, 0.0], 0.0));
        assert!(!is_clear([0.864, 0.0, 0.0], 0.0));
        assert!(is_clear([0.864, 0.0, 0.5], 0.0), "above it");
        // Turned by a right angle its axis reaches 0.05 towards the object, or away from it.
        assert!(!is_clear([0.82, 0.0, 0.0], -std::f64::consts::FRAC_PI_2));
        assert!(is_clear([0.85, 0.0, 0.0], std::f64::consts::FRAC_PI_2));
    }

    #[test]
    fn a_ball_around_a_hand_holds_all_of_it_wherever_it_turns() {
        let stick = |ends_m, radius_m| Capsule {
            ends_m,
            radius_m,
            is_of_box: false,
        };
        let hand = [
            (0, stick([[0.0; 3], [0.1, 0.0, 0.0]], 0.02)),
            (1, stick([[0.0; 3], [0.0, 0.05, 0.1]], 0.01)),
        ];
        let (tree, frames) = tree();
        let ball = ball_around(&hand, &tree);
        for turn in 0..12 {
            let frames = frames([0.0; 3], f64::from(turn));
            for (node, part) in &hand {
                for end in part.ends_m {
                    let frame = &frames.joints[*node];
                    let end = add(frame.position_m, rotate(frame.orientation, end));
                    let far_m = norm(subtract(end, ball.ends_m[0])) + part.radius_m;
                    assert!(far_m <= ball.radius_m + 1e-15, "{far_m}");
                }
            }
        }
        // It is not the whole of space: the finger's tip comes within a centimetre or two of its skin.
        assert!(ball.radius_m < 0.19, "{}", ball.radius_m);
    }

    #[test]
    fn a_box_is_as_far_from_a_piece_as_its_nearest_face_edge_or_corner() {
        let turned = Pose {
            position_m: [0.3, -0.2, 0.1],
            orientation: about([1.0, 2.0, 0.5], 0.9),
        };
        let half_m = [0.1, 0.2, 0.3];
        for (ends, wanted) in [
            ([[0.15, -1.0, 0.0], [0.15, 1.0, 0.0]], 0.05),
            ([[0.13, 0.24, -1.0], [0.13, 0.24, 1.0]], 0.05),
            ([[0.12, 0.23, 0.36], [5.0, 5.0, 5.0]], 0.07),
            ([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], 0.0),
        ] {
            let ends = ends.map(|end| add(turned.position_m, rotate(turned.orientation, end)));
            let found = box_to_piece_m(&turned, half_m, ends);
            assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
        }
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
