//! The file of a calibration.

use crate::technique::simulation::SearchPhysics;
use campaign::calibration::Posterior;
use diagnostic::{Problem, Source};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use stimulus::{Parameter, Space};
use study::placed::quoted;
use toml::{Table, Value};

/// What is wrong with such a file.
pub const CODE: &str = "bad-calibration-file";

/// The whole file.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibrationText {
    /// The fitted set's name.
    pub name: String,
    /// The scenario, relative to the study.
    pub scenario: Option<PathBuf>,
    /// The parameters to begin with, relative to the study.
    pub parameters: Option<PathBuf>,
    /// An entry of the ledger whose parameter set, scene or command's stimulus is fitted, in place of `scenario` and
    /// `parameters`.
    pub simulator: Option<String>,
    /// The physics of the episodes that the fit rests on: the fast one where the bench has one, if absent. The fitted set
    /// is checked in the full one.
    pub physics: Option<SearchPhysics>,
    /// The abstract test that episodes enact.
    pub test: String,
    /// The evidence whose counts are to be reproduced.
    pub evidence: String,
    /// Requirements and failure modes that are fitted.
    pub fit: Vec<String>,
    /// Those that are only predicted.
    #[serde(default)]
    pub hold_out: Vec<String>,
    /// Rounds of episodes.
    #[serde(default = "three")]
    pub rounds: u64,
    /// Episodes in a round.
    pub episodes_per_round: u64,
    /// Episodes of the fitted set.
    pub check_episodes: u64,
    /// Points of the posterior's sample.
    #[serde(default = "points")]
    pub points: usize,
    /// Which point of the posterior becomes the fitted set.
    #[serde(default)]
    pub point: Point,
    /// Level of the intervals.
    #[serde(default = "ninety_five")]
    pub confidence: f64,
    /// Whether trials are counted by subject where the evidence's tables do.
    #[serde(default = "yes")]
    pub by_subject: bool,
    /// For a requirement or failure mode, the failure modes after which a trial had no opportunity
    /// for it; without them its counts are not known by subject.
    #[serde(default)]
    pub no_opportunity_after: BTreeMap<String, Vec<String>>,
    /// Runs that are kept out of the fit.
    pub hold_out_runs: Option<HeldOutRuns>,
    /// What is known otherwise and replaces values of the parameters.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, schemars::Schema>")]
    pub known: Table,
    /// What is fitted, with its prior.
    #[serde(rename = "parameter")]
    pub parameters_fitted: Vec<Parameter>,
}

/// Runs that are predicted from the others.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum HeldOutRuns {
    /// Those of these subjects.
    Subjects(Vec<String>),
    /// Those of this share of the subjects, drawn by the study's seed.
    Share(f64),
    /// All, in so many groups of subjects drawn by the study's seed: each group is predicted from
    /// the others, and the fitted set rests on all.
    Folds(usize),
}

/// Which point of the posterior is taken.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Point {
    /// Its mean: the least squared error in the parameters.
    #[default]
    Mean,
    /// Its mode: where what was counted is most probable, given the prior.
    Mode,
}

impl Point {
    /// That point, in the unit cube.
    pub fn of(self, posterior: &Posterior) -> Vec<f64> {
        match self {
            Self::Mean => posterior.mean(),
            Self::Mode => posterior.mode(),
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mean => "posterior mean",
            Self::Mode => "posterior mode",
        }
    }
}

fn yes() -> bool {
    true
}

fn three() -> u64 {
    3
}

fn points() -> usize {
    4000
}

fn ninety_five() -> f64 {
    0.95
}

impl CalibrationText {
    /// Reads and checks the file.
    pub fn read(source: &Source) -> Result<Self, Problem> {
        let text: Self = study::read_toml(CODE, source)?;
        if let Some((word, message, remedy)) = text.wrong() {
            let span = quoted(source, &word);
            return Err(Problem::new(CODE, message).at(source, span).remedy(remedy));
        }
        Ok(text)
    }

