//! Cross-entropy: draw from a distribution, refit it to the best, draw again.
//!
//! ```text
//! draw N points; let E be the ceil(rho N) best of them
//! mean_j  <- a mean_E(x_j)   + (1 - a) mean_j                       continuous coordinate j
//! sd_j    <- b_t sd_E(x_j)   + (1 - b_t) sd_j,  b_t = b - b (1 - 1/t)^q
//! p_jk    <- a share_E(x_j = k) + (1 - a) p_jk                      discrete coordinate j, value k
//! ```
//!
//! Source: R. Y. Rubinstein, "The cross-entropy method for combinatorial and continuous
//! optimization" (1999); P.-T. de Boer, D. Kroese, S. Mannor and R. Rubinstein, "A tutorial on the
//! cross-entropy method" (2005), with its dynamic smoothing of deviations (section 5.2). For
//! falsification: S. Sankaranarayanan and G. Fainekos (2012). Deviations: continuous coordinates
//! are normal, cut off at the cube; no value of a discrete coordinate falls below a hundredth of
//! its even share, so that nothing is given up for ever; elites are never kept, so that a lucky
//! noisy value has no lasting effect. Cost: O(N d) a generation. Guarantee: none but the value of
//! what it finds.

use serde::{Deserialize, Serialize};
use stimulus::{Distribution, Point, Space};

use super::cube::{Cube, few_values, orderly};
use super::{Best, Evaluated, Search};
use crate::error::CampaignError;
use crate::random::Random;

const ELITE_SHARE: f64 = 0.2;
const SMALLEST_ELITE: usize = 5;
const SMOOTHING: f64 = 0.8;
const DEVIATION_SMOOTHING: f64 = 0.8;
const DEVIATION_POWER: i32 = 5;
const SMALLEST_DEVIATION: f64 = 1e-6;

/// What a coordinate is drawn from.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Axis {
    /// Normal in the unit interval, cut off at its ends.
    Normal { mean: f64, sd: f64 },
    /// One of few values, with probabilities.
    Few { probabilities: Vec<f64> },
}

/// A search by cross-entropy.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct CrossEntropy {
    cube: Cube,
    random: Random,
    axes: Vec<Axis>,
    population: usize,
    generation: u64,
    /// Coordinates and values of the present generation.
    told: Vec<(Vec<f64>, f64)>,
    best: Best,
}

impl CrossEntropy {
    /// A search with 20 points a generation and 3 more for each parameter.
    ///
    /// # Errors
    /// [`CampaignError::TooTight`] when no point meets the constraints.
    pub fn new(space: Space, seed: u64) -> Result<Self, CampaignError> {
        let population = 20 + 3 * space.dimensions();
        Self::with_population(space, seed, population)
    }

    /// A search with so many points a generation, at least 4.
    ///
    /// # Errors
    /// [`CampaignError::TooTight`] when no point meets the constraints.
    pub fn with_population(
        space: Space,
        seed: u64,
        population: usize,
    ) -> Result<Self, CampaignError> {
        let cube = Cube::new(space, seed)?;
        let axes = cube
            .parameters()
            .map(|p| Axis::new(&p.distribution, few_values(p)));
        Ok(Self {
            axes: axes.collect(),
            cube,
            random: Random::new(seed, "cross-entropy"),
            population: population.max(4),
            generation: 1,
            told: Vec::new(),
            best: Best::default(),
        })
    }

    /// How many points make a generation: the number to ask for at a time.
    #[must_use]
    pub fn population(&self) -> usize {
        self.population
    }

    /// Fits the axes to the best of the generation and opens the next one.
    fn refit(&mut self) {
        let mut told = std::mem::take(&mut self.told);
        told.sort_by(|a, b| a.1.total_cmp(&b.1));
        let elite = ((ELITE_SHARE * told.len() as f64).ceil() as usize).max(SMALLEST_ELITE);
        told.truncate(elite);
        for (index, axis) in self.axes.iter_mut().enumerate() {
            let values: Vec<f64> = told.iter().map(|(unit, _)| unit[index]).collect();
            axis.refit(&values, self.generation, |u| {
                value_index(&self.cube.space.parameters[index].distribution, u)
            });
        }
        self.generation += 1;
    }

    fn center(&self) -> Vec<f64> {
        let parameters = self.cube.parameters();
        let coordinate = |(axis, p): (&Axis, &stimulus::Parameter)| match axis {
            Axis::Normal { mean, .. } => *mean,
            Axis::Few { probabilities } => {
                let likeliest = (0..probabilities.len())
                    .max_by(|a, b| probabilities[*a].total_cmp(&probabilities[*b]))
                    .unwrap_or(0);
                middle_of(&p.distribution, likeliest)
            }
        };
        self.axes.iter().zip(parameters).map(coordinate).collect()
    }
}

