//! A correlated beta process: each outcome counts in part for contexts nearby.
//!
//! ```text
//! r(x) ~ Beta(s p(x) + sum_i k(x, x_i) y_i,  s (1 - p(x)) + sum_i k(x, x_i) (1 - y_i))
//! ```
//!
//! Source: R. Goetschalckx, P. Poupart and J. Hoey (2011). Deviations: the kernel is Matern 5/2;
//! its lengths maximise the probability of each outcome given all others (leave one out), one
//! coordinate after the other over a few values. Guarantee: estimated.

use crate::search::gaussian_process::matern;

/// Each coordinate's length before any data.
pub(super) const START_LENGTH: f64 = 0.4;

const LENGTHS: [f64; 4] = [0.15, 0.4, 1.2, 8.0];

/// How many episodes the prediction counts for.
const PRIOR_WEIGHT: f64 = 2.0;

/// How many episodes agreement counts for where regions are cut.
const LOCAL_PRIOR_WEIGHT: f64 = 0.3;

/// Lengths where regions are cut, at most.
pub(super) const LOCAL_LENGTH: f64 = 0.15;

/// A beta distribution of a rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Beta {
    a: f64,
    b: f64,
}

impl Beta {
    pub(super) fn mean(self) -> f64 {
        self.a / (self.a + self.b)
    }

    pub(super) fn sd(self) -> f64 {
        let sum = self.a + self.b;
        (self.a * self.b / (sum * sum * (sum + 1.0))).sqrt()
    }
}

/// Outcomes with their places, and how far each of them reaches.
#[derive(Debug, Clone)]
pub(super) struct Surrogate {
    lengths: Vec<f64>,
    unordered: Vec<bool>,
    rows: Vec<Vec<f64>>,
    outcomes: Vec<f64>,
    predicted: Vec<f64>,
}

impl Surrogate {
    pub(super) fn new(lengths: Vec<f64>, unordered: Vec<bool>) -> Self {
        Self {
            lengths,
            unordered,
            rows: Vec::new(),
            outcomes: Vec::new(),
            predicted: Vec::new(),
        }
    }

    /// Adds an outcome: 1 success, 0 failure, or between them what is expected of an episode that
    /// still runs.
    pub(super) fn push(&mut self, row: &[f64], outcome: f64, predicted: f64) {
        self.rows.push(row.to_vec());
        self.outcomes.push(outcome);
        self.predicted.push(predicted);
    }

    pub(super) fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// The distance of two rows in lengths.
    pub(super) fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let mut square = 0.0;
        for (index, length) in self.lengths.iter().enumerate() {
            let difference = match self.unordered[index] {
                true => f64::from(u8::from(a[index] != b[index])),
                false => a[index] - b[index],
            };
            square += (difference / length).powi(2);
        }
        square.sqrt()
    }

    /// What is thought of the rate at a row whose predicted rate is given.
    pub(super) fn at(&self, row: &[f64], predicted: f64) -> Beta {
        self.without(usize::MAX, row, predicted)
    }

    /// The same without one of the outcomes.
    fn without(&self, left_out: usize, row: &[f64], predicted: f64) -> Beta {
        let prior = predicted.clamp(0.001, 0.999);
        let (mut a, mut b) = (PRIOR_WEIGHT * prior, PRIOR_WEIGHT * (1.0 - prior));
        for (index, (other, outcome)) in self.rows.iter().zip(&self.outcomes).enumerate() {
            if index != left_out {
                let weight = matern(self.distance(row, other));
                a += weight * outcome;
                b += weight * (1.0 - outcome);
            }
        }
        Beta { a, b }
    }

    /// The difference that is expected at a row from outcomes nearby alone, however many there are
    /// elsewhere:
    ///
    /// ```text
    /// sum_i w_i (y_i - p_i) / (sum_i w_i + 0.3),   w_i = k(x, x_i)^2 with lengths of at most 0.15
    /// ```
    ///
    /// The process itself adds up weights, so that many outcomes in one corner reach far.
    pub(super) fn local_difference(&self, row: &[f64]) -> f64 {
        let (mut sum, mut weights) = (0.0, LOCAL_PRIOR_WEIGHT);
        for (index, other) in self.rows.iter().enumerate() {
            let weight = matern(self.distance(row, other)).powi(2);
            sum += weight * (self.outcomes[index] - self.predicted[index]);
            weights += weight;
        }
        sum / weights
    }

    /// The same process with lengths of at most so much.
    pub(super) fn with_lengths_up_to(mut self, longest: f64) -> Self {
        for length in &mut self.lengths {
            *length = length.min(longest);
        }
        self
    }

    /// Chooses each coordinate's length in turn, twice.
    pub(super) fn fit_lengths(&mut self) {
        let mut best = self.ln_probability();
        for index in (0..self.lengths.len()).chain(0..self.lengths.len()) {
            for length in LENGTHS {
                let before = std::mem::replace(&mut self.lengths[index], length);
                let found = self.ln_probability();
                if found > best + 1e-9 {
                    best = found;
                } else {
                    self.lengths[index] = before;
                }
            }
        }
    }

    /// Logarithm of the product of each outcome's probability given all others.
    fn ln_probability(&self) -> f64 {
        let one = |index: usize| {
            let mean = self
                .without(index, &self.rows[index], self.predicted[index])
                .mean();
            let outcome = self.outcomes[index];
            outcome * mean.ln() + (1.0 - outcome) * (1.0 - mean).ln()
        };
        (0..self.rows.len()).map(one).sum()
    }
}
