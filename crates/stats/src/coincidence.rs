//! How probable it is that two independent sources give the same numbers: whether a number was copied.
//!
//! # Definition
//! For `k` of `n` trials and sources that are independent of them, with Jeffreys' posterior `Beta(k + 1/2, n - k + 1/2)` of
//! the rate as what an independent source may have found:
//!
//! ```text
//! constant : max of P(c - w/2 <= rate <= c + w/2)           a number c written in steps of w (0.87: w = 0.01)
//!            and q(b) P(c - 1/(2b) <= rate <= c + 1/(2b))   that rounds to k/n = a/b in lowest terms
//! quotient : P(K = k | n) s(n)                    k/n as a quotient of whole numbers
//! counts   : P(K = k | n) of the beta-binomial predictive distribution        k of n again in as many trials
//! rows     : P(M >= m), M the sum of independent events of the probabilities b(k_i; n_i, k_i / n_i)
//!            (b the binomial probability: the largest that row i can have to be the same, whatever its own rate)
//! contents : P(T >= t), T the rows that two halves share when the pooled rows are divided at random
//! ```
//!
//! `q(b)` is how probable it is at most that another source has a multiple of `b` trials, so that it can give `a/b` at all:
//! an assumption, `min(1, 10/b)` where `b` has the prime factors 2, 3 and 5 alone, as numbers of trials that people choose
//! mostly have, and `min(1, 10 p/b) / p` for the largest prime factor `p` else. `s(n)` is how probable it is at most that another
//! source has just `n`: [`SAME_TRIALS`] where `n` is 1, 2 or 5 times a power of ten, and the less of that and `q(n)` else.
//!
//! Of several coincidences that could have been met in a study, of the probabilities `P_j` each, one is as improbable as
//! `x` with probability at most the sum of the `P_j <= x`; `m` of them together with probability at most `L^m / m!`, `L`
//! the sum of all `P_j` (the elementary symmetric polynomial of degree `m` is at most that). Where two sources have several
//! numbers that could coincide, twice the smaller of both is given, as there are two ways to be improbable.
//!
//! # Source
//! H. Jeffreys (1946) for the prior; M. H. DeGroot, "Probability and statistics" (1975), for predictive distributions;
//! R. A. Fisher (1935) for the division of pooled rows at random. The bound of its tail is Chernoff's, with the generating
//! function over contents `v` that stand in `c_v` of all rows, `sum over x of C(c_v, x) s^x t^min(x, c_v - x)`.
//!
//! # How often it is asked
//! Percent of 2000 studies of each kind (`cargo run --release -p corroborate-stats --example copies`) in which a coincidence has a
//! probability of at most 1 %, and in which a number is a rate with a probability of its own of at most 20 %. Rows "no" are
//! false alarms. Numbers of trials are 20, 50, 100, 200 or 500; "the same, always of as many trials" breaks the assumption
//! of [`SAME_TRIALS`].
//!
//! | evidence | copied | asked, % | noted, % |
//! |---|---|---|---|
//! | 3 constants, guesses, 2 decimals | no | 0.00 | 12.1 |
//! | 3 constants, guesses, 3 decimals | no | 0.00 | 2.9 |
//! | 3 constants, guesses, 4 decimals | no | 0.10 | 1.6 |
//! | 3 constants, the true rates, 2 decimals | no | 0.00 | 17.2 |
//! | 3 constants, the true rates, 3 decimals | no | 0.00 | 4.2 |
//! | 3 constants, the true rates, 4 decimals | no | 0.00 | 0.9 |
//! | 3 constants, rates of a pilot, 2 decimals | no | 0.00 | 9.6 |
//! | 3 constants, rates of a pilot, 3 decimals | no | 0.00 | 3.2 |
//! | 3 constants, rates of a pilot, 4 decimals | no | 0.00 | 2.3 |
//! | 3 constants, quotients of a pilot | no | 0.50 | 2.8 |
//! | the same, always of as many trials | no | 3.75 | 28.0 |
//! | totals of 1 modes in 50 trials | no | 0.00 | 0.0 |
//! | totals of 3 modes in 100 trials | no | 0.00 | 0.0 |
//! | totals of 6 modes in 200 trials | no | 0.00 | 0.0 |
//! | 10 people x 10, correlation 0 | no | 0.00 | 0.0 |
//! | 10 people x 10, correlation 0.1 | no | 0.00 | 0.0 |
//! | 10 people x 10, correlation 0.5 | no | 0.00 | 0.0 |
//! | 40 people x 5, correlation 0.1 | no | 0.10 | 0.0 |
//! | 60 rows of one trial | no | 0.15 | 0.0 |
//! | the same 12 conditions x 20 | no | 0.10 | 0.0 |
//! | a trend over 24 rows x 5 | no | 0.05 | 0.0 |
//! | 1 copied rates, 2 decimals | yes | 0.00 | 48.9 |
//! | 3 copied rates, 2 decimals | yes | 4.95 | 81.8 |
//! | 1 copied rates, 3 decimals | yes | 4.00 | 70.6 |
//! | 3 copied rates, 3 decimals | yes | 46.65 | 90.2 |
//! | 1 copied rates, 4 decimals | yes | 23.20 | 70.0 |
//! | 3 copied rates, 4 decimals | yes | 52.05 | 91.5 |
//! | copied totals of 1 modes in 200 trials | yes | 0.00 | 0.0 |
//! | copied totals of 3 modes in 100 trials | yes | 64.20 | 0.0 |
//! | copied totals of 6 modes in 200 trials | yes | 99.55 | 0.0 |
//! | renamed rows, 5 x 10 | yes | 0.00 | 0.0 |
//! | renamed and mixed rows, 5 x 10 | yes | 0.00 | 0.0 |
//! | renamed rows, 10 x 10 | yes | 70.55 | 0.0 |
//! | renamed and mixed rows, 10 x 10 | yes | 0.00 | 0.0 |
//! | renamed rows, 20 x 10 | yes | 91.35 | 0.0 |
//! | renamed and mixed rows, 20 x 10 | yes | 38.95 | 0.0 |
//! | renamed rows, 40 x 5 | yes | 95.10 | 0.0 |
//! | renamed and mixed rows, 40 x 5 | yes | 37.70 | 0.0 |
//!
//! # Assumes
//! Sources are independent of the counts, and find a rate as its posterior has it; trials are independent. How often
//! numbers of trials are the same is a guess ([`SAME_TRIALS`], `q(b)`). Where several coincidences count together they are
//! independent of each other.
//!
//! # Guarantee
//! *Rows* holds whatever the rates of the rows are, so that neither a trend nor hard and easy conditions nor rows that
//! always succeed pass for a copy (0 of n and n of n count nothing). *Contents* holds if the rows of both tables come from
//! one distribution. *Constant* and *counts* hold on average over what an independent source may have found; how often a
//! study of independent evidence is asked about is measured by `examples/copies.rs`. Cost: linear, but for *contents*:
//! pooled rows times rows of the first table, eight times.

