//! `corroborate refine`: patches of the assets from what disagrees, and what
//! they change.

use super::{Done, Host, json, run, use_threads};
use crate::args::{Format, Refine};
use crate::shown_calibration::as_text;
use corroborate::CalibrateRequest;
use corroborate::corroboration;
use corroborate::outcome::Outcome;
use corroborate::refine::apply::{Applied, Applier, append_to_ledger};
use corroborate::refine::command::fit;
use corroborate::refine::ledger_text::Names;
use corroborate::refine::proposal::{Change, Offered, Proposal};
use corroborate::refine::report::{Open, RefineReport};
use corroborate::refine::simulator::Recalibration;
use corroborate::refine::solver::Solver;
use corroborate::refine::suspects::offered;
use diagnostic::Problem;
use evidence::StudyResult;
use host::files::write_whole;
use std::path::{Path, PathBuf};
use study::Study;

/// Shows what is offered, and makes what is accepted.
pub fn refine(arguments: &Refine, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let folder = folder(arguments)?;
    let result = run::result(&folder, setting)?;
    let study = Study::load(&folder)?;
    let solver = Solver::new(&study, &setting.cancel);
    let mut offered = offered(&study, &result, &solver)?;
    if let Some(suspect) = arguments.suspect {
        known_suspect(&result, suspect)?;
        offered
            .proposals
            .retain(|proposal| proposal.suspect == Some(suspect));
    }
    let accepted = accepted(arguments, &offered.proposals)?;
    let applier = Applier {
        study: &study,
        result: &result,
        solver: &solver,
        rounds: usize::from(arguments.rounds),
    };
    let mut applied = applier.apply(&accepted)?;
    applied.extend(recalibrations(
        &study,
        &accepted,
        arguments.episodes,
        setting,
    )?);
    for proposal in &accepted {
        if let Change::FitCommand(wanted) = &proposal.change {
            applied.push(fit(&study, &result, wanted, setting)?);
        }
    }
    let is_changed = !applied.is_empty();
    let after = is_changed
        .then(|| run::result(&folder, setting))
        .transpose()?;
    done(arguments, &result, after.as_ref(), offered, applied)
}

fn done(
    arguments: &Refine,
    before: &StudyResult,
    after: Option<&StudyResult>,
    offered: Offered,
    applied: Vec<Applied>,
) -> Result<Done, Problem> {
    let report = RefineReport {
        open: Open::all(before, &offered.proposals),
        open_after: after.map(|result| Open::all(result, &[])),
        proposals: offered.proposals,
        refused: offered.refused,
        applied,
    };
    Ok(Done {
        outcome: match after {
            Some(result) => corroboration::outcome(result),
            None if report.proposals.is_empty() => Outcome::Holds,
            None => Outcome::Violated,
        },
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => report.text(),
        },
    })
}

fn known_suspect(result: &StudyResult, suspect: u32) -> Result<(), Problem> {
    let suspects = result.suspected();
    if suspects.iter().any(|known| known.rank == suspect) {
        return Ok(());
    }
    let count = suspects.len();
    Err(Problem::new(
        "unknown-proposal",
        format!("there is no suspect {suspect}: the study has {count}"),
    )
    .remedy("`corroborate refine STUDY` lists them with their ranks"))
}

fn accepted<'p>(
    arguments: &Refine,
    proposals: &'p [Proposal],
) -> Result<Vec<&'p Proposal>, Problem> {
    if arguments.all {
        return Ok(proposals.iter().filter(|p| !p.needs_decision).collect());
    }
    let wanted = arguments.accept.iter();
    wanted
        .map(|number| {
            let mut all = proposals.iter();
            all.find(|p| p.number == *number).ok_or_else(|| {
                let known: Vec<String> = proposals.iter().map(|p| p.number.to_string()).collect();
                Problem::new("unknown-proposal", format!("there is no proposal {number}")).remedy(
                    match known.is_empty() {
                        true => "nothing is offered here".to_owned(),
                        false => format!("offered are {}", known.join(", ")),
                    },
                )
            })
        })
        .collect()
}

