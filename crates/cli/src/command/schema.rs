//! `corroborate schema`: the keys of a study's files, as a reference for people and as JSON Schemas for editors.

mod text;

use super::{Done, json};
use crate::args::{Format, SchemaOfFile};
use corroborate::Outcome;
use corroborate::schemas::{FileOfStudy, files};
use diagnostic::{Problem, did_you_mean};
use std::fmt::Write as _;

/// Shows the kinds of file, or the keys of one.
pub fn schema(arguments: &SchemaOfFile) -> Result<Done, Problem> {
    let files = files();
    let output = match &arguments.file {
        None => list(&files, arguments.format)?,
        Some(name) => {
            let file = find(&files, name)?;
            match arguments.format {
                Format::Text => text::of_file(file),
                Format::Json => json(&file.schema)?,
            }
        }
    };
    Ok(Done {
        output,
        outcome: Outcome::Holds,
    })
}

fn find<'f>(files: &'f [FileOfStudy], name: &str) -> Result<&'f FileOfStudy, Problem> {
    let is_named =
        |file: &&FileOfStudy| file.name == name || file.name.strip_suffix(".toml") == Some(name);
    files.iter().find(is_named).ok_or_else(|| {
        let names = files.iter().map(|file| file.name);
        Problem::new(
            "unknown-file",
            format!("`{name}` is not a kind of file that a study has"),
        )
        .remedy(match did_you_mean(name, names) {
            Some(similar) => format!("did you mean `{similar}`?"),
            None => "`corroborate schema` lists them".to_owned(),
        })
    })
}

fn list(files: &[FileOfStudy], format: Format) -> Result<String, Problem> {
    if format == Format::Json {
        let all: serde_json::Map<String, serde_json::Value> = files
            .iter()
            .map(|file| (file.name.to_owned(), file.schema.as_value().clone()))
            .collect();
        return json(&all);
    }
    let mut output = String::new();
    for file in files {
        let _ = writeln!(output, "{:<24} {}", file.name, file.says);
    }
    output += "Next: corroborate schema scene.toml\n";
    Ok(output)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::tests::assert_schema_is_committed;

    #[test]
    fn the_committed_schemas_of_files_are_their_forms() {
        for file in files() {
            let name = format!("study/{}", file.schema_name());
            assert_schema_is_committed(&name, file.schema.as_value());
        }
    }

    #[test]
    fn every_key_has_words() {
        for file in files() {
            let missing = text::keys_without_words(&file);
            assert!(missing.is_empty(), "{}: {missing:?}", file.name);
        }
    }

    #[test]
    fn the_committed_reference_is_made_of_the_schemas() {
        let mut reference = String::from(text::HEAD);
        for file in files() {
            reference += "\n";
            reference += &text::of_file(&file);
        }
        crate::command::tests::assert_is_committed("docs/reference/study-files.md", &reference);
    }
}
