#![doc = include_str!("../README.md")]
//!
//! | file | holds |
//! |---|---|
//! | `study.toml` | title, summary, levels of confidence, conditions, seed, costs of trials, weights |
//! | `parameters.toml` | each distance, speed and time once, with its unit (may be missing) |
//! | `requirements.toml` | each requirement once, in all its forms; failure modes |
//! | `vocabulary.toml` | each proposition, bound to model, traces and tables |
//! | `ledger.toml` | the evidence, oldest first, with its assets and lineage (may be missing) |
//! | `looks.toml` | the counts by which it was judged so far; `run` writes it (may be missing) |
//! | `topics.toml` | where recordings have the signals (may be missing) |
//!
//! [`Study::load`] reads them, and reports every mistake that can be seen
//! without running anything.

mod finding;
mod judging_form;
mod ledger;
pub mod looks;
mod nearest;
mod parameters;
pub mod placed;
mod requirements;
pub mod schemas;
mod sentence_form;
mod texts;
mod toml_text;
mod vocabulary;
mod weighing;

pub use finding::{BenchFiles, Expected, Finding, Shows, UnknownStep};
pub use judging_form::{FormulaRule, JudgingForm, Rule, START_WITHIN_SECS, is_name};
pub use ledger::{
    Calibrated, Choice, CommandText, Entry, Keep, Method, OnFailure, Parts, PhysicsEngine,
    RecordingFiles, Simulated, TableFiles, TreeEvent, UntilText, Work,
};
pub use parameters::StudyParameters;
pub use requirements::{
    Background, FormText, Forms, ReadingForm, SubjectForm, TriggerForm, quoted_names, text_in_words,
};
pub use sentence_form::SentenceForm;
pub use texts::{Saved, Texts};
pub use toml_text::{place_of_unknown, read as read_toml, read_as};
pub use vocabulary::{Binding, Vocabulary};

use diagnostic::{Problem, Problems, Source};
use evidence::{ErrorFamily, FailureMode, Requirement, Step};
use host::{Reach, Trust};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The folders of a study that are written into.
const WRITTEN: [&str; 2] = ["results", "regressions"];

/// A loaded study.
#[derive(Debug)]
pub struct Study {
    /// The folder.
    pub folder: PathBuf,
    /// Which files it may read.
    pub reach: Reach,
    /// `study.toml`.
    pub about: About,
    /// The file that holds it.
    pub about_source: Source,
    /// The parameters.
    pub parameters: StudyParameters,
    /// What is required, in the order of the file.
    pub requirements: Vec<Requirement>,
    /// What can go wrong, in the order of the file.
    pub failure_modes: Vec<FailureMode>,
    /// How each of them is judged, requirements first.
    pub forms: Forms,
    /// The propositions.
    pub vocabulary: Vocabulary,
    /// The ledger's entries, oldest first.
    pub ledger: Vec<Entry>,
    /// The ledger's file, for diagnostics.
    pub ledger_source: Source,
    /// What one further trial of each piece of evidence costs.
    pub costs: evidence::TrialCosts,
    /// How much each piece of evidence counts where evidence is combined.
    pub weights: evidence::Weights,
    /// The looks so far; `None` if all sample sizes were fixed in advance.
    pub looks: Option<evidence::Looks>,
}

/// The content of `study.toml`.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct About {
    /// The study's title.
    pub title: String,
    /// What it is about, for a reader new to it.
    pub summary: String,
    /// The publication that it follows.
    #[serde(default)]
    pub source: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Level of all intervals.
    pub confidence: f64,
    /// Level at which agreement counts as shown, below 0.9998.
    pub agreement: f64,
    /// Conditions under which evidence holds, by name.
    #[serde(default)]
    pub conditions: BTreeMap<String, String>,
    /// What the numbers of the formal models mean.
    #[serde(default)]
    pub model: ModelUnits,
    /// Of what verdicts have to speak, and for what their error rates hold.
    #[serde(default)]
    pub verdicts: Verdicts,
    /// Whether trials may be added once the study was judged.
    #[serde(default)]
    pub sample_sizes: SampleSizes,
    /// What one further trial costs; without it every trial counts the same.
    costs: Option<weighing::CostsText>,
    /// How much a piece of evidence counts where evidence is combined; 1 unless declared.
    #[serde(default)]
    weights: BTreeMap<String, f64>,
}

