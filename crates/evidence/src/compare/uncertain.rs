//! One number that is uncertain: by the quantiles of its draws where these are known, else by a beta distribution.
//!
//! # Definition
//! Tails and quantiles are those of [`Quantiles`]. That one such number exceeds another is the mean of the other's
//! distribution function over the first,
//!
//! ```text
//! P(X >= Y + d)  =  integral over u in [0, 1] of  F_Y(Q_X(u) - d)
//! ```
//!
//! by midpoints: eight in each piece between two quantiles, and in the tails beyond them pieces that halve towards the end, so
//! that a small probability has places of its own.
//!
//! # Assumes
//! Two numbers that are compared are independent of each other, and the draws are of their distributions.
//!
//! # Guarantee
//! `F_Y` rises, so the sum is off by no more than half of what the heaviest place weighs: 0.0007 of 100 quantiles, and less in
//! the tails. Of two beta distributions it is integrated ([`probability_exceeds`]).

use super::quantiles::Quantiles;
use stats::{BetaPosterior, PosteriorPlaces, probability_exceeds};

/// Places in each piece between two quantiles.
const PLACES: usize = 8;
/// How often a tail is halved.
const HALVES: usize = 12;

/// A number with its distribution.
#[derive(Clone, Debug)]
pub(crate) struct Uncertain {
    /// The beta distribution of the same mean and variance.
    pub shape: BetaPosterior,
    /// Quantiles of the draws; `None` where only the beta distribution is known.
    pub quantiles: Option<Quantiles>,
}

impl From<BetaPosterior> for Uncertain {
    fn from(shape: BetaPosterior) -> Self {
        let quantiles = None;
        Self { shape, quantiles }
    }
}

impl Uncertain {
    /// The distribution of draws with these quantiles, ascending, whose beta distribution is `shape`.
    pub fn of_draws(quantiles: &[f64], shape: BetaPosterior) -> Self {
        let quantiles = Quantiles::new(quantiles, shape);
        Self { shape, quantiles }
    }

    /// The probability of at most this.
    pub fn cdf(&self, value: f64) -> f64 {
        match &self.quantiles {
            Some(quantiles) => quantiles.cdf(value),
            None => self.shape.cdf(value),
        }
    }

    /// The probability of at least this.
    pub fn sf(&self, value: f64) -> f64 {
        match &self.quantiles {
            Some(quantiles) => quantiles.sf(value),
            None => self.shape.sf(value),
        }
    }

    /// The value that is not reached with this probability.
    pub fn quantile(&self, probability: f64) -> f64 {
        match &self.quantiles {
            Some(quantiles) => quantiles.quantile(probability),
            None => self.shape.quantile(probability),
        }
    }

    /// The value that is exceeded with this probability.
    pub fn quantile_upper(&self, probability: f64) -> f64 {
        match &self.quantiles {
            Some(quantiles) => quantiles.quantile_upper(probability),
            None => self.shape.quantile_upper(probability),
        }
    }

    /// The probability that this is at least another and `by` more.
    pub fn exceeds(&self, other: &Self, by: f64) -> f64 {
        let sum = |found: f64| found.clamp(0.0, 1.0);
        match (&self.quantiles, &other.quantiles) {
            (None, None) => probability_exceeds(&self.shape, &other.shape, by),
            (Some(own), _) => sum(mean_over(own, |value| other.cdf(value - by))),
            (None, Some(others)) => sum(mean_over(others, |value| self.sf(value + by))),
        }
    }

    /// Places of the distribution, for plans.
    pub fn places(&self) -> PosteriorPlaces {
        PosteriorPlaces::of_quantiles(|level| self.quantile(level))
    }
}

