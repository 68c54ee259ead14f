//! Splitting against exact probabilities.

use stats::Confidence;
use stats::special::{normal_quantile, normal_sf};

use super::*;
use crate::error::CampaignError;
use crate::random::Random;

/// A walk on 0, 1, ... that goes up with probability `up`, begins at 1 and ends at 0 or `top`.
fn walk(job: &Job<usize>, up: f64, top: usize) -> Branch<usize> {
    let mut random = Random::new(job.seed, "walk");
    let (mut highest, mut place) = match &job.from {
        Some(from) => (from.rung, from.state),
        None => (0, 1),
    };
    let mut branch = Branch {
        crossings: Vec::new(),
        cost: 1.0,
    };
    loop {
        if place > highest {
            highest = place;
            let state = place;
            branch.crossings.push(Crossing {
                rung: highest,
                state,
            });
        }
        if place == 0 || highest >= top {
            return branch;
        }
        place = if random.chance(up) {
            place + 1
        } else {
            place - 1
        };
    }
}

/// Gambler's ruin from 1: `(r - 1) / (r^top - 1)` with `r` the odds of going down.
fn ruin(up: f64, top: usize) -> f64 {
    let odds = (1.0 - up) / up;
    (odds - 1.0) / (odds.powi(top as i32) - 1.0)
}

fn estimate_walk(up: f64, top: usize, seed: u64, options: (usize, usize, u64)) -> RareEstimate {
    let (particles, killed, replications) = options;
    let descents = (0..replications).map(|replication| {
        let options = SplittingOptions {
            particles,
            killed,
            top,
            seed: 1000 * seed + replication,
        };
        split(&options, |jobs| {
            Ok::<_, CampaignError>(jobs.iter().map(|job| walk(job, up, top)).collect())
        })
    });
    let descents: Vec<Descent> = descents.collect::<Result<_, _>>().unwrap();
    combine(&descents, Confidence::P95).unwrap()
}

#[test]
fn walks_with_known_probabilities_from_a_hundredth_to_a_hundred_millionth() {
    for (up, top) in [(0.25, 5), (0.25, 8), (0.2, 10), (0.2, 14)] {
        let exact = ruin(up, top);
        let found = (0..40)
            .map(|seed| estimate_walk(up, top, seed, (200, 20, 10)))
            .collect::<Vec<_>>();
        let covered = found
            .iter()
            .filter(|it| it.interval.contains(exact))
            .count();
        // Of 40 intervals at 95 %, at least 33: below that has probability 6e-4.
        assert!(covered >= 33, "{exact:e}: {covered} of 40");
        // Unbiased: the mean of 400 replications, within four standard errors.
        let all: Vec<f64> = found
            .iter()
            .flat_map(|it| it.replications.clone())
            .collect();
        let mean = all.iter().sum::<f64>() / 400.0;
        let error = (all.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / 399.0 / 400.0).sqrt();
        assert!((mean - exact).abs() < 4.0 * error, "{mean:e} of {exact:e}");
        assert!(found.iter().all(|it| it.episode_equivalents < 1e5));
    }
}

#[test]
fn one_in_a_million_takes_fewer_than_a_hundred_thousand_runs() {
    // (4 - 1) / (4^11 - 1) = 7.2e-7.
    let exact = ruin(0.2, 11);
    let found = estimate_walk(0.2, 11, 7, (500, 50, 16));
    assert!(found.interval.contains(exact), "{found:?}");
    assert!(found.episode_equivalents < 1e5, "{found:?}");
    assert!(found.relative_error.unwrap() < 0.3, "{found:?}");
    assert!(found.plain_equivalent.unwrap() > 100.0 * found.episode_equivalents);
}

/// A Brownian motion in small steps: does its sum of `steps` normal numbers ever exceed a rung?
#[test]
fn first_passages_of_a_gaussian_walk_agree_with_counting() {
    let (steps, top) = (50, 24);
    let run = |job: &Job<(usize, f64)>| {
        let mut random = Random::new(job.seed, "gaussian");
        let mut highest = job.from.as_ref().map_or(0, |from| from.rung);
        let (begun, mut sum) = job.from.as_ref().map_or((0, 0.0), |from| from.state);
        let mut crossings = Vec::new();
        for step in begun..steps {
            sum += random.standard_normal();
            // Rungs lie one apart; a step may jump over some.
            let rung = (sum.max(0.0) as usize).min(top);
            if rung > highest {
                highest = rung;
                crossings.push(Crossing {
                    rung,
                    state: (step + 1, sum),
                });
            }
            if highest == top {
                break;
            }
        }
        let cost = (steps - begun) as f64 / steps as f64;
        Branch { crossings, cost }
    };
    let descents: Vec<Descent> = (0..20)
        .map(|seed| {
            let options = SplittingOptions {
                particles: 300,
                killed: 60,
                top,
                seed,
            };
            split(&options, |jobs| {
                Ok::<_, CampaignError>(jobs.iter().map(run).collect())
            })
        })
        .collect::<Result<_, _>>()
        .unwrap();
    let found = combine(&descents, Confidence::P99).unwrap();
    let total = 1_000_000_u64;
    let hits = (0..total)
        .filter(|seed| {
            let job = Job {
                from: None,
                seed: *seed,
            };
            level_of(&run(&job)) == top
        })
        .count() as f64;
    let counted = hits / total as f64;
    // Counting has its own error: four standard deviations.
    let slack = 4.0 * hits.sqrt() / total as f64;
    let (low, high) = (found.interval.low - slack, found.interval.high + slack);
    assert!(low < counted && counted < high, "{found:?} {counted}");
    assert!(counted < 1e-3 && found.episode_equivalents < 1e5);
}

