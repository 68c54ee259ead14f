//! The table of traceability as CSV and as a page, and the tests that name a requirement.

use super::PackDrawing;
use ::pack::{Content, Part, Role};
use diagnostic::Problem;
use evidence::{Direction, Guarantee, Measure, Requirement, StudyResult, TraceRow, trace};
use std::collections::BTreeMap;
use study::{Finding, Shows, Study};

/// The columns of the table.
const COLUMNS: [&str; 22] = [
    "requirement",
    "text",
    "asks",
    "sentence",
    "formula",
    "monitor",
    "verdict",
    "step",
    "needs",
    "evidence",
    "technique",
    "conditions",
    "count",
    "trials",
    "estimate",
    "low",
    "high",
    "guarantee",
    "part",
    "assets",
    "tests",
    "missing",
];

/// The findings that the study keeps as regressions, by their path in it.
pub(super) fn regressions(study: &Study) -> Result<BTreeMap<String, Option<Finding>>, Problem> {
    let folder = study.folder.join("regressions");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        return Ok(BTreeMap::new());
    };
    let mut found = BTreeMap::new();
    for path in entries.flatten().map(|it| it.path()) {
        if path.extension().is_some_and(|it| it == "toml") && path.is_file() {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            // One that cannot be read is in the pack all the same, and names no requirement.
            found.insert(format!("regressions/{name}"), Finding::read(&path).ok());
        }
    }
    Ok(found)
}

/// The tests of each requirement: cases of JUnit XML that verify it, and regressions that show it violated.
pub(super) fn tests(study: &Study) -> Result<BTreeMap<String, Vec<String>>, Problem> {
    let mut tests: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for entry in &study.ledger {
        let tables = entry.work.parts().tables;
        for (requirement, test) in tables.into_iter().flat_map(|it| it.tests) {
            tests
                .entry(requirement.clone())
                .or_default()
                .push(format!("{}: {test}", entry.id));
        }
    }
    for (path, finding) in regressions(study)? {
        if let Some(Shows::Violated(requirement)) = finding.map(|it| it.shows) {
            tests.entry(requirement).or_default().push(path);
        }
    }
    Ok(tests)
}

/// Both forms of the table.
pub(super) fn parts(
    result: &StudyResult,
    tests: &BTreeMap<String, Vec<String>>,
    drawing: &PackDrawing<'_>,
) -> [Part; 2] {
    let rows = trace(result, tests);
    let part = |name: &str, what: &str, text: String| {
        Part::new(name, Role::Traceability, what, Content::text(text))
    };
    [
        part(
            "traceability/traceability.csv",
            "requirements, their forms, evidence, tests and verdicts, for spreadsheets",
            csv(&rows),
        ),
        part(
            "traceability/traceability.html",
            "the same as a page",
            (drawing.traceability)(result, &rows),
        ),
    ]
}

fn csv(rows: &[TraceRow<'_>]) -> String {
    let mut text = COLUMNS.join(",") + "\r\n";
    for row in rows {
        let cells: Vec<String> = cells(row).iter().map(|it| cell(it)).collect();
        text.push_str(&cells.join(","));
        text.push_str("\r\n");
    }
    text
}

fn cells(row: &TraceRow<'_>) -> [String; 22] {
    let requirement = row.requirement;
    let form = |form: &Option<String>| form.clone().unwrap_or_default();
    let piece = row.shown_by.map(|(piece, _)| piece);
    let [count, trials, estimate, low, high, guarantee] = figures(row);
    let assets: Vec<&str> = row.assets().map(|it| it.path.as_str()).collect();
    [
        requirement.id.clone(),
        requirement.text.clone(),
        asks(requirement),
        form(&requirement.sentence),
        form(&requirement.property),
        form(&requirement.monitor),
        row.verdict.words().to_owned(),
        row.step.map_or("", |it| it.words()).to_owned(),
        requirement.needs.words().to_owned(),
        piece.map_or(String::new(), |it| it.id.clone()),
        row.technique()
            .map_or("", |it| it.traits().heading)
            .to_owned(),
        piece.map_or(String::new(), |it| it.conditions.clone()),
        count,
        trials,
        estimate,
        low,
        high,
        guarantee,
        row.part.clone(),
        assets.join("; "),
        row.tests.join("; "),
        missing(row),
    ]
}

/// What the page marks as missing in a row: evidence, a verdict of it, a test.
fn missing(row: &TraceRow<'_>) -> String {
    let no_test = row.tests.is_empty().then_some("no test names it");
    let gap = Some(row.gap.as_str()).filter(|gap| !gap.is_empty());
    let all: Vec<&str> = gap.into_iter().chain(no_test).collect();
    all.join("; ")
}

fn asks(requirement: &Requirement) -> String {
    match requirement.threshold {
        None => "always".into(),
        Some(threshold) => {
            let side = match threshold.direction {
                Direction::AtLeast => "at least",
                Direction::AtMost => "at most",
            };
            format!("{side} {}", threshold.value)
        }
    }
}

/// Count, trials, estimate, limits and the kind of guarantee, as far as there are any.
fn figures(row: &TraceRow<'_>) -> [String; 6] {
    let Some((_, finding)) = row.shown_by else {
        return Default::default();
    };
    let shown = |value: Option<f64>| value.map_or(String::new(), |it| it.to_string());
    let (count, trials, guarantee) = match &finding.measure {
        Measure::Counts { count, trials, .. } => {
            (count.to_string(), trials.to_string(), "statistical")
        }
        // The limits are those of the distribution then.
        Measure::Probability {
            credible: Some(_), ..
        } => (String::new(), String::new(), "credible"),
        Measure::Probability { answer, .. } => (
            String::new(),
            String::new(),
            match &answer.guarantee {
                Guarantee::Exact { .. } => "exact",
                Guarantee::Bounded { .. } => "bounded",
                Guarantee::Schedulers { .. } => "bounded, over all schedulers",
                Guarantee::Statistical { .. } => "statistical",
                Guarantee::Estimated { .. } => "estimated, without a bound",
            },
        ),
        Measure::NotExpressible { .. } => (String::new(), String::new(), "not expressible"),
        Measure::NotCovered { .. } => (String::new(), String::new(), "not covered"),
    };
    let interval = finding.measure.interval();
    [
        count,
        trials,
        shown(finding.measure.estimate()),
        shown(interval.map(|it| it.low)),
        shown(interval.map(|it| it.high)),
        guarantee.to_owned(),
    ]
}

/// A cell (RFC 4180). A spreadsheet would compute what begins like a formula, so that an apostrophe stands before it.
fn cell(text: &str) -> String {
    let guarded = match text.starts_with(['=', '+', '-', '@', '\t', '\r']) {
        true => format!("'{text}"),
        false => text.to_owned(),
    };
    match guarded.contains(['"', ',', '\n', '\r']) {
        true => format!("\"{}\"", guarded.replace('"', "\"\"")),
        false => guarded,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_quoted_and_never_formulas() {
        assert_eq!(cell("plain"), "plain");
        assert_eq!(cell("a, \"b\"\nc"), "\"a, \"\"b\"\"\nc\"");
        assert_eq!(cell("=HYPERLINK(\"x\")"), "\"'=HYPERLINK(\"\"x\"\")\"");
        assert_eq!(cell("-1"), "'-1");
    }
}
