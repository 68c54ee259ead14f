//! What theory allows: the power of the difference test that matches a fault, with the same data.
//!
//! * two counts: the chi-squared test of two proportions, its power summed over all outcomes
//!   (`z^2 > z_(1-a/2)^2` with the pooled variance);
//! * a count and a computed value: the exact binomial test, its power summed likewise;
//! * two forms on the same `n` runs: one run on which they differ is proof, so `1 - (1 - d)^n` with `d`
//!   the probability that a run is such.
//!
//! The chi-squared test errs a little more often than declared, so that no exact test has much more power.
//! Clustered trials count at their effective size, rounded, as if it were known. Where it is learned from `k` people, the
//! variance has `f = k - 1` degrees of freedom ([`Side::degrees`]): the test is Student's, and an outcome with the
//! squared score `z^2` is rejected with probability `P(X <= f z^2 / t_f^2)`, `X` chi-squared with `f` degrees. Degrees of
//! two sides are joined by their variances (F. E. Satterthwaite 1946).
//!
//! Source: A. Agresti, "Categorical data analysis" (2013), sections 3.2 and 6.6; A. Donner and N. Klar, "Design and
//! analysis of cluster randomization trials" (2000), section 6.2, for Student's test on clusters. Guarantee: none beyond
//! that of a reference; a test that takes clustered trials to vary at least as binomial ones do can have more power than
//! Student's. Cost: the product of the outcomes that matter, some thousands.

use stats::special::{binomial_pmf, chi_squared_sf, normal_quantile, student_t_quantile};
use stats::{Sample, binomial_test_two_sided};

/// One side: its true rate and its independent trials; infinitely many where it is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// The true rate.
    pub rate: f64,
    /// Independent trials.
    pub trials: f64,
    /// Degrees of freedom of what is known of their variance; infinite where it is that of independent trials.
    pub degrees: f64,
}

impl Side {
    /// A value that is computed.
    #[must_use]
    pub fn computed(rate: f64) -> Self {
        Self::independent(rate, f64::INFINITY)
    }

    /// Independent trials.
    #[must_use]
    pub fn independent(rate: f64, trials: f64) -> Self {
        let degrees = f64::INFINITY;
        Self {
            rate,
            trials,
            degrees,
        }
    }

    /// The variance of its rate.
    fn variance(self) -> f64 {
        self.rate * (1.0 - self.rate) / self.trials
    }
}

/// Degrees of freedom of a sum of variances, each with its own.
#[must_use]
pub fn joined_degrees(parts: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut sum, mut squares) = (0.0, 0.0);
    for (variance, degrees) in parts {
        sum += variance;
        squares += variance * variance / degrees;
    }
    if squares > 0.0 {
        sum * sum / squares
    } else {
        f64::INFINITY
    }
}

/// How often a squared score is rejected at a level.
struct Rejection {
    critical: f64,
    /// By the score in critical values, in steps of [`STEP`]; empty where the variance is known.
    shares: Vec<f64>,
}

/// Between these steps shares are linear, to within 1e-4 from four degrees of freedom on.
const STEP: f64 = 0.005;

/// From so many critical values on everything is rejected, with four degrees of freedom but for 1e-7.
const SURE: f64 = 3.0;

impl Rejection {
    fn new(alpha: f64, degrees: f64) -> Self {
        if degrees.is_infinite() {
            return Self {
                critical: normal_quantile(1.0 - 0.5 * alpha).powi(2),
                shares: Vec::new(),
            };
        }
        let share = |step: u32| {
            let ratio = STEP * f64::from(step);
            1.0 - chi_squared_sf(degrees * ratio * ratio, degrees)
        };
        Self {
            critical: student_t_quantile(1.0 - 0.5 * alpha, degrees).powi(2),
            shares: (0..=(SURE / STEP) as u32).map(share).collect(),
        }
    }

    fn of(&self, squared: f64) -> f64 {
        if self.shares.is_empty() {
            return f64::from(u8::from(squared > self.critical));
        }
        let place = (squared / self.critical).sqrt() / STEP;
        let below = place as usize;
        match (self.shares.get(below), self.shares.get(below + 1)) {
            (Some(low), Some(high)) => low + (place - below as f64) * (high - low),
            _ => 1.0,
        }
    }
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
    let both = [first, second].into_iter();
    let rejection = Rejection::new(
        alpha,
        joined_degrees(both.map(|s| (s.variance(), s.degrees))),
    );
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
            if variance > 0.0 {
                power += weight * other * rejection.of(difference * difference / variance);
            }
        }
    }
    power
}

fn against_value(counted: Side, value: f64, alpha: f64) -> f64 {
    let n = counted.trials.round().max(1.0);
    let variance = value * (1.0 - value) / n;
    let outcomes = outcomes(counted.rate, n).into_iter();
    if counted.degrees.is_finite() && variance > 0.0 {
        let rejection = Rejection::new(alpha, counted.degrees);
        return outcomes
            .map(|(x, weight)| weight * rejection.of((x / n - value).powi(2) / variance))
            .sum();
    }
    let trials = n as u64;
    outcomes
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
        Side::independent(rate, trials)
    }

    /// Against the power of Student's test at the noncentrality of the difference, by R 4.3:
    /// `power.t.test(n = 10, delta = 1, sd = 1, type = "one.sample")$power` = 0.8031.
    #[test]
    fn a_variance_that_is_learned_costs_power() {
        // Ten people of ten thousand attempts, so alike that each is worth ten: the rate is off by sqrt(10) deviations.
        let (trials, value) = (1e4, 0.5_f64);
        let rate = value + (10.0 * value * (1.0 - value) / trials).sqrt();
        let learned = Side {
            degrees: 9.0,
            ..side(rate, trials)
        };
        let found = power(learned, Side::computed(value), 0.05);
        assert!((found - 0.803).abs() < 0.005, "{found}");
        let known = power(side(rate, trials), Side::computed(value), 0.05);
        assert!(known > found + 0.05, "{known} {found}");
        // As many degrees as there can be, and the test is that of independent trials.
        let many = Side {
            degrees: 1e6,
            ..learned
        };
        let nearly = power(many, side(0.5, 1e4), 0.05);
        let exactly = power(side(rate, trials), side(0.5, 1e4), 0.05);
        assert!((nearly - exactly).abs() < 0.005, "{nearly} {exactly}");
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