use crate::counts::Sample;
use crate::posterior::BetaPosterior;
use crate::special::{binomial_pmf, ln_gamma};
use std::collections::BTreeMap;

/// The probability that an independent source writes this number, in steps of `step`, where these are the counts.
///
/// ```
/// use stats::{Sample, constant_by_chance};
/// let counts = Sample { successes: 174, trials: 200 };
/// // Two digits say little, four say much.
/// assert!(constant_by_chance(counts, 0.87, 0.01) > 0.15);
/// let long = Sample { successes: 173, trials: 211 };
/// assert!(constant_by_chance(long, 0.8199, 0.0001) < 0.002);
/// ```
#[must_use]
pub fn constant_by_chance(counts: Sample, value: f64, step: f64) -> f64 {
    if !counts.is_informative() {
        return 1.0;
    }
    let posterior = BetaPosterior::jeffreys(counts);
    let within = |step: f64| {
        let (low, high) = (value - 0.5 * step, value + 0.5 * step);
        posterior.probability_between(low.max(0.0), high.min(1.0))
    };
    let below = counts.trials / greatest_divisor(counts.successes, counts.trials);
    within(step).max(common_multiple(below) * within(1.0 / below as f64))
}

/// The probability that an independent source writes this number, in steps of `step`, where the product of two rates (or
/// 1 minus it) is about as large; and whether the number is the product, rounded. `None` where the number is so far from
/// the product that it has no probability.
///
/// The product has the mean and the variance of the product of both posteriors, and is taken as normal (delta method).
///
/// ```
/// use stats::{Sample, product_by_chance};
/// let stages = [(174, 200), (187, 200)].map(|(successes, trials)| Sample { successes, trials });
/// let (chance, met) = product_by_chance(stages, false, 0.81345, 0.00001).unwrap();
/// assert!(met && chance < 2e-4);
/// let (chance, met) = product_by_chance(stages, true, 0.19, 0.01).unwrap();
/// assert!(met && chance > 0.1);
/// assert!(product_by_chance(stages, false, 0.2, 0.01).is_none());
/// ```
#[must_use]
pub fn product_by_chance(
    rates: [Sample; 2],
    is_of_rest: bool,
    value: f64,
    step: f64,
) -> Option<(f64, bool)> {
    let [first, second] = rates.map(BetaPosterior::jeffreys);
    let (a, b) = (first.mean(), second.mean());
    let (u, v) = (first.variance(), second.variance());
    let deviation = (a * a * v + b * b * u + u * v).sqrt();
    let turned = |product: f64| if is_of_rest { 1.0 - product } else { product };
    let distance = (value - turned(a * b)) / deviation;
    if distance.is_nan() || distance.abs() > 6.0 + step / deviation {
        return None;
    }
    let [p, q] = rates.map(|it| it.rate().unwrap_or(f64::NAN));
    let met = (value - turned(p * q)).abs() <= 0.5 * step * (1.0 + 1e-9);
    let reach = 0.5 * step / deviation;
    let below = |z: f64| crate::special::normal_cdf(z);
    let chance = below(distance + reach) - below(distance - reach);
    (chance > 0.0).then_some((chance, met))
}

