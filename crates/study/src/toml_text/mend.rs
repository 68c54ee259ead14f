//! A parsed text whose mistakes are mended one after another, so that the next is found.

use super::words::Mistake;
use diagnostic::did_you_mean;
use serde::de::DeserializeOwned;
use std::borrow::Cow;
use std::collections::VecDeque;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue, Deserializer, Error};

/// A value of each type that a field may have, as a text that gives it.
const VALUES: [&str; 10] = [
    "\"x\"",
    "1",
    "1.0",
    "true",
    "[]",
    "{}",
    "[0.0, 1.0]",
    "[1.0, 1.0, 1.0]",
    "[1.0, 1.0, 1.0, 1.0]",
    "[[0.0, 0.0], [1.0, 1.0]]",
];

/// By what the deserializer got over a mistake.
enum Helped {
    /// A value of the type that it wants.
    ByValue,
    /// The first of the words that it knows.
    ByWord,
}

/// A key, or the place in a list.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Step {
    Key(String),
    Place(usize),
}

/// A parsed text, mended so far.
pub(super) struct Mended<'t> {
    root: Spanned<DeValue<'t>>,
    /// Where something was put in that the user did not write.
    made_up: Vec<Range<usize>>,
    is_a_name_lost: bool,
}

impl<'t> Mended<'t> {
    /// A text in which what stands at `taken` is a number.
    pub(super) fn new(root: Spanned<DeValue<'t>>, taken: &[Range<usize>]) -> Self {
        let mut mended = Self {
            root,
            made_up: Vec::new(),
            is_a_name_lost: false,
        };
        for span in taken {
            let path = mended.path_of(&|value| value.span() == *span);
            if let (Some(path), Some(number)) = (path, value_of("1.0"))
                && let Some(value) = value_mut(&mut mended.root, &path)
            {
                *value = number;
            }
        }
        mended
    }

    /// The typed value.
    pub(super) fn read<T: DeserializeOwned>(&self) -> Result<T, Error> {
        typed(&self.root)
    }

    /// Places whose content is made up.
    pub(super) fn made_up(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.made_up.iter().cloned()
    }

    /// Whether something was left out or made up that may have been the name of something.
    pub(super) fn is_a_name_lost(&self) -> bool {
        self.is_a_name_lost
    }

    /// Where a mistake is: its own place, where the deserializer only knows the table around it.
    pub(super) fn place_of(&self, error: &Error, mistake: &Mistake<'_>) -> Range<usize> {
        let span = error.span().unwrap_or(0..0);
        let inside = match mistake {
            Mistake::UnknownField(field, _) => key_in_table_at(&self.root, span.start, field),
            Mistake::UnknownWord(word, _) => {
                let found = self.word_in_table_at(&span, word);
                found.and_then(|path| Some(self.at(&path)?.span()))
            }
            Mistake::MissingField(_) | Mistake::WrongType(..) | Mistake::Other => None,
        };
        inside.unwrap_or(span)
    }

    /// The key whose value stands there.
    pub(super) fn key_at(&self, span: &Range<usize>) -> Option<String> {
        let path = self.path_of(&|value| value.span() == *span && !value.span().is_empty())?;
        path.into_iter().rev().find_map(|step| match step {
            Step::Key(key) => Some(key),
            Step::Place(_) => None,
        })
    }

    /// Mends a mistake, so that the deserializer comes to the next one.
    pub(super) fn mend<T: DeserializeOwned>(&mut self, error: &Error) -> bool {
        let message = error.message().trim_end().to_owned();
        let span = error.span().unwrap_or(0..0);
        match Mistake::of(&message) {
            Mistake::UnknownField(field, known) => {
                self.without_field(&span, field, &known) || self.leave_out::<T>(error)
            }
            Mistake::MissingField(field) => {
                self.is_a_name_lost |= is_name(field);
                self.fill::<T>(error, field) || self.leave_out::<T>(error)
            }
            // A word of another meaning would make other fields wrong.
            Mistake::UnknownWord(word, known) => {
                let similar = did_you_mean(word, known.iter().copied());
                self.replace_word::<T>(error, word, similar) || self.leave_out::<T>(error)
            }
            Mistake::WrongType(..) | Mistake::Other => {
                self.replace::<T>(error) || self.leave_out::<T>(error)
            }
        }
    }

