//! Reachability within one strongly connected component, solved directly without any subtraction.
//!
//! *Problem.* For the states `i` of a component, with `p_ij` for transitions inside and weights to the
//! outside, solve `x_i = (n_i + sum_{j != i} p_ij x_j) / s_i` where `s_i = t_i + sum_{j != i} p_ij` and
//! `t_i` is the total probability of leaving the component. Several right-hand sides `n` at once.
//! Self-loops play no part: what is divided by is the sum of the other transitions, never `1 - p_ii`.
//!
//! *Method.* State elimination, the algorithm of Grassmann, Taksar and Heyman (1985) for absorbing
//! chains: take `k` out by `p_ij += p_ik p_kj / s_k`, `n_i += p_ik n_k / s_k`, `t_i += p_ik t_k / s_k`, and
//! at the end put the states back in reverse order. Sparse rows; the next state is one with the least
//! product of predecessors and successors (Markowitz 1957), lowest number first, so that results do not
//! depend on anything but the input.
//!
//! *Guarantee.* In exact arithmetic the result is exact. In floating point all operands are positive, so
//! results have small componentwise relative errors however ill conditioned the chain is (O'Cinneide
//! 1993). The bound used: each solution is a ratio of two sums of products of at most `m` entries (the
//! matrix-tree theorem), so perturbing the entries of a chain of `m` states by a factor `1 + e` moves it by
//! at most `(1 + e)^(2m)`. Eliminating `k`, whose row has `r` entries, perturbs the entries of the chain of
//! the `m` states that remain by at most `(r + 3) u`, and putting it back adds `(2 r + 4) u`:
//!
//! ```text
//! relative error <= sum over k of  2 m_k (r_k + 3) u + (2 r_k + 4) u        (first order)
//! ```
//!
//! Cost: the number of entries of the rows that are filled in; cubic at worst, near linear for the
//! components of most models. A budget stops it.

mod visits;

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use prism_lang::Arithmetic;

use crate::rounding::UNIT;

/// Products below this may have lost digits by underflow.
const SMALLEST_PRODUCT: f64 = 1e-290;

/// Equations of a component. Right-hand side 0 is the probability of leaving.
#[derive(Debug, Clone)]
pub(crate) struct System<N, const W: usize> {
    /// Transitions inside, without self-loops; columns ascend.
    pub rows: Vec<Vec<(u32, N)>>,
    /// `t_i`, then the right-hand sides.
    pub rhs: Vec<[N; W]>,
}

/// A solution of a [`System`].
#[derive(Debug, Clone)]
pub(crate) struct Solution<N, const W: usize> {
    /// For each state: 1 (nearly), then the value for each right-hand side.
    pub values: Vec<[N; W]>,
    /// First-order bound of the relative error, rounding of this computation only.
    pub relative_error: f64,
}

/// Why an elimination was given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum GivenUp {
    /// It needed more operations than allowed.
    Budget,
    /// Products became too small for floating point.
    Underflow,
    /// A state cannot leave: the equations have no unique solution.
    Singular,
    /// The caller asked to stop.
    Cancelled,
}

/// A state taken out, with its row at that time.
struct Removed<N, const W: usize> {
    state: usize,
    row: Vec<(u32, N)>,
    total: N,
    rhs: [N; W],
}

struct Elimination<N, const W: usize> {
    system: System<N, W>,
    predecessors: Vec<Vec<u32>>,
    present: Vec<bool>,
    queue: BinaryHeap<Reverse<(u64, u32)>>,
    operations: u64,
}

