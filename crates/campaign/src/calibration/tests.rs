//! Simulators with known parameters.

use stats::Confidence;

use super::*;
use crate::random::Random;

/// Three ways to fail of two parameters; the third shares an opportunity with the first.
fn rates(unit: &[f64]) -> [f64; 3] {
    let (a, b) = (unit[0], unit[1]);
    [0.35 * (1.0 - a).powi(2), 0.02 + 0.3 * b, 0.05 + 0.1 * a * b]
}

fn episode(unit: Vec<f64>, random: &mut Random) -> Episode {
    let [slip, miss, both] = rates(&unit);
    let slipped = random.chance(slip);
    let missed = random.chance(miss);
    let third = random.chance(both);
    // After a slip there is no opportunity for the second.
    let outcomes = vec![Some(slipped), (!slipped).then_some(missed), Some(third)];
    Episode { unit, outcomes }
}

/// Counts of 100 real runs at a truth.
fn reality(truth: &[f64], held_out: bool, random: &mut Random) -> Vec<Observed> {
    let runs: Vec<Episode> = (0..100).map(|_| episode(truth.to_vec(), random)).collect();
    ["slip", "miss", "both"]
        .iter()
        .enumerate()
        .map(|(mode, name)| {
            let outcomes = runs.iter().filter_map(|run| run.outcomes[mode]);
            let outcomes: Vec<bool> = outcomes.collect();
            let occurrences = outcomes.iter().filter(|o| **o).count() as u64;
            let mut observed = Observed::new(name, occurrences, outcomes.len() as u64);
            observed.held_out = held_out && mode == 2;
            observed
        })
        .collect()
}

fn calibrated(truth: &[f64], seed: u64, per_round: usize) -> Calibration {
    let mut random = Random::new(seed, "reality and simulator");
    let options = CalibrationOptions {
        dimensions: 2,
        points: 1000,
        seed,
    };
    let observed = reality(truth, true, &mut random);
    let mut calibration = Calibration::new(observed, options).unwrap();
    for _ in 0..2 {
        for unit in calibration.ask(per_round) {
            let told = episode(unit, &mut random);
            calibration.tell(told).unwrap();
        }
    }
    calibration
}

#[test]
fn planted_parameters_are_recovered() {
    let calibration = calibrated(&[0.6, 0.4], 3, 1000);
    let posterior = calibration.posterior();
    let marginals = posterior.marginals(Confidence::P95);
    for (marginal, truth) in marginals.iter().zip([0.6, 0.4]) {
        assert!(marginal.interval.contains(truth), "{marginals:?}");
        assert!(marginal.contraction > 0.5, "{marginals:?}");
    }
    assert!(posterior.effective_size() > 50.0);
    let known = |d: &Direction| d.identifiability != Identifiability::Unidentified;
    assert!(posterior.directions().iter().all(known));
    for (predicted, fit) in calibration
        .predictive(&posterior)
        .iter()
        .zip(calibration.fits())
    {
        assert!(predicted.counted.p_value.unwrap() > 0.01, "{predicted:?}");
        assert!(fit.p_value.is_none_or(|p| p > 0.001), "{fit:?}");
    }
}

#[test]
fn posterior_ranks_of_the_truth_are_uniform() {
    // Simulation-based calibration: truths from the prior; the posterior probability below the
    // truth is then uniform. 60 repeats, two parameters.
    let mut random = Random::new(11, "truths");
    let (mut ranks, mut covered) = (Vec::new(), 0);
    for seed in 0..60 {
        let truth = [random.unit(), random.unit()];
        let posterior = calibrated(&truth, 100 + seed, 250).posterior();
        for (d, truth) in truth.iter().enumerate() {
            let rank = posterior.cdf(d, *truth);
            covered += u32::from((0.025..=0.975).contains(&rank));
            ranks.push(rank);
        }
    }
    // 120 intervals at 95 %; 106 or fewer has probability 2e-3.
    assert!(covered >= 106, "{covered} of 120");
    // Kolmogorov and Smirnov: beyond 1.95 / sqrt(60) with probability 1e-3 (ranks of one repeat
    // hang together, so it is tested as of 60).
    ranks.sort_by(f64::total_cmp);
    let count = ranks.len() as f64;
    let distance = ranks.iter().enumerate().map(|(i, rank)| {
        let (low, high) = (i as f64 / count, (i as f64 + 1.0) / count);
        (rank - low).abs().max((rank - high).abs())
    });
    let distance = distance.fold(0.0, f64::max);
    assert!(distance < 1.95 / 60_f64.sqrt(), "{distance}");
}

