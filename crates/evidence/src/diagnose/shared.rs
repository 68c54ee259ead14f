//! What a simulator's model and its tools share of a conflict.
//!
//! # Definition
//! A conflict of strength `T` speaks against the simulator's model with `p T`, `p` the probability that it is
//! the odd one out. If the same episodes come out otherwise with half the time step or in another engine, a
//! conflict of strength `T'` is left with the rate that they then have: the violations are scaled by
//! `after / before`. The part `p (T - T')` speaks against the tool, and `p T'` against the model.
//!
//! Half the step takes away but half of an error of first order. Where the halved step is itself strong evidence (at least
//! [`STRONG`]), the rate without any error of the step lies between `after` (an error of high order) and
//! `2 after - before` (one of first order), and `T'` is the least that is left for a rate in between: what no order of
//! the error explains.
//!
//! The same holds where one value of a requirement model, replaced, makes the two agree ([`Symptom::EditExplains`]): its
//! share of the conflict is taken from the system models of that pair, and from what they are read through.
//!
//! # Assumes
//! An error of the step is of first or higher order and multiplies violations. The probability of being the odd one out
//! does not depend on it.
//!
//! # Source and guarantee
//! The method of difference (J. S. Mill, 1843), as in [`super::rates`]; L. F. Richardson, "The approximate arithmetical
//! solution by finite differences" (1911), for the limit of small steps. A step whose effect is not beyond chance is
//! never extrapolated, so that what chance does to chaotic episodes is not doubled.

use super::matter::{Clue, Matter};
use super::strength::{Rate, STRONG, strength};
use super::suspect::{HALF_STEP, Symptom};
use crate::{Evidence, Inaccuracy, Subject};

/// Moves to the tools what of the system models' clues goes away with another step or engine.
pub(super) fn share_with_tools(matter: &Matter<'_>, clues: &mut [Clue]) {
    for tool in 0..clues.len() {
        let Some((evidence, scales)) = otherwise(&clues[tool]) else {
            continue;
        };
        let subject = clues[tool].subject.clone();
        for model in 0..clues.len() {
            if clues[model].inaccuracy != Inaccuracy::SystemModel || clues[model].subject != subject
            {
                continue;
            }
            let Some(left) = left(matter, &clues[model], &evidence, &scales) else {
                continue;
            };
            let gone = clues[model].score * (1.0 - left);
            clues[model].score -= gone;
            clues[tool].score = clues[tool].score.max(gone);
        }
    }
}

/// Takes from the system models, and from what runs are read through, what an edit of a requirement model explains; of several edits the one that takes most.
pub(super) fn share_with_edits(clues: &mut [Clue]) {
    let taken = |clue: &Clue| {
        let (evidence, others) = match &clue.symptom {
            Symptom::RateDiffers {
                evidence, others, ..
            } => (evidence, others),
            Symptom::MissingMode { shown, .. } => match clue.asset.evidence.first() {
                Some(model) => (model, shown),
                None => return 0.0,
            },
            _ => return 0.0,
        };
        let shares = clues.iter().filter_map(|edit| match &edit.symptom {
            Symptom::EditExplains { pairs, share, .. } if edit.subject == clue.subject => {
                let is_own = |pair: &[String; 2]| {
                    pair.contains(evidence) && others.iter().any(|(id, ..)| pair.contains(id))
                };
                pairs.iter().any(is_own).then_some(*share)
            }
            _ => None,
        });
        shares.fold(0.0, f64::max)
    };
    let taken: Vec<f64> = clues.iter().map(taken).collect();
    for (clue, taken) in clues.iter_mut().zip(taken) {
        clue.score *= 1.0 - taken;
    }
}

/// Places between the rates at half the step and without error of the step at which a conflict is looked at.
const PLACES: u32 = 16;

/// Whose episodes a clue says come out otherwise, and by which factors violations may change.
fn otherwise(clue: &Clue) -> Option<(String, Vec<f64>)> {
    let Symptom::RunsOtherwise {
        violated: [before, after],
        changed,
        ..
    } = &clue.symptom
    else {
        return None;
    };
    let evidence = clue.asset.evidence.first()?.clone();
    let (before, after) = (*before as f64, *after as f64);
    let places = match changed == HALF_STEP && clue.score >= STRONG {
        true => PLACES,
        false => 0,
    };
    let scale = |place: u32| {
        let more = (after - before) * f64::from(place) / f64::from(PLACES);
        ((after + more) / before).max(0.0)
    };
    (before > 0.0).then(|| (evidence, (0..=places).map(scale).collect()))
}

/// The share of a conflict that is left, at the least.
fn left(matter: &Matter<'_>, clue: &Clue, evidence: &str, scales: &[f64]) -> Option<f64> {
    let Symptom::RateDiffers {
        evidence: ours,
        others,
        ..
    } = &clue.symptom
    else {
        return None;
    };
    if ours != evidence {
        return None;
    }
    let (piece, other) = (matter.piece(ours)?, matter.piece(&others.first()?.0)?);
    let subject = &clue.subject;
    let margin = matter.margin(subject);
    let (own, theirs) = (rate(piece, subject)?, rate(other, subject)?);
    let whole = strength(own, theirs, margin);
    let rests = scales.iter().map(|scale| {
        let rate = scaled(own, subject, *scale);
        strength(rate, theirs, margin)
    });
    let rest = rests.fold(f64::INFINITY, f64::min);
    (whole > 0.0).then(|| (rest / whole).min(1.0))
}

fn rate(piece: &Evidence, subject: &Subject) -> Option<Rate> {
    Rate::on(piece, subject)
}

/// The rate with so many times the violations.
fn scaled(rate: Rate, subject: &Subject, scale: f64) -> Rate {
    let Rate::Counted {
        count,
        open,
        trials,
    } = rate
    else {
        return rate;
    };
    let [least, most] = [count, count + open].map(|count| {
        let count = match subject {
            Subject::FailureMode(_) => count * scale,
            Subject::Requirement(_) => trials - (trials - count) * scale,
        };
        count.clamp(0.0, trials)
    });
    Rate::Counted {
        count: least,
        open: most - least,
        trials,
    }
}
