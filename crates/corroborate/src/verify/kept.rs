//! The evidence that is kept, and whether it is what was kept.

use super::audit::Audit;
use super::{compare, sound};
use crate::corroboration::{self, Piece};
use crate::results::json;
use crate::run::evidence_file;
use crate::technique::campaign::Sampled;
use crate::technique::model_checking::Compiled;
use crate::technique::{Asked, Kept, Produced, Techniques, technique_of};
use diagnostic::Problem;
use evidence::{Asset, StudyResult};
use host::Host;
use host::store::{Stored, hash_of};
use serde::de::DeserializeOwned;
use std::path::Path;
use study::{Entry, Study};

/// The evidence of every entry of the ledger; `None` if some cannot be read.
pub fn pieces(
    study: &Study,
    results: &Path,
    claimed: &StudyResult,
    (others, host, (deep, sampled)): (&Techniques, &Host, (bool, Sampled)),
    audit: &mut Audit,
) -> Result<Option<Vec<Piece>>, Problem> {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut is_whole = true;
    for entry in &study.ledger {
        let path = results.join(evidence_file(&entry.id));
        let Some(stored) = read::<Stored<Produced>>(&path, audit) else {
            is_whole = false;
            continue;
        };
        as_kept(&path, &stored, audit)?;
        let kept = Kept {
            path: &path,
            produced: &stored.content,
            results,
            before: &pieces,
            deep,
            sampled,
        };
        let technique = technique_of(study, entry, others)?;
        if !(deep && technique.is_computed_again_when_deep()) {
            sound::check(study.about.confidence, &path, &stored.content, audit);
        }
        technique.verify(Asked { study, entry, host }, &kept, audit)?;
        let assets = assets(study, entry, claimed)?;
        let mut piece = corroboration::piece(study, entry, assets, stored.inputs, stored.content)?;
        piece.drifted = drifted(study, entry, &pieces)?;
        pieces.push(piece);
    }
    Ok(is_whole.then_some(pieces))
}

/// The value in a file; a fault where there is none.
pub fn read<T: DeserializeOwned>(path: &Path, audit: &mut Audit) -> Option<T> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) => {
            audit.fault(path, "", format!("it cannot be read: {error}"));
            return None;
        }
    };
    match serde_json::from_str(&text) {
        Ok(value) => Some(value),
        Err(error) => {
            let place = format!("line {}, column {}", error.line(), error.column());
            audit.fault(path, &place, format!("it is not what is kept: {error}"));
            None
        }
    }
}

/// A kept file has its digest, and is written as this program writes.
fn as_kept(path: &Path, stored: &Stored<Produced>, audit: &mut Audit) -> Result<(), Problem> {
    if stored.is_as_kept() {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        if compare::bytes(path, &json(stored)?, &text, audit) {
            audit.checked(1, "pieces of evidence have the hash they were kept with");
        }
    } else {
        audit.fault(path, "/digest", "the hash of the content does not hold");
    }
    Ok(())
}

/// The assets that are stated, whose hashes are checked elsewhere; those that the ledger names must
/// be among them.
fn assets(study: &Study, entry: &Entry, claimed: &StudyResult) -> Result<Vec<Asset>, Problem> {
    let named = crate::technique::assets(study, entry)?;
    let stated = claimed.evidence.iter().find(|piece| piece.id == entry.id);
    let stated = stated.map_or(&[][..], |piece| &piece.assets);
    let as_stated = |one: &Asset| {
        let same = stated.iter().find(|asset| asset.path == one.path);
        same.map_or_else(|| one.hash.clone(), |asset| asset.hash.clone())
    };
    let further = stated
        .iter()
        .filter(|asset| !named.iter().any(|one| one.path == asset.path));
    // As when it was run: the ledger's first.
    Ok(named
        .iter()
        .map(|one| Asset {
            hash: as_stated(one),
            ..one.clone()
        })
        .chain(further.cloned())
        .collect())
}

/// The hash of a file; `None` if it cannot be read.
pub fn hash_of_file(path: &Path) -> Option<String> {
    let bytes = host::files::read_file(path, u64::MAX - 1);
    bytes.ok().map(|bytes| hash_of(&bytes))
}

/// Constants that do not have the value of the counts they were set to.
fn drifted(study: &Study, entry: &Entry, before: &[Piece]) -> Result<Vec<evidence::Clue>, Problem> {
    let Some(model) = entry.work.model() else {
        return Ok(Vec::new());
    };
    let compiled = Compiled::new(study, model)?;
    Ok(corroboration::drift(
        entry,
        |name| compiled.constant(name),
        |id| before.iter().map(|p| &p.evidence).find(|e| e.id == id),
    ))
}
