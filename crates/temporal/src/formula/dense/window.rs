//! Until, release, since and their special cases over runs of the operands.
//!
//! Seen from place x, an operator of the future with window [a, b] is the composition of the clamps
//! of the *lead* x ... x + a - 1, where until demands its left operand (release: does without), and
//! of the *body* x + a ... x + b, applied to what comes after: nothing (until: -inf, release:
//! +inf), or, where the end of the trace cuts the body off, what is said of times not seen. For the
//! past, mirrored. At an odd place, an open interval, part of the interval lies before the point
//! where the right operand is needed (see [`super::super::semantics::dense`]), so its clamp
//! differs; a stretch of constant operands contributes the clamp of the place that is looked at
//! first. If the window begins at 0, the right operand at x itself is enough.
//!
//! The composition is known before its window is over if it is constant: as soon as `eventually`
//! has seen truth, for example.
//!
//! Cost: O(1) amortised for each run of the operands, whatever the window. Memory: the runs within
//! the window, and with an unbounded window those since the first place that is not decided.

use std::collections::VecDeque;

use super::clamp::{Clamp, Outermost, Sliding};
use super::stream::Stream;
use crate::formula::positive::Timed;

/// A stretch of places with constant operands.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    start: i64,
    end: i64,
    left: f64,
    right: f64,
}

/// One operator at work.
#[derive(Debug, Clone)]
pub(super) struct WindowOperator {
    operator: Timed,
    low: i64,
    high: Option<i64>,
    /// Only the value at the first place is asked for.
    first_only: bool,
    /// Stretches that are still needed; the number of the first one is `base`.
    stretches: VecDeque<Stretch>,
    base: usize,
    known: i64,
    /// The place whose value is to be found next.
    place: i64,
    lead: Sliding,
    lead_range: (usize, usize),
    body: Sliding,
    body_range: (usize, usize),
}

impl WindowOperator {
    pub(super) fn new(operator: Timed, low: i64, high: Option<i64>, first_only: bool) -> Self {
        let future = matches!(operator, Timed::Until | Timed::Release);
        let first_only = first_only && future;
        let outermost = if future {
            Outermost::Oldest
        } else {
            Outermost::Newest
        };
        let endless = first_only || !future && high.is_none();
        WindowOperator {
            operator,
            low,
            high,
            first_only,
            stretches: VecDeque::new(),
            base: 0,
            known: 0,
            place: 0,
            lead: Sliding::new(outermost, first_only),
            lead_range: (0, 0),
            body: Sliding::new(outermost, endless),
            body_range: (0, 0),
        }
    }

    /// Number of stretches kept.
    pub(super) fn len(&self) -> usize {
        self.stretches.len()
    }

    pub(super) fn place(&self) -> i64 {
        self.place
    }

    fn is_future(&self) -> bool {
        matches!(self.operator, Timed::Until | Timed::Release)
    }

    /// Whether what the operator is about is found rather than excluded.
    fn is_existential(&self) -> bool {
        matches!(self.operator, Timed::Until | Timed::Since)
    }

    /// The value of a window in which nothing is.
    fn empty(&self) -> f64 {
        if self.is_existential() {
            f64::NEG_INFINITY
        } else {
            f64::INFINITY
        }
    }

    fn end_of_numbers(&self) -> usize {
        self.base + self.stretches.len()
    }

    /// Stretch by number, if it is there.
    fn stretch(&self, number: usize) -> Option<Stretch> {
        self.stretches.get(number.checked_sub(self.base)?).copied()
    }

    /// Takes what both operands have found since.
    pub(super) fn take(&mut self, left: &mut Stream, right: &mut Stream) {
        loop {
            left.forget_before(self.known);
            right.forget_before(self.known);
            let (Some(of_left), Some(of_right)) = (left.first(), right.first()) else {
                return;
            };
            let stretch = Stretch {
                start: self.known,
                end: of_left.end.min(of_right.end),
                left: of_left.value,
                right: of_right.value,
            };
            self.known = stretch.end;
            if self.first_only {
                self.fold(stretch);
            } else {
                self.append(stretch);
            }
        }
    }

