//! The ledger's entries: which evidence is to be produced, on which assets,
//! and whose counts those assets were set to.

use super::{About, Forms};
use crate::problem::{Problem, Source};
use crate::store::Inputs;
use evidence::{Calibration, Subject};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// One entry of the ledger.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Identifier.
    pub id: String,
    /// Short title.
    pub title: String,
    /// Under which conditions it holds: a key of the study's conditions.
    pub conditions: String,
    /// What was changed before it.
    pub changed: String,
    /// A step on the way to later evidence.
    pub intermediate: bool,
    /// The evidence of ours that reproduces this published evidence.
    pub reproduced_by: Option<String>,
    /// Whose counts its assets were set to.
    pub calibrated: Vec<Calibrated>,
    /// Figures of the source publication.
    pub published: Published,
    /// How to produce it.
    pub work: Work,
    /// How its episodes are run, for simulations.
    pub sampling: Sampling,
}

/// How the episodes of a simulation are run.
#[derive(Clone, Debug, Default)]
pub struct Sampling {
    /// When to end before the last episode.
    pub until: Option<UntilText>,
    /// Which recordings are kept.
    pub keep: Keep,
    /// Whether an episode ends once all verdicts are determined.
    pub early_end: bool,
}

impl Sampling {
    /// What results depend on.
    pub fn inputs(&self, inputs: &mut Inputs) {
        inputs
            .add_json("until", &self.until)
            .add_json("keep", &self.keep)
            .add_json("early_end", &self.early_end);
    }
}

/// A stopping rule as it is written.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct UntilText {
    /// The requirement that is to be decided.
    pub requirement: String,
    /// The confidence in the decision, for example 0.99.
    pub confidence: f64,
    /// The rate against which it is decided, if not the requirement's own.
    pub threshold: Option<f64>,
}

/// Which recordings of episodes are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Keep {
    /// All, so that a changed monitor judges the same episodes again.
    #[default]
    All,
    /// Those in which a requirement is violated or a failure mode occurs.
    Violations,
    /// None; results are kept.
    None,
}

/// Another simulator, or a rig, as the ledger names it.
#[derive(Clone, Debug)]
pub struct CommandText {
    /// The words of the command.
    pub command: Vec<String>,
    /// Files on which its episodes depend.
    pub assets: Vec<PathBuf>,
    /// What is done in each episode.
    pub stimulus: Option<PathBuf>,
    /// The extension of its recordings; empty for folders.
    pub leaves: String,
    /// The longest that an episode may take, in seconds of real time.
    pub limit_secs: f64,
}

/// How a piece of evidence is produced.
#[derive(Clone, Debug)]
pub enum Work {
    /// Check the properties of all requirements on a formal model.
    Check {
        /// The model's file, relative to the study.
        model: PathBuf,
        /// Methods; the first gives the answer that counts.
        methods: Vec<Method>,
    },
    /// Run seeded episodes of a simulation and judge them with the monitors.
    Simulate {
        /// The scenario's file, relative to the study.
        scenario: PathBuf,
        /// The parameter set's file, relative to the study.
        parameters: PathBuf,
        /// How many episodes.
        episodes: u64,
    },
    /// Run seeded episodes of a scene and judge them with the monitors.
    SimulateScene {
        /// The scene's file, relative to the study.
        scene: PathBuf,
        /// Which of its tests is enacted; the first if none is named.
        test: Option<String>,
        /// How many episodes.
        episodes: u64,
    },
    /// Run a command for each episode and judge the recording that it leaves.
    Command {
        /// Of a simulator or of a rig.
        technique: evidence::Technique,
        /// The command with all that belongs to it.
        command: CommandText,
        /// How many episodes.
        episodes: u64,
    },
    /// Read counts from tables.
    Read {
        /// Of the real robot or of published simulations.
        technique: evidence::Technique,
        /// Trials by subject.
        cohort: Option<PathBuf>,
        /// Verdicts by requirement.
        requirements: Option<PathBuf>,
        /// Occurrences by failure mode.
        failure_modes: Option<PathBuf>,
    },
    /// Judge recordings with the monitors; each is a trial.
    Judge {
        /// Of the robot at work, or of trials with it.
        technique: evidence::Technique,
        /// Their folder, relative to the study.
        recordings: PathBuf,
    },
}

