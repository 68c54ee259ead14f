//! Finds what a file holds by going from record to record, without reading the chunks' contents.
//!
//! The file itself is walked even if it has an index, so that nothing in it is overlooked; the index
//! only helps to get past damage, and is checked against what was found. Where a record's length
//! cannot be right and there is no index, the next chunk is searched for: its head says several
//! lengths, which must agree, and its checksum then decides.

use std::collections::BTreeMap;
use std::io::{self, Read, Seek};

use super::record::{
    ChannelRecord, ChunkHead, Fields, HEAD_BYTES, MAGIC, MessageHead, SchemaRecord, op,
};
use super::source::Source;
use super::summary::Summary;
use crate::reader::Loss;

/// Messages outside chunks are taken together up to this many bytes.
const BARE_BYTES: u64 = 1 << 20;

/// A part of the file that holds messages.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Segment {
    /// Where it begins.
    pub(super) offset: u64,
    pub(super) kind: Kind,
    /// The times it spans, as far as known.
    pub(super) start_nanos: u64,
    pub(super) end_nanos: u64,
    /// Number of messages, as far as known.
    pub(super) messages: Option<u64>,
    /// The channels it has messages of, where a checked summary says so.
    pub(super) channels: Option<Vec<u16>>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Kind {
    /// A chunk; its compressed records and how many of their bytes are there.
    Chunk { head: ChunkHead, present_bytes: u64 },
    /// Message records one after another.
    Bare { bytes: u64 },
}

impl Segment {
    /// The memory it takes when it is open.
    pub(super) fn memory_bytes(&self) -> u64 {
        match &self.kind {
            Kind::Chunk { head, .. } => head.uncompressed_bytes,
            Kind::Bare { bytes } => *bytes,
        }
    }

    pub(super) fn is_cut(&self) -> bool {
        matches!(&self.kind, Kind::Chunk { head, present_bytes }
            if *present_bytes < head.compressed_bytes)
    }
}

/// What was found in a file.
#[derive(Default)]
pub(super) struct Found {
    pub(super) segments: Vec<Segment>,
    pub(super) schemas: Vec<SchemaRecord>,
    pub(super) channels: Vec<ChannelRecord>,
    pub(super) metadata: BTreeMap<String, String>,
    pub(super) losses: Vec<Loss>,
    /// Where the data ends, and their checksum, if the end was reached.
    pub(super) data_end: Option<(u64, u32)>,
}

/// Why a record cannot be taken.
enum Trouble {
    Io(io::Error),
    /// What is wrong; the walk may go on behind the record.
    Skip(String),
    /// What is wrong; where the next record begins is not known.
    Lost(String),
    /// The file ends inside the record.
    Cut(&'static str),
}

impl From<io::Error> for Trouble {
    fn from(error: io::Error) -> Self {
        Trouble::Io(error)
    }
}

pub(super) fn walk<R: Read + Seek>(
    source: &mut Source<R>,
    summary: Option<&Summary>,
    record_limit_bytes: u64,
) -> io::Result<Found> {
    let mut walker = Walker {
        source,
        summary,
        record_limit_bytes,
        found: Found::default(),
    };
    walker.run()?;
    let mut found = walker.found;
    if let Some(summary) = summary {
        check_against(&mut found, summary);
    }
    Ok(found)
}

struct Walker<'s, R> {
    source: &'s mut Source<R>,
    summary: Option<&'s Summary>,
    record_limit_bytes: u64,
    found: Found,
}

