//! The optimum with bounds that hold, rounding included.
//!
//! *Method.* Component by component in reverse topological order (Dai, Strejček, Wu and Gupta 2011). Within one:
//!
//! 1. without alternatives, elimination ([`crate::elimination`]) within a budget, as in [`crate::sound`];
//! 2. some rounds of value iteration from below in place (Gauss-Seidel), forwards and backwards in turn, with the lower and
//!    with the upper values outside; whenever it hardly moves, bounds just below and above are guessed and kept
//!    if they are inductive (optimistic value iteration, Hartmanns and Kaminski 2020, here on both sides);
//! 3. policy iteration by linear equations, and bounds by slack ([`super::slack`]);
//! 4. more rounds of value iteration;
//! 5. policy iteration (Howard 1960), each scheduler's chain solved by elimination; then the guess as before.
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

use super::local::{Local, OUTSIDE, Side};
use super::policy::leaving;
use super::slack::Slack;
use super::{Problem, Solution};
use crate::answer::{CheckError, Options};
use crate::choices::Choices;
use crate::elimination::GivenUp;
use crate::engine::Context;
use crate::graph::{Components, NO_ROW};
use crate::rounding::{Bounds, SMALLEST_VALUE, UNIT};

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

/// Components of fewer states than this are iterated without solving equations.
const SMALL: usize = 50;
/// Chains of fewer states than this, or fewer transitions for each state, are eliminated first.
const EASY: usize = 1_000;
const SPARSE: usize = 4;

/// Solves the problem; `cap` is an upper bound of all values that is known beforehand.
pub(crate) fn solve(
    problem: &Problem<f64, Bounds>,
    cap: f64,
    context: &Context<'_>,
) -> Result<Solution<Bounds>, CheckError> {
    solve_with(problem, cap, context, EFFORT)
}

pub(crate) fn solve_with(
    problem: &Problem<f64, Bounds>,
    cap: f64,
    context: &Context<'_>,
    effort: Effort,
) -> Result<Solution<Bounds>, CheckError> {
    let states = problem.num_states();
    let open: Vec<bool> = problem.fixed.iter().map(Option::is_none).collect();
    let choices = Choices::new(&problem.matrix, &problem.choice_start);
    let components = Components::of_choices(choices, &open, |_| true);
    let mut solver = Solver {
        problem,
        context,
        effort,
        cap,
        position: vec![OUTSIDE; states],
        values: (problem.fixed.iter())
            .map(|fixed| fixed.unwrap_or(Bounds::ZERO))
            .collect(),
        choice: vec![NO_ROW; states],
        iterations: 0,
    };
    for (index, component) in components.iter().enumerate() {
        if index % 4096 == 0 {
            context.options.check_cancelled()?;
        }
        match component {
            [state] => solver.substitute(*state as usize)?,
            _ => solver.component(component)?,
        }
    }
    Ok(Solution {
        values: solver.values,
        choice: solver.choice,
        iterations: solver.iterations,
    })
}

struct Solver<'a> {
    problem: &'a Problem<f64, Bounds>,
    context: &'a Context<'a>,
    effort: Effort,
    cap: f64,
    position: Vec<u32>,
    values: Vec<Bounds>,
    choice: Vec<usize>,
    iterations: u64,
}

