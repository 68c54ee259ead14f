//! `corroborate compare`: the comparisons of a study that has been run.

use super::{Done, json};
use crate::args::{Compare, Format};
use corroborate::{CompareReport, CompareRequest, Ended};
use diagnostic::Problem;
use evidence::Comparison;

/// Prints comparisons.
pub fn compare(arguments: &Compare) -> Result<Done, Problem> {
    let report = corroborate::compare(&CompareRequest {
        study: arguments.study.clone(),
        out: arguments.out.clone(),
        evidence: arguments.evidence.clone(),
    })?;
    Ok(Done {
        outcome: report.outcome(),
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => text(&report),
        },
    })
}

fn text(report: &CompareReport) -> String {
    let mut output = String::new();
    let mut subject = "";
    for comparison in &report.comparisons {
        if comparison.subject.id() != subject {
            subject = comparison.subject.id();
            output.push_str(&format!("\n{}\n", report.heading(subject)));
        }
        output.push_str(&format!(
            "  {:<28} {:<15} {}\n",
            format!("{} and {}", comparison.left, comparison.right),
            outcome_name(comparison),
            comparison.reason
        ));
        if let Some(trigger) = &comparison.trigger {
            output.push_str(&format!("  {:<44} {}\n", "", trigger.reason));
        }
        if let Some(reason) = &comparison.trigger_not_compared {
            let words = "How often it is triggered is not compared:";
            output.push_str(&format!("  {:<44} {words} {reason}\n", ""));
        }
    }
    if output.is_empty() {
        output.push_str("There is nothing to compare.\n");
    }
    output.trim_start().to_owned()
}

fn outcome_name(comparison: &Comparison) -> &'static str {
    match comparison.outcome {
        evidence::Outcome::Corroborates if comparison.independent => "corroborates",
        evidence::Outcome::Corroborates => "fits",
        evidence::Outcome::Conflicts => "conflicts",
        evidence::Outcome::Inconclusive => "inconclusive",
        evidence::Outcome::NotComparable => "not comparable",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(CompareReport).into();
        crate::command::tests::assert_schema_is_committed("compare.schema.json", &schema);
    }
}
