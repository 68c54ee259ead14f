//! Whether JSON has the form that a JSON schema describes: the keywords that our schemas use, and no others.

use serde_json::{Map, Value};

/// All places at which `value` is not as `schema` says; empty if it conforms.
///
/// # Panics
/// If the schema uses a keyword that this validator does not know: a schema must not be half checked.
pub fn violations(schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    Validator { root: schema }.check(schema, value, "$", &mut found);
    found
}

struct Validator<'s> {
    root: &'s Value,
}

impl Validator<'_> {
    fn check(&self, schema: &Value, value: &Value, place: &str, found: &mut Vec<String>) {
        match schema {
            Value::Bool(true) => {}
            Value::Object(keywords) => {
                for (keyword, wanted) in keywords {
                    self.keyword(keywords, keyword, wanted, value, place, found);
                }
            }
            _ => found.push(format!("{place}: nothing is allowed here")),
        }
    }

    fn keyword(
        &self,
        all: &Map<String, Value>,
        keyword: &str,
        wanted: &Value,
        value: &Value,
        place: &str,
        found: &mut Vec<String>,
    ) {
        let mut fail = |what: String| found.push(format!("{place}: {what}, found {value}"));
        match keyword {
            "$schema" | "$defs" | "title" | "description" | "default" | "format" => {}
            "$ref" => self.check(self.referred(wanted), value, place, found),
            "type" if !has_type(wanted, value) => fail(format!("expected {wanted}")),
            "type" => {}
            "const" if wanted != value => fail(format!("expected {wanted}")),
            "const" => {}
            "enum" if !items(wanted).contains(value) => fail(format!("expected one of {wanted}")),
            "enum" => {}
            "minimum" if value.is_number() && value.as_f64() < wanted.as_f64() => {
                fail(format!("at least {wanted}"))
            }
            "minimum" => {}
            "maximum" if value.is_number() && value.as_f64() > wanted.as_f64() => {
                fail(format!("at most {wanted}"));
            }
            "maximum" => {}
            "minItems" if value.is_array() && (items(value).len() as u64) < count(wanted) => {
                fail(format!("at least {wanted} items"));
            }
            "maxItems" if value.is_array() && (items(value).len() as u64) > count(wanted) => {
                fail(format!("at most {wanted} items"));
            }
            "minItems" | "maxItems" => {}
            "anyOf" | "oneOf" => {
                let fitting = items(wanted)
                    .iter()
                    .filter(|one| self.fits(one, value))
                    .count();
                if fitting == 0 || (keyword == "oneOf" && fitting > 1) {
                    fail(format!("{fitting} of the alternatives fit"));
                }
            }
            "allOf" => items(wanted)
                .iter()
                .for_each(|one| self.check(one, value, place, found)),
            "required" => {
                for name in items(wanted).iter().filter_map(Value::as_str) {
                    if value.is_object() && value.get(name).is_none() {
                        found.push(format!("{place}: `{name}` is missing"));
                    }
                }
            }
            "properties" => self.properties(wanted, value, place, found),
            "additionalProperties" => self.further(all, wanted, value, place, found),
            "items" => {
                for (index, item) in items(value).iter().enumerate() {
                    self.check(wanted, item, &format!("{place}[{index}]"), found);
                }
            }
            // The places of a tuple.
            "prefixItems" => {
                for (index, (wanted, item)) in items(wanted).iter().zip(items(value)).enumerate() {
                    self.check(wanted, item, &format!("{place}[{index}]"), found);
                }
            }
            unknown => panic!("the validator does not know the keyword `{unknown}`"),
        }
    }

    fn properties(&self, wanted: &Value, value: &Value, place: &str, found: &mut Vec<String>) {
        let Some(wanted) = wanted.as_object() else {
            return;
        };
        for (name, schema) in wanted {
            if let Some(inner) = value.get(name) {
                self.check(schema, inner, &format!("{place}.{name}"), found);
            }
        }
    }

    fn further(
        &self,
        all: &Map<String, Value>,
        wanted: &Value,
        value: &Value,
        place: &str,
        found: &mut Vec<String>,
    ) {
        let (Some(object), known) = (value.as_object(), all.get("properties")) else {
            return;
        };
        for (name, inner) in object {
            if known.and_then(|k| k.get(name)).is_none() {
                self.check(wanted, inner, &format!("{place}.{name}"), found);
            }
        }
    }

    fn fits(&self, schema: &Value, value: &Value) -> bool {
        let mut found = Vec::new();
        self.check(schema, value, "$", &mut found);
        found.is_empty()
    }

    fn referred(&self, reference: &Value) -> &Value {
        let pointer = reference.as_str().and_then(|r| r.strip_prefix('#'));
        let pointer = pointer.expect("a reference within the schema");
        self.root
            .pointer(pointer)
            .expect("a reference that leads somewhere")
    }
}

fn count(value: &Value) -> u64 {
    value.as_u64().expect("a number of items")
}

fn items(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn has_type(wanted: &Value, value: &Value) -> bool {
    let is = |name: &str| match name {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        _ => false,
    };
    match wanted {
        Value::String(name) => is(name),
        _ => items(wanted).iter().filter_map(Value::as_str).any(is),
    }
}

#[test]
fn what_does_not_conform_is_found() {
    let schema: Value = serde_json::from_str(
        r##"{"type": "object", "required": ["a"], "properties": {"a": {"$ref": "#/$defs/n"}},
            "additionalProperties": false, "$defs": {"n": {"type": ["integer", "null"], "minimum": 0}}}"##,
    )
    .expect("a schema");
    let count = |text: &str| violations(&schema, &serde_json::from_str(text).expect("json")).len();
    assert_eq!(count(r#"{"a": 1}"#), 0);
    assert_eq!(count(r#"{"a": null}"#), 0);
    assert_eq!(count(r#"{}"#), 1);
    assert_eq!(count(r#"{"a": -1}"#), 1);
    assert_eq!(count(r#"{"a": 1.5}"#), 1);
    assert_eq!(count(r#"{"a": 1, "b": 2}"#), 1);
    let pair: Value = serde_json::from_str(r#"{"minItems": 2, "maxItems": 2}"#).expect("a schema");
    let of = |length: usize| violations(&pair, &Value::Array(vec![Value::Null; length])).len();
    assert_eq!((of(1), of(2), of(3)), (1, 0, 1));
}
