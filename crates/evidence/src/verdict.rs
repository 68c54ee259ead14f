//! Comparisons and conclusions: what the evidence amounts to.

use crate::{Interval, Looking, Relation, Step, Subject};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The outcome of comparing two pieces of evidence on one subject.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// Equivalence within the margin is shown.
    Corroborates,
    /// A difference beyond chance, corrected for the number of comparisons, whose estimate is the margin or more.
    Conflicts,
    /// Neither is shown, or a difference whose estimate lies within the margin.
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

/// In what share of all runs two pieces of evidence trigger a subject: a quantity of its own. It decides nothing about
/// the requirement, since trials are often arranged so that the trigger comes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TriggerComparison {
    /// What the comparison shows, uncorrected.
    pub outcome: Outcome,
    /// Right minus left.
    pub difference: f64,
    /// Interval of the difference at the study's level.
    pub difference_interval: Interval,
    /// p-value of "no difference", uncorrected.
    pub p_difference: f64,
    /// In one sentence, with both shares.
    pub reason: String,
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
    /// What the comparison shows; inconclusive, whatever `relation` says, where a side is of one person, session or other cluster alone.
    /// A conflict without a difference is one with what a model computes to be impossible.
    pub outcome: Outcome,
    /// What the tests and the estimate show together, of which the outcome follows; `null` where they are not
    /// comparable.
    #[serde(default)]
    pub relation: Option<Relation>,
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
    /// The same, corrected for all comparisons of the study by closed testing.
    pub p_difference_corrected: Option<f64>,
    /// p-value of "differs by more than the margin" (two one-sided tests).
    pub p_equivalence: Option<f64>,
    /// Posterior probability that the difference is below the margin.
    pub probability_within_margin: Option<f64>,
    /// Whether a side looks copied from the other, and no line of the ledger says whether it is: agreement is then
    /// no corroboration.
    #[serde(default)]
    pub possibly_copied: bool,
    /// Whether the runs of both sides are paired: other simulators with the same seeds. Their difference is one of the
    /// simulators, and their agreement is on the same draws.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub paired: bool,
    /// Up to which intraclass correlation the outcome holds, where counts enter of which it is not known whose they are.
    #[serde(default)]
    pub clustering: Option<ClusterSensitivity>,
    /// How often both sides trigger the subject, where both know it.
    #[serde(default)]
    pub trigger: Option<TriggerComparison>,
    /// Why these shares are not compared, where both sides know theirs and they are not known to be of the same population of
    /// runs; `None` elsewhere.
    #[serde(default)]
    pub trigger_not_compared: Option<String>,
    /// The number of this look at the pair and what it costs; `None` where no trials can be added.
    #[serde(default)]
    pub looking: Option<Looking>,
    /// What would decide, for inconclusive pairs.
    pub further_trials: Vec<FurtherTrials>,
    /// The reason in one sentence.
    pub reason: String,
}

impl Comparison {
    /// Whether one side counts runs of which the other computes for certain that there are none: of what [`crate::compare()`] finds, a conflict
    /// without a difference.
    #[must_use]
    pub fn is_with_the_impossible(&self) -> bool {
        self.outcome == Outcome::Conflicts && self.difference.is_none()
    }

    /// Which pieces conflict, and why: of one that conflicts.
    #[must_use]
    pub fn conflict_in_words(&self) -> String {
        format!("{} and {} conflict. {}", self.left, self.right, self.reason)
    }
}

/// What a monitor says of one run.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum RunVerdict {
    /// Its precondition was never met.
    NotCovered,
    /// All that was asked held. Of a failure mode: it did not occur.
    Satisfied,
    /// Something that was asked did not hold. Of a failure mode: it occurred.
    Violated,
    /// The run does not tell.
    Inconclusive,
}

impl RunVerdict {
    /// As it is written in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotCovered => "not-covered",
            Self::Satisfied => "satisfied",
            Self::Violated => "violated",
            Self::Inconclusive => "inconclusive",
        }
    }

    /// In words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::NotCovered => "not covered",
            Self::Satisfied | Self::Violated | Self::Inconclusive => self.name(),
        }
    }
}

impl std::fmt::Display for RunVerdict {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}

