//! Minimal cut sets.
//!
//! A cut set is a set of basic events that together make the event occur; it is minimal if none can be left out. Source:
//! A. Rauzy, *New algorithms for fault trees analysis*, Reliability Engineering and System Safety 40, 1993: for
//! `F = if x then F1 else F0`, the minimal sets are those of `F0`, and `x` with those of `F1` that contain none of `F0`. They
//! are held in a zero-suppressed decision diagram (S. Minato, 1993), whose size has little to do with their number, and
//! counted without being listed.
//!
//! Where the event is monotone, these are its prime implicants. Where it is not, they are its minimal solutions: the
//! smallest sets of basic events such that it occurs if exactly these do. A further one may then prevent it, which
//! [`CutSets::kind`] says.
//!
//! Listing costs the length of a path for each set: at each node it is known which sizes of sets are below it, so no
//! path ends in nothing.

use diagnostic::{Cancel, Problem};
use num_bigint::BigUint;
use num_traits::{One, Zero};

use crate::analysis::Analysis;
use crate::bdd::FALSE;
use crate::families::{EMPTY_SET, Families};
use crate::tree::NodeId;

/// What the sets are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutSetKind {
    /// Minimal cut sets of a monotone event, which are its prime implicants.
    MinimalCutSets,
    /// Minimal solutions of an event that is not (known to be) monotone: it occurs if exactly these basic events do, and may
    /// be prevented by a further one.
    MinimalSolutions,
}

/// The minimal cut sets of an event.
#[derive(Clone, Debug, PartialEq)]
pub struct CutSets {
    /// What they are.
    pub kind: CutSetKind,
    /// How many there are, listed or not.
    pub count: BigUint,
    /// The smallest of them, those of one size in the order of the decision diagram.
    pub sets: Vec<Vec<NodeId>>,
}

impl CutSets {
    /// Whether all are listed.
    pub fn is_complete(&self) -> bool {
        self.count == BigUint::from(self.sets.len())
    }
}

impl Analysis<'_> {
    /// The minimal cut sets: all are counted, and at most so many are listed, the smallest first.
    ///
    /// # Errors
    /// More nodes than allowed (`fault-tree-limit`), and interruption.
    pub fn cut_sets(&self, most: usize, cancel: &Cancel) -> Result<CutSets, Problem> {
        let mut families = Families::new(self.options.nodes, cancel);
        let mut of_nodes = vec![FALSE, EMPTY_SET];
        for node in &self.function.nodes[2..] {
            families.step()?;
            let low = of_nodes[node.low as usize];
            let high = families.without(of_nodes[node.high as usize], low)?;
            of_nodes.push(families.family(node.level, low, high)?);
        }
        let all = of_nodes[self.function.root as usize];
        let listed = families.smallest(all, most)?;
        let events = |set: Vec<u32>| {
            set.into_iter()
                .map(|level| self.events[level as usize])
                .collect()
        };
        Ok(CutSets {
            kind: match self.is_monotone() {
                true => CutSetKind::MinimalCutSets,
                false => CutSetKind::MinimalSolutions,
            },
            count: count(&families, all),
            sets: listed.into_iter().map(events).collect(),
        })
    }
}

fn count(families: &Families<'_>, family: u32) -> BigUint {
    let mut counts = vec![BigUint::zero(), BigUint::one()];
    for node in &families.nodes[2..families.nodes.len().min(family as usize + 1).max(2)] {
        counts.push(&counts[node.low as usize] + &counts[node.high as usize]);
    }
    counts.swap_remove(family as usize)
}
