//! What goes into a pack.

use crate::manifest::Sace;
use diagnostic::Problem;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::io::{Cursor, Read, Write};

/// What a part is for.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// A page about the pack itself.
    Guide,
    /// What was required.
    Requirements,
    /// Which requirement is shown by what.
    Traceability,
    /// How it was to be verified.
    Strategy,
    /// What was done, by which tool, on which files.
    Log,
    /// What came out.
    Results,
    /// A piece of evidence, or a statement about it.
    Evidence,
    /// Where the results come from.
    Provenance,
    /// The argument that the results support the requirements.
    Argument,
    /// A page for people.
    Report,
    /// Software of the system under test, as it was given.
    Sbom,
    /// A file of the study: model, table, parameters.
    Study,
    /// A recording, or the list of recordings.
    Recording,
}

impl Role {
    /// In words, as pages head them.
    pub fn words(self) -> &'static str {
        match self {
            Self::Guide => "Pages about the pack",
            Self::Requirements => "Requirements",
            Self::Traceability => "Traceability",
            Self::Strategy => "Strategy",
            Self::Log => "Log",
            Self::Results => "Results",
            Self::Evidence => "Evidence",
            Self::Provenance => "Provenance",
            Self::Argument => "Argument",
            Self::Report => "Report",
            Self::Sbom => "Software of the system under test",
            Self::Study => "Files of the study",
            Self::Recording => "Recordings",
        }
    }
}

/// A file of the pack.
pub struct Part {
    /// Its name in the pack, as [`crate::encoded`] makes it.
    pub name: String,
    /// What it is for.
    pub role: Role,
    /// The artefact of SACE to which it corresponds, if it does.
    pub sace: Option<Sace>,
    /// What it is, in one line.
    pub what: String,
    /// What it holds.
    pub content: Content,
}

impl Part {
    /// A part of no artefact of SACE.
    pub fn new(path: &str, role: Role, what: impl Into<String>, content: Content) -> Self {
        Self {
            name: crate::encoded(path),
            role,
            sace: None,
            what: what.into(),
            content,
        }
    }

    /// As an artefact of SACE.
    #[must_use]
    pub fn as_sace(mut self, artefact: Sace) -> Self {
        self.sace = Some(artefact);
        self
    }
}

/// Opens a content from its beginning.
pub type Open = Box<dyn Fn() -> Result<Box<dyn Read>, Problem>>;

/// What a part holds, with what is known of it.
pub struct Content {
    /// Bytes.
    pub size: u64,
    /// SHA-256 in hexadecimal.
    pub sha256: String,
    /// CRC-32, as ZIP has it.
    pub(crate) crc: u32,
    open: Open,
}

impl Content {
    /// A text.
    pub fn text(text: impl Into<String>) -> Self {
        Self::bytes(text.into().into_bytes())
    }

    /// Bytes in memory.
    pub fn bytes(bytes: Vec<u8>) -> Self {
        let bytes: std::sync::Arc<[u8]> = bytes.into();
        let mut known = Tally::default();
        known.add(&bytes);
        known.content(Box::new(move || Ok(Box::new(Cursor::new(bytes.clone())))))
    }

    /// What is too large for memory: it is read twice, now for its hashes and later into the pack.
    ///
    /// # Errors
    /// What `open` gives, and `cannot-read`.
    pub fn streamed(open: Open) -> Result<Self, Problem> {
        let mut known = Tally::default();
        copy(open()?.as_mut(), |bytes| {
            known.add(bytes);
            Ok(())
        })?;
        Ok(known.content(open))
    }

    /// Writes it, and holds it against what is known.
    pub(crate) fn write_to(&self, name: &str, out: &mut impl Write) -> Result<(), Problem> {
        let mut known = Tally::default();
        copy((self.open)()?.as_mut(), |bytes| {
            known.add(bytes);
            out.write_all(bytes).map_err(|error| cannot_write(&error))
        })?;
        let again = known.content(Box::new(|| Ok(Box::new(Cursor::new([])))));
        if (again.size, &again.sha256) == (self.size, &self.sha256) {
            return Ok(());
        }
        let message = format!("{name} was changed while it was packed");
        Err(Problem::new("changed-while-packed", message)
            .remedy("pack again when no program writes it"))
    }
}

/// What is known of bytes that went by.
#[derive(Default)]
pub(crate) struct Tally {
    size: u64,
    sha256: Sha256,
    crc: crc32fast::Hasher,
}

impl Tally {
    pub(crate) fn add(&mut self, bytes: &[u8]) {
        self.size += bytes.len() as u64;
        self.sha256.update(bytes);
        self.crc.update(bytes);
    }

    /// Their SHA-256 in hexadecimal, and their CRC-32.
    pub(crate) fn hashes(self) -> (String, u32) {
        (crate::hex(&self.sha256.finalize()), self.crc.finalize())
    }

    fn content(self, open: Open) -> Content {
        let size = self.size;
        let (sha256, crc) = self.hashes();
        Content {
            size,
            sha256,
            crc,
            open,
        }
    }
}

/// Hands over all that can be read.
fn copy(
    from: &mut dyn Read,
    mut to: impl FnMut(&[u8]) -> Result<(), Problem>,
) -> Result<(), Problem> {
    let mut buffer = vec![0; 1 << 16];
    loop {
        match from.read(&mut buffer) {
            Ok(0) => return Ok(()),
            Ok(count) => to(&buffer[..count])?,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) => {
                let message = format!("a part of the pack cannot be read: {error}");
                return Err(Problem::new("cannot-read", message));
            }
        }
    }
}

/// The archive could not be written.
pub(crate) fn cannot_write(error: &std::io::Error) -> Problem {
    Problem::new(
        "cannot-write",
        format!("the pack cannot be written: {error}"),
    )
    .remedy("check the free space and the permissions of the folder")
}
