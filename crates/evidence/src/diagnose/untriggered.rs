//! Pieces in which a requirement is never triggered, although it is triggered elsewhere.
//!
//! # Definition
//! A model *never triggers* a subject if it computes a probability of exactly 0 for its trigger, by a method whose bounds
//! hold; a simulator or recordings, if none of their runs does. Where another piece has it triggered in runs of the same
//! population ([`crate::TriggerComparison`], whose test shows a difference), the model lacks what leads there. The strength is that of
//! [`Rate::Never`] of a model, of the counted rate of others, against the other piece, the strongest of all such pieces. A model
//! of probability 0 is what is wrong; of runs that never do, half the strength counts, as the other piece may be what is wrong, and
//! the words that runs are read through are named with them.
//!
//! # Assumes
//! Both pieces are of one population of runs, as the comparison of their triggers asks. Trials are independent.
//!
//! # Source and guarantee
//! That something cannot happen is refuted by its happening. Nothing else would say so: with no run that triggers it, a
//! piece has no rate that could be compared.

use super::matter::{Clue, Matter, name_of};
use super::rates::figure;
use super::strength::{Rate, strength};
use super::suspect::Symptom;
use crate::{AskedBy, Evidence, Inaccuracy, Measure, Outcome, Subject};

/// The part of the disagreement that counts against runs, which may be right.
const OF_RUNS: f64 = 0.5;

impl Matter<'_> {
    /// Clues against pieces that never trigger what others trigger.
    pub(super) fn of_missing_triggers(&self) -> Vec<Clue> {
        let mut clues: Vec<Clue> = Vec::new();
        for piece in self.speaking() {
            for finding in &piece.findings {
                let never = match finding.trigger.as_deref() {
                    Some(Measure::Probability { answer, .. })
                        if answer.value == 0.0 && answer.guarantee.is_certain() =>
                    {
                        Some(Rate::Never)
                    }
                    Some(Measure::Counts {
                        count: 0, trials, ..
                    }) if *trials > 0 && is_judged(piece) => Some(Rate::counted(0, *trials)),
                    _ => None,
                };
                clues.extend(
                    never.and_then(|never| self.never_triggered(piece, never, &finding.subject)),
                );
            }
        }
        clues
    }

    fn never_triggered(&self, model: &Evidence, never: Rate, subject: &Subject) -> Option<Clue> {
        let margin = self.margin(subject);
        let triggers = self.comparisons.iter().filter_map(|pair| {
            let differs = pair.trigger.as_ref()?.outcome == Outcome::Conflicts;
            let other = match [&pair.left, &pair.right] {
                [one, other] if one == &model.id => other,
                [other, one] if one == &model.id => other,
                _ => return None,
            };
            let piece = self
                .piece(other)
                .filter(|_| differs && &pair.subject == subject)?;
            let (rate, words) = match piece.finding(subject)?.trigger.as_deref() {
                Some(Measure::Counts { count, trials, .. }) if *count > 0 => (
                    Rate::counted(*count, *trials),
                    format!("in {count} of {trials} runs of {}", piece.id),
                ),
                Some(Measure::Probability { answer, .. })
                    if answer.value > 0.0 && !model.technique.is_of_model() =>
                {
                    let words = format!("with probability {:.4} in {}", answer.value, piece.id);
                    (Rate::Computed(answer.value), words)
                }
                _ => return None,
            };
            Some((strength(never, rate, margin), piece, rate, words))
        });
        let mut shown: Vec<(f64, &Evidence, Rate, String)> = triggers.collect();
        shown.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (whole, most, ..) = shown.first()?;
        let words: Vec<&str> = shown.iter().map(|(.., words)| words.as_str()).collect();
        let elsewhere = words.join(", ");
        let mut asset = self.asset_of(model, subject);
        let (score, explanation) = match never {
            Rate::Counted { .. } => {
                asset.together.push("vocabulary.toml".to_owned());
                let words = format!(
                    "None of the runs of {} triggers it, which is triggered {elsewhere}: the runs do not lead there, or what they are \
                     read through does not show it.",
                    model.id
                );
                (OF_RUNS * whole, words)
            }
            Rate::Computed(_) | Rate::Never => {
                let words = format!(
                    "In {} it is triggered with probability 0, and {elsewhere}: the model lacks what leads there.",
                    model.id
                );
                (*whole, words)
            }
        };
        let runs = most
            .finding(subject)
            .map_or_else(Vec::new, |f| f.witnesses.clone());
        Some(Clue {
            inaccuracy: Inaccuracy::SystemModel,
            asset,
            subject: subject.clone(),
            score,
            title: format!("{} never triggers {}", model.id, name_of(subject)),
            explanation,
            symptom: Symptom::RateDiffers {
                subject: subject.clone(),
                evidence: model.id.clone(),
                value: 0.0,
                others: shown
                    .iter()
                    .map(|(_, piece, rate, _)| counts_of(piece, *rate))
                    .collect(),
            },
            figures: vec![figure(
                "against never being triggered, log10 Bayes factor",
                *whole,
            )],
            witnesses: self.witnesses(most, &runs, &format!("{} is triggered", name_of(subject))),
            ruled_out: Vec::new(),
            resolved_by: None,
        })
    }
}

/// Whether its runs are judged by monitors here.
fn is_judged(piece: &Evidence) -> bool {
    piece.technique.traits().asked_by == AskedBy::Monitor && !piece.published
}

/// A piece with the counts of its trigger; a computed value has none.
fn counts_of(piece: &Evidence, rate: Rate) -> (String, u64, u64) {
    match rate {
        Rate::Counted { count, trials, .. } => (piece.id.clone(), count as u64, trials as u64),
        Rate::Computed(_) | Rate::Never => (piece.id.clone(), 0, 0),
    }
}
