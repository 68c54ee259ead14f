//! StrictDoc's documents (`.sdoc`).
//!
//! # What is read
//! Nodes (`[REQUIREMENT]`, `[[REQUIREMENT]]`, or of any other type but a section, a document or its grammar) with a `UID`:
//! `STATEMENT`, `RATIONALE`, `STATUS`, and of `RELATIONS` those of type `Parent`. A field is one line behind its name, or the
//! lines between `>>>` and `<<<`. Nodes without a `UID` stay in the file and are counted.
//!
//! # Source
//! The grammar of StrictDoc's documents, and its user guide.

use crate::edit::{Edit, applied, line_end};
use crate::mistakes::{Mistakes, bad, cannot_write};
use crate::{Change, Columns, Document, Field, File, Format, Item, Placed};
use diagnostic::{Problem, Source, counted};
use std::ops::Range;

/// A document without requirements.
pub(crate) fn empty(title: &str) -> String {
    let title = title.split_whitespace().collect::<Vec<_>>().join(" ");
    let title = if title.is_empty() {
        "Requirements".into()
    } else {
        title
    };
    format!("[DOCUMENT]\nTITLE: {title}\n")
}

/// A field of a node.
struct Part {
    name: String,
    value: String,
    /// From the beginning of its line to the beginning of the line behind it.
    lines: Range<usize>,
    /// The text that stands for its value: behind the colon, or the lines between the marks with the marks.
    content: Range<usize>,
}

/// A node, or the head of the document.
struct Node {
    kind: String,
    head: Range<usize>,
    parts: Vec<Part>,
    /// Type and value of each relation, with the lines of the whole relation.
    relations: Vec<(String, String, Range<usize>)>,
    /// The line of `RELATIONS:`.
    relations_at: Option<Range<usize>>,
    /// Where its last line ends.
    end: usize,
}

impl Node {
    fn part(&self, name: &str) -> Option<&Part> {
        self.parts.iter().find(|part| part.name == name)
    }

    fn value(&self, name: &str) -> String {
        self.part(name)
            .map_or(String::new(), |part| part.value.clone())
    }

    fn is_requirement(&self) -> bool {
        !matches!(
            self.kind.as_str(),
            "DOCUMENT" | "GRAMMAR" | "SECTION" | "DOCUMENT_FROM_FILE" | "FREETEXT"
        )
    }
}

pub(crate) fn read(source: Source, columns: &Columns) -> Result<Document, Problem> {
    let mut mistakes = Mistakes::new(&source);
    let nodes = nodes(&source, &mut mistakes);
    let names = Names::new(&nodes, columns);
    let mut items = Vec::new();
    let (mut without_id, mut others) = (0, 0);
    for node in nodes.iter().filter(|node| node.is_requirement()) {
        let Some(id) = node.part(&names.id) else {
            without_id += 1;
            continue;
        };
        if node.part(&names.text).is_none() {
            others += 1;
            continue;
        }
        let parents = node.relations.iter().filter(|(kind, ..)| kind == "Parent");
        let item = Item {
            id: id.value.clone(),
            text: node.value(&names.text),
            rationale: node.value(&names.rationale),
            status: node.value(&names.status),
            parents: parents.map(|(_, value, _)| value.clone()).collect(),
        };
        items.push(Placed {
            item,
            source: 0,
            span: id.content.clone(),
            formulas: None,
        });
    }
    mistakes.or(())?;
    let mut notes = Vec::new();
    if without_id > 0 {
        notes.push(format!(
            "Kept in the file: {} without a {} (with a {} it is taken over).",
            counted(without_id, "node"),
            names.id,
            names.id
        ));
    }
    if others > 0 {
        notes.push(format!(
            "Kept in the file: {} without a {}.",
            counted(others, "node"),
            names.text
        ));
    }
    let fields = names.fields(&nodes);
    Ok(Document {
        format: Format::StrictDoc,
        sources: vec![source],
        items,
        fields,
        notes,
        columns: columns.clone(),
        archive: Vec::new(),
        members: Vec::new(),
        archive_name: String::new(),
    })
}

/// How the fields are called.
struct Names {
    id: String,
    text: String,
    rationale: String,
    status: String,
}

impl Names {
    fn new(nodes: &[Node], columns: &Columns) -> Self {
        let of = |field, usual: &str| columns.of(field).unwrap_or(usual).to_owned();
        let is_used = |name: &str| nodes.iter().any(|node| node.part(name).is_some());
        // Until 2021, requirements had a COMMENT in the place of a RATIONALE; it is another thing, and stays.
        let text = match is_used("STATEMENT") || !is_used("CONTENT") {
            true => "STATEMENT",
            false => "CONTENT",
        };
        Self {
            id: columns.id.clone().unwrap_or_else(|| "UID".to_owned()),
            text: of(Field::Text, text),
            rationale: of(Field::Rationale, "RATIONALE"),
            status: of(Field::Status, "STATUS"),
        }
    }

