//! Where the limit of a clustered count would be better with a subject less.
//!
//! # Definition
//! A subject whose trials all have the outcome that the claim asks for can make the claim's limit worse: it shows that
//! subjects differ, and of few who differ little is known (`stats::clustered`, "Not monotone"). The limit is valid with the
//! subject and without it; only the one with all subjects may be used, since to choose is to look for the better. That the
//! other would be better is said, so that nobody takes the subject's trials for worthless or leaves them out.
//!
//! Asked is of the one with the most trials, at one look, at the level of the claim; one test at the limit that there is.
//!
//! # Assumes
//! As the limit that it looks at: subjects are independent, with rates of a beta distribution, at one look.
//!
//! # Guarantee
//! The verdict does not depend on it: no limit is exchanged for the better one.

use super::limits::of_tests;
use super::stand::{ClaimLevels, at_one_look};
use crate::compare::{Belief, ByCluster, CountsAtLook};
use crate::{Direction, Threshold};
use stats::{ClusterMethod, Confidence, Sample, clustered_rate};
use std::rc::Rc;

/// By how much a limit has to be better to be told.
const TOLD: f64 = 0.001;

/// That the limit of the claim "met" would be better without a subject, as the end of a sentence; empty where it would not.
pub(super) fn better_without_one(
    belief: &Belief,
    threshold: Threshold,
    levels: ClaimLevels,
) -> String {
    let at_least = threshold.direction == Direction::AtLeast;
    let all = if at_least { "all" } else { "none" };
    match trials_of_harmful(belief, threshold.direction, levels.met) {
        Some(trials) => format!(
            "; without the subject {all} of whose {trials} trials count, who shows that subjects differ, the limit would be nearer \
             to the rate"
        ),
        None => String::new(),
    }
}

/// Trials of the subject without whom the limit would be better.
fn trials_of_harmful(belief: &Belief, direction: Direction, level: f64) -> Option<u64> {
    if belief.has_undecided() {
        return None;
    }
    let now = belief.counts()?;
    let found = now.clusters.as_ref()?.found()?;
    let contrary = |it: &Sample| match direction {
        Direction::AtLeast => it.failures(),
        Direction::AtMost => it.successes,
    };
    let clean = found.iter().enumerate();
    let clean = clean.filter(|(_, it)| it.trials > 1 && contrary(it) == 0);
    let (place, one) = clean.max_by_key(|(_, it)| it.trials)?;
    let mut others = found.to_vec();
    others.remove(place);
    let fewer = counted(&others)?;
    let estimate = now.effective.successes / now.effective.trials;
    let limits = of_tests(|t| at_one_look(&now, t), estimate, (level, level));
    let is_better = match direction {
        Direction::AtLeast => at_one_look(&fewer, limits.low + TOLD).0 <= level,
        Direction::AtMost => at_one_look(&fewer, limits.high - TOLD).1 <= level,
    };
    is_better.then_some(one.trials)
}

/// The counts of some subjects; `None` where they do not tell by themselves how alike their trials are.
fn counted(found: &[Sample]) -> Option<CountsAtLook> {
    let rate = clustered_rate(found, Confidence::P95).ok()?;
    let pairs: Vec<[u64; 2]> = found.iter().map(|it| [it.successes, it.trials]).collect();
    (rate.method == ClusterMethod::Profile).then(|| CountsAtLook {
        sample: rate.total,
        effective: rate.worth,
        clusters: Some(Rc::new(ByCluster::new(&pairs))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Measure;

    fn said(people: &[(u64, u64)], direction: Direction) -> String {
        let found: Vec<Sample> = people
            .iter()
            .map(|&(successes, trials)| Sample { successes, trials })
            .collect();
        let measure = Measure::of_clusters(&found, Confidence::P95).expect("counts");
        let belief = Belief::of(&measure).expect("counts");
        let threshold = Threshold {
            direction,
            value: 0.7,
        };
        better_without_one(&belief, threshold, ClaimLevels::both(Confidence::P95))
    }

    /// Three people who are alike show nothing of how people differ; a fourth who never fails does.
    #[test]
    fn a_person_who_never_fails_may_cost_more_than_his_trials_tell() {
        let alike = [(45, 50), (45, 50), (45, 50), (50, 50)];
        let words = said(&alike, Direction::AtLeast);
        assert!(words.contains("all of whose 50 trials count"), "{words}");
        let mirrored: Vec<(u64, u64)> = alike.iter().map(|(s, n)| (n - s, *n)).collect();
        let words = said(&mirrored, Direction::AtMost);
        assert!(words.contains("none of whose 50 trials count"), "{words}");
    }

    #[test]
    fn a_person_who_helps_is_not_named() {
        for people in [
            &[(9, 10), (9, 10), (10, 10), (10, 10), (10, 10)][..],
            &[(5, 10), (10, 10), (10, 10), (10, 10)],
            &[(9, 10), (8, 10), (9, 10)],
            &[(10, 10), (10, 10)],
        ] {
            assert_eq!(said(people, Direction::AtLeast), "", "{people:?}");
        }
    }
}