/// The mean of a monotone function over a distribution that is known by quantiles.
fn mean_over(quantiles: &Quantiles, function: impl Fn(f64) -> f64) -> f64 {
    let places = quantiles.places();
    let tails: f64 = places
        .tails
        .iter()
        .map(|(weight, lower, upper)| weight * (function(*lower) + function(*upper)))
        .sum();
    let middle: f64 = places.middle.iter().map(|value| function(*value)).sum();
    tails + places.weight * middle
}

/// Where a mean over a distribution is taken.
#[derive(Debug)]
pub(crate) struct Places {
    /// The weight of each place of a tail, and where it is in the lower and in the upper one.
    tails: Vec<(f64, f64, f64)>,
    /// Between the tails, each of the same weight.
    middle: Vec<f64>,
    /// That weight.
    weight: f64,
}

impl Places {
    /// Those of a distribution.
    pub fn of(quantiles: &Quantiles) -> Self {
        let first = 0.5 / quantiles.count() as f64;
        let both = |(level, weight)| {
            (
                weight,
                quantiles.quantile(level),
                quantiles.quantile_upper(level),
            )
        };
        let pieces = (quantiles.count() - 1) * PLACES;
        let weight = (1.0 - 2.0 * first) / pieces as f64;
        let levels = (0..pieces).map(|place| first + (place as f64 + 0.5) * weight);
        Self {
            tails: tail(first).map(both).collect(),
            middle: levels.map(|level| quantiles.quantile(level)).collect(),
            weight,
        }
    }
}

/// Levels and weights of a tail, from where it begins to its end.
fn tail(begins_at: f64) -> impl Iterator<Item = (f64, f64)> {
    (0..=HALVES).map(move |halved| {
        let high = begins_at * 0.5_f64.powi(halved as i32);
        let low = match halved {
            HALVES => 0.0,
            _ => 0.5 * high,
        };
        (0.5 * (low + high), high - low)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quantiles(of: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..100)
            .map(|it| of((f64::from(it) + 0.5) / 100.0))
            .collect()
    }

    /// Of draws that are those of a beta distribution it is what integration finds.
    #[test]
    fn draws_of_beta_distributions_exceed_each_other_as_these_do() {
        let betas = [(7.5, 2.5), (60.5, 40.5), (3.5, 9.5)]
            .map(|(a, b)| BetaPosterior::new(a, b).expect("a distribution"));
        for first in betas {
            for second in betas {
                let drawn =
                    |it: BetaPosterior| Uncertain::of_draws(&quantiles(|u| it.quantile(u)), it);
                for by in [0.0, 0.05, 0.3] {
                    let expected = probability_exceeds(&first, &second, by);
                    for (one, other) in [
                        (drawn(first), drawn(second)),
                        (drawn(first), second.into()),
                        (first.into(), drawn(second)),
                    ] {
                        let found = one.exceeds(&other, by);
                        assert!((found - expected).abs() < 7e-4, "{found} {expected} {by}");
                    }
                }
            }
        }
    }

    /// No draw of `min(p, 0.9)` lies above 0.9, where the beta distribution of its moments has more than a hundredth.
    #[test]
    fn a_tail_is_that_of_the_draws() {
        let constant = BetaPosterior::new(18.5, 2.5).expect("a distribution");
        let draws = quantiles(|u| constant.quantile(u).min(0.9));
        let moments = stats::Draws::new(&draws).expect("draws");
        let size = moments.mean() * (1.0 - moments.mean()) / moments.variance() - 1.0;
        let shape = BetaPosterior::new(moments.mean() * size, (1.0 - moments.mean()) * size);
        let shape = shape.expect("a distribution");
        let found = Uncertain::of_draws(&draws, shape);
        assert!(found.sf(0.92) <= 0.005, "{}", found.sf(0.92));
        assert!(shape.sf(0.92) > 1e-2, "{}", shape.sf(0.92));
        let narrow = BetaPosterior::new(92_000.0, 8_000.0).expect("a distribution");
        let exceeds = found.exceeds(&narrow.into(), 0.0);
        assert!(exceeds <= 0.006, "{exceeds}");
    }
}
