//! Deciding trials that others run: a line in, a line out, so that a test runner of any language holds no statistics of its own.
//!
//! | line | answer, a JSON object in one line |
//! |---|---|
//! | `seed TRIAL` | `{"trial": 3, "seed": 1862}`: the seed of the trial of this number, from 1 |
//! | `TRIAL OUTCOME [WHY]` | `{"verdict": "undecided", "ended": false, "taken": 12}`: how it stands; outcomes are `pass`, `fail`, `error` and `not-applicable` |
//! | `report` | the report, as `decide` prints it |
//!
//! Trials may be told in any order and by several runners, each to a process of its own: they are taken in the order of their
//! numbers, so that all come to the same answer. What is told twice counts once. `taken` is how many trials have been taken; the
//! others wait for those before them.

use super::journal::{Outcome, Trial};
use super::report::{Asked, DecideReport, Verdict};
use super::rule::{Course, DecideRule};
use super::{seeds, tables};
use diagnostic::Problem;
use host::store::Store;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Trials of a test that another program runs.
#[derive(Clone, Debug)]
pub struct ProtocolRequest {
    /// The requirement that the test verifies.
    pub requirement: String,
    /// The command by which a trial is run again, with `{seed}` and `{trial}`; may be empty.
    pub command: Vec<String>,
    /// What is asked of the rate, and when to stop.
    pub rule: DecideRule,
    /// The stream that seeds are drawn from.
    pub seed: u64,
    /// Where the tables are written with each report, if anywhere.
    pub out: Option<PathBuf>,
}

/// A conversation about one test.
#[derive(Debug)]
pub struct Protocol {
    request: ProtocolRequest,
    course: Course,
    told: BTreeMap<u64, Trial>,
    /// The trials that have been taken: those up to this number.
    taken: u64,
}

/// The answer to a line.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Answer {
    /// To `seed TRIAL`.
    Seed {
        /// The trial.
        trial: u64,
        /// Its seed.
        seed: u64,
    },
    /// To the outcome of a trial.
    Standing {
        /// What is decided so far.
        verdict: Verdict,
        /// Whether no further trials are needed: it is decided, or a limit is reached.
        ended: bool,
        /// How many trials have been taken; others that were told wait for those before them.
        taken: u64,
    },
    /// To `report`.
    Report(Box<DecideReport>),
}

impl Protocol {
    /// Before the first trial.
    ///
    /// # Errors
    /// `bad-rule`.
    pub fn new(request: ProtocolRequest) -> Result<Self, Problem> {
        let test = request.rule.test()?;
        Ok(Self {
            course: Course::new(request.rule, test),
            request,
            told: BTreeMap::new(),
            taken: 0,
        })
    }

    /// The answer to a line.
    ///
    /// # Errors
    /// `bad-line`; what writing the tables says.
    pub fn answer(&mut self, line: &str) -> Result<Answer, Problem> {
        let line = line.trim();
        let (first, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        match (first, rest.trim()) {
            ("report", "") => {
                let report = self.report();
                if let Some(out) = &self.request.out {
                    let store = Store::open(out)?;
                    tables::write(store.folder(), &report, self.course.trials())?;
                }
                Ok(Answer::Report(Box::new(report)))
            }
            ("seed", number) => {
                let trial = trial_number(number, line)?;
                let seed = seeds::seed_of(self.request.seed, trial);
                Ok(Answer::Seed { trial, seed })
            }
            (number, outcome) => self.told(trial_number(number, line)?, outcome, line),
        }
    }

    /// What was decided so far.
    #[must_use]
    pub fn report(&self) -> DecideReport {
        let asked = Asked {
            requirement: &self.request.requirement,
            command: &self.request.command,
            seed: self.request.seed,
            folder: self.request.out.as_deref().unwrap_or(Path::new("")),
        };
        DecideReport::of(&self.course, asked)
    }

    fn told(&mut self, trial: u64, text: &str, line: &str) -> Result<Answer, Problem> {
        let (name, why) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let outcome = Outcome::named(name).ok_or_else(|| bad_line(line))?;
        let told = Trial {
            trial,
            seed: seeds::seed_of(self.request.seed, trial),
            outcome,
            why: why.trim().to_owned(),
        };
        let before = self.told.entry(trial).or_insert(told);
        if before.outcome != outcome {
            let message = format!(
                "trial {trial} is told as `{name}` and was `{}` before",
                before.outcome.name()
            );
            return Err(Problem::new("bad-line", message)
                .remedy("number trials so that each is run once; a retry is a trial of its own"));
        }
        while let Some(next) = self.told.get(&(self.taken + 1)) {
            if self.course.ended().is_some() {
                break;
            }
            self.course.take(next.clone());
            self.taken += 1;
        }
        Ok(Answer::Standing {
            verdict: self.course.verdict(),
            ended: self.course.ended().is_some(),
            taken: self.taken,
        })
    }
}

fn trial_number(text: &str, line: &str) -> Result<u64, Problem> {
    let number = text.parse().ok().filter(|it| (1..1 << 31).contains(it));
    number.ok_or_else(|| bad_line(line))
}

fn bad_line(line: &str) -> Problem {
    let message = format!("`{line}` is not a line of the protocol");
    Problem::new("bad-line", message).remedy(
        "write `seed TRIAL`, `TRIAL OUTCOME [WHY]` with pass, fail, error or not-applicable, or `report`; trials are numbered \
         from 1",
    )
}
