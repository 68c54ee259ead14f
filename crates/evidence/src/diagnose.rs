//! Diagnosis: for each disagreement, which asset is to blame.
//!
//! # Definition
//! Webster et al. (2020, section 2.3) name three sources of disagreement:
//! the system model, the requirement model and the tool. They are separated
//! by what differs while all else is the same:
//!
//! * *tool*: one model, one property, two methods. If an answer without a
//!   bound lies outside the bounds of another method, it is wrong by at least
//!   that distance.
//! * *requirement model*: one set of traces, two readings of the requirement.
//!   Every trace with two verdicts is a witness. If two pieces of evidence
//!   conflict under the main reading and not under the other, the reading
//!   explains the conflict.
//! * *system model*: a failure mode whose rates conflict, or that one asset
//!   cannot express although others show it.
//!
//! The conflicts on one subject are edges between pieces of evidence. They
//! are covered by as few pieces as a greedy search finds: the piece with most
//! conflicts is the odd one out, its conflicts are one discrepancy, and the
//! rest is searched again. Published evidence that other evidence reproduces
//! is spoken for by that evidence and takes part only against it.
//!
//! A conflict on a requirement that none of these explains is reported as
//! undetermined.
//!
//! # Guarantee
//! Every comparison with the outcome *conflicts* between evidence that takes
//! part is named in at least one discrepancy.

mod alone;
mod contrast;
mod forms;
mod hidden;
mod matter;
mod ranking;
mod rates;
mod reading;
mod shared;
mod strength;
mod suspect;
mod system;
mod tool;

pub use contrast::{SameTraces, contrasts};
pub use matter::{Clue, Matter, requirement_form, system_model};
pub use ranking::rank;
pub use strength::{CERTAIN, Rate, strength};
pub use suspect::{
    Cell, Contrast, Diagnosis, Figure, JudgedBy, Suspect, SuspectAsset, SuspectKind, Symptom,
    Traces, Witness,
};

use crate::{Comparison, Discrepancy, Evidence, Measure, Outcome, Subject};
use std::collections::BTreeMap;

/// Explains the disagreements of a study, tools first, then requirement
/// models, then system models.
///
/// `evidence` is in the ledger's order; `comparisons` are its pairs; `alpha`
/// is the level of the tests (0.05 for a confidence of 0.95).
pub fn diagnose(evidence: &[Evidence], comparisons: &[Comparison], alpha: f64) -> Vec<Discrepancy> {
    let ledger = Ledger {
        evidence,
        conflicts: conflicts(evidence, comparisons),
        alpha,
    };
    let mut found = tool::tool_inaccuracies(evidence);
    found.extend(ledger.requirement_inaccuracies());
    found.extend(ledger.missing_behaviour());
    found.extend(ledger.differing_rates());
    let conflicting = ledger.conflicting_requirements(&found);
    found.extend(conflicting);
    found
}

/// The conflicts between pieces that take part, by subject in their order.
fn conflicts<'a>(evidence: &'a [Evidence], comparisons: &'a [Comparison]) -> Vec<&'a Comparison> {
    let spoken_for = |id: &str, other: &str| {
        let piece = evidence.iter().find(|e| e.id == id);
        piece.is_some_and(|e| e.reproduced_by.as_deref().is_some_and(|ours| ours != other))
    };
    comparisons
        .iter()
        .filter(|c| c.outcome == Outcome::Conflicts)
        .filter(|c| !spoken_for(&c.left, &c.right) && !spoken_for(&c.right, &c.left))
        .collect()
}

/// One piece of evidence with all that it conflicts with on a subject.
struct OddOneOut<'a> {
    subject: &'a Subject,
    id: &'a str,
    others: Vec<&'a str>,
    conflicts: Vec<&'a Comparison>,
}

struct Ledger<'a> {
    evidence: &'a [Evidence],
    conflicts: Vec<&'a Comparison>,
    alpha: f64,
}

