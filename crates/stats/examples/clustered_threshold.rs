//! How often tests of clustered counts against a threshold err at each level: sums over all outcomes.
//!
//! `cargo run -p corroborate-stats --release --example clustered_threshold` prints the tables in the documentation of `stats::clustered`.
//! With `unequal` it prints what is said there of clusters that differ in size. A row has clusters of one size. A figure is the largest probability, in percent, of showing at the level that the rate is
//! on one side of a threshold at which it is: over rates, and over correlations of a beta distribution of them or two
//! laws for which no test was made, in which all failures are of one kind of people.

use stats::special::{binomial_pmf, ln_gamma};
use stats::{
    BetaBinomial, Confidence, Sample, clustered_rate, clustered_test_above, clustered_test_below,
};

const LEVELS: [f64; 4] = [0.05, 0.025, 0.0125, 0.005];
const CORRELATIONS: [f64; 9] = [0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 0.6, 0.7, 0.85];
const RATES: [f64; 5] = [0.5, 0.7, 0.8, 0.9, 0.95];
const SIZES: [(usize, u64); 8] = [
    (4, 5),
    (5, 10),
    (10, 5),
    (20, 2),
    (20, 5),
    (25, 4),
    (30, 3),
    (100, 2),
];

/// P-values of "above" and "below" by each test: at the effective size, by the likelihood, by both, and by these and the
/// probability of a better count.
type Doubts = [[f64; 2]; TESTS];
const TESTS: usize = 4;

/// The p-values at each rate as a threshold.
fn doubts(clusters: &[Sample]) -> [Doubts; RATES.len()] {
    let rate = clustered_rate(clusters, Confidence::P95).expect("clusters");
    let fit = BetaBinomial::fit(clusters).expect("clusters");
    RATES.map(|threshold| {
        let worth = [
            clustered_test_above(rate.worth, threshold),
            clustered_test_below(rate.worth, threshold),
        ];
        let pair = |(above, below): (f64, f64)| [above, below];
        let likelihood = pair(fit.likelihood_tests(threshold));
        let with_count = pair(fit.threshold_tests(threshold));
        let larger = |other: [f64; 2]| [0, 1].map(|side| f64::max(worth[side], other[side]));
        [worth, likelihood, larger(likelihood), larger(with_count)]
    })
}

/// Probabilities of each number of successes in a cluster.
type Law = Vec<f64>;

fn beta_binomial(trials: u64, mean: f64, correlation: f64) -> Law {
    if correlation == 0.0 {
        return (0..=trials)
            .map(|k| binomial_pmf(k, trials, mean))
            .collect();
    }
    let size = (1.0 - correlation) / correlation;
    let (a, b) = (mean * size, (1.0 - mean) * size);
    let beta = |a: f64, b: f64| ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b);
    let one = |k: u64| {
        let (s, f) = (k as f64, (trials - k) as f64);
        let choose = ln_gamma(trials as f64 + 1.0) - ln_gamma(s + 1.0) - ln_gamma(f + 1.0);
        (choose + beta(a + s, b + f) - beta(a, b)).exp()
    };
    (0..=trials).map(one).collect()
}

/// Laws of a rate, with their name.
type Family<'a> = (&'a str, &'a dyn Fn(f64) -> Vec<Law>);

/// A share of the people fails so often that they make all failures.
fn two_kinds(trials: u64, mean: f64, share: f64) -> Law {
    let failing = 1.0 - (1.0 - mean) / share;
    let of = |rate: f64, k: u64| binomial_pmf(k, trials, rate.clamp(0.0, 1.0));
    (0..=trials)
        .map(|k| share * of(failing, k) + (1.0 - share) * of(1.0, k))
        .collect()
}

/// How many clusters have each number of successes, for all outcomes.
fn outcomes(clusters: usize, kinds: usize) -> Vec<Vec<usize>> {
    if kinds == 1 {
        return vec![vec![clusters]];
    }
    let first = 0..=clusters;
    first
        .flat_map(|first| {
            let rest = outcomes(clusters - first, kinds - 1);
            rest.into_iter()
                .map(move |rest| [vec![first], rest].concat())
        })
        .collect()
}

fn probability(outcome: &[usize], law: &Law) -> f64 {
    let total: usize = outcome.iter().sum();
    let mut log = ln_gamma(total as f64 + 1.0);
    for (&times, &each) in outcome.iter().zip(law) {
        if times > 0 {
            log += times as f64 * each.ln() - ln_gamma(times as f64 + 1.0);
        }
    }
    log.exp()
}

fn clusters(outcome: &[usize], trials: u64) -> Vec<Sample> {
    let of = |(successes, &times): (usize, &usize)| {
        let sample = Sample {
            successes: successes as u64,
            trials,
        };
        std::iter::repeat_n(sample, times)
    };
    outcome.iter().enumerate().flat_map(of).collect()
}

