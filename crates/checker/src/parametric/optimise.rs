//! The best choices in a region of parameters, proved for all its points.
//!
//! *Method.* At the middle of the region the problem is solved in rational arithmetic ([`crate::optimum::exact`]).
//! The chain that its scheduler induces is solved for all points by elimination. The scheduler is best at every
//! point at which no choice improves on these functions: `v - (r_c + sum_j p_cj v_j) / sum_j p_cj` must not be
//! negative (max; not positive for min) for any choice `c`, and by the equations' having one solution that
//! suffices. Signs are taken from Bernstein coefficients ([`super::region`]); where one is not known, the caller may
//! split the region. Source: Hahn, Han and Zhang 2011, "Synthesis for PCTL in Parametric Markov Decision Processes",
//! section 4. Deviation: the proof by Bernstein coefficients instead of a solver for real arithmetic.
//!
//! Guarantee: exact on the region, or "not known".

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use prism_lang::{Arithmetic, Rational};

use super::amount::FunctionAmount;
use super::engine::{Solver, choices_left};
use super::function::RationalFunction;
use super::region::{Region, Sign};
use crate::amount::Extended;
use crate::answer::CheckError;
use crate::choices::Choices;
use crate::engine::Context;
use crate::graph::{Components, NO_ROW};
use crate::optimum::{Problem, Solution, exact};
use crate::state_space::Csr;

type Functions = Problem<RationalFunction, FunctionAmount>;

/// What a scheduler's chain has for values, and how much each other choice would add: the same in every region.
#[derive(Debug)]
pub(crate) struct Known {
    values: Vec<RationalFunction>,
    advantages: Vec<RationalFunction>,
}

/// The schedulers of a property's problems that were looked at, by the problem's place and the choices.
pub(crate) type Schedulers = Mutex<BTreeMap<(usize, Vec<usize>), Arc<Known>>>;

/// A region in which a property's problems are solved, one after the other.
#[derive(Debug)]
pub(crate) struct Cell<'a> {
    pub(super) region: &'a Region,
    schedulers: &'a Schedulers,
    problems: AtomicUsize,
}

impl<'a> Cell<'a> {
    pub(crate) fn new(region: &'a Region, schedulers: &'a Schedulers) -> Self {
        Self {
            region,
            schedulers,
            problems: AtomicUsize::new(0),
        }
    }

    /// What is known of a scheduler of the next problem.
    fn known(
        &self,
        choice: &[usize],
        find: impl FnOnce() -> Result<Known, CheckError>,
    ) -> Result<Arc<Known>, CheckError> {
        let place = self.problems.fetch_add(1, Ordering::Relaxed);
        let mut all = self
            .schedulers
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let key = (place, choice.to_vec());
        if let Some(known) = all.get(&key) {
            return Ok(Arc::clone(known));
        }
        let known = Arc::new(find()?);
        all.insert(key, Arc::clone(&known));
        Ok(known)
    }
}

/// Solves a problem for all points of the context's region.
pub(super) fn solve(
    problem: &Functions,
    context: &Context<'_>,
) -> Result<Solution<FunctionAmount>, CheckError> {
    let open: Vec<bool> = problem.fixed.iter().map(Option::is_none).collect();
    let is_chain = |s: usize| problem.choice_start[s + 1] - problem.choice_start[s] == 1;
    let first = |s: usize| {
        if open[s] {
            problem.choice_start[s]
        } else {
            NO_ROW
        }
    };
    if (0..open.len()).all(|s| !open[s] || is_chain(s)) {
        let choice: Vec<usize> = (0..open.len()).map(first).collect();
        let values = induced(problem, &open, &choice, context)?;
        return Ok(solution(values, choice));
    }
    let cell = context.cell.ok_or_else(choices_left)?;
    let at_centre = at(problem, &cell.region.centre()).ok_or_else(choices_left)?;
    let choice = exact::solve(&at_centre, context.options)?.choice;
    let known = cell.known(&choice, || Known::new(problem, &open, &choice, context))?;
    let wanted = match problem.maximise {
        true => Sign::Negative,
        false => Sign::Positive,
    };
    let is_no_better = |advantage| cell.region.sign(advantage) == wanted;
    match known.advantages.iter().all(is_no_better) {
        true => Ok(solution(known.values.clone(), choice)),
        false => Err(CheckError::OpenChoice),
    }
}

