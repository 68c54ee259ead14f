//! The write-ahead log: pages that were committed but not yet copied into the database.
//!
//! A log is a header and frames; a frame is a page with its number, two salts and two running
//! checksums. A frame counts if it and all before it carry the salts of the header and the right
//! checksums, and if a commit follows. The last such frame of a page is the page.

use std::collections::HashMap;
use std::io;

use super::pager::{Blocks, be_u32};

const HEADER_BYTES: usize = 32;
const FRAME_HEADER_BYTES: usize = 24;

/// The committed frames of a log.
pub(crate) struct Wal {
    file: Blocks,
    header: [u8; HEADER_BYTES],
    page_bytes: usize,
    /// Where the content of a page begins. Only looked up, never iterated.
    frames: HashMap<u32, u64>,
    page_count: u32,
    highest_page: u32,
}

impl Wal {
    /// Reads the log; `None` if nothing in it was committed.
    pub(crate) fn read(mut file: Blocks) -> io::Result<Option<Self>> {
        let mut header = [0; HEADER_BYTES];
        if file.len() < HEADER_BYTES as u64 {
            return Ok(None);
        }
        file.read_at(0, &mut header)?;
        let is_big_endian = match be_u32(&header, 0) {
            0x377f_0682 => false,
            0x377f_0683 => true,
            _ => return Ok(None),
        };
        let page_bytes = be_u32(&header, 8) as usize;
        let size_is_valid = (512..=65_536).contains(&page_bytes) && page_bytes.is_power_of_two();
        let mut sums = Checksum {
            is_big_endian,
            sums: [0; 2],
        };
        sums.add(&header[..24]);
        if !size_is_valid || !sums.matches(&header[24..]) {
            return Ok(None);
        }
        let mut wal = Wal {
            file,
            header,
            page_bytes,
            frames: HashMap::new(),
            page_count: 0,
            highest_page: 0,
        };
        wal.read_frames(sums)?;
        Ok((wal.page_count > 0).then_some(wal))
    }

    fn read_frames(&mut self, mut sums: Checksum) -> io::Result<()> {
        let mut frame = vec![0; FRAME_HEADER_BYTES + self.page_bytes];
        let mut at = HEADER_BYTES as u64;
        let mut pending: Vec<(u32, u64)> = Vec::new();
        while at + frame.len() as u64 <= self.file.len() {
            self.file.read_at(at, &mut frame)?;
            let (head, page) = frame.split_at(FRAME_HEADER_BYTES);
            sums.add(&head[..8]);
            sums.add(page);
            if head[8..16] != self.header[16..24] || !sums.matches(&head[16..]) {
                break;
            }
            pending.push((be_u32(head, 0), at + FRAME_HEADER_BYTES as u64));
            let pages_after_commit = be_u32(head, 4);
            if pages_after_commit > 0 {
                self.page_count = pages_after_commit;
                let highest = pending.iter().map(|(page, _)| *page).max();
                self.highest_page = self.highest_page.max(highest.unwrap_or(0));
                self.frames.extend(pending.drain(..));
            }
            at += frame.len() as u64;
        }
        Ok(())
    }

    /// The size of a page.
    pub(crate) fn page_bytes(&self) -> usize {
        self.page_bytes
    }

    /// The pages of the database after the last commit.
    pub(crate) fn page_count(&self) -> u32 {
        self.page_count
    }

    /// The highest page that was committed here.
    pub(crate) fn highest_page(&self) -> u32 {
        self.highest_page
    }

    /// Whether `page` was committed here.
    pub(crate) fn contains(&self, page: u32) -> bool {
        self.frames.contains_key(&page)
    }

    /// Reads `page`, which must be contained.
    pub(crate) fn read_page(&mut self, page: u32, out: &mut Vec<u8>) -> io::Result<()> {
        let Some(&at) = self.frames.get(&page) else {
            return Err(io::Error::from(io::ErrorKind::NotFound));
        };
        out.resize(self.page_bytes, 0);
        self.file.read_at(at, out)
    }

    /// Whether the log was begun anew since it was read.
    pub(crate) fn has_changed(&mut self) -> bool {
        let mut now = [0; HEADER_BYTES];
        self.file.reread(0, &mut now).is_err() || now != self.header
    }
}

/// The two running sums over pairs of 32-bit words.
struct Checksum {
    is_big_endian: bool,
    sums: [u32; 2],
}

impl Checksum {
    fn add(&mut self, bytes: &[u8]) {
        for pair in bytes.as_chunks::<8>().0 {
            let [a, b, c, d, e, f, g, h] = *pair;
            let (first, second) = if self.is_big_endian {
                (
                    u32::from_be_bytes([a, b, c, d]),
                    u32::from_be_bytes([e, f, g, h]),
                )
            } else {
                (
                    u32::from_le_bytes([a, b, c, d]),
                    u32::from_le_bytes([e, f, g, h]),
                )
            };
            let [s0, s1] = &mut self.sums;
            *s0 = s0.wrapping_add(first).wrapping_add(*s1);
            *s1 = s1.wrapping_add(second).wrapping_add(*s0);
        }
    }

    /// Whether `stored` (8 bytes, big-endian in either kind of log) are the sums.
    fn matches(&self, stored: &[u8]) -> bool {
        [be_u32(stored, 0), be_u32(stored, 4)] == self.sums
    }
}
