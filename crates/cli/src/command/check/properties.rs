//! The properties of a command line and of its file.
//!
//! A property that means nothing over the model does not keep the others from being checked: it gets an error of
//! its own. If none is left, the mistakes end the command.

use crate::args::Check;
use crate::problem::{Problem, Source};
use prism_lang::ast::PropertyFile;
use prism_lang::{Constants, Diagnostic, NamedProperty, resolved};
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

/// All properties that were asked for, in order.
pub(super) fn properties(
    arguments: &Check,
    model: &resolved::Model,
    given: &Constants,
) -> Result<Vec<Asked>, Problem> {
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
    sources.extend(
        arguments
            .property_texts
            .iter()
            .map(|text| given_property(text)),
    );
    let mut all = Vec::new();
    for source in &sources {
        let parsed = prism_lang::parse_properties(&source.text);
        if let Some(problem) = Problem::from_diagnostics(source, &parsed.diagnostics) {
            return Err(problem);
        }
        all.extend(resolve(source, parsed.tree, model, given)?);
    }
    Ok(all)
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
    let mut first: Option<Vec<Diagnostic>> = None;
    loop {
        let found = match prism_lang::resolve_properties(&tree, model, given) {
            Ok(resolved) if resolved.is_empty() && first.is_some() => Vec::new(),
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
