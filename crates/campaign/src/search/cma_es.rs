//! Covariance matrix adaptation: an evolution strategy that learns the shape of what it descends.
//!
//! ```text
//! x_k ~ m + sigma N(0, C), k = 1..lambda, ranked; y_k = (x_k - m)/sigma
//! m       <- m + sigma y_w,                              y_w = sum_(i<=mu) w_i y_(i)
//! p_sigma <- (1 - c_s) p_sigma + sqrt(c_s (2 - c_s) mu_eff) C^(-1/2) y_w
//! sigma   <- sigma exp(c_s/d_s (|p_sigma| / E|N(0, I)| - 1))
//! p_c     <- (1 - c_c) p_c + h sqrt(c_c (2 - c_c) mu_eff) y_w
//! C       <- (1 - c_1 - c_mu) C + c_1 (p_c p_c^T + ...) + c_mu sum_i w_i y_(i) y_(i)^T
//! ```
//!
//! Source: N. Hansen, "The CMA evolution strategy: a tutorial" (2016), figure 6 and table 1, with
//! positive weights only; A. Auger and N. Hansen, "A restart CMA evolution strategy with
//! increasing population size" (2005) for restarts. Deviations: the search lives on the whole
//! line and is folded into the cube by reflection; a discrete coordinate is disturbed by at least
//! 0.3 of a value's width when it is drawn, so that it can leave its value however small sigma has
//! become; points beyond constraints are drawn again. Cost: O(lambda d^2 + d^3) a generation.
//! Guarantee: invariant under monotone changes of the values; else none but what it finds.

use serde::{Deserialize, Serialize};
use stimulus::{Point, Space};

use super::cube::{Cube, orderly, reflect};
use super::eigen::{Matrix, identity, symmetric_eigen};
use super::{Best, Evaluated, Search};
use crate::error::CampaignError;
use crate::random::Random;

/// The first deviation, in the unit cube.
const SIGMA: f64 = 0.3;

/// A search by covariance matrix adaptation.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct CmaEs {
    cube: Cube,
    random: Random,
    run: Run,
    /// Coordinates and values of the present generation.
    told: Vec<(Vec<f64>, f64)>,
    generation: u64,
    restarts: u64,
    best: Best,
}

/// The state between two restarts.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Run {
    lambda: usize,
    mean: Vec<f64>,
    sigma: f64,
    covariance: Matrix,
    /// Columns are directions; `lengths` the deviations along them.
    directions: Matrix,
    lengths: Vec<f64>,
    path_sigma: Vec<f64>,
    path_covariance: Vec<f64>,
    generation: u64,
    /// Best values of recent generations, for the decision to restart.
    recent: Vec<f64>,
}

/// Weights and rates, from the dimension and the population (table 1 of the tutorial).
struct Rates {
    weights: Vec<f64>,
    effective: f64,
    sigma: f64,
    damping: f64,
    path: f64,
    one: f64,
    many: f64,
    /// E|N(0, I)|.
    expected_length: f64,
}

