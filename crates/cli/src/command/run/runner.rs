//! Evidence for one entry of a ledger: kept where it is fresh, produced where it is not.

use super::prepare::{Prepared, counted_constants};
use super::{terminal_width, use_colour};
use crate::args::Format;
use crate::command::calibrate::kept_calibration;
use crate::command::diagnose::DIAGNOSIS;
use crate::command::explore::{kept_exploration, kept_map};
use crate::command::{Done, Host, json};
use corroborate::corroboration::{self, Piece};
use corroborate::technique::Produced;
use corroborate::technique::campaign::{self, Until};
use corroborate::technique::matrix::inputs_of;
use corroborate::technique::model_checking::{
    CountedConstant, worst_case_tests, worst_cases_in_lines,
};
use corroborate::technique::operation::{Recordings, verdicts_name};
use corroborate::technique::simulation::Seeds;
use diagnostic::Problem;
use evidence::StudyResult;
use host::store::{Inputs, Store};
use judging::forms::differences;
use judging::verdicts::RunVerdicts;
use std::collections::BTreeMap;
use study::{Entry, Study, Work};

/// The file that keeps the result of comparing, with the hash of what it was
/// compared from.
pub const STUDY: &str = "comparison.json";

pub(super) struct Runner<'a> {
    pub(super) study: &'a Study,
    pub(super) store: &'a Store,
    pub(super) setting: &'a Host,
    pub(super) program: String,
    /// What each entry rests on.
    pub(super) assets: BTreeMap<&'a str, Vec<evidence::Asset>>,
    /// The stopping rules of entries that have one.
    pub(super) untils: BTreeMap<&'a str, Until>,
}

