//! How often tests of equivalence err, and how often they show it: sums over all outcomes.
//!
//! `cargo run -p corroborate-stats --release --example equivalence_size` prints the tables in the documentation of
//! `stats::exact_equivalence`: for each pair of sizes and margin the largest probability of showing equivalence over all
//! boundary points, the chance of showing it of two equal rates, what happens to agreement when data become stronger, and
//! what one p-value costs.

use stats::special::binomial_pmf;
use stats::{DifferenceVariance, Sample, exact_equivalence, score_equivalence, tost};
use std::time::Instant;

const SIZES: [(u64, u64); 12] = [
    (5, 5),
    (5, 100),
    (10, 10),
    (10, 30),
    (12, 97),
    (20, 20),
    (29, 51),
    (30, 30),
    (30, 100),
    (60, 60),
    (60, 120),
    (100, 100),
];
const MARGINS: [f64; 6] = [0.01, 0.05, 0.1, 0.15, 0.2, 0.3];
const LEVELS: [f64; 3] = [0.01, 0.05, 0.1];
/// Boundary points, of each side.
const POINTS: u32 = 400;

type Test = fn(Sample, Sample, f64) -> f64;
const TESTS: [Test; 3] = [exact, approximate, planned];
const NAMES: [&str; 3] = ["exact", "approximate", "planned"];

fn exact(first: Sample, second: Sample, margin: f64) -> f64 {
    exact_equivalence(first, second, margin).unwrap_or(1.0)
}

/// The larger p-value of Agresti and Caffo's variance and of the score.
fn approximate(first: Sample, second: Sample, margin: f64) -> f64 {
    let tost = tost(first, second, margin, DifferenceVariance::AgrestiCaffo);
    let score = score_equivalence(first, second, margin);
    tost.map_or(1.0, |tost| tost.p_value())
        .max(score.unwrap_or(1.0))
}

/// What plans go by instead of the exact test: the approximate one at nine tenths of the level.
fn planned(first: Sample, second: Sample, margin: f64) -> f64 {
    approximate(first, second, margin) / 0.9
}

fn of(test: Test, (x, n): (u64, u64), (y, m): (u64, u64), margin: f64) -> f64 {
    let first = Sample {
        successes: x,
        trials: n,
    };
    let second = Sample {
        successes: y,
        trials: m,
    };
    test(first, second, margin)
}

/// The p-values of all outcomes.
fn table((n, m): (u64, u64), margin: f64, test: Test) -> Vec<f64> {
    let all = (0..=n).flat_map(|x| (0..=m).map(move |y| (x, y)));
    all.map(|(x, y)| of(test, (x, n), (y, m), margin)).collect()
}

/// The probability of a p-value of at most each level.
fn shown((n, m): (u64, u64), table: &[f64], first: f64, second: f64) -> [f64; 3] {
    let densities = |trials, rate: f64| -> Vec<f64> {
        let rate = rate.clamp(0.0, 1.0);
        (0..=trials)
            .map(|k| binomial_pmf(k, trials, rate))
            .collect()
    };
    let (xs, ys) = (densities(n, first), densities(m, second));
    let mut sums = [0.0; 3];
    for (x, row) in xs.iter().zip(table.chunks(ys.len())) {
        for (y, p) in ys.iter().zip(row) {
            for (sum, level) in sums.iter_mut().zip(LEVELS) {
                if *p <= level {
                    *sum += x * y;
                }
            }
        }
    }
    sums
}

fn size(sizes: (u64, u64), table: &[f64], margin: f64) -> [f64; 3] {
    let mut largest = [0.0_f64; 3];
    for point in 0..=POINTS {
        let u = (1.0 - margin) * f64::from(point) / f64::from(POINTS);
        for (first, second) in [(u + margin, u), (u, u + margin)] {
            for (most, now) in largest.iter_mut().zip(shown(sizes, table, first, second)) {
                *most = most.max(now);
            }
        }
    }
    largest
}

