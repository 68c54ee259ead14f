//! Comparisons and conclusions: what the evidence amounts to.

use crate::{Interval, Subject};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The outcome of comparing two pieces of evidence on one subject.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// Equivalence within the margin is shown.
    Corroborates,
    /// A difference beyond chance, corrected for the number of comparisons.
    Conflicts,
    /// Neither is shown.
    Inconclusive,
    /// They do not speak of the same thing, or one of them of nothing.
    NotComparable,
}

/// Trials of one technique that would decide an inconclusive pair.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FurtherTrials {
    /// The evidence to which trials would be added.
    pub evidence: String,
    /// How many more; `None` if no number of trials of this side alone
    /// would decide.
    pub trials: Option<u64>,
}

/// Two pieces of evidence on one subject.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Comparison {
    /// The requirement or failure mode.
    pub subject: Subject,
    /// The earlier evidence.
    pub left: String,
    /// The later evidence.
    pub right: String,
    /// What the comparison shows.
    pub outcome: Outcome,
    /// `false` if one side was calibrated on the other, or both on the same
    /// counts, on this quantity: agreement is then a fit.
    pub independent: bool,
    /// Right minus left.
    pub difference: Option<f64>,
    /// Interval of the difference at the study's level.
    pub difference_interval: Option<Interval>,
    /// The declared margin.
    pub margin: f64,
    /// p-value of "no difference", uncorrected.
    pub p_difference: Option<f64>,
    /// The same after Holm's correction over the study.
    pub p_difference_corrected: Option<f64>,
    /// p-value of "differs by more than the margin" (two one-sided tests).
    pub p_equivalence: Option<f64>,
    /// Posterior probability that the difference is below the margin.
    pub probability_within_margin: Option<f64>,
    /// What would decide, for inconclusive pairs.
    pub further_trials: Vec<FurtherTrials>,
    /// The reason in one sentence.
    pub reason: String,
}

/// What the study concludes about a requirement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Evidence supports that it holds, and none says otherwise.
    Satisfied,
    /// Evidence shows that it does not hold.
    Violated,
    /// Evidence does not decide.
    Undecided,
    /// Pieces of evidence contradict each other.
    Conflicting,
    /// Nothing speaks about it.
    NotCovered,
}

/// The conclusion about one requirement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Conclusion {
    /// The requirement's identifier.
    pub requirement: String,
    /// The verdict.
    pub verdict: Verdict,
    /// In one or two sentences, with figures.
    pub statement: String,
    /// What all current techniques support together ("at least …"), at the
    /// study's confidence: that all rates are at least this.
    pub common_lower_bound: Option<f64>,
    /// The evidence on which it rests: the current one of each technique.
    pub rests_on: Vec<String>,
    /// Agreement that is independent, in words, one a line.
    pub independent_agreement: Vec<String>,
    /// Agreement that is only a fit, in words, one a line.
    pub fitted_agreement: Vec<String>,
}

/// The paper's three sources of disagreement (section 2.3).
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Inaccuracy {
    /// The solver or simulator.
    Tool,
    /// The property, the monitor or the vocabulary.
    RequirementModel,
    /// The formal model or the simulation.
    SystemModel,
    /// The evidence at hand does not separate the three.
    Undetermined,
}

/// Something that evidence does not cover.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CoverageGap {
    /// The requirement or failure mode.
    pub subject: Subject,
    /// The evidence that does not cover it; empty if none covers it.
    pub evidence: Vec<String>,
    /// Why, in one sentence.
    pub reason: String,
}
