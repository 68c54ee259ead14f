//! Probabilities a number of steps earlier, with bounds, in plain floating point.
//!
//! *Method.* `x'_i = sum_j p_ij x_j` on the active states, `k` times, for a probability and its contrary side
//! by side, rounded to nearest. Lower and upper bounds are two runs, or one if they are equal at the start.
//!
//! *Guarantee.* All terms are positive, so each step multiplies the relative error by at most `1 + e + r u`,
//! with `e` that of the transition probabilities and `r` the longest row; after `k` steps it is at most
//! `k (e + r u)` to first order, which holds as long as no value becomes so small that digits are lost. That
//! is watched: [`back`] then returns nothing, and the caller allows for rounding at each step instead.
//!
//! Source: the matrix-vector iteration of Hansson and Jonsson 1994; error bound as in [`crate::rounding`].
//!
//! Cost: steps times transitions of the active states. Ends early when nothing changes.

use crate::answer::CheckError;
use crate::engine::Context;
use crate::graph::successors;
use crate::rounding::{Bounds, SMALLEST_VALUE, UNIT};
use crate::sound::Probability;
use crate::state_space::Csr;

/// A probability and that of the contrary.
type Pair = [f64; 2];

/// The values of `states` (in which the others keep theirs) `steps` steps earlier; `None` on underflow.
pub(crate) fn back(
    matrix: &Csr<f64>,
    values: &[Probability],
    states: &[usize],
    steps: u64,
    context: &Context<'_>,
) -> Result<Option<Vec<Probability>>, CheckError> {
    let lows = values
        .iter()
        .map(|v| [v.value.low, v.complement.low])
        .collect();
    let highs: Vec<Pair> = values
        .iter()
        .map(|v| [v.value.high, v.complement.high])
        .collect();
    let same = values
        .iter()
        .all(|v| v.value.is_exact() && v.complement.is_exact());
    let Some(lows) = run(matrix, lows, states, steps, context)? else {
        return Ok(None);
    };
    let highs = match same {
        true => lows.clone(),
        false => match run(matrix, highs, states, steps, context)? {
            Some(highs) => highs,
            None => return Ok(None),
        },
    };
    let longest = states
        .iter()
        .map(|state| successors(matrix, *state).len())
        .max()
        .unwrap_or(0);
    let error = steps as f64 * (context.entry_error + longest as f64 * UNIT);
    let mut result = values.to_vec();
    for state in states {
        let [value, complement] = [0, 1].map(|part| Bounds {
            low: lows[*state][part],
            high: highs[*state][part],
        });
        result[*state] = Probability::from_sums(value, complement, error);
    }
    Ok(Some(result))
}

fn run(
    matrix: &Csr<f64>,
    mut values: Vec<Pair>,
    states: &[usize],
    steps: u64,
    context: &Context<'_>,
) -> Result<Option<Vec<Pair>>, CheckError> {
    let lost = |value: f64| value > 0.0 && value < SMALLEST_VALUE;
    let mut next = values.clone();
    for step in 0..steps {
        if step % 16 == 0 {
            context.options.check_cancelled()?;
        }
        let (mut changed, mut underflow) = (false, false);
        for state in states {
            let new = mean(matrix, *state, &values);
            changed |= new != values[*state];
            underflow |= lost(new[0]) | lost(new[1]);
            next[*state] = new;
        }
        if underflow {
            return Ok(None);
        }
        std::mem::swap(&mut values, &mut next);
        if !changed {
            break;
        }
    }
    Ok(Some(values))
}

fn mean(matrix: &Csr<f64>, state: usize, values: &[Pair]) -> Pair {
    let range = matrix.row_start[state]..matrix.row_start[state + 1];
    let mut sum = [0.0; 2];
    for (column, p) in matrix.column[range.clone()]
        .iter()
        .zip(&matrix.value[range])
    {
        let target = values[*column as usize];
        sum[0] += p * target[0];
        sum[1] += p * target[1];
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::Options;

    /// From each state to the next with probability `p`, else to the failure state at the end.
    fn line(states: usize, p: f64) -> Csr<f64> {
        let mut rows: Vec<Vec<(u32, f64)>> = (0..states - 2)
            .map(|state| vec![(state as u32 + 1, p), (states as u32 - 1, 1.0 - p)])
            .collect();
        rows.push(vec![(states as u32 - 2, 1.0)]);
        rows.push(vec![(states as u32 - 1, 1.0)]);
        Csr::from_rows(rows)
    }

    fn start(states: usize) -> Vec<Probability> {
        (0..states)
            .map(|state| Probability::indicator(state == states - 2))
            .collect()
    }

    #[test]
    fn bounds_contain_the_power_and_zeros_stay_exact() {
        let options = Options::default();
        let context = Context::new(&options, 0.0);
        let active: Vec<usize> = (0..20).collect();
        let values = back(&line(22, 0.5), &start(22), &active, 20, &context)
            .unwrap()
            .unwrap();
        assert!(values[0].value.contains(0.5f64.powi(20)) && values[0].value.low > 0.0);
        assert!(values[0].value.relative_width() < 1e-13);
        let fewer = back(&line(22, 0.5), &start(22), &active, 19, &context)
            .unwrap()
            .unwrap();
        assert_eq!(fewer[0], Probability::indicator(false));
    }

    #[test]
    fn underflow_is_noticed() {
        let options = Options::default();
        let context = Context::new(&options, 0.0);
        let active: Vec<usize> = (0..20).collect();
        let result = back(&line(22, 1e-20), &start(22), &active, 20, &context).unwrap();
        assert_eq!(result, None);
    }
}
