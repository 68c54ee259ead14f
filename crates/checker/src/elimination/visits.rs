//! How often the states of a component are visited before it is left, by elimination.
//!
//! *Problem.* With `b_i` coming in from outside, solve `y_j = (b_j + sum_{i != j} y_i p_ij) / s_j`, the equations of [`super`] with
//! rows and columns exchanged: `y_j` is the expected number of visits (with rates in place of probabilities the expected time).
//!
//! *Method.* Taking `k` out also sends on what comes in: `b_j += b_k p_kj / s_k`. The column of `k` at that time is kept, and put
//! back in reverse order. No subtraction; guarantee and cost as in [`super`], with the column's entries beside the row's.

use prism_lang::Arithmetic;

use super::{Elimination, GivenUp, System, product};
use crate::rounding::UNIT;

/// A state taken out, with what led to it at that time.
struct Removed<N> {
    state: usize,
    column: Vec<(u32, N)>,
    total: N,
    inflow: N,
}

impl<N: Arithmetic> System<N, 1> {
    /// The visits of each state, and a first-order bound of their relative error, rounding of this computation only; `budget`
    /// bounds the number of multiplications.
    pub fn visits(
        self,
        mut inflow: Vec<N>,
        budget: u64,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<(Vec<N>, f64), GivenUp> {
        let states = self.rows.len();
        let mut elimination = Elimination::new(self);
        let mut removed = Vec::with_capacity(states);
        let mut relative_error = 0.0;
        while let Some(state) = elimination.next_state() {
            let column = elimination.column(state);
            let step = elimination.remove(state, cancelled)?;
            for (to, p) in &step.row {
                let share = p.div(&step.total).ok_or(GivenUp::Singular)?;
                let more = product(&share, &inflow[state])?;
                inflow[*to as usize] = inflow[*to as usize].add(&more);
            }
            let terms = (step.row.len() + column.len()) as f64;
            let remaining = (states - removed.len()) as f64;
            let row = step.row.len() as f64 + 1.0;
            relative_error += UNIT * (2.0 * remaining * (row + 3.0) + 2.0 * terms + 12.0);
            removed.push(Removed {
                state,
                column,
                total: step.total,
                inflow: inflow[state].clone(),
            });
            if elimination.operations > budget {
                return Err(GivenUp::Budget);
            }
        }
        let mut visits = vec![N::zero(); states];
        for step in removed.into_iter().rev() {
            let mut sum = step.inflow;
            for (from, p) in &step.column {
                sum = sum.add(&product(&visits[*from as usize], p)?);
            }
            visits[step.state] = sum.div(&step.total).ok_or(GivenUp::Singular)?;
        }
        Ok((visits, relative_error))
    }
}

impl<N: Arithmetic, const W: usize> Elimination<N, W> {
    /// What leads to a state from those that are left.
    fn column(&self, state: usize) -> Vec<(u32, N)> {
        let entry = |from: &u32| {
            let row = &self.system.rows[*from as usize];
            let at = row.binary_search_by_key(&(state as u32), |(column, _)| *column);
            at.ok().map(|at| (*from, row[at].1.clone()))
        };
        let from = self.predecessors[state].iter();
        from.filter(|from| self.present[**from as usize])
            .filter_map(entry)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use prism_lang::Rational;

    #[test]
    fn visits_on_a_line_are_those_of_ruin() {
        // States 0..9, up and down with probability 1/3 and 2/3, out at both ends; started in 4. Checked against its equations.
        let third = |k: i64| Rational::new(k.into(), 3.into());
        let rows: Vec<Vec<(u32, Rational)>> = (0..9u32)
            .map(|s| {
                let down = s.checked_sub(1).map(|to| (to, third(2)));
                let up = (s < 8).then(|| (s + 1, third(1)));
                down.into_iter().chain(up).collect()
            })
            .collect();
        let leaving = |s: usize| third(i64::from(s == 0) * 2 + i64::from(s == 8));
        let system = System {
            rows: rows.clone(),
            rhs: (0..9).map(|s| [leaving(s)]).collect(),
        };
        let start = |s: usize| third(i64::from(s == 4) * 3);
        let inflow = (0..9).map(start).collect();
        let (visits, _) = system.visits(inflow, u64::MAX, &|| false).unwrap();
        let mut next: Vec<Rational> = (0..9).map(start).collect();
        for (state, row) in rows.iter().enumerate() {
            for (to, p) in row {
                next[*to as usize] += &visits[state] * p;
            }
        }
        assert_eq!(next, visits);
        let out: Rational = (0..9).map(|s| &visits[s] * leaving(s)).sum();
        assert_eq!(out, third(3));
    }
}
