//! Recordings in MCAP, read as they come, in memory that does not grow with the file.
//!
//! Source: <https://mcap.dev/spec>. Opening goes from record to record of the file and notes where
//! chunks begin and which times they span (`walk`); a chunk is read when its first message may
//! be the next one, checked, and dropped when its last message was given.
//!
//! # Order
//! Messages come in order of their log time; those of equal times in the order of the file. Chunks
//! whose times overlap are open together. Where that would take more than
//! [`OpenOptions::memory_bytes`], messages come in the order of the file, and
//! [`Reader::in_time_order`] says so. A chunk whose head does not tell the truth about its times is
//! noted as a loss, since its messages may then be out of order.
//!
//! # Damage
//! | found | given |
//! |---|---|
//! | no footer, or cut anywhere | everything before the cut; of a chunk that was cut, what can be decompressed |
//! | a chunk whose checksum is wrong, or that cannot be decompressed | everything else; nothing of that chunk |
//! | a length that cannot be right | everything else, from the next chunk on |
//! | a wrong checksum over the whole, where messages stand outside chunks | no message outside chunks |
//!
//! Each is a [`Loss`] with its place. A chunk or a file whose writer left the checksum out is read
//! without it, and [`Reader::checked`] is then false: a flipped bit in it cannot be told from data.
//! The same holds for what is recovered of a chunk that was cut.
//!
//! # Cost
//! Opening costs one small read for each chunk; a file without chunks, and a file without a summary
//! ([`OpenOptions::look_ahead`]), is read once as a whole. Then each chunk is read once.

mod chunk;
mod record;
mod source;
mod summary;
mod topics;
mod walk;

use std::collections::BTreeMap;
use std::io::{Read, Seek};

use crate::reader::{
    Loss, OpenOptions, RawMessage, ReadError, ReadProblem, Reader, TopicId, TopicInfo,
};
use chunk::{Decompressor, beginning};
use record::{HEAD_BYTES, MAGIC, MessageHead, op, split_record};
use source::Source;
use summary::{Ending, Summary, read_ending};
use topics::Topics;
use walk::{Found, Kind, Segment, clamped, walk};

/// An MCAP file that is being read.
pub(crate) struct McapReader<R> {
    source: Source<R>,
    options: OpenOptions,
    topics: Topics,
    metadata: BTreeMap<String, String>,
    losses: Vec<Loss>,
    is_finished: bool,
    is_checked: bool,
    in_time_order: bool,
    /// What is still to be read, the next at the end.
    waiting: Vec<Segment>,
    open: Vec<OpenSegment>,
    /// Memory for segments to come.
    spare: Vec<OpenSegment>,
    compressed: Vec<u8>,
    decompressor: Decompressor,
    wanted: Vec<bool>,
    given: Vec<u64>,
    counts_can_be_checked: bool,
}

/// A chunk in memory.
#[derive(Default)]
struct OpenSegment {
    /// Where it begins, or its first message if they stand outside chunks.
    offset: u64,
    is_bare: bool,
    data: Vec<u8>,
    entries: Vec<Entry>,
    next: usize,
}

/// A message in a segment.
#[derive(Debug, Clone, Copy)]
struct Entry {
    log_nanos: i64,
    publish_nanos: i64,
    topic: TopicId,
    /// Where its data begin and end in the segment.
    start: u32,
    end: u32,
}

impl<R: Read + Seek> McapReader<R> {
    /// Opens a file.
    ///
    /// # Errors
    /// [`ReadError`] if it is empty or no MCAP file, or the operating system refuses.
    pub(crate) fn new(inner: R, options: &OpenOptions) -> Result<Self, ReadError> {
        let mut source = Source::new(inner)?;
        if source.bytes == 0 {
            return Err(ReadProblem::Empty.into());
        }
        if source.peek(0, MAGIC.len())? != MAGIC {
            return Err(ReadError {
                path: None,
                offset: Some(0),
                problem: ReadProblem::Malformed(
                    "it does not begin as MCAP files do; record it again, or copy it again from \
                     where it was made"
                        .to_owned(),
                ),
            });
        }
        let ending = read_ending(&mut source, options.record_bytes)?;
        let summary = match &ending {
            Ending::Summarised(summary) => Some(summary),
            _ => None,
        };
        let found = walk(&mut source, summary, options.record_bytes)?;
        let mut reader = McapReader {
            source,
            options: options.clone(),
            topics: Topics::default(),
            metadata: BTreeMap::new(),
            losses: Vec::new(),
            is_finished: !matches!(ending, Ending::Unfinished),
            is_checked: true,
            in_time_order: options.time_order,
            waiting: Vec::new(),
            open: Vec::new(),
            spare: Vec::new(),
            compressed: Vec::new(),
            decompressor: Decompressor::new(),
            wanted: Vec::new(),
            given: Vec::new(),
            counts_can_be_checked: false,
        };
        reader.begin(found, ending)?;
        Ok(reader)
    }

