//! A table of requirements whose columns "passed" and "failed" were exchanged.
//!
//! # Definition
//! The columns of a piece were exchanged if at least [`FEWEST`] of its rates of requirements differ strongly (at least
//! [`STRONG`], see [`mod@super::strength`]) from other evidence under the same conditions as they are, and if none of its
//! rates of requirements does with kept and violated exchanged in all of them. The exchange takes `T - T'` of a conflict,
//! `T'` being what is left with the other column.
//!
//! # Source and guarantee
//! One exchange in place of several wrong rates, as in [`super::names`]: each of the rates has to fit from the other side,
//! which wrong rates do beyond chance only where they are complements. One rate alone is no sign: a wrong model may be as
//! far off by chance.

use super::matter::{Clue, Matter, name_of};
use super::rates::figure;
use super::strength::{Rate, STRONG, strength};
use super::suspect::Symptom;
use crate::{Evidence, Inaccuracy, Subject};

/// Rates that have to be on the wrong side.
const FEWEST: usize = 2;

/// Whether a piece's columns "passed" and "failed" were exchanged, as far as the other evidence says.
#[must_use]
pub fn has_columns_exchanged(
    evidence: &[Evidence],
    piece: &Evidence,
    margin: &dyn Fn(&Subject) -> f64,
) -> bool {
    let mut mended = 0;
    for finding in &piece.findings {
        let subject = &finding.subject;
        let (Subject::Requirement(_), Some(rate)) = (subject, Rate::of(&finding.measure)) else {
            continue;
        };
        let Some(other) = contrary(rate) else {
            return false;
        };
        let worst = |rate: Rate| {
            let others = evidence.iter().filter(|other| {
                other.id != piece.id && !other.intermediate && other.conditions == piece.conditions
            });
            let theirs = others.filter_map(|other| Rate::on(other, subject));
            let apart = theirs.map(|theirs| strength(theirs, rate, margin(subject)));
            apart.fold(0.0, f64::max)
        };
        if worst(other) >= STRONG {
            return false;
        }
        mended += usize::from(worst(rate) >= STRONG);
    }
    mended >= FEWEST
}

/// A counted rate with kept and violated exchanged.
fn contrary(rate: Rate) -> Option<Rate> {
    match rate {
        Rate::Counted { count, trials } => Some(Rate::Counted {
            count: trials - count,
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
        if !is_table || !is_requirement || !has_columns_exchanged(self.evidence, piece, &margin) {
            return None;
        }
        let measure = &piece.finding(subject)?.measure;
        let exchanged = contrary(Rate::of(measure)?)?;
        let theirs = Rate::on(against, subject)?;
        let rest = strength(exchanged, theirs, self.margin(subject)).min(whole);
        let clue = Clue {
            inaccuracy: Inaccuracy::SystemModel,
            asset: self.table_and_words(piece, subject),
            subject: subject.clone(),
            score: whole - rest,
            title: format!("{} has passed and failed the wrong way round", piece.id),
            explanation: format!(
                "With passed and failed exchanged {} agrees with all other evidence on its requirements; of the conflict with \
                 {} on {} (Bayes factor 10^{whole:.1}) 10^{rest:.1} is left.",
                piece.id,
                against.id,
                name_of(subject)
            ),
            symptom: Symptom::RateDiffers {
                subject: subject.clone(),
                evidence: piece.id.clone(),
                value: measure.estimate()?,
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
        Some((clue, rest))
    }
}
