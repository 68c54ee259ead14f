//! `corroborate monitor`: a study's monitors over recordings.

use super::{Done, Setting, json};
use crate::args::{Format, Monitor};
use crate::outcome::Outcome;
use crate::problem::Problem;
use crate::study::Study;
use crate::technique::judging::{Judgement, Judges};
use evidence::Subject;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};
use temporal::monitor::Verdict;
use trace::Trace;

/// What `monitor --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct MonitorReport {
    /// Version of this form.
    pub format: String,
    /// One for each recording.
    pub recordings: Vec<RecordingVerdicts>,
    /// One for each monitor, over all recordings.
    pub totals: Vec<Total>,
}

/// The verdicts on one recording.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RecordingVerdicts {
    /// The file.
    pub file: String,
    /// Whether it was recorded to its end.
    pub complete: bool,
    /// What is missing, if it was not.
    pub lost: Option<String>,
    /// One for each monitor.
    pub verdicts: Vec<SubjectVerdict>,
}

/// The verdict of one monitor on one recording.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SubjectVerdict {
    /// The requirement or failure mode.
    pub subject: String,
    /// The reading, if it is not the main one.
    pub reading: Option<String>,
    /// `satisfied`, `violated`, `inconclusive` or `not-covered`. For a failure
    /// mode, `violated` means that it occurred.
    pub verdict: String,
    /// How often the precondition was met.
    pub covered: u64,
    /// How often all postconditions were.
    pub passed: u64,
    /// How often one was not.
    pub failed: u64,
    /// When the first failure shows, in seconds of the recording's clock.
    pub failed_at_secs: Option<f64>,
    /// The proposition that should have held then.
    pub failed_proposition: Option<String>,
    /// What that proposition means.
    pub failed_meaning: Option<String>,
}

/// One monitor over all recordings.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Total {
    /// The requirement or failure mode.
    pub subject: String,
    /// The reading, if it is not the main one.
    pub reading: Option<String>,
    /// Recordings in which its precondition was met and a verdict reached.
    pub covered: u64,
    /// Recordings that passed.
    pub passed: u64,
    /// Recordings that failed.
    pub failed: u64,
    /// Recordings that ended before a verdict.
    pub inconclusive: u64,
}

/// Judges recordings.
pub fn monitor(arguments: &Monitor, setting: &Setting) -> Result<Done, Problem> {
    let study = Study::load(&arguments.study)?;
    for id in &arguments.only {
        if study.forms.by_id(id).is_none() {
            return Err(Problem::new(
                "unknown-subject",
                format!("requirements.toml does not declare `{id}`"),
            )
            .remedy("check the identifier"));
        }
    }
    let wanted = |subject: &Subject| {
        arguments.only.is_empty() || arguments.only.iter().any(|id| id == subject.id())
    };
    let judges = Judges::new(&study, wanted)?;
    let files = recordings(&arguments.recordings)?;
    let stage = setting.talk.begin("recordings", files.len() as u64);
    let mut judged = Vec::new();
    let mut report = MonitorReport {
        format: "1.0".into(),
        recordings: Vec::new(),
        totals: Vec::new(),
    };
    for file in &files {
        setting.go_on()?;
        let (trace, lost) = read(file)?;
        if let (Some(lost), false) = (&lost, arguments.partial) {
            return Err(Problem::new(
                "recording-cut-short",
                format!("{} was cut short: {lost}", file.display()),
            )
            .remedy("record it again, or judge what there is with --partial"));
        }
        let judgements = judges
            .judge(&trace)
            .map_err(|problem| problem.about(&file.display().to_string()))?;
        report.recordings.push(RecordingVerdicts {
            file: file.display().to_string(),
            complete: trace.complete,
            lost,
            verdicts: judgements
                .iter()
                .map(|j| subject_verdict(&study, j))
                .collect(),
        });
        judged.push(judgements);
        stage.advance();
    }
    drop(stage);
    report.totals = totals(&judged);
    let outcome = outcome(&report, &judged);
    let output = match arguments.format {
        Format::Json => json(&report)?,
        Format::Text => text(&report),
    };
    Ok(Done { output, outcome })
}

/// The recordings named, with those of named folders in alphabetical order.
fn recordings(paths: &[PathBuf]) -> Result<Vec<PathBuf>, Problem> {
    let mut files = Vec::new();
    for path in paths {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let entries =
            std::fs::read_dir(path).map_err(|error| Problem::cannot_read(path, &error))?;
        let mut inside: Vec<PathBuf> = entries
            .flatten()
            .map(|entry| entry.path())
            .filter(|p| p.extension().is_some_and(|e| e == "mcap" || e == "csv"))
            .collect();
        if inside.is_empty() {
            return Err(Problem::new(
                "no-recordings",
                format!("{} holds no .mcap or .csv file", path.display()),
            )
            .remedy("name recordings, or a folder of them"));
        }
        inside.sort();
        files.extend(inside);
    }
    Ok(files)
}

