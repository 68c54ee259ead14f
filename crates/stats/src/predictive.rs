//! How many of further trials will succeed, given what is known of the rate.
//!
//! With the rate's posterior `Beta(a, b)`, the successes `Y` among `n` further trials have the
//! beta-binomial distribution
//!
//! ```text
//! P(Y = y) = C(n, y) B(a + y, b + n - y) / B(a, b),   P(y+1)/P(y) = (n-y)(a+y) / ((y+1)(b+n-y-1))
//! ```
//!
//! and the binomial one when the rate is taken for known. A chance that averages a power over this
//! distribution is called assurance.
//!
//! Source: J. G. Skellam (1948); A. O'Hagan, J. W. Stevens and M. J. Campbell, "Assurance in
//! clinical trial design" (2005). Deviation: the ratio is followed outwards from the mean and the
//! sum is made 1; beyond [`MOST_IN_TABLE`] trials the share of successes has the beta distribution
//! of the same mean and variance, with a continuity correction. Cost: `n` steps once. Guarantee:
//! relative error near 1e-12 in the table; beyond it the distribution function is off by less than
//! 0.001 from 20 successes (and failures) on, for posteriors of 5 trials and more.
//!
//! # Assumes
//! Further trials are independent given the rate, which is that of the trials so far and has the posterior that is given.

use crate::posterior::BetaPosterior;

/// Trials up to which every number of successes has its own probability.
pub const MOST_IN_TABLE: u64 = 1 << 16;

/// The distribution of the number of successes among further trials.
#[derive(Clone, Debug, PartialEq)]
pub struct Predictive {
    trials: u64,
    form: Form,
}

#[derive(Clone, Debug, PartialEq)]
enum Form {
    /// `P(Y <= y)` for every `y`.
    Table(Vec<f64>),
    /// The share of successes as a continuous number; `None` for a share that is certain.
    Share(BetaPosterior),
    /// All trials have this outcome.
    Certain(u64),
}

impl Predictive {
    /// Successes among `trials` when the rate has this posterior.
    ///
    /// ```
    /// use stats::{BetaPosterior, Predictive, Sample};
    /// let posterior = BetaPosterior::jeffreys(Sample { successes: 88, trials: 100 });
    /// let next = Predictive::new(&posterior, 50);
    /// assert!((next.cdf(40) - 0.1253).abs() < 1e-4);
    /// ```
    #[must_use]
    pub fn new(posterior: &BetaPosterior, trials: u64) -> Self {
        let (a, b) = posterior.parameters();
        if trials > MOST_IN_TABLE {
            let n = trials as f64;
            // Var(Y/n) = p q (a+b+n) / (n (a+b+1)), as that of a beta of this size.
            let size = (n * (a + b + 1.0) / (a + b + n) - 1.0).max(f64::MIN_POSITIVE);
            let mean = posterior.mean();
            let share = BetaPosterior::new(mean * size, (1.0 - mean) * size);
            return Self {
                trials,
                form: Form::Share(share.unwrap_or(*posterior)),
            };
        }
        let n = trials as f64;
        let ratio = |y: f64| (n - y) * (a + y) / ((y + 1.0) * (b + n - y - 1.0));
        Self {
            trials,
            form: Form::Table(cumulated(trials, posterior.mean(), ratio)),
        }
    }

    /// Successes among `trials` at a rate that is taken for known, within `[0, 1]`.
    #[must_use]
    pub fn at_rate(rate: f64, trials: u64) -> Self {
        let (rate, n) = (rate.clamp(0.0, 1.0), trials as f64);
        let form = if rate <= 0.0 {
            Form::Certain(0)
        } else if rate >= 1.0 {
            Form::Certain(trials)
        } else if trials > MOST_IN_TABLE {
            match BetaPosterior::new(rate * (n - 1.0), (1.0 - rate) * (n - 1.0)) {
                Ok(share) => Form::Share(share),
                Err(_) => Form::Certain((rate * n).round() as u64),
            }
        } else {
            let odds = rate / (1.0 - rate);
            Form::Table(cumulated(trials, rate, |y| (n - y) / (y + 1.0) * odds))
        };
        Self { trials, form }
    }

    /// The number of further trials.
    #[must_use]
    pub fn trials(&self) -> u64 {
        self.trials
    }

    /// `P(Y <= y)`.
    #[must_use]
    pub fn cdf(&self, y: u64) -> f64 {
        if y >= self.trials {
            return 1.0;
        }
        match &self.form {
            Form::Table(table) => table[y as usize],
            Form::Share(share) => share.cdf((y as f64 + 0.5) / self.trials as f64),
            Form::Certain(value) => f64::from(u8::from(*value <= y)),
        }
    }

    /// The probability of `from..=to`, 0 where `to < from`.
    #[must_use]
    pub fn probability(&self, from: u64, to: u64) -> f64 {
        if to < from {
            return 0.0;
        }
        let below = if from == 0 { 0.0 } else { self.cdf(from - 1) };
        (self.cdf(to) - below).max(0.0)
    }

    /// The least `y` with `P(Y <= y) >= probability`.
    #[must_use]
    pub fn quantile(&self, probability: f64) -> u64 {
        match &self.form {
            Form::Table(table) => table
                .partition_point(|p| *p < probability)
                .min(table.len() - 1) as u64,
            Form::Share(share) => {
                let y = share.quantile(probability.clamp(0.0, 1.0)) * self.trials as f64;
                (y.round() as u64).min(self.trials)
            }
            Form::Certain(value) => *value,
        }
    }

