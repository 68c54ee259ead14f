//! Numbers `x` for the bounds of a gain ([`super`]), where rounds in place are slow: by linear equations.
//!
//! *Problem.* In a component without alternatives, `x` and `g` with `r_i + sum_j q_ij (x_j - x_i) = g` for all `i`,
//! and `x_z = 0` for one state `z`; from some `x` and `g` on, by what is left: with `B` the equations of the states
//! other than `z` and the residual `s_i = r_i + sum_j q_ij (x_j - x_i) - g`
//!
//! ```text
//! B u = s,   B t = 1,   x += u - d t,   g += d      d such that the equation of z holds
//! ```
//!
//! (`t` is the expected time until `z`). Repeated, each time with a new residual, so that `u` and `t` may be rough.
//!
//! *Method.* `B` is a nonsingular M-matrix: stabilised biconjugate gradients (van der Vorst 1992), preconditioned on the
//! right by an incomplete factorisation without fill-in (Meijerink and van der Vorst 1977: it exists for M-matrices),
//! kept in single precision. Cost: rounds times entries; 4 bytes for each entry, some vectors.
//!
//! Guarantee: none is needed, for bounds hold for any `x`; where the equations are not solved, nothing is lost but time.

use super::iteration::Iteration;
use crate::answer::CheckError;
use crate::engine::Context;

/// Rounds of one solution.
const ROUNDS: usize = 2_000;
/// How far a solution brings the residual down, at least.
const REDUCTION: f64 = 1e-5;

/// The equations of all states but one, and their incomplete factors.
pub(super) struct Equations<'a> {
    chain: &'a Iteration<'a>,
    /// `z`.
    without: usize,
    leaving: Vec<f64>,
    /// Of each entry: below the diagonal that of the lower factor, above that of the upper one.
    factor: Vec<f32>,
    /// One over the diagonal of the upper factor; 0 for `z`.
    inverse: Vec<f64>,
    time: Option<Vec<f64>>,
}

impl<'a> Equations<'a> {
    pub fn new(chain: &'a Iteration<'a>, without: usize) -> Self {
        let states = chain.num_states();
        let rates = |state: usize| chain.entries(state).1.iter().sum();
        let mut equations = Self {
            chain,
            without,
            leaving: (0..states).map(rates).collect(),
            factor: vec![0.0; chain.num_entries()],
            inverse: vec![0.0; states],
            time: None,
        };
        equations.factorise();
        equations
    }

    fn factorise(&mut self) {
        let states = self.leaving.len();
        // Where an entry of the row at hand is; 0 for none.
        let mut place = vec![0_u32; states];
        let mut row: Vec<f64> = Vec::new();
        for state in (0..states).filter(|state| *state != self.without) {
            let range = self.chain.range(state);
            let (columns, rates) = self.chain.entries(state);
            row.clear();
            row.extend(rates.iter().map(|rate| -rate));
            for (at, column) in columns.iter().enumerate() {
                place[*column as usize] = at as u32 + 1;
            }
            let mut diagonal = self.leaving[state];
            for (at, column) in columns.iter().enumerate() {
                let above = *column as usize;
                if above >= state || above == self.without {
                    continue;
                }
                let share = row[at] * self.inverse[above];
                row[at] = share;
                let of_above = self.chain.range(above);
                let targets = self.chain.entries(above).0;
                for (target, value) in targets.iter().zip(&self.factor[of_above]) {
                    let target = *target as usize;
                    if target == state {
                        diagonal -= share * f64::from(*value);
                    } else if target > above && place[target] > 0 {
                        row[place[target] as usize - 1] -= share * f64::from(*value);
                    }
                }
            }
            for (at, column) in columns.iter().enumerate() {
                place[*column as usize] = 0;
                if *column as usize == self.without {
                    row[at] = 0.0;
                }
            }
            for (factor, value) in self.factor[range].iter_mut().zip(&row) {
                *factor = *value as f32;
            }
            // Rounding may leave nothing of a pivot that is positive.
            let pivot = match diagonal > 1e-12 * self.leaving[state] {
                true => diagonal,
                false => self.leaving[state],
            };
            self.inverse[state] = 1.0 / pivot;
        }
    }

    /// `B v`; `v` must be 0 at `z`, and the result is.
    fn apply(&self, v: &[f64], result: &mut [f64]) {
        for (state, result) in result.iter_mut().enumerate() {
            let (columns, rates) = self.chain.entries(state);
            let pairs = columns.iter().zip(rates);
            let moved: f64 = pairs.map(|(column, rate)| rate * v[*column as usize]).sum();
            *result = self.leaving[state] * v[state] - moved;
        }
        result[self.without] = 0.0;
    }