/// A recording, with what is lost if it was cut short.
fn read(path: &Path) -> Result<(Trace, Option<String>), Problem> {
    if path.extension().is_some_and(|e| e == "csv") {
        let trace = trace::read_csv_trace(path)
            .map_err(|error| Problem::new("bad-recording", error.to_string()))?;
        return Ok((trace, None));
    }
    let outcome = recording::read_mcap(path)
        .map_err(|error| Problem::new("bad-recording", error.to_string()))?;
    Ok((outcome.trace, outcome.lost))
}

fn subject_verdict(study: &Study, judgement: &Judgement) -> SubjectVerdict {
    let findings = &judgement.findings;
    let violation = findings.violation.as_ref();
    let responsible = violation.and_then(|v| v.responsible.last());
    let meaning = responsible.and_then(|r| study.vocabulary.propositions.get(&r.proposition));
    SubjectVerdict {
        subject: judgement.subject.id().to_owned(),
        reading: judgement.reading.map(str::to_owned),
        verdict: verdict_name(findings.verdict).into(),
        covered: findings.triggered,
        passed: findings.passed,
        failed: findings.failed,
        failed_at_secs: violation.map(|v| v.to_secs),
        failed_proposition: responsible.map(|r| r.proposition.clone()),
        failed_meaning: meaning.map(|p| p.meaning.clone()),
    }
}

fn verdict_name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NotCovered => "not-covered",
        Verdict::Satisfied => "satisfied",
        Verdict::Violated => "violated",
        Verdict::Inconclusive => "inconclusive",
    }
}

fn totals(judged: &[Vec<Judgement>]) -> Vec<Total> {
    let Some(first) = judged.first() else {
        return Vec::new();
    };
    (0..first.len())
        .map(|place| {
            let count = |verdict: Verdict| {
                judged
                    .iter()
                    .filter(|j| j[place].findings.verdict == verdict)
                    .count() as u64
            };
            let (passed, failed) = (count(Verdict::Satisfied), count(Verdict::Violated));
            Total {
                subject: first[place].subject.id().to_owned(),
                reading: first[place].reading.map(str::to_owned),
                covered: passed + failed,
                passed,
                failed,
                inconclusive: count(Verdict::Inconclusive),
            }
        })
        .collect()
}

/// Violated requirements count; a failure mode that occurs is a finding, not
/// a violation.
fn outcome(report: &MonitorReport, judged: &[Vec<Judgement>]) -> Outcome {
    let requirements = || {
        judged
            .iter()
            .flatten()
            .filter(|j| matches!(j.subject, Subject::Requirement(_)) && j.reading.is_none())
    };
    if requirements().any(|j| j.findings.verdict == Verdict::Violated) {
        Outcome::Violated
    } else if report.recordings.iter().any(|r| !r.complete) {
        Outcome::DataLost
    } else if requirements().any(|j| j.findings.verdict == Verdict::Inconclusive) {
        Outcome::Inconclusive
    } else {
        Outcome::Holds
    }
}

fn text(report: &MonitorReport) -> String {
    let mut output = String::new();
    for recording in &report.recordings {
        for verdict in recording
            .verdicts
            .iter()
            .filter(|v| v.verdict == "violated")
        {
            output.push_str(&format!(
                "{}: {} violated at {:.3} s, `{}` is false: {}\n",
                recording.file,
                label(&verdict.subject, verdict.reading.as_deref()),
                verdict.failed_at_secs.unwrap_or(0.0),
                verdict.failed_proposition.as_deref().unwrap_or(""),
                verdict.failed_meaning.as_deref().unwrap_or("")
            ));
        }
        if let Some(lost) = &recording.lost {
            output.push_str(&format!("{}: cut short, {lost}\n", recording.file));
        }
    }
    output.push_str(&format!(
        "\n{:<34} {:>8} {:>8} {:>8} {:>13}\n",
        "requirement or failure mode", "covered", "passed", "failed", "inconclusive"
    ));
    for total in &report.totals {
        output.push_str(&format!(
            "{:<34} {:>8} {:>8} {:>8} {:>13}\n",
            label(&total.subject, total.reading.as_deref()),
            total.covered,
            total.passed,
            total.failed,
            total.inconclusive
        ));
    }
    output.trim_start().to_owned()
}

fn label(subject: &str, reading: Option<&str>) -> String {
    match reading {
        Some(reading) => format!("{subject} (reading `{reading}`)"),
        None => subject.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(MonitorReport).into();
        crate::command::tests::assert_schema_is_committed("monitor.schema.json", &schema);
    }
}