/// What the study concludes about a requirement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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
    /// No evidence covers it.
    #[default]
    NotCovered,
}

/// What would follow for a decision if trials that are counted as independent were alike within groups (people,
/// sessions): the intraclass correlation at which it changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ClusterSensitivity {
    /// The evidence whose counts do not tell who did what.
    pub evidence: Vec<String>,
    /// Trials in each group.
    pub group_size: f64,
    /// Whether the number of trials in each group is an assumption, and not known from the tables.
    pub is_assumed: bool,
    /// The largest of the intraclass correlations at which it was drawn again below the first at which it is another, 0 if
    /// that is the first of all; `None` if it holds up to 1.
    pub holds_up_to: Option<f64>,
    /// The same in one sentence.
    pub statement: String,
}

impl Verdict {
    /// In words: `satisfied`, `violated`, `undecided`, `conflicting evidence`, `not covered`.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Verdict::Satisfied => "satisfied",
            Verdict::Violated => "violated",
            Verdict::Undecided => "undecided",
            Verdict::Conflicting => "conflicting evidence",
            Verdict::NotCovered => "not covered",
        }
    }
}

/// How one piece of evidence stands to a threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Standing {
    /// It shows that the threshold is met.
    Supports,
    /// It shows that the threshold is not met.
    Denies,
    /// It shows neither.
    Neither,
}

/// One piece of evidence against the threshold of a requirement, with the figures that decide.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PieceStanding {
    /// The evidence.
    pub evidence: String,
    /// The step on which it stands.
    pub step: Step,
    /// What it shows.
    pub standing: Standing,
    /// p-value against "the threshold is not met" (posterior probability of it, for a computed distribution).
    pub p_not_met: f64,
    /// p-value against "the threshold is met".
    pub p_met: f64,
    /// The largest `p_not_met` that shows the threshold to be met: the level, divided among what is judged.
    pub level_met: f64,
    /// The largest `p_met` that shows it to be missed.
    pub level_missed: f64,
    /// The one-sided limits of the rate at these levels: the threshold is shown to be met or missed exactly where it
    /// lies beyond one of them.
    pub limits: Interval,
    /// `true` where it is held under other conditions than those of the conclusion.
    pub elsewhere: bool,
    /// Over which runs its figure is taken, and how often these come.
    #[serde(default)]
    pub condition: String,
    /// The same in words, with figures.
    pub words: String,
}

/// Why a piece of evidence does not take part in a conclusion.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "kind", content = "of")]
pub enum ExclusionReason {
    /// The study marks it as a step on the way.
    Intermediate,
    /// A later piece of the same technique takes its place: its identifier.
    Superseded(String),
    /// The study names the piece that reproduces it.
    Reproduced(String),
    /// It holds under other conditions: these.
    OtherConditions(String),
    /// It rests on the counts of a piece that takes part: the reason.
    NotIndependent(String),
    /// All its trials are of one person or session, and nothing says that this one stands for all.
    OneSubject,
    /// It has a number on the requirement that cannot be judged: the reason.
    NoNumber(String),
    /// It cannot express the requirement: what is missing.
    NotExpressible(String),
    /// It could have covered the requirement and never did: why, as far as known.
    NotCovered(String),
    /// It is judged, but on a step below the one that the requirement needs, and does not carry over to it: the reason.
    BelowNeededStep(String),
}

impl ExclusionReason {
    /// Whether the piece says nothing of the requirement, so that nothing could be drawn from it.
    #[must_use]
    pub fn is_silence(&self) -> bool {
        matches!(self, Self::NotExpressible(_) | Self::NotCovered(_))
    }

    /// Whether other evidence takes the place of the piece, or it speaks of other conditions.
    #[must_use]
    pub fn lays_aside(&self) -> bool {
        match self {
            Self::Intermediate
            | Self::Superseded(_)
            | Self::Reproduced(_)
            | Self::OtherConditions(_) => true,
            Self::NotIndependent(_)
            | Self::OneSubject
            | Self::NoNumber(_)
            | Self::NotExpressible(_)
            | Self::NotCovered(_)
            | Self::BelowNeededStep(_) => false,
        }
    }
}

