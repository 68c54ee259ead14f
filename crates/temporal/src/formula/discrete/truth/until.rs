//! Truth of `left U right` and `eventually right` at every sample.
//!
//! # Definition
//! With W(i) the window of sample i, begin(i) its first sample and end(i) one past its last one,
//! which is known once the window is over:
//!
//! * i is true if right is true at some k in W(i), and left is true at all samples of [i, k);
//! * i is false if right is false at all samples of W(i) up to a cut: the end of the window, if it is
//!   over, or the first p >= i where left is false;
//! * i is unknown for good if neither holds although everything up to the cut has been said, or
//!   everything up to a k as in the first line.
//!
//! # Algorithm
//! Ours. Kept are the runs where left is true, where left is false, where right is true, where right
//! is false, and the samples that have been spoken of. Each new run of an operand is joined with its
//! neighbours, and what can be said because of the new samples is a range of samples i, since
//! begin and end are monotone:
//!
//! * right becomes true at k: all i that have k in their window, as far back as left is true up to k;
//! * left becomes true on [f, t): for each k after f at which right is true and which left now
//!   reaches, all i < t that have k in their window;
//! * left becomes false at p: all i <= p after the last such cut, if right is false from begin(i) to p;
//! * right becomes false on [f, t), so that it is false on [l, r): all i with l <= begin(i) and
//!   end(i) <= r; and those up to each cut in [f, r) with l <= begin(i);
//! * time passes: windows that are now over and in which right is false, or that are empty.
//!
//! # Cost
//! As in [`super`]. What lies before the first sample not yet spoken of is forgotten.

use super::super::Truth;
use super::super::runs::RunSet;
use super::super::timeline::{Span, Timeline};
use super::{After, Said, Speaker};

/// The state of one "until" or "eventually".
#[derive(Debug, Clone)]
pub(in super::super) struct Until {
    span: Span,
    /// Whether there is a left operand; otherwise it is true everywhere.
    has_left: bool,
    /// All samples before this one have been spoken of.
    done: u64,
    /// Those at or after `done` that have been spoken of.
    spoken: RunSet,
    left_true: RunSet,
    left_false: RunSet,
    right_true: RunSet,
    right_false: RunSet,
    left_said: RunSet,
    right_said: RunSet,
    /// One past the last sample at which an operand is unknown for good.
    unknown_to: u64,
    /// One past the last sample whose window is over.
    over: u64,
    /// Where the last questions to the timeline were answered.
    near_within: u64,
    near_beyond: u64,
    near_cut: u64,
}

impl Until {
    pub(super) fn new(span: Span, has_left: bool) -> Self {
        Until {
            span,
            has_left,
            done: 0,
            spoken: RunSet::default(),
            left_true: RunSet::default(),
            left_false: RunSet::default(),
            right_true: RunSet::default(),
            right_false: RunSet::default(),
            left_said: RunSet::default(),
            right_said: RunSet::default(),
            unknown_to: 0,
            over: 0,
            near_within: 0,
            near_beyond: 0,
            near_cut: 0,
        }
    }

    /// The first sample whose time may still be asked for.
    pub(super) fn needed_from(&self) -> u64 {
        match self.span {
            Span::Samples { .. } => u64::MAX,
            // The sample before the last one is asked about when time passes.
            Span::Seconds { .. } => self.done.saturating_sub(1),
        }
    }

    pub(super) fn stored(&self) -> usize {
        (self.left_true.len() + self.left_false.len() + self.left_said.len())
            + (self.right_true.len() + self.right_false.len() + self.right_said.len())
            + self.spoken.len()
    }

    /// Samples have been added to the timeline.
    #[inline]
    pub(super) fn tick(&mut self, timeline: &Timeline, speaker: &mut Speaker<'_>) {
        let over_before = self.over;
        self.over = timeline.end_over(self.span, timeline.count() - 1, over_before);
        if matches!(self.span, Span::Seconds { .. }) && self.over > over_before {
            self.windows_passed(timeline, speaker);
        }
    }