    fn append(&mut self, stretch: Stretch) {
        let number = self.end_of_numbers().wrapping_sub(1);
        // The clamp of a stretch of the past depends on where it ends.
        let open = if self.is_future() {
            number >= self.body_range.0 && number >= self.lead_range.0
        } else {
            number >= self.body_range.1 && number >= self.lead_range.0
        };
        match self.stretches.back_mut() {
            Some(last) if open && last.left == stretch.left && last.right == stretch.right => {
                last.end = stretch.end;
            }
            _ => self.stretches.push_back(stretch),
        }
    }

    /// Takes a stretch into the composition for the first place.
    fn fold(&mut self, stretch: Stretch) {
        if stretch.start == 0 && self.low == 0 {
            self.lead.push(self.here(stretch.right));
        }
        if stretch.start < self.low {
            self.lead.push(self.lead_clamp(stretch));
        }
        if stretch.end > self.low && self.high.is_none_or(|high| stretch.start <= high) {
            self.body.push(self.body_clamp(stretch));
        }
    }

    fn lead_clamp(&self, stretch: Stretch) -> Clamp {
        if self.is_existential() {
            Clamp::at_most(stretch.left)
        } else {
            Clamp::at_least(stretch.left)
        }
    }

    /// What the right operand at the place itself does if the window begins there.
    fn here(&self, right: f64) -> Clamp {
        if self.is_existential() {
            Clamp::at_least(right)
        } else {
            Clamp::at_most(right)
        }
    }

    fn body_clamp(&self, stretch: Stretch) -> Clamp {
        let Stretch { left, right, .. } = stretch;
        let looked_at_first = if self.is_future() {
            stretch.start
        } else {
            stretch.end - 1
        };
        let tick = looked_at_first % 2 == 0;
        if self.is_existential() {
            Clamp {
                floor: if tick { right } else { left.min(right) },
                ceiling: left,
            }
        } else {
            Clamp {
                floor: if tick { left.min(right) } else { left },
                ceiling: right,
            }
        }
    }

    /// Finds as many values as can be. With `closed`, nothing more will come, and what lies
    /// beyond has that value; `None` if nothing lies there.
    pub(super) fn advance(&mut self, out: &mut Stream, closed: Option<Option<f64>>) {
        if self.first_only {
            return self.advance_first(out, closed);
        }
        while self.place < self.known {
            let step = if self.is_future() {
                self.future_step(closed)
            } else {
                Some(self.past_step())
            };
            let Some((end, value)) = step else { return };
            out.push(end, value);
            self.place = end;
        }
    }

    fn advance_first(&mut self, out: &mut Stream, closed: Option<Option<f64>>) {
        if self.place > 0 || self.known == 0 {
            return;
        }
        let complete = self.high.is_some_and(|high| high < self.known);
        if let Some(value) = self.decide(self.pending(), complete, closed) {
            out.push(1, value);
            self.place = 1;
        }
    }

    /// The composition of what is known of the window of the next place.
    fn pending(&self) -> Clamp {
        let total = self.lead.total().after(self.body.total());
        match self.stretch(self.current()) {
            Some(current) if self.low == 0 && !self.first_only => {
                self.here(current.right).after(total)
            }
            _ => total,
        }
    }

    /// The first place at which the operands are not known.
    pub(super) fn known(&self) -> i64 {
        self.known
    }

    /// The value of the next place if what is not known had this value; at the first such place the
    /// operands are `next_left` and `next_right`.
    pub(super) fn bound(&self, unknown: f64, next_left: f64, next_right: f64) -> f64 {
        if !self.is_future() {
            return unknown;
        }
        if self.high.is_some_and(|high| self.place + high < self.known) {
            return self.pending().apply(self.empty());
        }
        let next = Stretch {
            start: self.known,
            end: self.known + 1,
            left: next_left,
            right: next_right,
        };
        let mut last = Clamp::IDENTITY;
        if self.known == self.place && self.low == 0 {
            last = self.here(next_right);
        }
        if self.known < self.place + self.low {
            last = last.after(self.lead_clamp(next));
        } else {
            last = last.after(self.body_clamp(next));
        }
        let total = if self.known > self.place {
            self.pending().after(last)
        } else {
            last
        };
        // With the window's last place, the window is over.
        let over = self
            .high
            .is_some_and(|high| self.place + high == self.known);
        total.apply(if over { self.empty() } else { unknown })
    }

