//! Which values the messages of a topic hold.

use std::fmt;

use serde::Serialize;

use super::units::{innermost, usual_unit};
use crate::decode::{Extractor, FieldPath, Value};
use crate::reader::{Encoding, TopicInfo};
use crate::schema::{MessageType, Primitive, ProtoKind, ProtobufSchema, Schema, Type};

/// The most elements of an array that are listed one by one.
const LISTED: u64 = 16;
/// The most fields that are listed for a topic.
const MAX_FIELDS: usize = 400;
/// The deepest nesting that is followed.
const MAX_DEPTH: usize = 12;

/// A value of a message, for show.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FieldValue {
    /// A number.
    Number(f64),
    /// A truth value.
    Bool(bool),
    /// A text.
    Text(String),
    /// Nothing is there.
    Missing,
}

impl fmt::Display for FieldValue {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FieldValue::Number(number) => write!(out, "{number}"),
            FieldValue::Bool(truth) => write!(out, "{truth}"),
            FieldValue::Text(text) => write!(out, "{text:?}"),
            FieldValue::Missing => out.write_str("missing"),
        }
    }
}

/// A field of a topic's messages.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FieldSummary {
    /// Its path, as a topic map writes it.
    pub path: String,
    /// The unit that the type fixes; empty if it fixes none.
    pub unit: String,
    /// What the first message holds there.
    pub first: FieldValue,
    /// How many elements the array has that this stands for, if it is too long to be listed; the
    /// path is then that of its first element.
    pub elements: Option<u64>,
}

/// A path, before its value is known.
struct Found {
    path: String,
    elements: Option<u64>,
}

/// The fields of `info`, with their values in the message `data`.
pub(super) fn fields_of(info: &TopicInfo, data: &[u8]) -> Vec<FieldSummary> {
    let mut walk = Walk {
        info,
        data,
        found: Vec::new(),
    };
    match info.schema.as_ref() {
        Schema::Struct(root) => walk.structure(root, "", 0),
        Schema::Protobuf(schema) => walk.protobuf(schema, schema.root, "", 0),
        Schema::Schemaless if info.encoding == Encoding::Json => {
            if let Ok(value) = serde_json::from_slice::<serde_json::Value>(data) {
                walk.json(&value, "", 0);
            }
        }
        _ => {}
    }
    let found = walk.found;
    let summary = |found: Found| FieldSummary {
        unit: usual_unit(info, &found.path).to_owned(),
        first: value_at(info, data, &found.path),
        elements: found.elements,
        path: found.path,
    };
    found.into_iter().map(summary).collect()
}

fn value_at(info: &TopicInfo, data: &[u8], path: &str) -> FieldValue {
    let values = FieldPath::parse(path)
        .and_then(|path| Extractor::new(info, &[path]))
        .ok()
        .and_then(|mut extractor| extractor.extract_values(data).ok());
    match values.as_ref().and_then(|values| values.first()) {
        Some(Value::Number(number)) => FieldValue::Number(*number),
        Some(Value::Bool(truth)) => FieldValue::Bool(*truth),
        Some(Value::Text(text)) => FieldValue::Text(text.clone()),
        Some(Value::Missing) | None => FieldValue::Missing,
    }
}

struct Walk<'a> {
    info: &'a TopicInfo,
    data: &'a [u8],
    found: Vec<Found>,
}

/// `below` under the path `above`; names with odd letters are put in quotes.
fn joined(above: &str, name: &str) -> String {
    let plain = |letter: char| letter.is_alphanumeric() || "_-/".contains(letter);
    let quoted = if !name.is_empty() && name.chars().all(plain) {
        name.to_owned()
    } else {
        format!("\"{name}\"")
    };
    if above.is_empty() {
        quoted
    } else {
        format!("{above}.{quoted}")
    }
}

