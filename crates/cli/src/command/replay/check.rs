//! All regressions run again: which no longer show what they did.

use super::episode::{Episode, finding_file, hash_of_trace, no_finding};
use super::{Host, json};
use crate::args::{Format, Replay};
use crate::command::Done;
use crate::shown_problem::rendered;
use corroborate::outcome::Outcome;
use corroborate::technique::exploration::{OpenBench, ShowsJudge, command_of};
use corroborate::technique::simulation::load_engine;
use diagnostic::Problem;
use host::Stage;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use study::{BenchFiles, Finding, Shows, Study};

/// What `replay --check --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CheckReport {
    /// Version of this form.
    pub format: String,
    /// The regressions, by name.
    pub regressions: Vec<RegressionReport>,
}

/// What became of a regression.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RegressionReport {
    /// Its file.
    pub file: String,
    /// What it showed, in words; absent if it cannot be read.
    pub shows: Option<String>,
    /// Whether it still shows it.
    pub shown: bool,
    /// Whether the recording is the same bytes as when it was stored; absent
    /// where that is not known.
    pub same_bytes: Option<bool>,
    /// Why it could not be run.
    pub error: Option<String>,
}

/// Runs regressions again.
pub fn check(study: &Study, arguments: &Replay, setting: &Host) -> Result<Done, Problem> {
    let files = files(study, &arguments.what)?;
    let findings: Vec<Result<Finding, Problem>> =
        files.iter().map(|file| Finding::read(file)).collect();
    let is_outside = |finding: &Finding| command_of(study, &finding.bench).is_some();
    if !findings.iter().flatten().all(is_outside) {
        // What keeps all of them from running is no result of any.
        load_engine(setting.physics_library.as_deref())?;
    }
    let prepared = Prepared::new(study, &findings, setting);
    let stage = setting.events.begin("regressions", files.len() as u64);
    let pairs: Vec<(&PathBuf, &Result<Finding, Problem>)> = files.iter().zip(&findings).collect();
    let regressions: Vec<RegressionReport> = pairs
        .into_par_iter()
        .map(|(file, finding)| prepared.one(file, finding, &stage))
        .collect();
    drop(stage);
    setting.go_on()?;
    let report = CheckReport {
        format: "1.0".into(),
        regressions,
    };
    let all_shown = report.regressions.iter().all(|it| it.shown);
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => as_text(&report),
        },
        outcome: match all_shown {
            true => Outcome::Holds,
            false => Outcome::Violated,
        },
    })
}

/// The named files, or all of the study's regressions.
fn files(study: &Study, named: &[String]) -> Result<Vec<PathBuf>, Problem> {
    if !named.is_empty() {
        let find = |name: &String| {
            let name = Path::new(name);
            finding_file(study, name).ok_or_else(|| no_finding(study, name))
        };
        return named.iter().map(find).collect();
    }
    let folder = study.folder.join("regressions");
    let entries = match std::fs::read_dir(&folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Err(none_there(&folder));
        }
        Err(error) => return Err(Problem::cannot_read(&folder, &error)),
    };
    let paths = entries.flatten().map(|entry| entry.path());
    let mut files: Vec<PathBuf> = paths
        .filter(|path| path.extension().is_some_and(|it| it == "toml"))
        .collect();
    files.sort();
    match files.is_empty() {
        true => Err(none_there(&folder)),
        false => Ok(files),
    }
}

fn none_there(folder: &Path) -> Problem {
    let message = format!("{} holds no regressions", folder.display());
    Problem::new("no-regressions", message)
        .remedy("`corroborate shrink STUDY FINDING` makes one of a finding")
}

/// The benches and judges that findings need, each once.
struct Prepared<'a> {
    benches: BTreeMap<String, Result<OpenBench, Problem>>,
    judges: BTreeMap<Shows, Result<ShowsJudge<'a>, Problem>>,
    setting: &'a Host,
}

impl<'a> Prepared<'a> {
    fn new(study: &'a Study, findings: &[Result<Finding, Problem>], setting: &'a Host) -> Self {
        let library = setting.physics_library.as_deref();
        let (mut benches, mut judges) = (BTreeMap::new(), BTreeMap::new());
        for finding in findings.iter().flatten() {
            let files = &finding.bench;
            benches
                .entry(key(files))
                .or_insert_with(|| OpenBench::of_files(study, files, library));
            let shows = &finding.shows;
            judges
                .entry(shows.clone())
                .or_insert_with(|| ShowsJudge::new(study, shows, &setting.cancel));
        }
        Self {
            benches,
            judges,
            setting,
        }
    }

