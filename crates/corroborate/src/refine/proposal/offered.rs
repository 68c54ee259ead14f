//! All that is offered for a study: in which order, and what of it waits for what.

use super::{Change, Proposal, is_of_structure};
use crate::refine::command::search;
use crate::refine::lineage::{chosen_for, note};
use crate::refine::rivals::tell;
use diagnostic::Problem;
use evidence::{StudyResult, Subject, Suspect, Symptom};
use host::Host;
use std::cmp::Reverse;
use study::Study;

/// The share of a conflict that an edit explains at the least for a model's number to wait for it.
const LEAST_SHARE: f64 = 0.05;

/// The share from which on an edit explains a conflict more likely than all else.
const LIKELY: f64 = 0.5;

/// What is offered, and what could not be.
#[derive(Clone, Debug, Default)]
pub struct Offered {
    /// Proposals.
    pub proposals: Vec<Proposal>,
    /// Disagreements for which there is none, with the reason.
    pub refused: Vec<String>,
}

impl Offered {
    pub(in crate::refine) fn add(&mut self, mut proposal: Proposal) {
        // Found in two ways, it is one change.
        let mut known = self.proposals.iter();
        let is_known = |it: &Proposal| it.file == proposal.file && it.diff == proposal.diff;
        if !proposal.diff.is_empty() && known.any(is_known) {
            return;
        }
        proposal.number = self.proposals.len() + 1;
        self.proposals.push(proposal);
    }

    /// Says what one offer means for another, by their numbers, and with what evidence agreement is a fit once it is made.
    pub(in crate::refine) fn finish(&mut self, result: &StudyResult) {
        let suspects = result.suspected();
        let touched: Vec<(u32, &[Subject])> = suspects
            .iter()
            .map(|it| (it.rank, it.subjects.as_slice()))
            .collect();
        self.await_exchanges(&touched);
        self.await_edits(suspects);
        self.await_branches();
        self.await_rows(suspects);
        self.choose(result);
        tell(self, suspects);
    }

    /// Searches for the numbers of commands' files that are offered, of those that are wanted; what has none is not offered.
    pub(in crate::refine) fn fit(
        &mut self,
        study: &Study,
        result: &StudyResult,
        is_wanted: &dyn Fn(&Proposal) -> bool,
        setting: &Host,
    ) -> Result<(), Problem> {
        let mut kept = Vec::new();
        for mut proposal in std::mem::take(&mut self.proposals) {
            if !is_wanted(&proposal) {
                kept.push(proposal);
                continue;
            }
            // Where nothing is suspected, a number that is fitted follows chance.
            if proposal.suspect.is_none() && matches!(proposal.change, Change::FitCommand(_)) {
                continue;
            }
            match search(study, result, &mut proposal, setting)? {
                Some(why) => self.refused.push(format!("{why}.")),
                None => kept.push(proposal),
            }
        }
        self.proposals = kept;
        self.in_order(result.suspected());
        Ok(())
    }

    /// Leaves open what is set to counts that may be those of something else: an exchange that explains a disagreement better than
    /// what a proposal is for has to be decided on first. `touched` are the ranks of suspects with what they touch.
    fn await_exchanges(&mut self, touched: &[(u32, &[Subject])]) {
        let exchanges = self.proposals.iter().filter(|it| it.is_exchange());
        let exchanges: Vec<(usize, u32, Vec<Subject>)> = exchanges
            .filter_map(|it| {
                let (_, subjects) = touched.iter().find(|of| Some(of.0) == it.suspect)?;
                Some((it.number, it.suspect?, subjects.to_vec()))
            })
            .collect();
        for proposal in self.proposals.iter_mut().filter(|it| !it.is_exchange()) {
            for (number, rank, subjects) in &exchanges {
                let is_better = proposal.suspect.is_none_or(|of| *rank < of);
                if is_better && proposal.touches(subjects) {
                    proposal.needs_decision = true;
                    proposal.notes.push(format!(
                        "Decide on {number} first: if two things have each other's counts, this sets a value to the wrong ones."
                    ));
                }
            }
        }
    }

