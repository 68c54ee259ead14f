//! A difference in words, with headings of plain text or of Markdown.

use corroborate::DiffReport;
use corroborate::diff::{
    AskedChange, CostChange, EvidenceChange, Fate, RateChange, Renamed, VerdictChange,
};
use diagnostic::counted;
use std::fmt::Write;

/// A heading and its lines.
type Part = (String, Vec<String>);

/// For a terminal.
pub fn plain(report: &DiffReport) -> String {
    let mut text = String::new();
    for (heading, lines) in parts(report) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{heading}");
        for line in lines {
            let _ = writeln!(text, "  {line}");
        }
    }
    text
}

/// For a comment on a change.
pub fn markdown(report: &DiffReport) -> String {
    let title = escaped(&report.title);
    let mut text = format!("## {title}: what changed in the evidence\n");
    for (heading, lines) in parts(report) {
        let _ = writeln!(text, "\n**{}**", escaped(&heading));
        if !lines.is_empty() {
            text.push('\n');
        }
        for line in lines {
            let _ = writeln!(text, "* {}", escaped(&line));
        }
    }
    text
}

/// In the order in which they matter.
fn parts(report: &DiffReport) -> Vec<Part> {
    let renamed = (!report.renamed.is_empty()).then(|| renamed(report));
    let asked = (!report.asked.is_empty()).then(|| asked(report));
    let rest = [rates(report), stale(report), stands(report), costs(report)];
    [verdicts(report)]
        .into_iter()
        .chain(renamed)
        .chain(asked)
        .chain(rest)
        .collect()
}

fn verdicts(report: &DiffReport) -> Part {
    let changed = report.verdicts.iter().filter(|it| it.changed);
    let lines: Vec<String> = changed.map(verdict).collect();
    let all = counted(report.verdicts.len(), "requirement");
    (format!("Verdicts: {} of {all} changed", lines.len()), lines)
}

/// Requirements under another identifier, which is no change of a verdict.
fn renamed(report: &DiffReport) -> Part {
    let line = |it: &Renamed| format!("{}: before {} (the text is the same)", it.after, it.before);
    let lines: Vec<String> = report.renamed.iter().map(line).collect();
    let many = counted(lines.len(), "requirement");
    (format!("Renamed: {many}"), lines)
}

/// What requirements ask for, where that is not the same: what their verdicts answer then differs.
fn asked(report: &DiffReport) -> Part {
    let line =
        |it: &AskedChange| format!("{}: {}, before: {}", it.requirement, it.after, it.before);
    let lines: Vec<String> = report.asked.iter().map(line).collect();
    let many = counted(lines.len(), "requirement");
    (format!("Asked for: {many} changed"), lines)
}

fn verdict(change: &VerdictChange) -> String {
    let word = |verdict: &Option<String>| {
        let none = || "not concluded".to_owned();
        verdict.clone().unwrap_or_else(none)
    };
    let worse = if change.worse { "worse: " } else { "" };
    format!(
        "{worse}{}: {}, before: {}. {}",
        change.requirement,
        word(&change.after),
        word(&change.before),
        change.statement
    )
}

fn rates(report: &DiffReport) -> Part {
    let beyond = report.rates.iter().filter(|it| it.beyond_chance);
    let lines: Vec<String> = beyond.map(rate).collect();
    let heading = format!(
        "Rates: {} of {} compared changed beyond chance (at {} %, corrected for all that are compared)",
        lines.len(),
        report.rates.len(),
        100.0 * report.confidence
    );
    (heading, lines)
}

fn rate(change: &RateChange) -> String {
    // Of computed values nothing is left to chance.
    let by = match change.p > 0.0 {
        true => format!("p = {}, corrected {}", p(change.p), p(change.p_corrected)),
        false => "computed in both".to_owned(),
    };
    let size = match (change.worse, change.beyond_margin) {
        (true, true) => "; worse by more than the margin",
        (true, false) => "; worse, within the margin",
        (false, true) => "; better by more than the margin",
        (false, false) => "; better, within the margin",
    };
    format!(
        "{}, {}: {:.2} %, before {:.2} % ({by}){size}",
        change.evidence,
        change.subject.in_words(),
        100.0 * change.after,
        100.0 * change.before
    )
}

/// A p-value.
fn p(value: f64) -> String {
    match value < 1e-4 {
        true => format!("{value:.1e}"),
        false => format!("{value:.4}"),
    }
}

fn of_fate(report: &DiffReport, fate: Fate) -> impl Iterator<Item = &EvidenceChange> {
    report.evidence.iter().filter(move |it| it.fate == fate)
}

fn stale(report: &DiffReport) -> Part {
    let again = of_fate(report, Fate::ProducedAgain).map(|it| {
        let files = it.files.iter();
        let files: Vec<String> = files
            .map(|it| format!("{} {}", it.path, it.change))
            .collect();
        let why = match files.is_empty() {
            true => "other settings, other counts of its constants, or another build".to_owned(),
            false => files.join(", "),
        };
        format!("{} ({}): {why}", it.id, it.title)
    });
    let mut lines: Vec<String> = again.collect();
    let heading = format!("Made stale and produced again: {}", lines.len());
    for (fate, word) in [(Fate::New, "new"), (Fate::Gone, "gone")] {
        let named = of_fate(report, fate).map(|it| format!("{word}: {} ({})", it.id, it.title));
        lines.extend(named);
    }
    (heading, lines)
}

fn stands(report: &DiffReport) -> Part {
    let stands = of_fate(report, Fate::Stands).map(|it| it.id.clone());
    let stands: Vec<String> = stands.collect();
    let heading = format!("Stands as it was: {}", stands.len());
    let line = (!stands.is_empty()).then(|| stands.join(", "));
    (heading, line.into_iter().collect())
}

fn costs(report: &DiffReport) -> Part {
    let less = report.costs.iter().filter(|it| it.after < it.before);
    let line = |it: &CostChange| {
        let (before, after) = (number(it.before), number(it.after));
        // What reads the same tells nothing.
        let said = || format!("{}: {after} {}, before {before}", it.evidence, it.of);
        (before != after).then(said)
    };
    let lines = report.costs.iter().filter_map(line).collect();
    let heading = format!("Costs: {} of {} are less", less.count(), report.costs.len());
    (heading, lines)
}

/// A count, or a time with three digits behind the point.
fn number(value: f64) -> String {
    match value.fract() == 0.0 {
        true => format!("{value}"),
        false => format!("{value:.3}"),
    }
}

/// Nothing in it is taken for markup.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for character in text.chars() {
        match character {
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '|' | '*' | '_' | '`' | '[' | ']' | '\\' | '#' => {
                escaped.push('\\');
                escaped.push(character);
            }
            other => escaped.push(other),
        }
    }
    escaped
}
