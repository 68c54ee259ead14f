//! How often the statements of a study are wrong: every error rate that this crate promises, measured.
//!
//! `cargo run -p corroborate-evidence --release --example error_rates` prints the tables of `ERROR_RATES.md`, with the names of
//! sections (`several`, `looks`, `looks-at-people`, `pairs`, `models`, `carried`, `people`, `cells`) only those, with a number so many studies. Each row is a simulation with a seed of
//! its own, or a sum over all outcomes, so that it prints the same each time. `tests/integration/error_rates.rs` has a small version.

pub(crate) mod carried;
pub(crate) mod cells;
pub(crate) mod laws;
pub(crate) mod looks;
pub(crate) mod pairs;
pub(crate) mod people;
pub(crate) mod several;
#[path = "../../tests/integration/support/mod.rs"]
pub(crate) mod support;
pub(crate) mod table;

use table::Row;

/// A section: its name, its heading, its rows.
type Section = (&'static str, &'static str, fn(u64) -> Vec<Row>);

/// All sections with the studies of a row.
const SECTIONS: [(Section, u64); 8] = [
    (
        (
            "several",
            "Several requirements at their thresholds",
            several::rows,
        ),
        1000,
    ),
    (
        (
            "looks",
            "Verdicts when trials are added until one comes out",
            looks::rows,
        ),
        200,
    ),
    (
        (
            "looks-at-people",
            "Verdicts when people are added until one comes out",
            looks::rows_of_people,
        ),
        200,
    ),
    (
        (
            "pairs",
            "Pairs when trials are added until something is shown",
            pairs::rows,
        ),
        600,
    ),
    (
        (
            "models",
            "Counts and a model when trials are added until something is shown",
            pairs::rows_with_a_model,
        ),
        600,
    ),
    (("carried", "Models that carry over", carried::rows), 100),
    (
        ("people", "Attempts of people who differ", people::rows),
        1000,
    ),
    (
        (
            "cells",
            "Each relation of a pair, at the worst rates",
            cells::rows,
        ),
        0,
    ),
];

#[allow(dead_code)] // The test that includes this file has no use for it.
fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let number = wanted.iter().find_map(|it| it.parse().ok());
    let names: Vec<&String> = wanted
        .iter()
        .filter(|it| it.parse::<u64>().is_err())
        .collect();
    for ((name, heading, rows), studies) in SECTIONS {
        let studies = number.unwrap_or(studies);
        if names.is_empty() || names.iter().any(|it| *it == name) {
            println!("## {heading}\n\n{}", table::markdown(&rows(studies)));
        }
    }
}
