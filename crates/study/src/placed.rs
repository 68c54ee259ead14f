//! Mistakes that other readers found in a text, as problems with their places.

use diagnostic::{MOST_SHOWN, Problem, Source};
use std::ops::Range;

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
    let mut place = 0..0;
    let Ok(file) = toml::de::DeTable::parse(&source.text) else {
        return place;
    };
    let mut here = toml::de::DeValue::Table(file.into_inner());
    for part in path {
        let next = match here {
            toml::de::DeValue::Table(table) => {
                let found = table
                    .into_iter()
                    .find(|(key, _)| key.get_ref().as_ref() == *part);
                found.map(|(key, value)| (key.span(), value.into_inner()))
            }
            toml::de::DeValue::Array(elements) => {
                let mut elements = elements.into_iter();
                let found = part
                    .parse()
                    .ok()
                    .and_then(|index: usize| elements.nth(index));
                found.map(|value| (value.span(), value.into_inner()))
            }
            _ => None,
        };
        let Some((found, value)) = next else {
            return place;
        };
        (place, here) = (found, value);
    }
    place
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
