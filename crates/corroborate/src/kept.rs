//! What diagnosing, exploring and calibrating left beside a study's results. It is taken into a result if it was made of
//! the files that the study has now.
//!
//! An exploration and a calibration are kept with a digest of what was written, so that what was changed by hand is not taken for
//! ours. A diagnosis has one of [`Stored`](host::store::Stored); a map of disagreement is derived again from its journal.

use crate::results::json;
use crate::technique::asset;
use diagnostic::Problem;
use evidence::{Asset, CalibrationReport, DisagreementMap, Exploration};
use host::store::hash_of;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::{Path, PathBuf};
use study::Study;

/// The file of a diagnosis.
pub const DIAGNOSIS: &str = "diagnosis.json";
/// The file of an exploration, in the folder of it.
pub const EXPLORATION: &str = "exploration.json";
/// The file of a map of disagreement, in the folder of an exploration.
pub const DISAGREEMENT: &str = "disagreement.json";
/// The file of a calibration, in the folder of it.
pub const CALIBRATION: &str = "calibration.json";

/// The folder of an exploration beside these results.
pub fn exploration_folder(results: &Path) -> PathBuf {
    results.join("exploration")
}

/// The file of a map of disagreement beside these results.
pub fn map_file(results: &Path) -> PathBuf {
    exploration_folder(results).join(DISAGREEMENT)
}

/// The exploration beside these results, if one was made.
///
/// # Errors
/// `stale-result` if it was made of other assets, `bad-result` if it cannot be read.
pub fn exploration(study: &Study, results: &Path) -> Result<Option<Exploration>, Problem> {
    const REMEDY: &str = "run corroborate explore again, or remove the file";
    let path = exploration_folder(results).join(EXPLORATION);
    let found: Option<Exploration> = read_sealed(&path, REMEDY)?;
    if let Some(found) = &found {
        of_these_assets(study, &path, &found.assets, REMEDY)?;
    }
    Ok(found)
}

/// The map of disagreement beside these results, if one was made.
///
/// # Errors
/// `stale-result` if it was made of other assets, `bad-result` if it cannot be read.
pub fn map(study: &Study, results: &Path) -> Result<Option<DisagreementMap>, Problem> {
    const REMEDY: &str = "run corroborate explore --disagreement again, or remove the file";
    let path = map_file(results);
    let map: Option<DisagreementMap> = read(&path, REMEDY)?;
    if let Some(map) = &map {
        of_these_assets(study, &path, &map.assets, REMEDY)?;
    }
    Ok(map)
}

/// The result of a calibration beside these results, if one was made.
///
/// # Errors
/// `stale-result` if it was made of other files, `bad-result` if it cannot be read.
pub fn calibration(study: &Study, results: &Path) -> Result<Option<CalibrationReport>, Problem> {
    const REMEDY: &str = "run corroborate calibrate again, or remove the file";
    let path = results.join("calibration").join(CALIBRATION);
    let Some(report) = read_sealed::<CalibrationReport>(&path, REMEDY)? else {
        return Ok(None);
    };
    let lineage = &report.lineage;
    for of in lineage.files.iter().chain([&lineage.calibration]) {
        let content = host::files::read_source(&study.folder.join(&of.file))?;
        if hash_of(content.text.as_bytes()) != of.hash {
            return Err(of_another(&path, &of.file, REMEDY));
        }
    }
    Ok(Some(report))
}

/// The key of the digest.
const DIGEST: &str = "digest";

/// A report as it is kept: as it is printed, with a digest before all else.
///
/// # Errors
/// `cannot-write` if it is no JSON.
pub fn sealed(report: &impl Serialize) -> Result<String, Problem> {
    let text = json(report)?;
    let failed = |why: &str| Problem::new("cannot-write", format!("the result as JSON: {why}"));
    let value: Value = serde_json::from_str(&text).map_err(|error| failed(&error.to_string()))?;
    let rest = text.strip_prefix('{').ok_or_else(|| failed("no object"))?;
    Ok(format!("{{\n  \"{DIGEST}\": \"{}\",{rest}", digest(&value)))
}