    fn one(
        &self,
        file: &Path,
        finding: &Result<Finding, Problem>,
        stage: &Stage,
    ) -> RegressionReport {
        let mut report = RegressionReport {
            file: file.display().to_string(),
            shows: finding.as_ref().ok().map(|it| it.shows.to_string()),
            shown: false,
            same_bytes: None,
            error: None,
        };
        match finding
            .as_ref()
            .map_err(Clone::clone)
            .and_then(|it| self.run(it, file))
        {
            Ok((shown, same_bytes)) => (report.shown, report.same_bytes) = (shown, same_bytes),
            Err(problem) => report.error = Some(rendered(&problem, false)),
        }
        stage.advance();
        report
    }

    /// Whether it is shown, and whether the bytes are the same.
    fn run(&self, finding: &Finding, file: &Path) -> Result<(bool, Option<bool>), Problem> {
        self.setting.go_on()?;
        let lost = || Problem::new("bad-finding", "it was not prepared");
        let bench = self.benches.get(&key(&finding.bench)).ok_or_else(lost)?;
        let bench = bench.as_ref().map_err(Clone::clone)?;
        let judge = self.judges.get(&finding.shows).ok_or_else(lost)?;
        let judge = judge.as_ref().map_err(Clone::clone)?;
        let episode = Episode::of_finding(finding.clone(), file);
        let recorded = episode
            .run(bench, None, &self.setting.cancel)
            .map_err(|error| super::episode::failed(&error))?;
        let shown = judge.shows(&recorded)?;
        let same = match &finding.recording {
            Some(known) => Some(known == &hash_of_trace(&recorded.trace)?.0),
            None => None,
        };
        Ok((shown, same))
    }
}

/// What tells benches apart.
fn key(files: &BenchFiles) -> String {
    let parts = [&files.scenario, &files.parameters, &files.scene];
    let parts = parts.map(|part| part.as_deref().unwrap_or("-"));
    format!("{}\n{}", files.evidence, parts.join("\n"))
}

fn as_text(report: &CheckReport) -> String {
    let mut text = String::new();
    for regression in &report.regressions {
        let shows = regression.shows.as_deref().unwrap_or("");
        let state = match (regression.shown, &regression.error) {
            (_, Some(_)) => "CANNOT BE RUN",
            (true, None) => "shown",
            (false, None) => "NO LONGER SHOWN",
        };
        text.push_str(&format!("{state:<16} {}  {shows}", regression.file));
        if regression.same_bytes == Some(false) {
            text.push_str("  (other bytes than when it was stored)");
        }
        text.push('\n');
        for line in regression.error.iter().flat_map(|error| error.lines()) {
            text.push_str(&format!("    {line}\n"));
        }
    }
    let shown = report.regressions.iter().filter(|it| it.shown).count();
    let all = report.regressions.len();
    text + &format!("{shown} of {all} regressions still show what they did\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(CheckReport).into();
        crate::command::tests::assert_schema_is_committed("regressions.schema.json", &schema);
    }

    #[test]
    fn the_text_says_what_became_of_each() {
        let one = |shown: bool, same_bytes: Option<bool>, error: Option<&str>| RegressionReport {
            file: "r/a.toml".into(),
            shows: Some("failure mode grip".into()),
            shown,
            same_bytes,
            error: error.map(str::to_owned),
        };
        let text = as_text(&CheckReport {
            format: "1.0".into(),
            regressions: vec![
                one(true, Some(true), None),
                one(true, Some(false), None),
                one(false, None, None),
                one(false, None, Some("error: no\nhelp: yes")),
            ],
        });
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "shown            r/a.toml  failure mode grip");
        assert!(lines[1].ends_with("(other bytes than when it was stored)"));
        assert!(lines[2].starts_with("NO LONGER SHOWN"));
        assert!(lines[3].starts_with("CANNOT BE RUN") && lines[5] == "    help: yes");
        assert_eq!(lines[6], "2 of 4 regressions still show what they did");
    }
}
