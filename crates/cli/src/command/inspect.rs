//! `corroborate inspect`: what is in a recording, and a draft of its topic
//! map; which signals a study's simulations have.

use super::{Done, json};
use crate::args::{Format, Inspect};
use corroborate::inspect::{
    DescriptionReport, InspectReport, InspectRequest, Inspected, StudySignals, write_draft,
};
use diagnostic::Problem;
use host::Host;
use recording::Inspection;
use robot_model::Loaded;
use std::path::Path;

mod description;
mod study;

/// Looks into a recording, or a description of a robot.
pub fn inspect(arguments: &Inspect, host: &Host) -> Result<Done, Problem> {
    let request = InspectRequest {
        file: arguments.recording.clone(),
        opening: arguments.opening.options(),
        gap_factor: arguments.gap_factor,
        packages: arguments.packages.clone(),
        arguments: arguments.arguments.iter().cloned().collect(),
    };
    let found = corroborate::inspect(&request, host)?;
    let outcome = found.outcome();
    let output = match found {
        Inspected::Recording(found) => of_recording(arguments, *found)?,
        Inspected::Description(loaded) => of_description(arguments, &loaded)?,
        Inspected::Study(found) => of_study(arguments, &found)?,
    };
    Ok(Done { output, outcome })
}

fn of_description(arguments: &Inspect, loaded: &Loaded) -> Result<String, Problem> {
    let name = arguments.recording.display().to_string();
    if arguments.draft_map.is_some() {
        let message = format!("{name} has no topics to draft a map of");
        return Err(Problem::new("bad-description", message).remedy("leave out --draft-map"));
    }
    match arguments.format {
        Format::Text => Ok(description::text(&name, loaded)),
        Format::Json => json(&DescriptionReport::new(name, loaded)),
    }
}

fn of_study(arguments: &Inspect, found: &StudySignals) -> Result<String, Problem> {
    if arguments.draft_map.is_some() {
        let message = format!(
            "{} is a study, which has no topics to draft a map of",
            found.study
        );
        return Err(Problem::new("bad-recording", message).remedy("leave out --draft-map"));
    }
    match arguments.format {
        Format::Text => Ok(study::text(found)),
        Format::Json => json(found),
    }
}

fn of_recording(arguments: &Inspect, found: Inspection) -> Result<String, Problem> {
    let printed = arguments.draft_map.as_deref() == Some(Path::new("-"));
    if printed && arguments.format == Format::Text {
        return Ok(found.draft_map());
    }
    let draft = arguments.draft_map.as_deref().filter(|_| !printed);
    if let Some(path) = draft {
        write_draft(path, &found)?;
    }
    let written = draft.map(|path| path.display().to_string());
    match arguments.format {
        Format::Text => Ok(text(&found, written.as_deref())),
        Format::Json => json(&InspectReport {
            format: "1.0".into(),
            file: arguments.recording.display().to_string(),
            draft_map: written,
            recording: found,
        }),
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
        let schema: serde_json::Value = schemars::schema_for!(DescriptionReport).into();
        let name = "inspect-description.schema.json";
        crate::command::tests::assert_schema_is_committed(name, &schema);
        let schema: serde_json::Value = schemars::schema_for!(StudySignals).into();
        crate::command::tests::assert_schema_is_committed("inspect-study.schema.json", &schema);
    }
}
