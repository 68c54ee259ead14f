//! What a conclusion leaves out, with the reason.
//!
//! # Definition
//! Every piece of the ledger with a finding on a requirement either takes part in its conclusion or is listed here, except
//! those that cannot express or never covered it, which are gaps of coverage. For trials of the system that the study marks
//! as intermediate, the verdict with them is found, too: they are not refined by what comes later, so leaving them out has
//! to be seen.

use super::judge::{Asked, Level};
use super::ladder::{self, Decided};
use super::{Piece, is_trial};
use crate::compare::Study;
use crate::{Evidence, Excluded, ExclusionReason, Measure, Standing, Subject};

/// The pieces that are left out, in the ledger's order.
pub(super) fn excluded(
    study: &Study<'_>,
    asked: &Asked<'_>,
    level: &Level,
    decided: Decided,
) -> Vec<Excluded> {
    let judged = asked.judge(level);
    let takes_part = |id: &str| {
        judged.iter().any(|it| {
            it.standing.evidence == id
                && it.decides
                && (!it.standing.elsewhere || it.standing.standing == Standing::Denies)
        })
    };
    let left_out = study.evidence.iter().enumerate();
    left_out
        .filter(|(_, piece)| !takes_part(&piece.id))
        .filter_map(|(index, piece)| {
            let reason = reason(study, asked, piece)?;
            let hidden = reason == ExclusionReason::Intermediate && is_trial(piece);
            let with_it = hidden.then(|| verdict_with(study, asked, level, index));
            Some(Excluded {
                words: words(&piece.id, &reason),
                evidence: piece.id.clone(),
                reason,
                verdict_with_it: with_it.filter(|other| *other != decided),
            })
        })
        .collect()
}

/// Why a piece does not take part; `None` if it has nothing to say of it.
fn reason(study: &Study<'_>, asked: &Asked<'_>, piece: &Evidence) -> Option<ExclusionReason> {
    let own = Subject::Requirement(asked.requirement.id.clone());
    let finding = piece
        .finding(&own)
        .or_else(|| piece.finding(&asked.quantity))?;
    let said = Piece::of(piece, asked.requirement, &asked.quantity);
    if said.is_none() {
        return match &finding.measure {
            Measure::Probability { .. } => {
                Some(ExclusionReason::NoNumber("its error is unknown".to_owned()))
            }
            _ => None,
        };
    }
    if asked.pieces.iter().any(|it| it.evidence.id == piece.id) {
        return Some(ExclusionReason::NotIndependent(dependence(
            study, asked, piece,
        )));
    }
    if piece.intermediate {
        return Some(ExclusionReason::Intermediate);
    }
    if let Some(by) = &piece.reproduced_by {
        return Some(ExclusionReason::Reproduced(by.clone()));
    }
    let here = asked.pieces.first().map(|it| &it.evidence.conditions);
    if here != Some(&piece.conditions) {
        return Some(ExclusionReason::OtherConditions(piece.conditions.clone()));
    }
    let mut later = asked.pieces.iter();
    let later = later.find(|it| it.evidence.technique == piece.technique)?;
    Some(ExclusionReason::Superseded(later.evidence.id.clone()))
}

/// On which trials that take part a piece of trials rests.
fn dependence(study: &Study<'_>, asked: &Asked<'_>, piece: &Evidence) -> String {
    let lineage = study.lineage();
    let pairs = asked.pieces.iter().zip(&asked.decides);
    let mut others = pairs.filter(|(it, decides)| **decides && is_trial(it.evidence));
    let found =
        others.find_map(|(it, _)| lineage.dependence(&it.evidence.id, &piece.id, &asked.quantity));
    found.unwrap_or_else(|| "it rests on other trials".to_owned())
}

/// The verdict if an intermediate piece took part, at the same share of the level.
fn verdict_with(study: &Study<'_>, asked: &Asked<'_>, level: &Level, index: usize) -> Decided {
    let mut evidence = study.evidence.to_vec();
    evidence[index].intermediate = false;
    let other = Study {
        evidence: &evidence,
        ..*study
    };
    let lineage = other.lineage();
    let with = Asked::on_other_evidence(&other, &lineage, asked);
    let level = level.shared_as(asked, &with);
    ladder::decide(&with.judge(&level), &with.conflicts())
}

fn words(id: &str, reason: &ExclusionReason) -> String {
    match reason {
        ExclusionReason::Intermediate => format!("{id} is marked as intermediate."),
        ExclusionReason::Superseded(by) => {
            format!("{id} is superseded by {by}, a later piece of the same technique.")
        }
        ExclusionReason::Reproduced(by) => format!("{id} is reproduced by {by}."),
        ExclusionReason::OtherConditions(conditions) => {
            format!(
                "{id} holds under other conditions ({conditions}) and does not refute it there."
            )
        }
        ExclusionReason::NotIndependent(why) => {
            format!("{id} does not decide beside the other trials: {why}.")
        }
        ExclusionReason::NoNumber(why) => format!("{id} has a number, but {why}."),
    }
}
