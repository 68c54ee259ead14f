//! A distribution that is known by evenly spaced quantiles.
//!
//! # Definition
//! `n` quantiles at the probabilities `(i + 1/2) / n`. Between two of them the distribution function is linear. Beyond the
//! first and the last it is the tail of the beta distribution of the same mean and variance, scaled so that it has the right
//! probability there.
//!
//! # Why
//! The beta distribution alone has another skew than, say, a probability that cannot exceed 0.98: of a model whose constant is
//! set to 94 of 120, and whose draws are below 0.95 with probability 0.010, it said 0.003.
//!
//! # Guarantee
//! Exact at the quantiles, up to the error of the draws; monotone everywhere.

use stats::BetaPosterior;
use std::rc::Rc;

/// Quantiles, ascending, and the beta distribution of the tails.
#[derive(Clone, Debug)]
pub(crate) struct Quantiles {
    at: Rc<[f64]>,
    tails: BetaPosterior,
}

impl Quantiles {
    /// `None` of fewer than two.
    pub fn new(at: &[f64], tails: BetaPosterior) -> Option<Self> {
        (at.len() > 1).then(|| Self {
            at: at.into(),
            tails,
        })
    }

    /// The probability of at most this.
    pub fn cdf(&self, value: f64) -> f64 {
        match self.beyond(value) {
            Some((below, above)) if value < self.at[0] => below.min(1.0 - above),
            Some((_, above)) => 1.0 - above,
            None => self.between(value),
        }
    }

    /// The probability of at least this.
    pub fn sf(&self, value: f64) -> f64 {
        match self.beyond(value) {
            Some((below, _)) if value < self.at[0] => 1.0 - below,
            Some((_, above)) => above,
            None => 1.0 - self.between(value),
        }
    }

    /// The value that is not reached with this probability.
    pub fn quantile(&self, probability: f64) -> f64 {
        let (outer, last) = (self.outer(), self.at.len() - 1);
        if probability < outer {
            let of_tail = self.tails.cdf(self.at[0]) * probability / outer;
            return self.tails.quantile(of_tail).min(self.at[0]);
        }
        if probability > 1.0 - outer {
            return self.quantile_upper(1.0 - probability);
        }
        let place = (probability / (2.0 * outer) - 0.5).clamp(0.0, last as f64);
        let index = (place.floor() as usize).min(last - 1);
        let (low, high) = (self.at[index], self.at[index + 1]);
        low + (place - index as f64) * (high - low)
    }

    /// The value that is exceeded with this probability.
    pub fn quantile_upper(&self, probability: f64) -> f64 {
        let (outer, last) = (self.outer(), self.at[self.at.len() - 1]);
        if probability >= outer {
            return self.quantile(1.0 - probability);
        }
        let of_tail = self.tails.sf(last) * probability / outer;
        self.tails.quantile_upper(of_tail).max(last)
    }

    /// The probability beyond the first, and beyond the last.
    fn outer(&self) -> f64 {
        0.5 / self.at.len() as f64
    }

    /// The probabilities of the tails below and above a value that lies beyond all quantiles.
    fn beyond(&self, value: f64) -> Option<(f64, f64)> {
        let (first, last) = (self.at[0], self.at[self.at.len() - 1]);
        let scaled = |tail: f64, of_outer: f64| match of_outer > 0.0 {
            true => (self.outer() * tail / of_outer).min(self.outer()),
            false => 0.0,
        };
        if value < first {
            let below = scaled(self.tails.cdf(value), self.tails.cdf(first));
            return Some((below, 0.0));
        }
        (value > last).then(|| (0.0, scaled(self.tails.sf(value), self.tails.sf(last))))
    }

    /// The distribution function between the first and the last.
    fn between(&self, value: f64) -> f64 {
        let above = self.at.partition_point(|it| *it <= value);
        let index = above.clamp(1, self.at.len() - 1) - 1;
        let (low, high) = (self.at[index], self.at[index + 1]);
        let share = match high > low {
            true => ((value - low) / (high - low)).clamp(0.0, 1.0),
            false => 1.0,
        };
        (index as f64 + share + 0.5) * 2.0 * self.outer()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_beta(alpha: f64, beta: f64) -> (BetaPosterior, Quantiles) {
        let posterior = BetaPosterior::new(alpha, beta).expect("a distribution");
        let at: Vec<f64> = (0..100)
            .map(|place| posterior.quantile((f64::from(place) + 0.5) / 100.0))
            .collect();
        (posterior, Quantiles::new(&at, posterior).expect("many"))
    }

    #[test]
    fn quantiles_of_a_beta_distribution_are_that_distribution() {
        let (posterior, found) = of_beta(7.5, 2.5);
        for place in 1..400 {
            let value = f64::from(place) / 400.0;
            let (expected, cdf) = (posterior.cdf(value), found.cdf(value));
            assert!((cdf - expected).abs() < 1e-3, "{value}: {cdf} {expected}");
            assert!((found.sf(value) - posterior.sf(value)).abs() < 1e-3);
        }
        for probability in [1e-5, 0.003, 0.01, 0.025, 0.4, 0.9, 0.999] {
            let (expected, value) = (posterior.quantile(probability), found.quantile(probability));
            assert!((value - expected).abs() < 1e-3, "{value} {expected}");
            let (expected, value) = (
                posterior.quantile_upper(probability),
                found.quantile_upper(probability),
            );
            assert!((value - expected).abs() < 1e-3, "{value} {expected}");
        }
    }

    #[test]
    fn both_tails_rise_and_fall_and_turn_back() {
        let (_, found) = of_beta(3.0, 40.0);
        let values = (0..=1000).map(|place| f64::from(place) / 1000.0);
        let both: Vec<(f64, f64)> = values.map(|it| (found.cdf(it), found.sf(it))).collect();
        assert!(
            both.windows(2)
                .all(|pair| pair[0].0 <= pair[1].0 && pair[0].1 >= pair[1].1)
        );
        for probability in [1e-4, 0.005, 0.05, 0.5, 0.97, 0.9999] {
            let again = found.cdf(found.quantile(probability));
            assert!((again - probability).abs() < 1e-6, "{again} {probability}");
        }
    }

    /// No draw lies above 0.98, and a quarter of them at it.
    #[test]
    fn a_skew_that_no_beta_distribution_has_is_kept() {
        let at: Vec<f64> = (0..100)
            .map(|it| (0.9 + 0.0011 * f64::from(it)).min(0.98))
            .collect();
        let mean = at.iter().sum::<f64>() / 100.0;
        let tails = BetaPosterior::new(mean * 100.0, (1.0 - mean) * 100.0).expect("a distribution");
        let found = Quantiles::new(&at, tails).expect("many");
        assert!(
            (found.cdf(0.9111) - 0.105).abs() < 0.006,
            "{}",
            found.cdf(0.9111)
        );
        assert!(found.sf(0.985) <= 0.005 && found.cdf(0.98) >= 0.99);
    }
}