fn greatest_divisor(a: u64, b: u64) -> u64 {
    match a {
        0 => b,
        _ => greatest_divisor(b % a, a),
    }
}

/// How probable it is at most that an independent source has a multiple of so many trials: an assumption.
fn common_multiple(of: u64) -> f64 {
    let mut rest = of.max(1);
    let mut largest = 1;
    for prime in [2, 3, 5] {
        while rest.is_multiple_of(prime) {
            rest /= prime;
        }
    }
    let mut factor = 7;
    while rest > 1 {
        while rest.is_multiple_of(factor) {
            rest /= factor;
            largest = factor;
        }
        factor += 2;
        if factor * factor > rest && rest > 1 {
            largest = rest;
            rest = 1;
        }
    }
    let round = of.max(1) / largest;
    (10.0 / round as f64).min(1.0) / largest as f64
}

/// The probability that as many independent trials give the same count.
///
/// ```
/// use stats::{Sample, count_by_chance};
/// assert!(count_by_chance(Sample { successes: 50, trials: 50 }) > 0.6);
/// assert!(count_by_chance(Sample { successes: 174, trials: 200 }) < 0.1);
/// ```
#[must_use]
pub fn count_by_chance(counts: Sample) -> f64 {
    let (k, n) = (counts.successes as f64, counts.trials as f64);
    let ln_beta = |a: f64, b: f64| ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b);
    let choose = ln_gamma(n + 1.0) - ln_gamma(k + 1.0) - ln_gamma(n - k + 1.0);
    let posterior = (k + 0.5, n - k + 0.5);
    let again = ln_beta(k + posterior.0, n - k + posterior.1);
    (choose + again - ln_beta(posterior.0, posterior.1))
        .exp()
        .min(1.0)
}

