use super::*;
use stats::Sample;

fn beta(successes: u64, trials: u64) -> BetaPosterior {
    BetaPosterior::jeffreys(Sample { successes, trials })
}

fn one(posterior: BetaPosterior) -> Side {
    Side {
        least: End::Uncertain(posterior.into()),
        greatest: End::Uncertain(posterior.into()),
        is_range: false,
    }
}

fn range(least: End, greatest: End) -> Side {
    Side {
        least,
        greatest,
        is_range: true,
    }
}

/// Evenly spaced quantiles.
fn places(posterior: &BetaPosterior) -> Vec<f64> {
    (0..400)
        .map(|i| posterior.quantile((f64::from(i) + 0.5) / 400.0))
        .collect()
}

/// By all pairs of places, with both ends functions of one constant.
#[test]
fn a_range_is_near_a_count_with_no_more_than_the_probability_that_both_ends_leave() {
    let margin = 0.05;
    for (constant, count) in [
        ((90, 100), (88, 100)),
        ((45, 50), (30, 40)),
        ((9, 10), (70, 80)),
    ] {
        let (p, other) = (beta(constant.0, constant.1), beta(count.0, count.1));
        let (mut near, mut same, mut all) = ([0.0, 0.0], [0.0, 0.0], 0.0);
        for x in places(&p) {
            // The ends are p^2 and p.
            for rate in places(&other) {
                all += 1.0;
                near[0] += f64::from(u8::from(x * x - margin < rate && rate < x + margin));
                same[0] += f64::from(u8::from(rate <= x));
                same[1] += f64::from(u8::from(rate >= x * x));
            }
        }
        near[0] /= all;
        // The distribution of p^2 is no beta distribution, but nearly.
        let squares: Vec<f64> = places(&p).iter().map(|x| x * x).collect();
        let draws = stats::Draws::new(&squares).expect("draws");
        let size = draws.mean() * (1.0 - draws.mean()) / draws.variance() - 1.0;
        let least = BetaPosterior::new(draws.mean() * size, (1.0 - draws.mean()) * size);
        let side = range(
            End::Uncertain(least.expect("a distribution").into()),
            End::Uncertain(p.into()),
        );
        let within = probability_within(&side, &one(other), margin);
        assert!((within - near[0]).abs() < 5e-3, "{within} {near:?}");
        let p_value = (2.0 * same[0].min(same[1]) / all).min(1.0);
        let found = p_difference(&side, &one(other));
        assert!((found - p_value).abs() < 8e-3, "{found} {p_value}");
        assert_eq!(found, p_difference(&one(other), &side));
        assert_eq!(within, probability_within(&one(other), &side, margin));
    }
}

/// What is known exactly is as for known ranges.
#[test]
fn known_ends_agree_for_certain_or_not_at_all() {
    let known = |low, high| range(End::Known(low), End::Known(high));
    let (wide, near, far) = (known(0.8, 0.95), known(0.82, 0.93), known(0.96, 0.99));
    assert_eq!(probability_within(&wide, &near, 0.03), 1.0);
    assert_eq!(probability_within(&wide, &near, 0.01), 0.0);
    assert_eq!(p_difference(&wide, &near), 1.0);
    assert_eq!(p_difference(&wide, &far), 0.0);
    // A number in the range agrees with it; one that may be outside does not for certain.
    let number = |low, high| Side {
        is_range: false,
        ..known(low, high)
    };
    assert_eq!(probability_within(&wide, &number(0.85, 0.86), 0.01), 1.0);
    assert_eq!(probability_within(&wide, &number(0.9, 0.98), 0.01), 0.0);
}

/// A range of no width whose end is a distribution is that distribution.
#[test]
fn a_range_without_width_is_its_distribution() {
    let (p, other) = (beta(87, 100), beta(80, 90));
    let side = range(End::Uncertain(p.into()), End::Uncertain(p.into()));
    let within = probability_within(&side, &one(other), 0.08);
    assert!((within - stats::probability_within(&p, &other, 0.08)).abs() < 1e-9);
    let above = stats::probability_greater(&p, &other);
    let expected = 2.0 * above.min(1.0 - above);
    assert!((p_difference(&side, &one(other)) - expected).abs() < 1e-9);
}

