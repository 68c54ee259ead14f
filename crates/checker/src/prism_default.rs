//! Reachability as PRISM computes it by default: Jacobi iteration that stops when little changes.
//!
//! On the states that are neither sure nor impossible, starting from the target's indicator,
//!
//! ```text
//! x'_i = (b_i + sum_{j != i} p_ij x_j) / (1 - p_ii),      stop when  max_i |x'_i - x_i| / x'_i < epsilon
//! ```
//!
//! (or `max_i |x'_i - x_i| < epsilon`, if [`crate::Termination::Absolute`] is asked for).
//!
//! Source: the PRISM manual (Kwiatkowska, Norman and Parker 2011), "Solution methods and options", read for
//! its default settings: method Jacobi, relative termination criterion, epsilon 1e-6, at most 10000
//! iterations.
//!
//! Guarantee: none. That values hardly change does not bound their distance from the fixed point: on some
//! models the result is wrong in its first digit. The method exists to reproduce published figures.
//!
//! Cost: iterations times transitions.

use crate::answer::{CheckError, Options};
use crate::graph::Qualitative;
use crate::state_space::Csr;

/// Solves the reachability problem whose target are the states of `sets.surely`; also the number of
/// iterations.
pub(crate) fn reachability(
    matrix: &Csr<f64>,
    sets: &Qualitative,
    options: &Options<'_>,
) -> Result<(Vec<f64>, u64), CheckError> {
    let mut x: Vec<f64> = sets
        .surely
        .iter()
        .map(|s| f64::from(u8::from(*s)))
        .collect();
    let open: Vec<usize> = (0..x.len())
        .filter(|state| !sets.surely[*state] && !sets.never[*state])
        .collect();
    if open.is_empty() {
        return Ok((x, 0));
    }
    let mut next = x.clone();
    for iteration in 1..=options.max_iters {
        if iteration % 64 == 0 {
            options.check_cancelled()?;
        }
        let mut change = 0f64;
        for state in &open {
            let new = jacobi(matrix, *state, &x);
            if !new.is_finite() {
                return Err(CheckError::NotFinite { state: *state });
            }
            // As in PRISM, 0/0 is no change.
            change = change.max(options.termination.change(x[*state], new));
            next[*state] = new;
        }
        std::mem::swap(&mut x, &mut next);
        if change < options.epsilon {
            return Ok((x, iteration));
        }
    }
    Err(CheckError::NotConverged {
        iterations: options.max_iters,
        epsilon: options.epsilon,
    })
}

fn jacobi(matrix: &Csr<f64>, state: usize, x: &[f64]) -> f64 {
    let (mut sum, mut stay) = (0.0, 0.0);
    for (target, p) in matrix.row(state) {
        if target == state {
            stay = *p;
        } else {
            sum += p * x[target];
        }
    }
    sum / (1.0 - stay)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::qualitative;

    /// From 0: stay with `stay`, else to the target 1 or the sink 2, evenly; 3 leads to 0 and back with 9/10.
    #[test]
    fn self_loops_are_solved_and_cycles_stop_early() {
        let rows = vec![
            vec![(0, 0.5), (1, 0.25), (2, 0.25)],
            vec![(1, 1.0)],
            vec![(2, 1.0)],
            vec![(4, 0.9), (0, 0.1)],
            vec![(3, 0.9), (1, 0.1)],
        ];
        let matrix = Csr::from_rows(rows);
        let right = [false, true, false, false, false];
        let sets = qualitative(&matrix, &[true; 5], &right);
        let (x, iterations) = reachability(&matrix, &sets, &Options::default()).unwrap();
        assert_eq!((x[0], x[1], x[2]), (0.5, 1.0, 0.0));
        // x3 = 0.05 + 0.9 x4 and x4 = 0.1 + 0.9 x3, so x3 = 0.14 / 0.19.
        let error = 0.14 / 0.19 - x[3];
        assert!(
            iterations > 50 && error > 1e-7 && error < 1e-5,
            "{iterations} {error}"
        );
        let never_left = vec![vec![(0, 1.0), (1, 1e-30)], vec![(1, 1.0)]];
        let matrix_of = Csr::from_rows(never_left);
        let open = Qualitative {
            surely: vec![false, true],
            never: vec![false; 2],
        };
        assert!(matches!(
            reachability(&matrix_of, &open, &Options::default()),
            Err(CheckError::NotFinite { state: 0 })
        ));
        let short = Options {
            max_iters: 3,
            ..Options::default()
        };
        assert!(matches!(
            reachability(&matrix, &sets, &short),
            Err(CheckError::NotConverged { iterations: 3, .. })
        ));
    }
}
