//! Reading one message into a row.

use std::borrow::Cow;
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, Visitor};

use super::TIME_ENTRY;
use super::schema::Shape;
use trace::{Field, FieldKind};

/// A message to be read, with the row that takes its values.
pub(super) struct Message<'a> {
    pub(super) fields: &'a [Field],
    pub(super) shape: &'a Shape,
    pub(super) row: &'a mut [f64],
}

impl Message<'_> {
    /// Fills the row from `data` and returns the exact time in seconds, if the message holds it.
    pub(super) fn read(self, data: &[u8]) -> Result<Option<f64>, serde_json::Error> {
        let mut exact_secs = None;
        let mut deserializer = serde_json::Deserializer::from_slice(data);
        let part = Part {
            fields: self.fields,
            shape: self.shape,
            row: self.row,
            exact_secs: Some(&mut exact_secs),
        };
        part.deserialize(&mut deserializer)?;
        deserializer.end()?;
        Ok(exact_secs)
    }
}

/// What stands at one place of the shape.
struct Part<'a> {
    fields: &'a [Field],
    shape: &'a Shape,
    row: &'a mut [f64],
    /// Where the exact time goes, in the outermost object.
    exact_secs: Option<&'a mut Option<f64>>,
}

impl<'de> DeserializeSeed<'de> for Part<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        match self.shape {
            Shape::Object(_) => deserializer.deserialize_map(self),
            Shape::Leaf(index) => match self.fields[*index].kind {
                FieldKind::Number => deserializer.deserialize_f64(self),
                FieldKind::Bool => deserializer.deserialize_bool(self),
                FieldKind::Enumeration(_) => deserializer.deserialize_str(self),
            },
        }
    }
}

impl Part<'_> {
    fn set(self, value: f64) {
        if let Shape::Leaf(index) = self.shape {
            self.row[*index] = value;
        }
    }

    fn kind(&self) -> Option<&FieldKind> {
        match self.shape {
            Shape::Leaf(index) => Some(&self.fields[*index].kind),
            Shape::Object(_) => None,
        }
    }
}

impl<'de> Visitor<'de> for Part<'_> {
    type Value = ();

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind() {
            None => out.write_str("an object with the fields of the topic"),
            Some(FieldKind::Number) => out.write_str("a number"),
            Some(FieldKind::Bool) => out.write_str("true or false"),
            Some(FieldKind::Enumeration(names)) => write!(out, "one of {names:?}"),
        }
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<(), E> {
        match self.kind() {
            Some(FieldKind::Number) => {
                self.set(value);
                Ok(())
            }
            _ => Err(E::invalid_type(serde::de::Unexpected::Float(value), &self)),
        }
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<(), E> {
        self.visit_f64(value as f64)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<(), E> {
        self.visit_f64(value as f64)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<(), E> {
        match self.kind() {
            Some(FieldKind::Bool) => {
                self.set(f64::from(u8::from(value)));
                Ok(())
            }
            _ => Err(E::invalid_type(serde::de::Unexpected::Bool(value), &self)),
        }
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<(), E> {
        let index = match self.kind() {
            Some(FieldKind::Enumeration(names)) => names.iter().position(|name| name == value),
            _ => None,
        };
        match index {
            Some(index) => {
                self.set(index as f64);
                Ok(())
            }
            None => Err(E::invalid_value(serde::de::Unexpected::Str(value), &self)),
        }
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut map: A) -> Result<(), A::Error> {
        let Shape::Object(entries) = self.shape else {
            while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
            return Err(A::Error::invalid_type(serde::de::Unexpected::Map, &self));
        };
        while let Some(name) = map.next_key::<Cow<'de, str>>()? {
            if let Some((_, shape)) = entries.iter().find(|(entry, _)| *entry == name) {
                let part = Part {
                    fields: self.fields,
                    shape,
                    row: self.row,
                    exact_secs: None,
                };
                map.next_value_seed(part)?;
            } else if let Some(exact_secs) = &mut self.exact_secs
                && name == TIME_ENTRY
            {
                **exact_secs = Some(map.next_value()?);
            } else {
                return Err(A::Error::custom(format_args!(
                    "the field {name} is not described"
                )));
            }
        }
        Ok(())
    }
}
