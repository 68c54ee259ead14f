//! Tables in CSV whose first line names the columns.
//!
//! # What is read
//! RFC 4180: fields in quotes may hold commas, line breaks and doubled quotes. Commas, semicolons or tabs separate; the first
//! line says which; of a file whose name ends with `.tsv`, tabs do if it has one. The columns of the fields are those that [`Columns`] name, else those of the usual names ([`USUAL`], in any
//! case). Other columns stay as they are.

use crate::edit::{Edit, applied, line_end};
use crate::mistakes::{Mistakes, cannot_write};
use crate::{Change, Columns, Document, Field, File, Format, Item, Placed};
use diagnostic::{Problem, Source, counted};
use std::ops::Range;

/// A table without requirements, for a file of this name.
pub(crate) fn empty(name: &str) -> String {
    let columns = ["id", "text", "rationale", "status", "parents"];
    let separator = if has_tabs(name) { "\t" } else { "," };
    columns.join(separator) + "\n"
}

/// Whether a file of this name is a table with tabs.
fn has_tabs(name: &str) -> bool {
    let ending = name.rsplit_once('.').map(|(_, ending)| ending);
    ending.is_some_and(|ending| ending.eq_ignore_ascii_case("tsv"))
}

/// How columns are usually called; the first of each list goes before the others.
const USUAL: [(Option<Field>, &[&str]); 5] = [
    (
        None,
        &[
            "id",
            "uid",
            "reqid",
            "req id",
            "requirement id",
            "identifier",
            "key",
        ],
    ),
    (
        Some(Field::Text),
        &[
            "text",
            "statement",
            "requirement",
            "description",
            "fulltext",
            "requirement text",
        ],
    ),
    (Some(Field::Rationale), &["rationale", "reason"]),
    (Some(Field::Status), &["status", "state"]),
    (
        Some(Field::Parents),
        &["parents", "parent", "parent id", "derived from", "links"],
    ),
];

/// A field of a row, with its place.
#[derive(Clone, Debug)]
struct Cell {
    span: Range<usize>,
    value: String,
}

struct Row {
    cells: Vec<Cell>,
    /// Where the row ends, before its line break.
    end: usize,
}

struct Table {
    separator: char,
    rows: Vec<Row>,
}

fn table(source: &Source, mistakes: &mut Mistakes<'_>) -> Table {
    let text = &source.text;
    let start = if text.starts_with('\u{feff}') { 3 } else { 0 };
    let first = text[start..].lines().next().unwrap_or_default();
    let count = |sign: char| first.matches(sign).count();
    let most = [',', ';', '\t']
        .into_iter()
        .max_by_key(|sign| (count(*sign), *sign == ','))
        .filter(|sign| count(*sign) > 0);
    let separator = match (has_tabs(&source.name), most) {
        // A name of a column may have commas.
        (true, _) if count('\t') > 0 => '\t',
        (true, None) => '\t',
        (_, most) => most.unwrap_or(','),
    };
    let mut rows = Vec::new();
    let mut at = start;
    while at < text.len() {
        let (row, next) = row(text, at, separator, mistakes);
        let is_empty = row.cells.len() == 1 && row.cells[0].span.is_empty();
        if !is_empty {
            rows.push(row);
        }
        at = next;
    }
    Table { separator, rows }
}

fn row(text: &str, start: usize, separator: char, mistakes: &mut Mistakes<'_>) -> (Row, usize) {
    let mut cells = Vec::new();
    let mut at = start;
    loop {
        let (cell, end) = cell(text, at, separator, mistakes);
        cells.push(cell);
        let rest = &text[end..];
        if rest.starts_with(separator) {
            at = end + 1;
            continue;
        }
        let line_break = match rest {
            _ if rest.starts_with("\r\n") => 2,
            "" => 0,
            _ => 1,
        };
        return (Row { cells, end }, end + line_break);
    }
}

