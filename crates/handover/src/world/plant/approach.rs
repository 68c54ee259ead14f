//! How soon something of the hand may come upon the object that it holds with other parts.
//!
//! Definition: a part of the hand at the distance `g` from the object, which is round about its axis,
//! comes nearer to it by at most `sum |r_j| l_j + |r_x| + |r_a| l` in a step: `r_j` are the rates of the
//! fingers' joints that move it and `l_j` how far from them it reaches, `r_x` and `r_a` those of the
//! object in the hand, across its axis, and `l` how far the part reaches from its centre. Until they have
//! met takes `g` divided by that; of a part that is nearer than [`UNFELT_M`], or touches, `g` is taken to
//! be that: squeezing fast is no steady motion. Nothing is said of ends that the object's way along its
//! axis brings. Distances are those of [`super::clearance`].

use testbench::geometry::{cross, norm, rotate};

use super::body::{Blueprint, Configuration};
use super::clearance::Clearance;
use super::joints::DrivenJoint;
use super::tree::{Frames, Tree};
use crate::scenario::Drive;

/// How far a part may go on that touches, or nearly: less than a grip presses into a pad.
const UNFELT_M: f64 = 2e-5;

/// The hand's shapes around what they hold.
#[derive(Debug, Clone)]
pub(super) struct Approach {
    tree: Tree,
    frames: Frames,
    clearance: Clearance,
    is_finger: Vec<bool>,
}

impl Approach {
    /// With every joint moving, the object as in `now`; `None` if none of them carries the hand.
    pub(super) fn new(
        blueprint: &Blueprint,
        joints: &[DrivenJoint],
        now: &Configuration,
    ) -> Option<Self> {
        let tree = Tree::new(&blueprint.scenario, joints, now, |_| true)?;
        Some(Self {
            clearance: Clearance::of(blueprint, joints, now, &tree),
            frames: tree.frames(),
            is_finger: joints.iter().map(|it| it.drive == Drive::Hand).collect(),
            tree,
        })
    }

    /// The steps until a part may meet the object: `now` has the object as seen from the hand, and
    /// `rates` are those of all joints (rad a step), of the object's place (m) and of its turn (rad).
    pub(super) fn steps(&mut self, now: &Configuration, rates: &[f64]) -> f64 {
        let angles = &now.positions_rad;
        let nodes = &self.tree.nodes;
        let state = |node: usize| (angles[nodes[node].joint], 0.0);
        self.tree.follow_into(state, &mut self.frames);
        let object = self.frames.hand.pose.then(&now.object.pose);
        let axis = rotate(now.object.pose.orientation, [0.0, 0.0, 1.0]);
        let across = |from: usize| {
            let rate = [rates[from], rates[from + 1], rates[from + 2]];
            norm(cross(axis, rate))
        };
        let (shifts_m, turns_rad) = (across(angles.len()), across(angles.len() + 3));
        let (clearance, frames) = (&self.clearance, &self.frames);
        let gaps = clearance.gaps(frames, &object);
        let steps = gaps.map(|gap| {
            let mut nearer_m = shifts_m + turns_rad * gap.reach_m(&object);
            let mut next = Some(gap.node);
            while let Some(node) = next {
                let joint = nodes[node].joint;
                if self.is_finger[joint] {
                    nearer_m += rates[joint].abs() * gap.reach_m(&frames.joints[node]);
                }
                next = nodes[node].parent;
            }
            gap.apart_m.max(UNFELT_M) / nearer_m
        });
        steps.fold(f64::INFINITY, f64::min)
    }
}
