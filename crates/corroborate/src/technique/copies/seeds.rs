//! Episodes of two simulations that were drawn from the same seeds.
//!
//! # Definition
//! The tables of two pieces of evidence by simulation that both have a column `seed` are held against each other. Seeds of
//! variants of one simulator that are equal give the same random numbers to both, so that their episodes are paired: they
//! are correlated, mostly positively, and not two samples.
//!
//! An entry of the ledger that is given another's seeds (`seeds = "S1"`) is *paired* with it, and with all others that have
//! these seeds: that is declared, and no question. If they run the same simulator on the same stimulus, which are the same
//! words of the ledger but for the names of files of the same content, they are the *same runs*.
//!
//! # Assumes
//! The same seed gives both variants the same random numbers in the same order.
//!
//! # Guarantee
//! Equal seeds are no coincidence that has a probability: numbers from 1 on are equal by intention, too. So one is a
//! question. Episodes that are run here have seeds of their own for each entry of the ledger (`simulation::Seeds`), and
//! variants that are compared on the same seeds are so as pairs (`what_if`).

use crate::technique::experiment::repeated::{Told, tables};
use diagnostic::Problem;
use evidence::{Asset, AssetRole, CopyKind, Evidence, LineageQuestion, SharedSeeds};
use serde_json::Value;
use std::collections::BTreeSet;
use study::{Entry, Study};

/// The header of seeds.
const SEED: &str = "seed";

/// The questions of all pairs, each with the place of the later piece.
pub(super) fn questions(
    study: &Study,
    evidence: &[Evidence],
) -> Result<Vec<(usize, LineageQuestion)>, Problem> {
    let told = tables(study)?;
    let place = |of: &Told| {
        evidence
            .iter()
            .position(|it| it.id == of.evidence && it.technique.is_of_simulator())
    };
    let mut found = Vec::new();
    for (number, later) in told.iter().enumerate() {
        for earlier in &told[..number] {
            let (Some(own), Some(_)) = (place(later), place(earlier)) else {
                continue;
            };
            let (ours, theirs) = (seeds(later), seeds(earlier));
            let same = ours.intersection(&theirs).count();
            if same > 0 && later.evidence != earlier.evidence {
                found.push((own, question(later, earlier, (same, ours.len()))));
            }
        }
    }
    Ok(found)
}

/// Keys of the ledger that say how many runs there are and how they are watched, not what happens in them.
const NOT_OF_A_RUN: [&str; 4] = ["technique", "episodes", "limit_secs", "persistent"];

/// Fills in which earlier simulations each piece shares its seeds with by the ledger. Gives the pairs that the ledger calls
/// independent of each other, as settled questions.
pub(super) fn fill(study: &Study, evidence: &mut [Evidence]) -> Vec<(usize, LineageQuestion)> {
    let entries: Vec<&Entry> = study
        .ledger
        .iter()
        .filter(|entry| entry.work.simulated().is_some())
        .collect();
    let mut settled = Vec::new();
    for (number, later) in entries.iter().enumerate() {
        let place = |id: &str| evidence.iter().position(|it| it.id == id);
        let Some(own) = place(&later.id) else {
            continue;
        };
        let mut shared = Vec::new();
        for earlier in &entries[..number] {
            let Some(other) = place(&earlier.id) else {
                continue;
            };
            if later.seeded_as() != earlier.seeded_as() {
                continue;
            }
            let seeds = SharedSeeds {
                with: earlier.id.clone(),
                of: later.seeded_as().to_owned(),
                same_runs: simulates(later, &evidence[own]) == simulates(earlier, &evidence[other]),
            };
            let reason = later.independent.reason(&earlier.id);
            let reason = reason.or(earlier.independent.reason(&later.id));
            // That the same runs are independent of themselves is no reason.
            match reason.filter(|_| !seeds.same_runs) {
                Some(reason) => settled.push((own, settled_by(&later.id, &seeds, reason))),
                None => shared.push(seeds),
            }
        }
        evidence[own].shared_seeds = shared;
    }
    settled
}

/// What an entry simulates: its work as the ledger has it, with the content of files in place of their names.
fn simulates(entry: &Entry, piece: &Evidence) -> Option<Value> {
    let mut work = serde_json::to_value(&entry.work).ok()?;
    by_content(&mut work, &piece.assets);
    // What these files name in turn.
    let models = piece.assets.iter();
    let models = models.filter(|asset| asset.role == AssetRole::SystemModel);
    let contents: BTreeSet<&str> = models.map(|asset| asset.hash.as_str()).collect();
    Some(serde_json::json!([work, contents]))
}

fn by_content(value: &mut Value, assets: &[Asset]) {
    match value {
        Value::String(text) => {
            let of_name = assets.iter().find(|asset| asset.path == *text);
            if let Some(asset) = of_name {
                *text = format!("content {}", asset.hash);
            }
        }
        Value::Array(all) => {
            all.iter_mut().for_each(|it| by_content(it, assets));
        }
        Value::Object(all) => {
            all.retain(|key, _| !NOT_OF_A_RUN.contains(&key.as_str()));
            all.values_mut().for_each(|it| by_content(it, assets));
        }
        Value::Null | Value::Bool(_) | Value::Number(_) => {}
    }
}

fn settled_by(id: &str, seeds: &SharedSeeds, reason: &str) -> LineageQuestion {
    let SharedSeeds { with, of, .. } = seeds;
    LineageQuestion {
        with: with.clone(),
        kind: CopyKind::Seeds,
        subjects: Vec::new(),
        finding: format!("runs of {id} and {with} both have the seeds of {of}"),
        places: Vec::new(),
        chance: 0.0,
        blocks: true,
        settled: Some(reason.to_owned()),
        remedy: "leave `seeds` out, so that each has seeds of its own".to_owned(),
    }
}

fn seeds(of: &Told) -> BTreeSet<&str> {
    let headers = of.table.headers().iter();
    let header = headers.into_iter().find(|it| it.eq_ignore_ascii_case(SEED));
    let column = header.and_then(|header| of.table.column(header).ok());
    column
        .map(|column| column.cells().collect())
        .unwrap_or_default()
}

fn question(later: &Told, earlier: &Told, (same, all): (usize, usize)) -> LineageQuestion {
    let (id, with) = (&later.evidence, &earlier.evidence);
    let line = |of: &Told| of.table.columns().next().map_or(0, |it| it.line(0));
    LineageQuestion {
        with: with.clone(),
        kind: CopyKind::Seeds,
        subjects: Vec::new(),
        finding: format!(
            "{same} of the {all} episodes of {id} have seeds that episodes of {with} have, too: the same random numbers, so \
             that the two are correlated"
        ),
        places: vec![
            format!("{}:{}", later.path, line(later)),
            format!("{}:{}", earlier.path, line(earlier)),
        ],
        chance: 0.0,
        blocks: true,
        settled: None,
        remedy: format!(
            "run one of them on other seeds, or compare them as pairs (`corroborate what-if`); if the seeds mean something \
             else in each, write `independent = {{ {with} = \"reason\" }}` in {id}'s entry of ledger.toml"
        ),
    }
}
