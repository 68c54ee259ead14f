//! Whether two proportions agree within a margin: an exact unconditional test, which errs at most at its level.
//!
//! # Definition
//! With `X ~ Binomial(n1, p1)`, `Y ~ Binomial(n2, p2)` and margin `m`, the hypothesis "the rates differ by `m` or more" is
//! `p1 - p2 >= m` or `p2 - p1 >= m`. For the first, outcomes are ordered by the signed likelihood ratio
//!
//! ```text
//! T(x, y) = sign(x/n1 - y/n2 - m) * 2 (max over all p1, p2 of l(x, y) - max over p1 - p2 = m of l(x, y)),
//! p(x, y) = sup over p1 - p2 >= m of P(T(X, Y) <= T(x, y))
//! ```
//!
//! and for the second with the samples exchanged. The p-value of the test is the larger of both (two one-sided tests).
//!
//! `T` grows with `x` and falls with `y`: by the envelope theorem its derivative by `x` is twice the difference of the log
//! odds of `x/n1` and of the first rate that is most likely on `p1 - p2 = m`, of which the latter is the larger one where
//! `x/n1 - y/n2 < m` and the smaller one elsewhere. So `{T <= t}` contains with `(x, y)` also `(x - 1, y)` and
//! `(x, y + 1)` (Barnard's condition of convexity), its probability falls with `p1` and grows with `p2`, and the supremum
//! is one over the nuisance parameter `u` in `p1 = u + m`, `p2 = u`.
//!
//! Only those `u` are gone through that Clopper and Pearson's intervals of both rates leave, which both hold with
//! probability `1 -` [`BEYOND`]; that is added to the p-value (Berger and Boos), which is therefore never below it. Rates
//! that the data exclude do not count against agreement then, and the cost grows with the root of the trials only.
//!
//! # The supremum
//! Found by branch and bound over `u`, to a relative [`TOLERANCE`], and given as an upper bound. With
//! `f(u) = P(T <= t)` and `I = n1 / (p1 q1) + n2 / (p2 q2)`, all derivatives are bounded by
//!
//! ```text
//! |f^(k)| <= sqrt(k! I^k f (1 - f)):
//! ```
//!
//! the likelihood at `u + e` over that at `u` is a product over all trials of `1 + e s_i`, with independent scores `s_i` of
//! mean 0 and variance `1 / (p q)`; so the `k`-th derivative of the likelihood over the likelihood is `k!` times the
//! elementary symmetric polynomial of the scores, whose variance is at most `k! I^k`, and its covariance with an indicator
//! is bounded by Cauchy and Schwarz. `k = 1` bounds `f` on an interval, `k = 3` the remainder of its expansion to the
//! second order about the middle. Where `I` is infinite (a rate of 0 or 1), `f` on `[a, b]` is at most its value at
//! `p1 = a + m`, `p2 = b`.
//!
//! # Source
//! I. S. F. Chan, "Exact tests of equivalence and efficacy with a non-zero lower bound for comparative studies",
//! Statistics in Medicine 17 (1998), for exact unconditional p-values with the nuisance parameter maximised;
//! J. Röhmel and U. Mansmann, "Unconditional non-asymptotic one-sided tests for independent binomial proportions when the
//! interest lies in showing non-inferiority and/or superiority", Biometrical Journal 41 (1999), for Barnard's condition and
//! the boundary; D. J. Schuirmann (1987) for the two one-sided tests; R. L. Berger and D. D. Boos, "P values maximized over
//! a confidence set for the nuisance parameter", Journal of the American Statistical Association 89 (1994). Deviations:
//! the order is the likelihood ratio's, since Barnard's condition is proved for it, and not that of the score; the bounds
//! of the derivatives are this project's.
//!
//! # Assumes
//! Trials of each sample are independent with one rate, the samples are independent of each other, and both sizes were
//! fixed in advance. Nothing of the rates.
//!
//! # Guarantee
//! Two rates that differ by the margin or more are said to agree with probability at most the level, whatever they are,
//! at every pair of sample sizes. The largest probabilities in percent over all boundary points in steps of 1/400 of their
//! range, at levels of 1, 5 and 10 %, beside those of the larger p-value of [`crate::tost`] with Agresti and Caffo's variance
//! and [`crate::score_equivalence`] (`cargo run -p corroborate-stats --release --example equivalence_size`; sums over all outcomes, of
//! which this is a part: twelve pairs of sizes from 5 and 5 to 100 and 100, margins of 1 to 30 points):
//!
//! | trials | margin | exact | approximate |
//! |---|---|---|---|
//! | 5, 100 | 0.3 | 0, 4.79, 9.25 | 0, 7.58, 12.91 |
//! | 10, 30 | 0.3 | 0.90, 4.80, 8.50 | 0.90, 4.80, 14.93 |
//! | 12, 97 | 0.2 | 0.69, 4.36, 9.23 | 0, 6.87, 11.33 |
//! | 30, 30 | 0.3 | 0.93, 4.40, 9.72 | 0.99, 5.62, 11.24 |
//! | 30, 100 | 0.1 | 0.59, 4.24, 7.53 | 0, 5.81, 11.72 |
//! | 60, 60 | 0.15 | 0.91, 4.70, 9.68 | 0.68, 5.06, 10.12 |
//! | 60, 120 | 0.2 | 0.97, 4.98, 9.96 | 0.98, 5.28, 12.68 |
//! | 100, 100 | 0.1 | 0.79, 4.70, 9.61 | 0.78, 5.76, 11.72 |
//! | largest of all 72 | | 0.98, 4.98, 9.97 | 1.16, 7.58, 19.69 |
//!
//! The chance in percent of showing agreement of two equal rates at 5 %, exact and approximate; and of the approximate test
//! at 4.5 %, by which plans go:
//!
//! | trials | margin | at 0.5 | at 0.8 | at 0.9 | at 0.95 |
//! |---|---|---|---|---|---|
//! | 30, 30 | 0.3 | 48.1, 49.9, 48.2 | 75.5, 78.3, 75.8 | 93.7, 94.6, 93.7 | 99.1, 99.1, 99.1 |
//! | 60, 60 | 0.15 | 0.3, 7.3, 0.1 | 27.7, 30.8, 27.7 | 64.2, 68.0, 63.8 | 90.6, 90.7, 87.6 |
//! | 30, 100 | 0.2 | 21.9, 28.3, 21.9 | 54.4, 56.4, 54.4 | 82.2, 80.6, 80.5 | 93.5, 93.0, 91.2 |
//! | 100, 100 | 0.1 | 0.0, 0.0, 0.0 | 8.6, 10.3, 7.0 | 47.9, 48.0, 43.7 | 78.5, 81.7, 78.1 |
//! | 100, 100 | 0.15 | 35.6, 37.9, 37.9 | 67.1, 68.1, 65.6 | 91.6, 92.4, 91.5 | 99.2, 99.4, 99.2 |
//! | 60, 120 | 0.15 | 19.6, 20.9, 20.8 | 51.2, 53.3, 50.4 | 83.3, 83.4, 81.8 | 96.1, 96.1, 95.9 |
//!
//! # Coherence
//! * Exchanging the samples, or successes and failures, changes nothing.
//! * With the sizes and the range of `u` fixed, the p-value against `p1 - p2 >= m` never grows when `x` falls or `y` grows
//!   (Barnard's condition), and the other one the other way round. The larger of both need not fall all the way to equal
//!   rates, since the second one takes over before: of 731 outcomes that agreed at one of the three levels with `x/n < y/m`
//!   at six pairs of sizes to 24, 4 did not with one more success of `x` (not beyond `y/m`).
//! * Doubling both counts never took agreement away: 0 of 2203.
//! * One trial more of a side, with the outcome towards the other rate: 2 of 1697, both at the level of 1 %. Probabilities of
//!   outcomes of other sizes are other sums, of which no order is proved.
//! * One success more on both sides is no stronger data in general: near 0 it moves both rates to where the variance is
//!   larger.
//! * With ever more trials of one side the p-value approaches that of the exact binomial test against a known probability,
//!   mostly from below: outcomes of the other side that tie there are told apart here.

