//! `corroborate monitor`: a study's monitors, or a formula, over recordings
//! of any format.

mod asked;
mod form;
mod text;

use super::{Done, Host, json};
use crate::args::{Format, Monitor};
use asked::Asked;
use corroborate::outcome::Outcome;
use diagnostic::Problem;
use evidence::Subject;
use form::{MonitorReport, RecordingVerdicts, Total};
use host::files::write_whole;
use judging::recording::{JudgedRecording, recordings};
use judging::{Judgement, Shown};
use std::path::{Path, PathBuf};
use temporal::monitor::Verdict;

/// Judges recordings.
pub fn monitor(arguments: &Monitor, setting: &Host) -> Result<Done, Problem> {
    let asked = Asked::new(arguments)?;
    let judges = asked.judges()?;
    let rules = asked.rules(arguments)?;
    let files = recordings(asked.recordings)?;
    let names = match &arguments.verdicts {
        Some(folder) => verdict_files(folder, &files)?,
        None => Vec::new(),
    };
    let warnings = asked.warnings();
    warnings.iter().for_each(|line| setting.events.say(line));
    let stage = setting.events.begin("recordings", files.len() as u64);
    let mut report = MonitorReport::new(warnings);
    let mut judged = Vec::new();
    for (place, file) in files.iter().enumerate() {
        setting.go_on()?;
        let name = names.get(place);
        let mut shown = match name {
            Some(_) => Some(Shown::new(&judges, &|subject| asked.text(subject))?),
            None => None,
        };
        let found = rules.judge_and_show(&judges, file, shown.as_mut(), &|| setting.go_on())?;
        refuse_incomplete(arguments, file, &found)?;
        if let (Some(shown), Some(name)) = (shown, name) {
            write_whole(name, &shown.finish(&found.judgements)?)?;
        }
        let mut verdicts = RecordingVerdicts::new(&asked, file, &found);
        verdicts.shown_in = name.map(|name| name.display().to_string());
        report.recordings.push(verdicts);
        judged.push((found.complete, found.judgements));
        stage.advance();
    }
    drop(stage);
    report.totals = totals(&judged);
    let outcome = outcome(&judged);
    let output = match arguments.format {
        Format::Json => json(&report)?,
        Format::Text => text::text(&report),
    };
    Ok(Done { output, outcome })
}

/// Where the verdicts over time go: one file for each recording, none of
/// which may replace another.
fn verdict_files(folder: &Path, files: &[PathBuf]) -> Result<Vec<PathBuf>, Problem> {
    let mut names: Vec<PathBuf> = Vec::new();
    for file in files {
        let stem = file.file_stem().unwrap_or_default().to_string_lossy();
        let number = |number: usize| match number {
            1 => folder.join(format!("{stem}.verdicts.mcap")),
            _ => folder.join(format!("{stem}-{number}.verdicts.mcap")),
        };
        let free = (1..).map(number).find(|name| !names.contains(name));
        names.extend(free);
    }
    match names.iter().find(|name| name.exists()) {
        Some(name) => Err(Problem::new(
            "already-there",
            format!("{} is there already and would be replaced", name.display()),
        )
        .remedy("name a new folder with --verdicts, or remove the file")),
        None => Ok(names),
    }
}

fn refuse_incomplete(
    arguments: &Monitor,
    file: &Path,
    found: &JudgedRecording<'_>,
) -> Result<(), Problem> {
    if found.complete || arguments.partial {
        return Ok(());
    }
    // A trace that was written to its end can say that its run was cut short.
    if found.lost.is_empty() {
        return Ok(());
    }
    let lost = found.lost.join("; ");
    Err(Problem::new(
        "recording-cut-short",
        format!("{} was cut short or damaged: {lost}", file.display()),
    )
    .remedy("record it again, or judge what there is with --partial"))
}

/// What was found in one recording, with whether it is complete.
type Found<'a> = (bool, Vec<Judgement<'a>>);

fn totals(judged: &[Found<'_>]) -> Vec<Total> {
    let Some((_, first)) = judged.first() else {
        return Vec::new();
    };
    (0..first.len())
        .map(|place| {
            let count = |verdict: Verdict| {
                judged
                    .iter()
                    .filter(|(_, j)| j[place].findings.verdict == verdict)
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
/// a violation. In a recording that is not complete, a violation may be due
/// to what is lost.
fn outcome(judged: &[Found<'_>]) -> Outcome {
    let any = |verdict: Verdict, incomplete_too: bool| {
        judged
            .iter()
            .filter(|(complete, _)| *complete || incomplete_too)
            .flat_map(|(_, judgements)| judgements)
            .filter(|j| matches!(j.subject, Subject::Requirement(_)) && j.reading.is_none())
            .any(|j| j.findings.verdict == verdict)
    };
    if any(Verdict::Violated, false) {
        Outcome::Violated
    } else if judged.iter().any(|(complete, _)| !complete) {
        Outcome::DataLost
    } else if any(Verdict::Inconclusive, true) {
        Outcome::Inconclusive
    } else {
        Outcome::Holds
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

    #[test]
    fn recordings_of_one_name_have_verdicts_of_their_own() {
        let folder = tempfile::tempdir().expect("a folder");
        let files = [PathBuf::from("a/run.mcap"), PathBuf::from("b/run.bag")];
        let names = verdict_files(folder.path(), &files).expect("names");
        let names: Vec<_> = names.iter().filter_map(|name| name.file_name()).collect();
        assert_eq!(names, ["run.verdicts.mcap", "run-2.verdicts.mcap"]);
        std::fs::write(folder.path().join(names[1]), "x").expect("written");
        assert!(verdict_files(folder.path(), &files).is_err());
    }
}
