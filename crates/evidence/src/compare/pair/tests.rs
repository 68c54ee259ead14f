use super::super::belief::samples::{counts, known};
use super::*;
use stats::special::binomial_pmf;

fn distribution(alpha: f64, beta: f64) -> Belief {
    let posterior = BetaPosterior::new(alpha, beta).unwrap();
    Belief::Distribution {
        value: posterior.mean(),
        posterior,
        quantiles: None,
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
        is_range: false,
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
    let clustered = || Belief::Counts {
        clusters: None,
        sample,
        effective,
        before: None,
        completions: None,
    };
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

fn range(low: f64, high: f64) -> Belief {
    Belief::Known {
        value: low,
        bounds: Interval { low, high },
        is_range: true,
    }
}

/// Counts differ from a decision process beyond chance, or agree with it, each with probability at most 5 % where it
/// is not so: at an end of the range, and a margin beyond it, by summing over all counts.
#[test]
fn false_claims_about_a_range_are_rare() {
    for (low, high, margin) in [
        (0.6, 0.9, 0.1),
        (0.0, 0.5, 0.05),
        (0.93, 1.0, 0.1),
        (0.6, 0.68, 0.1),
    ] {
        let pair = |s: u64, trials| Pair::new(counts(s, trials), range(low, high), margin);
        for trials in [1_u64, 10, 59, 200] {
            let chance = |truth: f64, claim: &dyn Fn(&Pair) -> bool| -> f64 {
                let claimed = (0..=trials).filter(|s| claim(&pair(*s, trials)));
                claimed.map(|s| binomial_pmf(s, trials, truth)).sum()
            };
            for truth in [low, 0.5 * (low + high), high] {
                let conflict = chance(truth, &|pair| pair.p_difference() <= 0.05);
                assert!(conflict <= 0.05 + 1e-9, "{truth} {trials}: {conflict}");
            }
            for truth in [low - margin, high + margin] {
                if (0.0..=1.0).contains(&truth) {
                    let agree = chance(truth, &|p| p.shows_agreement(Confidence::P95));
                    assert!(agree <= 0.05 + 1e-9, "{truth} {trials}: {agree}");
                }
            }
        }
    }
}

#[test]
fn ranges_are_compared_by_their_nearest_values() {
    let inside = Pair::new(counts(75, 100), range(0.6, 0.9), 0.05);
    assert_eq!((inside.difference(), inside.p_difference()), (0.0, 1.0));
    // Some scheduler is as near as can be, others are farther away than the margin.
    assert!(!inside.shows_agreement(Confidence::P95));
    let narrow = Pair::new(counts(75, 100), range(0.7, 0.8), 0.12);
    assert!(narrow.shows_agreement(Confidence::P95));
    let below = Pair::new(range(0.6, 0.9), counts(40, 100), 0.05);
    assert!((below.difference() + 0.2).abs() < 1e-12);
    assert!(below.p_difference() < 1e-3);
    let apart = Pair::new(range(0.1, 0.2), range(0.5, 0.9), 0.05);
    assert!((apart.difference() - 0.3).abs() < 1e-12);
    assert_eq!(apart.p_difference(), 0.0);
    // That they overlap does not make them agree.
    let overlap = Pair::new(range(0.1, 0.6), range(0.5, 0.9), 0.05);
    assert_eq!((overlap.difference(), overlap.p_difference()), (0.0, 1.0));
    assert!(!overlap.shows_agreement(Confidence::P95));
    let same = Pair::new(range(0.1, 0.6), range(0.12, 0.58), 0.05);
    assert!(same.shows_agreement(Confidence::P95));
    let point = Pair::new(known(0.62), range(0.57, 0.6), 0.05);
    assert!(point.shows_agreement(Confidence::P95));
    assert!((point.difference() + 0.02).abs() < 1e-12);
    let wide = Pair::new(known(0.62), range(0.1, 0.6), 0.05);
    assert!(!wide.shows_agreement(Confidence::P95));
}

/// A constant that was set to a few trials knows no more than these: what they do not show beside others, it does not.
#[test]
fn a_number_that_was_set_to_counts_differs_no_more_than_the_counts() {
    let set_to = |successes, trials| {
        let sample = Sample::new(successes, trials).expect("counts");
        let posterior = stats::BetaPosterior::jeffreys(sample);
        Belief::Distribution {
            value: successes as f64 / trials as f64,
            posterior,
            quantiles: None,
        }
    };
    for ((a, n), (b, m)) in [
        ((5, 5), (36, 60)),
        ((5, 5), (33, 60)),
        ((1, 5), (0, 60)),
        ((1, 1), (0, 30)),
    ] {
        let counted = Pair::new(counts(a, n), counts(b, m), 0.1).p_difference();
        let set = Pair::new(set_to(a, n), counts(b, m), 0.1).p_difference();
        assert!(set >= counted * 0.999, "{a}/{n} {b}/{m}: {set} {counted}");
    }
}
