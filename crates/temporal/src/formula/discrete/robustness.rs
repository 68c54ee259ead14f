//! Robustness at the first sample, in one pass.
//!
//! # Definition
//! The robustness of a formula is its truth with "true" replaced by plus infinity, "false" by minus
//! infinity, conjunction by the minimum and disjunction by the maximum (A. Donzé and O. Maler, "Robust
//! satisfaction of temporal logic over real-valued signals", FORMATS 2010). Where atoms are unknown
//! it lies between two values: since every node is monotone ([`super::program`]), these are its
//! robustness with all unknown atoms at minus and at plus infinity (as in J. Deshmukh and others, "Robust
//! online monitoring of signal temporal logic", Formal Methods in System Design 51, 2017).
//!
//! # Algorithm
//! Each node gives its values in order of samples, each once it is final; see [`ahead`] for operators
//! of the future and [`behind`] for those of the past. Where only the value at the first
//! sample is asked for (a formula's outermost operators) a future operator keeps two numbers, and
//! unbounded operators inside each other a few more ([`endless`]). One
//! *lane* of such nodes computes the lower end; a second one is split off at the first unknown
//! atom, and at the end, when what comes after the trace is taken for minus and for plus infinity.
//!
//! # Cost and guarantee
//! Amortised O(1) for each sample and operator, whatever the window. Memory: the samples of the
//! windows (fewer where there is no left operand); an unbounded operator of the future inside
//! a bounded one or one of the past keeps the whole trace, since its values are final only at its
//! end.
//! Only minima, maxima and changes of sign are taken, so there are no rounding errors.

mod ahead;
mod behind;
mod endless;
mod fold;
mod so_far;

use std::collections::VecDeque;
use std::sync::Arc;

use self::ahead::Ahead;
use self::behind::Behind;
use self::endless::Endless;
use self::so_far::Missing;
use super::program::{Node, NodeId, Op, Program};
use super::timeline::Timeline;

/// The nodes for one end of the interval.
#[derive(Debug, Clone)]
pub(super) struct Lane {
    nodes: Vec<(Node, State)>,
    /// What takes the place of the outermost nodes, if they are unbounded and inside each other.
    endless: Option<Endless>,
    /// What each node gave in the last step.
    given: Vec<Vec<f64>>,
    root: NodeId,
    value: Option<f64>,
    /// What the nodes have not given, by what comes after.
    missing: Arc<[[Missing; 2]]>,
    /// What statements about unknown atoms are taken for.
    unknown: f64,
}

#[derive(Debug, Clone)]
enum State {
    /// Its values are not needed.
    Idle,
    Constant,
    Atom,
    And(Box<Pairs>),
    /// Whether the first sample is behind.
    Next(bool),
    /// What was given of the last sample, and the number of samples given.
    Previous(Option<f64>, u64),
    Ahead(Box<Ahead>),
    Behind(Box<Behind>),
}

/// Values of two operands, of which one may be ahead.
#[derive(Debug, Clone, Default)]
pub(super) struct Pairs {
    left: VecDeque<f64>,
    right: VecDeque<f64>,
}

impl Pairs {
    /// Calls `pair` for each two values of the same sample.
    #[inline]
    pub(super) fn join(
        &mut self,
        left: &[f64],
        right: &[f64],
        sign: f64,
        mut pair: impl FnMut(f64, f64),
    ) {
        if self.left.is_empty() && self.right.is_empty() && left.len() == right.len() {
            for (&left, &right) in left.iter().zip(right) {
                pair(left * sign, right * sign);
            }
            return;
        }
        self.left.extend(left.iter().map(|value| value * sign));
        self.right.extend(right.iter().map(|value| value * sign));
        let ready = self.left.len().min(self.right.len());
        for (left, right) in self.left.drain(..ready).zip(self.right.drain(..ready)) {
            pair(left, right);
        }
    }

    pub(super) fn stored(&self) -> usize {
        self.left.len() + self.right.len()
    }
}

/// The greater of two numbers, neither of which is NaN.
#[inline]
pub(super) fn greater(left: f64, right: f64) -> f64 {
    if left > right { left } else { right }
}

/// The smaller of two numbers, neither of which is NaN.
#[inline]
pub(super) fn smaller(left: f64, right: f64) -> f64 {
    if left < right { left } else { right }
}

