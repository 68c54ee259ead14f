//! Ready requirements, as templates.

use requirement_lang::library::{Template, templates};
use schemars::JsonSchema;
use serde::Serialize;

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
pub fn library() -> LibraryReport {
    LibraryReport {
        format: "1.0".into(),
        templates: templates().map(shown).collect(),
    }
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
