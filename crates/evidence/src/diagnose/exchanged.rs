//! A piece of evidence with what its tables have the wrong way round exchanged.
//!
//! # Definition
//! Whole columns ([`super::columns`]) come first, then two names ([`super::names`]), then columns in single rows: two names explain two
//! rates, a row one. What is found is put right in all findings that it touches: the counts of two failure
//! modes or requirements, or kept and violated of all requirements. Intervals are left as they are: they are of other counts.
//!
//! # Assumes
//! What was found to be exchanged is what was exchanged.
//!
//! # Guarantee
//! Rates ([`super::strength::Rate`]) are those that the exchanged table would give.

use super::columns::{ExchangedColumns, exchanged_columns};
use super::names::{MixedUp, mixed_up};
use crate::{Evidence, Measure, Subject};

/// Whether people wrote down what a piece counts: what they write can be the wrong way round.
pub(super) fn is_table(piece: &Evidence) -> bool {
    piece.technique.traits().is_counted_by_people || piece.published
}

/// What of a piece's tables was exchanged.
#[derive(Clone, Debug, PartialEq)]
pub enum Exchanged<'p> {
    /// The columns "passed" and "failed", in all rows or in some.
    Columns(ExchangedColumns),
    /// Two names.
    Names(MixedUp<'p>),
}

/// What of a piece's tables was exchanged, as far as the other evidence says.
#[must_use]
pub fn exchanged<'p>(
    evidence: &[Evidence],
    piece: &'p Evidence,
    margin: &dyn Fn(&Subject) -> f64,
) -> Option<Exchanged<'p>> {
    let columns = exchanged_columns(evidence, piece, margin);
    let names = || mixed_up(evidence, piece, margin).map(Exchanged::Names);
    match columns {
        Some(all) if all.are_all => Some(Exchanged::Columns(all)),
        rows => names().or(rows.map(Exchanged::Columns)),
    }
}

/// The piece as its tables would give it if they were put right, if the other evidence says that they are not; with the odds
/// against another reason, in decades, where little says so ([`ExchangedColumns::odds`]).
pub fn put_right(
    evidence: &[Evidence],
    piece: &Evidence,
    margin: &dyn Fn(&Subject) -> f64,
) -> Option<(Evidence, Option<f64>)> {
    if !is_table(piece) {
        return None;
    }
    Some(match exchanged(evidence, piece, margin)? {
        Exchanged::Columns(found) => (with_columns(piece, &found), found.odds),
        Exchanged::Names(found) => (with_names(piece, &found), None),
    })
}

fn with_columns(piece: &Evidence, found: &ExchangedColumns) -> Evidence {
    let mut piece = piece.clone();
    for finding in &mut piece.findings {
        if let (true, Measure::Counts { count, trials, .. }) =
            (found.rows.contains(&finding.subject), &mut finding.measure)
        {
            *count = trials.saturating_sub(*count);
        }
    }
    piece
}

fn with_names(piece: &Evidence, found: &MixedUp<'_>) -> Evidence {
    let [a, b] = found.modes;
    let measure = |subject: &Subject| piece.finding(subject).map(|it| it.measure.clone());
    let (of_a, of_b) = (measure(a), measure(b));
    let mut exchanged = piece.clone();
    for finding in &mut exchanged.findings {
        let other = match &finding.subject {
            subject if subject == a => of_b.as_ref(),
            subject if subject == b => of_a.as_ref(),
            _ => None,
        };
        let Some(other) = other else { continue };
        match (&mut finding.measure, other) {
            (Measure::Counts { count, .. }, Measure::Counts { count: theirs, .. })
                if !found.is_whole =>
            {
                *count = *theirs;
            }
            (own, other) => *own = other.clone(),
        }
    }
    exchanged
}
