//! A table of requirements whose columns "passed" and "failed" were exchanged, in all rows or in some.
//!
//! # Definition
//! A row counts a requirement in sum; what is counted by person or session stands in another table. A row *fits* exchanged if
//! with kept and violated exchanged it differs strongly (at least [`STRONG`], see [`mod@super::strength`]) from no other evidence
//! under the same conditions, and is *wrong* if it differs so as it is.
//!
//! * The columns were exchanged if every row fits exchanged, and at least [`FEWEST`] are wrong, or one is by [`EXTREME`] against
//!   at least as many other pieces.
//! * Else single rows were, if each of them differs by [`EXTREME`] from all other evidence as it is and agrees with all of it
//!   exchanged (the evidence is for one rate), and if the requirement is kept in less than half of the trials as it is.
//!
//! The exchange takes `T - T'` of a conflict, `T'` being what is left with the other column.
//!
//! # Assumes
//! All other evidence is right. How much rarer rows are exchanged than wrong for another reason is a guess (`RARE`). Trials
//! are independent, or count at their effective size.
//!
//! # Source and guarantee
//! One exchange in place of wrong rates, as in [`super::names`]: each of the rates has to fit from the other side,
//! which wrong rates do beyond chance only where they are complements. A single row against one other piece may be that: a model
//! that asks the contrary gives the complement, too. What systems are built for is rather kept than violated, so that the row
//! is named which says otherwise, and the models with it.

use super::matter::{Clue, Matter, is_by_subject, name_of};
use super::rates::figure;
use super::strength::{Rate, STRONG, signed_strength, strength};
use super::suspect::Symptom;
use crate::{Evidence, Inaccuracy, Subject};

/// Rates that have to be on the wrong side, or other pieces on which side one of them is not.
const FEWEST: usize = 2;

/// Decades by which one rate has to differ from each of the others.
const EXTREME: f64 = 5.0;

/// How often a row is the wrong way round for each time that a rate is wrong otherwise, in decades.
const RARE: f64 = -0.5;

/// What of a piece's table of requirements has passed and failed the wrong way round, as far as the other evidence says.
#[derive(Clone, Debug, PartialEq)]
pub struct ExchangedColumns {
    /// The requirements of the rows.
    pub rows: Vec<Subject>,
    /// Whether these are all rows of the table.
    pub are_all: bool,
    /// The odds, in decades, against another reason, where one rate against one other piece is all that says so.
    pub odds: Option<f64>,
}

impl ExchangedColumns {
    /// What was exchanged, for people: the whole columns or rows of them.
    fn in_words(&self) -> String {
        let rows: Vec<String> = self
            .rows
            .iter()
            .map(|it| format!("`{}`", it.id()))
            .collect();
        match (self.are_all, rows.as_slice()) {
            (true, _) => String::new(),
            (false, [row]) => format!(" in its row {row}"),
            (false, rows) => format!(" in its rows {}", rows.join(", ")),
        }
    }
}

/// How a row stands to the other evidence.
struct Row<'e> {
    subject: &'e Subject,
    is_kept_rarely: bool,
    /// Strengths of disagreement as it is.
    now: Vec<f64>,
    /// Signed ones with kept and violated exchanged.
    then: Vec<f64>,
}

impl Row<'_> {
    fn fits(&self) -> bool {
        self.then.iter().all(|it| *it < STRONG)
    }

    fn is_extreme(&self) -> bool {
        !self.now.is_empty() && self.now.iter().all(|it| *it >= EXTREME)
    }

    /// How many wrong rates it counts as.
    fn wrong(&self) -> usize {
        match (self.is_extreme(), self.now.iter().any(|it| *it >= STRONG)) {
            (true, _) => self.now.len().min(FEWEST),
            (false, is_apart) => usize::from(is_apart),
        }
    }

    fn is_wrong_alone(&self) -> bool {
        self.is_kept_rarely && self.is_extreme() && self.then.iter().all(|it| *it < 0.0)
    }
}

