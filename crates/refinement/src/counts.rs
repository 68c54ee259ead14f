//! Whose counts an asset is set to.
//!
//! # Definition
//! What counted the real system (operation and experiments) comes before simulation; among equals what had more
//! opportunities, then what is later in the ledger. It must hold under the same conditions, count the subject, and not be a step on the way, published
//! evidence that other evidence of the study reproduces, or evidence that was itself set to the asset's.

use evidence::{Evidence, Measure, Subject, Technique, WitnessOf};
use schemars::JsonSchema;
use serde::Serialize;

/// Counts of a failure mode in one piece of evidence.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Counts {
    /// The evidence.
    pub evidence: String,
    /// How often it occurred.
    pub count: u64,
    /// Of how many opportunities.
    pub trials: u64,
}

impl Counts {
    /// What a piece of evidence counts of a subject.
    #[must_use]
    pub fn of(evidence: &[Evidence], id: &str, subject: &Subject) -> Option<Self> {
        let piece = evidence.iter().find(|piece| piece.id == id)?;
        counts(piece, subject)
    }

    /// The share.
    #[must_use]
    pub fn rate(&self) -> f64 {
        self.count as f64 / self.trials as f64
    }

    /// The share as an expression of the PRISM language.
    #[must_use]
    pub fn fraction(&self) -> String {
        format!("{}/{}", self.count, self.trials)
    }

    /// In words.
    #[must_use]
    pub fn words(&self) -> String {
        format!("{} of {} in {}", self.count, self.trials, self.evidence)
    }

    /// The exact binomial p-value of a rate, given these counts.
    #[must_use]
    pub fn p_value(&self, rate: f64) -> Option<f64> {
        let sample = stats::Sample::new(self.count, self.trials).ok()?;
        Some(stats::binomial_test_two_sided(sample, rate.clamp(0.0, 1.0)))
    }
}

/// All counts of a subject that the asset of `target` may be set to, best first.
#[must_use]
pub fn anchors(evidence: &[Evidence], target: &Evidence, subject: &Subject) -> Vec<Counts> {
    let mut found: Vec<(u8, u64, usize, Counts)> = Vec::new();
    for (place, piece) in evidence.iter().enumerate() {
        let is_usable = piece.conditions == target.conditions
            && piece.id != target.id
            && !piece.intermediate
            && piece.reproduced_by.is_none()
            && piece.calibrated.iter().all(|c| c.from != target.id);
        if let (true, Some(nearness), Some(counts)) =
            (is_usable, nearness(piece.technique), counts(piece, subject))
        {
            found.push((
                nearness,
                u64::MAX - counts.trials,
                usize::MAX - place,
                counts,
            ));
        }
    }
    found.sort_by_key(|(nearness, few, place, _)| (*nearness, *few, *place));
    found.into_iter().map(|(.., counts)| counts).collect()
}

/// How near to the real system a technique is; none for a model.
fn nearness(technique: Technique) -> Option<u8> {
    match technique.witness_of() {
        WitnessOf::System => Some(0),
        WitnessOf::Simulator => Some(1),
        WitnessOf::Model => None,
    }
}

fn counts(piece: &Evidence, subject: &Subject) -> Option<Counts> {
    match piece.finding(subject)?.measure {
        Measure::Counts { count, trials, .. } if trials > 0 => Some(Counts {
            evidence: piece.id.clone(),
            count,
            trials,
        }),
        _ => None,
    }
}
