//! Evidence as in-toto statements (in-toto Attestation Framework, Statement v1).
//!
//! A statement names files by their SHA-256 and says something about them. What it says here is of
//! two types of our own, described in `schemas/`. A statement is not signed; whoever vouches for it
//! wraps it in a DSSE envelope with a key of theirs.

use evidence::{Conclusion, Evidence, StudyResult};
use schemars::JsonSchema;
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;

/// The type of a statement, as the framework fixes it.
const STATEMENT: &str = "https://in-toto.io/Statement/v1";
/// The type of what is said about a piece of evidence.
const EVIDENCE: &str = "urn:x-corroborate:predicate:evidence:1.0";
/// The type of what is said about a study.
const STUDY: &str = "urn:x-corroborate:predicate:study:1.0";

/// An in-toto statement.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Statement<P> {
    /// Always `https://in-toto.io/Statement/v1`.
    #[serde(rename = "_type")]
    pub statement_type: String,
    /// The files that it is about.
    pub subject: Vec<File>,
    /// The type of the predicate.
    #[serde(rename = "predicateType")]
    pub predicate_type: String,
    /// What is said about them.
    pub predicate: P,
}

/// A file, as in-toto describes a resource.
#[derive(Debug, Serialize, JsonSchema)]
pub struct File {
    /// Its path from the folder of the assurance case.
    pub name: String,
    /// Its hash in hexadecimal, by the name of the algorithm: `sha256`.
    pub digest: BTreeMap<String, String>,
}

/// What is said about a piece of evidence: how it was obtained, from which assets (named by their
/// BLAKE3 hashes), and what it shows.
#[derive(Debug, Serialize, JsonSchema)]
pub struct EvidencePredicate {
    /// The study's title.
    pub study: String,
    /// Level of all intervals.
    pub confidence: f64,
    /// The program and version that produced it.
    pub produced_by: String,
    /// The evidence, as in the file that the statement is about.
    pub evidence: Evidence,
}

/// What is said about a study: what it concludes.
#[derive(Debug, Serialize, JsonSchema)]
pub struct StudyPredicate {
    /// The study's title.
    pub study: String,
    /// Level of all intervals.
    pub confidence: f64,
    /// The program and version that produced it.
    pub produced_by: String,
    /// One for each requirement.
    pub conclusions: Vec<Conclusion>,
}

/// The statement about one piece of evidence in a file of this name and content.
pub fn about_evidence(
    result: &StudyResult,
    piece: &Evidence,
    (name, content): (&str, &str),
) -> Statement<EvidencePredicate> {
    Statement {
        statement_type: STATEMENT.into(),
        subject: vec![file(name, content)],
        predicate_type: EVIDENCE.into(),
        predicate: EvidencePredicate {
            study: result.title.clone(),
            confidence: result.confidence,
            produced_by: result.produced_by.clone(),
            evidence: piece.clone(),
        },
    }
}

/// The statement about a study's files.
pub fn about_study(result: &StudyResult, files: &[(String, String)]) -> Statement<StudyPredicate> {
    Statement {
        statement_type: STATEMENT.into(),
        subject: files
            .iter()
            .map(|(name, content)| file(name, content))
            .collect(),
        predicate_type: STUDY.into(),
        predicate: StudyPredicate {
            study: result.title.clone(),
            confidence: result.confidence,
            produced_by: result.produced_by.clone(),
            conclusions: result.conclusions.clone(),
        },
    }
}

fn file(name: &str, content: &str) -> File {
    let digest = Sha256::digest(content.as_bytes());
    let hex: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
    File {
        name: name.to_owned(),
        digest: BTreeMap::from([("sha256".to_owned(), hex)]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The digest of an empty file is the published test vector of FIPS 180-4.
    #[test]
    fn files_are_named_by_sha256() {
        let empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
        assert_eq!(file("x", "").digest["sha256"], empty);
    }
}