    /// Windows in seconds that were over before one of the new samples: those in which right was
    /// false to the end, and those without a sample.
    fn windows_passed(&mut self, timeline: &Timeline, speaker: &mut Speaker<'_>) {
        let fresh = timeline.fresh();
        let last = fresh.checked_sub(1);
        if let Some((from, _)) = last.and_then(|last| self.right_false.containing(last)) {
            let from = self.begins_at(from, timeline);
            self.near_within = timeline.first_within(self.span, fresh, self.near_within);
            self.speak(from, self.near_within, Truth::False, speaker);
        }
        if self.span.starts_now() {
            return;
        }
        for sample in fresh.max(1)..timeline.count() {
            let begun = timeline.end_beyond(self.span, sample - 1, self.near_beyond);
            let passed = timeline.first_within(self.span, sample, self.near_within);
            (self.near_beyond, self.near_within) = (begun, passed);
            self.speak(begun, passed, Truth::False, speaker);
        }
    }

    /// The first sample whose window begins at `sample` or later.
    #[inline]
    fn begins_at(&mut self, sample: u64, timeline: &Timeline) -> u64 {
        if sample <= self.done {
            return self.done;
        }
        let first = timeline.end_beyond(self.span, sample - 1, self.near_cut);
        self.near_cut = first;
        first
    }

    /// The first sample that has `sample` in its window, and one past the last one.
    #[inline]
    fn reached_by(&mut self, sample: u64, timeline: &Timeline) -> (u64, u64) {
        let first = timeline.first_within(self.span, sample, self.near_within);
        let end = timeline.end_beyond(self.span, sample, self.near_beyond);
        (self.near_within, self.near_beyond) = (first, end);
        (first, end)
    }

    /// Says the value of what has not been spoken of in `[from, to)`.
    #[inline]
    fn speak(&mut self, from: u64, to: u64, value: Truth, speaker: &mut Speaker<'_>) {
        let from = from.max(self.done);
        if from >= to {
            return;
        }
        if self.spoken.is_empty() && from == self.done {
            speaker.say(from, to, value);
            self.done = to;
            return;
        }
        self.spoken
            .gaps(from, to, |from, to| speaker.say(from, to, value));
        self.spoken.insert(from, to);
        while let Some((from, to)) = self.spoken.first().filter(|run| run.0 <= self.done) {
            self.done = to.max(from);
            self.spoken.forget_before(self.done);
        }
    }

    /// The left operand was said.
    #[inline]
    pub(super) fn left(&mut self, said: Said, timeline: &Timeline, speaker: &mut Speaker<'_>) {
        self.left_said.insert(said.from, said.to);
        // What lies before all samples not yet spoken of cannot matter.
        let (from, to) = (said.from.max(self.done), said.to);
        match said.value {
            _ if from >= to => {}
            Truth::True => self.left_true(from, to, timeline, speaker),
            Truth::False => self.left_false(from, to, timeline, speaker),
            Truth::Unknown => self.unknown_to = self.unknown_to.max(to),
        }
    }

    /// The right operand was said.
    #[inline]
    pub(super) fn right(&mut self, said: Said, timeline: &Timeline, speaker: &mut Speaker<'_>) {
        self.right_said.insert(said.from, said.to);
        // What lies before all samples not yet spoken of cannot matter.
        let (from, to) = (said.from.max(self.done), said.to);
        match said.value {
            _ if from >= to => {}
            Truth::True => self.right_true(from, to, timeline, speaker),
            Truth::False => self.right_false(from, to, timeline, speaker),
            Truth::Unknown => self.unknown_to = self.unknown_to.max(to),
        }
    }

    fn left_true(&mut self, from: u64, to: u64, timeline: &Timeline, speaker: &mut Speaker<'_>) {
        let (first, last) = self.left_true.insert(from, to);
        let mut at = from + 1;
        while let Some((k, _)) = self.right_true.next_from(at).filter(|run| run.0 <= last) {
            let (reached, end) = self.reached_by(k, timeline);
            self.speak(reached.max(first), end.min(to), Truth::True, speaker);
            if end >= to {
                return;
            }
            at = k + 1;
        }
    }

    fn left_false(&mut self, from: u64, to: u64, timeline: &Timeline, speaker: &mut Speaker<'_>) {
        let mut before = self.left_false.last_before(from).map_or(0, |cut| cut + 1);
        self.left_false.insert(from, to);
        for cut in from..to {
            let run = self.right_false.containing(cut);
            let from = self.begins_at(run.map_or(cut + 1, |run| run.0), timeline);
            self.speak(from.max(before), cut + 1, Truth::False, speaker);
            before = cut + 1;
        }
    }

