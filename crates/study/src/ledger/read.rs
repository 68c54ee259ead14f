//! Reads `ledger.toml` and holds it against the rest of the study.

use super::{
    Calibrated, Entry, Independent, Keep, Method, OnFailure, PhysicsEngine, Published, UntilText,
    Work,
};
use crate::{About, Forms, Texts};
use diagnostic::{Problem, Problems, Source, did_you_mean};
use evidence::{Calibration, Subject};
use host::Reach;
use host::reach::{OUTSIDE, REMEDY};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;

#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    /// The pieces of evidence, oldest first.
    #[serde(default)]
    evidence: Vec<EntryText>,
}

#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EntryText {
    /// Identifier, for example `E3`.
    #[schemars(with = "String")]
    pub(super) id: Spanned<String>,
    /// What it is, in a few words.
    pub(super) title: String,
    /// How it is produced.
    #[schemars(with = "evidence::Technique")]
    pub(super) technique: Spanned<evidence::Technique>,
    /// The conditions of `study.toml` under which it holds. Evidence under different conditions is not compared.
    #[schemars(with = "String")]
    pub(super) conditions: Spanned<String>,
    /// What changed since the entry before, and why.
    pub(super) changed: String,
    /// A step on the way, which decides nothing; the report lists it as excluded.
    #[serde(default)]
    pub(super) intermediate: bool,
    /// A later entry that repeats this one, which is left out for it.
    #[schemars(with = "Option<String>")]
    pub(super) reproduced_by: Option<Spanned<String>>,
    /// Which numbers of its assets were set to whose counts.
    #[serde(default)]
    pub(super) calibrated: Vec<CalibratedText>,
    /// Changes of its texts that were chosen because then other evidence agrees: agreement with that evidence is a fit. `refine` writes
    /// them; where something else shows that a change is right, say so in `changed` and leave the line out.
    #[serde(default)]
    pub(super) chosen: Vec<ChosenText>,
    /// Why a number that looks copied from other evidence was not: one reason for all, or one for each piece of evidence.
    #[schemars(with = "Option<IndependentText>")]
    pub(super) independent: Option<Spanned<IndependentText>>,
    /// Why runs that reach no verdict are as likely to pass as the others, so that they may be left out. Without it they are counted
    /// against and for. Simulation, and recordings.
    #[schemars(with = "Option<String>")]
    pub(super) undecided_at_random: Option<Spanned<String>>,
    /// Values that a publication gives for this entry, shown beside the computed ones.
    #[serde(default)]
    pub(super) published: Published,
    /// The formal model, a file in the PRISM language. Model checking.
    #[schemars(with = "Option<PathBuf>")]
    pub(super) model: Option<Spanned<PathBuf>>,
    /// By which methods it is solved; the first gives the value. Model checking.
    #[schemars(with = "Option<Vec<Method>>")]
    pub(super) methods: Option<Spanned<Vec<Method>>>,
    /// The fault tree: a file in the Open-PSA format where it ends in `.xml`, else in Galileo's. Fault trees.
    #[schemars(with = "Option<PathBuf>")]
    pub(super) tree: Option<Spanned<PathBuf>>,
    /// Which event of the tree is the violation of which requirement, or the occurrence of which failure mode. Fault trees.
    #[schemars(with = "Option<BTreeMap<String, String>>")]
    pub(super) events: Option<Spanned<BTreeMap<String, Spanned<String>>>>,
    /// Whether the tree's probabilities are given that the requirement is triggered, or that the failure mode has its
    /// opportunity; otherwise they are over all runs. Fault trees.
    #[schemars(with = "Option<bool>")]
    pub(super) triggered: Option<Spanned<bool>>,
    /// The time under way without repair, in the unit of the tree's rates. Fault trees that have rates.
    #[schemars(with = "Option<f64>")]
    pub(super) mission_time: Option<Spanned<f64>>,
    /// The handover's scenario. Simulation, with `parameters`.
    #[schemars(with = "Option<PathBuf>")]
    pub(super) scenario: Option<Spanned<PathBuf>>,
    /// The handover's parameter set. Simulation, with `scenario`.
    #[schemars(with = "Option<PathBuf>")]
    pub(super) parameters: Option<Spanned<PathBuf>>,
    /// The scene. Simulation.
    #[schemars(with = "Option<PathBuf>")]
    pub(super) scene: Option<Spanned<PathBuf>>,
    /// Which test of the scene is run; the first, if absent.
    #[schemars(with = "Option<String>")]
    pub(super) test: Option<Spanned<String>>,
    /// The physics engine of the scene or of the handover; MuJoCo, if absent.
    #[schemars(with = "Option<PhysicsEngine>")]
    pub(super) engine: Option<Spanned<PhysicsEngine>>,
    /// How many episodes are run, at most where `until` ends earlier. Simulation and commands.
    #[schemars(with = "Option<u64>")]
    pub(super) episodes: Option<Spanned<u64>>,
    /// A program that takes a stimulus and a seed and leaves a recording, with its arguments (`corroborate explain command`).
    #[schemars(with = "Option<Vec<String>>")]
    pub(super) command: Option<Spanned<Vec<String>>>,
    /// Files on which a command's episodes depend, besides those that it names.
    #[schemars(with = "Option<Vec<PathBuf>>")]
    pub(super) assets: Option<Vec<Spanned<PathBuf>>>,
    /// The file that says what is done in each episode of a command: a test and settings.
    #[schemars(with = "Option<PathBuf>")]
    pub(super) stimulus: Option<Spanned<PathBuf>>,
    /// The extension of the recordings that the command leaves, for example `csv`; empty for folders.
    #[schemars(with = "Option<String>")]
    pub(super) leaves: Option<Spanned<String>>,
    /// After how many seconds of wall-clock time a command is ended and counted as hanging.
    #[schemars(with = "Option<f64>")]
    pub(super) limit_secs: Option<Spanned<f64>>,
    /// Whether the command is started once for many episodes, each of which it is asked for by a line on its input
    /// (`corroborate explain command`). Default: `false`, a process for each episode.
    #[schemars(with = "Option<bool>")]
    pub(super) persistent: Option<Spanned<bool>>,
    /// Another entry whose seeds its episodes have, in place of its own: then episode 7 of both draws from the same seed.
    #[schemars(with = "Option<String>")]
    pub(super) seeds: Option<Spanned<String>>,
    /// Ends a campaign as soon as a requirement is decided or a number is known well enough.
    #[schemars(with = "Option<UntilText>")]
    pub(super) until: Option<Spanned<UntilText>>,
    /// Which recordings are kept.
    #[schemars(with = "Option<Keep>")]
    pub(super) keep: Option<Spanned<Keep>>,
    /// Whether an episode ends once all its verdicts are decided.
    #[schemars(with = "Option<bool>")]
    pub(super) early_end: Option<Spanned<bool>>,
    /// What happens to an episode whose program or simulator fails.
    #[schemars(with = "Option<OnFailure>")]
    pub(super) on_failure: Option<Spanned<OnFailure>>,
    /// Tables of counted trials. Experiments and operation.
    #[schemars(with = "Option<TablesText>")]
    pub(super) tables: Option<Spanned<TablesText>>,
    /// A folder of recordings that are judged by the study's monitors. Experiments and operation.
    #[schemars(with = "Option<PathBuf>")]
    pub(super) recordings: Option<Spanned<PathBuf>>,
    /// Why recordings of the same messages are trials of their own. Without it only what holds with all of them and with one of each
    /// is said.
    #[schemars(with = "Option<String>")]
    pub(super) repeated_recordings: Option<Spanned<String>>,
    /// The name of a technique that is not built in, which whoever runs the study brings; `technique` says as whose evidence
    /// its findings count.
    #[schemars(with = "Option<String>")]
    pub(super) producer: Option<Spanned<String>>,
    /// What such a technique is told, in its own words.
    #[schemars(with = "Option<BTreeMap<String, AnyValue>>")]
    pub(super) with: Option<Spanned<toml::Table>>,
}

