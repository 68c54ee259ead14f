//! Robustness of `left U right` and `eventually right`.
//!
//! # Definition
//! At sample i with window W(i): the maximum over k in W(i) of the minimum of right at k and of
//! left at all samples of [i, k); without a left operand, the maximum of right over W(i).
//!
//! # Algorithm
//! The value of i is given once its window is over and both operands are known in it. Windows slide, so
//! it is a fold over a sliding window ([`super::fold`]); with a window that begins later than now it
//! is the minimum of that fold and of left from i to the beginning of the window. What comes
//! after the trace is one more sample, at which both operands have the same value.
//!
//! Where only the value at the first sample is asked for, that window does not slide: its fold is a
//! pair of numbers.

use super::fold::{Chain, Link, Peak};
use super::{Giver, Pairs, greater, smaller};
use crate::formula::discrete::timeline::{Span, Timeline, tolerance_secs};

/// The state of one "until" or "eventually".
#[derive(Debug, Clone)]
pub(super) struct Ahead {
    span: Span,
    pairs: Pairs,
    /// How many samples have been heard of.
    heard: u64,
    kind: Kind,
}

#[derive(Debug, Clone)]
enum Kind {
    First(First),
    Eventually(Slide, Peak),
    Until(Slide, Chain<false>, Peak),
}

/// The window of the first sample.
#[derive(Debug, Clone)]
struct First {
    start_secs: f64,
    /// Where it begins, if it has begun, and one past where it ends, if it is over.
    begin: Option<u64>,
    end: Option<u64>,
    fold: Link,
    given: bool,
}

/// The window that comes next.
#[derive(Debug, Clone, Default)]
struct Slide {
    /// The sample whose value is given next.
    next: u64,
    /// The first sample of its window, as far as is known.
    begin: u64,
    /// All samples before have windows that are over.
    over: u64,
    near_within: u64,
}

impl Ahead {
    pub(super) fn new(span: Span, has_left: bool, asked_once: bool) -> Self {
        let kind = match (asked_once, has_left) {
            (true, _) => Kind::First(First {
                start_secs: 0.0,
                begin: None,
                end: None,
                fold: Link::EMPTY,
                given: false,
            }),
            (false, false) => Kind::Eventually(Slide::default(), Peak::default()),
            (false, true) => Kind::Until(Slide::default(), Chain::default(), Peak::default()),
        };
        Ahead {
            span,
            pairs: Pairs::default(),
            heard: 0,
            kind,
        }
    }

    pub(super) fn needed_from(&self) -> u64 {
        match (&self.kind, self.span) {
            (Kind::Eventually(slide, _) | Kind::Until(slide, ..), Span::Seconds { .. }) => {
                slide.next
            }
            _ => u64::MAX,
        }
    }

    pub(super) fn stored(&self) -> usize {
        self.pairs.stored()
            + match &self.kind {
                Kind::First(_) => 1,
                Kind::Eventually(_, peak) => peak.len(),
                Kind::Until(_, chain, left) => chain.len() + left.len(),
            }
    }

    /// Samples have been added to the timeline.
    #[inline]
    pub(super) fn tick(&mut self, timeline: &Timeline, giver: &mut Giver<'_>) {
        let now = timeline.count() - 1;
        match &mut self.kind {
            Kind::First(first) => first.tick(self.span, timeline),
            Kind::Eventually(slide, _) | Kind::Until(slide, ..) => {
                slide.over = timeline.end_over(self.span, now, slide.over);
            }
        }
        self.give_ready(timeline, giver);
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
        match &mut self.kind {
            Kind::First(first) => first.hear(self.heard, left, right),
            Kind::Eventually(_, peak) => peak.push(self.heard, right),
            Kind::Until(_, chain, _) => chain.push(left, right),
        }
        self.heard += 1;
        self.give_ready(timeline, giver);
    }

    /// Gives the values of those samples whose windows are over and have been heard of.
    #[inline]
    fn give_ready(&mut self, timeline: &Timeline, giver: &mut Giver<'_>) {
        let limit = match &mut self.kind {
            Kind::First(first) => {
                if !first.given && first.end.is_some_and(|end| end <= self.heard) {
                    first.given = true;
                    giver.give(first.fold.reached);
                }
                return;
            }
            Kind::Eventually(slide, _) | Kind::Until(slide, ..) => {
                if self.heard == timeline.count() {
                    slide.over
                } else {
                    slide.near_within =
                        timeline.first_within(self.span, self.heard, slide.near_within);
                    slide.near_within
                }
            }
        };
        self.give_before(limit, None, timeline, giver);
    }

