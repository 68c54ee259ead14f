//! Coherence of comparisons and verdicts, by going through small counts: more of the same data never takes back what it
//! showed, and no value lies outside its own interval, however often it was looked at.

use crate::support;

use evidence::*;
use stats::Confidence;
use support::{Uniform, at_least, counts, exact, piece, requirement};

fn judged(
    ledger: &[Evidence],
    requirement: Requirement,
    looks: Option<&Looks>,
) -> (Option<Comparison>, Conclusion) {
    let influences = Influences::learn(ledger);
    let requirements = [requirement];
    let study = Study {
        requirements: &requirements,
        failure_modes: &[],
        evidence: ledger,
        influences: &influences,
        looks,
        levels: Levels::new(0.95, 0.95).expect("levels"),
    };
    let mut comparisons = compare(&study);
    let conclusion = conclude(&study, &comparisons).swap_remove(0);
    (comparisons.pop(), conclusion)
}

fn experiment(count: u64, trials: u64) -> Evidence {
    piece("E", Technique::Experiment, vec![(0, counts(count, trials))])
}

fn outcome(first: Evidence, second: Evidence, margin: f64) -> Outcome {
    let asked = Requirement {
        margin,
        ..requirement(0, at_least(0.5))
    };
    let (comparison, _) = judged(&[first, second], asked, None);
    comparison.expect("a comparison").outcome
}

/// Both counts twice and three times: agreement stays agreement, between counts and against a model.
#[test]
fn more_of_the_same_data_never_takes_agreement_back() {
    let simulated =
        |count, trials| piece("S", Technique::Simulation, vec![(0, counts(count, trials))]);
    let model = |value| piece("M", Technique::ModelChecking, vec![(0, exact(value))]);
    let mut agreed = [0, 0];
    for margin in [0.2, 0.3, 0.4] {
        for (n, m) in [(8, 8), (12, 7), (16, 16)] {
            for (x, y) in (0..=n).flat_map(|x| (0..=m).map(move |y| (x, y))) {
                let at =
                    |k: u64| outcome(experiment(k * x, k * n), simulated(k * y, k * m), margin);
                if at(1) == Outcome::Corroborates {
                    agreed[0] += 1;
                    for k in [2, 3] {
                        assert_eq!(
                            at(k),
                            Outcome::Corroborates,
                            "{x}/{n} {y}/{m} {margin} x{k}"
                        );
                    }
                }
            }
        }
        for (n, value) in [(10_u64, 0.9), (20, 0.5), (30, 1.0)] {
            for x in 0..=n {
                let at = |k: u64| outcome(experiment(k * x, k * n), model(value), margin);
                if at(1) == Outcome::Corroborates {
                    agreed[1] += 1;
                    for k in [2, 3] {
                        assert_eq!(
                            at(k),
                            Outcome::Corroborates,
                            "{x}/{n} {value} {margin} x{k}"
                        );
                    }
                }
            }
        }
    }
    assert!(agreed.iter().all(|count| *count > 20), "{agreed:?}");
}

/// One more success never takes back that a threshold is met, one more failure never that it is missed; nor does as much
/// again of the same.
#[test]
fn data_that_point_further_the_same_way_never_take_a_verdict_back() {
    for threshold in [0.5, 0.8, 0.95] {
        let verdict = |count, trials| {
            judged(
                &[experiment(count, trials)],
                requirement(0, at_least(threshold)),
                None,
            )
            .1
            .verdict
        };
        for trials in [5, 20, 60, 90] {
            for count in 0..=trials {
                match verdict(count, trials) {
                    Verdict::Satisfied => {
                        assert_eq!(verdict(count + 1, trials + 1), Verdict::Satisfied);
                        assert_eq!(verdict(2 * count, 2 * trials), Verdict::Satisfied);
                    }
                    Verdict::Violated => {
                        assert_eq!(verdict(count, trials + 1), Verdict::Violated);
                        assert_eq!(verdict(2 * count, 2 * trials), Verdict::Violated);
                    }
                    _ => {}
                }
            }
        }
    }
}

/// Intervals that allow for looks hold the rate that they stand beside, and those of one look lie in them.
#[test]
fn intervals_over_looks_hold_their_rate() {
    let mut uniform = Uniform(4);
    for study in 0..6 {
        let rate = uniform.of(&[0.0, 0.1, 0.5, 0.9, 0.99, 1.0]);
        let correlation = uniform.of(&[None, Some(0.2)]);
        let mut seen = Vec::new();
        let mut looks = Looks::default();
        for _ in 0..2 {
            match correlation {
                None => seen.push(uniform.sample(20, rate)),
                Some(correlation) => seen.extend(uniform.people(4, 5, rate, correlation)),
            }
            let total = stats::pool(&seen).expect("counts");
            let measure = match correlation {
                None => counts(total.successes, total.trials),
                Some(_) => Measure::of_clusters(&seen, Confidence::P95).expect("counts"),
            };
            let ledger = [piece("E", Technique::Experiment, vec![(0, measure)])];
            looks = looks.with(Look::of(&ledger));
            let (_, found) = judged(&ledger, requirement(0, at_least(0.8)), Some(&looks));
            let estimate = total.successes as f64 / total.trials as f64;
            for looking in &found.looking {
                let all = looking.interval.expect("an interval");
                let once = looking.single_look_interval.expect("an interval");
                for interval in [all, once] {
                    let holds = interval.low <= estimate + 1e-9 && estimate <= interval.high + 1e-9;
                    assert!(holds, "{study}: {estimate} in {interval:?}");
                }
            }
            assert!(!found.looking.is_empty());
            let limits = found.standings[0].limits;
            assert!(
                limits.low <= estimate + 1e-9 && estimate <= limits.high + 1e-9,
                "{limits:?}"
            );
        }
    }
}
