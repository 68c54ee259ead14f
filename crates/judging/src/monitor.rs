//! Recordings of any format, judged by a study's monitors or by formulas.
//!
//! The request is plain data ([`MonitorRequest`]), the report serializes by `schemas/monitor.schema.json` ([`MonitorReport`]).

mod asked;
mod report;
mod request;

pub use report::{
    DECIDED_BY_NO_NUMBER, MonitorReport, RecordingVerdicts, Robustness, ShownResponsible,
    ShownSignal, ShownViolation, SubjectVerdict, Total,
};
pub use request::{MonitorRequest, Monitored};

use crate::recording::{JudgedRecording, ReadingRules, recordings};
use crate::{Judgement, Judges, Shown};
use asked::Asked;
use diagnostic::Problem;
use host::Host;
use host::files::write_whole;
use std::path::{Path, PathBuf};
use temporal::monitor::Verdict;

/// Judges recordings. Warnings and progress go to the host's events.
pub fn monitor(request: &MonitorRequest, host: &Host) -> Result<MonitorReport, Problem> {
    let asked = Asked::new(&request.monitored, host)?;
    let work = Work {
        request,
        host,
        asked: &asked,
        judges: asked.judges()?,
        rules: asked.rules(request)?,
    };
    let files = recordings(&request.recordings)?;
    let names = match &request.verdicts {
        Some(folder) => verdict_files(folder, &files)?,
        None => Vec::new(),
    };
    let warnings = asked.warnings();
    warnings.iter().for_each(|line| host.events.say(line));
    let stage = host.events.begin("recordings", files.len() as u64);
    let mut report = MonitorReport::new(warnings);
    let mut judged = Vec::new();
    for (place, file) in files.iter().enumerate() {
        let (verdicts, judgements) = work.judge(file, names.get(place))?;
        report.recordings.push(verdicts);
        judged.push(judgements);
        stage.advance();
    }
    drop(stage);
    report.totals = totals(&judged);
    Ok(report)
}

/// What all recordings are judged with.
struct Work<'a> {
    request: &'a MonitorRequest,
    host: &'a Host,
    asked: &'a Asked<'a>,
    judges: Judges<'a>,
    rules: ReadingRules,
}

impl<'a> Work<'a> {
    /// Judges one recording; what is known at each instant is written to `name`.
    fn judge(
        &self,
        file: &Path,
        name: Option<&PathBuf>,
    ) -> Result<(RecordingVerdicts, Vec<Judgement<'a>>), Problem> {
        let (asked, judges) = (self.asked, &self.judges);
        let go_on = || self.host.go_on();
        go_on()?;
        let mut shown = match name {
            Some(_) => Some(Shown::new(judges, &|subject| asked.text(subject))?),
            None => None,
        };
        let found = (self.rules).judge_and_show(judges, file, shown.as_mut(), &go_on)?;
        self.refuse_incomplete(file, &found)?;
        if let (Some(shown), Some(name)) = (shown, name) {
            write_whole(name, &shown.finish(&found.judgements)?)?;
        }
        let mut verdicts = RecordingVerdicts::new(asked, file, &found);
        verdicts.shown_in = name.map(|name| name.display().to_string());
        Ok((verdicts, found.judgements))
    }

    fn refuse_incomplete(&self, file: &Path, found: &JudgedRecording<'_>) -> Result<(), Problem> {
        if found.complete || self.request.partial {
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
        .remedy(
            "record it again, or judge what there is all the same (--partial on the command line)",
        ))
    }
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
        .remedy("name a new folder for the verdicts (--verdicts on the command line), or remove the file")),
        None => Ok(names),
    }
}

/// How many of the recordings came to each verdict, for each monitor.
fn totals(judged: &[Vec<Judgement<'_>>]) -> Vec<Total> {
    let first = judged.first().map_or(&[][..], Vec::as_slice);
    let total = |(place, monitor): (usize, &Judgement<'_>)| {
        let count = |verdict: Verdict| {
            let verdicts = judged.iter().map(|it| it[place].findings.verdict);
            verdicts.filter(|found| *found == verdict).count() as u64
        };
        let (passed, failed) = (count(Verdict::Satisfied), count(Verdict::Violated));
        Total {
            subject: monitor.subject.id().to_owned(),
            reading: monitor.reading.map(str::to_owned),
            covered: passed + failed,
            passed,
            failed,
            inconclusive: count(Verdict::Inconclusive),
        }
    };
    first.iter().enumerate().map(total).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

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
