//! The links from the world to the hand, and the frames that their joints' angles give them.

use testbench::geometry::{
    IDENTITY, Pose, Vector, about, add, compose, cross, from_roll_pitch_yaw, norm, rotate, scale,
    subtract,
};

use super::ObjectState;
use super::joints::DrivenJoint;
use crate::scenario::{Body as Link, Scenario};

/// A stretch of the chain that ends at a joint or at the hand: how the frame at its end stands, at
/// angle 0, in the frame at its beginning.
#[derive(Debug, Clone, PartialEq)]
struct Stretch {
    pose: Pose,
    /// The joint, by its place among all joints, and its unit axis in the frame at the end.
    turns: Option<(usize, Vector)>,
}

/// The links from the world to the hand.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chain(Vec<Stretch>);

impl Chain {
    pub(super) fn to_hand(scenario: &Scenario, joints: &[DrivenJoint]) -> Self {
        let mut links = Vec::new();
        let mut name = scenario.robot.hand.as_str();
        while let Some(link) = scenario.bodies.iter().find(|link| link.name == name) {
            let joint = joints.iter().position(|joint| joint.name == link.name);
            let turns = joint.zip(link.joint.as_ref().map(|joint| unit(joint.axis)));
            links.push((frame_in_parent(link), turns));
            name = &link.parent;
        }
        let mut stretches = Vec::new();
        let mut pose = identity();
        for (next, turns) in links.into_iter().rev() {
            pose = pose.then(&next);
            if turns.is_some() {
                stretches.push(Stretch { pose, turns });
                pose = identity();
            }
        }
        stretches.push(Stretch { pose, turns: None });
        Self(stretches)
    }

    /// The chain's joints, outwards, by their places among all joints.
    pub(super) fn joints(&self) -> impl Iterator<Item = usize> {
        self.0.iter().filter_map(|stretch| Some(stretch.turns?.0))
    }

    /// The chain's end, with its motion; `state` gives angle and speed of the chain's joints, counted
    /// outwards.
    pub(super) fn hand(&self, state: impl Fn(usize) -> (f64, f64)) -> ObjectState {
        let mut frame = identity();
        let (mut spin, mut velocity) = ([0.0; 3], [0.0; 3]);
        for (index, stretch) in self.0.iter().enumerate() {
            let mut next = frame.then(&stretch.pose);
            let lever = subtract(next.position_m, frame.position_m);
            velocity = add(velocity, cross(spin, lever));
            if let Some((_, axis)) = stretch.turns {
                let (angle_rad, speed_rad_s) = state(index);
                let in_world = rotate(next.orientation, axis);
                spin = add(spin, scale(speed_rad_s, in_world));
                next.orientation = compose(next.orientation, about(axis, angle_rad));
            }
            frame = next;
        }
        ObjectState {
            pose: frame,
            velocity_m_s: velocity,
            spin_rad_s: spin,
        }
    }
}

/// The frame that moves nothing.
pub(super) fn identity() -> Pose {
    Pose {
        position_m: [0.0; 3],
        orientation: IDENTITY,
    }
}

pub(super) fn unit(axis: Vector) -> Vector {
    scale(1.0 / norm(axis), axis)
}

/// A link's frame in its parent's, at angle 0.
pub(super) fn frame_in_parent(link: &Link) -> Pose {
    Pose {
        position_m: link.position_m,
        orientation: compose(
            from_roll_pitch_yaw(link.rotation_rpy_rad),
            about(link.fixed_axis, link.fixed_angle_rad),
        ),
    }
}