/// Trials of a piece of evidence that count neither way.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ExcludedTrials {
    /// The evidence.
    pub evidence: String,
    /// How many.
    pub trials: u64,
    /// The same in a sentence, with the reason.
    pub words: String,
}

/// A piece of evidence that does not take part in a conclusion, or not on the step that the requirement needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Excluded {
    /// The evidence.
    pub evidence: String,
    /// Why.
    pub reason: ExclusionReason,
    /// The verdict and its step if it took part, where they would be others.
    pub verdict_with_it: Option<(Verdict, Option<Step>)>,
    /// The same in a sentence.
    pub words: String,
}

/// For what the error rate of a verdict holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorFamily {
    /// For the whole study: a false "violated" of any requirement at most at the level, and so a false "satisfied".
    #[default]
    Study,
    /// For each requirement by itself.
    Requirement,
}

/// The error rate of a verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ErrorRate {
    /// The probability of a false "satisfied", and of a false "violated", at most.
    pub level: f64,
    /// For what it holds.
    pub holds_for: ErrorFamily,
    /// How many quantities share the level where it holds for the study.
    pub quantities: usize,
}

/// The conclusion about one requirement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Conclusion {
    /// The requirement's identifier.
    pub requirement: String,
    /// The verdict.
    pub verdict: Verdict,
    /// Of what it speaks; `None` where nothing is decided.
    #[serde(default)]
    pub step: Option<Step>,
    /// The lowest step on which the requirement's "satisfied" is enough.
    #[serde(default)]
    pub needs: Step,
    /// How each piece stands to the threshold.
    #[serde(default)]
    pub standings: Vec<PieceStanding>,
    /// What was left out, with the reason.
    #[serde(default)]
    pub excluded: Vec<Excluded>,
    /// Trials that count neither way, by piece.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub excluded_trials: Vec<ExcludedTrials>,
    /// The error rate of the verdict.
    #[serde(default)]
    pub error_rate: ErrorRate,
    /// In one or two sentences, with figures.
    pub statement: String,
    /// What all current pieces support together ("at least …"), at the
    /// study's confidence: that all rates are at least this. `null` where they are not all over the same runs.
    pub common_lower_bound: Option<f64>,
    /// The evidence on which it rests: the current one of each technique.
    pub rests_on: Vec<String>,
    /// Agreement that is independent, in words, one a line.
    pub independent_agreement: Vec<String>,
    /// Agreement that is only a fit, in words, one a line.
    pub fitted_agreement: Vec<String>,
    /// Up to which intraclass correlation the verdict holds, for counts of which it is not known whose they are.
    #[serde(default)]
    pub clustering: Vec<ClusterSensitivity>,
    /// For each piece to which trials can be added, the number of this look at it and what it costs.
    #[serde(default)]
    pub looking: Vec<Looking>,
}

impl Conclusion {
    /// Whether the requirement is satisfied on a step that is enough for it.
    #[must_use]
    pub fn is_enough(&self) -> bool {
        self.verdict == Verdict::Satisfied && self.step >= Some(self.needs)
    }

    /// Over which runs the figures of its pieces are taken, each piece once, in the order of the pieces.
    #[must_use]
    pub fn conditions(&self) -> Vec<(&str, &str)> {
        let mut all: Vec<(&str, &str)> = Vec::new();
        for it in self.standings.iter().filter(|it| !it.condition.is_empty()) {
            if !all.iter().any(|(id, _)| *id == it.evidence) {
                all.push((&it.evidence, &it.condition));
            }
        }
        all
    }

    /// What was left out, pieces and trials, each in a sentence.
    pub fn left_out(&self) -> impl Iterator<Item = &str> {
        let pieces = self.excluded.iter().map(|it| it.words.as_str());
        pieces.chain(self.excluded_trials.iter().map(|it| it.words.as_str()))
    }

    /// Whether further evidence is needed: undecided, or satisfied on a step that is not enough.
    #[must_use]
    pub fn is_open(&self) -> bool {
        match self.verdict {
            Verdict::Undecided => true,
            Verdict::Satisfied => !self.is_enough(),
            _ => false,
        }
    }
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
