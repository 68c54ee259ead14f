//! What a chunk holds, decompressed and checked.

use std::io::Read;

use super::record::ChunkHead;

/// Expected growth beyond which memory is only taken as it is filled.
const USUAL_GROWTH: u64 = 1000;

/// Decompresses chunks.
pub(super) struct Decompressor {
    zstd: Option<zstd::bulk::Decompressor<'static>>,
}

impl Decompressor {
    pub(super) fn new() -> Self {
        Decompressor { zstd: None }
    }

    /// Decompresses a whole chunk into `out` and checks its length and checksum. What was compressed
    /// is of no use afterwards.
    ///
    /// # Errors
    /// What is wrong, as a clause.
    pub(super) fn whole(
        &mut self,
        head: &ChunkHead,
        compressed: &mut Vec<u8>,
        limit_bytes: u64,
        out: &mut Vec<u8>,
    ) -> Result<(), String> {
        let claimed = head.uncompressed_bytes;
        if claimed > limit_bytes {
            out.clear();
            return Err(format!(
                "a chunk claims to hold {claimed} bytes, more than the {limit_bytes} allowed"
            ));
        }
        let usual = (compressed.len() as u64).saturating_mul(USUAL_GROWTH);
        match head.compression.as_str() {
            "" => std::mem::swap(compressed, out),
            "zstd" if claimed <= usual => self.zstd(compressed, claimed, out)?,
            "zstd" | "lz4" => {
                out.clear();
                let reader = reader(head, compressed)?;
                let read = reader.take(claimed + 1).read_to_end(out);
                read.map_err(|error| format!("a chunk cannot be decompressed ({error})"))?;
            }
            other => {
                out.clear();
                return Err(format!(
                    "a chunk is compressed by {other}, which is not known"
                ));
            }
        }
        if out.len() as u64 != claimed {
            return Err(format!(
                "a chunk claims to hold {claimed} bytes, but holds {}",
                out.len()
            ));
        }
        if head.crc != 0 && crc32fast::hash(out) != head.crc {
            return Err("the checksum of a chunk is wrong".to_owned());
        }
        Ok(())
    }

    fn zstd(&mut self, compressed: &[u8], claimed: u64, out: &mut Vec<u8>) -> Result<(), String> {
        let problem = |error| format!("a chunk cannot be decompressed ({error})");
        if self.zstd.is_none() {
            self.zstd = Some(zstd::bulk::Decompressor::new().map_err(problem)?);
        }
        if let Some(zstd) = &mut self.zstd {
            // Exactly the room that is claimed, or what is said of damage would depend on the chunk
            // that was there before. What is there already is overwritten, not filled with zeros.
            out.resize(usize::try_from(claimed).unwrap_or(0), 0);
            let found = zstd.decompress_to_buffer(compressed, &mut out[..]);
            out.truncate(found.map_err(problem)?);
        }
        Ok(())
    }
}

/// The beginning of a chunk whose end is missing: all that can be decompressed. Its checksum cannot
/// be checked.
pub(super) fn beginning(head: &ChunkHead, compressed: &[u8], limit_bytes: u64) -> Vec<u8> {
    let mut out = Vec::new();
    let limit = limit_bytes.min(head.uncompressed_bytes);
    if head.compression.is_empty() {
        let length = (compressed.len() as u64).min(limit) as usize;
        out.extend_from_slice(&compressed[..length]);
    } else if let Ok(reader) = reader(head, compressed) {
        // An error is the missing end; what was decompressed before it stays.
        let _ = reader.take(limit).read_to_end(&mut out);
    }
    out
}

fn reader<'c>(head: &ChunkHead, compressed: &'c [u8]) -> Result<Box<dyn Read + 'c>, String> {
    match head.compression.as_str() {
        "lz4" => Ok(Box::new(lz4_flex::frame::FrameDecoder::new(compressed))),
        "zstd" => match zstd::stream::read::Decoder::with_buffer(compressed) {
            Ok(reader) => Ok(Box::new(reader)),
            Err(error) => Err(format!("a chunk cannot be decompressed ({error})")),
        },
        other => Err(format!(
            "a chunk is compressed by {other}, which is not known"
        )),
    }
}
