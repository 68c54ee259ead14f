//! The rate of one way to fail over the parameters: a Bayesian logistic regression.
//!
//! Definition. `logit p(x) = w . f(x)`, `x` the parameters mapped to [-1, 1] by the prior's
//! distribution function, `f` all monomials up to degree 2; the intercept has a normal prior of
//! deviation 5, the linear weights of deviation 3, those of degree 2 of deviation 1.5 (a rate that
//! bends more than that by itself is rare, and what was seldom seen would else be held possible
//! wherever there were few episodes). The posterior of `w` is taken as normal around its mode
//! with the inverse Hessian there (Laplace).
//!
//! Source: MacKay (1992), see the module above; Newton's method with step halving. Deviation: none.
//! Cost: O(episodes features^2) an iteration, some ten iterations. Guarantee: the mode is unique,
//! the objective being strictly concave; found to 1e-9 of its scale.

use crate::random::Random;

/// Prior deviation of the intercept, of the linear weights and of those of degree 2, in logits.
const INTERCEPT_DEVIATION: f64 = 5.0;
const SLOPE_DEVIATION: f64 = 3.0;
const CURVATURE_DEVIATION: f64 = 1.5;

/// Newton steps at most; a handful suffice.
const MOST_STEPS: usize = 100;

/// Groups of episodes in the test of fit.
const GROUPS: usize = 8;

/// A fitted response surface.
#[derive(Debug, Clone)]
pub struct Surface {
    weights: Vec<f64>,
    /// The lower Cholesky factor of the Hessian (the precision of the weights).
    factor: Vec<Vec<f64>>,
}

/// How well a surface describes the episodes it was fitted to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceFit {
    /// Episodes in which the way to fail had an opportunity.
    pub opportunities: u64,
    /// In how many of them it occurred.
    pub occurrences: u64,
    /// Probability of deviations as large as those seen if the surface is right: the test of D. W.
    /// Hosmer and S. Lemeshow (1980) over groups of equal expected counts. `None` with too few
    /// occurrences to test.
    pub p_value: Option<f64>,
}

/// All monomials up to degree 2 of coordinates in (0, 1), mapped to (-1, 1).
pub(super) fn features(unit: &[f64]) -> Vec<f64> {
    let x: Vec<f64> = unit.iter().map(|u| 2.0 * u - 1.0).collect();
    let mut row = vec![1.0];
    row.extend(&x);
    for i in 0..x.len() {
        row.extend((i..x.len()).map(|j| x[i] * x[j]));
    }
    row
}

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// The prior precision of the weight at `index` of `size`.
fn precision(index: usize, size: usize) -> f64 {
    let deviation = match index {
        0 => INTERCEPT_DEVIATION,
        _ if index <= dimensions(size) => SLOPE_DEVIATION,
        _ => CURVATURE_DEVIATION,
    };
    1.0 / (deviation * deviation)
}

/// How many parameters give `size` monomials up to degree 2.
fn dimensions(size: usize) -> usize {
    (0..size)
        .find(|d| (d + 1) * (d + 2) / 2 >= size)
        .unwrap_or(0)
}

impl Surface {
    /// Fits outcomes (occurred or not) at points of the unit cube of `dimensions`.
    #[must_use]
    pub fn fit(dimensions: usize, outcomes: &[(&[f64], bool)]) -> Self {
        let rows: Vec<(Vec<f64>, f64)> = (outcomes.iter())
            .map(|(unit, occurred)| (features(unit), f64::from(u8::from(*occurred))))
            .collect();
        let size = features(&vec![0.5; dimensions]).len();
        let mut weights = vec![0.0; size];
        let mut value = objective(&rows, &weights);
        let mut factor = cholesky(hessian(&rows, &weights));
        for _ in 0..MOST_STEPS {
            let step = solve(&factor, gradient(&rows, &weights));
            let mut length = 1.0;
            let mut next = moved(&weights, &step, length);
            let mut next_value = objective(&rows, &next);
            while next_value < value && length > 1e-9 {
                length /= 2.0;
                next = moved(&weights, &step, length);
                next_value = objective(&rows, &next);
            }
            let gain = next_value - value;
            (weights, value) = (next, next_value);
            factor = cholesky(hessian(&rows, &weights));
            if gain.abs() <= 1e-9 * (1.0 + value.abs()) {
                break;
            }
        }
        Self { weights, factor }
    }

    /// The rate at a point of the unit cube, by the most probable weights.
    #[must_use]
    pub fn rate(&self, unit: &[f64]) -> f64 {
        logistic(dot(&self.weights, &features(unit)))
    }

    /// Weights drawn from their posterior.
    pub(super) fn draw(&self, random: &mut Random) -> Vec<f64> {
        let noise: Vec<f64> = (self.weights.iter())
            .map(|_| random.standard_normal())
            .collect();
        let step = backward(&self.factor, noise);
        moved(&self.weights, &step, 1.0)
    }

