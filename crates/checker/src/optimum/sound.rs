//! The optimum with bounds that hold, rounding included.
//!
//! *Method.* Component by component in reverse topological order (Dai, Strejček, Wu and Gupta 2011). Within one:
//!
//! 1. without alternatives, elimination ([`crate::elimination`]) within a budget, as in [`crate::sound`];
//! 2. some rounds of value iteration with guesses ([`super::search`]), as long as they promise to be enough; then, where many
//!    transitions lead back, in the order in which states were explored, forwards and backwards in turn;
//! 3. policy iteration by linear equations, and bounds by slack ([`super::slack`]);
//! 4. more rounds of value iteration;
//! 5. policy iteration (Howard 1960), each scheduler's chain solved by elimination; then the guess as before.
//!
//! By linear equations or policy iteration ([`crate::Method`]): step 1 alone without alternatives, step 5 alone with them, whatever
//! they cost; if no bounds around the last scheduler's values are inductive, that is an error.
//!
//! *Why inductive bounds hold.* With `F` the right-hand side of [`super`]: if `F(u) <= u` then for each
//! scheduler that is sure to reach fixed states, hence for a best one, `u >= F^n(u)`, which tends to its value
//! or more; if `F(l) >= l` then some scheduler's value (max), or every such scheduler's value (min), is at
//! least `l`. `F` is computed rounded to nearest and then moved against the claim by more than its error.
//!
//! *Guarantee.* The bounds contain the optimum. For a component of `m` states whose probabilities are off by a
//! factor `1 + e`, each scheduler's value, and so the optimum, is off by at most `(1 + e)^(2 m)` (matrix-tree
//! theorem, see [`crate::elimination`]); that is added. If no guess holds in the end, the bound on that side
//! is the trivial one.
//!
//! Cost: rounds times entries; direct where components are small.

mod stopped;

use super::local::{Local, OUTSIDE, Side};
use super::policy::leaving;
use super::search::Search;
use super::{Problem, Solution};
use crate::answer::CheckError;
use crate::choices::Choices;
use crate::elimination::GivenUp;
use crate::engine::Context;
use crate::graph::{Components, NO_ROW};
use crate::rounding::{Bounds, SMALLEST_VALUE, UNIT};
use crate::sound::not_eliminated;
use stopped::LAST_WORK;

/// How much work is spent on a component by one way before the next is tried: multiplications.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    /// Of the first elimination, where there are no alternatives.
    pub direct: u64,
    /// Of value iteration before equations are solved.
    pub before: u64,
    /// Of value iteration thereafter.
    pub iterate: u64,
    /// Of each elimination of policy iteration.
    pub policy: u64,
    /// Of value iteration when all else failed.
    pub last: u64,
}

const EFFORT: Effort = Effort {
    direct: 100_000_000,
    before: 0,
    iterate: 2_000_000_000,
    policy: 20_000_000_000,
    last: 100_000_000_000,
};

/// Elimination and policy iteration alone.
const DIRECT: Effort = Effort {
    direct: u64::MAX,
    before: 0,
    iterate: 0,
    policy: u64::MAX,
    last: 0,
};

/// Components of fewer states than this are iterated without solving equations.
const SMALL: usize = 50;
/// Equations are solved in depth-first order if at most one in so many transitions leads back in it.
const NEARLY_ACYCLIC: usize = 8;
/// Chains of fewer states than this, or fewer transitions for each state, are eliminated first.
const EASY: usize = 1_000;
const SPARSE: usize = 4;

/// A problem on the states of a model, or of a quotient: as in [`super`], but a choice may also lead to its own state, which plays no part,
/// and choices are left out that lead nowhere else, or to a state of infinite value.
pub(crate) struct Equations<'a> {
    pub choices: Choices<'a, f64>,
    /// The reward of each choice; none if it is empty.
    pub reward: &'a [Bounds],
    /// The states whose values are asked for.
    pub open: Vec<bool>,
    /// The values of the others.
    pub values: Vec<Bounds>,
    pub maximise: bool,
    /// The greatest number of entries of the model that were added up to one entry of the matrix.
    pub merged: usize,
    /// An upper bound of all values that is known beforehand.
    pub cap: f64,
}

