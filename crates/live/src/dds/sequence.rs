//! Counting what is missing, by the numbers of the messages.
//!
//! Definition: a DDS writer numbers its messages 1, 2, 3, …. If the message after number `n` of a writer has number
//! `m > n + 1`, then `m - n - 1` messages are missing: lost on the way (best effort) or no longer kept by the writer
//! when they were asked for again (reliable, history "keep last"). Numbers that do not grow are repetitions and are left
//! out. Source: OMG DDSI-RTPS 2.5, 8.3.5.4 and 8.4.12 (a best-effort reader takes only growing numbers).

use std::collections::{BTreeMap, BTreeSet};

/// How many writers are remembered at most after they have gone: one that comes back (it was merely unreachable) goes
/// on with its numbers, and what was missed is counted.
const GONE_WRITERS_KEPT: usize = 1024;

/// The last number of each writer of a topic; `W` identifies a writer.
#[derive(Debug, Default)]
pub(crate) struct Numbers<W: Ord> {
    last: BTreeMap<W, i64>,
}

/// What a message's number says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Numbered {
    /// The first from this writer, which sent so many before.
    First { sent_before: u64 },
    /// The one after the last.
    Next,
    /// So many are missing before it.
    After { missing: u64 },
    /// It was there already.
    Repeated,
}

impl<W: Ord + Copy> Numbers<W> {
    pub(crate) fn new() -> Self {
        Self {
            last: BTreeMap::new(),
        }
    }

    /// Takes note of a message.
    pub(crate) fn note(&mut self, writer: W, number: i64) -> Numbered {
        let gap = |from: i64| u64::try_from(number.saturating_sub(from)).unwrap_or(0);
        match self.last.insert(writer, number) {
            None => Numbered::First {
                sent_before: gap(1),
            },
            Some(last) if last.checked_add(1) == Some(number) => Numbered::Next,
            Some(last) if number > last => Numbered::After {
                missing: gap(last.saturating_add(1)),
            },
            Some(last) => {
                self.last.insert(writer, last);
                Numbered::Repeated
            }
        }
    }

    /// Forgets the writers that are gone if they have become too many.
    pub(crate) fn forget_gone(&mut self, present: &BTreeSet<W>) {
        if self.last.len() > present.len() + GONE_WRITERS_KEPT {
            self.last.retain(|writer, _| present.contains(writer));
        }
    }
}

/// When messages could be handed out. Of each writer they are noted in the order of their numbers: one that was lost
/// and sent again arrives after those that follow it, and these could be handed out only when it had arrived.
#[derive(Debug, Default)]
pub(crate) struct Releases<W: Ord, T: Ord> {
    latest: BTreeMap<W, T>,
}

impl<W: Ord + Copy, T: Ord + Copy> Releases<W, T> {
    pub(crate) fn new() -> Self {
        Self {
            latest: BTreeMap::new(),
        }
    }

    /// The time at which a message that arrived at `arrived` could be handed out.
    pub(crate) fn note(&mut self, writer: W, arrived: T) -> T {
        let latest = self.latest.entry(writer).or_insert(arrived);
        *latest = arrived.max(*latest);
        *latest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_counted_for_each_writer() {
        let mut numbers = Numbers::new();
        assert_eq!(numbers.note('a', 5), Numbered::First { sent_before: 4 });
        assert_eq!(numbers.note('b', 1), Numbered::First { sent_before: 0 });
        assert_eq!(numbers.note('a', 6), Numbered::Next);
        assert_eq!(numbers.note('a', 10), Numbered::After { missing: 3 });
        assert_eq!(numbers.note('a', 10), Numbered::Repeated);
        assert_eq!(numbers.note('a', 7), Numbered::Repeated);
        assert_eq!(numbers.note('a', 11), Numbered::Next);
        assert_eq!(numbers.note('b', 2), Numbered::Next);
    }

    #[test]
    fn what_was_sent_again_holds_back_what_follows_it_of_the_same_writer() {
        let mut releases = Releases::new();
        // Numbers 1 to 4 of writer a arrive at 10, 40 (again), 20, 50; one of writer b at 30.
        let mut order: Vec<(i32, &str)> = Vec::new();
        for (name, writer, arrived) in [
            ("a1", 'a', 10),
            ("a2", 'a', 40),
            ("a3", 'a', 20),
            ("a4", 'a', 50),
            ("b1", 'b', 30),
        ] {
            order.push((releases.note(writer, arrived), name));
        }
        order.sort_by_key(|(released, _)| *released);
        let names: Vec<&str> = order.into_iter().map(|(_, name)| name).collect();
        assert_eq!(names, ["a1", "b1", "a2", "a3", "a4"]);
    }

    #[test]
    fn hostile_numbers_do_not_overflow() {
        let mut numbers = Numbers::new();
        assert_eq!(
            numbers.note(0, i64::MIN),
            Numbered::First { sent_before: 0 }
        );
        assert!(matches!(numbers.note(0, i64::MAX), Numbered::After { .. }));
        assert_eq!(numbers.note(0, i64::MAX), Numbered::Repeated);
    }

    #[test]
    fn writers_that_are_gone_are_remembered_up_to_a_bound() {
        let mut numbers = Numbers::new();
        for writer in 0..=GONE_WRITERS_KEPT {
            numbers.note(writer, 1);
        }
        let present = BTreeSet::from([0]);
        numbers.forget_gone(&present);
        assert_eq!(numbers.note(1, 5), Numbered::After { missing: 3 });
        numbers.note(GONE_WRITERS_KEPT + 1, 1);
        numbers.forget_gone(&present);
        assert_eq!(numbers.note(0, 2), Numbered::Next);
        assert_eq!(numbers.note(1, 6), Numbered::First { sent_before: 5 });
    }
}
