//! The file of rare events.

use diagnostic::{Problem, Problems, Source};
use schemars::JsonSchema;
use serde::Deserialize;
use std::ops::Range;
use std::path::PathBuf;
use stimulus::{Parameter, Space};
use study::placed::{toml_place, value_place};

/// What is wrong with such a file.
pub const CODE: &str = "bad-rare-event";

/// The whole file.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RareText {
    /// Scenario and parameters, relative to the study; or
    pub scenario: Option<PathBuf>,
    /// The handover's parameter set, with `scenario`.
    pub parameters: Option<PathBuf>,
    /// a scene.
    pub scene: Option<PathBuf>,
    /// An entry of the ledger whose scenario, scene or command is run, in place of files.
    pub evidence: Option<String>,
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
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EventText {
    /// What it is called.
    pub name: String,
    /// What happens, in words.
    pub meaning: String,
    /// A quantity whose greatest value is the score.
    pub greatest: Option<String>,
    /// A proposition; the longest time that it holds is the score, in s.
    pub longest: Option<String>,
    /// A requirement or failure mode; minus its space-time robustness so far is the score, from which 0 on
    /// it is violated.
    pub requirement: Option<String>,
    /// The event is a score of at least this; 0 for a requirement, if absent.
    pub limit: Option<f64>,
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
        let text: Self = study::read_toml(CODE, source)?;
        let mut found = Problems::new();
        for (index, event) in text.events.iter().enumerate() {
            let twice = text.events[..index].iter().any(|e| e.name == event.name);
            let wrong = match twice {
                true => Some(("two events have this name".into(), "rename one of them")),
                false => event.wrong(),
            };
            if let Some((message, remedy)) = wrong {
                let message = format!("event `{}`: {message}", event.name);
                let place = place_of(source, index, event, &message);
                found.add(Problem::new(CODE, message).at(source, place).remedy(remedy));
            }
        }
        found.or(())?;
        if text.events.is_empty() {
            let problem = Problem::new(CODE, "the file has no event");
            return Err(problem.at(source, 0..0).remedy("add an [[event]]"));
        }
        Ok(text)
    }
}

/// Where an event has the key of which a message speaks first; its name where it has none of these.
fn place_of(source: &Source, index: usize, event: &EventText, message: &str) -> Range<usize> {
    let index = index.to_string();
    let place = |key: &str| value_place(source, &["event", &index, key]);
    let element = toml_place(source, &["event", &index]);
    let named = message.split('`').skip(1).step_by(2).map(place);
    let mut named = named.filter(|place| *place != element);
    // The name itself stands in the message, but not as a key.
    let found = named.find(|place| source.text.get(place.clone()) != Some(event.name.as_str()));
    found.unwrap_or_else(|| place("name"))
}

impl EventText {
    /// What is wrong with it, and the remedy.
    fn wrong(&self) -> Option<(String, &'static str)> {
        let says = |text: &str, remedy| Some((text.to_owned(), remedy));
        if !(self.until_secs.is_finite() && self.until_secs > 0.0) {
            return says(
                &format!("`until_secs` must be more than 0 (got {})", self.until_secs),
                "give a positive number of seconds",
            );
        }
        let scores = [&self.greatest, &self.longest, &self.requirement];
        if scores.iter().filter(|score| score.is_some()).count() != 1 {
            return says(
                "it has no score, or several",
                "give one of `greatest = \"a quantity\"`, `longest = \"a proposition\"` and `requirement = \"its id\"`",
            );
        }
        if self.limit.is_none() && self.requirement.is_none() {
            return says(
                "it has no limit",
                "give the score from which on it is the event",
            );
        }
        if self.replications < 2 {
            return says(
                &format!(
                    "`replications` must be at least 2 to estimate the error (got {})",
                    self.replications
                ),
                "take 10 or more",
            );
        }
        if !self.parameters.is_empty() && !self.levels.is_empty() {
            return says(
                "levels are found, not given, where inputs vary",
                "leave out `levels`, or the parameters",
            );
        }
        let (particles, killed) = (self.particles, self.killed());
        if particles < 2 || killed == 0 || killed >= particles {
            return says(
                &format!("{killed} of {particles} runs cannot be killed at a time"),
                "take at least 2 particles, and kill at least 1 and fewer than all",
            );
        }
        if !self.parameters.is_empty() && (killed < 2 || !particles.is_multiple_of(killed)) {
            return says(
                &format!("{killed} chains do not share {particles} particles"),
                "set `killed` to 2 or more, and to a divisor of `particles`",
            );
        }
        let rungs = self.rungs();
        let rising = rungs.windows(2).all(|pair| pair[0] < pair[1]);
        if !rising || rungs.iter().any(|rung| !rung.is_finite()) {
            return says(
                "the levels and the limit do not rise",
                "order `levels` from the most to the least common, all below `limit`",
            );
        }
        let space = Space {
            parameters: self.parameters.clone(),
            constraints: Vec::new(),
        };
        let error = space.check().err()?;
        Some((error.to_string(), "correct the parameter"))
    }

    /// The ladder: the levels and then the limit.
    pub fn rungs(&self) -> Vec<f64> {
        self.levels.iter().copied().chain([self.limit()]).collect()
    }

    /// The score that is the event.
    pub fn limit(&self) -> f64 {
        self.limit.unwrap_or(0.0)
    }

    /// How many are killed at a time: as declared, or a tenth.
    pub fn killed(&self) -> usize {
        self.killed.unwrap_or(self.particles.div_ceil(10))
    }
}
