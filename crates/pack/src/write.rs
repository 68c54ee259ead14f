//! A pack is written: its parts, the hashes, the manifest and its signature.

use crate::envelope;
use crate::key::Key;
use crate::manifest::{
    Digest, Manifest, NotShown, PREDICATE, PartEntry, Predicate, Recording, STATEMENT, Subject,
};
use crate::part::{Content, Part, Role};
use crate::zip::Writer;
use crate::{ENVELOPE, GUIDE, MANIFEST, SUMS, guide};
use diagnostic::Problem;
use std::collections::BTreeSet;
use std::io::Write;

/// What is said about the pack as a whole.
#[derive(Clone, Debug, Default)]
pub struct About {
    /// The study's title.
    pub study: String,
    /// SHA-256 of the study's whole result, in hexadecimal.
    pub result_sha256: String,
    /// The program and version that produced the result.
    pub produced_by: String,
    /// The program and version that makes the pack.
    pub packed_by: String,
    /// Recordings on which the evidence rests.
    pub recordings: Vec<Recording>,
    /// What the pack does not show.
    pub not_shown: Vec<NotShown>,
}

impl About {
    /// Of a study with this title.
    pub fn new(study: impl Into<String>) -> Self {
        Self {
            study: study.into(),
            ..Self::default()
        }
    }
}

/// A pack that was written.
#[derive(Clone, Debug)]
pub struct Written {
    /// Its manifest.
    pub manifest: Manifest,
    /// The key that signed it; `None` if none did.
    pub signed_by: Option<String>,
}

/// Writes a pack of these parts, with a page on how it is verified, signed if there is a key.
///
/// # Errors
/// `cannot-write`, `cannot-read`, `changed-while-packed`, `pack-too-large`; `same-part` if two parts have one name.
pub fn write(
    mut parts: Vec<Part>,
    about: About,
    key: Option<&Key>,
    out: &mut impl Write,
) -> Result<Written, Problem> {
    let signer = key.map(|key| key.public().id());
    let page = guide::page(signer.as_deref());
    let what = "how this pack is verified with unzip, openssl and sha256sum";
    parts.push(Part::new(GUIDE, Role::Guide, what, Content::text(page)));
    parts.sort_by(|a, b| a.name.cmp(&b.name));
    let sums: String = parts.iter().map(sum).collect();
    let what = "the SHA-256 of every part, for sha256sum --check";
    parts.push(Part::new(SUMS, Role::Guide, what, Content::text(sums)));
    parts.sort_by(|a, b| a.name.cmp(&b.name));
    no_name_twice(&parts)?;
    let manifest = manifest(&parts, about);
    let text = text(&manifest)?;
    if let Some(key) = key {
        let content = Content::text(envelope::signed(text.as_bytes(), key));
        parts.push(Part::new(ENVELOPE, Role::Guide, "", content));
    }
    parts.push(Part::new(MANIFEST, Role::Guide, "", Content::text(text)));
    parts.sort_by(|a, b| a.name.cmp(&b.name));
    let mut archive = Writer::new(out);
    for part in &parts {
        archive.add(&part.name, &part.content)?;
    }
    archive.finish()?;
    Ok(Written {
        manifest,
        signed_by: signer,
    })
}

/// A line of the hashes.
fn sum(part: &Part) -> String {
    format!("{}  {}\n", part.content.sha256, part.name)
}

/// The hashes that stand beside these subjects.
pub(crate) fn sums(subjects: &[Subject]) -> String {
    let parts = subjects.iter().filter(|it| it.name != SUMS);
    parts
        .map(|it| format!("{}  {}\n", it.digest.sha256, it.name))
        .collect()
}

/// The manifest as it is written.
pub(crate) fn text(manifest: &Manifest) -> Result<String, Problem> {
    let text = serde_json::to_string_pretty(manifest);
    let text = text
        .map_err(|error| Problem::new("cannot-write", format!("the manifest as JSON: {error}")))?;
    Ok(text + "\n")
}

/// Files are told apart without their case on some machines.
fn no_name_twice(parts: &[Part]) -> Result<(), Problem> {
    let reserved = [MANIFEST, ENVELOPE].map(str::to_owned);
    let mut names: BTreeSet<String> = reserved.into();
    for part in parts {
        if !names.insert(part.name.to_lowercase()) {
            let message = format!("two parts would have the name {}", part.name);
            return Err(Problem::new("same-part", message).remedy(
                "rename one of the files: some file systems do not tell capital letters apart",
            ));
        }
    }
    Ok(())
}

fn manifest(parts: &[Part], about: About) -> Manifest {
    let subject = parts.iter().map(|part| Subject {
        name: part.name.clone(),
        digest: Digest {
            sha256: part.content.sha256.clone(),
        },
    });
    let entries = parts.iter().map(|part| PartEntry {
        name: part.name.clone(),
        role: part.role,
        sace: part.sace,
        bytes: part.content.size,
        what: part.what.clone(),
    });
    Manifest {
        statement_type: STATEMENT.into(),
        subject: subject.collect(),
        predicate_type: PREDICATE.into(),
        predicate: Predicate {
            format: "1.0".into(),
            study: about.study,
            result_sha256: about.result_sha256,
            produced_by: about.produced_by,
            packed_by: about.packed_by,
            parts: entries.collect(),
            recordings: about.recordings,
            not_shown: about.not_shown,
        },
    }
}