    /// Tests the surface against the outcomes it was fitted to.
    #[must_use]
    pub fn fit_test(&self, outcomes: &[(&[f64], bool)]) -> SurfaceFit {
        let mut rated: Vec<(f64, bool)> = (outcomes.iter())
            .map(|(unit, occurred)| (self.rate(unit), *occurred))
            .collect();
        rated.sort_by(|a, b| a.0.total_cmp(&b.0));
        let occurrences = rated.iter().filter(|(_, occurred)| *occurred).count();
        SurfaceFit {
            opportunities: rated.len() as u64,
            occurrences: occurrences as u64,
            p_value: hosmer_lemeshow(&rated),
        }
    }
}

pub(super) fn rate_with(weights: &[f64], features: &[f64]) -> f64 {
    logistic(dot(weights, features))
}

/// Groups of equal expected counts; each contributes its squared standard deviation.
fn hosmer_lemeshow(rated: &[(f64, bool)]) -> Option<f64> {
    let expected: f64 = rated.iter().map(|(rate, _)| rate).sum();
    let groups = GROUPS.min((expected / 5.0) as usize);
    if groups < 4 {
        return None;
    }
    let mut statistic = 0.0;
    let (mut counted, mut mean, mut variance, mut done) = (0.0, 0.0, 0.0, 0.0);
    let mut closed = 0;
    for (rate, occurred) in rated {
        counted += f64::from(u8::from(*occurred));
        mean += rate;
        variance += rate * (1.0 - rate);
        done += rate;
        if done >= expected * (closed + 1) as f64 / groups as f64 - 1e-9 {
            statistic += (counted - mean).powi(2) / variance.max(f64::MIN_POSITIVE);
            (counted, mean, variance) = (0.0, 0.0, 0.0);
            closed += 1;
        }
    }
    (closed > 2).then(|| stats::special::chi_squared_sf(statistic, (closed - 2) as f64))
}

fn objective(rows: &[(Vec<f64>, f64)], weights: &[f64]) -> f64 {
    let likelihood = rows.iter().map(|(row, y)| {
        let x = dot(row, weights);
        // ln(1 + e^x) without overflow.
        y * x - (x.max(0.0) + (-x.abs()).exp().ln_1p())
    });
    let prior = weights
        .iter()
        .enumerate()
        .map(|(i, w)| precision(i, weights.len()) * w * w);
    likelihood.sum::<f64>() - 0.5 * prior.sum::<f64>()
}

fn gradient(rows: &[(Vec<f64>, f64)], weights: &[f64]) -> Vec<f64> {
    let prior = weights.iter().enumerate();
    let mut sum: Vec<f64> = prior
        .map(|(i, w)| -precision(i, weights.len()) * w)
        .collect();
    for (row, y) in rows {
        let rest = y - logistic(dot(row, weights));
        sum.iter_mut().zip(row).for_each(|(s, f)| *s += rest * f);
    }
    sum
}

/// Minus the objective's second derivatives.
fn hessian(rows: &[(Vec<f64>, f64)], weights: &[f64]) -> Vec<Vec<f64>> {
    let size = weights.len();
    let mut sum = vec![vec![0.0; size]; size];
    for (row, _) in rows {
        let rate = logistic(dot(row, weights));
        let weight = rate * (1.0 - rate);
        for i in 0..size {
            let scaled = weight * row[i];
            sum[i][..=i]
                .iter_mut()
                .zip(row)
                .for_each(|(s, f)| *s += scaled * f);
        }
    }
    for (i, row) in sum.iter_mut().enumerate() {
        row[i] += precision(i, size);
    }
    sum
}

/// The lower factor `L` of `L L^T`, from the lower triangle; the matrix is positive definite
/// because of the prior.
fn cholesky(mut a: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    for i in 0..a.len() {
        for j in 0..=i {
            let (above, row) = a.split_at_mut(i);
            let other = if j < i { &above[j][..j] } else { &[][..] };
            let sum = match j < i {
                true => dot(&row[0][..j], other),
                false => row[0][..i].iter().map(|x| x * x).sum(),
            };
            let rest = row[0][j] - sum;
            row[0][j] = match j < i {
                true => rest / above[j][j],
                false => rest.max(f64::MIN_POSITIVE).sqrt(),
            };
        }
    }
    a
}

/// `L^-T x`.
fn backward(factor: &[Vec<f64>], mut x: Vec<f64>) -> Vec<f64> {
    for i in (0..x.len()).rev() {
        x[i] /= factor[i][i];
        let solved = x[i];
        x[..i]
            .iter_mut()
            .zip(&factor[i])
            .for_each(|(x, l)| *x -= l * solved);
    }
    x
}

/// `(L L^T)^-1 x`.
fn solve(factor: &[Vec<f64>], mut x: Vec<f64>) -> Vec<f64> {
    for i in 0..x.len() {
        let known = dot(&factor[i][..i], &x[..i]);
        x[i] = (x[i] - known) / factor[i][i];
    }
    backward(factor, x)
}

fn moved(from: &[f64], step: &[f64], length: f64) -> Vec<f64> {
    from.iter().zip(step).map(|(x, s)| x + length * s).collect()
}
