//! The segments whose messages are being given, and which message is next.

use std::io::{Read, Seek};

use super::McapReader;
use super::loader::Loaded;
use super::walk::{Kind, Segment, clamped};
use crate::reader::{ReadError, TopicId};

/// A segment in memory, and its messages.
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
    /// Understands a segment that was loaded; `false` if nothing of it can be given, which is then
    /// noted as a loss.
    pub(super) fn understand(&mut self, segment: &Segment, loaded: Loaded) -> (OpenSegment, bool) {
        let mut opened = OpenSegment {
            offset: segment.offset,
            is_bare: matches!(segment.kind, Kind::Bare { .. }),
            loaded,
            entries: std::mem::take(&mut self.spare_entries),
            next: 0,
        };
        opened.entries.clear();
        if let Kind::Chunk { head, .. } = &segment.kind {
            self.is_checked &= head.crc != 0 && !segment.is_cut();
        }
        let taken = self
            .topics
            .take(segment.offset, &opened.loaded, &mut opened.entries);
        if let Err(problem) = taken {
            let span = (clamped(segment.start_nanos), clamped(segment.end_nanos));
            self.lose(segment.offset, problem, Some(span), segment.messages);
            return (opened, false);
        }
        for (message, count) in self.topics.new_notes() {
            self.lose(segment.offset, message, None, count);
        }
        self.check_times(segment, &mut opened);
        (opened, true)
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
    pub(super) fn next_loaded(&mut self) -> Result<Option<(Segment, Option<Loaded>)>, ReadError> {
        if self.waiting.len() > 1 {
            self.ahead.start();
        }
        self.load_ahead();
        let next = self.ahead.pop()?;
        self.load_ahead();
        Ok(next)
    }

    fn load_ahead(&mut self) {
        while let Some(segment) = self.waiting.pop_if(|next| self.ahead.has_room(next)) {
            let is_wanted = self.is_wanted(&segment);
            self.ahead.push(segment, is_wanted);
        }
    }

    /// Whether a segment may hold a message of a selected topic.
    fn is_wanted(&self, segment: &Segment) -> bool {
        let is_unwanted = |channel: &u16| {
            let topic = self.topics.of_channel(*channel);
            topic.is_some_and(|topic| self.wanted.get(topic.index()) == Some(&false))
        };
        let channels = segment.channels.as_deref().unwrap_or_default();
        channels.is_empty() || !channels.iter().all(is_unwanted)
    }

    /// The segment that is read next.
    fn upcoming(&self) -> Option<&Segment> {
        self.ahead.front().or(self.waiting.last())
    }

    /// Keeps the memory of a segment for others.
    pub(super) fn reuse(&mut self, done: OpenSegment) {
        self.ahead.reuse(done.loaded);
        self.spare_entries = done.entries;
    }

    /// Opens every segment that may hold the next message.
    fn open_due(&mut self) -> Result<(), ReadError> {
        while let Some(segment) = self.upcoming() {
            let next = self.open.iter().filter_map(OpenSegment::head).min();
            let is_due = match next {
                None => true,
                Some(_) if !self.in_time_order => false,
                Some((log_nanos, _)) => clamped(segment.start_nanos) <= log_nanos,
            };
            if !is_due {
                break;
            }
            let Some((segment, Some(loaded))) = self.next_loaded()? else {
                continue;
            };
            let (opened, is_sound) = self.understand(&segment, loaded);
            self.update_lengths();
            if is_sound && !opened.entries.is_empty() {
                self.open.push(opened);
            } else {
                self.reuse(opened);
            }
        }
        Ok(())
    }

    /// The open segment with the next message of a selected topic, and the message's place in it.
    pub(super) fn find_next(&mut self) -> Result<Option<(usize, Entry)>, ReadError> {
        if let Some(entry) = self.next_of_only_one() {
            return Ok(Some((0, entry)));
        }
        loop {
            self.drop_unwanted();
            self.open_due()?;
            self.drop_unwanted();
            let heads = self.open.iter().enumerate();
            let next = heads
                .filter_map(|(place, segment)| Some((segment.head()?, place)))
                .min();
            let Some(((log_nanos, _), place)) = next else {
                if self.upcoming().is_none() {
                    self.check_counts();
                    return Ok(None);
                }
                continue;
            };
            // Passing over unwanted messages may have made another segment due.
            if self.in_time_order && self.is_due(log_nanos) {
                continue;
            }
            let segment = &mut self.open[place];
            let entry = segment.entries[segment.next];
            segment.next += 1;
            return Ok(Some((place, entry)));
        }
    }

    /// Whether the segment that is read next may hold messages up to `log_nanos`.
    fn is_due(&self, log_nanos: i64) -> bool {
        let start = self.upcoming().map(|next| clamped(next.start_nanos));
        start.is_some_and(|start| start <= log_nanos)
    }

    /// The next message in the commonest case: there is one open segment, whose next message is
    /// selected, and no other segment is due.
    fn next_of_only_one(&mut self) -> Option<Entry> {
        let [segment] = &self.open[..] else {
            return None;
        };
        let entry = *segment.entries.get(segment.next)?;
        if !self.wanted[entry.topic.index()] || (self.in_time_order && self.is_due(entry.log_nanos))
        {
            return None;
        }
        self.open[0].next += 1;
        Some(entry)
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
                self.reuse(done);
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
