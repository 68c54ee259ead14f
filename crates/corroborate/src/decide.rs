//! Whether a test with a seed succeeds often enough: repeated until its rate is decided, not until it passes.
//!
//! The procedure and what it guarantees stand in [`stats::IndifferenceTest`]. Trials are run in parallel and taken in the order of
//! their numbers, so that the counts at which it stops do not depend on how many run at a time, nor on which is done first. Each
//! trial is written to a journal as it ends; the same call goes on behind it. Trials whose harness broke count against
//! either answer, unless they are declared to be failures.

mod journal;
mod protocol;
mod report;
mod rule;
mod seeds;
mod tables;

pub use journal::{JOURNAL, Outcome};
pub use protocol::{Answer, Protocol, ProtocolRequest};
pub use report::{DecideReport, Failing, StoppedBy, Verdict, Zone, percent};
pub use rule::{Counts, DecideRule, OnError};
pub use seeds::seed_of;
pub use tables::{FAILING, TABLE, TRIALS, written_command};

use crate::technique::campaign::in_order;
use diagnostic::Problem;
use host::Host;
use host::store::Store;
use journal::{Journal, Trial};
use rig::{TrialCommand, TrialEnd};
use rule::Course;
use serde::Serialize;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The exit code by which a test says that it was not applicable, unless another one is named: that of Automake and CTest.
pub const NOT_APPLICABLE: i32 = 77;
/// The folder in which what passes while trials run is kept, beside what failing trials said.
const LOGS: &str = "logs";

/// A test to be repeated until its rate is decided. [`DecideRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct DecideRequest {
    /// The requirement that the test verifies, as it is named in the results.
    pub requirement: String,
    /// The program and its arguments; `{seed}` becomes the trial's seed, `{trial}` its number.
    pub command: Vec<String>,
    /// What is asked of the rate, and when to stop.
    pub rule: DecideRule,
    /// The stream that seeds are drawn from.
    pub seed: u64,
    /// How many trials run at a time; results do not depend on it.
    pub jobs: usize,
    /// How long a trial may take in real time.
    pub timeout: Option<Duration>,
    /// The exit code by which a trial says that it was none.
    pub not_applicable: i32,
    /// The folder in which trials run.
    pub folder: PathBuf,
    /// The folder of results.
    pub out: PathBuf,
}

impl DecideRequest {
    /// A command whose rate of success has to be at least this, one trial at a time, with results in `out`.
    pub fn new(command: Vec<String>, at_least: f64, out: impl Into<PathBuf>) -> Self {
        Self {
            requirement: "requirement".to_owned(),
            command,
            rule: DecideRule::new(at_least),
            seed: 1,
            jobs: 1,
            timeout: None,
            not_applicable: NOT_APPLICABLE,
            folder: PathBuf::from("."),
            out: out.into(),
        }
    }

    /// What trials of a journal have in common; others are not counted together.
    fn settings(&self) -> Settings<'_> {
        Settings {
            requirement: &self.requirement,
            command: &self.command,
            rule: self.rule.fixed(),
            seed: self.seed,
            timeout_secs: self.timeout.map(|it| it.as_secs_f64()),
            not_applicable: Some(self.not_applicable),
        }
    }
}

/// What has to be the same for trials to be counted together. Limits of trials and of errors may change: the answers hold at
/// any stopping time.
#[derive(Serialize)]
struct Settings<'a> {
    requirement: &'a str,
    command: &'a [String],
    #[serde(flatten)]
    rule: rule::Fixed,
    seed: u64,
    timeout_secs: Option<f64>,
    not_applicable: Option<i32>,
}

