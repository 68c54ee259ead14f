//! Bayesian optimisation: evaluate where a Gaussian process expects the largest improvement.
//!
//! ```text
//! EI(x) = (b - mean(x)) Phi(z) + sd(x) phi(z),   z = (b - mean(x)) / sd(x)
//! b = the smallest posterior mean at an evaluated point
//! ```
//!
//! Source: J. Mockus (1975); D. R. Jones, M. Schonlau and W. J. Welch, "Efficient global
//! optimization of expensive black-box functions" (1998). Deviations: with noise, b is a posterior
//! mean and not a value (as in "plug-in" EI; V. Picheny, T. Wagner and D. Ginsbourger, 2013);
//! several points at a time, and points still without value, count as if their expected value had
//! been told ("kriging believer"; D. Ginsbourger, R. Le Riche and L. Carraro, 2010); values far
//! above the rest are cut, since only the low ones matter; EI is maximised over a random even set
//! and around the best, then by a pattern search. Cost: O(n^3) for each eighth more data, O(n^2) for
//! each candidate; meant for a few hundred evaluations (300 in 6 parameters took 25 s, 100 took 1.5 s). Guarantee: none but what it finds.

use serde::{Deserialize, Serialize};
use stats::special::{normal_cdf, normal_density};
use stimulus::{Point, Space};

use super::cube::{Cube, orderly, unordered};
use super::gaussian_process::{GaussianProcess, Hyper, fitted};
use super::{Best, Evaluated, Search};
use crate::error::CampaignError;
use crate::random::Random;

/// A search by Bayesian optimisation.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Bayesian {
    cube: Cube,
    random: Random,
    seed: u64,
    initial: usize,
    asked: usize,
    rows: Vec<Vec<f64>>,
    values: Vec<f64>,
    hyper: Hyper,
    /// How many values there were when lengths and noise were last fitted.
    fitted_at: usize,
    best: Best,
}

impl Bayesian {
    /// A search that begins with `2 d + 3` points spread evenly.
    ///
    /// # Errors
    /// [`CampaignError::TooTight`] when no point meets the constraints.
    pub fn new(space: Space, seed: u64) -> Result<Self, CampaignError> {
        let cube = Cube::new(space, seed)?;
        let dimensions = cube.dimensions();
        Ok(Self {
            random: Random::new(seed, "bayesian"),
            seed,
            initial: 2 * dimensions + 3,
            asked: 0,
            rows: Vec::new(),
            values: Vec::new(),
            hyper: Hyper::start(dimensions),
            fitted_at: 0,
            best: Best::default(),
            cube,
        })
    }

    /// The Gaussian process of all that was told.
    #[must_use]
    pub fn process(&self) -> GaussianProcess {
        let values = cut_above(&self.values);
        GaussianProcess::with_hyper(&self.rows, &values, &self.unordered(), self.hyper.clone())
    }

    /// What is expected at a point of the space.
    #[must_use]
    pub fn predict(&self, point: &Point) -> super::Prediction {
        self.process().predict(&self.cube.space.unit_of(point))
    }

    fn unordered(&self) -> Vec<bool> {
        self.cube.parameters().map(unordered).collect()
    }

    /// Lengths and noise are fitted anew when there is an eighth more data than at the last time.
    fn refit(&mut self) {
        let due = self.fitted_at + self.fitted_at.div_ceil(8).max(1);
        if self.values.len() < self.initial.max(due) {
            return;
        }
        let values = cut_above(&self.values);
        self.hyper = fitted(&self.rows, &values, &self.unordered(), self.hyper.clone());
        self.fitted_at = self.values.len();
    }

    fn initial_point(&mut self) -> (Vec<f64>, Point) {
        let (seed, dimensions) = (self.seed, self.cube.dimensions());
        let mut index = self.asked as u64;
        let cube = &self.cube;
        cube.draw(&mut self.random, |_| {
            let mut rows = stats::design_from(index, 1, dimensions, seed);
            // Rejected places are left for ones far along the sequence.
            index += 1000;
            let row = rows.pop().unwrap_or_default();
            (row.clone(), row)
        })
    }

    /// The point of largest expected improvement among many.
    fn improving_point(&mut self, process: &GaussianProcess, target: f64) -> (Vec<f64>, Point) {
        let candidates = self.candidates();
        let gain = |row: &Vec<f64>| expected_improvement(process, row, target);
        let mut scored: Vec<(f64, Vec<f64>)> = candidates
            .into_iter()
            .map(|row| (gain(&row), row))
            .collect();
        scored.sort_by(|a, b| b.0.total_cmp(&a.0));
        scored.truncate(3);
        let climbed = scored.into_iter().map(|start| self.climb(start, &gain));
        let best = climbed.max_by(|a, b| a.0.total_cmp(&b.0));
        let row = best.map(|(_, row)| row).unwrap_or_default();
        let point = self.cube.at(&row);
        (row, point)
    }

