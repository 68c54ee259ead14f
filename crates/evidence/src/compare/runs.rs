//! Over which runs two findings are taken, and how often their subject is triggered in them.
//!
//! # Definition
//! A number over all runs (also those that do not trigger the requirement) and a rate over the runs that trigger it are
//! not compared: they answer different questions ([`Finding::is_over_the_same_runs`]). Nor is a number over
//! all runs of which the study says no trigger ([`Denominator::NoTrigger`]): that some runs do not trigger it is what
//! [`Denominator::Triggered`] says. Nor is a model's number given a trigger that was written by hand with anything that is
//! counted by a monitor which is triggered in other runs ([`Denominator::OtherTrigger`]).
//!
//! The share of runs that trigger it is a quantity of its own. It is compared by the tests of a pair, at the requirement's
//! margin, without correction for other comparisons and for looks before, and decides nothing. It is compared only where both
//! shares are known to be of the same population of runs: under the same conditions, of the same trigger, and of runs that come
//! as the conditions have it, which are those of a model, of a simulator's own campaign, and of operation. Trials that people
//! set up are often arranged so that the trigger comes, and what others counted in tables may be only such runs. Elsewhere the
//! reason is said in place of the comparison.
//!
//! One thing of it needs no population: what a model computes to be impossible for certain, and what others count, is refuted. That is a
//! conflict, however the runs were set up, as far as both hold under the same conditions ([`impossible`]).
//!
//! # Assumes
//! Runs of a model, of a simulator's own campaign and of operation come as the conditions have them. Their number was fixed
//! in advance: the test of shares does not know of looks.
//!
//! # Guarantee
//! That of the tests of a pair ([`super::pair`]), for each trigger on its own.

use super::words::{p_value, points};
use super::{Belief, Levels, Pair, Relation};
use crate::condition::share;
use crate::{
    AskedBy, AssetRole, Denominator, Evidence, Finding, Interval, Measure, Subject, Technique,
    TriggerComparison,
};

impl Finding {
    /// Whether its number and another's are over the same runs, so that they answer the same question.
    #[must_use]
    pub fn is_over_the_same_runs(&self, other: &Self) -> bool {
        use Denominator::{AllRuns, Covered, EveryRun, NoTrigger, OtherTrigger, Triggered};
        match (&self.denominator, &other.denominator) {
            (OtherTrigger { trigger, .. }, OtherTrigger { trigger: other, .. }) => trigger == other,
            (OtherTrigger { .. }, _) | (_, OtherTrigger { .. }) => false,
            (Triggered | Covered, AllRuns { .. }) | (AllRuns { .. }, Triggered | Covered) => false,
            (NoTrigger, Triggered) | (Triggered, NoTrigger) => false,
            // Nothing says of either that some runs do not trigger it.
            (NoTrigger, Covered) | (Covered, NoTrigger) => true,
            (EveryRun, _) | (_, EveryRun) => true,
            (Triggered | Covered, Triggered | Covered) => true,
            (NoTrigger | AllRuns { .. }, NoTrigger | AllRuns { .. }) => true,
        }
    }
}

/// Why the numbers of two findings are not over the same runs, if they are not.
pub(super) fn other_runs(
    (left, first): (&Evidence, &Finding),
    (right, second): (&Evidence, &Finding),
) -> Option<String> {
    if first.is_over_the_same_runs(second) {
        return None;
    }
    let other_trigger = |finding: &Finding| match &finding.denominator {
        Denominator::OtherTrigger { trigger, monitor } => Some(format!(
            " Its monitor is triggered by {monitor}, and the study's trigger for the model is {trigger}: write the same in \
             both in requirements.toml."
        )),
        Denominator::EveryRun
        | Denominator::NoTrigger
        | Denominator::Triggered
        | Denominator::Covered
        | Denominator::AllRuns { .. } => None,
    };
    if let Some(remedy) = other_trigger(first).or_else(|| other_trigger(second)) {
        return Some(format!(
            "They are taken over different runs: {}; {}.{remedy}",
            over(left, first),
            over(right, second)
        ));
    }
    let is_over_some = |finding: &Finding| {
        matches!(
            finding.denominator,
            Denominator::Triggered | Denominator::Covered
        )
    };
    let of_all = match is_over_some(first) {
        true => right,
        false => left,
    };
    Some(format!(
        "They are taken over different runs: {}; {}.{}",
        over(left, first),
        over(right, second),
        remedy(&first.subject, of_all.technique)
    ))
}

