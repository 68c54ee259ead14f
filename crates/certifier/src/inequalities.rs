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
//! do: then the target is reached with probability 1, all states being finite on the way. A value is infinite where a
//! state is entered, with positive probability, that cannot reach the target (for the least value: whatever is chosen).
//! A scheduler, if there is one, takes the place of "some `c`".
//!
//! Cost: one sum for each choice and side, first in floating point with a bound of its error, in rationals where that
//! leaves it open; progress by rounds of backward search. Guarantee: exact.

use num_traits::{Signed, Zero};
use prism_lang::{Rational, rational_to_f64};

use crate::failure::Failure;
use crate::question::Question;
use crate::reading::{Choice, LOOK, Reading};

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

struct Checker<'a> {
    reading: &'a Reading,
    question: &'a Question,
    bounds: &'a Bounds,
    go_on: &'a dyn Fn() -> bool,
    count: u64,
}

/// Checks all inequalities; says how many.
///
/// # Errors
/// The first that does not hold; [`Failure::Cancelled`] if `go_on`, which is asked now and then, says no.
pub fn check(
    reading: &Reading,
    question: &Question,
    bounds: &Bounds,
    go_on: &dyn Fn() -> bool,
) -> Result<u64, Failure> {
    let mut checker = Checker {
        reading,
        question,
        bounds,
        go_on,
        count: 0,
    };
    checker.ends()?;
    for side in [Side::Lower, Side::Upper] {
        let meets = checker.inductive(side)?;
        checker.progress(side, &meets)?;
    }
    checker.infinite()?;
    Ok(checker.count)
}

impl Checker<'_> {
    fn values(&self, side: Side) -> &[f64] {
        match side {
            Side::Lower => &self.bounds.lower,
            Side::Upper => &self.bounds.upper,
        }
    }

    fn is_open(&self, state: usize) -> bool {
        !self.reading.target[state] && !self.reading.failed[state]
    }

    fn broken(&self, state: usize, what: &str) -> Failure {
        Failure::Broken {
            state: self.reading.states[state].clone(),
            what: what.to_owned(),
        }
    }

    /// In the target, and where it can no longer be reached.
    fn ends(&self) -> Result<(), Failure> {
        let at_target = if self.question.reward.is_some() {
            0.0
        } else {
            1.0
        };
        for state in 0..self.reading.states.len() {
            let (low, high) = (self.bounds.lower[state], self.bounds.upper[state]);
            if low.is_nan() || high.is_nan() || low > high {
                return Err(self.broken(state, "the lower bound exceeds the upper one"));
            }
            if high < 0.0 {
                return Err(self.broken(state, "the upper bound is negative, as no value is"));
            }
            let value = match (self.reading.target[state], self.reading.failed[state]) {
                (true, _) => at_target,
                (_, true) => 0.0,
                _ => continue,
            };
            if low > value || high < value {
                return Err(self.broken(state, "the value is known, and not between the bounds"));
            }
        }
        Ok(())
    }

    /// Which choices meet the inequality of a side, in each open state.
    fn inductive(&mut self, side: Side) -> Result<Vec<Vec<bool>>, Failure> {
        let for_all = self.question.maximise == (side == Side::Upper);
        let mut all = Vec::with_capacity(self.reading.states.len());
        for (state, choices) in self.reading.choices.iter().enumerate() {
            if state.is_multiple_of(LOOK) && !(self.go_on)() {
                return Err(Failure::Cancelled);
            }
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
                return Err(self.broken(state, &format!("the {which} bound is not inductive")));
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
            _ => compared(side, own, choice, values),
        }
    }

    /// That the target is reached where a bound needs it.
    fn progress(&mut self, side: Side, meets: &[Vec<bool>]) -> Result<(), Failure> {
        let is_reward = self.question.reward.is_some();
        if is_reward == (side == Side::Lower) {
            return Ok(());
        }
        // The lower bound of a probability, or the upper one of a reward.
        let by_all = self.question.maximise == (side == Side::Upper);
        let may = |state: usize, choice: usize| meets[state].get(choice) == Some(&true);
        let reached = self.reached(&self.reading.target, by_all, may);
        for (state, reached) in reached.iter().enumerate() {
            let value = self.values(side)[state];
            let needs = match is_reward {
                true => value.is_finite(),
                false => value > 0.0,
            };
            if needs && self.is_open(state) && !reached {
                return Err(self.broken(state, "the bound makes no progress towards the target"));
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
        let mut reached = goal.to_vec();
        loop {
            let mut changed = false;
            for state in (0..goal.len()).rev() {
                if reached[state] || !self.is_open(state) {
                    continue;
                }
                let leads = |c: &Choice| c.outcomes.iter().any(|(t, _)| reached[*t]);
                let choices = &self.reading.choices[state];
                let holds = match by_all {
                    true => choices.iter().all(leads),
                    false => (choices.iter().enumerate()).any(|(at, c)| may(state, at) && leads(c)),
                };
                changed |= holds;
                reached[state] = holds;
            }
            if !changed {
                return reached;
            }
        }
    }

    /// That values that are said to be infinite are.
    fn infinite(&self) -> Result<(), Failure> {
        if self.bounds.lower.iter().all(|value| value.is_finite()) {
            return Ok(());
        }
        let possible = self.reached(&self.reading.target, false, |_, _| true);
        let never: Vec<bool> = possible.iter().map(|possible| !possible).collect();
        let misses = self.reached(&never, !self.question.maximise, |_, _| true);
        for (state, misses) in misses.iter().enumerate() {
            let value = self.bounds.lower[state];
            if value.is_infinite() && (value < 0.0 || self.question.reward.is_none() || !misses) {
                return Err(self.broken(state, "the value is not shown to be infinite"));
            }
        }
        Ok(())
    }
}

/// Whether `own >= F_c(values)` (upper) or `own <= F_c(values)` (lower), for finite numbers.
fn compared(side: Side, own: f64, choice: &Choice, values: &[f64]) -> bool {
    let mut sum = rational_to_f64(&choice.reward);
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
    exactly(side, own, choice, values)
}

fn exactly(side: Side, own: f64, choice: &Choice, values: &[f64]) -> bool {
    let exact = |value: f64| Rational::from_float(value).unwrap_or_else(Rational::zero);
    let mut sum = choice.reward.clone();
    for (target, p) in &choice.outcomes {
        sum += p * exact(values[*target]);
    }
    let difference = exact(own) - sum;
    match side {
        Side::Upper => !difference.is_negative(),
        Side::Lower => !difference.is_positive(),
    }
}
