//! `corroborate verify`: whether every figure of a result follows from its evidence, and every hash
//! holds.

use super::{Done, Host, json};
use crate::args::{Format, Verify};
use crate::drawing::drawing;
use corroborate::{Ended, VerifyReport, VerifyRequest};
use diagnostic::Problem;

/// Verifies the results of a study.
pub fn verify(arguments: &Verify, setting: &Host) -> Result<Done, Problem> {
    let request = VerifyRequest {
        techniques: corroborate::Techniques::default(),
        results: arguments.results.clone(),
        study: arguments.study.clone(),
        deep: arguments.deep,
    };
    let report = corroborate::verify(&request, setting, Some(&drawing()))?;
    Ok(Done {
        outcome: report.outcome(),
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => text(&report),
        },
    })
}

/// For people.
fn text(report: &VerifyReport) -> String {
    let mut text = String::new();
    for fault in &report.faults {
        let place = match fault.place.as_str() {
            "" => String::new(),
            place => format!(" at {place}"),
        };
        text.push_str(&format!("✗ {}{place}: {}\n", fault.file, fault.fault));
    }
    for checked in &report.checked {
        text.push_str(&format!("{:>8} {}\n", checked.count, checked.what));
    }
    for what in &report.not_checked {
        text.push_str(&format!("  not derived again: {what}\n"));
    }
    text.push_str(&match report.faults.len() {
        0 => "Everything that was checked holds.\n".to_owned(),
        1 => "1 fault.\n".to_owned(),
        faults => format!("{faults} faults.\n"),
    });
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(VerifyReport).into();
        crate::command::tests::assert_schema_is_committed("verify.schema.json", &schema);
    }
}
