//! `corroborate shrink`: the smallest scenario that still shows what an episode
//! showed, kept as a regression.

use super::{Done, Host, json};
use crate::args::{Format, Shrink};
use corroborate::Outcome;
use corroborate::shrink::{ShrinkReport, ShrinkRequest};
use diagnostic::Problem;
use std::path::Path;

/// Shrinks.
pub fn shrink(arguments: &Shrink, setting: &Host) -> Result<Done, Problem> {
    let request = ShrinkRequest {
        study: arguments.study.clone(),
        episode: arguments.finding.to_string_lossy().into_owned(),
        only: arguments.only.clone(),
        budget: arguments.budget,
        seeds: arguments.seeds,
        margin: arguments.margin,
        physics: arguments.physics,
        exploration: arguments.exploration.clone(),
        name: arguments.name.clone(),
    };
    let report = corroborate::shrink(&request, setting)?;
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => as_text(&report, &arguments.study),
        },
        outcome: match setting.cancel.is_cancelled() {
            true => Outcome::Interrupted,
            false => Outcome::Holds,
        },
    })
}

fn as_text(report: &ShrinkReport, study: &Path) -> String {
    let mut text = format!("{}\n", report.shows);
    extents(report, &mut text);
    let left = match report.test.actions.is_empty() {
        true => "nothing is done".to_owned(),
        false => report.test.to_string(),
    };
    let causes = report.causes_in_words();
    let clarity = report.clarity_in_words();
    text.push_str(&format!("{clarity}\nwhat is left: {left}\n{causes}\n"));
    text.push_str(match report.is_minimal {
        true => "no single action, value or setting can be left out, nor, in numbers of two digits, come nearer to its nominal value\n",
        false => "the search ended early: perhaps it can be made smaller still\n",
    });
    text + &format!(
        "{}; kept in {}\nNext: corroborate replay {} {}\n",
        report.episodes_in_words(),
        report.file,
        study.display(),
        report.file
    )
}

/// How much there was to the scenario, and how much is left.
fn extents(report: &ShrinkReport, text: &mut String) {
    let (before, after) = (&report.before, &report.after);
    let mut row = |name: &str, before: String, after: String| {
        text.push_str(&format!("{name:<28} {before:>8} -> {after}\n"));
    };
    row(
        "actions",
        before.actions.to_string(),
        after.actions.to_string(),
    );
    row(
        "values set",
        before.values.to_string(),
        after.values.to_string(),
    );
    row(
        "settings not nominal",
        before.settings.to_string(),
        after.settings.to_string(),
    );
    let secs = |value: f64| format!("{value:.2} s");
    row(
        "delays together",
        secs(before.delay_secs),
        secs(after.delay_secs),
    );
    row(
        "simulated time",
        secs(before.simulated_secs),
        secs(after.simulated_secs),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(ShrinkReport).into();
        crate::command::tests::assert_schema_is_committed("shrink.schema.json", &schema);
    }
}