mod level;
mod region;
mod supremum;

use crate::counts::{Confidence, Sample};
use crate::interval::clopper_pearson;
use level::Band;
use region::Region;
use supremum::{Line, supremum};

/// With more trials in either sample no p-value is given: the work grows with the root of both sizes, to seconds here.
pub const MOST_TRIALS: u64 = 100_000_000;

/// By how much of itself the p-value may exceed the supremum.
pub const TOLERANCE: f64 = 1e-3;

/// The probability that a true rate lies outside the intervals to which the nuisance parameter is confined.
pub const BEYOND: f64 = 1e-4;

/// The counts of a one-sided hypothesis: `x` of `n` exceed `y` of `m` by the margin or more.
#[derive(Clone, Copy, Debug)]
struct Counts {
    x: u64,
    n: u64,
    y: u64,
    m: u64,
    margin: f64,
}

/// The p-value of "the rates differ by `margin` or more"; `None` when either sample carries no information, the margin
/// is not between 0 and 1, or there are more trials than a hundred million, where [`score_equivalence`](crate::score_equivalence)
/// is as good.
///
/// ```
/// use stats::{Sample, exact_equivalence};
/// let (experiment, simulation) = (Sample::new(88, 100)?, Sample::new(439, 500)?);
/// assert!(exact_equivalence(experiment, simulation, 0.05) > Some(0.05));
/// assert!(exact_equivalence(experiment, simulation, 0.10) < Some(0.05));
/// # Ok::<(), stats::StatsError>(())
/// ```
#[must_use]
pub fn exact_equivalence(first: Sample, second: Sample, margin: f64) -> Option<f64> {
    let valid = first.is_informative() && second.is_informative() && margin > 0.0;
    if !valid || margin >= 1.0 || first.trials.max(second.trials) > MOST_TRIALS {
        return None;
    }
    let counts = Counts {
        x: first.successes,
        n: first.trials,
        y: second.successes,
        m: second.trials,
        margin,
    };
    Some(p_value(counts, true))
}

