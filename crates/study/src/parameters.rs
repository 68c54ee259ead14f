//! The parameters: each distance, speed and time once, with its unit.
//!
//! `parameters.toml` may be missing; then there are none. Requirements, the
//! vocabulary and hand-written formulas use the names, so that a changed
//! number changes everywhere.

use diagnostic::Problem;
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
    /// Reads `parameters.toml`, if there is one.
    pub fn load(folder: &Path) -> Result<Self, Problem> {
        let path = folder.join(FILE);
        if !path.exists() {
            return Ok(Self::default());
        }
        let source = host::files::read_source(&path)?;
        let texts: BTreeMap<String, ParameterText> = crate::toml_text::read(&source)?;
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
        let entries = declared.iter().map(|(name, p)| (name.clone(), &p.text));
        let values = trace::Parameters::new(entries).map_err(|errors| {
            let first = errors.into_iter().next();
            let (name, message) =
                first.map_or_else(Default::default, |e| (e.name.clone(), e.to_string()));
            let problem = Problem::new("bad-parameter", message)
                .remedy("write a number with its unit, for example \"250 mm/s\"");
            match declared.get(&name) {
                Some(parameter) => problem.at(&source, parameter.span.clone()),
                None => problem,
            }
        })?;
        Ok(Self { declared, values })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(text: &str) -> Result<StudyParameters, Problem> {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join(FILE), text).expect("written");
        StudyParameters::load(folder.path())
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
        let parameters = StudyParameters::load(folder.path()).expect("none");
        assert!(parameters.declared.is_empty());
    }
}
