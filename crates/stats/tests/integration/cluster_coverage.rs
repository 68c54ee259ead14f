//! Coverage of clustered rates: exactly, by enumeration of all outcomes, where these are few; and the tables in
//! `stats::clustered` and `stats::common_correlation`. Run the tables with
//!
//! ```text
//! cargo test --release -p corroborate-stats --test integration -- cluster_coverage --ignored --nocapture
//! ```

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

    /// Clusters whose rates have the beta distribution with this mean and correlation.
    fn clusters(&mut self, count: usize, trials: u64, mean: f64, correlation: f64) -> Vec<Sample> {
        let theta = correlation / (1.0 - correlation);
        let rates = BetaPosterior::new(mean / theta, (1.0 - mean) / theta);
        (0..count)
            .map(|_| {
                let u = self.next().clamp(1e-12, 1.0 - 1e-12);
                let rate = rates.as_ref().map_or(mean, |rates| rates.quantile(u));
                let successes = (0..trials).filter(|_| self.next() < rate).count() as u64;
                Sample { successes, trials }
            })
            .collect()
    }
}

const METHODS: [&str; 7] = [
    "pooled", "anova", "robust", "korn-g", "wilson*", "jeff*", "betabin",
];

fn intervals(clusters: &[Sample]) -> [Interval; 7] {
    let level = Confidence::P95;
    let robust = ClusterRobust::of(clusters).unwrap();
    let pooled = wilson(robust.total, level);
    let rate = clustered_rate(clusters, level).unwrap();
    let anova = match clustering(clusters) {
        Ok(found) => wilson(found.effective_sample(), level),
        Err(_) => pooled,
    };
    [
        pooled,
        anova,
        robust.interval(level),
        robust.adjusted_interval(level),
        wilson(robust.adjusted_sample(level), level),
        wilson(rate.worth, level),
        rate.interval,
    ]
}

#[test]
#[ignore = "prints the table of the documentation; minutes of work"]
fn table() {
    let repetitions = 1000;
    println!(
        "clusters trials rate  rho   {}",
        METHODS.map(|m| format!("{m:>13}")).concat()
    );
    for (count, trials) in [(5, 10), (10, 10), (20, 10), (50, 10), (10, 50)] {
        for mean in [0.5, 0.88, 0.97] {
            for correlation in [0.0, 0.1, 0.3] {
                let mut uniform = Uniform(count as u64 * 1000 + trials);
                let (mut covered, mut width) = ([0; 7], [0.0; 7]);
                for _ in 0..repetitions {
                    let clusters = uniform.clusters(count, trials, mean, correlation);
                    for (m, interval) in intervals(&clusters).into_iter().enumerate() {
                        covered[m] += usize::from(interval.contains(mean));
                        width[m] += interval.width();
                    }
                }
                let cell = |m: usize| {
                    let share = 100.0 * covered[m] as f64 / f64::from(repetitions);
                    format!("{share:>6.1} ({:.2})", width[m] / f64::from(repetitions))
                };
                let cells: String = (0..7).map(|m| format!("{:>13}", cell(m))).collect();
                println!("{count:>8} {trials:>6} {mean:>4}  {correlation:<4} {cells}");
            }
        }
    }
}

/// The probabilities of 0 to `trials` successes of a cluster.
fn beta_binomial(trials: u64, mean: f64, correlation: f64) -> Vec<f64> {
    let theta = correlation / (1.0 - correlation);
    let rising = |k: u64, a: f64| (0..k).map(|i| a + theta * i as f64).product::<f64>();
    let mut ways = 1.0;
    let mut all = Vec::new();
    for s in 0..=trials {
        let both = rising(s, mean) * rising(trials - s, 1.0 - mean);
        all.push(ways * both / rising(trials, 1.0));
        ways *= (trials - s) as f64 / (s + 1) as f64;
    }
    all
}

/// All ways in which so many clusters can have the outcomes from `at` on, given to `take` as how many have which.
fn each_outcome(counts: &mut Vec<u64>, at: usize, clusters: u64, take: &mut dyn FnMut(&[u64])) {
    if at + 1 == counts.len() {
        counts[at] = clusters;
        return take(counts);
    }
    for here in 0..=clusters {
        counts[at] = here;
        each_outcome(counts, at + 1, clusters - here, take);
    }
}

