//! ROS 1 bags, version 2.0.
//!
//! A bag is a sequence of records, each with a header of named fields. Messages and the connections
//! that they came by are in chunks, which may be compressed (bz2 or lz4); behind each chunk stand
//! index records; at the end stands an index of all connections and chunks, to which the header of
//! the bag points. A recorder that was killed leaves no index.
//!
//! Source: "Bag format version 2.0", ROS wiki (T. Field, J. Leibs, J. Bowman), and the serialisation
//! of messages of ROS 1. Own parser, since the published ones need the index or the whole file in
//! memory. Guarantee: where the index is damaged or absent, the bag is walked through record by
//! record, which finds every chunk in front of the first damaged record; a damaged chunk is left out
//! or cut where it breaks, and the others are read; each of these is a [`Loss`] with its place. The
//! format has no checksums but those of the compression, so a changed byte in an uncompressed chunk
//! may go unnoticed. Messages come in order of time as long as the chunks that overlap in time fit
//! into the memory that [`OpenOptions`] grants. Cost: each chunk is uncompressed once, or twice if
//! there is no index.

mod chunk;
mod index;
mod record;

pub(crate) use index::MAGIC_OF_ANY_VERSION;

use std::collections::BTreeMap;
use std::io::{Read, Seek};
use std::sync::Arc;

use crate::reader::{
    Encoding, Loss, OpenOptions, RawMessage, ReadError, ReadProblem, Reader, TopicId, TopicInfo,
};
use crate::schema::{Dialect, Schema, parse_msg};
use crate::storage::{IndexState, StoredFile};
use chunk::Content;
use index::{BagFile, ChunkInfo, Index, IndexError};
use record::Connection;

/// More chunks than this do not overlap in any bag that a recorder wrote.
const MAX_OPEN_CHUNKS: usize = 256;

/// A loss at `offset` of which no more is known.
pub(crate) fn loss(offset: u64, message: impl Into<String>) -> Loss {
    Loss {
        offset,
        message: message.into(),
        span_nanos: None,
        messages: None,
    }
}

/// A bag that is being read.
pub(crate) struct RosBagReader<R> {
    file: BagFile<R>,
    topics: Vec<TopicInfo>,
    /// The topic of each connection.
    topic_of: BTreeMap<u32, TopicId>,
    selected: Vec<bool>,
    /// In the order in which they are opened.
    chunks: Vec<ChunkInfo>,
    next_chunk: usize,
    open: Vec<OpenChunk>,
    open_bytes: u64,
    losses: Vec<Loss>,
    metadata: BTreeMap<String, String>,
    options: OpenOptions,
    in_time_order: bool,
    last_nanos: i64,
    scratch: Vec<u8>,
    has_ended: bool,
    index: IndexState,
    /// How many chunks were opened of each compression.
    compressions: BTreeMap<String, u64>,
}

/// A chunk some of whose messages are still to be given.
struct OpenChunk {
    offset: u64,
    content: Content,
    next: usize,
}

impl OpenChunk {
    fn next_nanos(&self) -> Option<i64> {
        Some(self.content.messages.get(self.next)?.nanos)
    }
}

impl<R: Read + Seek> RosBagReader<R> {
    /// Reads the index of the bag, or finds out what is in it.
    ///
    /// # Errors
    /// [`ReadError`] if it is no bag, or its header is damaged.
    pub(crate) fn new(source: R, options: &OpenOptions) -> Result<Self, ReadError> {
        let mut file = BagFile::new(source, options.record_bytes)?;
        let Index {
            connections,
            mut chunks,
            losses,
            state,
        } = file.index().map_err(read_error)?;
        let (topics, topic_of) = topics(&connections, &chunks);
        if options.time_order {
            chunks.sort_by_key(|chunk| (chunk.start_nanos, chunk.offset));
        }
        Ok(RosBagReader {
            file,
            selected: vec![true; topics.len()],
            topics,
            topic_of,
            chunks,
            next_chunk: 0,
            open: Vec::new(),
            open_bytes: 0,
            losses,
            metadata: BTreeMap::new(),
            in_time_order: options.time_order,
            options: options.clone(),
            last_nanos: i64::MIN,
            scratch: Vec::new(),
            has_ended: false,
            index: state,
            compressions: BTreeMap::new(),
        })
    }

