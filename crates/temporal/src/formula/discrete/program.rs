//! A formula as a list of nodes, operands before operators.
//!
//! Negation is pushed down to the atoms, so that every node is monotone in its operands, and equal
//! subformulas become one node. Disjunction, release, "always", "historically" and the weak forms of
//! next and previous are the *duals* of conjunction, until, "eventually", "once", next and previous:
//! a dual node negates what it reads and what it says. So the engines know six temporal operators.
//!
//! * `l <=> r` becomes `(l & r) | (!l & !r)`, its negation `(!l | !r) & (l | r)`; a subformula thus
//!   occurs at most twice, once for each polarity.
//! * `l W r = r R (l | r)`.
//! * `rise(f) = f & !previous f`, `fall(f) = rise(!f)`.

use std::ptr;

use rustc_hash::FxHashMap;

use super::super::ast::{Formula, Interval, Window};
use super::super::settings::{CompileError, TimeModel};
use super::timeline::Span;

/// The position of a node in its program.
pub(super) type NodeId = usize;

/// A program for some formulas.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Program {
    /// Operands stand before their operators.
    pub(super) nodes: Vec<Node>,
}

/// One operator, or the dual of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Node {
    pub(super) op: Op,
    /// Whether operands and result are negated.
    pub(super) dual: bool,
}

/// What a node that is not dual computes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Op {
    /// True.
    Constant,
    /// The atom with this number.
    Atom(usize),
    /// Both operands.
    And(NodeId, NodeId),
    /// The operand at the next sample, and there is one.
    Next(NodeId),
    /// The operand at the sample before, and there is one.
    Previous(NodeId),
    /// The operand somewhere in a window of the future.
    Eventually(Span, NodeId),
    /// The second operand somewhere in a window of the future, and the first from here to before it.
    Until(Span, NodeId, NodeId),
    /// The operand somewhere in a window of the past.
    Once(Span, NodeId),
    /// The second operand somewhere in a window of the past, and the first from after it to here.
    Since(Span, NodeId, NodeId),
}

impl Program {
    pub(super) fn new() -> Self {
        Program { nodes: Vec::new() }
    }

    /// Adds the nodes of `formula` and returns its own.
    pub(super) fn add(&mut self, formula: &Formula) -> Result<NodeId, CompileError> {
        if depth_exceeds(formula, MAX_NESTING) {
            return Err(CompileError::TooDeep);
        }
        Translation {
            program: self,
            done: FxHashMap::default(),
        }
        .translate(formula, true)
    }

    #[cfg(test)]
    fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether some window is measured in seconds.
    pub(super) fn measures_time(&self) -> bool {
        self.nodes.iter().any(|node| {
            matches!(
                node.op,
                Op::Eventually(Span::Seconds { .. }, _)
                    | Op::Until(Span::Seconds { .. }, ..)
                    | Op::Once(Span::Seconds { .. }, _)
                    | Op::Since(Span::Seconds { .. }, ..)
            )
        })
    }

    fn push(&mut self, op: Op, dual: bool) -> NodeId {
        let node = Node { op, dual };
        match self.nodes.iter().position(|other| *other == node) {
            Some(same) => same,
            None => {
                self.nodes.push(node);
                self.nodes.len() - 1
            }
        }
    }
}

/// The translation of one formula.
struct Translation<'p> {
    program: &'p mut Program,
    /// The nodes of the subformulas, by address and polarity: equivalences inside equivalences would
    /// else be translated exponentially often.
    done: FxHashMap<(*const Formula, bool), NodeId>,
}

