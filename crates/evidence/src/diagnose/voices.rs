//! Which pieces of evidence rest on a common assumption, and so have one voice against the others.
//!
//! # Definition
//! Two pieces share an assumption on a subject if
//! * a file that says how the system behaves, or a table, is among the assets of both (the same path or the same
//!   content);
//! * one was calibrated on the other on the subject, or both on the same counts of the subject;
//! * something of the one looks copied from the other ([`crate::LineageQuestion`]) and the ledger has not settled it;
//! * they are the same runs of one simulator ([`crate::SharedSeeds`]);
//! * rows of their tables repeat each other beyond chance, or most statements of their models ([`crate::CommonText`]).
//!
//! The *voice* of a piece is the set of pieces that are reached from it by such pairs. What was set to counts of the subject has the
//! voice of these on it, and no other: a model that was refined shares its text with the one before, and says on the subject what
//! was counted, so it does not join the one before to the counts.
//!
//! # Assumes
//! What pieces share shows in assets, calibrations, questions or tables, and pieces that share it with a third that speaks for
//! itself share it with each other.
//!
//! # Source and guarantee
//! Pieces that inherit one error are not independent witnesses (L. Bovens, S. Hartmann, "Bayesian Epistemology", 2003,
//! chapter 4). The relation is symmetric and the voices partition the pieces, so that each error is counted once. What
//! no asset, lineage or table shows is taken as independent.

use crate::{AssetRole, Evidence, Subject};

/// Whether two pieces share an assumption on a subject.
#[must_use]
pub fn share_assumption(one: &Evidence, other: &Evidence, subject: &Subject) -> bool {
    share_file(one, other)
        || share_counts(one, other, subject)
        || [(one, other), (other, one)]
            .into_iter()
            .any(|(a, b)| is_taken(a, b, subject))
}

fn share_file(one: &Evidence, other: &Evidence) -> bool {
    let speaks = |role: AssetRole| role != AssetRole::RequirementModel;
    let ours = one.assets.iter().filter(|a| speaks(a.role));
    ours.into_iter().any(|a| {
        let mut theirs = other.assets.iter().filter(|b| b.role == a.role);
        let is_same = |b: &crate::Asset| {
            let is_equal = !a.hash.is_empty() && a.hash == b.hash;
            a.path == b.path || is_equal && !one.may_equal_by_chance(other)
        };
        theirs.any(is_same)
    })
}

/// Whether two pieces have one voice on a subject, as far as these two say.
fn have_one_voice(one: &Evidence, other: &Evidence, subject: &Subject, all: &[&Evidence]) -> bool {
    let is_set = |piece: &Evidence| {
        let mut own = piece.calibrated.iter();
        own.any(|c| &c.subject == subject && all.iter().any(|it| it.id == c.from))
    };
    match is_set(one) || is_set(other) {
        true => {
            share_counts(one, other, subject)
                || is_calibrated(one, other, subject)
                || is_calibrated(other, one, subject)
        }
        false => share_assumption(one, other, subject),
    }
}

fn is_calibrated(copy: &Evidence, source: &Evidence, subject: &Subject) -> bool {
    let mut all = copy.calibrated.iter();
    all.any(|c| c.from == source.id && &c.subject == subject)
}

fn share_counts(one: &Evidence, other: &Evidence, subject: &Subject) -> bool {
    let of = |piece: &Evidence| -> Vec<String> {
        let all = piece.calibrated.iter().filter(|c| &c.subject == subject);
        all.map(|c| c.from.clone()).collect()
    };
    let theirs = of(other);
    of(one).iter().any(|from| theirs.contains(from))
}

/// Whether `copy` was set to `source` on the subject, or looks so.
fn is_taken(copy: &Evidence, source: &Evidence, subject: &Subject) -> bool {
    let asked = copy.lineage_questions.iter().any(|question| {
        let bears = question.subjects.is_empty() || question.subjects.contains(subject);
        question.with == source.id && bears && question.is_open()
    });
    is_calibrated(copy, source, subject)
        || asked
        || copy.shared_rows.iter().any(|rows| rows.with == source.id)
        || copy
            .shared_seeds
            .iter()
            .any(|it| it.with == source.id && it.same_runs)
        || copy.common_texts.iter().any(|text| text.with == source.id)
}

/// The voices of these pieces on a subject: each piece in one of them, in the order of the first.
#[must_use]
pub fn voices<'e>(pieces: &[&'e Evidence], subject: &Subject) -> Vec<Vec<&'e Evidence>> {
    let mut voices: Vec<Vec<&Evidence>> = Vec::new();
    for piece in pieces {
        let is_own = |voice: &Vec<&Evidence>| {
            let mut members = voice.iter();
            members.any(|member| have_one_voice(member, piece, subject, pieces))
        };
        let (own, rest): (Vec<_>, Vec<_>) = voices.into_iter().partition(is_own);
        voices = rest;
        let mut joined: Vec<&Evidence> = own.into_iter().flatten().collect();
        joined.push(piece);
        voices.push(joined);
    }
    let place = |piece: &Evidence| pieces.iter().position(|other| other.id == piece.id);
    voices.sort_by_key(|voice| voice.iter().filter_map(|piece| place(piece)).min());
    voices
}
