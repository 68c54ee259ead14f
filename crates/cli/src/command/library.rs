//! `corroborate requirements --library`: ready requirements, as templates.

use super::{Done, json};
use crate::args::Format;
use corroborate::outcome::Outcome;
use diagnostic::Problem;
use requirement_lang::library::{Template, templates};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;

/// What `requirements --library --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct LibraryReport {
    /// Version of this form.
    pub format: String,
    /// The templates.
    pub templates: Vec<TemplateShown>,
}

/// A requirement whose parameters are still to be declared.
#[derive(Debug, Serialize, JsonSchema)]
pub struct TemplateShown {
    /// What `template = "…"` in requirements.toml names.
    pub id: String,
    /// A short title.
    pub title: String,
    /// The standard in whose sense it is written.
    pub standard: String,
    /// What it is for.
    pub notes: String,
    /// The sentence.
    pub sentence: String,
    /// What parameters.toml has to declare.
    pub parameters: Vec<ParameterShown>,
    /// What vocabulary.toml has to bind.
    pub needs: Vec<NeedShown>,
}

/// A parameter of a template.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ParameterShown {
    /// Its name.
    pub name: String,
    /// The value to begin with, if there is one.
    pub default: Option<String>,
    /// The least value allowed.
    pub least: String,
    /// The greatest value allowed.
    pub most: String,
    /// What it is.
    pub meaning: String,
}

/// A proposition or quantity of a template.
#[derive(Debug, Serialize, JsonSchema)]
pub struct NeedShown {
    /// Its name.
    pub name: String,
    /// The unit of a quantity; `None` for a proposition.
    pub unit: Option<String>,
    /// In which frame it is measured, where that matters.
    pub frame: Option<String>,
    /// What it is.
    pub meaning: String,
}

/// Lists the templates.
pub fn library(format: Format) -> Result<Done, Problem> {
    let report = LibraryReport {
        format: "1.0".into(),
        templates: templates().map(shown).collect(),
    };
    let output = match format {
        Format::Json => json(&report)?,
        Format::Text => text(&report),
    };
    Ok(Done {
        output,
        outcome: Outcome::Holds,
    })
}

fn shown(template: &Template) -> TemplateShown {
    let owned = |text: Option<&str>| text.map(str::to_owned);
    TemplateShown {
        id: template.id.into(),
        title: template.title.into(),
        standard: template.standard.into(),
        notes: template.notes.into(),
        sentence: template.sentence.into(),
        parameters: template
            .parameters
            .iter()
            .map(|parameter| ParameterShown {
                name: parameter.name.into(),
                default: owned(parameter.default),
                least: parameter.least.into(),
                most: parameter.most.into(),
                meaning: parameter.meaning.into(),
            })
            .collect(),
        needs: template
            .needs
            .iter()
            .map(|need| NeedShown {
                name: need.name.into(),
                unit: owned(need.unit),
                frame: owned(need.frame),
                meaning: need.meaning.into(),
            })
            .collect(),
    }
}

fn text(report: &LibraryReport) -> String {
    let mut out = String::new();
    for template in &report.templates {
        // Writing to a String cannot fail.
        let _ = writeln!(
            out,
            "{}\n  {} ({})\n  {}",
            template.id, template.title, template.standard, template.sentence
        );
        for parameter in &template.parameters {
            let value = parameter.default.as_deref().unwrap_or("to be given");
            let _ = writeln!(
                out,
                "    {} = {value} ({} to {}): {}",
                parameter.name, parameter.least, parameter.most, parameter.meaning
            );
        }
        for need in &template.needs {
            let unit = need
                .unit
                .as_ref()
                .map_or(String::new(), |u| format!(" [{u}]"));
            let frame = need
                .frame
                .as_ref()
                .map_or(String::new(), |f| format!(", in {f}"));
            let _ = writeln!(
                out,
                "    binds {}{unit}{frame}: {}",
                need.name, need.meaning
            );
        }
        out.push('\n');
    }
    out.push_str(
        "Use one with `template = \"ID\"` in requirements.toml; declare its parameters in \
         parameters.toml and bind its names in vocabulary.toml.\n",
    );
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(LibraryReport).into();
        crate::command::tests::assert_schema_is_committed("library.schema.json", &schema);
    }
}
