//! The inequalities by which bounds of all states are shown to hold.
//!
//! *Definition.* `x` is a bound for each state; for a choice `c` of state `s` let
//! `F_c(x) = r_c + sum_t p_ct x_t`. In the target `x` is 1 (0 for rewards); where the target can no longer be reached
//! because what must hold before does not, it is 0. Elsewhere:
//!
//! ```text
//! greatest value   upper u:  u_s >= F_c(u) for all c              lower l:  l_s <= F_c(l) for some c
//! least value      upper u:  u_s >= F_c(u) for some c             lower l:  l_s <= F_c(l) for all c
//! ```
//!
//! *Why that suffices.* Probabilities: an upper bound that is inductive is at least the least solution, which is the
//! value. A lower bound also has to make progress: where it is positive, the target must be reachable (by the choices
//! that meet the inequality; for the least value by every choice), else every number would do in a cycle. Rewards: here
//! lower bounds need no progress, since a path that misses the target for ever counts as infinite; finite upper bounds
//! do: then the target is reached with probability 1, all states being finite on the way. A greatest value is infinite where
//! a state is entered, with positive probability, from which some choices avoid the target for ever; a least one where no
//! scheduler reaches the target almost surely.
//! A scheduler, if there is one, takes the place of "some `c`".
//!
//! Cost: one sum for each choice and side, first in floating point with a bound of its error, in rationals where that
//! leaves it open; progress by backward search. Guarantee: exact.

use num_traits::{Signed, Zero};
use prism_lang::{Rational, rational_to_f64};

use crate::failure::Failure;
use crate::incoming::Incoming;
use crate::question::Question;
use crate::reading::{Choice, Reading};

/// Bounds in the order of a reading's states.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// Lower bounds.
    pub lower: Vec<f64>,
    /// Upper bounds.
    pub upper: Vec<f64>,
    /// The choice that is taken in each state, where one is said.
    pub scheduler: Option<Vec<Option<usize>>>,
}

/// The side of a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Lower,
    Upper,
}

/// What is to be reached, or earned before.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// The choices of each state.
    pub choices: &'a [Vec<Choice>],
    /// What is to be reached.
    pub target: &'a [bool],
    /// Where it can no longer be.
    pub failed: &'a [bool],
    /// Whether the expected reward before the target is meant, else the probability of reaching it.
    pub is_reward: bool,
    /// Whether the greatest value over schedulers is meant, else the least.
    pub maximise: bool,
}

struct Checker<'a> {
    problem: Problem<'a>,
    bounds: &'a Bounds,
    /// The values themselves, where they are claimed; the bounds are then what is next to them.
    exact: Option<&'a [Option<Rational>]>,
    incoming: Incoming,
    count: u64,
}

/// Checks all inequalities; says how many.
///
/// # Errors
/// The first that does not hold: the number of the state, and what does not hold there.
pub fn check_problem(problem: Problem<'_>, bounds: &Bounds) -> Result<u64, (usize, String)> {
    let mut checker = Checker {
        problem,
        bounds,
        exact: None,
        incoming: Incoming::new(problem.choices),
        count: 0,
    };
    checker.all()
}

/// Checks that these are the values themselves (none: infinite), as both bounds at once; says how many inequalities hold.
///
/// # Errors
/// The first that does not hold: the number of the state, and what does not hold there.
pub fn check_exact(
    problem: Problem<'_>,
    values: &[Option<Rational>],
) -> Result<u64, (usize, String)> {
    if values.len() != problem.choices.len() {
        return Err(broken(0, "the values are not as many as the states"));
    }
    // Which are positive, and which infinite, is all that is asked of these.
    let near = |value: &Option<Rational>| match value {
        None => f64::INFINITY,
        Some(value) if value.is_positive() => rational_to_f64(value).max(f64::MIN_POSITIVE),
        Some(value) => rational_to_f64(value),
    };
    let near: Vec<f64> = values.iter().map(near).collect();
    let bounds = Bounds {
        lower: near.clone(),
        upper: near,
        scheduler: None,
    };
    let mut checker = Checker {
        problem,
        bounds: &bounds,
        exact: Some(values),
        incoming: Incoming::new(problem.choices),
        count: 0,
    };
    checker.all()
}

/// Checks all inequalities; says how many.
///
/// # Errors
/// The first that does not hold.
pub fn check(reading: &Reading, question: &Question, bounds: &Bounds) -> Result<u64, Failure> {
    let problem = Problem {
        choices: &reading.choices,
        target: &reading.target,
        failed: &reading.failed,
        is_reward: question.reward.is_some(),
        maximise: question.maximise,
    };
    check_problem(problem, bounds).map_err(|(state, what)| Failure::Broken {
        state: reading.states[state].clone(),
        what,
    })
}

