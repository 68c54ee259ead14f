//! Episodes of two simulations that were drawn from the same seeds.
//!
//! # Definition
//! The tables of two pieces of evidence by simulation that both have a column `seed` are held against each other. Seeds of
//! variants of one simulator that are equal give the same random numbers to both, so that their episodes are paired: they
//! are correlated, mostly positively, and not two samples.
//!
//! # Guarantee
//! Equal seeds are no coincidence that has a probability: numbers from 1 on are equal by intention, too. So one is a
//! question. Episodes that are run here have seeds of their own for each entry of the ledger (`simulation::Seeds`), and
//! variants that are compared on the same seeds are so as pairs (`what_if`).

use crate::technique::experiment::repeated::{Told, tables};
use diagnostic::Problem;
use evidence::{CopyKind, Evidence, LineageQuestion};
use std::collections::BTreeSet;
use study::Study;

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
