//! A Gaussian process: what values at some points say of the values at all others.
//!
//! ```text
//! cov(y_i, y_j) = s^2 (k(r_ij) + g [i = j]),   r_ij^2 = sum_k ((x_ik - x_jk) / l_k)^2
//! k(r) = (1 + sqrt(5) r + 5 r^2/3) exp(-sqrt(5) r)                       Matern 5/2
//! mean(x) = m + k_x^T (K + g I)^-1 (y - m),  var(x) = s^2 (1 - k_x^T (K + g I)^-1 k_x)
//! ```
//!
//! For a parameter whose order means nothing, the difference of two values is 0 or 1. Source:
//! C. E. Rasmussen and C. Williams, "Gaussian Processes for Machine Learning" (2006), algorithm
//! 2.1 and equations 4.17 and 5.8; the prior of lengths from C. Hvarfner, E. O. Hellsten and
//! L. Nardi, "Vanilla Bayesian optimization performs great in high dimensions" (2024). Deviations:
//! s^2 is profiled out; the lengths l and the noise g are the best of a deterministic pattern
//! search (R. Hooke and T. A. Jeeves, 1961), not a global optimum. Cost: O(n^3) to fit, times
//! about 20 (d + 1) for the search; O(n^2) for a prediction. Guarantee: estimated; intervals hold
//! if values are what the prior says.

use serde::{Deserialize, Serialize};

/// The kernel's lengths and the noise, as logarithms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Hyper {
    pub(crate) ln_lengths: Vec<f64>,
    pub(crate) ln_noise: f64,
}

/// What is expected at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Expected value.
    pub mean: f64,
    /// Standard deviation of the noiseless value.
    pub sd: f64,
}

/// A Gaussian process with data, ready for predictions.
///
/// ```
/// use campaign::GaussianProcess;
/// let rows: Vec<Vec<f64>> = (0..9).map(|i| vec![f64::from(i) / 8.0]).collect();
/// let values: Vec<f64> = rows.iter().map(|x| (6.0 * x[0]).sin()).collect();
/// let process = GaussianProcess::fit(&rows, &values, &[false]);
/// let between = process.predict(&[0.55]);
/// assert!((between.mean - 3.3_f64.sin()).abs() < 0.05);
/// assert!(between.sd < 0.1 && process.predict(&[3.0]).sd > between.sd);
/// ```
#[derive(Debug, Clone)]
pub struct GaussianProcess {
    rows: Vec<Vec<f64>>,
    unordered: Vec<bool>,
    hyper: Hyper,
    /// Centre and scale by which values were made standard.
    center: f64,
    scale: f64,
    /// Standard values.
    values: Vec<f64>,
    /// The lower Cholesky factor of K + g I.
    factor: Vec<Vec<f64>>,
    /// (K + g I)^-1 y.
    solved: Vec<f64>,
    /// s^2, of standard values.
    variance: f64,
}

const LN_NOISE: [f64; 2] = [-18.4, 2.3];
const LN_LENGTH: [f64; 2] = [-4.0, 5.0];

impl Hyper {
    pub(crate) fn start(dimensions: usize) -> Self {
        Self {
            ln_lengths: vec![-0.7; dimensions],
            ln_noise: -5.0,
        }
    }

    /// Logarithm of the prior density, up to a constant.
    fn ln_prior(&self) -> f64 {
        let dimensions = self.ln_lengths.len().max(1) as f64;
        let typical = 2.0_f64.sqrt() + 0.5 * dimensions.ln();
        let lengths = self.ln_lengths.iter().map(|l| (l - typical).powi(2) / 6.0);
        -lengths.sum::<f64>() - (self.ln_noise + 8.0).powi(2) / 50.0
    }

    /// All logarithms, with one changed within its bounds.
    fn moved(&self, index: usize, by: f64) -> Self {
        let mut moved = self.clone();
        match moved.ln_lengths.get_mut(index) {
            Some(length) => *length = (*length + by).clamp(LN_LENGTH[0], LN_LENGTH[1]),
            None => moved.ln_noise = (moved.ln_noise + by).clamp(LN_NOISE[0], LN_NOISE[1]),
        }
        moved
    }
}

impl GaussianProcess {
    /// Fits lengths and noise to values at rows of the unit cube; `unordered` marks coordinates
    /// whose order means nothing. Rows are as long as `unordered`, and as many as values.
    #[must_use]
    pub fn fit(rows: &[Vec<f64>], values: &[f64], unordered: &[bool]) -> Self {
        let hyper = fitted(rows, values, unordered, Hyper::start(unordered.len()));
        Self::with_hyper(rows, values, unordered, hyper)
    }