    /// Random points everywhere and around the best, on values that can come, all allowed.
    fn candidates(&mut self) -> Vec<Vec<f64>> {
        let dimensions = self.cube.dimensions();
        let everywhere = (200 * dimensions).clamp(400, 1500);
        let mut order: Vec<usize> = (0..self.values.len()).collect();
        order.sort_by(|a, b| self.values[*a].total_cmp(&self.values[*b]));
        order.truncate(5);
        let (cube, rows) = (&self.cube, &self.rows);
        let mut found = Vec::new();
        for index in 0..everywhere + 300 {
            let near = (index >= everywhere).then(|| &rows[order[index % order.len()]]);
            let reach = [0.2, 0.05, 0.01][index % 3];
            let (_, point) = cube.draw(&mut self.random, |random| {
                let row: Vec<f64> = match near {
                    None => (0..dimensions).map(|_| random.open_unit()).collect(),
                    Some(row) => row.iter().map(|x| disturbed(*x, reach, random)).collect(),
                };
                (row.clone(), row)
            });
            found.push(cube.space.unit_of(&point));
        }
        found
    }

    /// A pattern search for a larger gain, within the cube and the constraints.
    fn climb(&self, start: (f64, Vec<f64>), gain: &dyn Fn(&Vec<f64>) -> f64) -> (f64, Vec<f64>) {
        let mut best = start;
        let mut step = 0.02;
        while step > 0.001 {
            let before = best.0;
            for index in 0..best.1.len() {
                for by in [step, -step] {
                    let mut moved = best.1.clone();
                    moved[index] = (moved[index] + by).clamp(0.0, 1.0);
                    let point = self.cube.at(&moved);
                    if !self.cube.space.meets_constraints(&point) {
                        continue;
                    }
                    let moved = self.cube.space.unit_of(&point);
                    let found = gain(&moved);
                    if found > best.0 {
                        best = (found, moved);
                    }
                }
            }
            if best.0 <= before {
                step *= 0.5;
            }
        }
        best
    }

    /// The evaluated row of smallest posterior mean, and that mean.
    fn incumbent(&self, process: &GaussianProcess) -> Option<(usize, f64)> {
        let means = self.rows.iter().map(|row| process.predict(row).mean);
        means.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

fn disturbed(x: f64, reach: f64, random: &mut Random) -> f64 {
    (x + reach * random.standard_normal()).clamp(0.0, 1.0)
}

fn expected_improvement(process: &GaussianProcess, row: &[f64], target: f64) -> f64 {
    let expected = process.predict(row);
    let gain = target - expected.mean;
    if expected.sd <= 0.0 {
        return gain.max(0.0);
    }
    let z = gain / expected.sd;
    gain * normal_cdf(z) + expected.sd * normal_density(z)
}

/// Values more than five times as far above the lower quartile as the smallest one is below the
/// median are cut to there: one huge value would hide all differences among the small ones.
fn cut_above(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some((low, median)) = sorted.first().zip(sorted.get(sorted.len() / 2)) else {
        return Vec::new();
    };
    let limit = median + 5.0 * (median - low);
    let limit = if limit > *median {
        limit
    } else {
        f64::INFINITY
    };
    values.iter().map(|v| v.min(limit)).collect()
}

impl Search for Bayesian {
    fn ask(&mut self, count: usize) -> Vec<Point> {
        let mut points = Vec::with_capacity(count);
        let mut believer: Option<(GaussianProcess, f64)> = None;
        for _ in 0..count {
            let (row, point) = if self.asked < self.initial || self.values.is_empty() {
                self.initial_point()
            } else {
                let (mut process, target) = match believer.take() {
                    Some(kept) => kept,
                    None => self.believing(),
                };
                let (row, point) = self.improving_point(&process, target);
                process.push(&row, process.predict(&row).mean);
                believer = Some((process, target));
                (row, point)
            };
            self.asked += 1;
            let snapped = self.cube.space.unit_of(&point);
            let row = if snapped.len() == row.len() {
                snapped
            } else {
                row
            };
            points.push(point.clone());
            self.cube.propose(point, row, 0);
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
            self.rows.push(unit);
            self.values.push(value);
        }
        self.refit();
    }

    fn best(&self) -> Option<&Evaluated> {
        self.best.best.as_ref()
    }

    fn recommend(&self) -> Option<Point> {
        let (index, _) = self.incumbent(&self.process())?;
        Some(self.cube.at(&self.rows[index]))
    }
}

impl Bayesian {
    /// The process that takes open proposals for evaluated, and the mean to improve upon.
    fn believing(&self) -> (GaussianProcess, f64) {
        let mut process = self.process();
        let target = self.incumbent(&process).map_or(0.0, |(_, mean)| mean);
        for proposal in self.cube.open() {
            let expected = process.predict(&proposal.unit).mean;
            process.push(&proposal.unit, expected);
        }
        (process, target)
    }
}
