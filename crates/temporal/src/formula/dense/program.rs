//! A formula in positive form, computed over one number for each atom while time passes.
//!
//! Each operator gives its values in the order of places, each as soon as its operands determine
//! it. Conjunctions and disjunctions do so when one operand does.

use super::between::Between;
use super::stream::Stream;
use super::window::WindowOperator;
use crate::formula::ast::Window;
use crate::formula::positive::{Positive, Timed};
use crate::formula::report::RobustnessBounds;

/// Places for each second: one for each nanosecond and one for each interval between two.
const PLACES_PER_SEC: f64 = 2e9;

/// Which end of the atoms' bounds a program computes with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    Least,
    Greatest,
}

/// A formula at work. Operands stand before operators, and the last node is the whole.
#[derive(Debug, Clone)]
pub(super) struct Program {
    end: End,
    nodes: Vec<Node>,
    streams: Vec<Stream>,
}

#[derive(Debug, Clone)]
enum Node {
    Constant(f64),
    Literal {
        atom: usize,
        negated: bool,
    },
    Junction {
        and: bool,
        operands: Vec<usize>,
        place: i64,
        first_only: bool,
    },
    JustBefore {
        operand: usize,
        place: i64,
        before: f64,
    },
    Window {
        left: usize,
        right: usize,
        work: Box<WindowOperator>,
    },
}

impl Program {
    /// With `first_only`, only the value at the first place is of interest.
    pub(super) fn new(formula: &Positive, end: End, first_only: bool) -> Self {
        let mut nodes = Vec::new();
        build(formula, first_only, &mut nodes);
        Program {
            end,
            streams: vec![Stream::default(); nodes.len()],
            nodes,
        }
    }

    /// The same at the same time, computing with the other end of the bounds.
    pub(super) fn with_end(&self, end: End) -> Self {
        Program {
            end,
            ..self.clone()
        }
    }

    /// Takes the atoms' values at an even place after the last one, and what they were in between.
    pub(super) fn step(&mut self, place: i64, between: &[Between], atoms: &[RobustnessBounds]) {
        for node in 0..self.nodes.len() {
            let stream = &mut self.streams[node];
            match &mut self.nodes[node] {
                Node::Constant(value) => stream.push(place + 1, *value),
                Node::Literal { atom, negated } => {
                    if let Some(between) = between.get(*atom) {
                        stream.push(between.middle, self.end.of(Some(between.first), *negated));
                        stream.push(place, self.end.of(Some(between.then), *negated));
                    }
                    let value = self.end.of(atoms.get(*atom).copied(), *negated);
                    stream.push(place + 1, value);
                }
                _ => self.advance(node, None),
            }
        }
    }

    /// Ends the trace; what lies beyond has that value, or is not there.
    pub(super) fn close(&mut self, beyond: Option<f64>) {
        for node in 0..self.nodes.len() {
            self.advance(node, Some(beyond));
        }
    }

    /// The value of the whole up to a place, in order; `take` is called for each stretch.
    pub(super) fn root(&mut self) -> &mut Stream {
        // A program has at least one node.
        let root = self.streams.len() - 1;
        &mut self.streams[root]
    }

    /// The value at the first place if what is not known had this value.
    pub(super) fn bound(&self, unknown: f64) -> f64 {
        self.bound_of(self.nodes.len() - 1, 0, unknown)
    }

    /// Number of runs and stretches kept.
    pub(super) fn len(&self) -> usize {
        let of_node = |node: &Node| match node {
            Node::Window { work, .. } => work.len(),
            _ => 0,
        };
        self.streams.iter().map(Stream::len).sum::<usize>()
            + self.nodes.iter().map(of_node).sum::<usize>()
    }

    fn bound_of(&self, node: usize, place: i64, unknown: f64) -> f64 {
        let stream = &self.streams[node];
        if let Some(run) = stream.first().filter(|_| stream.known() > place) {
            return run.value;
        }
        match &self.nodes[node] {
            Node::Junction {
                and,
                operands,
                place: next,
                ..
            } if *next == place => {
                let values = operands
                    .iter()
                    .map(|&operand| self.bound_of(operand, place, unknown));
                if *and {
                    values.fold(f64::INFINITY, f64::min)
                } else {
                    values.fold(f64::NEG_INFINITY, f64::max)
                }
            }
            Node::Window { left, right, work } if work.place() == place => {
                let next_left = self.bound_of(*left, work.known(), unknown);
                let next_right = self.bound_of(*right, work.known(), unknown);
                work.bound(unknown, next_left, next_right)
            }
            _ => unknown,
        }
    }

    fn advance(&mut self, node: usize, closed: Option<Option<f64>>) {
        // Operands stand before their operator.
        let (before, rest) = self.streams.split_at_mut(node);
        let out = &mut rest[0];
        match &mut self.nodes[node] {
            Node::Constant(_) | Node::Literal { .. } => {}
            Node::Junction {
                and,
                operands,
                place,
                first_only,
            } => {
                join(*and, operands, before, place, out);
                if *first_only && *place > 0 {
                    operands
                        .iter()
                        .for_each(|&operand| before[operand].forget_before(i64::MAX));
                }
            }
            Node::JustBefore {
                operand,
                place,
                before: value,
            } => just_before(&mut before[*operand], place, value, out),
            Node::Window { left, right, work } => {
                // Operands are trees, so the two are distinct, and the left one comes first.
                let (first, second) = before.split_at_mut(*right);
                work.take(&mut first[*left], &mut second[0]);
                work.advance(out, closed);
            }
        }
    }
}