    /// Gives an unknown field the known name that it is like, or leaves it out.
    fn without_field(&mut self, span: &Range<usize>, field: &str, known: &[&str]) -> bool {
        let of_key = |table: &DeTable<'_>| {
            let mut keys = table.keys().filter(|key| key.get_ref().as_ref() == field);
            keys.any(|key| key.span() == *span)
        };
        let holds = |value: &Spanned<DeValue<'_>>| match value.get_ref() {
            DeValue::Table(table) => {
                of_key(table) || (value.span().start == span.start && table.contains_key(field))
            }
            _ => false,
        };
        let path = self.path_of(&holds);
        let Some(DeValue::Table(table)) = path.and_then(|path| self.at_mut(&path)) else {
            return false;
        };
        let Some((key, value)) = table.remove_entry(field) else {
            return false;
        };
        if let Some(similar) = did_you_mean(field, known.iter().copied())
            && !table.contains_key(similar)
        {
            let similar = Cow::Owned(similar.to_owned());
            table.insert(Spanned::new(key.span(), similar), value);
        }
        true
    }

    /// Puts in a field that is missing.
    fn fill<T: DeserializeOwned>(&mut self, error: &Error, field: &str) -> bool {
        let span = error.span().unwrap_or(0..0);
        let is_there = |value: &Spanned<DeValue<'_>>| match value.get_ref() {
            DeValue::Table(table) => value.span() == span && !table.contains_key(field),
            _ => false,
        };
        let Some(path) = self.path_of(&is_there) else {
            return false;
        };
        // No place of the text is the table's own, also where that is empty.
        let at = span.start + usize::from(span.is_empty());
        let place = at..at;
        let put = |root: &mut Spanned<DeValue<'t>>, value: DeValue<'t>| {
            if let Some(DeValue::Table(table)) = value_mut(root, &path) {
                let key = Spanned::new(place.clone(), Cow::Owned(field.to_owned()));
                table.insert(key, Spanned::new(place.clone(), value));
            }
        };
        let table = self.at(&path).map(extent);
        match self.first_that_helps::<T>(error, &place, &put) {
            Some(Helped::ByValue) => self.made_up.push(place),
            // Which other fields go with a word that was chosen here is not known.
            Some(Helped::ByWord) => self.made_up.push(table.unwrap_or(place)),
            None => return false,
        }
        true
    }

    /// Puts a value of another type in the place of one.
    fn replace<T: DeserializeOwned>(&mut self, error: &Error) -> bool {
        let Some(span) = error.span().filter(|span| !span.is_empty()) else {
            return false;
        };
        let is_there = |value: &Spanned<DeValue<'_>>| value.span() == span;
        let Some(path) = self.path_of(&is_there).filter(|path| !path.is_empty()) else {
            return false;
        };
        let put = |root: &mut Spanned<DeValue<'t>>, value: DeValue<'t>| {
            if let Some(old) = value_mut(root, &path) {
                *old = value;
            }
        };
        let is_replaced = self.first_that_helps::<T>(error, &span, &put).is_some();
        if is_replaced {
            let key = path.iter().rev().find_map(|step| match step {
                Step::Key(key) => Some(key.as_str()),
                Step::Place(_) => None,
            });
            self.is_a_name_lost |= key.is_some_and(is_name);
            self.made_up.push(span);
        }
        is_replaced
    }

    /// Puts the word that was probably meant in the place of one.
    fn replace_word<T: DeserializeOwned>(
        &mut self,
        error: &Error,
        word: &str,
        similar: Option<&str>,
    ) -> bool {
        let span = error.span().unwrap_or(0..0);
        let (Some(similar), Some(path)) = (similar, self.word_in_table_at(&span, word)) else {
            return false;
        };
        let mut root = self.root.clone();
        if let Some(old) = value_mut(&mut root, &path) {
            *old = DeValue::String(Cow::Owned(similar.to_owned()));
        }
        let next = typed::<T>(&root).err();
        let is_better = next
            .is_none_or(|next| next.message() != error.message() || next.span() != error.span());
        if is_better {
            self.root = root;
        }
        is_better
    }

    /// Takes the first value with which the deserializer gets further.
    fn first_that_helps<T: DeserializeOwned>(
        &mut self,
        error: &Error,
        place: &Range<usize>,
        put: &dyn Fn(&mut Spanned<DeValue<'t>>, DeValue<'t>),
    ) -> Option<Helped> {
        let mut helped = Helped::ByValue;
        let mut values: VecDeque<DeValue<'t>> =
            VALUES.iter().filter_map(|text| value_of(text)).collect();
        while let Some(value) = values.pop_front() {
            let is_x = matches!(&value, DeValue::String(text) if text == "x");
            let mut root = self.root.clone();
            put(&mut root, value);
            let next = typed::<T>(&root).err();
            if is_x
                && let Some(Mistake::UnknownWord("x", known)) =
                    next.as_ref().map(|next| Mistake::of(next.message()))
            {
                let word = (*known.first()?).to_owned();
                values.push_front(DeValue::String(Cow::Owned(word)));
                helped = Helped::ByWord;
                continue;
            }
            if next.is_none_or(|next| is_further(error, &next, place)) {
                self.root = root;
                return Some(helped);
            }
        }
        None
    }

    /// Leaves out what the mistake is in: the value, else what is around it.
    fn leave_out<T: DeserializeOwned>(&mut self, error: &Error) -> bool {
        let span = error.span().unwrap_or(0..0);
        let is_there = |value: &Spanned<DeValue<'_>>| value.span() == span;
        let word = match Mistake::of(error.message()) {
            Mistake::UnknownWord(word, _) => self.word_in_table_at(&span, word),
            _ => None,
        };
        let Some(path) = word.or_else(|| self.path_of(&is_there)) else {
            return false;
        };
        for length in (1..=path.len()).rev() {
            let (step, around) = (&path[length - 1], &path[..length - 1]);
            let mut root = self.root.clone();
            match (value_mut(&mut root, around), step) {
                (Some(DeValue::Table(table)), Step::Key(key)) => drop(table.remove(key.as_str())),
                (Some(DeValue::Array(list)), Step::Place(place)) => *list = without(list, *place),
                _ => continue,
            }
            let next = typed::<T>(&root).err();
            let is_better = next.is_none_or(|next| {
                let is_same = next.message() == error.message() && next.span() == error.span();
                let lacks_it = matches!((Mistake::of(next.message()), step),
                    (Mistake::MissingField(field), Step::Key(key)) if field == key);
                !is_same && !lacks_it
            });
            if is_better {
                self.is_a_name_lost |= match (self.at(&path[..length]), step) {
                    (Some(value), Step::Key(key)) => is_name(key) || value.get_ref().is_table(),
                    (Some(value), Step::Place(_)) => value.get_ref().is_table(),
                    (None, _) => true,
                };
                // A list of values that lacks one is not the user's.
                let is_table = self
                    .at(&path[..length])
                    .is_some_and(|it| it.get_ref().is_table());
                let list = self.at(around).map(Spanned::span);
                let list = list.filter(|_| matches!(step, Step::Place(_)) && !is_table);
                self.made_up.extend(list);
                self.root = root;
                return true;
            }
        }
        false
    }

    /// The way to a word in the table that begins at a place, or that stands there itself.
    fn word_in_table_at(&self, span: &Range<usize>, word: &str) -> Option<Vec<Step>> {
        let is_word = |value: &DeValue<'_>| value.as_str() == Some(word);
        let own = self.path_of(&|value| value.span() == *span && is_word(value.get_ref()));
        own.or_else(|| {
            let has_word = |value: &Spanned<DeValue<'_>>| match value.get_ref() {
                DeValue::Table(table) => {
                    value.span().start == span.start
                        && table.values().any(|value| is_word(value.get_ref()))
                }
                _ => false,
            };
            let mut path = self.path_of(&has_word)?;
            let DeValue::Table(table) = self.at(&path)?.get_ref() else {
                return None;
            };
            let mut entries = table.iter();
            let (key, _) = entries.find(|(_, value)| is_word(value.get_ref()))?;
            path.push(Step::Key(key.get_ref().to_string()));
            Some(path)
        })
    }

    /// The way to the innermost value of which something is true.
    fn path_of(&self, is_it: &dyn Fn(&Spanned<DeValue<'_>>) -> bool) -> Option<Vec<Step>> {
        path_in(&self.root, is_it)
    }

    fn at(&self, path: &[Step]) -> Option<&Spanned<DeValue<'t>>> {
        let mut here = &self.root;
        for step in path {
            here = match (here.get_ref(), step) {
                (DeValue::Table(table), Step::Key(key)) => table.get(key.as_str())?,
                (DeValue::Array(list), Step::Place(place)) => list.get(*place)?,
                _ => return None,
            };
        }
        Some(here)
    }

    fn at_mut(&mut self, path: &[Step]) -> Option<&mut DeValue<'t>> {
        value_mut(&mut self.root, path)
    }
}

