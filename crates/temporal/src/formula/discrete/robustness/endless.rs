//! Robustness of unbounded operators of the future inside each other, in constant memory.
//!
//! # Definition
//! Take the part of a formula from its root down to, and including, its unbounded future operators:
//! conjunctions, disjunctions, and the m operators u_1 ... u_m, above *leaves* whose values are known
//! in the order of samples. At each sample i, u_j(i) = max(right(i), min(left(i), u_j(i + 1))), or
//! its dual, so the value of the formula at the first sample is a lattice polynomial V (made
//! of minima, maxima and constants) of what is still to come, u_1(n + 1) ... u_m(n + 1).
//!
//! # Algorithm
//! A lattice polynomial over a chain is given by its values where every variable is plus or
//! minus infinity (R. L. Goodstein, "The solution of equations in a lattice", Proc. Royal Society of
//! Edinburgh A 67, 1967):
//!
//! ```text
//! V(u) = max over all sets S of variables of min(V(+inf for S, -inf else), min of u_j for j in S).
//! ```
//!
//! So V is 2^m numbers, however long the trace. With a new sample, u(n) is a polynomial of
//! u(n + 1), and the new V is the old one of it: found at each corner by evaluating both. What
//! comes after the trace is one of the corners.
//!
//! # Cost
//! O(4^m + 2^m |f|) for each sample, 2^m numbers and what the leaves wait for. Formulas with more than
//! [`MAX_OBLIGATIONS`] such operators, or with one below another kind of temporal operator, are left
//! to [`super::ahead`], which keeps the trace.

use std::collections::VecDeque;

use super::{greater, smaller};
use crate::formula::discrete::program::{NodeId, Op, Program};
use crate::formula::discrete::timeline::Span;

/// The most operators that are treated so.
const MAX_OBLIGATIONS: usize = 4;

/// The polynomial of one formula on one trace.
#[derive(Debug, Clone)]
pub(super) struct Endless {
    /// Operands stand before their operators; the last one is the formula.
    terms: Vec<Term>,
    leaves: Vec<Leaf>,
    /// Whether each operator is a dual.
    dual: Vec<bool>,
    /// V at the corners: number S of the corner where variable j is plus infinity if bit j is set.
    corners: Vec<f64>,
    begun: bool,
    /// Values of the terms, kept to avoid allocations.
    values: Vec<f64>,
    next: Vec<f64>,
}

/// A node whose values come in the order of samples.
#[derive(Debug, Clone)]
struct Leaf {
    node: NodeId,
    waiting: VecDeque<f64>,
    value: f64,
}

#[derive(Debug, Clone, Copy)]
enum Term {
    Leaf(usize),
    /// The minimum, or the maximum if dual.
    Both {
        left: usize,
        right: usize,
        dual: bool,
    },
    /// The operator with this number; its left operand, if there is one, and its right one.
    Future {
        number: usize,
        left: Option<usize>,
        right: usize,
    },
}

impl Endless {
    /// The polynomial of `root`, if it has unbounded operators of the future inside each other that
    /// can be treated so.
    pub(super) fn new(program: &Program, root: NodeId) -> Option<Self> {
        let endless = endless_nodes(program, root);
        if endless.iter().filter(|is_endless| **is_endless).count() < 2 {
            return None;
        }
        let mut built = Endless {
            terms: Vec::new(),
            leaves: Vec::new(),
            dual: Vec::new(),
            corners: Vec::new(),
            begun: false,
            values: Vec::new(),
            next: Vec::new(),
        };
        let above = above(program, &endless);
        let mut term_of = vec![None; program.nodes.len()];
        built.build(program, root, (&endless, &above), &mut term_of)?;
        built.values = vec![0.0; built.terms.len()];
        built.corners = vec![f64::NEG_INFINITY; 1 << built.dual.len()];
        built.next = built.corners.clone();
        Some(built)
    }

    /// The nodes whose values it wants.
    pub(super) fn leaves(&self) -> impl Iterator<Item = NodeId> {
        self.leaves.iter().map(|leaf| leaf.node)
    }

    pub(super) fn stored(&self) -> usize {
        let waiting: usize = self.leaves.iter().map(|leaf| leaf.waiting.len()).sum();
        self.corners.len() + waiting
    }

    /// Adds the term of a node, and returns its position. Given are which nodes are unbounded
    /// operators, and which are these or above them.
    fn build(
        &mut self,
        program: &Program,
        node: NodeId,
        (endless, above): (&[bool], &[bool]),
        term_of: &mut [Option<usize>],
    ) -> Option<usize> {
        if let Some(term) = term_of[node] {
            return Some(term);
        }
        let dual = program.nodes[node].dual;
        let kinds = (endless, above);
        let term = match program.nodes[node].op {
            _ if !above[node] => {
                self.leaves.push(Leaf {
                    node,
                    waiting: VecDeque::new(),
                    value: f64::NAN,
                });
                Term::Leaf(self.leaves.len() - 1)
            }
            Op::And(left, right) => Term::Both {
                left: self.build(program, left, kinds, term_of)?,
                right: self.build(program, right, kinds, term_of)?,
                dual,
            },
            Op::Eventually(_, right) if endless[node] => {
                let right = self.build(program, right, kinds, term_of)?;
                self.future(dual, None, right)?
            }
            Op::Until(_, left, right) if endless[node] => {
                let left = self.build(program, left, kinds, term_of)?;
                let right = self.build(program, right, kinds, term_of)?;
                self.future(dual, Some(left), right)?
            }
            _ => return None,
        };
        self.terms.push(term);
        term_of[node] = Some(self.terms.len() - 1);
        term_of[node]
    }

