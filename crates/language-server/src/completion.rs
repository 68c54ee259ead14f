//! What may be written at a place.

use crate::cursor;
use crate::kind::{self, Kind};
use crate::model::ModelView;
use crate::schema;
use crate::toml_tree;
use crate::workspace::Workspace;
use ls_types::{CompletionItem, CompletionItemKind};
use prism_lang::ast;
use prism_lang::names::{Names, Role, Space};
use std::collections::BTreeMap;
use std::path::Path;

/// Where in a text of the PRISM language something is to be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// In a comment, or where a new name is invented.
    Nowhere,
    /// Between declarations of a model.
    TopLevel,
    /// Between the commands of a module.
    Module,
    /// In quotes; of a reward structure behind a brace.
    Quotes { of_rewards: bool },
    /// Between the brackets with which a command begins.
    Action,
    /// In an expression.
    Expression,
}

const TOP: [&str; 16] = [
    "dtmc",
    "ctmc",
    "mdp",
    "const int",
    "const double",
    "const bool",
    "formula",
    "label",
    "global",
    "module",
    "rewards",
    "init",
    "system",
    "endinit",
    "endsystem",
    "endrewards",
];
const OPERATORS: [&str; 27] = [
    "P=?",
    "P>=",
    "P<=",
    "Pmin=?",
    "Pmax=?",
    "R=?",
    "Rmin=?",
    "Rmax=?",
    "S=?",
    "F",
    "G",
    "X",
    "U",
    "W",
    "A",
    "E",
    "C",
    "I",
    "filter",
    "true",
    "false",
    "min",
    "max",
    "const int",
    "const double",
    "label",
    "formula",
];
const FUNCTIONS: [&str; 10] = [
    "true", "false", "min", "max", "floor", "ceil", "round", "pow", "mod", "log",
];

/// What may be written at a place; the editor takes those that begin as what is there.
#[must_use]
pub fn at(workspace: &Workspace, path: &Path, offset: usize) -> Vec<CompletionItem> {
    let Some(text) = workspace.read(path) else {
        return Vec::new();
    };
    let Some(before) = text.as_str().get(..offset) else {
        return Vec::new();
    };
    let mut found = Found::default();
    match workspace.kind(path) {
        Kind::Model => {
            let place = place_in_model(before);
            if let Some(view) = workspace.model(path) {
                in_model(&mut found, place, &view);
            }
        }
        Kind::Properties => in_properties(workspace, &mut found, path, before),
        Kind::Toml => in_toml(workspace, &mut found, path, text.as_str(), offset),
        Kind::Other => {}
    }
    found.items.into_values().collect()
}

/// What was found, by its text.
#[derive(Default)]
struct Found {
    items: BTreeMap<String, CompletionItem>,
}

impl Found {
    fn add(&mut self, label: &str, kind: CompletionItemKind, detail: impl Into<String>) {
        let detail: String = detail.into();
        self.items
            .entry(label.to_owned())
            .or_insert(CompletionItem {
                label: label.to_owned(),
                kind: Some(kind),
                detail: (!detail.is_empty()).then_some(detail),
                ..CompletionItem::default()
            });
    }

    fn words(&mut self, words: &[&str]) {
        for word in words {
            self.add(word, CompletionItemKind::KEYWORD, "");
        }
    }

    /// The constants, formulas and variables of a model.
    fn values(&mut self, view: &ModelView) {
        for name in view.declared(Space::Value) {
            let (kind, detail) = match () {
                () if view.constant(name).is_some() => {
                    let value = view.resolved_already().and_then(|it| it.constant(name));
                    let shown = value.map_or_else(String::new, |it| format!("constant, {it}"));
                    (CompletionItemKind::CONSTANT, shown)
                }
                () if view.formula(name).is_some() => {
                    (CompletionItemKind::FUNCTION, "formula".to_owned())
                }
                () => (CompletionItemKind::VARIABLE, "variable".to_owned()),
            };
            self.add(name, kind, detail);
        }
    }

    fn names(&mut self, names: &[&str], kind: CompletionItemKind, what: &str) {
        for name in names {
            self.add(name, kind, what);
        }
    }
}

/// The text without its comments and without what stands in quotes, and whether its end is in either.
fn plain(before: &str) -> (String, bool, bool) {
    let mut shown = String::with_capacity(before.len());
    let (mut in_comment, mut in_quotes) = (false, false);
    let mut characters = before.chars().peekable();
    while let Some(character) = characters.next() {
        match character {
            '\n' => {
                (in_comment, in_quotes) = (false, false);
                shown.push('\n');
            }
            _ if in_comment => {}
            '"' => {
                in_quotes = !in_quotes;
                shown.push('"');
            }
            '/' if !in_quotes && characters.peek() == Some(&'/') => in_comment = true,
            _ if in_quotes => {}
            other => shown.push(other),
        }
    }
    (shown, in_comment, in_quotes)
}