fn sizes() {
    println!("largest size in % at levels of 1, 5 and 10 %, over all boundary points");
    println!("sizes      margin  exact                approximate          planned");
    let mut overall = [[0.0_f64; 3]; 3];
    for sizes in SIZES {
        for margin in MARGINS {
            let mut line = format!("{:>4} {:>4}  {margin:>6}", sizes.0, sizes.1);
            for (overall, test) in overall.iter_mut().zip(TESTS) {
                let found = size(sizes, &table(sizes, margin, test), margin);
                for (most, now) in overall.iter_mut().zip(found) {
                    *most = most.max(now);
                }
                let [a, b, c] = found.map(|size| 100.0 * size);
                line += &format!("  {a:5.2} {b:5.2} {c:5.2}");
            }
            println!("{line}");
        }
    }
    println!("largest of all: {overall:.4?}");
}

fn chances() {
    println!("\nchance in % of showing equivalence of equal rates, level 5 %");
    println!("sizes      margin    rate   exact  approximate  planned");
    let cases = [
        ((30, 30), 0.3),
        ((60, 60), 0.15),
        ((30, 100), 0.2),
        ((100, 100), 0.1),
        ((100, 100), 0.15),
        ((60, 120), 0.15),
    ];
    for (sizes, margin) in cases {
        let tables = TESTS.map(|test| table(sizes, margin, test));
        for rate in [0.5, 0.8, 0.9, 0.95, 1.0] {
            let [a, b, c] = tables
                .each_ref()
                .map(|table| 100.0 * shown(sizes, table, rate, rate)[1]);
            let (n, m) = sizes;
            println!("{n:>4} {m:>4}  {margin:>6}  {rate:>6}  {a:6.1}  {b:6.1}  {c:6.1}");
        }
    }
}

/// A change of the data that makes agreement stronger; `None` where it does not apply.
type Stronger = fn(x: u64, n: u64, y: u64, m: u64) -> Option<(u64, u64, u64, u64)>;

/// Of how many outcomes agreement at a level is lost by a change.
fn losses() {
    println!(
        "\noutcomes of sizes to 24 that agree, and those of them that do not after the change"
    );
    let changes: [(&str, Stronger); 4] = [
        ("both counts doubled", |x, n, y, m| {
            Some((2 * x, 2 * n, 2 * y, 2 * m))
        }),
        ("one success more on both sides", |x, n, y, m| {
            Some((x + 1, n + 1, y + 1, m + 1))
        }),
        ("one trial more towards the other rate", |x, n, y, m| {
            let lower = x * m <= y * n;
            let next = (x + u64::from(lower), n + 1, y, m);
            // Not beyond the other rate.
            (lower == (next.0 * m <= y * next.1)).then_some(next)
        }),
        (
            "one outcome changed towards the other rate",
            |x, n, y, m| {
                let next = (x + 1, n, y, m);
                ((x + 1) * m <= y * n).then_some(next)
            },
        ),
    ];
    for (name, change) in changes {
        for (which, test) in NAMES.iter().zip(TESTS).take(2) {
            let (mut agree, mut lost) = ([0_u64; 3], [0_u64; 3]);
            for (n, m) in [(8, 8), (12, 20), (16, 16), (24, 24), (24, 10), (20, 21)] {
                for (x, y) in (0..=n).flat_map(|x| (0..=m).map(move |y| (x, y))) {
                    for margin in [0.1, 0.2, 0.3, 0.4] {
                        let Some((a, k, b, l)) = change(x, n, y, m) else {
                            continue;
                        };
                        let now = of(test, (x, n), (y, m), margin);
                        let then = of(test, (a, k), (b, l), margin);
                        for (place, level) in LEVELS.into_iter().enumerate() {
                            agree[place] += u64::from(now <= level);
                            lost[place] += u64::from(now <= level && then > level);
                        }
                    }
                }
            }
            println!("{name:<45} {which:<12} {agree:?} {lost:?}");
        }
    }
}

fn costs() {
    println!("\nmicroseconds for one p-value");
    let sizes = [
        (20, 20),
        (100, 100),
        (100, 1000),
        (1000, 1000),
        (5000, 5000),
        (100, 100_000),
        (1_000_000, 1_000_000),
    ];
    for (n, m) in sizes {
        let start = Instant::now();
        let mut sum = 0.0;
        for repeat in 0..10 {
            sum += of(exact, (n * 9 / 10 - repeat, n), (m * 9 / 10, m), 0.1);
        }
        let each = start.elapsed().as_secs_f64() * 1e5;
        println!("{n:>8} {m:>8}  {each:>9.0}  (sum of ten {sum:.3})");
    }
}

fn main() {
    costs();
    losses();
    chances();
    sizes();
}
