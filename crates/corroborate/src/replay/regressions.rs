//! All regressions run again: which do what is expected of them.
//!
//! A regression is expected to fail (to show what it did) until its fault is fixed, and to pass from then on. To pass is
//! more than not to show it: the requirement has to come up and to be decided. What was cut to show a violation early is
//! run to its own end before it counts as passed.

use super::episode::{Episode, finding_file, hash_of_trace, no_finding};
use crate::technique::exploration::{OpenBench, Said, ShowsJudge, command_of, failed};
use crate::technique::simulation::load_engine;
use diagnostic::Problem;
use host::{Host, Stage};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use study::{BenchFiles, Choice, Expected, Finding, Shows, Study};

/// Regressions to be run again. [`RegressionsRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct RegressionsRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// Files of findings, as they are or relative to the study; all of its folder `regressions` if there are none.
    pub findings: Vec<String>,
    /// Writes into the files of those that pass and were expected to fail that they are expected to pass from now on.
    pub update: bool,
}

impl RegressionsRequest {
    /// All regressions of the study in this folder.
    pub fn new(study: impl Into<PathBuf>) -> Self {
        Self {
            study: study.into(),
            findings: Vec::new(),
            update: false,
        }
    }

    /// With a file among those that are run; others are not, then.
    #[must_use]
    pub fn finding(mut self, file: impl Into<String>) -> Self {
        self.findings.push(file.into());
        self
    }
}

/// What became of all regressions.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RegressionsReport {
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
    /// What is expected of it; absent if it cannot be read.
    pub expected: Option<Expected>,
    /// What it does.
    pub state: RegressionState,
    /// Whether that is what is expected.
    pub as_expected: bool,
    /// Whether its file says from now on that it is expected to pass.
    pub updated: bool,
    /// Why it neither fails nor passes, if it does neither.
    pub undecided: Option<String>,
    /// Whether it still shows it.
    pub shown: bool,
    /// Whether the recording is the same bytes as when it was stored; absent
    /// where that is not known.
    pub same_bytes: Option<bool>,
    /// Why it could not be run.
    pub error: Option<String>,
    /// The same with its place and a remedy, for a face that shows it at length.
    #[serde(skip)]
    #[schemars(skip)]
    pub problem: Option<Problem>,
}

/// What a regression does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RegressionState {
    /// It shows what it did.
    Fails,
    /// It was put to the test, and does not show it.
    Passes,
    /// It does not show it, and it was not put to the test: its requirement never came up, or its episode was cut short.
    Undecided,
    /// It could not be run.
    CannotBeRun,
}

impl RegressionsReport {
    /// Whether every regression does what is expected of it.
    pub fn all_as_expected(&self) -> bool {
        self.regressions.iter().all(|it| it.as_expected)
    }
}

impl RegressionReport {
    /// What became of it, in words.
    pub fn in_words(&self) -> String {
        let known = self.expected.unwrap_or_default();
        match (self.state, known) {
            (RegressionState::CannotBeRun, _) => "cannot be run".into(),
            (RegressionState::Undecided, _) => {
                let reason = self.undecided.as_deref().unwrap_or_default();
                format!("neither fails nor passes: {reason}")
            }
            (RegressionState::Fails, Expected::Fails) => "fails, as expected".into(),
            (RegressionState::Passes, Expected::Passes) => "passes, as expected".into(),
            (RegressionState::Fails, Expected::Passes) => {
                "fails again: it was fixed before, and is expected to pass".into()
            }
            (RegressionState::Passes, Expected::Fails) if self.updated => {
                "passes now, and is expected to from now on".into()
            }
            (RegressionState::Passes, Expected::Fails) => {
                "passes now and is expected to fail: if it is fixed, say so (`expected = \"passes\"` in its file, or --update), so that a later failure is reported"
                    .into()
            }
        }
    }
}

/// Runs regressions of a study again. One that cannot be run is told in its place, and the others are run all the same.
///
/// # Errors
/// What the study's files say wrong; `no-regressions` and `no-finding` if there is nothing to run; `interrupted` if the host
/// was asked to stop; `no-physics-library` if an episode cannot be simulated here.
pub fn check_regressions(
    request: &RegressionsRequest,
    host: &Host,
) -> Result<RegressionsReport, Problem> {
    let study = Study::load_for(&request.study, &host.trust)?;
    let files = files(&study, &request.findings)?;
    let findings: Vec<Result<Finding, Problem>> =
        files.iter().map(|file| Finding::read(file)).collect();
    let is_outside = |finding: &Finding| command_of(&study, &finding.bench).is_some();
    if !findings.iter().flatten().all(is_outside) {
        // What keeps all of them from running is no result of any.
        load_engine(host)?;
    }
    let prepared = Prepared::new(&study, &findings, host);
    let stage = host.events.begin("regressions", files.len() as u64);
    let pairs: Vec<(&PathBuf, &Result<Finding, Problem>)> = files.iter().zip(&findings).collect();
    let regressions: Vec<RegressionReport> = pairs
        .into_par_iter()
        .map(|(file, finding)| prepared.one(file, finding, &stage))
        .collect();
    drop(stage);
    host.go_on()?;
    let mut report = RegressionsReport {
        format: "2.0".into(),
        regressions,
    };
    if request.update {
        update(&mut report, &files)?;
    }
    Ok(report)
}

