//! For the undecided: the cheapest further trials that would decide, technique by technique.
//!
//! # Definition
//! See `decide`: a plan has the wanted chance of a decision, given what is known now. Plans are
//! made for each side alone and for both, at the declared cost of one trial of each; a trial is one
//! that covers the subject (an opportunity of a failure mode, a run to which a requirement
//! applies). Where not every run covers it, the runs are counted that have so many trials at the share of them that
//! covered it so far; costs are those of runs. The cheapest plan of all is the first.
//!
//! A conflict is planned at the level that closed testing (see `closed`) leaves the pair, if the other comparisons stay
//! as they are: with `t` groups in which some pair is not rejected and `m > 2` pieces in its own, its p-value has to be
//! at most `a / t`, and that of the piece against all others of the group together at most `a / (t m)`. The latter is
//! asked of the pair: together with others that agree with one side it is rather smaller. So with two pieces the level
//! is exact, and with more somewhat too strict: a decision is a little likelier than planned.
//!
//! # Assumes
//! Further trials come from the rates of today's, as many of the runs cover the subject as did so far, and the other
//! comparisons stay as they are.
//!
//! # Guarantee
//! That of `decide` for each plan.

use super::closed::MOST_PIECES;
use super::decide::{Plan, Planning, Plans};
use super::words::{list, percent};
use super::{Belief, Study, pair::Pair, paired};
use crate::looks::is_open;
use crate::resampled::MOST_PEOPLE;
use crate::{Comparison, Cost, Evidence, Finding, FurtherTrials, Measure, Outcome, Subject};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stats::Confidence;
use std::collections::{BTreeMap, BTreeSet};

/// What one further run (an episode, an attempt) of each piece of evidence costs, all in one unit.
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
    /// How many more trials of the subject.
    pub trials: u64,
    /// How many more runs have so many, if as many of them cover the subject as did so far.
    #[serde(default)]
    pub runs: u64,
    /// By whom they are made, where those so far are of people or sessions with several each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<FurtherSubjects>,
}

/// Further people or sessions, with as many trials each as those so far had on average. Whole people make whole multiples of
/// these.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct FurtherSubjects {
    /// How many.
    pub subjects: u64,
    /// The trials of each.
    pub each: u64,
}

impl FurtherSubjects {
    /// Those with so many trials in all; `None` where trials are independent, or not known to be of several subjects.
    pub(crate) fn of(measure: &Measure, more: u64) -> Option<Self> {
        let Measure::Counts {
            trials,
            subjects: Some(subjects),
            ..
        } = measure
        else {
            return None;
        };
        let each = (*trials as f64 / *subjects as f64).round() as u64;
        (*subjects > 0 && each > 1).then(|| Self {
            subjects: more.div_ceil(each),
            each,
        })
    }

    /// The trials of all of them.
    #[must_use]
    pub fn trials(self) -> u64 {
        self.subjects.saturating_mul(self.each)
    }

    /// `18 further people or sessions with 10 trials each`.
    #[must_use]
    pub fn in_words(self) -> String {
        let Self { subjects, each } = self;
        match subjects {
            1 => format!("1 further person or session with {each} trials"),
            _ => format!("{subjects} further people or sessions with {each} trials each"),
        }
    }
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
    /// The chance that they show agreement.
    #[serde(default)]
    pub agreement: f64,
    /// The chance that they show a conflict.
    #[serde(default)]
    pub conflict: f64,
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

/// Plans for every inconclusive comparison, in their order; each names its further trials from then on. Pairs with evidence of one
/// person, session or other cluster alone have none.
///
/// `comparisons` are those of [`crate::compare()`] on the same study.
pub fn undecided(
    study: &Study<'_>,
    comparisons: &mut [Comparison],
    costs: &TrialCosts,
) -> Vec<Undecided> {
    let levels = Conflicts::new(study, comparisons);
    let open = comparisons.iter_mut();
    let open = open.filter(|it| it.outcome == Outcome::Inconclusive);
    // More trials of the same one decide nothing of others.
    let is_of_one = |it: &Comparison| {
        let mut pieces = study.evidence.iter();
        pieces.any(|piece| {
            [&it.left, &it.right].contains(&&piece.id) && piece.is_of_one_subject_on(&it.subject)
        })
    };
    let open = open.filter(|it| !is_of_one(it));
    open.filter_map(|comparison| plans(study, comparison, costs, &levels))
        .collect()
}

/// At which level pairs conflict, as far as it is known before there are further trials.
struct Conflicts<'a> {
    study: &'a Study<'a>,
    /// Groups that are not decided: a pair of them may be equal.
    undecided_groups: usize,
    /// Pieces by group.
    pieces: BTreeMap<(Subject, String), BTreeSet<String>>,
    /// Pairs that are not decided.
    undecided_pairs: usize,
}