impl End {
    fn of(self, bounds: Option<RobustnessBounds>, negated: bool) -> f64 {
        let bounds = bounds.unwrap_or(RobustnessBounds::UNKNOWN);
        match (self, negated) {
            (End::Least, false) => bounds.low,
            (End::Least, true) => -bounds.high,
            (End::Greatest, false) => bounds.high,
            (End::Greatest, true) => -bounds.low,
        }
    }
}

/// Adds the nodes of a formula and returns the number of the last one.
fn build(formula: &Positive, first_only: bool, nodes: &mut Vec<Node>) -> usize {
    if let Some(simpler) = at_first_place(formula).filter(|_| first_only) {
        return build(&simpler, true, nodes);
    }
    let node = match formula {
        Positive::Constant(value) => Node::Constant(*value),
        Positive::Literal { atom, negated } => Node::Literal {
            atom: *atom,
            negated: *negated,
        },
        Positive::And(operands) | Positive::Or(operands) if operands.is_empty() => {
            let and = matches!(formula, Positive::And(_));
            Node::Constant(if and {
                f64::INFINITY
            } else {
                f64::NEG_INFINITY
            })
        }
        Positive::And(operands) | Positive::Or(operands) => Node::Junction {
            and: matches!(formula, Positive::And(_)),
            operands: operands
                .iter()
                .map(|operand| build(operand, first_only, nodes))
                .collect(),
            place: 0,
            first_only,
        },
        Positive::JustBefore { first, inner } => Node::JustBefore {
            operand: build(inner, false, nodes),
            place: 0,
            before: *first,
        },
        Positive::Timed {
            operator,
            window,
            left,
            right,
        } => window_node(*operator, *window, [left, right], first_only, nodes),
    };
    nodes.push(node);
    nodes.len() - 1
}

/// What an operator of the past is at the first place, before which there is nothing.
fn at_first_place(formula: &Positive) -> Option<Positive> {
    match formula {
        Positive::JustBefore { first, .. } => Some(Positive::Constant(*first)),
        Positive::Timed {
            operator: operator @ (Timed::Since | Timed::Trigger),
            window: Window::Seconds { low_secs, .. },
            right,
            ..
        } => Some(match (places(*low_secs) > 0, operator) {
            (false, _) => right.as_ref().clone(),
            (true, Timed::Since) => Positive::Constant(f64::NEG_INFINITY),
            (true, _) => Positive::Constant(f64::INFINITY),
        }),
        _ => None,
    }
}

fn window_node(
    operator: Timed,
    window: Window,
    [left, right]: [&Positive; 2],
    first_only: bool,
    nodes: &mut Vec<Node>,
) -> Node {
    let (low, high) = match window {
        Window::Seconds {
            low_secs,
            high_secs,
        } => (
            places(low_secs),
            high_secs.is_finite().then(|| places(high_secs)),
        ),
        // Refused in dense time before.
        Window::Samples { .. } => (0, None),
    };
    let left = build(left, false, nodes);
    let right = build(right, false, nodes);
    Node::Window {
        left,
        right,
        work: Box::new(WindowOperator::new(operator, low, high, first_only)),
    }
}

/// A distance in places, an even number. Not more than MAX_BOUND seconds, so it cannot overflow.
fn places(secs: f64) -> i64 {
    2 * (secs * (PLACES_PER_SEC / 2.0)).round() as i64
}

/// Extends the conjunction or disjunction of the operands as far as it is determined.
fn join(and: bool, operands: &[usize], streams: &mut [Stream], place: &mut i64, out: &mut Stream) {
    let deciding = if and {
        f64::NEG_INFINITY
    } else {
        f64::INFINITY
    };
    loop {
        let mut value = -deciding;
        let mut end = i64::MAX;
        let mut decided: Option<i64> = None;
        let mut all = true;
        for &operand in operands {
            streams[operand].forget_before(*place);
            match streams[operand].first() {
                Some(run) => {
                    value = if and {
                        value.min(run.value)
                    } else {
                        value.max(run.value)
                    };
                    end = end.min(run.end);
                    if run.value == deciding {
                        decided = decided.max(Some(run.end));
                    }
                }
                None => all = false,
            }
        }
        let (end, value) = match decided {
            Some(end) => (end, deciding),
            None if all => (end, value),
            None => return,
        };
        out.push(end, value);
        *place = end;
    }
}

/// Extends the value just before. At an odd place, an open interval, that is the value there; at an
/// even one, that of the place before.
fn just_before(operand: &mut Stream, place: &mut i64, before: &mut f64, out: &mut Stream) {
    loop {
        operand.forget_before(*place);
        let Some(run) = operand.first() else { return };
        if *place % 2 == 0 {
            out.push(*place + 1, *before);
        }
        out.push(run.end, run.value);
        *before = run.value;
        *place = run.end;
    }
}