impl<'a> Equations<'a> {
    /// Those of a problem.
    pub fn of(problem: &'a Problem<f64, Bounds>, cap: f64) -> Self {
        let known = problem.fixed.iter();
        Self {
            choices: Choices::new(&problem.matrix, &problem.choice_start),
            reward: &problem.reward,
            open: known.clone().map(Option::is_none).collect(),
            values: known.map(|fixed| fixed.unwrap_or(Bounds::ZERO)).collect(),
            maximise: problem.maximise,
            merged: problem.merged,
            cap,
        }
    }

    pub fn solve(self, context: &Context<'_>) -> Result<Solution<Bounds>, CheckError> {
        let effort = match context.options.method.is_direct() {
            true => DIRECT,
            false => EFFORT,
        };
        solve_with(self, context, effort)
    }
}

pub(crate) fn solve_with(
    equations: Equations<'_>,
    context: &Context<'_>,
    effort: Effort,
) -> Result<Solution<Bounds>, CheckError> {
    let states = equations.open.len();
    let asked = equations.open.iter().filter(|open| **open).count();
    let choices = equations.choices;
    let components = Components::of_choices(choices, &equations.open, |_| true);
    let mut solver = Solver {
        equations,
        context,
        effort,
        asked,
        position: vec![OUTSIDE; states],
        choice: vec![NO_ROW; states],
        iterations: 0,
        last_work: LAST_WORK,
    };
    for (index, component) in components.iter().enumerate() {
        if index % 4096 == 0 && !context.options.must_stop() {
            context.options.check_cancelled()?;
        }
        match component {
            [state] => solver.substitute(*state as usize)?,
            _ => solver.component_or_enclose(component)?,
        }
    }
    Ok(Solution {
        values: solver.equations.values,
        choice: solver.choice,
        iterations: solver.iterations,
    })
}

struct Solver<'a> {
    /// With the values found so far.
    equations: Equations<'a>,
    context: &'a Context<'a>,
    effort: Effort,
    /// How many states' values are asked for.
    asked: usize,
    position: Vec<u32>,
    choice: Vec<usize>,
    iterations: u64,
    /// Multiplications that may still be done once the check is stopped.
    last_work: u64,
}

