//! Shows what is offered for a study, and makes what is accepted.

use super::apply::{Applied, Applier, append_to_ledger};
use super::command::fit;
use super::ledger_text::Names;
use super::proposal::{Change, Offered, Proposal};
use super::report::{Open, RefineReport};
use super::simulator::Recalibration;
use super::solver::Solver;
use super::suspects::offered;
use crate::calibrate::{CalibrateRequest, calibrate};
use crate::corroboration;
use crate::outcome::Outcome;
use crate::run::{RunRequest, run_with_page};
use diagnostic::Problem;
use evidence::{CalibrationReport, StudyResult};
use host::Host;
use host::files::write_whole;
use std::path::{Path, PathBuf};
use study::Study;

/// What is to be accepted of what is offered.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Accept {
    /// Nothing: it is only shown.
    #[default]
    Nothing,
    /// The proposals of these numbers.
    Numbers(Vec<usize>),
    /// All that needs no decision.
    All,
}

/// What [`refine()`] needs to know.
#[derive(Clone, Debug)]
pub struct RefineRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// Offer only what is for this suspect, by its rank.
    pub suspect: Option<u32>,
    /// What is accepted.
    pub accept: Accept,
    /// How often models that result are refined again, at least once.
    pub rounds: usize,
    /// Whether numbers of commands' files are searched for before they are offered: at most
    /// [`refinement::MOST_RUNS_OF_A_FIT`] times an entry's episodes for each number.
    pub fit: bool,
    /// Episodes of a simulation that is fitted again; as many as before if `None`.
    pub episodes: Option<u64>,
    /// A new or empty folder in which a copy of the study is made and worked on, instead of in the study.
    pub to: Option<PathBuf>,
    /// Where the study's results are; in its folder `results` if `None`. A copy has its own there.
    pub out: Option<PathBuf>,
}

