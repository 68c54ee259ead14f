//! TOML texts of a study into their types, with all missing fields at once.
//!
//! The deserializer stops at its first mistake. Where that is a missing field, the field is added to a copy of the text with a
//! value of some type, and the copy is read for the next one. Only missing fields are collected so: another mistake of the copy
//! may come from the added values, and is told once these are the user's own. An unknown field is shown at its own place also
//! where the deserializer only knows the table that it stands in (in enumerations with a tag).

use diagnostic::{Problem, Source};
use serde::de::DeserializeOwned;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Error};

/// How many missing fields are collected.
const MOST: usize = 20;
/// Longer texts are not read again and again.
const LONGEST: usize = 1 << 20;
/// A value of each type that a field may have.
const VALUES: [&str; 7] = ["\"x\"", "1", "1.0", "true", "[]", "[0, 1]", "{}"];

/// Reads a text.
///
/// # Errors
/// Its first mistake, and after a missing field all others that are missing.
pub fn read<T: DeserializeOwned>(source: &Source) -> Result<T, Problem> {
    toml::from_str(&source.text).map_err(|error| {
        let problem = crate::placed::from_toml(source, &error);
        let problem = match place_of_unknown(&source.text, &error) {
            Some(place) => problem.at(source, place),
            None => problem,
        };
        let is_short = source.text.len() <= LONGEST;
        let others = is_short.then(|| further_missing::<T>(source, error));
        let all = others.into_iter().flatten();
        Problem::all([problem.clone()].into_iter().chain(all)).unwrap_or(problem)
    })
}

/// Where a field stands that is not known, if the error only shows its table.
pub fn place_of_unknown(text: &str, error: &Error) -> Option<Range<usize>> {
    let field = quoted_in(error.message(), "unknown field `")?;
    let span = error.span()?;
    if text
        .get(span.clone())
        .is_some_and(|shown| shown.trim_matches(['"', '\'']) == field)
    {
        return None;
    }
    let root = DeTable::parse(text).ok()?;
    let root = Spanned::new(root.span(), DeValue::Table(root.into_inner()));
    key_in_table_at(&root, span.start, field)
}

/// The key of this name in the innermost table that begins at a place.
fn key_in_table_at(value: &Spanned<DeValue<'_>>, start: usize, name: &str) -> Option<Range<usize>> {
    match value.get_ref() {
        DeValue::Array(array) => array.iter().find_map(|it| key_in_table_at(it, start, name)),
        DeValue::Table(table) => {
            let inner = table
                .values()
                .find_map(|it| key_in_table_at(it, start, name));
            let own = || {
                let mut keys = table.keys().filter(|key| key.get_ref().as_ref() == name);
                keys.next().map(Spanned::span)
            };
            inner.or_else(|| (value.span().start == start).then(own).flatten())
        }
        _ => None,
    }
}

/// The missing fields behind the first one.
fn further_missing<T: DeserializeOwned>(source: &Source, first: Error) -> Vec<Problem> {
    let mut filled = Filled {
        text: source.text.clone(),
        added: Vec::new(),
    };
    let mut problems = Vec::new();
    let mut error = first;
    while problems.len() < MOST {
        let Some((next, filled_more)) = filled.next_missing::<T>(&error) else {
            break;
        };
        filled = filled_more;
        let problem = crate::placed::from_toml(source, &next);
        problems.push(match next.span() {
            Some(span) => problem.at(source, filled.original(span)),
            None => problem,
        });
        error = next;
    }
    problems
}

/// A text with fields added.
struct Filled {
    text: String,
    /// Where something was added, in this text, and its length.
    added: Vec<(usize, usize)>,
}

impl Filled {
    /// The text with one field more, and the next that is missing, if one is.
    fn next_missing<T: DeserializeOwned>(&self, error: &Error) -> Option<(Error, Self)> {
        let field = quoted_in(error.message(), "missing field `")?;
        let is_missing = |error: &Error| error.message().starts_with("missing field `");
        let span = error.span();
        let word = self.with(field, VALUES[0], span.clone())?;
        let of_word = toml::from_str::<T>(&word.text).err();
        let variant = of_word.and_then(|error| {
            let known = quoted_in(error.message(), "unknown variant `x`, expected one of `")
                .or_else(|| quoted_in(error.message(), "unknown variant `x`, expected `"))?;
            Some(format!("\"{known}\""))
        });
        let values = variant.as_deref().into_iter().chain(VALUES);
        values.into_iter().find_map(|value| {
            let more = self.with(field, value, span.clone())?;
            let next = toml::from_str::<T>(&more.text).err().filter(is_missing)?;
            let is_other = next.message() != error.message() || next.span() != span;
            is_other.then_some((next, more))
        })
    }

