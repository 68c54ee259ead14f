//! Data that two pieces of evidence share though no lineage says so.
//!
//! # Definition
//! Two pieces share data if both rest on a table or recording of the same content (the same hash), under whatever name (whether
//! tables of totals under two names are one is a question, [`crate::CopyKind::File`]), or
//! if a table of the one repeats rows of a table of the other beyond chance ([`crate::Evidence::shared_rows`]), or most of
//! their models was written once ([`crate::Evidence::common_texts`]), or if both have the same runs of one simulator
//! ([`crate::Evidence::shared_seeds`]).
//! Then some trials are the trials of both, so that they agree whatever the truth is.
//!
//! # Assumes
//! Files of equal content are one file, but tables of totals, which may be equal by chance. Rows of different trials repeat
//! each other no oftener than `stats::shared_rows` says.
//!
//! # Guarantee
//! Rows are compared of tables of people or sessions (`stats::shared_rows` has the chance); totals of which the tables do
//! not say who did what are compared as whole files, and a recording that was written anew is not found. Episodes of two
//! entries of a ledger have the same seeds only where one is given those of the other. Runs of other simulators with the same
//! seeds are *paired*: they share their draws and nothing else.

use crate::{AssetRole, CommonText, Evidence, RepeatedRows, SharedSeeds};
use std::collections::{BTreeMap, BTreeSet};

/// What pairs of evidence share, in words, by their identifiers in order.
#[derive(Clone, Debug, Default)]
pub(super) struct SharedData {
    data: BTreeMap<(String, String), String>,
    /// Pairs that have the same runs, and why.
    same_runs: BTreeMap<(String, String), String>,
    /// Pairs of which each run has its counterpart, and why.
    paired: BTreeMap<(String, String), String>,
}

impl SharedData {
    pub fn of(evidence: &[Evidence]) -> Self {
        let mut by_content: BTreeMap<&str, BTreeMap<&str, &str>> = BTreeMap::new();
        for piece in evidence {
            let data = piece.assets.iter();
            // Without a hash nothing is known of the content.
            let data = data.filter(|it| it.role == AssetRole::Data && !it.hash.is_empty());
            for asset in data {
                let holders = by_content.entry(&asset.hash).or_default();
                holders.entry(&piece.id).or_insert(&asset.path);
            }
        }
        // By pair: how many files, and the first of them under both names.
        let mut shared: BTreeMap<(&str, &str), BTreeSet<(&str, &str)>> = BTreeMap::new();
        for holders in by_content.values().filter(|holders| holders.len() > 1) {
            let holders: Vec<(&str, &str)> =
                holders.iter().map(|(id, path)| (*id, *path)).collect();
            for (place, (first, path)) in holders.iter().enumerate() {
                for (second, other) in &holders[place + 1..] {
                    if path != other && may_equal(evidence, [first, second]) {
                        continue;
                    }
                    let files = shared.entry((first, second)).or_default();
                    files.insert((path, other));
                }
            }
        }
        let repeated = evidence.iter().flat_map(|piece| {
            let rows = piece.shared_rows.iter();
            rows.map(|rows| (ordered(&piece.id, &rows.with), rows_in_words(rows)))
        });
        let whole = shared.into_iter().map(|((first, second), files)| {
            let pair = (first.to_owned(), second.to_owned());
            (pair, words(&files))
        });
        let texts = evidence.iter().flat_map(|piece| {
            let texts = piece.common_texts.iter();
            texts.map(|text| (ordered(&piece.id, &text.with), text_in_words(text)))
        });
        let seeds = |same_runs: bool| {
            let pieces = evidence.iter().flat_map(move |piece| {
                let seeds = piece.shared_seeds.iter();
                seeds.filter(move |it| it.same_runs == same_runs).map(|it| {
                    let pair = ordered(&piece.id, &it.with);
                    let words = seeds_in_words(&piece.id, it);
                    (pair, words)
                })
            });
            pieces.collect::<Vec<_>>()
        };
        Self {
            // Of a pair that shares a whole file, too, that is said.
            data: texts
                .chain(repeated)
                .chain(whole)
                .chain(seeds(true))
                .collect(),
            same_runs: seeds(true).into_iter().collect(),
            paired: seeds(false).into_iter().collect(),
        }
    }

    /// Why two pieces have the same runs; `None` if they do not.
    pub fn same_runs(&self, first: &str, second: &str) -> Option<&str> {
        let found = self.same_runs.get(&ordered(first, second));
        found.map(String::as_str)
    }

    /// Why the runs of two pieces are paired; `None` if they are not.
    pub fn paired(&self, first: &str, second: &str) -> Option<&str> {
        self.paired.get(&ordered(first, second)).map(String::as_str)
    }

    /// What two pieces share; `None` if nothing that is known.
    pub fn between(&self, first: &str, second: &str) -> Option<&str> {
        self.data.get(&ordered(first, second)).map(String::as_str)
    }
}

fn may_equal(evidence: &[Evidence], ids: [&str; 2]) -> bool {
    let [one, other] = ids.map(|id| evidence.iter().find(|it| it.id == id));
    one.zip(other)
        .is_some_and(|(one, other)| one.may_equal_by_chance(other))
}

fn ordered(first: &str, second: &str) -> (String, String) {
    (first.min(second).to_owned(), first.max(second).to_owned())
}

fn rows_in_words(rows: &RepeatedRows) -> String {
    let [one, other] = &rows.tables;
    format!(
        "{} of the {} rows that `{one}` and `{other}` both have are the same (by chance with a probability of at most {:.1e}): \
         the same trials or the same people",
        rows.same, rows.common, rows.chance
    )
}

fn seeds_in_words(id: &str, seeds: &SharedSeeds) -> String {
    let SharedSeeds {
        with,
        of,
        same_runs,
    } = seeds;
    match same_runs {
        true => format!(
            "{with} and {id} are the same runs: one simulator, one stimulus, and the seeds of {of}"
        ),
        false => format!(
            "runs of {with} and {id} are paired, since both have the seeds of {of} and draw the same random numbers"
        ),
    }
}

fn text_in_words(text: &CommonText) -> String {
    let [one, other] = &text.files;
    match one == other {
        true => format!("both are computed from `{one}`"),
        false => format!(
            "{} of the {} statements of the shorter of the models `{one}` and `{other}` stand in both: a copy or a revision",
            text.same, text.statements
        ),
    }
}

fn words(files: &BTreeSet<(&str, &str)>) -> String {
    let Some((one, other)) = files.first() else {
        return String::new();
    };
    let first = match one == other {
        true => format!("`{one}`"),
        false => format!("`{one}`, which is `{other}`"),
    };
    match files.len() - 1 {
        0 => format!("both read {first}"),
        1 => format!("both read {first}, and 1 more file"),
        more => format!("both read {first}, and {more} more files"),
    }
}
