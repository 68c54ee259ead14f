//! The results of a study's last run, as they lie in its folder of results.

use crate::corroboration::FORMAT;
use diagnostic::Problem;
use evidence::StudyResult;
use host::store::hash_of;
use std::path::{Path, PathBuf};

/// The file of the whole result.
pub const RESULT: &str = "study.json";
/// The file of the page that a face draws of it.
pub const REPORT: &str = "report.html";
/// The folder of results in which the assurance case lies.
pub const ASSURANCE: &str = "assurance";

/// Where a study's results are, unless they go elsewhere.
pub fn results_folder(study: &Path, out: Option<&Path>) -> PathBuf {
    out.map_or_else(|| study.join("results"), Path::to_owned)
}

/// The result of a study's last run, if it is of the files that the study has now: what is said of others would be
/// said of nothing.
pub fn read_current_result(study: &Path, folder: &Path) -> Result<StudyResult, Problem> {
    let result = read_result(study, folder)?;
    for piece in &result.evidence {
        for asset in &piece.assets {
            let path = study.join(&asset.path);
            let bytes = host::files::read_file(&path, u64::MAX - 1)?;
            if hash_of(&bytes) != asset.hash {
                let message = format!("{} has changed since {} was produced", asset.path, piece.id);
                return Err(Problem::new("stale-result", message)
                    .remedy(format!("run `corroborate run {}` again", study.display())));
            }
        }
    }
    Ok(result)
}

/// The result of a study's last run.
pub fn read_result(study: &Path, folder: &Path) -> Result<StudyResult, Problem> {
    let path = folder.join(RESULT);
    if !path.exists() {
        return Err(Problem::new(
            "not-run",
            format!("{} holds no result of a run", folder.display()),
        )
        .remedy(format!("run `corroborate run {}` first", study.display())));
    }
    read_result_file(&path)
}

/// A result in a file.
///
/// # Errors
/// `not-run` if there is no such file, `bad-result` if it is none.
pub(crate) fn read_result_file(path: &Path) -> Result<StudyResult, Problem> {
    if !path.exists() {
        let message = format!("{} does not exist", path.display());
        return Err(Problem::new("not-run", message).remedy(
            "name a study that has been run, its folder of results, or the file study.json in it",
        ));
    }
    // It is written by this program and may be of any size.
    let source = host::files::read_any_size(path)?;
    let result: StudyResult = serde_json::from_str(&source.text).map_err(|error| {
        Problem::new("bad-result", format!("{}: {error}", path.display()))
            .remedy("run the study again")
    })?;
    if result.format.split('.').next() != FORMAT.split('.').next() {
        return Err(Problem::new(
            "bad-result",
            format!(
                "{} has the form {}, not {FORMAT}",
                path.display(),
                result.format
            ),
        )
        .remedy("run the study again with this program"));
    }
    Ok(result)
}

/// A value as results are written: JSON for people, with a final newline.
pub fn json(value: &impl serde::Serialize) -> Result<String, Problem> {
    serde_json::to_string_pretty(value)
        .map(|text| text + "\n")
        .map_err(|error| Problem::new("cannot-write", format!("the result as JSON: {error}")))
}
