//! Arguments of `decide`.

use super::Format;
use clap::Args;
use corroborate::decide::{DecideRule, NOT_APPLICABLE, OnError};
use std::path::PathBuf;
use std::time::Duration;

/// Where results go unless another folder is named.
const FOLDER: &str = "decision";

/// Arguments of `decide`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate decide -- ./run_test.sh {seed}
  corroborate decide --requirement REQ-7 --at-least 0.95 --margin 0.02 -- ./run_test.sh {seed}
  corroborate decide --jobs 4 --timeout 5min --out results/grasp -- launch_test grasp.test.py seed:={seed}
  corroborate decide -- sh -c 'SEED={seed} ctest -R grasp --no-tests=error'
  corroborate decide --on-error failure -- ./gtest_grasp --seed={seed}

The test is run again and again, each time with another seed, until its rate of
success is decided at the confidence: not until it passes. A test whose rate is
below the required one by more than the margin passes with probability of at most one
minus the confidence, one that is above it by more than the margin fails so seldom,
and between these either answer is allowed; both hold however many trials are run,
wherever they stop. A trial passes with exit code 0. The code of
--not-applicable leaves it out; a signal, a timeout, or codes by which shells
report these or a command that they cannot run, are errors of the harness, of which
--on-error says what they count for; every other code is a failure. Of the
command's words {seed} becomes the seed and {trial} the trial's number.

The folder of --out gets decision.json, junit.xml, failing-seeds.sh (each failing
trial with the command that runs it again), logs of failing trials, trials.csv, and
requirements.csv, which an entry of a study's ledger takes as `tables.requirements`.
Interrupted, the same command goes on where it stopped; a finished one with a larger
--max-trials goes on, too. Exits 0 if the rate is shown, 1 if it is missed, 3 if
neither is shown.")]
pub struct Decide {
    /// The requirement that the test verifies, as results name it.
    #[arg(long, short, value_name = "ID", default_value = "requirement")]
    pub requirement: String,
    /// The rate of success that is required.
    #[arg(long, value_name = "RATE", default_value_t = 0.95)]
    pub at_least: f64,
    /// One minus the probability of a wrong answer.
    #[arg(long, value_name = "LEVEL", default_value_t = 0.95)]
    pub confidence: f64,
    /// Rates nearer to the required one than this may get either answer: the larger, the fewer trials.
    #[arg(long, value_name = "RATE", default_value_t = 0.0)]
    pub margin: f64,
    /// How many trials are run at most.
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub max_trials: u64,
    /// How many trials in which the harness breaks are put up with.
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub max_errors: u64,
    /// What trials in which the harness breaks count for.
    #[arg(long, value_name = "AS", value_parser = super::choice::<OnError>(), default_value = "unknown")]
    pub on_error: OnError,
    /// The stream that seeds are drawn from: another number, other seeds.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// How many trials run at a time (results do not depend on it).
    #[arg(long, short, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: u16,
    /// How long a trial may take.
    #[arg(long, value_name = "TIME", value_parser = super::duration)]
    pub timeout: Option<Duration>,
    /// The exit code by which a trial says that it was not applicable.
    #[arg(long, value_name = "CODE", default_value_t = NOT_APPLICABLE, value_parser = clap::value_parser!(i32).range(1..=125))]
    pub not_applicable: i32,
    /// Where results go instead of the folder `decision`; with --protocol nothing is written without it.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Run nothing: be told outcomes by lines on standard input and answer each by a line of JSON, for test runners that
    /// run trials themselves (`corroborate explain decide`).
    #[arg(long)]
    pub protocol: bool,
    /// How the report is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// The test: a program and its arguments, with {seed}.
    #[arg(
        last = true,
        value_name = "COMMAND",
        required_unless_present = "protocol"
    )]
    pub command: Vec<String>,
}

impl Decide {
    /// What is asked of the rate.
    pub fn rule(&self) -> DecideRule {
        DecideRule {
            at_least: self.at_least,
            confidence: self.confidence,
            margin: self.margin,
            max_trials: self.max_trials,
            max_errors: self.max_errors,
            on_error: self.on_error,
        }
    }

    /// The folder of results.
    pub fn folder(&self) -> PathBuf {
        self.out.clone().unwrap_or_else(|| PathBuf::from(FOLDER))
    }
}
