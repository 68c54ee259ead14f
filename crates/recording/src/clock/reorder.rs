//! Puts what comes nearly in order of time into order.

use std::cmp::{Ordering, Reverse};
use std::collections::{BinaryHeap, VecDeque};

/// Something that came after what follows it was given out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Late {
    /// How much earlier it is than what was given out last.
    pub by_nanos: i64,
}

/// What waits to be given out in order of time.
#[derive(Debug)]
pub(crate) struct ReorderBuffer<T> {
    /// What came in order; its times increase.
    in_order: VecDeque<Entry<T>>,
    /// What came later than that.
    behind: BinaryHeap<Reverse<Entry<T>>>,
    window_nanos: i64,
    max_waiting: usize,
    newest_arrival_nanos: i64,
    last_out_nanos: i64,
    sequence: u64,
}

#[derive(Debug)]
struct Entry<T> {
    time_nanos: i64,
    sequence: u64,
    arrival_nanos: i64,
    item: T,
}

impl<T> Entry<T> {
    fn key(&self) -> (i64, u64) {
        (self.time_nanos, self.sequence)
    }
}

impl<T> PartialEq for Entry<T> {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl<T> Eq for Entry<T> {}

impl<T> PartialOrd for Entry<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> Ord for Entry<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.key().cmp(&other.key())
    }
}

impl<T> ReorderBuffer<T> {
    /// An empty buffer in which things wait for `window_nanos`, but no more than `max_waiting`.
    pub fn new(window_nanos: i64, max_waiting: usize) -> Self {
        ReorderBuffer {
            in_order: VecDeque::new(),
            behind: BinaryHeap::new(),
            window_nanos: window_nanos.max(0),
            max_waiting,
            newest_arrival_nanos: i64::MIN,
            last_out_nanos: i64::MIN,
            sequence: 0,
        }
    }

    /// Takes `item` of time `time_nanos`, which arrived at `arrival_nanos` of another clock.
    pub fn push(&mut self, time_nanos: i64, arrival_nanos: i64, item: T) -> Result<(), Late> {
        self.newest_arrival_nanos = self.newest_arrival_nanos.max(arrival_nanos);
        if time_nanos < self.last_out_nanos {
            let by_nanos = self.last_out_nanos.saturating_sub(time_nanos);
            return Err(Late { by_nanos });
        }
        let entry = Entry {
            time_nanos,
            sequence: self.sequence,
            arrival_nanos,
            item,
        };
        self.sequence += 1;
        match self.in_order.back() {
            Some(last) if last.time_nanos > time_nanos => self.behind.push(Reverse(entry)),
            _ => self.in_order.push_back(entry),
        }
        Ok(())
    }

    /// Time and item of what has waited long enough, in order of time; `None` if nothing has.
    pub fn pop(&mut self) -> Option<(i64, T)> {
        let crowded = self.in_order.len() + self.behind.len() > self.max_waiting;
        let first = self.first()?;
        let ripe_nanos = first.arrival_nanos.saturating_add(self.window_nanos);
        (crowded || ripe_nanos <= self.newest_arrival_nanos).then(|| self.take())?
    }

    /// Time and item of the first of all that wait.
    pub fn pop_any(&mut self) -> Option<(i64, T)> {
        self.take()
    }

    /// The time of the first of all that wait.
    pub fn first_nanos(&self) -> Option<i64> {
        self.first().map(|entry| entry.time_nanos)
    }

    fn first(&self) -> Option<&Entry<T>> {
        match (self.in_order.front(), self.behind.peek()) {
            (Some(front), Some(Reverse(behind))) => Some(front.min(behind)),
            (front, behind) => front.or(behind.map(|Reverse(entry)| entry)),
        }
    }

    fn take(&mut self) -> Option<(i64, T)> {
        let from_behind = match (self.in_order.front(), self.behind.peek()) {
            (Some(front), Some(Reverse(behind))) => behind < front,
            (front, _) => front.is_none(),
        };
        let entry = if from_behind {
            self.behind.pop().map(|Reverse(entry)| entry)
        } else {
            self.in_order.pop_front()
        }?;
        self.last_out_nanos = entry.time_nanos;
        Some((entry.time_nanos, entry.item))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_stamp_far_in_the_future_delays_nothing_but_itself() {
        let mut buffer = ReorderBuffer::new(10, 1000);
        let mut out = Vec::new();
        buffer.push(1_000_000, 0, "future").unwrap();
        for time in 0..100 {
            // A pause longer than the window does not let it out either.
            let arrival = if time < 50 { time } else { time + 500 };
            buffer.push(time, arrival, "now").unwrap();
            out.extend(std::iter::from_fn(|| buffer.pop()));
        }
        assert_eq!(out.len(), 90);
        assert!(out.iter().all(|(_, item)| *item == "now"));
        assert_eq!(
            std::iter::from_fn(|| buffer.pop_any()).last(),
            Some((1_000_000, "future"))
        );
    }

    #[test]
    fn what_comes_too_late_is_refused() {
        let mut buffer = ReorderBuffer::new(5, 1000);
        for time in 0..=20 {
            buffer.push(time, time, ()).unwrap();
            while buffer.pop().is_some() {}
        }
        assert_eq!(buffer.push(15, 20, ()), Ok(()));
        assert_eq!(buffer.push(12, 20, ()), Err(Late { by_nanos: 3 }));
    }

    #[test]
    fn a_full_buffer_gives_out_the_first() {
        let mut buffer = ReorderBuffer::new(i64::MAX, 2);
        for time in [5, 3, 4] {
            buffer.push(time, 0, ()).unwrap();
        }
        assert_eq!(buffer.pop(), Some((3, ())));
        assert_eq!(buffer.pop(), None);
    }

    proptest! {
        /// Whatever is delayed by at most the window comes out sorted, stable and whole.
        #[test]
        fn bounded_delays_are_undone(delays in prop::collection::vec((0..20_i64, 0..=50_i64), 1..200)) {
            let mut time = 0;
            let mut sent: Vec<(i64, i64)> = Vec::new();
            for (step, delay) in delays {
                time += step;
                sent.push((time, time + delay));
            }
            sent.sort_by_key(|&(_, arrival)| arrival);
            let mut buffer = ReorderBuffer::new(50, usize::MAX);
            let mut out = Vec::new();
            for (index, &(time, arrival)) in sent.iter().enumerate() {
                prop_assert_eq!(buffer.push(time, arrival, index), Ok(()));
                out.extend(std::iter::from_fn(|| buffer.pop()));
            }
            out.extend(std::iter::from_fn(|| buffer.pop_any()));
            let mut expected: Vec<(i64, usize)> = sent.iter().enumerate().map(|(index, &(time, _))| (time, index)).collect();
            expected.sort();
            prop_assert_eq!(out, expected);
        }
    }
}
