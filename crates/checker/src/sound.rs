//! Unbounded reachability in a Markov chain with bounds that hold.
//!
//! *Problem.* The probabilities `x_i` of reaching a target set from each state, and `y_i` of reaching the
//! contrary set, given the states in which they are 0 and 1 ([`crate::graph::qualitative`]). On the other
//! states `x_i = sum_{j != i} p_ij x_j / sum_{j != i} p_ij`, and likewise `y`: the self-loop is eliminated and
//! the divisor is a sum, so nothing is subtracted, and probabilities of 1e-53 keep their digits.
//!
//! *Method.* Component by component in reverse topological order (Ciesinski, Baier, Größer and Klein 2008;
//! Dai, Strejček, Wu and Gupta 2011). A component of one state is substituted. A larger one is solved by
//! elimination within a budget where it is small or sparse; else by linear equations and slack ([`crate::optimum::slack`]);
//! failing that by interval iteration; failing that by elimination with a large budget. Both bounds of what lies below enter each component.
//!
//! *Guarantee.* The bounds contain the exact values. What is added at each component: rounding (the bounds
//! in the heads of [`crate::elimination`] and [`crate::interval_iteration`]) and `2 m e` for a component
//! of `m` states whose transition probabilities are off by a factor `1 + e` (matrix-tree theorem,
//! see [`crate::elimination`]; `e` = [`Context::entry_error`]). `x` and `y` are computed independently and improve
//! each other's bounds, as `x + y = 1`.
//!
//! *By linear equations or policies* ([`crate::Method`], in a chain the same): by elimination alone, whatever it costs.
//!
//! Cost: linear in transitions outside larger components.

use crate::answer::CheckError;
use crate::elimination::{GivenUp, System};
use crate::engine::Context;
use crate::graph::{Components, Qualitative};
use crate::interval_iteration::Iteration;
use crate::optimum::local::Local;
use crate::optimum::slack::Slack;
use crate::rounding::{Bounds, SMALLEST_ENTRY, UNIT};
use crate::state_space::Csr;

/// How much work is spent on one component by one way before the next is tried.
#[derive(Debug, Clone, Copy)]
struct Effort {
    /// Multiplications of the first elimination.
    first_budget: u64,
    /// Whether linear equations and slack are tried thereafter.
    equations: bool,
    /// Rounds of iteration thereafter.
    first_rounds: u64,
    /// Multiplications of the second elimination.
    second_budget: u64,
    /// Rounds of iteration when all else failed.
    last_rounds: u64,
}

/// Transitions that are looked at for better bounds once a check is stopped.
const LAST_WORK: u64 = 20_000_000;
/// Components of fewer states than this, or fewer transitions for each state, are eliminated first.
const EASY: usize = 1_000;
const SPARSE: usize = 4;

const EFFORT: Effort = Effort {
    first_budget: 100_000_000,
    equations: true,
    first_rounds: 20_000,
    second_budget: 50_000_000_000,
    last_rounds: 1_000_000,
};

/// Elimination alone.
const DIRECT: Effort = Effort {
    first_budget: u64::MAX,
    equations: false,
    first_rounds: 0,
    second_budget: 0,
    last_rounds: 0,
};

/// A probability and that of the contrary, each computed on its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probability {
    /// The probability.
    pub value: Bounds,
    /// The probability of the contrary.
    pub complement: Bounds,
}

impl Probability {
    /// Exactly 1 if `holds`, else exactly 0.
    pub(crate) fn indicator(holds: bool) -> Self {
        Self {
            value: Bounds::indicator(holds),
            complement: Bounds::indicator(!holds),
        }
    }

    /// From the probability alone.
    pub(crate) fn from_value(value: Bounds) -> Self {
        let complement = Bounds {
            low: if value.high >= 1.0 {
                0.0
            } else {
                (1.0 - value.high).next_down()
            },
            high: if value.low <= 0.0 {
                1.0
            } else {
                (1.0 - value.low).next_up()
            },
        };
        match value.is_exact() && (value.low == 0.0 || value.low == 1.0) {
            true => Self::indicator(value.low == 1.0),
            false => Self { value, complement },
        }
    }

    /// The contrary.
    pub(crate) fn contrary(self) -> Self {
        Self {
            value: self.complement,
            complement: self.value,
        }
    }