impl<N: Arithmetic, const W: usize> System<N, W> {
    /// Solves the equations; `budget` bounds the number of multiplications.
    pub fn solve(
        self,
        budget: u64,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Solution<N, W>, GivenUp> {
        let states = self.rows.len();
        let mut elimination = Elimination::new(self);
        let mut removed = Vec::with_capacity(states);
        let mut relative_error = 0.0;
        while let Some(state) = elimination.next_state() {
            let step = elimination.remove(state, cancelled)?;
            removed.push(step);
            if elimination.operations > budget {
                return Err(GivenUp::Budget);
            }
            let row = removed.last().map_or(0, |step| step.row.len()) as f64 + 1.0;
            let remaining = (states - removed.len()) as f64;
            relative_error += UNIT * (2.0 * remaining * (row + 3.0) + 2.0 * row + 4.0);
        }
        Ok(Solution {
            values: put_back(removed, states, cancelled)?,
            relative_error,
        })
    }
}

impl<N: Arithmetic, const W: usize> Elimination<N, W> {
    fn new(system: System<N, W>) -> Self {
        let states = system.rows.len();
        let mut predecessors = vec![Vec::new(); states];
        for (state, row) in system.rows.iter().enumerate() {
            for (column, _) in row {
                predecessors[*column as usize].push(state as u32);
            }
        }
        let mut elimination = Self {
            system,
            predecessors,
            present: vec![true; states],
            queue: BinaryHeap::with_capacity(states),
            operations: 0,
        };
        for state in 0..states as u32 {
            let cost = elimination.cost(state);
            elimination.queue.push(Reverse((cost, state)));
        }
        elimination
    }

    fn cost(&self, state: u32) -> u64 {
        let state = state as usize;
        self.predecessors[state].len() as u64 * (self.system.rows[state].len() as u64 + 1)
    }

    /// The cheapest state left; queue entries whose cost has grown since are put back.
    fn next_state(&mut self) -> Option<usize> {
        while let Some(Reverse((cost, state))) = self.queue.pop() {
            if !self.present[state as usize] {
                continue;
            }
            let present = &self.present;
            self.predecessors[state as usize].retain(|p| present[*p as usize]);
            let current = self.cost(state);
            if current > cost {
                self.queue.push(Reverse((current, state)));
                continue;
            }
            return Some(state as usize);
        }
        None
    }

