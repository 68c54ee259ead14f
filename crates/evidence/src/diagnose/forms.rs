//! Forms against their sentence: where a requirement is written as a sentence, that is what is meant, and a form
//! that judges the same runs otherwise is the one in doubt.
//!
//! # Definition
//! From the runs on which the monitor and the sentence differ (`Evidence::form_differences`), the counts under the
//! sentence are those of the monitor, less the runs that it took for kept or violated, plus those that the sentence
//! does. They stand beside the monitor's as another way of judging. A form that differs from the sentence on any run
//! is named; its score is how strongly the two rates on these runs differ. Of a form on which no finding rests (a
//! property on runs, a reading) it is how strongly the share of such runs differs from none, at most [`UNHARMFUL`].
//!
//! Runs on which neither is violated are not among the differences, so that runs covered by one of the two only and
//! kept are missed: the counts are then off by as many.
//!
//! # Assumes
//! The sentence is what is meant. Runs are independent.
//!
//! # Guarantee
//! What is named differs on runs that are given. The counts under the sentence are off by the runs that only one of the two covers.

use super::matter::{Clue, Matter, name_of, requirement_form};
use super::strength::{Rate, strength};
use super::suspect::Symptom;
use crate::{Evidence, FormDifference, Inaccuracy, Measure, RunVerdict, Subject};

/// The form that others are held against.
pub(super) const SENTENCE: &str = "sentence";

/// What differs from the sentence of a subject in a piece.
fn differences<'e>(
    piece: &'e Evidence,
    subject: &Subject,
) -> impl Iterator<Item = &'e FormDifference> {
    let subject = subject.clone();
    let all = piece.form_differences.iter();
    all.filter(move |d| d.reference == SENTENCE && d.subject == subject)
}

/// The rate of a piece under the sentence; `None` unless its monitor differs from that on some runs.
pub(super) fn under_sentence(piece: &Evidence, subject: &Subject) -> Option<Rate> {
    let Measure::Counts { count, trials, .. } = piece.finding(subject)?.measure else {
        return None;
    };
    let counts = |verdict: RunVerdict| match subject {
        Subject::Requirement(_) => verdict == RunVerdict::Satisfied,
        Subject::FailureMode(_) => verdict == RunVerdict::Violated,
    };
    let decides = |verdict| matches!(verdict, RunVerdict::Satisfied | RunVerdict::Violated);
    let (mut count, mut trials) = (count as f64, trials as f64);
    let mut differs = false;
    for difference in differences(piece, subject).filter(|d| d.form == "monitor") {
        differs = true;
        let runs = difference.count as f64;
        let (sentence, monitor) = (difference.reference_verdict, difference.verdict);
        let weight = |holds: bool| if holds { runs } else { 0.0 };
        count += weight(counts(sentence)) - weight(counts(monitor));
        trials += weight(decides(sentence)) - weight(decides(monitor));
    }
    (differs && trials > 0.0).then(|| Rate::Counted {
        count: count.clamp(0.0, trials),
        open: 0.0,
        trials,
    })
}

/// The most that a form counts on which no finding rests.
const UNHARMFUL: f64 = 1.0;

impl Matter<'_> {
    /// Whether a form of a subject judges some run otherwise than its sentence; `None` where nothing was held
    /// against a sentence.
    pub(super) fn differs_from_sentence(&self, subject: &Subject, form: &str) -> Option<bool> {
        let mut all = self
            .speaking()
            .flat_map(|piece| differences(piece, subject))
            .peekable();
        all.peek()?;
        Some(all.any(|difference| difference.form == form))
    }

    /// Clues against forms that differ from their sentence on some runs.
    pub(super) fn of_forms(&self) -> Vec<Clue> {
        let mut clues = Vec::new();
        for piece in self.speaking() {
            let is_first = |place: usize, found: &FormDifference| {
                let before = piece.form_differences.iter().take(place);
                before
                    .into_iter()
                    .all(|d| (&d.subject, &d.form) != (&found.subject, &found.form))
            };
            for (place, found) in piece.form_differences.iter().enumerate() {
                if found.reference == SENTENCE && is_first(place, found) {
                    clues.push(self.against_sentence(piece, found));
                }
            }
        }
        clues
    }

    fn against_sentence(&self, piece: &Evidence, found: &FormDifference) -> Clue {
        let subject = &found.subject;
        let alike: Vec<&FormDifference> = differences(piece, subject)
            .filter(|d| d.form == found.form)
            .collect();
        let differing: u64 = alike.iter().map(|d| d.count).sum();
        let own = Rate::on(piece, subject);
        let score = match (own, under_sentence(piece, subject)) {
            (Some(own), Some(meant)) if found.form == "monitor" => {
                strength(own, meant, self.margin(subject))
            }
            // No finding rests on it; still it is certain on each of these runs.
            _ => {
                let rate = Rate::counted(differing, found.runs);
                strength(Rate::Computed(0.0), rate, self.margin(subject)).min(UNHARMFUL)
            }
        };
        let runs: Vec<String> = alike.iter().flat_map(|d| d.witnesses.clone()).collect();
        let shows = format!(
            "the {} and the sentence of {} differ",
            found.form,
            name_of(subject)
        );
        Clue {
            inaccuracy: Inaccuracy::RequirementModel,
            asset: requirement_form(subject, &found.form, &[&piece.id]),
            subject: subject.clone(),
            score,
            title: format!(
                "the {} of {} says something else than its sentence",
                found.form,
                name_of(subject)
            ),
            explanation: format!(
                "On {differing} of {} runs of {} they do not agree on {}.",
                found.runs,
                piece.id,
                name_of(subject)
            ),
            symptom: Symptom::FormsDiffer {
                subject: subject.clone(),
                form: found.form.clone(),
                reference: SENTENCE.into(),
                evidence: piece.id.clone(),
                differing,
                runs: found.runs,
            },
            figures: Vec::new(),
            witnesses: self.witnesses(piece, &runs, &shows),
            ruled_out: Vec::new(),
            resolved_by: None,
        }
    }
}
