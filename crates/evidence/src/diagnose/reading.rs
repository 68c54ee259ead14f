//! Requirement models to blame: one set of traces, two readings of the requirement.
//!
//! Every trace with two verdicts is a witness. If two pieces of evidence conflict under the main
//! reading and not under the other (by Fisher's exact test, or the exact binomial test against a
//! computed probability), the reading explains the conflict.

use super::{Ledger, merge};
use crate::compare::words::p_value;
use crate::{Comparison, Discrepancy, Evidence, Finding, Inaccuracy, Measure, Reading, Subject};
use std::collections::BTreeSet;

impl<'a> Ledger<'a> {
    pub(super) fn requirement_inaccuracies(&self) -> Vec<Discrepancy> {
        let mut merged: Vec<Discrepancy> = Vec::new();
        for piece in self.evidence.iter().filter(|e| !e.intermediate) {
            for finding in &piece.findings {
                for reading in finding.readings.iter().filter(|r| r.differing > 0) {
                    let one = self.requirement_inaccuracy(piece, finding, reading);
                    match merged
                        .iter_mut()
                        .find(|d| d.subjects == one.subjects && d.proposal == one.proposal)
                    {
                        Some(same) => merge(same, one),
                        None => merged.push(one),
                    }
                }
            }
        }
        merged.sort_by_key(|d| d.evidence.len() < 2);
        merged
    }

    fn requirement_inaccuracy(
        &self,
        piece: &Evidence,
        finding: &Finding,
        reading: &Reading,
    ) -> Discrepancy {
        let requirement = finding.subject.id();
        let mut explanation = format!(
            "On the same traces of {}, {}; the verdicts differ on {} runs.",
            piece.id,
            readings_in_words(finding, reading),
            reading.differing
        );
        let mut touched = BTreeSet::from([piece.id.clone()]);
        for other in self.in_conflict_with(&finding.subject, &piece.id) {
            if let Some((sentence, is_gone)) = self.explains(finding, reading, other) {
                explanation.push(' ');
                explanation.push_str(&sentence);
                if is_gone {
                    touched.insert(other.to_owned());
                }
            }
        }
        let meaning = reading.meaning.trim_end_matches('.');
        Discrepancy {
            inaccuracy: Inaccuracy::RequirementModel,
            title: if touched.len() > 1 {
                format!(
                    "Requirement {requirement} conflicts because of what its monitor reads; {}, it does not",
                    in_lower_case(meaning)
                )
            } else {
                format!("Requirement {requirement} has two readings with different verdicts")
            },
            explanation,
            subjects: vec![finding.subject.clone()],
            evidence: touched.into_iter().collect(),
            witnesses: reading
                .witnesses
                .iter()
                .map(|w| format!("{} {w}", piece.id))
                .collect(),
            resolved_by: None,
            proposal: Some(format!(
                "Decide which reading is meant. The reading `{}`: {meaning}.",
                reading.name
            )),
        }
    }

    /// Whether the other reading removes the conflict with `other`, in words
    /// and as a fact.
    fn explains(
        &self,
        finding: &Finding,
        reading: &Reading,
        other: &str,
    ) -> Option<(String, bool)> {
        let other_finding = self.piece(other)?.finding(&finding.subject)?;
        let ours = stats::Sample::new(reading.count, reading.trials).ok()?;
        let (theirs, p, test) = match &other_finding.measure {
            Measure::Counts { count, trials, .. } => {
                let sample = stats::Sample::new(*count, *trials).ok()?;
                let words = format!("{count} of {trials}");
                (
                    words,
                    stats::fisher_exact(ours, sample),
                    "Fisher's exact test",
                )
            }
            Measure::Probability { answer, .. } => {
                let p = stats::binomial_test_two_sided(ours, answer.value);
                (format!("{:.4}", answer.value), p, "exact binomial test")
            }
            _ => return None,
        };
        let is_gone = p >= self.alpha;
        let verdict = if is_gone {
            "the conflict is gone"
        } else {
            "they still differ"
        };
        let p = p_value(p);
        let sentence =
            format!("Against {other}'s {theirs}, {verdict} under that reading ({test}, p {p}).");
        Some((sentence, is_gone))
    }

    fn in_conflict_with(&self, subject: &Subject, id: &str) -> Vec<&'a str> {
        self.conflicts
            .iter()
            .filter(|c| &c.subject == subject)
            .filter_map(|c| match (c.left == id, c.right == id) {
                (true, _) => Some(c.right.as_str()),
                (_, true) => Some(c.left.as_str()),
                _ => None,
            })
            .collect()
    }

    /// Whether another reading of the requirement, on the traces of one side,
    /// removes the conflict with the other side.
    pub(super) fn is_explained_by_reading(&self, conflict: &Comparison) -> bool {
        let (left, right) = (&conflict.left, &conflict.right);
        [(left, right), (right, left)]
            .into_iter()
            .any(|(id, other)| {
                let finding = self.piece(id).and_then(|e| e.finding(&conflict.subject));
                finding.is_some_and(|finding| {
                    finding.readings.iter().any(|reading| {
                        self.explains(finding, reading, other)
                            .is_some_and(|(_, is_gone)| is_gone)
                    })
                })
            })
    }
}

fn readings_in_words(finding: &Finding, reading: &Reading) -> String {
    let main = match &finding.measure {
        Measure::Counts { count, trials, .. } => format!("{count} of {trials} runs pass"),
        _ => "no run is covered".to_owned(),
    };
    format!(
        "{main} as the monitor reads the requirement, and {} of {} under the reading `{}`",
        reading.count, reading.trials, reading.name
    )
}

/// A sentence as part of another.
fn in_lower_case(sentence: &str) -> String {
    let mut letters = sentence.chars();
    match letters.next() {
        Some(first) => first.to_lowercase().chain(letters).collect(),
        None => String::new(),
    }
}