/// The table `verdicts` of `study.toml`.
///
/// ```toml
/// [verdicts]
/// needs = "corroborated"     # or "model", "simulation", "system": the step that "satisfied" needs
/// error_rate = "study"       # or "requirement": for what the error rate of the verdicts holds
/// ```
#[derive(Debug, Default, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Verdicts {
    /// The step that requirements need which do not name their own.
    #[serde(default)]
    pub needs: Step,
    /// For what the error rates hold.
    #[serde(default)]
    pub error_rate: ErrorFamily,
}

/// Whether trials may be added once the study was judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SampleSizes {
    /// They may: tests allow for looks before and after, and looks are recorded.
    #[default]
    Growing,
    /// They were fixed before the first trial: each test has its whole level at the only look.
    Fixed,
}

/// What the numbers of the formal models mean.
#[derive(Debug, Default, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelUnits {
    /// The duration of one step, in continuous time of one unit of time, for example `0.1 s`.
    pub step: Option<String>,
    /// What one unit of a variable means, for example `0.1 s` of a timer.
    #[serde(default)]
    pub units: BTreeMap<String, String>,
}

impl About {
    /// What is read on with where the file cannot be read.
    fn unread() -> Self {
        Self {
            title: String::new(),
            summary: String::new(),
            source: String::new(),
            seed: 0,
            confidence: 0.95,
            agreement: 0.95,
            conditions: BTreeMap::new(),
            model: ModelUnits::default(),
            verdicts: Verdicts::default(),
            sample_sizes: SampleSizes::default(),
            costs: None,
            weights: BTreeMap::new(),
        }
    }
}

impl ModelUnits {
    /// The duration of a step or of a unit of continuous time in seconds; it was checked when the study was loaded.
    pub fn step_secs(&self) -> Option<f64> {
        quantity(self.step.as_deref()?).map(|step| step.si_value())
    }

    /// What one unit of a variable means.
    pub fn unit_of(&self, variable: &str) -> Option<trace::units::QuantityValue> {
        quantity(self.units.get(variable)?)
    }
}

/// A number with its unit.
fn quantity(text: &str) -> Option<trace::units::QuantityValue> {
    text.parse().ok()
}

impl Study {
    /// Loads the study in `folder`, which reads nothing outside of it.
    ///
    /// # Errors
    /// As [`Self::load_for`].
    pub fn load(folder: &Path) -> Result<Self, Problem> {
        Self::load_for(folder, &Trust::default())
    }

    /// Loads the study in `folder`, which reads there and where the user allows it.
    ///
    /// # Errors
    /// All mistakes of its files as one problem, in the order of files and lines; those that follow from others are left out.
    pub fn load_for(folder: &Path, trust: &Trust) -> Result<Self, Problem> {
        let mut found = Problems::new();
        let study = Self::read_for(folder, trust, &mut found)?;
        found.or(study)
    }

    /// Reads the study in `folder` behind its mistakes, which are added to those that were found. Where there are any, what is
    /// read has neutral values in their places, and is only good for looking further.
    ///
    /// # Errors
    /// `no-study` if there is none.
    pub fn read_for(folder: &Path, trust: &Trust, found: &mut Problems) -> Result<Self, Problem> {
        let reach = Reach::of(folder, trust);
        for written in WRITTEN {
            reach.check_written(&folder.join(written))?;
        }
        let saved = Saved(reach.clone());
        Self::read_in(folder, (&saved, reach), found)
    }

    /// The same of texts that need not be those in the folder: an editor's, which are not saved yet.
    ///
    /// # Errors
    /// `no-study` if there is none.
    pub fn read_texts(
        folder: &Path,
        texts: &dyn Texts,
        found: &mut Problems,
    ) -> Result<Self, Problem> {
        let reach = Reach::of(folder, &Trust::default());
        Self::read_in(folder, (texts, reach), found)
    }

