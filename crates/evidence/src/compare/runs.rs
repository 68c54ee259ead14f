//! Over which runs two findings are taken, and how often their subject is triggered in them.
//!
//! # Definition
//! A number over all runs (also those that do not trigger the requirement) and a rate over the runs that trigger it are
//! not compared: they answer different questions ([`Denominator::is_comparable`]). The share of runs that trigger it is a
//! quantity of its own. It is compared by the tests of a pair, at the requirement's margin, without correction, and
//! decides nothing: trials are often arranged so that the trigger comes.
//!
//! # Guarantee
//! That of the tests of a pair ([`super::pair`]), for each trigger on its own.

use super::words::{p_value, points};
use super::{Belief, Levels, Pair, Relation};
use crate::condition::share;
use crate::{Denominator, Evidence, Finding, Interval, Subject, TriggerComparison};

/// Why the numbers of two findings are not over the same runs, if they are not.
pub(super) fn other_runs(
    (left, first): (&Evidence, &Finding),
    (right, second): (&Evidence, &Finding),
) -> Option<String> {
    if first.denominator.is_comparable(&second.denominator) {
        return None;
    }
    Some(format!(
        "They are taken over different runs: {}; {}.{}",
        over(left, first),
        over(right, second),
        remedy(&first.subject)
    ))
}

fn over(evidence: &Evidence, finding: &Finding) -> String {
    let id = &evidence.id;
    match &finding.denominator {
        Denominator::AllRuns { reason } => format!(
            "{id} over all runs, whether or not they trigger it ({})",
            reason.trim_end_matches('.')
        ),
        Denominator::EveryRun => format!("{id} over all runs, each of which triggers it"),
        Denominator::Triggered => match finding.trigger.as_deref().and_then(share) {
            Some(share) => format!("{id} over the runs that trigger it ({share} of all)"),
            None => format!("{id} over the runs that trigger it"),
        },
    }
}

/// What makes them comparable.
fn remedy(subject: &Subject) -> &'static str {
    match subject {
        Subject::Requirement(_) => {
            " Say which runs of the model trigger it: `trigger = 'P=? [ F \"...\" ]'` in requirements.toml."
        }
        Subject::FailureMode(_) => {
            " Say which runs of the model give it an opportunity: `opportunity = 'P=? [ F \"...\" ]'` in \
             requirements.toml."
        }
    }
}

/// How often both sides trigger the subject, if both know it.
pub(super) fn triggers(
    (left, first): (&Evidence, &Finding),
    (right, second): (&Evidence, &Finding),
    margin: f64,
    levels: &Levels,
) -> Option<TriggerComparison> {
    let (first, second) = (first.trigger.as_deref()?, second.trigger.as_deref()?);
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
            format!("these shares differ beyond chance (p {})", p_value(p))
        }
        Relation::Indeterminate | Relation::IndeterminateOutside => {
            format!("whether these shares differ is open (p {})", p_value(p))
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

    /// Numbers over all runs and over those that trigger the requirement are never comparable; a number that is both is
    /// comparable with either.
    #[test]
    fn only_numbers_over_the_same_runs_are_comparable() {
        let all = || Denominator::AllRuns {
            reason: String::new(),
        };
        let of = [Denominator::EveryRun, Denominator::Triggered, all()];
        for (i, first) in of.iter().enumerate() {
            for (j, second) in of.iter().enumerate() {
                let expected = i == 0 || j == 0 || i == j;
                assert_eq!(
                    first.is_comparable(second),
                    expected,
                    "{first:?} {second:?}"
                );
            }
        }
    }
}
