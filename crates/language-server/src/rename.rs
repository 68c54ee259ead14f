//! Another name, everywhere at once, or not at all.
//!
//! # Definition
//! All places that name the thing ([`cursor::places`]) get the new name. It is refused, with the reason, where the new name is no
//! name, is taken in the same space in one of the files, would be caught by a renamed copy, or where a file that names the thing
//! cannot be read in full.
//!
//! # Guarantee
//! The renamed texts are read again before they are offered: what they name has to be what it was, place by place, and no file may
//! have a mistake that it did not have.

use crate::cursor;
use crate::kind::{self, Kind};
use crate::mentions::{Mention, Thing};
use crate::model::ModelView;
use crate::text::Text;
use crate::toml_tree;
use crate::workspace::Workspace;
use diagnostic::{Problem, Problems, Source};
use prism_lang::names::{Names, Role, Space};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use study::{Study, Texts};

/// The places to be replaced, by file.
pub type Replaced = BTreeMap<PathBuf, Vec<Range<usize>>>;

/// What is to be renamed at a place, and where it stands there.
///
/// # Errors
/// Why it cannot be renamed.
pub fn what(workspace: &Workspace, path: &Path, offset: usize) -> Result<Mention, String> {
    let found = cursor::at(workspace, path, offset);
    let Some(first) = found.first() else {
        return Err("there is no name here that can be changed".into());
    };
    if let [_, other, ..] = found.as_slice()
        && other.thing != first.thing
        && other.span == first.span
    {
        return Err(format!(
            "`{}` is both a value and an action here: this entry of a renamed copy renames both. Write two entries first.",
            first.thing.name()
        ));
    }
    match &first.thing {
        Thing::Subject(id) | Thing::Evidence(id) => Err(format!(
            "`{id}` is an identifier that tables, recordings and kept results name, too: change it by hand"
        )),
        Thing::Condition(name) => Err(format!(
            "`{name}` is a condition that kept results name, too: change it by hand"
        )),
        _ => Ok(first.clone()),
    }
}

/// Where the thing at a place gets its new name.
///
/// # Errors
/// Why it may not have that name.
pub fn rename(
    workspace: &Workspace,
    path: &Path,
    offset: usize,
    new: &str,
) -> Result<Replaced, String> {
    let it = what(workspace, path, offset)?;
    let old = it.thing.name();
    if new == old {
        return Ok(Replaced::new());
    }
    is_a_name(&it.thing, new)?;
    study_is_read(workspace, path)?;
    let places = cursor::places(workspace, &it.thing, path);
    if !places.iter().any(|it| it.role == Role::Definition) {
        return Err(format!("`{old}` is not declared in the files at hand"));
    }
    let mut replaced = Replaced::new();
    for place in &places {
        let of_file = replaced.entry(place.path.clone()).or_default();
        of_file.push(place.span.clone());
    }
    let files = match &it.thing {
        Thing::Prism(space, name) => cursor::files_of_name(workspace, *space, name, path),
        // All of the study's: where the name is not used, it may be caught.
        _ => {
            let study = workspace.study_of(path);
            study.map_or(Vec::new(), |it| it.files(workspace))
        }
    };
    for file in &files {
        is_free(workspace, file, &it.thing, new)?;
    }
    elsewhere(workspace, path, &it.thing)?;
    is_the_same(workspace, &it.thing, new, &replaced)?;
    Ok(replaced)
}

fn is_a_name(thing: &Thing, new: &str) -> Result<(), String> {
    let space = match thing {
        Thing::Prism(space, _) => *space,
        _ => Space::Observable,
    };
    match space.can_name(new) {
        true => Ok(()),
        false => Err(format!(
            "`{new}` cannot be a name here: names are letters, digits and `_`, do not start with a digit, and are not words of the language"
        )),
    }
}