/// The digest of a content, however it is laid out.
fn digest(content: &Value) -> String {
    hash_of(content.to_string().as_bytes())
}

/// What a file that [`sealed`] has made holds, if it is there.
fn read_sealed<T: DeserializeOwned>(path: &Path, remedy: &str) -> Result<Option<T>, Problem> {
    let Some(found) = read::<serde_json::Map<String, Value>>(path, remedy)? else {
        return Ok(None);
    };
    let failed =
        |why: &str| Problem::new("bad-result", format!("{}: {why}", path.display())).remedy(remedy);
    let stated = found.get(DIGEST).cloned();
    // In the same order, whatever a map of JSON does when a key is taken out.
    let content = found.into_iter().filter(|(key, _)| key != DIGEST);
    let content = Value::Object(content.collect());
    match stated {
        None => {
            return Err(failed(
                "it has no digest, which shows that it is as it was written",
            ));
        }
        Some(stated) if stated != digest(&content) => {
            return Err(failed(
                "the hash of its content does not hold: it was changed since it was written",
            ));
        }
        Some(_) => {}
    }
    serde_json::from_value(content)
        .map(Some)
        .map_err(|error| failed(&error.to_string()))
}

/// What a file holds, if it is there.
fn read<T: DeserializeOwned>(path: &Path, remedy: &str) -> Result<Option<T>, Problem> {
    let Ok(bytes) = std::fs::read(path) else {
        return Ok(None);
    };
    let found = serde_json::from_slice(&bytes).map_err(|error| {
        Problem::new("bad-result", format!("{}: {error}", path.display())).remedy(remedy)
    })?;
    Ok(Some(found))
}

fn of_these_assets(
    study: &Study,
    path: &Path,
    assets: &[Asset],
    remedy: &str,
) -> Result<(), Problem> {
    for of in assets {
        if asset(&study.folder, of.role, Path::new(&of.path))? != *of {
            return Err(of_another(path, &of.path, remedy));
        }
    }
    Ok(())
}

fn of_another(path: &Path, file: &str, remedy: &str) -> Problem {
    let message = format!("{} is of another {file}", path.display());
    Problem::new("stale-result", message).remedy(remedy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Report {
        zeta: f64,
        alpha: Vec<u64>,
        none: Option<String>,
    }

    #[test]
    fn what_was_changed_since_it_was_written_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("exploration.json");
        let report = Report {
            zeta: 0.1 + 0.2,
            alpha: vec![1, u64::MAX],
            none: None,
        };
        let read = || read_sealed::<Report>(&path, "make it again");
        assert_eq!(read().expect("no file"), None);
        let text = sealed(&report).expect("JSON");
        // Laid out as it is printed, but for the digest.
        let (first, rest) = text[2..].split_once('\n').expect("lines");
        assert!(first.starts_with("  \"digest\": \""), "{text}");
        assert_eq!(format!("{{\n{rest}"), json(&report).expect("JSON"));
        std::fs::write(&path, &text).expect("written");
        assert_eq!(read().expect("as written"), Some(report));
        for (changed, said) in [
            (text.replace("0.30000000000000004", "0.3"), "does not hold"),
            (text.replace("null", "\"added\""), "does not hold"),
            (text.replacen(first, "", 1), "has no digest"),
            ("[]".to_owned(), "invalid type"),
        ] {
            assert_ne!(changed, text, "{said}");
            std::fs::write(&path, changed).expect("written");
            let problem = read().expect_err(said);
            assert_eq!(problem.code, "bad-result");
            assert!(problem.to_string().contains(said), "{problem}");
        }
        // Another layout is the same content.
        let value: Value = serde_json::from_str(&text).expect("JSON");
        std::fs::write(&path, value.to_string()).expect("written");
        assert!(read().expect("the same").is_some());
    }
}