impl<R: Read + Seek> Walker<'_, R> {
    fn run(&mut self) -> io::Result<()> {
        let mut at = MAGIC.len() as u64;
        while self.found.data_end.is_none() {
            let left = self.source.bytes.saturating_sub(at);
            if left == 0 {
                self.lose(at, "the file ends without the end of its data".to_owned());
                return Ok(());
            }
            let (kind, length) = match self.head(at)? {
                Some(head) => head,
                None => {
                    self.lose(
                        at,
                        "the file is cut short at the head of a record".to_owned(),
                    );
                    return Ok(());
                }
            };
            let behind = at.saturating_add(HEAD_BYTES).saturating_add(length);
            match self.record(kind, at, length) {
                Ok(()) => at = behind,
                Err(Trouble::Io(error)) => return Err(error),
                Err(Trouble::Skip(problem)) => {
                    self.lose(at, problem);
                    at = behind;
                }
                Err(Trouble::Cut(what)) if self.next_chunk(at)?.is_none() => {
                    self.lose(at, format!("the file is cut short inside {what}"));
                    return Ok(());
                }
                Err(Trouble::Cut(what)) => {
                    let problem = format!("the length of {what} is wrong");
                    let Some(next) = self.resume(at, problem)? else {
                        return Ok(());
                    };
                    at = next;
                }
                Err(Trouble::Lost(problem)) => {
                    let Some(next) = self.resume(at, problem)? else {
                        return Ok(());
                    };
                    at = next;
                }
            }
        }
        Ok(())
    }

    fn resume(&mut self, at: u64, problem: String) -> io::Result<Option<u64>> {
        let next = self.next_chunk(at)?;
        let lost_bytes = next.unwrap_or(self.source.bytes) - at;
        self.lose(at, format!("{problem}; {lost_bytes} bytes are passed over"));
        Ok(next)
    }

    fn lose(&mut self, offset: u64, message: String) {
        self.found.losses.push(Loss {
            offset,
            message,
            span_nanos: None,
            messages: None,
        });
    }

    fn head(&mut self, at: u64) -> io::Result<Option<(u8, u64)>> {
        let bytes = self.source.peek(at, HEAD_BYTES as usize)?;
        let head = bytes.split_first().and_then(|(kind, rest)| {
            let length = rest.first_chunk::<8>()?;
            Some((*kind, u64::from_le_bytes(*length)))
        });
        Ok(head)
    }

    /// Takes one record.
    fn record(&mut self, kind: u8, at: u64, length: u64) -> Result<(), Trouble> {
        let left = self.source.bytes - at - HEAD_BYTES;
        let is_whole = length <= left;
        let what = match kind {
            op::CHUNK => return self.chunk(at, length, left),
            op::HEADER if at == MAGIC.len() as u64 => "the header",
            op::SCHEMA => "a schema",
            op::CHANNEL => "a channel",
            op::MESSAGE => "a message",
            op::MESSAGE_INDEX => "an index of messages",
            op::ATTACHMENT => "an attachment",
            op::METADATA => "metadata",
            op::DATA_END => "the end of the data",
            0x80.. if is_whole && self.summary.is_some() => return Ok(()),
            0x80.. if is_whole => {
                let problem = format!("a record of unknown kind {kind:#04x}");
                return Err(Trouble::Skip(problem));
            }
            _ => {
                let problem = format!("a record of kind {kind:#04x} has no place here");
                return Err(Trouble::Lost(problem));
            }
        };
        if !is_whole {
            return Err(Trouble::Cut(what));
        }
        let malformed = || Trouble::Lost(format!("{what} is malformed"));
        match kind {
            op::MESSAGE => self.message(at, length).map_err(|trouble| match trouble {
                Trouble::Skip(_) => malformed(),
                other => other,
            }),
            op::MESSAGE_INDEX => self.message_index(at, length)?.ok_or_else(malformed),
            op::ATTACHMENT => Ok(()),
            op::DATA_END if length == 4 => {
                let content = self.source.peek(at + HEAD_BYTES, 4)?;
                let crc = Fields(content).u32().ok_or_else(malformed)?;
                self.found.data_end = Some((at, crc));
                Ok(())
            }
            _ if length > self.record_limit_bytes => Err(malformed()),
            _ => {
                let mut content = Vec::new();
                self.source.read(at + HEAD_BYTES, length, &mut content)?;
                self.described(kind, &content).ok_or_else(malformed)
            }
        }
    }

    /// Takes a record that describes others.
    fn described(&mut self, kind: u8, content: &[u8]) -> Option<()> {
        let mut fields = Fields(content);
        match kind {
            op::SCHEMA => self.found.schemas.push(SchemaRecord::read(content)?),
            op::CHANNEL => self.found.channels.push(ChannelRecord::read(content)?),
            op::HEADER => {
                let (profile, library) = (fields.text()?, fields.text()?);
                for (name, text) in [("profile", profile), ("library", library)] {
                    if !text.is_empty() {
                        self.found.metadata.insert(format!("mcap.{name}"), text);
                    }
                }
            }
            op::METADATA => {
                let name = fields.text()?;
                for (key, value) in fields.texts()? {
                    self.found.metadata.insert(format!("{name}.{key}"), value);
                }
            }
            _ => return None,
        }
        Some(())
    }

    fn message(&mut self, at: u64, length: u64) -> Result<(), Trouble> {
        let content = self.source.peek(at + HEAD_BYTES, MessageHead::BYTES)?;
        let head = MessageHead::read(content).filter(|_| length >= MessageHead::BYTES as u64);
        let Some(head) = head else {
            return Err(Trouble::Skip(String::new()));
        };
        let whole = HEAD_BYTES + length;
        if let Some(last) = self.found.segments.last_mut()
            && let Kind::Bare { bytes } = &mut last.kind
            && last.offset + *bytes == at
            && *bytes + whole <= BARE_BYTES
        {
            *bytes += whole;
            last.start_nanos = last.start_nanos.min(head.log_nanos);
            last.end_nanos = last.end_nanos.max(head.log_nanos);
            last.messages = last.messages.map(|count| count + 1);
            return Ok(());
        }
        self.found.segments.push(Segment {
            offset: at,
            kind: Kind::Bare { bytes: whole },
            start_nanos: head.log_nanos,
            end_nanos: head.log_nanos,
            messages: Some(1),
            channels: None,
        });
        Ok(())
    }

    /// Counts the messages of the chunk before; `None` if it is malformed.
    fn message_index(&mut self, at: u64, length: u64) -> Result<Option<()>, Trouble> {
        let mut fields = Fields(self.source.peek(at + HEAD_BYTES, 6)?);
        let (_channel, bytes) = (fields.u16(), fields.u32());
        let Some(bytes) = bytes.filter(|bytes| u64::from(*bytes) + 6 == length) else {
            return Ok(None);
        };
        if let Some(last) = self.found.segments.last_mut() {
            let counted = last.messages.unwrap_or(0) + u64::from(bytes) / 16;
            last.messages = Some(counted);
        }
        Ok(Some(()))
    }

    fn chunk(&mut self, at: u64, length: u64, left: u64) -> Result<(), Trouble> {
        let content = self.source.peek(at + HEAD_BYTES, ChunkHead::MOST_BYTES)?;
        let Some(head) = ChunkHead::read(content) else {
            return Err(match left < ChunkHead::MOST_BYTES as u64 {
                true => Trouble::Cut("a chunk"),
                false => Trouble::Lost("the head of a chunk is malformed".to_owned()),
            });
        };
        if head.head_bytes.checked_add(head.compressed_bytes) != Some(length) {
            let problem = "the lengths in the head of a chunk contradict each other".to_owned();
            return Err(Trouble::Lost(problem));
        }
        let present_bytes = head.compressed_bytes.min(left - head.head_bytes);
        let is_cut = present_bytes < head.compressed_bytes;
        if is_cut && self.next_chunk(at)?.is_some() {
            return Err(Trouble::Lost("the length of a chunk is wrong".to_owned()));
        }
        self.found.segments.push(Segment {
            offset: at,
            start_nanos: head.start_nanos,
            end_nanos: head.end_nanos,
            kind: Kind::Chunk {
                head,
                present_bytes,
            },
            messages: None,
            channels: None,
        });
        if is_cut {
            return Err(Trouble::Cut("a chunk"));
        }
        Ok(())
    }

    /// The next chunk behind `at`, by the index or by searching.
    fn next_chunk(&mut self, at: u64) -> io::Result<Option<u64>> {
        if let Some(summary) = self.summary {
            let offsets = summary.chunks.iter().map(|chunk| chunk.offset);
            return Ok(offsets.filter(|offset| *offset > at).min());
        }
        const BLOCK_BYTES: u64 = 1 << 20;
        let overlap = HEAD_BYTES + ChunkHead::MOST_BYTES as u64;
        let mut begin = at + 1;
        let mut block = Vec::new();
        while begin < self.source.bytes {
            block.clear();
            self.source.read(begin, BLOCK_BYTES + overlap, &mut block)?;
            let places = block.iter().take(BLOCK_BYTES as usize).enumerate();
            for (place, _) in places.filter(|(_, byte)| **byte == op::CHUNK) {
                let offset = begin + place as u64;
                if is_chunk(&block[place..], self.source.bytes - offset) {
                    return Ok(Some(offset));
                }
            }
            begin += BLOCK_BYTES;
        }
        Ok(None)
    }
}

