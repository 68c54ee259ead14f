//! What may be written at a place.

mod place;
mod study;

use crate::kind::Kind;
use crate::model::ModelView;
use crate::workspace::Workspace;
use ls_types::{CompletionItem, CompletionItemKind};
use place::{Place, in_quotes_of, place_in_model, plain};
use prism_lang::names::{Names, Role, Space};
use std::collections::BTreeMap;
use std::path::Path;
use study::in_toml;

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
