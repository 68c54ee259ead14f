//! The segments whose messages are being given, and which message is next.

use std::io::{Read, Seek};

use super::McapReader;
use super::loader::Loaded;
use super::walk::{Kind, Segment, clamped};
use crate::reader::{ReadError, TopicId};

/// A segment in memory, and its messages.
#[derive(Default)]
pub(super) struct OpenSegment {
    /// Where it begins, or its first message if they stand outside chunks.
    pub(super) offset: u64,
    pub(super) is_bare: bool,
    pub(super) loaded: Loaded,
    pub(super) entries: Vec<Entry>,
    next: usize,
}

/// A message in a segment.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    pub(super) log_nanos: i64,
    pub(super) publish_nanos: i64,
    pub(super) topic: TopicId,
    /// Where its data begin and end in the segment.
    pub(super) start: u32,
    pub(super) end: u32,
}

impl OpenSegment {
    /// What decides which message is next: its time, then its place in the file.
    fn head(&self) -> Option<(i64, u64)> {
        let entry = self.entries.get(self.next)?;
        Some((entry.log_nanos, self.offset))
    }
}

impl<R: Read + Seek + Send + 'static> McapReader<R> {
    /// Understands a segment that was loaded; an error if nothing of it can be given, which is then
    /// noted as a loss.
    pub(super) fn understand(
        &mut self,
        segment: &Segment,
        loaded: Loaded,
    ) -> Result<OpenSegment, OpenSegment> {
        let mut opened = OpenSegment {
            offset: segment.offset,
            is_bare: matches!(segment.kind, Kind::Bare { .. }),
            loaded,
            ..OpenSegment::default()
        };
        if let Kind::Chunk { head, .. } = &segment.kind {
            self.is_checked &= head.crc != 0 && !segment.is_cut();
        }
        let taken = self
            .topics
            .take(segment.offset, &opened.loaded, &mut opened.entries);
        if let Err(problem) = taken {
            let span = (clamped(segment.start_nanos), clamped(segment.end_nanos));
            self.lose(segment.offset, problem, Some(span), segment.messages);
            return Err(opened);
        }
        for (message, count) in self.topics.new_notes() {
            self.lose(segment.offset, message, None, count);
        }
        self.check_times(segment, &mut opened);
        Ok(opened)
    }

    /// Sorts the messages of a segment, and checks that its head tells the truth about their times.
    fn check_times(&mut self, segment: &Segment, opened: &mut OpenSegment) {
        let entries = &mut opened.entries;
        let (start, end) = (clamped(segment.start_nanos), clamped(segment.end_nanos));
        let is_outside = |entry: &Entry| entry.log_nanos < start || entry.log_nanos > end;
        if entries.iter().any(is_outside) && self.topics.note_once(segment.offset) {
            let problem = "the times of a chunk are not those of its messages, which may \
                           therefore be out of order";
            self.lose(segment.offset, problem.to_owned(), None, Some(0));
        }
        if self.in_time_order && !entries.is_sorted_by_key(|entry| entry.log_nanos) {
            entries.sort_by_key(|entry| entry.log_nanos);
        }
    }

    /// Takes the segment that is read next, loaded if it is wanted; lets more be loaded meanwhile.
    pub(super) fn next_loaded(
        &mut self,
        is_wanted: &dyn Fn(&Segment) -> bool,
    ) -> Result<Option<(Segment, Option<Loaded>)>, ReadError> {
        self.load_ahead(is_wanted);
        let next = self.ahead.pop()?;
        self.load_ahead(is_wanted);
        Ok(next)
    }

@@@
    /// The open segment with the next message of a selected topic, and the message's place in it.
    fn find_next(&mut self) -> Result<Option<(usize, Entry)>, ReadError> {
        loop {
            self.drop_unwanted();
            self.open_due()?;
            self.drop_unwanted();
            let heads = self.open.iter().enumerate();
            let next = heads
                .filter_map(|(place, segment)| Some((segment.head()?, place)))
                .min();
            let Some((_, place)) = next else {
                if self.waiting.is_empty() {
                    self.check_counts();
                    return Ok(None);
                }
                continue;
            };
            // Passing over unwanted messages may have made another segment due.
            let (log_nanos, _) = next.map(|(head, _)| head).unwrap_or_default();
            let waits = self.waiting.last().map(|s| clamped(s.start_nanos));
            if self.in_time_order && waits.is_some_and(|start| start <= log_nanos) {
                continue;
            }
            let segment = &mut self.open[place];
            let entry = segment.entries[segment.next];
            segment.next += 1;
            return Ok(Some((place, entry)));
        }
    }

    /// Passes over messages of topics that are not selected, and closes segments that are done.
    fn drop_unwanted(&mut self) {
        let mut place = 0;
        while place < self.open.len() {
            let segment = &mut self.open[place];
            while let Some(entry) = segment.entries.get(segment.next)
                && !self.wanted[entry.topic.index()]
            {
                segment.next += 1;
            }
            if segment.next >= segment.entries.len() {
                let done = self.open.remove(place);
                self.spare.push(done);
                self.spare.truncate(2);
            } else {
                place += 1;
            }
        }
    }

    /// At the end: compares what was given with what the summary counts.
    fn check_counts(&mut self) {
        if !std::mem::take(&mut self.counts_can_be_checked) || !self.losses.is_empty() {
            return;
        }
        for index in 0..self.topics.all.len() {
            let info = &self.topics.all[index];
            let Some(counted) = info.message_count.filter(|_| self.wanted[index]) else {
                continue;
            };
            let given = self.given[index];
            if given != counted {
                let problem = format!(
                    "the summary counts {counted} messages of {}, but there are {given}",
                    info.name
                );
                self.lose(0, problem, None, counted.checked_sub(given));
            }
        }
    }
}

}
