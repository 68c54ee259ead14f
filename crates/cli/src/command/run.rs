//! `corroborate run`: produce what is missing or stale, compare, conclude,
//! report.

use super::{Done, Setting, json, use_threads};
use crate::args::{Format, Run};
use crate::corroboration::{self, Piece};
use crate::forms::differences;
use crate::outcome::Outcome;
use crate::problem::{Problem, did_you_mean};
use crate::store::{Inputs, Store, program_hash};
use crate::study::{Entry, Study, Work};
use crate::technique::campaign::{self, OutsideCommand, Until};
use crate::technique::experiment::Tables;
use crate::technique::model_checking::{Compiled, CountedConstant};
use crate::technique::operation::Recordings;
use crate::technique::simulation::{Campaign, Seeds};
use crate::technique::{self, Produced};
use evidence::{AssetRole, Measure, StudyResult};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What an entry needs, read and checked before anything runs.
enum Prepared<'a> {
    Check(Box<Compiled<'a>>),
    Simulate(Box<Campaign>),
    Command(Box<OutsideCommand>),
    /// The physics library is missing; said when the entry's turn comes, so
    /// that all else still runs.
    CannotSimulate(Problem),
    Read(Tables),
    Judge(Recordings),
}

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
const STUDY: &str = "comparison.json";

/// Where a study's results are.
pub fn results_folder(study: &Path, out: Option<&Path>) -> PathBuf {
    out.map_or_else(|| study.join("results"), Path::to_owned)
}

fn prepare<'a>(study: &'a Study, setting: &Setting) -> Result<Vec<Prepared<'a>>, Problem> {
    let prepared = study
        .ledger
        .iter()
        .map(|entry| match &entry.work {
            Work::Check { model, .. } => {
                let compiled = Compiled::new(study, model)?;
                check_constants(study, entry, &compiled)?;
                compiled.warn(&|line| setting.talk.say(line));
                Ok(Prepared::Check(Box::new(compiled)))
            }
            Work::Simulate {
                scenario,
                parameters,
                ..
            } => {
                let library = setting.physics_library.as_deref();
                prepared_campaign(Campaign::new(study, scenario, parameters, library), setting)
            }
            Work::SimulateScene { scene, test, .. } => {
                let library = setting.physics_library.as_deref();
                let campaign = Campaign::of_scene(study, scene, test.as_deref(), library);
                prepared_campaign(campaign, setting)
            }
            Work::Command { command, .. } => {
                let command = OutsideCommand::new(study, command)?;
                Ok(Prepared::Command(Box::new(command)))
            }
            Work::Read {
                cohort,
                requirements,
                failure_modes,
                ..
            } => Ok(Prepared::Read(Tables::read(
                study,
                cohort.as_deref(),
                requirements.as_deref(),
                failure_modes.as_deref(),
            )?)),
            Work::Judge { recordings, .. } => {
                Ok(Prepared::Judge(Recordings::find(study, recordings)?))
            }
        })
        .collect::<Result<Vec<_>, Problem>>()?;
    technique::judging::Judges::new(study, |_| true)?;
    every_proposition_is_expressed_somewhere(study, &prepared)?;
    Ok(prepared)
}

/// A campaign, or that simulations cannot run here; what of robots'
/// descriptions is not simulated is said.
fn prepared_campaign(
    campaign: Result<Campaign, Problem>,
    setting: &Setting,
) -> Result<Prepared<'static>, Problem> {
    match campaign {
        Ok(campaign) => {
            campaign.gaps().iter().for_each(|gap| setting.talk.say(gap));
            Ok(Prepared::Simulate(Box::new(campaign)))
        }
        Err(problem) if problem.code == "no-physics-library" => {
            Ok(Prepared::CannotSimulate(problem))
        }
        Err(problem) => Err(problem),
    }
}

/// The stopping rules of the ledger, held against the requirements.
fn untils(study: &Study) -> Result<BTreeMap<&str, Until>, Problem> {
    let with_rule = study
        .ledger
        .iter()
        .filter_map(|entry| Some((entry, entry.sampling.until.as_ref()?)));
    with_rule
        .map(|(entry, text)| {
            let until = Until::new(study, text).map_err(|problem| problem.about(&entry.id))?;
            Ok((entry.id.as_str(), until))
        })
        .collect()
}

