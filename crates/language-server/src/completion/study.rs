//! What may be written in a study's files.

use super::{Found, OPERATORS};
use crate::cursor;
use crate::kind;
use crate::schema;
use crate::study_view::StudyView;
use crate::toml_tree;
use crate::workspace::Workspace;
use ls_types::CompletionItemKind;
use std::path::Path;

/// In a study's file: keys where a line begins, else words, names and identifiers by the key.
pub(super) fn in_toml(
    workspace: &Workspace,
    found: &mut Found,
    path: &Path,
    text: &str,
    offset: usize,
) {
    let line = text[..offset].rfind('\n').map_or(0, |at| at + 1);
    let written = &text[line..offset];
    let schema = kind::schema_name(path).and_then(|it| workspace.schemas.get(it));
    let table = table_above(&text[..line]);
    let key_only = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | ' ');
    if written.trim_start().starts_with('#') {
        return;
    }
    if written.chars().all(key_only) {
        let mut base = table;
        let dotted: Vec<&str> = written.trim_start().split('.').collect();
        let parents = &dotted[..dotted.len().saturating_sub(1)];
        base.extend(parents.iter().map(|it| it.trim().to_owned()));
        for (key, said) in schema.map_or(Vec::new(), |it| schema::keys(it, &base)) {
            found.add(&key, CompletionItemKind::PROPERTY, said);
        }
        return;
    }
    let mut at = toml_tree::nodes(text)
        .into_iter()
        .filter(|node| !node.has_parts && node.value.start <= offset && offset <= node.value.end);
    let path_of_value = at
        .next_back()
        .map_or_else(|| path_by_line(written, table), |it| it.path);
    for (word, said) in schema.map_or(Vec::new(), |it| schema::choices(it, &path_of_value)) {
        found.add(&word, CompletionItemKind::VALUE, said);
    }
    names_for_key(workspace, found, path, &path_of_value);
}

/// The path of the value that a line begins, where the file cannot be read yet.
fn path_by_line(written: &str, mut table: Vec<String>) -> Vec<String> {
    let key = written.rsplit(['{', ',']).next().unwrap_or(written);
    let key = key.split('=').next().unwrap_or("").trim();
    let whole = written.split('=').next().unwrap_or("").trim();
    if whole != key {
        table.extend(whole.split('.').map(|it| it.trim().to_owned()));
    }
    table.extend(key.split('.').map(|it| it.trim().to_owned()));
    table
}

/// The path of the table that the last header above opens; an element of a list of tables is the first one of it.
fn table_above(before: &str) -> Vec<String> {
    let header = before
        .lines()
        .rev()
        .find(|line| line.trim_start().starts_with('['));
    let Some(header) = header.map(str::trim) else {
        return Vec::new();
    };
    let is_list = header.starts_with("[[");
    let inner = header.trim_matches(['[', ']']);
    let mut path: Vec<String> = Vec::new();
    for part in inner.split('.') {
        let part = part.trim().trim_matches(['"', '\'']);
        // Tables below an element of a list: `[requirement.reading.human]`.
        if path.len() == 1
            && matches!(
                path[0].as_str(),
                "requirement" | "failure_mode" | "evidence"
            )
        {
            path.push("0".into());
        }
        path.push(part.to_owned());
    }
    if is_list {
        path.push("0".into());
    }
    path
}

/// Names of the study that a key takes.
fn names_for_key(workspace: &Workspace, found: &mut Found, path: &Path, at: &[String]) {
    let Some(view) = workspace.study_of(path) else {
        return;
    };
    let keys = at.iter().map(String::as_str);
    let keys: Vec<&str> = keys.filter(|it| it.parse::<usize>().is_err()).collect();
    match keys.last().copied().unwrap_or("") {
        "shall" | "trace" | "graded" | "formula" | "when" | "assert" | "wait_for" | "hold"
        | "until" | "trigger" => {
            propositions(&view, found);
            parameters(&view, found);
        }
        "property" | "occurs" | "opportunity" => {
            propositions(&view, found);
            found.words(&OPERATORS);
        }
        "experiment" => propositions(&view, found),
        "parameters" => parameters(&view, found),
        "model" if keys.len() == 2 && path.ends_with("vocabulary.toml") => {
            for model in cursor::models_seen_from(workspace, path) {
                found.values(&model);
            }
        }
        "constant" => {
            for model in cursor::models_seen_from(workspace, path) {
                let names = model.tree.constants.iter();
                let names: Vec<&str> = names.map(|it| it.name.text.as_str()).collect();
                found.names(&names, CompletionItemKind::CONSTANT, "constant");
            }
        }
        key => identifiers(&view, found, key),
    }
}

/// Identifiers that a key takes, each with what it stands for.
fn identifiers(view: &StudyView, found: &mut Found, key: &str) {
    let Some(study) = &view.study else {
        return;
    };
    let mut add = |id: &str, says: &str| found.add(id, CompletionItemKind::REFERENCE, says);
    match key {
        "from" | "reproduced_by" | "shown_by" => {
            study.ledger.iter().for_each(|it| add(&it.id, &it.title));
        }
        "same_as" | "requirement" => {
            (study.requirements.iter()).for_each(|it| add(&it.id, &it.text));
        }
        "failure_mode" => study
            .failure_modes
            .iter()
            .for_each(|it| add(&it.id, &it.name)),
        "conditions" => {
            (study.about.conditions.iter()).for_each(|(name, meaning)| add(name, meaning));
        }
        _ => {}
    }
}

fn propositions(view: &StudyView, found: &mut Found) {
    for name in &view.known.propositions {
        let study = view.study.as_ref();
        let bound = study.and_then(|it| it.vocabulary.propositions.get(name));
        let meaning = bound.map_or("", |it| it.meaning.as_str());
        found.add(name, CompletionItemKind::ENUM_MEMBER, meaning);
    }
}

fn parameters(view: &StudyView, found: &mut Found) {
    let declared = view.study.iter().flat_map(|it| &it.parameters.declared);
    for (name, parameter) in declared {
        let said = format!("{}: {}", parameter.text, parameter.meaning);
        found.add(name, CompletionItemKind::CONSTANT, said);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_known_by_the_header_above() {
        assert_eq!(table_above("[a]\nx = 1\n"), ["a"]);
        assert_eq!(
            table_above("[[requirement]]\nid = 1\n"),
            ["requirement", "0"]
        );
        assert_eq!(
            table_above("[requirement.reading.human]\n"),
            ["requirement", "0", "reading", "human"]
        );
        assert_eq!(
            path_by_line("monitor.then = [{ hold = \"", vec![]),
            ["monitor", "then", "hold"]
        );
        assert_eq!(
            path_by_line("experiment = \"", vec!["r".into()]),
            ["r", "experiment"]
        );
    }
}
