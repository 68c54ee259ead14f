//! What diagnosing, exploring and calibrating left beside a study's results. It is taken into a result if it was made of
//! the files that the study has now.

use crate::technique::asset;
use diagnostic::Problem;
use evidence::{Asset, CalibrationReport, DisagreementMap, Exploration};
use host::store::hash_of;
use serde::de::DeserializeOwned;
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
    let found: Option<Exploration> = read(&path, REMEDY)?;
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
    let Some(report) = read::<CalibrationReport>(&path, REMEDY)? else {
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