fn cell(text: &str, start: usize, separator: char, mistakes: &mut Mistakes<'_>) -> (Cell, usize) {
    let ends = |letter: char| letter == separator || letter == '\n' || letter == '\r';
    let bare_end = |from: usize| text[from..].find(ends).map_or(text.len(), |at| from + at);
    if !text[start..].starts_with('"') {
        let end = bare_end(start);
        let value = text[start..end].to_owned();
        return (
            Cell {
                span: start..end,
                value,
            },
            end,
        );
    }
    let mut value = String::new();
    let mut at = start + 1;
    loop {
        let Some(quote) = text[at..].find('"').map(|found| at + found) else {
            mistakes.add(
                start..start + 1,
                "this field in quotes has no end",
                "close it with a quote; quotes in it are doubled",
            );
            return (
                Cell {
                    span: start..text.len(),
                    value,
                },
                text.len(),
            );
        };
        value.push_str(&text[at..quote]);
        at = quote + 1;
        if !text[at..].starts_with('"') {
            break;
        }
        value.push('"');
        at += 1;
    }
    let end = bare_end(at);
    if end > at {
        mistakes.add(
            at..end,
            "text follows the quote that ends the field",
            "put the whole field into quotes, and double the quotes in it",
        );
    }
    let value = value.replace("\r\n", "\n");
    (
        Cell {
            span: start..end,
            value,
        },
        end,
    )
}

/// Which column is which.
struct Layout {
    id: usize,
    fields: Vec<(Field, usize)>,
}

fn layout(
    source: &Source,
    table: &Table,
    columns: &Columns,
    mistakes: &mut Mistakes<'_>,
) -> Option<Layout> {
    let Some(header) = table.rows.first() else {
        mistakes.add(
            0..0,
            "the table is empty",
            "its first line names the columns, for example `id,text`",
        );
        return None;
    };
    let names: Vec<String> = header
        .cells
        .iter()
        .map(|cell| cell.value.trim().to_lowercase())
        .collect();
    let place = header.cells[0].span.start..header.end;
    let mut of = |field: Option<Field>, declared: Option<&str>, is_needed: bool| {
        let usual = USUAL
            .iter()
            .find(|(known, _)| *known == field)
            .map_or(&[][..], |(_, names)| names);
        let found = match declared {
            Some(name) => names
                .iter()
                .position(|known| *known == name.trim().to_lowercase()),
            None => usual
                .iter()
                .find_map(|name| names.iter().position(|known| known == name)),
        };
        let what = field.map_or("id", Field::name);
        match (found, declared) {
            (None, Some(name)) => {
                let message = format!("the table has no column `{name}`");
                mistakes.add(place.clone(), message, "name one of its columns");
            }
            (None, None) if is_needed => {
                let message = format!("the table has no column for the {what} of requirements");
                mistakes.add(
                    place.clone(),
                    message,
                    "name it with `--field`, for example `--field text=Description`",
                );
            }
            _ => {}
        }
        found
    };
    let id = of(None, columns.id.as_deref(), true);
    let mut fields = Vec::new();
    for field in Field::ALL {
        let found = of(Some(field), columns.of(field), field == Field::Text);
        fields.extend(found.map(|column| (field, column)));
    }
    let _ = source;
    Some(Layout { id: id?, fields })
}