impl Work {
    /// The technique that does it.
    pub fn technique(&self) -> evidence::Technique {
        match self {
            Work::Check { .. } => evidence::Technique::ModelChecking,
            Work::Simulate { .. } | Work::SimulateScene { .. } => evidence::Technique::Simulation,
            Work::Read { technique, .. }
            | Work::Judge { technique, .. }
            | Work::Command { technique, .. } => *technique,
        }
    }

    /// Whether counts are read instead of produced.
    pub fn is_read(&self) -> bool {
        matches!(self, Work::Read { .. })
    }
}

/// A method of model checking.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Bounds that hold, to a relative width (for `check`: `--precision`).
    Sound,
    /// Rational arithmetic, without any rounding.
    Exact,
    /// The stopping rule of PRISM's default settings: an estimate.
    PrismDefault,
}

impl Method {
    /// The checker's method.
    pub fn of_checker(self) -> checker::Method {
        match self {
            Method::Sound => checker::Method::Sound,
            Method::Exact => checker::Method::Exact,
            Method::PrismDefault => checker::Method::PrismDefault,
        }
    }

    /// Its name in evidence, reports and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Method::Sound => "sound",
            Method::Exact => "exact",
            Method::PrismDefault => "prism-default",
        }
    }
}

/// A number of the assets that was set to another evidence's count.
#[derive(Clone, Debug)]
pub struct Calibrated {
    /// As the evidence reports it.
    pub calibration: Calibration,
    /// The formal model's constant whose uncertainty is carried through; a
    /// held constant keeps its value.
    pub constant: Option<String>,
    /// Whether the constant keeps its value although it was estimated.
    pub held: bool,
    /// Its place in the ledger.
    pub span: Range<usize>,
}

/// Figures that the source publication prints.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// States of the model.
    pub states: Option<u64>,
    /// Transitions of the model.
    pub transitions: Option<u64>,
    /// The probability of the first requirement.
    pub success: Option<PublishedValue>,
    /// Values by requirement.
    #[serde(default)]
    pub requirements: BTreeMap<String, String>,
    /// What it took, in words.
    pub cost: Option<String>,
}