fn level_of<S>(branch: &Branch<S>) -> usize {
    branch.crossings.last().map_or(0, |crossing| crossing.rung)
}

#[test]
fn gaussian_tails_by_subsets_down_to_a_hundred_millionth() {
    for (exact, dimensions) in [(1e-3, 1), (1e-6, 3), (1e-8, 6)] {
        // The scaled sum of normal numbers is normal.
        let limit = -normal_quantile(exact);
        let mut covered = 0;
        let mut relative = 0.0;
        for seed in 0..15_u64 {
            let descents: Vec<Descent> = (0..10)
                .map(|replication| {
                    let options = SubsetOptions {
                        particles: 500,
                        chains: 50,
                        dimensions,
                        limit,
                        seed: 100 * seed + replication,
                    };
                    let score = |inputs: Vec<Candidate>| {
                        let sum =
                            |c: &Candidate| c.unit.iter().map(|u| normal_quantile(*u)).sum::<f64>();
                        let scale = (dimensions as f64).sqrt();
                        Ok::<_, CampaignError>(inputs.iter().map(|c| sum(c) / scale).collect())
                    };
                    subset(&options, score).unwrap().0
                })
                .collect();
            let found = combine(&descents, Confidence::P95).unwrap();
            covered += u32::from(found.interval.contains(exact));
            relative += found.probability / exact / 15.0;
            assert!(found.episode_equivalents < 1e5);
        }
        assert!(covered >= 11, "{exact:e}: {covered} of 15");
        // The bias is a small part of the spread.
        assert!((0.7..1.4).contains(&relative), "{exact:e}: {relative}");
        assert!((normal_sf(limit) / exact - 1.0).abs() < 1e-9);
    }
}

#[test]
fn random_outcomes_of_an_input_are_part_of_the_event() {
    // The score is one uniform number of the input plus one of the seed.
    let descents: Vec<Descent> = (0..20)
        .map(|seed| {
            let options = SubsetOptions {
                particles: 400,
                chains: 80,
                dimensions: 1,
                limit: 1.96,
                seed,
            };
            let score = |inputs: Vec<Candidate>| {
                let one = |c: &Candidate| c.unit[0] + Random::new(c.seed, "noise").unit();
                Ok::<_, CampaignError>(inputs.iter().map(one).collect())
            };
            subset(&options, score).unwrap().0
        })
        .collect();
    let found = combine(&descents, Confidence::P99).unwrap();
    assert!(found.interval.contains(0.04 * 0.04 / 2.0), "{found:?}");
}

#[test]
fn what_never_happens_is_bounded_by_the_first_runs() {
    let never = |jobs: Vec<Job<()>>| {
        let nothing = jobs.iter().map(|_| Branch {
            crossings: Vec::new(),
            cost: 1.0,
        });
        Ok::<_, CampaignError>(nothing.collect())
    };
    let descents: Vec<Descent> = (0..5)
        .map(|seed| {
            let options = SplittingOptions {
                particles: 100,
                killed: 10,
                top: 3,
                seed,
            };
            split(&options, never).unwrap()
        })
        .collect();
    let found = combine(&descents, Confidence::P95).unwrap();
    assert_eq!((found.probability, found.interval.low), (0.0, 0.0));
    // 1 - 0.025^(1/500).
    assert!((found.interval.high - 0.007_350).abs() < 1e-5, "{found:?}");
}

#[test]
fn a_flat_score_is_never_an_event() {
    let options = SubsetOptions {
        particles: 20,
        chains: 4,
        dimensions: 2,
        limit: 1.0,
        seed: 1,
    };
    let (descent, _) = subset(&options, |inputs| {
        Ok::<_, CampaignError>(vec![0.0; inputs.len()])
    })
    .unwrap();
    assert_eq!(descent.probability, 0.0);
}

#[test]
fn options_that_cannot_be_are_refused() {
    let options = SplittingOptions {
        particles: 10,
        killed: 10,
        top: 3,
        seed: 0,
    };
    let none = |_: Vec<Job<()>>| Ok::<_, CampaignError>(Vec::new());
    assert!(split(&options, none).is_err());
    let short = SplittingOptions {
        killed: 1,
        ..options
    };
    assert!(split(&short, none).is_err(), "too few outcomes");
    assert!(combine(&[], Confidence::P95).is_err());
}
