//! Numbers `x` for the bounds of a gain ([`super`]), where rounds in place are slow: by linear equations.
//!
//! *Problem.* In a component without alternatives, `x` and `g` with `r_i + sum_j q_ij (x_j - x_i) = g` for all `i`,
//! and `x_z = 0` for one state `z`: one equation for each state, in which the unknown `g` takes the place of `x_z`. With
//! `B` the equations of the states other than `z` and `c_j = q_zj`
//!
//! ```text
//! M = |  B   1 |      unknowns (x, g), right-hand side r
//!     | -c   1 |
//! ```
//!
//! The residual is `d_i - g` of [`super`], so the bounds of the gain are as close as it is small.
//!
//! *Method.* [`crate::krylov`], with the incomplete factors `LU` of `B` and, for the last row and column, block elimination by
//! `t = (LU)^-1 1`, an approximation of the expected times until `z`: `g = (v_z + c u) / (1 + c t)` and `x = u - g t` with
//! `u = (LU)^-1 v`. `1 + c t` tends to one over the share of time in `z`, so that a `z` in which the chain often is makes
//! the equations easier.
//!
//! Guarantee: none is needed, for bounds hold for any `x`; where the equations are not solved, nothing is lost but time.

use super::iteration::Iteration;
use crate::answer::CheckError;
use crate::engine::Context;
use crate::krylov::{Factors, Operator, correct};

/// Rounds of one solution.
const ROUNDS: usize = 4_000;

/// The equations, and their incomplete factors.
pub(super) struct Equations<'a> {
    chain: &'a Iteration<'a>,
    /// `z`.
    without: usize,
    leaving: Vec<f64>,
    factors: Factors,
    /// `t`, and `1 + c t`.
    time: Vec<f64>,
    scale: f64,
}

impl<'a> Equations<'a> {
    pub fn new(chain: &'a Iteration<'a>, without: usize) -> Self {
        let states = chain.num_states();
        let rates = |state: usize| chain.entries(state).1.iter().sum();
        let leaving: Vec<f64> = (0..states).map(rates).collect();
        let factors = Factors::new(&leaving, |state| chain.entries(state), Some(without));
        let mut one = vec![1.0; states];
        one[without] = 0.0;
        let mut time = vec![0.0; states];
        factors.solve(&one, &mut time);
        let mut equations = Self {
            chain,
            without,
            leaving,
            factors,
            time,
            scale: 1.0,
        };
        equations.scale = 1.0 + equations.onwards(&equations.time);
        equations
    }

    /// `c v`; `v` must be 0 at `z`.
    fn onwards(&self, v: &[f64]) -> f64 {
        let (columns, rates) = self.chain.entries(self.without);
        let pairs = columns.iter().zip(rates);
        pairs.map(|(column, rate)| rate * v[*column as usize]).sum()
    }

    /// Improves `x` until `d` is within this share of `gain` in all states, if it can; the rounds.
    pub fn improve(
        &self,
        x: &mut [f64],
        gain: &mut f64,
        rewards: impl Fn(usize) -> f64,
        share: f64,
        context: &Context<'_>,
    ) -> Result<usize, CheckError> {
        let reference = x[self.without];
        x.iter_mut().for_each(|x| *x -= reference);
        x[self.without] = *gain;
        let mut residual = vec![0.0; x.len()];
        self.apply(x, &mut residual);
        for (state, residual) in residual.iter_mut().enumerate() {
            *residual = rewards(state) - *residual;
        }
        let goal = |x: &[f64]| share * x[self.without].abs();
        let (_, rounds) = correct(self, x, &mut residual, goal, ROUNDS, context.options)?;
        *gain = std::mem::take(&mut x[self.without]);
        Ok(rounds)
    }
}

impl Operator for Equations<'_> {
    fn apply(&self, v: &mut [f64], result: &mut [f64]) {
        let gain = std::mem::take(&mut v[self.without]);
        for (state, result) in result.iter_mut().enumerate() {
            let (columns, rates) = self.chain.entries(state);
            let mut value = self.leaving[state] * v[state] + gain;
            for (column, rate) in columns.iter().zip(rates) {
                value -= rate * v[*column as usize];
            }
            *result = value;
        }
        v[self.without] = gain;
    }

    fn precondition(&self, v: &[f64], result: &mut [f64]) {
        self.factors.solve(v, result);
        // The factors are the identity at `z`.
        result[self.without] = 0.0;
        let gain = (v[self.without] + self.onwards(result)) / self.scale;
        for (result, time) in result.iter_mut().zip(&self.time) {
            *result -= gain * time;
        }
        result[self.without] = gain;
    }
}