#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TablesText {
    /// Attempts by subject: one row for each person or session.
    #[schemars(with = "Option<PathBuf>")]
    pub(super) cohort: Option<Spanned<PathBuf>>,
    /// Counts by requirement.
    #[schemars(with = "Option<PathBuf>")]
    pub(super) requirements: Option<Spanned<PathBuf>>,
    /// Counts by failure mode.
    #[schemars(with = "Option<PathBuf>")]
    pub(super) failure_modes: Option<Spanned<PathBuf>>,
    /// Why the one person or session of a cohort stands for all: without it, trials of one alone decide nothing of others.
    #[schemars(with = "Option<String>")]
    pub(super) one_for_all: Option<Spanned<String>>,
    /// A folder of JUnit XML, or one file: each run's test cases are trials of the requirements that their property `verifies` names.
    #[schemars(with = "Option<PathBuf>")]
    pub(super) junit: Option<Spanned<PathBuf>>,
    /// Episodes of a learned policy: LeRobot's `eval_info.json`, a folder of them, a dataset of LeRobot, a folder of them, or a table in
    /// CSV with a row for each. They are a cohort of clusters.
    #[schemars(with = "Option<PathBuf>")]
    pub(super) episodes: Option<Spanned<PathBuf>>,
    /// What makes episodes alike: `task`, `seed`, `checkpoint`, a column of the table, or `episode` if each stands by itself.
    #[schemars(with = "Option<String>")]
    pub(super) cluster: Option<Spanned<String>>,
    /// By requirement the test that verifies it, where test cases of `junit` do not say so.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, String>")]
    pub(super) tests: BTreeMap<String, Spanned<String>>,
}

