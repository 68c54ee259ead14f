//! A file's JSON Schema as a reference for people, in Markdown: a table of keys for each of its tables.

use corroborate::schemas::FileOfStudy;
use serde_json::{Map, Value};
use std::fmt::Write as _;

/// How the reference of all files begins.
#[cfg(test)]
pub const HEAD: &str = "\
# The files of a study

Made of the types that read the files; `corroborate schema FILE` prints the same, `--format json` as a JSON Schema for editors
(`corroborate init` writes the line that makes them use it). Keys in bold are required. What two keys say together is checked
when the study is loaded; mistakes are shown with their place.
";

/// The keys of a file.
pub fn of_file(file: &FileOfStudy) -> String {
    let root = file.schema.as_value();
    let mut output = format!("## {}\n\n{}.\n", file.name, capital(file.says));
    table(&mut output, root, "");
    for (name, definition) in definitions(root) {
        let _ = write!(output, "\n### {} of {}\n", shown_name(name), file.name);
        if let Some(words) = words(definition) {
            let _ = write!(output, "\n{words}\n");
        }
        table(&mut output, definition, "");
    }
    output
}

/// The keys of a schema that say nothing of themselves, as `Type.key`.
#[cfg(test)]
pub fn keys_without_words(file: &FileOfStudy) -> Vec<String> {
    let root = file.schema.as_value();
    let mut missing = Vec::new();
    let parts = definitions(root).into_iter();
    for (name, part) in parts.chain([(file.name, root)]) {
        for object in [part].into_iter().chain(variants(part)) {
            for (key, property) in properties(object) {
                if words_of_key(object, property).is_none() && property.get("const").is_none() {
                    missing.push(format!("{name}.{key}"));
                }
            }
        }
    }
    missing
}

fn definitions(root: &Value) -> Vec<(&str, &Value)> {
    let definitions = root.get("$defs").and_then(Value::as_object);
    let definitions = definitions.into_iter().flatten();
    definitions.map(|(name, it)| (name.as_str(), it)).collect()
}

fn properties(schema: &Value) -> impl Iterator<Item = (&str, &Value)> {
    let properties = schema.get("properties").and_then(Value::as_object);
    let properties = properties.into_iter().flatten();
    properties.map(|(name, property)| (name.as_str(), property))
}

/// The forms of which a schema has one.
fn variants(schema: &Value) -> impl Iterator<Item = &Value> {
    let lists = ["oneOf", "anyOf"].into_iter();
    let lists = lists.filter_map(|key| schema.get(key)?.as_array());
    lists.flatten()
}

/// A schema's own words, on one line, without examples in code and without links.
fn words(schema: &Value) -> Option<String> {
    let words = schema.get("description")?.as_str()?;
    let words = words.split("```").next().unwrap_or_default();
    let words = words.replace("[`", "`").replace("`]", "`");
    let words: Vec<&str> = words.split_whitespace().collect();
    (!words.is_empty()).then(|| words.join(" "))
}

/// The words of a key; a form with this key alone, or with it beside its tag, may have them instead.
fn words_of_key(form: &Value, property: &Value) -> Option<String> {
    let keys = properties(form).filter(|(_, it)| it.get("const").is_none());
    let is_alone = || keys.count() == 1;
    words(property).or_else(|| words(form).filter(|_| is_alone()))
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|letter| letter.to_uppercase());
    first.into_iter().flatten().chain(letters).collect()
}

/// The name of a type without what only the code needs.
fn shown_name(name: &str) -> &str {
    let suffixes = ["Text", "Data", "Keys"].into_iter();
    suffixes
        .filter_map(|suffix| name.strip_suffix(suffix))
        .find(|rest| !rest.is_empty())
        .unwrap_or(name)
}

/// What stands in a table of this schema: its keys, then those of each of its forms, or the words that it may be.
fn table(output: &mut String, schema: &Value, title: &str) {
    if !title.is_empty() {
        let _ = write!(output, "\n{title}\n");
    }
    rows(output, schema);
    if let Some(of_each) = schema.get("additionalProperties")
        && (of_each.is_object() || of_each == true)
    {
        let _ = write!(output, "\nAny name: {}.\n", value_of(of_each));
    }
    choices(output, schema);
    for form in variants(schema) {
        let Some((tag, word)) = tag_of(form) else {
            if words_of_choice(form).is_none() {
                rows(output, form);
            }
            continue;
        };
        let words = words(form).unwrap_or_default();
        table(output, form, &format!("With `{tag} = \"{word}\"`: {words}"));
    }
}

