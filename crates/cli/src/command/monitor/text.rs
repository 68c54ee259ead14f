//! Verdicts as text for people.

use evidence::RunVerdict;
use judging::monitor::{
    DECIDED_BY_NO_NUMBER, MonitorReport, RecordingVerdicts, Robustness, ShownResponsible,
    ShownSignal, SubjectVerdict,
};
use std::fmt::Write;

/// The most propositions that are named for one violation.
const NAMED: usize = 12;

/// The report, violations first.
pub fn text(report: &MonitorReport) -> String {
    let mut output = String::new();
    for recording in &report.recordings {
        of_recording(&mut output, recording);
    }
    totals(&mut output, report);
    output.trim_start().to_owned()
}

fn of_recording(output: &mut String, recording: &RecordingVerdicts) {
    let file = &recording.file;
    for verdict in &recording.verdicts {
        let label = label(&verdict.subject, verdict.reading.as_deref());
        // Writing to a String cannot fail.
        let _ = match verdict.verdict {
            RunVerdict::Violated => writeln!(output, "{file}: {label} {}", violated(verdict)),
            RunVerdict::Satisfied | RunVerdict::NotCovered | RunVerdict::Inconclusive => {
                match robustness(verdict) {
                    Some(robustness) => {
                        writeln!(output, "{file}: {label} {}, {robustness}", verdict.verdict)
                    }
                    None => Ok(()),
                }
            }
        };
        for part in responsible(verdict) {
            let _ = writeln!(output, "    {part}");
        }
        if let Some(asked) = &verdict.ends_before {
            let _ = writeln!(
                output,
                "{file}: {label} is inconclusive: it asks for {asked}{}, and the recording ends before",
                match verdict.covered {
                    0 => "",
                    _ => " from its first trigger on",
                }
            );
        }
        if let Some(asked) = &verdict.left_out {
            let _ = writeln!(
                output,
                "{file}: {label}: what began in the last {asked} and is still pending at the end is left out"
            );
        }
        if let Some(from) = verdict.judged_from_secs {
            let _ = writeln!(
                output,
                "{file}: {label} is judged from {from} s on, when all signals that it reads had a value"
            );
        }
    }
    if let Some(lost) = &recording.lost {
        let _ = writeln!(output, "{file}: lost: {lost}");
    }
    if !recording.complete {
        let _ = writeln!(
            output,
            "{file}: not complete, so what is missing may have changed a verdict"
        );
    }
    for note in &recording.notes {
        let _ = writeln!(output, "{file}: note: {note}");
    }
    if let Some(shown) = &recording.shown_in {
        let _ = writeln!(output, "{file}: verdicts over time are in {shown}");
    }
}

fn violated(verdict: &SubjectVerdict) -> String {
    let mut said = "violated".to_owned();
    if let Some(violation) = &verdict.violation {
        let (from, to) = (violation.from_secs, violation.to_secs);
        let _ = write!(said, " at {to:.3} s (from {from:.3} s)");
    } else if let Some(secs) = verdict.decided_at_secs {
        let _ = write!(said, " at {secs:.3} s");
    }
    if let Some(robustness) = robustness(verdict) {
        let _ = write!(said, ", {robustness}");
    }
    said
}

/// The robustness, or why there is none; `None` if there is nothing to say.
fn robustness(verdict: &SubjectVerdict) -> Option<String> {
    match (&verdict.robustness, &verdict.no_robustness) {
        (Some(robustness), _) => Some(format!("robustness {}", shown_robustness(robustness))),
        (None, Some(reason)) if reason != DECIDED_BY_NO_NUMBER => {
            Some(format!("no robustness: {reason}"))
        }
        (None, _) => None,
    }
}

fn responsible(verdict: &SubjectVerdict) -> Vec<String> {
    let Some(violation) = &verdict.violation else {
        return Vec::new();
    };
    let all = &violation.responsible;
    let mut lines: Vec<String> = all.iter().take(NAMED).map(one_responsible).collect();
    if all.len() > NAMED {
        lines.push(format!("and {} more", all.len() - NAMED));
    }
    lines
}

fn one_responsible(part: &ShownResponsible) -> String {
    let (name, value) = (&part.proposition, part.value);
    let mut line = format!("`{name}` is {value}");
    let (from, to) = (part.from_secs, part.to_secs);
    if from < to {
        let _ = write!(line, " from {from:.3} s to {to:.3} s");
    } else {
        let _ = write!(line, " at {to:.3} s");
    }
    if let Some(meaning) = &part.meaning {
        let _ = write!(line, ": {meaning}");
    }
    let signals: Vec<String> = part.signals.iter().map(shown_signal).collect();
    if !signals.is_empty() {
        let _ = write!(line, " ({})", signals.join(", "));
    }
    line
}

fn shown_signal(signal: &ShownSignal) -> String {
    let mut shown = signal.name.clone();
    if !signal.unit.is_empty() && signal.unit != "1" {
        let _ = write!(shown, " [{}]", signal.unit);
    }
    if let Some(frame) = &signal.frame {
        let _ = write!(shown, " in {frame}");
    }
    shown
}

fn shown_robustness(robustness: &Robustness) -> String {
    let shown = shown_bounds(robustness);
    if robustness.exact {
        return shown;
    }
    format!("{shown} (not exact: it was triggered again while under way)")
}

fn shown_bounds(robustness: &Robustness) -> String {
    match (robustness.least, robustness.greatest) {
        (Some(least), Some(greatest)) if least == greatest => format!("{least}"),
        (Some(least), Some(greatest)) => format!("from {least} to {greatest}"),
        (Some(least), None) => format!("at least {least}"),
        (None, Some(greatest)) => format!("at most {greatest}"),
        (None, None) => "unknown".to_owned(),
    }
}

fn totals(output: &mut String, report: &MonitorReport) {
    let _ = writeln!(
        output,
        "\n{:<34} {:>8} {:>8} {:>8} {:>13}",
        "requirement or failure mode", "covered", "passed", "failed", "inconclusive"
    );
    for total in &report.totals {
        let _ = writeln!(
            output,
            "{:<34} {:>8} {:>8} {:>8} {:>13}",
            label(&total.subject, total.reading.as_deref()),
            total.covered,
            total.passed,
            total.failed,
            total.inconclusive
        );
    }
}

fn label(subject: &str, reading: Option<&str>) -> String {
    match reading {
        Some(reading) => format!("{subject} (reading `{reading}`)"),
        None => subject.to_owned(),
    }
}
