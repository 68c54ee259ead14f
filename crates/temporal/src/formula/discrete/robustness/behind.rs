//! Robustness of `left S right` and `once right`.
//!
//! # Definition
//! At sample i with window W(i) of the past: the maximum over k in W(i) of the minimum of right at
//! k and of left at all samples of (k, i].
//!
//! # Algorithm
//! The mirror image of [`super::ahead`], but the value of a sample is final when both operands are known
//! there. Samples too young for the window wait. A window without end needs no more than its fold.

use std::collections::VecDeque;

use super::fold::{Chain, Link, Peak};
use super::{Giver, Pairs, smaller};
use crate::formula::discrete::timeline::{Span, Timeline};

/// The state of one "since" or "once".
#[derive(Debug, Clone)]
pub(super) struct Behind {
    span: Span,
    pairs: Pairs,
    /// The next sample.
    next: u64,
    /// Values of both operands at samples that are too young for the window.
    young: VecDeque<(f64, f64)>,
    /// The least value of left among these; values are negated.
    young_left: Peak,
    window: Window,
    begin: u64,
    end: u64,
}

#[derive(Debug, Clone)]
enum Window {
    Unbounded(Link),
    Once(Peak),
    Since(Chain<true>),
}

impl Behind {
    pub(super) fn new(span: Span, has_left: bool) -> Self {
        let window = match (span.is_bounded(), has_left) {
            (false, _) => Window::Unbounded(Link::EMPTY),
            (true, false) => Window::Once(Peak::default()),
            (true, true) => Window::Since(Chain::default()),
        };
        Behind {
            span,
            pairs: Pairs::default(),
            next: 0,
            young: VecDeque::new(),
            young_left: Peak::default(),
            window,
            begin: 0,
            end: 0,
        }
    }

    /// The windows of samples still to come begin here or later.
    pub(super) fn needed_from(&self) -> u64 {
        match self.span {
            Span::Samples { .. } => u64::MAX,
            _ if self.span.is_bounded() => self.begin,
            Span::Seconds { .. } => self.end.min(self.next),
        }
    }

    pub(super) fn stored(&self) -> usize {
        self.pairs.stored()
            + self.young.len()
            + self.young_left.len()
            + match &self.window {
                Window::Unbounded(_) => 1,
                Window::Once(peak) => peak.len(),
                Window::Since(chain) => chain.len(),
            }
    }

    /// Both operands gave values.
    #[inline]
    pub(super) fn hear_both(
        &mut self,
        left: &[f64],
        right: &[f64],
        timeline: &Timeline,
        giver: &mut Giver<'_>,
    ) {
        let mut pairs = std::mem::take(&mut self.pairs);
        let sign = giver.sign;
        pairs.join(left, right, sign, |left, right| {
            self.hear(left, right, timeline, giver);
        });
        self.pairs = pairs;
    }

    /// The values of the operands at the next sample.
    #[inline]
    pub(super) fn hear(
        &mut self,
        left: f64,
        right: f64,
        timeline: &Timeline,
        giver: &mut Giver<'_>,
    ) {
        let begin_before = self.begin;
        let end_before = self.end;
        self.begin = timeline.first_within(self.span, self.next, self.begin);
        self.end = timeline.end_beyond(self.span, self.next, self.end);
        self.young.push_back((left, right));
        for sample in end_before..self.end {
            let (left, right) = self.young.pop_front().unwrap_or((left, right));
            self.enter(sample, left, right);
        }
        self.leave(begin_before);
        if self.young.is_empty() {
            self.young_left = Peak::default();
        } else {
            self.young_left.push(self.next, -left);
            self.young_left.forget_before(self.end);
        }
        let reached = match &self.window {
            Window::Unbounded(link) => link.reached,
            Window::Once(peak) => peak.value(),
            Window::Since(chain) => chain.fold().reached,
        };
        giver.give(smaller(-self.young_left.value(), reached));
        self.next += 1;
    }

    #[inline]
    fn enter(&mut self, sample: u64, left: f64, right: f64) {
        match &mut self.window {
            Window::Unbounded(link) => {
                *link = link.then::<true>(Link {
                    all_left: left,
                    reached: right,
                });
            }
            Window::Once(peak) => peak.push(sample, right),
            Window::Since(chain) => chain.push(left, right),
        }
    }

    #[inline]
    fn leave(&mut self, begin_before: u64) {
        match &mut self.window {
            Window::Unbounded(_) => {}
            Window::Once(peak) => peak.forget_before(self.begin),
            Window::Since(chain) => {
                for _ in begin_before..self.begin {
                    chain.pop();
                }
            }
        }
    }
}