impl Solver<'_> {
    /// A state that does not reach itself.
    fn substitute(&mut self, state: usize) -> Result<(), CheckError> {
        let mut best: Option<(Bounds, usize)> = None;
        let mut longest = 0;
        for row in self.problem.choice_start[state]..self.problem.choice_start[state + 1] {
            let mut sum = (self.problem.reward.get(row).copied()).unwrap_or(Bounds::ZERO);
            let (mut total, mut entries) = (0.0, 0);
            for (target, p) in self.problem.matrix.row(row) {
                total += p;
                entries += 1;
                sum.low += p * self.values[target].low;
                sum.high += p * self.values[target].high;
            }
            longest = longest.max(entries);
            let (low, high) = (sum.low / total, sum.high / total);
            let maximise = self.problem.maximise;
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
        self.context.entry_error + self.problem.merged as f64 * UNIT
    }

    fn store(&mut self, state: usize, value: Bounds, row: usize, error: f64) {
        self.values[state] = widened(value, error, self.cap);
        self.choice[state] = row;
    }

    fn component(&mut self, component: &[u32]) -> Result<(), CheckError> {
        // In the order in which they were explored, incomplete factors are better than in that of the search for components.
        let mut component = component.to_vec();
        component.sort_unstable();
        let component = &component[..];
        let local = Local::new(self.problem, component, &self.values, &mut self.position);
        let inputs = self.entry_error() + (local.longest_exit + 2) as f64 * UNIT;
        let input_error = 2.0 * component.len() as f64 * inputs;
        if local.is_chain() {
            let policy: Vec<usize> = (0..local.len()).collect();
            let is_simple = local.len() < EASY || local.entries() < SPARSE * local.len();
            let budget = if is_simple { self.effort.direct } else { 0 };
            if let Some((values, error)) = self.evaluate(&local, &policy, budget)? {
                self.keep(component, &local, values, &policy, input_error + error);
                return Ok(());
            }
        }
        let share = component.len() as f64 / self.problem.num_states() as f64;
        let floor = 4.0 * local.error;
        let mut search = Search {
            tolerance: (self.context.options.precision * share / 4.0).max(floor),
            maximise: self.problem.maximise,
            low: vec![0.0; local.len()],
            high: vec![0.0; local.len()],
            found: vec![(0.0, self.cap); local.len()],
            local: &local,
            rounds: 0,
        };
        let options = self.context.options;
        let cancelled = || options.cancel.is_some_and(|cancel| cancel());
        let mut solved = search.rounds(self.effort.before, &cancelled);
        if !solved && local.len() >= SMALL {
            solved = search.solve(options)?;
        }
        if !solved {
            solved = search.iterate(self.effort.iterate, &cancelled);
        }
        options.check_cancelled()?;
        if !solved {
            solved = self.improve_policies(&mut search)?;
        }
        if !solved {
            search.iterate(self.effort.last, &cancelled);
            options.check_cancelled()?;
        }
        self.iterations += search.rounds;
        let policy: Vec<usize> = (0..local.len())
            .map(|place| {
                local
                    .best(place, &search.low, Side::Low, self.problem.maximise)
                    .0
            })
            .collect();
        let bounds = (search.found.iter())
            .map(|(low, high)| Bounds {
                low: *low,
                high: *high,
            })
            .collect();
        self.keep(component, &local, bounds, &policy, input_error);
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
        let cancelled = || options.cancel.is_some_and(|cancel| cancel());
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

    /// Policy iteration; whether bounds around its result were found.
    fn improve_policies(&self, search: &mut Search<'_>) -> Result<bool, CheckError> {
        const ROUNDS: usize = 200;
        let local = search.local;
        let inside = |row: usize| &local.column[local.row_start[row]..local.row_start[row + 1]];
        let choices = |place: usize| local.choice_start[place]..local.choice_start[place + 1];
        let leaves = |row: usize| local.exit[row] > 0.0;
        let Some(mut policy) = leaving(local.len(), choices, inside, leaves) else {
            return Ok(false);
        };
        for _ in 0..ROUNDS {
            let Some((values, _)) = self.evaluate(local, &policy, self.effort.policy)? else {
                return Ok(false);
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
        Ok(search.guess(search.tolerance / 16.0) || search.guess(search.tolerance))
    }
}

/// The search for bounds of one component.
struct Search<'a> {
    local: &'a Local,
    maximise: bool,
    tolerance: f64,
    /// Approximations with the lower and upper values outside.
    low: Vec<f64>,
    high: Vec<f64>,
    /// Bounds that hold.
    found: Vec<(f64, f64)>,
    rounds: u64,
}

impl Search<'_> {
    /// Iterates until bounds are found or `work` multiplications are done; then what was reached gives what bounds it can.
    fn iterate(&mut self, work: u64, cancelled: &dyn Fn() -> bool) -> bool {
        if self.rounds(work, cancelled) {
            return true;
        }
        if self.local.is_one_sided() {
            self.high.clone_from(&self.low);
        }
        // What was reached from below is a lower bound when moved down by the error of a round.
        self.guess(self.tolerance.max(1e-3));
        false
    }

    /// Iterates until bounds are found or `work` multiplications are done.
    fn rounds(&mut self, work: u64, cancelled: &dyn Fn() -> bool) -> bool {
        let one_sided = self.local.is_one_sided();
        let each = (self.local.entries() + self.local.len()).max(1) as u64 * 2;
        let last = self.rounds + (work / each).max(64);
        let mut patience = self.tolerance / 10.0;
        while self.rounds < last {
            if self.rounds.is_multiple_of(16) && cancelled() {
                return false;
            }
            let mut low = std::mem::take(&mut self.low);
            let mut change = self.round(&mut low, Side::Low);
            self.low = low;
            if !one_sided {
                let mut high = std::mem::take(&mut self.high);
                change = change.max(self.round(&mut high, Side::High));
                self.high = high;
            }
            self.rounds += 1;
            if change <= patience {
                if one_sided {
                    self.high.clone_from(&self.low);
                }
                if self.guess(self.tolerance) {
                    return true;
                }
                if change == 0.0 {
                    break;
                }
                patience /= 4.0;
            }
        }
        false
    }

    /// By linear equations and slack ([`super::slack`]), from what iteration has reached; whether both bounds are close.
    fn solve(&mut self, options: &Options<'_>) -> Result<bool, CheckError> {
        let slack = Slack {
            local: self.local,
            maximise: self.maximise,
            tolerance: self.tolerance,
            options,
        };
        let confirmed = slack.search(self.low.clone())?;
        if let Some(lower) = &confirmed.lower {
            (self.found.iter_mut().zip(lower)).for_each(|(f, x)| f.0 = f.0.max(*x));
        }
        if let Some(upper) = &confirmed.upper {
            (self.found.iter_mut().zip(upper)).for_each(|(f, x)| f.1 = f.1.min(*x));
        }
        if confirmed.is_close {
            self.low = confirmed.candidate;
        }
        Ok(confirmed.is_close)
    }

    /// One round from below; the greatest relative change.
    fn round(&self, x: &mut [f64], side: Side) -> f64 {
        let mut change = 0f64;
        let states = x.len();
        for position in 0..states {
            let place = match self.rounds.is_multiple_of(2) {
                true => position,
                false => states - 1 - position,
            };
            let (_, value) = self.local.best(place, x, side, self.maximise);
            let known = x[place];
            if value > known {
                change = change.max((value - known) / value);
                x[place] = value;
            }
        }
        change
    }

    /// Tries bounds at this relative distance; whether both hold.
    fn guess(&mut self, distance: f64) -> bool {
        let distance = 0.45 * distance;
        let lower: Vec<f64> = self.low.iter().map(|x| x * (1.0 - distance)).collect();
        let upper: Vec<f64> = self.high.iter().map(|x| x * (1.0 + distance)).collect();
        let held = [
            self.inductive(lower, Side::Low, distance),
            self.inductive(upper, Side::High, distance),
        ];
        for (place, found) in self.found.iter_mut().enumerate() {
            if let Some(lower) = &held[0] {
                found.0 = found.0.max(lower[place]);
            }
            if let Some(upper) = &held[1] {
                found.1 = found.1.min(upper[place]);
            }
        }
        held.iter().all(Option::is_some)
    }

    /// The guess, or what some rounds make of it, if that is inductive.
    ///
    /// A guess that fails by much less than its distance is worth more rounds, forwards and backwards in turn: where a
    /// state's choice neither earns nor leaves, what is to spare has to arrive from other states first, and within one
    /// round the allowance for rounding adds up along the states that are looked at one after the other.
    fn inductive(&self, mut guess: Vec<f64>, side: Side, distance: f64) -> Option<Vec<f64>> {
        const FEW: usize = 6;
        const MANY: usize = 1000;
        /// Rounds in which what is missing has to become less.
        const SPAN: usize = 64;
        let error = match side {
            Side::Low => 1.0 - self.local.error,
            Side::High => 1.0 + self.local.error,
        };
        let by_rounding = 8.0 * self.local.error;
        let allowed = by_rounding.max(distance / 100.0);
        let states = guess.len();
        let mut worst_before = f64::INFINITY;
        for round in 0..MANY {
            let (mut holds, mut worst) = (true, 0.0_f64);
            for position in 0..states {
                let place = if round % 2 == 0 {
                    position
                } else {
                    states - 1 - position
                };
                let (_, value) = self.local.best(place, &guess, side, self.maximise);
                let (next, known) = (value * error, guess[place]);
                let missing = match side {
                    Side::Low => known - next,
                    Side::High => next - known,
                };
                if missing > 0.0 || missing.is_nan() {
                    holds = false;
                    let share = missing / known;
                    worst = worst.max(if share.is_nan() { f64::INFINITY } else { share });
                }
                guess[place] = next;
            }
            if holds {
                return Some(guess);
            }
            if round >= FEW && worst > allowed {
                return None;
            }
            if round % SPAN == SPAN - 1 {
                if worst > by_rounding && worst > 0.9 * worst_before {
                    return None;
                }
                worst_before = worst;
            }
        }
        None
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

/// A state without choices and value.
pub(crate) fn no_choice() -> CheckError {
    CheckError::Unsupported(
        "a state has no choice that ever ends; please report the model as an error of the checker"
            .to_owned(),
    )
}
