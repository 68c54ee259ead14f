//! `corroborate requirements`: each requirement in all its forms, where they
//! drifted apart, and the recordings on which they do not agree; or ready
//! requirements, as templates.

mod exchange;
mod library;

use super::{Done, Host, json};
use crate::args::{Format, Requirements};
use crate::written;
use corroborate::requirements::{RequirementForms, RequirementsReport};
use corroborate::{Ended, Outcome, RequirementsRequest};
use diagnostic::{Problem, counted};
use judging::forms::drift::Drift;
use std::fmt::Write;

/// Shows requirements and checks their forms against each other, or lists the library.
pub fn requirements(arguments: &Requirements, setting: &Host) -> Result<Done, Problem> {
    if let Some(asked) = &arguments.exchange {
        return exchange::exchange(asked, setting);
    }
    let Some(folder) = &arguments.study else {
        let report = corroborate::requirements::library();
        return Ok(Done {
            output: match arguments.format {
                Format::Json => json(&report)?,
                Format::Text => library::text(&report),
            },
            outcome: Outcome::Holds,
        });
    };
    let request = RequirementsRequest {
        study: folder.clone(),
        recordings: arguments.recordings.clone(),
        map: arguments.map.clone(),
    };
    let report = corroborate::requirements(&request, setting);
    let found = match &report {
        Ok(report) => written::of_drift(&report.drift),
        Err(problem) => written::of_problem(problem),
    };
    written::keep_sarif(arguments.sarif.as_deref(), &found)?;
    let report = report?;
    Ok(Done {
        outcome: report.outcome(),
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => text(&report),
        },
    })
}

fn text(report: &RequirementsReport) -> String {
    let mut out = String::new();
    for requirement in &report.requirements {
        requirement_text(&mut out, requirement);
    }
    drift_text(&mut out, &report.drift);
    for hint in &report.hints {
        let _ = writeln!(
            out,
            "  hint: {}, {}: {}, where the requirement has {}",
            hint.requirement, hint.form, hint.found, hint.declared
        );
    }
    differences_text(&mut out, report);
    out
}

fn requirement_text(out: &mut String, shown: &RequirementForms) {
    let _ = writeln!(out, "{}", shown.id);
    let mut line = |label: &str, text: &str| {
        // Writing to a String cannot fail.
        let _ = writeln!(out, "  {label:<11} {text}");
    };
    line("text", &shown.text);
    for (label, text) in [("rationale", &shown.rationale), ("status", &shown.status)] {
        if !text.is_empty() {
            line(label, text);
        }
    }
    if !shown.parents.is_empty() {
        line("parents", &shown.parents.join(", "));
    }
    if let Some(first) = &shown.same_quantity_as {
        line("forms", &format!("those of {first}"));
        out.push('\n');
        return;
    }
    if let Some(sentence) = &shown.sentence {
        line("sentence", sentence);
    }
    for words in &shown.meaning {
        line("", words);
    }
    if !shown.parameters.is_empty() {
        line("parameters", &shown.parameters.join(", "));
    }
    for (label, form) in [("property", &shown.property), ("monitor", &shown.monitor)] {
        if let Some(form) = form {
            line(label, &format!("{}   ({})", form.text, form.origin));
        }
    }
    if let Some(witness) = &shown.test_witness {
        line("test", &format!("a witness of {witness}"));
    }
    if let Some(falsify) = &shown.test_falsify {
        line("", &format!("to break it: a witness of {falsify}"));
    }
    if let Some(reach) = &shown.test_reach {
        line("", &format!("in simulation: {reach}"));
    }
    if !shown.coverage.is_empty() {
        let names: Vec<&str> = shown.coverage.iter().map(|bin| bin.name.as_str()).collect();
        line("coverage", &names.join(", "));
    }
    for missing in &shown.not_expressible {
        let text = format!("no {}: {}", missing.form, missing.reason);
        line("", &text);
    }
    out.push('\n');
}

fn drift_text(out: &mut String, drift: &[Drift]) {
    if drift.is_empty() {
        out.push_str("No drift: the forms declare what their requirements do.\n");
        return;
    }
    out.push_str("Drift\n");
    for found in drift {
        let _ = writeln!(
            out,
            "  {}, {}: {}: {}, where the requirement has {}\n    {}: {}",
            found.requirement,
            found.form,
            found.kind.words(),
            found.found,
            found.declared,
            found.place,
            found.remedy
        );
    }
}

fn differences_text(out: &mut String, report: &RequirementsReport) {
    for form in &report.not_judged {
        let _ = writeln!(
            out,
            "  {}, {}: cannot judge recordings: {}",
            form.requirement, form.form, form.reason
        );
    }
    if report.recordings.is_empty() {
        out.push_str("Name recordings, and the forms are held against each other on them.\n");
        return;
    }
    let _ = writeln!(
        out,
        "\nDifferences on {}: {}",
        counted(report.recordings.len(), "recording"),
        report.differences.len()
    );
    for found in &report.differences {
        let at = found
            .at_secs
            .map_or(String::new(), |secs| format!(" (at {secs:.3} s)"));
        let _ = writeln!(
            out,
            "  {}, {}: {} {}, {} {}{at}",
            found.requirement,
            found.recording,
            found.reference,
            found.reference_verdict,
            found.form,
            found.verdict
        );
    }
    for note in &report.notes {
        let _ = writeln!(out, "  note: {note}");
    }
    for lost in &report.lost {
        let _ = writeln!(out, "  lost: {lost}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(RequirementsReport).into();
        crate::command::tests::assert_schema_is_committed("requirements.schema.json", &schema);
    }
}