impl<'a> Conflicts<'a> {
    fn new(study: &'a Study<'a>, comparisons: &[Comparison]) -> Self {
        let mut found = Self {
            study,
            undecided_groups: 0,
            pieces: BTreeMap::new(),
            undecided_pairs: 0,
        };
        let mut undecided = BTreeSet::new();
        for one in comparisons {
            let (Some(group), Some(p)) = (found.group(one), one.p_difference_corrected) else {
                continue;
            };
            if p > study.levels.confidence.alpha() {
                undecided.insert(group.clone());
                found.undecided_pairs += 1;
            }
            let pieces = found.pieces.entry(group).or_default();
            pieces.extend([one.left.clone(), one.right.clone()]);
        }
        found.undecided_groups = undecided.len();
        found
    }

    fn group(&self, comparison: &Comparison) -> Option<(Subject, String)> {
        let mut all = self.study.evidence.iter();
        let left = all.find(|piece| piece.id == comparison.left)?;
        Some((comparison.subject.clone(), left.conditions.clone()))
    }

    /// The p-value from which on a pair conflicts.
    fn level(&self, comparison: &Comparison) -> Confidence {
        let group = self.group(comparison);
        let pieces = group.and_then(|group| self.pieces.get(&group));
        let pieces = pieces.map_or(2, BTreeSet::len);
        let is_closed = self.pieces.values().all(|all| all.len() <= MOST_PIECES);
        let tests = match (is_closed, pieces) {
            (false, _) => self.undecided_pairs,
            (true, 2) => self.undecided_groups,
            (true, more) => self.undecided_groups * more,
        };
        self.study.levels.confidence.simultaneous(tests.max(1))
    }
}

/// Whether all are current evidence on the subject.
fn is_current(study: &Study<'_>, subject: &Subject, ids: [&String; 2]) -> bool {
    let current = crate::conclude::current_evidence(study.evidence, |piece| {
        let finding = piece.finding(subject);
        finding.is_some_and(|finding| Belief::of_finding(finding).is_ok())
    });
    let is_among = |id: &String| {
        let mut current = current.iter();
        current.any(|&index| &study.evidence[index].id == id)
    };
    ids.into_iter().all(is_among)
}

fn plans(
    study: &Study<'_>,
    comparison: &mut Comparison,
    costs: &TrialCosts,
    levels: &Conflicts<'_>,
) -> Option<Undecided> {
    let piece = |id: &str| study.evidence.iter().find(|piece| piece.id == id);
    let belief = |piece: &Evidence| Belief::of_finding(piece.finding(&comparison.subject)?).ok();
    let (first, second) = (piece(&comparison.left)?, piece(&comparison.right)?);
    if first.is_simulated_of_one() || second.is_simulated_of_one() {
        comparison.reason += " More runs of the same cluster tell nothing of others.";
        return None;
    }
    let sides = ((first, belief(first)?), (second, belief(second)?));
    // What a plan promises would rest on runs of which nobody knows what they showed.
    if let Some(why) = not_planned([&sides.0.1, &sides.1.1]) {
        comparison.reason += &format!(" {why}");
        return None;
    }
    let pair = paired(study, &comparison.subject, comparison.margin, sides);
    let open = (is_open(first), is_open(second));
    let plans = Planning::new(&pair, &study.levels, levels.level(comparison))
        .with_open_sides(open)
        .plans((
            costs.of(&first.id) * runs_per_trial(first, &comparison.subject),
            costs.of(&second.id) * runs_per_trial(second, &comparison.subject),
        ));
    name_trials(comparison, (&pair, open), &plans, [first, second]);
    let (left, right) = (&comparison.left, &comparison.right);
    let cost_of = |it: &PlannedTrials| {
        let each = piece(&it.evidence).map_or(1.0, |of| runs_per_trial(of, &comparison.subject));
        it.trials as f64 * costs.of(&it.evidence) * each
    };
    let planned = |plan: &Plan| {
        let trials = planned_trials(plan, &comparison.subject, [first, second]);
        DecisionPlan {
            cost: trials.iter().map(cost_of).sum(),
            trials,
            chance: plan.chance,
            agreement: plan.agreement,
            conflict: plan.conflict,
        }
    };
    Some(Undecided {
        subject: comparison.subject.clone(),
        left: left.clone(),
        right: right.clone(),
        unit: costs.unit.clone(),
        current: is_current(study, &comparison.subject, [left, right]),
        plans: plans.by_cost().iter().map(planned).collect(),
    })
}

