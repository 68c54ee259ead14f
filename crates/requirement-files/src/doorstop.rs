//! Folders of Doorstop.
//!
//! # What is read
//! The files of one folder with a `.doorstop.yml`: each item (`UID.yml`, or `UID.md` with YAML before the text) has its `text`;
//! its parents are the ids of its `links`; rationale and status are attributes of these names, where the folder's items have
//! such. Items that are not `active` or not `normative` stay in their files and are counted. In Markdown, the first heading of
//! the text is the item's header and stays.
//!
//! # Source
//! Doorstop's reference of items and documents (version 3).

mod yaml;

use crate::edit::{Edit, applied, line_end};
use crate::mistakes::{bad, cannot_write};
use crate::{Change, Columns, Document, Field, File, Format, Item, Placed};
use diagnostic::{Problem, Source, counted};
use std::ops::Range;
use yaml::{Mapping, Value};

/// The file that makes a folder one of Doorstop's.
const SETTINGS: &str = ".doorstop.yml";

/// Whether a file of a folder of Doorstop is to be read: the settings, and what can be an item.
#[must_use]
pub fn is_item_file(name: &str) -> bool {
    name == SETTINGS
        || (!name.starts_with('.') && (name.ends_with(".yml") || name.ends_with(".md")))
}

/// The settings of a folder without items, whose ids are like this one.
pub(crate) fn empty(first_id: &str) -> Result<String, Problem> {
    let digits = first_id.len()
        - first_id
            .trim_end_matches(|it: char| it.is_ascii_digit())
            .len();
    let front = &first_id[..first_id.len() - digits];
    let prefix = front.trim_end_matches(['-', '_', '.']);
    if digits == 0 || prefix.is_empty() {
        return Err(does_not_fit(
            first_id,
            "letters and a number, such as REQ001 or REQ-1",
        ));
    }
    let separator = &front[prefix.len()..];
    Ok(format!(
        "settings:\n  digits: {digits}\n  prefix: {}\n  sep: {}\n",
        yaml::quoted(prefix),
        yaml::quoted(separator)
    ))
}

fn does_not_fit(id: &str, expected: &str) -> Problem {
    cannot_write(
        id,
        &format!("ids of this folder of Doorstop are {expected}"),
    )
    .remedy("give the requirement such an id, or export to another format")
}

/// A folder's settings.
struct Settings {
    prefix: String,
    separator: String,
    is_markdown: bool,
}

impl Settings {
    fn of(sources: &[Source]) -> Result<Self, Problem> {
        let source = sources.iter().find(|it| it.name == SETTINGS);
        let source = source.ok_or_else(|| {
            bad(format!("the folder has no {SETTINGS}")).remedy("name a folder of Doorstop")
        })?;
        let root = yaml::read(source, 0..source.text.len())?;
        let settings = match root.get("settings").map(|it| &it.value) {
            Some(Value::Mapping(settings)) => settings,
            _ => {
                return Err(bad("the settings of the folder are missing")
                    .at(source, 0..1)
                    .remedy("write `settings:` with `prefix`, `digits` and `sep`"));
            }
        };
        let text = |key: &str| settings.text(key).unwrap_or_default().to_owned();
        Ok(Self {
            prefix: text("prefix"),
            separator: text("sep"),
            is_markdown: text("itemformat") == "markdown",
        })
    }

    /// Whether an id can be one of this folder.
    fn fits(&self, id: &str) -> bool {
        let Some(rest) = id.strip_prefix(&self.prefix) else {
            return false;
        };
        let Some(rest) = rest.strip_prefix(&self.separator) else {
            return false;
        };
        let is_number = !rest.is_empty() && rest.bytes().all(|it| it.is_ascii_digit());
        let is_name =
            !self.separator.is_empty() && !rest.is_empty() && !rest.contains(&self.separator);
        let is_file_name =
            !id.contains(['/', '\\']) && !id.starts_with('.') && !id.contains(char::is_control);
        (is_number || is_name) && is_file_name
    }
}

/// The parts of an item's file.
struct Parts {
    mapping: Mapping,
    /// In Markdown, the place of the text behind the heading.
    body: Option<Range<usize>>,
}