/// Whether a field gives its table the name by which others know it.
fn is_name(field: &str) -> bool {
    matches!(field, "id" | "name")
}

/// Whether the deserializer got over a mistake: it stops elsewhere, and not for what was put in at that place.
fn is_further(before: &Error, after: &Error, place: &Range<usize>) -> bool {
    let is_about_value = matches!(
        Mistake::of(after.message()),
        Mistake::WrongType(..) | Mistake::UnknownWord("x", _) | Mistake::Other
    );
    let is_same_place = after.span() == before.span();
    let is_same = is_same_place && after.message() == before.message();
    let is_put_in = after.span().as_ref() == Some(place);
    !(is_same || is_put_in || is_about_value && is_same_place)
}

fn typed<T: DeserializeOwned>(root: &Spanned<DeValue<'_>>) -> Result<T, Error> {
    let table = match root.get_ref() {
        DeValue::Table(table) => table.clone(),
        _ => DeTable::new(),
    };
    T::deserialize(Deserializer::from(Spanned::new(root.span(), table)))
}

/// From where a value begins to where the last of its parts ends.
fn extent(value: &Spanned<DeValue<'_>>) -> Range<usize> {
    let ends: Vec<usize> = match value.get_ref() {
        DeValue::Table(table) => table.values().map(|it| extent(it).end).collect(),
        DeValue::Array(list) => list.iter().map(|it| extent(it).end).collect(),
        _ => Vec::new(),
    };
    let span = value.span();
    span.start..ends.into_iter().fold(span.end, usize::max)
}

