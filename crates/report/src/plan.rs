//! Further trials in words: what they are, what they cost, and the chance that they decide.

use crate::number;
use evidence::{Deciding, DecisionPlan, PlannedTrials, Programme, StudyResult, TrialCosts};

/// Trials of several pieces: `120 more trials in E3 and 400 in E4`.
pub fn trials(planned: &[PlannedTrials]) -> String {
    named(planned, "trial")
}

fn named(planned: &[PlannedTrials], noun: &str) -> String {
    let parts: Vec<String> = planned
        .iter()
        .enumerate()
        .map(|(place, one)| {
            let noun = match (place, one.trials) {
                (0, 1) => format!(" more {noun}"),
                (0, _) => format!(" more {noun}s"),
                _ => String::new(),
            };
            let runs = match one.runs > one.trials {
                true => format!(" (about {} runs)", number::count(one.runs)),
                false => String::new(),
            };
            let by = one
                .by
                .map_or(String::new(), |by| format!(" (by {})", by.in_words()));
            format!(
                "{}{noun} in {}{runs}{by}",
                number::count(one.trials),
                one.evidence
            )
        })
        .collect();
    match parts.as_slice() {
        [] => "no trials".to_owned(),
        [rest @ .., last] if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => parts.concat(),
    }
}

/// What trials cost, where costs are declared: ` at 12.5 min`.
fn at_cost(cost: f64, costs: &TrialCosts) -> String {
    match costs.declared {
        true => format!(" at {}", priced(cost, costs)),
        false => String::new(),
    }
}

/// A cost with its unit.
fn priced(cost: f64, costs: &TrialCosts) -> String {
    let decimals = match cost {
        cost if cost >= 100.0 => 0,
        cost if cost >= 1.0 => 1,
        _ => 3,
    };
    format!("{} {}", number::decimal(cost, decimals), costs.unit)
}

/// One plan: `120 more trials in E3 at 30 min, with a chance of 81 % (agreement 70 %, conflict 11 %, neither 19 %)`.
pub fn plan(plan: &DecisionPlan, costs: &TrialCosts) -> String {
    format!(
        "{}{}, with a chance of {}",
        trials(&plan.trials),
        at_cost(plan.cost, costs),
        outcomes(
            plan.chance,
            [
                ("agreement", plan.agreement),
                ("conflict", plan.conflict),
                ("neither", 1.0 - plan.chance),
            ]
        )
    )
}

/// The chance of a decision and that of each outcome; small ones are not rounded to nothing.
fn outcomes(chance: f64, each: [(&str, f64); 3]) -> String {
    let percent = |share: f64| match share {
        share if share > 0.0 && share < 0.001 => format!("below {}", number::percent(0.001)),
        share => number::percent(share.clamp(0.0, 0.999)),
    };
    let each = each.map(|(name, share)| format!("{name} {}", percent(share)));
    format!("{} ({})", percent(chance), each.join(", "))
}

/// The trials that would settle a requirement, in the same words.
pub fn deciding(one: &Deciding, costs: &TrialCosts) -> String {
    let Some(count) = one.trials else {
        return format!("no plan of trials in {} alone was found", one.evidence);
    };
    let planned = PlannedTrials {
        evidence: one.evidence.clone(),
        trials: count,
        runs: count,
        by: one.by,
    };
    format!(
        "{}{}, with a chance of {}",
        trials(&[planned]),
        at_cost(one.cost.unwrap_or_default(), costs),
        outcomes(
            one.chance.unwrap_or_default(),
            [
                ("satisfied", one.satisfied.unwrap_or_default()),
                ("violated", one.violated.unwrap_or_default()),
                ("undecided", 1.0 - one.chance.unwrap_or_default()),
            ]
        )
    )
}

/// The whole programme in one sentence.
pub fn programme(programme: &Programme, costs: &TrialCosts) -> String {
    let pairs = |count: u64| match count {
        1 => "1 undecided pair".to_owned(),
        count => format!("{} undecided pairs", number::count(count)),
    };
    let mut words = match programme.pairs {
        0 => String::new(),
        count => format!(
            "{}{} would serve {} of current evidence.",
            named(&programme.trials, "run"),
            at_cost(programme.cost, costs),
            pairs(count)
        ),
    };
    if programme.beyond > 0 {
        let rest = format!(
            "For {} no plan of further trials was found.",
            pairs(programme.beyond)
        );
        words = format!("{words} {rest}").trim().to_owned();
    }
    words
}

/// What trials that are added now cost where sample sizes were declared as fixed.
pub fn of_fixed_sizes(study: &StudyResult) -> Option<&'static str> {
    study.synthesis.looks.is_none().then_some(
        "study.toml says that all sample sizes were fixed before. Trials that are added now, after a look, keep the declared \
         error rates only without `sample_sizes = \"fixed\"`, with wider limits and smaller chances than these.",
    )
}

/// How plans are priced.
pub fn pricing(costs: &TrialCosts) -> String {
    if !costs.declared {
        return "No costs are declared (study.toml, [costs]), so every trial counts the same."
            .to_owned();
    }
    let each: Vec<String> = costs
        .per_trial
        .iter()
        .map(|(evidence, cost)| format!("{evidence} {}", priced(*cost, costs)))
        .collect();
    format!("A trial costs, as declared: {}.", each.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use evidence::FurtherSubjects;

    fn planned(evidence: &str, trials: u64) -> PlannedTrials {
        PlannedTrials {
            evidence: evidence.into(),
            trials,
            runs: if evidence == "E4" { 2 * trials } else { trials },
            by: None,
        }
    }

    #[test]
    fn trials_are_named_once_and_priced_where_prices_are_known() {
        let both = DecisionPlan {
            trials: vec![planned("E3", 1), planned("E4", 12000)],
            cost: 31.5,
            chance: 0.8124,
            agreement: 0.8,
            conflict: 0.0124,
        };
        let by_people = PlannedTrials {
            by: Some(FurtherSubjects {
                subjects: 18,
                each: 10,
            }),
            ..planned("E3", 180)
        };
        assert_eq!(
            trials(&[by_people]).replace('\u{a0}', " "),
            "180 more trials in E3 (by 18 further people or sessions with 10 trials each)"
        );
        let equal = TrialCosts::equal();
        let free = plan(&both, &equal).replace('\u{a0}', " ");
        assert!(
            free.starts_with("1 more trial in E3 and 12,000 in E4 (about 24,000 runs)"),
            "{free}"
        );
        assert!(
            free.ends_with(
                "with a chance of 81.2 % (agreement 80.0 %, conflict 1.2 %, neither 18.8 %)"
            ),
            "{free}"
        );
        let declared = TrialCosts {
            unit: "min".into(),
            declared: true,
            ..equal.declare("E3", 15.0)
        };
        assert!(
            plan(&both, &declared).contains(" at 31.5 min"),
            "{}",
            plan(&both, &declared)
        );
        assert_eq!(
            pricing(&declared),
            "A trial costs, as declared: E3 15.0 min."
        );
        assert_eq!(trials(&[]), "no trials");
    }
}
