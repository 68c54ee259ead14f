//! Evidence for the entries of a ledger: kept where it is fresh, produced where it is not.

use super::prepare::Prepared;
use super::ready::{COMPARISON, Ready, evidence_file};
use crate::corroboration::{self, Piece};
use crate::kept::{self, DIAGNOSIS};
use crate::results::{REPORT, RESULT, json};
use crate::technique::Produced;
use crate::technique::campaign;
use crate::technique::matrix::inputs_of;
use crate::technique::model_checking::{CountedConstant, worst_case_tests, worst_cases_in_lines};
use crate::technique::operation::{Recordings, verdicts_name};
use crate::technique::simulation::Seeds;
use diagnostic::Problem;
use evidence::{DescriptionGap, EpisodeFailures, Measure, StudyResult};
use host::store::Store;
use judging::forms::differences;
use judging::verdicts::RunVerdicts;
use study::{Entry, Work};

/// A study that is being run, with the folder that keeps its results.
pub(super) struct Runner<'a> {
    pub(super) ready: Ready<'a>,
    pub(super) store: Store,
}

impl Runner<'_> {
    /// The evidence of all entries, or of those that `only` names if it names any.
    pub(super) fn pieces(&self, only: &[String]) -> Result<Vec<Piece>, Problem> {
        let mut pieces: Vec<Piece> = Vec::new();
        let mut missing: Option<(&str, Problem)> = None;
        for (entry, prepared) in self.ready.entries() {
            if !only.is_empty() && !only.contains(&entry.id) {
                continue;
            }
            self.ready.host.go_on()?;
            if let Prepared::CannotSimulate(problem) = prepared {
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
        prepared: &Prepared,
        before: &[Piece],
    ) -> Result<Piece, Problem> {
        let counted = self.ready.counted(entry, prepared, before)?;
        let inputs = self.ready.inputs(entry, prepared, &counted)?;
        let name = evidence_file(&entry.id);
        let (produced, how) = match self.store.fresh::<Produced>(&name, &inputs) {
            Some(produced) => (produced, "kept".into()),
            None => {
                let produced = self.produced(entry, prepared, &counted, &inputs)?;
                self.store.keep(&name, &inputs, &produced)?;
                let how = time_taken(&produced);
                (produced, how)
            }
        };
        let piece = self.ready.piece(entry, prepared, before, inputs, produced);
        self.tell(entry, &piece, &how)?;
        Ok(piece)
    }

    fn produced(
        &self,
        entry: &Entry,
        prepared: &Prepared,
        counted: &[CountedConstant],
        inputs: &str,
    ) -> Result<Produced, Problem> {
        let host = self.ready.host;
        match (prepared, &entry.work) {
            (Prepared::Check(compiled), Work::Check { methods, .. }) => {
                let begin = |title: &str, total: u64| host.events.begin(title, total);
                compiled.produce(&entry.id, methods, counted, &host.cancel, &begin)
            }
            (
                Prepared::Simulate(campaign),
                Work::Simulate { episodes, .. } | Work::SimulateScene { episodes, .. },
            ) => self.simulate(entry, campaign::Source::Bench(campaign), *episodes),
            (Prepared::Command(command), Work::Command { episodes, .. }) => {
                self.simulate(entry, campaign::Source::Command(command), *episodes)
            }
            (Prepared::Read(tables), Work::Read { technique, .. }) => {
                tables.produce(self.ready.study, &entry.id, *technique)
            }
            (Prepared::Judge(recordings), Work::Judge { .. }) => {
                self.judge(entry, recordings, inputs)
            }
            _ => Err(Problem::new(
                "prepared-otherwise",
                format!("the entry `{}` was prepared for other work", entry.id),
            )
            .remedy("this is a bug of the program: please report it with the ledger")),
        }
    }

    fn simulate(
        &self,
        entry: &Entry,
        source: campaign::Source<'_>,
        episodes: u64,
    ) -> Result<Produced, Problem> {
        let (study, host, program) = (self.ready.study, self.ready.host, self.ready.program());
        let inputs = campaign::episode_inputs(study, entry, source, program);
        let folder = self
            .store
            .stage(&format!("episodes/{}", entry.id), &inputs.hash())?;
        let stage = host
            .events
            .begin(&format!("{}: episodes", entry.id), episodes);
        let plan = campaign::Campaigning {
            study,
            id: &entry.id,
            source,
            seeds: Seeds::new(study.about.seed, &entry.id),
            numbers: 1..episodes + 1,
            keep: entry.sampling.keep,
            early_end: entry.sampling.early_end,
            on_failure: entry.sampling.on_failure,
            until: self.ready.untils.get(entry.id.as_str()),
            folder: &folder,
            judged_by: campaign::judged_by(study, source, program),
            interrupt: &host.cancel,
            stage: &stage,
        };
        plan.produce()
    }

    /// Judges recordings; what each form says of each is kept for a diagnosis.
    fn judge(
        &self,
        entry: &Entry,
        recordings: &Recordings,
        inputs: &str,
    ) -> Result<Produced, Problem> {
        let (study, events) = (self.ready.study, &self.ready.host.events);
        let stage = events.begin(&format!("{}: recordings", entry.id), recordings.count());
        let interrupt = &self.ready.host.cancel;
        let say = |line: &str| events.say(line);
        let (produced, main) = recordings.produce(study, &entry.id, interrupt, &stage, &say)?;
        let forms = recordings.form_verdicts(study, interrupt)?;
        let verdicts = RunVerdicts { main, forms };
        self.store
            .keep(&verdicts_name(&entry.id), inputs, verdicts)?;
        Ok(produced)
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
    Some(format!("{kind} in {count} of {trials} episodes{first}"))
}
