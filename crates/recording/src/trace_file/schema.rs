//! The schema of a topic, and the shape of its messages.

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};

use super::TIME_ENTRY;
use trace::{Channel, Field, FieldKind};

/// The part of the schema that is our own.
#[derive(Serialize, Deserialize)]
pub(super) struct Description {
    pub(super) fields: Vec<FieldText>,
}

/// A field as it is written in the schema.
#[derive(Serialize, Deserialize)]
pub(super) struct FieldText {
    name: String,
    unit: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    frame: Option<String>,
    kind: KindText,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum KindText {
    Number,
    Bool,
    Enumeration(Vec<String>),
}

/// What is read of a schema.
#[derive(Deserialize)]
pub(super) struct SchemaText {
    #[serde(rename = "x-corroborate")]
    pub(super) description: Description,
}

impl From<&Field> for FieldText {
    fn from(field: &Field) -> Self {
        let kind = match &field.kind {
            FieldKind::Number => KindText::Number,
            FieldKind::Bool => KindText::Bool,
            FieldKind::Enumeration(names) => KindText::Enumeration(names.clone()),
        };
        let Field {
            name, unit, frame, ..
        } = field.clone();
        FieldText {
            name,
            unit,
            frame,
            kind,
        }
    }
}

impl From<FieldText> for Field {
    fn from(text: FieldText) -> Self {
        let FieldText {
            name,
            unit,
            frame,
            kind,
        } = text;
        let kind = match kind {
            KindText::Number => FieldKind::Number,
            KindText::Bool => FieldKind::Bool,
            KindText::Enumeration(names) => FieldKind::Enumeration(names),
        };
        Field {
            name,
            unit,
            frame,
            kind,
        }
    }
}

/// The shape of a message: which field stands under which names.
#[derive(Debug, PartialEq)]
pub(super) enum Shape {
    /// The value of a field, by its index.
    Leaf(usize),
    /// An object, with its entries in the order of the fields.
    Object(Vec<(String, Shape)>),
}

impl Shape {
    /// The shape of the messages of a topic with `fields`: nested at dots if that is possible.
    pub(super) fn of(fields: &[Field]) -> Shape {
        let nested = nest(fields);
        nested.unwrap_or_else(|| {
            let flat = fields.iter().enumerate();
            Shape::Object(
                flat.map(|(index, field)| (field.name.clone(), Shape::Leaf(index)))
                    .collect(),
            )
        })
    }
}

/// Nests at dots; `None` if a name is both a value and an object, or has an empty part.
fn nest(fields: &[Field]) -> Option<Shape> {
    let mut root: Vec<(String, Shape)> = Vec::new();
    for (index, field) in fields.iter().enumerate() {
        let mut parts: Vec<&str> = field.name.split('.').collect();
        if parts.iter().any(|part| part.is_empty()) {
            return None;
        }
        let last = parts.pop()?;
        let mut entries = &mut root;
        for part in parts {
            let at = entries
                .iter()
                .position(|(name, _)| name == part)
                .unwrap_or_else(|| {
                    entries.push((part.to_owned(), Shape::Object(Vec::new())));
                    entries.len() - 1
                });
            match &mut entries[at].1 {
                Shape::Object(below) => entries = below,
                Shape::Leaf(_) => return None,
            }
        }
        if entries.iter().any(|(name, _)| name == last) {
            return None;
        }
        entries.push((last.to_owned(), Shape::Leaf(index)));
    }
    // The exact time stands beside the outermost entries.
    let clash = root.iter().any(|(name, _)| name == TIME_ENTRY);
    (!clash).then_some(Shape::Object(root))
}

/// `text` as a JSON string.
pub(super) fn quoted(text: &str) -> String {
    serde_json::Value::String(text.to_owned()).to_string()
}

/// The JSON schema of `channel`'s messages.
pub(super) fn schema_text(channel: &Channel) -> Result<String, serde_json::Error> {
    let fields = channel.fields.iter().map(FieldText::from).collect();
    let description = serde_json::to_string(&Description { fields })?;
    let mut text = format!("{{\"title\":{},", quoted(&channel.topic));
    let shape = Shape::of(&channel.fields);
    push_properties(&mut text, &shape, &channel.fields, true);
    let _ = write!(text, ",\"x-corroborate\":{description}}}");
    Ok(text)
}

/// Appends the type and properties of `shape`, without the surrounding braces.
fn push_properties(text: &mut String, shape: &Shape, fields: &[Field], outermost: bool) {
    match shape {
        Shape::Leaf(index) => push_leaf(text, &fields[*index]),
        Shape::Object(entries) => {
            text.push_str("\"type\":\"object\",\"properties\":{");
            for (position, (name, below)) in entries.iter().enumerate() {
                let comma = if position == 0 { "" } else { "," };
                let _ = write!(text, "{comma}{}:{{", quoted(name));
                push_properties(text, below, fields, false);
                text.push('}');
            }
            if outermost {
                let comma = if entries.is_empty() { "" } else { "," };
                let _ = write!(text, "{comma}\"{TIME_ENTRY}\":{{\"type\":\"number\"}}");
            }
            text.push('}');
        }
    }
}

fn push_leaf(text: &mut String, field: &Field) {
    match &field.kind {
        FieldKind::Number => text.push_str("\"type\":\"number\""),
        FieldKind::Bool => text.push_str("\"type\":\"boolean\""),
        FieldKind::Enumeration(names) => {
            let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
            let _ = write!(text, "\"type\":\"string\",\"enum\":[{}]", names.join(","));
        }
    }
    let mut about = Vec::new();
    if !field.unit.is_empty() {
        about.push(format!("unit {}", field.unit));
    }
    if let Some(frame) = &field.frame {
        about.push(format!("frame {frame}"));
    }
    if !about.is_empty() {
        let _ = write!(text, ",\"description\":{}", quoted(&about.join(", ")));
    }
}