/// Whether a whole chunk may begin here, of whose record `left` bytes are in the file.
fn is_chunk(bytes: &[u8], left: u64) -> bool {
    let Some(length) = bytes.get(1..9).and_then(|b| b.first_chunk::<8>()) else {
        return false;
    };
    let length = u64::from_le_bytes(*length);
    if length == 0 || length > left.saturating_sub(HEAD_BYTES) {
        return false;
    }
    let Some(head) = bytes.get(9..).and_then(ChunkHead::read) else {
        return false;
    };
    let is_known = ["", "zstd", "lz4"].contains(&head.compression.as_str());
    let agrees = head.head_bytes.checked_add(head.compressed_bytes) == Some(length);
    is_known && agrees && head.start_nanos <= head.end_nanos
}

/// Adds to the chunks what a checked summary says about them, and notes those it has and the walk
/// did not find.
fn check_against(found: &mut Found, summary: &Summary) {
    let places = found.segments.iter().enumerate();
    let places: BTreeMap<u64, usize> = places.map(|(place, s)| (s.offset, place)).collect();
    for index in &summary.chunks {
        match places.get(&index.offset) {
            Some(place) => {
                let segment = &mut found.segments[*place];
                segment.channels = Some(index.channels.clone());
                (segment.start_nanos, segment.end_nanos) = (index.start_nanos, index.end_nanos);
            }
            None => found.losses.push(Loss {
                offset: index.offset,
                message: format!("a chunk of {} bytes cannot be found", index.bytes),
                span_nanos: Some((clamped(index.start_nanos), clamped(index.end_nanos))),
                messages: None,
            }),
        }
    }
}

pub(super) fn clamped(nanos: u64) -> i64 {
    i64::try_from(nanos).unwrap_or(i64::MAX)
}
