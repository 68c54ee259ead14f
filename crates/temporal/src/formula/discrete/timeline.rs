//! Which samples lie in whose window.
//!
//! A window `[low, high]` pairs each sample with those that are between `low` and `high` later
//! (operators of the future) or earlier (of the past): counted in samples, or measured by the
//! samples' own times, which need not be regular. For two samples e <= l the distance is l - e or
//! t_l - t_e, and both "at least `low`" and "at most `high`" are monotone in e and in l. So
//! every question below is a partition point, found from where the last one was.
//!
//! Times are compared with a tolerance of 1 ns, the resolution of recorded times, or of four units
//! in the last place of the later time where that is coarser (as in [`crate::monitor`]). A window
//! is over at the first sample whose distance is at least `high` within this tolerance, which is
//! its last member if the distance is at most `high` within the tolerance.
//!
//! Cost: O(1) amortised when asked in order; O(log W) with W samples kept otherwise.

use std::collections::VecDeque;

pub(super) use crate::clock::tolerance_secs;

/// How far a window reaches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Span {
    /// Distances in samples; `high` is `u64::MAX` when there is no end.
    Samples { low: u64, high: u64 },
    /// Distances in seconds; `high` is infinite when there is no end.
    Seconds { low: f64, high: f64 },
}

impl Span {
    pub(super) fn is_bounded(self) -> bool {
        match self {
            Span::Samples { high, .. } => high != u64::MAX,
            Span::Seconds { high, .. } => high.is_finite(),
        }
    }

    /// Whether every sample is in its own window.
    pub(super) fn starts_now(self) -> bool {
        match self {
            Span::Samples { low, .. } => low == 0,
            Span::Seconds { low, .. } => low <= 0.0,
        }
    }
}

/// The times of the samples that windows may still ask for.
#[derive(Debug, Clone)]
pub(super) struct Timeline {
    /// Whether times are kept at all: only windows in seconds need them.
    keeps_times: bool,
    times_secs: VecDeque<f64>,
    /// The number of the first sample whose time is kept.
    base: u64,
    /// How many samples there have been.
    count: u64,
    /// The first one of those that were added last.
    fresh: u64,
}

impl Timeline {
    pub(super) fn new(keeps_times: bool) -> Self {
        Timeline {
            keeps_times,
            times_secs: VecDeque::new(),
            base: 0,
            count: 0,
            fresh: 0,
        }
    }

    /// The first one of those samples that were added last.
    #[inline]
    pub(super) fn fresh(&self) -> u64 {
        self.fresh
    }

    /// How many samples there have been.
    #[inline]
    pub(super) fn count(&self) -> u64 {
        self.count
    }

    /// How many times are stored.
    pub(super) fn stored(&self) -> usize {
        self.times_secs.len()
    }

    /// Adds samples with these times.
    #[inline]
    pub(super) fn add(&mut self, times_secs: &[f64]) {
        self.fresh = self.count;
        self.count += times_secs.len() as u64;
        if self.keeps_times {
            self.times_secs.extend(times_secs);
        }
    }

    /// Makes the last `count` samples those that were added last.
    pub(super) fn freshen(&mut self, count: u64) {
        self.fresh = self.count - count;
    }

    /// Takes the samples that were added last away again.
    pub(super) fn take_back(&mut self) {
        self.count = self.fresh;
        if self.keeps_times {
            self.times_secs.truncate((self.fresh - self.base) as usize);
        }
    }

    /// Forgets times before that of `sample`.
    pub(super) fn forget_before(&mut self, sample: u64) {
        let sample = sample.min(self.count);
        if self.keeps_times && sample > self.base {
            self.times_secs.drain(..(sample - self.base) as usize);
            self.base = sample;
        }
    }

    /// The time of a sample that is kept.
    #[inline]
    pub(super) fn time(&self, sample: u64) -> f64 {
        self.times_secs[(sample - self.base) as usize]
    }

    /// The first sample that is no more than the span's end before `later`: the first one whose
    /// window of the future is not over before `later`, and the first member of the window of the
    /// past of `later`. `near` is a guess.
    #[inline]
    pub(super) fn first_within(&self, span: Span, later: u64, near: u64) -> u64 {
        match span {
            Span::Samples { high, .. } => later.saturating_sub(high),
            Span::Seconds { high, .. } if high == f64::INFINITY => 0,
            Span::Seconds { high, .. } => {
                let time_secs = self.time(later);
                let limit = high + tolerance_secs(time_secs);
                self.partition(later, near, |e| time_secs - e > limit)
            }
        }
    }

