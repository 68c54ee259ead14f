//! `corroborate inspect`: what is in a recording, and a draft of its topic
//! map.

use super::{Done, json};
use crate::args::{Format, Inspect};
use corroborate::outcome::Outcome;
use diagnostic::Problem;
use host::files::write_whole;
use recording::{InspectOptions, Inspection};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;

mod description;
mod form;

/// What `inspect --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct InspectReport {
    /// Version of this form.
    pub format: String,
    /// The recording.
    pub file: String,
    /// Where the draft of the topic map was written.
    pub draft_map: Option<String>,
    /// What is in it.
    #[schemars(with = "form::InspectionForm")]
    pub recording: Inspection,
}

/// Looks into a recording, or a description of a robot.
pub fn inspect(arguments: &Inspect) -> Result<Done, Problem> {
    if description::is_description(&arguments.recording) {
        return description::inspect(arguments);
    }
    let options = InspectOptions {
        gap_factor: arguments.gap_factor,
    };
    let opening = arguments.opening.options();
    let found = recording::inspect(&arguments.recording, &opening, &options)
        .map_err(|error| Problem::new("bad-recording", error.to_string()))?;
    let outcome = outcome(&found);
    let printed = arguments.draft_map.as_deref() == Some(Path::new("-"));
    if printed && arguments.format == Format::Text {
        let output = found.draft_map();
        return Ok(Done { output, outcome });
    }
    let written = match &arguments.draft_map {
        Some(path) if !printed => Some(write_draft(path, &found)?),
        _ => None,
    };
    let output = match arguments.format {
        Format::Text => text(&found, written.as_deref()),
        Format::Json => json(&InspectReport {
            format: "1.0".into(),
            file: arguments.recording.display().to_string(),
            draft_map: written,
            recording: found,
        })?,
    };
    Ok(Done { output, outcome })
}

/// Writes the draft, but never over a map that somebody has worked on.
fn write_draft(path: &Path, found: &Inspection) -> Result<String, Problem> {
    if path.exists() {
        return Err(Problem::new(
            "already-there",
            format!(
                "{} is there already, and a draft would replace it",
                path.display()
            ),
        )
        .remedy("name a new file, or print the draft with --draft-map -"));
    }
    write_whole(path, found.draft_map().as_bytes())?;
    Ok(path.display().to_string())
}

/// Whether something of the recording is lost.
fn outcome(found: &Inspection) -> Outcome {
    let misfits = found.topics.iter().any(|topic| topic.misfits > 0);
    let lost = !found.complete || found.error.is_some() || !found.losses.is_empty();
    if lost || misfits {
        Outcome::DataLost
    } else {
        Outcome::Holds
    }
}

fn text(found: &Inspection, written: Option<&str>) -> String {
    let mut output = found.to_string();
    if let Some(path) = written {
        output.push_str(&format!(
            "a draft of the topic map is in {path}: delete what is not needed, name the rest\n"
        ));
    }
    output
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(InspectReport).into();
        crate::command::tests::assert_schema_is_committed("inspect.schema.json", &schema);
    }
}