fn place_in_model(before: &str) -> Place {
    let (shown, in_comment, in_quotes) = plain(before);
    if in_comment {
        return Place::Nowhere;
    }
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let rest = shown.trim_end_matches(is_part);
    if in_quotes {
        return in_quotes_of(&shown);
    }
    let words: Vec<&str> = rest
        .split(|c| !is_part(c))
        .filter(|it| !it.is_empty())
        .collect();
    let last_of = |open: &str, close: &str| {
        let open = words.iter().rposition(|it| *it == open);
        let close = words.iter().rposition(|it| *it == close);
        open.is_some() && open > close
    };
    let statement = rest.rsplit(';').next().unwrap_or("");
    let in_module = last_of("module", "endmodule");
    let trimmed = statement.trim();
    if in_module && trimmed.ends_with('[') && !trimmed.contains("->") && trimmed.len() == 1 {
        return Place::Action;
    }
    if in_module {
        // Behind the word `module` comes the new name, and behind that, on a line of its own, the first declaration.
        let mut parts = trimmed.split_whitespace();
        let is_header = parts.by_ref().any(|it| it == "module");
        return match (trimmed.is_empty(), is_header, parts.count()) {
            (true, ..) => Place::Module,
            (_, true, 1) if rest.ends_with('\n') => Place::Module,
            (_, true, 0 | 1) => Place::Nowhere,
            _ => Place::Expression,
        };
    }
    let of_type = [
        "dtmc",
        "ctmc",
        "mdp",
        "pta",
        "endmodule",
        "endrewards",
        "endinit",
        "endsystem",
    ];
    let is_top = trimmed.is_empty() || of_type.iter().any(|it| trimmed.ends_with(it));
    let invents = [
        "const", "int", "double", "bool", "formula", "label", "global", "module", "rewards",
    ];
    let last = trimmed.split_whitespace().next_back().unwrap_or("");
    let invents = invents.contains(&last);
    match (is_top, invents) {
        (true, _) => Place::TopLevel,
        (_, true) => Place::Nowhere,
        _ => Place::Expression,
    }
}

fn in_quotes_of(shown: &str) -> Place {
    let before = shown.trim_end_matches('"').trim_end();
    let invents =
        before.ends_with("label") || before.ends_with("rewards") || before.ends_with("system");
    match invents {
        true => Place::Nowhere,
        false => Place::Quotes {
            of_rewards: before.ends_with('{')
                && before
                    .trim_end_matches('{')
                    .trim_end()
                    .ends_with(['R', '/']),
        },
    }
}

fn in_model(found: &mut Found, place: Place, view: &ModelView) {
    match place {
        Place::Nowhere => {}
        Place::TopLevel => found.words(&TOP),
        Place::Module => found.words(&["endmodule", "[] "]),
        Place::Action => {
            let actions = view.declared(Space::Action);
            found.names(&actions, CompletionItemKind::EVENT, "action");
        }
        Place::Quotes { .. } => quoted(found, view, false),
        Place::Expression => {
            found.values(view);
            found.words(&FUNCTIONS);
            found.words(&["init", "bool", "int", "endmodule", "endrewards", "endinit"]);
            let modules = view.declared(Space::Module);
            found.names(&modules, CompletionItemKind::MODULE, "module");
        }
    }
}

fn quoted(found: &mut Found, view: &ModelView, of_rewards: bool) {
    if of_rewards {
        let rewards = view.declared(Space::Reward);
        found.names(&rewards, CompletionItemKind::STRUCT, "reward structure");
        return;
    }
    for label in &view.tree.labels {
        let detail = format!("label, {}", label.body);
        found.add(&label.name.text, CompletionItemKind::ENUM_MEMBER, detail);
    }
    found.names(
        &["init", "deadlock"],
        CompletionItemKind::ENUM_MEMBER,
        "built in",
    );
}

