//! A table of requirements whose columns "passed" and "failed" were exchanged.
//!
//! # Definition
//! The columns of a piece were exchanged if at least [`FEWEST`] of its rates of requirements, or one against at least as many
//! other pieces, differ strongly (at least [`STRONG`], see [`mod@super::strength`]; the one by [`EXTREME`]) from other evidence
//! under the same conditions as they are, and if none of its rates of requirements does with kept and violated exchanged in
//! all of them. The exchange takes `T - T'` of a conflict,
//! `T'` being what is left with the other column.
//!
//! # Source and guarantee
//! One exchange in place of several wrong rates, as in [`super::names`]: each of the rates has to fit from the other side,
//! which wrong rates do beyond chance only where they are complements. One rate against one other piece is no sign: a wrong
//! model may be as far off by chance.

use super::matter::{Clue, Matter, name_of};
use super::rates::figure;
use super::strength::{Rate, STRONG, strength};
use super::suspect::Symptom;
use crate::{Evidence, Inaccuracy, Subject};

/// Rates that have to be on the wrong side, or other pieces on which side one of them is not.
const FEWEST: usize = 2;

/// Decades by which one rate has to differ from each of the others.
const EXTREME: f64 = 5.0;

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
        let (Subject::Requirement(_), Some(rate)) = (subject, Rate::of(finding)) else {
            continue;
        };
        let Some(other) = contrary(rate) else {
            return false;
        };
        let apart = |rate: Rate| {
            let others = evidence.iter().filter(|other| {
                other.id != piece.id && !other.intermediate && other.conditions == piece.conditions
            });
            let theirs = others.filter_map(|other| Rate::on(other, subject));
            let apart = theirs.map(|theirs| strength(theirs, rate, margin(subject)));
            apart.collect::<Vec<f64>>()
        };
        if apart(other).iter().any(|it| *it >= STRONG) {
            return false;
        }
        let now = apart(rate);
        let extreme = now.iter().filter(|it| **it >= EXTREME).count();
        mended += match (extreme == now.len(), now.iter().any(|it| *it >= STRONG)) {
            (true, true) => extreme.min(FEWEST),
            (_, is_apart) => usize::from(is_apart),
        };
    }
    mended >= FEWEST
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
        if !is_table || !is_requirement || !has_columns_exchanged(self.evidence, piece, &margin) {
            return None;
        }
        let finding = piece.finding(subject)?;
        let exchanged = contrary(Rate::of(finding)?)?;
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
        Some((clue, rest))
    }
}