impl RefineRequest {
    /// What is offered for all suspects of a study, and nothing accepted.
    pub fn new(study: impl Into<PathBuf>) -> Self {
        Self {
            study: study.into(),
            suspect: None,
            accept: Accept::Nothing,
            rounds: 1,
            fit: false,
            episodes: None,
            to: None,
            out: None,
        }
    }
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct Refined {
    /// What is offered, what was made, and what is open then.
    pub report: RefineReport,
    /// The fits of parameters that were made for it.
    pub calibrations: Vec<CalibrationReport>,
    /// How the study stands after it. Where nothing was accepted `Violated` if something is offered, `Inconclusive` if not and
    /// there are open suspects, otherwise `Holds`.
    pub outcome: Outcome,
}

/// Runs a study as far as it is stale, shows what is offered against its suspects and makes what is accepted; then runs what
/// is new. `draw` draws the report's page, as for [`run_with_page`].
///
/// # Errors
/// Those of [`run()`](crate::run()), `unknown-proposal` for a suspect or a number that there is not, `folder-not-empty` for a
/// copy that would hide something, and whatever keeps an accepted proposal from being made.
pub fn refine(
    request: &RefineRequest,
    host: &Host,
    draw: &dyn Fn(&StudyResult) -> String,
) -> Result<Refined, Problem> {
    let folder = folder(request, host)?;
    let run = RunRequest {
        out: request.out.clone().filter(|_| request.to.is_none()),
        ..RunRequest::new(&folder)
    };
    let result = || run_with_page(&run, host, draw)?.into_study();
    let before = result()?;
    let study = Study::load_for(&folder, &host.trust)?;
    let solver = Solver::new(&study, &host.cancel);
    let mut offered = offered(&study, &before, &solver, host)?;
    // What was interrupted is no answer: a number that was not solved for would be said to have no value.
    host.go_on()?;
    let is_wanted = |it: &Proposal| request.suspect.is_none() || it.suspect == request.suspect;
    if let Some(suspect) = request.suspect {
        known_suspect(&before, suspect)?;
    }
    if request.fit {
        offered.fit(&study, &before, &is_wanted, host)?;
    }
    // What names other proposals by their numbers comes when these stay.
    offered.finish(&before);
    offered.proposals.retain(is_wanted);
    let accepted = accepted(&request.accept, &offered.proposals)?;
    let applier = Applier {
        study: &study,
        result: &before,
        solver: &solver,
        rounds: request.rounds,
    };
    let mut applied = applier.apply(&accepted)?;
    let mut calibrations = Vec::new();
    for proposal in &accepted {
        if let Change::Recalibrate(wanted) = &proposal.change {
            let (made, calibration) = recalibrate(&study, wanted, request.episodes, host)?;
            applied.push(made);
            calibrations.push(calibration);
        }
    }
    for proposal in &accepted {
        if let Change::FitCommand(wanted) = &proposal.change {
            applied.push(fit(&study, &before, wanted, host)?);
        }
    }
    let after = (!applied.is_empty()).then(result).transpose()?;
    Ok(refined(
        &before,
        after.as_ref(),
        offered,
        applied,
        calibrations,
    ))
}

fn refined(
    before: &StudyResult,
    after: Option<&StudyResult>,
    offered: Offered,
    applied: Vec<Applied>,
    calibrations: Vec<CalibrationReport>,
) -> Refined {
    let report = RefineReport {
        open: Open::all(before, &offered.proposals),
        open_after: after.map(|result| Open::all(result, &[])),
        proposals: offered.proposals,
        refused: offered.refused,
        applied,
    };
    Refined {
        outcome: match after {
            Some(result) => corroboration::outcome(result),
            None if !report.proposals.iter().all(Proposal::is_idle) => Outcome::Violated,
            // Somebody is suspected, and nothing would mend it.
            None if !report.open.is_empty() => Outcome::Inconclusive,
            // What fixes no disagreement is worth a look, and no reason to say that something is wrong.
            None => Outcome::Holds,
        },
        report,
        calibrations,
    }
}

fn known_suspect(result: &StudyResult, suspect: u32) -> Result<(), Problem> {
    let suspects = result.suspected();
    if suspects.iter().any(|known| known.rank == suspect) {
        return Ok(());
    }
    let known: Vec<String> = suspects.iter().map(|it| it.rank.to_string()).collect();
    let remedy = match known.is_empty() {
        true => "the study has no suspects".to_owned(),
        false => format!("suspects are {}", known.join(", ")),
    };
    Err(Problem::new("unknown-proposal", format!("there is no suspect {suspect}")).remedy(remedy))
}

fn accepted<'p>(accept: &Accept, proposals: &'p [Proposal]) -> Result<Vec<&'p Proposal>, Problem> {
    let numbers = match accept {
        Accept::Nothing => return Ok(Vec::new()),
        Accept::All => return Ok(proposals.iter().filter(|p| !p.needs_decision).collect()),
        Accept::Numbers(numbers) => numbers,
    };
    let of_number = |number: &usize| {
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
    };
    numbers.iter().map(of_number).collect()
}

/// Where to work: in the study, or in a copy of it.
fn folder(request: &RefineRequest, host: &Host) -> Result<PathBuf, Problem> {
    let Some(to) = &request.to else {
        return Ok(request.study.clone());
    };
    // A folder that is no study is said before anything is copied.
    Study::load_for(&request.study, &host.trust)?;
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
    copy(&request.study, &target, Path::new(""))?;
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
        } else if from.join(&inner).is_file() {
            std::fs::copy(from.join(&inner), to.join(&inner))
                .map_err(|error| Problem::cannot_write(&to.join(&inner), &error))?;
        }
    }
    Ok(())
}

fn recalibrate(
    study: &Study,
    recalibration: &Recalibration,
    episodes: Option<u64>,
    host: &Host,
) -> Result<(Applied, CalibrationReport), Problem> {
    let entry = study.entry(&recalibration.entry)?;
    let target = recalibration.target(study, entry);
    let file = study.folder.join(&recalibration.file);
    let report = calibrate(&CalibrateRequest::new(&study.folder, file), host)?;
    let to = study.folder.join(&target);
    write_whole(&to, report.parameter_set.as_bytes())?;
    let id = Names::next_id(study, &entry.id, &[]);
    let new = recalibration.new_entry(entry, id.clone(), &target, episodes);
    append_to_ledger(study, &new.text())?;
    let applied = Applied {
        entry: Some(id),
        file: target,
        what: new.changed,
    };
    Ok((applied, report))
}
