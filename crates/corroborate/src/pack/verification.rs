//! A pack is verified: every byte of the archive, every part, the signature.
//!
//! What is checked, and what it guarantees, is defined in the crate `pack`. Without a signature, or without the key that verifies
//! it, nothing says who made the pack: that is not a fault, but not enough either.

use crate::verify::{Checked, Fault};
use ::pack::{NotShown, PublicKey, Signature, check};
use diagnostic::Problem;
use host::files::read_source;
use schemars::JsonSchema;
use serde::Serialize;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// What `verify --format json` prints of a pack.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct PackVerification {
    /// Version of this form.
    pub format: String,
    /// The archive.
    pub pack: PathBuf,
    /// Its SHA-256 in hexadecimal.
    pub sha256: String,
    /// The study's title; absent if the manifest cannot be read.
    pub study: Option<String>,
    /// What is known of the signature.
    pub signature: PackSignature,
    /// What is not as it was written.
    pub faults: Vec<Fault>,
    /// What holds.
    pub checked: Vec<Checked>,
    /// What was not checked, and why.
    pub not_checked: Vec<String>,
    /// What the pack says that it does not show.
    #[schemars(with = "Vec<std::collections::BTreeMap<String, String>>")]
    pub not_shown: Vec<NotShown>,
}

/// What is known of a pack's signature.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(tag = "is", rename_all = "kebab-case")]
pub enum PackSignature {
    /// There is none.
    Absent,
    /// The archive is damaged before the place of a signature: whether there is one is not known.
    NotRead,
    /// There is one, and no key was given to verify it by.
    NotVerified {
        /// The SHA-256 of the public key that it names.
        key: String,
    },
    /// It is of the given key.
    Valid {
        /// The SHA-256 of the public key.
        key: String,
    },
    /// It is not of the given key, or not of this manifest.
    Invalid,
}

/// Verifies a pack; its signature by the public key in a file, if one is named.
///
/// # Errors
/// `cannot-read`, `bad-key`. What does not hold of the pack is no error, but a fault in the report.
pub fn verify_pack(file: &Path, key: Option<&Path>) -> Result<PackVerification, Problem> {
    let key = key.map(|key| {
        let source = read_source(key)?;
        PublicKey::of_pem(&source.name, &source.text)
    });
    let key = key.transpose()?;
    let archive = std::fs::File::open(file).map_err(|error| Problem::cannot_read(file, &error))?;
    let found = check(
        &mut BufReader::with_capacity(1 << 16, archive),
        key.as_ref(),
    );
    let (faults, checked) = (faults(file, &found), holds(&found));
    let (signature, not_checked) = signature(found.signature);
    let predicate = found.manifest.map(|it| it.predicate);
    Ok(PackVerification {
        format: "1.0".into(),
        pack: file.to_owned(),
        sha256: found.sha256,
        study: predicate.as_ref().map(|it| it.study.clone()),
        signature,
        faults,
        checked,
        not_checked,
        not_shown: predicate.map(|it| it.not_shown).unwrap_or_default(),
    })
}

fn faults(file: &Path, found: &::pack::Checked) -> Vec<Fault> {
    let name = file.display();
    let faults = found.faults.iter().map(|fault| Fault {
        file: match fault.part.as_str() {
            "" => name.to_string(),
            part => format!("{name}: {part}"),
        },
        place: String::new(),
        fault: fault.what.clone(),
    });
    faults.collect()
}

/// What holds of a pack without a fault.
fn holds(found: &::pack::Checked) -> Vec<Checked> {
    let Some(manifest) = (found.manifest.as_ref()).filter(|_| found.faults.is_empty()) else {
        return Vec::new();
    };
    let holds = |count: u64, what: &str| Checked {
        count,
        what: what.to_owned(),
    };
    vec![
        holds(
            manifest.subject.len() as u64,
            "parts are as the manifest names them (SHA-256), and there are no others",
        ),
        holds(
            found.bytes,
            "bytes of the archive are those of its parts, and nothing stands between them",
        ),
    ]
}

fn signature(found: Signature) -> (PackSignature, Vec<String>) {
    let again =
        "the figures themselves: unpack it, and run `corroborate verify` on study/results in it, as far as its files are in it under \
         their own names"
            .to_owned();
    let (signature, what) = match found {
        Signature::Valid { key } => (PackSignature::Valid { key }, None),
        Signature::Invalid => (PackSignature::Invalid, None),
        Signature::Absent => (
            PackSignature::Absent,
            Some("who made it: the pack is not signed".to_owned()),
        ),
        Signature::NotRead => (
            PackSignature::NotRead,
            Some(
                "the signature: the archive is damaged, and could not be read as far as where its signature stands"
                    .to_owned(),
            ),
        ),
        Signature::NotVerified { key } => {
            let what = format!(
                "the signature: it names the key {key}; give the signer's public key with --key"
            );
            (PackSignature::NotVerified { key }, Some(what))
        }
    };
    (signature, what.into_iter().chain([again]).collect())
}
