//! One set of further trials for all that is undecided.
//!
//! # Definition
//! Each undecided pair of current evidence has plans (see `further`). A *programme* takes one plan
//! of each; a run of a piece of evidence serves all its pairs, so the programme has, of each
//! piece, the most runs that any of the plans takes. It costs what those cost.
//!
//! Plans are chosen by descent: each pair starts with its cheapest, then pair by pair the plan is
//! taken with which the whole is cheapest, until nothing changes.
//!
//! # Assumes
//! A run serves every pair of its piece, and gives as many trials of a subject as the runs so far did.
//!
//! # Guarantee
//! Every pair has at least the trials of one of its plans. The set is cheapest among those that
//! differ in one pair's plan, which need not be the cheapest of all; with one undecided pair it is.

use super::{DecisionPlan, PlannedTrials, TrialCosts, Undecided};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Further trials that serve all undecided pairs of current evidence.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Programme {
    /// The runs of each piece, in the order of their identifiers; each is one trial of what every run covers.
    pub trials: Vec<PlannedTrials>,
    /// What they cost, in the unit of the costs.
    pub cost: f64,
    /// How many undecided pairs they serve.
    pub pairs: u64,
    /// How many undecided pairs no further trials would decide.
    pub beyond: u64,
}

/// Times that all pairs are looked at.
const ROUNDS: usize = 20;

/// The programme for all pairs that are current; `None` if there are none.
#[must_use]
pub fn programme(undecided: &[Undecided], costs: &TrialCosts) -> Option<Programme> {
    let current = undecided.iter().filter(|one| one.current);
    let (open, beyond): (Vec<&Undecided>, Vec<&Undecided>) =
        current.partition(|one| !one.plans.is_empty());
    if open.is_empty() && beyond.is_empty() {
        return None;
    }
    let mut chosen = vec![0; open.len()];
    for _ in 0..ROUNDS {
        if !improve(&open, &mut chosen, costs) {
            break;
        }
    }
    let trials = most_runs(&open, &chosen);
    Some(Programme {
        cost: cost(&trials, costs),
        trials: trials
            .into_iter()
            .map(|(evidence, trials)| PlannedTrials {
                evidence: evidence.to_owned(),
                trials,
                runs: trials,
                by: None,
            })
            .collect(),
        pairs: open.len() as u64,
        beyond: beyond.len() as u64,
    })
}

/// Takes for each pair the plan with which the whole is cheapest; whether any plan changed.
fn improve(open: &[&Undecided], chosen: &mut [usize], costs: &TrialCosts) -> bool {
    let mut changed = false;
    for pair in 0..open.len() {
        let before = chosen[pair];
        let mut best = (cost(&most_runs(open, chosen), costs), before);
        for plan in 0..open[pair].plans.len() {
            chosen[pair] = plan;
            let with = cost(&most_runs(open, chosen), costs);
            if with < best.0 {
                best = (with, plan);
            }
        }
        chosen[pair] = best.1;
        changed |= best.1 != before;
    }
    changed
}

/// Of each piece, the most runs of the chosen plans.
fn most_runs<'a>(open: &[&'a Undecided], chosen: &[usize]) -> BTreeMap<&'a str, u64> {
    let mut most: BTreeMap<&str, u64> = BTreeMap::new();
    let plans = open.iter().zip(chosen);
    let plans = plans.filter_map(|(one, plan)| one.plans.get(*plan));
    for planned in plans.flat_map(|plan: &DecisionPlan| &plan.trials) {
        let trials = most.entry(&planned.evidence).or_default();
        *trials = planned.runs.max(*trials);
    }
    most
}

fn cost(trials: &BTreeMap<&str, u64>, costs: &TrialCosts) -> f64 {
    let each = trials
        .iter()
        .map(|(evidence, trials)| *trials as f64 * costs.of(evidence));
    each.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Subject;

    fn plan(trials: &[(&str, u64)]) -> DecisionPlan {
        let planned = |(evidence, trials): &(&str, u64)| PlannedTrials {
            evidence: (*evidence).to_owned(),
            trials: *trials,
            runs: *trials,
            by: None,
        };
        DecisionPlan {
            trials: trials.iter().map(planned).collect(),
            cost: trials.iter().map(|(_, trials)| *trials as f64).sum(),
            chance: 0.8,
            agreement: 0.7,
            conflict: 0.1,
        }
    }

    fn pair(current: bool, plans: &[&[(&str, u64)]]) -> Undecided {
        Undecided {
            subject: Subject::Requirement("1".into()),
            left: "a".into(),
            right: "b".into(),
            unit: "trials".into(),
            current,
            plans: plans.iter().map(|trials| plan(trials)).collect(),
        }
    }

    /// Alone, `b` would be cheaper for the second pair; but `a` is tried anyway.
    #[test]
    fn trials_serve_several_pairs() {
        let first = pair(true, &[&[("a", 100)]]);
        let second = pair(true, &[&[("b", 50)], &[("a", 80)]]);
        let never = pair(true, &[]);
        let old = pair(false, &[&[("c", 7)]]);
        let all = [first, second, never, old];
        let found = programme(&all, &TrialCosts::equal()).unwrap();
        assert_eq!(found.trials, plan(&[("a", 100)]).trials);
        assert_eq!((found.cost, found.pairs, found.beyond), (100.0, 2, 1));
        let dear = TrialCosts::equal().declare("a", 10.0);
        let found = programme(&all[1..2], &dear).unwrap();
        assert_eq!((found.cost, found.trials[0].trials), (50.0, 50));
        assert_eq!(programme(&all[3..], &dear), None);
    }
}
