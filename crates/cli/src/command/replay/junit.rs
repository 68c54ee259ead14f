//! Regressions as JUnit XML, which build servers read.
//!
//! A test case is a regression; a failure is one that does not do what is expected of it, and an error one that cannot be
//! run. What was expected is a property of each.

use corroborate::replay::{RegressionReport, RegressionState, RegressionsReport};
use report::junit::{Case, End, Said, Suite, xml};
use std::path::Path;

/// The report as XML.
pub fn of(report: &RegressionsReport) -> String {
    xml(&[Suite {
        name: "regressions".to_owned(),
        cases: report.regressions.iter().map(case).collect(),
    }])
}

fn case(regression: &RegressionReport) -> Case {
    let name = Path::new(&regression.file).file_stem().unwrap_or_default();
    let expected = regression.expected.map_or("unknown", |it| it.name());
    let shows = regression.shows.clone().unwrap_or_default();
    Case {
        class: "regressions".to_owned(),
        name: name.to_string_lossy().into_owned(),
        file: Some(regression.file.clone()),
        secs: None,
        properties: vec![
            ("expected".to_owned(), expected.to_owned()),
            ("shows".to_owned(), shows.clone()),
        ],
        end: end(regression, shows),
    }
}

fn end(regression: &RegressionReport, shows: String) -> End {
    let said = |kind: &str| Said {
        kind: kind.to_owned(),
        message: regression.in_words(),
        text: regression.error.clone().unwrap_or(shows),
    };
    match (regression.state, regression.as_expected) {
        (_, true) => End::Passed,
        (RegressionState::CannotBeRun, _) => End::Error(said("cannot-be-run")),
        (RegressionState::Undecided, _) => End::Failed(said("undecided")),
        (RegressionState::Fails, _) => End::Failed(said("fails-again")),
        (RegressionState::Passes, _) => End::Failed(said("passes-now")),
    }
}
