//! Proposals that make the same evidence agree: at most one of them is right, and the evidence does not say which.
//!
//! # Definition
//! A proposal *repairs* a pair of evidence on a subject if they disagree strongly before it and not after it ([`refinement::Trial`]), if a
//! single edit explains their conflict ([`Symptom::EditExplains`]), or if it is offered because they differ and cannot be computed
//! before it is made (an exchange, a form, a fit). Two proposals are *rivals* if they repair one pair on one subject and do no harm.
//! A proposal is *refuted* if it predicts a rate that the counts reject at [`REFUTED`]: beside one that is not, it is no rival but says so.
//!
//! # Guarantee
//! No proposal with a rival is offered without naming it. That a proposal without one is right is not shown.

use super::proposal::{Change, Effect, Offered, Proposal};
use evidence::{Subject, Suspect, Symptom};
use std::collections::BTreeSet;

/// The p-value below which counts reject a rate that a proposal predicts.
const REFUTED: f64 = 0.001;

/// What of the predictions of a proposal the counts reject.
fn refuted(proposal: &Proposal) -> Option<&Effect> {
    let mut effects = proposal.effects.iter();
    effects.find(|it| it.p_value.is_some_and(|p| p < REFUTED))
}

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
    let are_refuted: Vec<bool> = offered
        .proposals
        .iter()
        .map(|it| refuted(it).is_some())
        .collect();
    for (place, (number, _, own)) in all.iter().enumerate() {
        let proposal = &mut offered.proposals[place];
        let others = all
            .iter()
            .filter(|(other, is_harmful, _)| other != number && !is_harmful);
        let sound =
            all.iter()
                .zip(&are_refuted)
                .find(|((other, is_harmful, theirs), is_refuted)| {
                    other != number
                        && !is_harmful
                        && !**is_refuted
                        && own.intersection(theirs).next().is_some()
                });
        if let (Some(effect), Some(((sound, ..), _))) = (refuted(proposal), sound) {
            let note = format!(
                "Proposal {sound} explains the same, and predicts no rate that was not counted; with this one {} would not be what was \
                 counted.",
                effect.subject.in_words()
            );
            proposal.notes.push(note);
            continue;
        }
        let is_refuted = are_refuted[place];
        let others = others.filter(|(other, ..)| {
            let theirs = all.iter().position(|(number, ..)| number == other);
            theirs.is_some_and(|theirs| are_refuted[theirs] == is_refuted)
        });
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