impl Checker<'_> {
    fn all(&mut self) -> Result<u64, Broken> {
        self.ends()?;
        for side in [Side::Lower, Side::Upper] {
            let meets = self.inductive(side)?;
            self.progress(side, &meets)?;
        }
        self.infinite()?;
        Ok(self.count)
    }

    fn values(&self, side: Side) -> &[f64] {
        match side {
            Side::Lower => &self.bounds.lower,
            Side::Upper => &self.bounds.upper,
        }
    }

    fn is_open(&self, state: usize) -> bool {
        !self.problem.target[state] && !self.problem.failed[state]
    }

    /// In the target, and where it can no longer be reached.
    fn ends(&self) -> Result<(), Broken> {
        let at_target = if self.problem.is_reward { 0.0 } else { 1.0 };
        for state in 0..self.problem.choices.len() {
            let (low, high) = (self.bounds.lower[state], self.bounds.upper[state]);
            if low.is_nan() || high.is_nan() || low > high {
                return Err(broken(state, "the lower bound exceeds the upper one"));
            }
            if high < 0.0 {
                return Err(broken(state, "the upper bound is negative, as no value is"));
            }
            let value = match (self.problem.target[state], self.problem.failed[state]) {
                (true, _) => at_target,
                (_, true) => 0.0,
                _ => continue,
            };
            let is_other = |exact: &[Option<Rational>]| exact[state] != Rational::from_float(value);
            if low > value || high < value || self.exact.is_some_and(is_other) {
                return Err(broken(
                    state,
                    "the value is known, and not between the bounds",
                ));
            }
        }
        Ok(())
    }

    /// Which choices meet the inequality of a side, in each open state.
    fn inductive(&mut self, side: Side) -> Result<Vec<Vec<bool>>, Broken> {
        let for_all = self.problem.maximise == (side == Side::Upper);
        let mut all = Vec::with_capacity(self.problem.choices.len());
        for (state, choices) in self.problem.choices.iter().enumerate() {
            if !self.is_open(state) {
                all.push(Vec::new());
                continue;
            }
            self.count += choices.len() as u64;
            let mut meets: Vec<bool> = (choices.iter())
                .map(|choice| self.meets(side, state, choice))
                .collect();
            let taken = self.bounds.scheduler.as_ref().and_then(|s| s[state]);
            if let (false, Some(taken)) = (for_all, taken) {
                // Only what the scheduler takes counts.
                let keep = |(place, meets): (usize, bool)| meets && place == taken;
                meets = meets.into_iter().enumerate().map(keep).collect();
            }
            let holds = match for_all {
                true => meets.iter().all(|m| *m),
                false => meets.iter().any(|m| *m),
            };
            if !holds {
                let which = if side == Side::Lower {
                    "lower"
                } else {
                    "upper"
                };
                return Err(broken(
                    state,
                    &format!("the {which} bound is not inductive"),
                ));
            }
            all.push(meets);
        }
        Ok(all)
    }

    /// Whether a choice meets the inequality.
    fn meets(&self, side: Side, state: usize, choice: &Choice) -> bool {
        let values = self.values(side);
        let own = values[state];
        let infinite = choice
            .outcomes
            .iter()
            .any(|(t, _)| values[*t].is_infinite());
        match (side, own.is_infinite(), infinite) {
            // Infinite lower bounds are shown elsewhere.
            (Side::Lower, true, _) | (Side::Lower, _, true) => true,
            (Side::Upper, true, _) => true,
            (Side::Upper, false, true) => false,
            _ => match self.exact {
                None => compared(side, own, choice, values, self.problem.is_reward),
                Some(exact) => {
                    let of = |state: usize| exact[state].clone().unwrap_or_else(Rational::zero);
                    met(side, &of(state), choice, of, self.problem.is_reward)
                }
            },
        }
    }

    /// That the target is reached where a bound needs it.
    fn progress(&mut self, side: Side, meets: &[Vec<bool>]) -> Result<(), Broken> {
        let is_reward = self.problem.is_reward;
        if is_reward == (side == Side::Lower) {
            return Ok(());
        }
        // The lower bound of a probability, or the upper one of a reward.
        let by_all = self.problem.maximise == (side == Side::Upper);
        let may = |state: usize, choice: usize| meets[state].get(choice) == Some(&true);
        let reached = self.reached(self.problem.target, by_all, may);
        for (state, reached) in reached.iter().enumerate() {
            let value = self.values(side)[state];
            let needs = match is_reward {
                true => value.is_finite(),
                false => value > 0.0,
            };
            if needs && self.is_open(state) && !reached {
                return Err(broken(
                    state,
                    "the bound makes no progress towards the target",
                ));
            }
        }
        Ok(())
    }

    /// The states from which `goal` is reached with positive probability: by every choice, or by one that may be taken.
    fn reached(
        &self,
        goal: &[bool],
        by_all: bool,
        may: impl Fn(usize, usize) -> bool,
    ) -> Vec<bool> {
        let choices = self.problem.choices;
        // How many choices lead there already does not matter if one is enough.
        let mut missing: Vec<usize> = match by_all {
            true => choices.iter().map(Vec::len).collect(),
            false => vec![1; choices.len()],
        };
        let mut leads: Vec<Vec<bool>> = choices.iter().map(|own| vec![false; own.len()]).collect();
        let mut reached = goal.to_vec();
        let is_next = |state: usize, missing: usize| missing == 0 && self.is_open(state);
        for (state, missing) in missing.iter().enumerate() {
            reached[state] |= is_next(state, *missing);
        }
        let mut queue: Vec<usize> = (0..goal.len()).filter(|state| reached[*state]).collect();
        while let Some(state) = queue.pop() {
            for (from, place) in self.incoming.of(state) {
                if reached[from]
                    || !by_all && !may(from, place)
                    || std::mem::replace(&mut leads[from][place], true)
                {
                    continue;
                }
                missing[from] = missing[from].saturating_sub(1);
                if is_next(from, missing[from]) {
                    reached[from] = true;
                    queue.push(from);
                }
            }
        }
        reached
    }

    /// That values that are said to be infinite are.
    fn infinite(&self) -> Result<(), Broken> {
        if self.bounds.lower.iter().all(|value| value.is_finite()) {
            return Ok(());
        }
        let misses = match self.problem.maximise {
            true => {
                let avoids = self.avoiding();
                self.reached(&avoids, false, |_, _| true)
            }
            false => (self.almost_sure().iter().map(|sure| !sure)).collect(),
        };
        for (state, misses) in misses.iter().enumerate() {
            let value = self.bounds.lower[state];
            if value.is_infinite() && (value < 0.0 || !self.problem.is_reward || !misses) {
                return Err(broken(state, "the value is not shown to be infinite"));
            }
        }
        Ok(())
    }
}

