//! The summary at the end of a finished file, believed only if its checksum is right.

use std::io::{self, Read, Seek};

use super::record::{
    ChannelRecord, ChunkIndex, Fields, HEAD_BYTES, MAGIC, SchemaRecord, Statistics, op,
    split_record,
};
use super::source::Source;

/// The content of a footer.
const FOOTER_BYTES: u64 = 20;

/// What the summary says.
#[derive(Default)]
pub(super) struct Summary {
    pub(super) schemas: Vec<SchemaRecord>,
    pub(super) channels: Vec<ChannelRecord>,
    pub(super) chunks: Vec<ChunkIndex>,
    pub(super) statistics: Option<Statistics>,
}

/// How a file ends.
pub(super) enum Ending {
    /// Without a footer: its writer did not finish it, or it was cut.
    Unfinished,
    /// With a footer, but without a summary.
    Finished,
    /// With a summary that has no checksum.
    Unguarded,
    /// With a summary whose checksum is right.
    Summarised(Summary),
    /// With a footer, and a summary that is damaged, at this offset.
    Damaged(u64, &'static str),
}

pub(super) fn read_ending<R: Read + Seek>(
    source: &mut Source<R>,
    limit_bytes: u64,
) -> io::Result<Ending> {
    let tail_bytes = HEAD_BYTES + FOOTER_BYTES + MAGIC.len() as u64;
    let Some(footer_at) = source.bytes.checked_sub(tail_bytes) else {
        return Ok(Ending::Unfinished);
    };
    let mut tail = Vec::new();
    source.read(footer_at, tail_bytes, &mut tail)?;
    let Some((op::FOOTER, content, rest)) = split_record(&tail) else {
        return Ok(Ending::Unfinished);
    };
    let mut fields = Fields(content);
    let (Some(start), Some(_), Some(crc), true) =
        (fields.u64(), fields.u64(), fields.u32(), rest == MAGIC)
    else {
        return Ok(Ending::Unfinished);
    };
    if start == 0 {
        return Ok(Ending::Finished);
    }
    if start > footer_at || footer_at - start > limit_bytes {
        let problem = "the footer's offset of the summary is wrong";
        return Ok(Ending::Damaged(footer_at, problem));
    }
    let mut bytes = Vec::new();
    // The checksum covers the summary and the footer up to the checksum itself.
    source.read(start, footer_at - start + HEAD_BYTES + 16, &mut bytes)?;
    if crc == 0 {
        return Ok(Ending::Unguarded);
    }
    if crc32fast::hash(&bytes) != crc {
        return Ok(Ending::Damaged(
            start,
            "the checksum of the summary is wrong",
        ));
    }
    let records = &bytes[..(footer_at - start) as usize];
    Ok(match read_summary(records) {
        Some(summary) => Ending::Summarised(summary),
        None => Ending::Damaged(start, "the summary is malformed"),
    })
}

fn read_summary(mut bytes: &[u8]) -> Option<Summary> {
    let mut summary = Summary::default();
    while !bytes.is_empty() {
        let (kind, content, rest) = split_record(bytes)?;
        bytes = rest;
        match kind {
            op::SCHEMA => summary.schemas.push(SchemaRecord::read(content)?),
            op::CHANNEL => summary.channels.push(ChannelRecord::read(content)?),
            op::CHUNK_INDEX => summary.chunks.push(ChunkIndex::read(content)?),
            op::STATISTICS => summary.statistics = Some(Statistics::read(content)?),
            _ => {}
        }
    }
    Some(summary)
}
