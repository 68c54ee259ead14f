//! What was found by looking for what nobody has thought of.
//!
//! An exploration chooses its episodes to show something new, so what it holds are witnesses: each can be run again, and
//! none says how often something happens. Where causes were looked for, each finding has the smallest scenarios that
//! still show it.

use crate::{Asset, Subject};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// What an exploration found; `F` is how a finding is told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Exploration<F = Discovery> {
    /// Version of this form.
    pub format: String,
    /// What the numbers are, and what they are not.
    pub statement: String,
    /// What was run: an entry of the ledger.
    pub evidence: String,
    /// The version of the physics engine, and which physics the episodes are of if it is not the full one.
    pub engine: String,
    /// What the full physics showed of it, where the episodes are of a fast one; absent where they are of the full one.
    pub confirmation: Option<Confirmation<F>>,
    /// The ledger's entry whose formal model the episodes were held against.
    pub model: Option<String>,
    /// The file that says how it explored, relative to the study where it is one of the study's.
    pub plan: String,
    /// The seed from which those of the episodes are drawn, as a text: readers round numbers beyond 2^53.
    pub seed: String,
    /// What bench, model and plan rest on.
    pub assets: Vec<Asset>,
    /// Episodes that were run.
    pub episodes: u64,
    /// Simulated time of all episodes.
    pub simulated_secs: f64,
    /// Why it ended.
    pub stopped: Stopped,
    /// What was found, in the order in which it was found.
    pub findings: Vec<F>,
    /// Episodes whose physics gave no numbers, so that nothing is said of the robot in them. That it happens is a
    /// finding of its own (the simulator fails), of which the first can be replayed.
    pub broken: Vec<BrokenEpisode>,
}

/// What the full physics showed of an exploration in a fast one. All findings are shown by it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Confirmation<F = Discovery> {
    /// The version of the physics engine.
    pub engine: String,
    /// What episodes of the fast physics showed, and the full physics in none of those that were run again in it: no
    /// findings.
    pub not_confirmed: Vec<F>,
}

/// Why an exploration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Stopped {
    /// All episodes of the budget were run.
    Budget,
    /// More episodes of this kind have stopped paying.
    NothingNew,
    /// It was interrupted; what was found until then is given.
    Interrupted,
}

/// Something that was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Discovery {
    /// What it is, in words.
    pub in_words: String,
    /// The requirement that is violated or the way to fail, if it is one of these.
    pub subject: Option<Subject>,
    /// The file of the first episode that showed it, relative to the result.
    pub file: String,
    /// The number of that episode, from 1.
    pub first_episode: u64,
    /// That episode's seed, as a text: readers round numbers beyond 2^53.
    pub seed: String,
    /// What led to it.
    pub found_by: String,
    /// How many episodes of the exploration showed it, in the physics that these were run in.
    pub episodes: u64,
    /// Whether it was shown again when that episode was run again.
    pub replayed: bool,
    /// What brings it about, with `--causes`: the scenarios that are left when its episodes are shrunk.
    pub causes: Vec<CauseFound>,
    /// Episodes that met none of these; absent if none were looked for.
    pub without_cause: Option<u64>,
}

/// What brought a finding about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CauseFound {
    /// Causes of different findings with the same actions, and the same settings on the same sides of nominal, have the
    /// same number. From 1, in the order in which they were found.
    pub number: u64,
    /// The settings that are not nominal.
    pub settings: Vec<CauseSetting>,
    /// What is done, as far as it is needed.
    pub test: String,
    /// Of the episodes that showed the finding, those that met this cause: they did this, with each
    /// number at least as far from nominal. Each is counted for one cause. It says how often this exploration came there, not
    /// how often it happens.
    pub episodes: u64,
    /// The episode that was shrunk.
    pub shrunk_episode: u64,
    /// Whether nothing more can be left out of it.
    pub is_minimal: bool,
    /// The scenario, relative to the result; `replay` runs it, `shrink` keeps it as a regression.
    pub file: String,
}

/// A setting that is not nominal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CauseSetting {
    /// Its key.
    pub key: String,
    /// Its value, as text.
    pub value: String,
    /// The nominal value, if there is one.
    pub nominal: Option<String>,
}

impl fmt::Display for CauseSetting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}", self.key, self.value)?;
        match &self.nominal {
            Some(nominal) => write!(f, " (nominal {nominal})"),
            None => Ok(()),
        }
    }
}

impl CauseFound {
    /// The settings in words.
    #[must_use]
    pub fn settings_in_words(&self) -> String {
        let settings: Vec<String> = self.settings.iter().map(ToString::to_string).collect();
        match settings.is_empty() {
            true => "all that is set or drawn once is nominal".to_owned(),
            false => settings.join(", "),
        }
    }

    /// The actions in words.
    #[must_use]
    pub fn test_in_words(&self) -> &str {
        match self.test.is_empty() {
            true => "nothing is done",
            false => &self.test,
        }
    }
}

/// An episode whose physics gave no numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BrokenEpisode {
    /// Its number.
    pub episode: u64,
    /// Its seed, as a text: readers round numbers beyond 2^53.
    pub seed: String,
    /// Why.
    pub reason: String,
}