    /// Fails if the document's own grammar lets the field have some values only, and this is none of them.
    fn check(&self, nodes: &[Node], kind: &str, item: &Item, field: Field) -> Result<(), Problem> {
        let (name, value) = (self.of(field), item.value(field));
        let Some((is_single, choices)) = choices(nodes, kind, name) else {
            return Ok(());
        };
        let given = match is_single {
            true => vec![value.clone()],
            false => crate::listed(&value),
        };
        let other = given.iter().find(|it| !choices.contains(it));
        match other.filter(|_| !value.is_empty()) {
            None => Ok(()),
            Some(other) => {
                let reason = format!(
                    "its {field} is `{other}`, and the document's grammar lets {name} be one of {} only",
                    choices.join(", ")
                );
                Err(cannot_write(&item.id, &reason)
                    .remedy("give it one of these, or add a choice to the grammar"))
            }
        }
    }

    /// A grammar of the document's own says which fields there are.
    fn fields(&self, nodes: &[Node]) -> Vec<Field> {
        let grammar = nodes.iter().find(|node| node.kind == "GRAMMAR");
        let known = |name: &str| {
            grammar.is_none_or(|grammar| {
                let mut titles = grammar
                    .parts
                    .iter()
                    .filter(|part| part.name == "- TITLE")
                    .peekable();
                titles.peek().is_none() || titles.any(|part| part.value == name)
            })
        };
        let mut fields = vec![Field::Text];
        if known(&self.rationale) {
            fields.push(Field::Rationale);
        }
        if known(&self.status) {
            fields.push(Field::Status);
        }
        fields.push(Field::Parents);
        fields
    }

    fn of(&self, field: Field) -> &str {
        match field {
            Field::Text => &self.text,
            Field::Rationale => &self.rationale,
            Field::Status => &self.status,
            Field::Parents => "RELATIONS",
        }
    }
}

/// What the grammar lets a field of nodes of this kind have: whether one choice alone, and the choices.
fn choices(nodes: &[Node], kind: &str, field: &str) -> Option<(bool, Vec<String>)> {
    let grammar = nodes.iter().find(|node| node.kind == "GRAMMAR")?;
    let (mut tag, mut title) = ("", "");
    for part in &grammar.parts {
        match part.name.as_str() {
            "- TAG" => (tag, title) = (part.value.trim(), ""),
            "- TITLE" => title = part.value.trim(),
            "TYPE" if (tag, title) == (kind, field) => {
                let (form, inner) = part.value.trim().strip_suffix(')')?.split_once('(')?;
                let is_single = match form {
                    "SingleChoice" => true,
                    "MultipleChoice" => false,
                    _ => return None,
                };
                return Some((is_single, crate::listed(inner)));
            }
            _ => {}
        }
    }
    None
}

/// A line with its place, without its end.
struct Line<'t> {
    text: &'t str,
    start: usize,
    /// The beginning of the next line.
    next: usize,
}

fn lines(text: &str) -> Vec<Line<'_>> {
    let mut start = 0;
    let lines = text.split_inclusive('\n').map(|whole| {
        let line = Line {
            text: whole.trim_end_matches(['\n', '\r']),
            start,
            next: start + whole.len(),
        };
        start = line.next;
        line
    });
    lines.collect()
}

fn nodes(source: &Source, mistakes: &mut Mistakes<'_>) -> Vec<Node> {
    let text = &source.text;
    let lines = lines(text);
    let first = lines
        .iter()
        .find(|line| !line.text.trim_matches('\u{feff}').is_empty());
    if first.is_none_or(|line| line.text.trim_start_matches('\u{feff}') != "[DOCUMENT]") {
        let at = first.map_or(0, |line| line.start);
        mistakes.add(
            at..at + 1,
            "this is not a document of StrictDoc",
            "its first line has to be `[DOCUMENT]`",
        );
        return Vec::new();
    }
    let mut nodes: Vec<Node> = Vec::new();
    let mut at = 0;
    while let Some(line) = lines.get(at) {
        let bare = line.text.trim_start_matches('\u{feff}');
        if let Some(kind) = head(bare) {
            nodes.push(Node {
                kind: kind.to_owned(),
                head: line.start..line.start + line.text.len(),
                parts: Vec::new(),
                relations: Vec::new(),
                relations_at: None,
                end: line.next,
            });
            at += 1;
            continue;
        }
        match nodes.last_mut() {
            Some(node)
                if !bare.trim().is_empty()
                    && !bare.starts_with("[/")
                    && !bare.starts_with("[[/") =>
            {
                at = part(text, &lines, at, node, mistakes);
                node.end = lines.get(at).map_or(text.len(), |next| next.start);
            }
            _ => at += 1,
        }
    }
    nodes
}

