//! The statistics of one pair of rates.

use super::Belief;
use stats::{
    BetaPosterior, Confidence, DifferenceVariance, EffectiveSample, Interval, Sample,
    binomial_test_above, binomial_test_below, binomial_test_two_sided, boschloo_exact,
    fisher_exact, probability_greater, probability_within,
};

/// Two rates that are to be compared at a margin.
pub(super) struct Pair {
    first: Belief,
    second: Belief,
    margin: f64,
}

impl Pair {
    pub fn new(first: Belief, second: Belief, margin: f64) -> Self {
        Self {
            first,
            second,
            margin,
        }
    }

    /// The same margin for other beliefs.
    pub fn with(&self, first: Belief, second: Belief) -> Self {
        Self::new(first, second, self.margin)
    }

    pub fn first(&self) -> &Belief {
        &self.first
    }

    pub fn second(&self) -> &Belief {
        &self.second
    }

    pub fn margin(&self) -> f64 {
        self.margin
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
            ) => at_effective_size(boschloo_exact, (*a, *ea), (*b, *eb)),
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

    /// Fisher's p-value of "no difference" between two counts: known everywhere, quickly found, and
    /// never below the one that decides.
    pub fn p_by_fisher(&self) -> Option<f64> {
        match (&self.first, &self.second) {
            (
                Belief::Counts {
                    sample: a,
                    effective: ea,
                },
                Belief::Counts {
                    sample: b,
                    effective: eb,
                },
            ) => Some(at_effective_size(fisher_exact, (*a, *ea), (*b, *eb))),
            _ => None,
        }
    }

    /// p-value of "the difference is the margin or more"; `None` where a side is a distribution
    /// and a posterior probability takes its place.
    pub fn p_equivalence(&self) -> Option<f64> {
        use Belief::{Counts, Known};
        match (&self.first, &self.second) {
            (Counts { effective: a, .. }, Counts { effective: b, .. }) => {
                // Each alone errs too often somewhere: the one near the ends, the other for arms of
                // very different size.
                let tost = stats::tost(*a, *b, self.margin, DifferenceVariance::AgrestiCaffo)?;
                let score = stats::score_equivalence(*a, *b, self.margin).unwrap_or(0.0);
                Some(tost.p_value().max(score))
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
}

/// An exact test at the neighbouring whole numbers with the largest p-value.
fn at_effective_size(
    test: fn(Sample, Sample) -> f64,
    first: (Sample, EffectiveSample),
    second: (Sample, EffectiveSample),
) -> f64 {
    let second = Belief::whole_counts(second.0, second.1);
    Belief::whole_counts(first.0, first.1)
        .into_iter()
        .flat_map(|a| second.iter().map(move |b| test(a, *b)))
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
}
