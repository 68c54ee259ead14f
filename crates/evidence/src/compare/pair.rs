//! The statistics of one pair of rates.

use super::{Belief, Levels};
use stats::power::{Arm, Goal, further_trials};
use stats::{
    BetaPosterior, Confidence, DifferenceVariance, EffectiveSample, Interval, Sample,
    binomial_test_above, binomial_test_below, binomial_test_two_sided, fisher_exact,
    probability_greater, probability_within,
};

/// Two rates that are to be compared at a margin.
pub(super) struct Pair {
    first: Belief,
    second: Belief,
    margin: f64,
}

/// Further trials that would probably decide.
pub(super) struct Plan {
    /// In the first alone: `None` if it has no trials, `Some(None)` if no number would do.
    pub first: Option<Option<u64>>,
    /// In the second alone.
    pub second: Option<Option<u64>>,
    /// In the first and in the second together.
    pub both: Option<(u64, u64)>,
}

impl Pair {
    pub fn new(first: Belief, second: Belief, margin: f64) -> Self {
        Self {
            first,
            second,
            margin,
        }
    }

    /// Second minus first.
    pub fn difference(&self) -> f64 {
        self.second.estimate() - self.first.estimate()
    }

    pub fn difference_interval(&self, confidence: Confidence) -> Interval {
        let side = |belief: &Belief| (belief.estimate(), belief.interval(confidence));
        stats::difference_interval(side(&self.second), side(&self.first))
    }

    /// p-value of "no difference", or twice the smaller posterior tail.
    pub fn p_difference(&self) -> f64 {
        use Belief::{Counts, Known};
        match (&self.first, &self.second) {
            (
                Counts {
                    sample: a,
                    effective: ea,
                },
                Counts {
                    sample: b,
                    effective: eb,
                },
            ) => fisher_at_effective_size((*a, *ea), (*b, *eb)),
            (Counts { sample, effective }, Known { bounds, .. })
            | (Known { bounds, .. }, Counts { sample, effective }) => {
                binomial_at_effective_size(*sample, *effective, bounds)
            }
            (Known { bounds: a, .. }, Known { bounds: b, .. }) => {
                if a.low > b.high || b.low > a.high {
                    0.0
                } else {
                    1.0
                }
            }
            (first, second) => match (first.posterior(), second.posterior()) {
                (Some(a), Some(b)) => posterior_difference(&a, &b),
                (Some(a), None) => tails_beyond(&a, &second.interval(Confidence::P95)),
                (None, Some(b)) => tails_beyond(&b, &first.interval(Confidence::P95)),
                (None, None) => 1.0,
            },
        }
    }

    /// p-value of "the difference is the margin or more"; `None` where a side is a distribution
    /// and a posterior probability takes its place.
    pub fn p_equivalence(&self) -> Option<f64> {
        use Belief::{Counts, Known};
        match (&self.first, &self.second) {
            (Counts { effective: a, .. }, Counts { effective: b, .. }) => {
                stats::tost(*a, *b, self.margin, DifferenceVariance::AgrestiCaffo)
                    .map(|tost| tost.p_value())
            }
            (Counts { effective, .. }, Known { bounds, .. })
            | (Known { bounds, .. }, Counts { effective, .. }) => {
                Some(exact_tost(*effective, bounds, self.margin))
            }
            (Known { bounds: a, .. }, Known { bounds: b, .. }) => {
                Some(if within_for_certain(a, b, self.margin) {
                    0.0
                } else {
                    1.0
                })
            }
            _ => None,
        }
    }

    /// Posterior probability that the difference is below the margin.
    pub fn probability_within(&self) -> f64 {
        let bounds = |belief: &Belief| belief.interval(Confidence::P95);
        match (self.first.posterior(), self.second.posterior()) {
            (Some(a), Some(b)) => probability_within(&a, &b, self.margin),
            (Some(a), None) => near(&a, &bounds(&self.second), self.margin),
            (None, Some(b)) => near(&b, &bounds(&self.first), self.margin),
            (None, None) => {
                let (a, b) = (bounds(&self.first), bounds(&self.second));
                f64::from(u8::from(within_for_certain(&a, &b, self.margin)))
            }
        }
    }