    /// From sums that were computed with this relative error.
    fn widened(value: Bounds, complement: Bounds, error: f64) -> Self {
        let (value, complement) = value
            .widened(error)
            .with_complement(complement.widened(error));
        Self { value, complement }
    }

    /// Like [`Self::widened`], but sums that are 0 are exact: they had no positive term.
    pub(crate) fn from_sums(value: Bounds, complement: Bounds, error: f64) -> Self {
        if value == Bounds::ZERO || complement == Bounds::ZERO {
            return Self::indicator(complement == Bounds::ZERO);
        }
        Self::widened(value, complement, error)
    }

    /// The mean over a state's transitions, one step before; its bounds allow for rounding.
    pub(crate) fn mean<'a>(
        transitions: impl Iterator<Item = (&'a f64, &'a Self)>,
        entry_error: f64,
    ) -> Self {
        let (mut value, mut complement, mut entries) = (Bounds::ZERO, Bounds::ZERO, 0);
        for (p, target) in transitions {
            accumulate(&mut value, *p, target.value);
            accumulate(&mut complement, *p, target.complement);
            entries += 1;
        }
        Self::from_sums(value, complement, entry_error + (entries + 1) as f64 * UNIT)
    }
}

/// Refuses matrices whose entries are too small for the error bounds.
pub(crate) fn check_entries(matrix: &Csr<f64>) -> Result<(), CheckError> {
    match matrix.value.iter().find(|value| **value < SMALLEST_ENTRY) {
        Some(value) => Err(CheckError::Unsupported(format!(
            "a transition has the probability {value:e}, too small for floating point with sound \
             bounds; use the exact method"
        ))),
        None => Ok(()),
    }
}

/// Probabilities of reaching the target, the states of `sets.surely`, and how many rounds of iteration
/// were needed.
pub(crate) fn reachability(
    matrix: &Csr<f64>,
    sets: &Qualitative,
    context: &Context<'_>,
) -> Result<(Vec<Probability>, u64), CheckError> {
    let effort = match context.options.method.is_direct() {
        true => DIRECT,
        false => EFFORT,
    };
    reachability_with(matrix, sets, context, effort)
}

fn reachability_with(
    matrix: &Csr<f64>,
    sets: &Qualitative,
    context: &Context<'_>,
    effort: Effort,
) -> Result<(Vec<Probability>, u64), CheckError> {
    let result = sets
        .surely
        .iter()
        .map(|surely| Probability::indicator(*surely))
        .collect();
    let open = |(surely, never): (&bool, &bool)| !surely && !never;
    let open: Vec<bool> = sets.surely.iter().zip(&sets.never).map(open).collect();
    let mut solver = Solver {
        matrix,
        context,
        effort,
        local: vec![u32::MAX; matrix.num_rows()],
        result,
        iterations: 0,
        last_work: LAST_WORK,
    };
    for (index, component) in Components::new(matrix, &open).iter().enumerate() {
        if index % 4096 == 0 && !context.options.must_stop() {
            context.options.check_cancelled()?;
        }
        match component {
            [state] => solver.substitute(*state as usize),
            _ => solver.solve_or_enclose(component)?,
        }
    }
    Ok((solver.result, solver.iterations))
}

struct Solver<'a> {
    matrix: &'a Csr<f64>,
    context: &'a Context<'a>,
    effort: Effort,
    /// Position of a state in the component being solved.
    local: Vec<u32>,
    result: Vec<Probability>,
    iterations: u64,
    /// Transitions that may still be looked at once the check is stopped.
    last_work: u64,
}