/// That the study's own files can be read in full, also those of which not even the mention of the thing was found.
fn study_is_read(workspace: &Workspace, path: &Path) -> Result<(), String> {
    let Some(study) = workspace.study_of(path) else {
        return Ok(());
    };
    let files = study.files(workspace);
    let mut files = files
        .iter()
        .filter(|it| it.extension().is_some_and(|it| it == "toml"));
    files.try_for_each(|file| toml_is_read(workspace, file))
}

fn toml_is_read(workspace: &Workspace, file: &Path) -> Result<(), String> {
    let text = workspace.read(file);
    let mistake = text.and_then(|it| Some(line_of(&it, toml_tree::mistake(it.as_str())?)));
    match mistake {
        None => Ok(()),
        Some(line) => Err(format!(
            "{} has syntax errors (line {line}), so that names in it may be overlooked: correct them first",
            shown(file)
        )),
    }
}

/// Whether a file has the new name already, or catches it.
fn is_free(workspace: &Workspace, file: &Path, thing: &Thing, new: &str) -> Result<(), String> {
    let taken = |it: &Mention| match (&it.thing, thing) {
        (Thing::Prism(space, name), Thing::Prism(wanted, _)) => name == new && space == wanted,
        // In the study's texts a bare word is one or the other.
        (
            Thing::Proposition(name) | Thing::Parameter(name),
            Thing::Proposition(_) | Thing::Parameter(_),
        ) => name == new,
        _ => false,
    };
    let here = cursor::in_file(workspace, file);
    if let Some(it) = here.iter().find(|it| taken(it)) {
        let text = workspace.read(file);
        let line = text.map_or(0, |text| line_of(&text, it.span.start));
        let file = shown(file);
        return Err(format!("`{new}` is already a name in {file}, line {line}"));
    }
    let is_read = match workspace.kind(file) {
        Kind::Model => match workspace.model(file) {
            Some(view) => {
                let in_copies = [Space::Value, Space::Action];
                if matches!(thing, Thing::Prism(space, _) if in_copies.contains(space)) {
                    is_not_caught(&view, thing.name(), new)?;
                }
                view.is_read
            }
            None => true,
        },
        Kind::Properties => workspace.properties(file).is_none_or(|view| view.is_read),
        Kind::Toml | Kind::Other => true,
    };
    match is_read {
        true => Ok(()),
        false => Err(format!(
            "{} has syntax errors, so that names in it may be overlooked: correct them first",
            shown(file)
        )),
    }
}

/// Whether the renamed copies of a model leave both names what they are.
fn is_not_caught(view: &ModelView, old: &str, new: &str) -> Result<(), String> {
    let file = shown(&view.path);
    if view.names.is_in_a_copy(&view.tree, new) {
        return Err(format!(
            "`{new}` is a name in a renamed copy of a module in {file}, which would catch it"
        ));
    }
    let of_copies = [Space::Value, Space::Action];
    let mut here = view.names.iter();
    let is_both = here.any(|it| {
        let mut beside = view.names.at(it.span.start);
        it.name == old
            && of_copies.contains(&it.space)
            && beside.any(|other| other.space != it.space && other.span == it.span)
    });
    match is_both {
        true => Err(format!(
            "a renamed copy in {file} renames `{old}` as a value and as an action by one entry: write two entries first"
        )),
        false => Ok(()),
    }
}

fn line_of(text: &Text, offset: usize) -> u32 {
    text.position(offset).line + 1
}

