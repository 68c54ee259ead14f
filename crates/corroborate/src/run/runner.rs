//! Evidence for the entries of a ledger: kept where it is fresh, produced where it is not.

use super::prepare::Opened;
use super::ready::{COMPARISON, Ready, evidence_file};
use crate::corroboration::{self, Piece};
use crate::kept::{self, DIAGNOSIS};
use crate::results::{REPORT, RESULT, json};
use crate::technique::matrix::inputs_of;
use crate::technique::model_checking::{worst_case_tests, worst_cases_in_lines};
use crate::technique::{Produced, Working};
use diagnostic::{Problem, counted};
use evidence::{DescriptionGap, EpisodeFailures, Measure, StudyResult};
use host::store::Store;
use judging::forms::differences;
use study::Entry;

/// A study that is being run, with the folder that keeps its results.
pub(super) struct Runner<'a> {
    pub(super) ready: Ready<'a>,
    pub(super) store: Store,
}

impl Runner<'_> {
    /// The evidence of all entries, or of those that `only` names if it names any.
    pub(super) fn pieces(&self, only: &[String]) -> Result<Vec<Piece>, Problem> {
        self.refuse_what_is_not_allowed(only)?;
        let mut pieces: Vec<Piece> = Vec::new();
        let mut missing: Option<(&str, Problem)> = None;
        for (entry, prepared) in self.ready.entries() {
            if !only.is_empty() && !only.contains(&entry.id) {
                continue;
            }
            self.ready.host.go_on()?;
            if let Some(problem) = prepared.work.obstacle() {
                missing.get_or_insert((&entry.id, problem.clone()));
                continue;
            }
            pieces.push(self.piece(entry, prepared, &pieces)?);
        }
        let Some((id, problem)) = missing else {
            return Ok(pieces);
        };
        self.say(&format!(
            "{id} could not be produced, so nothing is compared"
        ));
        Err(problem)
    }

    /// Before anything runs: whether a program would have to run that the user has not allowed.
    fn refuse_what_is_not_allowed(&self, only: &[String]) -> Result<(), Problem> {
        for (entry, prepared) in self.ready.entries() {
            let is_asked_for = only.is_empty() || only.contains(&entry.id);
            let Some(problem) = prepared.work.not_allowed().filter(|_| is_asked_for) else {
                continue;
            };
            // Where there is an obstacle, what was kept cannot be told to be fresh.
            if prepared.work.obstacle().is_some() || !self.is_fresh(entry, prepared)? {
                return Err(problem.clone());
            }
        }
        Ok(())
    }

    /// Whether what was kept is fresh of an entry that depends on no evidence before it.
    fn is_fresh(&self, entry: &Entry, prepared: &Opened<'_>) -> Result<bool, Problem> {
        let counted = self.ready.counted(entry, prepared, &[])?;
        let inputs = self.ready.inputs(entry, prepared, &counted)?;
        let kept = self
            .store
            .fresh::<Produced>(&evidence_file(&entry.id), &inputs);
        Ok(kept.is_some())
    }

    /// What the pieces say together: kept, if nothing has changed, or compared.
    pub(super) fn compared(&self, pieces: Vec<Piece>) -> Result<StudyResult, Problem> {
        let inputs = self.ready.study_inputs(&pieces);
        if let Some(result) = self.store.fresh::<StudyResult>(COMPARISON, &inputs) {
            self.say("nothing has changed since the last run");
            return Ok(result);
        }
        let result = corroboration::corroborate(self.ready.study, pieces)?;
        self.store.keep(COMPARISON, &inputs, &result)?;
        Ok(result)
    }

    /// The evidence of one entry: kept, if it is fresh, or produced.
    fn piece(
        &self,
        entry: &Entry,
        prepared: &Opened<'_>,
        before: &[Piece],
    ) -> Result<Piece, Problem> {
        let counted = self.ready.counted(entry, prepared, before)?;
        let inputs = self.ready.inputs(entry, prepared, &counted)?;
        let name = evidence_file(&entry.id);
        let (produced, how) = match self.store.fresh::<Produced>(&name, &inputs) {
            Some(produced) => (produced, "kept".into()),
            None => {
                let produced = prepared.work.produce(&Working {
                    counted: &counted,
                    store: &self.store,
                    inputs: &inputs,
                    until: self.ready.untils.get(entry.id.as_str()),
                })?;
                self.store.keep(&name, &inputs, &produced)?;
                let how = time_taken(&produced);
                (produced, how)
            }
        };
        let piece = self
            .ready
            .piece(entry, prepared, before, inputs, produced)?;
        self.tell(entry, &piece, &how)?;
        Ok(piece)
    }

    /// Says what a piece shows, and writes the tests that its worst cases make.
    fn tell(&self, entry: &Entry, piece: &Piece, how: &str) -> Result<(), Problem> {
        let (id, title, headline) = (&entry.id, &entry.title, &piece.headline);
        self.say(&format!("{id:<13} {title}: {headline} ({how})"));
        for line in piece.evidence.failures.iter().filter_map(failures_in_words) {
            self.say(&format!("{id:<13} {line}"));
        }
        for (file, test) in worst_case_tests(&piece.evidence.findings) {
            self.store.write(file, test.as_bytes())?;
        }
        for line in worst_cases_in_lines(id, &piece.evidence.findings) {
            self.say(&line);
        }
        let gaps = &piece.evidence.description_gaps;
        if !gaps.is_empty() {
            let counts = DescriptionGap::in_short(gaps);
            self.say(&format!(
                "{id:<13} not simulated as described: {counts} (listed in the report)"
            ));
        }
        let differing = &piece.evidence.form_differences;
        if !differing.is_empty() {
            self.say(&differences::in_words(differing));
        }
        Ok(())
    }

    /// The result with the diagnosis, the map of disagreement, the exploration and the calibration that were made of
    /// the same evidence and assets, if any were.
    pub(super) fn completed(&self, mut result: StudyResult) -> StudyResult {
        let inputs = inputs_of(&result);
        result.diagnosis = self.store.fresh(DIAGNOSIS, &inputs);
        let (study, folder) = (self.ready.study, self.store.folder());
        result.disagreement = self.or_said("map of disagreement", kept::map(study, folder));
        result.exploration = self.or_said("exploration", kept::exploration(study, folder));
        result.calibration = self.or_said("calibration", kept::calibration(study, folder));
        result
    }

    /// What was kept, unless it is of other assets, which is said.
    fn or_said<T>(&self, what: &str, kept: Result<Option<T>, Problem>) -> Option<T> {
        kept.unwrap_or_else(|problem| {
            self.say(&format!("the {what} is left out: {problem}"));
            None
        })
    }

    /// Writes the result, and the page that is drawn of it.
    pub(super) fn write(&self, result: &StudyResult, page: Option<String>) -> Result<(), Problem> {
        self.store.write(RESULT, json(result)?.as_bytes())?;
        match page {
            Some(page) => self.store.write(REPORT, page.as_bytes()),
            None => Ok(()),
        }
    }

    fn say(&self, line: &str) {
        self.ready.host.events.say(line);
    }
}

/// How long it took, and how fast episodes ran.
fn time_taken(produced: &Produced) -> String {
    let speed = produced.cost.real_time_factor;
    let speed = speed.map_or(String::new(), |f| {
        format!(", {f:.0} times real time on a core")
    });
    format!("{:.1} s{speed}", produced.cost.wall_secs)
}

/// In how many episodes a failure was met, and in which one first.
fn failures_in_words(failure: &EpisodeFailures) -> Option<String> {
    let Measure::Counts { count, trials, .. } = failure.measure else {
        return None;
    };
    let (kind, first) = (failure.kind, failure.witnesses.first());
    let first = first.map_or(String::new(), |name| format!(", first in {name}"));
    Some(format!(
        "{kind} in {count} of {}{first}",
        counted(trials, "episode")
    ))
}