impl Walk<'_> {
    fn add(&mut self, path: String, elements: Option<u64>) {
        // A name of a field may be anything; what no path can say is left out.
        if self.found.len() < MAX_FIELDS && FieldPath::parse(&path).is_ok() {
            self.found.push(Found { path, elements });
        }
    }

    fn structure(&mut self, message: &MessageType, above: &str, depth: usize) {
        if depth > MAX_DEPTH {
            return;
        }
        // In joint states and the like, the names beside the numbers say which is which.
        let names = message.fields.iter().find(|field| {
            field.name == "name"
                && matches!(&field.kind, Type::Sequence(element) if **element == Type::Text)
        });
        let names = names.map(|field| self.texts(&joined(above, &field.name)));
        for field in &message.fields {
            let path = joined(above, &field.name);
            match (&field.kind, &names) {
                (Type::Sequence(element), Some(names))
                    if matches!(**element, Type::Primitive(_)) && !names.is_empty() =>
                {
                    for name in names {
                        self.add(format!("{path}[name='{name}']"), None);
                    }
                }
                (kind, _) => self.value(kind, &path, depth),
            }
        }
    }

    fn value(&mut self, kind: &Type, path: &str, depth: usize) {
        match kind {
            Type::Primitive(_) | Type::Text => self.add(path.to_owned(), None),
            Type::Struct(message) => self.structure(message, path, depth + 1),
            Type::Array(element, count) => self.elements(element, path, *count, depth),
            Type::Sequence(element) => {
                let count = self.length(path);
                self.elements(element, path, count, depth);
            }
            Type::WideText => {}
        }
    }

    fn elements(&mut self, element: &Type, path: &str, count: u64, depth: usize) {
        // Images and the like are no signals.
        let bytes = matches!(element, Type::Primitive(Primitive::Uint8 | Primitive::Int8));
        if count == 0 || (bytes && count > LISTED) || depth > MAX_DEPTH {
            return;
        }
        if count > LISTED {
            if let Type::Primitive(_) = innermost(element) {
                self.add(format!("{path}[0]"), Some(count));
            }
            return;
        }
        for index in 0..count {
            self.value(element, &format!("{path}[{index}]"), depth + 1);
        }
    }

    fn length(&self, path: &str) -> u64 {
        match value_at(self.info, self.data, &format!("length({path})")) {
            FieldValue::Number(count) if count >= 0.0 => count as u64,
            _ => 0,
        }
    }

    /// The texts of an array, if they can be written in a path and differ.
    fn texts(&self, path: &str) -> Vec<String> {
        let count = self.length(path).min(64);
        let texts =
            (0..count).map(|index| value_at(self.info, self.data, &format!("{path}[{index}]")));
        let texts: Vec<String> = texts
            .filter_map(|value| match value {
                FieldValue::Text(text) => Some(text),
                _ => None,
            })
            .collect();
        let fits = |(index, text): (usize, &String)| {
            !text.is_empty() && !text.contains(['\'', '"', '\\']) && !texts[..index].contains(text)
        };
        if texts.iter().enumerate().all(fits) {
            texts
        } else {
            Vec::new()
        }
    }

    fn protobuf(&mut self, schema: &ProtobufSchema, message: usize, above: &str, depth: usize) {
        let Some(message) = schema.messages.get(message).filter(|_| depth <= MAX_DEPTH) else {
            return;
        };
        for field in &message.fields {
            let path = joined(above, &field.name);
            let count = if field.repeated {
                self.length(&path)
            } else {
                1
            };
            let is_message = matches!(field.kind, ProtoKind::Message(_));
            if field.repeated && count > LISTED {
                if !is_message {
                    self.add(format!("{path}[0]"), Some(count));
                }
                continue;
            }
            for index in 0..count {
                let path = if field.repeated {
                    format!("{path}[{index}]")
                } else {
                    path.clone()
                };
                match &field.kind {
                    ProtoKind::Message(inner) => self.protobuf(schema, *inner, &path, depth + 1),
                    ProtoKind::Bytes | ProtoKind::Group => {}
                    _ => self.add(path, None),
                }
            }
        }
    }

    fn json(&mut self, value: &serde_json::Value, path: &str, depth: usize) {
        match value {
            _ if depth > MAX_DEPTH => {}
            serde_json::Value::Object(entries) => {
                for (name, inner) in entries {
                    self.json(inner, &joined(path, name), depth + 1);
                }
            }
            serde_json::Value::Array(elements) if elements.len() as u64 > LISTED => {
                if elements.iter().all(serde_json::Value::is_number) {
                    self.add(format!("{path}[0]"), Some(elements.len() as u64));
                }
            }
            serde_json::Value::Array(elements) => {
                for (index, inner) in elements.iter().enumerate() {
                    self.json(inner, &format!("{path}[{index}]"), depth + 1);
                }
            }
            serde_json::Value::Null => {}
            _ if path.is_empty() => {}
            _ => self.add(path.to_owned(), None),
        }
    }
}