fn parts(source: &Source) -> Result<Parts, Problem> {
    if !source.name.ends_with(".md") {
        let mapping = yaml::read(source, 0..source.text.len())?;
        return Ok(Parts {
            mapping,
            body: None,
        });
    }
    let text = &source.text;
    let front = text
        .strip_prefix("---\n")
        .map(|_| 4)
        .or_else(|| text.strip_prefix("---\r\n").map(|_| 5));
    let end = front.and_then(|front| {
        text[front..]
            .find("\n---")
            .map(|at| (front, front + at + 1))
    });
    let Some((front, end)) = end else {
        return Err(bad("the item has no attributes before its text")
            .at(source, 0..1)
            .remedy("begin it with `---`, the attributes, and `---`"));
    };
    let mapping = yaml::read(source, front..end)?;
    let mut body = text[end..].find('\n').map_or(text.len(), |at| end + at + 1);
    let rest = text[body..].trim_start_matches(['\r', '\n']);
    body = text.len() - rest.len();
    if rest.starts_with("# ") {
        let rest = rest
            .find('\n')
            .map_or("", |at| &rest[at..])
            .trim_start_matches(['\r', '\n']);
        body = text.len() - rest.len();
    }
    let end = body + text[body..].trim_end().len();
    Ok(Parts {
        mapping,
        body: Some(body..end),
    })
}

pub(crate) fn read(sources: Vec<Source>, columns: &Columns) -> Result<Document, Problem> {
    let settings = Settings::of(&sources)?;
    let mut problems = Vec::new();
    let mut items = Vec::new();
    let (mut idle, mut others) = (0, 0);
    let mut used = Vec::new();
    for (at, source) in sources.iter().enumerate() {
        if source.name == SETTINGS {
            continue;
        }
        let id = source.name.rsplit_once('.').map_or("", |(stem, _)| stem);
        if !settings.fits(id) {
            others += 1;
            continue;
        }
        let parts = match parts(source) {
            Ok(parts) => parts,
            Err(problem) => {
                problems.push(problem);
                continue;
            }
        };
        let is_off = |key: &str| parts.mapping.text(key) == Some("false");
        if is_off("active") || is_off("normative") {
            idle += 1;
            continue;
        }
        for (field, name) in [
            (Field::Rationale, columns.of(Field::Rationale)),
            (Field::Status, columns.of(Field::Status)),
        ] {
            if parts.mapping.get(name.unwrap_or(field.name())).is_some() && !used.contains(&field) {
                used.push(field);
            }
        }
        items.push(Placed {
            item: item(id, source, &parts, columns),
            source: at,
            span: 0..1,
            formulas: None,
        });
    }
    if let Some(problem) = Problem::all(problems) {
        return Err(problem);
    }
    items.sort_by(|one: &Placed, two| one.item.id.cmp(&two.item.id));
    let mut notes = Vec::new();
    if idle > 0 {
        notes.push(format!(
            "Kept in the folder: {} that are not active or not normative.",
            counted(idle, "item")
        ));
    }
    if others > 0 {
        notes.push(format!(
            "Kept in the folder: {} whose names do not fit its ids.",
            counted(others, "file")
        ));
    }
    let mut fields = vec![Field::Text];
    fields.extend(used);
    fields.push(Field::Parents);
    fields.sort();
    Ok(Document {
        format: Format::Doorstop,
        sources,
        items,
        fields,
        notes,
        columns: columns.clone(),
        archive: Vec::new(),
        members: Vec::new(),
        archive_name: String::new(),
    })
}

fn item(id: &str, source: &Source, parts: &Parts, columns: &Columns) -> Item {
    let value = |field: Field| {
        let name = columns.of(field).unwrap_or(field.name());
        parts
            .mapping
            .text(name)
            .unwrap_or_default()
            .trim_end_matches('\n')
            .to_owned()
    };
    let links = match parts.mapping.get("links").map(|it| &it.value) {
        Some(Value::List(links)) => links.iter().filter_map(link).collect(),
        _ => Vec::new(),
    };
    Item {
        id: id.to_owned(),
        text: match &parts.body {
            Some(body) => source.text[body.clone()].replace("\r\n", "\n"),
            None => value(Field::Text),
        },
        rationale: value(Field::Rationale),
        status: value(Field::Status),
        parents: links,
    }
}

/// The id that a link names: by itself, or with the fingerprint behind it.
fn link(value: &Value) -> Option<String> {
    match value {
        Value::Text(id) => Some(id.clone()),
        Value::Mapping(mapping) => mapping.entries.first().map(|entry| entry.key.clone()),
        _ => None,
    }
}

