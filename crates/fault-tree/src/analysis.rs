//! What is asked of one event of a tree.

use diagnostic::{Cancel, Problem};
use stats::Confidence;

use crate::compile::compile;
use crate::function::{Direction, Function, directions};
use crate::order::{Order, ordered};
use crate::tree::{Connective, FaultTree, NodeId, NodeKind};

/// How an event is analysed, and with how much.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// The order of the basic events.
    pub order: Order,
    /// Nodes of decision diagrams that may be made, for the probability and again for the cut sets: about 40 bytes each.
    pub nodes: usize,
    /// Bits that all numbers together may have for an exact rational probability; beyond, it is enclosed by two doubles.
    pub exact_bits: u64,
    /// With which confidence a probability from counts holds, for all counts together.
    pub confidence: Confidence,
}

impl Default for Options {
    /// Small arguments first, four million nodes, 2^28 bits, 95 %.
    fn default() -> Self {
        Self {
            order: Order::default(),
            nodes: 4_000_000,
            exact_bits: 1 << 28,
            confidence: Confidence::P95,
        }
    }
}

/// One event of a tree, ready to be asked: its decision diagram is built.
///
/// Probabilities are in [`Analysis::probability`], cut sets in [`Analysis::cut_sets`], importance in
/// [`Analysis::importance`].
#[derive(Clone, Debug)]
pub struct Analysis<'a> {
    pub(crate) tree: &'a FaultTree,
    /// The basic events by level.
    pub(crate) events: Vec<NodeId>,
    pub(crate) function: Function,
    /// How the event depends on each basic event, by level.
    pub(crate) directions: Vec<Direction>,
    pub(crate) options: Options,
}

impl<'a> Analysis<'a> {
    /// Builds the decision diagram of an event of the tree.
    ///
    /// # Errors
    /// More nodes than allowed (`fault-tree-limit`), and interruption.
    pub fn new(
        tree: &'a FaultTree,
        event: NodeId,
        options: Options,
        cancel: &Cancel,
    ) -> Result<Self, Problem> {
        let events = ordered(tree, event, options.order);
        let (mut diagram, root) = compile(tree, event, &events, options.nodes, cancel)?;
        let function = Function::of(&diagram, root);
        let signs = signs(tree, event);
        let mixed: Vec<bool> = events.iter().map(|it| signs[it.index()] == BOTH).collect();
        // Whether the tree is monotone in spite of its text may take nodes that are not there; then it is not known.
        let found = match mixed.contains(&true) {
            true => match directions(&mut diagram, root, &mixed) {
                Err(problem) if problem.is_interruption() => return Err(problem),
                found => found.ok(),
            },
            false => None,
        };
        let direction = |(level, event): (usize, &NodeId)| match signs[event.index()] {
            BOTH => found.as_ref().map_or(Direction::Mixed, |it| it[level]),
            NEGATIVE => Direction::Decreasing,
            _ => Direction::Increasing,
        };
        let directions = events.iter().enumerate().map(direction).collect();
        Ok(Self {
            tree,
            events,
            function,
            directions,
            options,
        })
    }

    /// Whether no basic event can prevent this one: the tree is coherent, as far as monotony goes. `false` also where that
    /// would take more nodes than are allowed to find out.
    pub fn is_monotone(&self) -> bool {
        let support = self.function.support(self.events.len());
        let mut used = self.directions.iter().zip(support);
        used.all(|(direction, used)| !used || *direction == Direction::Increasing)
    }

    /// The basic events on which this one depends, in the order of the diagram. One that cancels out is not among them.
    pub fn support(&self) -> Vec<NodeId> {
        let support = self.function.support(self.events.len());
        let used = self.events.iter().zip(support).filter(|(_, used)| *used);
        used.map(|(event, _)| *event).collect()
    }

    /// Nodes of the decision diagram.
    pub fn nodes(&self) -> usize {
        self.function.nodes.len() - 2
    }
}

const POSITIVE: u8 = 1;
const NEGATIVE: u8 = 2;
const BOTH: u8 = 3;

/// Through an even number of negations, an odd one, or both: how each node is used, as the text has it.
fn signs(tree: &FaultTree, top: NodeId) -> Vec<u8> {
    let mut signs = vec![0; tree.nodes.len()];
    signs[top.index()] = POSITIVE;
    // Arguments stand before their gates.
    for index in (0..=top.index()).rev() {
        let NodeKind::Gate(connective, arguments) = &tree.nodes[index].kind else {
            continue;
        };
        let sign: u8 = signs[index];
        let passed = match connective {
            Connective::And | Connective::Or | Connective::AtLeast(_) => sign,
            Connective::Not | Connective::Nand | Connective::Nor => {
                (sign & POSITIVE) << 1 | (sign & NEGATIVE) >> 1
            }
            Connective::Xor if sign != 0 => BOTH,
            Connective::Xor => 0,
        };
        arguments.iter().for_each(|it| signs[it.index()] |= passed);
    }
    signs
}
