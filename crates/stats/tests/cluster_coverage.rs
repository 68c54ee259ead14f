//! The tables of coverage in `stats::clustered` and `stats::common_correlation`, measured. Run them with
//!
//! ```text
//! cargo test --release -p stats --test cluster_coverage -- --ignored --nocapture
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
                    let total = heterogeneity::pool(&own).unwrap();
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
