//! The tableau of a formula: what must hold from the next step on, given the letter read now.
//!
//! A formula in negation normal form is rewritten, for one letter, into a disjunction of *moves*. A
//! move `(S, P)` says: the word is fine if from the next position on all formulas of `S` hold; `P`
//! is the set of untils whose fulfilment this move puts off. With `a`, `b` read as their own moves:
//!
//! ```text
//! a U b        = b  |  (a & X (a U b), put off)      a R b        = b & (a | X (a R b))
//! a U[0,0] b   = b                                   a R[0,0] b   = b
//! a U[0,h] b   = b  |  a & X (a U[0,h-1] b)          a R[0,h] b   = b & (a | X (a R[0,h-1] b))
//! a U[l,h] b   = a & X (a U[l-1,h-1] b)              a R[l,h] b   = a | X (a R[l-1,h-1] b)
//! ```
//!
//! An infinite sequence of moves is accepting iff no unbounded until is put off in all but finitely
//! many of them; then the word satisfies the formula (transition-based generalised Büchi acceptance).
//!
//! Source: Couvreur 1999 ("On-the-fly verification of linear temporal logic", promises), Gastin and
//! Oddoux 2001 (sets of obligations as states). Deviations: one letter at a time, so that no formula
//! over the letters is ever needed; windows count down instead of being expanded in advance; a move
//! is dropped if another asks for a subset of its obligations and puts off a subset of its untils.
//! That is sound: a run that obeys the larger move can be followed, step by step, by one with fewer
//! obligations and fewer delays. An obligation is dropped if another one of the same set implies
//! it, by windows (`a U[0,i] b` implies `a U[0,j] b` for `i <= j`, dually for `R`) or because it is a
//! disjunction with a member in the set; both orders are well-founded.
//!
//! Cost: exponential in the number of temporal operators in the worst case, as it must be.

use rustc_hash::FxHashMap;

use super::AutomatonError;
use crate::ltl::{Ltl, StepBound};

/// Number of an interned formula.
pub(super) type NodeId = u32;

/// Formulas that must all hold; sorted, without repetitions. Empty: nothing is required.
pub(super) type Obligations = Box<[NodeId]>;

/// One way to go on.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Move {
    /// What must hold from the next position on.
    pub obligations: Obligations,
    /// Untils put off, as a bit set.
    pub put_off: u64,
}

/// A formula in negation normal form.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Node {
    True,
    False,
    Literal {
        ap: usize,
        positive: bool,
    },
    And(NodeId, NodeId),
    Or(NodeId, NodeId),
    Next(NodeId),
    Until {
        left: NodeId,
        right: NodeId,
        bound: StepBound,
    },
    Release {
        left: NodeId,
        right: NodeId,
        bound: StepBound,
    },
}

/// Interned formulas and their moves.
#[derive(Debug, Clone, Default)]
pub(super) struct Tableau {
    nodes: Vec<Node>,
    index: FxHashMap<Node, NodeId>,
    /// Bit of each unbounded until.
    untils: FxHashMap<NodeId, u32>,
    moves: FxHashMap<(NodeId, u64), Vec<Move>>,
}

impl Tableau {
    /// The tableau of `formula`, or of its negation, and the obligations it starts with.
    pub fn new(formula: &Ltl, negated: bool) -> Result<(Self, Obligations), AutomatonError> {
        let mut tableau = Self::default();
        let root = tableau.normal_form(formula, !negated);
        if tableau.untils.len() > 64 {
            return Err(AutomatonError::TooManyUntils {
                untils: tableau.untils.len(),
            });
        }
        let mut start = Vec::new();
        tableau.flatten(root, &mut start);
        let start = tableau.normalise(start);
        Ok((tableau, start))
    }

    /// Number of unbounded untils, that is of acceptance conditions.
    pub fn until_count(&self) -> u32 {
        self.untils.len() as u32
    }

    /// Whether these obligations can never be met.
    pub fn is_false(&self, obligations: &[NodeId]) -> bool {
        (obligations.iter()).any(|node| self.nodes[*node as usize] == Node::False)
    }

    fn intern(&mut self, node: Node) -> NodeId {
        if let Some(id) = self.index.get(&node) {
            return *id;
        }
        let id = self.nodes.len() as NodeId;
        self.nodes.push(node.clone());
        self.index.insert(node, id);
        id
    }