/// A printed probability.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedValue {
    /// The method of ours that should give these digits.
    pub method: Method,
    /// The digits.
    pub value: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    evidence: Vec<EntryText>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EntryText {
    id: Spanned<String>,
    title: String,
    technique: Spanned<evidence::Technique>,
    conditions: Spanned<String>,
    changed: String,
    #[serde(default)]
    intermediate: bool,
    reproduced_by: Option<Spanned<String>>,
    #[serde(default)]
    calibrated: Vec<CalibratedText>,
    #[serde(default)]
    published: Published,
    model: Option<Spanned<PathBuf>>,
    methods: Option<Spanned<Vec<Method>>>,
    scenario: Option<Spanned<PathBuf>>,
    parameters: Option<Spanned<PathBuf>>,
    scene: Option<Spanned<PathBuf>>,
    test: Option<Spanned<String>>,
    episodes: Option<Spanned<u64>>,
    command: Option<Spanned<Vec<String>>>,
    assets: Option<Vec<Spanned<PathBuf>>>,
    stimulus: Option<Spanned<PathBuf>>,
    leaves: Option<Spanned<String>>,
    limit_secs: Option<Spanned<f64>>,
    until: Option<Spanned<UntilText>>,
    keep: Option<Spanned<Keep>>,
    early_end: Option<Spanned<bool>>,
    tables: Option<Spanned<TablesText>>,
    recordings: Option<Spanned<PathBuf>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TablesText {
    cohort: Option<Spanned<PathBuf>>,
    requirements: Option<Spanned<PathBuf>>,
    failure_modes: Option<Spanned<PathBuf>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CalibratedText {
    parameter: Option<String>,
    constant: Option<Spanned<String>>,
    #[serde(default)]
    held: bool,
    from: Spanned<String>,
    failure_mode: Option<Spanned<String>>,
    requirement: Option<Spanned<String>>,
}

/// Reads `ledger.toml`, if there is one, and checks it against the rest of the
/// study.
pub fn load(folder: &Path, about: &About, forms: &Forms) -> Result<(Vec<Entry>, Source), Problem> {
    let path = folder.join("ledger.toml");
    let source = if path.exists() {
        Source::read(&path)?
    } else {
        Source {
            name: path.display().to_string(),
            text: String::new(),
        }
    };
    let file: File =
        toml::from_str(&source.text).map_err(|error| Problem::from_toml(&source, &error))?;
    let all: BTreeSet<String> = file
        .evidence
        .iter()
        .map(|e| e.id.get_ref().clone())
        .collect();
    let reader = Reader {
        folder,
        source: &source,
        about,
        forms,
        all,
    };
    let mut seen = BTreeSet::new();
    let mut entries = Vec::new();
    for text in file.evidence {
        if !seen.insert(text.id.get_ref().clone()) {
            return Err(reader.problem(
                "duplicate-id",
                format!("the ledger has two entries `{}`", text.id.get_ref()),
                text.id.span(),
                "give each piece of evidence its own identifier",
            ));
        }
        entries.push(reader.entry(text, &seen)?);
    }
    Ok((entries, source))
}

struct Reader<'a> {
    folder: &'a Path,
    source: &'a Source,
    about: &'a About,
    forms: &'a Forms,
    all: BTreeSet<String>,
}

impl Reader<'_> {
    fn problem(
        &self,
        code: &'static str,
        message: String,
        span: Range<usize>,
        remedy: &str,
    ) -> Problem {
        Problem::new(code, message)
            .at(self.source, span)
            .remedy(remedy)
    }

    fn entry(&self, text: EntryText, seen: &BTreeSet<String>) -> Result<Entry, Problem> {
        if !is_file_name(text.id.get_ref()) {
            return Err(self.problem(
                "bad-id",
                format!("`{}` cannot name evidence", text.id.get_ref()),
                text.id.span(),
                "use letters, digits, `-` and `_`; results are kept in files of that name",
            ));
        }
        let conditions = text.conditions.get_ref();
        if !self.about.conditions.contains_key(conditions) {
            return Err(self.problem(
                "unknown-conditions",
                format!("study.toml describes no conditions `{conditions}`"),
                text.conditions.span(),
                "describe them under [conditions] in study.toml",
            ));
        }
        if let Some(ours) = &text.reproduced_by
            && !self.all.contains(ours.get_ref())
        {
            return Err(self.unknown_evidence(ours));
        }
        let calibrated = text
            .calibrated
            .iter()
            .map(|c| self.calibrated(c, text.id.get_ref(), seen))
            .collect::<Result<_, _>>()?;
        Ok(Entry {
            work: self.work(&text)?,
            sampling: self.sampling(&text)?,
            calibrated,
            conditions: conditions.clone(),
            id: text.id.into_inner(),
            title: text.title,
            changed: text.changed,
            intermediate: text.intermediate,
            reproduced_by: text.reproduced_by.map(Spanned::into_inner),
            published: text.published,
        })
    }

    fn unknown_evidence(&self, id: &Spanned<String>) -> Problem {
        self.problem(
            "unknown-evidence",
            format!("the ledger has no evidence `{}` there", id.get_ref()),
            id.span(),
            "name an entry of this ledger; what calibrates another must stand before it",
        )
    }

    fn calibrated(
        &self,
        text: &CalibratedText,
        id: &str,
        seen: &BTreeSet<String>,
    ) -> Result<Calibrated, Problem> {
        if !seen.contains(text.from.get_ref()) || text.from.get_ref() == id {
            return Err(self.unknown_evidence(&text.from));
        }
        let (subject, named) = match (&text.failure_mode, &text.requirement) {
            (Some(mode), None) => (Subject::FailureMode(mode.get_ref().clone()), mode),
            (None, Some(requirement)) => (
                Subject::Requirement(requirement.get_ref().clone()),
                requirement,
            ),
            _ => {
                return Err(self.problem(
                    "bad-calibration",
                    "a calibration needs either a `failure_mode` or a `requirement`".into(),
                    text.from.span(),
                    "say which of its counts was taken",
                ));
            }
        };
        if self.forms.of(&subject).is_none() {
            return Err(self.problem(
                "unknown-subject",
                format!(
                    "requirements.toml declares no `{}` of this kind",
                    named.get_ref()
                ),
                named.span(),
                "check the identifier",
            ));
        }
        let parameter = match (&text.parameter, &text.constant) {
            (Some(parameter), None) => parameter.clone(),
            (None, Some(constant)) => constant.get_ref().clone(),
            _ => {
                return Err(self.problem(
                    "bad-calibration",
                    "a calibration needs either a `constant` of the model or a `parameter`".into(),
                    text.from.span(),
                    "say which number was set",
                ));
            }
        };
        Ok(Calibrated {
            calibration: Calibration {
                parameter,
                from: text.from.get_ref().clone(),
                subject,
            },
            span: text
                .constant
                .as_ref()
                .map_or(text.from.span(), Spanned::span),
            constant: text.constant.as_ref().map(|c| c.get_ref().clone()),
            held: text.held,
        })
    }

    fn work(&self, text: &EntryText) -> Result<Work, Problem> {
        use evidence::Technique::{Experiment, ModelChecking, Operation, Simulation};
        match text.technique.get_ref() {
            ModelChecking => self.check(text),
            technique @ (Simulation | Experiment) if text.command.is_some() => {
                self.command(text, *technique)
            }
            Simulation if text.tables.is_none() => self.simulate(text),
            Experiment if text.recordings.is_some() => self.judge(text, Experiment),
            technique @ (Simulation | Experiment) => self.read(text, *technique),
            Operation => self.judge(text, Operation),
        }
    }

    fn check(&self, text: &EntryText) -> Result<Work, Problem> {
        let model = self.file(text, "model", text.model.as_ref())?;
        let methods = match &text.methods {
            None => vec![Method::Sound],
            Some(methods) if methods.get_ref().is_empty() => {
                return Err(self.problem(
                    "no-method",
                    "`methods` is empty".into(),
                    methods.span(),
                    "leave it out for the sound method",
                ));
            }
            Some(methods) => methods.get_ref().clone(),
        };
        Ok(Work::Check { model, methods })
    }

    /// How many episodes are asked for.
    fn episodes(&self, text: &EntryText) -> Result<u64, Problem> {
        let episodes = text.episodes.as_ref().ok_or_else(|| {
            self.problem(
                "missing-entry",
                format!(
                    "the simulation `{}` does not say how many `episodes`",
                    text.id.get_ref()
                ),
                text.id.span(),
                "add for example `episodes = 100`, or `tables.…` to read published counts",
            )
        })?;
        if !(1..=10_000_000).contains(episodes.get_ref()) {
            return Err(self.problem(
                "bad-episodes",
                format!("{} is no number of episodes", episodes.get_ref()),
                episodes.span(),
                "choose 1 to 10000000",
            ));
        }
        Ok(*episodes.get_ref())
    }

    fn command(&self, text: &EntryText, technique: evidence::Technique) -> Result<Work, Problem> {
        let others = [
            text.scenario.as_ref().map(Spanned::span),
            text.scene.as_ref().map(Spanned::span),
            text.tables.as_ref().map(Spanned::span),
            text.recordings.as_ref().map(Spanned::span),
        ];
        if let Some(span) = others.into_iter().flatten().next() {
            return Err(self.problem(
                "bad-ledger",
                format!("`{}` has a command and another source", text.id.get_ref()),
                span,
                "keep either `command` or this",
            ));
        }
        let (words, span) = match &text.command {
            Some(words) => (words.get_ref().clone(), words.span()),
            None => (Vec::new(), text.id.span()),
        };
        let names = |place: &str| words.iter().any(|word| word.contains(place));
        let is_usable = words.first().is_some_and(|word| !word.is_empty());
        if !is_usable || !names("{recording}") || !names("{seed}") {
            return Err(self.problem(
                "bad-command",
                "the command has to be told where to leave its recording, and its seed".into(),
                span,
                "for example `command = [\"python3\", \"simulate.py\", \"{stimulus}\", \"{seed}\", \"{recording}\"]`",
            ));
        }
        let assets = text.assets.iter().flatten().map(|path| self.existing(path));
        let command = CommandText {
            command: words,
            assets: assets.collect::<Result<_, _>>()?,
            stimulus: text
                .stimulus
                .as_ref()
                .map(|it| self.existing(it))
                .transpose()?,
            leaves: self.leaves(text)?,
            limit_secs: self.limit_secs(text)?,
        };
        Ok(Work::Command {
            technique,
            command,
            episodes: self.episodes(text)?,
        })
    }

    fn leaves(&self, text: &EntryText) -> Result<String, Problem> {
        let Some(leaves) = &text.leaves else {
            return Ok("mcap".into());
        };
        let extension = leaves.get_ref().trim_start_matches('.');
        if extension
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || c == '.')
        {
            return Ok(extension.to_owned());
        }
        Err(self.problem(
            "bad-command",
            format!("`{extension}` is no extension of a file"),
            leaves.span(),
            "name for example `mcap`, `bag`, `db3`, `csv` or `jsonl`; leave it empty for a folder",
        ))
    }

    fn limit_secs(&self, text: &EntryText) -> Result<f64, Problem> {
        match &text.limit_secs {
            None => Ok(3600.0),
            Some(limit) if *limit.get_ref() > 0.0 && *limit.get_ref() <= 1e6 => {
                Ok(*limit.get_ref())
            }
            Some(limit) => Err(self.problem(
                "bad-command",
                format!("{} s is no limit for an episode", limit.get_ref()),
                limit.span(),
                "choose seconds of real time above 0, at most 1000000",
            )),
        }
    }

    /// How episodes are run; only what has episodes may say so.
    fn sampling(&self, text: &EntryText) -> Result<Sampling, Problem> {
        let spans = [
            text.until.as_ref().map(Spanned::span),
            text.keep.as_ref().map(Spanned::span),
            text.early_end.as_ref().map(Spanned::span),
        ];
        if let (None, Some(span)) = (&text.episodes, spans.into_iter().flatten().next()) {
            return Err(self.problem(
                "bad-ledger",
                format!("`{}` runs no episodes", text.id.get_ref()),
                span,
                "`until`, `keep` and `early_end` belong to entries with `episodes`",
            ));
        }
        if let (Some(_), Some(early)) = (&text.command, &text.early_end) {
            return Err(self.problem(
                "bad-ledger",
                "another simulator is judged by its recording, so it does not end early".into(),
                early.span(),
                "leave `early_end` out",
            ));
        }
        Ok(Sampling {
            until: text.until.as_ref().map(|it| it.get_ref().clone()),
            keep: text
                .keep
                .as_ref()
                .map(|it| *it.get_ref())
                .unwrap_or_default(),
            early_end: text.early_end.as_ref().is_some_and(|it| *it.get_ref()),
        })
    }

    fn simulate(&self, text: &EntryText) -> Result<Work, Problem> {
        let episodes = self.episodes(text)?;
        if let Some(scene) = &text.scene {
            return self.simulate_scene(text, scene, episodes);
        }
        Ok(Work::Simulate {
            scenario: self.file(text, "scenario", text.scenario.as_ref())?,
            parameters: self.file(text, "parameters", text.parameters.as_ref())?,
            episodes,
        })
    }

    fn simulate_scene(
        &self,
        text: &EntryText,
        scene: &Spanned<PathBuf>,
        episodes: u64,
    ) -> Result<Work, Problem> {
        if let Some(other) = text.scenario.as_ref().or(text.parameters.as_ref()) {
            return Err(self.problem(
                "bad-ledger",
                format!("`{}` names a scene and a scenario", text.id.get_ref()),
                other.span(),
                "keep either `scene` or `scenario` and `parameters`",
            ));
        }
        Ok(Work::SimulateScene {
            scene: self.existing(scene)?,
            test: text.test.as_ref().map(|test| test.get_ref().clone()),
            episodes,
        })
    }

    fn judge(&self, text: &EntryText, technique: evidence::Technique) -> Result<Work, Problem> {
        let (Some(recordings), None) = (&text.recordings, &text.tables) else {
            return Err(self.problem(
                "missing-entry",
                format!(
                    "`{}` has to name either `recordings` or, for an experiment, `tables`",
                    text.id.get_ref()
                ),
                text.id.span(),
                "add for example `recordings = \"runs/recordings\"`, a folder of the study",
            ));
        };
        Ok(Work::Judge {
            technique,
            recordings: match self.folder.join(recordings.get_ref()).exists() {
                true => recordings.get_ref().clone(),
                false => self.existing(recordings)?,
            },
        })
    }

    fn read(&self, text: &EntryText, technique: evidence::Technique) -> Result<Work, Problem> {
        let Some(tables) = &text.tables else {
            return Err(self.problem(
                "missing-entry",
                format!("the experiment `{}` names no tables", text.id.get_ref()),
                text.id.span(),
                "add `tables.cohort`, `tables.requirements` or `tables.failure_modes`, or `recordings`",
            ));
        };
        let span = tables.span();
        let tables = tables.get_ref();
        let file =
            |path: &Option<Spanned<PathBuf>>| path.as_ref().map(|p| self.existing(p)).transpose();
        let work = Work::Read {
            technique,
            cohort: file(&tables.cohort)?,
            requirements: file(&tables.requirements)?,
            failure_modes: file(&tables.failure_modes)?,
        };
        match &work {
            Work::Read {
                cohort: None,
                requirements: None,
                failure_modes: None,
                ..
            } => Err(self.problem(
                "missing-entry",
                "`tables` names no table".into(),
                span,
                "add `cohort`, `requirements` or `failure_modes`",
            )),
            _ => Ok(work),
        }
    }

    fn file(
        &self,
        text: &EntryText,
        what: &str,
        path: Option<&Spanned<PathBuf>>,
    ) -> Result<PathBuf, Problem> {
        match path {
            Some(path) => self.existing(path),
            None => Err(self.problem(
                "missing-entry",
                format!("the evidence `{}` names no `{what}`", text.id.get_ref()),
                text.id.span(),
                &format!("add `{what} = \"…\"`"),
            )),
        }
    }

    fn existing(&self, path: &Spanned<PathBuf>) -> Result<PathBuf, Problem> {
        if self.folder.join(path.get_ref()).is_file() {
            return Ok(path.get_ref().clone());
        }
        Err(self.problem(
            "missing-file",
            format!("the study has no file {}", path.get_ref().display()),
            path.span(),
            "paths are relative to the study's folder",
        ))
    }
}

fn is_file_name(id: &str) -> bool {
    !id.is_empty()
        && id.len() <= 64
        && id
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_')
}
