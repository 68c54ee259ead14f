//! The records of MCAP, read from bytes that nobody vouches for.
//!
//! Source: <https://mcap.dev/spec>. A record is a byte for its kind, its length in eight bytes, and
//! its content. Numbers are little-endian; texts and maps have their length in four bytes before.

use std::collections::BTreeMap;

pub(super) const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
/// Kind and length.
pub(super) const HEAD_BYTES: u64 = 9;

pub(super) mod op {
    pub(in crate::mcap) const HEADER: u8 = 0x01;
    pub(in crate::mcap) const FOOTER: u8 = 0x02;
    pub(in crate::mcap) const SCHEMA: u8 = 0x03;
    pub(in crate::mcap) const CHANNEL: u8 = 0x04;
    pub(in crate::mcap) const MESSAGE: u8 = 0x05;
    pub(in crate::mcap) const CHUNK: u8 = 0x06;
    pub(in crate::mcap) const MESSAGE_INDEX: u8 = 0x07;
    pub(in crate::mcap) const CHUNK_INDEX: u8 = 0x08;
    pub(in crate::mcap) const ATTACHMENT: u8 = 0x09;
    pub(in crate::mcap) const STATISTICS: u8 = 0x0b;
    pub(in crate::mcap) const METADATA: u8 = 0x0c;
    pub(in crate::mcap) const DATA_END: u8 = 0x0f;
}

/// Takes values from the front of bytes.
pub(super) struct Fields<'b>(pub(super) &'b [u8]);

impl<'b> Fields<'b> {
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*first)
    }

    pub(super) fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// Bytes after their length in four bytes.
    pub(super) fn bytes(&mut self) -> Option<&'b [u8]> {
        let length = self.u32()? as usize;
        let (bytes, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(bytes)
    }

    pub(super) fn text(&mut self) -> Option<String> {
        String::from_utf8(self.bytes()?.to_vec()).ok()
    }

    pub(super) fn texts(&mut self) -> Option<BTreeMap<String, String>> {
        let mut entries = Fields(self.bytes()?);
        let mut found = BTreeMap::new();
        while !entries.0.is_empty() {
            found.insert(entries.text()?, entries.text()?);
        }
        Some(found)
    }

    fn numbers(&mut self) -> Option<BTreeMap<u16, u64>> {
        let mut entries = Fields(self.bytes()?);
        let mut found = BTreeMap::new();
        while !entries.0.is_empty() {
            found.insert(entries.u16()?, entries.u64()?);
        }
        Some(found)
    }
}

/// Splits the first record off `bytes`: its kind, its content and what follows.
pub(super) fn split_record(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (kind, rest) = bytes.split_first()?;
    let (length, rest) = rest.split_first_chunk::<8>()?;
    let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
    let (content, rest) = rest.split_at_checked(length)?;
    Some((*kind, content, rest))
}

/// A schema record.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SchemaRecord {
    pub(super) id: u16,
    pub(super) name: String,
    pub(super) encoding: String,
    pub(super) data: Vec<u8>,
}

impl SchemaRecord {
    pub(super) fn read(content: &[u8]) -> Option<Self> {
        let mut fields = Fields(content);
        Some(SchemaRecord {
            id: fields.u16()?,
            name: fields.text()?,
            encoding: fields.text()?,
            data: fields.bytes()?.to_vec(),
        })
    }
}

/// A channel record.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ChannelRecord {
    pub(super) id: u16,
    pub(super) schema_id: u16,
    pub(super) topic: String,
    pub(super) message_encoding: String,
    metadata: BTreeMap<String, String>,
}

impl ChannelRecord {
    pub(super) fn read(content: &[u8]) -> Option<Self> {
        let mut fields = Fields(content);
        Some(ChannelRecord {
            id: fields.u16()?,
            schema_id: fields.u16()?,
            topic: fields.text()?,
            message_encoding: fields.text()?,
            metadata: fields.texts()?,
        })
    }
}

/// What stands before the data of a message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MessageHead {
    pub(super) channel: u16,
    pub(super) log_nanos: u64,
    pub(super) publish_nanos: u64,
}

impl MessageHead {
    pub(super) const BYTES: usize = 22;

    pub(super) fn read(content: &[u8]) -> Option<Self> {
        let mut fields = Fields(content);
        let channel = fields.u16()?;
        let _sequence = fields.u32()?;
        Some(MessageHead {
            channel,
            log_nanos: fields.u64()?,
            publish_nanos: fields.u64()?,
        })
    }
}

/// What stands before the compressed records of a chunk.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ChunkHead {
    pub(super) start_nanos: u64,
    pub(super) end_nanos: u64,
    pub(super) uncompressed_bytes: u64,
    pub(super) crc: u32,
    pub(super) compression: String,
    pub(super) compressed_bytes: u64,
    /// Length of what stands before the records.
    pub(super) head_bytes: u64,
}

impl ChunkHead {
    /// Enough bytes for any head with a known compression.
    pub(super) const MOST_BYTES: usize = 28 + 4 + 64 + 8;

    pub(super) fn read(content: &[u8]) -> Option<Self> {
        let mut fields = Fields(content);
        let (start_nanos, end_nanos) = (fields.u64()?, fields.u64()?);
        let (uncompressed_bytes, crc) = (fields.u64()?, fields.u32()?);
        let compression = fields.text()?;
        let compressed_bytes = fields.u64()?;
        Some(ChunkHead {
            start_nanos,
            end_nanos,
            uncompressed_bytes,
            crc,
            head_bytes: 28 + 4 + compression.len() as u64 + 8,
            compression,
            compressed_bytes,
        })
    }
}

/// What the summary says about a chunk.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ChunkIndex {
    pub(super) offset: u64,
    pub(super) bytes: u64,
    pub(super) start_nanos: u64,
    pub(super) end_nanos: u64,
    pub(super) channels: Vec<u16>,
}

impl ChunkIndex {
    pub(super) fn read(content: &[u8]) -> Option<Self> {
        let mut fields = Fields(content);
        Some(ChunkIndex {
            start_nanos: fields.u64()?,
            end_nanos: fields.u64()?,
            offset: fields.u64()?,
            bytes: fields.u64()?,
            channels: fields.numbers()?.into_keys().collect(),
        })
    }
}

/// How many messages each channel has, as the summary says.
pub(super) struct Statistics {
    pub(super) channels: u32,
    pub(super) messages: BTreeMap<u16, u64>,
}

impl Statistics {
    pub(super) fn read(content: &[u8]) -> Option<Self> {
        let mut fields = Fields(content);
        let (_messages, _schemas) = (fields.u64()?, fields.u16()?);
        let channels = fields.u32()?;
        let (_attachments, _metadata, _chunks) = (fields.u32()?, fields.u32()?, fields.u32()?);
        let (_start, _end) = (fields.u64()?, fields.u64()?);
        Some(Statistics {
            channels,
            messages: fields.numbers()?,
        })
    }
}