/// Repeats the test until its rate is decided, or a limit is reached. What was run before in the same folder is not run again.
///
/// Writes to `out`: the journal, the failing seeds with the command that runs each again, what failing trials printed, a table of
/// trials, and a table that a study's ledger takes as an experiment.
///
/// # Errors
/// `bad-rule` for a threshold, a margin or a confidence that are none; `no-seed` for a command without `{seed}`;
/// `test-cannot-start`; `other-trials` if `out` has trials of another command or with other settings; `bad-journal`;
/// `results-in-use`; `interrupted` if the host was asked to stop: the trials so far are kept.
pub fn decide(request: &DecideRequest, host: &Host) -> Result<DecideReport, Problem> {
    let test = request.rule.test()?;
    has_seed(&request.command)?;
    let store = Store::open(&request.out)?;
    let journal = Journal::open(store.folder(), &request.settings())?;
    let logs = store.folder().join(LOGS);
    std::fs::create_dir_all(&logs).map_err(|error| Problem::cannot_write(&logs, &error))?;
    let work = Work {
        request,
        command: TrialCommand {
            words: request.command.clone(),
            folder: request.folder.clone(),
            limit: request.timeout,
            not_applicable: request.not_applicable,
        },
        journal,
        logs,
        host,
    };
    let course = work.course(Course::new(request.rule, test))?;
    let report = DecideReport::of(
        &course,
        report::Asked {
            requirement: &request.requirement,
            command: &request.command,
            seed: request.seed,
            folder: store.folder(),
        },
    );
    tables::write(store.folder(), &report, course.trials())?;
    Ok(report)
}

/// A test without a seed would be the same trial again and again, or one that cannot be run again.
fn has_seed(command: &[String]) -> Result<(), Problem> {
    if command.iter().any(|word| word.contains("{seed}")) {
        return Ok(());
    }
    let message = "the command has no `{seed}`, so that its trials would not differ by a seed and could not be run again";
    Err(Problem::new("no-seed", message).remedy(
        "write `{seed}` where the test takes its seed, for example `./test.sh {seed}` or `sh -c 'SEED={seed} ./test.sh'`",
    ))
}

/// Trials under way.
struct Work<'a> {
    request: &'a DecideRequest,
    command: TrialCommand,
    journal: Journal,
    logs: PathBuf,
    host: &'a Host,
}

impl Work<'_> {
    /// Runs and takes trials until the course is over.
    fn course(&self, mut course: Course) -> Result<Course, Problem> {
        let most = self.request.rule.max_trials;
        let title = format!("trials of {}", self.request.requirement);
        let stage = self.host.events.begin(&title, most);
        let run = |(): &mut (), number: u64| self.trial(number);
        let take = |_, trial: Trial| {
            let ended = course.take(trial);
            stage.advance_with(|| course.in_words());
            Ok(match ended {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            })
        };
        let jobs = self.request.jobs.max(1);
        let ran = in_order(1..most + 1, jobs, || (), run, take);
        ran.map_err(|problem| match problem.is_interruption() {
            true => {
                let kept = self.journal.count();
                let doing = format!("repeating the test; {kept} trials are kept");
                Problem::interrupted_while(&doing).resumable()
            }
            false => problem,
        })?;
        drop(stage);
        Ok(course)
    }

    /// One trial: that of the journal, if it is there.
    fn trial(&self, number: u64) -> Result<Trial, Problem> {
        if let Some(known) = self.journal.known(number) {
            return Ok(known);
        }
        self.host.go_on()?;
        let seed = seed_of(self.request.seed, number);
        let said = self.logs.join(log_name(number));
        let end = self.command.run(seed, number, &said, &self.host.cancel)?;
        let (outcome, why) = match end {
            TrialEnd::Passed => (Outcome::Pass, String::new()),
            TrialEnd::Failed(code) => (Outcome::Fail, format!("exit code {code}")),
            TrialEnd::NotApplicable => (Outcome::NotApplicable, String::new()),
            TrialEnd::Error(why) => (Outcome::Error, why),
        };
        // What those that need no look have printed would fill the disk.
        if !outcome.is_failing() {
            let _ = std::fs::remove_file(&said);
        }
        let trial = Trial {
            trial: number,
            seed,
            outcome,
            why,
        };
        self.journal.write(&trial)?;
        Ok(trial)
    }
}

/// The file with what a trial has printed.
fn log_name(trial: u64) -> String {
    format!("trial-{trial:05}.log")
}

/// The file with what a failing trial has printed, if it is kept there.
fn log_of(folder: &Path, trial: u64) -> Option<String> {
    let name = format!("{LOGS}/{}", log_name(trial));
    folder.join(&name).exists().then_some(name)
}
