//! Coriolis and centrifugal torques of a tree of turning joints.
//!
//! Definition: with every motion described by its spin `w` and the velocity `v` of what is at the
//! world's origin, joint `j` about the axis `e` through `p` adds `(e, p x e) s_j` at speed `s_j`. While
//! no joint accelerates, the motion of segment `j` changes by
//!
//! ```text
//! a_j = a_p + V_p x S_j s_j        p what j hangs on, (w, v) x (e, u) = (w x e, w x u + v x e)
//! ```
//!
//! which takes the force `f_j = I_j a_j + V_j x* I_j V_j`, `(w, v) x* (n, f) = (w x n + v x f, w x f)`;
//! a joint's torque is the sum of what its segment and those beyond it take, along its axis: recursive
//! Newton-Euler (Featherstone, "Rigid Body Dynamics Algorithms", 2008, chapter 5), in coordinates of the
//! world. Cost: some hundred operations a joint.

use testbench::geometry::{Vector, add, cross, dot, scale};

use super::branches::Branches;
use super::inertia::Composite;

/// A motion, or how it changes: spin, and velocity at the world's origin. Or a force: torque about the
/// origin, and force.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Screw {
    turn: Vector,
    shift: Vector,
}

impl Screw {
    /// Of unit speed about an axis through a point.
    #[inline]
    fn about(at_m: Vector, axis: Vector) -> Self {
        Self {
            turn: axis,
            shift: cross(at_m, axis),
        }
    }

    #[inline]
    fn times(self, factor: f64) -> Self {
        Self {
            turn: scale(factor, self.turn),
            shift: scale(factor, self.shift),
        }
    }

    #[inline]
    fn plus(self, other: Self) -> Self {
        Self {
            turn: add(self.turn, other.turn),
            shift: add(self.shift, other.shift),
        }
    }

    /// How this motion changes what is fixed in it: another motion.
    #[inline]
    fn moves(self, other: Self) -> Self {
        Self {
            turn: cross(self.turn, other.turn),
            shift: add(cross(self.turn, other.shift), cross(self.shift, other.turn)),
        }
    }

    /// Likewise a momentum.
    #[inline]
    fn carries(self, other: Self) -> Self {
        Self {
            turn: add(cross(self.turn, other.turn), cross(self.shift, other.shift)),
            shift: cross(self.turn, other.shift),
        }
    }

    /// The momentum of a composite in this motion.
    #[inline]
    fn of(self, composite: &Composite) -> Self {
        let (shift, turn) = composite.momenta(self.turn, self.shift);
        Self { turn, shift }
    }
}

/// Works them out.
#[derive(Debug, Clone, Default)]
pub(super) struct Coriolis {
    /// How each segment moves, how that changes, and what it takes.
    moves: Vec<(Screw, Screw)>,
    taken: Vec<Screw>,
}

impl Coriolis {
    /// Takes the torques off `torques_nm`: `axes` are a point on each joint's axis and its direction,
    /// `segments` what turns with a joint and not with the next, both in the world.
    pub(super) fn take_off(
        &mut self,
        torques_nm: &mut [f64],
        branches: &Branches,
        axes: &[(Vector, Vector)],
        segments: &[Composite],
        speed_rad_s: impl Fn(usize) -> f64,
    ) {
        self.moves.clear();
        self.taken.clear();
        for (joint, ((at_m, axis), segment)) in axes.iter().zip(segments).enumerate() {
            let parent = branches.parent(joint).map(|parent| self.moves[parent]);
            let (motion, change) = parent.unwrap_or_default();
            let own = Screw::about(*at_m, *axis).times(speed_rad_s(joint));
            let change = change.plus(motion.moves(own));
            let motion = motion.plus(own);
            self.moves.push((motion, change));
            self.taken
                .push(change.of(segment).plus(motion.carries(motion.of(segment))));
        }
        for (joint, (at_m, axis)) in axes.iter().enumerate().rev() {
            let Screw { turn, shift } = Screw::about(*at_m, *axis);
            let taken = self.taken[joint];
            torques_nm[joint] -= dot(turn, taken.turn) + dot(shift, taken.shift);
            if let Some(parent) = branches.parent(joint) {
                self.taken[parent] = self.taken[parent].plus(taken);
            }
        }
    }
}
