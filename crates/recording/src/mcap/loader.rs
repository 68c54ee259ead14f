//! A segment of a file in memory: read, decompressed, checked, and split into its records.
//!
//! Nothing here depends on other segments, so it can be done on another thread
//! ([`Ahead`](super::ahead::Ahead)). What messages mean, which does depend on other segments, is
//! found out where they are read ([`Topics::take`](super::topics::Topics::take)).

use std::io::{self, Read, Seek};

use super::chunk::{Decompressor, beginning};
use super::record::{HEAD_BYTES, MessageHead, op, split_record};
use super::source::Source;
use super::walk::{Kind, Segment};

/// A message in a segment.
#[derive(Debug, Clone, Copy)]
pub(super) struct MessageAt {
    pub(super) head: MessageHead,
    /// Where its data begin and end in the segment.
    pub(super) start: u32,
    pub(super) end: u32,
}

/// A schema or channel in a segment.
#[derive(Debug, Clone, Copy)]
pub(super) struct DescriptionAt {
    /// How many messages stand before it.
    pub(super) messages_before: usize,
    pub(super) kind: u8,
    /// Where its content begins and ends in the segment.
    pub(super) start: usize,
    pub(super) end: usize,
}

/// A segment in memory.
#[derive(Debug, Default)]
pub(super) struct Loaded {
    pub(super) data: Vec<u8>,
    pub(super) messages: Vec<MessageAt>,
    pub(super) descriptions: Vec<DescriptionAt>,
    /// What is wrong behind the records above, as a clause.
    pub(super) problem: Option<String>,
}

/// Loads segments.
pub(super) struct Loader<R> {
    source: Source<R>,
    record_limit_bytes: u64,
    compressed: Vec<u8>,
    decompressor: Decompressor,
}

impl<R: Read + Seek> Loader<R> {
    pub(super) fn new(source: Source<R>, record_limit_bytes: u64) -> Self {
        Loader {
            source,
            record_limit_bytes,
            compressed: Vec::new(),
            decompressor: Decompressor::new(),
        }
    }

    /// Loads `segment` into `loaded`, whose memory is used again.
    ///
    /// # Errors
    /// Only what the operating system says; damage is [`Loaded::problem`].
    pub(super) fn load(&mut self, segment: &Segment, loaded: &mut Loaded) -> io::Result<()> {
        loaded.messages.clear();
        loaded.descriptions.clear();
        loaded.problem = self.bytes(segment, &mut loaded.data)?.err();
        if loaded.problem.is_none() {
            loaded.problem = loaded.split(segment.is_cut()).err();
        }
        Ok(())
    }

    /// The records of a segment as bytes; inside, what is wrong with them.
    fn bytes(&mut self, segment: &Segment, data: &mut Vec<u8>) -> io::Result<Result<(), String>> {
        match &segment.kind {
            Kind::Bare { bytes } => {
                data.clear();
                self.source.read(segment.offset, *bytes, data)?;
                Ok(Ok(()))
            }
            Kind::Chunk {
                head,
                present_bytes,
            } => {
                self.compressed.clear();
                let begin = segment.offset + HEAD_BYTES + head.head_bytes;
                self.source
                    .read(begin, *present_bytes, &mut self.compressed)?;
                let limit = self.record_limit_bytes;
                if segment.is_cut() {
                    *data = beginning(head, &self.compressed, limit);
                    return Ok(Ok(()));
                }
                let compressed = &mut self.compressed;
                Ok(self.decompressor.whole(head, compressed, limit, data))
            }
        }
    }
}

impl Loaded {
    /// Splits the bytes into records; of a segment that was cut, up to the first one that is not
    /// whole.
    fn split(&mut self, is_cut: bool) -> Result<(), String> {
        let data = &self.data[..];
        if u32::try_from(data.len()).is_err() {
            return Err("a chunk holds more than 4 GiB".to_owned());
        }
        let mut rest = data;
        while !rest.is_empty() {
            let Some((kind, content, after)) = split_record(rest) else {
                if is_cut {
                    break;
                }
                return Err("a record inside a chunk is malformed".to_owned());
            };
            rest = after;
            let end = data.len() - rest.len();
            let start = end - content.len();
            match kind {
                op::MESSAGE => {
                    let Some(head) = MessageHead::read(content) else {
                        return Err("a message inside a chunk is malformed".to_owned());
                    };
                    self.messages.push(MessageAt {
                        head,
                        start: (start + MessageHead::BYTES) as u32,
                        end: end as u32,
                    });
                }
                op::SCHEMA | op::CHANNEL => self.descriptions.push(DescriptionAt {
                    messages_before: self.messages.len(),
                    kind,
                    start,
                    end,
                }),
                _ => {
                    return Err(format!(
                        "a record of kind {kind:#04x} stands inside a chunk"
                    ));
                }
            }
        }
        Ok(())
    }
}