    pub(crate) fn with_hyper(
        rows: &[Vec<f64>],
        values: &[f64],
        unordered: &[bool],
        hyper: Hyper,
    ) -> Self {
        let (center, scale) = center_and_scale(values);
        let mut process = Self {
            rows: Vec::with_capacity(rows.len()),
            unordered: unordered.to_vec(),
            hyper,
            center,
            scale,
            values: Vec::with_capacity(rows.len()),
            factor: Vec::with_capacity(rows.len()),
            solved: Vec::new(),
            variance: 1.0,
        };
        for (row, value) in rows.iter().zip(values) {
            process.extend_factor(row, *value);
        }
        process.solve();
        let quadratic: f64 = process
            .solved
            .iter()
            .zip(&process.values)
            .map(|(a, y)| a * y)
            .sum();
        process.variance = (quadratic / (process.values.len().max(1) as f64)).max(1e-12);
        process
    }

    /// Adds an observation without changing lengths, noise and scale.
    pub(crate) fn push(&mut self, row: &[f64], value: f64) {
        self.extend_factor(row, value);
        self.solve();
    }

    /// Noise as a standard deviation, in the unit of the values.
    #[must_use]
    pub fn noise_sd(&self) -> f64 {
        self.scale * (self.variance * self.hyper.ln_noise.exp()).sqrt()
    }

    /// What is expected at a row of the unit cube.
    #[must_use]
    pub fn predict(&self, row: &[f64]) -> Prediction {
        let covariances = self.covariances(row);
        let pairs = covariances.iter().zip(&self.solved);
        let mean: f64 = pairs.map(|(k, a)| k * a).sum();
        let white = forward(&self.factor, covariances);
        let explained: f64 = white.iter().map(|v| v * v).sum();
        Prediction {
            mean: self.center + self.scale * mean,
            sd: self.scale * (self.variance * (1.0 - explained).max(0.0)).sqrt(),
        }
    }

    fn covariances(&self, row: &[f64]) -> Vec<f64> {
        let inverse: Vec<f64> = self.hyper.ln_lengths.iter().map(|l| (-l).exp()).collect();
        let one = |other: &Vec<f64>| matern(distance(row, other, &inverse, &self.unordered));
        self.rows.iter().map(one).collect()
    }

    /// One more row of the Cholesky factor.
    fn extend_factor(&mut self, row: &[f64], value: f64) {
        let mut line = forward(&self.factor, self.covariances(row));
        let explained: f64 = line.iter().map(|v| v * v).sum();
        // Twins without noise would make the matrix singular.
        let left = 1.0 + self.hyper.ln_noise.exp() - explained;
        line.push(left.max(1e-10).sqrt());
        self.factor.push(line);
        self.rows.push(row.to_vec());
        self.values.push((value - self.center) / self.scale);
    }

    fn solve(&mut self) {
        let mut x = forward(&self.factor, self.values.clone());
        for i in (0..x.len()).rev() {
            x[i] /= self.factor[i][i];
            let solved = x[i];
            let line = &self.factor[i];
            x[..i]
                .iter_mut()
                .zip(line)
                .for_each(|(x, l)| *x -= l * solved);
        }
        self.solved = x;
    }

    /// Logarithm of the marginal likelihood of standard values, times the prior.
    fn ln_evidence(&self) -> f64 {
        let n = self.values.len() as f64;
        let ln_determinant: f64 = (self.factor.iter().enumerate())
            .map(|(i, line)| 2.0 * line[i].ln())
            .sum();
        -0.5 * (n * self.variance.ln() + ln_determinant) + self.hyper.ln_prior()
    }
}

/// The best lengths and noise that a pattern search from `start` finds.
pub(crate) fn fitted(rows: &[Vec<f64>], values: &[f64], unordered: &[bool], start: Hyper) -> Hyper {
    let evidence = |hyper: &Hyper| {
        GaussianProcess::with_hyper(rows, values, unordered, hyper.clone()).ln_evidence()
    };
    let mut best = (evidence(&start), start);
    let mut step = 1.6;
    while step > 0.15 {
        let before = best.0;
        for index in 0..=unordered.len() {
            for by in [step, -step] {
                let moved = best.1.moved(index, by);
                let found = evidence(&moved);
                if found > best.0 {
                    best = (found, moved);
                    break;
                }
            }
        }
        if best.0 - before < 0.05 {
            step *= 0.5;
        }
    }
    best.1
}

