//! `corroborate report`: the report of a study that has been run.

use super::run::{results_folder, terminal_width, use_colour};
use super::{Done, json};
use crate::args::{Format, Report};
use corroborate::corroboration::{self, FORMAT};
use diagnostic::Problem;
use evidence::StudyResult;
use host::files::write_whole;
use std::path::Path;

/// Writes the report again.
pub fn report(arguments: &Report) -> Result<Done, Problem> {
    let folder = results_folder(&arguments.study, arguments.out.as_deref());
    let result = read_current_result(&arguments.study, &folder)?;
    let to = arguments
        .to
        .clone()
        .unwrap_or_else(|| folder.join("report.html"));
    write_whole(&to, report::html(&result).as_bytes())?;
    let output = match arguments.format {
        Format::Json => json(&result)?,
        Format::Text => format!(
            "{}\nReport: {}\n",
            report::text(&result, terminal_width(), use_colour()),
            to.display()
        ),
    };
    Ok(Done {
        output,
        outcome: corroboration::outcome(&result),
    })
}

/// The result of a study's last run, if it is of the files that the study has now: what is said of others would be
/// said of nothing.
pub fn read_current_result(study: &Path, folder: &Path) -> Result<StudyResult, Problem> {
    let result = read_result(study, folder)?;
    for piece in &result.evidence {
        for asset in &piece.assets {
            let path = study.join(&asset.path);
            let bytes =
                std::fs::read(&path).map_err(|error| Problem::cannot_read(&path, &error))?;
            if host::store::hash_of(&bytes) != asset.hash {
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
    let path = folder.join("study.json");
    if !path.exists() {
        return Err(Problem::new(
            "not-run",
            format!("{} holds no result of a run", folder.display()),
        )
        .remedy(format!("run `corroborate run {}` first", study.display())));
    }
    let source = host::files::read_source(&path)?;
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