/// How probable it is at most that an independent source has the same number of trials: an assumption.
pub const SAME_TRIALS: f64 = 0.1;

/// The same of this number: 1, 2 or 5 times a power of ten is what people choose, and others are rarer, as their multiples are.
fn same_trials(trials: u64) -> f64 {
    let mut leading = trials.max(1);
    while leading.is_multiple_of(10) {
        leading /= 10;
    }
    match leading {
        1 | 2 | 5 => SAME_TRIALS,
        _ => common_multiple(trials).min(SAME_TRIALS),
    }
}

/// The probability that an independent source writes the quotient of these counts: of as many trials, and the same count.
///
/// ```
/// let counts = stats::Sample { successes: 174, trials: 200 };
/// assert!(stats::quotient_by_chance(counts) < 0.01);
/// // Hardly anybody else has 211 trials.
/// let odd = stats::Sample { successes: 184, trials: 211 };
/// assert!(stats::quotient_by_chance(odd) < 0.001);
/// ```
#[must_use]
pub fn quotient_by_chance(counts: Sample) -> f64 {
    same_trials(counts.trials) * count_by_chance(counts)
}

/// The probability of any coincidence as improbable as `found` among those that could have been met.
#[must_use]
pub fn any_coincidence(possible: &[f64], found: f64) -> f64 {
    let as_improbable = possible.iter().filter(|chance| **chance <= found);
    as_improbable.sum::<f64>().clamp(found.min(1.0), 1.0)
}

/// The probability of at least `met` coincidences of those that could have been met.
#[must_use]
pub fn several_coincidences(possible: &[f64], met: usize) -> f64 {
    let expected: f64 = possible.iter().sum();
    let terms = (1..=met).map(|i| expected / i as f64);
    terms.product::<f64>().min(1.0)
}

/// A coincidence that could have been met between two sources.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Possible {
    /// Between which two sources.
    pub pair: usize,
    /// Its probability if they are independent.
    pub chance: f64,
    /// Whether it was met.
    pub met: bool,
}

/// For each coincidence that was met, the probability of one as improbable, or of as many between two sources, anywhere
/// among those that could have been met; `None` for those that were not.
///
/// ```
/// use stats::{Possible, coincidences};
/// let found = coincidences(&[
///     Possible { pair: 0, chance: 0.02, met: true },
///     Possible { pair: 0, chance: 0.01, met: false },
///     Possible { pair: 1, chance: 0.30, met: false },
/// ]);
/// assert_eq!(found, [Some(0.06), None, None]);
/// ```
#[must_use]
pub fn coincidences(possible: &[Possible]) -> Vec<Option<f64>> {
    let chances: Vec<f64> = possible.iter().map(|it| it.chance).collect();
    let mut by_pair: BTreeMap<usize, (Vec<f64>, usize)> = BTreeMap::new();
    for it in possible {
        let (chances, met) = by_pair.entry(it.pair).or_default();
        chances.push(it.chance);
        *met += usize::from(it.met);
    }
    let several = |met: usize| {
        let pairs = by_pair.values();
        let each = pairs.map(|(chances, _)| several_coincidences(chances, met));
        each.sum::<f64>().min(1.0)
    };
    let judge = |it: &Possible| {
        let alone = any_coincidence(&chances, it.chance);
        let (of_pair, met) = &by_pair[&it.pair];
        let least = match met {
            0 | 1 => alone,
            _ => alone.min(several(*met)),
        };
        match of_pair.len() {
            0 | 1 => least,
            _ => (2.0 * least).min(1.0),
        }
    };
    possible
        .iter()
        .map(|it| it.met.then(|| judge(it)))
        .collect()
}