impl Solver<'_> {
    /// A state that does not reach itself but by its self-loop.
    fn substitute(&mut self, state: usize) {
        let (mut total, mut entries) = (0.0, 0);
        let (mut value, mut complement) = (Bounds::ZERO, Bounds::ZERO);
        for (target, p) in self
            .matrix
            .row(state)
            .filter(|(target, _)| *target != state)
        {
            total += p;
            entries += 1;
            accumulate(&mut value, *p, self.result[target].value);
            accumulate(&mut complement, *p, self.result[target].complement);
        }
        let error = 2.0 * self.context.entry_error + (2 * entries + 2) as f64 * UNIT;
        let quotient = |sum: Bounds| Bounds {
            low: sum.low / total,
            high: sum.high / total,
        };
        self.store(state, quotient(value), quotient(complement), error);
    }

    fn store(&mut self, state: usize, value: Bounds, complement: Bounds, error: f64) {
        self.result[state] = Probability::widened(value, complement, error);
    }

    /// Solves a component; if that is stopped before it has bounds, by some rounds from the values right outside.
    fn solve_or_enclose(&mut self, component: &[u32]) -> Result<(), CheckError> {
        let options = self.context.options;
        if !options.must_stop() {
            match self.solve(component) {
                Err(CheckError::Cancelled) if options.must_stop() => {}
                other => return other,
            }
        }
        let system = self.system(component);
        let (outside, longest) = self.exits(component);
        let each = (system.rows.iter().map(Vec::len).sum::<usize>() + component.len()) as u64;
        let rounds = self.last_work / each;
        let mut iteration = Iteration::new(&system, outside);
        iteration.run(options.precision, rounds, &|| false);
        self.last_work = self.last_work.saturating_sub(iteration.rounds * each);
        self.keep(
            component,
            iteration,
            self.input_error(component.len(), longest),
        );
        Ok(())
    }

    /// Of the entries of the model, and of the sums over transitions that leave.
    fn input_error(&self, states: usize, longest: usize) -> f64 {
        2.0 * states as f64 * (self.context.entry_error + (longest + 2) as f64 * UNIT)
    }

    /// Keeps the bounds of an iteration.
    fn keep(&mut self, component: &[u32], iteration: Iteration, input_error: f64) {
        self.iterations += iteration.rounds;
        for (state, [low, high, contrary_low, contrary_high]) in
            component.iter().zip(iteration.bounds)
        {
            let value = Bounds { low, high };
            let complement = Bounds {
                low: contrary_low,
                high: contrary_high,
            };
            self.store(*state as usize, value, complement, input_error);
        }
    }

    fn solve(&mut self, component: &[u32]) -> Result<(), CheckError> {
        let system = self.system(component);
        let options = self.context.options;
        let cancelled = || options.is_cancelled();
        let width = |row: &Vec<_>| row.len();
        let longest = system.rows.iter().map(width).max().unwrap_or(0);
        let exits = self.exits(component);
        let input_error = self.input_error(component.len(), exits.1);
        let entries: usize = system.rows.iter().map(Vec::len).sum();
        let is_direct = self.effort.first_budget == u64::MAX;
        let is_easy = is_direct || component.len() < EASY || entries < SPARSE * component.len();
        let first = self.effort.first_budget;
        if is_easy && self.eliminate(component, system.clone(), first, input_error, &cancelled)? {
            return Ok(());
        }
        if is_direct {
            return Err(not_eliminated(component.len()));
        }
        let share = component.len() as f64 / self.matrix.num_rows() as f64;
        let floor = 64.0 * (longest + 4) as f64 * UNIT;
        let tolerance = (self.context.options.precision * share / 4.0).max(floor);
        if self.equations(component, &system, tolerance, input_error)? {
            return Ok(());
        }
        let mut iteration = Iteration::new(&system, exits.0);
        let is_done = iteration.run(tolerance, self.effort.first_rounds, &cancelled);
        if !is_done && !options.must_stop() {
            options.check_cancelled()?;
            let budget = self.effort.second_budget;
            match self.eliminate(component, system, budget, input_error, &cancelled) {
                Ok(true) => return Ok(()),
                Err(CheckError::Cancelled) if options.must_stop() => {}
                other => {
                    other?;
                    iteration.run(tolerance, self.effort.last_rounds, &cancelled);
                }
            }
            if !options.must_stop() {
                options.check_cancelled()?;
            }
        }
        self.keep(component, iteration, input_error);
        Ok(())
    }

    /// Solves a component by linear equations and slack ([`crate::optimum::slack`]); false if that gave no close bounds.
    fn equations(
        &mut self,
        component: &[u32],
        system: &System<f64, 5>,
        tolerance: f64,
        input_error: f64,
    ) -> Result<bool, CheckError> {
        if !self.effort.equations {
            return Ok(false);
        }
        let mut bounds: Vec<(Vec<f64>, Vec<f64>)> = Vec::with_capacity(2);
        for lanes in [[1, 2], [3, 4]] {
            let local = Local::of_chain(system, lanes);
            let slack = Slack {
                local: &local,
                maximise: true,
                tolerance,
                options: self.context.options,
            };
            let start = match bounds.first() {
                None => vec![0.0; component.len()],
                // The contrary's probability is what is left of one, up to rounding.
                Some((lower, upper)) => {
                    let pairs = lower.iter().zip(upper);
                    pairs
                        .map(|(low, high)| (1.0 - (low + high) / 2.0).max(0.0))
                        .collect()
                }
            };
            let found = slack.search(start)?;
            let (Some(lower), Some(upper), true) = (found.lower, found.upper, found.is_close)
            else {
                return Ok(false);
            };
            bounds.push((lower, upper));
        }
        for (place, state) in component.iter().enumerate() {
            let [value, complement] = [0, 1].map(|problem: usize| Bounds {
                low: bounds[problem].0[place],
                high: bounds[problem].1[place].min(1.0),
            });
            self.store(*state as usize, value, complement, input_error);
        }
        Ok(true)
    }

    /// Solves a component directly; false if that was given up.
    fn eliminate(
        &mut self,
        component: &[u32],
        system: System<f64, 5>,
        budget: u64,
        input_error: f64,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<bool, CheckError> {
        let solution = match system.solve(budget, cancelled) {
            Ok(solution) => solution,
            Err(GivenUp::Cancelled) => return Err(CheckError::Cancelled),
            Err(_) => return Ok(false),
        };
        let error = solution.relative_error + input_error;
        for (state, [_, low, high, contrary_low, contrary_high]) in
            component.iter().zip(solution.values)
        {
            let value = Bounds { low, high };
            let complement = Bounds {
                low: contrary_low,
                high: contrary_high,
            };
            self.store(*state as usize, value, complement, error);
        }
        Ok(true)
    }

    /// The equations of a component.
    fn system(&mut self, component: &[u32]) -> System<f64, 5> {
        for (position, state) in component.iter().enumerate() {
            self.local[*state as usize] = position as u32;
        }
        let mut system = System {
            rows: Vec::with_capacity(component.len()),
            rhs: Vec::with_capacity(component.len()),
        };
        for state in component {
            let (mut row, mut exit) = (Vec::new(), 0.0);
            let (mut value, mut complement) = (Bounds::ZERO, Bounds::ZERO);
            for (target, p) in self.matrix.row(*state as usize) {
                match self.local[target] {
                    u32::MAX => {
                        exit += p;
                        accumulate(&mut value, *p, self.result[target].value);
                        accumulate(&mut complement, *p, self.result[target].complement);
                    }
                    _ if target == *state as usize => {}
                    position => row.push((position, *p)),
                }
            }
            row.sort_unstable_by_key(|(column, _)| *column);
            system.rows.push(row);
            system
                .rhs
                .push([exit, value.low, value.high, complement.low, complement.high]);
        }
        component
            .iter()
            .for_each(|state| self.local[*state as usize] = u32::MAX);
        system
    }

    /// The least and greatest values right outside a component, and its longest row.
    fn exits(&mut self, component: &[u32]) -> ([Bounds; 2], usize) {
        component
            .iter()
            .for_each(|state| self.local[*state as usize] = 0);
        let nothing = Bounds {
            low: 1.0,
            high: 0.0,
        };
        let (mut outside, mut longest) = ([nothing; 2], 0);
        for state in component {
            let mut length = 0;
            for (target, _) in self.matrix.row(*state as usize) {
                length += 1;
                if self.local[target] == u32::MAX {
                    let here = [self.result[target].value, self.result[target].complement];
                    for (known, here) in outside.iter_mut().zip(here) {
                        known.low = known.low.min(here.low);
                        known.high = known.high.max(here.high);
                    }
                }
            }
            longest = longest.max(length);
        }
        component
            .iter()
            .for_each(|state| self.local[*state as usize] = u32::MAX);
        (outside, longest)
    }
}

/// Elimination of a component, asked for by name, was given up.
pub(crate) fn not_eliminated(states: usize) -> CheckError {
    CheckError::Unsupported(format!(
        "the equations of a component of {states} states cannot be solved by elimination in floating point, since \
         products become too small for it: use the sound or the exact method"
    ))
}

fn accumulate(sum: &mut Bounds, probability: f64, value: Bounds) {
    sum.low += probability * value.low;
    sum.high += probability * value.high;
}

#[cfg(test)]
mod tests;
