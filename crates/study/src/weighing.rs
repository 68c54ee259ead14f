//! What `study.toml` declares for weighing evidence: costs of trials, and weights.
//!
//! ```toml
//! [costs]            # what one further trial costs; without it every trial counts the same
//! unit = "min"
//! technique = { simulation = 0.2, experiment = 15 }
//! evidence = { rig = 5 }          # pieces that cost something else than their technique
//!
//! [weights]          # how much a piece counts where evidence is combined, 0 to 1; 1 unless declared
//! E4 = 0.5
//! ```

use super::{About, Entry};
use crate::placed::toml_place;
use diagnostic::{Problem, Source};
use evidence::{Technique, TrialCosts, Weights};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// The table `costs`.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CostsText {
    /// The unit of all costs, for example `min` or `EUR`.
    unit: String,
    /// Of one trial by technique.
    #[serde(default)]
    technique: BTreeMap<Technique, f64>,
    /// Of one trial by evidence; comes before the technique's.
    #[serde(default)]
    evidence: BTreeMap<String, f64>,
}

/// What one further trial of each piece of evidence costs.
pub fn trial_costs(
    about: &About,
    ledger: &[Entry],
    source: &Source,
) -> Result<TrialCosts, Problem> {
    let Some(text) = &about.costs else {
        return Ok(TrialCosts::equal());
    };
    for id in text.evidence.keys() {
        known(id, ledger, source, "costs")?;
    }
    let every = text.technique.values().chain(text.evidence.values());
    if let Some(bad) = every.into_iter().find(|c| !(c.is_finite() && **c > 0.0)) {
        return Err(declared(
            source,
            "bad-cost",
            format!("{bad} is no cost of a trial"),
            "costs",
        )
        .remedy("costs are positive numbers, for example `experiment = 15`"));
    }
    let mut costs = TrialCosts::equal();
    costs.unit.clone_from(&text.unit);
    costs.declared = true;
    for entry in ledger {
        let technique = entry.work.technique();
        let of = text.evidence.get(&entry.id);
        match of.or_else(|| text.technique.get(&technique)) {
            Some(cost) => costs = costs.declare(&entry.id, *cost),
            None if technique.is_of_model() => {}
            None => return Err(missing(entry, technique, source)),
        }
    }
    Ok(costs)
}

/// A trial without a cost among trials that have one would be compared in no unit.
fn missing(entry: &Entry, technique: Technique, source: &Source) -> Problem {
    let name = technique.traits().key;
    let message = format!(
        "study.toml declares costs, but none of a trial of `{}` ({})",
        entry.id,
        technique.name()
    );
    declared(source, "missing-cost", message, "costs").remedy(format!(
        "add it, for example `technique.{name} = 1` below [costs], or leave [costs] out"
    ))
}

/// How much each piece of evidence counts where evidence is combined.
pub fn weights(about: &About, ledger: &[Entry], source: &Source) -> Result<Weights, Problem> {
    let mut weights = Weights::default();
    for (id, weight) in &about.weights {
        known(id, ledger, source, "weights")?;
        weights = weights.declare(id, *weight).map_err(|_| {
            let message = format!("{weight} is no weight of `{id}`");
            declared(source, "bad-weight", message, "weights")
                .remedy("a weight lies between 0 (left out) and 1 (counted in full)")
        })?;
    }
    Ok(weights)
}

fn known(id: &str, ledger: &[Entry], source: &Source, table: &str) -> Result<(), Problem> {
    if ledger.iter().any(|entry| entry.id == id) {
        return Ok(());
    }
    let ids: Vec<&str> = ledger.iter().map(|entry| entry.id.as_str()).collect();
    let message = format!("the ledger has no evidence `{id}`");
    Err(
        declared(source, "unknown-evidence", message, table).remedy(match ids.is_empty() {
            true => "the ledger is empty".to_owned(),
            false => format!("it has {}", ids.join(", ")),
        }),
    )
}

/// A problem of a table of `study.toml`, at its name.
fn declared(source: &Source, code: &'static str, message: String, table: &str) -> Problem {
    Problem::new(code, message).at(source, toml_place(source, &[table]))
}