fn rows(output: &mut String, schema: &Value) {
    let keys: Vec<_> = properties(schema).collect();
    let keys = keys.into_iter().filter(|(_, it)| it.get("const").is_none());
    let (required, optional): (Vec<_>, Vec<_>) =
        keys.partition(|(key, _)| is_required(schema, key));
    if required.is_empty() && optional.is_empty() {
        return;
    }
    *output += "\n| key | value | meaning |\n|---|---|---|\n";
    for (mark, keys) in [("**", required), ("", optional)] {
        for (key, property) in keys {
            let meaning =
                words_of_key(schema, property).unwrap_or_default() + &default_of(property);
            let _ = writeln!(
                output,
                "| {mark}`{key}`{mark} | {} | {} |",
                value_of(property),
                meaning.replace('|', "\\|")
            );
        }
    }
}

fn is_required(schema: &Value, key: &str) -> bool {
    let required = schema.get("required").and_then(Value::as_array);
    required.is_some_and(|keys| keys.iter().any(|it| it == key))
}

fn default_of(property: &Value) -> String {
    let is_nothing = |value: &Value| match value {
        Value::Null => true,
        Value::Array(elements) => elements.is_empty(),
        Value::Object(object) => object.is_empty(),
        Value::String(text) => text.is_empty(),
        _ => false,
    };
    match property.get("default") {
        Some(value) if !is_nothing(value) => format!(" Default: `{value}`."),
        _ => String::new(),
    }
}

/// The key whose word says which form this is, with the word.
fn tag_of(form: &Value) -> Option<(&str, &str)> {
    properties(form).find_map(|(key, property)| Some((key, property.get("const")?.as_str()?)))
}

/// The words that a value may be, with what each means.
fn choices(output: &mut String, schema: &Value) {
    let mut found: Vec<(String, String)> = Vec::new();
    for form in [schema].into_iter().chain(variants(schema)) {
        found.extend(words_of_choice(form).into_iter().flatten());
    }
    if found.is_empty() {
        return;
    }
    *output += "\n| word | meaning |\n|---|---|\n";
    for (word, meaning) in found {
        let _ = writeln!(output, "| `{word}` | {meaning} |");
    }
}

fn words_of_choice(form: &Value) -> Option<Vec<(String, String)>> {
    let meaning = || words(form).unwrap_or_default();
    if let Some(word) = form.get("const").and_then(Value::as_str) {
        return Some(vec![(word.to_owned(), meaning())]);
    }
    let all = form.get("enum")?.as_array()?.iter();
    Some(
        all.filter_map(|word| Some((word.as_str()?.to_owned(), String::new())))
            .collect(),
    )
}

/// What a value has to be.
fn value_of(schema: &Value) -> String {
    let Some(object) = schema.as_object() else {
        return "any value".into();
    };
    if let Some(name) = object.get("$ref").and_then(Value::as_str) {
        let name = name.rsplit('/').next().unwrap_or(name);
        return shown_name(name).to_owned();
    }
    let forms: Vec<&Value> = variants(schema).filter(|form| !is_null(form)).collect();
    if !forms.is_empty() {
        let mut shown: Vec<String> = forms.into_iter().map(value_of).collect();
        shown.dedup();
        return shown.join(" or ");
    }
    if let Some(word) = object.get("const") {
        return format!("`{word}`");
    }
    if let Some(words) = object.get("enum").and_then(Value::as_array) {
        let words: Vec<String> = words.iter().map(|word| format!("`{word}`")).collect();
        return words.join(", ");
    }
    let types: Vec<&str> = match object.get("type") {
        Some(Value::String(one)) => vec![one],
        Some(Value::Array(more)) => more.iter().filter_map(Value::as_str).collect(),
        _ => return "any value".into(),
    };
    let shown = types.iter().filter(|name| **name != "null");
    let shown: Vec<String> = shown.map(|name| value_of_type(name, object)).collect();
    shown.join(" or ")
}

fn is_null(schema: &Value) -> bool {
    schema.get("type").is_some_and(|name| name == "null")
}

fn value_of_type(name: &str, object: &Map<String, Value>) -> String {
    match name {
        "string" => "text".into(),
        "boolean" => "`true` or `false`".into(),
        "integer" => "whole number".into(),
        "array" => {
            let of = object.get("items").map_or("any value".into(), value_of);
            match object.get("minItems").and_then(Value::as_u64) {
                Some(count) if object.get("maxItems").and_then(Value::as_u64) == Some(count) => {
                    format!("{count} x {of}")
                }
                _ => format!("list of {of}"),
            }
        }
        "object" => match object.get("additionalProperties") {
            Some(of_each) if of_each.is_object() || of_each == true => {
                format!("table by name: {}", value_of(of_each))
            }
            _ => "table".into(),
        },
        other => other.to_owned(),
    }
}