    /// One past the last sample that is at least the span's beginning before `later`: the end of
    /// those whose window of the future has begun at `later`, and of the window of the past of
    /// `later`.
    #[inline]
    pub(super) fn end_beyond(&self, span: Span, later: u64, near: u64) -> u64 {
        match span {
            Span::Samples { low, .. } => (later + 1).saturating_sub(low),
            Span::Seconds { low, .. } if low <= 0.0 => later + 1,
            Span::Seconds { low, .. } => self.end_at_distance(low, later, near),
        }
    }

    /// One past the last sample whose window of the future is over when `later` has been seen.
    #[inline]
    pub(super) fn end_over(&self, span: Span, later: u64, near: u64) -> u64 {
        match span {
            Span::Samples { high, .. } => (later + 1).saturating_sub(high),
            Span::Seconds { high, .. } if high == f64::INFINITY => 0,
            Span::Seconds { high, .. } => self.end_at_distance(high, later, near),
        }
    }

    #[inline]
    fn end_at_distance(&self, distance_secs: f64, later: u64, near: u64) -> u64 {
        let time_secs = self.time(later);
        let limit = distance_secs - tolerance_secs(time_secs);
        self.partition(later + 1, near, |e| time_secs - e >= limit)
    }

    /// The first sample of the future window of `earlier`, or one past the last sample if it has not
    /// begun.
    pub(super) fn window_begin(&self, span: Span, earlier: u64) -> u64 {
        match span {
            Span::Samples { low, .. } => earlier.saturating_add(low),
            Span::Seconds { low, .. } => {
                let from_secs = self.time(earlier);
                self.search_between(earlier, self.count, |later| {
                    later - from_secs < low - tolerance_secs(later)
                })
            }
        }
    }

    /// One past the last sample seen of the future window of `earlier`.
    pub(super) fn window_end(&self, span: Span, earlier: u64) -> u64 {
        match span {
            Span::Samples { high, .. } => earlier.saturating_add(high).saturating_add(1),
            Span::Seconds { high, .. } => {
                let from_secs = self.time(earlier);
                self.search_between(earlier, self.count, |later| {
                    later - from_secs <= high + tolerance_secs(later)
                })
            }
        }
    }

    /// The first of the kept samples before `end` whose time is not `early`, or `end`; `early` is
    /// true of a prefix. Searches by doubling steps from `near`.
    #[inline]
    fn partition(&self, end: u64, near: u64, early: impl Fn(f64) -> bool) -> u64 {
        let near = near.clamp(self.base, end.max(self.base));
        if near < end && early(self.time(near)) {
            self.search_up(near + 1, end, early)
        } else if near > self.base && !early(self.time(near - 1)) {
            self.search_between(self.base, near - 1, early)
        } else {
            near
        }
    }

    /// Everything before `from` is early.
    fn search_up(&self, mut from: u64, end: u64, early: impl Fn(f64) -> bool) -> u64 {
        let mut stride = 1;
        while from < end {
            let probe = (from + stride - 1).min(end - 1);
            if !early(self.time(probe)) {
                return self.search_between(from, probe, early);
            }
            from = probe + 1;
            stride *= 2;
        }
        end
    }

    /// Everything before `from` is early, and `to` is not.
    fn search_between(&self, mut from: u64, mut to: u64, early: impl Fn(f64) -> bool) -> u64 {
        while from < to {
            let middle = from + (to - from) / 2;
            if early(self.time(middle)) {
                from = middle + 1;
            } else {
                to = middle;
            }
        }
        from
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn partition_points_do_not_depend_on_the_guess() {
        let times = [0.0, 0.1, 0.5, 0.6, 2.0, 2.1, 2.2, 7.0];
        let mut timeline = Timeline::new(true);
        timeline.add(&times);
        let span = Span::Seconds {
            low: 0.1,
            high: 1.6,
        };
        for later in 0..8_u64 {
            for near in 0..10 {
                let now = times[later as usize];
                let within = (0..=later).find(|&e| now - times[e as usize] <= 1.6 + 1e-9);
                assert_eq!(Some(timeline.first_within(span, later, near)), within);
                let beyond = (0..=later)
                    .filter(|&e| now - times[e as usize] >= 0.1 - 1e-9)
                    .count() as u64;
                assert_eq!(timeline.end_beyond(span, later, near), beyond);
            }
        }
    }

    #[test]
    fn deadlines_are_met_on_the_nanosecond() {
        let mut timeline = Timeline::new(true);
        for tick in 0..=20 {
            timeline.add(&[f64::from(tick) * 0.1]);
        }
        let span = Span::Seconds {
            low: 0.0,
            high: 0.3,
        };
        // 0.1 * 3 is not 0.3 in binary, nor 1.7 - 1.4.
        for later in 3..=20 {
            assert_eq!(timeline.first_within(span, later, 0), later - 3);
            assert_eq!(timeline.end_over(span, later, 0), later - 2);
        }
    }
}