/// The probability that at least as many rows are the same as of these, of which each is a row in both tables.
///
/// ```
/// use stats::{Sample, rows_by_chance};
/// let people = [9, 10, 8, 7, 9, 10, 10, 6, 9, 10].map(|successes| Sample { successes, trials: 10 });
/// assert!(rows_by_chance(&people, &people) < 1.3e-3);
/// // Nothing follows from rows that always succeed.
/// let always = [Sample { successes: 50, trials: 50 }; 40];
/// assert_eq!(rows_by_chance(&always, &always), 1.0);
/// ```
#[must_use]
pub fn rows_by_chance(first: &[Sample], second: &[Sample]) -> f64 {
    let pairs = || first.iter().zip(second);
    let same = pairs().filter(|(one, other)| one == other).count();
    // By how many events so far: their distribution.
    let mut many = vec![1.0];
    for (one, other) in pairs() {
        // The larger of the two: a row that differs has no probability of its own to be the same.
        let chance = largest(*one).max(largest(*other));
        many.push(0.0);
        for i in (0..many.len()).rev() {
            let before = if i > 0 { many[i - 1] } else { 0.0 };
            many[i] = many[i] * (1.0 - chance) + before * chance;
        }
    }
    let tail: f64 = many.iter().skip(same).rev().sum();
    tail.min(1.0)
}

/// The largest probability of exactly these successes in so many trials, at any rate.
fn largest(row: Sample) -> f64 {
    match row.rate() {
        Some(rate) => binomial_pmf(row.successes, row.trials, rate),
        None => 1.0,
    }
}

/// Contents that two tables share in whatever order, and how likely at most chance gives as many.
///
/// ```
/// use stats::contents_by_chance;
/// let rows: Vec<u32> = (0..20).collect();
/// let mixed: Vec<u32> = (0..20).map(|i| i * 7 % 20).collect();
/// let (same, chance) = contents_by_chance(&rows, &mixed);
/// assert!(same == 20 && chance < 1e-5);
/// assert_eq!(contents_by_chance(&[1; 30], &[1; 30]).1, 1.0);
/// ```
#[must_use]
pub fn contents_by_chance<T: Ord>(first: &[T], second: &[T]) -> (u64, f64) {
    let mut contents: BTreeMap<&T, [usize; 2]> = BTreeMap::new();
    for content in first {
        contents.entry(content).or_default()[0] += 1;
    }
    for content in second {
        contents.entry(content).or_default()[1] += 1;
    }
    let same: usize = contents.values().map(|[a, b]| a.min(b)).sum();
    let frequencies: Vec<usize> = contents.values().map(|[a, b]| a + b).collect();
    // Powers of two, the last so large that only the most possible rows count.
    let tilts = [0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 16.0, 400.0];
    let bounds = tilts.map(|tilt| ln_tail(&frequencies, first.len(), same, tilt));
    let least = bounds.into_iter().fold(0.0_f64, f64::min);
    (same as u64, least.exp())
}

/// Powers of two below this, and scaled weights below that, are taken for larger: what underflows to 0 would be impossible, and
/// the bound too small. Larger terms give a larger bound.
const LEAST_EXPONENT: f64 = -1000.0;
const LEAST_WEIGHT: f64 = 1e-300;