    /// Takes over what was found, and looks ahead if topics are not known yet.
    fn begin(&mut self, found: Found, ending: Ending) -> Result<(), ReadError> {
        self.metadata = found.metadata;
        self.losses = found.losses;
        if let Ending::Damaged(offset, problem) = ending {
            self.lose(offset, problem.to_owned(), None, None);
        }
        let summary = match ending {
            Ending::Summarised(summary) => summary,
            _ => Summary::default(),
        };
        let is_described_outside = !found.schemas.is_empty() || !found.channels.is_empty();
        let needs_whole = is_described_outside && summary.statistics.is_none();
        for schema in summary.schemas.into_iter().chain(found.schemas) {
            if !self.topics.add_schema(schema) {
                self.lose(0, "a schema is described twice".to_owned(), None, None);
            }
        }
        for channel in summary.channels.into_iter().chain(found.channels) {
            if !self.topics.add_channel(channel) {
                self.lose(0, "a channel is described twice".to_owned(), None, None);
            }
        }
        let knows_all = summary.statistics.as_ref().is_some_and(|statistics| {
            statistics.channels as usize == self.topics.all.len()
                && statistics.messages.len() <= self.topics.all.len()
        });
        self.waiting = found.segments;
        self.check_bare(found.data_end, needs_whole)?;
        if knows_all && let Some(statistics) = summary.statistics {
            self.topics.set_counts(&statistics.messages);
            self.counts_can_be_checked = true;
        } else if self.options.look_ahead {
            self.look_ahead()?;
        }
        self.order();
        self.update_lengths();
        Ok(())
    }

    /// Checks messages outside chunks, which only the checksum over the whole guards, and
    /// descriptions outside them where the summary does not repeat them.
    fn check_bare(
        &mut self,
        data_end: Option<(u64, u32)>,
        is_described_outside: bool,
    ) -> Result<(), ReadError> {
        let is_bare = |segment: &Segment| matches!(segment.kind, Kind::Bare { .. });
        if !self.waiting.iter().any(is_bare) && !is_described_outside {
            return Ok(());
        }
        match data_end.filter(|(_, crc)| *crc != 0) {
            None => self.is_checked = false,
            Some((end, crc)) if self.source.crc(end)? != crc => {
                let bare = self.waiting.iter().filter(|s| is_bare(s));
                let messages = bare.clone().filter_map(|s| s.messages).sum();
                let offset = bare.clone().map(|s| s.offset).min().unwrap_or(0);
                self.waiting.retain(|segment| !is_bare(segment));
                self.is_checked &= !is_described_outside;
                let problem = "the checksum over the whole is wrong, so messages outside chunks \
                               cannot be trusted";
                self.lose(offset, problem.to_owned(), None, Some(messages));
            }
            Some(_) => {}
        }
        Ok(())
    }

    /// Reads everything once to learn all topics and how many messages each has.
    fn look_ahead(&mut self) -> Result<(), ReadError> {
        let mut counts = BTreeMap::new();
        let mut sound = Vec::new();
        for segment in std::mem::take(&mut self.waiting) {
            let mut opened = self.spare.pop().unwrap_or_default();
            if self.load(&segment, &mut opened)? {
                for entry in &opened.entries {
                    *counts.entry(entry.topic).or_insert(0) += 1;
                }
                sound.push(segment);
            }
            self.spare.push(opened);
        }
        self.waiting = sound;
        for info in &mut self.topics.all {
            info.message_count = Some(counts.get(&info.id).copied().unwrap_or(0));
        }
        // Noted once; what is read again is the same.
        self.topics.forget_notes();
        Ok(())
    }

    /// Puts the segments into the order in which they are opened, the first at the end.
    fn order(&mut self) {
        if self.in_time_order {
            self.waiting.sort_by_key(|s| (s.start_nanos, s.offset));
            let mut open: Vec<(u64, u64)> = Vec::new();
            for segment in &self.waiting {
                open.retain(|(end, _)| *end >= segment.start_nanos);
                open.push((segment.end_nanos, segment.memory_bytes()));
                let bytes = open
                    .iter()
                    .fold(0_u64, |sum, (_, b)| sum.saturating_add(*b));
                if open.len() > 1 && bytes > self.options.memory_bytes {
                    self.in_time_order = false;
                    break;
                }
            }
        }
        if !self.in_time_order {
            self.waiting.sort_by_key(|segment| segment.offset);
        }
        self.waiting.reverse();
    }

    fn update_lengths(&mut self) {
        self.wanted.resize(self.topics.all.len(), true);
        self.given.resize(self.topics.all.len(), 0);
    }

    fn lose(
        &mut self,
        offset: u64,
        message: String,
        span_nanos: Option<(i64, i64)>,
        messages: Option<u64>,
    ) {
        self.losses.push(Loss {
            offset,
            message,
            span_nanos,
            messages,
        });
    }

