//! The test with an indifference zone: its two error rates exactly, and a small version of the simulation of suites.

use std::collections::BTreeMap;

use stats::{Confidence, Decision, IndifferenceTest, Sample, SequentialTest, time_uniform_limits};

#[path = "../../examples/deciding.rs"]
#[allow(dead_code, reason = "the example's own beginning")]
mod example;

fn counts(successes: u64, trials: u64) -> [Sample; 2] {
    [Sample::new(successes, trials).unwrap(); 2]
}

/// The probabilities of each answer within so many trials, by the sum over all paths.
fn answers(test: &IndifferenceTest, rate: f64, most: u64) -> (f64, f64) {
    // The probability of each number of successes among paths that are open.
    let mut open = vec![1.0_f64];
    let (mut passed, mut failed) = (0.0, 0.0);
    for trials in 1..=most {
        let mut next = vec![0.0; trials as usize + 1];
        for (successes, chance) in open.iter().enumerate() {
            next[successes] += chance * (1.0 - rate);
            next[successes + 1] += chance * rate;
        }
        for (successes, chance) in next.iter_mut().enumerate() {
            match test.decide(counts(successes as u64, trials)) {
                Decision::Open => continue,
                Decision::AtLeast => passed += *chance,
                Decision::Below => failed += *chance,
            }
            *chance = 0.0;
        }
        open = next;
    }
    (passed, failed)
}

#[test]
fn both_error_rates_hold_exactly_at_the_edges_of_the_zone() {
    for (threshold, margin, level) in [(0.95, 0.02, 0.95), (0.8, 0.05, 0.9), (0.5, 0.0, 0.95)] {
        let confidence = Confidence::new(level).unwrap();
        let test = IndifferenceTest::new(threshold, margin, confidence).unwrap();
        let zone = test.zone();
        let (false_pass, passes) = (
            answers(&test, zone.low, 600).0,
            answers(&test, zone.high, 600).0,
        );
        let (false_fail, fails) = (
            answers(&test, zone.high, 600).1,
            answers(&test, zone.low, 600).1,
        );
        assert!(
            false_pass <= confidence.alpha(),
            "{threshold}: {false_pass}"
        );
        assert!(
            false_fail <= confidence.alpha(),
            "{threshold}: {false_fail}"
        );
        // Further away still rarer, and the right answer is given if there is a zone.
        assert!(answers(&test, zone.low - 0.02, 600).0 <= false_pass);
        assert!(
            margin == 0.0 || (passes > 0.8 && fails > 0.8),
            "{threshold}: {passes} {fails}"
        );
    }
}

#[test]
fn without_a_margin_it_is_the_test_of_one_threshold() {
    let test = IndifferenceTest::new(0.9, 0.0, Confidence::P95).unwrap();
    let one = SequentialTest::new(0.9, Confidence::P95).unwrap();
    for trials in 1..200 {
        for successes in 0..=trials {
            let sample = Sample::new(successes, trials).unwrap();
            let difference = test.ln_evidence_above(sample) - one.ln_evidence_at_least(sample);
            assert!(difference.abs() < 1e-9, "{sample}: {difference}");
            assert_eq!(test.decide([sample; 2]), one.decide(sample), "{sample}");
        }
    }
}

#[test]
fn unknown_outcomes_count_against_either_answer() {
    let test = IndifferenceTest::new(0.95, 0.02, Confidence::P95).unwrap();
    assert_eq!(test.decide(counts(60, 60)), Decision::AtLeast);
    let unknown = |successes: u64, unknown: u64, failures: u64| {
        let trials = successes + unknown + failures;
        [successes, successes + unknown].map(|successes| Sample::new(successes, trials).unwrap())
    };
    assert_eq!(test.decide(unknown(60, 5, 0)), Decision::Open);
    assert_eq!(test.decide(counts(20, 25)), Decision::Below);
    assert_eq!(test.decide(unknown(20, 5, 0)), Decision::Open);
}

#[test]
fn a_threshold_of_one_is_missed_by_one_failure_and_shown_within_its_margin() {
    let test = IndifferenceTest::new(1.0, 0.05, Confidence::P95).unwrap();
    assert_eq!(test.decide(counts(9, 10)), Decision::Below);
    assert_eq!(test.decide(counts(58, 58)), Decision::Open);
    assert_eq!(test.decide(counts(59, 59)), Decision::AtLeast);
}

