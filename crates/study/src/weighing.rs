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
use crate::placed::{toml_place, value_place};
use diagnostic::{Problem, Problems, Source, did_you_mean};
use evidence::{Technique, TrialCosts, Weights};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;

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
    let mut found = Problems::new();
    for id in text.evidence.keys() {
        let place = toml_place(source, &["costs", "evidence", id]);
        found.keep(known(id, ledger, source, place));
    }
    let of_techniques = text.technique.iter();
    let of_techniques = of_techniques.map(|(of, cost)| ("technique", of.traits().key, *cost));
    let of_evidence = text.evidence.iter();
    let of_evidence = of_evidence.map(|(of, cost)| ("evidence", of.as_str(), *cost));
    for (table, of, cost) in of_techniques.chain(of_evidence) {
        if !(cost.is_finite() && cost > 0.0) {
            found.add(
                Problem::new(
                    "bad-cost",
                    format!("the cost of a trial of `{of}` must be greater than 0 (got {cost})"),
                )
                .at(source, value_place(source, &["costs", table, of]))
                .remedy("write a positive number, for example `experiment = 15`"),
            );
        }
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
            None => found.add(missing(entry, technique, source)),
        }
    }
    found.or(costs)
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
    let mut found = Problems::new();
    for (id, weight) in &about.weights {
        found.keep(known(
            id,
            ledger,
            source,
            toml_place(source, &["weights", id]),
        ));
        match weights.clone().declare(id, *weight) {
            Ok(more) => weights = more,
            Err(_) => found.add(
                Problem::new(
                    "bad-weight",
                    format!("the weight of `{id}` must be between 0 and 1 (got {weight})"),
                )
                .at(source, value_place(source, &["weights", id]))
                .remedy("write 0 to leave it out, 1 to count it in full, or a number between"),
            ),
        }
    }
    found.or(weights)
}

fn known(id: &str, ledger: &[Entry], source: &Source, place: Range<usize>) -> Result<(), Problem> {
    if ledger.iter().any(|entry| entry.id == id) {
        return Ok(());
    }
    let ids: Vec<&str> = ledger.iter().map(|entry| entry.id.as_str()).collect();
    let message = format!("the ledger has no evidence `{id}`");
    let similar = did_you_mean(id, ids.iter().copied());
    let problem = Problem::new("unknown-evidence", message).at(source, place);
    Err(problem.remedy(match (similar, ids.is_empty()) {
        (Some(similar), _) => format!("did you mean `{similar}`?"),
        (None, true) => "the ledger is empty".to_owned(),
        (None, false) => format!("it has {}", ids.join(", ")),
    }))
}

/// A problem of a table of `study.toml`, at its name.
fn declared(source: &Source, code: &'static str, message: String, table: &str) -> Problem {
    Problem::new(code, message).at(source, toml_place(source, &[table]))
}