/// Says in the files of those that pass that they are expected to.
fn update(report: &mut RegressionsReport, files: &[PathBuf]) -> Result<(), Problem> {
    for (one, file) in report.regressions.iter_mut().zip(files) {
        let is_mended = one.state == RegressionState::Passes;
        if is_mended && one.expected == Some(Expected::Fails) {
            Finding::expect(file, Expected::Passes)?;
            (one.updated, one.as_expected) = (true, true);
        }
    }
    Ok(())
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
    files.iter().try_for_each(|it| study.reach.check(it))?;
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
    host: &'a Host,
}

impl<'a> Prepared<'a> {
    fn new(study: &'a Study, findings: &[Result<Finding, Problem>], host: &'a Host) -> Self {
        let (mut benches, mut judges) = (BTreeMap::new(), BTreeMap::new());
        for finding in findings.iter().flatten() {
            let files = &finding.bench;
            benches
                .entry(key(files))
                .or_insert_with(|| OpenBench::of_files(study, files, host));
            let shows = &finding.shows;
            judges
                .entry(shows.clone())
                .or_insert_with(|| ShowsJudge::new(study, shows, &host.cancel));
        }
        Self {
            benches,
            judges,
            host,
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
            expected: finding.as_ref().ok().map(|it| it.expected),
            state: RegressionState::CannotBeRun,
            as_expected: false,
            updated: false,
            undecided: None,
            shown: false,
            same_bytes: None,
            error: None,
            problem: None,
        };
        let ran = finding.as_ref().map_err(Clone::clone);
        match ran.and_then(|it| self.run(it, file)) {
            Ok((said, same_bytes)) => {
                report.shown = said == Said::Shown;
                report.same_bytes = same_bytes.filter(|_| report.shown);
                report.state = match said {
                    Said::Shown => RegressionState::Fails,
                    Said::NotShown => RegressionState::Passes,
                    Said::Undecided(reason) => {
                        report.undecided = Some(reason);
                        RegressionState::Undecided
                    }
                };
                report.as_expected = match (report.state, report.expected) {
                    (RegressionState::Fails, expected) => expected == Some(Expected::Fails),
                    (RegressionState::Passes, expected) => expected == Some(Expected::Passes),
                    (RegressionState::Undecided | RegressionState::CannotBeRun, _) => false,
                };
            }
            Err(problem) => {
                report.error = Some(problem.line());
                report.problem = Some(problem);
            }
        }
        stage.advance();
        report
    }

    /// What it says, and whether the bytes are the same.
    fn run(&self, finding: &Finding, file: &Path) -> Result<(Said, Option<bool>), Problem> {
        self.host.go_on()?;
        let lost = || Problem::new("bad-finding", "it was not prepared");
        let bench = self.benches.get(&key(&finding.bench)).ok_or_else(lost)?;
        let bench = bench.as_ref().map_err(Clone::clone)?;
        let judge = self.judges.get(&finding.shows).ok_or_else(lost)?;
        let judge = judge.as_ref().map_err(Clone::clone)?;
        let mut episode = Episode::of_finding(finding.clone(), file);
        let run = |episode: &Episode| {
            let recorded = episode.run(bench, None, &self.host.cancel);
            recorded.map_err(|error| failed(&error))
        };
        let recorded = run(&episode)?;
        let said = judge.said(&recorded)?;
        if said != Said::Shown && episode.bench.until_secs.take().is_some() {
            // It was cut where it showed the violation; what it does instead may take longer.
            return Ok((judge.said(&run(&episode)?)?, None));
        }
        let same = match &finding.recording {
            Some(known) => Some(known == &hash_of_trace(&recorded.trace)?.0),
            None => None,
        };
        Ok((said, same))
    }
}

/// What tells benches apart.
fn key(files: &BenchFiles) -> String {
    let parts = [&files.scenario, &files.parameters, &files.scene];
    let parts = parts.map(|part| part.as_deref().unwrap_or("-"));
    let engine = files.engine.unwrap_or_default().word();
    format!("{}\n{}\n{engine}", files.evidence, parts.join("\n"))
}
