//! The text of `requirements.toml`, edited as a person would: only what changes changes, comments stay.

use super::drift::SentenceShown;
use super::merge::Merged;
use diagnostic::{Problem, Source};
use host::files::{with_line_ends_of, write_whole};
use requirement_files::{Document, Field, Item};
use std::ops::Range;
use study::Study;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A replacement at a place.
struct Edit {
    span: Range<usize>,
    text: String,
}

/// The text with what is carried over; `None` if that is nothing.
pub(super) fn edited(
    study: &Study,
    document: &Document,
    merged: &Merged,
    sentences: &[SentenceShown],
    with_sentences: bool,
) -> Result<Option<String>, Problem> {
    if merged.changed.is_empty() && merged.added.is_empty() {
        return Ok(None);
    }
    let source = &study.forms.source;
    let root = DeTable::parse(&source.text).map_err(|error| {
        Problem::new("bad-study-file", error.to_string()).at(source, error.span().unwrap_or(0..0))
    })?;
    let mut edits = Vec::new();
    for (id, fields) in merged.fields_by_id() {
        let Some(placed) = document.item(id) else {
            continue;
        };
        let table = table(root.get_ref(), id);
        let table = table.ok_or_else(|| not_found(source, id))?;
        for field in fields {
            edits.extend(set(&source.text, table, field, &placed.item));
        }
    }
    let mut text = applied(&source.text, edits);
    for item in &merged.added {
        let sentence = sentences.iter().find(|it| it.id == item.id);
        append(&mut text, item, sentence, with_sentences);
    }
    let text = with_line_ends_of(&text, &source.text).into_owned();
    hold_against(&text, document, merged)?;
    Ok(Some(text))
}

fn not_found(source: &Source, id: &str) -> Problem {
    Problem::new(
        "unknown-requirement",
        format!("`{id}` cannot be found in {}", source.name),
    )
}

/// The requirement of this id.
fn table<'t, 'a>(root: &'t DeTable<'a>, id: &str) -> Option<&'t DeTable<'a>> {
    let DeValue::Array(all) = get(root, "requirement")?.1.get_ref() else {
        return None;
    };
    let mut tables = all.iter().filter_map(|it| match it.get_ref() {
        DeValue::Table(table) => Some(table),
        _ => None,
    });
    tables.find(|table| matches!(get(table, "id").map(|it| it.1.get_ref()), Some(DeValue::String(own)) if own == id))
}

type Entry<'t, 'a> = (
    &'t Spanned<std::borrow::Cow<'a, str>>,
    &'t Spanned<DeValue<'a>>,
);

fn get<'t, 'a>(table: &'t DeTable<'a>, key: &str) -> Option<Entry<'t, 'a>> {
    let mut all = table.iter();
    all.find(|(name, _)| name.get_ref() == key)
}

/// The value of a field as TOML writes it.
fn written(item: &Item, field: Field) -> String {
    match field {
        Field::Parents => {
            let all: Vec<String> = item.parents.iter().map(|it| quoted(it)).collect();
            format!("[{}]", all.join(", "))
        }
        _ => quoted(&item.value(field)),
    }
}

/// A text as TOML writes it: as it is where it can be, in several lines where it has some.
pub(super) fn quoted(text: &str) -> String {
    let is_odd = |letter: char| letter.is_control() && letter != '\n';
    if text.contains('\n') && !text.contains(is_odd) {
        let inner = text.replace('\\', "\\\\");
        // Three quotes would end it.
        let inner = match text.contains("\"\"\"") || text.ends_with('"') {
            true => inner.replace('"', "\\\""),
            false => inner,
        };
        return format!("\"\"\"\n{inner}\"\"\"");
    }
    if text.contains(['"', '\\']) && !text.contains('\'') && !text.contains(char::is_control) {
        return format!("'{text}'");
    }
    let mut out = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            odd if is_odd(odd) => out.push_str(&format!("\\u{:04X}", odd as u32)),
            other => out.push(other),
        }
    }
    out.push('"');
    out
}

fn set(text: &str, table: &DeTable<'_>, field: Field, item: &Item) -> Option<Edit> {
    let value = written(item, field);
    if let Some((_, known)) = get(table, field.name()) {
        let span = known.span();
        return Some(Edit { span, text: value });
    }
    let (_, own) = get(table, "text").or_else(|| get(table, "id"))?;
    let end = own.span().end;
    let start = text[..own.span().start].rfind('\n').map_or(0, |at| at + 1);
    // In a table in braces, all keys stand in one line.
    let line = &text[start..];
    if line.trim_start().starts_with('{') || line.trim_start().starts_with("requirement") {
        let text = format!(", {} = {value}", field.name());
        return Some(Edit {
            span: end..end,
            text,
        });
    }
    let at = text[end..].find('\n').map_or(text.len(), |at| end + at);
    let text = format!("\n{} = {value}", field.name());
    Some(Edit { span: at..at, text })
}

