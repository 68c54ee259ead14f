//! `corroborate run`: produce what is missing or stale, compare, conclude,
//! report.

mod prepare;
mod runner;

use super::{Done, Setting, json, use_threads};
use crate::args::{Format, Run};
use crate::corroboration::{self, Piece};
use crate::outcome::Outcome;
use crate::problem::Problem;
use crate::store::{Store, program_hash};
use crate::study::Study;
use evidence::StudyResult;
pub use prepare::assets;
use prepare::{Prepared, prepare, untils};
use runner::Runner;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Runs a study.
pub fn run(arguments: &Run, setting: &Setting) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
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
        setting.talk.say(&warning.warning_line());
    }
    let prepared = prepare(&study, setting)?;
    let untils = untils(&study)?;
    // Hashed before anything runs, so that an edit meanwhile is not taken for
    // what was run.
    let assets = study
        .ledger
        .iter()
        .zip(&prepared)
        .map(|(entry, prepared)| {
            let mut assets = assets(&study, entry)?;
            match prepared {
                Prepared::Judge(recordings) => assets.extend_from_slice(recordings.assets()),
                Prepared::Simulate(campaign) => assets.extend_from_slice(campaign.assets()),
                Prepared::Command(command) => assets.extend_from_slice(command.assets()),
                _ => {}
            }
            Ok((entry.id.as_str(), assets))
        })
        .collect::<Result<BTreeMap<_, _>, Problem>>()?;
    let folder = results_folder(&arguments.study, arguments.out.as_deref());
    let store = Store::open(&folder)?;
    let runner = Runner {
        study: &study,
        store: &store,
        setting,
        program: program_hash()?,
        assets,
        untils,
    };
    let mut pieces: Vec<Piece> = Vec::new();
    let mut skipped: Vec<(&str, Problem)> = Vec::new();
    for (entry, prepared) in study.ledger.iter().zip(&prepared) {
        if !arguments.only.is_empty() && !arguments.only.contains(&entry.id) {
            continue;
        }
        setting.go_on()?;
        match prepared {
            Prepared::CannotSimulate(problem) => skipped.push((&entry.id, problem.clone())),
            _ => pieces.push(runner.piece(entry, prepared, &pieces)?),
        }
    }
    if let Some((id, problem)) = skipped.into_iter().next() {
        setting.talk.say(&format!(
            "{id} could not be produced, so nothing is compared"
        ));
        return Err(problem);
    }
    if !arguments.only.is_empty() {
        return only_some(&pieces, arguments.format);
    }
    let inputs = runner.study_inputs(&pieces);
    let result = match runner.store.fresh::<StudyResult>(STUDY, &inputs) {
        Some(result) => {
            setting.talk.say("nothing has changed since the last run");
            result
        }
        None => {
            let result = corroboration::corroborate(&study, pieces)?;
            runner.store.keep(STUDY, &inputs, &result)?;
            result
        }
    };
    runner.write(&result, arguments.format)
}

/// The file that keeps the result of comparing, with the hash of what it was
/// compared from.
pub const STUDY: &str = "comparison.json";

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
