//! Proposals that make the same evidence agree: at most one of them is right, and the evidence does not say which.
//!
//! # Definition
//! A proposal *repairs* a pair of evidence on a subject if they disagree strongly before it and not after it ([`refinement::Trial`]), if a
//! single edit explains their conflict ([`Symptom::EditExplains`]), or if it is offered because they differ and cannot be computed
//! before it is made (an exchange, a form, a fit). Two proposals are *rivals* if they repair one pair on one subject and do no harm.
//!
//! # Guarantee
//! No proposal with a rival is offered without naming it. That a proposal without one is right is not shown.

use super::proposal::{Change, Offered, Proposal};
use evidence::{Subject, Suspect, Symptom};
use std::collections::BTreeSet;

/// A pair on a subject, its sides in the order of their names.
type Repaired = (Subject, [String; 2]);

fn repaired(subject: &Subject, one: &str, other: &str) -> Repaired {
    let mut pair = [one.to_owned(), other.to_owned()];
    pair.sort();
    (subject.clone(), pair)
}

/// What a proposal repairs.
fn repairs(proposal: &Proposal, suspects: &[Suspect]) -> BTreeSet<Repaired> {
    let mut all = suspects.iter();
    let suspect = all.find(|it| Some(it.rank) == proposal.suspect);
    match &proposal.change {
        Change::Model { entry, .. } => {
            let touched = proposal.tried.repairs.iter();
            touched
                .map(|it| repaired(&it.subject, entry, &it.evidence))
                .collect()
        }
        Change::Value { value, .. } => {
            let symptoms = suspect.iter().flat_map(|it| &it.symptoms);
            let own = symptoms.filter_map(|it| match it {
                Symptom::EditExplains {
                    subject,
                    found,
                    instead,
                    pairs,
                    ..
                } if (found, instead) == (&value.old, &value.new) => Some((subject, pairs)),
                _ => None,
            });
            own.flat_map(|(subject, pairs)| {
                let pairs = pairs.iter();
                pairs.map(move |[one, other]| repaired(subject, one, other))
            })
            .collect()
        }
        Change::Form(_) | Change::Text { .. } | Change::Whole { .. } | Change::Exchange { .. } => {
            let chosen = proposal.chosen.iter();
            chosen
                .map(|it| repaired(&it.subject, &it.entry, &it.from))
                .collect()
        }
        Change::Recalibrate(fit) => {
            let modes = fit.fit.iter();
            modes
                .map(|mode| repaired(&Subject::FailureMode(mode.clone()), &fit.entry, &fit.from))
                .collect()
        }
        Change::FitCommand(fit) => {
            BTreeSet::from([repaired(&fit.subject, &fit.entry, &fit.counts.evidence)])
        }
    }
}

/// Says of each proposal which others repair what it repairs.
pub(super) fn tell(offered: &mut Offered, suspects: &[Suspect]) {
    let all: Vec<(usize, bool, BTreeSet<Repaired>)> = offered
        .proposals
        .iter()
        .map(|it| (it.number, it.tried.is_harmful(), repairs(it, suspects)))
        .collect();
    for (proposal, (number, _, own)) in offered.proposals.iter_mut().zip(&all) {
        let others = all
            .iter()
            .filter(|(other, is_harmful, _)| other != number && !is_harmful);
        let common: Vec<(usize, &Repaired)> = others
            .filter_map(|(other, _, theirs)| Some((*other, own.intersection(theirs).next()?)))
            .collect();
        proposal.rivals = common.iter().map(|(other, _)| *other).collect();
        if let Some((_, (subject, [one, other]))) = common.first() {
            let numbers: Vec<String> = proposal.rivals.iter().map(usize::to_string).collect();
            let (they, make) = match numbers.len() {
                1 => ("Proposal", "makes"),
                _ => ("Proposals", "make"),
            };
            proposal.notes.push(format!(
                "{they} {} {make} {one} and {other} agree on {}, too: the evidence does not tell which is right.",
                numbers.join(", "),
                subject.in_words()
            ));
        }
    }
}