    /// Negation normal form of the formula (`positive`) or of its negation.
    fn normal_form(&mut self, formula: &Ltl, positive: bool) -> NodeId {
        match formula {
            Ltl::True => self.constant(positive),
            Ltl::False => self.constant(!positive),
            Ltl::Ap(ap) => self.intern(Node::Literal { ap: *ap, positive }),
            Ltl::Not(inner) => self.normal_form(inner, !positive),
            Ltl::And(left, right) => self.combine(left, right, positive, positive),
            Ltl::Or(left, right) => self.combine(left, right, positive, !positive),
            Ltl::Next(inner) => {
                let inner = self.normal_form(inner, positive);
                self.intern(Node::Next(inner))
            }
            Ltl::Until(left, right, bound) => {
                let (left, right) = (
                    self.normal_form(left, positive),
                    self.normal_form(right, positive),
                );
                self.window(left, right, *bound, positive)
            }
            Ltl::Release(left, right, bound) => {
                let (left, right) = (
                    self.normal_form(left, positive),
                    self.normal_form(right, positive),
                );
                self.window(left, right, *bound, !positive)
            }
            Ltl::WeakUntil(left, right, bound) => self.weak_until(left, right, *bound, positive),
            Ltl::Finally(inner, bound) => {
                let (left, right) = (self.constant(positive), self.normal_form(inner, positive));
                self.window(left, right, *bound, positive)
            }
            Ltl::Globally(inner, bound) => {
                let (left, right) = (self.constant(!positive), self.normal_form(inner, positive));
                self.window(left, right, *bound, !positive)
            }
        }
    }

    fn constant(&mut self, value: bool) -> NodeId {
        self.intern(if value { Node::True } else { Node::False })
    }

    fn combine(&mut self, left: &Ltl, right: &Ltl, positive: bool, conjunction: bool) -> NodeId {
        let left = self.normal_form(left, positive);
        let right = self.normal_form(right, positive);
        self.junction(left, right, conjunction)
    }

    fn junction(&mut self, left: NodeId, right: NodeId, conjunction: bool) -> NodeId {
        let (left, right) = (left.min(right), left.max(right));
        if left == right {
            return left;
        }
        self.intern(if conjunction {
            Node::And(left, right)
        } else {
            Node::Or(left, right)
        })
    }

    /// `a W_B b = (!a | b) R_B (a | b)`, and its negation `(a & !b) U_B (!a & !b)`.
    fn weak_until(&mut self, left: &Ltl, right: &Ltl, bound: StepBound, positive: bool) -> NodeId {
        let not_left = self.normal_form(left, !positive);
        let left = self.normal_form(left, positive);
        let right = self.normal_form(right, positive);
        if positive {
            let release = self.junction(not_left, right, false);
            let held = self.junction(left, right, false);
            self.window(release, held, bound, false)
        } else {
            // Here `left` is the negation of the operand, `not_left` the operand itself.
            let waiting = self.junction(not_left, right, true);
            let given_up = self.junction(left, right, true);
            self.window(waiting, given_up, bound, true)
        }
    }

    /// An until or a release; unbounded untils get their acceptance bit.
    fn window(&mut self, left: NodeId, right: NodeId, bound: StepBound, until: bool) -> NodeId {
        if bound.is_empty() {
            return self.constant(!until);
        }
        if !until {
            return self.intern(Node::Release { left, right, bound });
        }
        if bound.upper.is_none() {
            let bound = StepBound::UNBOUNDED;
            let unbounded = self.intern(Node::Until { left, right, bound });
            let next_bit = self.untils.len() as u32;
            self.untils.entry(unbounded).or_insert(next_bit);
        }
        self.intern(Node::Until { left, right, bound })
    }

    /// All moves that satisfy all of `obligations` on reading `letter`.
    pub fn successors(&mut self, obligations: &[NodeId], letter: u64) -> Vec<Move> {
        let mut moves = vec![Move::free()];
        for node in obligations {
            let of_node = self.moves(*node, letter);
            moves = self.conjunction(&moves, &of_node);
        }
        moves
    }

    /// The moves that satisfy one formula on reading `letter`.
    fn moves(&mut self, node: NodeId, letter: u64) -> Vec<Move> {
        if let Some(known) = self.moves.get(&(node, letter)) {
            return known.clone();
        }
        let moves = match self.nodes[node as usize].clone() {
            Node::True => vec![Move::free()],
            Node::False => Vec::new(),
            Node::Literal { ap, positive } if (letter >> ap & 1 == 1) == positive => {
                vec![Move::free()]
            }
            Node::Literal { .. } => Vec::new(),
            Node::And(left, right) => {
                let (left, right) = (self.moves(left, letter), self.moves(right, letter));
                self.conjunction(&left, &right)
            }
            Node::Or(left, right) => {
                minimal([self.moves(left, letter), self.moves(right, letter)].concat())
            }
            Node::Next(inner) => self.later(inner, 0),
            Node::Until { left, right, bound } => {
                let now = self.moves(right, letter);
                let hold = self.moves(left, letter);
                let later = self.later_window(node, left, right, bound, true);
                let wait = self.conjunction(&hold, &later);
                if bound.lower > 0 {
                    wait
                } else {
                    minimal([now, wait].concat())
                }
            }
            Node::Release { left, right, bound } => {
                let held = self.moves(right, letter);
                let mut free = self.moves(left, letter);
                free.extend(self.later_window(node, left, right, bound, false));
                let free = minimal(free);
                if bound.lower > 0 {
                    free
                } else {
                    self.conjunction(&held, &free)
                }
            }
        };
        self.moves.insert((node, letter), moves.clone());
        moves
    }

