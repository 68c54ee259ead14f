//! For the undecided: the cheapest further trials that would decide, technique by technique.
//!
//! # Definition
//! See `decide`: a plan has the wanted chance of a decision, given what is known now. Plans are
//! made for each side alone and for both, at the declared cost of one trial of each; a trial is one
//! that covers the subject (an opportunity of a failure mode, a run to which a requirement
//! applies). The cheapest plan of all is the first.

use super::decide::{Plan, Planning};
use super::{Belief, Study, pair::Pair};
use crate::{Comparison, Cost, Evidence, Measure, Outcome, Subject};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What one further trial of each piece of evidence costs, all in one unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrialCosts {
    /// The unit, for example `trials`, `s` or `EUR`.
    pub unit: String,
    /// Cost of a trial by the evidence's identifier; 1 where none is given.
    pub per_trial: BTreeMap<String, f64>,
    /// `true` if the study declares them; else every trial counts the same.
    #[serde(default)]
    pub declared: bool,
}

impl Default for TrialCosts {
    fn default() -> Self {
        Self::equal()
    }
}

impl TrialCosts {
    /// All trials cost the same: the fewest are the cheapest.
    #[must_use]
    pub fn equal() -> Self {
        Self {
            unit: "trials".to_owned(),
            per_trial: BTreeMap::new(),
            declared: false,
        }
    }

    /// Seconds for a trial as measured: elapsed time over the most trials of any finding. Evidence
    /// without both is left out, and then costs 1 second unless it is declared.
    #[must_use]
    pub fn measured(evidence: &[Evidence], costs: &[Cost]) -> Self {
        let seconds = |piece: &Evidence| {
            let cost = costs.iter().find(|cost| cost.evidence == piece.id)?;
            let trials = piece
                .findings
                .iter()
                .filter_map(|finding| match finding.measure {
                    Measure::Counts { trials, .. } if trials > 0 => Some(trials),
                    _ => None,
                });
            let each = cost.wall_secs / trials.max()? as f64;
            (each.is_finite() && each > 0.0).then(|| (piece.id.clone(), each))
        };
        Self {
            unit: "s".to_owned(),
            per_trial: evidence.iter().filter_map(seconds).collect(),
            declared: false,
        }
    }

    /// The same with the cost of one piece declared. Costs that are not positive are ignored.
    #[must_use]
    pub fn declare(mut self, evidence: &str, per_trial: f64) -> Self {
        if per_trial.is_finite() && per_trial > 0.0 {
            self.per_trial.insert(evidence.to_owned(), per_trial);
        }
        self
    }

    pub(crate) fn of(&self, evidence: &str) -> f64 {
        let declared = self.per_trial.get(evidence).copied();
        declared
            .filter(|cost| cost.is_finite() && *cost > 0.0)
            .unwrap_or(1.0)
    }
}

/// Further trials of one piece of evidence, within a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlannedTrials {
    /// The evidence.
    pub evidence: String,
    /// How many more trials.
    pub trials: u64,
}

/// Further trials that together would decide a pair.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DecisionPlan {
    /// The trials, of one side or of both.
    pub trials: Vec<PlannedTrials>,
    /// What they cost, in the unit of the costs.
    pub cost: f64,
    /// The chance that they decide, given what is known now.
    pub chance: f64,
}

/// An undecided pair, with the plans that would decide it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Undecided {
    /// The requirement or failure mode.
    pub subject: Subject,
    /// The earlier evidence.
    pub left: String,
    /// The later evidence.
    pub right: String,
    /// The unit of all costs.
    pub unit: String,
    /// `true` if both sides are current, so that a conclusion waits for the decision.
    #[serde(default)]
    pub current: bool,
    /// Plans, the cheapest first; none where up to 10^7 further trials would not decide, or where
    /// nobody can add trials to the side that needs them.
    pub plans: Vec<DecisionPlan>,
}

/// Plans for every inconclusive comparison, in their order.
///
/// `comparisons` are those of [`crate::compare()`] on the same study.
pub fn undecided(
    study: &Study<'_>,
    comparisons: &[Comparison],
    costs: &TrialCosts,
) -> Vec<Undecided> {
    let family = comparisons
        .iter()
        .filter(|comparison| comparison.outcome != Outcome::NotComparable)
        .count();
    comparisons
        .iter()
        .filter(|comparison| comparison.outcome == Outcome::Inconclusive)
        .filter_map(|comparison| plans(study, comparison, costs, family))
        .collect()
}

/// Whether trials can be added: not to what others published.
pub(crate) fn is_open(piece: &Evidence) -> bool {
    !piece.published && piece.reproduced_by.is_none()
}

/// Whether all are the latest evidence of their technique on the subject.
fn is_current(study: &Study<'_>, subject: &Subject, ids: [&String; 2]) -> bool {
    let current = crate::conclude::latest_of_each_technique(study.evidence, |piece| {
        let finding = piece.finding(subject);
        finding.is_some_and(|finding| Belief::of(&finding.measure).is_ok())
    });
    let is_among = |id: &String| {
        let mut current = current.iter();
        current.any(|&index| &study.evidence[index].id == id)
    };
    ids.into_iter().all(is_among)
}

fn plans(
    study: &Study<'_>,
    comparison: &Comparison,
    costs: &TrialCosts,
    family: usize,
) -> Option<Undecided> {
    let piece = |id: &str| study.evidence.iter().find(|piece| piece.id == id);
    let belief = |piece: &Evidence| Belief::of(&piece.finding(&comparison.subject)?.measure).ok();
    let (left, right) = (&comparison.left, &comparison.right);
    let (first, second) = (piece(left)?, piece(right)?);
    let pair = Pair::new(belief(first)?, belief(second)?, comparison.margin);
    let open = (is_open(first), is_open(second));
    let all = Planning::new(&pair, &study.levels, family)
        .with_open_sides(open)
        .plans((costs.of(left), costs.of(right)))
        .by_cost();
    let trials = |plan: &Plan| {
        [(left, plan.trials.0), (right, plan.trials.1)]
            .into_iter()
            .filter(|(_, trials)| *trials > 0)
            .map(|(evidence, trials)| PlannedTrials {
                evidence: evidence.clone(),
                trials,
            })
            .collect()
    };
    Some(Undecided {
        subject: comparison.subject.clone(),
        left: left.clone(),
        right: right.clone(),
        unit: costs.unit.clone(),
        current: is_current(study, &comparison.subject, [left, right]),
        plans: all
            .iter()
            .map(|plan| DecisionPlan {
                trials: trials(plan),
                cost: plan.cost,
                chance: plan.chance,
            })
            .collect(),
    })
}
