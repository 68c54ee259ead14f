//! The parameters: each distance, speed and time once, with its unit.
//!
//! `parameters.toml` may be missing; then there are none. Requirements, the
//! vocabulary and hand-written formulas use the names, so that a changed
//! number changes everywhere.

use crate::Texts;
use diagnostic::{Problem, Problems};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

/// The file's name within a study.
const FILE: &str = "parameters.toml";

/// One declared parameter.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// The value with its unit, as it is written.
    pub text: String,
    /// What it limits or means, in words.
    pub meaning: String,
    /// The place of its value in the file.
    pub span: Range<usize>,
}

/// All parameters of a study.
#[derive(Clone, Debug, Default)]
pub struct StudyParameters {
    /// The declarations, by name.
    pub declared: BTreeMap<String, Parameter>,
    /// Their values.
    pub values: trace::Parameters,
}

#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
struct ParameterText {
    /// A number with its unit, for example `"250 mm/s"`.
    #[schemars(with = "String")]
    value: Spanned<String>,
    /// What it limits or means, in words.
    meaning: String,
}

/// The JSON Schema of `parameters.toml`.
pub(crate) fn schema() -> schemars::Schema {
    schemars::schema_for!(BTreeMap<String, ParameterText>)
}

impl StudyParameters {
    /// Reads `parameters.toml`, if there is one. Mistakes are added to those that were found, and what has one gets no value.
    pub fn load(folder: &Path, texts: &dyn Texts, found: &mut Problems) -> Self {
        let path = folder.join(FILE);
        if !texts.exists(&path) {
            return Self::default();
        }
        let Some(source) = found.keep(texts.text(&path)) else {
            found.lose_names();
            return Self::default();
        };
        let texts = crate::toml_text::read_on(&source, found);
        let texts: BTreeMap<String, ParameterText> = texts.unwrap_or_default();
        let declared: BTreeMap<String, Parameter> = texts
            .into_iter()
            .map(|(name, text)| {
                let span = text.value.span();
                let parameter = Parameter {
                    text: text.value.into_inner(),
                    meaning: text.meaning,
                    span: span.start + 1..span.end.saturating_sub(1).max(span.start + 1),
                };
                (name, parameter)
            })
            .collect();
        let mut values = trace::Parameters::default();
        let mut entries: BTreeMap<&str, &str> = BTreeMap::new();
        entries.extend(
            declared
                .iter()
                .map(|(name, it)| (name.as_str(), it.text.as_str())),
        );
        let of = |entries: &BTreeMap<&str, &str>| {
            trace::Parameters::new(entries.iter().map(|(name, text)| (*name, *text)))
        };
        match of(&entries) {
            Ok(all) => values = all,
            Err(errors) => {
                for error in errors {
                    entries.remove(error.name.as_str());
                    let problem = Problem::new("bad-parameter", error.to_string())
                        .remedy("write a number with its unit, for example \"250 mm/s\"");
                    found.add(match declared.get(&error.name) {
                        Some(parameter) => problem.at(&source, parameter.span.clone()),
                        None => problem,
                    });
                    found.break_name(&error.name);
                }
                values = of(&entries).unwrap_or(values);
            }
        }
        Self { declared, values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn saved(folder: &Path) -> crate::Saved {
        crate::Saved(host::Reach::of(folder, &host::Trust::default()))
    }

    fn load(text: &str) -> Result<StudyParameters, Problem> {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join(FILE), text).expect("written");
        let mut found = Problems::new();
        let parameters = StudyParameters::load(folder.path(), &saved(folder.path()), &mut found);
        found.or(parameters)
    }

    #[test]
    fn values_have_units() {
        let parameters =
            load("[near]\nvalue = \"10 cm\"\nmeaning = \"near\"\n").expect("parameters");
        let near = parameters.values.get("near").expect("declared");
        assert_eq!(near.si_value(), 0.1);
        assert_eq!(parameters.declared["near"].meaning, "near");
    }

    #[test]
    fn a_value_that_is_no_quantity_is_shown_in_its_place() {
        let problem = load("[near]\nvalue = \"10 cats\"\nmeaning = \"near\"\n").unwrap_err();
        let shown = problem.to_string();
        assert!(shown.contains("parameters.toml:2"), "{shown}");
    }

    #[test]
    fn a_study_without_the_file_has_none() {
        let folder = tempfile::tempdir().expect("a folder");
        let parameters =
            StudyParameters::load(folder.path(), &saved(folder.path()), &mut Problems::new());
        assert!(parameters.declared.is_empty());
    }
}