impl Solver<'_> {
    /// A state that does not reach itself.
    fn substitute(&mut self, state: usize) -> Result<(), CheckError> {
        let mut best: Option<(Bounds, usize)> = None;
        let mut longest = 0;
        let equations = &self.equations;
        let maximise = equations.maximise;
        for row in equations.choices.rows(state) {
            let mut sum = (equations.reward.get(row).copied()).unwrap_or(Bounds::ZERO);
            let (mut total, mut entries) = (0.0, 0);
            for (target, p) in equations.choices.matrix.row(row) {
                if target != state {
                    total += p;
                    entries += 1;
                    sum.low += p * equations.values[target].low;
                    sum.high += p * equations.values[target].high;
                }
            }
            if entries == 0 || sum.low == f64::INFINITY {
                continue;
            }
            longest = longest.max(entries);
            let (low, high) = (sum.low / total, sum.high / total);
            best = Some(match best {
                None => (Bounds { low, high }, row),
                Some((known, chosen)) => {
                    let better = if maximise {
                        low > known.low
                    } else {
                        low < known.low
                    };
                    let (low, high) = match maximise {
                        true => (low.max(known.low), high.max(known.high)),
                        false => (low.min(known.low), high.min(known.high)),
                    };
                    (Bounds { low, high }, if better { row } else { chosen })
                }
            });
        }
        let Some((value, row)) = best else {
            return Err(no_choice());
        };
        let error = 2.0 * self.entry_error() + (2 * longest + 4) as f64 * UNIT;
        self.store(state, value, row, error);
        Ok(())
    }

    fn entry_error(&self) -> f64 {
        self.context.entry_error + self.equations.merged as f64 * UNIT
    }

    fn store(&mut self, state: usize, value: Bounds, row: usize, error: f64) {
        self.equations.values[state] = widened(value, error, self.equations.cap);
        self.choice[state] = row;
    }

    /// Of the entries of the model, and of the sums over transitions that leave.
    fn input_error(&self, local: &Local) -> f64 {
        let inputs = self.entry_error() + (local.longest_exit + 3) as f64 * UNIT;
        2.0 * local.len() as f64 * inputs
    }

    fn component(&mut self, component: &[u32]) -> Result<(), CheckError> {
        let local = Local::new(&self.equations, component, &mut self.position);
        let input_error = self.input_error(&local);
        let is_direct = self.effort.direct == u64::MAX;
        if local.is_chain() {
            let policy: Vec<usize> = (0..local.len()).collect();
            let is_simple = local.len() < EASY || local.entries() < SPARSE * local.len();
            let budget = match is_simple || is_direct {
                true => self.effort.direct,
                false => 0,
            };
            if let Some((values, error)) = self.evaluate(&local, &policy, budget)? {
                self.keep(component, &local, values, &policy, input_error + error);
                return Ok(());
            }
            if is_direct {
                return Err(not_eliminated(local.len()));
            }
        }
        let share = component.len() as f64 / self.asked as f64;
        let floor = 4.0 * local.error;
        let tolerance = (self.context.options.precision * share / 4.0).max(floor);
        let options = self.context.options;
        let cancelled = || options.is_cancelled();
        let mut search = Search::new(
            &local,
            self.equations.maximise,
            tolerance,
            self.equations.cap,
        );
        if is_direct {
            search.rounds = (self.improve_policies(&mut search)?)
                .ok_or_else(|| no_bounds_of_policy(local.len()))?;
            return self.keep_found(component, &search, input_error);
        }
        let solved = search.rounds(self.effort.before, true, &cancelled);
        if solved || local.len() < SMALL {
            let solved = solved || search.iterate(self.effort.iterate, &cancelled);
            return self.finish(component, &mut search, solved, input_error);
        }
        if local.entries_back() * NEARLY_ACYCLIC <= local.entries() {
            let solved = search.solve(options)? || search.iterate(self.effort.iterate, &cancelled);
            return self.finish(component, &mut search, solved, input_error);
        }
        // Where many transitions lead back, incomplete factors are better in the order in which states were explored.
        let mut explored: Vec<(u32, f64)> = component
            .iter()
            .copied()
            .zip(search.low.iter().copied())
            .collect();
        explored.sort_unstable_by_key(|(state, _)| *state);
        let rounds = search.rounds;
        drop(local);
        let component: Vec<u32> = explored.iter().map(|(state, _)| *state).collect();
        let local = Local::new(&self.equations, &component, &mut self.position);
        let mut search = Search::new(
            &local,
            self.equations.maximise,
            tolerance,
            self.equations.cap,
        );
        search.rounds = rounds;
        search.low = explored.iter().map(|(_, low)| *low).collect();
        search.high.clone_from(&search.low);
        drop(explored);
        search.alternating = true;
        let solved = search.rounds(self.effort.before, false, &cancelled)
            || search.solve(options)?
            || search.iterate(self.effort.iterate, &cancelled);
        self.finish(&component, &mut search, solved, input_error)
    }

    /// Tries what is left to try, and keeps what was found.
    fn finish(
        &mut self,
        component: &[u32],
        search: &mut Search<'_>,
        mut solved: bool,
        input_error: f64,
    ) -> Result<(), CheckError> {
        let options = self.context.options;
        let cancelled = || options.is_cancelled();
        if !solved && options.must_stop() {
            return self.keep_reached(component, search, input_error);
        }
        if !solved {
            options.check_cancelled()?;
            solved = match self.improve_policies(search) {
                Err(CheckError::Cancelled) if options.must_stop() => {
                    return self.keep_reached(component, search, input_error);
                }
                schedulers => schedulers?.is_some(),
            };
        }
        if !solved {
            search.iterate(self.effort.last, &cancelled);
            if options.must_stop() {
                return self.keep_reached(component, search, input_error);
            }
            options.check_cancelled()?;
        }
        self.keep_found(component, search, input_error)
    }

    /// Keeps the bounds that a search has found.
    fn keep_found(
        &mut self,
        component: &[u32],
        search: &Search<'_>,
        input_error: f64,
    ) -> Result<(), CheckError> {
        self.iterations += search.rounds;
        let local = search.local;
        let choice = |place: usize| local.best(place, &search.low, Side::Low, search.maximise).0;
        let policy: Vec<usize> = (0..local.len()).map(choice).collect();
        let bounds = (search.found.iter())
            .map(|(low, high)| Bounds {
                low: *low,
                high: *high,
            })
            .collect();
        self.keep(component, local, bounds, &policy, input_error);
        Ok(())
    }

    fn keep(
        &mut self,
        component: &[u32],
        local: &Local,
        values: Vec<Bounds>,
        policy: &[usize],
        error: f64,
    ) {
        for ((state, value), row) in component.iter().zip(values).zip(policy) {
            self.store(*state as usize, value, local.origin[*row], error);
        }
    }

    /// The values of the chain in which these choices are taken, and the relative error of that computation.
    fn evaluate(
        &self,
        local: &Local,
        policy: &[usize],
        budget: u64,
    ) -> Result<Option<(Vec<Bounds>, f64)>, CheckError> {
        if budget == 0 {
            return Ok(None);
        }
        let options = self.context.options;
        let cancelled = || options.is_cancelled();
        match local.system(policy).solve(budget, &cancelled) {
            Ok(solution) => {
                let value = |[_, low, high]: &[f64; 3]| Bounds {
                    low: *low,
                    high: *high,
                };
                let values = solution.values.iter().map(value).collect();
                Ok(Some((values, solution.relative_error)))
            }
            Err(GivenUp::Cancelled) => Err(CheckError::Cancelled),
            Err(_) => Ok(None),
        }
    }

    /// Policy iteration; the number of schedulers if bounds around its result were found.
    fn improve_policies(&self, search: &mut Search<'_>) -> Result<Option<u64>, CheckError> {
        const ROUNDS: usize = 200;
        let local = search.local;
        let inside = |row: usize| &local.column[local.row_start[row]..local.row_start[row + 1]];
        let choices = |place: usize| local.choice_start[place]..local.choice_start[place + 1];
        let leaves = |row: usize| local.exit[row] > 0.0;
        let Some(mut policy) = leaving(local.len(), choices, inside, leaves) else {
            return Ok(None);
        };
        let mut schedulers = 0;
        for _ in 0..ROUNDS {
            self.context.options.check_cancelled()?;
            schedulers += 1;
            let Some((values, _)) = self.evaluate(local, &policy, self.effort.policy)? else {
                return Ok(None);
            };
            search.low = values.iter().map(|value| value.low).collect();
            search.high = values.iter().map(|value| value.high).collect();
            let mut changed = false;
            for (place, chosen) in policy.iter_mut().enumerate() {
                let (row, value) = local.best(place, &search.high, Side::High, search.maximise);
                let known = local.row_value(*chosen, &search.high, Side::High);
                let gain = if search.maximise {
                    value - known
                } else {
                    known - value
                };
                if gain > 1e-12 * known {
                    *chosen = row;
                    changed = true;
                }
            }
            if !changed {
                break;
            }
        }
        let held = search.guess(search.tolerance / 16.0) || search.guess(search.tolerance);
        Ok(held.then_some(schedulers))
    }
}

