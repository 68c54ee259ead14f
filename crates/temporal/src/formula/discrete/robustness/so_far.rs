//! Bounds of the robustness at any time, mostly without finishing a copy of what is at work.
//!
//! # Definition
//! The robust satisfaction interval of a partial trace (J. Deshmukh and others, "Robust online
//! monitoring of signal temporal logic", Formal Methods in System Design 51, 2017): the least
//! and the greatest robustness that any continuation can give; each is that where every subformula
//! is minus, or plus, infinity after the last sample.
//!
//! # Algorithm
//! Finishing a lane gives what its nodes have not given yet. For many formulas that need not be done,
//! since the values that are missing are known to be
//!
//! * none: a node without future operators gives each value at its own sample;
//! * all of them infinite, like what comes after: `eventually[0, w] p` is plus infinity at each sample
//!   whose window is not over if what comes after may be, and so is a disjunction with it.
//!
//! An outermost operator over such nodes keeps a fold, of which the missing values are the
//! last part. Elsewhere a copy of the lane is finished.
//!
//! # Cost and guarantee
//! O(|f|) for formulas such as `always p`, `always (p => eventually[0, w] q)`, `p until q`,
//! unbounded operators inside each other over present and past; otherwise as much as is stored (the
//! windows). The bounds are the same in both cases (tested).

use super::super::program::{Node, NodeId, Op, Program};
use super::super::timeline::Timeline;
use super::{Lane, State, smaller};

/// What the values are that a node has not given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Missing {
    /// There are none.
    None,
    /// All are what comes after.
    AsAfter,
    /// Some are neither.
    Other,
}

/// For each node, what is missing if minus (first) or plus (second) infinity comes after.
pub(super) fn missing(program: &Program) -> Vec<[Missing; 2]> {
    let mut all: Vec<[Missing; 2]> = Vec::with_capacity(program.nodes.len());
    for node in &program.nodes {
        all.push([false, true].map(|above| {
            let of = |operand: NodeId| all[operand][usize::from(above)];
            missing_of(*node, above, of)
        }));
    }
    all
}

fn missing_of(node: Node, above: bool, of: impl Fn(NodeId) -> Missing) -> Missing {
    // A dual node sees what comes after with the other sign.
    let above = above != node.dual;
    let none = |operands: &[NodeId]| operands.iter().all(|it| of(*it) == Missing::None);
    let plain = |operands: &[NodeId]| operands.iter().all(|it| of(*it) != Missing::Other);
    match node.op {
        Op::Constant | Op::Atom(_) => Missing::None,
        Op::And(left, right) | Op::Since(_, left, right) if none(&[left, right]) => Missing::None,
        Op::Previous(operand) | Op::Once(_, operand) if none(&[operand]) => Missing::None,
        Op::And(left, right) if !above && plain(&[left, right]) => Missing::AsAfter,
        Op::Next(operand) if none(&[operand]) => Missing::AsAfter,
        Op::Eventually(_, operand) if above && plain(&[operand]) => Missing::AsAfter,
        _ => Missing::Other,
    }
}

impl Lane {
    /// What [`Lane::close`] would give if every subformula were `after` from now on: plus or minus
    /// infinity.
    pub(in super::super) fn so_far(&self, timeline: &Timeline, after: f64) -> Option<f64> {
        if self.value.is_some() {
            return self.value;
        }
        let at_once = match &self.endless {
            Some(endless) => {
                let above = usize::from(after > 0.0);
                let complete = |leaf: NodeId| self.missing[leaf][above] == Missing::None;
                let all = endless.leaves().all(complete);
                all.then(|| endless.close(Some(after))).flatten()
            }
            None => self.first_so_far(self.root, after),
        };
        at_once.or_else(|| self.clone().close(timeline, Some(after)))
    }

    /// The value of a node at the first sample, if it can be told so.
    fn first_so_far(&self, node: NodeId, after: f64) -> Option<f64> {
        let (Node { op, dual }, state) = &self.nodes[node];
        let sign = if *dual { -1.0 } else { 1.0 };
        let missing = |operand: NodeId| self.missing[operand][usize::from(after > 0.0)];
        match (*op, state) {
            (Op::And(left, right), State::And(pairs)) => {
                let of = |waiting: Option<&f64>, operand| match waiting {
                    Some(value) => Some(*value),
                    None => Some(self.first_so_far(operand, after)? * sign),
                };
                let left = of(pairs.left.front(), left)?;
                let right = of(pairs.right.front(), right)?;
                Some(smaller(left, right) * sign)
            }
            (Op::Eventually(_, operand), State::Ahead(ahead)) => {
                let plain = missing(operand) != Missing::Other;
                Some(ahead.first_so_far(after * sign, plain)? * sign)
            }
            (Op::Until(_, left, right), State::Ahead(ahead)) => {
                let none = [left, right].map(missing) == [Missing::None; 2];
                none.then(|| ahead.first_so_far(after * sign, true))
                    .flatten()
                    .map(|value| value * sign)
            }
            _ => None,
        }
    }
}
