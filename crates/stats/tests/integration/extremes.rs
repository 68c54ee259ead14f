//! Intervals and tests of counts at the ends of their range and of the sizes that are met: 0 of n, n of n, from five
//! trials to a hundred million. Numbers by scipy 1.17.

use stats::*;

const MANY: u64 = 100_000_000;

fn sample(successes: u64, trials: u64) -> Sample {
    Sample::new(successes, trials).unwrap()
}

fn close(found: f64, expected: f64, what: &str) {
    let scale = expected.abs().max(1e-300);
    assert!(
        (found - expected).abs() <= 1e-9 * scale || found == expected,
        "{what}: {found:e}, expected {expected:e}"
    );
}

/// `binomtest(s, n).proportion_ci(method="wilson")` and, for Clopper and Pearson's, `beta.ppf` and `beta.isf`. Upper
/// limits are held by their distance from 1, which is what rounding would spoil.
#[test]
fn intervals_of_one_rate() {
    let cases = [
        (0, 5, [0.0, 0.43448246478317476], [0.0, 0.5218237501049815]),
        (
            2,
            5,
            [0.11762077423264794, 0.769275718723987],
            [0.052744950526316906, 0.8533672003653269],
        ),
        (
            0,
            MANY,
            [0.0, 3.841458673126072e-8],
            [0.0, 3.6888793860747784e-8],
        ),
        (
            3,
            MANY,
            [1.0202707334903538e-8, 8.821187709148198e-8],
            [6.186721271685465e-9, 8.767272822906881e-8],
        ),
        (
            MANY / 2,
            MANY,
            [0.49990200180265526, 0.5000979981973447],
            [0.4999019968019593, 0.5000980031980407],
        ),
    ];
    for (successes, trials, by_wilson, by_clopper_pearson) in cases {
        let (one, other) = (
            sample(successes, trials),
            sample(trials - successes, trials),
        );
        for (method, expected) in [
            (IntervalMethod::Wilson, by_wilson),
            (IntervalMethod::ClopperPearson, by_clopper_pearson),
        ] {
            let what = format!("{} of {successes} of {trials}", method.name());
            let found = method.interval(one, Confidence::P95);
            close(found.low, expected[0], &what);
            close(found.high, expected[1], &what);
            // The other outcome mirrors it, as far as numbers near 1 can.
            let mirrored = method.interval(other, Confidence::P95);
            assert!((1.0 - mirrored.high - expected[0]).abs() < 1e-15, "{what}");
            assert!((1.0 - mirrored.low - expected[1]).abs() < 1e-15, "{what}");
        }
    }
}

/// `binom.cdf(s, n, t)` and `binom.sf(s - 1, n, t)`.
#[test]
fn tests_of_one_rate() {
    for (successes, trials, threshold, below, above) in [
        (0, 5, 0.3, 0.16807, 1.0),
        (5, 5, 0.9, 1.0, 0.59049),
        (2, 5, 0.4, 0.68256, 0.66304),
        (0, MANY, 1e-8, 0.36787943933204503, 1.0),
        (3, MANY, 1e-8, 0.9810118437369786, 0.08030139615169558),
        (
            50_010_000,
            MANY,
            0.5,
            0.9772552668785531,
            0.022755531314786137,
        ),
    ] {
        let what = format!("{successes} of {trials} against {threshold}");
        let counted = sample(successes, trials);
        let (found_below, found_above) = (
            binomial_test_below(counted, threshold),
            binomial_test_above(counted, threshold),
        );
        assert!(
            (found_below / below - 1.0).abs() < 1e-7,
            "{what}: {found_below}"
        );
        assert!(
            (found_above / above - 1.0).abs() < 1e-7,
            "{what}: {found_above}"
        );
        let two_sided = binomial_test_two_sided(counted, threshold);
        assert!((0.0..=1.0).contains(&two_sided), "{what}: {two_sided}");
    }
}

/// `fisher_exact`, `boschloo_exact`; of a hundred million, twice the hypergeometric chance that all five are in the second.
#[test]
fn tests_of_two_rates() {
    let fisher = |a, b, c, d| fisher_exact(sample(a, b), sample(c, d));
    close(
        fisher(0, 5, 5, 5),
        0.007936507936507938,
        "0 of 5 and 5 of 5",
    );
    close(fisher(5, 5, 3, 5), 0.4444444444444445, "5 of 5 and 3 of 5");
    close(fisher(0, 5, 0, 5), 1.0, "nothing at all");
    let rare = fisher(0, MANY, 5, MANY);
    assert!((rare / 0.06249999642015481 - 1.0).abs() < 1e-7, "{rare}");
    let boschloo = boschloo_exact(sample(0, 5), sample(5, 5));
    assert!((boschloo / 0.001953125 - 1.0).abs() < 1e-6, "{boschloo}");
    assert_eq!(boschloo_exact(sample(0, MANY), sample(5, MANY)), rare);
}

/// What has no closed form to hold it against stays within its range, and certainty grows with the trials.
#[test]
fn everything_else_stays_in_its_range() {
    let probability = |p: f64, what: &str| assert!((0.0..=1.0).contains(&p), "{what}: {p}");
    for trials in [5, 1000, MANY] {
        for (first, second) in [(0, 0), (0, trials), (trials, trials), (trials / 2, trials)] {
            let (one, other) = (sample(first, trials), sample(second, trials));
            let what = format!("{first} and {second} of {trials}");
            for method in [DifferenceVariance::Wald, DifferenceVariance::AgrestiCaffo] {
                let difference = Difference::between(one, other, method).unwrap();
                let interval = difference.interval(Confidence::P95);
                assert!(interval.low >= -1.0 && interval.high <= 1.0, "{what}");
                assert!(interval.low <= interval.high, "{what}");
                probability(difference.p_value(), &what);
                probability(difference.tost(0.1).p_value(), &what);
            }
            probability(score_equivalence(one, other, 0.1).unwrap(), &what);
            let found = heterogeneity(&[one, other]).unwrap();
            probability(found.p_value, &what);
            probability(found.fixed.rate(), &what);
            let sequence = confidence_sequence(one, Confidence::P95);
            let wilson = wilson(one, Confidence::P95);
            assert!(sequence.contains(first as f64 / trials as f64), "{what}");
            assert!(
                sequence.width() >= 0.9 * wilson.width(),
                "{what}: {sequence} {wilson}"
            );
            let pairs = Pairs {
                pairs: trials,
                only_first: first.min(trials - second),
                only_second: second.min(trials - first),
            };
            let interval = pairs.interval(Confidence::P95);
            assert!(interval.low >= -1.0 && interval.high <= 1.0, "{what}");
            probability(pairs.p_value(), &what);
            if trials == MANY {
                // Integrals over posteriors so narrow take minutes.
                continue;
            }
            let posteriors = [one, other].map(BetaPosterior::jeffreys);
            probability(
                probability_within(&posteriors[0], &posteriors[1], 0.1),
                &what,
            );
            probability(probability_greater(&posteriors[0], &posteriors[1]), &what);
        }
    }
    // No difference in a hundred million trials is equivalence, and all the difference is none.
    let (none, all) = (sample(0, MANY), sample(MANY, MANY));
    assert!(score_equivalence(none, none, 1e-6).unwrap() < 1e-10);
    assert!(score_equivalence(none, all, 0.1).unwrap() > 0.999);
    assert!(heterogeneity(&[none, all]).unwrap().p_value < 1e-10);
}
