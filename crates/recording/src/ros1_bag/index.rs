//! Which connections and chunks a bag has: from the index at its end, or by walking through it.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read, Seek, SeekFrom};

use super::chunk::{self, Content};
use super::loss;
use super::record::{Connection, Header, op};
use crate::{IndexState, Loss};

/// The first bytes of a bag of any version.
pub(crate) const MAGIC_OF_ANY_VERSION: &[u8] = b"#ROSBAG V";

/// The first bytes of a bag.
const MAGIC: &[u8; 13] = b"#ROSBAG V2.0\n";

/// Headers are short, even with the definition of a large type; a longer one is not believed.
const MAX_HEADER_BYTES: u64 = 16 << 20;

/// A bag's file.
pub(crate) struct BagFile<R> {
    source: R,
    len: u64,
    max_chunk_bytes: u64,
}

/// A record in the file.
pub(crate) struct Record {
    header: Vec<u8>,
    /// Where its data begin.
    data_at: u64,
    /// How long the data are told to be.
    data_len: u64,
}

impl Record {
    fn header(&self) -> Option<Header<'_>> {
        Header::new(&self.header)
    }

    fn end(&self) -> u64 {
        self.data_at + self.data_len
    }
}

/// A chunk as the index describes it, or as the walk found it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ChunkInfo {
    /// Where its record begins.
    pub(crate) offset: u64,
    /// The earliest of its messages.
    pub(crate) start_nanos: i64,
    /// The latest of its messages.
    pub(crate) end_nanos: i64,
    /// How many messages it has of each connection.
    pub(crate) counts: BTreeMap<u32, u64>,
}

/// What a bag consists of.
#[derive(Debug, Default)]
pub(crate) struct Index {
    /// By their ids.
    pub(crate) connections: BTreeMap<u32, Connection>,
    pub(crate) chunks: Vec<ChunkInfo>,
    pub(crate) losses: Vec<Loss>,
    /// What the index in the file is worth.
    pub(crate) state: IndexState,
}

/// Why a bag cannot be read at all.
pub(crate) enum IndexError {
    Io(io::Error),
    /// What is wrong where.
    Format(u64, String),
}

impl From<io::Error> for IndexError {
    fn from(error: io::Error) -> Self {
        IndexError::Io(error)
    }
}

impl<R: Read + Seek> BagFile<R> {
    /// Chunks that claim more than `max_chunk_bytes` are not believed.
    pub(crate) fn new(mut source: R, max_chunk_bytes: u64) -> io::Result<Self> {
        let len = source.seek(SeekFrom::End(0))?;
        Ok(BagFile {
            source,
            len,
            max_chunk_bytes,
        })
    }

    /// Finds the connections and chunks of the bag.
    pub(crate) fn index(&mut self) -> Result<Index, IndexError> {
        let header = self.bag_header()?;
        let encryptor = header.header().and_then(|header| header.text("encryptor"));
        if encryptor.is_some_and(|name| !name.is_empty()) {
            let message = "the bag is encrypted; decrypt it first".to_owned();
            return Err(IndexError::Format(MAGIC.len() as u64, message));
        }
        let stated = header.header().and_then(|header| {
            Some((
                header.u64("index_pos")?,
                header.u32("conn_count")?,
                header.u32("chunk_count")?,
            ))
        });
        let mut state = IndexState::Missing;
        let problem = match stated {
            None => loss(MAGIC.len() as u64, "the header of the bag is incomplete"),
            Some((0, ..)) => loss(
                self.len,
                "the bag was not closed, so it may end before the recording did",
            ),
            Some((index_pos, ..)) if index_pos > self.len => loss(
                self.len,
                format!(
                    "the file ends after {} bytes, before the index at byte {index_pos}",
                    self.len
                ),
            ),
            Some((index_pos, connections, chunks)) => {
                match self.read_index(index_pos, connections, chunks)? {
                    Ok(index) => return Ok(index),
                    Err(problem) => {
                        state = IndexState::Damaged;
                        problem
                    }
                }
            }
        };
        let mut index = self.walk(header.end())?;
        index.state = state;
        index.losses.insert(0, problem);
        Ok(index)
    }