    fn decide(&self, total: Clamp, complete: bool, closed: Option<Option<f64>>) -> Option<f64> {
        if complete || total.is_constant() {
            return Some(total.apply(self.empty()));
        }
        closed.map(|beyond| total.apply(beyond.unwrap_or(self.empty())))
    }

    /// The number of the stretch that contains the next place.
    fn current(&self) -> usize {
        let at = self
            .stretches
            .partition_point(|stretch| stretch.end <= self.place);
        self.base + at
    }

    /// The next value and up to where it holds, if it can be told.
    fn future_step(&mut self, closed: Option<Option<f64>>) -> Option<(i64, f64)> {
        self.forget(self.place, self.base + self.stretches.len());
        self.slide_lead(self.place, self.place + self.low - 1);
        let last = self.high.map_or(i64::MAX, |high| self.place + high);
        self.slide_body(self.place + self.low, last);
        let complete = last < self.known;
        let value = self.decide(self.pending(), complete, closed)?;
        let mut end = self
            .stretch(self.base)
            .map_or(self.known, |stretch| stretch.end);
        if self.low > 0 {
            if let Some(first) = self.stretch(self.body_range.0) {
                end = end.min(first.end - self.low);
            }
            if let Some(next) = self.stretch(self.lead_range.1) {
                end = end.min(next.start + 1 - self.low);
            }
        }
        if let (true, Some(high)) = (complete, self.high)
            && let Some(newest) = self.stretch(self.body_range.1.wrapping_sub(1))
        {
            end = end.min(newest.end - high);
        }
        Some((end, value))
    }

    fn past_step(&mut self) -> (i64, f64) {
        self.slide_lead(self.place - self.low + 1, self.place);
        let first = self.high.map_or(i64::MIN, |high| self.place - high);
        self.slide_body(first, self.place - self.low);
        let value = self.pending().apply(self.empty());
        let current = self.current();
        let mut end = self
            .stretch(current)
            .map_or(self.known, |stretch| stretch.end);
        if let Some(next) = self.stretch(self.body_range.1) {
            end = end.min(next.start + self.low);
        }
        if let (Some(high), Some(oldest)) = (self.high, self.stretch(self.body_range.0))
            && self.body_range.0 < self.body_range.1
        {
            end = end.min(oldest.end + high);
        }
        if self.low > 0
            && let Some(oldest) = self.stretch(self.lead_range.0)
        {
            end = end.min(oldest.end + self.low - 1);
        }
        let oldest_body = if self.high.is_some() {
            self.body_range.0
        } else {
            self.body_range.1
        };
        let oldest_lead = if self.low > 0 {
            self.lead_range.0
        } else {
            current
        };
        self.forget(self.place, oldest_body.min(oldest_lead));
        (end, value)
    }

    /// Forgets stretches that end by `place` and are numbered less than `needed`.
    fn forget(&mut self, place: i64, needed: usize) {
        while self.base < needed
            && self
                .stretches
                .front()
                .is_some_and(|first| first.end <= place)
        {
            self.stretches.pop_front();
            self.base += 1;
        }
    }

    /// Lets the lead be the places `first` to `last`, as far as they are known.
    fn slide_lead(&mut self, first: i64, last: i64) {
        if self.low == 0 {
            return;
        }
        while let Some(next) = self
            .stretch(self.lead_range.1)
            .filter(|next| next.start <= last)
        {
            self.lead.push(self.lead_clamp(next));
            self.lead_range.1 += 1;
        }
        while self.lead_range.0 < self.lead_range.1
            && self
                .stretch(self.lead_range.0)
                .is_none_or(|oldest| oldest.end <= first)
        {
            self.lead.pop();
            self.lead_range.0 += 1;
        }
    }

    /// Lets the body be the places `first` to `last`, as far as they are known.
    fn slide_body(&mut self, first: i64, last: i64) {
        while let Some(next) = self
            .stretch(self.body_range.1)
            .filter(|next| next.start <= last)
        {
            self.body.push(self.body_clamp(next));
            self.body_range.1 += 1;
        }
        if first == i64::MIN {
            return;
        }
        while self.body_range.0 < self.body_range.1
            && self
                .stretch(self.body_range.0)
                .is_none_or(|oldest| oldest.end <= first)
        {
            self.body.pop();
            self.body_range.0 += 1;
        }
    }
}
