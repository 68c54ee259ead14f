//! Forward kinematics: where every link is, for given positions of the joints.
//!
//! For a link with pose `P` in its parent and joints `1..k` from the parent outwards, its frame in the parent is
//! `P T_1 ... T_k` with `T = Trans(axis (q - q0))` for a slide and `T = Trans(a) Rot(q - q0) Trans(-a)` for a turn about an
//! axis through `a`; a free joint replaces it. The world pose is the product along the path from the root (J. J. Craig,
//! Introduction to Robotics, chapter 3). Cost: linear in links and joints.

use std::fmt;

use crate::model::{Joint, JointKind, Model};
use crate::pose::{Pose, Quaternion, about, normalized, scaled};

/// Why positions do not fit the model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrongSize {
    /// How many numbers the joints have.
    pub needed: usize,
    /// How many were given.
    pub given: usize,
}

impl fmt::Display for WrongSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the joints have {} positions, but {} are given; start from reference_positions()",
            self.needed, self.given
        )
    }
}

impl std::error::Error for WrongSize {}

impl Model {
    /// Numbers in the positions of all joints.
    #[must_use]
    pub fn position_size(&self) -> usize {
        let sizes = self.joints.iter().map(|joint| joint.kind.position_size());
        sizes.sum()
    }

    /// Where the numbers of a joint start in the positions; `None` for a joint without any.
    #[must_use]
    pub fn position_start(&self, joint: usize) -> Option<usize> {
        let own = self.joints.get(joint)?.kind.position_size();
        let before = self.joints[..joint].iter();
        (own > 0).then(|| before.map(|joint| joint.kind.position_size()).sum())
    }

    /// Positions at which every link stands at its `pose_in_parent`.
    #[must_use]
    pub fn reference_positions(&self) -> Vec<f64> {
        let mut positions = Vec::with_capacity(self.position_size());
        for joint in &self.joints {
            match joint.kind {
                JointKind::Fixed => {}
                JointKind::Revolute | JointKind::Prismatic => positions.push(joint.reference),
                JointKind::Ball => positions.extend([1.0, 0.0, 0.0, 0.0]),
                JointKind::Free => {
                    let pose = self.links[joint.link].pose_in_parent;
                    positions.extend(pose.position_m);
                    positions.extend(pose.rotation);
                }
            }
        }
        positions
    }

    /// The frame of every link in the world, in the order of the links.
    ///
    /// `positions` lists the numbers of each joint in the order of [`Model::joints`]; couplings are not applied.
    ///
    /// # Errors
    /// When their number is not [`Model::position_size`].
    pub fn poses(&self, positions: &[f64]) -> Result<Vec<Pose>, WrongSize> {
        let needed = self.position_size();
        if positions.len() != needed {
            return Err(WrongSize {
                needed,
                given: positions.len(),
            });
        }
        let mut local: Vec<Pose> = self.links.iter().map(|link| link.pose_in_parent).collect();
        let mut rest = positions;
        for joint in &self.joints {
            let (own, behind) = rest.split_at(joint.kind.position_size());
            rest = behind;
            local[joint.link] = moved(&local[joint.link], joint, own);
        }
        let mut world: Vec<Pose> = Vec::with_capacity(local.len());
        for (link, local) in self.links.iter().zip(&local) {
            let pose = link
                .parent
                .map_or(*local, |parent| world[parent].then(local));
            world.push(pose);
        }
        Ok(world)
    }
}

/// A link's pose after a joint has moved.
fn moved(before: &Pose, joint: &Joint, position: &[f64]) -> Pose {
    match (joint.kind, position) {
        (JointKind::Prismatic, [q]) => {
            before.then(&Pose::at(scaled(joint.axis, q - joint.reference)))
        }
        (JointKind::Revolute, [q]) => {
            before.then(&turn_about(joint, about(joint.axis, q - joint.reference)))
        }
        (JointKind::Ball, [w, x, y, z]) => {
            before.then(&turn_about(joint, normalized([*w, *x, *y, *z])))
        }
        (JointKind::Free, [px, py, pz, w, x, y, z]) => Pose {
            position_m: [*px, *py, *pz],
            rotation: normalized([*w, *x, *y, *z]),
        },
        _ => *before,
    }
}

fn turn_about(joint: &Joint, rotation: Quaternion) -> Pose {
    let there = Pose::at(joint.anchor_m);
    let back = Pose::at(scaled(joint.anchor_m, -1.0));
    there.then(&Pose::turned(rotation)).then(&back)
}