    /// Leaves open what is for a subject of which one row of a table is suspected first, for what it has or for how much it counts: what is
    /// wrong in that row explains it, too.
    fn await_rows(&mut self, suspects: &[Suspect]) {
        let is_row = |it: &&Suspect| {
            let mut symptoms = it.symptoms.iter();
            it.is_open()
                && symptoms.any(|one| {
                    matches!(
                        one,
                        Symptom::RowDiffers { .. } | Symptom::MoreThanAttempts { .. }
                    )
                })
        };
        for row in suspects.iter().filter(is_row) {
            for proposal in &mut self.proposals {
                let mut all = suspects.iter();
                let own = all.find(|it| Some(it.rank) == proposal.suspect);
                let shares = own.is_some_and(|own| {
                    own.rank > row.rank && own.subjects.iter().any(|it| row.subjects.contains(it))
                });
                if shares {
                    proposal.needs_decision = true;
                    proposal.notes.push(format!(
                        "Decide on suspect {} first: {}, and if that row is wrong, what this changes is right as it is.",
                        row.rank, row.title
                    ));
                }
            }
        }
    }

    /// Says with what evidence agreement is a fit once a change is made.
    fn choose(&mut self, result: &StudyResult) {
        for proposal in &mut self.proposals {
            proposal.chosen = chosen_for(result, proposal);
            proposal.notes.extend(note(proposal));
        }
    }

    /// Leaves open what sets a model's number on a subject that an edit of another text explains, too: which of both is wrong
    /// the evidence does not say, and a right model must not be made to fit a wrong word.
    fn await_edits(&mut self, suspects: &[Suspect]) {
        for proposal in &mut self.proposals {
            let Change::Model { entry, change } = &proposal.change else {
                continue;
            };
            let subject = change.subject();
            let explains = |suspect: &&Suspect| {
                suspect.is_open()
                    && suspect.symptoms.iter().any(|symptom| match symptom {
                        Symptom::EditExplains {
                            subject: of,
                            pairs,
                            share,
                            ..
                        } => {
                            *of == subject
                                && *share >= LEAST_SHARE
                                && pairs.iter().any(|pair| pair.contains(entry))
                        }
                        _ => false,
                    })
            };
            if let Some(other) = suspects.iter().find(explains) {
                proposal.needs_decision = true;
                proposal.notes.push(format!(
                    "Decide on suspect {} first: {}, too, and then what this changes is right as it is.",
                    other.rank, other.title
                ));
            }
        }
    }

    /// Leaves open what sets a model's number on a subject that a branch put into or taken out of the same model moves, too: a number
    /// can be made to fit what a wrong or a lacking branch does.
    fn await_branches(&mut self) {
        let branches = self.proposals.iter().filter(|it| !it.tried.is_harmful());
        let branches: Vec<(usize, String, Vec<Subject>)> = branches
            .filter_map(|it| match &it.change {
                Change::Model { entry, change } if is_of_structure(change) => {
                    let moved = it.effects.iter().filter(|of| of.before != of.after);
                    let moved = moved.map(|of| of.subject.clone()).collect();
                    Some((it.number, entry.clone(), moved))
                }
                _ => None,
            })
            .collect();
        for proposal in &mut self.proposals {
            let Change::Model { entry, change } = &proposal.change else {
                continue;
            };
            let is_number = !is_of_structure(change);
            let rival = branches
                .iter()
                .find(|(_, of, subjects)| of == entry && subjects.contains(&change.subject()));
            if let (true, Some((number, ..))) = (is_number, rival) {
                proposal.needs_decision = true;
                proposal.notes.push(format!(
                    "Decide on {number} as well: it explains it, too, and then what this changes is right as it is."
                ));
            }
        }
    }

