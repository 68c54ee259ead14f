//! Bytes of a file at any place, with few calls of the operating system.

use std::io::{self, Read, Seek, SeekFrom};

/// Read at once where reading goes on, and where it jumps.
const AHEAD_BYTES: usize = 256 * 1024;
const JUMP_BYTES: usize = 4 * 1024;

pub(super) struct Source<R> {
    inner: R,
    pub(super) bytes: u64,
    buffer: Vec<u8>,
    buffer_at: u64,
}

impl<R: Read + Seek> Source<R> {
    pub(super) fn new(mut inner: R) -> io::Result<Self> {
        let bytes = inner.seek(SeekFrom::End(0))?;
        Ok(Source {
            inner,
            bytes,
            buffer: Vec::new(),
            buffer_at: 0,
        })
    }

    /// Up to `length` bytes at `at`, for small lengths; fewer only at the end of the file.
    pub(super) fn peek(&mut self, at: u64, length: usize) -> io::Result<&[u8]> {
        let end = self.buffer_at + self.buffer.len() as u64;
        if at < self.buffer_at || at + length as u64 > end {
            let goes_on = at >= self.buffer_at && at <= end;
            let wanted = if goes_on { AHEAD_BYTES } else { JUMP_BYTES }.max(length);
            let mut buffer = std::mem::take(&mut self.buffer);
            buffer.clear();
            self.read(at, wanted as u64, &mut buffer)?;
            (self.buffer, self.buffer_at) = (buffer, at);
        }
        let from = (at - self.buffer_at) as usize;
        let to = (from + length).min(self.buffer.len());
        Ok(&self.buffer[from.min(to)..to])
    }

    /// Appends up to `length` bytes at `at` to `out`; fewer only at the end of the file. Never takes
    /// more memory than the file has bytes.
    pub(super) fn read(&mut self, at: u64, length: u64, out: &mut Vec<u8>) -> io::Result<()> {
        let length = length.min(self.bytes.saturating_sub(at));
        self.inner.seek(SeekFrom::Start(at))?;
        out.reserve(usize::try_from(length).unwrap_or(0));
        self.inner.by_ref().take(length).read_to_end(out)?;
        Ok(())
    }

    /// The checksum of the first `length` bytes.
    pub(super) fn crc(&mut self, length: u64) -> io::Result<u32> {
        let mut hasher = crc32fast::Hasher::new();
        let mut at = 0;
        let mut block = Vec::new();
        while at < length {
            block.clear();
            self.read(at, (length - at).min(AHEAD_BYTES as u64), &mut block)?;
            if block.is_empty() {
                break;
            }
            hasher.update(&block);
            at += block.len() as u64;
        }
        Ok(hasher.finalize())
    }
}
