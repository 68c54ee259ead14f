//! The interval that the independent evidence on a requirement supports together.
//!
//! # Definition
//! Of the current evidence (see `conclude`) those pieces are combined that are independent, can be
//! counted, and do not conflict with one another: counts at their effective size, and
//! distributions of computed probabilities at the counts that would leave them. Each enters with a
//! declared weight from 0 to 1. A probability that is known exactly is not a count: it is held
//! against the interval, not combined.
//!
//! * The rates may be one (Cochran's Q has a p-value of at least [`SCATTER`]): a power prior, that
//!   is the beta posterior of all weighted counts, and its credible interval.
//! * They scatter: random effects, with Hartung and Knapp's interval of the mean rate. Weights are
//!   then not used, but for those of 0.
//! * Two pieces conflict: nothing is combined.
//!
//! The verdict of the interval against the threshold: *satisfied* when all of it meets the
//! threshold, *violated* when none of it does, *undecided* else.
//!
//! # Source
//! See `stats::combination`; the level of 0.1 for Q is customary, its power being low.
//!
//! # Guarantee
//! Where the true rates are one, the interval covers it at the study's level on average. It says
//! nothing of dependence that is not declared.

use super::stand::Standing;
use super::{Piece, among_current, current, independent, quantity, stand};
use crate::compare::{Belief, Lineage, Study};
use crate::{Comparison, Direction, Interval, Outcome, Requirement, Subject, Threshold, Verdict};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stats::{Confidence, EffectiveSample, StatsError};
use std::collections::BTreeMap;

/// The p-value of Cochran's Q below which rates count as scattered.
pub const SCATTER: f64 = 0.1;

/// How much each piece of evidence counts, from 0 (left out) to 1 (in full); 1 where not declared.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Weights {
    declared: BTreeMap<String, f64>,
}

impl Weights {
    /// The same with one piece's weight declared.
    ///
    /// # Errors
    /// [`StatsError::OutOfRange`] for a weight outside `[0, 1]`.
    pub fn declare(mut self, evidence: &str, weight: f64) -> Result<Self, StatsError> {
        if !(0.0..=1.0).contains(&weight) {
            return Err(StatsError::OutOfRange {
                what: "weight",
                value: weight,
                expected: "a number from 0 to 1",
            });
        }
        self.declared.insert(evidence.to_owned(), weight);
        Ok(self)
    }

    fn of(&self, evidence: &str) -> f64 {
        self.declared.get(evidence).copied().unwrap_or(1.0)
    }
}

/// How rates were combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// One common rate, counts weighted.
    PowerPrior,
    /// Rates that scatter about a mean.
    RandomEffects,
}

/// What the independent evidence on a requirement supports together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Combined {
    /// The requirement's identifier.
    pub requirement: String,
    /// The pieces that were combined, with their weights.
    pub pieces: BTreeMap<String, f64>,
    /// Pieces that were not, each with the reason.
    pub left_out: BTreeMap<String, String>,
    /// `true` if every pair of the combined pieces corroborates.
    pub corroborated: bool,
    /// How they were combined; `None` if nothing was.
    pub model: Option<Model>,
    /// The combined rate.
    pub rate: Option<f64>,
    /// Its interval at the study's level.
    pub interval: Option<Interval>,
    /// p-value of "one common rate", with two pieces or more.
    pub p_heterogeneity: Option<f64>,
    /// The verdict of the interval against the threshold.
    pub verdict: Verdict,
}

/// Combines the independent evidence on every requirement, in their order.
///
/// `comparisons` are those of [`crate::compare()`] on the same study.
pub fn combine(study: &Study<'_>, comparisons: &[Comparison], weights: &Weights) -> Vec<Combined> {
    let lineage = study.lineage();
    study
        .requirements
        .iter()
        .map(|requirement| combined(study, &lineage, requirement, comparisons, weights))
        .collect()
}

