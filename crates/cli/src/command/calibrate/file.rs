//! The file of a calibration.

use crate::problem::{Problem, Source};
use serde::Deserialize;
use std::path::PathBuf;
use stimulus::{Parameter, Space};
use toml::{Table, Value};

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibrationText {
    /// The fitted set's name.
    pub name: String,
    /// The scenario, relative to the study.
    pub scenario: PathBuf,
    /// The parameters to begin with, relative to the study.
    pub parameters: PathBuf,
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
    /// Level of the intervals.
    #[serde(default = "ninety_five")]
    pub confidence: f64,
    /// What is known otherwise and replaces values of the parameters.
    #[serde(default)]
    pub known: Table,
    /// What is fitted, with its prior.
    #[serde(rename = "parameter")]
    pub parameters_fitted: Vec<Parameter>,
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
        let text: Self =
            toml::from_str(&source.text).map_err(|error| Problem::from_toml(source, &error))?;
        let bad = |message: String, remedy: &str| {
            let message = format!("{}: {message}", source.name);
            Err(Problem::new("bad-calibration-file", message).remedy(remedy))
        };
        if let Err(error) = text.space().check() {
            return bad(error.to_string(), "correct the parameter");
        }
        if text.parameters_fitted.is_empty() {
            return bad("no parameter is fitted".into(), "add a [[parameter]]");
        }
        if text.episodes_per_round == 0 || text.rounds == 0 || text.check_episodes == 0 {
            return bad("it has no episodes".into(), "give numbers of at least 1");
        }
        let stray = text.parameters_fitted.iter().flat_map(|p| &p.sets);
        if let Some(key) = stray.into_iter().find(|k| !k.starts_with("parameters.")) {
            let message = format!("`{key}` is not a value of the parameter set");
            return bad(message, "fit keys that begin with `parameters.`");
        }
        if let Some(both) = text.fit.iter().find(|id| text.hold_out.contains(id)) {
            return bad(format!("`{both}` is fitted and held out"), "choose one");
        }
        Ok(text)
    }

    /// What is fitted.
    pub fn space(&self) -> Space {
        Space {
            parameters: self.parameters_fitted.clone(),
            constraints: Vec::new(),
        }
    }
}

/// Replaces values of `into` by those of `known`, table by table.
pub fn merge(into: &mut Table, known: &Table) {
    for (key, value) in known {
        match (into.get_mut(key), value) {
            // A distribution replaces another whole.
            (Some(Value::Table(old)), Value::Table(new)) if old.keys().any(|k| !is_kind(k)) => {
                merge(old, new);
            }
            _ => {
                into.insert(key.clone(), value.clone());
            }
        }
    }
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
        merge(&mut base, &known);
        let wanted: Table = toml::from_str(
            "a = 1\n[hand]\nfriction = { normal = [0.5, 0.1] }\nstiffness = 2.0\nmass = { uniform = [1.0, 2.0] }",
        )
        .unwrap();
        assert_eq!(base, wanted);
    }
}