impl<'a> Ledger<'a> {
    fn piece(&self, id: &str) -> Option<&'a Evidence> {
        self.evidence.iter().find(|e| e.id == id)
    }

    fn place(&self, id: &str) -> usize {
        self.evidence
            .iter()
            .position(|e| e.id == id)
            .unwrap_or(usize::MAX)
    }

    /// Covers the wanted conflicts on each subject by odd ones out.
    fn odd_ones_out(&self, wanted: impl Fn(&Comparison) -> bool) -> Vec<OddOneOut<'a>> {
        let mut subjects: Vec<&Subject> = Vec::new();
        for conflict in self.conflicts.iter().filter(|c| wanted(c)) {
            if !subjects.contains(&&conflict.subject) {
                subjects.push(&conflict.subject);
            }
        }
        let mut found = Vec::new();
        for subject in subjects {
            let mut left: Vec<&'a Comparison> = self
                .conflicts
                .iter()
                .copied()
                .filter(|c| &c.subject == subject && wanted(c))
                .collect();
            while let Some(odd) = self.oddest(subject, &left) {
                left.retain(|c| c.left != odd.id && c.right != odd.id);
                found.push(odd);
            }
        }
        found
    }

    /// The piece with most conflicts; of equals the earlier in the ledger.
    fn oddest(&self, subject: &'a Subject, conflicts: &[&'a Comparison]) -> Option<OddOneOut<'a>> {
        let mut count: BTreeMap<&'a str, usize> = BTreeMap::new();
        for conflict in conflicts {
            *count.entry(&conflict.left).or_default() += 1;
            *count.entry(&conflict.right).or_default() += 1;
        }
        let (id, _) = count
            .into_iter()
            .min_by_key(|(id, count)| (usize::MAX - count, self.place(id)))?;
        let conflicts: Vec<&'a Comparison> = conflicts
            .iter()
            .copied()
            .filter(|c| c.left == id || c.right == id)
            .collect();
        let others = conflicts
            .iter()
            .map(|c| {
                if c.left == id {
                    c.right.as_str()
                } else {
                    c.left.as_str()
                }
            })
            .collect();
        Some(OddOneOut {
            subject,
            id,
            others,
            conflicts,
        })
    }

    /// Later evidence of the same technique that none of the others conflicts
    /// with.
    fn mended_by(&self, odd: &OddOneOut) -> Option<String> {
        let piece = self.piece(odd.id)?;
        let conflicting = |id: &str| {
            self.conflicts.iter().any(|c| {
                &c.subject == odd.subject
                    && odd.others.iter().any(|other| {
                        *other != id
                            && ((c.left == id && c.right == *other)
                                || (c.right == id && c.left == *other))
                    })
            })
        };
        self.evidence
            .iter()
            .skip(self.place(odd.id) + 1)
            .filter(|e| e.technique == piece.technique && !e.intermediate && !e.published)
            .filter(|e| {
                e.finding(odd.subject)
                    .is_some_and(|f| f.measure.estimate().is_some())
            })
            .find(|e| !conflicting(&e.id))
            .map(|e| e.id.clone())
    }

    fn rates(&self, odd: &OddOneOut) -> String {
        let rate = |id: &str| {
            let finding = self.piece(id).and_then(|e| e.finding(odd.subject));
            match finding.map(|f| &f.measure) {
                Some(Measure::Counts { count, trials, .. }) => {
                    format!("{count} of {trials} in {id}")
                }
                Some(Measure::Probability { answer, .. }) => format!("{:.4} in {id}", answer.value),
                _ => format!("nothing in {id}"),
            }
        };
        let others: Vec<String> = odd.others.iter().map(|id| rate(id)).collect();
        format!("{} against {}.", rate(odd.id), others.join(", "))
    }

    fn witnesses(&self, odd: &OddOneOut) -> Vec<String> {
        let finding = self.piece(odd.id).and_then(|e| e.finding(odd.subject));
        finding.map_or_else(Vec::new, |f| f.witnesses.clone())
    }
}

fn merge(into: &mut Discrepancy, other: Discrepancy) {
    into.explanation.push(' ');
    into.explanation.push_str(&other.explanation);
    let conflicting = other.evidence.len() > 1;
    for id in other.evidence {
        if !into.evidence.contains(&id) {
            into.evidence.push(id);
        }
    }
    into.witnesses.extend(other.witnesses);
    if conflicting {
        into.title = other.title;
    }
}

fn name_of(subject: &Subject) -> String {
    match subject {
        Subject::Requirement(id) => format!("requirement {id}"),
        Subject::FailureMode(id) => id.replace('_', " "),
    }
}

fn pieces(odd: &OddOneOut) -> Vec<String> {
    std::iter::once(odd.id)
        .chain(odd.others.iter().copied())
        .map(str::to_owned)
        .collect()
}

/// The reasons of the conflicts, each once.
fn reasons(odd: &OddOneOut) -> String {
    let mut reasons: Vec<&str> = Vec::new();
    for conflict in &odd.conflicts {
        let reason = conflict.reason.as_str();
        if !reasons.contains(&reason) {
            reasons.push(reason);
        }
    }
    match reasons.as_slice() {
        [] => String::new(),
        [only] => (*only).to_owned(),
        [first, _] => format!("{first} Likewise the other."),
        [first, rest @ ..] => format!("{first} Likewise the {} others.", rest.len()),
    }
}
