//! Reduced ordered binary decision diagrams, with a limit on their nodes.
//!
//! Source: R. E. Bryant, *Graph-based algorithms for Boolean function manipulation*, IEEE Trans. Computers C-35, 1986; for
//! fault trees A. Rauzy, *New algorithms for fault trees analysis*, Reliability Engineering and System Safety 40, 1993.
//!
//! A node is never freed: the limit counts all that were made, which bounds the memory (about 40 bytes a node). The table of
//! results forgets what does not fit; this costs time and changes no result. All walks have their own stacks. The same calls
//! give the same nodes, whatever was asked before elsewhere.

use diagnostic::{Cancel, Problem};
use rustc_hash::FxHashMap;

use crate::results::Results;

/// The function that is false.
pub(crate) const FALSE: u32 = 0;
/// The function that is true.
pub(crate) const TRUE: u32 = 1;
/// The level of the two constants: below all variables.
pub(crate) const BOTTOM: u32 = u32::MAX;
/// Steps between looks at the flag that asks to stop.
const STEPS_BETWEEN_LOOKS: u64 = 4_096;

/// A node: if the variable of this level, then `high`, else `low`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Decision {
    pub level: u32,
    pub low: u32,
    pub high: u32,
}

/// An operation on two functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operation {
    And,
    Or,
    Xor,
}

enum Task {
    Visit(u32, u32),
    Join(u32, u32, u32),
}

/// All functions over one order of the variables.
pub(crate) struct Diagram<'a> {
    pub nodes: Vec<Decision>,
    unique: FxHashMap<Decision, u32>,
    results: Results,
    limit: usize,
    steps: u64,
    cancel: &'a Cancel,
}

impl<'a> Diagram<'a> {
    pub fn new(limit: usize, cancel: &'a Cancel) -> Self {
        let constant = |value| Decision {
            level: BOTTOM,
            low: value,
            high: value,
        };
        Self {
            nodes: vec![constant(FALSE), constant(TRUE)],
            unique: FxHashMap::default(),
            results: Results::new(),
            limit: limit.min(u32::MAX as usize - 1),
            steps: 0,
            cancel,
        }
    }

    pub fn level(&self, function: u32) -> u32 {
        self.nodes[function as usize].level
    }

    /// The function `if level then high else low`; the level is above both.
    pub fn decision(&mut self, level: u32, low: u32, high: u32) -> Result<u32, Problem> {
        if low == high {
            return Ok(low);
        }
        let node = Decision { level, low, high };
        if let Some(known) = self.unique.get(&node) {
            return Ok(*known);
        }
        if self.nodes.len() - 2 >= self.limit {
            let message = format!(
                "the fault tree needs more than the {} nodes of a decision diagram that are allowed",
                self.limit
            );
            return Err(Problem::undecided("fault-tree-limit", message)
                .remedy("allow more nodes, choose another order of the events, or ask for an event further down"));
        }
        let index = self.nodes.len() as u32;
        self.nodes.push(node);
        self.unique.insert(node, index);
        Ok(index)
    }

    /// `left` and, or, exclusive-or `right`.
    pub fn apply(&mut self, operation: Operation, left: u32, right: u32) -> Result<u32, Problem> {
        let mut tasks = vec![Task::Visit(left, right)];
        let mut results: Vec<u32> = Vec::new();
        while let Some(task) = tasks.pop() {
            match task {
                Task::Visit(a, b) => match self.known(operation, a.min(b), a.max(b)) {
                    Some(result) => results.push(result),
                    None => {
                        self.step()?;
                        let (a, b) = (a.min(b), a.max(b));
                        let level = self.level(a).min(self.level(b));
                        let (a_low, a_high) = self.cofactors(a, level);
                        let (b_low, b_high) = self.cofactors(b, level);
                        tasks.push(Task::Join(level, a, b));
                        tasks.push(Task::Visit(a_high, b_high));
                        tasks.push(Task::Visit(a_low, b_low));
                    }
                },
                Task::Join(level, a, b) => {
                    let high = results.pop().expect("the second of two");
                    let low = results.pop().expect("the first of two");
                    let result = self.decision(level, low, high)?;
                    self.results
                        .put((a, b, operation as u8), result, self.nodes.len());
                    results.push(result);
                }
            }
        }
        Ok(results[0])
    }

    /// The function that is true where this one is not.
    pub fn negation(&mut self, function: u32) -> Result<u32, Problem> {
        self.apply(Operation::Xor, function, TRUE)
    }

    fn cofactors(&self, function: u32, level: u32) -> (u32, u32) {
        let node = self.nodes[function as usize];
        match node.level == level {
            true => (node.low, node.high),
            false => (function, function),
        }
    }

    /// The result where it needs no work. `a <= b`, so a constant is `a`.
    fn known(&self, operation: Operation, a: u32, b: u32) -> Option<u32> {
        match (operation, a, b) {
            (Operation::And, FALSE, _) | (Operation::Xor, FALSE, FALSE) => Some(FALSE),
            (Operation::And, TRUE, other) | (Operation::Or | Operation::Xor, FALSE, other) => {
                Some(other)
            }
            (Operation::Or, TRUE, _) => Some(TRUE),
            (Operation::And | Operation::Or, a, b) if a == b => Some(a),
            (Operation::Xor, a, b) if a == b => Some(FALSE),
            _ => self.results.get((a, b, operation as u8)),
        }
    }

    /// Looks from time to time whether the caller asks to stop.
    pub fn step(&mut self) -> Result<(), Problem> {
        self.steps += 1;
        if self.steps.is_multiple_of(STEPS_BETWEEN_LOOKS) && self.cancel.is_cancelled() {
            return Err(Problem::interrupted_while(
                "building the decision diagram of a fault tree",
            ));
        }
        Ok(())
    }

    /// The nodes that a function has, constants left out; arguments stand before those that lead to them.
    pub fn reachable(&self, function: u32) -> Vec<u32> {
        let mut is_reached = vec![false; self.nodes.len().min(function as usize + 1)];
        is_reached[function as usize] = true;
        for index in (2..is_reached.len()).rev() {
            if is_reached[index] {
                let node = self.nodes[index];
                is_reached[node.low as usize] = true;
                is_reached[node.high as usize] = true;
            }
        }
        (2..is_reached.len() as u32)
            .filter(|it| is_reached[*it as usize])
            .collect()
    }
}