#[test]
fn a_parameter_without_influence_is_named() {
    let mut random = Random::new(5, "idle");
    let observed = vec![Observed::new("slip", 10, 100)];
    let options = CalibrationOptions {
        dimensions: 2,
        points: 1000,
        seed: 1,
    };
    let mut calibration = Calibration::new(observed, options).unwrap();
    for unit in calibration.ask(1500) {
        let outcomes = vec![Some(random.chance(0.3 * unit[0]))];
        calibration.tell(Episode { unit, outcomes }).unwrap();
    }
    let posterior = calibration.posterior();
    let marginals = posterior.marginals(Confidence::P95);
    assert!(marginals[0].contraction > 0.6 && marginals[1].contraction < 0.3);
    let least = &posterior.directions()[0];
    let is_unidentified = least.identifiability == Identifiability::Unidentified;
    assert!(is_unidentified && least.loadings[1] > 0.9, "{least:?}");
    for (contraction, expected) in [
        (0.95, Identifiability::Identified),
        (0.8, Identifiability::Identified),
        (0.79, Identifiability::Weak),
        (0.5, Identifiability::Weak),
        (0.49, Identifiability::Unidentified),
        (-0.1, Identifiability::Unidentified),
    ] {
        assert_eq!(Identifiability::of(contraction), expected, "{contraction}");
    }
}

#[test]
fn the_mode_of_a_few_in_a_hundred_reproduces_them_and_lies_below_the_mean() {
    let mut random = Random::new(21, "few");
    let options = CalibrationOptions {
        dimensions: 1,
        points: 1000,
        seed: 3,
    };
    let observed = vec![Observed::new("slip", 3, 100)];
    let mut calibration = Calibration::new(observed, options).unwrap();
    for _round in 0..3 {
        for unit in calibration.ask(1000) {
            let outcomes = vec![Some(random.chance(0.15 * unit[0]))];
            calibration.tell(Episode { unit, outcomes }).unwrap();
        }
    }
    let posterior = calibration.posterior();
    let (mode, mean) = (posterior.mode()[0], posterior.mean()[0]);
    // The posterior is near Beta(4, 98) in the rate: mode 0.03, mean 0.039.
    assert!((0.15 * mode - 0.03).abs() < 0.006, "{mode}");
    assert!(mode < mean, "{mode} {mean}");
}

#[test]
fn a_mode_that_the_simulator_cannot_show_fails_its_prediction() {
    let mut random = Random::new(8, "blind");
    let observed = vec![
        Observed::new("slip", 10, 100),
        Observed::new("unknown", 12, 100).held_out(),
    ];
    let options = CalibrationOptions {
        dimensions: 1,
        points: 500,
        seed: 2,
    };
    let mut calibration = Calibration::new(observed, options).unwrap();
    for unit in calibration.ask(800) {
        let outcomes = vec![Some(random.chance(0.3 * unit[0])), Some(false)];
        calibration.tell(Episode { unit, outcomes }).unwrap();
    }
    let predictive = calibration.predictive(&calibration.posterior());
    assert!(
        predictive[0].counted.p_value.unwrap() > 0.05,
        "{predictive:?}"
    );
    assert!(
        predictive[1].counted.p_value.unwrap() < 1e-3,
        "{predictive:?}"
    );
}

