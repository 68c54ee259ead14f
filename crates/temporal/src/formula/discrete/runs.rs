//! Sets of samples as sorted runs.
//!
//! Truth values of signals change seldom in comparison with how often they are sampled, and what a
//! monitor still has to remember about them is a set of samples. A [`RunSet`] keeps such a set as
//! its maximal runs `[from, to)`, in ascending order. Samples mostly arrive in order, so the last
//! run is looked at first; otherwise a run is found by bisection.
//!
//! Cost: O(1) for an insertion at the end, O(log r) to find one of r runs, O(r) for an insertion
//! in the middle, which happens only when an operand is decided out of order.

use std::collections::VecDeque;

use super::Truth;

/// A set of samples, as maximal runs.
#[derive(Debug, Clone, Default)]
pub(super) struct RunSet {
    runs: VecDeque<(u64, u64)>,
}

impl RunSet {
    pub(super) fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// How many runs are stored.
    pub(super) fn len(&self) -> usize {
        self.runs.len()
    }

    pub(super) fn first(&self) -> Option<(u64, u64)> {
        self.runs.front().copied()
    }

    /// Position of the first run that ends after `sample`.
    #[inline]
    fn position(&self, sample: u64) -> usize {
        match self.runs.back() {
            None => 0,
            Some(&(_, to)) if to <= sample => self.runs.len(),
            Some(&(from, _)) if from <= sample => self.runs.len() - 1,
            Some(_) => self.runs.partition_point(|&(_, to)| to <= sample),
        }
    }

    /// Adds `[from, to)`, which must not be empty, and returns the maximal run it is now part of.
    #[inline]
    pub(super) fn insert(&mut self, from: u64, to: u64) -> (u64, u64) {
        match self.runs.back_mut() {
            None => {
                self.runs.push_back((from, to));
                (from, to)
            }
            Some(last) if last.1 == from => {
                last.1 = to;
                *last
            }
            Some(last) if last.1 < from => {
                self.runs.push_back((from, to));
                (from, to)
            }
            Some(_) => self.insert_inside(from, to),
        }
    }

    fn insert_inside(&mut self, from: u64, to: u64) -> (u64, u64) {
        let begin = self.runs.partition_point(|&(_, end)| end < from);
        let end = self.runs.partition_point(|&(start, _)| start <= to);
        if begin == end {
            self.runs.insert(begin, (from, to));
            return (from, to);
        }
        let merged = (from.min(self.runs[begin].0), to.max(self.runs[end - 1].1));
        self.runs[begin] = merged;
        if end > begin + 1 {
            self.runs.drain(begin + 1..end);
        }
        merged
    }

    /// The maximal run that contains `sample`.
    #[inline]
    pub(super) fn containing(&self, sample: u64) -> Option<(u64, u64)> {
        let run = *self.runs.get(self.position(sample))?;
        (run.0 <= sample).then_some(run)
    }

    /// The part from `sample` on of the first run that has such a part.
    #[inline]
    pub(super) fn next_from(&self, sample: u64) -> Option<(u64, u64)> {
        let run = *self.runs.get(self.position(sample))?;
        Some((run.0.max(sample), run.1))
    }

    /// The last element before `sample`.
    pub(super) fn last_before(&self, sample: u64) -> Option<u64> {
        let position = self.runs.partition_point(|&(from, _)| from < sample);
        let (_, to) = *self.runs.get(position.checked_sub(1)?)?;
        Some(to.min(sample) - 1)
    }

    /// Calls `found` for each maximal part of `[from, to)` that is missing.
    #[inline]
    pub(super) fn gaps(&self, from: u64, to: u64, mut found: impl FnMut(u64, u64)) {
        let mut at = from;
        let mut position = self.position(from);
        while at < to {
            match self.runs.get(position) {
                Some(&(start, end)) if start < to => {
                    if at < start {
                        found(at, start);
                    }
                    at = end;
                    position += 1;
                }
                _ => {
                    found(at, to);
                    return;
                }
            }
        }
    }

    /// Forgets all elements before `sample`.
    #[inline]
    pub(super) fn forget_before(&mut self, sample: u64) {
        while let Some(first) = self.runs.front_mut() {
            if first.1 <= sample {
                self.runs.pop_front();
            } else {
                first.0 = first.0.max(sample);
                return;
            }
        }
    }
}

/// Truth values of some samples, as runs of the same value.
#[derive(Debug, Clone, Default)]
pub(super) struct RunMap {
    runs: VecDeque<(u64, u64, Truth)>,
}

impl RunMap {
    /// How many runs are stored.
    pub(super) fn len(&self) -> usize {
        self.runs.len()
    }

