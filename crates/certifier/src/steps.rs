//! Values some steps earlier, in intervals.
//!
//! *Definition.* `x'_s = opt over c of r_c + sum_t p_ct x_t`, `k` times. Cost: steps times transitions. Guarantee:
//! containment, by directed rounding.

use crate::failure::Failure;
use crate::interval::Interval;
use crate::question::unsupported;
use crate::reading::Choice;

/// Most multiplications.
const MOST_WORK: u64 = 3_000_000_000;

/// Probabilities and rewards as intervals.
pub(crate) struct Rows {
    choices: Vec<Vec<Row>>,
    entries: u64,
}

/// A choice in intervals.
pub(crate) struct Row {
    outcomes: Vec<(usize, Interval)>,
    reward: Interval,
}

impl Row {
    pub fn new(choice: &Choice) -> Self {
        Self {
            outcomes: (choice.outcomes.iter())
                .map(|(target, p)| (*target, Interval::of(p)))
                .collect(),
            reward: Interval::of(&choice.reward),
        }
    }

    /// The mean of values after the step, and something more.
    pub fn mean(&self, more: Interval, values: &[Interval]) -> Interval {
        let outcomes = self.outcomes.iter();
        outcomes.fold(more, |sum, (target, p)| sum.add(&p.mul(&values[*target])))
    }
}

impl Rows {
    pub fn new(choices: &[Vec<Choice>]) -> Self {
        let choices: Vec<Vec<Row>> = (choices.iter())
            .map(|choices| choices.iter().map(Row::new).collect())
            .collect();
        let lengths = choices
            .iter()
            .flatten()
            .map(|row| row.outcomes.len() as u64);
        Self {
            entries: lengths.sum(),
            choices,
        }
    }

    /// Values so many steps earlier; states that are not active keep theirs. Before each step `cancelled` is asked.
    pub fn back(
        &self,
        mut values: Vec<Interval>,
        steps: u64,
        maximise: bool,
        active: &dyn Fn(usize) -> bool,
        with_rewards: bool,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Vec<Interval>, Failure> {
        for step in 0..steps {
            if cancelled() {
                return Err(Failure::Cancelled);
            }
            if step.saturating_mul(self.entries) > MOST_WORK {
                return Err(unsupported("so many steps of so large a model"));
            }
            let next: Vec<Interval> = (0..values.len())
                .map(|state| match active(state) {
                    true => self.best(state, &values, maximise, with_rewards),
                    false => values[state],
                })
                .collect();
            if next == values {
                break;
            }
            values = next;
        }
        Ok(values)
    }

    fn best(
        &self,
        state: usize,
        values: &[Interval],
        maximise: bool,
        with_rewards: bool,
    ) -> Interval {
        let value = |row: &Row| {
            let start = match with_rewards {
                true => row.reward,
                false => Interval::ZERO,
            };
            row.mean(start, values)
        };
        let values = self.choices[state].iter().map(value);
        let best = values.reduce(|a, b| a.best(&b, maximise));
        best.unwrap_or(Interval::ZERO)
    }
}
