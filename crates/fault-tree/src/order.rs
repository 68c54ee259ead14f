//! The order of the basic events in a decision diagram, on which its size depends.
//!
//! Source: A. Rauzy, *Some disturbing facts about depth-first left-most variable ordering heuristics for binary decision
//! diagrams*, Journal of Risk and Reliability 222, 2008. No heuristic is best for all trees; events that occur together in the
//! tree should stand together.

use crate::tree::{FaultTree, NodeId, NodeKind};

/// How the basic events are ordered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// As a walk in depth meets them, small arguments before large ones; arguments of one size as they are written. (The size
    /// is the number of nodes, those that are shared counted each time.)
    #[default]
    SmallFirst,
    /// As a walk in depth meets them, arguments as they are written.
    LeftMost,
}

/// The basic events below an event, in order.
pub(crate) fn ordered(tree: &FaultTree, top: NodeId, order: Order) -> Vec<NodeId> {
    let sizes = match order {
        Order::SmallFirst => sizes(tree),
        Order::LeftMost => Vec::new(),
    };
    let mut is_met = vec![false; tree.nodes.len()];
    let mut events = Vec::new();
    let mut open = vec![top];
    while let Some(at) = open.pop() {
        if std::mem::replace(&mut is_met[at.index()], true) {
            continue;
        }
        match &tree.node(at).kind {
            NodeKind::Basic(_) => events.push(at),
            NodeKind::House(_) => {}
            NodeKind::Gate(_, arguments) => {
                let first = open.len();
                open.extend(arguments.iter().rev().filter(|it| !is_met[it.index()]));
                if order == Order::SmallFirst {
                    // The last is walked first.
                    open[first..].sort_by_key(|it| std::cmp::Reverse(sizes[it.index()]));
                }
            }
        }
    }
    events
}

fn sizes(tree: &FaultTree) -> Vec<u64> {
    let mut sizes: Vec<u64> = Vec::with_capacity(tree.nodes.len());
    for node in &tree.nodes {
        let size = match &node.kind {
            NodeKind::Basic(_) | NodeKind::House(_) => 1,
            NodeKind::Gate(_, arguments) => {
                let parts = arguments.iter().map(|it| sizes[it.index()]);
                parts.fold(1, u64::saturating_add)
            }
        };
        sizes.push(size);
    }
    sizes
}
