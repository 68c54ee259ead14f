//! Recordings in MCAP, read as they come, in memory that does not grow with the file.
//!
//! Source: <https://mcap.dev/spec>. Opening goes from record to record of the file and notes where
//! chunks begin and which times they span (`walk`); a chunk is read when its first message may
//! be the next one, checked, and dropped when its last message was given. A second thread reads,
//! decompresses and checks the next chunks meanwhile (`ahead`); what is given, and what is noted
//! when, does not depend on it.
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

mod ahead;
mod chunk;
mod loader;
mod opening;
mod record;
mod segments;
mod source;
mod summary;
mod topics;
mod walk;

use std::collections::BTreeMap;
use std::io::{Read, Seek};

use crate::reader::{Loss, OpenOptions, RawMessage, ReadError, Reader, TopicInfo};
use crate::storage::StoredFile;
use ahead::Ahead;
use record::{HEAD_BYTES, MessageHead};
use segments::{Entry, OpenSegment};
use topics::Topics;
use walk::Segment;

/// An MCAP file that is being read.
pub(crate) struct McapReader<R> {
    options: OpenOptions,
    topics: Topics,
    metadata: BTreeMap<String, String>,
    stored: StoredFile,
    losses: Vec<Loss>,
    is_finished: bool,
    is_checked: bool,
    in_time_order: bool,
    /// When its last message was logged.
    end_nanos: Option<i64>,
    /// What is still to be read, the next at the end.
    waiting: Vec<Segment>,
    /// What is read before that.
    ahead: Ahead<R>,
    open: Vec<OpenSegment>,
    /// Memory for the messages of segments to come.
    spare_entries: Vec<Entry>,
    wanted: Vec<bool>,
    given: Vec<u64>,
    counts_can_be_checked: bool,
}

impl<R> McapReader<R> {
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
}

impl<R: Read + Seek + Send + 'static> Reader for McapReader<R> {
    fn topics(&self) -> &[TopicInfo] {
        &self.topics.all
    }

    fn next(&mut self) -> Result<Option<RawMessage<'_>>, ReadError> {
        let found = match self.find_next() {
            Ok(found) => found,
            Err(error) => {
                self.ahead.clear();
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
            data: &segment.loaded.data[start..end],
            offset: segment.offset + inside,
        }))
    }

    fn losses(&self) -> &[Loss] {
        &self.losses
    }

    fn end_nanos(&self) -> Option<i64> {
        self.end_nanos
    }

    fn complete(&self) -> bool {
        self.is_finished && self.losses.is_empty()
    }

    fn select(&mut self, wanted: &dyn Fn(&TopicInfo) -> bool) {
        self.wanted = self.topics.all.iter().map(wanted).collect();
        // What is loaded ahead was chosen by what was wanted before.
        self.waiting.extend(self.ahead.clear().into_iter().rev());
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

    fn storage(&self) -> Vec<StoredFile> {
        vec![self.stored.clone()]
    }
}

#[cfg(test)]
mod tests;
