//! A decided rate, for people.

use corroborate::decide::{DecideReport, FAILING, OnError, Verdict, percent};
use diagnostic::counted;
use std::fmt::Write;
use std::path::Path;

/// How many failing seeds are shown.
const SHOWN: usize = 5;

/// The report as text.
pub fn of(report: &DecideReport, folder: &Path) -> String {
    let mut text = format!("{}: {}\n", report.requirement, report.verdict.word());
    // Writing to a string cannot fail.
    let _ = writeln!(text, "  success rate  {}", report.rate_in_words());
    let _ = writeln!(text, "  required      {}", required(report));
    let _ = writeln!(text, "  guarantee     {}", report.guarantee);
    if let Some(why) = report.undecided_in_words() {
        let _ = writeln!(text, "  undecided     {why}");
    }
    for line in left_out(report) {
        let _ = writeln!(text, "  trials        {line}");
    }
    failing(report, folder, &mut text);
    text
}

fn required(report: &DecideReport) -> String {
    let at_least = percent(report.at_least);
    let zone = match report.margin > 0.0 {
        false => format!("at least {at_least}, without a margin"),
        true => format!(
            "at least {at_least}; between {} and {} either answer is allowed",
            percent(report.zone.low),
            percent(report.zone.high)
        ),
    };
    match (report.verdict, report.margin > 0.0) {
        (Verdict::Passed, true) if report.shows_at_least => {
            format!("{zone}; the interval shows {at_least} itself")
        }
        _ => zone,
    }
}

/// What is said of trials that are neither passed nor failed.
fn left_out(report: &DecideReport) -> Vec<String> {
    let counts = report.counts;
    let mut lines = Vec::new();
    if counts.errors > 0 {
        let counts_for = match report.on_error {
            OnError::Unknown => "count against either answer",
            OnError::Failure => "count as failures",
        };
        let errors = counted(counts.errors, "trial");
        lines.push(format!("{errors} in which the harness broke {counts_for}"));
    }
    if counts.not_applicable > 0 {
        let left = counted(counts.not_applicable, "trial");
        lines.push(format!("{left} not applicable, left out"));
    }
    lines
}

fn failing(report: &DecideReport, folder: &Path, text: &mut String) {
    if report.failing.is_empty() {
        return;
    }
    let file = folder.join(FAILING);
    let count = report.failing.len();
    let _ = writeln!(text, "  failing       {count}, all in {}", file.display());
    for it in report.failing.iter().take(SHOWN) {
        let command = it.command.as_deref().unwrap_or_default();
        let _ = writeln!(text, "    seed {:<10} {}: {command}", it.seed, it.why);
    }
}