    /// Puts what does no harm before what does, and of these what is for the first suspects first; but a search for a number behind
    /// what explains, more likely than not, all that it is for with a value that is known, and what mends nothing behind what does.
    pub(in crate::refine) fn in_order(&mut self, suspects: &[Suspect]) {
        let offered: Vec<u32> = self.proposals.iter().filter_map(|it| it.suspect).collect();
        let edits = suspects
            .iter()
            .filter(|it| it.is_open() && offered.contains(&it.rank));
        let explained: Vec<&Subject> = edits
            .flat_map(|it| &it.symptoms)
            .filter_map(|symptom| match symptom {
                Symptom::EditExplains { subject, share, .. } if *share >= LIKELY => Some(subject),
                _ => None,
            })
            .collect();
        let is_late = |it: &Proposal| {
            let mut subjects = it
                .tried
                .repairs
                .iter()
                .map(|touch| &touch.subject)
                .peekable();
            let is_search = matches!(it.change, Change::FitCommand(_) | Change::Recalibrate(_));
            is_search && subjects.peek().is_some() && subjects.all(|it| explained.contains(&it))
        };
        let is_vain = |it: &Proposal| {
            matches!(it.change, Change::Model { .. }) && it.tried.repairs.is_empty()
        };
        // Of one model's changes for one suspect what repairs more comes first.
        let repaired = |it: &Proposal| match it.change {
            Change::Model { .. } => it.tried.repairs.len(),
            _ => usize::MAX,
        };
        self.proposals.sort_by_cached_key(|it| {
            let suspect = it.suspect.unwrap_or(u32::MAX);
            let is_behind = is_late(it) || is_vain(it);
            (
                it.tried.is_harmful(),
                is_behind,
                suspect,
                Reverse(repaired(it)),
            )
        });
        for (number, proposal) in (1..).zip(&mut self.proposals) {
            proposal.number = number;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::one_value::OneValue;
    use super::super::Effect;
    use super::*;
    use refinement::Trial;

    fn proposal(suspect: Option<u32>, change: Change, moves: &str) -> Proposal {
        Proposal {
            number: 0,
            suspect,
            title: String::new(),
            reason: String::new(),
            file: String::new(),
            also: Vec::new(),
            chosen: Vec::new(),
            rivals: Vec::new(),
            diff: String::new(),
            effects: vec![Effect {
                subject: Subject::FailureMode(moves.into()),
                before: Some(0.1),
                after: Some(0.2),
                counted: None,
                p_value: None,
            }],
            tried: Trial::default(),
            notes: Vec::new(),
            needs_decision: false,
            change,
        }
    }

    fn value() -> Change {
        Change::Value {
            file: "m.prism".into(),
            value: OneValue {
                line: 1,
                old: "0.1".into(),
                new: "0.2".into(),
            },
            fitted: None,
        }
    }

    #[test]
    fn what_moves_an_exchanged_subject_waits_for_the_exchange() {
        let subjects = ["slip", "miss"].map(|id| Subject::FailureMode(id.into()));
        let exchange = Change::Exchange { texts: Vec::new() };
        let mut offered = Offered::default();
        offered.add(proposal(None, value(), "slip"));
        offered.add(proposal(Some(1), exchange, "slip"));
        offered.add(proposal(None, value(), "another"));
        offered.add(proposal(Some(0), value(), "miss"));
        offered.in_order(&[]);
        offered.await_exchanges(&[(1, &subjects)]);
        let waits = |moves: &str| {
            let of = Subject::FailureMode(moves.into());
            let mut values = offered.proposals.iter().filter(|it| !it.is_exchange());
            values
                .find(|it| it.effects[0].subject == of)
                .map(|it| it.needs_decision)
        };
        assert_eq!(waits("slip"), Some(true));
        assert_eq!(waits("another"), Some(false));
        // What is suspected more than the exchange does not wait for it.
        assert_eq!(waits("miss"), Some(false));
    }
}