    /// Gives the values of all samples before `limit`; those `after` the trace are one more value
    /// of both operands.
    #[inline]
    fn give_before(
        &mut self,
        limit: u64,
        after: Option<f64>,
        timeline: &Timeline,
        giver: &mut Giver<'_>,
    ) {
        match &mut self.kind {
            Kind::First(_) => {}
            Kind::Eventually(slide, peak) => {
                while slide.next < limit {
                    slide.advance(self.span, self.heard, timeline);
                    peak.forget_before(slide.begin);
                    giver.give(after.map_or(peak.value(), |after| greater(peak.value(), after)));
                    slide.next += 1;
                }
            }
            Kind::Until(slide, chain, before) => {
                while slide.next < limit {
                    let begin = slide.begin;
                    slide.advance(self.span, self.heard, timeline);
                    for sample in begin..slide.begin {
                        // The greatest of the negated values is the least.
                        let left = chain.pop().unwrap_or(f64::INFINITY);
                        before.push(sample, -left);
                    }
                    before.forget_before(slide.next);
                    let Link { all_left, reached } = chain.fold();
                    let reached =
                        after.map_or(reached, |after| greater(reached, smaller(all_left, after)));
                    giver.give(smaller(-before.value(), reached));
                    slide.next += 1;
                }
            }
        }
    }

    /// The value of the first sample, if `after` is the value of both operands from now on. If not
    /// all that is missing of the operands is nothing or `after` (`plain`), this is known only where
    /// it does not matter.
    pub(super) fn first_so_far(&self, after: f64, plain: bool) -> Option<f64> {
        let Kind::First(first) = &self.kind else {
            return None;
        };
        let Link { all_left, reached } = first.fold;
        // A window that is over may have no sample whose value is still missing.
        let is_settled = |end: u64| first.begin.is_some_and(|it| it.max(self.heard) >= end);
        if first.given || first.end.is_some_and(is_settled) {
            return Some(reached);
        }
        let value = greater(reached, smaller(all_left, after));
        (plain || first.end.is_none() && value == f64::INFINITY).then_some(value)
    }

    /// The trace is over, and `after` is the value of both operands in what comes after it.
    pub(super) fn close(&mut self, timeline: &Timeline, after: f64, giver: &mut Giver<'_>) {
        if let Kind::First(first) = &mut self.kind {
            if !first.given && timeline.count() > 0 {
                let Link { all_left, reached } = first.fold;
                giver.give(greater(reached, smaller(all_left, after)));
            }
            return;
        }
        self.give_before(timeline.count(), Some(after), timeline, giver);
    }
}

impl First {
    #[inline]
    fn tick(&mut self, span: Span, timeline: &Timeline) {
        if timeline.fresh() == 0 {
            self.start(span, timeline);
        }
        let Span::Seconds { low, high } = span else {
            return;
        };
        if self.begin.is_some() && (self.end.is_some() || high == f64::INFINITY) {
            return;
        }
        for sample in timeline.fresh()..timeline.count() {
            let time_secs = timeline.time(sample);
            let (past_secs, tolerance_secs) =
                (time_secs - self.start_secs, tolerance_secs(time_secs));
            if self.begin.is_none() && past_secs >= low - tolerance_secs {
                self.begin = Some(sample);
            }
            // The window holds all samples of its last instant, which are added together.
            let is_same_instant =
                sample > timeline.fresh() && timeline.time(sample - 1) == time_secs;
            let is_open = self.end.is_none() || is_same_instant && self.end == Some(sample);
            if is_open && past_secs >= high - tolerance_secs {
                let is_member = past_secs <= high + tolerance_secs;
                self.end = Some(sample + u64::from(is_member));
            }
        }
    }

    fn start(&mut self, span: Span, timeline: &Timeline) {
        match span {
            Span::Samples { low, high } => {
                self.begin = Some(low);
                self.end = (high != u64::MAX).then(|| high.saturating_add(1));
            }
            Span::Seconds { .. } => self.start_secs = timeline.time(0),
        }
    }

    #[inline]
    fn hear(&mut self, sample: u64, left: f64, right: f64) {
        if self.end.is_some_and(|end| sample >= end) {
            return;
        }
        let is_member = self.begin.is_some_and(|begin| sample >= begin);
        self.fold = self.fold.then::<false>(Link {
            all_left: left,
            reached: if is_member { right } else { f64::NEG_INFINITY },
        });
    }
}

impl Slide {
    /// Finds the beginning of the window of the next sample, at most `heard`.
    #[inline]
    fn advance(&mut self, span: Span, heard: u64, timeline: &Timeline) {
        match span {
            Span::Samples { low, .. } => self.begin = self.next.saturating_add(low).min(heard),
            Span::Seconds { low, .. } => {
                self.begin = self.begin.max(self.next);
                let from_secs = timeline.time(self.next);
                while self.begin < heard {
                    let time_secs = timeline.time(self.begin);
                    if time_secs - from_secs >= low - tolerance_secs(time_secs) {
                        return;
                    }
                    self.begin += 1;
                }
            }
        }
    }
}