    fn read_in(
        folder: &Path,
        (texts, reach): (&dyn Texts, Reach),
        found: &mut Problems,
    ) -> Result<Self, Problem> {
        if !folder.is_dir() {
            return Err(
                Problem::new("no-study", format!("{} is not a folder", folder.display()))
                    .remedy(nearest::remedy(folder))
                    .of_file(folder),
            );
        }
        let (about, about_source) = read_about(folder, texts, found)?;
        let parameters = StudyParameters::load(folder, texts, found);
        let vocabulary = Vocabulary::load(folder, texts, &parameters, found);
        let (mut requirements, failure_modes, forms) =
            requirements::load((folder, texts), &vocabulary, &parameters, &about, found);
        let (ledger, ledger_source) = ledger::load((folder, texts, &reach), &about, &forms, found);
        forms.complete_carried(&mut requirements, &ledger, found);
        let costs = weighing::trial_costs(&about, &ledger, &about_source);
        let costs = found
            .keep(costs)
            .unwrap_or_else(evidence::TrialCosts::equal);
        let weights = weighing::weights(&about, &ledger, &about_source);
        let weights = found.keep(weights).unwrap_or_default();
        let looks = found.keep(looks::load(folder, texts, &about)).flatten();
        Ok(Self {
            folder: folder.to_owned(),
            reach,
            costs,
            weights,
            looks,
            about,
            about_source,
            parameters,
            requirements,
            failure_modes,
            forms,
            vocabulary,
            ledger,
            ledger_source,
        })
    }

    /// The study as its files are now, with the same reach.
    ///
    /// # Errors
    /// As [`Self::load_for`].
    pub fn again(&self) -> Result<Self, Problem> {
        let mut found = Problems::new();
        let saved = Saved(self.reach.clone());
        let study = Self::read_in(&self.folder, (&saved, self.reach.clone()), &mut found)?;
        found.or(study)
    }

    /// The difference of two rates that counts as agreement on a requirement or failure mode.
    pub fn margin(&self, subject: &evidence::Subject) -> f64 {
        evidence::margin_of(&self.requirements, &self.failure_modes, subject)
    }

    /// The ledger entry with this identifier.
    pub fn entry(&self, id: &str) -> Result<&Entry, Problem> {
        self.ledger.iter().find(|e| e.id == id).ok_or_else(|| {
            let known: Vec<&str> = self.ledger.iter().map(|e| e.id.as_str()).collect();
            Problem::new(
                "unknown-evidence",
                format!("the ledger has no evidence `{id}`"),
            )
            .remedy(format!("it has {}", known.join(", ")))
        })
    }
}

/// Its mistakes are added to those that were found; values that are wrong are replaced.
fn read_about(
    folder: &Path,
    texts: &dyn Texts,
    found: &mut Problems,
) -> Result<(About, Source), Problem> {
    let path = folder.join("study.toml");
    if !texts.exists(&path) {
        return Err(Problem::new(
            "no-study",
            format!("not a study: {} does not exist", path.display()),
        )
        .remedy(nearest::remedy_within(folder))
        .of_file(&path));
    }
    let source = texts.text(&path)?;
    let mut own = Problems::new();
    let about: Option<About> = toml_text::read_on(&source, &mut own);
    let mut about = about.unwrap_or_else(About::unread);
    // Conditions may stand under a name that could not be read.
    if !own.is_empty() && about.conditions.is_empty() {
        found.lose_names();
    }
    found.join(own);
    for (name, level, most) in [
        ("confidence", &mut about.confidence, 1.0),
        ("agreement", &mut about.agreement, MOST_AGREEMENT),
    ] {
        if !(*level > 0.5 && *level < most) {
            found.add(
                Problem::new(
                    "bad-level",
                    format!("`{name}` must be between 0.5 and {most} (got {level})"),
                )
                .at(&source, placed::value_place(&source, &[name]))
                .remedy("write a level of confidence, for example 0.95"),
            );
            *level = 0.95;
        }
    }
    check_model_units(&about.model, &source, found);
    Ok((about, source))
}

/// No counts show agreement at a higher level: the test confines the rates to intervals that miss them with a probability of 1e-4, which
/// counts for no agreement, and a quarter of that again where trials may be added.
const MOST_AGREEMENT: f64 = 0.9998;

fn check_model_units(model: &ModelUnits, source: &Source, found: &mut Problems) {
    let bad = |path: &[&str], what: String| {
        Problem::new("bad-unit", what)
            .at(source, placed::value_place(source, path))
            .remedy("write for example \"0.1 s\"")
    };
    if let Some(text) = &model.step {
        let step = quantity(text).filter(|step| {
            step.dimension() == trace::units::Dimension::TIME && step.si_value() > 0.0
        });
        if step.is_none() {
            let what = format!("`step` must be a time of more than 0 with its unit (got `{text}`)");
            found.add(bad(&["model", "step"], what));
        }
    }
    for (variable, text) in &model.units {
        if quantity(text).is_none_or(|unit| unit.unit().is_none()) {
            let what =
                format!("the unit of `{variable}` must be a number with a unit (got `{text}`)");
            found.add(bad(&["model", "units", variable], what));
        }
    }
}