    /// What the incomplete factors have for `B^-1 v`.
    fn precondition(&self, v: &[f64], result: &mut [f64]) {
        let states = v.len();
        for state in 0..states {
            let (columns, _) = self.chain.entries(state);
            let mut value = v[state];
            for (column, factor) in columns.iter().zip(&self.factor[self.chain.range(state)]) {
                if (*column as usize) < state {
                    value -= f64::from(*factor) * result[*column as usize];
                }
            }
            result[state] = value;
        }
        for state in (0..states).rev() {
            let (columns, _) = self.chain.entries(state);
            let mut value = result[state];
            for (column, factor) in columns.iter().zip(&self.factor[self.chain.range(state)]) {
                if (*column as usize) > state {
                    value -= f64::from(*factor) * result[*column as usize];
                }
            }
            result[state] = value * self.inverse[state];
        }
    }

    /// A rough solution of `B y = b`; `None` if the residual did not come down.
    fn solve(&self, b: &[f64], context: &Context<'_>) -> Result<Option<Vec<f64>>, CheckError> {
        let states = b.len();
        let mut y = vec![0.0; states];
        let goal = REDUCTION * norm(b);
        if goal == 0.0 {
            return Ok(Some(y));
        }
        let mut residual = b.to_vec();
        let shadow = b.to_vec();
        let (mut direction, mut image) = (vec![0.0; states], vec![0.0; states]);
        let (mut near, mut second) = (vec![0.0; states], vec![0.0; states]);
        let (mut rho, mut alpha, mut omega) = (1.0, 1.0, 1.0);
        for round in 0..ROUNDS {
            if round % 16 == 0 {
                context.options.check_cancelled()?;
            }
            let next = dot(&shadow, &residual);
            let beta = next / rho * (alpha / omega);
            rho = next;
            for ((direction, residual), image) in direction.iter_mut().zip(&residual).zip(&image) {
                *direction = residual + beta * (*direction - omega * image);
            }
            self.precondition(&direction, &mut near);
            self.apply(&near, &mut image);
            alpha = rho / dot(&shadow, &image);
            add(&mut y, alpha, &near);
            add(&mut residual, -alpha, &image);
            if norm(&residual) <= goal {
                return Ok(Some(y));
            }
            self.precondition(&residual, &mut near);
            self.apply(&near, &mut second);
            omega = dot(&second, &residual) / dot(&second, &second);
            add(&mut y, omega, &near);
            add(&mut residual, -omega, &second);
            let left = norm(&residual);
            if left <= goal {
                return Ok(Some(y));
            }
            // Also when it is not a number.
            if !(left < 1e20 * norm(b) && rho != 0.0 && omega != 0.0) {
                return Ok(None);
            }
        }
        Ok(None)
    }

    /// Improves `x`, and the gain that it is meant for; false if that failed.
    pub fn improve(
        &mut self,
        x: &mut [f64],
        gain: &mut f64,
        rewards: impl Fn(usize) -> f64,
        context: &Context<'_>,
    ) -> Result<bool, CheckError> {
        let states = x.len();
        let without = self.without;
        let reference = x[without];
        x.iter_mut().for_each(|x| *x -= reference);
        let time = match self.time.take() {
            Some(time) => time,
            None => {
                let mut one = vec![1.0; states];
                one[without] = 0.0;
                match self.solve(&one, context)? {
                    Some(time) => time,
                    None => return Ok(false),
                }
            }
        };
        let mut residual = vec![0.0; states];
        self.apply(x, &mut residual);
        for (state, residual) in residual.iter_mut().enumerate() {
            *residual = rewards(state) - *gain - *residual;
        }
        residual[without] = 0.0;
        let Some(correction) = self.solve(&residual, context)? else {
            return Ok(false);
        };
        add(x, 1.0, &correction);
        let (columns, rates) = self.chain.entries(without);
        let onwards = |v: &[f64]| -> f64 {
            let pairs = columns.iter().zip(rates);
            pairs.map(|(column, rate)| rate * v[*column as usize]).sum()
        };
        let change = (rewards(without) + onwards(x) - *gain) / (1.0 + onwards(&time));
        add(x, -change, &time);
        *gain += change;
        self.time = Some(time);
        Ok(gain.is_finite())
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `a += factor * b`
fn add(a: &mut [f64], factor: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += factor * b);
}

/// The greatest absolute value; not a number if one is not.
fn norm(v: &[f64]) -> f64 {
    v.iter()
        .fold(0.0, |norm: f64, v| match v.is_nan() || norm.is_nan() {
            true => f64::NAN,
            false => norm.max(v.abs()),
        })
}