/// That a number over all runs is held against a rate over runs that a table calls covered, where the table has no other row that
/// says how many runs there were: whether these are all runs is not known.
pub(super) fn total_unknown(
    (left, first): (&Evidence, &Finding),
    (right, second): (&Evidence, &Finding),
) -> Option<String> {
    let (all, table, covered) = match (&first.denominator, &second.denominator) {
        (Denominator::NoTrigger, Denominator::Covered) => (left, right, second),
        (Denominator::Covered, Denominator::NoTrigger) => (right, left, first),
        _ => return None,
    };
    let is_row = |it: &&Finding| matches!(it.measure, Measure::Counts { .. });
    let rows = table.findings.iter().filter(is_row).count();
    let key = match covered.subject {
        Subject::Requirement(_) => "trigger",
        Subject::FailureMode(_) => "opportunity",
    };
    (rows == 1).then(|| {
        format!(
            "{} is over all runs, and nothing says that the runs which {} counts as covered are all of them: if some runs do not come \
             to it, name what triggers it (`{key}` in requirements.toml)",
            all.id, table.id
        )
    })
}

fn over(evidence: &Evidence, finding: &Finding) -> String {
    let id = &evidence.id;
    match &finding.denominator {
        Denominator::AllRuns { reason } => format!(
            "{id} over all runs, whether or not they trigger it ({})",
            reason.trim_end_matches('.')
        ),
        Denominator::OtherTrigger { trigger, .. } => format!("{id} over the runs with {trigger}"),
        Denominator::EveryRun => format!("{id} over all runs, each of which triggers it"),
        Denominator::NoTrigger => {
            format!("{id} over all runs, of which the study does not say which trigger it")
        }
        Denominator::Triggered | Denominator::Covered => {
            match finding.trigger.as_deref().and_then(share) {
                Some(share) => format!("{id} over the runs that trigger it ({share} of all)"),
                None => format!("{id} over the runs that trigger it"),
            }
        }
    }
}

/// What makes them comparable, where the number over all runs is of this technique.
fn remedy(subject: &Subject, of_all: Technique) -> &'static str {
    match (of_all.traits().asked_by, subject) {
        (AskedBy::Event, _) => {
            " If the tree's probability is over the runs that trigger it, say so: `triggered = true` in its entry of ledger.toml."
        }
        (AskedBy::Property | AskedBy::Monitor, Subject::Requirement(_)) => {
            " Say which runs of the model trigger it: `trigger = 'P=? [ F \"...\" ]'` in requirements.toml."
        }
        (AskedBy::Property | AskedBy::Monitor, Subject::FailureMode(_)) => {
            " Say which runs of the model give it an opportunity: `opportunity = 'P=? [ F \"...\" ]'` in \
             requirements.toml."
        }
    }
}

/// How often both sides trigger the subject, if both know it; or why that is not compared.
pub(super) fn triggers(
    (left, first): (&Evidence, &Finding),
    (right, second): (&Evidence, &Finding),
    margin: f64,
    levels: &Levels,
) -> Option<Result<TriggerComparison, String>> {
    let (of_left, of_right) = (first.trigger.as_deref()?, second.trigger.as_deref()?);
    let of_others = other_population((left, first), (right, second));
    match of_others {
        Some(reason) => Some(Err(reason)),
        None => shares((left, of_left), (right, of_right), margin, levels).map(Ok),
    }
}

/// That one side computes for certain that no run comes to what triggers the subject, of which the other counted runs.
pub(super) fn impossible(
    (left, first): (&Evidence, &Finding),
    (right, second): (&Evidence, &Finding),
) -> Option<String> {
    let never = |finding: &Finding| {
        let trigger = finding.trigger.as_deref()?;
        match Belief::of(trigger).ok()? {
            Belief::Known { bounds, .. } => (bounds.high <= 0.0).then_some(()),
            _ => None,
        }
    };
    let counted = |finding: &Finding| match (&finding.measure, &finding.denominator) {
        (
            Measure::Counts { trials, .. },
            Denominator::Triggered | Denominator::Covered | Denominator::EveryRun,
        ) => Some(*trials).filter(|trials| *trials > 0),
        _ => None,
    };
    let (model, other, trials) = match (never(first), counted(second)) {
        (Some(()), Some(trials)) => (left, right, trials),
        _ => (right, left, never(second).and_then(|()| counted(first))?),
    };
    let (noun, came) = match (&first.subject, trials) {
        (Subject::Requirement(_), 1) => ("triggers it", "1 run that does"),
        (Subject::Requirement(_), _) => ("triggers it", "runs that do"),
        (Subject::FailureMode(_), 1) => ("gives it an opportunity", "1 opportunity"),
        (Subject::FailureMode(_), _) => ("gives it an opportunity", "opportunities"),
    };
    let came = match trials {
        1 => came.to_owned(),
        many => format!("{many} {came}"),
    };
    (left.conditions == right.conditions).then(|| {
        format!(
            "In {} no run {noun}, for certain, and {} counts {came}: what happened is not impossible.",
            model.id, other.id
        )
    })
}