pub(crate) fn with(document: &Document, changes: &[Change]) -> Result<Vec<File>, Problem> {
    let settings = Settings::of(&document.sources)?;
    let mut files = Vec::new();
    let mut level = document.items.len();
    for change in changes {
        match change {
            Change::Set(item, fields) => {
                let placed = document.item(&item.id);
                let placed =
                    placed.ok_or_else(|| cannot_write(&item.id, "the folder does not have it"))?;
                let source = &document.sources[placed.source];
                let edits = edits(source, item, fields, &document.columns)?;
                files.push(File {
                    name: source.name.clone(),
                    bytes: applied(&source.text, edits).into_bytes(),
                });
            }
            Change::Add(item) => {
                if !settings.fits(&item.id) {
                    let expected =
                        format!("`{}{}` and a number", settings.prefix, settings.separator);
                    return Err(does_not_fit(&item.id, &expected));
                }
                level += 1;
                files.push(new_file(item, &settings, level, document));
            }
        }
    }
    // A new folder needs its settings, too.
    if document.items.is_empty() && document.sources.len() == 1 {
        files.push(File {
            name: SETTINGS.to_owned(),
            bytes: document.sources[0].text.clone().into_bytes(),
        });
    }
    Ok(files)
}

fn edits(
    source: &Source,
    item: &Item,
    fields: &[Field],
    columns: &Columns,
) -> Result<Vec<Edit>, Problem> {
    let parts = parts(source)?;
    let end = line_end(&source.text);
    let mut edits = Vec::new();
    for field in fields {
        if let (Field::Text, Some(body)) = (field, &parts.body) {
            edits.push(Edit::replace(body.clone(), item.text.replace('\n', end)));
            continue;
        }
        let name = columns.of(*field).unwrap_or(field.name());
        let (name, value) = match field {
            Field::Parents => ("links", links(item, &source.text, &parts, end)),
            _ => (name, yaml::scalar(&item.value(*field), end)),
        };
        let entry = format!("{name}: {value}{end}");
        let entry = match value.starts_with(end) {
            true => format!("{name}:{value}{end}"),
            false => entry,
        };
        match parts.mapping.get(name) {
            Some(known) => edits.push(Edit::replace(known.lines.clone(), entry)),
            None => edits.push(Edit::insert(parts.mapping.end, entry)),
        }
    }
    Ok(edits)
}

/// The links, those that stay with the fingerprints that they had.
fn links(item: &Item, text: &str, parts: &Parts, end: &str) -> String {
    if item.parents.is_empty() {
        return "[]".to_owned();
    }
    let known = match parts.mapping.get("links").map(|it| &it.value) {
        Some(Value::List(links)) => links.as_slice(),
        _ => &[],
    };
    let _ = text;
    let entry = |parent: &String| {
        let fingerprint = known.iter().find_map(|value| match value {
            Value::Mapping(mapping)
                if mapping.entries.first().is_some_and(|it| it.key == *parent) =>
            {
                mapping.text(parent)
            }
            _ => None,
        });
        match fingerprint {
            Some(fingerprint) => format!("{end}- {parent}: {fingerprint}"),
            None => format!("{end}- {parent}"),
        }
    };
    item.parents.iter().map(entry).collect()
}

fn new_file(item: &Item, settings: &Settings, level: usize, document: &Document) -> File {
    let links = match item.parents.is_empty() {
        true => " []".to_owned(),
        false => item.parents.iter().map(|it| format!("\n- {it}")).collect(),
    };
    let mut head = format!(
        "active: true\nderived: false\n{}level: 1.{level}\nlinks:{links}\nnormative: true\nref: ''\n",
        if settings.is_markdown {
            ""
        } else {
            "header: ''\n"
        }
    );
    for field in [Field::Rationale, Field::Status] {
        let value = item.value(field);
        if !value.is_empty() && document.fields.contains(&field) {
            let name = document.columns.of(field).unwrap_or(field.name());
            head.push_str(&format!("{name}: {}\n", yaml::scalar(&value, "\n")));
        }
    }
    head.push_str("reviewed: null\n");
    let (ending, text) = match settings.is_markdown {
        true => ("md", format!("---\n{head}---\n\n{}\n", item.text)),
        false => (
            "yml",
            format!("{head}text: {}\n", yaml::scalar(&item.text, "\n")),
        ),
    };
    File {
        name: format!("{}.{ending}", item.id),
        bytes: text.into_bytes(),
    }
}
