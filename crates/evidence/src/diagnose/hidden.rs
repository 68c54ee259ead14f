//! Disagreement that no conflict of the findings shows.
//!
//! # Definition
//! A formal model and runs agree by property and monitor, but not by the property on both: what the
//! requirement models do hides what the system models do. It speaks against the formal model with the
//! strength `c(A, B)` (or `c(A, C)`), at most [`UNHARMFUL`], since no conflict hangs on it.
//!
//! # Assumes
//! Paths and runs are independent, and the property judges both alike.
//!
//! # Guarantee
//! None that it is the model: the requirement models may be what is wrong. What is named differs on paths and runs judged alike.

use super::matter::{Clue, Matter, name_of, system_model};
use super::strength::{Rate, STRONG, strength};
use super::suspect::{Cell, Figure, JudgedBy, Symptom};
use crate::{Evidence, Inaccuracy, Subject};

/// The most that a difference counts on which no conflict hangs.
const UNHARMFUL: f64 = 2.0;

impl Matter<'_> {
    /// Clues against system models that differ by the property on both, and do not conflict otherwise.
    pub(super) fn of_hidden_conflicts(&self) -> Vec<Clue> {
        let conflicts = self.conflicts();
        let mut clues = Vec::new();
        let formal: Vec<&Evidence> = self
            .speaking()
            .filter(|e| e.technique.is_of_model())
            .collect();
        for cell in self
            .cells
            .iter()
            .filter(|c| ['B', 'C'].contains(&c.cell) && c.trials > 0)
        {
            let Some(runs) = self.piece(&cell.evidence) else {
                continue;
            };
            let is_open = |model: &Evidence| {
                conflicts.iter().all(|c| {
                    c.subject != cell.subject
                        || ![&c.left, &c.right].contains(&&model.id)
                        || ![&c.left, &c.right].contains(&&runs.id)
                })
            };
            let models = formal
                .iter()
                .filter(|m| m.conditions == runs.conditions && is_open(m));
            clues.extend(models.filter_map(|model| self.of_hidden(model, runs, cell)));
        }
        clues
    }

    fn of_hidden(&self, model: &Evidence, runs: &Evidence, cell: &Cell) -> Option<Clue> {
        let subject = &cell.subject;
        let is_own =
            matches!(subject, Subject::Requirement(_)) && cell.judged_by == JudgedBy::Property;
        let value = model.finding(subject)?.measure.estimate()?;
        let margin = self.margin(subject);
        // Runs without a verdict are counted for agreement.
        let trials = cell.trials + cell.undecided;
        let nearest = (cell.share_near(value) * trials as f64).round() as u64;
        let count = nearest.clamp(cell.count, cell.count + cell.undecided);
        let left = strength(Rate::Computed(value), Rate::counted(count, trials), margin);
        (is_own && left >= STRONG).then(|| Clue {
            inaccuracy: Inaccuracy::SystemModel,
            asset: system_model(model),
            subject: subject.clone(),
            score: left.min(UNHARMFUL),
            title: format!("{} and {} differ by the property of {}", model.id, runs.id, name_of(subject)),
            explanation: format!(
                "By the property of {} {} computes {value:.4}, and {count} of {trials} runs of {} keep it \
                 (Bayes factor 10^{left:.1}); their findings do not conflict, since the monitor asks for something else.",
                name_of(subject), model.id, runs.id
            ),
            symptom: Symptom::RateDiffers {
                subject: subject.clone(),
                evidence: model.id.clone(),
                value,
                others: vec![(runs.id.clone(), count, trials)],
            },
            figures: vec![Figure {
                name: "hidden disagreement, log10 Bayes factor".into(),
                value: left,
                interval: None,
            }],
            witnesses: Vec::new(),
            ruled_out: vec!["the requirement model: it is the same property".into()],
            resolved_by: None,
        })
    }
}