    fn bag_header(&mut self) -> Result<Record, IndexError> {
        let mut magic = Vec::new();
        self.source.seek(SeekFrom::Start(0))?;
        (&mut self.source)
            .take(MAGIC.len() as u64)
            .read_to_end(&mut magic)?;
        if magic != MAGIC {
            let message = "it does not begin as a ROS bag of version 2.0; convert older bags with \
                           \"rosbag fix\""
                .to_owned();
            return Err(IndexError::Format(0, message));
        }
        let at = MAGIC.len() as u64;
        match self.record(at)? {
            Some(record) if record.header().and_then(|h| h.op()) == Some(op::BAG_HEADER) => {
                Ok(record)
            }
            _ => Err(IndexError::Format(
                at,
                "the header of the bag is cut short or damaged".to_owned(),
            )),
        }
    }

    /// The record at `offset`, without its data; `None` if there is none.
    fn record(&mut self, offset: u64) -> io::Result<Option<Record>> {
        let Some(header_len) = self.length_at(offset)? else {
            return Ok(None);
        };
        let header_at = offset + 4;
        if header_len > MAX_HEADER_BYTES || header_at + header_len > self.len {
            return Ok(None);
        }
        let mut header = Vec::new();
        (&mut self.source)
            .take(header_len)
            .read_to_end(&mut header)?;
        let Some(data_len) = self.length_at(header_at + header_len)? else {
            return Ok(None);
        };
        let data_at = header_at + header_len + 4;
        let record = Record {
            header,
            data_at,
            data_len,
        };
        Ok(record.header().is_some().then_some(record))
    }

    fn length_at(&mut self, offset: u64) -> io::Result<Option<u64>> {
        if offset + 4 > self.len {
            return Ok(None);
        }
        let mut four = [0; 4];
        self.source.seek(SeekFrom::Start(offset))?;
        self.source.read_exact(&mut four)?;
        Ok(Some(u64::from(u32::from_le_bytes(four))))
    }

    /// The data of a record, as far as the file has them.
    fn data(&mut self, record: &Record, out: &mut Vec<u8>) -> io::Result<()> {
        out.clear();
        self.source.seek(SeekFrom::Start(record.data_at))?;
        (&mut self.source)
            .take(record.data_len)
            .read_to_end(out)
            .map(|_| ())
    }

    /// Uncompresses the chunk at `offset`.
    pub(crate) fn chunk(&mut self, offset: u64, scratch: &mut Vec<u8>) -> io::Result<Content> {
        let broken = |problem: &str| Content {
            problem: Some(problem.to_owned()),
            ..Content::default()
        };
        let Some(record) = self.record(offset)? else {
            return Ok(broken("its header is cut short or damaged"));
        };
        let described = record
            .header()
            .filter(|header| header.op() == Some(op::CHUNK));
        let described = described.and_then(|h| Some((h.text("compression")?, h.u32("size")?)));
        let Some((compression, size)) = described else {
            return Ok(broken("its header is that of something else"));
        };
        if u64::from(size) > self.max_chunk_bytes {
            return Ok(broken(&format!(
                "it claims to hold {size} bytes, more than is believed"
            )));
        }
        self.data(&record, scratch)?;
        let is_cut = (scratch.len() as u64) < record.data_len;
        Ok(chunk::content(&compression, scratch, size, is_cut))
    }

    /// How many messages of each connection the index records behind the chunk at `offset` tell.
    pub(crate) fn index_behind(&mut self, offset: u64) -> io::Result<BTreeMap<u32, u64>> {
        let mut counts = BTreeMap::new();
        let mut at = self.record(offset)?.map_or(self.len, |record| record.end());
        while let Some(record) = self.record(at)? {
            let Some(header) = record
                .header()
                .filter(|header| header.op() == Some(op::INDEX))
            else {
                break;
            };
            if let (Some(id), Some(count)) = (header.u32("conn"), header.u32("count")) {
                *counts.entry(id).or_default() += u64::from(count);
            }
            at = record.end();
        }
        Ok(counts)
    }

