//! `corroborate replay --check`: which regressions do what is expected of them.

use super::{Done, Host, json, junit};
use crate::args::{Format, Replay};
use crate::shown_problem::rendered;
use corroborate::Ended;
use corroborate::replay::{
    RegressionReport, RegressionState, RegressionsReport, RegressionsRequest, check_regressions,
};
use diagnostic::Problem;
use host::files::write_whole;

/// Runs regressions again.
pub fn check(arguments: &Replay, setting: &Host) -> Result<Done, Problem> {
    let request = RegressionsRequest {
        study: arguments.study.clone(),
        findings: arguments.what.clone(),
        update: arguments.update,
    };
    let mut report = check_regressions(&request, setting)?;
    for regression in &mut report.regressions {
        regression.error = regression.problem.as_ref().map(|it| rendered(it, false));
    }
    if let Some(file) = &arguments.junit {
        write_whole(file, junit::of(&report).as_bytes())?;
    }
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => as_text(&report),
        },
        outcome: report.outcome(),
    })
}

/// What became of a regression, in capitals where it is not what is expected.
fn state(regression: &RegressionReport) -> &'static str {
    match (regression.state, regression.as_expected) {
        (RegressionState::CannotBeRun, _) => "CANNOT BE RUN",
        (RegressionState::Undecided, _) => "NOT DECIDED",
        (RegressionState::Fails, true) => "fails still",
        (RegressionState::Fails, false) => "FAILS AGAIN",
        (RegressionState::Passes, true) if regression.updated => "passes now",
        (RegressionState::Passes, true) => "passes",
        (RegressionState::Passes, false) => "PASSES NOW",
    }
}

fn as_text(report: &RegressionsReport) -> String {
    let mut text = String::new();
    for regression in &report.regressions {
        let shows = regression.shows.as_deref().unwrap_or("");
        let state = state(regression);
        text.push_str(&format!("{state:<16} {}  {shows}", regression.file));
        if regression.same_bytes == Some(false) {
            text.push_str("  (other bytes than when it was stored)");
        }
        text.push('\n');
        let is_told = !regression.as_expected || regression.updated;
        if is_told && regression.error.is_none() {
            text.push_str(&format!("    {}\n", regression.in_words()));
        }
        for line in regression.error.iter().flat_map(|error| error.lines()) {
            text.push_str(&format!("    {line}\n"));
        }
    }
    let expected = report.regressions.iter().filter(|it| it.as_expected);
    let all = report.regressions.len();
    text + &format!(
        "{} of {all} regressions do what is expected of them\n",
        expected.count()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use study::Expected;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(RegressionsReport).into();
        crate::command::tests::assert_schema_is_committed("regressions.schema.json", &schema);
    }

    fn one(expected: Expected, state: RegressionState) -> RegressionReport {
        RegressionReport {
            file: "r/a.toml".into(),
            shows: Some("failure mode <grip>".into()),
            expected: Some(expected),
            state,
            as_expected: matches!(
                (state, expected),
                (RegressionState::Fails, Expected::Fails)
                    | (RegressionState::Passes, Expected::Passes)
            ),
            updated: false,
            undecided: (state == RegressionState::Undecided).then(|| "no trigger".into()),
            shown: state == RegressionState::Fails,
            same_bytes: None,
            error: (state == RegressionState::CannotBeRun).then(|| "error: no\nhelp: yes".into()),
            problem: None,
        }
    }

    fn all() -> RegressionsReport {
        RegressionsReport {
            format: "2.0".into(),
            regressions: vec![
                RegressionReport {
                    same_bytes: Some(false),
                    ..one(Expected::Fails, RegressionState::Fails)
                },
                one(Expected::Passes, RegressionState::Passes),
                one(Expected::Passes, RegressionState::Fails),
                one(Expected::Fails, RegressionState::Passes),
                one(Expected::Passes, RegressionState::Undecided),
                one(Expected::Fails, RegressionState::CannotBeRun),
            ],
        }
    }

    #[test]
    fn the_text_says_what_became_of_each() {
        let text = as_text(&all());
        let begins = |word: &str| text.lines().find(|line| line.starts_with(word));
        let still = begins("fails still").expect("a line");
        assert!(
            still.ends_with("(other bytes than when it was stored)"),
            "{text}"
        );
        assert!(begins("passes   ").is_some(), "{text}");
        assert!(begins("FAILS AGAIN").is_some() && text.contains("it was fixed before"));
        assert!(begins("PASSES NOW").is_some() && text.contains("`expected = \"passes\"`"));
        assert!(begins("NOT DECIDED").is_some() && text.contains("nor passes: no trigger"));
        assert!(begins("CANNOT BE RUN").is_some() && text.contains("\n    help: yes\n"));
        assert!(
            text.ends_with("2 of 6 regressions do what is expected of them\n"),
            "{text}"
        );
    }

    #[test]
    fn junit_has_a_failure_for_each_that_is_not_as_expected() {
        let text = junit::of(&all());
        assert!(
            text.contains("tests=\"6\" failures=\"3\" errors=\"1\""),
            "{text}"
        );
        assert_eq!(text.matches("<testcase ").count(), 6);
        assert_eq!(text.matches("<failure ").count(), 3);
        assert_eq!(text.matches("<error ").count(), 1);
        assert!(
            text.contains("<property name=\"expected\" value=\"passes\"/>"),
            "{text}"
        );
        assert!(text.contains("failure mode &lt;grip&gt;"), "{text}");
        assert!(text.contains("type=\"fails-again\""), "{text}");
        assert!(text.contains("type=\"passes-now\""), "{text}");
    }
}