    /// Sets the values of `[from, to)`, of which none is set.
    #[inline]
    pub(super) fn insert(&mut self, from: u64, to: u64, value: Truth) {
        match self.runs.back_mut() {
            Some(last) if last.1 == from && last.2 == value => last.1 = to,
            Some(last) if last.1 > from => {
                let position = self.runs.partition_point(|&(start, ..)| start < from);
                self.runs.insert(position, (from, to, value));
            }
            _ => self.runs.push_back((from, to, value)),
        }
    }

    /// Takes the values set in `[from, to)` out: `taken` is called for each maximal part, with
    /// its value, or none where no value is set.
    #[inline]
    pub(super) fn take(
        &mut self,
        from: u64,
        to: u64,
        mut taken: impl FnMut(u64, u64, Option<Truth>),
    ) {
        let mut position = match self.runs.front() {
            Some(&(_, end, _)) if end > from => 0,
            _ => self.runs.partition_point(|&(_, end, _)| end <= from),
        };
        let mut at = from;
        while at < to {
            let Some(&(start, end, value)) = self.runs.get(position).filter(|run| run.0 < to)
            else {
                taken(at, to, None);
                return;
            };
            if at < start {
                taken(at, start, None);
                at = start;
            }
            let until = end.min(to);
            taken(at, until, Some(value));
            position = self.cut(position, at, until);
            at = until;
        }
    }

    /// Removes `[from, to)` from the run at `position`, and returns the position of the first
    /// run that does not end before `to`.
    fn cut(&mut self, position: usize, from: u64, to: u64) -> usize {
        let (start, end, value) = self.runs[position];
        match (start < from, to < end) {
            (false, false) => {
                if position == 0 {
                    self.runs.pop_front();
                } else {
                    self.runs.remove(position);
                }
                position
            }
            (false, true) => {
                self.runs[position].0 = to;
                position
            }
            (true, false) => {
                self.runs[position].1 = from;
                position + 1
            }
            (true, true) => {
                self.runs[position].1 = from;
                self.runs.insert(position + 1, (to, end, value));
                position + 1
            }
        }
    }

    /// Takes the first run out if it begins at `sample`.
    #[inline]
    pub(super) fn take_first_at(&mut self, sample: u64) -> Option<(u64, Truth)> {
        let &(from, to, value) = self.runs.front()?;
        (from == sample).then(|| {
            self.runs.pop_front();
            (to, value)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every set of at most three runs within ten samples, against a set of booleans.
    #[test]
    fn runs_are_the_set() {
        let all: Vec<(u64, u64)> = (0..9)
            .flat_map(|from| (from + 1..=9).map(move |to| (from, to)))
            .collect();
        for &first in &all {
            for &second in &all {
                for &third in all.iter().step_by(3) {
                    let mut set = RunSet::default();
                    let mut plain = [false; 10];
                    for (from, to) in [first, second, third] {
                        let run = set.insert(from, to);
                        plain[from as usize..to as usize].fill(true);
                        assert!(run.0 <= from && to <= run.1);
                        assert!((run.0..run.1).all(|at| plain[at as usize]));
                        assert!(run.0 == 0 || !plain[run.0 as usize - 1]);
                        assert!(!plain[run.1 as usize]);
                    }
                    agrees(&set, &plain);
                    set.forget_before(4);
                    plain[..4].fill(false);
                    agrees(&set, &plain);
                }
            }
        }
    }

    fn agrees(set: &RunSet, plain: &[bool; 10]) {
        for at in 0..10_u64 {
            assert_eq!(set.containing(at).is_some(), plain[at as usize]);
            let next = (at..10).find(|&next| plain[next as usize]);
            assert_eq!(set.next_from(at).map(|run| run.0), next);
            let last = (0..at).rev().find(|&last| plain[last as usize]);
            assert_eq!(set.last_before(at), last);
        }
        let mut missing = [true; 10];
        set.gaps(0, 10, |from, to| {
            missing[from as usize..to as usize].fill(false);
        });
        assert_eq!(&missing, plain);
    }

    #[test]
    fn values_are_taken_once() {
        let mut map = RunMap::default();
        map.insert(0, 3, Truth::True);
        map.insert(3, 5, Truth::True);
        map.insert(8, 9, Truth::False);
        map.insert(5, 6, Truth::Unknown);
        let mut seen = Vec::new();
        map.take(1, 9, |from, to, value| seen.push((from, to, value)));
        assert_eq!(
            seen,
            [
                (1, 5, Some(Truth::True)),
                (5, 6, Some(Truth::Unknown)),
                (6, 8, None),
                (8, 9, Some(Truth::False))
            ]
        );
        assert_eq!(map.take_first_at(0), Some((1, Truth::True)));
        assert_eq!(map.len(), 0);
    }
}
