//! Every public function that takes counts, with every count that fits into 64 bits, contradictory ones among them: a value
//! in its range or an error, never a panic, and nothing whose work grows with the size of a number (which would not end here).

use stats::*;

const COUNTS: [u64; 13] = [
    0,
    1,
    2,
    3,
    1000,
    1 << 31,
    1 << 32,
    (1 << 53) - 1,
    1 << 53,
    (1 << 53) + 1,
    1 << 63,
    u64::MAX - 1,
    u64::MAX,
];

/// All pairs of counts: also more successes than trials.
fn samples() -> Vec<Sample> {
    let of = |trials| COUNTS.map(move |successes| Sample { successes, trials });
    COUNTS.into_iter().flat_map(of).collect()
}

/// A few of them, for functions of several.
fn some_samples() -> Vec<Sample> {
    let pairs = [
        (0, 0),
        (1, 1),
        (3, 9),
        (3, MOST_TRIALS),
        (1 << 52, MOST_TRIALS),
        (MOST_TRIALS, MOST_TRIALS),
        (3, MOST_TRIALS + 1),
        (1 << 63, 1 << 63),
        (u64::MAX, 3),
        (u64::MAX, u64::MAX),
    ];
    let of = |(successes, trials)| Sample { successes, trials };
    pairs.map(of).to_vec()
}

fn pairs() -> impl Iterator<Item = (Sample, Sample)> {
    let all = some_samples();
    let of = move |first: Sample| all.clone().into_iter().map(move |second| (first, second));
    some_samples().into_iter().flat_map(of)
}

fn probability(found: f64, what: &str) {
    assert!((-1e-12..=1.0 + 1e-9).contains(&found), "{what}: {found}");
}

fn within(interval: Interval, low: f64, high: f64, what: &str) {
    let is_ordered = interval.low <= interval.high;
    assert!(
        is_ordered && interval.low >= low && interval.high <= high,
        "{what}: {interval}"
    );
}

const LEVEL: Confidence = Confidence::P95;
const THRESHOLDS: [f64; 4] = [0.0, 0.05, 0.5, 1.0];

#[test]
fn too_many_trials_are_refused_and_say_nothing() {
    for trials in [MOST_TRIALS + 1, u64::MAX] {
        let refused = Sample::new(3, trials).unwrap_err();
        assert!(
            refused.to_string().contains("at most 2^53 trials"),
            "{refused}"
        );
        let counted = Sample {
            successes: 3,
            trials,
        };
        assert!(!counted.is_informative() && counted.rate().is_none());
        assert_eq!(wilson(counted, LEVEL), Interval::VACUOUS);
        assert_eq!(binomial_test_two_sided(counted, 0.5), 1.0);
    }
    assert!(Sample::new(3, MOST_TRIALS).is_ok());
    let most = Sample::new(1, MOST_TRIALS).unwrap();
    assert!(pool(&[most, most]).is_err());
}

#[test]
fn one_rate() {
    for sample in samples() {
        let what = sample.to_string();
        for method in IntervalMethod::ALL {
            let found = method.interval(sample, LEVEL);
            within(found, 0.0, 1.0, &format!("{} of {what}", method.name()));
        }
        within(confidence_sequence(sample, LEVEL), 0.0, 1.0, &what);
        for threshold in THRESHOLDS {
            let what = format!("{what} against {threshold}");
            probability(binomial_test_below(sample, threshold), &what);
            probability(binomial_test_above(sample, threshold), &what);
            probability(binomial_test_two_sided(sample, threshold), &what);
            // At the ends one side of the threshold holds no rate.
            if (0.01..=0.99).contains(&threshold) {
                let test = SequentialTest::new(threshold, LEVEL).unwrap();
                assert!(!test.ln_evidence_below(sample).is_nan(), "{what}");
                assert!(!test.ln_evidence_at_least(sample).is_nan(), "{what}");
                let says_nothing = test.decide(sample) == Decision::Open;
                assert!(sample.is_informative() || says_nothing, "{what}");
            }
        }
    }
}