fn center_and_scale(values: &[f64]) -> (f64, f64) {
    let n = values.len().max(1) as f64;
    let center = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - center).powi(2)).sum::<f64>() / n;
    let scale = variance.sqrt();
    (center, if scale > 0.0 { scale } else { 1.0 })
}

/// L^-1 x.
fn forward(factor: &[Vec<f64>], mut x: Vec<f64>) -> Vec<f64> {
    for (i, line) in factor.iter().enumerate() {
        let (before, rest) = x.split_at_mut(i);
        let known: f64 = before.iter().zip(line).map(|(x, l)| x * l).sum();
        rest[0] = (rest[0] - known) / line[i];
    }
    x
}

fn distance(a: &[f64], b: &[f64], inverse_lengths: &[f64], unordered: &[bool]) -> f64 {
    let mut square = 0.0;
    for (((x, y), inverse), unordered) in a.iter().zip(b).zip(inverse_lengths).zip(unordered) {
        let difference = match unordered {
            true => f64::from(x != y),
            false => x - y,
        };
        square += (difference * inverse).powi(2);
    }
    square.sqrt()
}

pub(crate) fn matern(distance: f64) -> f64 {
    let r = 5.0_f64.sqrt() * distance;
    (1.0 + r + r * r / 3.0) * (-r).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn predictions_are_those_of_the_definition() {
        // With two points and fixed lengths the equations can be solved by hand.
        let hyper = Hyper {
            ln_lengths: vec![0.0],
            ln_noise: 0.1_f64.ln(),
        };
        let process =
            GaussianProcess::with_hyper(&[vec![0.0], vec![1.0]], &[1.0, -1.0], &[false], hyper);
        let (k, a, b) = (matern(1.0), matern(0.25), matern(0.75));
        // (K + g I)^-1 (1, -1) = (1, -1) / (1.1 - k).
        assert!((process.predict(&[0.25]).mean - (a - b) / (1.1 - k)).abs() < 1e-12);
        let determinant = 1.1 * 1.1 - k * k;
        let explained = (1.1 * (a * a + b * b) - 2.0 * k * a * b) / determinant;
        let variance = (2.0 / (1.1 - k)) / 2.0;
        let expected = (variance * (1.0 - explained)).sqrt();
        assert!((process.predict(&[0.25]).sd - expected).abs() < 1e-12);
    }

    #[test]
    fn noise_is_told_from_shape() {
        let mut random = Random::new(3, "noise");
        let rows: Vec<Vec<f64>> = (0..120).map(|_| vec![random.unit()]).collect();
        let value = |x: &Vec<f64>, noise: f64| (6.0 * x[0]).sin() + 0.2 * noise;
        let values: Vec<f64> = rows
            .iter()
            .map(|x| value(x, random.standard_normal()))
            .collect();
        let process = GaussianProcess::fit(&rows, &values, &[false]);
        // The standard error of a deviation from 120 values is 0.2 / sqrt(240) = 0.013.
        assert!(
            (process.noise_sd() - 0.2).abs() < 0.05,
            "{}",
            process.noise_sd()
        );
        let worst = (0..=20)
            .map(|i| vec![f64::from(i) / 20.0])
            .map(|x| (process.predict(&x).mean - value(&x, 0.0)).abs())
            .fold(0.0, f64::max);
        assert!(worst < 0.2, "{worst}");
    }

    #[test]
    fn labels_have_no_order() {
        let rows: Vec<Vec<f64>> = [0.1, 0.5, 0.9].map(|x| vec![x]).to_vec();
        let process = GaussianProcess::with_hyper(
            &rows[..1],
            &[1.0],
            &[true],
            Hyper {
                ln_lengths: vec![0.0],
                ln_noise: -5.0,
            },
        );
        assert_eq!(process.predict(&rows[1]), process.predict(&rows[2]));
    }

    #[test]
    fn no_data_and_equal_data_are_no_problem() {
        let empty = GaussianProcess::fit(&[], &[], &[false]);
        assert!(empty.predict(&[0.5]).mean == 0.0 && empty.predict(&[0.5]).sd.is_finite());
        let rows = vec![vec![0.5]; 5];
        let equal = GaussianProcess::fit(&rows, &[2.0; 5], &[false]);
        assert!((equal.predict(&[0.5]).mean - 2.0).abs() < 1e-9);
    }
}
