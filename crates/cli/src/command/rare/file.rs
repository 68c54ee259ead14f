//! The file of rare events.

use crate::problem::{Problem, Source};
use serde::Deserialize;
use std::path::PathBuf;
use stimulus::{Parameter, Space};

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RareText {
    /// Scenario and parameters, relative to the study.
    pub scenario: PathBuf,
    pub parameters: PathBuf,
    /// The abstract test that episodes enact.
    pub test: String,
    /// Level of the intervals.
    #[serde(default = "ninety_five")]
    pub confidence: f64,
    /// What is to be estimated.
    #[serde(rename = "event")]
    pub events: Vec<EventText>,
}

/// One event.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EventText {
    pub name: String,
    pub meaning: String,
    /// A quantity whose greatest value is the score.
    pub greatest: Option<String>,
    /// A proposition; the longest time that it holds is the score, in s.
    pub longest: Option<String>,
    /// The event is a score of at least this.
    pub limit: f64,
    /// Scores on the way to it, rising (for splitting only).
    #[serde(default)]
    pub levels: Vec<f64>,
    /// An episode is looked at until this time.
    pub until_secs: f64,
    /// Runs (or inputs) at a time.
    #[serde(default = "two_hundred")]
    pub particles: usize,
    /// Runs killed at a time, or chains of inputs.
    pub killed: Option<usize>,
    /// Independent replications.
    #[serde(default = "ten")]
    pub replications: u64,
    /// Plain episodes to be counted for comparison.
    #[serde(default)]
    pub plain: u64,
    /// Inputs that vary; with them the event is sought among inputs instead of
    /// among continuations of saved runs.
    #[serde(default, rename = "parameter")]
    pub parameters: Vec<Parameter>,
}

fn ninety_five() -> f64 {
    0.95
}

fn two_hundred() -> usize {
    200
}

fn ten() -> u64 {
    10
}

impl RareText {
    /// Reads and checks the file.
    pub fn read(source: &Source) -> Result<Self, Problem> {
        let text: Self =
            toml::from_str(&source.text).map_err(|error| Problem::from_toml(source, &error))?;
        for (index, event) in text.events.iter().enumerate() {
            event.check(source)?;
            if text.events[..index].iter().any(|e| e.name == event.name) {
                let message = format!("{}: two events are called `{}`", source.name, event.name);
                return Err(Problem::new("bad-rare-event", message).remedy("rename one of them"));
            }
        }
        Ok(text)
    }
}

impl EventText {
    fn check(&self, source: &Source) -> Result<(), Problem> {
        let problem = |text: &str, remedy: &str| {
            let message = format!("{}: `{}`: {text}", source.name, self.name);
            Err(Problem::new("bad-rare-event", message).remedy(remedy))
        };
        if !(self.until_secs.is_finite() && self.until_secs > 0.0) {
            return problem(
                "`until_secs` is no duration",
                "give a positive number of seconds",
            );
        }
        if self.replications < 2 {
            return problem(
                "one replication says nothing of its own error",
                "take 10 or more",
            );
        }
        if !self.parameters.is_empty() && !self.levels.is_empty() {
            return problem(
                "levels are found, not given, where inputs vary",
                "leave out `levels`, or the parameters",
            );
        }
        let space = Space {
            parameters: self.parameters.clone(),
            constraints: Vec::new(),
        };
        match space.check() {
            Ok(()) => self.rungs().map(|_| ()),
            Err(error) => problem(&error.to_string(), "correct the parameter"),
        }
    }

    /// The ladder: the levels and then the limit.
    pub fn rungs(&self) -> Result<Vec<f64>, Problem> {
        let rungs: Vec<f64> = self.levels.iter().copied().chain([self.limit]).collect();
        let rising = rungs.windows(2).all(|pair| pair[0] < pair[1]);
        if rising && rungs.iter().all(|rung| rung.is_finite()) {
            return Ok(rungs);
        }
        let message = format!("{}: the levels and the limit do not rise", self.name);
        Err(Problem::new("bad-rare-event", message)
            .remedy("order `levels` from the most to the least common, all below `limit`"))
    }

    /// How many are killed at a time: as declared, or a tenth.
    pub fn killed(&self) -> usize {
        self.killed.unwrap_or(self.particles.div_ceil(10))
    }
}
