//! Schedulers for what counts for a number of steps only: the memory is how many were taken.
//!
//! *Definition.* With `n` steps left the choice is the one that attains `x_n = opt over c of r_c + sum_j p_cj
//! x_(n-1, j)`. For `left U[a,b] right` the first `a` steps must stay in `left`; then `right` ends it. Without `b`, what
//! is done after `a` steps is a scheduler by the state alone.
//!
//! Source: Puterman 1994, section 4.3. Cost: steps times transitions, and one number for each state and step.
//! Guarantee: that of the arithmetic; values that cannot be told apart count as equal.

use std::cmp::Ordering;

use crate::amount::Amount;
use crate::answer::{CheckError, Options};
use crate::choices::Choices;

use super::Policy;

/// Most decisions that are remembered.
const MOST_DECISIONS: u64 = 400_000_000;

/// Decisions by the number of steps left.
pub(crate) struct Countdown<'a, A: Amount> {
    choices: Choices<'a, A::Entry>,
    values: Vec<A>,
    /// With one step left, with two, and so on: the place of the choice among the state's.
    decisions: Vec<Vec<u32>>,
    maximise: bool,
    entry_error: f64,
}

impl<'a, A: Amount> Countdown<'a, A> {
    /// Before any step.
    pub fn new(
        choices: Choices<'a, A::Entry>,
        values: Vec<A>,
        maximise: bool,
        entry_error: f64,
    ) -> Self {
        Self {
            choices,
            values,
            decisions: Vec::new(),
            maximise,
            entry_error,
        }
    }

    /// So many steps more; states that are not active keep their value.
    pub fn steps(
        &mut self,
        steps: u64,
        active: impl Fn(usize) -> bool,
        reward: Option<&[A]>,
        options: &Options<'_>,
    ) -> Result<(), CheckError> {
        let states = self.values.len() as u64;
        let all = (self.decisions.len() as u64).saturating_add(steps);
        if all.saturating_mul(states) > MOST_DECISIONS {
            return Err(CheckError::Unsupported(format!(
                "a scheduler for {all} steps in {states} states has more than {MOST_DECISIONS} decisions, too many to \
                 be written: ask for fewer steps"
            )));
        }
        for _ in 0..steps {
            options.check_cancelled()?;
            let mut decided = vec![0; self.values.len()];
            let mut values = self.values.clone();
            for state in (0..values.len()).filter(|state| active(*state)) {
                if let Some((place, value)) = self.best(state, reward) {
                    (decided[state], values[state]) = (place, value);
                }
            }
            self.decisions.push(decided);
            self.values = values;
        }
        Ok(())
    }

    /// Sets the value of some states.
    pub fn set(&mut self, value: &A, of: impl Fn(usize) -> bool) {
        for state in (0..self.values.len()).filter(|state| of(*state)) {
            self.values[state] = value.clone();
        }
    }

    fn best(&self, state: usize, reward: Option<&[A]>) -> Option<(u32, A)> {
        let mut best: Option<(u32, A)> = None;
        for (place, row) in self.choices.rows(state).enumerate() {
            let entries = self.choices.matrix.row(row);
            let transitions = entries.map(|(target, p)| (p, &self.values[target]));
            let value = A::mean(reward.map(|r| &r[row]), transitions, self.entry_error);
            let better = |known: &A| {
                let order = value.compare(known).unwrap_or_else(|| {
                    let middle = |x: &A| x.bounds().middle();
                    middle(&value)
                        .partial_cmp(&middle(known))
                        .unwrap_or(Ordering::Equal)
                });
                order
                    == match self.maximise {
                        true => Ordering::Greater,
                        false => Ordering::Less,
                    }
            };
            if best.as_ref().is_none_or(|(_, known)| better(known)) {
                best = Some((place as u32, value));
            }
        }
        best
    }

    /// The policy; `over` says, after so many steps in a state, that nothing matters any more, `after` what is done
    /// after the last step.
    pub fn policy<F: Fn(u64, usize) -> bool>(
        self,
        over: F,
        after: Vec<Option<usize>>,
    ) -> CountdownPolicy<'a, A, F> {
        CountdownPolicy {
            countdown: self,
            over,
            after,
        }
    }
}

/// Decisions as a policy.
pub(crate) struct CountdownPolicy<'a, A: Amount, F> {
    countdown: Countdown<'a, A>,
    over: F,
    after: Vec<Option<usize>>,
}

impl<A: Amount, F: Fn(u64, usize) -> bool> CountdownPolicy<'_, A, F> {
    fn memory(&self, taken: u32, state: usize) -> u32 {
        let last = self.countdown.decisions.len() as u32;
        match taken >= last || (self.over)(u64::from(taken), state) {
            true => last,
            false => taken,
        }
    }
}

impl<A: Amount, F: Fn(u64, usize) -> bool> Policy for CountdownPolicy<'_, A, F> {
    type Key = u32;

    fn first(&mut self, _: usize, state: usize) -> u32 {
        self.memory(0, state)
    }

    fn row(&mut self, state: usize, taken: u32) -> Option<usize> {
        let decisions = &self.countdown.decisions;
        if taken as usize >= decisions.len() {
            return self.after.get(state).copied().flatten();
        }
        let left = decisions.len() - 1 - taken as usize;
        let row = self.countdown.choices.rows(state).start + decisions[left][state] as usize;
        Some(row)
    }

    fn next(&mut self, _: usize, taken: u32, _: usize, target: usize) -> u32 {
        self.memory(taken.saturating_add(1), target)
    }

    fn number(&mut self, taken: u32) -> u32 {
        taken
    }
}
