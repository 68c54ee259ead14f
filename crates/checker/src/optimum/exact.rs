//! The optimum in rational arithmetic.
//!
//! *Method.* Component by component, policy iteration (Howard 1960): from a scheduler that is sure to leave
//! the component, solve its chain by elimination ([`crate::elimination`]), change choices where another is
//! strictly better, until none is. Guarantee: exact. Cost: few rounds on most models, exponentially many in
//! the worst case; numbers grow with the number of states.

use prism_lang::{Arithmetic, Rational};

use super::policy::leaving_component;
use super::sound::no_choice;
use super::{Problem, Solution};
use crate::amount::{Amount, Extended};
use crate::answer::{CheckError, Options};
use crate::choices::Choices;
use crate::elimination::{GivenUp, System};
use crate::graph::{Components, NO_ROW};

/// Solves the problem.
pub(crate) fn solve(
    problem: &Problem<Rational, Extended>,
    options: &Options<'_>,
) -> Result<Solution<Extended>, CheckError> {
    let open: Vec<bool> = problem.fixed.iter().map(Option::is_none).collect();
    let choices = Choices::new(&problem.matrix, &problem.choice_start);
    let mut solver = Solver {
        problem,
        options,
        position: vec![u32::MAX; open.len()],
        values: (problem.fixed.iter())
            .map(|fixed| fixed.clone().unwrap_or_else(Extended::zero))
            .collect(),
        choice: vec![NO_ROW; open.len()],
    };
    for component in Components::of_choices(choices, &open, |_| true).iter() {
        options.check_cancelled()?;
        solver.component(component)?;
    }
    Ok(Solution {
        values: solver.values,
        choice: solver.choice,
        iterations: 0,
    })
}

struct Solver<'a> {
    problem: &'a Problem<Rational, Extended>,
    options: &'a Options<'a>,
    position: Vec<u32>,
    values: Vec<Extended>,
    choice: Vec<usize>,
}

impl Solver<'_> {
    fn component(&mut self, component: &[u32]) -> Result<(), CheckError> {
        let choices = Choices::new(&self.problem.matrix, &self.problem.choice_start);
        let first = leaving_component(choices, component, &mut self.position);
        let mut policy = first.ok_or_else(no_choice)?;
        for (place, state) in component.iter().enumerate() {
            self.position[*state as usize] = place as u32;
        }
        loop {
            self.evaluate(component, &policy)?;
            let mut changed = false;
            for (state, chosen) in component.iter().zip(&mut policy) {
                let row = self.best(*state as usize, *chosen);
                changed |= row != *chosen;
                *chosen = row;
            }
            if !changed {
                break;
            }
        }
        for (state, row) in component.iter().zip(&policy) {
            self.position[*state as usize] = u32::MAX;
            self.choice[*state as usize] = *row;
        }
        Ok(())
    }

    /// Sets the values to those of the chain in which these choices are taken.
    fn evaluate(&mut self, component: &[u32], policy: &[usize]) -> Result<(), CheckError> {
        let mut system: System<Rational, 2> = System {
            rows: Vec::with_capacity(component.len()),
            rhs: Vec::with_capacity(component.len()),
        };
        for row in policy {
            let (mut entries, mut exit) = (Vec::new(), Rational::zero());
            let mut value = self.reward(*row);
            for (target, p) in self.problem.matrix.row(*row) {
                match self.position[target] {
                    u32::MAX => {
                        exit = exit.add(p);
                        value = value.add(&Extended::Finite(p.clone()).mul(&self.values[target]));
                    }
                    place => entries.push((place, p.clone())),
                }
            }
            entries.sort_unstable_by_key(|(column, _)| *column);
            let Extended::Finite(value) = value else {
                return Err(no_choice());
            };
            system.rows.push(entries);
            system.rhs.push([exit, value]);
        }
        let cancelled = || self.options.is_cancelled();
        let solution = system
            .solve(u64::MAX, &cancelled)
            .map_err(|reason| match reason {
                GivenUp::Cancelled => CheckError::Cancelled,
                _ => no_choice(),
            })?;
        for (state, [_, value]) in component.iter().zip(solution.values) {
            self.values[*state as usize] = Extended::Finite(value);
        }
        Ok(())
    }

    fn reward(&self, row: usize) -> Extended {
        self.problem
            .reward
            .get(row)
            .cloned()
            .unwrap_or_else(Extended::zero)
    }

    /// The best choice of a state for the present values; the known one if no other is better.
    fn best(&self, state: usize, known: usize) -> usize {
        let mut best = (known, self.row_value(known));
        for row in self.problem.choice_start[state]..self.problem.choice_start[state + 1] {
            let value = self.row_value(row);
            if value.beats(&best.1, self.problem.maximise) {
                best = (row, value);
            }
        }
        best.0
    }

    fn row_value(&self, row: usize) -> Extended {
        let sum = Extended::mean(
            Some(&self.reward(row)),
            self.problem
                .matrix
                .row(row)
                .map(|(target, p)| (p, &self.values[target])),
            0.0,
        );
        let total: Rational = self.problem.matrix.row(row).map(|(_, p)| p).sum();
        match total == Rational::one() {
            true => sum,
            false => sum.div(&Extended::Finite(total)),
        }
    }
}
