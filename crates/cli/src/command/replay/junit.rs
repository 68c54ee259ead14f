//! Regressions as JUnit XML, which build servers read.
//!
//! A test case is a regression; a failure is one that does not do what is expected of it, and an error one that cannot be
//! run. What was expected is a property of each. The form is that of Jenkins' `xunit` schema, as far as it goes.

use corroborate::replay::{RegressionReport, RegressionState, RegressionsReport};
use std::fmt::Write;
use std::path::Path;

/// The report as XML.
pub fn of(report: &RegressionsReport) -> String {
    let all = &report.regressions;
    let is_error = |it: &&RegressionReport| it.state == RegressionState::CannotBeRun;
    let errors = all.iter().filter(is_error).count();
    let failures = all
        .iter()
        .filter(|it| !it.as_expected && !is_error(it))
        .count();
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let _ = writeln!(
        text,
        "<testsuites>\n  <testsuite name=\"regressions\" tests=\"{}\" failures=\"{failures}\" errors=\"{errors}\">",
        all.len()
    );
    for regression in all {
        case(regression, &mut text);
    }
    text + "  </testsuite>\n</testsuites>\n"
}

fn case(regression: &RegressionReport, text: &mut String) {
    let file = Path::new(&regression.file);
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let _ = writeln!(
        text,
        "    <testcase classname=\"regressions\" name=\"{}\" file=\"{}\">",
        escaped(&name),
        escaped(&regression.file)
    );
    let expected = regression.expected.map_or("unknown", |it| it.name());
    let properties = [
        ("expected", expected),
        ("shows", regression.shows.as_deref().unwrap_or_default()),
    ];
    text.push_str("      <properties>\n");
    for (name, value) in properties {
        let value = escaped(value);
        let _ = writeln!(
            text,
            "        <property name=\"{name}\" value=\"{value}\"/>"
        );
    }
    text.push_str("      </properties>\n");
    let what = match (regression.state, regression.as_expected) {
        (_, true) => None,
        (RegressionState::CannotBeRun, _) => Some(("error", "cannot-be-run")),
        (RegressionState::Undecided, _) => Some(("failure", "undecided")),
        (RegressionState::Fails, _) => Some(("failure", "fails-again")),
        (RegressionState::Passes, _) => Some(("failure", "passes-now")),
    };
    if let Some((element, kind)) = what {
        let shows = regression.shows.as_deref().unwrap_or_default();
        let details = regression.error.as_deref().unwrap_or(shows);
        let _ = writeln!(
            text,
            "      <{element} type=\"{kind}\" message=\"{}\">{}</{element}>",
            escaped(&regression.in_words()),
            escaped(details)
        );
    }
    text.push_str("    </testcase>\n");
}

/// A text as it stands in XML; what XML does not allow at all becomes a question mark.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\n' | '\t' => escaped.push(character),
            '\u{0}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => escaped.push('?'),
            other => escaped.push(other),
        }
    }
    escaped
}