/// Why two shares of triggers are not known to be of the same population of runs, if they are not.
fn other_population(
    (left, first): (&Evidence, &Finding),
    (right, second): (&Evidence, &Finding),
) -> Option<String> {
    if left.conditions != right.conditions {
        return Some(format!(
            "{} and {} hold for other conditions, so that their runs are not the same.",
            left.id, right.id
        ));
    }
    let trigger = |finding: &Finding| match &finding.denominator {
        Denominator::OtherTrigger { trigger, .. } => Some(trigger.clone()),
        Denominator::EveryRun
        | Denominator::NoTrigger
        | Denominator::Triggered
        | Denominator::Covered
        | Denominator::AllRuns { .. } => None,
    };
    if trigger(first) != trigger(second) {
        return Some(format!(
            "The shares of {} and {} are of different triggers.",
            left.id, right.id
        ));
    }
    let arranged = [left, right].into_iter().find(|it| is_arranged(it))?;
    Some(format!(
        "The runs of {} were set up or chosen by people, perhaps so that it is triggered: nothing says that they are a sample of \
         all runs.",
        arranged.id
    ))
}

/// Whether its runs may have been chosen by whether they trigger a subject: trials that people set up, and what others counted
/// of a model or simulator that the study does not have.
fn is_arranged(evidence: &Evidence) -> bool {
    let of_system = evidence.technique.is_of_system();
    let has_data = evidence.assets.iter().any(|it| it.role == AssetRole::Data);
    let has_model = (evidence.assets.iter()).any(|it| it.role == AssetRole::SystemModel);
    evidence.technique.traits().is_counted_by_people || !of_system && has_data && !has_model
}

/// The comparison of two shares.
fn shares(
    (left, first): (&Evidence, &Measure),
    (right, second): (&Evidence, &Measure),
    margin: f64,
    levels: &Levels,
) -> Option<TriggerComparison> {
    let beliefs = (Belief::of(first).ok()?, Belief::of(second).ok()?);
    let pair = Pair::new(beliefs.0, beliefs.1, margin);
    let p = pair.p_difference();
    let relation = Relation::of(
        p <= levels.confidence.alpha(),
        pair.shows_agreement(levels.agreement),
        pair.is_inside_margin(),
    );
    let interval = pair.difference_interval(levels.confidence);
    let shown = match relation {
        Relation::Equivalent | Relation::TrivialDifference => {
            format!("these shares agree within {}", points(margin))
        }
        Relation::Different | Relation::DifferenceWithinMargin => {
            format!(
                "these shares differ beyond chance (p {}, taken by itself)",
                p_value(p)
            )
        }
        Relation::Indeterminate | Relation::IndeterminateOutside => {
            format!(
                "whether these shares differ is open (p {}, taken by itself)",
                p_value(p)
            )
        }
    };
    Some(TriggerComparison {
        outcome: relation.outcome(),
        difference: pair.difference(),
        difference_interval: Interval {
            low: interval.low,
            high: interval.high,
        },
        p_difference: p,
        reason: format!(
            "Triggered in {} of the runs of {} and in {} of those of {}; {shown}.",
            share(first)?,
            left.id,
            share(second)?,
            right.id
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(denominator: Denominator, trigger: Option<Measure>) -> Finding {
        Finding {
            subject: Subject::Requirement("1".into()),
            measure: Measure::NotCovered {
                reason: String::new(),
                constant: None,
            },
            denominator,
            trigger: trigger.map(Box::new),
            undecided: 0,
            left_out: 0,
            completions: None,
            witnesses: vec![],
            readings: vec![],
        }
    }

    /// A number that is over every run by what is known is comparable with each other; one over all runs of which nothing
    /// is known is not comparable with one that shows that some do not trigger the requirement.
    #[test]
    fn only_numbers_over_the_same_runs_are_comparable() {
        let all = Denominator::AllRuns {
            reason: String::new(),
        };
        let sample = stats::Sample {
            successes: 294,
            trials: 300,
        };
        let share = Measure::of_counts(sample, None, stats::Confidence::P95).expect("counts");
        let every = finding(Denominator::EveryRun, None);
        let nothing_said = finding(Denominator::NoTrigger, None);
        let all = finding(all, None);
        let some = finding(Denominator::Triggered, Some(share));
        let of_unknown_many = finding(Denominator::Covered, None);
        for (first, second, expected) in [
            (&every, &some, true),
            (&every, &nothing_said, true),
            (&every, &all, true),
            (&nothing_said, &nothing_said, true),
            (&nothing_said, &all, true),
            (&nothing_said, &of_unknown_many, true),
            (&some, &of_unknown_many, true),
            (&nothing_said, &some, false),
            (&all, &some, false),
            (&all, &of_unknown_many, false),
        ] {
            for (first, second) in [(first, second), (second, first)] {
                let said = (&first.denominator, &second.denominator);
                assert_eq!(first.is_over_the_same_runs(second), expected, "{said:?}");
            }
        }
    }
}