#[test]
fn what_is_said_of_a_rate_besides() {
    for sample in samples() {
        let what = sample.to_string();
        probability(constant_by_chance(sample, 0.5, 0.01), &what);
        let posterior = BetaPosterior::jeffreys(sample);
        probability(posterior.mean(), &what);
        within(posterior.credible_interval(LEVEL), 0.0, 1.0, &what);
        if sample.is_informative() {
            probability(count_by_chance(sample), &what);
            probability(quotient_by_chance(sample), &what);
        }
        for worth in [1.0, 1e9, 2e19] {
            if let Ok(worth) = EffectiveSample::at_size(sample, worth) {
                assert!(!whole_counts(sample, worth).is_empty(), "{what}");
            }
        }
        for further in [0, 1, 1 << 53, u64::MAX] {
            let next = Predictive::new(&posterior, further);
            let middle = next.quantile(0.5);
            assert!(middle <= further, "{what}, {further}");
            probability(next.cdf(middle), &what);
            assert!(next.representatives(5).len() <= 5, "{what}, {further}");
        }
    }
}

#[test]
fn two_rates() {
    for (one, other) in pairs() {
        let what = format!("{one} and {other}");
        probability(fisher_exact(one, other), &what);
        probability(boschloo_exact(one, other), &what);
        for margin in [1e-6, 0.05, 0.5] {
            let found = exact_equivalence(one, other, margin);
            probability(found.unwrap_or(1.0), &what);
            let found = score_equivalence(one, other, margin);
            probability(found.unwrap_or(1.0), &what);
            for variance in [DifferenceVariance::Wald, DifferenceVariance::AgrestiCaffo] {
                let found = tost(one, other, margin, variance);
                probability(found.map_or(1.0, |it| it.p_value()), &what);
            }
        }
        let ends = [one, one];
        within(time_uniform_limits(ends, LEVEL), 0.0, 1.0, &what);
        let test = IndifferenceTest::new(0.9, 0.02, LEVEL).unwrap();
        let says_nothing = test.decide(ends) == Decision::Open;
        assert!(one.is_informative() || says_nothing, "{what}");
        let further = test.further_trials(ends);
        assert!(further.is_none_or(|it| it > 0), "{what}");
        let chance = product_by_chance(ends, false, 0.5, 0.01);
        probability(chance.map_or(0.0, |(chance, _)| chance), &what);
    }
}

#[test]
fn pairs_of_trials() {
    for all in COUNTS {
        for first in COUNTS {
            for second in COUNTS {
                let what = format!("{all} pairs, {first} and {second}");
                let pairs = Pairs {
                    pairs: all,
                    only_first: first,
                    only_second: second,
                };
                probability(pairs.p_value(), &what);
                let fits = first.checked_add(second).is_some_and(|it| it <= all);
                if fits {
                    within(pairs.interval(LEVEL), -1.0, 1.0, &what);
                    let change = pairs.difference().unwrap_or(0.0);
                    assert!((-1.0..=1.0).contains(&change), "{what}: {change}");
                }
            }
        }
    }
}

#[test]
fn several_samples() {
    for (one, other) in pairs() {
        let what = format!("{one} and {other}");
        for all in [vec![one, other], vec![one, other, one, other]] {
            if let Ok(found) = clustered_rate(&all, LEVEL) {
                within(found.interval, 0.0, 1.0, &what);
            }
            if let Ok(found) = clustering(&all) {
                probability(found.p_value, &what);
            }
            if let Ok(found) = ClusterRobust::of(&all) {
                within(found.interval(LEVEL), 0.0, 1.0, &what);
            }
            if let Ok(found) = heterogeneity(&all) {
                probability(found.p_value, &what);
                within(found.random.interval(LEVEL), 0.0, 1.0, &what);
            }
            if let Ok(found) = chi_squared_homogeneity(&all) {
                probability(found.p_value, &what);
            }
            drop(outlier(&all));
            drop(CommonCorrelation::of(&[all.as_slice()]));
            probability(rows_by_chance(&all, &all), &what);
            probability(alike_in_order(&all).unwrap_or(1.0), &what);
            let labels: Vec<usize> = (0..all.len()).collect();
            probability(alike_by_label(&all, &labels).unwrap_or(1.0), &what);
            for threshold in [0.05, 0.95] {
                probability(continued_above(&all, threshold), &what);
                probability(continued_below(&all, threshold), &what);
            }
            within(continued_interval(&all, LEVEL), 0.0, 1.0, &what);
        }
    }
}