    /// Outcomes that stand for all, with their weights: each outcome itself when there are at most
    /// `most`, else the middles of `most` equally likely groups.
    #[must_use]
    pub fn representatives(&self, most: usize) -> Vec<(u64, f64)> {
        match &self.form {
            Form::Certain(value) => vec![(*value, 1.0)],
            Form::Table(table) if table.len() <= most => {
                let weight = |y: usize| table[y] - if y == 0 { 0.0 } else { table[y - 1] };
                (0..table.len())
                    .map(|y| (y as u64, weight(y)))
                    .filter(|(_, weight)| *weight > 0.0)
                    .collect()
            }
            _ => (0..most.max(1))
                .map(|group| (group as f64 + 0.5) / most.max(1) as f64)
                .map(|middle| (self.quantile(middle), 1.0 / most.max(1) as f64))
                .collect(),
        }
    }
}

/// `P(Y <= y)` for `y` from 0 to `trials`, from the ratio of neighbouring probabilities.
fn cumulated(trials: u64, mean: f64, ratio: impl Fn(f64) -> f64) -> Vec<f64> {
    let start = ((trials as f64 * mean) as usize).min(trials as usize);
    let mut table = vec![0.0; trials as usize + 1];
    table[start] = 1.0;
    for y in start..trials as usize {
        table[y + 1] = table[y] * ratio(y as f64);
    }
    for y in (0..start).rev() {
        table[y] = table[y + 1] / ratio(y as f64);
    }
    let total: f64 = table.iter().sum();
    let mut sum = 0.0;
    for value in &mut table {
        sum += *value / total;
        *value = sum.min(1.0);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counts::Sample;

    fn posterior(successes: u64, trials: u64) -> BetaPosterior {
        BetaPosterior::jeffreys(Sample { successes, trials })
    }

    /// scipy 1.16: betabinom.cdf(y, n, a, b) and binom.cdf(y, n, p).
    #[test]
    fn reference_values() {
        let cases = [
            (88, 100, 50, 40, BB[0]),
            (0, 5, 200, 0, BB[1]),
            (439, 500, 60_000, 52_000, BB[2]),
            (5, 5, 17, 16, BB[3]),
        ];
        for (s, n, further, y, expected) in cases {
            let found = Predictive::new(&posterior(s, n), further).cdf(y);
            assert!(
                (found / expected - 1.0).abs() < 1e-9,
                "{s}/{n}: {found} {expected}"
            );
        }
        let found = Predictive::at_rate(0.88, 1000).cdf(870);
        assert!((found / BINOMIAL - 1.0).abs() < 1e-9, "{found}");
    }

    const BB: [f64; 4] = [
        0.12531262632908857,
        0.16002312068627478,
        0.23118477479349892,
        0.5139893690135242,
    ];
    const BINOMIAL: f64 = 0.17711612425788842;

    #[test]
    fn many_trials_join_on_to_the_table() {
        for (s, n) in [(88, 100), (0, 5), (5, 5), (3, 1000)] {
            let posterior = posterior(s, n);
            let table = Predictive::new(&posterior, MOST_IN_TABLE);
            let share = Predictive::new(&posterior, MOST_IN_TABLE + 1);
            for p in [0.01, 0.1, 0.3, 0.5, 0.9, 0.99] {
                let y = table.quantile(p).clamp(20, MOST_IN_TABLE - 20);
                assert!((share.cdf(y) - table.cdf(y)).abs() < 1e-3, "{s}/{n} {p}");
            }
        }
        let (table, share) = (
            Predictive::at_rate(0.3, MOST_IN_TABLE),
            Predictive::at_rate(0.3, MOST_IN_TABLE + 1),
        );
        let y = table.quantile(0.2);
        assert!((share.cdf(y) - table.cdf(y)).abs() < 2e-3);
    }

    #[test]
    fn representatives_stand_for_all_outcomes() {
        let few = Predictive::new(&posterior(3, 10), 20);
        let all = few.representatives(100);
        assert_eq!(all.len(), 21);
        assert!((all.iter().map(|r| r.1).sum::<f64>() - 1.0).abs() < 1e-12);
        let mean = |representatives: &[(u64, f64)]| -> f64 {
            representatives.iter().map(|(y, w)| *y as f64 * w).sum()
        };
        assert!((mean(&all) - 20.0 * 3.5 / 11.0).abs() < 1e-9);
        let many = Predictive::new(&posterior(88, 100), 5000);
        let some = many.representatives(64);
        assert_eq!(some.len(), 64);
        assert!((mean(&some) / (5000.0 * 88.5 / 101.0) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn the_ends() {
        assert_eq!(Predictive::at_rate(0.0, 10).cdf(0), 1.0);
        assert_eq!(Predictive::at_rate(1.0, 10).cdf(9), 0.0);
        let none = Predictive::new(&posterior(3, 10), 0);
        assert_eq!((none.cdf(0), none.quantile(0.5)), (1.0, 0));
        assert_eq!(none.representatives(8), vec![(0, 1.0)]);
        assert_eq!(none.probability(1, 0), 0.0);
    }
}
