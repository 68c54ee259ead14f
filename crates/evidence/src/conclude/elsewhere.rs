//! What evidence under other conditions says against a requirement.
//!
//! # Definition
//! *Elsewhere* is, under each of the conditions other than those that most techniques share, the latest evidence of each
//! technique, and of experiments and operation all of it. A piece of it that denies the threshold, judged one-sidedly at the
//! same level as all independent pieces together, shows that the requirement does not hold: a requirement is asked under
//! every condition that the study declares. It never shows that a requirement holds, and no rates are compared with it.
//!
//! # Assumes
//! As in [`super`], under each of the conditions. Nothing of how pieces under several conditions depend on each other.
//!
//! # Guarantee
//! With the pieces elsewhere counted among those that the level is divided by, a requirement that holds under all conditions
//! is called violated with probability at most `alpha`, as in [`super`].

use super::{Piece, is_trial, stands_for_itself};
use crate::{Evidence, Requirement, Subject, Technique};
use std::collections::BTreeMap;

/// The pieces under other conditions than those of the current ones, in the ledger's order.
pub(super) fn elsewhere<'a>(
    evidence: &'a [Evidence],
    requirement: &Requirement,
    quantity: &Subject,
    current: &[Piece<'_>],
) -> Vec<Piece<'a>> {
    let Some(conditions) = current.first().map(|piece| &piece.evidence.conditions) else {
        return Vec::new();
    };
    let says = |piece: &Evidence| {
        stands_for_itself(piece)
            && &piece.conditions != conditions
            && Piece::of(piece, requirement, quantity).is_some()
    };
    let mut latest: BTreeMap<(&str, Technique), usize> = BTreeMap::new();
    for (index, piece) in evidence.iter().enumerate().filter(|(_, it)| says(it)) {
        latest.insert((&piece.conditions, piece.technique), index);
    }
    let wanted = |index: usize, piece: &Evidence| {
        says(piece) && (is_trial(piece) || latest.values().any(|it| *it == index))
    };
    let pieces = evidence.iter().enumerate();
    let pieces = pieces.filter(|(index, piece)| wanted(*index, piece));
    let found = pieces.filter_map(|(_, piece)| Piece::of(piece, requirement, quantity));
    found.collect()
}
