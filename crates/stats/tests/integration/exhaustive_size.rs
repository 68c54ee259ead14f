//! The size of the two exact tests of two counts over *all* true rates, not over a grid: an upper bound by an independent
//! method, for every level that a p-value can have.
//!
//! The probability of a set of outcomes with `p1 = u + d`, `p2 = u` is a polynomial in `u`. On `[a, b]` each factor `p` or
//! `1 - p` is linear, with its values at both ends as coefficients in the Bernstein basis; products are convolutions of
//! positive numbers, so that nothing cancels. A polynomial is at most its largest Bernstein coefficient, and halving the
//! interval brings that down to the supremum (G. Farin, "Curves and surfaces for computer aided geometric design").

use stats::{Sample, boschloo_exact, exact_equivalence};

/// A polynomial on an interval: Bernstein coefficients times binomial coefficients.
fn times(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            product[i + j] += x * y;
        }
    }
    product
}

fn choose(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product()
}

/// The probabilities of 0 to `n` successes at a rate that goes from `p` to `q`.
fn binomial(n: usize, (p, q): (f64, f64)) -> Vec<Vec<f64>> {
    let of = |k: usize| {
        let mut product = vec![choose(n, k)];
        for i in 0..n {
            let factor = if i < k { [p, q] } else { [1.0 - p, 1.0 - q] };
            product = times(&product, &factor);
        }
        product
    };
    (0..=n).map(of).collect()
}

/// An upper bound, to within `slack`, of the probability of the outcomes over all `u` in `[a, b]`.
fn bound(set: &[Vec<bool>], difference: f64, (a, b): (f64, f64), slack: f64, least: f64) -> f64 {
    let (n, m) = (set.len() - 1, set[0].len() - 1);
    let (xs, ys) = (
        binomial(n, (a + difference, b + difference)),
        binomial(m, (a, b)),
    );
    let mut sum = vec![0.0; n + m + 1];
    for (x, row) in xs.iter().zip(set) {
        for (y, _) in ys.iter().zip(row).filter(|(_, is_in)| **is_in) {
            for (total, one) in sum.iter_mut().zip(times(x, y)) {
                *total += one;
            }
        }
    }
    let coefficient = |k: usize| sum[k] / choose(n + m, k);
    let most = (0..=n + m).map(coefficient).fold(0.0, f64::max);
    let at_ends = coefficient(0).max(coefficient(n + m));
    if most <= least.max(at_ends) + slack || b - a < 1e-6 {
        return most;
    }
    let middle = f64::midpoint(a, b);
    let left = bound(set, difference, (a, middle), slack, least);
    left.max(bound(set, difference, (middle, b), slack, least.max(left)))
}

fn sample(successes: usize, trials: usize) -> Sample {
    Sample {
        successes: successes as u64,
        trials: trials as u64,
    }
}

/// The p-values of all outcomes.
fn table(n: usize, m: usize, p: impl Fn(Sample, Sample) -> f64) -> Vec<Vec<f64>> {
    let row = |x: usize| (0..=m).map(|y| p(sample(x, n), sample(y, m))).collect();
    (0..=n).map(row).collect()
}

/// The distinct p-values up to a half.
fn levels(table: &[Vec<f64>]) -> Vec<f64> {
    let mut all: Vec<f64> = table
        .iter()
        .flatten()
        .copied()
        .filter(|p| *p <= 0.5)
        .collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
    all
}

const SIZES: [(usize, usize); 6] = [(3, 3), (4, 9), (6, 6), (7, 5), (8, 8), (10, 4)];
const SLACK: f64 = 1e-5;

#[test]
fn equivalence_errs_at_most_at_its_level_at_every_rate() {
    let mut tested = 0;
    for (n, m) in SIZES {
        for margin in [0.1, 0.25, 0.4, 0.6] {
            let p = |a, b| exact_equivalence(a, b, margin).expect("a margin");
            let table = table(n, m, p);
            for level in levels(&table) {
                let set: Vec<Vec<bool>> = table
                    .iter()
                    .map(|row| row.iter().map(|p| *p <= level + 1e-12).collect())
                    .collect();
                // The samples exchanged, the other side of the hypothesis.
                let turned: Vec<Vec<bool>> = (0..=m)
                    .map(|y| (0..=n).map(|x| set[x][y]).collect())
                    .collect();
                // Beyond the margin, too, where less is claimed.
                for share in [0.0, 0.3, 0.8] {
                    let apart = margin + share * (1.0 - margin);
                    let interval = (0.0, 1.0 - apart);
                    for set in [&set, &turned] {
                        let most = bound(set, apart, interval, SLACK, 0.0);
                        assert!(
                            most <= level + 2.0 * SLACK,
                            "{n} {m} {margin} {level} {apart}: {most}"
                        );
                    }
                }
                tested += 1;
            }
        }
    }
    assert!(tested > 100, "{tested}");
}

#[test]
fn a_difference_is_wrong_at_most_at_its_level_at_every_rate() {
    let mut reached = 0.0_f64;
    for (n, m) in SIZES {
        let table = table(n, m, boschloo_exact);
        for level in levels(&table) {
            let set: Vec<Vec<bool>> = table
                .iter()
                .map(|row| row.iter().map(|p| *p <= level + 1e-12).collect())
                .collect();
            let most = bound(&set, 0.0, (0.0, 1.0), SLACK, 0.0);
            assert!(most <= level + 2.0 * SLACK, "{n} {m} {level}: {most}");
            reached = reached.max(most / level);
        }
    }
    // The p-value is the supremum itself, so that the test can fail.
    assert!(reached > 0.95, "{reached}");
}