/// What of a piece's columns "passed" and "failed" was exchanged, as far as the other evidence says.
#[must_use]
pub fn exchanged_columns(
    evidence: &[Evidence],
    piece: &Evidence,
    margin: &dyn Fn(&Subject) -> f64,
) -> Option<ExchangedColumns> {
    let others = |subject: &Subject| {
        let others = evidence.iter().filter(|other| {
            other.id != piece.id && !other.intermediate && other.conditions == piece.conditions
        });
        let rates = others.filter_map(|other| Rate::on(other, subject));
        rates.collect::<Vec<Rate>>()
    };
    let counted = piece.findings.iter().filter(|finding| {
        matches!(finding.subject, Subject::Requirement(_)) && !is_by_subject(finding)
    });
    let rows = counted.filter_map(|finding| {
        let subject = &finding.subject;
        let rate = Rate::of(finding)?;
        let other = contrary(rate)?;
        let margin = margin(subject);
        let theirs = others(subject).into_iter();
        let both = theirs.map(|it| {
            (
                strength(it, rate, margin),
                signed_strength(it, other, margin),
            )
        });
        let (now, then) = both.unzip();
        Some(Row {
            subject,
            is_kept_rarely: rate.share() < other.share(),
            now,
            then,
        })
    });
    let rows: Vec<Row<'_>> = rows.collect();
    let wrong: usize = rows.iter().map(Row::wrong).sum();
    let are_all = rows.iter().all(Row::fits) && wrong >= FEWEST;
    let chosen = rows.iter().filter(|row| are_all || row.is_wrong_alone());
    let chosen: Vec<&Row<'_>> = chosen.collect();
    let odds = match chosen.as_slice() {
        [] => return None,
        [row] if !are_all && row.then.len() < FEWEST => {
            Some(RARE - row.then.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b)))
        }
        _ => None,
    };
    Some(ExchangedColumns {
        rows: chosen.iter().map(|row| row.subject.clone()).collect(),
        are_all: are_all || chosen.len() == rows.len(),
        odds,
    })
}

/// A counted rate with kept and violated exchanged.
fn contrary(rate: Rate) -> Option<Rate> {
    match rate {
        Rate::Counted {
            count,
            open,
            trials,
        } => Some(Rate::Counted {
            count: trials - count - open,
            open,
            trials,
        }),
        Rate::Computed(_) | Rate::Never => None,
    }
}

impl Matter<'_> {
    /// What of a conflict goes away if a table's columns are exchanged: the clue, and what is left.
    pub(super) fn of_columns(
        &self,
        piece: &Evidence,
        against: &Evidence,
        subject: &Subject,
        whole: f64,
    ) -> Option<(Clue, f64)> {
        let is_table = super::exchanged::is_table(piece);
        let margin = |subject: &Subject| self.margin(subject);
        let is_requirement = matches!(subject, Subject::Requirement(_));
        if !is_table || !is_requirement {
            return None;
        }
        let found = exchanged_columns(self.evidence, piece, &margin)?;
        if !found.rows.contains(subject) {
            return None;
        }
        let finding = piece.finding(subject)?;
        let exchanged = contrary(Rate::of(finding)?)?;
        let theirs = Rate::on(against, subject)?;
        let rest = strength(exchanged, theirs, self.margin(subject)).min(whole);
        let share = found.odds.map_or(1.0, |odds| {
            let odds = 10.0_f64.powf(odds);
            odds / (1.0 + odds)
        });
        // Of two tables that are each other's contrary either may be the one.
        let share = match super::exchanged::is_table(against) {
            true => share / 2.0,
            false => share,
        };
        let taken = (whole - rest) * share;
        let mut asset = self.table_and_words(piece, subject);
        if !found.are_all {
            asset.part = Some(format!("row `{}`", subject.id()));
        }
        let place = found.in_words();
        let agrees_on = match found.are_all {
            true => "its requirements".to_owned(),
            false => name_of(subject),
        };
        let clue = Clue {
            inaccuracy: Inaccuracy::SystemModel,
            asset,
            subject: subject.clone(),
            score: taken,
            title: format!(
                "{} has passed and failed the wrong way round{place}",
                piece.id
            ),
            explanation: format!(
                "With passed and failed exchanged {} agrees with all other evidence on {agrees_on}; of the conflict with \
                 {} on {} (Bayes factor 10^{whole:.1}) 10^{rest:.1} is left.",
                piece.id,
                against.id,
                name_of(subject)
            ),
            symptom: Symptom::RateDiffers {
                subject: subject.clone(),
                evidence: piece.id.clone(),
                value: finding.measure.estimate()?,
                others: vec![super::rates::counts_of(against, subject)],
            },
            figures: vec![
                figure("conflict, log10 Bayes factor", whole),
                figure(
                    "left of it with the columns exchanged, log10 Bayes factor",
                    rest,
                ),
            ],
            witnesses: Vec::new(),
            ruled_out: Vec::new(),
            resolved_by: self.mended(piece, against, subject),
        };
        Some((clue, whole - taken))
    }
}