#[test]
fn the_same_episodes_give_the_same_posterior_and_next_round() {
    let once = calibrated(&[0.3, 0.7], 9, 200);
    let twice = calibrated(&[0.3, 0.7], 9, 200);
    assert_eq!(once.posterior().mean(), twice.posterior().mean());
    assert_eq!(once.clone().ask(20), twice.clone().ask(20));
}

#[test]
fn surfaces_follow_rates_and_say_when_they_do_not() {
    let mut random = Random::new(4, "surface");
    let points: Vec<Vec<f64>> = (0..4000).map(|_| vec![random.unit()]).collect();
    let mut outcomes = |rate: &dyn Fn(f64) -> f64| -> Vec<(Vec<f64>, bool)> {
        let one = |p: &Vec<f64>| (p.clone(), random.chance(rate(p[0])));
        points.iter().map(one).collect()
    };
    let smooth = outcomes(&|u| 0.3 / (1.0 + (4.0 * u).exp()));
    let wiggly = outcomes(&|u| if (u * 5.0) as i32 % 2 == 0 { 0.3 } else { 0.01 });
    fn borrowed(outcomes: &[(Vec<f64>, bool)]) -> Vec<(&[f64], bool)> {
        outcomes.iter().map(|(u, o)| (u.as_slice(), *o)).collect()
    }
    let surface = Surface::fit(1, &borrowed(&smooth));
    for u in [0.1, 0.5, 0.9] {
        let exact = 0.3 / (1.0 + (4.0_f64 * u).exp());
        assert!((surface.rate(&[u]) - exact).abs() < 0.02);
    }
    assert!(surface.fit_test(&borrowed(&smooth)).p_value.unwrap() > 0.01);
    let wrong = Surface::fit(1, &borrowed(&wiggly));
    assert!(wrong.fit_test(&borrowed(&wiggly)).p_value.unwrap() < 1e-6);
}

#[test]
fn contradictory_or_empty_counts_are_refused() {
    let options = CalibrationOptions {
        dimensions: 1,
        points: 500,
        seed: 2,
    };
    let refused = |observed: Observed| Calibration::new(vec![observed], options).is_err();
    let counts = |occurrences, opportunities| Observed::new("slip", occurrences, opportunities);
    assert!(refused(counts(3, 2)));
    assert!(refused(counts(1, 2).held_out()));
    assert!(refused(counts(0, 0)));
    assert!(refused(counts(1, u64::MAX)));
    let mut parts = counts(1, 4);
    parts.clusters = vec![counted(1, 2), counted(1, 2)];
    assert!(refused(parts), "parts that do not add up");
    let mut good = Calibration::new(vec![counts(1, 2)], options).unwrap();
    assert!(good.with_observed(Vec::new()).is_err());
    let outcomes = vec![None, None];
    assert!(
        good.tell(Episode {
            unit: vec![0.5],
            outcomes
        })
        .is_err()
    );
}

fn counted(occurrences: u64, opportunities: u64) -> Counted {
    Counted {
        occurrences,
        opportunities,
    }
}

/// Persons of ten trials each, whose own rates are beta distributed around `rate`: each outcome
/// repeats an earlier one of the same person in proportion (Polya's urn).
fn persons(count: usize, rate: f64, correlation: f64, random: &mut Random) -> Vec<Counted> {
    let person = |random: &mut Random| {
        let mut occurred = 0;
        for trial in 0..10 {
            let (trial, before) = (f64::from(trial), occurred as f64);
            let own = rate * (1.0 - correlation) + before * correlation;
            let chance = own / (1.0 + (trial - 1.0) * correlation);
            occurred += u64::from(random.chance(chance));
        }
        counted(occurred, 10)
    };
    (0..count).map(|_| person(random)).collect()
}

