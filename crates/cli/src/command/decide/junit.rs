//! A decided rate as JUnit XML: one test case.

use corroborate::decide::{DecideReport, Verdict, percent};
use report::junit::{Case, End, Said, Suite, xml};

/// The report as XML.
pub fn of(report: &DecideReport) -> String {
    xml(&[Suite {
        name: "decide".to_owned(),
        cases: vec![Case {
            class: "decide".to_owned(),
            name: report.requirement.clone(),
            file: None,
            secs: None,
            properties: properties(report),
            end: end(report),
        }],
    }])
}

fn properties(report: &DecideReport) -> Vec<(String, String)> {
    let interval = format!("{} to {}", report.interval.low, report.interval.high);
    let further = report.further_trials.map(|it| it.to_string());
    let properties = [
        ("verifies", Some(report.requirement.clone())),
        ("outcome", Some(report.verdict.word().to_owned())),
        ("rate", report.rate.map(|it| it.to_string())),
        ("interval", Some(interval)),
        ("guarantee", Some(report.guarantee.clone())),
        ("trials", Some(report.trials.to_string())),
        ("passed", Some(report.counts.passed.to_string())),
        ("failed", Some(report.counts.failed.to_string())),
        ("errors", Some(report.counts.errors.to_string())),
        (
            "not-applicable",
            Some(report.counts.not_applicable.to_string()),
        ),
        (
            "required",
            Some(format!("at least {}", percent(report.at_least))),
        ),
        ("margin", Some(report.margin.to_string())),
        ("confidence", Some(report.confidence.to_string())),
        ("further-trials", further),
    ];
    let known = properties.into_iter();
    let known = known.filter_map(|(name, value)| Some((name.to_owned(), value?)));
    known.collect()
}

fn end(report: &DecideReport) -> End {
    let seeds = report.failing.iter().map(|it| {
        let command = it.command.as_deref().unwrap_or_default();
        format!("seed {}: {} {command}", it.seed, it.why)
    });
    match report.verdict {
        Verdict::Passed => End::Passed,
        Verdict::Failed => End::Failed(Said {
            kind: "rate".to_owned(),
            message: report.rate_in_words(),
            text: seeds.collect::<Vec<_>>().join("\n"),
        }),
        Verdict::Undecided => End::Skipped(format!(
            "undecided: {}; {}",
            report.rate_in_words(),
            report.undecided_in_words().unwrap_or_default()
        )),
    }
}
