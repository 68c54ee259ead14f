//! Opens a file: what it holds, and in which order that will be read.

use std::collections::BTreeMap;
use std::io::{self, Read, Seek};

use super::McapReader;
use super::ahead::Ahead;
use super::loader::Loader;
use super::record::MAGIC;
use super::source::Source;
use super::summary::{Ending, Summary, read_ending};
use super::topics::Topics;
use super::walk::{Found, Kind, Segment, walk};
use crate::reader::{OpenOptions, ReadError, ReadProblem};
use crate::storage::{IndexState, StoredFile};

/// Whether what stands outside chunks can be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Outside {
    /// Nothing stands there that would have to be.
    Nothing,
    /// It has no checksum.
    Unguarded,
    Right,
    Wrong,
}

impl Outside {
    /// Checks what only the checksum over the whole guards: messages outside chunks, and with
    /// `is_described`, descriptions outside them.
    fn check<R: Read + Seek>(
        source: &mut Source<R>,
        found: &Found,
        is_described: bool,
    ) -> io::Result<Self> {
        if !found.segments.iter().any(is_bare) && !is_described {
            return Ok(Outside::Nothing);
        }
        Ok(match found.data_end.filter(|(_, crc)| *crc != 0) {
            None => Outside::Unguarded,
            Some((end, crc)) if source.crc(end)? == crc => Outside::Right,
            Some(_) => Outside::Wrong,
        })
    }
}

fn is_bare(segment: &Segment) -> bool {
    matches!(segment.kind, Kind::Bare { .. })
}

/// Whether descriptions stand outside chunks that a summary does not repeat.
fn is_described_outside(found: &Found, summary: Option<&Summary>) -> bool {
    let has_descriptions = !found.schemas.is_empty() || !found.channels.is_empty();
    has_descriptions && summary.is_none_or(|summary| summary.statistics.is_none())
}

fn stored(found: &Found, ending: &Ending) -> StoredFile {
    let index = match ending {
        Ending::Summarised(_) => IndexState::Sound,
        Ending::Unguarded => IndexState::Unguarded,
        Ending::Unfinished | Ending::Finished => IndexState::Missing,
        Ending::Damaged(..) => IndexState::Damaged,
    };
    let compressions = found
        .segments
        .iter()
        .filter_map(|segment| match &segment.kind {
            Kind::Chunk { head, .. } => Some(head.compression.as_str()),
            Kind::Bare { .. } => None,
        });
    StoredFile::of_chunks("MCAP", compressions, index)
}

impl<R: Read + Seek + Send + 'static> McapReader<R> {
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
        let is_described = is_described_outside(&found, summary);
        let outside = Outside::check(&mut source, &found, is_described)?;
        let mut reader = McapReader {
            options: options.clone(),
            topics: Topics::default(),
            metadata: BTreeMap::new(),
            stored: stored(&found, &ending),
            losses: Vec::new(),
            is_finished: !matches!(ending, Ending::Unfinished),
            is_checked: true,
            in_time_order: options.time_order,
            end_nanos: None,
            waiting: Vec::new(),
            ahead: Ahead::new(Loader::new(source, options.record_bytes)),
            open: Vec::new(),
            spare_entries: Vec::new(),
            wanted: Vec::new(),
            given: Vec::new(),
            counts_can_be_checked: false,
        };
        reader.begin(found, ending, (outside, is_described))?;
        Ok(reader)
    }

    /// Takes over what was found, and looks ahead if topics are not known yet.
    fn begin(
        &mut self,
        found: Found,
        ending: Ending,
        (outside, is_described): (Outside, bool),
    ) -> Result<(), ReadError> {
        self.metadata = found.metadata;
        self.losses = found.losses;
        if let Ending::Damaged(offset, problem) = ending {
            self.lose(offset, problem.to_owned(), None, None);
        }
        let summary = match ending {
            Ending::Summarised(summary) => summary,
            _ => Summary::default(),
        };
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
        let ends = found
            .segments
            .iter()
            .map(|it| super::walk::clamped(it.end_nanos));
        self.end_nanos = ends.max();
        self.waiting = found.segments;
        self.judge_outside(outside, is_described);
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

    /// Leaves messages outside chunks out if they cannot be trusted.
    fn judge_outside(&mut self, outside: Outside, is_described: bool) {
        match outside {
            Outside::Nothing | Outside::Right => {}
            Outside::Unguarded => self.is_checked = false,
            Outside::Wrong => {
                let bare = self.waiting.iter().filter(|segment| is_bare(segment));
                let messages = bare.clone().filter_map(|s| s.messages).sum();
                let offset = bare.clone().map(|s| s.offset).min().unwrap_or(0);
                self.waiting.retain(|segment| !is_bare(segment));
                self.is_checked &= !is_described;
                let problem = "the checksum over the whole is wrong, so messages outside chunks \
                               cannot be trusted";
                self.lose(offset, problem.to_owned(), None, Some(messages));
            }
        }
    }

    /// Reads everything once to learn all topics and how many messages each has.
    fn look_ahead(&mut self) -> Result<(), ReadError> {
        let mut counts = BTreeMap::new();
        let mut sound = Vec::new();
        // The next at the end, as everywhere.
        self.waiting.reverse();
        while let Some((segment, loaded)) = self.next_loaded()? {
            let Some(loaded) = loaded else { continue };
            let (opened, is_sound) = self.understand(&segment, loaded);
            if is_sound {
                for entry in &opened.entries {
                    *counts.entry(entry.topic).or_insert(0) += 1;
                }
                sound.push(segment);
            }
            self.reuse(opened);
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
}
