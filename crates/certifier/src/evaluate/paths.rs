//! Probabilities of path formulas, and what an oracle is asked.

use prism_lang::property::{Path, TimeBound};

use super::{ATTEMPTS, Evaluator};
use crate::explicit::possible;
use crate::failure::Failure;
use crate::formula::Formula;
use crate::inequalities::{Bounds, Problem, check_problem};
use crate::interval::Interval;
use crate::question::unsupported;
use crate::reading::Choice;
use crate::steps::Rows;

impl Evaluator<'_> {
    /// The probability of a path formula in each state.
    pub fn path(&mut self, path: &Path, maximise: bool) -> Result<Vec<Interval>, Failure> {
        self.needs_probabilities()?;
        if let Path::Timed { .. } = path {
            return self.timed_path(path);
        }
        if path.has_time_bound() {
            return self.in_windows(path);
        }
        let mut sets = Vec::new();
        let formula = self.formula(path, &mut sets)?;
        let reading = self.reading()?;
        let indicator = |set: Vec<bool>| {
            let number = |holds| if holds { Interval::ONE } else { Interval::ZERO };
            set.into_iter().map(number).collect()
        };
        if let Some(set) = as_set(&formula, &sets, reading.states.len()) {
            return Ok(indicator(set));
        }
        let set = |of: &Formula| as_set(of, &sets, reading.states.len());
        match &formula {
            Formula::Next(of) => {
                if let Some(of) = set(of) {
                    let rows = Rows::new(&reading.choices);
                    let cancelled = || self.oracle.is_cancelled();
                    return rows.back(indicator(of), 1, maximise, &|_| true, false, &cancelled);
                }
            }
            Formula::Until(left, right, first, last) => {
                if let (Some(left), Some(right)) = (set(left), set(right)) {
                    return self.until(&left, &right, (*first, *last), maximise, false);
                }
            }
            Formula::Release(left, right, first, last) => {
                if let (Some(left), Some(right)) = (set(&left.negated()), set(&right.negated())) {
                    return self.until(&left, &right, (*first, *last), !maximise, true);
                }
            }
            _ => {}
        }
        self.on_product(&formula, &sets, maximise)
    }

    /// The probability of an until formula, or that of its contrary, which keeps its digits where it is small. Which of the
    /// schedulers count is said of the formula.
    fn until(
        &mut self,
        left: &[bool],
        right: &[bool],
        (first, last): (u64, Option<u64>),
        maximise: bool,
        contrary: bool,
    ) -> Result<Vec<Interval>, Failure> {
        let reading = self.reading()?;
        let number = |holds: bool| match holds != contrary {
            true => Interval::ONE,
            false => Interval::ZERO,
        };
        let rows = Rows::new(&reading.choices);
        let best = maximise != contrary;
        let mut values = match last {
            None => self.until_ever(&reading.choices, (left, right), maximise, contrary)?,
            Some(last) if last < first => vec![number(false); right.len()],
            Some(last) => {
                let start = right.iter().map(|holds| number(*holds)).collect();
                let open = |state: usize| left[state] && !right[state];
                let cancelled = || self.oracle.is_cancelled();
                rows.back(start, last - first, best, &open, false, &cancelled)?
            }
        };
        if first > 0 {
            // At the step before, `left` must hold, whether `right` does or not.
            for _ in 0..first {
                let cancelled = || self.oracle.is_cancelled();
                values = rows.back(values, 1, best, &|state| left[state], false, &cancelled)?;
                for (value, left) in values.iter_mut().zip(left) {
                    if !left {
                        *value = number(false);
                    }
                }
            }
        }
        Ok(values)
    }

    /// The same without bounds.
    fn until_ever(
        &mut self,
        choices: &[Vec<Choice>],
        (left, right): (&[bool], &[bool]),
        maximise: bool,
        contrary: bool,
    ) -> Result<Vec<Interval>, Failure> {
        if !contrary {
            return self.reached(choices, left, right, maximise);
        }
        if !self.is_chain() {
            let values = self.reached(choices, left, right, maximise)?;
            return Ok(values.iter().map(Interval::contrary).collect());
        }
        // A chain almost surely comes to the target, or to where it can no longer be reached.
        let open = |state: usize| left[state] && !right[state];
        let cut: Vec<Vec<Choice>> = (choices.iter().enumerate())
            .map(|(state, own)| if open(state) { own.clone() } else { Vec::new() })
            .collect();
        let missed: Vec<bool> = (possible(&cut, right).iter())
            .map(|possible| !possible)
            .collect();
        let waits: Vec<bool> = right.iter().map(|holds| !holds).collect();
        self.reached(choices, &waits, &missed, true)
    }

    /// The probability of passing through `left` to `right`, shown by inequalities.
    pub fn reached(
        &mut self,
        choices: &[Vec<Choice>],
        left: &[bool],
        right: &[bool],
        maximise: bool,
    ) -> Result<Vec<Interval>, Failure> {
        let failed: Vec<bool> = (left.iter().zip(right)).map(|(l, r)| !l && !r).collect();
        self.solved(Problem {
            choices,
            target: right,
            failed: &failed,
            is_reward: false,
            maximise,
        })
    }

    /// What an oracle says of a problem, if it is right.
    pub fn solved(&mut self, problem: Problem<'_>) -> Result<Vec<Interval>, Failure> {
        let states = problem.choices.len();
        let mut why = (0, "there are no bounds".to_owned());
        for attempt in 0..ATTEMPTS {
            let found = match attempt {
                0 => evident(&problem).or_else(|| self.oracle.bounds(&problem, 0)),
                attempt => self.oracle.bounds(&problem, attempt),
            };
            let Some(bounds) = found else {
                break;
            };
            if bounds.lower.len() != states || bounds.upper.len() != states {
                return Err(Failure::Incomplete(
                    "the bounds are not as many as the states".to_owned(),
                ));
            }
            match check_problem(problem, &bounds) {
                Ok(count) => {
                    self.inequalities += count;
                    let ends = bounds.lower.into_iter().zip(bounds.upper);
                    return Ok(ends.map(|(low, high)| Interval { low, high }).collect());
                }
                Err(found) => why = found,
            }
        }
        let state = self.reading()?.states.get(why.0).cloned();
        Err(Failure::Broken {
            state: state.unwrap_or_default(),
            what: why.1,
        })
    }

    /// A path formula over the sets of its state subformulas.
    pub fn formula(&mut self, path: &Path, sets: &mut Vec<Vec<bool>>) -> Result<Formula, Failure> {
        let window = |bound: &TimeBound| (bound.first_step(), bound.last_step());
        let until = |l: Formula, r: Formula, bound: &TimeBound| {
            let (first, last) = window(bound);
            Formula::Until(Box::new(l), Box::new(r), first, last)
        };
        Ok(match path {
            Path::State(state) => {
                let set = self.truths(state)?;
                // What holds everywhere, or nowhere, is still to be read: `X true` is decided one step later.
                let known = sets.iter().position(|known| *known == set);
                let number = known.unwrap_or_else(|| {
                    sets.push(set);
                    sets.len() - 1
                });
                Formula::Set(number, true)
            }
            Path::Not(a) => self.formula(a, sets)?.negated(),
            Path::And(a, b) => Formula::And(vec![self.formula(a, sets)?, self.formula(b, sets)?]),
            Path::Or(a, b) => Formula::Or(vec![self.formula(a, sets)?, self.formula(b, sets)?]),
            Path::Implies(a, b) => Formula::Or(vec![
                self.formula(a, sets)?.negated(),
                self.formula(b, sets)?,
            ]),
            Path::Iff(a, b) => {
                let (a, b) = (self.formula(a, sets)?, self.formula(b, sets)?);
                let neither = Formula::And(vec![a.negated(), b.negated()]);
                Formula::Or(vec![Formula::And(vec![a, b]), neither])
            }
            Path::Next(a) => Formula::Next(Box::new(self.formula(a, sets)?)),
            Path::Until { left, right, bound } => {
                until(self.formula(left, sets)?, self.formula(right, sets)?, bound)
            }
            Path::Finally { operand, bound } => {
                until(Formula::True, self.formula(operand, sets)?, bound)
            }
            Path::Globally { operand, bound } => {
                until(Formula::True, self.formula(operand, sets)?.negated(), bound).negated()
            }
            Path::WeakUntil { left, right, bound } => {
                let (l, r) = (self.formula(left, sets)?, self.formula(right, sets)?);
                let waits = Formula::And(vec![l.clone(), r.negated()]);
                let given_up = Formula::And(vec![l.negated(), r.negated()]);
                until(waits, given_up, bound).negated()
            }
            Path::Release { left, right, bound } => {
                let (l, r) = (self.formula(left, sets)?, self.formula(right, sets)?);
                until(l.negated(), r.negated(), bound).negated()
            }
            Path::Timed { .. } => {
                return Err(unsupported(
                    "a bound in time within another temporal operator",
                ));
            }
        })
    }
}

