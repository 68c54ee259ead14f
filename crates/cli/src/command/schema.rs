//! `corroborate schema`: the keys of a study's files, as a reference for people and as JSON Schemas for editors.

mod text;

use super::{Done, json};
use crate::args::{Format, SchemaOfFile};
use corroborate::outcome::Outcome;
use diagnostic::{Problem, did_you_mean};
use schemars::Schema;
use std::fmt::Write as _;

/// A kind of file that a study may have.
pub struct FileOfStudy {
    /// Its name, or that of its kind where a study may have several under names of its own.
    pub name: &'static str,
    /// What it says.
    pub says: &'static str,
    /// Its keys.
    pub schema: Schema,
}

/// What each kind of file says, in the order in which a study is written.
const SAYS: [(&str, &str); 16] = [
    (
        "study.toml",
        "title, levels of confidence, conditions, seed, costs and weights",
    ),
    (
        "parameters.toml",
        "each distance, speed and time once, with its unit",
    ),
    (
        "vocabulary.toml",
        "each proposition, bound to the formal model, to signals and to columns",
    ),
    (
        "requirements.toml",
        "what is required, and the ways to fail",
    ),
    (
        "ledger.toml",
        "the evidence, oldest first: technique, assets, lineage",
    ),
    (
        "topics.toml",
        "where recordings have the signals, with units, frames and clock",
    ),
    (
        "scene.toml",
        "a simulated scene: robots, objects, people, sensors, controllers, tests",
    ),
    (
        "scenario.toml",
        "the handover's scenario: robot, object, person, sensors, tests (`scenario` of an entry of the ledger)",
    ),
    (
        "scenario-parameters.toml",
        "what tuning changes in the handover (`parameters` of an entry of the ledger)",
    ),
    (
        "ros2.toml",
        "which signals `simulate --as` writes into which messages of ROS 2",
    ),
    (
        "exploration.toml",
        "what `explore` may vary, and where its tests come from",
    ),
    ("calibration.toml", "what `calibrate` fits to which counts"),
    ("rare.toml", "the events whose probability `rare` estimates"),
    (
        "variant.toml",
        "a change of the assets that `what-if` tries (in `variants/`)",
    ),
    (
        "finding.toml",
        "an episode that shows something (in `regressions/`); `explore` and `shrink` write it",
    ),
    (
        "looks.toml",
        "the counts by which the study was judged so far; `run` writes it",
    ),
];

/// All kinds of file.
pub fn files() -> Vec<FileOfStudy> {
    let mut schemas = corroborate::schemas::all();
    schemas.push(("ros2.toml", corroborate::ros2_table::schema()));
    let with_words = SAYS.iter().filter_map(|(name, says)| {
        let place = schemas.iter().position(|(file, _)| file == name)?;
        let (_, schema) = schemas.swap_remove(place);
        Some(FileOfStudy { name, says, schema })
    });
    with_words.collect()
}

/// The schema's file beside a study's files.
pub fn schema_name(file: &str) -> String {
    file.replace(".toml", ".schema.json")
}

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
    fn every_file_has_its_schema_and_its_words() {
        let files = files();
        assert_eq!(files.len(), SAYS.len());
        assert_eq!(files.len(), corroborate::schemas::all().len() + 1);
        for file in &files {
            let name = format!("study/{}", schema_name(file.name));
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