    /// The place in `open` of the chunk with the next message, opening what must be open first.
    fn next_open(&mut self) -> Result<Option<usize>, ReadError> {
        loop {
            self.drop_finished();
            let earliest = (0..self.open.len())
                .filter_map(|place| Some((self.open[place].next_nanos()?, place)))
                .min();
            let Some(upcoming) = self.chunks.get(self.next_chunk) else {
                return Ok(earliest.map(|(_, place)| place));
            };
            let has_room =
                self.open.len() < MAX_OPEN_CHUNKS && self.open_bytes < self.options.memory_bytes;
            match earliest {
                Some((_, place)) if !self.options.time_order => return Ok(Some(place)),
                Some((nanos, place)) if nanos < upcoming.start_nanos => return Ok(Some(place)),
                Some((_, place)) if !has_room => return Ok(Some(place)),
                _ => self.open_next()?,
            }
        }
    }

    fn drop_finished(&mut self) {
        let bytes = &mut self.open_bytes;
        self.open.retain(|chunk| {
            let is_unfinished = chunk.next_nanos().is_some();
            if !is_unfinished {
                *bytes -= chunk.content.bytes.len() as u64;
            }
            is_unfinished
        });
    }

    /// Opens the next chunk, unless nothing in it is asked for.
    fn open_next(&mut self) -> Result<(), ReadError> {
        let info = self.chunks[self.next_chunk].clone();
        self.next_chunk += 1;
        let is_wanted = |id: &u32| {
            let topic = self.topic_of.get(id);
            topic.is_none_or(|topic| self.selected[topic.index()])
        };
        if !info.counts.keys().any(is_wanted) && self.file.index_behind(info.offset)? == info.counts
        {
            return Ok(());
        }
        let mut content = self.file.chunk(info.offset, &mut self.scratch)?;
        let compression = std::mem::take(&mut content.compression);
        *self.compressions.entry(compression).or_default() += 1;
        self.check(&info, &mut content);
        let (topic_of, selected) = (&self.topic_of, &self.selected);
        content.messages.retain(|entry| {
            let topic = topic_of.get(&entry.connection);
            topic.is_some_and(|topic| selected[topic.index()])
        });
        self.open_bytes += content.bytes.len() as u64;
        self.open.push(OpenChunk {
            offset: info.offset,
            content,
            next: 0,
        });
        Ok(())
    }

    /// Compares a chunk with what the index says of it.
    fn check(&mut self, info: &ChunkInfo, content: &mut Content) {
        let mut counts: BTreeMap<u32, u64> = BTreeMap::new();
        for entry in &content.messages {
            *counts.entry(entry.connection).or_default() += 1;
        }
        let (found, told): (u64, u64) = (counts.values().sum(), info.counts.values().sum());
        let problem = match content.problem.take() {
            Some(problem) => Some(problem),
            None if counts != info.counts => Some(format!(
                "it holds {found} messages on {} connections, but the index says {told} on {}",
                counts.len(),
                info.counts.len()
            )),
            None => None,
        };
        if let Some(problem) = problem {
            let lost = told.checked_sub(found).filter(|lost| *lost > 0);
            self.losses.push(Loss {
                offset: info.offset,
                message: format!("a chunk is damaged: {problem}"),
                span_nanos: (info.start_nanos <= info.end_nanos)
                    .then_some((info.start_nanos, info.end_nanos)),
                messages: lost,
            });
        }
        let unknown = counts
            .iter()
            .filter(|(id, _)| !self.topic_of.contains_key(id));
        let unknown: u64 = unknown.map(|(_, count)| count).sum();
        if unknown > 0 {
            self.losses.push(Loss {
                messages: Some(unknown),
                ..loss(
                    info.offset,
                    "a chunk holds messages of a connection that is not described",
                )
            });
        }
    }
}

impl<R: Read + Seek> Reader for RosBagReader<R> {
    fn topics(&self) -> &[TopicInfo] {
        &self.topics
    }