/// A value that only the technique that takes it knows.
struct AnyValue;

impl JsonSchema for AnyValue {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "AnyValue".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        true.into()
    }
}

/// `"reason"`, or `{ E2 = "reason" }`.
#[derive(JsonSchema, Deserialize)]
#[serde(untagged)]
pub(super) enum IndependentText {
    OfAll(String),
    Of(BTreeMap<String, String>),
}

#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CalibratedText {
    /// The parameter of a simulator that was set, or the constant of a model that was solved for: with it the model has the
    /// counted rate, and is as uncertain as that.
    #[schemars(with = "Option<String>")]
    parameter: Option<Spanned<String>>,
    /// The constant of a model that was set.
    #[schemars(with = "Option<String>")]
    constant: Option<Spanned<String>>,
    /// Whether the uncertainty of the counts is left out: the constant is held at its value.
    #[serde(default)]
    held: bool,
    /// Whether the constant is 1 minus the rate.
    #[serde(default)]
    complement: bool,
    /// The evidence whose counts it was set to.
    #[schemars(with = "String")]
    from: Spanned<String>,
    /// The failure mode whose rate it is, or
    #[schemars(with = "Option<String>")]
    failure_mode: Option<Spanned<String>>,
    /// the requirement whose rate it is.
    #[schemars(with = "Option<String>")]
    requirement: Option<Spanned<String>>,
}

#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ChosenText {
    /// What was changed, in a few words.
    #[schemars(with = "String")]
    what: Spanned<String>,
    /// The evidence that agrees with it, which may stand later in the ledger.
    #[schemars(with = "String")]
    from: Spanned<String>,
    /// The failure mode on which it agrees, or
    #[schemars(with = "Option<String>")]
    failure_mode: Option<Spanned<String>>,
    /// the requirement on which it does.
    #[schemars(with = "Option<String>")]
    requirement: Option<Spanned<String>>,
}

/// The JSON Schema of `ledger.toml`.
pub(crate) fn schema() -> schemars::Schema {
    schemars::schema_for!(File)
}

/// Reads `ledger.toml`, if there is one, and checks it against the rest of the
/// study. Mistakes are added to those that were found; an entry whose work cannot be told is left out.
pub fn load(
    (folder, texts, reach): (&Path, &dyn Texts, &Reach),
    about: &About,
    forms: &Forms,
    found: &mut Problems,
) -> (Vec<Entry>, Source) {
    let path = folder.join("ledger.toml");
    let empty = || Source::new(path.display().to_string(), "");
    let source = if texts.exists(&path) {
        let source = found.keep(texts.text(&path));
        source.unwrap_or_else(empty)
    } else {
        empty()
    };
    let Some(file) = crate::toml_text::read_on::<File>(&source, found) else {
        return (Vec::new(), source);
    };
    let all: BTreeSet<String> = file
        .evidence
        .iter()
        .map(|e| e.id.get_ref().clone())
        .collect();
    let reader = Reader {
        folder,
        reach,
        source: &source,
        about,
        forms,
        all,
    };
    let mut seen = BTreeSet::new();
    let mut entries = Vec::new();
    let mut left_out = Vec::new();
    for (place, text) in file.evidence.into_iter().enumerate() {
        let id = text.id.get_ref().clone();
        if !seen.insert(id.clone()) {
            found.add(reader.problem(
                "duplicate-id",
                format!("the ledger has two entries `{id}`"),
                text.id.span(),
                "give each piece of evidence its own identifier",
            ));
        }
        match reader.entry(text, place, &seen, found) {
            Some(entry) => entries.push(entry),
            None => left_out.push(id),
        }
    }
    left_out.iter().for_each(|id| found.break_name(id));
    (entries, source)
}

