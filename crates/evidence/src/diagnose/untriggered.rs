//! Models in which a requirement is never triggered, although it is triggered elsewhere.
//!
//! # Definition
//! A model *never triggers* a subject if it computes a probability of exactly 0 for its trigger, by a method whose bounds
//! hold. Where another piece counts it triggered in runs of the same population ([`crate::TriggerComparison`], whose test
//! shows a difference), the model lacks what leads there. The strength is that of [`Rate::Never`] against the count, the
//! strongest of all such pieces.
//!
//! # Source and guarantee
//! That something cannot happen is refuted by its happening. Nothing else would say so: with no run that triggers it, a
//! model has no rate that could be compared.

use super::matter::{Clue, Matter, name_of};
use super::rates::figure;
use super::strength::{Rate, strength};
use super::suspect::Symptom;
use crate::{Evidence, Inaccuracy, Measure, Outcome, Subject};

impl Matter<'_> {
    /// Clues against models that never trigger what others trigger.
    pub(super) fn of_missing_triggers(&self) -> Vec<Clue> {
        let mut clues: Vec<Clue> = Vec::new();
        let models = self
            .speaking()
            .filter(|piece| piece.technique.is_of_model());
        for model in models {
            for finding in &model.findings {
                let is_never = matches!(
                    finding.trigger.as_deref(),
                    Some(Measure::Probability { answer, .. })
                        if answer.value == 0.0 && !answer.guarantee.is_estimated()
                );
                if is_never {
                    clues.extend(self.never_triggered(model, &finding.subject));
                }
            }
        }
        clues
    }

    fn never_triggered(&self, model: &Evidence, subject: &Subject) -> Option<Clue> {
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
            match piece.finding(subject)?.trigger.as_deref() {
                Some(Measure::Counts { count, trials, .. }) if *count > 0 => {
                    Some((piece, *count, *trials))
                }
                _ => None,
            }
        });
        let mut shown: Vec<(f64, &Evidence, u64, u64)> = triggers
            .map(|(piece, count, trials)| {
                let apart = strength(Rate::Never, Rate::counted(count, trials), margin);
                (apart, piece, count, trials)
            })
            .collect();
        shown.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (score, most, ..) = *shown.first()?;
        let words: Vec<String> = shown
            .iter()
            .map(|(_, piece, count, trials)| format!("{count} of {trials} runs of {}", piece.id))
            .collect();
        let runs = most
            .finding(subject)
            .map_or_else(Vec::new, |f| f.witnesses.clone());
        Some(Clue {
            inaccuracy: Inaccuracy::SystemModel,
            asset: self.asset_of(model, subject),
            subject: subject.clone(),
            score,
            title: format!("{} never triggers {}", model.id, name_of(subject)),
            explanation: format!(
                "In {} it is triggered with probability 0, and in {}: the model lacks what leads there.",
                model.id,
                words.join(", ")
            ),
            symptom: Symptom::RateDiffers {
                subject: subject.clone(),
                evidence: model.id.clone(),
                value: 0.0,
                others: shown
                    .iter()
                    .map(|(_, piece, count, trials)| (piece.id.clone(), *count, *trials))
                    .collect(),
            },
            figures: vec![figure(
                "against never being triggered, log10 Bayes factor",
                score,
            )],
            witnesses: self.witnesses(most, &runs, &format!("{} is triggered", name_of(subject))),
            ruled_out: Vec::new(),
            resolved_by: None,
        })
    }
}