fn solution(values: Vec<RationalFunction>, choice: Vec<usize>) -> Solution<FunctionAmount> {
    Solution {
        values: values.into_iter().map(FunctionAmount::Finite).collect(),
        choice,
        iterations: 0,
    }
}

/// The values of the chain in which these choices are taken.
fn induced(
    problem: &Functions,
    open: &[bool],
    choice: &[usize],
    context: &Context<'_>,
) -> Result<Vec<RationalFunction>, CheckError> {
    let mut values = Vec::with_capacity(open.len());
    for fixed in &problem.fixed {
        values.push(match fixed {
            None => RationalFunction::zero(),
            Some(FunctionAmount::Finite(value)) => value.clone(),
            Some(_) => return Err(choices_left()),
        });
    }
    let mut chain = Csr::with_capacity(open.len());
    for row in choice {
        match *row {
            NO_ROW => chain.push_row([]),
            row => chain.push_row(problem.matrix.row(row).map(|(t, p)| (t as u32, p.clone()))),
        }
    }
    let reward = |state: usize| match choice[state] {
        NO_ROW => None,
        row => problem.reward.get(row).cloned(),
    };
    let rewards: Vec<FunctionAmount> = (0..open.len())
        .map(|s| reward(s).unwrap_or(FunctionAmount::Finite(RationalFunction::zero())))
        .collect();
    let mut solver = Solver::new(&chain, open.len(), context);
    for component in Components::of_choices(Choices::new(&chain, &[]), open, |_| true).iter() {
        solver.component(component, &rewards, &mut values)?;
    }
    Ok(values)
}

impl Known {
    fn new(
        problem: &Functions,
        open: &[bool],
        choice: &[usize],
        context: &Context<'_>,
    ) -> Result<Self, CheckError> {
        let values = induced(problem, open, choice, context)?;
        let mut advantages = Vec::new();
        for state in (0..open.len()).filter(|s| open[*s]) {
            context.options.check_cancelled()?;
            for row in problem.choice_start[state]..problem.choice_start[state + 1] {
                if row != choice[state] {
                    let advantage = advantage(problem, row, &values[state], &values)?;
                    if !advantage.is_zero() {
                        advantages.push(advantage);
                    }
                }
            }
        }
        Ok(Self { values, advantages })
    }
}

/// How much a choice adds to `value`.
fn advantage(
    problem: &Functions,
    row: usize,
    value: &RationalFunction,
    values: &[RationalFunction],
) -> Result<RationalFunction, CheckError> {
    let mut advantage = match problem.reward.get(row) {
        None => RationalFunction::zero(),
        Some(FunctionAmount::Finite(reward)) => reward.clone(),
        Some(_) => return Err(choices_left()),
    };
    for (target, p) in problem.matrix.row(row) {
        advantage = advantage.add(&p.mul(&values[target].sub(value)));
    }
    match advantage.is_too_large() {
        true => Err(super::engine::too_large()),
        false => Ok(advantage),
    }
}

/// The problem at a point; `None` if a function has no value there.
fn at(problem: &Functions, point: &[Rational]) -> Option<Problem<Rational, Extended>> {
    let value = |amount: &FunctionAmount| match amount {
        FunctionAmount::Finite(value) => value.at(point).map(Extended::Finite),
        _ => None,
    };
    let fixed = |amount: &Option<FunctionAmount>| match amount {
        None => Some(None),
        Some(amount) => value(amount).map(Some),
    };
    let entries = problem.matrix.value.iter().map(|p| p.at(point));
    Some(Problem {
        matrix: Csr {
            row_start: problem.matrix.row_start.clone(),
            column: problem.matrix.column.clone(),
            value: entries.collect::<Option<_>>()?,
        },
        choice_start: problem.choice_start.clone(),
        reward: problem.reward.iter().map(value).collect::<Option<_>>()?,
        fixed: problem.fixed.iter().map(fixed).collect::<Option<_>>()?,
        maximise: problem.maximise,
        merged: problem.merged,
    })
}