fn shown(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// Keys whose texts are for people.
const PROSE: [&str; 10] = [
    "meaning",
    "title",
    "summary",
    "text",
    "changed",
    "name",
    "because",
    "source",
    "description",
    "note",
];

/// How many further files are looked into.
const MOST_FILES: usize = 500;

/// Of a study's other files, these speak of what a model declares.
const OF_MODELS: [&str; 5] = [
    "calibration.toml",
    "variant.toml",
    "exploration.toml",
    "rare.toml",
    "finding.toml",
];

/// That no other file of the study names the thing in a way that is not known here.
fn elsewhere(workspace: &Workspace, from: &Path, thing: &Thing) -> Result<(), String> {
    let Some(study) = workspace.study_of(from) else {
        return Ok(());
    };
    if let Thing::Prism(space, name) = thing {
        let files = cursor::files_of_name(workspace, *space, name, from);
        let models = study.models();
        // A name of a model that is no part of the study is of no concern to its files.
        if !files.iter().any(|it| models.contains(it)) {
            return Ok(());
        }
    }
    let name = thing.name();
    if let Some(template) = needed_by(&study.study, thing) {
        return Err(format!(
            "`{name}` is a name that the library's requirement `{template}` needs: it cannot be changed"
        ));
    }
    let mut files = Vec::new();
    below(&study.folder, 0, &mut files);
    for file in files {
        let is_of_models = kind::schema_name(&file).is_some_and(|it| OF_MODELS.contains(&it));
        let of_models_alone = matches!(thing, Thing::Prism(..));
        if of_models_alone && !is_of_models {
            continue;
        }
        toml_is_read(workspace, &file)?;
        if let Some(line) = names_it_otherwise(workspace, &file, thing) {
            let file = shown(&file);
            return Err(format!(
                "{file}, line {line}, may name `{name}`, too: change it there by hand first"
            ));
        }
    }
    Ok(())
}

/// The line of a file in which a key or a text that is not for people has the name, where that is not known to be one: what is
/// known is replaced with all others.
fn names_it_otherwise(workspace: &Workspace, file: &Path, thing: &Thing) -> Option<u32> {
    let text = workspace.read(file)?;
    let known = cursor::in_file(workspace, file);
    let is_known = |part: &Range<usize>| {
        let mut inside = known.iter().filter(|it| it.thing == *thing);
        inside.any(|it| part.start <= it.span.start && it.span.end <= part.end)
    };
    let mut nodes = toml_tree::nodes(text.as_str()).into_iter();
    let found = nodes.find(|node| {
        let is_prose = node.keys().any(|key| PROSE.contains(&key));
        let words = node.text.as_deref();
        let in_value = words.is_some_and(|it| has_word(it, thing.name()));
        let is_key = node.path.last().is_some_and(|it| it == thing.name());
        !is_prose && in_value && !is_known(&node.value) || is_key && !is_known(&node.key)
    })?;
    Some(line_of(&text, found.key.start))
}

/// The requirement of the library that needs a proposition or a parameter by its name.
fn needed_by(study: &Option<Study>, thing: &Thing) -> Option<String> {
    let text = &study.as_ref()?.forms.source.text;
    let used = toml_tree::nodes(text).into_iter();
    let used = used.filter(|it| it.is(&["requirement", "*", "template"]));
    let mut used = used.filter_map(|it| it.text);
    used.find(|id| {
        requirement_lang::library::template(id).is_some_and(|template| match thing {
            Thing::Proposition(name) => template.needs.iter().any(|it| it.name == name),
            Thing::Parameter(name) => template.parameters.iter().any(|it| it.name == name),
            _ => false,
        })
    })
}

/// The TOML files below a study's folder that are not its own.
fn below(folder: &Path, depth: usize, files: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|it| it.path()).collect();
    paths.sort();
    for path in paths {
        let name = path.file_name().and_then(|it| it.to_str()).unwrap_or("");
        if files.len() >= MOST_FILES || name.starts_with('.') || name == "results" {
            continue;
        }
        let is_own = depth == 0 && kind::OF_STUDY.contains(&name);
        if path.is_dir() && depth < 4 && !path.is_symlink() {
            below(&path, depth + 1, files);
        } else if name.ends_with(".toml") && !is_own {
            files.push(path);
        }
    }
}

fn has_word(text: &str, word: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    text.split(|c| !is_part(c)).any(|it| it == word)
}

