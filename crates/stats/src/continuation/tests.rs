use super::*;
use crate::special::binomial_pmf;

fn look(successes: u64, trials: u64) -> Sample {
    Sample { successes, trials }
}

/// The mean of the conditional error after a stage is the one before it, by quadrature.
#[test]
fn what_is_kept_and_spent_is_what_there_was() {
    for budget in [1e-6, 0.001, 0.05, 0.3, 0.7, 0.95, 0.999] {
        for growth in [1.0, 0.5, 0.1, 0.3086, 0.001] {
            let spending = Spending::new(budget, growth);
            // Cells that are narrow where it is steep.
            let ends: Vec<f64> = (0..=4000)
                .map(|i| (f64::from(i) / 4000.0).powi(4))
                .collect();
            let cells = ends.windows(2);
            let sum: f64 = cells
                .map(|cell| (cell[1] - cell[0]) * spending.mean(cell[0], cell[1]))
                .sum();
            assert!(
                (sum - budget).abs() < 1e-6 * budget,
                "{budget} {growth}: {sum}"
            );
        }
    }
}

/// It grows with the budget and falls with the p-value, so that tests at all levels are nested.
#[test]
fn the_conditional_error_is_monotone() {
    for growth in [1.0, 0.25, 0.02] {
        let mut last = vec![0.0; 200];
        for step in 1..300 {
            let spending = Spending::new(f64::from(step) / 300.0, growth);
            let now: Vec<f64> = (0..200)
                .map(|i| spending.mean(f64::from(i) / 200.0, f64::from(i + 1) / 200.0))
                .collect();
            assert!(now.windows(2).all(|two| two[0] >= two[1] - 1e-12));
            assert!(
                now.iter().zip(&last).all(|(a, b)| a >= &(b - 1e-9)),
                "{growth} {step}"
            );
            last = now;
        }
    }
}

/// The last look is decided without the search for the point up to which it rejects: the same decision.
#[test]
fn the_last_look_is_decided_as_by_what_it_would_keep() {
    for budget in [1e-60, 1e-6, 0.01, 0.05, 0.3, 0.7, 0.95, 0.999] {
        for growth in [1.0, 0.5, 0.1, 0.3086, 0.001] {
            let spending = Spending::new(budget, growth);
            let end = spending.certain;
            let near = [0.5, 0.999, 1.0 - 1e-9, 1.0 + 1e-9, 1.001, 2.0].map(|share| end * share);
            let others = [0.0, 1e-300, 0.2, 0.9, 1.0];
            for high in near.into_iter().chain(others).filter(|high| *high <= 1.0) {
                let kept = spending.mean(0.5 * high, high) >= 1.0;
                let decided = Spending::is_certain(budget, growth, high);
                assert_eq!(
                    decided,
                    kept || high <= 0.0,
                    "{budget} {growth} {high} {end}"
                );
            }
        }
    }
}

/// The greatest probability of ever rejecting, over all rules that choose the size of the next stage from what was
/// seen, by going through all paths.
fn worst(
    path: &mut Vec<Sample>,
    sizes: &[u64],
    most: u64,
    rate: f64,
    threshold: f64,
    level: f64,
) -> f64 {
    if rejects(&stages_of_counts(path, threshold), level) {
        return 1.0;
    }
    let before = path.last().copied().unwrap_or(look(0, 0));
    let mut greatest = 0.0_f64;
    for size in sizes.iter().filter(|size| before.trials + **size <= most) {
        let mut chance = 0.0;
        for own in 0..=*size {
            path.push(look(before.successes + own, before.trials + size));
            chance +=
                binomial_pmf(own, *size, rate) * worst(path, sizes, most, rate, threshold, level);
            path.pop();
        }
        greatest = greatest.max(chance);
    }
    greatest
}

/// Whoever looks as often as he likes, and adds as many trials as he likes, never errs more often than the level says.
#[test]
fn no_rule_of_going_on_errs_more_often_than_the_level() {
    for (threshold, level) in [(0.5, 0.1), (0.3, 0.05), (0.8, 0.1)] {
        for sizes in [&[1, 4][..], &[2, 3, 5]] {
            for rate in [threshold, threshold - 0.1] {
                let most = if sizes.len() == 2 { 9 } else { 12 };
                let error = worst(&mut Vec::new(), sizes, most, rate, threshold, level);
                assert!(
                    error <= level + 1e-9,
                    "{threshold} {level} {sizes:?} {rate}: {error}"
                );
            }
        }
    }
}

/// The exact test of all trials at each look, by contrast, errs more often, and this does not.
#[test]
fn looking_again_without_it_errs_too_often() {
    let (threshold, level, size) = (0.5, 0.05, 40);
    let mut errors = [0.0; 2];
    let chance = |x| binomial_pmf(x, size, threshold);
    for x in 0..=size {
        for y in 0..=size {
            for z in 0..=size {
                let looks = [
                    look(x, size),
                    look(x + y, 2 * size),
                    look(x + y + z, 3 * size),
                ];
                let weight = chance(x) * chance(y) * chance(z);
                if weight < 1e-9 {
                    continue;
                }
                let naive = looks
                    .iter()
                    .any(|look| binomial_test_above(*look, threshold) <= level);
                let stages = stages_of_counts(&looks, threshold);
                let ours = (1..=3).any(|end| rejects(&stages[..end], level));
                errors[0] += weight * f64::from(u8::from(naive));
                errors[1] += weight * f64::from(u8::from(ours));
            }
        }
    }
    assert!(errors[0] > 1.5 * level && errors[1] <= level, "{errors:?}");
    assert!(errors[1] > 0.6 * level, "{errors:?}");
}

