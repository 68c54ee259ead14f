//! `corroborate decide`: whether a test succeeds often enough, repeated until that is known.

mod junit;
mod protocol;
mod text;

use super::{Done, Host, json};
use crate::args::{Decide, Format};
use corroborate::Ended;
use corroborate::decide::{DecideReport, DecideRequest};
use diagnostic::Problem;
use host::files::write_whole;
use std::path::{Path, PathBuf};

/// The file of the report in the folder of results.
const REPORT: &str = "decision.json";
/// The file of the test case there.
const JUNIT: &str = "junit.xml";

/// Repeats the test, or answers whoever does.
pub fn decide(arguments: &Decide, setting: &Host) -> Result<Done, Problem> {
    if arguments.protocol {
        return protocol::converse(arguments);
    }
    let request = DecideRequest {
        requirement: arguments.requirement.clone(),
        command: arguments.command.clone(),
        rule: arguments.rule(),
        seed: arguments.seed,
        jobs: usize::from(arguments.jobs),
        timeout: arguments.timeout,
        not_applicable: arguments.not_applicable,
        folder: PathBuf::from("."),
        out: arguments.folder(),
    };
    let report = corroborate::decide(&request, setting)?;
    keep(&report, &request.out)?;
    Ok(Done {
        outcome: report.outcome(),
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => text::of(&report, &request.out),
        },
    })
}

/// Writes the report and its test case beside the tables.
fn keep(report: &DecideReport, folder: &Path) -> Result<(), Problem> {
    write_whole(&folder.join(REPORT), json(report)?.as_bytes())?;
    write_whole(&folder.join(JUNIT), junit::of(report).as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(DecideReport).into();
        crate::command::tests::assert_schema_is_committed("decide.schema.json", &schema);
    }
}
