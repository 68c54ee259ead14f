//! The keys and values of a TOML text with their places.

use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// How deep tables may be nested to be looked into.
const DEEPEST: usize = 40;

/// A key or an element of a list, with its value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Node {
    /// The keys that lead to it, its own last; places in lists as numbers.
    pub path: Vec<String>,
    /// Where its key is written; of an element, where the element is.
    pub key: Range<usize>,
    /// Where its value is written.
    pub value: Range<usize>,
    /// The value, if it is a text.
    pub text: Option<String>,
    /// Whether it is a table or a list.
    pub has_parts: bool,
}

impl Node {
    /// The path without the places in lists.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        let is_key = |part: &&String| part.parse::<usize>().is_err();
        self.path.iter().filter(is_key).map(String::as_str)
    }

    /// Whether the path matches a pattern of keys: `*` is any one of them.
    #[must_use]
    pub fn is(&self, pattern: &[&str]) -> bool {
        self.path.len() == pattern.len()
            && (self.path.iter().zip(pattern))
                .all(|(part, wanted)| *wanted == "*" || part == wanted)
    }

    /// The last key.
    #[must_use]
    pub fn last(&self) -> &str {
        self.keys().last().unwrap_or("")
    }
}

/// All keys and elements, in the order of the text as far as that can be told; of a text with mistakes those that could be read.
#[must_use]
pub fn nodes(text: &str) -> Vec<Node> {
    let (table, _) = DeTable::parse_recoverable(text);
    let mut found = Vec::new();
    of_table(table.get_ref(), &[], &mut found);
    found.sort_by_key(|it| (it.key.start, it.path.len()));
    found
}

/// Where a text is no TOML first, if it is none.
#[must_use]
pub fn mistake(text: &str) -> Option<usize> {
    let (_, mistakes) = DeTable::parse_recoverable(text);
    let places = mistakes.iter().map(|it| it.span().map_or(0, |it| it.start));
    places.min()
}

fn of_table(table: &DeTable<'_>, path: &[String], found: &mut Vec<Node>) {
    for (key, value) in table {
        let mut path = path.to_vec();
        path.push(key.get_ref().to_string());
        one(path, key.span(), value.span(), value.get_ref(), found);
    }
}

fn one(
    path: Vec<String>,
    key: Range<usize>,
    place: Range<usize>,
    value: &DeValue<'_>,
    found: &mut Vec<Node>,
) {
    found.push(Node {
        key,
        value: place,
        text: value.as_str().map(str::to_owned),
        has_parts: value.is_table() || value.is_array(),
        path: path.clone(),
    });
    if path.len() >= DEEPEST {
        return;
    }
    match value {
        DeValue::Table(table) => of_table(table, &path, found),
        DeValue::Array(elements) => {
            for (place, element) in elements.iter().enumerate() {
                let mut path = path.clone();
                path.push(place.to_string());
                let span = element.span();
                one(path, span.clone(), span, element.get_ref(), found);
            }
        }
        _ => {}
    }
}

/// What stands between the quotes of a text, with where it begins: as many bytes as in the file, so that a place in it is a
/// place in the file. What is escaped is blanked, but for quotes.
#[must_use]
pub fn inside(file: &str, value: &Range<usize>) -> (usize, String) {
    let Some(raw) = file.get(value.clone()) else {
        return (value.start, String::new());
    };
    let quotes = ["\"\"\"", "'''", "\"", "'"];
    let quote = quotes
        .into_iter()
        .find(|it| raw.len() >= 2 * it.len() && raw.starts_with(it) && raw.ends_with(it));
    let Some(quote) = quote else {
        return (value.start, raw.to_owned());
    };
    let content = &raw[quote.len()..raw.len() - quote.len()];
    let start = value.start + quote.len();
    if quote.starts_with('\'') {
        return (start, content.to_owned());
    }
    let mut shown = String::with_capacity(content.len());
    let mut characters = content.chars();
    while let Some(character) = characters.next() {
        if character != '\\' {
            shown.push(character);
            continue;
        }
        shown.push(' ');
        match characters.next() {
            Some(quoted @ ('"' | '\n')) => shown.push(quoted),
            Some(other) => shown.extend(std::iter::repeat_n(' ', other.len_utf8())),
            None => {}
        }
    }
    (start, shown)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_have_their_paths_and_places() {
        let text = "a = 1\n[b]\nc.d = [\"x\", { e = \"y\" }]\n[[f]]\ng = true\n[[f]]\n";
        let found = nodes(text);
        let paths: Vec<String> = found.iter().map(|it| it.path.join(".")).collect();
        assert!(
            paths.contains(&"b.c.d.1.e".into()) && paths.contains(&"f.0.g".into()),
            "{paths:?}"
        );
        let e = found
            .iter()
            .find(|it| it.is(&["b", "c", "d", "*", "e"]))
            .unwrap();
        assert_eq!((&text[e.key.clone()], e.text.as_deref()), ("e", Some("y")));
        assert_eq!(e.keys().collect::<Vec<_>>(), ["b", "c", "d", "e"]);
    }

    #[test]
    fn places_inside_of_a_text_are_places_in_the_file() {
        for (file, expected) in [
            ("k = \"a\\\"b\\\"c\"", "a \"b \"c"),
            ("k = 'a\\b'", "a\\b"),
            ("k = \"\"\"a \\\n  b\"\"\"", "a  \n  b"),
            ("k = \"a\\nb é\"", "a  b é"),
        ] {
            let node = nodes(file).pop().expect("a key");
            let (start, shown) = inside(file, &node.value);
            assert_eq!(shown, expected);
            assert_eq!(file[start..].chars().next(), Some('a'));
            let b = shown.find('b').unwrap();
            assert_eq!(&file[start + b..=start + b], "b");
        }
    }

    #[test]
    fn a_text_with_mistakes_has_what_could_be_read() {
        let found = nodes("a = \nb = \"x\"\n[c\nd = 1");
        assert!(found.iter().any(|it| it.path == ["b"]), "{found:?}");
    }
}