    /// Reads a segment into memory; `false` if nothing of it can be given.
    fn load(&mut self, segment: &Segment, opened: &mut OpenSegment) -> Result<bool, ReadError> {
        opened.offset = segment.offset;
        opened.is_bare = matches!(segment.kind, Kind::Bare { .. });
        opened.next = 0;
        opened.entries.clear();
        let is_cut = segment.is_cut();
        let read = match &segment.kind {
            Kind::Bare { bytes } => {
                opened.data.clear();
                self.source.read(segment.offset, *bytes, &mut opened.data)?;
                Ok(())
            }
            Kind::Chunk {
                head,
                present_bytes,
            } => {
                self.compressed.clear();
                let begin = segment.offset + HEAD_BYTES + head.head_bytes;
                self.source
                    .read(begin, *present_bytes, &mut self.compressed)?;
                self.is_checked &= head.crc != 0 && !is_cut;
                let limit = self.options.record_bytes;
                if is_cut {
                    opened.data = beginning(head, &self.compressed, limit);
                    Ok(())
                } else {
                    let (data, compressed) = (&mut opened.data, &self.compressed);
                    self.decompressor.whole(head, compressed, limit, data)
                }
            }
        };
        let taken = read.and_then(|()| self.topics.take(opened, is_cut));
        let span = (clamped(segment.start_nanos), clamped(segment.end_nanos));
        if let Err(problem) = taken {
            self.lose(segment.offset, problem, Some(span), segment.messages);
            return Ok(false);
        }
        for (message, count) in self.topics.new_notes() {
            self.lose(segment.offset, message, None, count);
        }
        self.check_times(segment, opened);
        Ok(true)
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

    /// Opens every segment that may hold the next message.
    fn open_due(&mut self) -> Result<(), ReadError> {
        while let Some(segment) = self.waiting.last() {
            let next = self.open.iter().filter_map(OpenSegment::head).min();
            let is_due = match next {
                None => true,
                Some(_) if !self.in_time_order => false,
                Some((log_nanos, _)) => clamped(segment.start_nanos) <= log_nanos,
            };
            if !is_due {
                break;
            }
            let Some(segment) = self.waiting.pop() else {
                break;
            };
            let unwanted = |channel: &u16| {
                let topic = self.topics.of_channel(*channel);
                topic.is_some_and(|topic| !self.wanted[topic.index()])
            };
            let channels = segment.channels.as_deref();
            if channels.is_some_and(|all| !all.is_empty() && all.iter().all(unwanted)) {
                continue;
            }
            let mut opened = self.spare.pop().unwrap_or_default();
            let is_sound = self.load(&segment, &mut opened)?;
            self.update_lengths();
            if is_sound && !opened.entries.is_empty() {
                self.open.push(opened);
            } else {
                self.spare.push(opened);
            }
        }
        Ok(())
    }

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

impl OpenSegment {
    /// What decides which message is next: its time, then its place in the file.
    fn head(&self) -> Option<(i64, u64)> {
        let entry = self.entries.get(self.next)?;
        Some((entry.log_nanos, self.offset))
    }
}

impl<R: Read + Seek> Reader for McapReader<R> {
    fn topics(&self) -> &[TopicInfo] {
        &self.topics.all
    }

    fn next(&mut self) -> Result<Option<RawMessage<'_>>, ReadError> {
        let found = match self.find_next() {
            Ok(found) => found,
            Err(error) => {
                self.waiting.clear();
                self.open.clear();
                self.is_finished = false;
                return Err(error);
            }
        };
        let Some((place, entry)) = found else {
            return Ok(None);
        };
        self.given[entry.topic.index()] += 1;
        let segment = &self.open[place];
        let (start, end) = (entry.start as usize, entry.end as usize);
        let inside = match segment.is_bare {
            true => u64::from(entry.start) - HEAD_BYTES - MessageHead::BYTES as u64,
            false => 0,
        };
        Ok(Some(RawMessage {
            topic: entry.topic,
            log_nanos: entry.log_nanos,
            publish_nanos: entry.publish_nanos,
            data: &segment.data[start..end],
            offset: segment.offset + inside,
        }))
    }

    fn losses(&self) -> &[Loss] {
        &self.losses
    }

    fn complete(&self) -> bool {
        self.is_finished && self.losses.is_empty()
    }

    fn select(&mut self, wanted: &dyn Fn(&TopicInfo) -> bool) {
        self.wanted = self.topics.all.iter().map(wanted).collect();
        self.counts_can_be_checked &= self.given.iter().all(|given| *given == 0);
    }

    fn metadata(&self) -> &BTreeMap<String, String> {
        &self.metadata
    }

    fn in_time_order(&self) -> bool {
        self.in_time_order
    }

    fn checked(&self) -> bool {
        self.is_checked
    }
}
