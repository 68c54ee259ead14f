//! The shares of time of an irreducible chain by the classical iterations, which stop when little changes.
//!
//! *Definition.* The shares `y`, which sum to 1, balance what comes and goes: `y_j s_j = sum_{i != j} y_i q_ij` for all `j`,
//! with the rates (or probabilities) `q` and `s_j = sum_{k != j} q_jk`. From equal shares,
//!
//! ```text
//! value iteration   y'_j = y_j + (sum_{i != j} y_i q_ij - y_j s_j) 0.99 / max s      (the power method)
//! Jacobi            y'_j = (sum_{i != j} y_i q_ij) / s_j
//! Gauss-Seidel      the same, each new share used at once; forwards and backwards in turn
//! ```
//!
//! and after each round divided by their sum, until no share changes by more than epsilon. Modified policy iteration
//! has no scheduler to follow here and is value iteration.
//!
//! Source: Stewart 1994, "Introduction to the Numerical Solution of Markov Chains", chapter 3. Jacobi iteration need not
//! converge (it does not where the chain is periodic); then that is said. Guarantee: none. Cost: rounds times entries.

use crate::answer::{CheckError, Options};
use crate::graph::EndComponent;
use crate::method::Method;
use crate::state_space::Csr;

/// Less than 1, so that periodic chains do not go round for ever.
const PACE: f64 = 0.99;
/// Entries that are looked at between two looks at whether to stop.
const LOOK: usize = 1 << 22;

/// What comes into each state of a component, by position.
pub(super) struct Flows {
    /// The entries of each position.
    start: Vec<usize>,
    /// Where each comes from.
    source: Vec<u32>,
    rate: Vec<f64>,
    /// The rate of leaving each position.
    leaving: Vec<f64>,
}

impl Flows {
    /// Those of a component without alternatives; `local` gives the position of each of its states.
    pub fn new(matrix: &Csr<f64>, component: &EndComponent, local: &[u32]) -> Self {
        let states = component.states.len();
        let mut start = vec![0; states + 1];
        let others = |place: usize| {
            let row = matrix.row(component.rows[place]);
            row.map(|(target, rate)| (local[target] as usize, *rate))
                .filter(move |(to, _)| *to != place)
        };
        let mut leaving = vec![0.0; states];
        for (place, leaving) in leaving.iter_mut().enumerate() {
            for (to, rate) in others(place) {
                start[to + 1] += 1;
                *leaving += rate;
            }
        }
        for place in 0..states {
            start[place + 1] += start[place];
        }
        let mut next = start.clone();
        let mut source = vec![0; start[states]];
        let mut rates = vec![0.0; start[states]];
        for place in 0..states {
            for (to, rate) in others(place) {
                source[next[to]] = place as u32;
                rates[next[to]] = rate;
                next[to] += 1;
            }
        }
        Self {
            start,
            source,
            rate: rates,
            leaving,
        }
    }

    /// The share of each position, and the rounds.
    pub fn shares(&self, options: &Options<'_>) -> Result<(Vec<f64>, u64), CheckError> {
        let states = self.leaving.len();
        let mut shares = vec![1.0 / states as f64; states];
        if states == 1 {
            return Ok((shares, 0));
        }
        let fastest = self.leaving.iter().copied().fold(0.0, f64::max);
        let mut before = shares.clone();
        let every = (LOOK / (self.source.len() + states)).max(1) as u64;
        for round in 0..options.max_iters {
            if round % every == 0 {
                options.check_cancelled()?;
            }
            for place in 0..states {
                let place = match round % 2 {
                    1 if options.method == Method::GaussSeidel => states - 1 - place,
                    _ => place,
                };
                shares[place] = match options.method {
                    Method::GaussSeidel => self.into(place, &shares) / self.leaving[place],
                    Method::Jacobi => self.into(place, &before) / self.leaving[place],
                    _ => {
                        let gained = self.into(place, &before);
                        let kept = before[place] * (1.0 - PACE * self.leaving[place] / fastest);
                        kept + gained * PACE / fastest
                    }
                };
            }
            let sum: f64 = shares.iter().sum();
            let mut change = 0f64;
            for (place, (share, before)) in shares.iter_mut().zip(&mut before).enumerate() {
                *share /= sum;
                if !share.is_finite() {
                    return Err(CheckError::NotFinite { state: place });
                }
                change = change.max(options.termination.change(*before, *share));
                *before = *share;
            }
            if change < options.epsilon {
                return Ok((shares, round + 1));
            }
        }
        Err(CheckError::NotConverged {
            iterations: options.max_iters,
            epsilon: options.epsilon,
        })
    }

    fn into(&self, place: usize, shares: &[f64]) -> f64 {
        let range = self.start[place]..self.start[place + 1];
        let entries = self.source[range.clone()].iter().zip(&self.rate[range]);
        entries
            .map(|(source, rate)| shares[*source as usize] * rate)
            .sum()
    }
}