/// Values that need not be computed: nothing is open, or there is no target.
fn evident(problem: &Problem<'_>) -> Option<Bounds> {
    let mut ends = problem.target.iter().zip(problem.failed);
    if problem.target.contains(&true) && ends.any(|(target, failed)| !target && !failed) {
        return None;
    }
    let value = |target: &bool| match (target, problem.is_reward) {
        (true, false) => 1.0,
        (false, true) => f64::INFINITY,
        _ => 0.0,
    };
    let values: Vec<f64> = problem.target.iter().map(value).collect();
    Some(Bounds {
        lower: values.clone(),
        upper: values,
        scheduler: None,
    })
}

/// The states in which a formula without temporal operators holds.
pub(crate) fn as_set(formula: &Formula, sets: &[Vec<bool>], states: usize) -> Option<Vec<bool>> {
    let all = |of: &[Formula], start: bool, join: fn(bool, bool) -> bool| {
        of.iter().try_fold(vec![start; states], |all, next| {
            let next = as_set(next, sets, states)?;
            Some(all.into_iter().zip(next).map(|(a, b)| join(a, b)).collect())
        })
    };
    match formula {
        Formula::True => Some(vec![true; states]),
        Formula::False => Some(vec![false; states]),
        Formula::Set(set, holds) => Some(sets[*set].iter().map(|inside| inside == holds).collect()),
        Formula::And(of) => all(of, true, |a, b| a && b),
        Formula::Or(of) => all(of, false, |a, b| a || b),
        _ => None,
    }
}
