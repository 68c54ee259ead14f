//! The posterior as a weighted sample: marginals, correlations, and what stays unknown.
//!
//! Definition. Points of the prior carry weights in proportion to their likelihood. Contraction of
//! a parameter is `1 - var(posterior) / var(prior)`, taken in the prior's own unit cube, where every
//! prior is uniform with variance 1/12: 0 if nothing was learnt, 1 if all is known. Directions are
//! the eigenvectors of the posterior's covariance there, with a contraction of their own. Words follow
//! from the contraction ([`Identifiability`]): 0.8 and more is identified, 0.5 to 0.8 weakly, less is not.
//!
//! Source: A. Raue et al., "Structural and practical identifiability analysis of partially observed
//! dynamical models by exploiting the profile likelihood", Bioinformatics 25 (2009) for the notion;
//! contraction after M. Schad, M. Betancourt and S. Vasishth, "Toward a principled Bayesian
//! workflow", Psychological Methods 26 (2021). Cost: linear. Guarantee: the effective sample size,
//! `(sum w)^2 / sum w^2` (L. Kish, 1965), says how far the sample can be trusted.

use stats::{Confidence, Draws, Interval};

use crate::random::Random;
use crate::search::eigen::symmetric_eigen;

/// From this contraction on, counts say where a value is.
const IDENTIFIED: f64 = 0.8;

/// From this contraction on, they say more than the prior that is left.
const WEAKLY_IDENTIFIED: f64 = 0.5;

/// The prior's variance in the unit cube.
const PRIOR_VARIANCE: f64 = 1.0 / 12.0;

/// A weighted sample of parameters in the unit cube.
#[derive(Debug, Clone)]
pub struct Posterior {
    units: Vec<Vec<f64>>,
    weights: Vec<f64>,
    /// For each point, the rate of each way to fail.
    rates: Vec<Vec<f64>>,
}

/// One parameter, in the unit cube.
#[derive(Debug, Clone, PartialEq)]
pub struct Marginal {
    /// Mean.
    pub mean: f64,
    /// Median.
    pub median: f64,
    /// Between equal tails.
    pub interval: Interval,
    /// How much of the prior's variance is gone, 0 to 1 (below 0 if it grew).
    pub contraction: f64,
}

/// Whether the data say where a value is, by the contraction of its posterior.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Identifiability {
    /// A contraction of at least 0.8.
    Identified,
    /// From 0.5 to 0.8.
    Weak,
    /// Less: the value is mostly the prior's.
    Unidentified,
}

impl Identifiability {
    /// That of a contraction.
    #[must_use]
    pub fn of(contraction: f64) -> Self {
        match contraction {
            it if it >= IDENTIFIED => Self::Identified,
            it if it >= WEAKLY_IDENTIFIED => Self::Weak,
            _ => Self::Unidentified,
        }
    }
}

/// A direction in the unit cube.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// How much of it each parameter is; squares add up to 1, the largest is positive.
    pub loadings: Vec<f64>,
    /// Posterior variance over prior variance.
    pub variance_share: f64,
    /// Whether the data say where in this direction the parameters are.
    pub identifiability: Identifiability,
}

impl Posterior {
    pub(super) fn new(units: Vec<Vec<f64>>, ln_weights: &[f64], rates: Vec<Vec<f64>>) -> Self {
        let most = ln_weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let raw: Vec<f64> = ln_weights.iter().map(|w| (w - most).exp()).collect();
        let total: f64 = raw.iter().sum();
        let weights = raw.iter().map(|w| w / total).collect();
        Self {
            units,
            weights,
            rates,
        }
    }

    /// The points with their weights, which add up to 1.
    pub fn sample(&self) -> impl Iterator<Item = (&[f64], f64)> {
        let units = self.units.iter().map(Vec::as_slice);
        units.zip(self.weights.iter().copied())
    }

    /// The rate of a way to fail at each point, with the point's weight.
    pub(super) fn rates(&self, mode: usize) -> impl Iterator<Item = (f64, f64)> {
        let rates = self.rates.iter().map(move |rates| rates[mode]);
        rates.zip(self.weights.iter().copied())
    }

    /// How many independent points the sample is worth.
    #[must_use]
    pub fn effective_size(&self) -> f64 {
        1.0 / self.weights.iter().map(|w| w * w).sum::<f64>()
    }

