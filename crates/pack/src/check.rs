//! A pack is checked, byte by byte.
//!
//! # Definition
//! The archive is read once, from its first byte to its last. Every byte has to be the one that [`crate::write()`] would have
//! written for the parts that stand there; every part has to be named by the manifest with the SHA-256 that it has, and every part
//! that is named has to be there; the envelope has to hold the manifest, and its signature has to be of the key that is given.
//!
//! Guarantee: if there are no faults and the signature is valid, the archive is, byte for byte, one that the owner of the key
//! has signed (as far as SHA-256 and Ed25519 hold). Without a signature or a key, changes by somebody who forms the archive
//! anew are not noticed, and [`Signature`] says so. Memory: the manifest, its envelope and the hashes, at most 64 MiB each; parts are
//! hashed as they go by.

use crate::envelope;
use crate::key::PublicKey;
use crate::manifest::{Manifest, PREDICATE, STATEMENT};
use crate::part::Tally;
use crate::write::{sums, text};
use crate::zip::{Entry, LOCAL, LOCAL_BYTES, MOST_BYTES, MOST_ENTRIES, directory};
use crate::{ENVELOPE, FIRST, MANIFEST, SUMS, name};
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::io::Read;

/// The largest manifest that is read.
const MOST_KEPT: u64 = 64 << 20;
/// The longest name.
const LONGEST_NAME: usize = 4096;
/// How many faults are told.
const MOST_FAULTS: usize = 50;

/// Something in a pack that is not as it was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The part, or empty for the archive.
    pub part: String,
    /// What is wrong.
    pub what: String,
}

/// What is known of a pack's signature.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Signature {
    /// It has none: nothing says who made it.
    Absent,
    /// The archive could not be read up to where its signature would stand: whether it has one is not known.
    NotRead,
    /// It names the key with this identifier, and no key was given to verify it by.
    NotVerified {
        /// The SHA-256 of the public key in DER.
        key: String,
    },
    /// It is of the given key.
    Valid {
        /// The SHA-256 of the public key in DER.
        key: String,
    },
    /// It is not of the given key, or of another manifest; a fault says which.
    Invalid,
}

/// What the check of a pack found.
#[derive(Clone, Debug)]
pub struct Checked {
    /// What is not as it was written.
    pub faults: Vec<Fault>,
    /// Of the signature.
    pub signature: Signature,
    /// The manifest, if it can be read.
    pub manifest: Option<Manifest>,
    /// Parts that were read.
    pub parts: u64,
    /// Bytes that were read.
    pub bytes: u64,
    /// SHA-256 of the archive in hexadecimal, as far as it was read.
    pub sha256: String,
}

/// Whether a file that begins with these bytes can be a pack: its first part is [`FIRST`], in the form in which packs
/// have their parts. A look from the outside, for who would write over it; [`check()`] says whether it is one.
pub fn begins_as_pack(bytes: &[u8]) -> bool {
    let entry = Entry {
        name: FIRST.to_owned(),
        crc: 0,
        size: 0,
        offset: 0,
    };
    let header = entry.local_header();
    // Checksum and sizes are those of its page.
    let is_of_content = |at: usize| (14..26).contains(&at);
    bytes.len() >= header.len()
        && (header.iter().zip(bytes).enumerate()).all(|(at, (a, b))| a == b || is_of_content(at))
}

/// Checks a pack; its signature is verified by the key, if one is given.
pub fn check(archive: &mut dyn Read, key: Option<&PublicKey>) -> Checked {
    let mut reading = Reading::new(archive);
    if let Err(what) = reading.entries() {
        reading.fault("", what);
    }
    let mut checked = reading.checked();
    let manifest = reading.kept.get(MANIFEST).cloned();
    let Some(manifest) = manifest else {
        // What is no archive of ours has said so already.
        match reading.is_whole {
            true => reading.fault(MANIFEST, "it is missing"),
            false => checked.signature = Signature::NotRead,
        }
        checked.faults = reading.faults;
        return checked;
    };
    checked.manifest = reading.manifest(&manifest);
    checked.signature = reading.signature(&manifest, key);
    checked.faults = reading.faults;
    checked
}

/// An archive that is read from its beginning.
struct Reading<'r> {
    from: &'r mut dyn Read,
    at: u64,
    whole: Sha256,
    entries: Vec<Entry>,
    hashes: BTreeMap<String, String>,
    kept: BTreeMap<String, Vec<u8>>,
    faults: Vec<Fault>,
    /// Whether it was read up to its end.
    is_whole: bool,
}

