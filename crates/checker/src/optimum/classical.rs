//! The optimum by the classical iterations, which stop when little changes.
//!
//! With `s_c = sum_{j != i} p_cj`, from `x = 0`, the values of one strongly connected component after the other in reverse
//! topological order; components of one state need no iteration:
//!
//! ```text
//! value iteration   x'_i = opt over c of  r_c + sum_{j != i} p_cj x_j + (1 - s_c) x_i
//! Jacobi            x'_i = opt over c of (r_c + sum_{j != i} p_cj x_j) / s_c
//! Gauss-Seidel      the same, each new value used at once; forwards and backwards in turn
//! modified policy   a round of value iteration, which chooses a scheduler; then [`SWEEPS`] rounds of Gauss-Seidel in its
//! iteration         chain
//! ```
//!
//! until no value changes by more than epsilon ([`Termination`]), in modified policy iteration in a round that chooses.
//!
//! Source: Puterman 1994, sections 6.3 and 6.5; Varga 1962, "Matrix Iterative Analysis"; the order of Dai, Strejček, Wu
//! and Gupta 2011. Deviations: end components have been collapsed before, so that there is one solution. Modified policy
//! iteration of least rewards begins at the values of a scheduler that is sure to end, since a scheduler that goes round
//! for ever may look best from 0.
//!
//! Guarantee: none. That values hardly change does not bound their distance from the solution. Cost: rounds times
//! entries; a round is counted for each component on its own.
//!
//! [`Termination`]: crate::Termination

use super::policy::leaving_component;
use super::sound::no_choice;
use super::{Problem, Solution};
use crate::answer::{CheckError, Options};
use crate::choices::Choices;
use crate::graph::{Components, NO_ROW, Qualitative};
use crate::method::Method;
use crate::state_space::Csr;

/// Rounds in which modified policy iteration follows a scheduler.
const SWEEPS: u64 = 20;
/// Updates of a state between two looks at whether to stop.
const LOOK: u64 = 1 << 20;

/// Solves the problem by the method that the options name.
pub(crate) fn solve(
    problem: &Problem<f64, f64>,
    options: &Options<'_>,
) -> Result<Solution<f64>, CheckError> {
    let equations = Equations {
        choices: Choices::new(&problem.matrix, &problem.choice_start),
        reward: &problem.reward,
        maximise: problem.maximise,
        options,
    };
    let open: Vec<bool> = problem.fixed.iter().map(Option::is_none).collect();
    let start = problem.fixed.iter().map(|f| f.unwrap_or(0.0)).collect();
    equations.solve(&open, start)
}

/// The probabilities of reaching the states of `sets.surely` in a chain, and the rounds.
pub(crate) fn reachability(
    matrix: &Csr<f64>,
    sets: &Qualitative,
    options: &Options<'_>,
) -> Result<(Vec<f64>, u64), CheckError> {
    let equations = Equations {
        choices: Choices::new(matrix, &[]),
        reward: &[],
        maximise: true,
        options,
    };
    let pairs = sets.surely.iter().zip(&sets.never);
    let open: Vec<bool> = pairs.map(|(surely, never)| !surely && !never).collect();
    let indicator = sets.surely.iter().map(|s| f64::from(u8::from(*s)));
    let found = equations.solve(&open, indicator.collect())?;
    Ok((found.values, found.iterations))
}

/// As in [`super`], but rows may also lead to their own state.
struct Equations<'a> {
    choices: Choices<'a, f64>,
    /// None if it is empty.
    reward: &'a [f64],
    maximise: bool,
    options: &'a Options<'a>,
}

/// What is known while components are solved.
struct Progress {
    x: Vec<f64>,
    choice: Vec<usize>,
    iterations: u64,
    /// Updates of states since the last look at whether to stop.
    updates: u64,
}

