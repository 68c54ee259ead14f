//! The files of variants: `variants/*.toml` of a study.

use diagnostic::{Problem, Source};
use evidence::Subject;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use stimulus::Settings;
use study::{Entry, Study, Work};
use toml::Spanned;

/// What is wrong with such a file.
pub const CODE: &str = "bad-variant";

/// A variant.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variant {
    /// Its name.
    pub name: String,
    /// What would be different.
    pub meaning: String,
    /// The requirements and failure modes that are looked at.
    #[schemars(with = "Vec<String>")]
    pub subjects: Vec<Spanned<String>>,
    /// What it means to each piece of evidence.
    #[serde(rename = "change")]
    pub changes: Vec<ChangeText>,
}

/// What a variant means to one piece of evidence.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChangeText {
    /// The evidence.
    #[schemars(with = "String")]
    pub evidence: Spanned<String>,
    /// New definitions of a model's constants, over the values that they have.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, String>")]
    pub constants: BTreeMap<String, Spanned<String>>,
    /// New values in a simulation's data: `scenario.…` or `parameters.…` of the handover, any of a scene's, what the
    /// stimulus of a command sets.
    #[serde(default)]
    pub settings: Settings,
    /// Why it cannot be expressed there.
    pub cannot: Option<String>,
    /// What is taken for granted.
    pub assumes: Option<String>,
}

/// A variant with its file.
#[derive(Debug)]
pub struct Read {
    /// The variant.
    pub variant: Variant,
    /// Its file.
    pub source: Source,
}

/// All variants of a study, by their files' names.
pub fn variants(study: &Study) -> Result<Vec<Read>, Problem> {
    let folder = study.folder.join("variants");
    let entries = std::fs::read_dir(&folder).map(|entries| {
        let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
        paths
            .filter(|path| path.extension().is_some_and(|it| it == "toml"))
            .collect::<Vec<PathBuf>>()
    });
    let mut files = entries.unwrap_or_default();
    files.sort();
    if files.is_empty() {
        return Err(Problem::new(
            "no-variants",
            format!("{} has no variants", study.folder.display()),
        )
        .remedy("write one as `variants/NAME.toml`: see `corroborate explain bad-variant`"));
    }
    files.iter().map(|file| read(study, file)).collect()
}

fn read(study: &Study, file: &std::path::Path) -> Result<Read, Problem> {
    study.reach.check(file)?;
    let source = host::files::read_source(file)?;
    let variant: Variant = study::read_toml(CODE, &source)?;
    for subject in &variant.subjects {
        subject_of(study, &source, subject)?;
    }
    for change in &variant.changes {
        let entry = study
            .entry(change.evidence.get_ref())
            .map_err(|problem| problem.at(&source, change.evidence.span()))?;
        fits(&source, change, entry)?;
    }
    Ok(Read { variant, source })
}

/// The requirement or failure mode that a variant names.
pub fn subject_of(
    study: &Study,
    source: &Source,
    id: &Spanned<String>,
) -> Result<Subject, Problem> {
    let form = study.forms.by_id(id.get_ref());
    form.map(|form| form.subject.clone()).ok_or_else(|| {
        let message = format!(
            "the study has no requirement or failure mode `{}`",
            id.get_ref()
        );
        Problem::new(CODE, message)
            .at(source, id.span())
            .remedy("name one of requirements.toml")
    })
}

/// Whether episodes of it can be run as often as wanted; a rig moves, so it is not run for a prediction.
pub fn is_simulated(work: &Work) -> bool {
    work.simulated().is_some() && work.technique().is_of_simulator()
}

/// A change has to be one that its evidence can have.
fn fits(source: &Source, change: &ChangeText, entry: &Entry) -> Result<(), Problem> {
    let parts = (
        change.cannot.is_some(),
        !change.constants.is_empty(),
        !change.settings.is_empty(),
    );
    let is_checked = entry.work.model().is_some();
    let remedy = match parts {
        (true, false, false) => return Ok(()),
        (false, true, false) if is_checked => return Ok(()),
        (false, false, true) if is_simulated(&entry.work) => return Ok(()),
        _ if is_checked => "give `constants` of the model, or say in `cannot` why not",
        _ if is_simulated(&entry.work) => "give `settings`, or say in `cannot` why not",
        _ => "say in `cannot` why it is not tried there",
    };
    let message = format!("the change of {} cannot be made there", entry.id);
    Err(Problem::new(CODE, message)
        .at(source, change.evidence.span())
        .remedy(remedy))
}
