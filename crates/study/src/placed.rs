//! Mistakes that other readers found in a text, as problems with their places.

use diagnostic::{MOST_SHOWN, Problem, Source};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Diagnostics of the PRISM language as one problem; `None` if none is an error.
pub fn from_diagnostics(
    source: &Source,
    diagnostics: &[prism_lang::Diagnostic],
) -> Option<Problem> {
    let errors = || diagnostics.iter().filter(|d| d.is_error());
    let shown = errors().take(MOST_SHOWN);
    let problem = Problem::all(shown.map(|d| from_diagnostic(source, d)))?;
    Some(problem.and_more(errors().skip(MOST_SHOWN).count()))
}

fn from_diagnostic(source: &Source, diagnostic: &prism_lang::Diagnostic) -> Problem {
    let range = |span: prism_lang::Span| span.start..span.end;
    let related = diagnostic.related.iter();
    let related = related.map(|(span, note)| (range(*span), note.clone()));
    let problem = Problem::new(diagnostic.code, diagnostic.message.clone()).at_places(
        source,
        range(diagnostic.span),
        related.collect(),
    );
    match &diagnostic.remedy {
        Some(remedy) => problem.remedy(remedy.clone()),
        None => problem,
    }
}

/// A warning in one line, with its place.
pub fn warning_line(source: &Source, warning: &prism_lang::Diagnostic) -> String {
    let (line, column) = prism_lang::line_and_column(&source.text, warning.span.start);
    format!(
        "warning: {}:{line}:{column}: {}",
        source.name, warning.message
    )
}

/// A TOML file that does not have the expected form.
pub fn from_toml(source: &Source, error: &toml::de::Error) -> Problem {
    let problem = Problem::new("bad-study-file", error.message().trim_end().to_owned())
        .remedy("`corroborate init` writes a small study with every kind of entry");
    match error.span() {
        Some(span) => problem.at(source, span),
        None => problem.about(&source.name),
    }
}

/// Where a word stands in a file: in quotes if it does so, else bare, else the first line.
pub fn quoted(source: &Source, word: &str) -> Range<usize> {
    let text = &source.text;
    let found = [format!("\"{word}\""), word.to_owned()]
        .into_iter()
        .filter(|_| !word.is_empty())
        .find_map(|wanted| text.find(&wanted).map(|at| at..at + wanted.len()));
    found.unwrap_or_else(|| 0..text.lines().next().map_or(0, str::len))
}

/// Where a TOML file has what a path of keys leads to (places in lists as numbers), or the last part of it that is there: the
/// key, or the element of a list.
pub fn toml_place(source: &Source, path: &[&str]) -> Range<usize> {
    let (place, _) = along(source, path);
    place
}

/// Where the value stands that a path of keys leads to; where it is not there, as [`toml_place`].
pub fn value_place(source: &Source, path: &[&str]) -> Range<usize> {
    let (place, value) = along(source, path);
    value.unwrap_or(place)
}

/// The last key or element of a path that is there, and the value where the path's end is there.
fn along(source: &Source, path: &[&str]) -> (Range<usize>, Option<Range<usize>>) {
    let mut place = 0..0;
    let Ok(file) = DeTable::parse(&source.text) else {
        return (place, None);
    };
    let mut span = file.span();
    let mut here = DeValue::Table(file.into_inner());
    for part in path {
        let next = match here {
            DeValue::Table(table) => {
                let found = table
                    .into_iter()
                    .find(|(key, _)| key.get_ref().as_ref() == *part);
                found.map(|(key, value)| (key.span(), value.span(), value.into_inner()))
            }
            DeValue::Array(elements) => {
                let mut elements = elements.into_iter();
                let found = part
                    .parse()
                    .ok()
                    .and_then(|index: usize| elements.nth(index));
                found.map(|value| (value.span(), value.span(), value.into_inner()))
            }
            _ => None,
        };
        let Some(found) = next else {
            return (place, None);
        };
        (place, span, here) = found;
    }
    (place, Some(span))
}

/// Where, in the table that stands at a place, a value is of which something is true, under the key that it is given with.
pub fn value_in(
    source: &Source,
    table: &Range<usize>,
    is_it: &dyn Fn(&str, &DeValue<'_>) -> bool,
) -> Option<Range<usize>> {
    let file = DeTable::parse(&source.text).ok()?;
    let file = Spanned::new(file.span(), DeValue::Table(file.into_inner()));
    first_in(table_at(&file, table)?, "", is_it)
}

/// Where a key stands in the table that stands at a place.
pub fn key_in(source: &Source, table: &Range<usize>, key: &str) -> Option<Range<usize>> {
    let file = DeTable::parse(&source.text).ok()?;
    let file = Spanned::new(file.span(), DeValue::Table(file.into_inner()));
    let DeValue::Table(table) = table_at(&file, table)?.get_ref() else {
        return None;
    };
    let mut keys = table.keys().filter(|it| it.get_ref().as_ref() == key);
    keys.next().map(Spanned::span)
}

/// The places of the elements of a list that stands at a place.
pub fn elements(source: &Source, list: &Range<usize>) -> Vec<Range<usize>> {
    fn at(value: &Spanned<DeValue<'_>>, list: &Range<usize>) -> Option<Vec<Range<usize>>> {
        match value.get_ref() {
            DeValue::Array(elements) if value.span() == *list => {
                Some(elements.iter().map(Spanned::span).collect())
            }
            DeValue::Array(elements) => elements.iter().find_map(|value| at(value, list)),
            DeValue::Table(table) => table.values().find_map(|value| at(value, list)),
            _ => None,
        }
    }
    let Ok(file) = DeTable::parse(&source.text) else {
        return Vec::new();
    };
    let file = Spanned::new(file.span(), DeValue::Table(file.into_inner()));
    at(&file, list).unwrap_or_default()
}

fn table_at<'v, 't>(
    value: &'v Spanned<DeValue<'t>>,
    span: &Range<usize>,
) -> Option<&'v Spanned<DeValue<'t>>> {
    if value.span() == *span && value.get_ref().is_table() {
        return Some(value);
    }
    match value.get_ref() {
        DeValue::Table(table) => table.values().find_map(|value| table_at(value, span)),
        DeValue::Array(list) => list.iter().find_map(|value| table_at(value, span)),
        _ => None,
    }
}

fn first_in(
    value: &Spanned<DeValue<'_>>,
    key: &str,
    is_it: &dyn Fn(&str, &DeValue<'_>) -> bool,
) -> Option<Range<usize>> {
    if is_it(key, value.get_ref()) {
        return Some(value.span());
    }
    match value.get_ref() {
        DeValue::Table(table) => table
            .iter()
            .find_map(|(key, value)| first_in(value, key.get_ref(), is_it)),
        DeValue::Array(list) => list.iter().find_map(|value| first_in(value, key, is_it)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_found_where_it_is_set() {
        let source = Source {
            name: "study.toml".into(),
            text: "# [weights] and format\n[a]\nformat = 1\n[weights]\nE1 = 2\n[[l]]\nc = [1, 22]"
                .into(),
        };
        let at = |path: &[&str]| &source.text[toml_place(&source, path)];
        assert_eq!(toml_place(&source, &["weights", "E1"]).start, 48);
        assert_eq!(
            (at(&["weights", "E1"]), at(&["l", "0", "c", "1"])),
            ("E1", "22")
        );
        assert_eq!((at(&["weights", "E2"]), at(&["costs"])), ("weights", ""));
    }
}
