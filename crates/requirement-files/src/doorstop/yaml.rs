//! YAML of one mapping, with the lines that each of its entries takes.
//!
//! Events come from a parser of YAML; aliases are refused, so that nothing expands. An entry's lines are found by layout: they
//! go to the next line that begins in the first column.

use crate::mistakes::bad;
use diagnostic::{Problem, Source};
use saphyr_parser::{Event, Parser};
use std::ops::Range;

/// How deeply values may be nested.
const MAX_DEPTH: usize = 40;
/// The most values of one text.
const MOST_VALUES: usize = 100_000;

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Text(String),
    List(Vec<Value>),
    Mapping(Mapping),
}

/// A mapping, its entries in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Mapping {
    pub(super) entries: Vec<Entry>,
    /// Of the outermost, where its text ends.
    pub(super) end: usize,
}

/// A key with its value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) key: String,
    pub(super) value: Value,
    /// Of the outermost mapping, the lines that it takes.
    pub(super) lines: Range<usize>,
}

impl Mapping {
    pub(super) fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }

    pub(super) fn text(&self, key: &str) -> Option<&str> {
        match &self.get(key)?.value {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }
}

/// Reads the mapping that a part of a text is.
pub(super) fn read(source: &Source, part: Range<usize>) -> Result<Mapping, Problem> {
    let text = &source.text[part.clone()];
    let mut reader = Reader {
        events: Parser::new_from_str(text),
        count: 0,
    };
    let root = reader.document().map_err(|(line, message)| {
        let at = part.start + line_offset(text, line);
        let length = source.text[at..].lines().next().map_or(1, str::len).max(1);
        bad(message)
            .at(source, at..at + length)
            .remedy("correct it here; the file has to be valid YAML")
    })?;
    let mut root = root;
    place(&mut root, text, part.start);
    Ok(root)
}

/// The beginning of a line, counted from one.
fn line_offset(text: &str, line: usize) -> usize {
    let lines = text.split_inclusive('\n').take(line.saturating_sub(1));
    lines.map(str::len).sum::<usize>().min(text.len())
}

/// Gives each entry the lines that it takes.
fn place(root: &mut Mapping, text: &str, start: usize) {
    let mut begins: Vec<usize> = Vec::new();
    let mut at = 0;
    let mut end = text.len();
    for line in text.split_inclusive('\n') {
        let is_mark = line.starts_with("---") || line.starts_with("...");
        let is_inside =
            line.starts_with([' ', '\t', '#', '\n', '\r', '-', '%', '}', ']', '\u{feff}']);
        if is_mark && !begins.is_empty() {
            end = at;
            break;
        }
        if !is_inside && !is_mark {
            begins.push(at);
        }
        at += line.len();
    }
    // Blank lines and comments at the end belong to no entry.
    let used = text[..end].trim_end_matches(['\n', '\r']).len();
    let end = text[used..]
        .find('\n')
        .map_or(text.len(), |at| used + at + 1)
        .min(end);
    root.end = start + end;
    let count = begins.len();
    for (index, entry) in root.entries.iter_mut().enumerate() {
        let from = begins.get(index).copied().unwrap_or(end);
        let to = begins.get(index + 1).copied().unwrap_or(end);
        entry.lines = start + from..start + to;
    }
    if count != root.entries.len() {
        // Laid out otherwise, as `{a: 1}`: no entry can be replaced by its lines.
        root.entries
            .iter_mut()
            .for_each(|entry| entry.lines = start + end..start + end);
    }
}

type Mistake = (usize, String);

struct Reader<'t> {
    events: Parser<'t, saphyr_parser::StrInput<'t>>,
    count: usize,
}

impl<'t> Reader<'t> {
    fn next(&mut self) -> Result<(Event<'t>, usize), Mistake> {
        self.count += 1;
        if self.count > MOST_VALUES {
            return Err((1, format!("the text has more than {MOST_VALUES} values")));
        }
        match self.events.next() {
            Some(Ok((event, span))) => Ok((event, span.start.line())),
            Some(Err(error)) => Err((error.marker().line(), error.info().to_owned())),
            None => Err((1, "the text ends too early".to_owned())),
        }
    }

    fn document(&mut self) -> Result<Mapping, Mistake> {
        loop {
            let (event, line) = self.next()?;
            match event {
                Event::StreamStart | Event::DocumentStart(_) | Event::Nothing => {}
                Event::StreamEnd | Event::DocumentEnd => return Ok(Mapping::default()),
                event => {
                    return match self.value(event, line, 0)? {
                        Value::Mapping(mapping) => Ok(mapping),
                        Value::Text(text) if text.is_empty() => Ok(Mapping::default()),
                        _ => Err((line, "`key: value` is expected here".to_owned())),
                    };
                }
            }
        }
    }

    fn value(&mut self, event: Event<'t>, line: usize, depth: usize) -> Result<Value, Mistake> {
        if depth > MAX_DEPTH {
            return Err((
                line,
                format!("values are nested more than {MAX_DEPTH} deep"),
            ));
        }
        match event {
            Event::Scalar(text, ..) => Ok(Value::Text(text.into_owned())),
            Event::Alias(_) => Err((line, "aliases are not read".to_owned())),
            Event::SequenceStart(..) => {
                let mut list = Vec::new();
                loop {
                    let (event, line) = self.next()?;
                    if event == Event::SequenceEnd {
                        return Ok(Value::List(list));
                    }
                    list.push(self.value(event, line, depth + 1)?);
                }
            }
            Event::MappingStart(..) => {
                let mut mapping = Mapping::default();
                loop {
                    let (event, line) = self.next()?;
                    if event == Event::MappingEnd {
                        return Ok(Value::Mapping(mapping));
                    }
                    let Value::Text(key) = self.value(event, line, depth + 1)? else {
                        return Err((line, "a key has to be a text".to_owned()));
                    };
                    let (event, line) = self.next()?;
                    let value = self.value(event, line, depth + 1)?;
                    if mapping.get(&key).is_some() {
                        return Err((line, format!("`{key}` is given twice")));
                    }
                    mapping.entries.push(Entry {
                        key,
                        value,
                        lines: 0..0,
                    });
                }
            }
            _ => Err((line, "a value is expected here".to_owned())),
        }
    }
}

/// A text in single quotes.
pub(super) fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', "''"))
}

/// A text as the value of a key: its lines as a block where they can be one.
pub(super) fn scalar(text: &str, end: &str) -> String {
    let is_odd = |letter: char| {
        (letter.is_control() && letter != '\n')
            || letter == '\u{feff}'
            || letter == '\u{2028}'
            || letter == '\u{2029}'
            || letter == '\u{85}'
    };
    if text.is_empty() {
        return "''".to_owned();
    }
    let is_block =
        !text.contains(is_odd) && !text.starts_with([' ', '\n']) && !text.ends_with('\n');
    if is_block {
        let lines = text.split('\n').map(|line| match line.is_empty() {
            true => String::new(),
            false => format!("  {line}"),
        });
        let lines: Vec<String> = lines.collect();
        return format!("|{end}{}", lines.join(end));
    }
    let mut out = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            odd if is_odd(odd) => out.push_str(&format!("\\u{:04x}", odd as u32)),
            other => out.push(other),
        }
    }
    out.push('"');
    out
}
