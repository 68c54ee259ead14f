//! Rows of one table that are another's under other names: renamed people, in the same order or another.
//!
//! # Definition
//! Of two cohorts that differ as files, the cells of the columns by which something is counted are compared in one form
//! (`1.0` is `1`, `true` is `1`), with the probabilities of `stats::renamed_rows`.
//!
//! # Assumes
//! Rows of different people are independent, as `stats::renamed_rows` has it.
//!
//! # Guarantee
//! Few people with few outcomes repeat each other by chance; ten people with ten trials each are found in the same order,
//! in another mostly from twenty on (`cargo run --release -p corroborate-stats --example copies`).

use super::Cohort;
use super::repeated::{Told, canonical, counted_columns, tables};
use diagnostic::Problem;
use stats::{Sample, Unnamed};
use std::collections::BTreeSet;
use study::Study;

/// What two tables have in common.
pub struct Renamed {
    /// The evidence with the earlier table.
    pub earlier: String,
    /// The evidence with the later one.
    pub later: String,
    /// Both tables, the earlier first.
    pub paths: [String; 2],
    /// Where the rows begin, the later table first.
    pub places: Vec<String>,
    /// How the rows stand to each other.
    pub how: &'static str,
    /// Rows that are the same.
    pub same: u64,
    /// Rows of the later table.
    pub rows: u64,
    /// The probability of as many by chance, at most, for any of the pairs of tables.
    pub chance: f64,
}

/// A table with what was counted in each row.
struct Counted {
    told: Told,
    /// The counts by row for each binding; none where the table has no such column.
    samples: Vec<Vec<Sample>>,
}

/// Every pair of cohorts that are different files.
pub fn pairs(study: &Study) -> Result<Vec<Renamed>, Problem> {
    let headers = counted_columns(study);
    let mut counted = Vec::new();
    for told in tables(study)? {
        counted.push(Counted::of(study, told)?);
    }
    let many = counted.len() * counted.len().saturating_sub(1) / 2;
    let mut found = Vec::new();
    for (place, later) in counted.iter().enumerate() {
        for earlier in &counted[..place] {
            if earlier.told.path != later.told.path {
                found.extend(compared(earlier, later, &headers, many));
            }
        }
    }
    Ok(found)
}

impl Counted {
    fn of(study: &Study, told: Told) -> Result<Self, Problem> {
        let cohort = Cohort::new(study, told.table.clone())?;
        let propositions = study.vocabulary.propositions.values();
        let bindings = propositions.filter_map(|it| Some(it.column.as_ref()?.text.as_str()));
        let samples = bindings.map(|binding| cohort.counts(binding).unwrap_or_default());
        Ok(Self {
            samples: samples.collect(),
            told,
        })
    }

    fn has(&self, header: &str) -> bool {
        self.told.table.column(header).is_ok()
    }

    /// Its rows by these columns.
    fn rows(&self, headers: &[&str]) -> Unnamed<Vec<String>> {
        let mut contents = vec![Vec::new(); self.told.table.len()];
        let columns = headers
            .iter()
            .filter_map(|header| self.told.table.column(header).ok());
        for column in columns {
            for (row, cell) in contents.iter_mut().zip(column.cells()) {
                row.push(canonical(cell));
            }
        }
        Unnamed {
            contents,
            columns: self.samples.clone(),
        }
    }
}

fn compared(
    earlier: &Counted,
    later: &Counted,
    headers: &BTreeSet<&str>,
    many: usize,
) -> Option<Renamed> {
    let headers = headers.iter().copied().chain(["attempts"]);
    let common: Vec<&str> = headers
        .filter(|header| earlier.has(header) && later.has(header))
        .collect();
    let rows = later.told.table.len();
    if earlier.told.table.is_empty() || rows == 0 {
        return None;
    }
    let found = stats::renamed_rows(&earlier.rows(&common), &later.rows(&common));
    let line = |it: &Counted| it.told.table.columns().next().map_or(0, |c| c.line(0));
    let place = |it: &Counted| format!("{}:{}", it.told.path, line(it));
    Some(Renamed {
        earlier: earlier.told.evidence.clone(),
        later: later.told.evidence.clone(),
        paths: [earlier.told.path.clone(), later.told.path.clone()],
        places: vec![place(later), place(earlier)],
        how: if found.in_order {
            "in the same order"
        } else {
            "in another order"
        },
        same: found.same,
        rows: rows as u64,
        chance: (found.chance * many as f64).min(1.0),
    })
}
