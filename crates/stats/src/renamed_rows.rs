//! Whether the rows of one table are another's under other names, in the same order or another.
//!
//! # Definition
//! * *In the same order*: row `i` with row `i`. The probability is the larger of two: of as many equal rows if contents
//!   come to places by chance ([`mod@crate::shared_rows`]), and of as many equal counts whatever each row's rate is
//!   ([`crate::rows_by_chance`], of the column that tells most), so that neither a trend nor conditions of different
//!   difficulty pass for a copy. Of rows of one trial each the first counts alone, and nothing if a table is sorted by its
//!   outcomes (runs test, p < [`SORTED`]).
//! * *In another order*: all contents as they are ([`crate::contents_by_chance`]).
//!
//! The smaller of both, doubled, is the probability of the tables.
//!
//! # Source
//! The tests' own; C. E. Bonferroni (1936) for the doubling.
//!
//! # Assumes
//! Rows of different trials are independent: at their places, contents come by chance or counts are independent given each
//! row's rate; in another order, rows of both tables are of one distribution. Of several columns the least probability
//! counts, without correction for their number.
//!
//! # Guarantee
//! That of the tests. Rows of one trial that fail in both tables because their conditions are hard count as repeated: then
//! the trials of both tables are not independent either. Cost: that of [`crate::contents_by_chance`].

use crate::coincidence::{contents_by_chance, rows_by_chance};
use crate::counts::Sample;
use crate::runs::runs_test;
use crate::shared_rows::shared_rows;

/// Below this p-value of few runs a table counts as sorted by its outcomes.
pub const SORTED: f64 = 0.01;

/// A table of rows whose names do not count.
#[derive(Clone, Debug)]
pub struct Unnamed<T> {
    /// What each row says.
    pub contents: Vec<T>,
    /// For each column that counts something, the counts by row.
    pub columns: Vec<Vec<Sample>>,
}

/// Rows of the second table that are rows of the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenamedRows {
    /// Whether they stand in the same order.
    pub in_order: bool,
    /// Rows that are the same.
    pub same: u64,
    /// The probability of as many by chance, at most.
    pub chance: f64,
}

/// Compares two tables row by row and as a whole.
///
/// ```
/// use stats::{Sample, Unnamed, renamed_rows};
/// let table = |counts: [u64; 10]| Unnamed {
///     contents: counts.to_vec(),
///     columns: vec![counts.map(|successes| Sample { successes, trials: 10 }).to_vec()],
/// };
/// let people = table([9, 10, 8, 7, 9, 10, 10, 6, 9, 10]);
/// assert!(renamed_rows(&people, &people).chance < 3e-3);
/// let others = table([10, 9, 9, 10, 7, 8, 10, 9, 10, 10]);
/// assert!(renamed_rows(&people, &others).chance > 0.05);
/// ```
#[must_use]
pub fn renamed_rows<T: Ord>(first: &Unnamed<T>, second: &Unnamed<T>) -> RenamedRows {
    let placed = shared_rows(&first.contents, &second.contents);
    let in_order = at_their_places(first, second, placed.chance);
    let (shared, anyhow) = contents_by_chance(&first.contents, &second.contents);
    let is_in_order = in_order <= anyhow;
    RenamedRows {
        in_order: is_in_order,
        same: if is_in_order { placed.same } else { shared },
        chance: (2.0 * in_order.min(anyhow)).min(1.0),
    }
}

/// The probability of as many equal rows at equal places.
fn at_their_places<T>(first: &Unnamed<T>, second: &Unnamed<T>, by_permutation: f64) -> f64 {
    let single = |it: &Unnamed<T>| it.columns.iter().flatten().all(|row| row.trials <= 1);
    if single(first) && single(second) {
        let sorted = is_sorted(&first.columns) || is_sorted(&second.columns);
        return if sorted { 1.0 } else { by_permutation };
    }
    let columns = first.columns.iter().zip(&second.columns);
    let chances = columns.map(|(one, other)| rows_by_chance(one, other));
    chances.fold(1.0, f64::min).max(by_permutation)
}

/// Whether outcomes stand in their order, so that places tell them.
fn is_sorted(columns: &[Vec<Sample>]) -> bool {
    columns.iter().any(|column| {
        let outcomes: Vec<bool> = column.iter().map(|row| row.successes > 0).collect();
        runs_test(&outcomes).is_some_and(|runs| runs.p_value < SORTED)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(counts: &[u64], trials: u64) -> Unnamed<u64> {
        let column = counts.iter().map(|&successes| Sample { successes, trials });
        Unnamed {
            contents: counts.to_vec(),
            columns: vec![column.collect()],
        }
    }

    #[test]
    fn single_trials_in_order_are_found_unless_sorted() {
        let mixed: Vec<u64> = (0..60).map(|i| u64::from(i * i % 7 != 2)).collect();
        let mut sorted = mixed.clone();
        sorted.sort_unstable();
        let found = |counts: &[u64]| renamed_rows(&table(counts, 1), &table(counts, 1));
        assert!(found(&mixed).chance < 1e-9 && found(&mixed).in_order);
        assert!(found(&sorted).chance > 0.1, "{:?}", found(&sorted));
    }

    #[test]
    fn rows_that_always_succeed_or_fail_tell_nothing() {
        let by_condition: Vec<u64> = (0..24).map(|i| if i % 3 == 0 { 0 } else { 20 }).collect();
        let both = table(&by_condition, 20);
        assert!(renamed_rows(&both, &both).chance > 0.4);
    }

    #[test]
    fn many_rows_are_found_in_another_order() {
        let counts: Vec<u64> = (0..40).map(|i| (i * i * 7 + i * 3) % 41).collect();
        let mut turned = counts.clone();
        turned.rotate_left(13);
        let found = renamed_rows(&table(&counts, 40), &table(&turned, 40));
        assert!(
            found.chance < 1e-3 && !found.in_order && found.same == 40,
            "{found:?}"
        );
    }
}