/// Where to work: in the study, or in a copy of it.
fn folder(arguments: &Refine) -> Result<PathBuf, Problem> {
    let Some(to) = &arguments.to else {
        return Ok(arguments.study.clone());
    };
    // A folder that is no study is said before anything is copied.
    Study::load(&arguments.study)?;
    let is_used = std::fs::read_dir(to).is_ok_and(|mut entries| entries.next().is_some());
    if is_used {
        return Err(Problem::new(
            "folder-not-empty",
            format!("{} is not empty, so nothing was copied there", to.display()),
        )
        .remedy("name a new folder, or refine the copy itself"));
    }
    std::fs::create_dir_all(to).map_err(|error| Problem::cannot_write(to, &error))?;
    let target = to
        .canonicalize()
        .map_err(|error| Problem::cannot_read(to, &error))?;
    copy(&arguments.study, &target, Path::new(""))?;
    Ok(to.clone())
}

/// Copies a study with its results, without the episodes' recordings.
fn copy(from: &Path, to: &Path, below: &Path) -> Result<(), Problem> {
    let folder = from.join(below);
    let fail = |error: std::io::Error| Problem::cannot_read(&folder, &error);
    std::fs::create_dir_all(to.join(below))
        .map_err(|error| Problem::cannot_write(&to.join(below), &error))?;
    let mut entries: Vec<PathBuf> = std::fs::read_dir(&folder)
        .and_then(|entries| entries.map(|entry| Ok(entry?.file_name().into())).collect())
        .map_err(fail)?;
    entries.sort();
    for name in entries {
        let inner = below.join(&name);
        let is_left_out = ["results/episodes", "results/.lock"]
            .iter()
            .any(|it| inner == Path::new(it));
        // The copy itself may lie in the study.
        let is_copy = from
            .join(&inner)
            .canonicalize()
            .is_ok_and(|path| path == to);
        if is_left_out || is_copy {
            continue;
        }
        if from.join(&inner).is_dir() {
            copy(from, to, &inner)?;
        } else {
            std::fs::copy(from.join(&inner), to.join(&inner))
                .map_err(|error| Problem::cannot_write(&to.join(&inner), &error))?;
        }
    }
    Ok(())
}

fn recalibrations(
    study: &Study,
    accepted: &[&Proposal],
    episodes: Option<u64>,
    setting: &Host,
) -> Result<Vec<Applied>, Problem> {
    let wanted = accepted.iter().filter_map(|it| match &it.change {
        Change::Recalibrate(recalibration) => Some(recalibration),
        _ => None,
    });
    wanted
        .map(|recalibration| recalibrate(study, recalibration, episodes, setting))
        .collect()
}

fn recalibrate(
    study: &Study,
    recalibration: &Recalibration,
    episodes: Option<u64>,
    setting: &Host,
) -> Result<Applied, Problem> {
    let entry = study.entry(&recalibration.entry)?;
    let target = recalibration.target(study, entry);
    let file = study.folder.join(&recalibration.file);
    let report = corroborate::calibrate(&CalibrateRequest::new(&study.folder, file), setting)?;
    let to = study.folder.join(&target);
    write_whole(&to, report.parameter_set.as_bytes())?;
    setting.events.say(as_text(&report).trim_end());
    let id = Names::next_id(study, &entry.id, &[]);
    let new = recalibration.new_entry(entry, id.clone(), &target, episodes);
    append_to_ledger(study, &new.text())?;
    Ok(Applied {
        entry: Some(id),
        file: target,
        what: new.changed,
    })
}

#[cfg(test)]
mod tests {
    use super::RefineReport;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(RefineReport).into();
        crate::command::tests::assert_schema_is_committed("refine.schema.json", &schema);
    }
}