/// What was set to a count must be a constant of the model.
fn check_constants(study: &Study, entry: &Entry, compiled: &Compiled) -> Result<(), Problem> {
    for calibrated in &entry.calibrated {
        let Some(name) = &calibrated.constant else {
            continue;
        };
        if compiled.constant(name).is_none() {
            let problem = Problem::new(
                "unknown-constant",
                format!(
                    "the model of {} has no number `{name}` among its constants",
                    entry.id
                ),
            )
            .at(&study.ledger_source, calibrated.span.clone());
            return Err(match did_you_mean(name, compiled.constants()) {
                Some(similar) => problem.remedy(format!("did you mean `{similar}`?")),
                None => problem.remedy("name a constant that the model defines"),
            });
        }
    }
    Ok(())
}

/// A name that no model of the study knows is a mistake, not an abstraction.
fn every_proposition_is_expressed_somewhere(
    study: &Study,
    prepared: &[Prepared],
) -> Result<(), Problem> {
    let models: Vec<&Compiled> = prepared
        .iter()
        .filter_map(|p| match p {
            Prepared::Check(compiled) => Some(compiled.as_ref()),
            _ => None,
        })
        .collect();
    for (name, proposition) in &study.vocabulary.propositions {
        let (Some(binding), Some(first)) = (&proposition.model, models.first()) else {
            continue;
        };
        if models.iter().any(|m| m.expressed.contains(name.as_str())) {
            continue;
        }
        let reason = first.not_expressed.get(name.as_str());
        let reason = reason.map_or("it cannot be evaluated", String::as_str);
        return Err(Problem::new(
            "unknown-name",
            format!("no model of the study expresses `{name}`: {reason}"),
        )
        .at(&study.vocabulary.source, binding.span.clone())
        .remedy("correct the name, or remove the `model` binding"));
    }
    Ok(())
}

struct Runner<'a> {
    study: &'a Study,
    store: &'a Store,
    setting: &'a Setting,
    program: String,
    /// What each entry rests on.
    assets: BTreeMap<&'a str, Vec<evidence::Asset>>,
    /// The stopping rules of entries that have one.
    untils: BTreeMap<&'a str, Until>,
}