    fn future(&mut self, dual: bool, left: Option<usize>, right: usize) -> Option<Term> {
        let number = self.dual.len();
        self.dual.push(dual);
        (number < MAX_OBLIGATIONS).then_some(Term::Future {
            number,
            left,
            right,
        })
    }

    /// Takes what the nodes gave in a step.
    #[inline]
    pub(super) fn hear(&mut self, given: &[Vec<f64>]) {
        let mut ready = usize::MAX;
        for leaf in &mut self.leaves {
            leaf.waiting.extend(&given[leaf.node]);
            ready = ready.min(leaf.waiting.len());
        }
        for _ in 0..ready {
            for leaf in &mut self.leaves {
                leaf.value = leaf.waiting.pop_front().unwrap_or(f64::NAN);
            }
            self.take();
        }
    }

    /// Takes the next sample, at which all leaves have their values.
    fn take(&mut self) {
        for corner in 0..self.corners.len() {
            self.evaluate(corner);
            self.next[corner] = if self.begun {
                self.at_values()
            } else {
                self.values.last().copied().unwrap_or(f64::NAN)
            };
        }
        std::mem::swap(&mut self.corners, &mut self.next);
        self.begun = true;
    }

    /// The values of all terms, if what comes next is at this corner.
    fn evaluate(&mut self, corner: usize) {
        for (at, term) in self.terms.iter().enumerate() {
            self.values[at] = match *term {
                Term::Leaf(leaf) => self.leaves[leaf].value,
                Term::Both { left, right, dual } => {
                    least(dual, self.values[left], self.values[right])
                }
                Term::Future {
                    number,
                    left,
                    right,
                } => {
                    let next = at_corner(corner, number);
                    let held = left.map_or(next, |left| {
                        least(self.dual[number], self.values[left], next)
                    });
                    least(!self.dual[number], self.values[right], held)
                }
            };
        }
    }

    /// V where the operators have the values of their terms.
    fn at_values(&self) -> f64 {
        let mut best = f64::NEG_INFINITY;
        for (set, &corner) in self.corners.iter().enumerate() {
            let mut value = corner;
            for (at, term) in self.terms.iter().enumerate() {
                if let Term::Future { number, .. } = *term
                    && set >> number & 1 == 1
                {
                    value = smaller(value, self.values[at]);
                }
            }
            best = greater(best, value);
        }
        best
    }

    /// V, if nothing comes after the trace (`None`), or everything is `after`: plus or minus
    /// infinity.
    pub(super) fn close(&self, after: Option<f64>) -> Option<f64> {
        let mut corner = 0;
        for (number, &dual) in self.dual.iter().enumerate() {
            // Without more samples "eventually" is false, and "always" true.
            if after.map_or(dual, |after| after > 0.0) {
                corner |= 1 << number;
            }
        }
        self.corners.get(corner).copied().filter(|_| self.begun)
    }
}

/// The minimum, or the maximum if `dual`.
#[inline]
fn least(dual: bool, left: f64, right: f64) -> f64 {
    if dual {
        greater(left, right)
    } else {
        smaller(left, right)
    }
}

#[inline]
fn at_corner(corner: usize, number: usize) -> f64 {
    if corner >> number & 1 == 1 {
        f64::INFINITY
    } else {
        f64::NEG_INFINITY
    }
}

/// Which of the nodes below `root` are unbounded operators of the future.
fn endless_nodes(program: &Program, root: NodeId) -> Vec<bool> {
    let is_endless = |span: Span| span.starts_now() && !span.is_bounded();
    (program.nodes.iter().enumerate())
        .map(|(index, node)| match node.op {
            Op::Eventually(span, _) | Op::Until(span, ..) => index <= root && is_endless(span),
            _ => false,
        })
        .collect()
}

/// For each node, whether it or one below it is among `wanted`.
fn above(program: &Program, wanted: &[bool]) -> Vec<bool> {
    let mut above = vec![false; program.nodes.len()];
    for (index, node) in program.nodes.iter().enumerate() {
        let below = match node.op {
            Op::Constant | Op::Atom(_) => false,
            Op::Next(operand)
            | Op::Previous(operand)
            | Op::Eventually(_, operand)
            | Op::Once(_, operand) => above[operand],
            Op::And(left, right) | Op::Until(_, left, right) | Op::Since(_, left, right) => {
                above[left] || above[right]
            }
        };
        above[index] = wanted[index] || below;
    }
    above
}
