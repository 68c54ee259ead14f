//! `corroborate engines`: the same episodes in two physics engines, and how
//! far they differ; or whether each engine repeats itself, by hashes.

use super::{Done, Host, json, use_threads};
use crate::args::{Engines, Format};
use corroborate::Ended;
use corroborate::engines::{
    EnginesReport, EnginesRequest, Repeated, SignalKind, SignalReport, VerdictReport,
};
use corroborate::technique::campaign::failures_in_words;
use diagnostic::{Problem, counted};
use std::fmt::Write;

/// Runs the command.
pub fn engines(arguments: &Engines, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let request = EnginesRequest {
        study: arguments.study.clone(),
        evidence: arguments.evidence.clone(),
        episodes: arguments.episodes,
        seed: arguments.seed,
        determinism: arguments.determinism,
        against: arguments.against.clone(),
        tolerances: arguments.tolerance.iter().cloned().collect(),
    };
    let report = corroborate::engines(&request, setting)?;
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => text(&report),
        },
        outcome: report.outcome(),
    })
}

fn text(report: &EnginesReport) -> String {
    let mut out = String::new();
    let (engines, episodes) = (report.engines.join(" and "), report.episodes);
    let _ = writeln!(
        out,
        "{}: {} in {engines}",
        report.evidence,
        counted(episodes, "episode")
    );
    if report.repeated.is_empty() {
        verdicts(&report.verdicts, episodes, &mut out);
    }
    for engine in &report.failures {
        for failures in &engine.failures {
            let _ = writeln!(out, "{}: {}", engine.engine, failures_in_words(failures));
        }
    }
    events(&report.signals, &mut out);
    numbers(&report.signals, &mut out);
    let same = report
        .signals
        .iter()
        .filter(|it| it.is_same() && it.rows > 0);
    let not_compared = report.signals.iter().filter(|it| it.rows == 0);
    if !report.signals.is_empty() {
        let _ = writeln!(
            out,
            "\nThe same: {} of {}",
            same.count(),
            counted(report.signals.len(), "signal")
        );
    }
    for signal in not_compared {
        let _ = writeln!(
            out,
            "{}: compared in no row, since the recordings have it at other times or in units of other quantities",
            signal.signal
        );
    }
    repeated(&report.repeated, &mut out);
    out
}

/// The verdicts, those that differ first.
fn verdicts(verdicts: &[VerdictReport], episodes: u64, out: &mut String) {
    let differ = verdicts.iter().filter(|it| !it.differ.is_empty()).count();
    let _ = match differ {
        0 => writeln!(out, "\nNo verdict differs."),
        _ => writeln!(out, "\nVerdicts differ"),
    };
    for (place, one) in verdicts.iter().enumerate() {
        if place == differ && differ > 0 {
            let _ = writeln!(out, "Verdicts that are the same");
        }
        verdict(one, episodes, out);
    }
}

/// Truth values and names that differ.
fn events(signals: &[SignalReport], out: &mut String) {
    let differ = signals
        .iter()
        .filter(|it| it.kind == SignalKind::Event && !it.is_same());
    for (place, signal) in differ.enumerate() {
        if place == 0 {
            let _ = writeln!(
                out,
                "\n{:<44} {:>12} {:>12}",
                "truth value or name", "rows differ", "at s"
            );
        }
        let share = signal.typical.unwrap_or(0.0) * 100.0;
        let _ = writeln!(
            out,
            "{:<44} {share:>10.3} % {:>12.3}",
            signal.signal, signal.largest_at_secs
        );
    }
}

/// Numbers that differ, those that lie furthest apart first.
fn numbers(signals: &[SignalReport], out: &mut String) {
    let differ = signals
        .iter()
        .filter(|it| it.kind != SignalKind::Event && !it.is_same());
    for (place, signal) in differ.enumerate() {
        if place == 0 {
            let _ = writeln!(
                out,
                "\n{:<44} {:>14} {:>12} {:>12} {:>9} {:>12} {:>12}",
                "number", "relative", "rms", "largest", "at s", "mean 1", "mean 2"
            );
        }
        let name = match signal.kind {
            SignalKind::Angle => format!("{} ({}, angle)", signal.signal, signal.unit),
            SignalKind::Number | SignalKind::Event => {
                format!("{} ({})", signal.signal, signal.unit)
            }
        };
        let relative = match signal.tolerance {
            Some(_) => format!("{:.2} x tol.", signal.relative()),
            None => format!("{:.3} % range", signal.relative() * 100.0),
        };
        let number = |number: Option<f64>| number.map_or("-".to_owned(), |n| format!("{n:.6}"));
        let _ = writeln!(
            out,
            "{name:<44} {relative:>14} {:>12} {:>12.6} {:>9.3} {:>12} {:>12}",
            number(signal.typical),
            signal.largest,
            signal.largest_at_secs,
            number(signal.means.map(|means| means[0])),
            number(signal.means.map(|means| means[1]))
        );
    }
}

/// What the recordings show of one requirement or failure mode.
fn verdict(verdict: &VerdictReport, episodes: u64, out: &mut String) {
    let reading = match &verdict.reading {
        Some(reading) => format!(" ({reading})"),
        None => String::new(),
    };
    let [first, second] = verdict.violated;
    let _ = writeln!(
        out,
        "{:<24}{reading} violated in {first} and {second}; verdicts differ in {} of {episodes}",
        verdict.subject.id(),
        verdict.differ.len()
    );
    for pair in &verdict.differ {
        let _ = writeln!(
            out,
            "    episode {} (seed {}): {} and {}",
            pair.episode, pair.seed, pair.first, pair.second
        );
    }
}

/// Appends the hashes.
fn repeated(repeated: &[Repeated], out: &mut String) {
    for it in repeated {
        let said = match it.same {
            true if it.continued.is_some() => "the same again and continued".to_owned(),
            true => "the same again".to_owned(),
            false => format!(
                "NOT the same: again {}, continued {}",
                it.again,
                it.continued.as_deref().unwrap_or("not")
            ),
        };
        let _ = writeln!(
            out,
            "{} episode {} (seed {}): {} {said}{}",
            it.engine,
            it.episode,
            it.seed,
            it.hash,
            it.failed.map_or(String::new(), |kind| format!("; {kind}"))
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(EnginesReport).into();
        crate::command::tests::assert_schema_is_committed("engines.schema.json", &schema);
    }
}