fn combined(
    study: &Study<'_>,
    lineage: &Lineage<'_>,
    requirement: &Requirement,
    comparisons: &[Comparison],
    weights: &Weights,
) -> Combined {
    let quantity = quantity(study.requirements, requirement);
    let pieces = current(study.evidence, requirement, &quantity);
    let among = among_current(comparisons, &quantity, &pieces);
    let mut result = blank(requirement, pieces.is_empty());
    let counts = chosen(&pieces, lineage, &quantity, weights, &mut result);
    let both = |c: &&&Comparison| {
        result.pieces.contains_key(&c.left) && result.pieces.contains_key(&c.right)
    };
    let inside: Vec<&Comparison> = among.iter().filter(both).copied().collect();
    if inside.iter().any(|c| c.outcome == Outcome::Conflicts) {
        result.verdict = Verdict::Conflicting;
        return result;
    }
    let all = |c: &&Comparison| c.outcome == Outcome::Corroborates;
    result.corroborated = !inside.is_empty() && inside.iter().all(all);
    estimate(&counts, study.levels.confidence, &mut result);
    if let Some(interval) = result.interval {
        result.verdict = verdict(interval, requirement.threshold);
    }
    result
}

/// Nothing combined yet.
fn blank(requirement: &Requirement, nothing: bool) -> Combined {
    Combined {
        requirement: requirement.id.clone(),
        pieces: BTreeMap::new(),
        left_out: BTreeMap::new(),
        corroborated: false,
        model: None,
        rate: None,
        interval: None,
        p_heterogeneity: None,
        verdict: if nothing {
            Verdict::NotCovered
        } else {
            Verdict::Undecided
        },
    }
}

/// The pieces that are combined; the others are noted with the reason.
fn chosen(
    pieces: &[Piece<'_>],
    lineage: &Lineage<'_>,
    quantity: &Subject,
    weights: &Weights,
    result: &mut Combined,
) -> Vec<(EffectiveSample, f64)> {
    let free = independent(pieces, lineage, quantity);
    let mut counts = Vec::new();
    for (index, piece) in pieces.iter().enumerate() {
        let id = piece.evidence.id.clone();
        let weight = weights.of(&id);
        let reason = match piece.belief.worth_in_counts() {
            _ if !free.contains(&index) => "rests on the counts of a piece that is combined",
            _ if weight <= 0.0 => "has a declared weight of 0",
            None if matches!(piece.belief, Belief::Known { .. }) => "is computed, not counted",
            None => "says less than one trial would",
            Some(sample) => {
                counts.push((sample, weight));
                result.pieces.insert(id, weight);
                continue;
            }
        };
        result.left_out.insert(id, reason.to_owned());
    }
    counts
}

/// Rate and interval of the combined counts.
fn estimate(counts: &[(EffectiveSample, f64)], confidence: Confidence, result: &mut Combined) {
    let samples: Vec<EffectiveSample> = counts.iter().map(|(sample, _)| *sample).collect();
    let found = stats::heterogeneity(&samples).ok();
    result.p_heterogeneity = found.map(|found| found.p_value);
    let scattered = found.filter(|found| found.p_value < SCATTER);
    let interval = match scattered {
        Some(found) => {
            result.model = Some(Model::RandomEffects);
            result.rate = Some(found.random.rate());
            stats::random_effects_interval(&samples, &found, confidence).ok()
        }
        None => stats::power_prior(counts).ok().map(|posterior| {
            result.model = Some(Model::PowerPrior);
            result.rate = Some(posterior.mean());
            posterior.credible_interval(confidence)
        }),
    };
    // Without a failure nothing speaks against 1, and without a success nothing against 0.
    let counted = |part: fn(&EffectiveSample) -> f64| {
        let weighted = counts.iter().filter(|(_, weight)| *weight > 0.0);
        weighted.into_iter().any(|(sample, _)| part(sample) > 0.0)
    };
    result.interval = interval.map(|interval| Interval {
        low: if counted(|sample| sample.successes) {
            interval.low
        } else {
            0.0
        },
        high: if counted(EffectiveSample::failures) {
            interval.high
        } else {
            1.0
        },
    });
}

/// Whether the whole interval, or none of it, meets the threshold.
fn verdict(interval: Interval, threshold: Option<Threshold>) -> Verdict {
    let threshold = threshold.unwrap_or(Threshold {
        direction: Direction::AtLeast,
        value: 1.0,
    });
    let bounds = stats::Interval {
        low: interval.low,
        high: interval.high,
    };
    match stand::of_bounds(&bounds, threshold) {
        Standing::Supports => Verdict::Satisfied,
        Standing::Denies => Verdict::Violated,
        Standing::Neither => Verdict::Undecided,
    }
}
