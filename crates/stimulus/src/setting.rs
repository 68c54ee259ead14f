//! One value that is set: yes or no, a number, or a text.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Values by the dotted keys of what they set.
pub type Settings = BTreeMap<String, Setting>;

/// One value. Numbers are finite; whole ones are written without a point in JSON and TOML.
#[derive(Debug, Clone, PartialEq)]
pub enum Setting {
    /// Yes or no.
    Bool(bool),
    /// A finite number; units are those of what is set.
    Number(f64),
    /// A text, such as the label of a choice.
    Text(String),
}

/// Up to here whole numbers are exact in an `f64`, and written as whole numbers.
const EXACT_INTEGERS: f64 = 9_007_199_254_740_992.0;

impl Setting {
    /// The number as a whole one, if it is.
    #[must_use]
    pub fn as_integer(&self) -> Option<i64> {
        match self {
            Self::Number(number) if number.fract() == 0.0 && number.abs() <= EXACT_INTEGERS => {
                Some(*number as i64)
            }
            _ => None,
        }
    }

    /// The value as TOML: whole numbers as integers.
    #[must_use]
    pub fn to_toml(&self) -> toml::Value {
        match (self, self.as_integer()) {
            (_, Some(integer)) => toml::Value::Integer(integer),
            (Self::Bool(value), _) => toml::Value::Boolean(*value),
            (Self::Number(value), _) => toml::Value::Float(*value),
            (Self::Text(value), _) => toml::Value::String(value.clone()),
        }
    }
}

impl fmt::Display for Setting {
    /// Writes a yes, no or number plainly and a text in quotes.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(value) => write!(f, "{value}"),
            Self::Number(value) => write!(f, "{value}"),
            Self::Text(value) => write!(f, "{value:?}"),
        }
    }
}

impl From<bool> for Setting {
    fn from(value: bool) -> Self {
        Self::Bool(value)
    }
}

impl From<f64> for Setting {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<&str> for Setting {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}

impl Serialize for Setting {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match (self, self.as_integer()) {
            (_, Some(integer)) => serializer.serialize_i64(integer),
            (Self::Bool(value), _) => serializer.serialize_bool(*value),
            (Self::Number(value), _) => serializer.serialize_f64(*value),
            (Self::Text(value), _) => serializer.serialize_str(value),
        }
    }
}

impl<'de> Deserialize<'de> for Setting {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Reader)
    }
}

impl JsonSchema for Setting {
    fn schema_name() -> Cow<'static, str> {
        "Setting".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Yes or no, a finite number, or a text.",
            "type": ["boolean", "number", "string"],
        })
    }
}

struct Reader;

impl Visitor<'_> for Reader {
    type Value = Setting;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("true, false, a number or a text")
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Setting, E> {
        Ok(Setting::Bool(value))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Setting, E> {
        if value.is_finite() {
            // Minus zero and zero are one value: they must not differ in a hash.
            Ok(Setting::Number(value + 0.0))
        } else {
            Err(E::custom("a number that is set must be finite"))
        }
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Setting, E> {
        let number = value as f64;
        if number.abs() > EXACT_INTEGERS {
            return Err(E::custom("a whole number must lie within 2^53 of 0"));
        }
        Ok(Setting::Number(number))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Setting, E> {
        let value = i64::try_from(value).unwrap_or(i64::MAX);
        self.visit_i64(value)
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<Setting, E> {
        Ok(Setting::Text(value.to_owned()))
    }
}