/// The coverage of the interval of a clustered rate, by mean and correlation of the cases.
fn exact_coverage(clusters: u64, trials: u64, cases: &[(f64, f64)]) -> Vec<f64> {
    let of_case = |&(mean, correlation): &(f64, f64)| beta_binomial(trials, mean, correlation);
    let chances: Vec<Vec<f64>> = cases.iter().map(of_case).collect();
    let mut covered = vec![0.0; cases.len()];
    let mut take = |counts: &[u64]| {
        let alike = |(successes, times): (u64, &u64)| {
            std::iter::repeat_n(Sample { successes, trials }, *times as usize)
        };
        let all: Vec<Sample> = (0..).zip(counts).flat_map(alike).collect();
        let interval = clustered_rate(&all, Confidence::P95).unwrap().interval;
        for ((case, chances), covered) in cases.iter().zip(&chances).zip(&mut covered) {
            if interval.contains(case.0) {
                // The multinomial probability of so many clusters with each outcome.
                let (mut left, mut chance) = (0.0, 1.0);
                for (times, p) in counts.iter().zip(chances) {
                    for i in 1..=*times {
                        left += 1.0;
                        chance *= left * p / i as f64;
                    }
                }
                *covered += chance;
            }
        }
    };
    let mut counts = vec![0; trials as usize + 1];
    each_outcome(&mut counts, 0, clusters, &mut take);
    covered
}

/// Five people with four trials each: 126 outcomes. With chi-squared's limit of the likelihood 90.6 % at least, with
/// that limit times k/(k - 1) 92.4 %.
#[test]
fn few_people_are_covered_exactly_as_said() {
    let mut cases = Vec::new();
    for mean in [0.5, 0.7, 0.88, 0.95, 0.97, 0.99] {
        cases.extend([0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7].map(|correlation| (mean, correlation)));
    }
    let covered = exact_coverage(5, 4, &cases);
    let least = covered.iter().copied().fold(1.0, f64::min);
    assert!((least - 0.9588).abs() < 5e-4, "{least} {covered:?}");
}

#[test]
#[ignore = "prints the table of the documentation; minutes of work"]
fn exact_table() {
    let correlations = [0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7];
    for (clusters, trials) in [
        (4, 5),
        (5, 2),
        (5, 5),
        (5, 10),
        (7, 10),
        (10, 2),
        (10, 5),
        (20, 2),
        (20, 3),
        (20, 5),
        (50, 2),
    ] {
        for mean in [0.5, 0.7, 0.88, 0.95, 0.97, 0.99] {
            let covered = exact_coverage(clusters, trials, &correlations.map(|rho| (mean, rho)));
            let cells: String = covered
                .iter()
                .map(|c| format!("{:>6.1}", 100.0 * c))
                .collect();
            println!("{clusters:>3} x {trials:<3} {mean:<5} {cells}");
        }
    }
}

/// A rate counted by cluster, and the same as a total, beside three columns of the same clusters, each with rates of
/// its own.
#[test]
#[ignore = "prints the table of the documentation; minutes of work"]
fn table_of_a_common_correlation() {
    let (repetitions, level) = (500, Confidence::P95);
    println!("clusters trials  rate  rho    by cluster    of a total   independent   each once");
    let mut least = [100.0_f64; 2];
    for (count, trials) in [(5, 5), (10, 10), (20, 5)] {
        for mean in [0.005, 0.03, 0.12, 0.5] {
            for correlation in [0.0, 0.1, 0.3, 0.5] {
                let mut uniform = Uniform(count as u64 * 1000 + trials);
                let (mut covered, mut width) = ([0; 4], [0.0; 4]);
                for _ in 0..repetitions {
                    let mut draw = |mean| uniform.clusters(count, trials, mean, correlation);
                    let others = [draw(0.12), draw(0.05), draw(0.03)];
                    let own = draw(mean);
                    let common = CommonCorrelation::of(&others).unwrap();
                    let total = pool(&own).unwrap();
                    let of_total = common.rate(total, &vec![trials; count], level).unwrap();
                    let alone = clustered_rate(&own, level).unwrap();
                    let intervals = [
                        match alone.method {
                            ClusterMethod::OneEach => of_total.interval,
                            _ => alone.interval,
                        },
                        of_total.interval,
                        wilson(total, level),
                        alone.interval,
                    ];
                    for (m, interval) in intervals.into_iter().enumerate() {
                        covered[m] += usize::from(interval.contains(mean));
                        width[m] += interval.width();
                    }
                }
                let share = |m: usize| 100.0 * covered[m] as f64 / f64::from(repetitions);
                let cell = |m: usize| {
                    format!("{:.1} ({:.2})", share(m), width[m] / f64::from(repetitions))
                };
                let cells: String = (0..4).map(|m| format!("{:>14}", cell(m))).collect();
                println!("{count:>8} {trials:>6} {mean:>5}  {correlation:<4}{cells}");
                least = [least[0].min(share(0)), least[1].min(share(1))];
            }
        }
    }
    println!("least: {least:?}");
}