    /// The same with a field in the table that begins at the span.
    fn with(&self, field: &str, value: &str, table: Option<Range<usize>>) -> Option<Self> {
        let start = table.map_or(0, |span| span.start);
        let rest = self.text.get(start..)?;
        let (at, text) = if let Some(inside) = rest.strip_prefix('{') {
            let between = if inside.trim_start().starts_with('}') {
                ""
            } else {
                ", "
            };
            (start + 1, format!("{field} = {value}{between}"))
        } else if rest.starts_with('[')
            && !self.text[..start]
                .trim_end_matches([' ', '\t'])
                .ends_with('=')
        {
            let line = rest.find('\n').map_or(rest.len(), |end| end + 1);
            (start + line, format!("{field} = {value}\n"))
        } else if start == 0 {
            (0, format!("{field} = {value}\n"))
        } else {
            return None;
        };
        let mut added: Vec<(usize, usize)> = self.added.clone();
        for (place, _) in &mut added {
            if *place >= at {
                *place += text.len();
            }
        }
        added.push((at, text.len()));
        let mut filled = self.text.clone();
        filled.insert_str(at, &text);
        Some(Self {
            text: filled,
            added,
        })
    }

    /// A place of this text in the original.
    fn original(&self, span: Range<usize>) -> Range<usize> {
        let back = |place: usize| {
            let before = self.added.iter().filter(|(at, _)| *at < place);
            place.saturating_sub(before.map(|(_, length)| length).sum())
        };
        let start = back(span.start);
        start..back(span.end).max(start)
    }
}

/// What stands in backticks behind the beginning of a message.
fn quoted_in<'m>(message: &'m str, beginning: &str) -> Option<&'m str> {
    message.strip_prefix(beginning)?.split('`').next()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only read")]
    struct File {
        title: String,
        #[serde(default)]
        entry: Vec<Entry>,
    }

    #[derive(Debug, Deserialize)]
    #[expect(dead_code, reason = "only read")]
    struct Entry {
        id: String,
        colour: Colour,
        count: u64,
        range: [f64; 2],
        #[serde(flatten)]
        kind: Kind,
    }

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Colour {
        Red,
        Green,
    }

    #[derive(Debug, Deserialize)]
    #[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
    #[expect(dead_code, reason = "only read")]
    enum Kind {
        Laser { rays: u32 },
    }

    fn shown(text: &str) -> String {
        let source = Source {
            name: "f.toml".into(),
            text: text.into(),
        };
        read::<File>(&source).expect_err("mistakes").to_string()
    }

    #[test]
    fn missing_fields_are_told_at_once_each_in_its_table() {
        let said = shown(
            "[[entry]]\nkind = \"laser\"\nrays = 3\n\n[[entry]]\nid = \"b\"\nrange = [0.0, 1.0]\nkind = \"laser\"\nrays = 3\n",
        );
        for field in ["title", "id", "colour", "count", "range"] {
            assert!(
                said.contains(&format!("missing field `{field}`")),
                "{field}:\n{said}"
            );
        }
        for place in ["f.toml:1:", "f.toml:5:"] {
            assert!(said.contains(place), "{place}:\n{said}");
        }
    }

    #[test]
    fn an_unknown_field_of_a_tagged_table_is_shown_at_itself() {
        let said = shown(
            "title = \"t\"\n[[entry]]\nid = \"a\"\ncolour = \"red\"\ncount = 1\nrange = [0.0, 1.0]\nkind = \"laser\"\nrays = 3\nrayz = 4\n",
        );
        assert!(said.contains("unknown field `rayz`"), "{said}");
        assert!(said.contains("f.toml:9:1"), "{said}");
    }
}