fn in_properties(workspace: &Workspace, found: &mut Found, path: &Path, before: &str) {
    let (shown, in_comment, in_quotes) = plain(before);
    let Some(view) = workspace.properties(path).filter(|_| !in_comment) else {
        return;
    };
    if in_quotes {
        let place = in_quotes_of(&shown);
        let of_rewards = place == Place::Quotes { of_rewards: true };
        if place == Place::Nowhere {
            return;
        }
        if let Some(model) = &view.model {
            quoted(found, model, of_rewards);
        }
        if !of_rewards {
            let names = defined(&view.names, Space::Label);
            found.names(&names, CompletionItemKind::ENUM_MEMBER, "label or property");
        }
        return;
    }
    found.words(&OPERATORS);
    found.words(&FUNCTIONS);
    let names = defined(&view.names, Space::Value);
    found.names(&names, CompletionItemKind::CONSTANT, "of this file");
    if let Some(model) = &view.model {
        found.values(model);
    }
}

fn defined(names: &Names, space: Space) -> Vec<&str> {
    let all = names.iter();
    let all = all.filter(|it| it.space == space && it.role == Role::Definition);
    all.map(|it| it.name.as_str()).collect()
}

/// In a study's file: keys where a line begins, else words, names and identifiers by the key.
fn in_toml(workspace: &Workspace, found: &mut Found, path: &Path, text: &str, offset: usize) {
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
    let at = toml_tree::nodes(text)
        .into_iter()
        .filter(|node| !node.has_parts && node.value.start <= offset && offset <= node.value.end);
    let path_of_value = at
        .last()
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
    let keys: Vec<&str> = at
        .iter()
        .map(String::as_str)
        .filter(|it| it.parse::<usize>().is_err())
        .collect();
    let last = keys.last().copied().unwrap_or("");
    let study = view.study.as_ref();
    let mut propositions = || {
        for name in &view.known.propositions {
            let meaning = study.and_then(|it| it.vocabulary.propositions.get(name));
            let meaning = meaning.map_or("", |it| it.meaning.as_str());
            found.add(name, CompletionItemKind::ENUM_MEMBER, meaning);
        }
    };
    match last {
        "shall" | "trace" | "graded" | "formula" | "when" | "assert" | "wait_for" | "hold"
        | "until" | "trigger" => {
            propositions();
            parameters(&view, found);
        }
        "property" | "occurs" | "opportunity" => {
            propositions();
            found.words(&OPERATORS);
        }
        "experiment" => propositions(),
        "parameters" => parameters(&view, found),
        "model" if keys.len() == 2 && path.ends_with("vocabulary.toml") => {
            for model in cursor::models_seen_from(workspace, path) {
                found.values(&model);
            }
        }
        "constant" => {
            for model in cursor::models_seen_from(workspace, path) {
                let constants = model.tree.constants.iter();
                let names: Vec<&str> = constants
                    .map(|it: &ast::Constant| it.name.text.as_str())
                    .collect();
                found.names(&names, CompletionItemKind::CONSTANT, "constant");
            }
        }
        "from" | "reproduced_by" | "shown_by" => {
            for entry in study.iter().flat_map(|it| &it.ledger) {
                found.add(
                    &entry.id,
                    CompletionItemKind::REFERENCE,
                    entry.title.clone(),
                );
            }
        }
        "same_as" | "requirement" => {
            for it in study.iter().flat_map(|it| &it.requirements) {
                found.add(&it.id, CompletionItemKind::REFERENCE, it.text.clone());
            }
        }
        "failure_mode" => {
            for it in study.iter().flat_map(|it| &it.failure_modes) {
                found.add(&it.id, CompletionItemKind::REFERENCE, it.name.clone());
            }
        }
        "conditions" => {
            for (name, meaning) in study.iter().flat_map(|it| &it.about.conditions) {
                found.add(name, CompletionItemKind::REFERENCE, meaning.clone());
            }
        }
        _ => {}
    }
}

fn parameters(view: &crate::study_view::StudyView, found: &mut Found) {
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
    fn places_in_models_are_told_apart() {
        for (before, place) in [
            ("", Place::TopLevel),
            ("dtmc\nco", Place::TopLevel),
            ("dtmc\nconst ", Place::Nowhere),
            ("dtmc\nconst int n = ", Place::Expression),
            ("dtmc // const int n = ", Place::Nowhere),
            ("dtmc\nmodule m\n", Place::Module),
            ("dtmc\nmodule m\n x : bool;\n [", Place::Action),
            ("dtmc\nmodule m\n x : bool;\n [a] x & ", Place::Expression),
            (
                "dtmc\nmodule m\n x : bool;\n [a] x -> (x'=",
                Place::Expression,
            ),
            ("dtmc\nmodule m\n x : [0..", Place::Expression),
            ("dtmc\nmodule m endmodule\n", Place::TopLevel),
            ("dtmc label \"", Place::Nowhere),
        ] {
            assert_eq!(place_in_model(before), place, "{before}");
        }
    }

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
