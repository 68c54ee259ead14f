//! `corroborate doctor`: what is there, what is missing, and what that disables.

use super::{Done, Host, json};
use crate::args::{Doctor, Format};
use corroborate::Ended;
use corroborate::doctor::{DoctorReport, Presence};
use diagnostic::Problem;
use std::fmt::Write;

/// Looks around.
pub fn doctor(arguments: &Doctor, setting: &Host) -> Result<Done, Problem> {
    let report = corroborate::doctor::doctor(setting);
    Ok(Done {
        outcome: report.outcome(),
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => text(&report),
        },
    })
}

fn text(report: &DoctorReport) -> String {
    let mut text = format!(
        "corroborate {} (build {}), {} threads\n",
        report.version,
        report.build.get(..12).unwrap_or(&report.build),
        report.threads
    );
    for it in &report.examined {
        let word = match it.presence {
            Presence::Present => "present",
            Presence::Missing => "MISSING",
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{word}  {}: {}", it.name, it.found);
        if it.presence == Presence::Missing {
            let _ = writeln!(text, "         disables: {}", it.needed_for);
            let _ = writeln!(text, "         help: {}", it.remedy);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(DoctorReport).into();
        crate::command::tests::assert_schema_is_committed("doctor.schema.json", &schema);
    }
}
