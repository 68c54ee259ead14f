//! The optimum as PRISM estimates it by default: iteration from 0 that stops when little changes.
//!
//! As [`crate::prism_default`] where there are no alternatives (method Jacobi: self-loops are divided out), else
//! value iteration: `x'_i = opt over c of r_c + sum p_cj x_j`, self-loops included. Stops when no value changes
//! by more than epsilon ([`crate::Termination`]). Deviation: end components have been collapsed before. Guarantee: none.
//! Cost: iterations times entries.

use super::{Problem, Solution};
use crate::answer::{CheckError, Options};
use crate::graph::NO_ROW;

/// Solves the problem.
pub(crate) fn solve(
    problem: &Problem<f64, f64>,
    options: &Options<'_>,
) -> Result<Solution<f64>, CheckError> {
    let mut x: Vec<f64> = problem.fixed.iter().map(|f| f.unwrap_or(0.0)).collect();
    let open: Vec<usize> = (0..x.len())
        .filter(|s| problem.fixed[*s].is_none())
        .collect();
    let mut choice = vec![NO_ROW; x.len()];
    if open.is_empty() {
        return Ok(Solution {
            values: x,
            choice,
            iterations: 0,
        });
    }
    let is_chain = open
        .iter()
        .all(|s| problem.choice_start[s + 1] - problem.choice_start[*s] == 1);
    let mut next = x.clone();
    for iteration in 1..=options.max_iters {
        if iteration % 64 == 0 {
            options.check_cancelled()?;
        }
        let mut change = 0f64;
        for state in &open {
            let (row, new) = best(problem, *state, &x, is_chain);
            if !new.is_finite() {
                return Err(CheckError::NotFinite { state: *state });
            }
            change = change.max(options.termination.change(x[*state], new));
            (choice[*state], next[*state]) = (row, new);
        }
        std::mem::swap(&mut x, &mut next);
        if change < options.epsilon {
            return Ok(Solution {
                values: x,
                choice,
                iterations: iteration,
            });
        }
    }
    Err(CheckError::NotConverged {
        iterations: options.max_iters,
        epsilon: options.epsilon,
    })
}

fn best(problem: &Problem<f64, f64>, state: usize, x: &[f64], is_chain: bool) -> (usize, f64) {
    let mut best = (NO_ROW, f64::NAN);
    for row in problem.choice_start[state]..problem.choice_start[state + 1] {
        let mut sum = problem.reward.get(row).copied().unwrap_or(0.0);
        let mut total = 0.0;
        for (target, p) in problem.matrix.row(row) {
            sum += p * x[target];
            total += p;
        }
        let value = match is_chain {
            true => sum / total,
            false => sum + (1.0 - total).max(0.0) * x[state],
        };
        if best.0 == NO_ROW || (value != best.1 && (value > best.1) == problem.maximise) {
            best = (row, value);
        }
    }
    best
}
