//! Where a scene's file says what is wrong with it.

use diagnostic::{Problem, Source};
use std::ops::Range;
use testbench::ScenarioError;
use testbench::scene::SceneData;
use toml::de::{DeTable, DeValue};

/// The problem of a scene that cannot be used, at its place in the file as far as that is known.
pub fn problem_of(source: &Source, error: &ScenarioError) -> Problem {
    let text = &source.text;
    let plain = || Problem::new("bad-scene", format!("{}: {error}", source.name));
    let span = match error {
        // Read as data it says where, as a table it does not.
        ScenarioError::Syntax { .. } => {
            let Err(error) = toml::from_str::<SceneData>(text) else {
                return plain();
            };
            let message = error.message().trim_end().to_owned();
            let own = study::place_of_unknown(text, &error);
            return match own.or(error.span()) {
                Some(span) => Problem::new("bad-scene", message).at(source, first_line(text, span)),
                None => plain(),
            };
        }
        ScenarioError::Value { key, .. } => span_of(text, key),
        ScenarioError::UnknownName { key, name } => {
            span_of(text, key).map(|span| named(text, span, name))
        }
        ScenarioError::Description { .. } => None,
        ScenarioError::Several(all) => {
            let each = all.iter().map(|error| problem_of(source, error));
            return Problem::all(each).unwrap_or_else(plain);
        }
    };
    match span {
        Some(span) => Problem::new("bad-scene", error.to_string()).at(source, span),
        None => plain(),
    }
}

/// The value at a dotted key, in which an entry of a list is known by its name or place; else the
/// last of its parents that is there.
pub fn span_of(text: &str, key: &str) -> Option<Range<usize>> {
    let root = DeTable::parse(text).ok()?;
    let mut parts = key.split('.').peekable();
    let mut found = root.get_ref().get(parts.next()?)?;
    for part in parts {
        let next = match found.get_ref() {
            DeValue::Table(table) => table.get(part),
            DeValue::Array(list) => match part.parse::<usize>() {
                Ok(place) => list.get(place),
                Err(_) => list.iter().find(|entry| {
                    let name = entry.get_ref().get("name");
                    name.is_some_and(|name| name.get_ref().as_str() == Some(part))
                }),
            },
            _ => None,
        };
        match next {
            Some(next) => found = next,
            None => break,
        }
    }
    Some(first_line(text, found.span()))
}

/// A table has many lines; the first says enough.
fn first_line(text: &str, span: Range<usize>) -> Range<usize> {
    let shown = text.get(span.clone()).unwrap_or_default();
    let length = shown.find('\n').unwrap_or(shown.len());
    span.start..span.start + length
}

/// Where `name` stands in quotes, from the span on; else the span.
fn named(text: &str, span: Range<usize>, name: &str) -> Range<usize> {
    let quoted = format!("\"{name}\"");
    let behind = text.get(span.start..).unwrap_or_default();
    match behind.find(&quoted) {
        Some(place) => span.start + place..span.start + place + quoted.len(),
        None => span,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[simulation]\nduration_secs = 5\n[[sensor]]\nname = \"a\"\nrays = 3\n[[sensor]]\nname = \"b\"\nrays = 0\njoints = [\"left\", \"right\"]\n";

    #[test]
    fn keys_are_found_by_name_and_by_place_or_else_their_parents() {
        let at = |key: &str| span_of(TEXT, key).map(|span| &TEXT[span]);
        assert_eq!(at("simulation.duration_secs"), Some("5"));
        assert_eq!(at("sensor.b.rays"), Some("0"));
        assert_eq!(at("sensor.0.rays"), Some("3"));
        assert_eq!(at("sensor.b.joints.1"), Some("\"right\""));
        assert!(at("sensor.b.fault.0.kind").is_some_and(|text| text.contains("sensor")));
        assert_eq!(at("nothing.at.all"), None);
        let span = span_of(TEXT, "sensor.b.joint").expect("the sensor");
        assert_eq!(&TEXT[named(TEXT, span, "right")], "\"right\"");
    }

    #[test]
    fn what_is_wrong_is_shown_with_its_line() {
        let source = Source {
            name: "scene.toml".into(),
            text: "name = \"s\"\nsimulation = { duration = 5 }\n".into(),
        };
        let error = ScenarioError::Syntax {
            reason: "unknown".into(),
        };
        let shown = problem_of(&source, &error).to_string();
        assert!(shown.contains("scene.toml:2"), "{shown}");
    }
}