fn planned_trials(plan: &Plan, subject: &Subject, sides: [&Evidence; 2]) -> Vec<PlannedTrials> {
    let trials = [plan.trials.0, plan.trials.1];
    let wanted = sides.into_iter().zip(trials).filter(|(_, n)| *n > 0);
    wanted
        .map(|(piece, trials)| {
            let finding = piece.finding(subject);
            let by = finding.and_then(|it| FurtherSubjects::of(&it.measure, trials));
            let trials = by.map_or(trials, FurtherSubjects::trials);
            PlannedTrials {
                evidence: piece.id.clone(),
                trials,
                runs: (trials as f64 * runs_per_trial(piece, subject)).ceil() as u64,
                by,
            }
        })
        .collect()
}

/// Runs for each trial of a subject: the most trials of any requirement are taken for the runs, as a run may have several opportunities of
/// a failure; where it has no requirement, those of any finding.
fn runs_per_trial(piece: &Evidence, subject: &Subject) -> f64 {
    let trials = |finding: &Finding| match finding.measure {
        Measure::Counts { trials, .. } => trials,
        _ => 0,
    };
    // Where it is known in how many runs it was triggered, these are the runs.
    let runs = |finding: &Finding| match finding.trigger.as_deref() {
        Some(Measure::Counts { trials, .. }) => *trials,
        _ => trials(finding),
    };
    let own = piece.finding(subject).map_or(0, trials);
    let most = |of_requirements: bool| {
        let all = piece.findings.iter();
        let all =
            all.filter(|it| !of_requirements || matches!(it.subject, Subject::Requirement(_)));
        all.map(runs).max().unwrap_or(0)
    };
    let runs = match most(true) {
        0 => most(false),
        runs => runs,
    };
    match own {
        0 => 1.0,
        own => runs as f64 / own as f64,
    }
}

/// Why no trials are planned for counts that may be several; `None` where each run counts for itself.
fn not_planned(sides: [&Belief; 2]) -> Option<String> {
    let undecided: u64 = sides.iter().map(|it| it.undecided()).sum();
    let what = match undecided {
        0 if sides.iter().any(|it| it.has_undecided()) => {
            "Recordings with the same messages count once and each"
        }
        0 => return None,
        1 => "1 run without a verdict counts both ways",
        many => &format!("{many} runs without a verdict count both ways"),
    };
    Some(format!(
        "{what} here: what is right has to be found out before further trials are planned."
    ))
}

/// Says of an undecided pair how many trials of each side alone would decide it, and what is cheapest.
fn name_trials(
    comparison: &mut Comparison,
    (pair, open): (&Pair, (bool, bool)),
    plans: &Plans,
    pieces: [&Evidence; 2],
) {
    let sides = [
        (
            &comparison.left,
            pair.first(),
            open.0,
            plans.first.map(|plan| plan.trials.0),
        ),
        (
            &comparison.right,
            pair.second(),
            open.1,
            plans.second.map(|plan| plan.trials.1),
        ),
    ];
    let counted = sides
        .into_iter()
        .filter(|(_, belief, open, _)| *open && belief.design_effect().is_some());
    let further = counted.map(|(evidence, _, _, trials)| FurtherTrials {
        evidence: evidence.clone(),
        trials,
    });
    comparison.further_trials = further.collect();
    let words = match plans.cheapest() {
        Some(plan) => plan_in_words(&plan, &comparison.subject, pieces),
        None => match [pair.first(), pair.second()]
            .into_iter()
            .zip([open.0, open.1])
            .any(|(side, is_open)| is_open && is_by_subject(side))
        {
            true => format!(
                " No plan of up to {MOST_PEOPLE} further people or sessions was found that would decide."
            ),
            false => " No plan of further trials was found that would decide.".to_owned(),
        },
    };
    comparison.reason.push_str(&words);
}

/// Whether the counts are known by subject, so that further ones are planned by it.
fn is_by_subject(belief: &Belief) -> bool {
    let counts = belief.counts();
    counts.is_some_and(|it| it.clusters.is_some_and(|all| all.subjects().is_some()))
}

fn plan_in_words(plan: &Plan, subject: &Subject, sides: [&Evidence; 2]) -> String {
    let planned = planned_trials(plan, subject, sides).into_iter();
    let in_words = |it: PlannedTrials| {
        let noun = if it.trials == 1 { "trial" } else { "trials" };
        let runs = match it.runs > it.trials {
            true => format!(" (about {} runs)", it.runs),
            false => String::new(),
        };
        let by = it
            .by
            .map_or(String::new(), |by| format!(", by {}", by.in_words()));
        format!("{} further {noun} in {}{runs}{by}", it.trials, it.evidence)
    };
    let parts: Vec<String> = planned.map(in_words).collect();
    let chance = |share: f64| percent(share.min(0.999));
    format!(
        " {} would decide with a chance of {} (agreement {}, conflict {}).",
        list(&parts),
        chance(plan.chance),
        chance(plan.agreement),
        chance(plan.conflict)
    )
}
