//! Folds over sliding windows.
//!
//! * [`Peak`]: the greatest value of a window, by a monotone queue (D. Lemire, "Streaming
//!   maximum-minimum filter using no more than three comparisons per element", Nordic Journal of
//!   Computing 13, 2006).
//! * [`Chain`]: "until" over a window. For consecutive samples with values (l, r) of both operands,
//!   let a be the minimum of the l, and b the maximum over k of the minimum of r_k and all l before
//!   k. Two adjacent pieces (a, b) and (a', b') make (min(a, a'), max(b, min(a, b'))), which is
//!   associative; so a queue made of two stacks that keep partial folds gives the fold of any
//!   sliding window (the "two stacks" of K. Tangwongsan, M. Hirzel and S. Schneider, "Low-latency
//!   sliding-window aggregation in worst-case constant time", DEBS 2017). For "since" the same is
//!   done in mirror image: (min(a, a'), max(b', min(b, a'))).
//!
//! Cost: amortised O(1) for each sample, whatever the window; memory: the window.

use std::collections::VecDeque;

use super::{greater, smaller};

/// The greatest value of a sliding window.
#[derive(Debug, Clone, Default)]
pub(super) struct Peak {
    /// Samples and values, both increasing in age; values fall.
    queue: VecDeque<(u64, f64)>,
}

impl Peak {
    /// Adds the value of a sample after all others.
    #[inline]
    pub(super) fn push(&mut self, sample: u64, value: f64) {
        while self.queue.back().is_some_and(|last| last.1 <= value) {
            self.queue.pop_back();
        }
        self.queue.push_back((sample, value));
    }

    /// Takes away all samples before `sample`.
    #[inline]
    pub(super) fn forget_before(&mut self, sample: u64) {
        while self.queue.front().is_some_and(|first| first.0 < sample) {
            self.queue.pop_front();
        }
    }

    /// The greatest value; minus infinity if there is none.
    #[inline]
    pub(super) fn value(&self) -> f64 {
        self.queue
            .front()
            .map_or(f64::NEG_INFINITY, |first| first.1)
    }

    pub(super) fn len(&self) -> usize {
        self.queue.len()
    }
}

/// The fold of some consecutive samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Link {
    /// The least value of the left operand.
    pub(super) all_left: f64,
    /// The value of the until (or since) within these samples.
    pub(super) reached: f64,
}

impl Link {
    /// No samples.
    pub(super) const EMPTY: Self = Link {
        all_left: f64::INFINITY,
        reached: f64::NEG_INFINITY,
    };

    /// Of these samples and the later ones of `next`; mirrored for "since".
    #[inline]
    pub(super) fn then<const MIRRORED: bool>(self, next: Self) -> Self {
        let reached = if MIRRORED {
            greater(next.reached, smaller(self.reached, next.all_left))
        } else {
            greater(self.reached, smaller(self.all_left, next.reached))
        };
        Link {
            all_left: smaller(self.all_left, next.all_left),
            reached,
        }
    }
}

/// A sliding window of samples with their fold.
#[derive(Debug, Clone)]
pub(super) struct Chain<const MIRRORED: bool> {
    /// Older samples, the oldest last: the sample's left value, and the fold from it on.
    old: Vec<(f64, Link)>,
    /// Later samples.
    new: Vec<Link>,
    new_fold: Link,
}

impl<const MIRRORED: bool> Default for Chain<MIRRORED> {
    fn default() -> Self {
        Chain {
            old: Vec::new(),
            new: Vec::new(),
            new_fold: Link::EMPTY,
        }
    }
}

impl<const MIRRORED: bool> Chain<MIRRORED> {
    /// Adds the sample after all others.
    #[inline]
    pub(super) fn push(&mut self, left: f64, right: f64) {
        let link = Link {
            all_left: left,
            reached: right,
        };
        self.new.push(link);
        self.new_fold = self.new_fold.then::<MIRRORED>(link);
    }

    /// Takes the first sample away and returns its left value.
    #[inline]
    pub(super) fn pop(&mut self) -> Option<f64> {
        if self.old.is_empty() {
            let mut fold = Link::EMPTY;
            for link in self.new.drain(..).rev() {
                fold = link.then::<MIRRORED>(fold);
                self.old.push((link.all_left, fold));
            }
            self.new_fold = Link::EMPTY;
        }
        self.old.pop().map(|(left, _)| left)
    }

    /// The fold of all samples.
    #[inline]
    pub(super) fn fold(&self) -> Link {
        let old = self.old.last().map_or(Link::EMPTY, |(_, fold)| *fold);
        old.then::<MIRRORED>(self.new_fold)
    }

    pub(super) fn len(&self) -> usize {
        self.old.len() + self.new.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Windows of every length up to 12 over a pseudo-random word, against the definition.
    #[test]
    fn folds_are_what_they_say() {
        let value = |at: u64| ((at * 2_654_435_761) % 1_000) as f64 - 500.0;
        for length in 1..12_u64 {
            let (mut until, mut since) = (Chain::<false>::default(), Chain::<true>::default());
            let mut peak = Peak::default();
            for now in 0..60_u64 {
                until.push(value(2 * now), value(2 * now + 1));
                since.push(value(2 * now), value(2 * now + 1));
                peak.push(now, value(now));
                if now >= length {
                    until.pop();
                    since.pop();
                }
                let from = (now + 1).saturating_sub(length);
                peak.forget_before(from);
                let least = |range: std::ops::Range<u64>| {
                    range.map(|j| value(2 * j)).fold(f64::INFINITY, f64::min)
                };
                let reached = (from..=now)
                    .map(|k| value(2 * k + 1).min(least(from..k)))
                    .fold(f64::NEG_INFINITY, f64::max);
                assert_eq!(until.fold().reached, reached);
                let reached = (from..=now)
                    .map(|k| value(2 * k + 1).min(least(k + 1..now + 1)))
                    .fold(f64::NEG_INFINITY, f64::max);
                assert_eq!(since.fold().reached, reached);
                assert_eq!(until.fold().all_left, least(from..now + 1));
                let most = (from..=now).map(value).fold(f64::NEG_INFINITY, f64::max);
                assert_eq!(peak.value(), most);
            }
        }
    }
}
