//! Whether intervals and tests keep what they promise, by simulation with fixed seeds.
//!
//! Each rate of coverage or of false alarms is held to its bound within four standard deviations
//! of the simulation, so that a method that misses its level by more fails the test.

use stats::*;

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

    fn sample(&mut self, trials: u64, rate: f64) -> Sample {
        let successes = (0..trials).filter(|_| self.next() < rate).count() as u64;
        Sample { successes, trials }
    }

    /// Clusters whose rates are drawn from the beta distribution with this mean and correlation.
    fn clusters(&mut self, count: usize, trials: u64, mean: f64, correlation: f64) -> Vec<Sample> {
        let theta = correlation / (1.0 - correlation);
        let rates = BetaPosterior::new(mean / theta, (1.0 - mean) / theta);
        (0..count)
            .map(|_| {
                let u = self.next().clamp(1e-12, 1.0 - 1e-12);
                let rate = rates.as_ref().map_or(mean, |rates| rates.quantile(u));
                self.sample(trials, rate)
            })
            .collect()
    }
}

/// Four standard deviations of a share of `count` that is `share` in truth.
fn tolerance(share: f64, count: usize) -> f64 {
    4.0 * (share * (1.0 - share) / count as f64).sqrt()
}

#[test]
fn intervals_of_clustered_rates_cover_and_the_naive_ones_do_not() {
    let repetitions = 1000;
    let designs = [
        (10, 10, 0.5, 0.0),
        (10, 10, 0.88, 0.1),
        (10, 10, 0.88, 0.3),
        (20, 10, 0.5, 0.3),
        (20, 10, 0.88, 0.1),
    ];
    let mut naive = 0;
    for (index, (count, trials, mean, correlation)) in designs.into_iter().enumerate() {
        let mut uniform = Uniform(index as u64);
        let (mut robust, mut adjusted) = (0, 0);
        for _ in 0..repetitions {
            let clusters = uniform.clusters(count, trials, mean, correlation);
            let rate = ClusterRobust::of(&clusters).unwrap();
            robust += usize::from(rate.interval(Confidence::P95).contains(mean));
            adjusted += usize::from(rate.adjusted_interval(Confidence::P95).contains(mean));
            naive += usize::from(wilson(rate.total, Confidence::P95).contains(mean));
        }
        // Within a point of the level; at 10 clusters and 88 % the ends are near and it is wider.
        let covered = robust as f64 / repetitions as f64;
        let range = 0.94 - tolerance(0.95, repetitions)..0.965 + tolerance(0.95, repetitions);
        assert!(range.contains(&covered), "{designs:?}[{index}]: {covered}");
        assert!(adjusted as f64 / repetitions as f64 > 0.95 - tolerance(0.95, repetitions));
    }
    let covered = naive as f64 / (repetitions * designs.len()) as f64;
    assert!(
        covered < 0.87,
        "intervals that ignore the clusters miss: {covered}"
    );
}

#[test]
fn the_profile_of_the_beta_binomial_covers() {
    let repetitions = 300;
    for (index, (count, mean, correlation)) in [(10, 0.5, 0.3), (20, 0.88, 0.3), (20, 0.5, 0.1)]
        .into_iter()
        .enumerate()
    {
        let mut uniform = Uniform(index as u64);
        let covered = (0..repetitions)
            .filter(|_| {
                let clusters = uniform.clusters(count, 10, mean, correlation);
                BetaBinomial::fit(&clusters)
                    .unwrap()
                    .interval(Confidence::P95)
                    .contains(mean)
            })
            .count() as f64
            / repetitions as f64;
        assert!(
            (covered - 0.955).abs() < 0.01 + tolerance(0.95, repetitions),
            "{index}: {covered}"
        );
    }
}

/// Few people with few trials each, correlations from 0 to 0.5, rates at the ends: what cannot tell how alike its
/// trials are covers by what its neighbours tell, where trials taken as independent do not.
#[test]
fn counts_that_cannot_tell_their_correlation_cover_by_a_common_one() {
    let (repetitions, level) = (60, Confidence::P95);
    let designs = [
        (5, 5, 0.03, 0.5),
        (5, 10, 0.005, 0.1),
        (10, 10, 0.97, 0.3),
        (20, 5, 0.5, 0.5),
    ];
    let mut covered = [0; 3];
    for (index, (count, trials, mean, correlation)) in designs.into_iter().enumerate() {
        let mut uniform = Uniform(index as u64);
        for _ in 0..repetitions {
            let mut draw = |mean| uniform.clusters(count, trials, mean, correlation);
            let (first, second, own) = (draw(0.88), draw(0.05), draw(mean));
            let common = CommonCorrelation::of(&[&first, &second]).unwrap();
            let total = pool(&own).unwrap();
            let of_total = common.rate(total, &vec![trials; count], level).unwrap();
            let of_ends = clustered_rate_among(&common, &own, level).unwrap();
            covered[0] += usize::from(of_total.interval.contains(mean));
            covered[1] += usize::from(of_ends.interval.contains(mean));
            covered[2] += usize::from(wilson(total, level).contains(mean));
        }
    }
    let draws = repetitions * designs.len();
    let least = (0.94 - tolerance(0.94, draws)) * draws as f64;
    assert!(
        covered[0] as f64 > least && covered[1] as f64 > least,
        "{covered:?}"
    );
    assert!((covered[2] as f64) < 0.88 * draws as f64, "{covered:?}");
}