    fn next(&mut self) -> Result<Option<RawMessage<'_>>, ReadError> {
        if self.has_ended {
            return Ok(None);
        }
        let place = match self.next_open() {
            Ok(Some(place)) => place,
            Ok(None) => {
                self.has_ended = true;
                return Ok(None);
            }
            Err(error) => {
                self.has_ended = true;
                return Err(error);
            }
        };
        let chunk = &mut self.open[place];
        let entry = chunk.content.messages[chunk.next];
        chunk.next += 1;
        self.in_time_order &= entry.nanos >= self.last_nanos;
        self.last_nanos = entry.nanos;
        Ok(Some(RawMessage {
            topic: self.topic_of[&entry.connection],
            log_nanos: entry.nanos,
            publish_nanos: entry.nanos,
            data: &chunk.content.bytes[entry.start..entry.start + entry.len],
            offset: chunk.offset,
        }))
    }

    fn losses(&self) -> &[Loss] {
        &self.losses
    }

    fn end_nanos(&self) -> Option<i64> {
        self.chunks.iter().map(|chunk| chunk.end_nanos).max()
    }

    fn complete(&self) -> bool {
        self.losses.is_empty()
    }

    fn select(&mut self, wanted: &dyn Fn(&TopicInfo) -> bool) {
        self.selected = self.topics.iter().map(wanted).collect();
        let (topic_of, selected) = (&self.topic_of, &self.selected);
        for chunk in &mut self.open {
            let rest = chunk.content.messages.split_off(chunk.next);
            let is_wanted = |id: &u32| {
                topic_of
                    .get(id)
                    .is_some_and(|topic| selected[topic.index()])
            };
            let kept = rest
                .into_iter()
                .filter(|entry| is_wanted(&entry.connection));
            chunk.content.messages.extend(kept);
        }
    }

    fn metadata(&self) -> &BTreeMap<String, String> {
        &self.metadata
    }

    /// The format has no checksums.
    fn checked(&self) -> bool {
        false
    }

    fn storage(&self) -> Vec<StoredFile> {
        let opened = self.compressions.iter();
        let opened = opened.flat_map(|(name, count)| (0..*count).map(|_| name.as_str()));
        let mut file = StoredFile::of_chunks("ROS 1 bag", opened, self.index);
        file.chunks = Some(self.chunks.len() as u64);
        vec![file]
    }

    fn in_time_order(&self) -> bool {
        self.in_time_order
    }
}

/// The topics in the order of their first connections, and which topic a connection belongs to.
/// Connections of the same topic, type and definition are one: that of several publishers.
fn topics(
    connections: &BTreeMap<u32, Connection>,
    chunks: &[ChunkInfo],
) -> (Vec<TopicInfo>, BTreeMap<u32, TopicId>) {
    let mut counts: BTreeMap<u32, u64> = BTreeMap::new();
    for (id, count) in chunks.iter().flat_map(|chunk| &chunk.counts) {
        *counts.entry(*id).or_default() += count;
    }
    let mut topics: Vec<TopicInfo> = Vec::new();
    let mut topic_of = BTreeMap::new();
    let mut known: BTreeMap<(&str, &str, &str), TopicId> = BTreeMap::new();
    for (id, connection) in connections {
        let key = (
            &*connection.topic,
            &*connection.type_name,
            &*connection.definition,
        );
        let topic = *known.entry(key).or_insert_with(|| {
            let topic = TopicId(topics.len() as u32);
            topics.push(topic_info(topic, connection));
            topic
        });
        let count = counts.get(id).copied().unwrap_or(0);
        let total = &mut topics[topic.index()].message_count;
        *total = Some(total.unwrap_or(0) + count);
        topic_of.insert(*id, topic);
    }
    (topics, topic_of)
}

fn topic_info(id: TopicId, connection: &Connection) -> TopicInfo {
    let parsed = parse_msg(&connection.type_name, &connection.definition, Dialect::Ros1);
    let schema = match parsed {
        Ok(message_type) => Schema::Struct(message_type),
        Err(error) => Schema::Unknown {
            reason: error.to_string(),
        },
    };
    TopicInfo {
        id,
        name: connection.topic.clone(),
        type_name: connection.type_name.clone(),
        encoding: Encoding::Ros1,
        schema: Arc::new(schema),
        message_count: None,
    }
}

fn read_error(error: IndexError) -> ReadError {
    match error {
        IndexError::Io(error) => error.into(),
        IndexError::Format(offset, message) => ReadError {
            path: None,
            offset: Some(offset),
            problem: ReadProblem::Malformed(message),
        },
    }
}
