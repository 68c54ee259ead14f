//! Truth of `left S right` and `once right` at every sample.
//!
//! # Definition
//! With W(i) the window of the past of sample i, i is true if right is true at some k in W(i), and
//! left is true at all samples of (k, i].
//!
//! # Algorithm
//! The last k at which right is true and which is old enough for the window is the best one: it is
//! in the window if any is, and asks least of left. So i is true if this k is not too old, and no
//! sample at which left is false comes after it (K. Havelund and G. Rosu, "Synthesizing monitors
//! for safety properties", TACAS 2002, with windows added). For Kleene's logic this is done twice, with
//! what is unknown taken for false, and for true. Samples are judged in order, when both operands
//! have been said; deviation from [`super`]: not earlier, if operands are said out of order.
//!
//! # Cost
//! Amortised O(1) for each sample; memory for the runs where right is true and still too young.

use super::super::Truth;
use super::super::runs::{RunMap, RunSet};
use super::super::timeline::{Span, Timeline};
use super::{Said, Speaker};

/// The state of one "since" or "once".
#[derive(Debug, Clone)]
pub(in super::super) struct Past {
    span: Span,
    has_left: bool,
    /// The next sample to judge.
    next: u64,
    left: Queue,
    right: Queue,
    pessimist: Lane,
    optimist: Lane,
    near_within: u64,
    near_beyond: u64,
}

/// What an operand said, in order.
#[derive(Debug, Clone, Default)]
struct Queue {
    waiting: RunMap,
    value: Option<Truth>,
    /// `value` is that of all samples before this one.
    to: u64,
}

impl Queue {
    /// The value at `sample`, if it has been said; samples are asked for in order.
    #[inline]
    fn at(&mut self, sample: u64) -> Option<Truth> {
        if sample >= self.to {
            (self.to, self.value) = match self.waiting.take_first_at(sample) {
                Some((to, value)) => (to, Some(value)),
                None => return None,
            };
        }
        self.value
    }
}

/// The algorithm for operands that are true or false.
#[derive(Debug, Clone, Default)]
struct Lane {
    /// Where right is true, but too recently.
    young: RunSet,
    /// The last sample at which right is true among those old enough.
    latest: Option<u64>,
    /// One past the last sample at which left is false.
    broken_to: u64,
}

impl Lane {
    #[inline]
    fn judge(&mut self, sample: u64, left: bool, right: bool, window: (u64, u64)) -> bool {
        if !left {
            self.broken_to = sample + 1;
        }
        if right {
            self.young.insert(sample, sample + 1);
        }
        if (self.young.first()).is_some_and(|run| run.0 < window.1) {
            self.latest = self.young.last_before(window.1);
            self.young.forget_before(window.1);
        }
        (self.latest).is_some_and(|latest| latest >= window.0 && latest + 1 >= self.broken_to)
    }
}

impl Past {
    pub(super) fn new(span: Span, has_left: bool) -> Self {
        Past {
            span,
            has_left,
            next: 0,
            left: Queue::default(),
            right: Queue::default(),
            pessimist: Lane::default(),
            optimist: Lane::default(),
            near_within: 0,
            near_beyond: 0,
        }
    }

    /// The windows of samples still to be judged begin here or later.
    pub(super) fn needed_from(&self) -> u64 {
        match self.span {
            Span::Samples { .. } => u64::MAX,
            _ if self.span.is_bounded() => self.near_within,
            // Only the end of the window is asked for.
            Span::Seconds { .. } => self.near_beyond.min(self.next),
        }
    }

    pub(super) fn stored(&self) -> usize {
        self.left.waiting.len()
            + self.right.waiting.len()
            + self.pessimist.young.len()
            + self.optimist.young.len()
    }

    #[inline]
    pub(super) fn left(&mut self, said: Said) {
        self.left.waiting.insert(said.from, said.to, said.value);
    }

    #[inline]
    pub(super) fn right(&mut self, said: Said) {
        self.right.waiting.insert(said.from, said.to, said.value);
    }

    /// Judges the samples at which both operands have been said.
    #[inline]
    pub(super) fn settle(&mut self, timeline: &Timeline, speaker: &mut Speaker<'_>) {
        while self.next < timeline.count() {
            let Some(right) = self.right.at(self.next) else {
                return;
            };
            let left = if self.has_left {
                let Some(left) = self.left.at(self.next) else {
                    return;
                };
                left
            } else {
                Truth::True
            };
            self.near_within = timeline.first_within(self.span, self.next, self.near_within);
            self.near_beyond = timeline.end_beyond(self.span, self.next, self.near_beyond);
            let window = (self.near_within, self.near_beyond);
            let sure = |value: Truth| value == Truth::True;
            let possible = |value: Truth| value != Truth::False;
            let low = (self.pessimist).judge(self.next, sure(left), sure(right), window);
            let high = (self.optimist).judge(self.next, possible(left), possible(right), window);
            let value = match (low, high) {
                (true, _) => Truth::True,
                (false, true) => Truth::Unknown,
                (false, false) => Truth::False,
            };
            speaker.say(self.next, self.next + 1, value);
            self.next += 1;
        }
    }
}
