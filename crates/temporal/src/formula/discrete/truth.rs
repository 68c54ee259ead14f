//! Truth: what is determined, as soon as it is, at every sample and for every subformula.
//!
//! # Definition
//! The value of a subformula at a sample is true, false or not (yet) known, by Kleene's logic: what
//! has not been seen, and atoms that are unknown, may be either. A value that is determined stays so.
//! Each node *says* the value of every sample exactly once, at the first step at which it is
//! determined, in whatever order this happens; or, when everything it depends on has been said and
//! it is still neither true nor false, that it is unknown for good.
//!
//! # Algorithm
//! Ours. A node is told what its operands say, as runs of samples with the same value; it keeps the
//! runs that can still matter ([`super::runs`]), and says what follows from those that are new.
//! See [`until`] for the operators of the future and [`past`] for those of the past.
//!
//! # Cost and guarantee
//! Amortised O(1) for each sample and operator if operands are determined in order, whatever the
//! window; memory grows with the number of changes of truth within the windows, not with samples.
//! Operators of the past wait until their operands are determined at all samples up to now;
//! otherwise, a value is said at the very sample that determines it.

pub(super) mod past;
pub(super) mod until;

use self::past::Past;
use self::until::Until;
use super::Truth;
use super::program::{Node, NodeId, Op, Program};
use super::runs::RunMap;
use super::timeline::Timeline;

/// A run of samples and what a node says of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Said {
    pub(super) from: u64,
    pub(super) to: u64,
    pub(super) value: Truth,
}

/// What comes after the last sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum After {
    /// No sample.
    Nothing,
    /// Samples, at which every subformula has this value.
    All(bool),
}

/// The state of all nodes.
#[derive(Debug, Clone)]
pub(super) struct TruthEngine {
    nodes: Vec<(Node, State)>,
    said: Vec<Vec<Said>>,
}

#[derive(Debug, Clone)]
enum State {
    Constant,
    Atom,
    And(Box<[RunMap; 2]>),
    Next,
    /// What was said of the last sample, if it was.
    Previous(Option<Truth>),
    Until(Box<Until>),
    Past(Box<Past>),
}

impl TruthEngine {
    pub(super) fn new(program: &Program) -> Self {
        let state = |node: &Node| match node.op {
            Op::Constant => State::Constant,
            Op::Atom(_) => State::Atom,
            Op::And(..) => State::And(Box::default()),
            Op::Next(_) => State::Next,
            Op::Previous(_) => State::Previous(None),
            Op::Eventually(span, _) => State::Until(Box::new(Until::new(span, false))),
            Op::Until(span, ..) => State::Until(Box::new(Until::new(span, true))),
            Op::Once(span, _) => State::Past(Box::new(Past::new(span, false))),
            Op::Since(span, ..) => State::Past(Box::new(Past::new(span, true))),
        };
        TruthEngine {
            nodes: (program.nodes.iter())
                .map(|node| (*node, state(node)))
                .collect(),
            said: vec![Vec::new(); program.nodes.len()],
        }
    }

    /// What this node said in the last step.
    #[inline]
    pub(super) fn said(&self, node: NodeId) -> &[Said] {
        &self.said[node]
    }

    /// Takes the samples that were last added to `timeline`; `atom` gives the truth of an atom at the
    /// first of them, the second, and so on.
    #[inline]
    pub(super) fn step(&mut self, timeline: &Timeline, atom: impl Fn(usize, usize) -> Truth) {
        let (fresh, count) = (timeline.fresh(), timeline.count());
        for (index, (node, state)) in self.nodes.iter_mut().enumerate() {
            let (before, rest) = self.said.split_at_mut(index);
            let Some(out) = rest.first_mut() else { return };
            out.clear();
            let mut speaker = Speaker {
                out,
                dual: node.dual,
            };
            match (node.op, state) {
                (Op::Constant, _) => speaker.say(fresh, count, Truth::True),
                // The dual of an atom is its negation: only the result is negated.
                (Op::Atom(number), _) => {
                    speaker.say_all(fresh, count, |offset| atom(number, offset));
                }
                (_, state) => {
                    match state {
                        State::Until(until) => until.tick(timeline, &mut speaker),
                        State::Previous(held) => {
                            let first = (fresh == 0).then_some(Truth::False);
                            if let Some(value) = held.take().or(first) {
                                speaker.say(fresh, fresh + 1, value);
                            }
                        }
                        _ => {}
                    }
                    listen(*node, before, timeline, state, &mut speaker);
                }
            }
        }
    }