impl Runner<'_> {
    /// The evidence of one entry: kept, if it is fresh, or produced.
    fn piece(
        &self,
        entry: &Entry,
        prepared: &Prepared,
        before: &[Piece],
    ) -> Result<Piece, Problem> {
        let counted = counted_constants(entry, before)?;
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
                &self.setting.interrupt,
                &|title, total| self.setting.talk.begin(title, total),
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
            (Prepared::Judge(recordings), Work::Judge { .. }) => self.judge(entry, recordings)?,
            _ => {
                return Err(Problem::new(
                    "bad-ledger",
                    format!("the entry `{}` was prepared for other work", entry.id),
                ));
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
        let inputs = self.episode_inputs(entry, source);
        let folder = self
            .store
            .stage(&format!("episodes/{}", entry.id), &inputs.hash())?;
        let title = format!("{}: episodes", entry.id);
        let stage = self.setting.talk.begin(&title, episodes);
        let plan = campaign::Campaigning {
            study: self.study,
            id: &entry.id,
            source,
            seeds: Seeds::new(self.study.about.seed, &entry.id),
            numbers: 1..episodes + 1,
            keep: entry.sampling.keep,
            early_end: entry.sampling.early_end,
            until: self.untils.get(entry.id.as_str()),
            folder: &folder,
            judged_by: campaign::judged_by(self.study, source, &self.program),
            interrupt: &self.setting.interrupt,
            stage: &stage,
        };
        plan.produce()
    }

    /// What the recordings of episodes depend on. Another simulator runs the
    /// same whichever build of this program calls it.
    fn episode_inputs(&self, entry: &Entry, source: campaign::Source<'_>) -> Inputs {
        let mut inputs = Inputs::default();
        source.inputs(&mut inputs);
        if matches!(source, campaign::Source::Bench(_)) {
            inputs.add("program", self.program.as_bytes());
        }
        inputs
            .add("seed", &self.study.about.seed.to_le_bytes())
            .add("evidence", entry.id.as_bytes());
        if entry.sampling.early_end {
            inputs.add_json("early_end", &true);
        }
        inputs
    }

    fn judge(&self, entry: &Entry, recordings: &Recordings) -> Result<Produced, Problem> {
        let talk = &self.setting.talk;
        let stage = talk.begin(&format!("{}: recordings", entry.id), recordings.count());
        let interrupt = &self.setting.interrupt;
        recordings.produce(self.study, &entry.id, interrupt, &stage, &|line| {
            talk.say(line);
        })
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
                technique::judging::inputs_of(self.study, &mut inputs);
                entry.sampling.inputs(&mut inputs);
            }
            (Prepared::Command(command), Work::Command { episodes, .. }) => {
                command.inputs(&mut inputs);
                command.reading_inputs(&mut inputs);
                inputs.add("seed", &self.study.about.seed.to_le_bytes());
                inputs.add_json("episodes", episodes);
                technique::judging::inputs_of(self.study, &mut inputs);
                entry.sampling.inputs(&mut inputs);
            }
            (Prepared::Read(tables), Work::Read { .. }) => tables.inputs(self.study, &mut inputs),
            (Prepared::Judge(recordings), Work::Judge { .. }) => {
                recordings.inputs(self.study, &mut inputs)?;
                technique::judging::inputs_of(self.study, &mut inputs);
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
            piece.drifted = corroboration::drift(entry, |name| compiled.constant(name), before);
        }
        let (id, title, headline) = (&entry.id, &entry.title, &piece.headline);
        self.setting
            .talk
            .say(&format!("{id:<13} {title}: {headline} ({how})"));
        let differing = &piece.evidence.form_differences;
        if !differing.is_empty() {
            self.setting.talk.say(&differences::in_words(differing));
        }
        Ok(piece)
    }

    /// The hash of everything that comparing and concluding depend on.
    fn study_inputs(&self, pieces: &[Piece]) -> String {
        let mut inputs = Inputs::default();
        inputs.add("program", self.program.as_bytes());
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

    fn write(&self, result: &StudyResult, format: Format) -> Result<Done, Problem> {
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

/// The constants whose counts are uncertain, with the counts.
fn counted_constants(entry: &Entry, before: &[Piece]) -> Result<Vec<CountedConstant>, Problem> {
    let mut counted = Vec::new();
    // A step on the way is not compared, so its uncertainty is not asked for.
    if entry.intermediate {
        return Ok(counted);
    }
    for calibrated in &entry.calibrated {
        let Some(constant) = &calibrated.constant else {
            continue;
        };
        let calibration = &calibrated.calibration;
        // With --only, the evidence that supplies the counts may be left out;
        // the result is then kept under other inputs.
        let finding = before
            .iter()
            .find(|piece| piece.evidence.id == calibration.from)
            .and_then(|piece| piece.evidence.finding(&calibration.subject));
        let Some(finding) = finding else {
            continue;
        };
        let Measure::Counts { count, trials, .. } = finding.measure else {
            return Err(Problem::new(
                "bad-calibration",
                format!(
                    "`{}` of {} was set to {}'s count of {}, which has none",
                    calibration.parameter,
                    entry.id,
                    calibration.from,
                    calibration.subject.id()
                ),
            )
            .remedy("calibrate from evidence that counts"));
        };
        let sample = stats::Sample::new(count, trials)
            .map_err(|error| Problem::new("bad-counts", error.to_string()))?;
        counted.push(CountedConstant {
            name: constant.clone(),
            sample,
            subject: calibration.subject.clone(),
            held: calibrated.held,
        });
    }
    Ok(counted)
}

fn assets(study: &Study, entry: &Entry) -> Result<Vec<evidence::Asset>, Problem> {
    use AssetRole::{Data, RequirementModel, SystemModel};
    let mut files: Vec<(AssetRole, &Path)> = Vec::new();
    match &entry.work {
        Work::Check { model, .. } => files.push((SystemModel, model)),
        Work::Simulate {
            scenario,
            parameters,
            ..
        } => files.extend([(SystemModel, scenario.as_path()), (SystemModel, parameters)]),
        Work::SimulateScene { scene, .. } => files.push((SystemModel, scene)),
        Work::Read {
            cohort,
            requirements,
            failure_modes,
            ..
        } => {
            let tables = [cohort, requirements, failure_modes];
            files.extend(tables.into_iter().flatten().map(|t| (Data, t.as_path())));
        }
        Work::Judge { .. } | Work::Command { .. } => {
            let map = Path::new("topics.toml");
            if study.folder.join(map).exists() {
                files.push((RequirementModel, map));
            }
        }
    }
    files.push((RequirementModel, Path::new("requirements.toml")));
    files.push((RequirementModel, Path::new("vocabulary.toml")));
    files
        .into_iter()
        .map(|(role, path)| technique::asset(&study.folder, role, path))
        .collect()
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