    /// Reads the index; the inner error says why it is not to be believed.
    fn read_index(
        &mut self,
        index_pos: u64,
        connections: u32,
        chunks: u32,
    ) -> io::Result<Result<Index, Loss>> {
        let mut index = Index::default();
        let (mut at, mut data) = (index_pos, Vec::new());
        while at < self.len {
            let understood = match self.record(at)? {
                Some(record) if record.end() <= self.len => {
                    self.data(&record, &mut data)?;
                    at = record.end();
                    record
                        .header()
                        .and_then(|header| index.note(&header, &data))
                }
                _ => None,
            };
            if understood.is_none() {
                return Ok(Err(loss(at, "the index at the end of the bag is damaged")));
            }
        }
        let offsets: BTreeSet<u64> = index.chunks.iter().map(|chunk| chunk.offset).collect();
        let is_whole = index.connections.len() == connections as usize
            && index.chunks.len() == chunks as usize
            && offsets.len() == index.chunks.len()
            && offsets.last().is_none_or(|last| *last < index_pos)
            && index.chunks.iter().all(|chunk| {
                chunk
                    .counts
                    .keys()
                    .all(|id| index.connections.contains_key(id))
            });
        if !is_whole {
            let message = format!(
                "the index at the end of the bag does not fit its header, which tells {connections} \
                 connections and {chunks} chunks"
            );
            return Ok(Err(loss(index_pos, message)));
        }
        index.chunks.sort_by_key(|chunk| chunk.offset);
        index.state = IndexState::Sound;
        Ok(Ok(index))
    }

    /// Walks through the records from `at` on and uncompresses each chunk, to learn what is in it.
    fn walk(&mut self, mut at: u64) -> io::Result<Index> {
        let mut index = Index::default();
        let mut scratch = Vec::new();
        while at < self.len {
            let record = self.record(at)?;
            let kind = record.as_ref().and_then(|record| record.header()?.op());
            let (Some(record), Some(kind)) = (record, kind) else {
                index
                    .losses
                    .push(loss(at, "what follows is not a record; it is lost"));
                break;
            };
            match kind {
                op::CHUNK => {
                    let content = self.chunk(at, &mut scratch)?;
                    index.add_chunk(at, content);
                }
                op::MESSAGE => {
                    let message = "a message outside of any chunk is left out";
                    index.losses.push(loss(at, message));
                }
                op::CONNECTION if record.end() <= self.len => {
                    self.data(&record, &mut scratch)?;
                    if let Some(header) = record.header() {
                        index.note(&header, &scratch);
                    }
                }
                op::INDEX | op::CHUNK_INFO | op::CONNECTION | op::BAG_HEADER => {}
                other => {
                    let message = format!("a record of the unknown kind {other} is left out");
                    index.losses.push(loss(at, message));
                }
            }
            at = record.end();
        }
        Ok(index)
    }
}

impl Index {
    /// Takes a record of the index into account; `None` if it does not belong there.
    fn note(&mut self, header: &Header<'_>, data: &[u8]) -> Option<()> {
        match header.op()? {
            op::CONNECTION => self.add_connection(Connection::of_record(header, data)?),
            op::CHUNK_INFO => {
                let mut chunk = ChunkInfo {
                    offset: header.u64("chunk_pos")?,
                    start_nanos: header.nanos("start_time")?,
                    end_nanos: header.nanos("end_time")?,
                    counts: BTreeMap::new(),
                };
                let (pairs, rest) = data.as_chunks::<8>();
                if header.u32("count")? as usize != pairs.len() || !rest.is_empty() {
                    return None;
                }
                for [a, b, c, d, e, f, g, h] in pairs {
                    let id = u32::from_le_bytes([*a, *b, *c, *d]);
                    let count = u64::from(u32::from_le_bytes([*e, *f, *g, *h]));
                    *chunk.counts.entry(id).or_default() += count;
                }
                self.chunks.push(chunk);
            }
            _ => return None,
        }
        Some(())
    }

    /// Bags repeat a connection in each chunk that it first appears in and in the index.
    fn add_connection(&mut self, connection: Connection) {
        self.connections.entry(connection.id).or_insert(connection);
    }

    fn add_chunk(&mut self, offset: u64, content: Content) {
        let mut chunk = ChunkInfo {
            offset,
            ..ChunkInfo::default()
        };
        chunk.start_nanos = content
            .messages
            .first()
            .map_or(i64::MAX, |entry| entry.nanos);
        chunk.end_nanos = content
            .messages
            .last()
            .map_or(i64::MIN, |entry| entry.nanos);
        for entry in &content.messages {
            *chunk.counts.entry(entry.connection).or_default() += 1;
        }
        for connection in content.connections {
            self.add_connection(connection);
        }
        self.chunks.push(chunk);
    }
}
