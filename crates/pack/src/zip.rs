//! The container: a ZIP archive in one form alone, so that its bytes follow from its parts.
//!
//! # Definition
//! The entries stand in ascending order of their names, each a local header and its content, uncompressed; then the central
//! directory and its end, without comments, extra fields or times (all entries are of 1980-01-01 00:00). Every field has the
//! one value that this file gives it, which is also the one that Python's `zipfile` writes for the same names: so anybody can
//! form the archive again and compare. Source: PKWARE, APPNOTE.TXT 6.3.10, 4.3.
//!
//! A crate that writes ZIP was not taken: which version numbers, flags and attributes it writes changes between its releases, and
//! then the same study would no longer give the same archive, nor could [`crate::check()`] say that nothing stands between parts.
//!
//! Guarantee: two archives of the same parts are the same bytes; an archive that is read here has no byte that does not belong
//! to a part's name, its content, or the directory of these.

use crate::part::cannot_write;
use diagnostic::Problem;
use std::io::Write;

/// The bytes of the largest archive, beyond which Python's `zipfile` and others need extensions of the format.
pub const MOST_BYTES: u64 = 2_000_000_000;
/// The most entries, for the same reason.
pub(crate) const MOST_ENTRIES: usize = 65_000;

pub(crate) const LOCAL: [u8; 4] = *b"PK\x03\x04";
const CENTRAL: [u8; 4] = *b"PK\x01\x02";
const END: [u8; 4] = *b"PK\x05\x06";
/// What a reader needs to know: version 2.0.
const VERSION: u16 = 20;
/// Written on a system with the permissions of Unix.
const UNIX: u8 = 3;
/// A regular file that all may read.
const ATTRIBUTES: u32 = 0o100_644 << 16;
/// 1980-01-01, the first day of the format.
const DATE: u16 = (1 << 5) | 1;
/// Of a local header without its name.
pub(crate) const LOCAL_BYTES: usize = 30;

/// An entry.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub name: String,
    pub crc: u32,
    pub size: u32,
    /// Where its local header begins.
    pub offset: u32,
}

impl Entry {
    /// What stands before the content.
    pub fn local_header(&self) -> Vec<u8> {
        let mut bytes = Vec::from(LOCAL);
        bytes.extend(VERSION.to_le_bytes());
        self.common(&mut bytes);
        bytes.extend(self.name.as_bytes());
        bytes
    }

    /// Flags, method, time, checksum, sizes, and the lengths of name and extra fields.
    fn common(&self, bytes: &mut Vec<u8>) {
        for field in [0, 0, 0, DATE] {
            bytes.extend(u16::to_le_bytes(field));
        }
        for field in [self.crc, self.size, self.size] {
            bytes.extend(field.to_le_bytes());
        }
        bytes.extend((self.name.len() as u16).to_le_bytes());
        bytes.extend([0, 0]);
    }

    fn central_header(&self) -> Vec<u8> {
        let mut bytes = Vec::from(CENTRAL);
        bytes.extend([VERSION as u8, UNIX]);
        bytes.extend(VERSION.to_le_bytes());
        self.common(&mut bytes);
        // Comment, disk and internal attributes.
        bytes.extend([0; 6]);
        bytes.extend(ATTRIBUTES.to_le_bytes());
        bytes.extend(self.offset.to_le_bytes());
        bytes.extend(self.name.as_bytes());
        bytes
    }
}

/// The directory of these entries, which begins where they end, and its end.
pub(crate) fn directory(entries: &[Entry], begin: u64) -> Vec<u8> {
    let mut bytes: Vec<u8> = entries.iter().flat_map(Entry::central_header).collect();
    let (size, count) = (bytes.len() as u32, entries.len() as u16);
    bytes.extend(END);
    bytes.extend([0; 4]);
    bytes.extend(count.to_le_bytes());
    bytes.extend(count.to_le_bytes());
    bytes.extend(size.to_le_bytes());
    bytes.extend((begin as u32).to_le_bytes());
    bytes.extend([0, 0]);
    bytes
}

/// Writes an archive, entry by entry.
pub(crate) struct Writer<'w, W: Write> {
    out: &'w mut W,
    entries: Vec<Entry>,
    at: u64,
}

impl<'w, W: Write> Writer<'w, W> {
    pub fn new(out: &'w mut W) -> Self {
        Self {
            out,
            entries: Vec::new(),
            at: 0,
        }
    }

    /// Writes an entry, whose name follows all names before it.
    pub fn add(&mut self, name: &str, content: &crate::Content) -> Result<(), Problem> {
        let size = u32::try_from(content.size).ok();
        let end = self.at + content.size + (LOCAL_BYTES + name.len()) as u64;
        let size = size.filter(|_| end <= MOST_BYTES && self.entries.len() < MOST_ENTRIES);
        let Some(size) = size else {
            return Err(too_large());
        };
        let entry = Entry {
            name: name.to_owned(),
            crc: content.crc,
            size,
            offset: self.at as u32,
        };
        let header = entry.local_header();
        let written = self.out.write_all(&header);
        written.map_err(|error| cannot_write(&error))?;
        content.write_to(name, self.out)?;
        self.entries.push(entry);
        self.at = end;
        Ok(())
    }

    /// Writes the directory.
    pub fn finish(self) -> Result<(), Problem> {
        let directory = directory(&self.entries, self.at);
        let written = self.out.write_all(&directory);
        written.map_err(|error| cannot_write(&error))
    }
}

fn too_large() -> Problem {
    let message = format!(
        "the pack would be larger than {} GB or have more than {MOST_ENTRIES} parts",
        MOST_BYTES / 1_000_000_000
    );
    Problem::new("pack-too-large", message).remedy(
        "leave recordings out (without --with-recordings): the pack names them by their SHA-256",
    )
}
