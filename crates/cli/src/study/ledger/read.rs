//! Reads `ledger.toml` and holds it against the rest of the study.

use super::{Calibrated, Entry, Independent, Keep, Method, OnFailure, Published, UntilText};
use crate::problem::{Problem, Source};
use crate::study::{About, Forms};
use evidence::{Calibration, Subject};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    evidence: Vec<EntryText>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EntryText {
    pub(super) id: Spanned<String>,
    pub(super) title: String,
    pub(super) technique: Spanned<evidence::Technique>,
    pub(super) conditions: Spanned<String>,
    pub(super) changed: String,
    #[serde(default)]
    pub(super) intermediate: bool,
    pub(super) reproduced_by: Option<Spanned<String>>,
    #[serde(default)]
    pub(super) calibrated: Vec<CalibratedText>,
    pub(super) independent: Option<Spanned<IndependentText>>,
    #[serde(default)]
    pub(super) published: Published,
    pub(super) model: Option<Spanned<PathBuf>>,
    pub(super) methods: Option<Spanned<Vec<Method>>>,
    pub(super) scenario: Option<Spanned<PathBuf>>,
    pub(super) parameters: Option<Spanned<PathBuf>>,
    pub(super) scene: Option<Spanned<PathBuf>>,
    pub(super) test: Option<Spanned<String>>,
    pub(super) episodes: Option<Spanned<u64>>,
    pub(super) command: Option<Spanned<Vec<String>>>,
    pub(super) assets: Option<Vec<Spanned<PathBuf>>>,
    pub(super) stimulus: Option<Spanned<PathBuf>>,
    pub(super) leaves: Option<Spanned<String>>,
    pub(super) limit_secs: Option<Spanned<f64>>,
    pub(super) until: Option<Spanned<UntilText>>,
    pub(super) keep: Option<Spanned<Keep>>,
    pub(super) early_end: Option<Spanned<bool>>,
    pub(super) on_failure: Option<Spanned<OnFailure>>,
    pub(super) tables: Option<Spanned<TablesText>>,
    pub(super) recordings: Option<Spanned<PathBuf>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TablesText {
    pub(super) cohort: Option<Spanned<PathBuf>>,
    pub(super) requirements: Option<Spanned<PathBuf>>,
    pub(super) failure_modes: Option<Spanned<PathBuf>>,
}

/// `"reason"`, or `{ E2 = "reason" }`.
#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum IndependentText {
    OfAll(String),
    Of(BTreeMap<String, String>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CalibratedText {
    parameter: Option<String>,
    constant: Option<Spanned<String>>,
    #[serde(default)]
    held: bool,
    #[serde(default)]
    complement: bool,
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

pub(super) struct Reader<'a> {
    pub(super) folder: &'a Path,
    source: &'a Source,
    about: &'a About,
    forms: &'a Forms,
    all: BTreeSet<String>,
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
        let independent = self.independent(&text)?;
        Ok(Entry {
            independent,
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
        let is_other = |id: &&String| *id != own && self.all.contains(*id);
        if let Some(unknown) = independent.of.keys().find(|id| !is_other(id)) {
            return Err(self.problem(
                "unknown-evidence",
                format!("`independent` names `{unknown}`, which is no other entry of the ledger"),
                given.span(),
                "name the evidence of which this is independent: `independent = { E2 = \"reason\" }`",
            ));
        }
        let mut reasons = independent.of.values().chain(&independent.of_all);
        if reasons.any(|reason| reason.trim().is_empty()) {
            return Err(self.problem(
                "no-reason",
                "`independent` gives no reason".into(),
                given.span(),
                "say where the numbers come from, for example `independent = { E2 = \"measured on another robot in 2019\" }`",
            ));
        }
        Ok(independent)
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
                format!("the evidence `{}` names no `{what}`", text.id.get_ref()),
                text.id.span(),
                &format!("add `{what} = \"…\"`"),
            )),
        }
    }

    pub(super) fn existing(&self, path: &Spanned<PathBuf>) -> Result<PathBuf, Problem> {
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
