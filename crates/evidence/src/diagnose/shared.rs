//! What a simulator's model and its tools share of a conflict.
//!
//! # Definition
//! A conflict of strength `T` speaks against the simulator's model with `p T`, `p` the probability that it is
//! the odd one out. If the same episodes come out otherwise with half the time step or in another engine, a
//! conflict of strength `T'` is left with the rate that they then have: the violations are scaled by
//! `after / before`. The part `p (T - T')` speaks against the tool, and `p T'` against the model.
//!
//! Source: the method of difference (J. S. Mill, 1843), as in [`super::rates`].

use super::matter::{Clue, Matter};
use super::strength::{Rate, strength};
use super::suspect::Symptom;
use crate::{Evidence, Inaccuracy, Subject};

/// Moves to the tools what of the system models' clues goes away with another step or engine.
pub(super) fn share_with_tools(matter: &Matter<'_>, clues: &mut [Clue]) {
    for tool in 0..clues.len() {
        let Some((evidence, scale)) = otherwise(&clues[tool]) else {
            continue;
        };
        let subject = clues[tool].subject.clone();
        for model in 0..clues.len() {
            if clues[model].inaccuracy != Inaccuracy::SystemModel || clues[model].subject != subject
            {
                continue;
            }
            let Some(left) = left(matter, &clues[model], &evidence, scale) else {
                continue;
            };
            let gone = clues[model].score * (1.0 - left);
            clues[model].score -= gone;
            clues[tool].score = clues[tool].score.max(gone);
        }
    }
}

/// Whose episodes a clue says come out otherwise, and by which factor violations change.
fn otherwise(clue: &Clue) -> Option<(String, f64)> {
    let Symptom::RunsOtherwise {
        violated: [before, after],
        ..
    } = clue.symptom
    else {
        return None;
    };
    let evidence = clue.asset.evidence.first()?.clone();
    (before > 0).then(|| (evidence, after as f64 / before as f64))
}

/// The share of a conflict that is left.
fn left(matter: &Matter<'_>, clue: &Clue, evidence: &str, scale: f64) -> Option<f64> {
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
    let theirs = rate(other, subject)?;
    let whole = strength(rate(piece, subject)?, theirs, margin);
    let rest = strength(
        scaled(rate(piece, subject)?, subject, scale),
        theirs,
        margin,
    );
    (whole > 0.0).then(|| (rest / whole).min(1.0))
}

fn rate(piece: &Evidence, subject: &Subject) -> Option<Rate> {
    Rate::of(&piece.finding(subject)?.measure)
}

/// The rate with so many times the violations.
fn scaled(rate: Rate, subject: &Subject, scale: f64) -> Rate {
    let Rate::Counted { count, trials } = rate else {
        return rate;
    };
    let count = match subject {
        Subject::FailureMode(_) => count * scale,
        Subject::Requirement(_) => trials - (trials - count) * scale,
    };
    Rate::Counted {
        count: count.clamp(0.0, trials),
        trials,
    }
}
