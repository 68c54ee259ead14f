//! Pieces in which a requirement is never triggered, although it is triggered elsewhere.
//!
//! # Definition
//! A model *never triggers* a subject if it computes a probability of exactly 0 for its trigger, by a method whose bounds
//! hold; a simulator or recordings, if none of their runs does. Where another piece has it triggered in runs of the same
//! population ([`crate::TriggerComparison`], whose test shows a difference), or counts any that do, however they were set up
//! ([`crate::Comparison::is_with_the_impossible`]), the model lacks what leads there. The same of a failure mode's opportunities. The strength is that of
//! [`Rate::Never`] of a model, of the counted rate of others, against the other piece, the strongest of all such pieces. A model
//! of probability 0 is what is wrong, or the words by which it is asked, which are named with it; of runs that never do, half the strength counts, as the other piece may be what is wrong, and
//! the words that runs are read through are named with them.
//!
//! # Assumes
//! Both pieces hold under the same conditions; where shares are compared, they are of one population of runs. Trials are independent.
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
            let shares = pair.trigger.as_ref();
            let differs = shares.is_some_and(|it| it.outcome == Outcome::Conflicts)
                || pair.is_with_the_impossible();
            let other = match [&pair.left, &pair.right] {
                [one, other] if one == &model.id => other,
                [other, one] if one == &model.id => other,
                _ => return None,
            };
            let piece = self
                .piece(other)
                .filter(|_| differs && &pair.subject == subject)?;
            let finding = piece.finding(subject)?;
            let (rate, words) = match finding.trigger.as_deref() {
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
                // How many runs there were is not known, and that there was one is enough.
                None => match finding.measure {
                    Measure::Counts { trials, .. } if trials > 0 => (
                        Rate::counted(trials, trials),
                        format!("{trials} times in {}", piece.id),
                    ),
                    _ => return None,
                },
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
        asset.together.push("vocabulary.toml".to_owned());
        let [does, is_done] = match subject {
            Subject::Requirement(_) => ["triggers it", "which is triggered"],
            Subject::FailureMode(_) => [
                "gives it an opportunity",
                "of which there are opportunities",
            ],
        };
        let (score, explanation) = match never {
            Rate::Counted { .. } => {
                let words = format!(
                    "None of the runs of {} {does}, {is_done} {elsewhere}: the runs do not lead there, or what they are \
                     read through does not show it.",
                    model.id
                );
                (OF_RUNS * whole, words)
            }
            Rate::Computed(_) | Rate::Never => {
                let words = format!(
                    "In {} no run {does}, for certain, {is_done} {elsewhere}: the model lacks what leads there, or the words by \
                     which it is asked mean something else.",
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
            title: match subject {
                Subject::Requirement(_) => {
                    format!("{} never triggers {}", model.id, name_of(subject))
                }
                Subject::FailureMode(_) => format!(
                    "{} never gives {} an opportunity",
                    model.id,
                    name_of(subject)
                ),
            },
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
            witnesses: self.witnesses(
                most,
                &runs,
                &match subject {
                    Subject::Requirement(_) => format!("{} is triggered", name_of(subject)),
                    Subject::FailureMode(_) => format!("{} has an opportunity", name_of(subject)),
                },
            ),
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