impl Axis {
    fn new(distribution: &Distribution, few: Option<usize>) -> Self {
        match few {
            Some(count) => Self::Few {
                probabilities: possible(distribution, count),
            },
            // Wide enough to be nearly even within the cube.
            None => Self::Normal { mean: 0.5, sd: 0.7 },
        }
    }

    fn draw(&self, distribution: &Distribution, random: &mut Random) -> f64 {
        match self {
            Self::Normal { mean, sd } => {
                let normal = Distribution::Normal {
                    mean: *mean,
                    sd: *sd,
                    low: 0.0,
                    high: 1.0,
                };
                normal.quantile(random.open_unit())
            }
            Self::Few { probabilities } => {
                let index = random.weighted(probabilities).unwrap_or(0);
                middle_of(distribution, index)
            }
        }
    }

    fn refit(&mut self, values: &[f64], generation: u64, index_of: impl Fn(f64) -> usize) {
        let count = values.len() as f64;
        match self {
            Self::Normal { mean, sd } => {
                let center = values.iter().sum::<f64>() / count;
                let square = values.iter().map(|v| (v - center).powi(2)).sum::<f64>();
                let spread = (square / (count - 1.0).max(1.0)).sqrt();
                let late = (1.0 - 1.0 / generation as f64).powi(DEVIATION_POWER);
                let weight = DEVIATION_SMOOTHING * (1.0 - late);
                let weight = weight.max(0.1);
                *mean = SMOOTHING * center + (1.0 - SMOOTHING) * *mean;
                *sd = (weight * spread + (1.0 - weight) * *sd).max(SMALLEST_DEVIATION);
            }
            Self::Few { probabilities } => {
                let floor = 0.01 / probabilities.len() as f64;
                let mut shares = vec![0.0; probabilities.len()];
                for value in values {
                    shares[index_of(*value)] += 1.0 / count;
                }
                for (p, share) in probabilities.iter_mut().zip(shares) {
                    if *p > 0.0 {
                        *p = (SMOOTHING * share + (1.0 - SMOOTHING) * *p).max(floor);
                    }
                }
            }
        }
    }
}

/// An even probability for each value that can come.
fn possible(distribution: &Distribution, count: usize) -> Vec<f64> {
    match distribution {
        Distribution::Choice { weights, .. } => {
            weights.iter().map(|w| f64::from(*w > 0.0)).collect()
        }
        Distribution::Boolean { probability } => {
            vec![f64::from(*probability < 1.0), f64::from(*probability > 0.0)]
        }
        _ => vec![1.0; count],
    }
}

/// The coordinate in the middle of the interval of the value at `index`.
fn middle_of(distribution: &Distribution, index: usize) -> f64 {
    match distribution {
        Distribution::Choice { weights, .. } => {
            let before: f64 = weights[..index].iter().sum();
            (before + 0.5 * weights[index]) / weights.iter().sum::<f64>()
        }
        Distribution::Integer { low, .. } => distribution.unit_of((low + index as i64) as f64),
        _ => distribution.unit_of(index as f64),
    }
}

/// The place of the value at coordinate `u`: the inverse of [`middle_of`].
fn value_index(distribution: &Distribution, u: f64) -> usize {
    match distribution {
        Distribution::Choice { weights, .. } => {
            let total: f64 = weights.iter().sum();
            let mut sum = 0.0;
            let reached = weights.iter().position(|weight| {
                sum += weight;
                sum >= u * total && *weight > 0.0
            });
            reached.unwrap_or(weights.len() - 1)
        }
        Distribution::Integer { low, .. } => (distribution.quantile(u) - *low as f64) as usize,
        _ => distribution.quantile(u) as usize,
    }
}

impl Search for CrossEntropy {
    fn ask(&mut self, count: usize) -> Vec<Point> {
        let mut points = Vec::with_capacity(count);
        for _ in 0..count {
            let (axes, space) = (&self.axes, &self.cube.space);
            let (unit, point) = self.cube.draw(&mut self.random, |random| {
                let pairs = axes.iter().zip(&space.parameters);
                let unit = pairs.map(|(axis, p)| axis.draw(&p.distribution, random));
                let unit: Vec<f64> = unit.collect();
                (unit.clone(), unit)
            });
            points.push(point.clone());
            self.cube.propose(point, unit, self.generation);
        }
        points
    }

    fn tell(&mut self, results: &[(Point, f64)]) {
        for (point, value) in results {
            let Some(unit) = self.cube.settled_unit(point) else {
                continue;
            };
            let value = orderly(*value);
            self.best.tell(point, value);
            self.told.push((unit, value));
        }
        if self.told.len() >= self.population {
            self.refit();
        }
    }

    fn best(&self) -> Option<&Evaluated> {
        self.best.best.as_ref()
    }

    fn recommend(&self) -> Option<Point> {
        let center = self.cube.at(&self.center());
        if self.generation > 1 && self.cube.space.meets_constraints(&center) {
            return Some(center);
        }
        self.best().map(|best| best.point.clone())
    }
}