/// The p-value, of all nuisance parameters or of those that both intervals leave.
fn p_value(counts: Counts, confined: bool) -> f64 {
    let exchanged = Counts {
        x: counts.y,
        n: counts.m,
        y: counts.x,
        m: counts.n,
        margin: counts.margin,
    };
    let mut lines = Vec::new();
    for counts in [counts, exchanged] {
        let (from, to) = match confined {
            true => left_by_intervals(&counts),
            false => (0.0, 1.0 - counts.margin),
        };
        let excess = counts.x as f64 / counts.n as f64 - counts.y as f64 / counts.m as f64;
        if from <= to {
            lines.push(Line {
                counts,
                region: Region::new(&counts, needed(&counts, from, to)),
                from,
                to,
            });
        } else if excess > counts.margin {
            // The intervals leave only rates that differ by more than the margin.
            return 1.0;
        }
    }
    let beyond = if confined { BEYOND } else { 0.0 };
    (supremum(&lines) + beyond).min(1.0)
}

/// The second rates on the boundary that both intervals leave.
fn left_by_intervals(counts: &Counts) -> (f64, f64) {
    let Ok(level) = Confidence::new(1.0 - 0.5 * BEYOND) else {
        return (0.0, 1.0 - counts.margin);
    };
    let of = |successes, trials| clopper_pearson(Sample { successes, trials }, level);
    let (first, second) = (of(counts.x, counts.n), of(counts.y, counts.m));
    let from = second.low.max(first.low - counts.margin).max(0.0);
    let to = second.high.min(first.high.min(1.0) - counts.margin);
    (from, to)
}