fn observed_persons(persons: Vec<Counted>, held_out: Vec<Counted>) -> Observed {
    let sum = |count: fn(&Counted) -> u64| persons.iter().map(count).sum();
    let mut observed = Observed::new("slip", sum(|it| it.occurrences), sum(|it| it.opportunities));
    observed.clusters = persons;
    observed.held_out_runs = held_out;
    observed
}

/// One parameter; episodes fail at half of it.
fn halved(observed: Observed, seed: u64, random: &mut Random) -> Calibration {
    let options = CalibrationOptions {
        dimensions: 1,
        points: 400,
        seed,
    };
    let mut calibration = Calibration::new(vec![observed], options).unwrap();
    for unit in calibration.ask(1500) {
        let outcomes = vec![Some(random.chance(unit[0] / 2.0))];
        calibration.tell(Episode { unit, outcomes }).unwrap();
    }
    calibration
}

#[test]
fn ninety_per_cent_intervals_and_held_out_persons_hold_with_persons_that_differ() {
    // Simulation-based calibration with everything drawn from its prior, correlations as well.
    // Eight persons are fitted, four are held out.
    let mut random = Random::new(21, "persons");
    let (mut covered, mut naive, mut low_p, mut ranks) = (0_u32, 0_u32, 0_u32, Vec::new());
    const REPEATS: u32 = 100;
    for seed in 0..u64::from(REPEATS) {
        let truth = random.unit();
        let correlation = 1.0 - (1.0 - random.unit()).powf(1.0 / 9.0);
        let fitted = persons(8, truth / 2.0, correlation, &mut random);
        let held_out = persons(4, truth / 2.0, correlation, &mut random);
        let calibration = halved(observed_persons(fitted, held_out), seed, &mut random);
        let posterior = calibration.posterior();
        let rank = posterior.cdf(0, truth);
        covered += u32::from((0.05..=0.95).contains(&rank));
        ranks.push(rank);
        let predictive = calibration.predictive(&posterior).remove(0);
        let p = predictive.held_out_runs.unwrap().p_value.unwrap();
        low_p += u32::from(p < 0.1);
        // The same counts as if all trials were independent.
        let mut independent = calibration.observed()[0].clone();
        independent.clusters.clear();
        let other = calibration.with_observed(vec![independent]).unwrap();
        naive += u32::from((0.05..=0.95).contains(&other.posterior().cdf(0, truth)));
    }
    // Binomial(100, 0.9): 81 or fewer has probability 5e-3, 98 or more 2e-3.
    assert!((82..=97).contains(&covered), "{covered}, naive {naive}");
    // Binomial(100, 0.1), 20 or more: 2e-3.
    assert!(low_p < 20, "{low_p}");
    assert!(naive < covered, "{naive} {covered}");
    ranks.sort_by(f64::total_cmp);
    let count = ranks.len() as f64;
    let distance = (ranks.iter().enumerate()).map(|(i, rank)| {
        let (low, high) = (i as f64 / count, (i as f64 + 1.0) / count);
        (rank - low).abs().max((rank - high).abs())
    });
    let distance = distance.fold(0.0, f64::max);
    assert!(distance < 1.95 / count.sqrt(), "{distance}");
}

#[test]
fn persons_unlike_the_others_contradict_their_prediction() {
    let mut random = Random::new(6, "others");
    let fitted = vec![counted(1, 10); 8];
    let calibration = halved(
        observed_persons(fitted, vec![counted(9, 10); 2]),
        1,
        &mut random,
    );
    let predictive = calibration.predictive(&calibration.posterior()).remove(0);
    assert!(predictive.counted.p_value.unwrap() > 0.1, "{predictive:?}");
    let held_out = predictive.held_out_runs.unwrap();
    assert_eq!((held_out.occurrences, held_out.opportunities), (18, 20));
    assert!(held_out.p_value.unwrap() < 1e-3, "{held_out:?}");
    assert!(held_out.high < 12, "{held_out:?}");
}
