//! `corroborate run`: produce what is missing or stale, compare, conclude,
//! report.

mod prepare;
mod runner;

use super::{Done, Host, json, use_threads};
use crate::args::{Format, Run};
use corroborate::corroboration::Piece;
use corroborate::outcome::Outcome;
use diagnostic::Problem;
use evidence::StudyResult;
use host::store::Store;
use prepare::{all_assets, prepare, untils};
use runner::Runner;
use std::path::{Path, PathBuf};
use study::{self, Study};

pub use prepare::{assets, counted_constants};
pub use runner::STUDY;

/// Runs a study.
pub fn run(arguments: &Run, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    Ok(carried_out(arguments, setting)?.0)
}

/// What a whole study amounts to; its results are where `run` leaves them.
pub fn result(study: &Path, setting: &Host) -> Result<StudyResult, Problem> {
    let arguments = Run {
        study: study.to_owned(),
        out: None,
        only: Vec::new(),
        threads: None,
        format: Format::Text,
    };
    match carried_out(&arguments, setting)? {
        (_, Some(result)) => Ok(result),
        (_, None) => Err(Problem::new("empty-ledger", "nothing was compared")),
    }
}

/// What is printed, and what was compared if all was asked for.
fn carried_out(arguments: &Run, setting: &Host) -> Result<(Done, Option<StudyResult>), Problem> {
    let study = loaded(arguments, setting)?;
    let prepared = prepare(&study, setting)?;
    let untils = untils(&study)?;
    // Hashed before anything runs, so that an edit meanwhile is not taken for
    // what was run.
    let assets = all_assets(&study, &prepared)?;
    let folder = results_folder(&arguments.study, arguments.out.as_deref());
    let store = Store::open(&folder)?;
    let runner = Runner {
        study: &study,
        store: &store,
        setting,
        program: setting.build.as_str().to_owned(),
        assets,
        untils,
    };
    let pieces = runner.pieces(&prepared, &arguments.only)?;
    if !arguments.only.is_empty() {
        return Ok((only_some(&pieces, arguments.format)?, None));
    }
    let result = runner.completed(runner.compared(pieces)?);
    if let Some(looks) = &result.synthesis.looks {
        study::looks::keep(&study.folder, looks)?;
    }
    let done = runner.write(&result, arguments.format)?;
    Ok((done, Some(result)))
}

/// The study, if it asks for evidence, and for all that `--only` names.
fn loaded(arguments: &Run, setting: &Host) -> Result<Study, Problem> {
    let study = Study::load(&arguments.study)?;
    if study.ledger.is_empty() {
        return Err(Problem::new(
            "empty-ledger",
            format!("{} asks for no evidence", study.ledger_source.name),
        )
        .remedy("add an [[evidence]] with `id`, `technique` and its assets"));
    }
    for id in &arguments.only {
        study.entry(id)?;
    }
    for warning in study.forms.warnings(&[]) {
        setting.events.say(&warning.warning_line());
    }
    Ok(study)
}

/// Where a study's results are.
pub fn results_folder(study: &Path, out: Option<&Path>) -> PathBuf {
    out.map_or_else(|| study.join("results"), Path::to_owned)
}

/// Columns of the terminal that shows the summary.
pub fn terminal_width() -> usize {
    let columns = std::env::var("COLUMNS").ok().and_then(|c| c.parse().ok());
    columns.unwrap_or(100).clamp(40, 160)
}

/// Whether the summary may use colour.
pub fn use_colour() -> bool {
    use std::io::IsTerminal;
    std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}

fn only_some(pieces: &[Piece], format: Format) -> Result<Done, Problem> {
    let output = match format {
        Format::Json => {
            let evidence: Vec<&evidence::Evidence> = pieces.iter().map(|p| &p.evidence).collect();
            json(&evidence)?
        }
        Format::Text => pieces
            .iter()
            .map(|p| format!("{}: {}\n", p.evidence.id, p.headline))
            .collect(),
    };
    Ok(Done {
        output,
        outcome: Outcome::Holds,
    })
}
