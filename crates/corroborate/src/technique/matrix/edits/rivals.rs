//! What explains as an edit does, and is none: a number or a branch of a model, a gate of a tree, an exchange.
//!
//! # Definition
//! That of [`super`]: each is weighed by what goes away and what comes up with it, less what counts against it.
//!
//! # Assumes
//! As [`super`].
//!
//! # Guarantee
//! None but that the figures were computed: the most of all is what edits are held against.

use super::explained::balance;
use super::{Pairs, answers};
use crate::technique::matrix::Diagnosing;
use crate::technique::matrix::gates::OfTree;
use crate::technique::matrix::lines::{OfModel, OfModels};
use evidence::{Evidence, Subject, changed_places, put_right};

impl Diagnosing<'_> {
    /// What is explained, as by an edit, if one number of a formal model has another value, or a branch of it or a gate of a
    /// fault tree is another; the most of all these. What counts against each is its [`refinement::ModelChange::cost`].
    pub(super) fn numbers(&self, offered: &OfModels, before: &Pairs) -> Option<f64> {
        let weight = |model: &OfModel, then: &super::Values| {
            let mut after = self.result.evidence.clone();
            let piece = after.iter_mut().find(|it| it.id == model.evidence)?;
            for new in answers(Some(&model.before), then, &piece.findings) {
                let old = piece.findings.iter_mut();
                if let Some(old) = old.into_iter().find(|old| old.subject == new.subject) {
                    *old = new;
                }
            }
            let after = self.disagreements(&after);
            Some(balance(before, &after, &|_| true)?.weight())
        };
        let all = offered.models.iter();
        let of_models = all.flat_map(|model| {
            let answers = model.answers();
            answers.filter_map(move |(then, cost)| Some(weight(model, then)? - cost))
        });
        let of_trees = offered.trees.iter().filter_map(OfTree::weight);
        of_models.chain(of_trees).max_by(f64::total_cmp)
    }

    /// What is explained, as by an edit, if what a table has the wrong way round is exchanged, or two pieces that changed
    /// places are put back; the most of all.
    pub(super) fn exchange(&self, before: &Pairs) -> Option<f64> {
        let margin = |subject: &Subject| self.margin(subject);
        let all = &self.result.evidence;
        let weight = |piece: &Evidence| {
            let (exchanged, odds) = put_right(all, piece, &margin)?;
            let after: Vec<Evidence> = all
                .iter()
                .map(|it| match it.id == piece.id {
                    true => exchanged.clone(),
                    false => it.clone(),
                })
                .collect();
            let after = self.disagreements(&after);
            let balance = balance(before, &after, &|_| true)?;
            Some(balance.weight() + odds.map_or(0.0, |odds| odds.min(0.0)))
        };
        let moved = |piece: &Evidence| {
            let other = changed_places(all, piece, &margin)?;
            let of = |it: &Evidence| match &it.id {
                id if *id == piece.id => other.findings.clone(),
                id if *id == other.id => piece.findings.clone(),
                _ => it.findings.clone(),
            };
            let after: Vec<Evidence> = all
                .iter()
                .map(|it| Evidence {
                    findings: of(it),
                    ..it.clone()
                })
                .collect();
            Some(balance(before, &self.disagreements(&after), &|_| true)?.weight())
        };
        let found = all.iter().filter_map(|piece| {
            weight(piece)
                .into_iter()
                .chain(moved(piece))
                .max_by(f64::total_cmp)
        });
        found.max_by(f64::total_cmp)
    }
}