/// The successes of the second sample that are not negligible anywhere between two of its rates.
fn needed(counts: &Counts, from: f64, to: f64) -> (u64, u64) {
    let (low, high) = (Band::new(counts.m, from), Band::new(counts.m, to));
    (low.from, high.from + high.densities.len() as u64 - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::special::binomial_pmf;

    fn p(x: u64, n: u64, y: u64, m: u64, margin: f64) -> f64 {
        let (first, second) = (
            Sample {
                successes: x,
                trials: n,
            },
            Sample {
                successes: y,
                trials: m,
            },
        );
        exact_equivalence(first, second, margin).unwrap()
    }

    /// `P(X = x, Y = y)` for all outcomes, row by row of `x`.
    fn densities(n: u64, m: u64, first: f64, second: f64) -> Vec<f64> {
        let of = |trials, rate: f64| -> Vec<f64> {
            let rate = rate.clamp(0.0, 1.0);
            (0..=trials)
                .map(|k| binomial_pmf(k, trials, rate))
                .collect()
        };
        let ys = of(m, second);
        let xs = of(n, first);
        xs.iter()
            .flat_map(|x| ys.iter().map(move |y| x * y))
            .collect()
    }

    /// The signed likelihood ratio with the boundary's maximum by a ternary search.
    fn order_by_search(x: u64, n: u64, y: u64, m: u64, margin: f64) -> f64 {
        let term = |k: u64, n: u64, q: f64| {
            let part = |k: f64, q: f64| if k == 0.0 { 0.0 } else { k * q.ln() };
            part(k as f64, q) + part((n - k) as f64, 1.0 - q)
        };
        let at = |u: f64| term(x, n, u + margin) + term(y, m, u);
        let (mut low, mut high) = (0.0, 1.0 - margin);
        for _ in 0..200 {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if at(a) >= at(b) { high = b } else { low = a }
        }
        let (p1, p2) = (x as f64 / n as f64, y as f64 / m as f64);
        let free = term(x, n, p1) + term(y, m, p2);
        (p1 - p2 - margin).signum() * (free - at(0.5 * (low + high))).max(0.0)
    }

    /// The p-value by definition: every outcome ordered by a search, the supremum over a fine grid.
    fn by_definition(x: u64, n: u64, y: u64, m: u64, margin: f64) -> f64 {
        let one_sided = |x: u64, n: u64, y: u64, m: u64| {
            let limit = order_by_search(x, n, y, m, margin) + 1e-7;
            let belongs: Vec<bool> = (0..=n)
                .flat_map(|a| (0..=m).map(move |b| (a, b)))
                .map(|(a, b)| order_by_search(a, n, b, m, margin) <= limit)
                .collect();
            let points = 2000;
            let mut largest = 0.0_f64;
            for point in 0..=points {
                let u = (1.0 - margin) * f64::from(point) / f64::from(points);
                let all = densities(n, m, u + margin, u);
                let inside = all.iter().zip(&belongs).filter(|(_, is)| **is);
                largest = largest.max(inside.map(|(density, _)| density).sum());
            }
            largest
        };
        one_sided(x, n, y, m).max(one_sided(y, m, x, n))
    }

    #[test]
    fn it_is_the_supremum_of_the_definition() {
        let cases = [
            (9, 10, 7, 8, 0.3),
            (5, 5, 9, 9, 0.5),
            (12, 20, 8, 12, 0.3),
            (0, 12, 1, 15, 0.2),
            (14, 15, 3, 4, 0.1),
            (20, 20, 20, 20, 0.15),
            (3, 18, 1, 25, 0.25),
            (1, 1, 1, 1, 0.99),
        ];
        for (x, n, y, m, margin) in cases {
            let counts = Counts { x, n, y, m, margin };
            let (found, wanted) = (p_value(counts, false), by_definition(x, n, y, m, margin));
            // Never below it, and above it by the tolerance and what the grid misses.
            assert!(
                found >= wanted - 1e-12 && found <= wanted * (1.0 + TOLERANCE) + 2e-4,
                "{x}/{n} {y}/{m} {margin}: {found} {wanted}"
            );
        }
    }

    /// Summed over all outcomes at all boundary points of a grid, at sizes that differ, too.
    #[test]
    fn the_level_is_kept_everywhere_on_the_boundary() {
        for (n, m) in [(1, 3), (5, 5), (6, 14), (17, 11)] {
            for margin in [0.05, 0.1, 0.2, 0.3, 0.7] {
                let table: Vec<f64> = (0..=n)
                    .flat_map(|x| (0..=m).map(move |y| p(x, n, y, m, margin)))
                    .collect();
                for step in 0..=100 {
                    let u = (1.0 - margin) * f64::from(step) / 100.0;
                    for (first, second) in [(u + margin, u), (u, u + margin)] {
                        let all = densities(n, m, first, second);
                        for alpha in [0.01, 0.05, 0.1] {
                            let shown = all.iter().zip(&table).filter(|(_, p)| **p <= alpha);
                            let size: f64 = shown.map(|(density, _)| density).sum();
                            assert!(size <= alpha, "{n} {m} {margin} {u} {alpha}: {size}");
                        }
                    }
                }
            }
        }
    }

    /// Barnard's condition: the p-value of one hypothesis over all nuisance parameters.
    #[test]
    fn one_sided_p_values_fall_towards_the_other_rate_and_beyond() {
        let one_sided = |x, n, y, m, margin| {
            let counts = Counts { x, n, y, m, margin };
            let (from, to) = (0.0, 1.0 - margin);
            let region = Region::new(&counts, needed(&counts, from, to));
            let line = Line {
                counts,
                region,
                from,
                to,
            };
            supremum(&[line])
        };
        for (n, m, margin) in [(7, 7, 0.2), (6, 11, 0.1), (13, 5, 0.4)] {
            for (x, y) in (0..=n).flat_map(|x| (0..=m).map(move |y| (x, y))) {
                let here = one_sided(x, n, y, m, margin) * (1.0 + TOLERANCE) + 2e-6;
                assert!(x == 0 || one_sided(x - 1, n, y, m, margin) <= here);
                assert!(y == m || one_sided(x, n, y + 1, m, margin) <= here);
            }
        }
    }

    #[test]
    fn doubled_counts_agree_where_the_counts_do() {
        for (n, m) in [(8, 8), (12, 20), (15, 11)] {
            for (x, y) in (0..=n).flat_map(|x| (0..=m).map(move |y| (x, y))) {
                for margin in [0.2, 0.3, 0.4] {
                    let (once, twice) =
                        (p(x, n, y, m, margin), p(2 * x, 2 * n, 2 * y, 2 * m, margin));
                    for alpha in [0.01, 0.05, 0.1] {
                        assert!(once > alpha || twice <= alpha, "{x}/{n} {y}/{m} {margin}");
                    }
                }
            }
        }
    }

    #[test]
    fn neither_the_order_of_the_samples_nor_what_counts_as_success_matters() {
        for (x, n, y, m) in [(88, 100, 439, 500), (0, 9, 3, 40), (17, 17, 90, 100)] {
            let found = p(x, n, y, m, 0.1);
            for other in [p(y, m, x, n, 0.1), p(n - x, n, m - y, m, 0.1)] {
                assert!(
                    (found / other - 1.0).abs() <= 2.0 * TOLERANCE,
                    "{found} {other}"
                );
            }
        }
    }

    #[test]
    fn against_ever_more_trials_it_becomes_the_exact_binomial_test() {
        // 88 of 100 against 0.9 known, margin 0.1: at most 0.8, or at least 1.
        let known = crate::binomial_test_above(
            Sample {
                successes: 88,
                trials: 100,
            },
            0.8,
        );
        for (trials, most) in [(10_000, 0.25), (10_000_000, 0.03)] {
            let found = p(88, 100, trials / 10 * 9, trials, 0.1);
            let off = (found - known).abs();
            assert!(off < most * known, "{trials}: {found} {known}");
        }
    }

    #[test]
    fn confining_the_nuisance_parameter_costs_its_level_at_most() {
        for (x, n, y, m, margin) in [
            (880, 1000, 890, 1000, 0.05),
            (500, 1000, 520, 1000, 0.06),
            (990, 1000, 985, 900, 0.02),
            (20, 30, 1500, 1900, 0.3),
            (0, 40, 100, 1900, 0.2),
        ] {
            let y = y.min(m);
            let counts = Counts { x, n, y, m, margin };
            let (all, confined) = (p_value(counts, false), p_value(counts, true));
            assert!(
                confined <= all * (1.0 + TOLERANCE) + BEYOND,
                "{all} {confined}"
            );
        }
    }

    #[test]
    fn nothing_and_no_margin() {
        let of = |successes, trials| Sample { successes, trials };
        assert_eq!(exact_equivalence(of(0, 0), of(1, 2), 0.1), None);
        assert_eq!(exact_equivalence(of(1, 2), of(1, 2), 0.0), None);
        assert_eq!(exact_equivalence(of(1, 2), of(1, 2), 1.0), None);
        assert!(p(0, 10, 10, 10, 0.1) > 0.99);
        assert!(p(0, 100_000, 100_000, 100_000, 0.1) > 0.99);
    }
}
