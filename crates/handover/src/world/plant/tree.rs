//! The robot's moving joints as a tree, and the frames that their angles give them.

use testbench::geometry::{Pose, Vector, about, add, compose, cross, rotate, scale, subtract};

use super::ObjectState;
use super::body::Configuration;
use super::chain::{frame_in_parent, identity, unit};
use super::joints::DrivenJoint;
use crate::scenario::{Body as Link, Scenario};

/// A joint that moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Node {
    /// Its place among all joints.
    pub(super) joint: usize,
    /// The node that it hangs on, which comes before it.
    pub(super) parent: Option<usize>,
    /// How the frame behind it stands, at angle 0, in its parent's.
    pub(super) pose: Pose,
    axis: Vector,
}

/// Moving joints, each after the one that it hangs on; the others stand as they did.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tree {
    pub(super) nodes: Vec<Node>,
    /// The node that carries the hand, and the hand in its frame.
    pub(super) hand: (usize, Pose),
}

/// Where the joints and the hand are.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Frames {
    /// The frame behind each joint.
    pub(super) joints: Vec<Pose>,
    /// A point on each joint's axis and its unit direction.
    pub(super) axes: Vec<(Vector, Vector)>,
    /// How each frame moves: spin, and the velocity of its origin.
    moves: Vec<(Vector, Vector)>,
    pub(super) hand: ObjectState,
}

impl Tree {
    /// The joints that `moves` picks; the others stand as in `now`. `None` if none of them carries the
    /// hand.
    pub(super) fn new(
        scenario: &Scenario,
        joints: &[DrivenJoint],
        now: &Configuration,
        moves: impl Fn(&DrivenJoint) -> bool,
    ) -> Option<Self> {
        let mut tree = Self {
            nodes: Vec::new(),
            hand: (0, identity()),
        };
        // Joints are numbered depth first, so that a parent is there before its children.
        let moving = joints.iter().enumerate().filter(|(_, joint)| moves(joint));
        for (index, joint) in moving {
            let link = link(scenario, &joint.name)?;
            let axis = link.joint.as_ref()?.axis;
            let (parent, outer) = tree.place_of_parent(scenario, joints, now, link);
            tree.nodes.push(Node {
                joint: index,
                parent,
                pose: outer.then(&frame_in_parent(link)),
                axis: unit(axis),
            });
        }
        let hand = link(scenario, &scenario.robot.hand)?;
        let (node, pose) = tree.place_of(scenario, joints, now, hand);
        tree.hand = (node?, pose);
        Some(tree)
    }

    /// The node that carries a link, if one does, and the link in its frame or in the world's.
    pub(super) fn place_of(
        &self,
        scenario: &Scenario,
        joints: &[DrivenJoint],
        now: &Configuration,
        link: &Link,
    ) -> (Option<usize>, Pose) {
        let joint = joints.iter().position(|joint| joint.name == link.name);
        let node = (self.nodes.iter()).position(|node| Some(node.joint) == joint);
        if node.is_some() {
            return (node, identity());
        }
        let mut inner = frame_in_parent(link);
        if let (Some(joint), Some(hinge)) = (joint, &link.joint) {
            let turn = about(hinge.axis, now.positions_rad[joint]);
            inner.orientation = compose(inner.orientation, turn);
        }
        let (node, outer) = self.place_of_parent(scenario, joints, now, link);
        (node, outer.then(&inner))
    }

    fn place_of_parent(
        &self,
        scenario: &Scenario,
        joints: &[DrivenJoint],
        now: &Configuration,
        child: &Link,
    ) -> (Option<usize>, Pose) {
        match link(scenario, &child.parent) {
            Some(parent) => self.place_of(scenario, joints, now, parent),
            None => (None, identity()),
        }
    }

    /// Joints about z, each with the one that it hangs on and its place there; the first carries the hand.
    #[cfg(test)]
    pub(super) fn of_nodes(nodes: &[(Option<usize>, Vector)]) -> Self {
        let node = |(joint, (parent, position_m)): (usize, &(Option<usize>, Vector))| Node {
            joint,
            parent: *parent,
            pose: Pose {
                position_m: *position_m,
                ..identity()
            },
            axis: [0.0, 0.0, 1.0],
        };
        Self {
            nodes: nodes.iter().enumerate().map(node).collect(),
            hand: (0, identity()),
        }
    }

    /// Frames at rest, to be followed into.
    pub(super) fn frames(&self) -> Frames {
        Frames {
            joints: Vec::with_capacity(self.nodes.len()),
            axes: Vec::with_capacity(self.nodes.len()),
            moves: Vec::with_capacity(self.nodes.len()),
            hand: ObjectState::at_rest(identity()),
        }
    }

    /// The frames; `state` gives angle and speed of each node.
    pub(super) fn follow_into(&self, state: impl Fn(usize) -> (f64, f64), frames: &mut Frames) {
        frames.joints.clear();
        frames.axes.clear();
        frames.moves.clear();
        for (index, node) in self.nodes.iter().enumerate() {
            let (mut frame, mut spin, velocity) = match node.parent {
                Some(parent) => carried(&frames.joints[parent], &frames.moves[parent], &node.pose),
                None => (node.pose, [0.0; 3], [0.0; 3]),
            };
            let (angle_rad, speed_rad_s) = state(index);
            let in_world = rotate(frame.orientation, node.axis);
            spin = add(spin, scale(speed_rad_s, in_world));
            frame.orientation = compose(frame.orientation, about(node.axis, angle_rad));
            frames.axes.push((frame.position_m, in_world));
            frames.joints.push(frame);
            frames.moves.push((spin, velocity));
        }
        let (node, pose) = &self.hand;
        let (pose, spin_rad_s, velocity_m_s) =
            carried(&frames.joints[*node], &frames.moves[*node], pose);
        frames.hand = ObjectState {
            pose,
            velocity_m_s,
            spin_rad_s,
        };
    }
}

/// A frame fixed in another: its pose, its spin and the velocity of its origin.
#[inline]
fn carried(outer: &Pose, moves: &(Vector, Vector), inner: &Pose) -> (Pose, Vector, Vector) {
    let pose = outer.then(inner);
    let lever = subtract(pose.position_m, outer.position_m);
    let (spin, velocity) = *moves;
    (pose, spin, add(velocity, cross(spin, lever)))
}

fn link<'a>(scenario: &'a Scenario, name: &str) -> Option<&'a Link> {
    scenario.bodies.iter().find(|link| link.name == name)
}
