//! What theory allows: the power of the difference test that matches a fault, with the same data.
//!
//! * two counts: the chi-squared test of two proportions, its power summed over all outcomes
//!   (`z^2 > z_(1-a/2)^2` with the pooled variance);
//! * a count and a computed value: the exact binomial test, its power summed likewise;
//! * two forms on the same `n` runs: one run on which they differ is proof, so `1 - (1 - d)^n` with `d`
//!   the probability that a run is such.
//!
//! The chi-squared test errs a little more often than declared, so that no exact test has much more power.
//! Clustered trials count at their effective size, rounded, and where nobody ever fails at one for each person: how alike
//! the attempts are is not known, and does not show. Source: A. Agresti, "Categorical data
//! analysis" (2013), sections 3.2 and 6.6. Cost: the product of the outcomes that matter, some thousands.

use stats::special::{binomial_pmf, normal_quantile};
use stats::{Sample, binomial_test_two_sided};

/// One side: its true rate and its independent trials; infinitely many where it is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// The true rate.
    pub rate: f64,
    /// Independent trials.
    pub trials: f64,
}

/// Outcomes less likely than this are left out of sums.
const NEGLIGIBLE: f64 = 1e-9;

/// The power of the two-sided difference test at level `alpha`.
#[must_use]
pub fn power(first: Side, second: Side, alpha: f64) -> f64 {
    match (first.trials.is_finite(), second.trials.is_finite()) {
        (true, true) => of_counts(first, second, alpha),
        (true, false) => against_value(first, second.rate, alpha),
        (false, true) => against_value(second, first.rate, alpha),
        (false, false) => f64::from(u8::from((first.rate - second.rate).abs() > 1e-9)),
    }
}

fn of_counts(first: Side, second: Side, alpha: f64) -> f64 {
    let critical = normal_quantile(1.0 - 0.5 * alpha).powi(2);
    let (n, m) = (
        first.trials.round().max(1.0),
        second.trials.round().max(1.0),
    );
    let others = outcomes(second.rate, m);
    let mut power = 0.0;
    for (x, weight) in outcomes(first.rate, n) {
        for (y, other) in &others {
            let pooled = (x + y) / (n + m);
            let variance = pooled * (1.0 - pooled) * (1.0 / n + 1.0 / m);
            let difference = x / n - y / m;
            if variance > 0.0 && difference * difference > critical * variance {
                power += weight * other;
            }
        }
    }
    power
}

fn against_value(counted: Side, value: f64, alpha: f64) -> f64 {
    let n = counted.trials.round().max(1.0);
    let trials = n as u64;
    outcomes(counted.rate, n)
        .into_iter()
        .filter(|(x, _)| {
            let successes = *x as u64;
            binomial_test_two_sided(Sample { successes, trials }, value) <= alpha
        })
        .map(|(_, weight)| weight)
        .sum()
}

/// The outcomes of a count that are not negligible, with their probabilities.
fn outcomes(rate: f64, trials: f64) -> Vec<(f64, f64)> {
    let n = trials as u64;
    let half = 7.0 * (trials * rate * (1.0 - rate)).sqrt() + 12.0;
    let from = (trials * rate - half).max(0.0) as u64;
    let to = ((trials * rate + half) as u64).min(n);
    (from..=to)
        .map(|k| (k as f64, binomial_pmf(k, n, rate)))
        .filter(|(_, weight)| *weight > NEGLIGIBLE)
        .collect()
}

/// The probability that one of `runs` shows a difference that each shows with probability `each`.
#[must_use]
pub fn seen(each: f64, runs: usize) -> f64 {
    1.0 - (1.0 - each.clamp(0.0, 1.0)).powf(runs as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(rate: f64, trials: f64) -> Side {
        Side { rate, trials }
    }

    /// The same test's power if rates were normal: `P(|d| > z s0)` with the pooled variance in `s0`.
    fn normal_theory((p, n): (f64, f64), (q, m): (f64, f64)) -> f64 {
        let share = |size: f64| if size.is_finite() { 1.0 / size } else { 0.0 };
        let pooled = if m.is_finite() {
            (p * n + q * m) / (n + m)
        } else {
            q
        };
        let critical =
            normal_quantile(0.975) * (pooled * (1.0 - pooled) * (share(n) + share(m))).sqrt();
        let deviation = (p * (1.0 - p) * share(n) + q * (1.0 - q) * share(m)).sqrt();
        stats::special::normal_cdf(((p - q).abs() - critical) / deviation)
    }

    #[test]
    fn powers_are_near_those_of_normal_theory() {
        for (p, q, n, m) in [
            (0.3, 0.4, 200.0, 300.0),
            (0.1, 0.2, 500.0, 100.0),
            (0.5, 0.7, 60.0, 60.0),
        ] {
            let found = power(side(p, n), side(q, m), 0.05);
            let theory = normal_theory((p, n), (q, m));
            assert!((found - theory).abs() < 0.03, "{found} {theory}");
        }
        let known = power(side(0.3, 200.0), side(0.4, f64::INFINITY), 0.05);
        let theory = normal_theory((0.3, 200.0), (0.4, f64::INFINITY));
        assert!((known - theory).abs() < 0.05, "{known} {theory}");
    }

    #[test]
    fn without_a_difference_the_power_is_about_the_level() {
        let level = power(side(0.3, 200.0), side(0.3, 300.0), 0.05);
        assert!((level - 0.05).abs() < 0.01, "{level}");
        assert!(power(side(0.3, 200.0), side(0.3, f64::INFINITY), 0.05) <= 0.05);
        assert_eq!(
            power(side(0.3, f64::INFINITY), side(0.4, f64::INFINITY), 0.05),
            1.0
        );
        assert!((seen(0.01, 100) - (1.0 - 0.99_f64.powi(100))).abs() < 1e-12);
    }
}
