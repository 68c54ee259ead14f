//! The manifest: an in-toto statement (in-toto Attestation Framework, Statement v1) about the parts of a pack.

use crate::part::Role;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The type of a statement, as the framework fixes it.
pub(crate) const STATEMENT: &str = "https://in-toto.io/Statement/v1";
/// The type of what is said about a pack.
pub(crate) const PREDICATE: &str = "urn:x-corroborate:predicate:pack:1.0";

/// The manifest of a pack.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Always `https://in-toto.io/Statement/v1`.
    #[serde(rename = "_type")]
    pub statement_type: String,
    /// Every part but this manifest and its envelope, in the order of their names.
    pub subject: Vec<Subject>,
    /// Always `urn:x-corroborate:predicate:pack:1.0`.
    #[serde(rename = "predicateType")]
    pub predicate_type: String,
    /// What is said about them.
    pub predicate: Predicate,
}

/// A part, as in-toto describes a resource.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Subject {
    /// Its name in the pack.
    pub name: String,
    /// Its hash.
    pub digest: Digest,
}

/// A hash by its algorithm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Digest {
    /// SHA-256 in hexadecimal.
    pub sha256: String,
}

/// What is said about a pack.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Predicate {
    /// Version of this form.
    pub format: String,
    /// The study's title.
    pub study: String,
    /// SHA-256 of the study's whole result, in hexadecimal.
    pub result_sha256: String,
    /// The program and version that produced the result.
    pub produced_by: String,
    /// The program and version that made the pack.
    pub packed_by: String,
    /// Every part that is named above, in the same order, with what it is.
    pub parts: Vec<PartEntry>,
    /// Recordings on which the evidence rests; most are not in the pack.
    pub recordings: Vec<Recording>,
    /// What the pack does not show.
    pub not_shown: Vec<NotShown>,
}

/// What a part is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartEntry {
    /// Its name in the pack.
    pub name: String,
    /// What it is for.
    pub role: Role,
    /// The artefact of SACE to which it corresponds; absent if it corresponds to none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sace: Option<Sace>,
    /// Its size in bytes.
    pub bytes: u64,
    /// What it is, in one line.
    pub what: String,
}

/// An artefact of the stage "AS verification assurance" of SACE (Safety Assurance of autonomous systems in Complex Environments,
/// University of York), by the letters of the guidance.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
pub enum Sace {
    /// \[Q\]: safety requirements, an input of the stage.
    Q,
    /// \[RR\]: verification strategy.
    RR,
    /// \[SS\]: verification log.
    SS,
    /// \[TT\]: verification results.
    TT,
    /// \[VV\]: verification argument.
    VV,
}

impl Sace {
    /// All that a pack can have, in the order of the guidance.
    pub const ALL: [Self; 5] = [Self::Q, Self::RR, Self::SS, Self::TT, Self::VV];

    /// The artefact's letters and name in the guidance.
    pub fn words(self) -> &'static str {
        match self {
            Self::Q => "[Q] Safety requirements",
            Self::RR => "[RR] Verification strategy",
            Self::SS => "[SS] AS verification log",
            Self::TT => "[TT] Verification results",
            Self::VV => "[VV] AS verification argument",
        }
    }
}

/// A recording on which evidence rests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Recording {
    /// Its path, relative to the study's folder.
    pub path: String,
    /// Its size in bytes.
    pub bytes: u64,
    /// Its SHA-256 in hexadecimal.
    pub sha256: String,
    /// The part that holds it; absent if it is not in the pack.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
}

/// Something that the pack does not show.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NotShown {
    /// Of what: a requirement, a piece of evidence, the pack itself.
    pub of: String,
    /// In one or two sentences.
    pub words: String,
}
