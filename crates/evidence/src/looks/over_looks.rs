//! Counts against a threshold over all looks at them.
//!
//! # Definition
//! Of independent trials the p-values are those of `stats::continued_above` and `continued_below`, exact at every look.
//! Of correlated trials each look has the p-value of the test of correlated trials, and its information is the number of
//! trials at the design effect of today. A look's p-value is also that of its counts by subject, whichever is greater.
//! Where a few subjects are added, they are mostly a stage judged by the exact distribution of their successes, since one person
//! more is no normal increment: `stats::continued_clusters_above` says when. The limits of the rate are where the p-value is the error.
//!
//! # Assumes
//! As in [`super`]. Correlated trials are of people who are added from one population, with rates of a beta distribution;
//! the design effect was at all looks that of today.
//!
//! # Guarantee
//! Of `stats::continuation`: exact for independent trials, approximate for correlated ones.

use crate::compare::{Belief, CountsAtLook};
use stats::{
    ClusteredLook, EffectiveSample, Sample, ScoredLook, clustered_test_above, clustered_test_below,
    continued_above, continued_below, continued_clusters_above, continued_clusters_below,
};

/// p-values of "the rate is below the threshold" and "the rate is at least as high"; 1 of what is not counted.
pub(crate) fn doubts(belief: &Belief, threshold: f64) -> (f64, f64) {
    doubts_of(&looks(belief), threshold)
}

/// The least of both at any look before this one: what was shown then, whether or not all trials together show it.
pub(crate) fn least_before(belief: &Belief, threshold: f64) -> (f64, f64) {
    let looks = looks(belief);
    let before = (1..looks.len()).map(|count| doubts_of(&looks[..count], threshold));
    before.fold((1.0, 1.0), |least, one| {
        (least.0.min(one.0), least.1.min(one.1))
    })
}

fn doubts_of(looks: &[CountsAtLook], threshold: f64) -> (f64, f64) {
    if looks.iter().all(CountsAtLook::is_independent) {
        let samples: Vec<Sample> = looks.iter().map(|look| look.sample).collect();
        let now = looks.last();
        let by_cluster = now.map_or((0.0, 0.0), |now| now.doubts_by_cluster(threshold));
        let above = continued_above(&samples, threshold).max(by_cluster.0);
        let below = continued_below(&samples, threshold).max(by_cluster.1);
        return (above, below);
    }
    let by_cluster = looks.iter().map(|look| look.doubts_by_cluster(threshold));
    let by_cluster: Vec<(f64, f64)> = by_cluster.collect();
    let clustered = |test: fn(EffectiveSample, f64) -> f64, of: fn(&(f64, f64)) -> f64| {
        let pairs = looks.iter().zip(&by_cluster);
        let clustered = pairs.map(|(look, by_cluster)| ClusteredLook {
            clusters: look.clusters.as_ref().and_then(|it| it.found()),
            scored: ScoredLook {
                p: test(look.effective, threshold).max(of(by_cluster)),
                information: look.sample.trials as f64,
            },
        });
        clustered.collect::<Vec<_>>()
    };
    let below = if threshold >= 1.0 {
        1.0
    } else {
        continued_clusters_above(&clustered(clustered_test_above, |it| it.0), threshold)
    };
    let at_least = if threshold <= 0.0 {
        1.0
    } else {
        continued_clusters_below(&clustered(clustered_test_below, |it| it.1), threshold)
    };
    (below, at_least)
}

/// All looks, the present one last.
fn looks(belief: &Belief) -> Vec<CountsAtLook> {
    let before = match belief {
        Belief::Counts {
            before: Some(before),
            ..
        } => before.to_vec(),
        _ => Vec::new(),
    };
    before.into_iter().chain(belief.counts()).collect()
}

/// The counts after further trials, at these counts in independent trials, looked at again.
pub(crate) fn after(now: &Belief, then: EffectiveSample) -> Belief {
    let Belief::Counts {
        sample, effective, ..
    } = now
    else {
        return now.clone();
    };
    let effect = (sample.trials as f64 / effective.trials).max(1.0);
    let trials = (then.trials * effect).round() as u64;
    let successes = (then.successes * effect).round() as u64;
    let counts = Sample {
        successes: successes.min(trials),
        trials,
    };
    let is_independent = effective.trials >= sample.trials as f64;
    Belief::Counts {
        sample: counts,
        effective: if is_independent { counts.into() } else { then },
        clusters: None,
        before: Some(looks(now).into()),
        completions: None,
    }
}

/// The number of the present look.
pub(crate) fn number(belief: &Belief) -> u64 {
    looks(belief).len() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conclude::of_tests;
    use stats::{Confidence, Interval, continued_interval};

    fn limits(belief: &Belief, error: f64) -> crate::Interval {
        of_tests(
            |rate| doubts(belief, rate),
            belief.estimate(),
            (error, error),
        )
    }

    fn looked_at(looks: &[(u64, u64, Option<f64>)]) -> Belief {
        let of = |look: &(u64, u64, Option<f64>)| {
            Belief::of_counts(look.0, look.1, look.2).expect("counts")
        };
        let (now, before) = looks.split_last().expect("a look");
        let before: Vec<Option<Belief>> = before.iter().map(|look| Some(of(look))).collect();
        of(now).looked_at(&before)
    }

    #[test]
    fn limits_are_those_of_continued_counts() {
        let belief = looked_at(&[(17, 20, None), (45, 50, None), (93, 100, None)]);
        let samples =
            [(17, 20), (45, 50), (93, 100)].map(|(successes, trials)| Sample { successes, trials });
        let expected = continued_interval(&samples, Confidence::P95);
        let found = Interval {
            low: limits(&belief, 0.025).low,
            high: limits(&belief, 0.025).high,
        };
        assert!(
            (found.low - expected.low).abs() < 1e-9,
            "{found} {expected}"
        );
        assert!(
            (found.high - expected.high).abs() < 1e-9,
            "{found} {expected}"
        );
        assert_eq!(number(&belief), 3);
    }

    /// What a plan asks of further trials is what will be concluded from them.
    #[test]
    fn further_trials_are_judged_as_they_will_be() {
        let now = looked_at(&[(17, 20, None), (45, 50, None)]);
        let then = EffectiveSample {
            successes: 93.0,
            trials: 100.0,
        };
        let later = looked_at(&[(17, 20, None), (45, 50, None), (93, 100, None)]);
        assert_eq!(doubts(&after(&now, then), 0.85), doubts(&later, 0.85));
    }

    #[test]
    fn correlated_trials_say_less_and_looks_cost() {
        let plain = looked_at(&[(88, 100, None)]);
        let alike = looked_at(&[(88, 100, Some(40.0))]);
        let again = looked_at(&[(44, 50, Some(20.0)), (88, 100, Some(40.0))]);
        let low = |belief: &Belief| limits(belief, 0.05).low;
        assert!(low(&alike) < low(&plain), "{} {}", low(&alike), low(&plain));
        assert!(low(&again) < low(&alike), "{} {}", low(&again), low(&alike));
        // One failure denies certainty at any look, and no count shows it.
        assert!(doubts(&again, 1.0).1 < 1e-9 && doubts(&again, 1.0).0 >= 1.0);
    }
}