pub(super) struct Reader<'a> {
    pub(super) folder: &'a Path,
    reach: &'a Reach,
    pub(super) source: &'a Source,
    about: &'a About,
    forms: &'a Forms,
    pub(super) all: BTreeSet<String>,
}

impl Reader<'_> {
    pub(super) fn problem(
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

    /// An entry whose mistakes are told; nothing where its work cannot be told.
    fn entry(
        &self,
        text: EntryText,
        place: usize,
        seen: &BTreeSet<String>,
        found: &mut Problems,
    ) -> Option<Entry> {
        if !is_file_name(text.id.get_ref()) {
            found.add(self.problem(
                "bad-id",
                format!(
                    "`id` must be letters, digits, `-` and `_` (got `{}`)",
                    text.id.get_ref()
                ),
                text.id.span(),
                "choose another; results are kept in files of that name",
            ));
        }
        found.keep(self.known_conditions(&text));
        if let Some(ours) = &text.reproduced_by
            && !self.all.contains(ours.get_ref())
        {
            found.add(self.unknown_evidence(ours));
        }
        let calibrated = text.calibrated.iter();
        let calibrated = calibrated
            .filter_map(|c| found.keep(self.calibrated(c, text.id.get_ref(), seen)))
            .collect();
        let chosen = text.chosen.iter();
        let chosen = chosen
            .filter_map(|it| found.keep(self.chosen(it, text.id.get_ref())))
            .collect();
        let independent = found.keep(self.independent(&text)).unwrap_or_default();
        let undecided_at_random = found.keep(self.undecided_at_random(&text)).flatten();
        let sampling = found.keep(self.sampling(&text)).unwrap_or_default();
        let work = found.keep(self.work(&text, place))?;
        found.keep(self.constants_have_a_model(&text, &work));
        Some(Entry {
            independent,
            undecided_at_random,
            work,
            sampling,
            calibrated,
            chosen,
            conditions: text.conditions.get_ref().clone(),
            id: text.id.into_inner(),
            title: text.title,
            changed: text.changed,
            intermediate: text.intermediate,
            reproduced_by: text.reproduced_by.map(Spanned::into_inner),
            published: text.published,
        })
    }

    fn known_conditions(&self, text: &EntryText) -> Result<(), Problem> {
        let conditions = text.conditions.get_ref();
        if self.about.conditions.contains_key(conditions) {
            return Ok(());
        }
        let known = self.about.conditions.keys().map(String::as_str);
        let remedy = match did_you_mean(conditions, known) {
            Some(similar) => format!("did you mean `{similar}`?"),
            None => "describe them under [conditions] in study.toml".to_owned(),
        };
        Err(self.problem(
            "unknown-conditions",
            format!("study.toml has no conditions `{conditions}`"),
            text.conditions.span(),
            &remedy,
        ))
    }

    /// Of what judges runs, the reason why those without a verdict are missing at random.
    fn undecided_at_random(&self, text: &EntryText) -> Result<Option<String>, Problem> {
        let Some(declared) = &text.undecided_at_random else {
            return Ok(None);
        };
        if text.episodes.is_none() && text.recordings.is_none() && text.producer.is_none() {
            return Err(self.problem(
                "bad-ledger",
                format!("`{}` judges no runs, so it has no undecided ones", text.id.get_ref()),
                declared.span(),
                "leave `undecided_at_random` out: it belongs to entries with `episodes` or `recordings`",
            ));
        }
        self.reason("undecided_at_random", &text.undecided_at_random)
    }

    /// Only a formal model has constants, and only a fault tree basic events, that can be set; whether it has these, and the numbers
    /// that were solved for (`parameter`), is seen when it is read.
    fn constants_have_a_model(&self, text: &EntryText, work: &Work) -> Result<(), Problem> {
        let id = text.id.get_ref();
        let mut found = Problems::new();
        let has_constants = work.model().or(work.tree()).is_some();
        for calibrated in &text.calibrated {
            match (&calibrated.constant, &calibrated.parameter) {
                (Some(constant), _) if !has_constants => found.add(self.problem(
                    "bad-calibration",
                    format!("`{id}` has no model, and so no constant `{}`", constant.get_ref()),
                    constant.span(),
                    "write `parameter = \"...\"` for a number that was set elsewhere than in a model",
                )),
                (Some(_) | None, _) => {}
            }
        }
        found.or(())
    }

    fn independent(&self, text: &EntryText) -> Result<Independent, Problem> {
        let Some(given) = &text.independent else {
            return Ok(Independent::default());
        };
        let independent = match given.get_ref() {
            IndependentText::OfAll(reason) => Independent {
                of_all: Some(reason.clone()),
                of: BTreeMap::new(),
            },
            IndependentText::Of(of) => Independent {
                of_all: None,
                of: of.clone(),
            },
        };
        let own = text.id.get_ref();
        // Its own name says that its trials are independent of each other.
        let is_known = |id: &&String| *id == own || self.all.contains(*id);
        let mut found = Problems::new();
        for unknown in independent.of.keys().filter(|id| !is_known(id)) {
            let place = crate::placed::key_in(self.source, &given.span(), unknown);
            let known = self.all.iter().map(String::as_str);
            let remedy = match did_you_mean(unknown, known) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => "name the evidence of which this is independent: `independent = { E2 = \"reason\" }`".to_owned(),
            };
            found.add(self.problem(
                "unknown-evidence",
                format!("`independent` names `{unknown}`, but the ledger has no such entry"),
                place.unwrap_or(given.span()),
                &remedy,
            ));
        }
        let mut reasons = independent.of.values().chain(&independent.of_all);
        if reasons.any(|reason| reason.trim().is_empty()) {
            found.add(self.problem(
                "no-reason",
                "`independent` gives no reason".into(),
                given.span(),
                "say where the numbers come from, for example `independent = { E2 = \"measured on another robot in 2019\" }`",
            ));
        }
        found.or(independent)
    }

    pub(super) fn unknown_evidence(&self, id: &Spanned<String>) -> Problem {
        let known = self.all.iter().map(String::as_str);
        let similar = did_you_mean(id.get_ref(), known.filter(|it| it != id.get_ref()));
        let is_later = self.all.contains(id.get_ref());
        let remedy = match similar.filter(|_| !is_later) {
            Some(similar) => format!("did you mean `{similar}`?"),
            None if is_later => "what calibrates another must stand before it".to_owned(),
            None => "name an entry of this ledger".to_owned(),
        };
        let before = if is_later { " before this one" } else { "" };
        self.problem(
            "unknown-evidence",
            format!("the ledger has no evidence `{}`{before}", id.get_ref()),
            id.span(),
            &remedy,
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
        let about = (&text.failure_mode, &text.requirement);
        let subject = self.counted_subject(&text.from, about)?;
        let parameter = match (&text.parameter, &text.constant) {
            (Some(parameter), None) => parameter.get_ref().clone(),
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
        if text.complement && text.constant.is_none() {
            return Err(self.problem(
                "bad-calibration",
                "only a `constant` of the model can be the complement of a rate".into(),
                text.from.span(),
                "leave `complement` out",
            ));
        }
        Ok(Calibrated {
            calibration: Calibration {
                parameter,
                from: text.from.get_ref().clone(),
                subject,
                chosen: false,
            },
            span: text
                .constant
                .as_ref()
                .map_or(text.from.span(), Spanned::span),
            constant: text.constant.as_ref().map(|c| c.get_ref().clone()),
            held: text.held,
            is_complement: text.complement,
        })
    }

    /// A change of a text that was chosen because evidence agrees with it. Nothing is computed from it, so that this evidence may stand
    /// later in the ledger.
    fn chosen(&self, text: &ChosenText, id: &str) -> Result<Calibration, Problem> {
        if text.from.get_ref() == id {
            return Err(self.problem(
                "unknown-evidence",
                format!("`chosen` of `{id}` names `{id}` itself"),
                text.from.span(),
                "name the other evidence, which agrees with what was chosen",
            ));
        }
        if !self.all.contains(text.from.get_ref()) {
            return Err(self.unknown_evidence(&text.from));
        }
        if text.what.get_ref().trim().is_empty() {
            return Err(self.problem(
                "no-reason",
                "`chosen` does not say what was changed".into(),
                text.what.span(),
                "say it in a few words, for example `what = \"the guard of `wait`\"`",
            ));
        }
        let about = (&text.failure_mode, &text.requirement);
        Ok(Calibration {
            parameter: text.what.get_ref().clone(),
            from: text.from.get_ref().clone(),
            subject: self.counted_subject(&text.from, about)?,
            chosen: true,
        })
    }

    /// The failure mode or requirement whose counts an entry names.
    fn counted_subject(
        &self,
        from: &Spanned<String>,
        about: (&Option<Spanned<String>>, &Option<Spanned<String>>),
    ) -> Result<Subject, Problem> {
        let (subject, named) = match about {
            (Some(mode), None) => (Subject::FailureMode(mode.get_ref().clone()), mode),
            (None, Some(requirement)) => (
                Subject::Requirement(requirement.get_ref().clone()),
                requirement,
            ),
            _ => {
                return Err(self.problem(
                    "bad-calibration",
                    "what was set or chosen for counts needs either a `failure_mode` or a `requirement`, and not both".into(),
                    from.span(),
                    "say which of its counts it was",
                ));
            }
        };
        if self.forms.of(&subject).is_none() {
            let kind = match &subject {
                Subject::Requirement(_) => "requirement",
                Subject::FailureMode(_) => "failure mode",
            };
            let like = |it: &&crate::SubjectForm| {
                std::mem::discriminant(&it.subject) == std::mem::discriminant(&subject)
            };
            let known = self.forms.subjects.iter().filter(like);
            let remedy = match did_you_mean(named.get_ref(), known.map(|it| it.subject.id())) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => format!("name a {kind} of requirements.toml"),
            };
            return Err(self.problem(
                "unknown-subject",
                format!("requirements.toml has no {kind} `{}`", named.get_ref()),
                named.span(),
                &remedy,
            ));
        }
        Ok(subject)
    }

    /// The requirement or failure mode of this identifier, which stands beside an event.
    pub(super) fn subject(&self, id: &str, beside: &Spanned<String>) -> Result<Subject, Problem> {
        let either = [
            Subject::Requirement(id.to_owned()),
            Subject::FailureMode(id.to_owned()),
        ];
        let known = either.into_iter().find(|it| self.forms.of(it).is_some());
        known.ok_or_else(|| {
            let ids = self.forms.subjects.iter().map(|form| form.subject.id());
            let remedy = match did_you_mean(id, ids) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => "name a requirement or a failure mode".to_owned(),
            };
            self.problem(
                "unknown-subject",
                format!("requirements.toml has neither a requirement nor a failure mode `{id}`"),
                beside.span(),
                &remedy,
            )
        })
    }

    pub(super) fn file(
        &self,
        text: &EntryText,
        what: &str,
        path: Option<&Spanned<PathBuf>>,
    ) -> Result<PathBuf, Problem> {
        match path {
            Some(path) => self.existing(path),
            None => Err(self.problem(
                "missing-entry",
                format!(
                    "missing field `{what}` of the evidence `{}`",
                    text.id.get_ref()
                ),
                text.id.span(),
                &format!("add `{what} = \"…\"`"),
            )),
        }
    }

    /// Whether a file or folder may be read, if it is there.
    pub(super) fn in_reach(&self, path: &Spanned<PathBuf>) -> Result<(), Problem> {
        match self.reach.refuses(&self.folder.join(path.get_ref())) {
            None => Ok(()),
            Some(why) => Err(self.problem(
                OUTSIDE,
                format!("{} is not opened: {why}", path.get_ref().display()),
                path.span(),
                REMEDY,
            )),
        }
    }

    pub(super) fn existing(&self, path: &Spanned<PathBuf>) -> Result<PathBuf, Problem> {
        self.in_reach(path)?;
        if self.folder.join(path.get_ref()).is_file() {
            return Ok(path.get_ref().clone());
        }
        Err(self.problem(
            "missing-file",
            match self.folder.join(path.get_ref()).exists() {
                true => format!("{} is not a file", path.get_ref().display()),
                false => format!("the study has no file {}", path.get_ref().display()),
            },
            path.span(),
            &self.similar_file(path.get_ref()),
        ))
    }
}

impl Reader<'_> {
    /// A file of the same folder whose name is like the one that is missing.
    fn similar_file(&self, path: &Path) -> String {
        let folder = path.parent().unwrap_or(Path::new(""));
        let files = std::fs::read_dir(self.folder.join(folder));
        let files = files.into_iter().flatten().flatten();
        let mut names: Vec<String> = files
            .filter(|file| file.path().is_file())
            .filter_map(|file| file.file_name().into_string().ok())
            .collect();
        names.sort();
        let name = path.file_name().and_then(std::ffi::OsStr::to_str);
        let similar = name.and_then(|name| did_you_mean(name, names.iter().map(String::as_str)));
        match similar {
            Some(similar) => format!("did you mean `{}`?", folder.join(similar).display()),
            None => "paths are relative to the study's folder".to_owned(),
        }
    }
}

fn is_file_name(id: &str) -> bool {
    !id.is_empty()
        && id.len() <= 64
        && id
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_')
}