impl Rates {
    fn new(dimensions: usize, lambda: usize) -> Self {
        let n = dimensions.max(1) as f64;
        let parents = (lambda / 2).max(1);
        let raw = |i: usize| ((lambda as f64 + 1.0) / 2.0).ln() - (i as f64 + 1.0).ln();
        let raw: Vec<f64> = (0..parents).map(raw).collect();
        let total: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|w| w / total).collect();
        let effective = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        let sigma = (effective + 2.0) / (n + effective + 5.0);
        let one = 2.0 / ((n + 1.3).powi(2) + effective);
        let many = 2.0 * (effective - 2.0 + 1.0 / effective) / ((n + 2.0).powi(2) + effective);
        Self {
            weights,
            effective,
            sigma,
            damping: 1.0 + 2.0 * (((effective - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + sigma,
            path: (4.0 + effective / n) / (n + 4.0 + 2.0 * effective / n),
            one,
            many: many.min(1.0 - one).max(0.0),
            expected_length: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
        }
    }
}

impl Run {
    fn new(mean: Vec<f64>, lambda: usize) -> Self {
        let size = mean.len();
        Self {
            lambda,
            sigma: SIGMA,
            covariance: identity(size),
            directions: identity(size),
            lengths: vec![1.0; size],
            path_sigma: vec![0.0; size],
            path_covariance: vec![0.0; size],
            generation: 0,
            recent: Vec::new(),
            mean,
        }
    }

    /// A draw from N(mean, sigma^2 C).
    fn draw(&self, random: &mut Random) -> Vec<f64> {
        let along: Vec<f64> = self
            .lengths
            .iter()
            .map(|l| l * random.standard_normal())
            .collect();
        let step = |row: &Vec<f64>| row.iter().zip(&along).map(|(v, a)| v * a).sum::<f64>();
        let steps = self.directions.iter().map(step);
        self.mean
            .iter()
            .zip(steps)
            .map(|(m, y)| m + self.sigma * y)
            .collect()
    }

    /// C^(-1/2) v.
    fn whitened(&self, v: &[f64]) -> Vec<f64> {
        let size = v.len();
        let along = |k: usize| -> f64 {
            let dot: f64 = (0..size).map(|i| self.directions[i][k] * v[i]).sum();
            dot / self.lengths[k]
        };
        let along: Vec<f64> = (0..size).map(along).collect();
        let back = |row: &Vec<f64>| row.iter().zip(&along).map(|(d, a)| d * a).sum();
        self.directions.iter().map(back).collect()
    }

    /// One generation's learning from coordinates in ascending order of their values.
    fn learn(&mut self, ranked: &[Vec<f64>]) {
        let rates = Rates::new(self.mean.len(), ranked.len());
        self.generation += 1;
        let steps: Vec<Vec<f64>> = ranked.iter().map(|x| self.step_to(x)).collect();
        let size = self.mean.len();
        let mut step = vec![0.0; size];
        for (weight, y) in rates.weights.iter().zip(&steps) {
            step.iter_mut().zip(y).for_each(|(s, y)| *s += weight * y);
        }
        for (m, s) in self.mean.iter_mut().zip(&step) {
            *m += self.sigma * s;
        }
        let length = self.lengthen_sigma_path(&step, &rates);
        let faded = 1.0 - (1.0 - rates.sigma).powf(2.0 * self.generation as f64);
        let limit = (1.4 + 2.0 / (size as f64 + 1.0)) * rates.expected_length;
        let steady = length / faded.sqrt() < limit;
        self.adapt_covariance(&steps, &step, &rates, steady);
        let growth = rates.sigma / rates.damping * (length / rates.expected_length - 1.0);
        self.sigma = (self.sigma * growth.min(1.0).exp()).min(1.0);
        self.decompose();
    }

    fn step_to(&self, x: &[f64]) -> Vec<f64> {
        let pairs = x.iter().zip(&self.mean);
        pairs.map(|(x, m)| (x - m) / self.sigma).collect()
    }

    /// Updates the path of sigma and returns its length.
    fn lengthen_sigma_path(&mut self, step: &[f64], rates: &Rates) -> f64 {
        let gain = (rates.sigma * (2.0 - rates.sigma) * rates.effective).sqrt();
        let white = self.whitened(step);
        for (p, w) in self.path_sigma.iter_mut().zip(&white) {
            *p = (1.0 - rates.sigma) * *p + gain * w;
        }
        self.path_sigma.iter().map(|p| p * p).sum::<f64>().sqrt()
    }

    fn adapt_covariance(&mut self, steps: &[Vec<f64>], step: &[f64], rates: &Rates, steady: bool) {
        let on = f64::from(u8::from(steady));
        let gain = on * (rates.path * (2.0 - rates.path) * rates.effective).sqrt();
        for (p, s) in self.path_covariance.iter_mut().zip(step) {
            *p = (1.0 - rates.path) * *p + gain * s;
        }
        let lost = rates.one * (1.0 - on) * rates.path * (2.0 - rates.path);
        let keep = 1.0 - rates.one - rates.many + lost;
        let path = &self.path_covariance;
        for (i, row) in self.covariance.iter_mut().enumerate() {
            for (j, c) in row.iter_mut().enumerate() {
                let weighted = rates.weights.iter().zip(steps);
                let many: f64 = weighted.map(|(w, y)| w * y[i] * y[j]).sum();
                *c = keep * *c + rates.one * path[i] * path[j] + rates.many * many;
            }
        }
    }

    fn decompose(&mut self) {
        let (values, directions) = symmetric_eigen(&self.covariance);
        self.directions = directions;
        self.lengths = values.iter().map(|v| v.max(1e-30).sqrt()).collect();
    }

    /// Whether the run has nothing more to gain (conditions of the restart paper).
    fn is_over(&self) -> bool {
        let longest = self.lengths.iter().fold(0.0_f64, |a, b| a.max(*b));
        let shortest = self.lengths.iter().fold(f64::INFINITY, |a, b| a.min(*b));
        let patience = 10 + (30.0 * self.mean.len() as f64 / self.lambda as f64).ceil() as usize;
        let window = self.recent.len().saturating_sub(patience);
        let recent = &self.recent[window..];
        let low = recent.iter().fold(f64::INFINITY, |a, b| a.min(*b));
        let high = recent.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
        let flat = recent.len() >= patience && high - low <= 1e-12 * (1.0 + high.abs());
        self.sigma * longest < 1e-12 || longest > 1e7 * shortest || flat
    }
}

impl CmaEs {
    /// A search from the middle of the cube with `4 + floor(3 ln d)` points a generation.
    ///
    /// # Errors
    /// [`CampaignError::TooTight`] when no point meets the constraints.
    pub fn new(space: Space, seed: u64) -> Result<Self, CampaignError> {
        let cube = Cube::new(space, seed)?;
        let size = cube.dimensions();
        let lambda = 4 + (3.0 * (size.max(1) as f64).ln()).floor() as usize;
        let nominal = cube.space.unit_of(&cube.space.nominal());
        Ok(Self {
            random: Random::new(seed, "cma-es"),
            run: Run::new(nominal, lambda),
            cube,
            told: Vec::new(),
            generation: 0,
            restarts: 0,
            best: Best::default(),
        })
    }

    /// How many points make a generation: the number to ask for at a time. Larger portions are
    /// learned from as one larger generation.
    #[must_use]
    pub fn population(&self) -> usize {
        self.run.lambda
    }

    /// How often the search began anew, each time with twice as many points a generation.
    #[must_use]
    pub fn restarts(&self) -> u64 {
        self.restarts
    }

    fn finish_generation(&mut self) {
        let mut told = std::mem::take(&mut self.told);
        told.sort_by(|a, b| a.1.total_cmp(&b.1));
        self.run.recent.push(told[0].1);
        let ranked: Vec<Vec<f64>> = told.into_iter().map(|(unit, _)| unit).collect();
        self.run.learn(&ranked);
        self.generation += 1;
        if self.run.is_over() {
            let mean = (0..self.cube.dimensions()).map(|_| self.random.open_unit());
            self.run = Run::new(mean.collect(), 2 * self.run.lambda);
            self.restarts += 1;
        }
    }

    /// Noise for discrete coordinates whose deviation has become less than 0.3 of a value's width.
    fn disturbance(&self) -> Vec<f64> {
        let deviations = self.run.covariance.iter().enumerate();
        let deviations = deviations.map(|(i, row)| self.run.sigma * row[i].max(0.0).sqrt());
        let wanted = self
            .cube
            .parameters()
            .map(|p| match p.distribution.cardinality() {
                Some(count) if count > 1 => 0.3 / count as f64,
                _ => 0.0,
            });
        let pairs = deviations.zip(wanted);
        pairs
            .map(|(has, wants)| (wants * wants - has * has).max(0.0).sqrt())
            .collect()
    }
}

impl Search for CmaEs {
    fn ask(&mut self, count: usize) -> Vec<Point> {
        let extra = self.disturbance();
        let mut points = Vec::with_capacity(count);
        for _ in 0..count {
            let run = &self.run;
            let (unit, point) = self.cube.draw(&mut self.random, |random| {
                let x = run.draw(random);
                let pairs = x.iter().zip(&extra);
                let noisy = pairs.map(|(x, sd)| match *sd > 0.0 {
                    true => reflect(x + sd * random.standard_normal()),
                    false => reflect(*x),
                });
                let folded = noisy.collect();
                (x, folded)
            });
            points.push(point.clone());
            self.cube.propose(point, unit, self.generation);
        }
        points
    }

    fn tell(&mut self, results: &[(Point, f64)]) {
        for (point, value) in results {
            if self.cube.unit_of(point).is_none() {
                continue;
            }
            let value = orderly(*value);
            self.best.tell(point, value);
            // Points from elsewhere, or of a generation that is over, would distort the paths.
            if let Some(proposal) = self.cube.settle(point)
                && proposal.generation == self.generation
            {
                self.told.push((proposal.unit, value));
            }
        }
        if self.told.len() >= self.run.lambda {
            self.finish_generation();
        }
    }

    fn best(&self) -> Option<&Evaluated> {
        self.best.best.as_ref()
    }

    fn recommend(&self) -> Option<Point> {
        let folded: Vec<f64> = self.run.mean.iter().map(|x| reflect(*x)).collect();
        let center = self.cube.at(&folded);
        // After a restart the mean has not yet learnt anything.
        if self.run.generation > 0
            && self.restarts == 0
            && self.cube.space.meets_constraints(&center)
        {
            return Some(center);
        }
        self.best().map(|best| best.point.clone())
    }
}
