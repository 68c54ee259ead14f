//! Rows that the tables of two pieces of evidence have in common: the same trials told twice, though no lineage says so.
//!
//! # Definition
//! Of two tables of people or sessions, which differ as files, the rows with the same name in the first column are compared
//! on all further columns that both have. They repeat each other if as many equal rows have a probability of at most
//! `CHANCE` (divided by the number of pairs of tables) where contents come to names by chance (`stats::shared_rows`), and
//! what was counted, by itself, one of at most `OF_OUTCOMES`.
//!
//! # Assumes
//! Contents of different trials come to names by chance. What tables have in common by design stands in columns by which
//! nothing is counted.
//!
//! # Guarantee
//! The second condition is there since tables may agree by design in what was set: ages, orders, settings of the same
//! people or the same plan. Then only what came out speaks, with its smaller probability. The same people in other trials
//! are found, too, where they repeat what they did; those trials are not independent either. Not found are fewer than ten
//! rows, rows under other names, and rows of so few values that chance gives as many: 0 of 10 each time tells nothing.

use super::columns::header;
use super::placed::table_problem;
use diagnostic::Problem;
use evidence::{Evidence, RepeatedRows};
use stats::SharedRows;
use std::collections::{BTreeMap, BTreeSet};
use study::Study;
use trace::Table;

/// Up to which probability equal rows are not by chance.
const CHANCE: f64 = 1e-6;

/// The same for what was counted alone.
const OF_OUTCOMES: f64 = 1e-3;

/// A table with the evidence that it is of.
pub struct Told {
    /// The evidence.
    pub evidence: String,
    /// The table's file, relative to the study.
    pub path: String,
    /// The table.
    pub table: Table,
}

/// Fills in which rows each piece of evidence has in common with earlier ones.
pub fn find(study: &Study, evidence: &mut [Evidence]) -> Result<(), Problem> {
    let told = tables(study)?;
    if told.len() < 2 {
        return Ok(());
    }
    let counted = counted_columns(study);
    let limit = CHANCE / (told.len() * (told.len() - 1) / 2) as f64;
    for (place, later) in told.iter().enumerate() {
        let repeated: Vec<RepeatedRows> = told[..place]
            .iter()
            .filter_map(|earlier| repeated(earlier, later, &counted, limit))
            .collect();
        if let Some(piece) = evidence.iter_mut().find(|it| it.id == later.evidence) {
            piece.shared_rows = repeated;
        }
    }
    Ok(())
}

/// The tables of people or sessions, in the ledger's order.
pub fn tables(study: &Study) -> Result<Vec<Told>, Problem> {
    let mut told = Vec::new();
    for entry in &study.ledger {
        if let Some(path) = entry.work.cohort() {
            let table = Table::read(&study.folder.join(path)).map_err(table_problem)?;
            told.push(Told {
                evidence: entry.id.clone(),
                path: path.to_string_lossy().replace('\\', "/"),
                table,
            });
        }
    }
    Ok(told)
}

/// The columns by which something is counted.
pub(super) fn counted_columns(study: &Study) -> BTreeSet<&str> {
    let bindings = study.vocabulary.propositions.values();
    let texts = bindings.filter_map(|it| Some(it.column.as_ref()?.text.as_str()));
    texts.map(header).collect()
}

fn repeated(
    earlier: &Told,
    later: &Told,
    counted: &BTreeSet<&str>,
    limit: f64,
) -> Option<RepeatedRows> {
    // What is the same as a file is found as a file.
    if earlier.path == later.path {
        return None;
    }
    let theirs: BTreeSet<&str> = later
        .table
        .headers()
        .iter()
        .skip(1)
        .map(String::as_str)
        .collect();
    let common: Vec<&str> = earlier
        .table
        .headers()
        .iter()
        .skip(1)
        .map(String::as_str)
        .filter(|header| theirs.contains(header))
        .collect();
    let outcomes: Vec<&str> = common
        .iter()
        .copied()
        .filter(|header| counted.contains(header))
        .collect();
    let all = shared(earlier, later, &common);
    (all.chance <= limit && shared(earlier, later, &outcomes).chance <= OF_OUTCOMES).then(|| {
        RepeatedRows {
            with: earlier.evidence.clone(),
            tables: [earlier.path.clone(), later.path.clone()],
            same: all.same,
            common: all.common,
            chance: all.chance,
        }
    })
}

/// How many rows of the same name are the same in these columns.
fn shared(earlier: &Told, later: &Told, columns: &[&str]) -> SharedRows {
    let (ours, theirs) = (rows(&earlier.table, columns), rows(&later.table, columns));
    let both = ours
        .into_iter()
        .filter_map(|(name, row)| Some((row, theirs.get(name)?)));
    let (ours, theirs): (Vec<Vec<String>>, Vec<&Vec<String>>) = both.unzip();
    let ours: Vec<&Vec<String>> = ours.iter().collect();
    stats::shared_rows(&ours, &theirs)
}

/// The rows by the name in the first column.
fn rows<'t>(table: &'t Table, columns: &[&str]) -> BTreeMap<&'t str, Vec<String>> {
    let names = table.columns().next();
    let names = names.map_or_else(Vec::new, |column| column.as_texts());
    // In the order of the wanted columns: the other table may have another.
    let cells = columns
        .iter()
        .filter_map(|header| table.column(header).ok());
    let cells: Vec<Vec<&str>> = cells.map(|column| column.as_texts()).collect();
    let row = |at: usize| cells.iter().map(|column| canonical(column[at])).collect();
    (0..).zip(names).map(|(at, name)| (name, row(at))).collect()
}

/// A cell in one form, so that other ways to write the same do not hide it.
pub(super) fn canonical(cell: &str) -> String {
    let text = cell.trim().to_lowercase();
    match text.as_str() {
        "true" | "yes" => return "1".to_owned(),
        "false" | "no" => return "0".to_owned(),
        _ => {}
    }
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => number.to_string(),
        _ => text,
    }
}
