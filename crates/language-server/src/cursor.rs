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
    in_file(workspace, path)
        .into_iter()
        .filter(|it| it.span.start <= offset && offset <= it.span.end)
        .collect()
}

/// All that a file names.
#[must_use]
pub fn in_file(workspace: &Workspace, path: &Path) -> Vec<Mention> {
    match workspace.kind(path) {
        Kind::Model => {
            let view = workspace.model(path);
            view.map_or(Vec::new(), |view| of_names(path, &view.names))
        }
        Kind::Properties => {
            let view = workspace.properties(path);
            view.map_or(Vec::new(), |view| of_names(path, &view.names))
        }
        Kind::Toml => match (workspace.study_of(path), workspace.read(path)) {
            (Some(study), Some(text)) if path.parent() == Some(&study.folder) => {
                crate::mentions::of_file(&study, path, text.as_str())
            }
            _ => Vec::new(),
        },
        Kind::Other => Vec::new(),
    }
}

fn of_names(path: &Path, names: &Names) -> Vec<Mention> {
    names.iter().map(|it| of_name(path, it)).collect()
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
            Some(study) => study.files().collect(),
            None => vec![from.to_owned()],
        },
    };
    let all = files.iter().flat_map(|file| in_file(workspace, file));
    all.filter(|it| it.thing == *thing).collect()
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
            files.extend(study.files());
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