/// A text with a new name at these places.
#[must_use]
pub fn replaced(text: &str, places: &[Range<usize>], new: &str) -> String {
    let mut sorted: Vec<&Range<usize>> = places.iter().collect();
    sorted.sort_by_key(|it| it.start);
    sorted.dedup();
    let mut result = String::with_capacity(text.len());
    let mut done = 0;
    for place in sorted.into_iter().filter(|it| it.end <= text.len()) {
        if place.start >= done {
            result.push_str(&text[done..place.start]);
            result.push_str(new);
            done = place.end;
        }
    }
    result.push_str(&text[done..]);
    result
}

/// Reads the renamed texts again.
fn is_the_same(
    workspace: &Workspace,
    thing: &Thing,
    new: &str,
    all: &Replaced,
) -> Result<(), String> {
    let mut texts = BTreeMap::new();
    for (file, places) in all {
        let Some(before) = workspace.read(file) else {
            continue;
        };
        let after = replaced(before.as_str(), places, new);
        let expected = expected(workspace, file, thing, new);
        let found = match workspace.kind(file) {
            Kind::Model => Some(Names::of_model(
                &prism_lang::parse_model(&after).tree,
                &after,
            )),
            Kind::Properties => Some(Names::of_properties(
                &prism_lang::parse_properties(&after).tree,
                &after,
            )),
            Kind::Toml | Kind::Other => None,
        };
        if let Some(found) = found {
            let found: Vec<_> = found
                .iter()
                .map(|it| (it.space, it.role, it.name.clone()))
                .collect();
            if found != expected {
                return Err(format!(
                    "{} would mean something else with `{new}`",
                    shown(file)
                ));
            }
        }
        texts.insert(file.clone(), after);
    }
    has_no_new_mistakes(workspace, all, texts)
}

type Named = (Space, Role, String);

/// What a file names now, with the new name in the place of the old one.
fn expected(workspace: &Workspace, file: &Path, thing: &Thing, new: &str) -> Vec<Named> {
    let names = cursor::in_file(workspace, file).into_iter();
    names
        .filter_map(|it| match (&it.thing, &it.thing == thing) {
            (Thing::Prism(space, _), true) => Some((*space, it.role, new.to_owned())),
            (Thing::Prism(space, name), false) => Some((*space, it.role, name.clone())),
            _ => None,
        })
        .collect()
}

/// The workspace with some texts changed.
struct Changed<'w> {
    workspace: &'w Workspace,
    texts: BTreeMap<PathBuf, String>,
}

impl Texts for Changed<'_> {
    fn exists(&self, path: &Path) -> bool {
        self.texts.contains_key(path) || Texts::exists(self.workspace, path)
    }

    fn text(&self, path: &Path) -> Result<Source, Problem> {
        match self.texts.get(path) {
            Some(text) => Ok(Source::new(path.display().to_string(), text.clone())),
            None => Texts::text(self.workspace, path),
        }
    }
}

/// That a study whose files are changed can be read as well as before.
fn has_no_new_mistakes(
    workspace: &Workspace,
    all: &Replaced,
    texts: BTreeMap<PathBuf, String>,
) -> Result<(), String> {
    let Some(study) = all.keys().find_map(|it| workspace.study_of(it)) else {
        return Ok(());
    };
    let changed = Changed { workspace, texts };
    let problems = |texts: &dyn Texts| {
        let mut found = Problems::new();
        let read = Study::read_texts(&study.folder, texts, &mut found);
        found.keep(read.map(drop));
        found.into_problem().map_or(Vec::new(), Problem::into_each)
    };
    let (before, after) = (problems(workspace), problems(&changed));
    match after.len() > before.len() {
        true => {
            let first = after.iter().find(|it| !before.contains(it));
            let why = first.map_or_else(String::new, |it| it.message().to_owned());
            Err(format!(
                "the study could not be read with the new name: {why}"
            ))
        }
        false => Ok(()),
    }
}