impl<'r> Reading<'r> {
    fn new(from: &'r mut dyn Read) -> Self {
        Self {
            from,
            at: 0,
            whole: Sha256::new(),
            entries: Vec::new(),
            hashes: BTreeMap::new(),
            kept: BTreeMap::new(),
            faults: Vec::new(),
            is_whole: false,
        }
    }

    fn checked(&self) -> Checked {
        Checked {
            faults: Vec::new(),
            signature: Signature::Absent,
            manifest: None,
            parts: self.entries.len() as u64,
            bytes: self.at,
            sha256: crate::hex(&self.whole.clone().finalize()),
        }
    }

    fn fault(&mut self, part: &str, what: impl Into<String>) {
        if self.faults.len() < MOST_FAULTS {
            self.faults.push(Fault {
                part: part.to_owned(),
                what: plain(&what.into()),
            });
        }
    }

    /// Reads so many bytes, or as many as there are.
    fn take(&mut self, count: usize) -> Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        let mut limited = (&mut *self.from).take(count as u64);
        let read = limited.read_to_end(&mut bytes);
        read.map_err(|error| format!("byte {}: {error}", self.at))?;
        self.whole.update(&bytes);
        self.at += bytes.len() as u64;
        Ok(bytes)
    }

    /// All entries, and the directory behind them.
    fn entries(&mut self) -> Result<(), String> {
        loop {
            let begin = self.at;
            let mark = self.take(4)?;
            if mark == LOCAL {
                self.entry(begin)?;
            } else if self.entries.is_empty() {
                return Err(
                    "it is not an evidence pack: it does not begin with a part of a ZIP archive"
                        .into(),
                );
            } else {
                return self.directory(begin, mark);
            }
        }
    }

    fn entry(&mut self, begin: u64) -> Result<(), String> {
        let entry = self.header(begin)?;
        if (self.entries.last()).is_some_and(|last| last.name >= entry.name) {
            return Err(format!("byte {begin}: {} stands out of order", entry.name));
        }
        self.content(&entry)?;
        self.entries.push(entry);
        Ok(())
    }

    /// The entry whose local header begins here, if every byte of that is as a pack has it.
    fn header(&mut self, begin: u64) -> Result<Entry, String> {
        let mut header = Vec::from(LOCAL);
        header.extend(self.take(LOCAL_BYTES - LOCAL.len())?);
        if header.len() < LOCAL_BYTES {
            return Err(format!("byte {begin}: the archive ends within a part"));
        }
        let number = |at: usize| u32::from_le_bytes(std::array::from_fn(|i| header[at + i]));
        let (crc, size) = (number(14), number(18));
        let length = usize::from(u16::from_le_bytes([header[26], header[27]]));
        let name = self.take(length.min(LONGEST_NAME))?;
        header.extend(&name);
        let name = String::from_utf8(name).ok().filter(|it| name::is_safe(it));
        let name = name.ok_or(format!(
            "byte {begin}: the name of a part is not one that a pack has"
        ))?;
        let fits = begin + u64::from(size) <= MOST_BYTES && self.entries.len() < MOST_ENTRIES;
        let offset = u32::try_from(begin).ok().filter(|_| fits);
        let offset = offset.ok_or("it is larger than any pack")?;
        let entry = Entry {
            name,
            crc,
            size,
            offset,
        };
        match entry.local_header() == header {
            true => Ok(entry),
            false => Err(format!(
                "byte {begin}: the header of {} is not as a pack has it",
                entry.name
            )),
        }
    }

    /// The content of an entry goes by.
    fn content(&mut self, entry: &Entry) -> Result<(), String> {
        let is_kept = [MANIFEST, ENVELOPE, SUMS].contains(&entry.name.as_str());
        if is_kept && u64::from(entry.size) > MOST_KEPT {
            return Err(format!(
                "{} has more than {} MiB",
                entry.name,
                MOST_KEPT >> 20
            ));
        }
        let (mut tally, mut kept) = (Tally::default(), Vec::new());
        let mut left = entry.size as usize;
        while left > 0 {
            let bytes = self.take(left.min(1 << 16))?;
            if bytes.is_empty() {
                return Err(format!("the archive ends within {}", entry.name));
            }
            left -= bytes.len();
            tally.add(&bytes);
            if is_kept {
                kept.extend(bytes);
            }
        }
        let (sha256, crc) = tally.hashes();
        if crc != entry.crc {
            self.fault(&entry.name, "its checksum (CRC-32) does not hold");
        }
        self.hashes.insert(entry.name.clone(), sha256);
        if is_kept {
            self.kept.insert(entry.name.clone(), kept);
        }
        Ok(())
    }

    fn directory(&mut self, begin: u64, mark: Vec<u8>) -> Result<(), String> {
        let expected = directory(&self.entries, begin);
        let mut found = mark;
        found.extend(self.take(expected.len() - found.len() + 1)?);
        let same = found.iter().zip(&expected).take_while(|(a, b)| a == b);
        let same = same.count();
        if found != expected {
            let place = begin + same as u64;
            return Err(format!(
                "byte {place}: the archive's directory is not that of its parts"
            ));
        }
        self.is_whole = true;
        Ok(())
    }

    /// Holds the parts against the manifest.
    fn manifest(&mut self, bytes: &[u8]) -> Option<Manifest> {
        let manifest: Manifest = match serde_json::from_slice(bytes) {
            Ok(manifest) => manifest,
            Err(error) => {
                self.fault(MANIFEST, format!("it cannot be read: {error}"));
                return None;
            }
        };
        if manifest.statement_type != STATEMENT || manifest.predicate_type != PREDICATE {
            self.fault(
                MANIFEST,
                "it is not the statement of an evidence pack of version 1",
            );
        }
        if text(&manifest).is_ok_and(|it| it.as_bytes() != bytes) {
            self.fault(MANIFEST, "it is not in the form in which it was written");
        }
        let named = manifest.subject.iter().map(|it| &it.name);
        if !named.eq(manifest.predicate.parts.iter().map(|it| &it.name)) {
            self.fault(
                MANIFEST,
                "the parts that it names and those that it describes differ",
            );
        }
        self.parts(&manifest);
        if self
            .kept
            .get(SUMS)
            .is_some_and(|it| it != sums(&manifest.subject).as_bytes())
        {
            self.fault(SUMS, "its hashes are not those of the manifest");
        }
        Some(manifest)
    }

    fn parts(&mut self, manifest: &Manifest) {
        let mut found = std::mem::take(&mut self.hashes);
        for outside in [MANIFEST, ENVELOPE] {
            found.remove(outside);
        }
        for subject in &manifest.subject {
            match found.remove(&subject.name) {
                Some(hash) if hash == subject.digest.sha256 => {}
                Some(_) => self.fault(
                    &subject.name,
                    "it is not the file that the manifest names (SHA-256)",
                ),
                // What a damaged archive does not show is not said to be missing.
                None if !self.is_whole => {}
                None => self.fault(
                    &subject.name,
                    "the manifest names it, and it is not in the pack",
                ),
            }
        }
        for name in found.keys() {
            self.fault(name, "it is in the pack, and the manifest does not name it");
        }
    }

    fn signature(&mut self, manifest: &[u8], key: Option<&PublicKey>) -> Signature {
        let Some(envelope) = self.kept.get(ENVELOPE) else {
            // A fault says where reading ended.
            if !self.is_whole {
                return Signature::NotRead;
            }
            if key.is_some() {
                self.fault(
                    ENVELOPE,
                    "the pack has no signature, and a key was given to verify it by",
                );
                return Signature::Invalid;
            }
            return Signature::Absent;
        };
        let read = match envelope::Read::of(envelope, manifest) {
            Ok(read) => read,
            Err(what) => {
                self.fault(ENVELOPE, what);
                return Signature::Invalid;
            }
        };
        match key {
            None => Signature::NotVerified { key: read.keyid },
            Some(key) if read.is_of(key, manifest) => Signature::Valid { key: read.keyid },
            Some(key) => {
                let what = match read.keyid == key.id() {
                    true => "the signature is not of this manifest".to_owned(),
                    false => format!(
                        "it is signed by the key {}, not by {}",
                        read.keyid,
                        key.id()
                    ),
                };
                self.fault(ENVELOPE, what);
                Signature::Invalid
            }
        }
    }
}

/// A text that may quote the archive, without what would mean something to a terminal, and no longer than what is read.
fn plain(text: &str) -> String {
    let said: String = text.chars().take(MOST_SAID).collect();
    diagnostic::printable_line(&said).into_owned()
}

/// How many characters of a fault are told.
const MOST_SAID: usize = 500;