    /// Whether agreement within the margin is shown at this level.
    pub fn shows_agreement(&self, level: Confidence) -> bool {
        match self.p_equivalence() {
            Some(p) => p <= level.alpha(),
            None => self.probability_within() >= level.level(),
        }
    }

    /// Trials that would show agreement or a difference, whichever takes fewer, if the rates seen
    /// are the true ones. Conflicts are planned at Bonferroni's level for the number of
    /// comparisons, which is a little more than Holm's correction asks for. Plans by normal theory
    /// are raised until the tests that decide would decide at the expected counts.
    pub fn plan(&self, levels: &Levels, family: usize) -> Plan {
        let arms = (self.first.arm(), self.second.arm());
        let effects = (self.first.design_effect(), self.second.design_effect());
        let agreement = (
            Goal::Equivalence {
                margin: self.margin,
            },
            levels.agreement,
        );
        let conflict = (Goal::Difference, levels.confidence.simultaneous(family));
        let plans: Vec<Needed> = [agreement, conflict]
            .into_iter()
            .filter_map(|(goal, level)| {
                let plan = needed(goal, arms, effects, level, levels.power)?;
                Some(self.raised(plan, goal, level))
            })
            .collect();
        let fewest = |pick: fn(&Needed) -> Option<u64>| plans.iter().filter_map(pick).min();
        Plan {
            first: effects.0.map(|_| fewest(|plan| plan.first)),
            second: effects.1.map(|_| fewest(|plan| plan.second)),
            both: plans
                .iter()
                .filter_map(|plan| plan.both)
                .min_by_key(|both| both.0 + both.1),
        }
    }
}

impl Pair {
    /// The plan with sizes at which the goal's own test decides, if the rates stay as they are.
    fn raised(&self, plan: Needed, goal: Goal, level: Confidence) -> Needed {
        let decides = |first: u64, second: u64| {
            let extended = Self::new(
                extended(&self.first, first),
                extended(&self.second, second),
                self.margin,
            );
            match goal {
                Goal::Equivalence { .. } => extended.shows_agreement(level),
                Goal::Difference => extended.p_difference() <= level.alpha(),
            }
        };
        let both = plan.both.and_then(|(first, second)| {
            let of = |factor: f64, trials: u64| (trials as f64 * factor).ceil() as u64;
            let factors =
                std::iter::successors(Some(1.0), |f| (*f < MOST_RAISED).then_some(f * STEP));
            factors
                .map(|f| (of(f, first), of(f, second)))
                .find(|(first, second)| decides(*first, *second))
        });
        Needed {
            first: plan.first.and_then(|n| raise(n, |n| decides(n, 0))),
            second: plan.second.and_then(|n| raise(n, |n| decides(0, n))),
            both,
        }
    }
}

/// By how much a plan is raised at a time, and at most.
const STEP: f64 = 1.25;
const MOST_RAISED: f64 = 1e4;

/// The first size from `planned` on, in steps, for which the test decides.
fn raise(planned: u64, decides: impl Fn(u64) -> bool) -> Option<u64> {
    let most = (planned.max(100) as f64 * MOST_RAISED) as u64;
    let next = |n: &u64| (*n < most).then_some((*n as f64 * STEP).ceil() as u64 + 1);
    std::iter::successors(Some(planned), next).find(|n| decides(*n))
}

/// The belief after `extra` more trials at the same rate and with the same clustering.
fn extended(belief: &Belief, extra: u64) -> Belief {
    let Belief::Counts { sample, effective } = belief else {
        return belief.clone();
    };
    let trials = sample.trials.saturating_add(extra);
    let growth = trials as f64 / sample.trials as f64;
    let successes = ((sample.successes as f64 * growth).round() as u64).min(trials);
    let more = Sample { successes, trials };
    match EffectiveSample::at_size(more, effective.trials * growth) {
        Ok(effective) => Belief::Counts {
            sample: more,
            effective,
        },
        Err(_) => belief.clone(),
    }
}

/// Trials that one goal needs, as trials (not independent ones).
struct Needed {
    first: Option<u64>,
    second: Option<u64>,
    both: Option<(u64, u64)>,
}