    #[inline]
    fn right_true(&mut self, from: u64, to: u64, timeline: &Timeline, speaker: &mut Speaker<'_>) {
        self.right_true.insert(from, to);
        if !self.has_left && self.span.starts_now() {
            let first = timeline.first_within(self.span, from, self.near_within);
            self.near_within = first;
            self.speak(first, to, Truth::True, speaker);
            return;
        }
        for k in from..to {
            let (first, end) = self.reached_by(k, timeline);
            let first = if self.has_left {
                let run = k
                    .checked_sub(1)
                    .and_then(|last| self.left_true.containing(last));
                first.max(run.map_or(k, |run| run.0))
            } else {
                first
            };
            self.speak(first, end, Truth::True, speaker);
        }
    }

    #[inline]
    fn right_false(&mut self, from: u64, to: u64, timeline: &Timeline, speaker: &mut Speaker<'_>) {
        let (first, last) = self.right_false.insert(from, to);
        let begun = self.begins_at(first, timeline);
        let over = if last < timeline.count() {
            self.near_within = timeline.first_within(self.span, last, self.near_within);
            self.near_within
        } else {
            self.over
        };
        self.speak(begun, over, Truth::False, speaker);
        if self.has_left && !self.left_false.is_empty() {
            self.cuts(begun, from, to, last, speaker);
        }
    }

    /// Right is false from the beginning of the windows of all samples from `begun` on, to `last`;
    /// what is new of this is `[from, to)`.
    fn cuts(&mut self, begun: u64, from: u64, to: u64, last: u64, speaker: &mut Speaker<'_>) {
        let mut before = self.left_false.last_before(from).map_or(0, |cut| cut + 1);
        let mut at = from;
        while before < to
            && let Some((cut, _)) = self.left_false.next_from(at).filter(|run| run.0 < last)
        {
            self.speak(begun.max(before), cut + 1, Truth::False, speaker);
            before = cut + 1;
            at = cut + 1;
        }
    }

    /// Says what is unknown for good, and forgets what cannot matter any more.
    #[inline]
    pub(super) fn settle(&mut self, timeline: &Timeline, speaker: &mut Speaker<'_>) {
        while self.done < self.unknown_to && self.is_final(self.done, timeline) {
            self.speak(self.done, self.done + 1, Truth::Unknown, speaker);
        }
        self.left_true.forget_before(self.done);
        self.left_false.forget_before(self.done);
        let begin = match self.span {
            Span::Samples { low, .. } => self.done.saturating_add(low),
            Span::Seconds { .. } => self.done,
        };
        self.right_true.forget_before(begin);
        self.right_false.forget_before(begin);
    }

    /// Whether all that the value of `sample` may depend on has been said.
    fn is_final(&self, sample: u64, timeline: &Timeline) -> bool {
        let said_to = |said: &RunSet| said.first().filter(|run| run.0 == 0).map_or(0, |run| run.1);
        let right = said_to(&self.right_said);
        let left = if self.has_left {
            said_to(&self.left_said)
        } else {
            u64::MAX
        };
        if sample < self.over {
            let end = timeline.window_end(self.span, sample);
            if right >= end && left.saturating_add(1) >= end {
                return true;
            }
        }
        let said = left.min(right);
        if (self.left_false.next_from(sample)).is_some_and(|cut| cut.0 < said) {
            return true;
        }
        let begin = timeline.window_begin(self.span, sample);
        (self.right_true.next_from(begin)).is_some_and(|found| found.0 < right && found.0 <= left)
    }

    /// The trace is over: speaks of all samples that are left.
    pub(super) fn close(&mut self, timeline: &Timeline, after: After, speaker: &mut Speaker<'_>) {
        let count = timeline.count();
        let Some(now) = count.checked_sub(1) else {
            return;
        };
        if after == After::All(true) {
            let run = self.left_true.containing(now);
            let from = match run {
                _ if !self.has_left => 0,
                Some((from, _)) => from,
                None => count,
            };
            self.speak(self.over.max(from), count, Truth::True, speaker);
        } else {
            if let Some((from, _)) = self.right_false.containing(now) {
                let from = self.begins_at(from, timeline);
                self.speak(from, count, Truth::False, speaker);
            }
            let begun = timeline.end_beyond(self.span, now, self.near_beyond);
            self.speak(begun, count, Truth::False, speaker);
        }
        self.speak(self.done, count, Truth::Unknown, speaker);
    }
}