impl Lane {
    pub(super) fn new(program: &Program, root: NodeId) -> Self {
        let endless = Endless::new(program, root);
        let (needed, asked_once) = demands(program, root, endless.as_ref());
        let state = |(index, node): (NodeId, &Node)| match node.op {
            _ if !needed[index] => State::Idle,
            Op::Constant => State::Constant,
            Op::Atom(_) => State::Atom,
            Op::And(..) => State::And(Box::default()),
            Op::Next(_) => State::Next(false),
            Op::Previous(_) => State::Previous(None, 0),
            Op::Eventually(span, _) => {
                State::Ahead(Box::new(Ahead::new(span, false, asked_once[index])))
            }
            Op::Until(span, ..) => {
                State::Ahead(Box::new(Ahead::new(span, true, asked_once[index])))
            }
            Op::Once(span, _) => State::Behind(Box::new(Behind::new(span, false))),
            Op::Since(span, ..) => State::Behind(Box::new(Behind::new(span, true))),
        };
        Lane {
            nodes: (program.nodes.iter().enumerate())
                .map(|entry| (*entry.1, state(entry)))
                .collect(),
            endless,
            given: vec![Vec::new(); program.nodes.len()],
            root,
            value: None,
            missing: so_far::missing(program).into(),
            unknown: f64::NEG_INFINITY,
        }
    }

    /// The same for the other end of the interval.
    pub(super) fn optimist(&self) -> Self {
        Lane {
            unknown: f64::INFINITY,
            ..self.clone()
        }
    }

    /// Takes the samples that were last added to `timeline`; `atom` gives the values of an atom
    /// there.
    #[inline]
    pub(super) fn step<I: Iterator<Item = f64>>(
        &mut self,
        timeline: &Timeline,
        atom: impl Fn(usize) -> I,
    ) {
        if self.value.is_some() {
            return;
        }
        let unknown = self.unknown;
        for (index, (node, state)) in self.nodes.iter_mut().enumerate() {
            let (before, rest) = self.given.split_at_mut(index);
            let Some(out) = rest.first_mut() else { return };
            out.clear();
            let mut giver = Giver::new(out, *node);
            let sign = giver.sign;
            match (node.op, &mut *state) {
                (_, State::Idle) => continue,
                (Op::Constant, _) => {
                    let count = (timeline.count() - timeline.fresh()) as usize;
                    giver.out.resize(count, f64::INFINITY * sign);
                }
                (Op::Atom(number), _) => giver.out.extend(atom(number).map(|value| {
                    if value.is_nan() {
                        unknown
                    } else {
                        value * sign
                    }
                })),
                (_, State::Ahead(ahead)) => ahead.tick(timeline, &mut giver),
                (_, State::Previous(held, _)) => {
                    let first = (timeline.fresh() == 0).then_some(f64::NEG_INFINITY);
                    if let Some(value) = held.take().or(first) {
                        giver.give(value);
                    }
                }
                _ => {}
            }
            listen(*node, before, timeline, state, &mut giver);
        }
        match &mut self.endless {
            Some(endless) => endless.hear(&self.given),
            None => self.value = self.given[self.root].first().copied(),
        }
    }

    /// The robustness at the first sample, if nothing comes after the trace (`None`), or samples at
    /// which every subformula has the value `after`.
    pub(super) fn close(mut self, timeline: &Timeline, after: Option<f64>) -> Option<f64> {
        if self.value.is_some() {
            return self.value;
        }
        for (index, (node, state)) in self.nodes.iter_mut().enumerate() {
            let (before, rest) = self.given.split_at_mut(index);
            let out = rest.first_mut()?;
            out.clear();
            let mut giver = Giver::new(out, *node);
            listen(*node, before, timeline, state, &mut giver);
            let after = after.map_or(f64::NEG_INFINITY, |after| after * giver.sign);
            match state {
                State::Ahead(ahead) => ahead.close(timeline, after, &mut giver),
                State::Next(_) if timeline.count() > 0 => giver.give(after),
                _ => {}
            }
        }
        match &mut self.endless {
            Some(endless) => {
                endless.hear(&self.given);
                endless.close(after)
            }
            None => self.given[self.root].first().copied(),
        }
    }