impl Equations<'_> {
    fn solve(&self, open: &[bool], start: Vec<f64>) -> Result<Solution<f64>, CheckError> {
        let mut progress = Progress {
            choice: vec![NO_ROW; start.len()],
            x: start,
            iterations: 0,
            updates: 0,
        };
        let mut position = vec![u32::MAX; open.len()];
        for component in Components::of_choices(self.choices, open, |_| true).iter() {
            match component {
                [state] => {
                    self.look(&mut progress, 1)?;
                    self.update(*state as usize, true, &mut progress)?;
                }
                _ if self.options.method == Method::ModifiedPolicyIteration => {
                    self.by_schedulers(component, &mut position, &mut progress)?;
                }
                _ => self.by_values(component, &mut progress)?,
            }
        }
        Ok(Solution {
            values: progress.x,
            choice: progress.choice,
            iterations: progress.iterations,
        })
    }

    /// Value iteration, Jacobi or Gauss-Seidel.
    fn by_values(&self, component: &[u32], progress: &mut Progress) -> Result<(), CheckError> {
        for round in 0..self.options.max_iters {
            let change = match self.options.method {
                Method::GaussSeidel => self.in_place(component, round, progress)?,
                method => self.all_at_once(component, method == Method::Jacobi, progress)?,
            };
            if change < self.options.epsilon {
                return Ok(());
            }
        }
        Err(self.not_converged())
    }

    /// Modified policy iteration.
    fn by_schedulers(
        &self,
        component: &[u32],
        position: &mut [u32],
        progress: &mut Progress,
    ) -> Result<(), CheckError> {
        let begun = progress.iterations;
        let is_over = |progress: &Progress| progress.iterations - begun >= self.options.max_iters;
        if !self.maximise && !self.reward.is_empty() {
            let policy = leaving_component(self.choices, component, position);
            let policy = policy.ok_or_else(no_choice)?;
            for (state, row) in component.iter().zip(policy) {
                progress.choice[*state as usize] = row;
            }
            while self.follow(component, progress)? >= self.options.epsilon {
                if is_over(progress) {
                    return Err(self.not_converged());
                }
            }
        }
        while self.all_at_once(component, false, progress)? >= self.options.epsilon {
            for _ in 0..SWEEPS {
                if is_over(progress) {
                    return Err(self.not_converged());
                }
                self.follow(component, progress)?;
            }
        }
        Ok(())
    }

    /// A round in which all new values come from old ones; the greatest change.
    fn all_at_once(
        &self,
        component: &[u32],
        divided: bool,
        progress: &mut Progress,
    ) -> Result<f64, CheckError> {
        self.look(progress, component.len())?;
        let mut change = 0f64;
        let mut next = Vec::with_capacity(component.len());
        for state in component.iter().map(|state| *state as usize) {
            let (row, new) = self.best(state, divided, &progress.x)?;
            change = change.max(self.options.termination.change(progress.x[state], new));
            progress.choice[state] = row;
            next.push(new);
        }
        for (state, new) in component.iter().zip(next) {
            progress.x[*state as usize] = new;
        }
        progress.iterations += 1;
        Ok(change)
    }

    /// A round in which each new value is used at once; the greatest change.
    fn in_place(
        &self,
        component: &[u32],
        round: u64,
        progress: &mut Progress,
    ) -> Result<f64, CheckError> {
        self.look(progress, component.len())?;
        let mut change = 0f64;
        for place in 0..component.len() {
            let place = match round % 2 {
                0 => place,
                _ => component.len() - 1 - place,
            };
            change = change.max(self.update(component[place] as usize, true, progress)?);
        }
        progress.iterations += 1;
        Ok(change)
    }

    /// A round in place in the chain of the choices made; the greatest change.
    fn follow(&self, component: &[u32], progress: &mut Progress) -> Result<f64, CheckError> {
        self.look(progress, component.len())?;
        let mut change = 0f64;
        for state in component.iter().map(|state| *state as usize) {
            let new = self.row_value(state, progress.choice[state], true, &progress.x);
            let new = finite(state, new.ok_or_else(no_choice)?)?;
            change = change.max(self.options.termination.change(progress.x[state], new));
            progress.x[state] = new;
        }
        progress.iterations += 1;
        Ok(change)
    }

    /// Sets a state's value and choice; the change.
    fn update(
        &self,
        state: usize,
        divided: bool,
        progress: &mut Progress,
    ) -> Result<f64, CheckError> {
        let (row, new) = self.best(state, divided, &progress.x)?;
        let change = self.options.termination.change(progress.x[state], new);
        (progress.choice[state], progress.x[state]) = (row, new);
        Ok(change)
    }

    /// The best choice of a state and its value.
    fn best(&self, state: usize, divided: bool, x: &[f64]) -> Result<(usize, f64), CheckError> {
        let mut best: Option<(usize, f64)> = None;
        for row in self.choices.rows(state) {
            let Some(value) = self.row_value(state, row, divided, x) else {
                continue;
            };
            let is_better = |(_, known): (usize, f64)| {
                value != known && (value > known) == self.maximise && !known.is_nan()
            };
            if best.is_none_or(is_better) {
                best = Some((row, value));
            }
        }
        let (row, value) = best.ok_or_else(no_choice)?;
        Ok((row, finite(state, value)?))
    }

    /// The value of a choice; nothing if it only stays.
    fn row_value(&self, state: usize, row: usize, divided: bool, x: &[f64]) -> Option<f64> {
        let mut sum = self.reward.get(row).copied().unwrap_or(0.0);
        let mut total = 0.0;
        for (target, p) in self.choices.matrix.row(row) {
            if target != state {
                sum += p * x[target];
                total += p;
            }
        }
        if total == 0.0 {
            return None;
        }
        Some(match divided {
            true => sum / total,
            false => sum + (1.0 - total).max(0.0) * x[state],
        })
    }

    /// Looks now and then whether to stop.
    fn look(&self, progress: &mut Progress, updates: usize) -> Result<(), CheckError> {
        progress.updates += updates as u64;
        if progress.updates >= LOOK {
            progress.updates = 0;
            self.options.check_cancelled()?;
        }
        Ok(())
    }

    fn not_converged(&self) -> CheckError {
        CheckError::NotConverged {
            iterations: self.options.max_iters,
            epsilon: self.options.epsilon,
        }
    }
}

fn finite(state: usize, value: f64) -> Result<f64, CheckError> {
    match value.is_finite() {
        true => Ok(value),
        false => Err(CheckError::NotFinite { state }),
    }
}
