//! Running a study: what is missing or stale is produced, then everything is compared and concluded.

mod counted;
mod prepare;
mod ready;
mod runner;

pub(crate) use counted::counted_constants;
pub(crate) use prepare::{Opened, check_constants};
pub(crate) use ready::{COMPARISON, Ready, evidence_file};

use crate::corroboration::Piece;
use crate::results::results_folder;
use crate::technique::Techniques;
use diagnostic::{Problem, Problems};
use evidence::{Evidence, StudyResult};
use host::Host;
use host::store::Store;
use runner::Runner;
use serde::Serialize;
use std::path::PathBuf;
use study::Study;

/// A study to be run. [`RunRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct RunRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// Where results go; by default to the folder `results` of the study.
    pub out: Option<PathBuf>,
    /// Produces only the evidence with these identifiers, and compares nothing; all if there are none.
    pub only: Vec<String>,
    /// Techniques that are not built in; by default none.
    pub techniques: Techniques,
}

impl RunRequest {
    /// All of the study in this folder, with results in its folder `results`.
    pub fn new(study: impl Into<PathBuf>) -> Self {
        Self {
            study: study.into(),
            out: None,
            only: Vec::new(),
            techniques: Techniques::default(),
        }
    }

    /// With results in another folder.
    #[must_use]
    pub fn out(mut self, folder: impl Into<PathBuf>) -> Self {
        self.out = Some(folder.into());
        self
    }

    /// With a piece of evidence among those that are produced; nothing is compared then.
    #[must_use]
    pub fn only(mut self, id: impl Into<String>) -> Self {
        self.only.push(id.into());
        self
    }

    /// With techniques that are not built in.
    #[must_use]
    pub fn techniques(mut self, techniques: Techniques) -> Self {
        self.techniques = techniques;
        self
    }

    /// Where results go.
    pub fn results(&self) -> PathBuf {
        results_folder(&self.study, self.out.as_deref())
    }
}

/// What a run gave.
#[derive(Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RunReport {
    /// What the whole study amounts to.
    Study(Box<StudyResult>),
    /// The evidence that was asked for, in the order of the ledger.
    Only(Vec<EvidenceReport>),
}

/// One piece of evidence that was asked for.
#[derive(Debug, Serialize)]
pub struct EvidenceReport {
    /// The evidence.
    pub evidence: Evidence,
    /// Its main figure in words.
    pub headline: String,
}

impl RunReport {
    /// What the whole study amounts to.
    ///
    /// # Errors
    /// `empty-ledger` if only some of its evidence was asked for.
    pub fn into_study(self) -> Result<StudyResult, Problem> {
        match self {
            Self::Study(result) => Ok(*result),
            Self::Only(_) => Err(Problem::new(
                "empty-ledger",
                "only some evidence was asked for, so there is no comparison",
            )
            .remedy("run the study without `only`")),
        }
    }
}

impl From<Piece> for EvidenceReport {
    fn from(piece: Piece) -> Self {
        Self {
            evidence: piece.evidence,
            headline: piece.headline,
        }
    }
}

/// Runs a study: produces what is missing or stale, compares, concludes, and writes `study.json`.
///
/// What an earlier run kept of the same inputs is not produced again, and a run that was interrupted goes on where it
/// stopped. Progress goes to the host's events.
///
/// # Errors
/// What the study's files say wrong, each with its place; `interrupted` if the host was asked to stop;
/// `results-in-use` if another run writes to the same folder; `no-physics-library` if episodes cannot be simulated here
/// (all other evidence is produced and kept).
pub fn run(request: &RunRequest, host: &Host) -> Result<RunReport, Problem> {
    carried_out(request, host, None)
}

/// The same, with the page that `draw` makes of the result written beside it, while no other run may write there.
///
/// # Errors
/// Those of [`run()`].
pub fn run_with_page(
    request: &RunRequest,
    host: &Host,
    draw: &dyn Fn(&StudyResult) -> String,
) -> Result<RunReport, Problem> {
    carried_out(request, host, Some(draw))
}

/// Draws a page.
type Draw<'d> = &'d dyn Fn(&StudyResult) -> String;

fn carried_out(
    request: &RunRequest,
    host: &Host,
    draw: Option<Draw<'_>>,
) -> Result<RunReport, Problem> {
    let study = loaded(request, host)?;
    let runner = Runner {
        ready: Ready::new(&study, &request.techniques, host)?,
        store: Store::open(&request.results())?,
    };
    let pieces = runner.pieces(&request.only)?;
    if !request.only.is_empty() {
        let asked = pieces.into_iter().map(EvidenceReport::from);
        return Ok(RunReport::Only(asked.collect()));
    }
    let result = runner.completed(runner.compared(pieces)?);
    if let Some(looks) = &result.synthesis.looks {
        study::looks::keep(&study.folder, looks)?;
    }
    runner.write(&result, draw.map(|draw| draw(&result)))?;
    Ok(RunReport::Study(Box::new(result)))
}

/// The study, if it asks for evidence, and for all that is asked for of it.
///
/// # Errors
/// All mistakes of its files and of those that they name.
pub(crate) fn loaded(request: &RunRequest, host: &Host) -> Result<Study, Problem> {
    let mut found = Problems::new();
    let study = Study::read_for(&request.study, &host.trust, &mut found)?;
    if !found.is_empty() {
        prepare::look_further(&study, &request.techniques, host, &mut found);
        return found.or(study);
    }
    if study.ledger.is_empty() {
        return Err(
            Problem::new("empty-ledger", "the study asks for no evidence")
                .at(&study.ledger_source, 0..0)
                .remedy("add an [[evidence]] with `id`, `technique` and its assets to ledger.toml"),
        );
    }
    for id in &request.only {
        found.keep(study.entry(id).map(drop));
    }
    let study = found.or(study)?;
    for warning in study.forms.warnings(&[]) {
        host.events.say(&warning.warning_line());
    }
    Ok(study)
}
