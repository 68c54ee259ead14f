//! The decision diagram of one event alone: only its own nodes, those furthest down first.

use crate::bdd::{BOTTOM, Decision, Diagram, FALSE, Operation, TRUE};
use diagnostic::Problem;

/// How a function depends on a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    /// The variable can only make it true.
    Increasing,
    /// The variable can only make it false.
    Decreasing,
    /// Both happen, or it is not known that they do not.
    Mixed,
}

/// A function as nodes in the order of falling levels, so that children stand before their parents. The first two are the
/// constants.
#[derive(Clone, Debug)]
pub(crate) struct Function {
    pub nodes: Vec<Decision>,
    pub root: u32,
}

impl Function {
    pub fn of(diagram: &Diagram<'_>, root: u32) -> Self {
        let mut reached = diagram.reachable(root);
        reached.sort_by_key(|it| (std::cmp::Reverse(diagram.level(*it)), *it));
        let mut place = vec![0_u32; root as usize + 1];
        if root >= TRUE {
            place[TRUE as usize] = TRUE;
        }
        let mut nodes = vec![diagram.nodes[FALSE as usize], diagram.nodes[TRUE as usize]];
        for index in reached {
            let node = diagram.nodes[index as usize];
            place[index as usize] = nodes.len() as u32;
            nodes.push(Decision {
                level: node.level,
                low: place[node.low as usize],
                high: place[node.high as usize],
            });
        }
        Self {
            nodes,
            root: place[root as usize],
        }
    }

    /// Which variables of `count` the function depends on.
    pub fn support(&self, count: usize) -> Vec<bool> {
        let mut support = vec![false; count];
        for node in self.nodes.iter().filter(|it| it.level != BOTTOM) {
            support[node.level as usize] = true;
        }
        support
    }

    /// The first node whose level is at most this: those before it do not depend on the variable or what is above it.
    pub fn first_up_from(&self, level: u32) -> usize {
        2 + self.nodes[2..].partition_point(|it| it.level > level)
    }
}

/// How the function depends on the variables that are asked about: it increases in one if and only if `low` implies `high` in
/// each of its nodes, since each node is what remains of the function under some assignment of what is above it.
pub(crate) fn directions(
    diagram: &mut Diagram<'_>,
    root: u32,
    asked: &[bool],
) -> Result<Vec<Direction>, Problem> {
    let mut rises = vec![true; asked.len()];
    let mut falls = vec![true; asked.len()];
    for index in diagram.reachable(root) {
        let Decision { level, low, high } = diagram.nodes[index as usize];
        let level = level as usize;
        if asked[level] && (rises[level] || falls[level]) {
            let both = diagram.apply(Operation::And, low, high)?;
            rises[level] &= both == low;
            falls[level] &= both == high;
        }
    }
    let pairs = rises.into_iter().zip(falls);
    Ok(pairs
        .map(|pair| match pair {
            (true, _) => Direction::Increasing,
            (false, true) => Direction::Decreasing,
            (false, false) => Direction::Mixed,
        })
        .collect())
}
