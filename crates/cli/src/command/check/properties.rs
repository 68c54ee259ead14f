//! The properties of a command line and of its file.
//!
//! A property that means nothing over the model does not keep the others from being checked: it gets an error of
//! its own. If none is left, the mistakes end the command.

use super::form::{PropertyReport, wrong_report};
use crate::args::Check;
use crate::problem::{Problem, Source};
use crate::study::Method;
use prism_lang::ast::PropertyFile;
use prism_lang::{Constants, Diagnostics, NamedProperty, resolved};
use std::path::Path;

/// A property that was asked for.
pub(super) enum Asked {
    Property(Box<NamedProperty>),
    Wrong(Wrong),
}

/// A property that means nothing over the model.
pub(super) struct Wrong {
    pub name: Option<String>,
    pub text: String,
    pub message: String,
    pub unsupported: bool,
}

impl Asked {
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Property(property) => property.name.as_deref(),
            Self::Wrong(wrong) => wrong.name.as_deref(),
        }
    }
}

/// A text of properties.
pub(super) struct Text {
    pub source: Source,
    pub tree: PropertyFile,
}

/// Reads the texts of all properties that were asked for.
pub(super) fn read(arguments: &Check) -> Result<Vec<Text>, Problem> {
    let mut sources = Vec::new();
    if let Some(argument) = &arguments.properties {
        let looks_like_file = Path::new(argument).exists()
            || [".props", ".pctl", ".csl", ".prop", ".ltl"]
                .iter()
                .any(|e| argument.ends_with(e));
        sources.push(if looks_like_file {
            Source::read(Path::new(argument))?
        } else {
            given_property(argument)
        });
    }
    let given = arguments.property_texts.iter();
    sources.extend(given.map(|text| given_property(text)));
    let parsed = |source: Source| {
        let parsed = prism_lang::parse_properties(&source.text);
        match Problem::from_diagnostics(&source, &parsed.diagnostics) {
            Some(problem) => Err(problem),
            None => Ok(Text {
                source,
                tree: parsed.tree,
            }),
        }
    };
    sources.into_iter().map(parsed).collect()
}

/// All properties that were asked for, in order.
pub(super) fn resolved(
    texts: &[Text],
    model: &resolved::Model,
    given: &Constants,
) -> Result<Vec<Asked>, Problem> {
    let mut all = Vec::new();
    for text in texts {
        all.extend(resolve(&text.source, text.tree.clone(), model, given)?);
    }
    Ok(all)
}

/// The same, read again.
pub(super) fn properties(
    arguments: &Check,
    model: &resolved::Model,
    given: &Constants,
) -> Result<Vec<Asked>, Problem> {
    resolved(&read(arguments)?, model, given)
}

/// The properties, none of which can be checked.
pub(super) fn failed(texts: &[Text], method: Method, problem: &Problem) -> Vec<PropertyReport> {
    let all = texts.iter().flat_map(|text| &text.tree.properties);
    all.enumerate()
        .map(|(place, property)| {
            let wrong = Wrong {
                name: property.name.as_ref().map(|name| name.text.clone()),
                text: property.text.clone(),
                message: problem.line(),
                unsupported: problem.code == "unsupported",
            };
            wrong_report(place + 1, &wrong, method)
        })
        .collect()
}

/// The properties of a text, those with mistakes set apart.
fn resolve(
    source: &Source,
    mut tree: PropertyFile,
    model: &resolved::Model,
    given: &Constants,
) -> Result<Vec<Asked>, Problem> {
    let mut all: Vec<Option<Asked>> = tree.properties.iter().map(|_| None).collect();
    let mut places: Vec<usize> = (0..all.len()).collect();
    let mut first: Option<Diagnostics> = None;
    loop {
        let found = match prism_lang::resolve_properties(&tree, model, given) {
            Ok(resolved) if resolved.is_empty() && first.is_some() => Vec::new().into(),
            Ok(resolved) => {
                for (place, property) in places.iter().zip(resolved) {
                    all[*place] = Some(Asked::Property(Box::new(property)));
                }
                return Ok(all.into_iter().flatten().collect());
            }
            Err(found) => found,
        };
        let wrong = found.iter().find_map(|mistake| {
            let holds = |p: &prism_lang::ast::Property| {
                p.span.start <= mistake.span.start && mistake.span.end <= p.span.end
            };
            Some((tree.properties.iter().position(holds)?, mistake))
        });
        let Some((position, mistake)) = wrong else {
            // A mistake outside of properties, or nothing that is right.
            let shown = first.unwrap_or(found);
            return Err(
                Problem::from_diagnostics(source, &shown).unwrap_or_else(|| {
                    Problem::new("cannot-resolve", "a property cannot be resolved")
                }),
            );
        };
        let removed = tree.properties.remove(position);
        all[places.remove(position)] = Some(Asked::Wrong(Wrong {
            name: removed.name.as_ref().map(|name| name.text.clone()),
            text: removed.text,
            message: mistake.to_string(),
            unsupported: mistake.code == "unsupported",
        }));
        first.get_or_insert(found);
    }
}

fn given_property(text: &str) -> Source {
    Source {
        name: "<property>".into(),
        text: text.to_owned(),
    }
}
