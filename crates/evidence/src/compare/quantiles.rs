//! A distribution that is known by evenly spaced quantiles.
//!
//! # Definition
//! `n` quantiles at the probabilities `(i + 1/2) / n`. Between two of them, and beyond the first and the last, the distribution
//! function is linear in that of the beta distribution of the same mean and variance: it has that shape where nothing is known,
//! and the right probability at the quantiles. Below the middle it is worked out from below, above it from above.
//!
//! # Why
//! The beta distribution alone has another skew than, say, a probability that cannot exceed 0.98: of a model whose constant is
//! set to 94 of 120, and whose draws are below 0.95 with probability 0.010, it said 0.003.
//!
//! # Assumes
//! The draws are of the distribution. That it has the beta distribution's shape between quantiles is not tested.
//!
//! # Guarantee
//! Exact at the quantiles, up to the error of the draws, and everywhere if it is that beta distribution; monotone.

use super::uncertain::Places;
use stats::BetaPosterior;
use std::cell::OnceCell;
use std::rc::Rc;

/// Quantiles, ascending, and the beta distribution between them.
#[derive(Clone, Debug)]
pub(crate) struct Quantiles {
    at: Rc<[f64]>,
    shape: BetaPosterior,
    /// For means over the distribution, which are taken many times: finding them takes longer than the mean.
    places: Rc<OnceCell<Places>>,
}

impl Quantiles {
    /// `None` of fewer than two.
    pub fn new(at: &[f64], shape: BetaPosterior) -> Option<Self> {
        (at.len() > 1).then(|| Self {
            at: at.into(),
            shape,
            places: Rc::default(),
        })
    }

    /// How many quantiles there are; at least two.
    pub fn count(&self) -> usize {
        self.at.len()
    }

    /// Places of the distribution, for means over it.
    pub fn places(&self) -> &Places {
        self.places.get_or_init(|| Places::of(self))
    }

    /// The probability of at most this.
    pub fn cdf(&self, value: f64) -> f64 {
        match value < self.middle() {
            true => self.below(value),
            false => 1.0 - self.above(value),
        }
    }

    /// The probability of at least this.
    pub fn sf(&self, value: f64) -> f64 {
        match value < self.middle() {
            true => 1.0 - self.below(value),
            false => self.above(value),
        }
    }

    /// The value that is not reached with this probability.
    pub fn quantile(&self, probability: f64) -> f64 {
        if probability > 0.5 {
            return self.quantile_upper(1.0 - probability);
        }
        let of = |it: usize| self.shape.cdf(self.at[it]);
        let (from, to, share) = self.around(probability);
        let low = from.map_or(0.0, of);
        self.shape.quantile(low + share * (of(to) - low))
    }

    /// The value that is exceeded with this probability.
    pub fn quantile_upper(&self, probability: f64) -> f64 {
        if probability > 0.5 {
            return self.quantile(1.0 - probability);
        }
        let last = self.at.len() - 1;
        let of = |it: usize| self.shape.sf(self.at[last - it]);
        let (from, to, share) = self.around(probability);
        let low = from.map_or(0.0, of);
        self.shape.quantile_upper(low + share * (of(to) - low))
    }

    fn middle(&self) -> f64 {
        self.at[self.at.len() / 2]
    }

    /// The probability of a quantile, from its own end.
    fn level(&self, place: usize) -> f64 {
        (place as f64 + 0.5) / self.at.len() as f64
    }

    /// Between which quantiles, counted from an end, a probability lies, and where between them; none is the end itself.
    fn around(&self, probability: f64) -> (Option<usize>, usize, f64) {
        let first = self.level(0);
        if probability <= first {
            return (None, 0, probability.max(0.0) / first);
        }
        let place = probability * self.at.len() as f64 - 0.5;
        let from = (place.floor() as usize).min(self.at.len() - 2);
        (Some(from), from + 1, (place - from as f64).clamp(0.0, 1.0))
    }

    fn below(&self, value: f64) -> f64 {
        let to = self.at.partition_point(|it| *it < value);
        let of = |it: usize| self.shape.cdf(self.at[it.min(self.at.len() - 1)]);
        self.between(to, of, self.shape.cdf(value))
    }

    fn above(&self, value: f64) -> f64 {
        let last = self.at.len() - 1;
        let to = self.at.len() - self.at.partition_point(|it| *it <= value);
        let of = |it: usize| self.shape.sf(self.at[last - it.min(last)]);
        self.between(to, of, self.shape.sf(value))
    }

    /// The probability of a tail that ends before quantile `to`, counted from its own end, where the beta distribution's is
    /// `tail`, and `of` a quantile's.
    fn between(&self, to: usize, of: impl Fn(usize) -> f64, tail: f64) -> f64 {
        let to = to.min(self.at.len() - 1);
        let (low, from) = match to.checked_sub(1) {
            None => (0.0, 0.0),
            Some(from) => (of(from), self.level(from)),
        };
        let width = of(to) - low;
        let share = if width > 0.0 {
            ((tail - low) / width).clamp(0.0, 1.0)
        } else {
            0.0
        };
        from + share * (self.level(to) - from)
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
            assert!((cdf - expected).abs() < 1e-9, "{value}: {cdf} {expected}");
            assert!((found.sf(value) - posterior.sf(value)).abs() < 1e-9);
        }
        for probability in [1e-5, 0.003, 0.01, 0.025, 0.4, 0.9, 0.999] {
            let (expected, value) = (posterior.quantile(probability), found.quantile(probability));
            assert!((value - expected).abs() < 1e-9, "{value} {expected}");
            let (expected, value) = (
                posterior.quantile_upper(probability),
                found.quantile_upper(probability),
            );
            assert!((value - expected).abs() < 1e-9, "{value} {expected}");
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
        assert!(found.sf(0.985) <= 0.005 && found.cdf(0.9799) < 0.75 && found.sf(0.9801) <= 0.005);
    }
}
