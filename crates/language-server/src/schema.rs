//! What JSON Schemas say of keys: what they mean, which there are, which values they may have.

use serde_json::{Map, Value};

/// How many references are followed.
const DEEPEST: usize = 30;

/// A part of a schema.
#[derive(Clone, Copy)]
struct Part<'s> {
    root: &'s Value,
    here: &'s Value,
}

impl<'s> Part<'s> {
    fn with(self, here: &'s Value) -> Self {
        Self { here, ..self }
    }

    /// What it refers to, and all that it may be instead.
    fn alternatives(self) -> Vec<Self> {
        let mut all = Vec::new();
        self.collect(DEEPEST, &mut all);
        all
    }

    fn collect(self, depth: usize, all: &mut Vec<Self>) {
        if depth == 0 || all.len() > 200 {
            return;
        }
        all.push(self);
        if let Some(reference) = self.here.get("$ref").and_then(Value::as_str) {
            let target = reference
                .strip_prefix('#')
                .and_then(|it| self.root.pointer(it));
            if let Some(target) = target {
                self.with(target).collect(depth - 1, all);
            }
        }
        for key in ["anyOf", "oneOf", "allOf"] {
            let parts = self.here.get(key).and_then(Value::as_array);
            for part in parts.into_iter().flatten() {
                self.with(part).collect(depth - 1, all);
            }
        }
    }

    /// What stands under a key, or at a place in a list.
    fn step(self, key: &str) -> Vec<Self> {
        let mut found = Vec::new();
        for part in self.alternatives() {
            let property = part.here.get("properties").and_then(|it| it.get(key));
            let other = part
                .here
                .get("additionalProperties")
                .filter(|it| it.is_object());
            let item = part
                .here
                .get("items")
                .filter(|_| key.parse::<usize>().is_ok());
            if let Some(next) = property.or(item).or(other) {
                found.push(part.with(next));
            }
        }
        found
    }

    fn at(self, path: &[String]) -> Vec<Self> {
        let mut here = vec![self];
        for key in path {
            here = here.into_iter().flat_map(|it| it.step(key)).collect();
        }
        here
    }
}

/// What a schema says of the key at the end of a path.
#[must_use]
pub fn description(schema: &Value, path: &[String]) -> Option<String> {
    let part = Part {
        root: schema,
        here: schema,
    };
    let found = part.at(path);
    let described = found.iter().flat_map(|it| it.alternatives());
    described
        .filter_map(|it| it.here.get("description")?.as_str())
        .next()
        .map(str::to_owned)
}

/// The keys that a table at a path may have, each with what it means.
#[must_use]
pub fn keys(schema: &Value, path: &[String]) -> Vec<(String, String)> {
    let part = Part {
        root: schema,
        here: schema,
    };
    let mut found: Vec<(String, String)> = Vec::new();
    for table in part.at(path).into_iter().flat_map(Part::alternatives) {
        let keys = table.here.get("properties").and_then(Value::as_object);
        for (key, what) in keys.into_iter().flat_map(Map::iter) {
            let said = table.with(what).alternatives().into_iter();
            let said = said
                .filter_map(|it| it.here.get("description")?.as_str())
                .next();
            if found.iter().all(|(known, _)| known != key) {
                found.push((key.clone(), said.unwrap_or("").to_owned()));
            }
        }
    }
    found
}

/// The words that the value at a path may be, each with what it means.
#[must_use]
pub fn choices(schema: &Value, path: &[String]) -> Vec<(String, String)> {
    let part = Part {
        root: schema,
        here: schema,
    };
    let mut found: Vec<(String, String)> = Vec::new();
    for value in part.at(path).into_iter().flat_map(Part::alternatives) {
        let said = value.here.get("description").and_then(Value::as_str);
        let words = value.here.get("enum").and_then(Value::as_array);
        let one = value.here.get("const");
        let all = words
            .into_iter()
            .flatten()
            .chain(one)
            .filter_map(Value::as_str);
        for word in all {
            if found.iter().all(|(known, _)| known != word) {
                let said = said.filter(|_| one.is_some()).unwrap_or("");
                found.push((word.to_owned(), said.to_owned()));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn references_lists_and_alternatives_are_followed() {
        let schema = json!({
            "properties": { "list": { "items": { "$ref": "#/$defs/One" }, "description": "all" } },
            "additionalProperties": { "properties": { "k": { "description": "any key" } } },
            "$defs": { "One": { "properties": { "a": { "anyOf": [{ "$ref": "#/$defs/Word" }], "description": "an a" } } },
                       "Word": { "oneOf": [{ "const": "x", "description": "an x" }, { "enum": ["y", "z"] }] } }
        });
        let path = |text: &str| text.split('.').map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(description(&schema, &path("list")).as_deref(), Some("all"));
        assert_eq!(
            description(&schema, &path("list.0.a")).as_deref(),
            Some("an a")
        );
        assert_eq!(
            description(&schema, &path("other.k")).as_deref(),
            Some("any key")
        );
        assert_eq!(description(&schema, &path("list.0.b")), None);
        assert_eq!(
            keys(&schema, &path("list.3")),
            [("a".to_owned(), "an a".to_owned())]
        );
        let words: Vec<_> = choices(&schema, &path("list.0.a"))
            .into_iter()
            .map(|it| it.0)
            .collect();
        assert_eq!(words, ["x", "y", "z"]);
    }

    #[test]
    fn a_schema_that_refers_to_itself_ends() {
        let schema = json!({ "$ref": "#" });
        assert_eq!(description(&schema, &["a".to_owned()]), None);
    }
}
