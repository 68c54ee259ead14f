//! What the deserializer says, in words for who wrote the text.

use super::OWN;
use super::mend::Mended;
use diagnostic::{Problem, Source, did_you_mean};
use toml::de::Error;

/// What a mistake is, and what the deserializer expects there.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Mistake<'m> {
    /// A field that is not known, and those that are.
    UnknownField(&'m str, Vec<&'m str>),
    /// A field that has to be there.
    MissingField(&'m str),
    /// A word that is none of these.
    UnknownWord(&'m str, Vec<&'m str>),
    /// A value of this kind in place of that.
    WrongType(&'m str, &'m str),
    /// Whatever else.
    Other,
}

impl<'m> Mistake<'m> {
    /// Reads the deserializer's message.
    pub(super) fn of(message: &'m str) -> Self {
        if let Some(field) = quoted_in(message, "missing field `") {
            return Self::MissingField(field);
        }
        if let Some(field) = quoted_in(message, "unknown field `") {
            return Self::UnknownField(field, known_in(message));
        }
        if let Some(word) = quoted_in(message, "unknown variant `") {
            return Self::UnknownWord(word, known_in(message));
        }
        for beginning in ["invalid type: ", "invalid value: ", "invalid length "] {
            let rest = message.strip_prefix(beginning);
            if let Some((got, expected)) = rest.and_then(|rest| rest.split_once(", expected ")) {
                return Self::WrongType(got, expected.trim_end());
            }
        }
        Self::Other
    }
}

/// A mistake with its place and what to do about it.
pub(super) fn problem(
    code: &'static str,
    source: &Source,
    tree: &Mended<'_>,
    error: &Error,
) -> Problem {
    let message = error.message().trim_end();
    let mistake = Mistake::of(message);
    let place = tree.place_of(error, &mistake);
    let named = tree.key_at(&place);
    let value = named.clone();
    let named = named.map_or_else(|| "the value".to_owned(), |key| format!("`{key}`"));
    let (message, remedy) = match &mistake {
        Mistake::UnknownField(field, known) => (
            format!("unknown field `{field}`"),
            one_of(field, known, "a field"),
        ),
        Mistake::MissingField(field) => (
            format!("missing field `{field}`"),
            format!("add `{field} = ...` there"),
        ),
        Mistake::UnknownWord(word, known) => (
            match value {
                Some(key) => format!("`{key}` cannot be `{word}`"),
                None => format!("`{word}` is unknown there"),
            },
            one_of(word, known, "a word"),
        ),
        Mistake::WrongType(got, expected) => (
            format!(
                "{named} must be {} (got {})",
                in_words(expected, got),
                got_in_words(got)
            ),
            what_it_holds(code),
        ),
        Mistake::Other => (message.to_owned(), what_it_holds(code)),
    };
    Problem::new(code, message).at(source, place).remedy(remedy)
}

/// Where it is said what a file holds.
fn what_it_holds(code: &str) -> String {
    match code == OWN {
        true => "`corroborate init` writes a small study with every kind of entry".to_owned(),
        false => format!("`corroborate explain {code}` says what the file holds"),
    }
}

/// Which of those that are known was meant, or which there are.
fn one_of(word: &str, known: &[&str], what: &str) -> String {
    if let Some(similar) = did_you_mean(word, known.iter().copied()) {
        return format!("did you mean `{similar}`?");
    }
    let known: Vec<String> = known.iter().map(|it| format!("`{it}`")).collect();
    match known.is_empty() {
        true => "remove it: nothing is expected there".to_owned(),
        false => format!(
            "remove it, or use {what} that is known: {}",
            known.join(", ")
        ),
    }
}

/// What the deserializer expects in the place of what it got.
fn in_words(expected: &str, got: &str) -> String {
    match expected {
        "u64" if got.ends_with("128") => format!("a whole number of at most {}", u64::MAX),
        "f64" | "f32" => "a number".to_owned(),
        "u64" | "u32" | "u16" | "u8" | "usize" => "a whole number of at least 0".to_owned(),
        "i64" | "i32" | "i16" | "i8" | "isize" => "a whole number".to_owned(),
        "a boolean" => "`true` or `false`".to_owned(),
        "a string" | "path string" => "a text in quotes".to_owned(),
        "a sequence" => "a list in brackets".to_owned(),
        "a map" => "a table".to_owned(),
        other if other.starts_with("struct ") => "a table".to_owned(),
        other => match other.strip_prefix("an array of length ") {
            Some(length) => format!("a list of {length} values"),
            None => other.to_owned(),
        },
    }
}

/// What the deserializer met.
fn got_in_words(got: &str) -> String {
    // Of a number that no type has, the deserializer says the type that it tried: `99…9` as i128.
    let value = |beginning: &str| {
        let rest = got.strip_prefix(beginning)?.trim_start_matches('`');
        rest.split('`').next()
    };
    if let Some(text) = got.strip_prefix("string ") {
        return format!("the text {text}");
    }
    if let Some(number) = value("integer ").or_else(|| value("floating point ")) {
        return number.to_owned();
    }
    if let Some(truth) = value("boolean ") {
        return truth.to_owned();
    }
    match got {
        "sequence" => "a list".to_owned(),
        "map" => "a table".to_owned(),
        other if other.parse::<usize>().is_ok() => format!("{other} values"),
        other => other.to_owned(),
    }
}

/// What stands in backticks behind the beginning of a message.
pub(super) fn quoted_in<'m>(message: &'m str, beginning: &str) -> Option<&'m str> {
    message.strip_prefix(beginning)?.split('`').next()
}

/// What stands in backticks behind `expected`.
fn known_in(message: &str) -> Vec<&str> {
    let (_, expected) = message.split_once(", expected ").unwrap_or_default();
    expected.split('`').skip(1).step_by(2).collect()
}
