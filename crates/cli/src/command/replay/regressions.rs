//! `corroborate replay --check`: which regressions no longer show what they did.

use super::{Done, Host, json};
use crate::args::{Format, Replay};
use crate::shown_problem::rendered;
use corroborate::outcome::Outcome;
use corroborate::replay::{RegressionsReport, RegressionsRequest, check_regressions};
use diagnostic::Problem;

/// Runs regressions again.
pub fn check(arguments: &Replay, setting: &Host) -> Result<Done, Problem> {
    let request = RegressionsRequest {
        study: arguments.study.clone(),
        findings: arguments.what.clone(),
    };
    let mut report = check_regressions(&request, setting)?;
    for regression in &mut report.regressions {
        regression.error = regression.problem.as_ref().map(|it| rendered(it, false));
    }
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => as_text(&report),
        },
        outcome: match report.all_shown() {
            true => Outcome::Holds,
            false => Outcome::Violated,
        },
    })
}

fn as_text(report: &RegressionsReport) -> String {
    let mut text = String::new();
    for regression in &report.regressions {
        let shows = regression.shows.as_deref().unwrap_or("");
        let state = match (regression.shown, &regression.error) {
            (_, Some(_)) => "CANNOT BE RUN",
            (true, None) => "shown",
            (false, None) => "NO LONGER SHOWN",
        };
        text.push_str(&format!("{state:<16} {}  {shows}", regression.file));
        if regression.same_bytes == Some(false) {
            text.push_str("  (other bytes than when it was stored)");
        }
        text.push('\n');
        for line in regression.error.iter().flat_map(|error| error.lines()) {
            text.push_str(&format!("    {line}\n"));
        }
    }
    let shown = report.regressions.iter().filter(|it| it.shown).count();
    let all = report.regressions.len();
    text + &format!("{shown} of {all} regressions still show what they did\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use corroborate::replay::RegressionReport;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(RegressionsReport).into();
        crate::command::tests::assert_schema_is_committed("regressions.schema.json", &schema);
    }

    #[test]
    fn the_text_says_what_became_of_each() {
        let one = |shown: bool, same_bytes: Option<bool>, error: Option<&str>| RegressionReport {
            file: "r/a.toml".into(),
            shows: Some("failure mode grip".into()),
            shown,
            same_bytes,
            error: error.map(str::to_owned),
            problem: None,
        };
        let text = as_text(&RegressionsReport {
            format: "1.0".into(),
            regressions: vec![
                one(true, Some(true), None),
                one(true, Some(false), None),
                one(false, None, None),
                one(false, None, Some("error: no\nhelp: yes")),
            ],
        });
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "shown            r/a.toml  failure mode grip");
        assert!(lines[1].ends_with("(other bytes than when it was stored)"));
        assert!(lines[2].starts_with("NO LONGER SHOWN"));
        assert!(lines[3].starts_with("CANNOT BE RUN") && lines[5] == "    help: yes");
        assert_eq!(lines[6], "2 of 4 regressions still show what they did");
    }
}