/// The graph of choices.
impl Checker<'_> {
    /// The states from which some choices avoid the target for ever: the greatest set that can be stayed in.
    fn avoiding(&self) -> Vec<bool> {
        let mut stays: Vec<bool> = self.problem.target.iter().map(|target| !target).collect();
        let mut on = self.all_on();
        let without = |state: &usize| on[*state].is_empty();
        let leaving: Vec<usize> = (0..stays.len())
            .filter(|state| !stays[*state] || without(state))
            .collect();
        leaving.iter().for_each(|state| stays[*state] = false);
        let along = self.incoming.unravel(leaving, &mut on, |_| false);
        along.into_iter().for_each(|state| stays[state] = false);
        stays
    }

    /// The states from which some choices reach the target almost surely: the greatest set in which it can be reached by
    /// choices that do not leave the set.
    fn almost_sure(&self) -> Vec<bool> {
        let target = self.problem.target;
        let mut sure = vec![true; target.len()];
        let mut on = self.all_on();
        loop {
            let next = self.reached(target, false, |state, place| on[state][place]);
            let lost: Vec<usize> = (0..sure.len())
                .filter(|state| sure[*state] && !next[*state])
                .collect();
            if lost.is_empty() {
                return sure;
            }
            lost.iter().for_each(|state| sure[*state] = false);
            let along = self.incoming.unravel(lost, &mut on, |state| target[state]);
            along.into_iter().for_each(|state| sure[state] = false);
        }
    }

    fn all_on(&self) -> Vec<Vec<bool>> {
        let choices = self.problem.choices.iter();
        choices.map(|own| vec![true; own.len()]).collect()
    }
}

/// A state and what does not hold there.
type Broken = (usize, String);

fn broken(state: usize, what: &str) -> Broken {
    (state, what.to_owned())
}

/// Whether `own >= F_c(values)` (upper) or `own <= F_c(values)` (lower), for finite numbers.
fn compared(side: Side, own: f64, choice: &Choice, values: &[f64], is_reward: bool) -> bool {
    let mut sum = match is_reward {
        true => rational_to_f64(&choice.reward),
        false => 0.0,
    };
    for (target, p) in &choice.outcomes {
        sum += rational_to_f64(p) * values[*target];
    }
    // Each number is rounded once, each product and sum, too; nothing is negative. Doubled to be safe.
    let error = (choice.outcomes.len() as f64 + 4.0) * sum.abs() * 4.0 * f64::EPSILON + 1e-300;
    let difference = own - sum;
    let nonnegative = own >= 0.0 && choice.outcomes.iter().all(|(t, _)| values[*t] >= 0.0);
    if nonnegative && difference.abs() > error {
        return (difference > 0.0) == (side == Side::Upper);
    }
    exactly(side, own, choice, values, is_reward)
}

fn exactly(side: Side, own: f64, choice: &Choice, values: &[f64], is_reward: bool) -> bool {
    let exact = |value: f64| Rational::from_float(value).unwrap_or_else(Rational::zero);
    met(
        side,
        &exact(own),
        choice,
        |state| exact(values[state]),
        is_reward,
    )
}

/// The same for rational numbers.
fn met(
    side: Side,
    own: &Rational,
    choice: &Choice,
    value: impl Fn(usize) -> Rational,
    is_reward: bool,
) -> bool {
    let mut sum = match is_reward {
        true => choice.reward.clone(),
        false => Rational::zero(),
    };
    for (target, p) in &choice.outcomes {
        sum += p * value(*target);
    }
    match side {
        Side::Upper => *own >= sum,
        Side::Lower => *own <= sum,
    }
}