#[test]
fn zones_that_reach_beyond_rates_are_refused() {
    for (threshold, margin) in [
        (0.99, 0.01),
        (0.99, 0.02),
        (0.01, 0.01),
        (1.0, 0.0),
        (0.0, 0.0),
        (0.5, -0.1),
    ] {
        let refused = IndifferenceTest::new(threshold, margin, Confidence::P95);
        assert!(refused.is_err(), "{threshold} {margin}");
    }
    for wrong in [f64::NAN, f64::INFINITY] {
        assert!(IndifferenceTest::new(wrong, 0.0, Confidence::P95).is_err());
        assert!(IndifferenceTest::new(0.5, wrong, Confidence::P95).is_err());
    }
}

#[test]
fn so_many_further_trials_decide_it_and_one_less_does_not() {
    let test = IndifferenceTest::new(0.95, 0.02, Confidence::P95).unwrap();
    for (successes, trials) in [(10, 10), (99, 100), (80, 90), (388, 400)] {
        let ends = counts(successes, trials);
        let further = test.further_trials(ends);
        let decided = test.decide(ends) != Decision::Open;
        assert!(
            decided || further.is_some_and(|it| it > 0),
            "{successes}/{trials}"
        );
    }
    // As many as it likes are not enough in the middle of the zone.
    let stuck = IndifferenceTest::new(0.5, 0.1, Confidence::P95).unwrap();
    assert_eq!(stuck.further_trials(counts(500, 1000)), None);
    // Nor where the rate is exactly the threshold: Jeffreys' halves alone are no forecast.
    let exact = IndifferenceTest::new(0.9, 0.0, Confidence::P95).unwrap();
    for (successes, trials) in [(54, 60), (9, 10), (900, 1000)] {
        let at_threshold = counts(successes, trials);
        assert_eq!(exact.decide(at_threshold), Decision::Open);
        assert_eq!(exact.further_trials(at_threshold), None);
    }
    assert!(exact.further_trials(counts(55, 60)).is_some());
    assert!(exact.further_trials(counts(0, 0)).is_some());
    let further = test.further_trials(counts(30, 30)).expect("all succeed");
    let after = |further: u64| {
        let rate = 30.5 / 31.0;
        test.decide(counts(
            30 + (rate * further as f64).round() as u64,
            30 + further,
        ))
    };
    assert_eq!(after(further), Decision::AtLeast);
    assert_eq!(after(further - 1), Decision::Open);
}

#[test]
fn limits_hold_at_all_numbers_of_trials_together() {
    let draws = &mut example::Draws(11);
    for rate in [0.5, 0.93, 0.99] {
        let sequences = 400;
        let mut seen = BTreeMap::new();
        let missed = (0..sequences).filter(|_| {
            let mut successes = 0;
            (1..=300_u64).any(|trials| {
                successes += u64::from(draws.passes(rate));
                let limits = || time_uniform_limits(counts(successes, trials), Confidence::P95);
                !*(seen.entry((successes, trials))).or_insert_with(|| limits().contains(rate))
            })
        });
        // 5 % of 400 are 20; three standard deviations are 13.
        let missed = missed.count();
        assert!(missed <= 33, "{rate}: {missed} of {sequences}");
    }
}

#[test]
fn suites_err_as_seldom_as_declared_and_repeating_until_it_passes_does_not() {
    let table = example::table(400);
    let row = |rate: f64| table.iter().find(|it| it.rate == rate).expect("a row");
    // Three standard errors of 400 tests above 5 %.
    let allowed = 0.05 + 0.033;
    for it in &table {
        assert!(
            it.rate > 0.93 || it.decided.passed <= allowed,
            "{}",
            it.rate
        );
        assert!(
            it.rate < 0.97 || it.decided.failed <= allowed,
            "{}",
            it.rate
        );
    }
    let unlimited = row(0.93).unlimited.expect("an edge");
    assert!(unlimited.passed <= allowed && unlimited.failed > 0.9);
    // 1 - 0.6^5 = 0.922.
    assert!((row(0.4).until_pass.passed - 0.922).abs() < 0.05);
    assert!(row(0.4).decided.passed == 0.0 && row(0.4).decided.failed == 1.0);
    assert!(row(0.4).decided.trials < 10.0 && row(1.0).decided.trials < 70.0);
}