fn without<'t>(list: &DeArray<'t>, place: usize) -> DeArray<'t> {
    let mut left = DeArray::new();
    let others = list.iter().enumerate().filter(|(at, _)| *at != place);
    others.for_each(|(_, value)| left.push(value.clone()));
    left
}

/// A value that a text gives, at no place.
fn value_of(text: &'static str) -> Option<DeValue<'static>> {
    DeValue::parse(text).ok().map(Spanned::into_inner)
}

fn value_mut<'v, 't>(
    root: &'v mut Spanned<DeValue<'t>>,
    path: &[Step],
) -> Option<&'v mut DeValue<'t>> {
    let mut here = root.get_mut();
    for step in path {
        here = match (here, step) {
            (DeValue::Table(table), Step::Key(key)) => table.get_mut(key.as_str())?.get_mut(),
            (DeValue::Array(list), Step::Place(place)) => list.get_mut(*place)?.get_mut(),
            _ => return None,
        };
    }
    Some(here)
}

fn path_in(
    value: &Spanned<DeValue<'_>>,
    is_it: &dyn Fn(&Spanned<DeValue<'_>>) -> bool,
) -> Option<Vec<Step>> {
    let behind = |step: Step, value: &Spanned<DeValue<'_>>| {
        let mut path = path_in(value, is_it)?;
        path.insert(0, step);
        Some(path)
    };
    let inner = match value.get_ref() {
        DeValue::Array(list) => list
            .iter()
            .enumerate()
            .find_map(|(place, value)| behind(Step::Place(place), value)),
        DeValue::Table(table) => table
            .iter()
            .find_map(|(key, value)| behind(Step::Key(key.get_ref().to_string()), value)),
        _ => None,
    };
    inner.or_else(|| is_it(value).then(Vec::new))
}

/// The key of this name in the innermost table that begins at a place.
pub(super) fn key_in_table_at(
    value: &Spanned<DeValue<'_>>,
    start: usize,
    name: &str,
) -> Option<Range<usize>> {
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