impl Translation<'_> {
    fn push(&mut self, op: Op, dual: bool) -> NodeId {
        self.program.push(op, dual)
    }

    /// Adds `formula`, or its negation if not `positive`.
    fn translate(&mut self, formula: &Formula, positive: bool) -> Result<NodeId, CompileError> {
        let key = (ptr::from_ref(formula), positive);
        if let Some(&node) = self.done.get(&key) {
            return Ok(node);
        }
        if self.program.nodes.len() > MAX_NODES {
            return Err(CompileError::TooDeep);
        }
        let node = self.translate_afresh(formula, positive)?;
        self.done.insert(key, node);
        Ok(node)
    }

    fn translate_afresh(
        &mut self,
        formula: &Formula,
        positive: bool,
    ) -> Result<NodeId, CompileError> {
        match formula {
            Formula::True => Ok(self.push(Op::Constant, !positive)),
            Formula::False => Ok(self.push(Op::Constant, positive)),
            Formula::Atom(atom) => Ok(self.push(Op::Atom(atom.0), !positive)),
            Formula::Not(inner) => self.translate(inner, !positive),
            Formula::And(operands) => self.all_of(operands, positive, !positive),
            Formula::Or(operands) => self.all_of(operands, positive, positive),
            Formula::Implies(left, right) => {
                let left = self.translate(left, !positive)?;
                let right = self.translate(right, positive)?;
                Ok(self.push(Op::And(left, right), positive))
            }
            Formula::Iff(left, right) => self.equivalence(left, right, positive),
            Formula::Next(inner) => {
                let inner = self.translate(inner, positive)?;
                Ok(self.push(Op::Next(inner), !positive))
            }
            Formula::Previous(inner) => {
                let inner = self.translate(inner, positive)?;
                Ok(self.push(Op::Previous(inner), !positive))
            }
            Formula::Rise(inner) => self.becomes(inner, true, positive),
            Formula::Fall(inner) => self.becomes(inner, false, positive),
            Formula::Eventually(interval, inner) => {
                self.windowed(Op::Eventually, interval, inner, positive, !positive)
            }
            Formula::Always(interval, inner) => {
                self.windowed(Op::Eventually, interval, inner, positive, positive)
            }
            Formula::Once(interval, inner) => {
                self.windowed(Op::Once, interval, inner, positive, !positive)
            }
            Formula::Historically(interval, inner) => {
                self.windowed(Op::Once, interval, inner, positive, positive)
            }
            _ => self.translate_binary(formula, positive),
        }
    }

    /// The temporal operators with two operands.
    fn translate_binary(
        &mut self,
        formula: &Formula,
        positive: bool,
    ) -> Result<NodeId, CompileError> {
        match formula {
            Formula::Until(interval, left, right) => {
                let span = span(interval)?;
                let left = self.translate(left, positive)?;
                let right = self.translate(right, positive)?;
                Ok(self.push(Op::Until(span, left, right), !positive))
            }
            Formula::Release(interval, left, right) => {
                let span = span(interval)?;
                let left = self.translate(left, positive)?;
                let right = self.translate(right, positive)?;
                Ok(self.push(Op::Until(span, left, right), positive))
            }
            Formula::WeakUntil(interval, left, right) => {
                let span = span(interval)?;
                let left = self.translate(left, positive)?;
                let right = self.translate(right, positive)?;
                let either = self.push(Op::And(left, right), positive);
                Ok(self.push(Op::Until(span, right, either), positive))
            }
            Formula::Since(interval, left, right) => {
                let span = span(interval)?;
                let left = self.translate(left, positive)?;
                let right = self.translate(right, positive)?;
                Ok(self.push(Op::Since(span, left, right), !positive))
            }
            // All others were translated by the caller.
            _ => Ok(self.push(Op::Constant, !positive)),
        }
    }

    /// The conjunction of `operands`, each negated if not `positive`, or its dual.
    fn all_of(
        &mut self,
        operands: &[Formula],
        positive: bool,
        dual: bool,
    ) -> Result<NodeId, CompileError> {
        let Some((first, others)) = operands.split_first() else {
            return Ok(self.push(Op::Constant, dual));
        };
        let mut all = self.translate(first, positive)?;
        for other in others {
            let other = self.translate(other, positive)?;
            all = self.push(Op::And(all, other), dual);
        }
        Ok(all)
    }

    fn equivalence(
        &mut self,
        left: &Formula,
        right: &Formula,
        positive: bool,
    ) -> Result<NodeId, CompileError> {
        let left_true = self.translate(left, true)?;
        let left_false = self.translate(left, false)?;
        let right_true = self.translate(right, true)?;
        let right_false = self.translate(right, false)?;
        if positive {
            let both = self.push(Op::And(left_true, right_true), false);
            let neither = self.push(Op::And(left_false, right_false), false);
            Ok(self.push(Op::And(both, neither), true))
        } else {
            let some_false = self.push(Op::And(left_false, right_false), true);
            let some_true = self.push(Op::And(left_true, right_true), true);
            Ok(self.push(Op::And(some_false, some_true), false))
        }
    }

    /// `inner` (or its negation, if not `rises`) here and not before; negated if not `positive`.
    fn becomes(
        &mut self,
        inner: &Formula,
        rises: bool,
        positive: bool,
    ) -> Result<NodeId, CompileError> {
        let here = self.translate(inner, rises == positive)?;
        let before = self.translate(inner, rises != positive)?;
        let before = self.push(Op::Previous(before), positive);
        Ok(self.push(Op::And(here, before), !positive))
    }

    fn windowed(
        &mut self,
        op: fn(Span, NodeId) -> Op,
        interval: &Interval,
        inner: &Formula,
        positive: bool,
        dual: bool,
    ) -> Result<NodeId, CompileError> {
        let span = span(interval)?;
        let inner = self.translate(inner, positive)?;
        Ok(self.push(op(span, inner), dual))
    }
}

/// How deeply formulas may be nested.
const MAX_NESTING: usize = 500;

/// How many nodes a program may have.
const MAX_NODES: usize = 20_000;

fn depth_exceeds(formula: &Formula, limit: usize) -> bool {
    let Some(limit) = limit.checked_sub(1) else {
        return true;
    };
    (formula.operands().into_iter()).any(|operand| depth_exceeds(operand, limit))
}

fn span(interval: &Interval) -> Result<Span, CompileError> {
    Ok(match interval.window(TimeModel::Discrete)? {
        Window::Samples { low, high } => Span::Samples {
            low,
            high: high.unwrap_or(u64::MAX),
        },
        Window::Seconds {
            low_secs,
            high_secs,
        } => Span::Seconds {
            low: low_secs,
            high: high_secs,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_parts_become_one_node() {
        let mut program = Program::new();
        let always = Formula::always(Interval::UNBOUNDED, Formula::atom(0));
        let both = Formula::and(always.clone(), always);
        program.add(&both).unwrap();
        // The atom, "always", and the conjunction.
        assert_eq!(program.len(), 3);
    }

    #[test]
    fn equivalences_do_not_explode() {
        let mut formula = Formula::atom(0);
        for atom in 1..200 {
            formula = Formula::Iff(Box::new(formula), Box::new(Formula::atom(atom)));
        }
        let mut program = Program::new();
        program.add(&formula).unwrap();
        // At most three nodes for each polarity of an equivalence, and two for each atom.
        assert!(program.len() <= 200 * (2 * 3 + 2), "{}", program.len());
    }

    #[test]
    fn deep_formulas_are_refused() {
        let mut formula = Formula::atom(0);
        for _ in 0..10 * MAX_NESTING {
            formula = Formula::not(formula);
        }
        assert_eq!(Program::new().add(&formula), Err(CompileError::TooDeep));
    }
}
