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
mod parameters;
pub mod placed;
mod requirements;
pub mod schemas;
mod sentence_form;
mod toml_text;
mod vocabulary;
mod weighing;

pub use finding::{BenchFiles, Expected, Finding, Shows, UnknownStep};
pub use judging_form::{FormulaRule, JudgingForm, Rule, START_WITHIN_SECS, is_name};
pub use ledger::{
    Calibrated, Choice, CommandText, Entry, Keep, Method, OnFailure, Parts, RecordingFiles,
    Simulated, TableFiles, TreeEvent, UntilText, Work,
};
pub use parameters::StudyParameters;
pub use requirements::{
    FormText, Forms, ReadingForm, SubjectForm, TriggerForm, quoted_names, text_in_words,
};
pub use sentence_form::SentenceForm;
pub use toml_text::place_of_unknown;
pub use vocabulary::{Binding, Vocabulary};

use diagnostic::{Problem, Source};
use evidence::{ErrorFamily, FailureMode, Requirement, Step};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A loaded study.
#[derive(Debug)]
pub struct Study {
    /// The folder.
    pub folder: PathBuf,
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
    /// Level at which agreement counts as shown.
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
    /// Loads the study in `folder`.
    pub fn load(folder: &Path) -> Result<Self, Problem> {
        if !folder.is_dir() {
            return Err(
                Problem::new("no-study", format!("{} is not a folder", folder.display()))
                    .remedy("name a study's folder, or make one with `corroborate init FOLDER`"),
            );
        }
        let (about, about_source) = read_about(folder)?;
        let parameters = StudyParameters::load(folder)?;
        let vocabulary = Vocabulary::load(folder, &parameters)?;
        let (mut requirements, failure_modes, forms) =
            requirements::load(folder, &vocabulary, &parameters, &about)?;
        let (ledger, ledger_source) = ledger::load(folder, &about, &forms)?;
        forms.complete_carried(&mut requirements, &ledger)?;
        let costs = weighing::trial_costs(&about, &ledger, &about_source)?;
        let weights = weighing::weights(&about, &ledger, &about_source)?;
        let looks = looks::load(folder, &about)?;
        Ok(Self {
            folder: folder.to_owned(),
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

fn read_about(folder: &Path) -> Result<(About, Source), Problem> {
    let path = folder.join("study.toml");
    if !path.exists() {
        return Err(Problem::new(
            "no-study",
            format!("{} has no study.toml, so it is no study", folder.display()),
        )
        .remedy("make a study with `corroborate init FOLDER`"));
    }
    let source = host::files::read_source(&path)?;
    let about: About = toml_text::read(&source)?;
    for (name, level) in [
        ("confidence", about.confidence),
        ("agreement", about.agreement),
    ] {
        if !(level > 0.5 && level < 1.0) {
            let place = source.text.find(name).unwrap_or(0);
            return Err(Problem::new(
                "bad-level",
                format!("`{name}` is {level}, which is no level of confidence"),
            )
            .at(&source, place..place + name.len())
            .remedy("choose a level between 0.5 and 1, for example 0.95"));
        }
    }
    check_model_units(&about.model, &source)?;
    Ok((about, source))
}

fn check_model_units(model: &ModelUnits, source: &Source) -> Result<(), Problem> {
    let bad = |text: &str, what: String, example: &str| {
        let place = source.text.find(text).unwrap_or(0);
        Problem::new("bad-unit", what)
            .at(source, place..place + text.len())
            .remedy(format!("write for example \"{example}\""))
    };
    if let Some(text) = &model.step {
        let step = quantity(text).filter(|step| {
            step.dimension() == trace::units::Dimension::TIME && step.si_value() > 0.0
        });
        if step.is_none() {
            return Err(bad(
                text,
                format!("`{text}` is no duration of a step"),
                "0.1 s",
            ));
        }
    }
    for (variable, text) in &model.units {
        if quantity(text).is_none_or(|unit| unit.unit().is_none()) {
            let what = format!("`{text}` is no unit of the variable `{variable}`");
            return Err(bad(text, what, "0.1 s"));
        }
    }
    Ok(())
}
