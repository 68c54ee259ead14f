//! Coverage at all times at once, at the ends, and to a million trials.

use stats::{Confidence, Interval, Sample, clopper_pearson};
use stats::{Decision, RunningInterval, SequentialTest, confidence_sequence, ln_evidence_against};

fn sample(successes: u64, trials: u64) -> Sample {
    Sample::new(successes, trials).unwrap()
}

/// Uniform numbers: SplitMix64 (G. L. Steele, D. Lea and C. H. Flood, 2014).
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[test]
fn the_true_rate_is_hardly_ever_excluded_at_any_time() {
    let sequences = 2000;
    for (index, rate) in [0.001, 0.05, 0.5, 0.88, 0.999].into_iter().enumerate() {
        let mut excluded = 0;
        let mut uniform = Uniform(index as u64);
        for _ in 0..sequences {
            let mut successes = 0;
            let ever = (1..=3000_u64).any(|trials| {
                successes += u64::from(uniform.next() < rate);
                ln_evidence_against(sample(successes, trials), rate) >= 20_f64.ln()
            });
            excluded += u64::from(ever);
        }
        // At most 5 %, within 4 standard deviations of 2000 sequences.
        assert!(excluded < 100 + 39, "{rate}: {excluded} of {sequences}");
    }
}

#[test]
fn a_fixed_look_repeated_does_exclude_it_which_the_sequence_is_for() {
    let mut uniform = Uniform(5);
    let mut excluded = 0;
    for _ in 0..200 {
        let mut successes = 0;
        excluded += u64::from((1..=2000_u64).any(|trials| {
            successes += u64::from(uniform.next() < 0.5);
            trials >= 20
                && !clopper_pearson(sample(successes, trials), Confidence::P95).contains(0.5)
        }));
    }
    assert!(excluded > 30, "{excluded} of 200 with peeking");
}

#[test]
fn wrong_decisions_are_as_rare_as_stated() {
    let test = SequentialTest::new(0.9, Confidence::P95).unwrap();
    for (rate, wrong) in [(0.9, Decision::Below), (0.8999, Decision::AtLeast)] {
        let mut uniform = Uniform(9);
        let mut count = 0;
        for _ in 0..1000 {
            let mut successes = 0;
            let first = (1..=1500_u64).find_map(|trials| {
                successes += u64::from(uniform.next() < rate);
                let decision = test.decide(sample(successes, trials));
                (decision != Decision::Open).then_some(decision)
            });
            count += u64::from(first == Some(wrong));
        }
        assert!(count < 50 + 28, "{rate}: {count} of 1000");
    }
}

#[test]
fn what_is_far_from_the_threshold_is_decided_soon() {
    let test = SequentialTest::new(0.95, Confidence::P99).unwrap();
    let needed = |rate: f64| {
        let mut uniform = Uniform(11);
        let mut successes = 0;
        (1..=100_000_u64).find_map(|trials| {
            successes += u64::from(uniform.next() < rate);
            let decision = test.decide(sample(successes, trials));
            (decision != Decision::Open).then_some((decision, trials))
        })
    };
    let (decision, trials) = needed(0.88).unwrap();
    assert!(
        decision == Decision::Below && trials < 1000,
        "{decision:?} {trials}"
    );
    let (decision, trials) = needed(0.999).unwrap();
    assert!(
        decision == Decision::AtLeast && trials < 1000,
        "{decision:?} {trials}"
    );
}

#[test]
fn the_ends_and_great_counts_are_exact_enough() {
    for trials in [1, 2, 10, 1000, 1_000_000, 100_000_000] {
        let none = confidence_sequence(sample(0, trials), Confidence::P95);
        let all = confidence_sequence(sample(trials, trials), Confidence::P95);
        assert!(none.low == 0.0 && all.high == 1.0);
        assert!((none.high - (1.0 - all.low)).abs() < 1e-12);
        // With no success, M = B(1/2, n + 1/2) / pi / (1 - p)^n in closed form.
        let n = trials as f64;
        let evidence = ln_evidence_against(sample(0, trials), none.high);
        let direct = stats::special::ln_gamma(n + 0.5) + stats::special::ln_gamma(0.5)
            - stats::special::ln_gamma(n + 1.0)
            - std::f64::consts::PI.ln()
            - n * (-none.high).ln_1p();
        assert!(
            (evidence - direct).abs() < 1e-5,
            "{trials}: {evidence} {direct}"
        );
        assert!((evidence - 20_f64.ln()).abs() < 1e-5 || none.high == 1.0);
    }
    let half = confidence_sequence(sample(500_000, 1_000_000), Confidence::P95);
    assert!((half.low + half.high - 1.0).abs() < 1e-9);
    assert!(half.width() < 0.0047, "{half}");
}

/// The widths that the module's page states.
#[test]
fn the_price_of_looking_is_as_stated() {
    let ratio = |successes, trials| {
        let counts = sample(successes, trials);
        confidence_sequence(counts, Confidence::P95).width()
            / clopper_pearson(counts, Confidence::P95).width()
    };
    let ratios = [
        ratio(88, 100),
        ratio(8800, 10_000),
        ratio(880_000, 1_000_000),
    ];
    for (found, stated) in ratios.into_iter().zip([1.56, 2.00, 2.29]) {
        assert!((found - stated).abs() < 0.006, "{ratios:?}");
    }
}

#[test]
fn a_running_interval_only_narrows() {
    let mut running = RunningInterval::new(Confidence::P95);
    let mut uniform = Uniform(3);
    let mut last = Interval::VACUOUS;
    for _ in 0..500 {
        running.observe(uniform.next() < 0.3);
        let now = running.interval();
        assert!(now.low >= last.low && now.high <= last.high);
        last = now;
    }
    assert!(last.contains(0.3));
    let at_once = confidence_sequence(running.sample(), Confidence::P95);
    assert!(last.low >= at_once.low && last.high <= at_once.high);
}

#[test]
fn thresholds_at_the_ends_and_outside() {
    let certain = SequentialTest::new(1.0, Confidence::P99).unwrap();
    assert_eq!(certain.decide(sample(1_000_000, 1_000_000)), Decision::Open);
    assert_eq!(certain.decide(sample(999, 1000)), Decision::Below);
    let nothing = SequentialTest::new(0.0, Confidence::P99).unwrap();
    assert_eq!(nothing.decide(sample(0, 5)), Decision::AtLeast);
    assert!(SequentialTest::new(1.1, Confidence::P99).is_err());
    assert!(SequentialTest::new(f64::NAN, Confidence::P99).is_err());
}