    /// A point drawn by weight.
    #[must_use]
    pub fn draw(&self, random: &mut Random) -> Vec<f64> {
        // Weights are positive and add up to 1, so there is always one.
        let place = random.weighted(&self.weights).unwrap_or(0);
        self.units[place].clone()
    }

    /// The mean of all parameters.
    #[must_use]
    pub fn mean(&self) -> Vec<f64> {
        let dimensions = self.units.first().map_or(0, Vec::len);
        let mean = |d: usize| self.sample().map(|(unit, w)| unit[d] * w).sum();
        (0..dimensions).map(mean).collect()
    }

    /// The point of the sample with the largest density, the first of equals: the posterior's mode as far as the sample
    /// resolves it, since its points lie evenly over a uniform prior. Of a skewed posterior, such as that of a rate seen
    /// three times in a hundred, it is where the counts are best reproduced, and the mean lies above it.
    #[must_use]
    pub fn mode(&self) -> Vec<f64> {
        let heavier = |best: usize, place: usize| match self.weights[place] > self.weights[best] {
            true => place,
            false => best,
        };
        let best = (0..self.units.len()).reduce(heavier);
        best.map_or_else(Vec::new, |place| self.units[place].clone())
    }

    fn covariance(&self) -> Vec<Vec<f64>> {
        let mean = self.mean();
        let of = |i: usize, j: usize| -> f64 {
            let parts = self.sample();
            parts
                .map(|(unit, w)| w * (unit[i] - mean[i]) * (unit[j] - mean[j]))
                .sum()
        };
        let dimensions = mean.len();
        let row = |i| (0..dimensions).map(|j| of(i, j)).collect();
        (0..dimensions).map(row).collect()
    }

    /// Each parameter by itself.
    #[must_use]
    pub fn marginals(&self, confidence: Confidence) -> Vec<Marginal> {
        let covariance = self.covariance();
        let mean = self.mean();
        (0..mean.len())
            .map(|d| {
                let values: Vec<f64> = self.units.iter().map(|unit| unit[d]).collect();
                let draws = Draws::weighted(&values, &self.weights).ok();
                let draws = draws.as_ref();
                Marginal {
                    mean: mean[d],
                    median: draws.map_or(mean[d], |it| it.quantile(0.5)),
                    interval: draws.map_or(Interval::VACUOUS, |it| it.interval(confidence)),
                    contraction: 1.0 - covariance[d][d] / PRIOR_VARIANCE,
                }
            })
            .collect()
    }

    /// Correlations of the parameters in the unit cube.
    #[must_use]
    pub fn correlations(&self) -> Vec<Vec<f64>> {
        let c = self.covariance();
        let of = |i: usize, j: usize| match c[i][i] * c[j][j] {
            product if product > 0.0 => c[i][j] / product.sqrt(),
            _ => 0.0,
        };
        let row = |i| (0..c.len()).map(|j| of(i, j)).collect();
        (0..c.len()).map(row).collect()
    }

    /// Directions from the least to the best known.
    #[must_use]
    pub fn directions(&self) -> Vec<Direction> {
        let (values, vectors) = symmetric_eigen(&self.covariance());
        let mut directions: Vec<Direction> = (values.iter().enumerate())
            .map(|(column, value)| {
                let loadings: Vec<f64> = vectors.iter().map(|row| row[column]).collect();
                let by_size = |a: &&f64, b: &&f64| a.abs().total_cmp(&b.abs());
                let largest = loadings.iter().max_by(by_size).copied();
                let sign = largest.map_or(1.0, f64::signum);
                let variance_share = value / PRIOR_VARIANCE;
                Direction {
                    loadings: loadings.iter().map(|x| x * sign).collect(),
                    variance_share,
                    identifiability: Identifiability::of(1.0 - variance_share),
                }
            })
            .collect();
        directions.sort_by(|a, b| b.variance_share.total_cmp(&a.variance_share));
        directions
    }

    /// The probability that the posterior gives to values of a parameter below `unit`.
    #[must_use]
    pub fn cdf(&self, dimension: usize, unit: f64) -> f64 {
        let below = self.sample().filter(|(point, _)| point[dimension] < unit);
        below.map(|(_, w)| w).sum()
    }
}