#[test]
fn one_look_costs_a_fifth_of_the_level() {
    for (x, n, threshold) in [(73, 73, 0.95), (98, 100, 0.9), (1000, 1500, 0.6)] {
        let raw = binomial_test_above(look(x, n), threshold);
        let continued = continued_above(&[look(x, n)], threshold);
        assert!((continued / (raw / SHARE_OF_A_LOOK) - 1.0).abs() < 1e-9);
    }
}

#[test]
fn p_values_of_stages_never_rise_and_do_not_see_empty_looks() {
    let looks = [
        look(50, 60),
        look(50, 60),
        look(95, 110),
        look(96, 114),
        look(270, 300),
    ];
    let mut last = 1.0;
    for end in 1..=looks.len() {
        let now = p_of_stages(&stages_of_counts(&looks[..end], 0.8));
        assert!(now <= last + 1e-12, "{end}: {now} {last}");
        last = now;
    }
    let without = [looks[0], looks[2], looks[3], looks[4]];
    assert_eq!(continued_above(&looks, 0.8), continued_above(&without, 0.8));
}

/// Of 360/400 the last 200 alone would show more than all of them; what all show is shown.
#[test]
fn no_looks_show_what_all_trials_together_do_not() {
    for looks in [
        &[look(160, 200), look(360, 400)][..],
        &[look(3, 3), look(10, 12)],
        &[look(200, 200), look(360, 400)],
    ] {
        let now = looks[looks.len() - 1];
        for rate in [0.5, 0.6, 0.8, 0.87, 0.885, 0.895, 0.95] {
            let once = (
                binomial_test_above(now, rate),
                crate::binomial_test_below(now, rate),
            );
            assert!(continued_above(looks, rate) >= once.0, "{looks:?} {rate}");
            assert!(continued_below(looks, rate) >= once.1, "{looks:?} {rate}");
        }
        let once = crate::clopper_pearson(now, Confidence::P95);
        let found = continued_interval(looks, Confidence::P95);
        let wider = found.low <= once.low + 1e-9 && found.high >= once.high - 1e-9;
        assert!(wider, "{looks:?}: {found} {once}");
        let scored = looks.iter().map(|look| ScoredLook {
            p: binomial_test_above(*look, 0.87),
            information: look.trials as f64,
        });
        let scored: Vec<ScoredLook> = scored.collect();
        let once = binomial_test_above(now, 0.87);
        assert!(continued_p(&scored) >= once && !continued_rejects(&scored, 0.99 * once));
    }
}

/// A glance at trials that cannot show anything costs next to nothing.
#[test]
fn a_first_look_that_cannot_come_out_leaves_the_level_to_the_next() {
    let later = look(237, 240);
    let once = continued_above(&[later], 0.95);
    for first in [look(2, 2), look(1, 2), look(4, 5)] {
        let again = continued_above(&[first, later], 0.95);
        assert!(again < 2.5 * once, "{first}: {again} {once}");
    }
    // One that could have come out costs.
    let again = continued_above(&[look(77, 80), later], 0.95);
    assert!(again > 3.0 * once, "{again} {once}");
}

/// A p-value of 1 at first says that nothing was shown, not that what follows is all the better.
#[test]
fn the_worst_first_look_is_no_credit_to_the_next() {
    let at = |p: f64, information: f64| ScoredLook { p, information };
    let worst = continued_p(&[at(1.0, 2.0), at(0.1, 100.0)]);
    assert!(worst > 0.1, "{worst}");
}

/// The p-value rises with the threshold, so that the limits bound all rates that are not excluded.
#[test]
fn what_is_excluded_is_an_interval() {
    for looks in [
        &[look(17, 20), look(45, 50), look(93, 100)][..],
        &[look(5, 5), look(7, 12), look(8, 13)],
        &[
            look(88, 100),
            look(260, 300),
            look(265, 306),
            look(700, 800),
        ],
    ] {
        let (mut above, mut below) = (0.0, 1.0);
        for i in 1..400 {
            let rate = f64::from(i) / 400.0;
            let (a, b) = (continued_above(looks, rate), continued_below(looks, rate));
            // Where it might matter.
            assert!(
                a >= above - 1e-9 || a > 0.5,
                "{looks:?} {rate}: {a} {above}"
            );
            assert!(
                b <= below + 1e-9 || below > 0.5,
                "{looks:?} {rate}: {b} {below}"
            );
            (above, below) = (a, b);
        }
        let interval = continued_interval(looks, Confidence::P95);
        let last = looks[looks.len() - 1];
        assert!(
            interval.contains(last.rate().expect("counts")),
            "{interval} {last}"
        );
    }
}

/// Scores of counts of which many are needed are near to the exact stages.
#[test]
fn scores_are_near_to_exact_stages() {
    let looks = [look(1840, 2000), look(3700, 4000), look(9290, 10_000)];
    let scored = looks.map(|look| ScoredLook {
        p: binomial_test_above(look, 0.925),
        information: look.trials as f64,
    });
    let (exact, near) = (continued_above(&looks, 0.925), continued_p(&scored));
    assert!((exact / near - 1.0).abs() < 0.15, "{exact} {near}");
}

#[test]
fn a_sequence_leaves_out_repeated_looks_and_those_of_other_trials() {
    // The second look is repeated, and the first had more failures.
    let looks = [look(3, 10), look(9, 10), look(9, 10), look(18, 20)];
    assert_eq!(sequence(&looks), [look(9, 10), look(18, 20)]);
}
