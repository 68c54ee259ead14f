//! Whether like outcomes stand together in an order (of rows, of time): the runs test.
//!
//! # Definition
//! Of `a` successes and `b` failures in an order, a run is a longest stretch of the same outcome. If the trials are
//! independent with one rate, all `C(a + b, a)` orders are as likely, and with `R` the runs
//!
//! ```text
//! P(R = 2 i)     = 2 C(a-1, i-1) C(b-1, i-1) / C(a+b, a)
//! P(R = 2 i + 1) = [C(a-1, i) C(b-1, i-1) + C(a-1, i-1) C(b-1, i)] / C(a+b, a)
//! ```
//!
//! The p-value is `P(R <= r)`: few runs mean that neighbours are alike.
//!
//! # Source
//! A. Wald and J. Wolfowitz, "On a test whether two samples are from the same population" (1940).
//!
//! # Assumes
//! Under the hypothesis trials are independent with one rate throughout, and stand in the order in which they were made.
//! Their number may be random.
//!
//! # Guarantee
//! Exact. A drift of the rate in time gives few runs, too. Cost: linear in the runs.

use crate::special::ln_gamma;

/// An order of outcomes and how few its runs are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Runs {
    /// Longest stretches of the same outcome.
    pub runs: u64,
    /// The runs that independent trials give on average.
    pub expected: f64,
    /// The probability of as few by chance.
    pub p_value: f64,
}

/// The runs of outcomes in their order; `None` if all are the same.
///
/// ```
/// use stats::runs_test;
/// let drifted: Vec<bool> = (0..20).map(|i| i < 10).collect();
/// assert!(runs_test(&drifted).unwrap().p_value < 2e-5);
/// let alternating: Vec<bool> = (0..20).map(|i| i % 2 == 0).collect();
/// assert!(runs_test(&alternating).unwrap().p_value > 0.99);
/// ```
#[must_use]
pub fn runs_test(outcomes: &[bool]) -> Option<Runs> {
    let successes = outcomes.iter().filter(|outcome| **outcome).count() as u64;
    let failures = outcomes.len() as u64 - successes;
    if successes == 0 || failures == 0 {
        return None;
    }
    let changes = outcomes.windows(2).filter(|pair| pair[0] != pair[1]);
    let runs = 1 + changes.count() as u64;
    let (a, b) = (successes as f64, failures as f64);
    let p_value: f64 = (2..=runs)
        .map(|runs| probability(runs, successes, failures))
        .sum();
    Some(Runs {
        runs,
        expected: 1.0 + 2.0 * a * b / (a + b),
        p_value: p_value.min(1.0),
    })
}

fn probability(runs: u64, a: u64, b: u64) -> f64 {
    let half = runs / 2;
    let all = ln_choose(a + b, a);
    let ways = |i: u64, j: u64| (ln_choose(a - 1, i) + ln_choose(b - 1, j) - all).exp();
    match runs % 2 {
        0 => 2.0 * ways(half - 1, half - 1),
        _ => ways(half, half - 1) + ways(half - 1, half),
    }
}

fn ln_choose(n: u64, k: u64) -> f64 {
    if k > n {
        return f64::NEG_INFINITY;
    }
    let ln_factorial = |n: u64| ln_gamma(n as f64 + 1.0);
    ln_factorial(n) - ln_factorial(k) - ln_factorial(n - k)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every order of up to ten outcomes.
    #[test]
    fn the_p_value_is_the_share_of_orders_with_as_few_runs() {
        for length in 2..=10_usize {
            let order = |mask: u32| (0..length).map(|i| mask >> i & 1 == 1).collect::<Vec<_>>();
            for successes in 1..length {
                let orders: Vec<Runs> = (0..1_u32 << length)
                    .filter(|mask| mask.count_ones() as usize == successes)
                    .filter_map(|mask| runs_test(&order(mask)))
                    .collect();
                for found in &orders {
                    let as_few = orders.iter().filter(|it| it.runs <= found.runs).count();
                    let share = as_few as f64 / orders.len() as f64;
                    assert!((found.p_value - share).abs() < 1e-9, "{found:?} {share}");
                }
                let mean = orders.iter().map(|it| it.runs as f64).sum::<f64>();
                assert!((mean / orders.len() as f64 - orders[0].expected).abs() < 1e-9);
            }
        }
        assert_eq!(runs_test(&[true, true]), None);
    }
}