fn needed(
    goal: Goal,
    arms: (Arm, Arm),
    effects: (Option<f64>, Option<f64>),
    level: Confidence,
    power: f64,
) -> Option<Needed> {
    let plan = further_trials(goal, arms.0, arms.1, level, power).ok()?;
    let trials = |independent: u64, effect: f64| (independent as f64 * effect).ceil() as u64;
    let alone = |independent: Option<u64>, effect: Option<f64>| Some(trials(independent?, effect?));
    let both = || {
        let independent = plan.both?;
        Some((
            trials(independent, effects.0?),
            trials(independent, effects.1?),
        ))
    };
    Some(Needed {
        first: alone(plan.first, effects.0),
        second: alone(plan.second, effects.1),
        both: both(),
    })
}

fn fisher_at_effective_size(
    first: (Sample, EffectiveSample),
    second: (Sample, EffectiveSample),
) -> f64 {
    let second = Belief::whole_counts(second.0, second.1);
    Belief::whole_counts(first.0, first.1)
        .into_iter()
        .flat_map(|a| second.iter().map(move |b| fisher_exact(a, *b)))
        .fold(0.0, f64::max)
}

/// The two-sided exact test against the bound nearest to the rate.
fn binomial_at_effective_size(
    sample: Sample,
    effective: EffectiveSample,
    bounds: &Interval,
) -> f64 {
    let rate = effective.successes / effective.trials;
    let nearest = rate.max(bounds.low).min(bounds.high);
    Belief::whole_counts(sample, effective)
        .into_iter()
        .map(|whole| binomial_test_two_sided(whole, nearest))
        .fold(0.0, f64::max)
}

fn posterior_difference(first: &BetaPosterior, second: &BetaPosterior) -> f64 {
    let (above, below) = (
        probability_greater(first, second),
        probability_greater(second, first),
    );
    (2.0 * above.min(below)).min(1.0)
}

/// Twice the smaller posterior probability of lying beyond the bounds.
fn tails_beyond(posterior: &BetaPosterior, bounds: &Interval) -> f64 {
    (2.0 * posterior.cdf(bounds.high).min(posterior.sf(bounds.low))).min(1.0)
}

/// Two one-sided exact tests of a count against a probability between bounds.
fn exact_tost(sample: EffectiveSample, bounds: &Interval, margin: f64) -> f64 {
    let (floor, ceiling) = (bounds.high - margin, bounds.low + margin);
    let not_below = if floor < 0.0 {
        0.0
    } else {
        binomial_test_above(sample, floor)
    };
    let not_above = if ceiling > 1.0 {
        0.0
    } else {
        binomial_test_below(sample, ceiling)
    };
    not_below.max(not_above)
}

/// Probability of being within the margin of every value between the bounds.
fn near(posterior: &BetaPosterior, bounds: &Interval, margin: f64) -> f64 {
    posterior.probability_between(bounds.high - margin, bounds.low + margin)
}

fn within_for_certain(first: &Interval, second: &Interval, margin: f64) -> bool {
    first.high - second.low < margin && second.high - first.low < margin
}

#[cfg(test)]
mod tests {
    use super::*;
    use stats::special::binomial_pmf;

    fn counts(successes: u64, trials: u64) -> Belief {
        let sample = Sample { successes, trials };
        Belief::Counts {
            sample,
            effective: sample.into(),
        }
    }

    fn known(value: f64) -> Belief {
        Belief::Known {
            value,
            bounds: Interval {
                low: value,
                high: value,
            },
        }
    }

    fn distribution(alpha: f64, beta: f64) -> Belief {
        let posterior = BetaPosterior::new(alpha, beta).unwrap();
        Belief::Distribution {
            value: posterior.mean(),
            posterior,
        }
    }

    /// At the edge of the margin, agreement with a known probability is shown with probability at
    /// most 5 %, by summing over all counts.
    #[test]
    fn false_agreement_with_a_known_probability_is_rare() {
        for (value, margin) in [(0.9, 0.1), (1.0, 0.05), (0.5, 0.2), (0.03, 0.1)] {
            for truth in [value - margin, value + margin] {
                for trials in [1_u64, 10, 59, 200] {
                    if !(0.0..=1.0).contains(&truth) {
                        continue;
                    }
                    let shown = |s: &u64| {
                        let pair = Pair::new(counts(*s, trials), known(value), margin);
                        pair.shows_agreement(Confidence::P95)
                    };
                    let chance: f64 = (0..=trials)
                        .filter(shown)
                        .map(|s| binomial_pmf(s, trials, truth))
                        .sum();
                    assert!(
                        chance <= 0.05 + 1e-9,
                        "{value} {margin} {truth} {trials}: {chance}"
                    );
                }
            }
        }
    }