    /// What is wrong with it: the word where it is, the message, and the remedy.
    fn wrong(&self) -> Option<(String, String, &'static str)> {
        for parameter in &self.parameters_fitted {
            let alone = Space {
                parameters: vec![parameter.clone()],
                constraints: Vec::new(),
            };
            if let Err(error) = alone.check() {
                return Some((
                    parameter.name.clone(),
                    error.to_string(),
                    "correct the parameter",
                ));
            }
        }
        let says = |word: &str, message: &str, remedy| Some((word.into(), message.into(), remedy));
        let files = (self.scenario.is_some(), self.parameters.is_some());
        if files != (self.simulator.is_none(), self.simulator.is_none()) {
            return says(
                "",
                "the file names neither a scenario with its parameters nor one entry of the ledger",
                "give `scenario` and `parameters`, or `simulator`",
            );
        }
        if let Err(error) = self.space().check() {
            return says(
                "",
                &error.to_string(),
                "give each parameter a name and keys of its own",
            );
        }
        if self.parameters_fitted.is_empty() {
            return says("", "no parameter is fitted", "add a [[parameter]]");
        }
        if self.fit.is_empty() {
            return says(
                "",
                "nothing is fitted",
                "name requirements or failure modes in `fit`",
            );
        }
        if self.episodes_per_round == 0 || self.rounds == 0 || self.check_episodes == 0 {
            return says("", "it has no episodes", "give numbers of at least 1");
        }
        if self.name.trim().is_empty() {
            return says("", "the fitted set has no name", "give a `name`");
        }
        self.wrong_ids()
    }

    fn wrong_ids(&self) -> Option<(String, String, &'static str)> {
        let all: Vec<&String> = self.fit.iter().chain(&self.hold_out).collect();
        let twice = |place: usize| all[..place].contains(&all[place]);
        if let Some(place) = (0..all.len()).find(|place| twice(*place)) {
            let message = format!("`{}` is named twice in `fit` and `hold_out`", all[place]);
            return Some((all[place].clone(), message, "name it once, in one of them"));
        }
        if let Some(id) = self
            .no_opportunity_after
            .keys()
            .find(|id| !all.contains(id))
        {
            let message = format!("`{id}` is neither fitted nor held out");
            return Some((
                id.clone(),
                message,
                "correct the name in [no_opportunity_after]",
            ));
        }
        let problem = match &self.hold_out_runs {
            _ if self.hold_out_runs.is_some() && !self.by_subject => {
                "runs are held out by subject, but `by_subject` is false"
            }
            Some(HeldOutRuns::Share(share)) if !(*share > 0.0 && *share < 1.0) => {
                "the share of runs held out is not between 0 and 1"
            }
            Some(HeldOutRuns::Folds(0 | 1)) => "fewer than two folds leave nothing to fit",
            Some(HeldOutRuns::Subjects(subjects)) if subjects.is_empty() => {
                "no subject is held out"
            }
            _ => return None,
        };
        let remedy = "correct `hold_out_runs`";
        Some(("hold_out_runs".into(), problem.into(), remedy))
    }

    /// What is fitted.
    pub fn space(&self) -> Space {
        Space {
            parameters: self.parameters_fitted.clone(),
            constraints: Vec::new(),
        }
    }
}

/// A table as text.
pub fn written(table: &Table) -> Result<String, Problem> {
    toml::to_string(table).map_err(|error| Problem::new("cannot-write", error.to_string()))
}

/// Replaces values of `into` by those of `known`, table by table; the key that
/// `into` does not have is the error.
pub fn merge(into: &mut Table, known: &Table) -> Result<(), String> {
    for (key, value) in known {
        let Some(old) = into.get_mut(key) else {
            return Err(key.clone());
        };
        match (old, value) {
            // A distribution replaces another whole.
            (Value::Table(old), Value::Table(new)) if !old.keys().any(|k| is_kind(k)) => {
                merge(old, new).map_err(|inner| format!("{key}.{inner}"))?;
            }
            (old, new) => *old = new.clone(),
        }
    }
    Ok(())
}

fn is_kind(key: &str) -> bool {
    matches!(key, "uniform" | "normal")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_replaces_values_and_whole_distributions() {
        let mut base: Table = toml::from_str(
            "a = 1\n[hand]\nfriction = { uniform = [0.1, 0.9] }\nstiffness = 2.0\nmass = 1.0",
        )
        .unwrap();
        let known: Table = toml::from_str(
            "[hand]\nfriction = { normal = [0.5, 0.1] }\nmass = { uniform = [1.0, 2.0] }",
        )
        .unwrap();
        merge(&mut base, &known).unwrap();
        let wanted: Table = toml::from_str(
            "a = 1\n[hand]\nfriction = { normal = [0.5, 0.1] }\nstiffness = 2.0\nmass = { uniform = [1.0, 2.0] }",
        )
        .unwrap();
        assert_eq!(base, wanted);
        let unknown: Table = toml::from_str("hand.frictoin = 1.0").unwrap();
        assert_eq!(merge(&mut base, &unknown).unwrap_err(), "hand.frictoin");
    }
}