/// Bounds of a number that is not negative, from bounds computed with a relative error of at most `error` (to
/// first order; twice that is allowed for).
pub(crate) fn widened(value: Bounds, error: f64, cap: f64) -> Bounds {
    if value == Bounds::ZERO {
        return value;
    }
    if error.is_nan() || error > 1.0 {
        return Bounds {
            low: 0.0,
            high: cap,
        };
    }
    let margin = 2.0 * error + 4.0 * UNIT;
    let low = (value.low * (1.0 - margin)).next_down();
    let high = (value.high.max(SMALLEST_VALUE) * (1.0 + margin)).next_up();
    Bounds {
        low: if low < SMALLEST_VALUE {
            0.0
        } else {
            low.min(cap)
        },
        high: high.min(cap),
    }
}

/// Policy iteration, asked for by name, ended without bounds.
fn no_bounds_of_policy(states: usize) -> CheckError {
    CheckError::Unsupported(format!(
        "policy iteration on a component of {states} states ended with a scheduler around whose values no bounds can be \
         shown: use the sound or the exact method"
    ))
}

/// A state without choices and value, or with infinite ones only.
pub(crate) fn no_choice() -> CheckError {
    CheckError::Unsupported(
        "the values of a state grow beyond the range of floating point: use the exact method, or smaller numbers"
            .to_owned(),
    )
}
