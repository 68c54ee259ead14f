//! What is said of what stands at a place.

mod prism;
mod study;
mod words;

use crate::cursor;
use crate::kind::{self, Kind};
use crate::mentions::Thing;
use crate::schema;
use crate::toml_tree;
use crate::workspace::Workspace;
use std::ops::Range;
use std::path::Path;

/// What is shown, in Markdown, and the part of the text that it is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shown {
    /// In Markdown.
    pub text: String,
    /// What it is about.
    pub span: Range<usize>,
}

/// What is said of a place.
#[must_use]
pub fn at(workspace: &Workspace, path: &Path, offset: usize) -> Option<Shown> {
    let mut parts = Vec::new();
    let mut span = None;
    for mention in cursor::at(workspace, path, offset) {
        span = span.or(Some(mention.span.clone()));
        match &mention.thing {
            Thing::Prism(space, name) => {
                parts.extend(prism::of_name(workspace, *space, name, path));
            }
            thing => parts.extend(study::of_thing(workspace, thing, path)),
        }
    }
    match workspace.kind(path) {
        Kind::Model | Kind::Properties if parts.is_empty() => {
            let text = workspace.read(path)?;
            let (word, at) = words::at(text.as_str(), offset)?;
            parts.extend(words::of_language(word, workspace.kind(path)));
            span = Some(at);
        }
        Kind::Toml => {
            let (mut more, at) = in_toml(workspace, path, offset);
            parts.append(&mut more);
            span = span.or(at);
        }
        _ => {}
    }
    parts.extend(mistakes_at(workspace, path, offset));
    let text = parts.join("\n\n---\n\n");
    let span = span.unwrap_or(offset..offset);
    (!text.is_empty()).then_some(Shown { text, span })
}

/// What a key means, and what a sentence says.
fn in_toml(
    workspace: &Workspace,
    path: &Path,
    offset: usize,
) -> (Vec<String>, Option<Range<usize>>) {
    let mut parts = Vec::new();
    let mut span = None;
    let Some(text) = workspace.read(path) else {
        return (parts, span);
    };
    let is_at = |place: &Range<usize>| place.start <= offset && offset <= place.end;
    for node in toml_tree::nodes(text.as_str()) {
        if is_at(&node.value) && !node.has_parts && node.last() == "shall" {
            parts.extend(study::of_sentence(workspace, path, &node));
            span = Some(node.value.clone());
        }
        let is_key = node
            .path
            .last()
            .is_some_and(|it| it.parse::<usize>().is_err());
        if is_at(&node.key) && is_key {
            let schema = kind::schema_name(path).and_then(|it| workspace.schemas.get(it));
            let said = schema.and_then(|it| schema::description(it, &node.path));
            if let Some(said) = said {
                parts.push(format!("`{}`: {said}", node.last()));
                span = Some(node.key.clone());
            }
        }
    }
    (parts, span)
}

/// What the codes of the mistakes at a place mean.
fn mistakes_at(workspace: &Workspace, path: &Path, offset: usize) -> Vec<String> {
    let is_at = |it: &prism_lang::Diagnostic| it.span.start <= offset && offset <= it.span.end;
    let mut codes: Vec<&str> = match workspace.kind(path) {
        Kind::Model => workspace.model(path).map_or(Vec::new(), |it| {
            let at = it.diagnostics().filter(|it| is_at(it));
            at.map(|it| it.code).collect()
        }),
        Kind::Properties => workspace.properties(path).map_or(Vec::new(), |it| {
            let at = it.diagnostics.iter().filter(|it| is_at(it));
            at.map(|it| it.code).collect()
        }),
        Kind::Toml | Kind::Other => Vec::new(),
    };
    codes.dedup();
    codes
        .into_iter()
        .filter_map(|code| {
            let text = workspace.engine.explanation(code)?;
            Some(format!("**{code}**\n\n{text}"))
        })
        .collect()
}