/// The type of a node, of its first line.
fn head(line: &str) -> Option<&str> {
    let inner = match line.strip_prefix("[[") {
        Some(inner) => inner.strip_suffix("]]")?,
        None => line.strip_prefix('[')?.strip_suffix(']')?,
    };
    let is_name = |letter: char| {
        letter.is_ascii_uppercase() || letter.is_ascii_digit() || "_-".contains(letter)
    };
    (!inner.is_empty() && inner.chars().all(is_name)).then_some(inner)
}

/// Reads the field that begins in a line, and gives the line behind it.
fn part(
    text: &str,
    lines: &[Line<'_>],
    at: usize,
    node: &mut Node,
    mistakes: &mut Mistakes<'_>,
) -> usize {
    let line = &lines[at];
    // The grammar's elements and options are indented; they are kept as they are.
    if line.text == "RELATIONS:" || line.text == "REFS:" {
        node.relations_at = Some(line.start..line.next);
        return relations(lines, at + 1, node);
    }
    let Some((name, value)) = line.text.split_once(':') else {
        if node.is_requirement() {
            mistakes.add(
                line.start..line.start + line.text.len().max(1),
                "this line is neither a field nor a part of one",
                "write `NAME: value`, or put several lines between `>>>` and `<<<`",
            );
        }
        return at + 1;
    };
    let content = line.start + name.len() + 1;
    if value.trim() != ">>>" {
        let inner = value.strip_prefix(' ').unwrap_or(value);
        node.parts.push(Part {
            name: name.trim().to_owned(),
            value: inner.trim_end().to_owned(),
            lines: line.start..line.next,
            content: line.start + line.text.len() - inner.len()..line.start + line.text.len(),
        });
        return at + 1;
    }
    let close = (at + 1..lines.len()).find(|it| lines[*it].text.starts_with("<<<"));
    let Some(close) = close else {
        mistakes.add(
            content..line.start + line.text.len(),
            "this field has no end",
            "close it with `<<<` in a line of its own",
        );
        return lines.len();
    };
    let inner = &text[lines[at + 1].start..lines[close].start];
    node.parts.push(Part {
        name: name.trim().to_owned(),
        value: inner
            .replace("\r\n", "\n")
            .trim_end_matches('\n')
            .to_owned(),
        lines: line.start..lines[close].next,
        content: content + 1..lines[close].start + lines[close].text.len(),
    });
    close + 1
}

fn relations(lines: &[Line<'_>], mut at: usize, node: &mut Node) -> usize {
    while let Some(line) = lines.get(at) {
        if let Some(kind) = line.text.strip_prefix("- TYPE:") {
            node.relations
                .push((kind.trim().to_owned(), String::new(), line.start..line.next));
        } else if let (Some(value), Some(last)) = (
            line.text.trim_start().strip_prefix("VALUE:"),
            node.relations.last_mut(),
        ) {
            last.1 = value.trim().to_owned();
            last.2.end = line.next;
        } else if line.text.starts_with("  ") {
            if let Some(last) = node.relations.last_mut() {
                last.2.end = line.next;
            }
        } else {
            break;
        }
        at += 1;
    }
    at
}

pub(crate) fn with(document: &Document, changes: &[Change]) -> Result<Vec<File>, Problem> {
    let mut source = document.sources[0].clone();
    let end = line_end(&source.text);
    if !source.text.ends_with('\n') {
        source.text.push_str(end);
    }
    let source = &source;
    let mut mistakes = Mistakes::new(source);
    let nodes = nodes(source, &mut mistakes);
    mistakes.or(())?;
    let names = Names::new(&nodes, &document.columns);
    let mut edits = Vec::new();
    let mut added = String::new();
    for change in changes {
        match change {
            Change::Set(item, fields) => {
                let node = nodes
                    .iter()
                    .find(|node| node.is_requirement() && node.value(&names.id) == item.id);
                let node =
                    node.ok_or_else(|| cannot_write(&item.id, "the file does not have it"))?;
                // Relations stand behind all fields.
                let mut fields = fields.clone();
                fields.sort();
                for field in fields {
                    names.check(&nodes, &node.kind, item, field)?;
                    edits.extend(set(node, item, field, &names, end)?);
                }
            }
            Change::Add(item) => added.push_str(&node_of(item, document, &nodes, &names, end)?),
        }
    }
    if !added.is_empty() {
        edits.push(behind_all(&source.text, &added, end));
    }
    Ok(vec![File {
        name: source.name.clone(),
        bytes: applied(&source.text, edits).into_bytes(),
    }])
}

/// New nodes stand at the end, an empty line before each.
fn behind_all(text: &str, added: &str, end: &str) -> Edit {
    let has_empty_line = text.ends_with(&format!("\n{end}"));
    let added = match has_empty_line {
        true => added.strip_prefix(end).unwrap_or(added),
        false => added,
    };
    Edit::insert(text.len(), added)
}

/// How a value is written behind the name of its field.
fn written(id: &str, value: &str, end: &str) -> Result<String, Problem> {
    if value.lines().any(|line| line.starts_with("<<<")) {
        return Err(cannot_write(
            id,
            "a line that begins with `<<<` would end the field",
        ));
    }
    let is_line =
        !value.contains('\n') && !value.starts_with(char::is_whitespace) && value != ">>>";
    Ok(match is_line && value == value.trim_end() {
        true => value.to_owned(),
        false => format!(">>>{end}{}{end}<<<", value.replace('\n', end)),
    })
}

fn set(
    node: &Node,
    item: &Item,
    field: Field,
    names: &Names,
    end: &str,
) -> Result<Vec<Edit>, Problem> {
    if field == Field::Parents {
        return Ok(vec![parents(node, item, end)]);
    }
    let name = names.of(field);
    let value = item.value(field);
    Ok(match (node.part(name), value.is_empty()) {
        (Some(part), true) => vec![Edit::replace(part.lines.clone(), "")],
        (Some(part), false) => vec![Edit::replace(
            part.content.clone(),
            written(&item.id, &value, end)?,
        )],
        (None, true) => Vec::new(),
        (None, false) => {
            // A grammar has its fields in order: the status before the title, the rationale behind the statement.
            let behind = match field {
                Field::Status => &names.id,
                _ => &names.text,
            };
            let at = node
                .part(behind)
                .map_or(node.head.end, |part| part.lines.end);
            vec![Edit::insert(
                at,
                format!("{name}: {}{end}", written(&item.id, &value, end)?),
            )]
        }
    })
}

/// The relations with other parents: those of other types stay.
fn parents(node: &Node, item: &Item, end: &str) -> Edit {
    let entry = |parent: &String| format!("- TYPE: Parent{end}  VALUE: {parent}{end}");
    let missing = item.parents.iter().filter(|parent| {
        !node
            .relations
            .iter()
            .any(|(kind, value, _)| kind == "Parent" && value == *parent)
    });
    let missing: String = missing.map(entry).collect();
    let Some(at) = &node.relations_at else {
        return Edit::insert(node.end, format!("RELATIONS:{end}{missing}"));
    };
    let last = node
        .relations
        .last()
        .map_or(at.end, |(.., lines)| lines.end);
    let others: Vec<_> = node
        .relations
        .iter()
        .filter(|(kind, ..)| kind != "Parent")
        .collect();
    if item.parents.is_empty() && others.is_empty() {
        return Edit::replace(at.start..last, "");
    }
    let mut new = format!("RELATIONS:{end}");
    for parent in &item.parents {
        new.push_str(&entry(parent));
    }
    for (kind, value, _) in others {
        new.push_str(&format!("- TYPE: {kind}{end}  VALUE: {value}{end}"));
    }
    Edit::replace(at.start..last, new)
}

fn node_of(
    item: &Item,
    document: &Document,
    nodes: &[Node],
    names: &Names,
    end: &str,
) -> Result<String, Problem> {
    // As most of the document's nodes are called.
    let mut kinds = nodes
        .iter()
        .filter(|node| node.is_requirement() && node.part(&names.id).is_some());
    let kind = kinds
        .next_back()
        .map_or("REQUIREMENT", |node| node.kind.as_str());
    let mut node = format!("{end}[{kind}]{end}{}: {}{end}", names.id, item.id);
    let mut field = |field: Field| -> Result<(), Problem> {
        let value = item.value(field);
        if !value.is_empty() && document.fields.contains(&field) {
            names.check(nodes, kind, item, field)?;
            node.push_str(&format!(
                "{}: {}{end}",
                names.of(field),
                written(&item.id, &value, end)?
            ));
        }
        Ok(())
    };
    field(Field::Status)?;
    if item.text.is_empty() {
        return Err(bad(format!("`{}` has no text", item.id)).remedy("give it one"));
    }
    field(Field::Text)?;
    field(Field::Rationale)?;
    if !item.parents.is_empty() {
        node.push_str(&format!("RELATIONS:{end}"));
        for parent in &item.parents {
            node.push_str(&format!("- TYPE: Parent{end}  VALUE: {parent}{end}"));
        }
    }
    Ok(node)
}