    /// Without a difference, one is found with probability at most 5 %, by summing over all pairs
    /// of counts.
    #[test]
    fn false_differences_between_counts_are_rare() {
        let (n, m) = (12_u64, 20_u64);
        for truth in [0.02, 0.3, 0.5, 0.88] {
            let mut chance = 0.0;
            for a in 0..=n {
                for b in 0..=m {
                    let pair = Pair::new(counts(a, n), counts(b, m), 0.1);
                    if pair.p_difference() <= 0.05 {
                        chance += binomial_pmf(a, n, truth) * binomial_pmf(b, m, truth);
                    }
                }
            }
            assert!(chance <= 0.05, "{truth}: {chance}");
        }
    }

    #[test]
    fn known_probabilities_agree_or_differ_for_certain() {
        let bounded = Belief::Known {
            value: 0.5,
            bounds: Interval {
                low: 0.49,
                high: 0.51,
            },
        };
        let near = Pair::new(known(0.52), bounded.clone(), 0.05);
        assert_eq!(
            (near.p_difference(), near.p_equivalence()),
            (0.0, Some(0.0))
        );
        let same = Pair::new(known(0.5), bounded.clone(), 0.05);
        assert_eq!((same.p_difference(), same.probability_within()), (1.0, 1.0));
        let vague = Pair::new(known(0.5), bounded, 0.005);
        assert!(!vague.shows_agreement(Confidence::P95));
    }

    #[test]
    fn distributions_are_judged_by_their_posterior() {
        let pair = Pair::new(known(1.0), distribution(86.7, 13.3), 0.1);
        assert_eq!(pair.p_difference(), 0.0);
        assert_eq!(pair.p_equivalence(), None);
        assert!(!pair.shows_agreement(Confidence::P95));
        let same = Pair::new(distribution(500.0, 500.0), distribution(500.0, 500.0), 0.1);
        assert!((same.p_difference() - 1.0).abs() < 1e-9);
        assert!(same.shows_agreement(Confidence::P95));
    }

    #[test]
    fn clustering_makes_both_claims_harder() {
        let sample = Sample {
            successes: 88,
            trials: 100,
        };
        let effective = EffectiveSample::at_size(sample, 55.0).unwrap();
        let clustered = || Belief::Counts { sample, effective };
        for other in [counts(439, 500), known(0.95), counts(60, 100)] {
            let plain = Pair::new(counts(88, 100), other.clone(), 0.1);
            let cautious = Pair::new(clustered(), other, 0.1);
            assert!(cautious.p_difference() >= plain.p_difference());
            // Beyond the margin there is nothing to show, and less certainty looks like less of it.
            if plain.difference().abs() < 0.1 {
                assert!(cautious.p_equivalence() > plain.p_equivalence());
            }
        }
    }

    #[test]
    fn plans_speak_of_trials_and_only_of_sides_that_have_them() {
        let levels = Levels::new(0.95, 0.95).unwrap();
        let plan = Pair::new(counts(88, 100), counts(439, 500), 0.05).plan(&levels, 10);
        assert_eq!(
            plan.second,
            Some(None),
            "the experiment's own variance is too large"
        );
        let (first, second) = plan.both.unwrap();
        assert_eq!(first, second);
        let sample = Sample {
            successes: 88,
            trials: 100,
        };
        let effective = EffectiveSample::at_size(sample, 50.0).unwrap();
        let clustered = Belief::Counts { sample, effective };
        let doubled = Pair::new(clustered, known(0.88), 0.05).plan(&levels, 10);
        assert_eq!(doubled.second, None);
        assert_eq!(doubled.both, None);
        // (z_.95 + z_.9)^2 p q / m^2 = 399.1 independent trials, with p = 45/52 for the variance,
        // of which there are 50; two trials are worth one.
        assert_eq!(doubled.first, Some(Some(700)));
    }
}
