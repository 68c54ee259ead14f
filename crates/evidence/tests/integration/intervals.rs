//! No number lies outside the interval that is shown with it, however skewed its distribution and however few its trials.

use evidence::{CredibleInterval, Guarantee, Measure, MethodAnswer};
use stats::{BetaPosterior, Confidence, Sample, SharesDesign};

fn assert_inside(measure: &Measure, what: &str) {
    let (Some(interval), Some(estimate)) = (measure.interval(), measure.estimate()) else {
        panic!("{what} has a number");
    };
    assert!(
        interval.low <= estimate && estimate <= interval.high,
        "{what}: {estimate} in {interval:?}"
    );
}

fn answer(value: f64, guarantee: Guarantee) -> MethodAnswer {
    MethodAnswer {
        method: "sound".into(),
        value,
        complement: None,
        guarantee,
        iterations: None,
    }
}

#[test]
fn counts_lie_in_their_interval() {
    for trials in [1, 2, 7, 60, 1000] {
        for count in [0, 1, trials / 2, trials - 1, trials] {
            for share in [0.02, 0.3, 1.0] {
                let sample = Sample::new(count, trials).expect("counts");
                let size = Some(trials as f64 * share);
                let measure = Measure::of_counts(sample, size, Confidence::P95).expect("a measure");
                assert_inside(&measure, &format!("{count} of {trials}, {share}"));
            }
        }
    }
    let clusters = [(0, 10), (0, 10), (0, 10), (10, 10)];
    let clusters = clusters.map(|(count, trials)| Sample::new(count, trials).expect("counts"));
    let measure = Measure::of_clusters(&clusters, Confidence::P95).expect("a measure");
    assert_inside(&measure, "clusters");
}

/// A rare event that was not counted once has the constant 0, and a posterior whose central interval is above 0.
#[test]
fn a_computed_probability_lies_in_the_interval_of_its_constants() {
    for (successes, trials) in [(0, 98), (98, 98), (1, 3), (174, 200), (0, 1)] {
        let written = successes as f64 / trials as f64;
        let posterior = [BetaPosterior::jeffreys(Sample { successes, trials })];
        let design = SharesDesign::new(&posterior, 300, 1);
        // A chain with 1, 5 and 200 attempts: ever more skewed.
        for attempts in [1, 5, 200] {
            let of = |p: f64| (1.0 - p).powi(attempts);
            let values: Vec<f64> = design.rows().iter().map(|row| of(row[0])).collect();
            let found = CredibleInterval::of_design(&["p"], &design, &values, Confidence::P95);
            let value = of(written);
            let credible = found.expect("a distribution").beside(value);
            let what = format!("{successes} of {trials}, {attempts} attempts");
            assert!(credible.interval.contains(credible.mean), "{what}: mean");
            assert!(credible.interval.contains(value), "{what}: answer");
            let measure = Measure::Probability {
                answer: answer(value, Guarantee::Exact { rational: None }),
                others: vec![],
                credible: Some(credible),
            };
            assert_inside(&measure, &what);
        }
    }
}

/// A quotient of two answers and its contrary lie within the bounds that both imply, and these have the true value.
#[test]
fn quotients_and_contraries_lie_within_their_bounds() {
    for joint in [0.0, 1e-300, 1e-9, 0.0525, 0.15] {
        for whole in [0.15, 0.5, 1.0] {
            for error in [0.0_f64, 1e-12, 1e-6] {
                let bounded = |value: f64| {
                    let (low, high) = (value * (1.0 - error), (value * (1.0 + error)).min(1.0));
                    answer(value, Guarantee::Bounded { low, high })
                };
                let quotient = bounded(joint).quotient(&bounded(whole));
                for (answer, truth) in [
                    (quotient.clone(), joint / whole),
                    (quotient.contrary(), 1.0 - joint / whole),
                ] {
                    let bounds = answer.bounds().expect("bounds");
                    let what = format!("{joint} / {whole}, {error}: {bounds:?}");
                    assert!(bounds.low <= bounds.high && bounds.high <= 1.0, "{what}");
                    assert!(bounds.contains(answer.value), "{what}: {}", answer.value);
                    assert!(bounds.contains(truth), "{what}: {truth}");
                }
            }
        }
    }
    // What never fails is certain, to the last digit.
    let never = answer(
        0.0,
        Guarantee::Bounded {
            low: 0.0,
            high: 0.0,
        },
    );
    let certain = never
        .quotient(&answer(0.15, Guarantee::Exact { rational: None }))
        .contrary();
    assert_eq!(certain.bounds().map(|b| (b.low, b.high)), Some((1.0, 1.0)));
    assert_eq!(certain.complement, Some(0.0));
}