#[test]
fn the_nearest_value_may_be_anywhere_that_the_ends_leave_open() {
    let ends = Ends {
        as_written: Interval {
            low: 0.7,
            high: 0.9,
        },
        least: End::Uncertain(beta(70, 100).into()),
        greatest: End::Uncertain(beta(90, 100).into()),
        is_range: true,
    };
    let inside = ends.interval_of_nearest(0.8, Confidence::P95);
    assert!(inside.low <= 0.8 && inside.high >= 0.8 && inside.high - inside.low < 0.05);
    let above = ends.interval_of_nearest(0.9, Confidence::P95);
    assert!(above.low < 0.85 && above.high > 0.94, "{above:?}");
    let whole = ends.interval(Confidence::P95);
    assert!(whole.low < 0.62 && whole.high > 0.94, "{whole:?}");
}

/// Ends that hardly vary beside ends that do: an adaptive integral over them once took as many evaluations as its depth allowed.
#[test]
fn ends_of_very_different_widths_are_compared_as_their_limit() {
    let counted = beta(17, 20);
    for size in [1e6, 1e10, 1e14] {
        let narrow = BetaPosterior::new(0.8 * size, 0.2 * size).expect("a distribution");
        for by in [0.0, 0.03, -0.03] {
            let (narrow, wide) = (
                End::Uncertain(narrow.into()),
                End::Uncertain(counted.into()),
            );
            let limit = counted.cdf(0.8 - by);
            let found = narrow.exceeds(&wide, by);
            assert!((found - limit).abs() < 1e-3, "{size} {by}: {found} {limit}");
            let back = wide.exceeds(&narrow, by);
            let limit = counted.sf(0.8 + by);
            assert!((back - limit).abs() < 1e-3, "{size} {by}: {back} {limit}");
        }
    }
}

/// What plans ask of places is what conclusions integrate, within what `stats::PosteriorPlaces` states for each end.
#[test]
fn a_planned_side_says_nearly_what_the_sides_say() {
    let ends = [
        End::Known(0.82),
        End::Uncertain(beta(41, 50).into()),
        End::Uncertain(beta(850, 1000).into()),
    ];
    let greatest = [
        End::Known(0.93),
        End::Uncertain(beta(46, 50).into()),
        End::Uncertain(beta(930, 1000).into()),
    ];
    for least in &ends {
        for greatest in &greatest {
            for is_range in [true, false] {
                let side = Side {
                    least: least.clone(),
                    greatest: greatest.clone(),
                    is_range,
                };
                let planned = PlannedSide::Ends {
                    least: least.into(),
                    greatest: greatest.into(),
                    is_range,
                };
                for (successes, trials) in [(16, 20), (19, 20), (175, 200), (700, 1000)] {
                    let counts = beta(successes, trials);
                    let pairs = [
                        (
                            planned.p_difference(&counts),
                            p_difference(&side, &one(counts)),
                        ),
                        (
                            planned.probability_within(&counts, 0.05),
                            probability_within(&side, &one(counts), 0.05),
                        ),
                    ];
                    for (found, exact) in pairs {
                        assert!((found - exact).abs() < 8e-3, "{found} {exact} {side:?}");
                    }
                }
            }
        }
    }
}

/// A model's ends are held against a threshold by their draws: none of `min(p, 0.9)` lies above 0.9, where the beta distribution
/// of its mean and variance has more than a hundredth.
#[test]
fn the_ends_of_a_model_have_the_tails_of_their_draws() {
    use super::super::Belief;
    use crate::{CredibleInterval, Guarantee, Measure, MethodAnswer, Worst};
    let p = BetaPosterior::new(18.5, 2.5).expect("a distribution");
    let design = stats::SharesDesign::new(&[p], 4000, 1);
    let of_rows =
        |of: fn(f64) -> f64| -> Vec<f64> { design.rows().iter().map(|x| of(x[0])).collect() };
    let (least, greatest) = (of_rows(|p| p.powi(9)), of_rows(|p| p.min(0.9)));
    let ends = (least.as_slice(), greatest.as_slice());
    let credible = CredibleInterval::of_ends(&["p"], &design, ends, Worst::Least, Confidence::P95);
    let guarantee = Guarantee::Schedulers {
        low: 0.88_f64.powi(9),
        high: 0.88,
        worst: None,
    };
    let measure = Measure::Probability {
        answer: MethodAnswer {
            method: "sound".into(),
            value: 0.88_f64.powi(9),
            complement: None,
            guarantee,
            iterations: None,
        },
        others: vec![],
        credible: Some(credible.expect("an interval")),
    };
    let Ok(Belief::Range { ends, .. }) = Belief::of(&measure) else {
        panic!("no range");
    };
    let found = ends.greatest.at_least(0.92);
    assert!(found <= 0.005, "{found}");
}
