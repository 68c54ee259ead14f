//! A study: a folder of plain files that says what is required of a system,
//! what its words mean, and which evidence is to be produced.
//!
//! | file | holds |
//! |---|---|
//! | `study.toml` | title, summary, levels of confidence, conditions, seed |
//! | `requirements.toml` | each requirement once, in all its forms; failure modes |
//! | `vocabulary.toml` | each proposition, bound to model, traces and tables |
//! | `ledger.toml` | the evidence, oldest first, with its assets and lineage |
//!
//! [`Study::load`] reads all four, and reports every mistake that can be seen
//! without running anything.

mod ledger;
mod requirements;
mod vocabulary;

pub use ledger::{Entry, Method, Work};
pub use requirements::{FormText, Forms, SubjectForm, quoted_names};
pub use vocabulary::Vocabulary;

use crate::problem::{Problem, Source};
use evidence::{FailureMode, Requirement};
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
}

/// The content of `study.toml`.
#[derive(Debug, Deserialize)]
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
        let vocabulary = Vocabulary::load(folder)?;
        let (requirements, failure_modes, forms) = requirements::load(folder, &vocabulary)?;
        let (ledger, ledger_source) = ledger::load(folder, &about, &forms)?;
        Ok(Self {
            folder: folder.to_owned(),
            about,
            about_source,
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
    let source = Source::read(&path)?;
    let about: About =
        toml::from_str(&source.text).map_err(|error| Problem::from_toml(&source, &error))?;
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
    Ok((about, source))
}