pub(crate) fn read(source: Source, columns: &Columns) -> Result<Document, Problem> {
    let mut mistakes = Mistakes::new(&source);
    let table = table(&source, &mut mistakes);
    let layout = layout(&source, &table, columns, &mut mistakes);
    let mut items = Vec::new();
    let mut notes = Vec::new();
    let mut fields = Vec::new();
    if let Some(layout) = &layout {
        fields = layout.fields.iter().map(|(field, _)| *field).collect();
        let width = table.rows[0].cells.len();
        let mut without_id = 0;
        for row in &table.rows[1..] {
            if row.cells.len() != width {
                let message = format!(
                    "this row has {}, and the first line {width}",
                    counted(row.cells.len(), "field")
                );
                let start = row.cells[0].span.start;
                mistakes.add(
                    start..row.end,
                    message,
                    "put fields that hold a separator or a line break into quotes",
                );
                continue;
            }
            let id = row.cells[layout.id].value.trim().to_owned();
            if id.is_empty() {
                without_id += 1;
                continue;
            }
            items.push(placed(row, layout, id));
        }
        if without_id > 0 {
            notes.push(format!(
                "Kept in the file: {} without an id.",
                counted(without_id, "row")
            ));
        }
        let other = width.saturating_sub(layout.fields.len() + 1);
        if other > 0 {
            notes.push(format!(
                "Kept in the file: {} of other contents.",
                counted(other, "column")
            ));
        }
    }
    mistakes.or(())?;
    Ok(Document {
        format: Format::Csv,
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

fn placed(row: &Row, layout: &Layout, id: String) -> Placed {
    let value = |field: Field| {
        let column = layout.fields.iter().find(|(known, _)| *known == field);
        column.map_or(String::new(), |(_, column)| {
            row.cells[*column].value.clone()
        })
    };
    Placed {
        item: Item {
            id,
            text: value(Field::Text),
            rationale: value(Field::Rationale),
            status: value(Field::Status),
            parents: crate::listed(&value(Field::Parents)),
        },
        source: 0,
        span: row.cells[layout.id].span.clone(),
        formulas: None,
    }
}

pub(crate) fn with(document: &Document, changes: &[Change]) -> Result<Vec<File>, Problem> {
    let source = &document.sources[0];
    let mut mistakes = Mistakes::new(source);
    let table = table(source, &mut mistakes);
    let layout = layout(source, &table, &document.columns, &mut mistakes);
    mistakes.or(())?;
    let layout = layout.ok_or_else(|| cannot_write(&source.name, "it has no columns"))?;
    let end = line_end(&source.text);
    let mut edits = Vec::new();
    let mut rows = String::new();
    for change in changes {
        match change {
            Change::Set(item, fields) => {
                let row = table.rows[1..].iter().find(|row| {
                    row.cells
                        .get(layout.id)
                        .is_some_and(|cell| cell.value.trim() == item.id)
                });
                let row = row.ok_or_else(|| cannot_write(&item.id, "the file does not have it"))?;
                for (field, column) in layout
                    .fields
                    .iter()
                    .filter(|(field, _)| fields.contains(field))
                {
                    let text = quoted(&item.value(*field), table.separator, end);
                    edits.push(Edit::replace(row.cells[*column].span.clone(), text));
                }
            }
            Change::Add(item) => {
                let width = table.rows[0].cells.len();
                let cells = (0..width).map(|column| {
                    let field = layout.fields.iter().find(|(_, known)| *known == column);
                    match field {
                        _ if column == layout.id => quoted(&item.id, table.separator, end),
                        Some((field, _)) => quoted(&item.value(*field), table.separator, end),
                        None => String::new(),
                    }
                });
                let cells: Vec<String> = cells.collect();
                rows.push_str(&cells.join(&table.separator.to_string()));
                rows.push_str(end);
            }
        }
    }
    if !rows.is_empty() {
        let is_open = !source.text.is_empty() && !source.text.ends_with('\n');
        let rows = if is_open {
            format!("{end}{rows}")
        } else {
            rows
        };
        edits.push(Edit::insert(source.text.len(), rows));
    }
    Ok(vec![File {
        name: source.name.clone(),
        bytes: applied(&source.text, edits).into_bytes(),
    }])
}

/// A field as it is written, in quotes where it needs them.
fn quoted(value: &str, separator: char, end: &str) -> String {
    let needs = value.contains([separator, '"', '\n', '\r']) || value != value.trim();
    match needs {
        true => format!("\"{}\"", value.replace('"', "\"\"").replace('\n', end)),
        false => value.to_owned(),
    }
}