/// The probability of a decision, by test, side and level.
type Sizes = [[[f64; 4]; 2]; TESTS];

/// The largest probability of each decision under some laws: by test, side and level.
fn sizes(found: &[(Vec<usize>, [Doubts; RATES.len()])], rate: usize, laws: &[Law]) -> Sizes {
    let mut largest = [[[0.0_f64; 4]; 2]; TESTS];
    for law in laws {
        let mut sums = [[[0.0; 4]; 2]; TESTS];
        for (outcome, doubts) in found {
            let probability = probability(outcome, law);
            for (test, side, level) in cells() {
                if doubts[rate][test][side] <= LEVELS[level] {
                    sums[test][side][level] += probability;
                }
            }
        }
        for (test, side, level) in cells() {
            largest[test][side][level] = largest[test][side][level].max(sums[test][side][level]);
        }
    }
    largest
}

fn cells() -> impl Iterator<Item = (usize, usize, usize)> {
    (0..TESTS)
        .flat_map(|test| (0..2).flat_map(move |side| (0..4).map(move |level| (test, side, level))))
}

/// The larger of each two.
fn larger(one: &Sizes, other: &Sizes) -> Sizes {
    let mut all = *one;
    for (test, side, level) in cells() {
        all[test][side][level] = all[test][side][level].max(other[test][side][level]);
    }
    all
}

/// Even numbers between 0 and 1, by S. Vigna's SplitMix64.
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Of people with these numbers of trials, of whom a share succeeds half of the time and the others always: how often "below" is
/// claimed of their mean, in percent by level, of so many draws.
fn of_unequal(trials: &[u64], share: f64, draws: u64) -> [f64; 4] {
    let mean = 1.0 - 0.5 * share;
    let mut uniform = Uniform(1);
    let mut found = [0_u64; 4];
    for _ in 0..draws {
        let of_one = |&trials: &u64, uniform: &mut Uniform| {
            let fails = uniform.next() < share;
            let failures = (0..trials).filter(|_| fails && uniform.next() < 0.5);
            Sample {
                successes: trials - failures.count() as u64,
                trials,
            }
        };
        let people: Vec<Sample> = trials.iter().map(|it| of_one(it, &mut uniform)).collect();
        let rate = clustered_rate(&people, Confidence::P95).expect("people");
        let fit = BetaBinomial::fit(&people).expect("people");
        let doubt = clustered_test_below(rate.worth, mean).max(fit.threshold_tests(mean).1);
        for (count, level) in found.iter_mut().zip(LEVELS) {
            *count += u64::from(doubt <= level);
        }
    }
    found.map(|it| 100.0 * it as f64 / draws as f64)
}

/// People of unequal numbers of trials.
fn print_unequal() {
    let few_with_many = [[3; 12].as_slice(), &[40; 3]].concat();
    let all: Vec<u64> = (0..20).map(|it| 1 + it % 19).collect();
    for (name, trials) in [("12 x 3 and 3 x 40", few_with_many), ("20 x 1 to 19", all)] {
        let found = of_unequal(&trials, 0.8, 20_000).map(|it| format!("{it:.1}"));
        println!(
            "unequal, four of five fail half of the time, below: {name}: {}",
            found.join(" ")
        );
    }
}

fn main() {
    if std::env::args().nth(1).as_deref() == Some("unequal") {
        print_unequal();
        return;
    }
    println!(
        "| clusters x trials | law | claim | at `n*` | by the likelihood | by both | and a better count |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (number, trials) in SIZES {
        let all = outcomes(number, trials as usize + 1);
        let with_doubts = |it: &Vec<usize>| (it.clone(), doubts(&clusters(it, trials)));
        let found: Vec<_> = all.iter().map(with_doubts).collect();
        let beta = |rate: f64| {
            let of = |it| beta_binomial(trials, rate, it);
            CORRELATIONS.map(of).to_vec()
        };
        let others = |rate: f64| {
            let failing = 1.0 - rate;
            vec![
                two_kinds(trials, rate, failing),
                two_kinds(trials, rate, 2.0 * failing),
            ]
        };
        let laws: [Family<'_>; 2] = [("beta", &beta), ("two kinds", &others)];
        for (name, laws) in laws {
            let at = |(place, rate): (usize, f64)| sizes(&found, place, &laws(rate));
            let rates = RATES.into_iter().enumerate().map(at);
            let largest = rates.fold(Sizes::default(), |all, it| larger(&all, &it));
            for (side, claim) in ["above", "below"].iter().enumerate() {
                let of = |test: usize| {
                    largest[test][side]
                        .map(|it| format!("{:.1}", 100.0 * it))
                        .join(" ")
                };
                println!(
                    "| {number} x {trials} | {name} | {claim} | {} | {} | {} | {} |",
                    of(0),
                    of(1),
                    of(2),
                    of(3)
                );
            }
        }
    }
}