    /// The move that requires `node` from the next step on.
    fn later(&mut self, node: NodeId, put_off: u64) -> Vec<Move> {
        let mut obligations = Vec::new();
        self.flatten(node, &mut obligations);
        let obligations = self.normalise(obligations);
        if self.is_false(&obligations) {
            return Vec::new();
        }
        vec![Move {
            obligations,
            put_off,
        }]
    }

    /// The move that leaves an until or a release to the next step, its window one step shorter.
    /// A window whose last step is now cannot be left: an until has failed, a release has held.
    fn later_window(
        &mut self,
        node: NodeId,
        left: NodeId,
        right: NodeId,
        bound: StepBound,
        until: bool,
    ) -> Vec<Move> {
        if bound.upper == Some(0) {
            return if until {
                Vec::new()
            } else {
                vec![Move::free()]
            };
        }
        let shorter = StepBound {
            lower: bound.lower.saturating_sub(1),
            upper: bound.upper.map(|upper| upper - 1),
        };
        let rest = self.window(left, right, shorter, until);
        let put_off = (self.untils.get(&node)).map_or(0, |bit| 1 << bit);
        self.later(rest, put_off)
    }

    /// Moves that satisfy both sides.
    fn conjunction(&self, left: &[Move], right: &[Move]) -> Vec<Move> {
        let mut both = Vec::with_capacity(left.len() * right.len());
        for one in left {
            for other in right {
                let joined = [&one.obligations[..], &other.obligations[..]].concat();
                both.push(Move {
                    obligations: self.normalise(joined),
                    put_off: one.put_off | other.put_off,
                });
            }
        }
        minimal(both)
    }

    /// The conjuncts of a formula, without `true`.
    fn flatten(&self, node: NodeId, into: &mut Vec<NodeId>) {
        match self.nodes[node as usize] {
            Node::True => {}
            Node::And(left, right) => {
                self.flatten(left, into);
                self.flatten(right, into);
            }
            _ => into.push(node),
        }
    }

    /// Sorted, without repetitions and without what another obligation implies.
    fn normalise(&self, mut obligations: Vec<NodeId>) -> Obligations {
        obligations.sort_unstable();
        obligations.dedup();
        let needed = |node: &NodeId| {
            !(obligations.iter()).any(|other| other != node && self.implies(*other, *node))
        };
        let kept: Vec<NodeId> = obligations.iter().copied().filter(needed).collect();
        kept.into_boxed_slice()
    }

    /// Two implications that can be read off: a member of a disjunction, a tighter window.
    fn implies(&self, strong: NodeId, weak: NodeId) -> bool {
        match (&self.nodes[strong as usize], &self.nodes[weak as usize]) {
            (_, Node::Or(left, right)) => *left == strong || *right == strong,
            (
                Node::Until { left, right, bound },
                Node::Until {
                    left: l,
                    right: r,
                    bound: wide,
                },
            )
            | (
                Node::Release {
                    left: l,
                    right: r,
                    bound: wide,
                },
                Node::Release { left, right, bound },
            ) => (left, right) == (l, r) && strictly_inside(*bound, *wide),
            _ => false,
        }
    }
}

/// Whether both windows start now and `narrow` ends first.
fn strictly_inside(narrow: StepBound, wide: StepBound) -> bool {
    let both_start_now = narrow.lower == 0 && wide.lower == 0;
    let ends_first = match (narrow.upper, wide.upper) {
        (Some(narrow), Some(wide)) => narrow < wide,
        (Some(_), None) => true,
        (None, _) => false,
    };
    both_start_now && ends_first
}

impl Move {
    /// The move that requires nothing.
    fn free() -> Self {
        Self {
            obligations: Box::new([]),
            put_off: 0,
        }
    }

    /// Whether every run that takes `other` could take this one.
    fn dominates(&self, other: &Self) -> bool {
        self.put_off & !other.put_off == 0 && is_subset(&self.obligations, &other.obligations)
    }
}

/// Whether sorted `small` is a subset of sorted `large`.
pub(super) fn is_subset(small: &[NodeId], large: &[NodeId]) -> bool {
    let mut rest = large.iter();
    small.len() <= large.len() && small.iter().all(|node| rest.any(|other| other == node))
}

/// The moves that no other one dominates, sorted.
fn minimal(mut moves: Vec<Move>) -> Vec<Move> {
    moves.sort();
    moves.dedup();
    let keep: Vec<bool> = (moves.iter())
        .map(|one| !(moves.iter()).any(|other| other != one && other.dominates(one)))
        .collect();
    let mut keep = keep.into_iter();
    moves.retain(|_| keep.next().unwrap_or(true));
    moves
}