/// The logarithm of Chernoff's bound at `t = 2^tilt`.
fn ln_tail(frequencies: &[usize], drawn: usize, same: usize, tilt: f64) -> f64 {
    let all: usize = frequencies.iter().sum();
    let share = drawn as f64 / all.max(1) as f64;
    // By rows drawn so far, scaled: binomial weights, which cancel, keep the terms near 1.
    let mut weights = vec![1.0];
    let mut ln_scale = 0.0;
    for &frequency in frequencies {
        let most = (frequency / 2) as f64;
        let term: Vec<f64> = (0..=frequency)
            .map(|x| {
                let shared = x.min(frequency - x) as f64;
                let weight = ((shared - most) * tilt).max(LEAST_EXPONENT).exp2();
                binomial_pmf(x as u64, frequency as u64, share) * weight
            })
            .collect();
        weights = times(&weights, &term, drawn);
        let greatest = weights.iter().copied().fold(0.0, f64::max);
        if greatest <= 0.0 {
            return 0.0;
        }
        let scaled = |weight: &mut f64| *weight = (*weight / greatest).max(LEAST_WEIGHT);
        weights.iter_mut().for_each(scaled);
        ln_scale += greatest.ln();
    }
    let most: usize = frequencies.iter().map(|frequency| frequency / 2).sum();
    let Some(weight) = weights.get(drawn).filter(|weight| **weight > 0.0) else {
        return 0.0;
    };
    let ways = binomial_pmf(drawn as u64, all as u64, share).ln();
    let free = (most as f64 - same as f64) * tilt * std::f64::consts::LN_2;
    (weight.ln() + ln_scale - ways + free).min(0.0)
}