fn applied(text: &str, mut edits: Vec<Edit>) -> String {
    edits.sort_by_key(|edit| (edit.span.start, edit.span.end));
    let mut new = String::with_capacity(text.len() + 256);
    let mut from = 0;
    for edit in edits {
        new.push_str(&text[from..edit.span.start]);
        new.push_str(&edit.text);
        from = edit.span.end;
    }
    new.push_str(&text[from..]);
    new
}

/// Adds a requirement, with its translated sentence as a proposal.
fn append(text: &mut String, item: &Item, sentence: Option<&SentenceShown>, with_sentences: bool) {
    if !text.is_empty() && !text.ends_with('\n') {
        text.push('\n');
    }
    text.push_str(&format!("\n[[requirement]]\nid = {}\n", quoted(&item.id)));
    for field in Field::ALL {
        if field == Field::Text || !item.value(field).is_empty() {
            text.push_str(&format!("{} = {}\n", field.name(), written(item, field)));
        }
    }
    let Some((shown, own)) = sentence.and_then(|it| Some((it, it.sentence.as_ref()?))) else {
        return;
    };
    // What a file of another tool says stays in its line.
    let plain = |text: &str| text.replace(char::is_control, " ");
    if with_sentences && shown.can_be_taken() {
        text.push_str(&format!("shall = {}\n", quoted(own)));
        return;
    }
    text.push_str(&format!("# shall = {}\n", plain(&quoted(own))));
    for definition in &shown.definitions {
        text.push_str(&format!("#   {}\n", plain(definition)));
    }
    if !shown.not_in_vocabulary.is_empty() {
        let names = plain(&shown.not_in_vocabulary.join("; "));
        text.push_str(&format!("#   not in vocabulary.toml yet: {names}\n"));
    }
}

/// Reads the new text, and fails unless it holds what was carried over.
fn hold_against(text: &str, document: &Document, merged: &Merged) -> Result<(), Problem> {
    let failed = |id: &str, reason: &str| {
        let message = format!("`{id}` cannot be written into requirements.toml: {reason}");
        Problem::new("cannot-write-requirement", message)
            .remedy("write the requirements as tables, each below a line `[[requirement]]`")
    };
    let root: toml::Table =
        toml::from_str(text).map_err(|error| failed("requirements", error.message()))?;
    let all = root.get("requirement").and_then(toml::Value::as_array);
    let of = |id: &str| {
        let mut all = all.into_iter().flatten();
        all.find(|it| it.get("id").and_then(toml::Value::as_str) == Some(id))
    };
    let value = |table: &toml::Value, field: Field| match table.get(field.name()) {
        Some(toml::Value::Array(all)) => {
            let all = all.iter().filter_map(toml::Value::as_str);
            all.collect::<Vec<_>>().join(", ")
        }
        // Where lines of the file end with CR LF, those of a value do.
        Some(value) => value.as_str().unwrap_or_default().replace("\r\n", "\n"),
        None => String::new(),
    };
    let changed = merged.fields_by_id().into_iter();
    let added = merged
        .added
        .iter()
        .map(|item| (item.id.as_str(), Field::ALL.to_vec()));
    for (id, fields) in changed.chain(added) {
        let item = document.item(id).map(|placed| &placed.item);
        let (Some(table), Some(item)) = (of(id), item) else {
            return Err(failed(id, "it would not be found again"));
        };
        for field in fields {
            if value(table, field) != item.value(field) {
                return Err(failed(
                    id,
                    &format!("its {field} would not be read again as it is"),
                ));
            }
        }
    }
    Ok(())
}

/// Writes the text; a study that it breaks gets its old text back.
pub(super) fn write(study: &Study, text: &str) -> Result<(), Problem> {
    let path = study.folder.join("requirements.toml");
    write_whole(&path, text.as_bytes())?;
    match study.again() {
        Ok(_) => Ok(()),
        Err(problem) => {
            write_whole(&path, study.forms.source.text.as_bytes())?;
            Err(problem.about(
                "with what was imported, the study would not be read, so nothing was written",
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_written_so_that_they_are_read_again() {
        for text in [
            "plain",
            "say \"no\" \\ now",
            "it's \"both\" \\",
            "two\nlines \\ \"\"\" and \"",
            "\nleading",
            "tab\tand\r\nodd\u{1}",
            "",
            "'''",
        ] {
            let read: toml::Table = toml::from_str(&format!("a = {}", quoted(text))).expect(text);
            assert_eq!(read["a"].as_str(), Some(text));
        }
    }
}
