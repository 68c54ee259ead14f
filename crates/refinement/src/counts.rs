//! Whose counts an asset is set to.
//!
//! # Definition
//! What counted the real system (operation and experiments) comes before simulation; among equals what had more
//! opportunities, then what is later in the ledger. It must hold under the same conditions, count the subject, and not be a step on the way, published
//! evidence that other evidence of the study reproduces, or evidence that was itself set to the asset's.
//!
//! # Assumes
//! What counted the real system is nearer to it than a simulation. Trials that are alike say as much as independent ones of
//! their effective size.
//!
//! # Guarantee
//! Counts that rest on the asset itself are never taken, so that nothing is fitted to its own output. [`Counts::p_value`] is the
//! greatest over all that runs without a verdict may have shown.

use evidence::{Evidence, Measure, Subject, Technique, WitnessOf};
use schemars::JsonSchema;
use serde::Serialize;
use stats::{EffectiveSample, Sample, StatsError};

/// Counts of a failure mode in one piece of evidence.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Counts {
    /// The evidence.
    pub evidence: String,
    /// How often it occurred.
    pub count: u64,
    /// Of how many opportunities.
    pub trials: u64,
    /// All that it may be where runs reached no verdict, each with what it is worth in independent trials.
    #[serde(skip)]
    ends: Vec<(Sample, EffectiveSample)>,
    /// The ends of the interval of its rate.
    #[serde(skip)]
    interval: [f64; 2],
}

impl Counts {
    /// So many of independent trials.
    ///
    /// # Errors
    /// [`stats::StatsError`] for more than there are trials.
    pub fn of_independent(evidence: &str, count: u64, trials: u64) -> Result<Self, StatsError> {
        let sample = Sample::new(count, trials)?;
        let interval = stats::clopper_pearson(sample, stats::Confidence::P95);
        Ok(Self {
            evidence: evidence.to_owned(),
            count,
            trials,
            ends: vec![(sample, sample.into())],
            interval: [interval.low, interval.high],
        })
    }

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

    /// The ends of the interval with which the evidence shows its rate: of people or sessions where their trials are alike, at every look
    /// where trials may be added, and of all that runs without a verdict may have shown. Of independent trials Clopper and Pearson's.
    #[must_use]
    pub fn interval(&self) -> [f64; 2] {
        self.interval
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

    /// The exact binomial p-value of a rate, given these counts at their effective size; the greatest over all that runs
    /// without a verdict may have shown.
    ///
    /// ```
    /// let counts = refinement::Counts::of_independent("E3", 9, 10)?;
    /// assert!(counts.p_value(0.5).is_some_and(|p| (p - 0.0215).abs() < 1e-4));
    /// # Ok::<(), stats::StatsError>(())
    /// ```
    #[must_use]
    pub fn p_value(&self, rate: f64) -> Option<f64> {
        let whole =
            |(sample, worth): &(Sample, EffectiveSample)| stats::whole_counts(*sample, *worth);
        let p = |whole| stats::binomial_test_two_sided(whole, rate.clamp(0.0, 1.0));
        self.ends.iter().flat_map(whole).map(p).reduce(f64::max)
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
    let finding = piece.finding(subject)?;
    let Measure::Counts {
        count,
        trials,
        interval,
        ..
    } = finding.measure
    else {
        return None;
    };
    (trials > 0).then(|| Counts {
        evidence: piece.id.clone(),
        count,
        trials,
        ends: finding.may_be().filter_map(Measure::at_its_worth).collect(),
        interval: [interval.low, interval.high],
    })
}