/// The product of two polynomials up to a degree.
fn times(left: &[f64], right: &[f64], degree: usize) -> Vec<f64> {
    let length = (left.len() + right.len() - 1).min(degree + 1);
    let mut product = vec![0.0; length];
    for (i, one) in left.iter().enumerate() {
        for (j, other) in right.iter().enumerate() {
            if i + j < length {
                product[i + j] += one * other;
            }
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of one trial each share what they have to share: nothing follows from it, however unlike the tables are.
    #[test]
    fn what_must_be_shared_is_shared_by_chance() {
        for (zeros, rows, ones) in [
            (12_usize, 20_usize, 18_usize),
            (20, 20, 18),
            (15, 75, 60),
            (40, 400, 396),
        ] {
            let first = vec![0; zeros];
            let mut second = vec![1; ones];
            second.resize(rows, 0);
            let (same, chance) = contents_by_chance(&first, &second);
            assert_eq!(same as usize, zeros.min(rows - ones));
            assert!(chance > 0.99, "{zeros} {rows} {ones}: {chance:e}");
        }
    }

    #[test]
    fn counts_again_sum_to_one_over_all_counts_and_are_the_integral_over_the_posterior() {
        // By midpoints of the posterior's distribution function.
        for (successes, trials) in [(0, 5), (5, 5), (3, 7), (17, 20), (174, 200)] {
            let counts = Sample { successes, trials };
            let posterior = BetaPosterior::jeffreys(counts);
            let points = 4000;
            let mean: f64 = (0..points)
                .map(|i| posterior.quantile((f64::from(i) + 0.5) / f64::from(points)))
                .map(|rate| binomial_pmf(successes, trials, rate))
                .sum::<f64>()
                / f64::from(points);
            let found = count_by_chance(counts);
            assert!((found / mean - 1.0).abs() < 1e-3, "{found} {mean}");
        }
    }

    #[test]
    fn a_constant_is_as_probable_as_its_cell_and_cells_sum_to_one() {
        let counts = Sample {
            successes: 17,
            trials: 20,
        };
        let posterior = BetaPosterior::jeffreys(counts);
        // 17/20 is in lowest terms, and half of all sources may have a multiple of 20 trials.
        let cell = |value: f64| posterior.probability_between(value - 0.025, value + 0.025);
        assert!((constant_by_chance(counts, 0.85, 0.001) - 0.5 * cell(0.85)).abs() < 1e-12);
        let cells = (0..=10).map(|i| constant_by_chance(counts, f64::from(i) / 10.0, 0.1));
        assert!((cells.sum::<f64>() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn multiples_of_round_numbers_are_common_and_of_primes_are_not() {
        let expected = [
            (1, 1.0),
            (20, 0.5),
            (100, 0.1),
            (600, 1.0 / 60.0),
            (37, 1.0 / 37.0),
            (98, 5.0 / 49.0),
            (7 * 600, 1.0 / 420.0),
            (11 * 13, 10.0 / 143.0),
        ];
        for (of, chance) in expected {
            let found = common_multiple(of);
            assert!((found - chance).abs() < 1e-12, "{of} {found} {chance}");
        }
    }

    /// Every pair of tables of three rows, at rates that differ by row.
    #[test]
    fn rows_are_the_same_no_oftener_than_said_whatever_their_rates() {
        let trials = [4_u64, 3, 2];
        for rates in [[0.5, 0.5, 0.5], [0.9, 0.2, 0.6], [1.0, 0.0, 0.7]] {
            let first = [3, 1, 1];
            let table = |counts: [u64; 3]| {
                let rows = counts.into_iter().zip(trials);
                rows.map(|(successes, trials)| Sample { successes, trials })
                    .collect::<Vec<_>>()
            };
            let bound = rows_by_chance(&table(first), &table(first));
            let all_same: f64 = (0..3)
                .map(|i| binomial_pmf(first[i], trials[i], rates[i]))
                .product();
            assert!(all_same <= bound * (1.0 + 1e-12), "{all_same} {bound}");
            // With one row that differs: no probability above that of two of three.
            let other = table([3, 1, 2]);
            let two = rows_by_chance(&table(first), &other);
            assert!(two > bound && two <= 1.0);
        }
    }

    /// Every way of dividing the pooled rows, counted.
    #[test]
    fn shared_contents_are_bounded_and_exact_where_nothing_more_could_be_shared() {
        let cases: [(&[u8], &[u8]); 5] = [
            (&[1, 2, 3, 4, 5], &[5, 4, 3, 2, 1]),
            (&[1, 1, 2, 3, 3, 3], &[3, 1, 3, 2, 3, 1]),
            (&[1, 1, 2, 3, 3], &[3, 1, 3, 4, 6, 1]),
            (&[1, 2, 3], &[4, 5, 6, 7]),
            (&[1, 1, 1, 1], &[1, 1, 2, 1]),
        ];
        for (first, second) in cases {
            let pooled: Vec<u8> = first.iter().chain(second).copied().collect();
            let overlap = |mask: u32| {
                let mut halves = BTreeMap::<u8, [usize; 2]>::new();
                for (i, content) in pooled.iter().enumerate() {
                    halves.entry(*content).or_default()[(mask >> i & 1) as usize] += 1;
                }
                halves.values().map(|[a, b]| *a.min(b)).sum::<usize>()
            };
            let (same, bound) = contents_by_chance(first, second);
            let ways =
                (0..1_u32 << pooled.len()).filter(|mask| mask.count_ones() as usize == first.len());
            let (mut as_many, mut all, mut most) = (0.0, 0.0, 0);
            for mask in ways {
                let shared = overlap(mask);
                most = most.max(shared);
                all += 1.0;
                as_many += f64::from(u8::from(shared as u64 >= same));
            }
            let share: f64 = as_many / all;
            assert!(bound >= share * (1.0 - 1e-9), "{first:?} {bound} {share}");
            if same as usize == most && first.len() == second.len() {
                assert!((bound - share).abs() < 1e-9, "{first:?} {bound} {share}");
            }
        }
    }

    #[test]
    fn several_are_at_most_the_symmetric_polynomials() {
        let possible = [0.1, 0.05, 0.2, 0.02];
        let mut exact = 0.0;
        for mask in 0_u32..16 {
            if mask.count_ones() >= 2 {
                let parts = (0..4).map(|i| match mask >> i & 1 {
                    1 => possible[i],
                    _ => 1.0 - possible[i],
                });
                exact += parts.product::<f64>();
            }
        }
        assert!(several_coincidences(&possible, 2) >= exact);
        assert!((any_coincidence(&possible, 0.05) - 0.07).abs() < 1e-12);
        assert_eq!(any_coincidence(&[], 0.3), 0.3);
    }
}