#[test]
fn clusters_are_found_where_there_are_some_and_rarely_where_there_are_none() {
    let (repetitions, mut uniform) = (2000, Uniform(9));
    let mut share = |correlation| {
        let found = (0..repetitions).filter(|_| {
            let clusters = uniform.clusters(20, 10, 0.88, correlation);
            BetaBinomial::fit(&clusters).unwrap().p_value <= 0.05
        });
        found.count() as f64 / repetitions as f64
    };
    let false_alarms = share(0.0);
    assert!(
        false_alarms < 0.05 + tolerance(0.05, repetitions),
        "{false_alarms}"
    );
    let found = share(0.3);
    assert!(found > 0.9, "{found}");
}

/// Averaged over rates as Jeffreys' prior has them, its posterior covers exactly; summed over all
/// counts, without simulation.
#[test]
fn posteriors_cover_on_average_over_rates_and_counts() {
    for trials in [5_u64, 20, 100] {
        let prior = BetaPosterior::jeffreys(Sample {
            successes: 0,
            trials: 0,
        });
        let intervals: Vec<Interval> = (0..=trials)
            .map(|successes| {
                BetaPosterior::jeffreys(Sample { successes, trials })
                    .credible_interval(Confidence::P95)
            })
            .collect();
        let points = 4000;
        let mut covered = 0.0;
        for point in 0..points {
            let rate = prior.quantile((f64::from(point) + 0.5) / f64::from(points));
            for (successes, interval) in intervals.iter().enumerate() {
                if interval.contains(rate) {
                    covered += special::binomial_pmf(successes as u64, trials, rate);
                }
            }
        }
        let covered = covered / f64::from(points);
        assert!((covered - 0.95).abs() < 2e-3, "{trials}: {covered}");
    }
}

/// A product of four success rates, each known from counts, as a model's answer: the interval
/// carried through covers the true product.
#[test]
fn intervals_carried_through_a_model_cover() {
    let (repetitions, mut uniform) = (600, Uniform(4));
    let truth = [(0.07, 98), (0.03, 98), (0.02, 100), (0.002, 500)];
    let product: f64 = truth.iter().map(|(rate, _)| 1.0 - rate).product();
    let mut covered = 0;
    for _ in 0..repetitions {
        let posteriors =
            truth.map(|(rate, trials)| BetaPosterior::jeffreys(uniform.sample(trials, rate)));
        let results: Vec<f64> = posterior_design(&posteriors, 256, 1)
            .iter()
            .map(|row| row.iter().map(|rate| 1.0 - rate).product())
            .collect();
        let interval = Draws::new(&results).unwrap().interval(Confidence::P95);
        covered += usize::from(interval.contains(product));
    }
    let covered = covered as f64 / repetitions as f64;
    // Jeffreys' priors add half a failure to each of four counts, which costs a little coverage.
    assert!(
        (covered - 0.95).abs() < 0.015 + tolerance(0.95, repetitions),
        "{covered}"
    );
}

/// Quantiles of Jeffreys' posterior after 0 of n, by mpmath in 40 digits (findroot of betainc); those
/// after n of n are their mirror images.
#[test]
fn posteriors_at_the_ends_from_five_trials_to_a_hundred_million() {
    let cases = [
        (5_u64, 9.342060003954473e-05, 0.3793771422990394),
        (1000, 4.909116947944411e-07, 0.002508164341422298),
        (100_000_000, 4.9103455735883596e-12, 2.5119430558282965e-08),
    ];
    for (trials, low, high) in cases {
        let none = BetaPosterior::jeffreys(Sample {
            successes: 0,
            trials,
        });
        let all = BetaPosterior::jeffreys(Sample {
            successes: trials,
            trials,
        });
        let found = none.credible_interval(Confidence::P95);
        assert!((found.low / low - 1.0).abs() < 1e-11, "{trials}: {found:?}");
        assert!(
            (found.high / high - 1.0).abs() < 1e-11,
            "{trials}: {found:?}"
        );
        let mirrored = all.credible_interval(Confidence::P95);
        assert!((mirrored.low - (1.0 - high)).abs() < 1e-15, "{mirrored:?}");
        assert!((mirrored.high - (1.0 - low)).abs() < 1e-15, "{mirrored:?}");
    }
}