    fn remove(
        &mut self,
        state: usize,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Removed<N, W>, GivenUp> {
        self.present[state] = false;
        let row = std::mem::take(&mut self.system.rows[state]);
        let rhs = self.system.rhs[state].clone();
        let total = (row.iter()).fold(rhs[0].clone(), |sum, (_, value)| sum.add(value));
        if total.is_zero() {
            return Err(GivenUp::Singular);
        }
        for predecessor in std::mem::take(&mut self.predecessors[state]) {
            // Rational functions can take minutes for one of them.
            if cancelled() {
                return Err(GivenUp::Cancelled);
            }
            self.redirect(predecessor as usize, state, &row, &total, &rhs)?;
        }
        // Fewer predecessors may make a successor cheaper than the queue knows.
        for (column, _) in &row {
            let cost = self.cost(*column);
            self.queue.push(Reverse((cost, *column)));
        }
        Ok(Removed {
            state,
            row,
            total,
            rhs,
        })
    }

    /// Replaces the transition from `from` to `via` by what `via` does.
    fn redirect(
        &mut self,
        from: usize,
        via: usize,
        via_row: &[(u32, N)],
        total: &N,
        via_rhs: &[N; W],
    ) -> Result<(), GivenUp> {
        let old = std::mem::take(&mut self.system.rows[from]);
        let Ok(position) = old.binary_search_by_key(&(via as u32), |(column, _)| *column) else {
            self.system.rows[from] = old;
            return Ok(());
        };
        let share = (old[position].1.div(total)).ok_or(GivenUp::Singular)?;
        self.operations += (via_row.len() + old.len() + W) as u64;
        for (value, more) in self.system.rhs[from].iter_mut().zip(via_rhs) {
            *value = value.add(&product(&share, more)?);
        }
        let mut merged = Vec::with_capacity(old.len() + via_row.len());
        let mut old = old
            .into_iter()
            .filter(|(column, _)| *column as usize != via)
            .peekable();
        for (column, value) in via_row
            .iter()
            .filter(|(column, _)| *column as usize != from)
        {
            while let Some(entry) = old.next_if(|(known, _)| known < column) {
                merged.push(entry);
            }
            let more = product(&share, value)?;
            match old.next_if(|(known, _)| known == column) {
                Some((_, known)) => merged.push((*column, known.add(&more))),
                None => {
                    merged.push((*column, more));
                    self.predecessors[*column as usize].push(from as u32);
                }
            }
        }
        merged.extend(old);
        self.system.rows[from] = merged;
        Ok(())
    }
}

fn product<N: Arithmetic>(share: &N, value: &N) -> Result<N, GivenUp> {
    let product = share.mul(value);
    if !N::EXACT && !value.is_zero() && product.to_f64() < SMALLEST_PRODUCT {
        return Err(GivenUp::Underflow);
    }
    Ok(product)
}

/// Solves the removed rows, last removed first.
fn put_back<N: Arithmetic, const W: usize>(
    removed: Vec<Removed<N, W>>,
    states: usize,
    cancelled: &dyn Fn() -> bool,
) -> Result<Vec<[N; W]>, GivenUp> {
    let mut values: Vec<[N; W]> = vec![std::array::from_fn(|_| N::zero()); states];
    for step in removed.into_iter().rev() {
        if cancelled() {
            return Err(GivenUp::Cancelled);
        }
        let mut solution = step.rhs;
        for (column, weight) in &step.row {
            for (sum, value) in solution.iter_mut().zip(&values[*column as usize]) {
                *sum = sum.add(&product(weight, value)?);
            }
        }
        for value in &mut solution {
            *value = value.div(&step.total).ok_or(GivenUp::Singular)?;
        }
        values[step.state] = solution;
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use prism_lang::Rational;

    /// Gambler's ruin: from fortune `i` of `n`, up with probability `p`. Probability of reaching `n` is
    /// `(1 - r^i) / (1 - r^n)` with `r = (1 - p) / p`.
    fn ruin<N: Arithmetic>(n: usize, p: N, q: N) -> System<N, 2> {
        let inner = n - 1;
        let mut system = System {
            rows: vec![Vec::new(); inner],
            rhs: vec![[N::zero(), N::zero()]; inner],
        };
        for state in 0..inner {
            if state > 0 {
                system.rows[state].push((state as u32 - 1, q.clone()));
            }
            if state + 1 < inner {
                system.rows[state].push((state as u32 + 1, p.clone()));
            }
        }
        system.rhs[0][0] = q;
        system.rhs[inner - 1] = [p.clone(), p];
        system
    }

    #[test]
    fn ruin_is_exact_in_rational_arithmetic() {
        let third = |k: i64| Rational::new(k.into(), 3.into());
        let solution = ruin(10, third(1), third(2))
            .solve(u64::MAX, &|| false)
            .unwrap();
        for state in 0..9u32 {
            let expected =
                Rational::new((2i64.pow(state + 1) - 1).into(), (2i64.pow(10) - 1).into());
            assert_eq!(solution.values[state as usize][1], expected);
        }
    }

    #[test]
    fn rounding_errors_stay_within_their_bound() {
        // r = 9, so the value at fortune 1 of 80 is 8 / (9^80 - 1): far below the rounding of 1.
        let solution = ruin(80, 0.1, 0.9).solve(u64::MAX, &|| false).unwrap();
        let expected = 8.0 / 9f64.powi(80);
        let error = (solution.values[0][1] / expected - 1.0).abs();
        assert!(error <= solution.relative_error + 1e-14, "{error}");
        assert!(solution.relative_error < 1e-11);
    }

    #[test]
    fn a_budget_and_a_state_without_exit_are_reported() {
        assert_eq!(
            ruin(80, 0.5, 0.5).solve(3, &|| false).err(),
            Some(GivenUp::Budget)
        );
        let stuck = System::<f64, 2> {
            rows: vec![vec![(1, 1.0)], vec![(0, 1.0)]],
            rhs: vec![[0.0; 2]; 2],
        };
        assert_eq!(stuck.solve(99, &|| false).err(), Some(GivenUp::Singular));
    }
}
