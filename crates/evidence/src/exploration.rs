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
    /// What was found, what matters first: what happens before the task is over, before what happens only afterwards; of
    /// each, violated requirements, failure modes, programs of the robot that fail, behaviour that the model does not have,
    /// simulators that fail; else in the order in which it was found.
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
    /// In how many of these it came only after the task was over; absent where nothing says when that is.
    #[serde(default)]
    pub after_task: Option<u64>,
    /// What the recordings show at the finding and hardly elsewhere, if anything does beyond chance.
    #[serde(default)]
    pub told_apart: Option<Distinction>,
    /// Why nothing is said of that, where nothing is.
    #[serde(default)]
    pub not_told_apart: Option<String>,
    /// Whether it was shown again when that episode was run again.
    pub replayed: bool,
    /// What brings it about, with `--causes`: the scenarios that are left when its episodes are shrunk.
    pub causes: Vec<CauseFound>,
    /// Episodes that met none of these; absent if none were looked for.
    pub without_cause: Option<u64>,
}

impl Discovery {
    /// Whether it was never seen before the task was over.
    #[must_use]
    pub fn is_after_task(&self) -> bool {
        self.after_task == Some(self.episodes)
    }
}

/// What recorded signals have at the moments of a finding and hardly at others: an association in these episodes, which
/// were chosen, and no cause.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Distinction {
    /// Conditions, all of which held.
    pub terms: Vec<SignalTerm>,
    /// Whether they held just before the finding showed, at the last sample of an earlier time; else when it showed.
    pub just_before: bool,
    /// Episodes that showed the finding in which they held then, and all that did.
    pub shown: [u64; 2],
    /// Other whole episodes in which they held at any time, and all such episodes.
    pub elsewhere: [u64; 2],
    /// That the two shares of episodes differ by chance: Fisher's exact test, two-sided, times the rules of this kind and the number of
    /// kinds (Bonferroni). Absent where the episodes are not told apart, and only moments within them are.
    pub p_value: Option<f64>,
    /// For which share of the episodes that showed the finding the conditions hold, on average over these; absent where moments are not told
    /// apart.
    pub share_of_time: Option<f64>,
    /// That the finding shows while they hold by chance, at a time that is as likely as any other of its episode: times
    /// the conditions that could be added (Bonferroni).
    pub moment_p_value: Option<f64>,
    /// Rules of this kind that could have been found.
    pub rules: u64,
    /// Other rules of this kind with the same counts of episodes.
    pub as_good: Vec<String>,
}

/// A condition on a recorded signal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SignalTerm {
    /// `/topic.field`.
    pub signal: String,
    /// How it is compared.
    pub relation: SignalRelation,
    /// With what.
    pub value: String,
    /// The unit of numbers.
    pub unit: String,
}

/// How a signal is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SignalRelation {
    /// It is this.
    Equals,
    /// It is this or more.
    AtLeast,
    /// It is this or less.
    AtMost,
}

impl fmt::Display for SignalTerm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let relation = match self.relation {
            SignalRelation::Equals => "=",
            SignalRelation::AtLeast => ">=",
            SignalRelation::AtMost => "<=",
        };
        write!(f, "{} {relation} {}", self.signal, self.value)?;
        match self.unit.as_str() {
            "" | "1" => Ok(()),
            unit => write!(f, " {unit}"),
        }
    }
}

impl Distinction {
    /// The rule in words.
    #[must_use]
    pub fn rule_in_words(&self) -> String {
        let terms: Vec<String> = self.terms.iter().map(ToString::to_string).collect();
        terms.join(" and ")
    }

    /// The rule with its counts.
    #[must_use]
    pub fn in_words(&self) -> String {
        let [shown, of_shown] = self.shown;
        let [elsewhere, of_others] = self.elsewhere;
        let always = match (shown == of_shown, elsewhere) {
            (true, 0) => "always and only while",
            (true, _) => "always while",
            (false, 0) => "only while, not always:",
            (false, _) => "mostly while",
        };
        let when = match self.just_before {
            true => "just before it",
            false => "when it shows",
        };
        let p = |p: Option<f64>| match p {
            None => String::new(),
            Some(p) if p < 0.001 => ", p < 0.001".to_owned(),
            Some(p) => format!(", p = {p:.3}"),
        };
        let time = self.share_of_time.map_or(String::new(), |share| {
            let p = p(self.moment_p_value);
            format!(
                "; for {:.1} % of the time of those that showed it{p}",
                share * 100.0
            )
        });
        let as_good = match self.as_good.split_first() {
            None => String::new(),
            Some((first, [])) => format!("; as good: {first}"),
            Some((first, more)) => format!("; as good: {first} and {} more", more.len()),
        };
        format!(
            "{always} {} ({when} in {shown} of {of_shown} episodes that showed it; at any time in {elsewhere} of {of_others} \
             others{}{time}; corrected for {} rules{as_good})",
            self.rule_in_words(),
            p(self.p_value),
            self.rules
        )
    }
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
            true => "all parameters are at their nominal values".to_owned(),
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