impl Runner<'_> {
    /// The evidence of all entries, or of those that `only` names if it names any.
    pub(super) fn pieces(
        &self,
        prepared: &[Prepared],
        only: &[String],
    ) -> Result<Vec<Piece>, Problem> {
        let mut pieces: Vec<Piece> = Vec::new();
        let mut missing: Option<(&str, Problem)> = None;
        for (entry, prepared) in self.study.ledger.iter().zip(prepared) {
            if !only.is_empty() && !only.contains(&entry.id) {
                continue;
            }
            self.setting.go_on()?;
            if let Prepared::CannotSimulate(problem) = prepared {
                missing.get_or_insert((&entry.id, problem.clone()));
                continue;
            }
            pieces.push(self.piece(entry, prepared, &pieces)?);
        }
        let Some((id, problem)) = missing else {
            return Ok(pieces);
        };
        self.setting.events.say(&format!(
            "{id} could not be produced, so nothing is compared"
        ));
        Err(problem)
    }

    /// What the pieces say together: kept, if nothing has changed, or compared.
    pub(super) fn compared(&self, pieces: Vec<Piece>) -> Result<StudyResult, Problem> {
        let inputs = self.study_inputs(&pieces);
        if let Some(result) = self.store.fresh::<StudyResult>(STUDY, &inputs) {
            self.setting
                .events
                .say("nothing has changed since the last run");
            return Ok(result);
        }
        let result = corroboration::corroborate(self.study, pieces)?;
        self.store.keep(STUDY, &inputs, &result)?;
        Ok(result)
    }

    /// The evidence of one entry: kept, if it is fresh, or produced.
    fn piece(
        &self,
        entry: &Entry,
        prepared: &Prepared,
        before: &[Piece],
    ) -> Result<Piece, Problem> {
        let value_of = |name: &str| match prepared {
            Prepared::Check(compiled) => compiled.constant(name),
            _ => None,
        };
        let counted = counted_constants(self.study, entry, before, &value_of)?;
        let inputs = self.inputs(entry, prepared, &counted)?;
        let name = format!("evidence/{}.json", entry.id);
        if let Some(produced) = self.store.fresh::<Produced>(&name, &inputs) {
            return self.finished(entry, prepared, before, inputs, produced, false);
        }
        let produced = match (prepared, &entry.work) {
            (Prepared::Check(compiled), Work::Check { methods, .. }) => compiled.produce(
                &entry.id,
                methods,
                &counted,
                &self.setting.cancel,
                &|title, total| self.setting.events.begin(title, total),
            )?,
            (
                Prepared::Simulate(campaign),
                Work::Simulate { episodes, .. } | Work::SimulateScene { episodes, .. },
            ) => self.simulate(entry, campaign::Source::Bench(campaign), *episodes)?,
            (Prepared::Command(command), Work::Command { episodes, .. }) => {
                self.simulate(entry, campaign::Source::Command(command), *episodes)?
            }
            (Prepared::Read(tables), Work::Read { technique, .. }) => {
                tables.produce(self.study, &entry.id, *technique)?
            }
            (Prepared::Judge(recordings), Work::Judge { .. }) => {
                self.judge(entry, recordings, &inputs)?
            }
            _ => {
                return Err(Problem::new(
                    "prepared-otherwise",
                    format!("the entry `{}` was prepared for other work", entry.id),
                )
                .remedy("this is a bug of the program: please report it with the ledger"));
            }
        };
        self.store.keep(&name, &inputs, &produced)?;
        self.finished(entry, prepared, before, inputs, produced, true)
    }

    fn simulate(
        &self,
        entry: &Entry,
        source: campaign::Source<'_>,
        episodes: u64,
    ) -> Result<Produced, Problem> {
        let inputs = campaign::episode_inputs(self.study, entry, source, &self.program);
        let folder = self
            .store
            .stage(&format!("episodes/{}", entry.id), &inputs.hash())?;
        let title = format!("{}: episodes", entry.id);
        let stage = self.setting.events.begin(&title, episodes);
        let plan = campaign::Campaigning {
            study: self.study,
            id: &entry.id,
            source,
            seeds: Seeds::new(self.study.about.seed, &entry.id),
            numbers: 1..episodes + 1,
            keep: entry.sampling.keep,
            early_end: entry.sampling.early_end,
            on_failure: entry.sampling.on_failure,
            until: self.untils.get(entry.id.as_str()),
            folder: &folder,
            judged_by: campaign::judged_by(self.study, source, &self.program),
            interrupt: &self.setting.cancel,
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
        let talk = &self.setting.events;
        let stage = talk.begin(&format!("{}: recordings", entry.id), recordings.count());
        let interrupt = &self.setting.cancel;
        let say = |line: &str| talk.say(line);
        let (produced, main) =
            recordings.produce(self.study, &entry.id, interrupt, &stage, &say)?;
        let forms = recordings.form_verdicts(self.study, interrupt)?;
        let verdicts = RunVerdicts { main, forms };
        self.store
            .keep(&verdicts_name(&entry.id), inputs, verdicts)?;
        Ok(produced)
    }

    /// The hash of everything that the entry's findings depend on.
    fn inputs(
        &self,
        entry: &Entry,
        prepared: &Prepared,
        counted: &[CountedConstant],
    ) -> Result<String, Problem> {
        let mut inputs = Inputs::default();
        inputs
            .add("program", self.program.as_bytes())
            .add("evidence", entry.id.as_bytes())
            .add_json("confidence", &self.study.about.confidence);
        match (prepared, &entry.work) {
            (Prepared::Check(compiled), Work::Check { methods, .. }) => {
                compiled.inputs(&mut inputs);
                inputs.add_json("methods", methods);
                inputs.add("seed", &self.study.about.seed.to_le_bytes());
                for constant in counted {
                    let sample = (
                        constant.sample.successes,
                        constant.sample.trials,
                        constant.held,
                    );
                    inputs.add_json(&constant.name, &sample);
                }
            }
            (
                Prepared::Simulate(campaign),
                Work::Simulate { episodes, .. } | Work::SimulateScene { episodes, .. },
            ) => {
                campaign.inputs(&mut inputs);
                inputs.add("seed", &self.study.about.seed.to_le_bytes());
                inputs.add_json("episodes", episodes);
                judging::inputs_of(self.study, &mut inputs);
                entry.sampling.inputs(&mut inputs);
            }
            (Prepared::Command(command), Work::Command { episodes, .. }) => {
                command.inputs(&mut inputs);
                command.reading_inputs(&mut inputs);
                inputs.add("seed", &self.study.about.seed.to_le_bytes());
                inputs.add_json("episodes", episodes);
                judging::inputs_of(self.study, &mut inputs);
                entry.sampling.inputs(&mut inputs);
            }
            (Prepared::Read(tables), Work::Read { .. }) => tables.inputs(self.study, &mut inputs),
            (Prepared::Judge(recordings), Work::Judge { .. }) => {
                recordings.inputs(self.study, &mut inputs)?;
                judging::inputs_of(self.study, &mut inputs);
            }
            _ => {}
        }
        Ok(inputs.hash())
    }

    fn finished(
        &self,
        entry: &Entry,
        prepared: &Prepared,
        before: &[Piece],
        inputs: String,
        produced: Produced,
        is_new: bool,
    ) -> Result<Piece, Problem> {
        let how = if is_new {
            let speed = produced.cost.real_time_factor;
            let speed = speed.map_or(String::new(), |f| {
                format!(", {f:.0} times real time on a core")
            });
            format!("{:.1} s{speed}", produced.cost.wall_secs)
        } else {
            "kept".into()
        };
        let assets = self
            .assets
            .get(entry.id.as_str())
            .cloned()
            .unwrap_or_default();
        let mut piece = corroboration::piece(self.study, entry, assets, inputs, produced);
        if let Prepared::Check(compiled) = prepared {
            let known = |id: &str| before.iter().map(|p| &p.evidence).find(|e| e.id == id);
            piece.drifted = corroboration::drift(entry, |name| compiled.constant(name), known);
        }
        let (id, title, headline) = (&entry.id, &entry.title, &piece.headline);
        self.setting
            .events
            .say(&format!("{id:<13} {title}: {headline} ({how})"));
        for failure in &piece.evidence.failures {
            if let evidence::Measure::Counts { count, trials, .. } = failure.measure {
                let (kind, first) = (failure.kind, failure.witnesses.first());
                let first = first.map_or(String::new(), |name| format!(", first in {name}"));
                self.setting.events.say(&format!(
                    "{id:<13} {kind} in {count} of {trials} episodes{first}"
                ));
            }
        }
        for (file, test) in worst_case_tests(&piece.evidence.findings) {
            self.store.write(file, test.as_bytes())?;
        }
        for line in worst_cases_in_lines(id, &piece.evidence.findings) {
            self.setting.events.say(&line);
        }
        let gaps = &piece.evidence.description_gaps;
        if !gaps.is_empty() {
            let counts = evidence::DescriptionGap::in_short(gaps);
            self.setting.events.say(&format!(
                "{id:<13} not simulated as described: {counts} (listed in the report)"
            ));
        }
        let differing = &piece.evidence.form_differences;
        if !differing.is_empty() {
            self.setting.events.say(&differences::in_words(differing));
        }
        Ok(piece)
    }

    /// The hash of everything that comparing and concluding depend on.
    fn study_inputs(&self, pieces: &[Piece]) -> String {
        let mut inputs = Inputs::default();
        inputs.add("program", self.program.as_bytes());
        let now: Vec<evidence::Evidence> = pieces.iter().map(|p| p.evidence.clone()).collect();
        let looks = self.study.looks.clone();
        inputs.add_json(
            "looks",
            &looks.map(|looks| looks.with(evidence::Look::of(&now))),
        );
        for piece in pieces {
            inputs.add(&piece.evidence.id, piece.evidence.inputs.as_bytes());
            inputs.add_json("cost", &piece.cost);
        }
        // The texts that were loaded: the files may have been edited since.
        let study = self.study;
        for source in [
            &study.about_source,
            &study.forms.source,
            &study.vocabulary.source,
            &study.ledger_source,
        ] {
            inputs.add("file", source.text.as_bytes());
        }
        inputs.hash()
    }

    /// The result with the diagnosis, the map of disagreement, the exploration and the calibration that were made of
    /// the same evidence and assets, if any were.
    pub(super) fn completed(&self, mut result: StudyResult) -> StudyResult {
        let inputs = inputs_of(&result);
        result.diagnosis = self.store.fresh(DIAGNOSIS, &inputs);
        let folder = self.store.folder();
        result.disagreement = self.kept("map of disagreement", kept_map(self.study, folder));
        result.exploration = self.kept("exploration", kept_exploration(self.study, folder));
        result.calibration = self.kept("calibration", kept_calibration(self.study, folder));
        result
    }

    /// What was kept, unless it is of other assets, which is said.
    fn kept<T>(&self, what: &str, kept: Result<Option<T>, Problem>) -> Option<T> {
        kept.unwrap_or_else(|problem| {
            let reason = format!("the {what} is left out: {problem}");
            self.setting.events.say(&reason);
            None
        })
    }

    pub(super) fn write(&self, result: &StudyResult, format: Format) -> Result<Done, Problem> {
        let study_json = json(result)?;
        self.store.write("study.json", study_json.as_bytes())?;
        self.store
            .write("report.html", report::html(result).as_bytes())?;
        let report = self.store.folder().join("report.html");
        let output = match format {
            Format::Json => study_json,
            Format::Text => format!(
                "{}\nReport: {}\n",
                report::text(result, terminal_width(), use_colour()),
                report.display()
            ),
        };
        Ok(Done {
            output,
            outcome: corroboration::outcome(result),
        })
    }
}