    /// The first sample whose time may still be asked for.
    pub(super) fn needed_from(&self) -> u64 {
        (self.nodes.iter())
            .map(|(_, state)| match state {
                State::Ahead(ahead) => ahead.needed_from(),
                State::Behind(behind) => behind.needed_from(),
                _ => u64::MAX,
            })
            .min()
            .unwrap_or(u64::MAX)
    }

    /// How many values are stored.
    pub(super) fn stored(&self) -> usize {
        (self.nodes.iter())
            .map(|(_, state)| match state {
                State::And(pairs) => pairs.stored(),
                State::Ahead(ahead) => ahead.stored(),
                State::Behind(behind) => behind.stored(),
                _ => 0,
            })
            .sum::<usize>()
            + self.endless.as_ref().map_or(0, Endless::stored)
    }
}

/// For each node, whether its values are needed, and whether only that at the first sample is.
fn demands(program: &Program, root: NodeId, endless: Option<&Endless>) -> (Vec<bool>, Vec<bool>) {
    let mut needed = vec![false; program.nodes.len()];
    let mut once = vec![true; program.nodes.len()];
    match endless {
        None => needed[root] = true,
        Some(endless) => endless.leaves().for_each(|leaf| {
            needed[leaf] = true;
            once[leaf] = false;
        }),
    }
    for (index, node) in program.nodes.iter().enumerate().rev() {
        if !needed[index] {
            continue;
        }
        let operands = match node.op {
            Op::Constant | Op::Atom(_) => [None, None],
            Op::Next(operand)
            | Op::Previous(operand)
            | Op::Eventually(_, operand)
            | Op::Once(_, operand) => [Some(operand), None],
            Op::And(left, right) | Op::Until(_, left, right) | Op::Since(_, left, right) => {
                [Some(left), Some(right)]
            }
        };
        let is_and = matches!(node.op, Op::And(..));
        for operand in operands.into_iter().flatten() {
            needed[operand] = true;
            once[operand] &= is_and && once[index];
        }
    }
    (needed, once)
}

/// Where a node gives its values; negates those of a dual node.
pub(super) struct Giver<'a> {
    out: &'a mut Vec<f64>,
    sign: f64,
}

impl<'a> Giver<'a> {
    #[inline]
    fn new(out: &'a mut Vec<f64>, node: Node) -> Self {
        let sign = if node.dual { -1.0 } else { 1.0 };
        Giver { out, sign }
    }

    #[inline]
    pub(super) fn give(&mut self, value: f64) {
        self.out.push(value * self.sign);
    }
}

/// Gives a node what its operands gave in this step.
#[inline]
fn listen(
    node: Node,
    before: &[Vec<f64>],
    timeline: &Timeline,
    state: &mut State,
    giver: &mut Giver<'_>,
) {
    let sign = giver.sign;
    match (node.op, state) {
        (Op::And(left, right), State::And(pairs)) => {
            pairs.join(&before[left], &before[right], sign, |left, right| {
                giver.give(smaller(left, right));
            });
        }
        (Op::Next(operand), State::Next(begun)) => {
            for &value in &before[operand] {
                if *begun {
                    giver.give(value * sign);
                }
                *begun = true;
            }
        }
        (Op::Previous(operand), State::Previous(held, heard)) => {
            for &value in &before[operand] {
                *heard += 1;
                if *heard < timeline.count() {
                    giver.give(value * sign);
                } else {
                    *held = Some(value * sign);
                }
            }
        }
        (Op::Eventually(_, operand), State::Ahead(ahead)) => {
            for &value in &before[operand] {
                ahead.hear(f64::INFINITY, value * sign, timeline, giver);
            }
        }
        (Op::Until(_, left, right), State::Ahead(ahead)) => {
            ahead.hear_both(&before[left], &before[right], timeline, giver);
        }
        (Op::Once(_, operand), State::Behind(behind)) => {
            for &value in &before[operand] {
                behind.hear(f64::INFINITY, value * sign, timeline, giver);
            }
        }
        (Op::Since(_, left, right), State::Behind(behind)) => {
            behind.hear_both(&before[left], &before[right], timeline, giver);
        }
        _ => {}
    }
}
