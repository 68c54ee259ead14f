//! What a place in a text names, and all places that name the same.

use crate::kind::Kind;
use crate::mentions::{Mention, Thing};
use crate::model::ModelView;
use crate::workspace::Workspace;
use prism_lang::names::{Names, Occurrence, Role, Space};
use std::path::{Path, PathBuf};

/// What stands at a place; in a renamed copy, a name may stand for two things.
#[must_use]
pub fn at(workspace: &Workspace, path: &Path, offset: usize) -> Vec<Mention> {
    let is_at = |it: &Occurrence| it.span.start <= offset && offset <= it.span.end;
    match with_names(workspace, path, |names| some(path, names, is_at)) {
        Some(found) => found,
        None => {
            let all = in_file(workspace, path).into_iter();
            all.filter(|it| it.span.start <= offset && offset <= it.span.end)
                .collect()
        }
    }
}

/// What is made of the names of a text in the PRISM language; `None` of other files.
fn with_names<T>(workspace: &Workspace, path: &Path, make: impl Fn(&Names) -> T) -> Option<T> {
    match workspace.kind(path) {
        Kind::Model => workspace.model(path).map(|view| make(&view.names)),
        Kind::Properties => workspace.properties(path).map(|view| make(&view.names)),
        Kind::Toml | Kind::Other => None,
    }
}

fn some(path: &Path, names: &Names, wanted: impl Fn(&Occurrence) -> bool) -> Vec<Mention> {
    let found = names.iter().filter(|it| wanted(it));
    found.map(|it| of_name(path, it)).collect()
}

/// The places of a file that name a thing.
fn of_thing(workspace: &Workspace, path: &Path, thing: &Thing) -> Vec<Mention> {
    let is_it = |it: &Occurrence| match thing {
        Thing::Prism(space, name) => it.space == *space && it.name == *name,
        _ => false,
    };
    match with_names(workspace, path, |names| some(path, names, is_it)) {
        Some(found) => found,
        None => {
            let all = in_file(workspace, path).into_iter();
            all.filter(|it| it.thing == *thing).collect()
        }
    }
}

/// All that a file names.
#[must_use]
pub fn in_file(workspace: &Workspace, path: &Path) -> Vec<Mention> {
    if let Some(found) = with_names(workspace, path, |names| some(path, names, |_| true)) {
        return found;
    }
    match (workspace.study_of(path), workspace.read(path)) {
        (Some(study), Some(text)) if study.knows(path) => {
            crate::mentions::of_file(&study, path, text.as_str())
        }
        _ => Vec::new(),
    }
}

fn of_name(path: &Path, it: &Occurrence) -> Mention {
    Mention {
        path: path.to_owned(),
        span: it.span.start..it.span.end,
        thing: Thing::Prism(it.space, it.name.clone()),
        role: it.role,
    }
}

/// All places that name a thing, seen from a file: in the files in which the name means the same.
#[must_use]
pub fn places(workspace: &Workspace, thing: &Thing, from: &Path) -> Vec<Mention> {
    let files = match thing {
        Thing::Prism(space, name) => files_of_name(workspace, *space, name, from),
        _ => match workspace.study_of(from) {
            Some(study) => study.files(workspace),
            None => vec![from.to_owned()],
        },
    };
    let all = files.iter();
    all.flat_map(|file| of_thing(workspace, file, thing))
        .collect()
}

/// The files in which a name of a model means what it means in this one.
///
/// A name that a properties file declares is its own. One of a model is known in the property files that are judged with it. If
/// the study that has the model in its ledger names it, it is that of all models of the ledger that declare it, since the study's
/// texts are asked of each of them.
#[must_use]
pub fn files_of_name(workspace: &Workspace, space: Space, name: &str, from: &Path) -> Vec<PathBuf> {
    let mut models: Vec<PathBuf> = Vec::new();
    match workspace.kind(from) {
        Kind::Properties => match workspace.properties(from) {
            Some(view) if view.names.definition(space, name).is_none() => {
                models.extend(view.model.as_ref().map(|it| it.path.clone()));
            }
            _ => return vec![from.to_owned()],
        },
        Kind::Model => models.push(from.to_owned()),
        Kind::Toml | Kind::Other => {}
    }
    let start = models.first().cloned().unwrap_or_else(|| from.to_owned());
    let mut files = Vec::new();
    if let Some(study) = workspace.study_of(&start) {
        let of_ledger = study.models();
        let thing = Thing::Prism(space, name.to_owned());
        let is_named = || study.mentions(workspace).iter().any(|it| it.thing == thing);
        let is_of_study = models.first().is_none_or(|it| of_ledger.contains(it));
        if is_of_study && is_named() {
            let declares = |it: &PathBuf| {
                let model = workspace.model(it);
                model.is_some_and(|it| it.names.definition(space, name).is_some())
            };
            models.extend(of_ledger.into_iter().filter(declares));
            files.extend(study.files(workspace));
        }
    }
    models.sort();
    models.dedup();
    for model in &models {
        files.extend(properties_of(workspace, model));
    }
    files.extend(models);
    if files.is_empty() {
        files.push(from.to_owned());
    }
    files.sort();
    files.dedup();
    files
}

/// The property files that are judged with a model: in its folder, or in its study's.
#[must_use]
pub fn properties_of(workspace: &Workspace, model: &Path) -> Vec<PathBuf> {
    let study = workspace.study_folder(model);
    let folders = model.parent().map(Path::to_owned).into_iter().chain(study);
    let mut found: Vec<PathBuf> = folders
        .flat_map(|folder| workspace.siblings(&folder, Kind::Properties))
        .filter(|path| {
            let view = workspace.properties(path);
            view.is_some_and(|view| view.model.as_ref().is_some_and(|it| it.path == model))
        })
        .collect();
    found.sort();
    found.dedup();
    found
}

/// The models in which a name may be looked up from a file: the one itself, the one that properties are judged with, or those
/// of the study's ledger.
#[must_use]
pub fn models_seen_from(workspace: &Workspace, path: &Path) -> Vec<std::rc::Rc<ModelView>> {
    match workspace.kind(path) {
        Kind::Model => workspace.model(path).into_iter().collect(),
        Kind::Properties => {
            let view = workspace.properties(path);
            view.and_then(|it| it.model.clone()).into_iter().collect()
        }
        Kind::Toml | Kind::Other => {
            let study = workspace.study_of(path);
            let models = study.map_or(Vec::new(), |it| it.models());
            models.iter().filter_map(|it| workspace.model(it)).collect()
        }
    }
}

/// Where a thing is declared, seen from a file. An action is declared by every command that has it.
#[must_use]
pub fn definitions(workspace: &Workspace, thing: &Thing, from: &Path) -> Vec<Mention> {
    let all = places(workspace, thing, from);
    all.into_iter()
        .filter(|it| it.role == Role::Definition)
        .collect()
}
