//! Values in the text of a TOML file, found with their places, so that all else stays as it is written.

use prism_lang::Span;
use prism_lang::edit::Edit;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

pub(crate) type Table<'a> = DeTable<'a>;

pub(crate) fn get<'t, 'a>(table: &'t Table<'a>, key: &str) -> Option<&'t Spanned<DeValue<'a>>> {
    let mut all = table.iter();
    all.find(|(name, _)| name.get_ref().as_ref() == key)
        .map(|(_, value)| value)
}

pub(crate) fn table_of<'t, 'a>(table: &'t Table<'a>, key: &str) -> Option<&'t Table<'a>> {
    match get(table, key)?.get_ref() {
        DeValue::Table(table) => Some(table),
        _ => None,
    }
}

/// The first table with this `id` in the arrays of tables of these names.
pub(crate) fn with_id<'t, 'a>(
    document: &'t Table<'a>,
    arrays: &[&str],
    id: &str,
) -> Option<&'t Table<'a>> {
    let arrays = arrays.iter();
    let arrays = arrays.filter_map(|kind| match get(document, kind)?.get_ref() {
        DeValue::Array(array) => Some(array),
        _ => None,
    });
    let tables = arrays.flat_map(|array| array.iter());
    let mut tables = tables.filter_map(|value| match value.get_ref() {
        DeValue::Table(table) => Some(table),
        _ => None,
    });
    tables.find(|table| {
        let own = get(table, "id").map(Spanned::get_ref);
        matches!(own, Some(DeValue::String(own)) if own.as_ref() == id)
    })
}

pub(crate) fn span_of(value: &Spanned<DeValue>) -> Span {
    Span::new(value.span().start, value.span().end)
}

pub(crate) fn number(value: &DeValue) -> Option<f64> {
    match value {
        DeValue::Integer(value) => value.as_str().replace('_', "").parse().ok(),
        DeValue::Float(value) => value.as_str().replace('_', "").parse().ok(),
        _ => None,
    }
}

/// Edits that take out the lines of a key with all that it holds, dotted or not.
pub(crate) fn without(text: &str, table: &Table, key: &str) -> Vec<Edit> {
    let mut lines: Vec<(usize, usize)> = Vec::new();
    let all = table.iter();
    for (name, value) in all.filter(|(name, _)| name.get_ref().as_ref() == key) {
        let start = name.span().start;
        match value.get_ref() {
            DeValue::Table(inner) if !text[value.span()].starts_with('{') => {
                leaves(text, inner, &mut lines);
            }
            _ => lines.push(line(text, start, value.span().end)),
        }
    }
    lines.sort_unstable();
    lines.dedup();
    let edit = |(start, end): (usize, usize)| Edit::replace(Span::new(start, end), "");
    lines.into_iter().map(edit).collect()
}

fn leaves(text: &str, table: &Table, lines: &mut Vec<(usize, usize)>) {
    for (name, value) in table.iter() {
        match value.get_ref() {
            DeValue::Table(inner) if !text[value.span()].starts_with('{') => {
                leaves(text, inner, lines);
            }
            _ => lines.push(line(text, name.span().start, value.span().end)),
        }
    }
}

/// From the beginning of the line of `start` to the beginning of the line behind `end`.
fn line(text: &str, start: usize, end: usize) -> (usize, usize) {
    let from = text[..start].rfind('\n').map_or(0, |place| place + 1);
    let to = text[end..]
        .find('\n')
        .map_or(text.len(), |place| end + place + 1);
    (from, to)
}