    /// Ends the trace: afterwards every node has said something of every sample.
    pub(super) fn close(&mut self, timeline: &Timeline, after: After) {
        for (index, (node, state)) in self.nodes.iter_mut().enumerate() {
            let (before, rest) = self.said.split_at_mut(index);
            let Some(out) = rest.first_mut() else { return };
            out.clear();
            let mut speaker = Speaker {
                out,
                dual: node.dual,
            };
            let after = match after {
                After::All(value) => After::All(value != node.dual),
                other => other,
            };
            listen(*node, before, timeline, state, &mut speaker);
            match state {
                State::Until(until) => until.close(timeline, after, &mut speaker),
                State::Next if timeline.count() > 0 => {
                    let value = Truth::of(Some(after == After::All(true)));
                    speaker.say(timeline.count() - 1, timeline.count(), value);
                }
                _ => {}
            }
        }
    }

    /// The first sample whose time may still be asked for.
    pub(super) fn needed_from(&self) -> u64 {
        (self.nodes.iter())
            .map(|(_, state)| match state {
                State::Until(until) => until.needed_from(),
                State::Past(past) => past.needed_from(),
                _ => u64::MAX,
            })
            .min()
            .unwrap_or(u64::MAX)
    }

    /// How many runs are stored.
    pub(super) fn stored(&self) -> usize {
        (self.nodes.iter())
            .map(|(_, state)| match state {
                State::And(waiting) => waiting[0].len() + waiting[1].len(),
                State::Until(until) => until.stored(),
                State::Past(past) => past.stored(),
                _ => 0,
            })
            .sum()
    }
}

/// Where a node says its values; negates those of a dual node.
pub(super) struct Speaker<'a> {
    out: &'a mut Vec<Said>,
    dual: bool,
}

impl Speaker<'_> {
    #[inline]
    pub(super) fn say(&mut self, from: u64, to: u64, value: Truth) {
        self.out.push(Said {
            from,
            to,
            value: value.negated_if(self.dual),
        });
    }

    /// Says the values at `from`, `from + 1` and so on.
    #[inline]
    fn say_all(&mut self, from: u64, to: u64, value: impl Fn(usize) -> Truth) {
        let mut begin = from;
        let mut run = value(0);
        for sample in from + 1..to {
            let next = value((sample - from) as usize);
            if next != run {
                self.say(begin, sample, run);
                (begin, run) = (sample, next);
            }
        }
        self.say(begin, to, run);
    }
}

/// Tells a node what its operands said in this step.
#[inline]
fn listen(
    node: Node,
    before: &[Vec<Said>],
    timeline: &Timeline,
    state: &mut State,
    speaker: &mut Speaker<'_>,
) {
    let of = |operand: NodeId| {
        (before[operand].iter()).map(move |said| Said {
            value: said.value.negated_if(node.dual),
            ..*said
        })
    };
    match (node.op, state) {
        (Op::And(left, right), State::And(waiting)) => {
            let [lefts, rights] = waiting.as_mut();
            of(left).for_each(|said| conjoin(said, lefts, rights, speaker));
            of(right).for_each(|said| conjoin(said, rights, lefts, speaker));
        }
        (Op::Next(operand), _) => of(operand).for_each(|said| {
            let from = said.from.saturating_sub(1);
            if from + 1 < said.to {
                speaker.say(from, said.to - 1, said.value);
            }
        }),
        (Op::Previous(operand), State::Previous(held)) => of(operand).for_each(|said| {
            let to = (said.to + 1).min(timeline.count());
            if said.from + 1 < to {
                speaker.say(said.from + 1, to, said.value);
            }
            if said.to == timeline.count() {
                *held = Some(said.value);
            }
        }),
        (Op::Eventually(_, operand), State::Until(until)) => {
            of(operand).for_each(|said| until.right(said, timeline, speaker));
            until.settle(timeline, speaker);
        }
        (Op::Until(_, left, right), State::Until(until)) => {
            of(left).for_each(|said| until.left(said, timeline, speaker));
            of(right).for_each(|said| until.right(said, timeline, speaker));
            until.settle(timeline, speaker);
        }
        (Op::Once(_, operand), State::Past(past)) => {
            of(operand).for_each(|said| past.right(said));
            past.settle(timeline, speaker);
        }
        (Op::Since(_, left, right), State::Past(past)) => {
            of(left).for_each(|said| past.left(said));
            of(right).for_each(|said| past.right(said));
            past.settle(timeline, speaker);
        }
        _ => {}
    }
}

/// What follows from `said` of one operand of a conjunction, given what has been said of the other.
#[inline]
fn conjoin(said: Said, own: &mut RunMap, other: &mut RunMap, speaker: &mut Speaker<'_>) {
    other.take(said.from, said.to, |from, to, value| {
        match (said.value, value) {
            // A false operand spoke for both.
            (_, Some(Truth::False)) => {}
            (Truth::False, None) => {
                speaker.say(from, to, Truth::False);
                own.insert(from, to, Truth::False);
            }
            (_, None) => own.insert(from, to, said.value),
            (own, Some(other)) => speaker.say(from, to, own.min(other)),
        }
    });
}
