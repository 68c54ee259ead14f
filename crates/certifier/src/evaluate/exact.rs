//! Values as rational numbers, for comparisons that no interval decides.
//!
//! *Definition.* Values are rational where what is asked is reached, or earned before a target, or happens within steps. A
//! value that equals the bound it is compared with, as 1/6 does in `P>=1/6 [ .. ]`, lies in every interval around it; so
//! the number itself is asked of the oracle, and counts only if it solves all equations
//! (`check_exact` of the module `inequalities`). Steps are taken back in rationals.
//!
//! Cost: that of exact solving, asked for only where intervals leave a comparison open; numbers grow with the steps, of
//! which few are taken. Guarantee: exact.

use num_traits::{One, Zero};
use prism_lang::ast::{BinaryOp, Optimum};
use prism_lang::property::{Horizon, Path, Quantity, RewardObjective, RewardQuery};
use prism_lang::{Comparison, Rational};

use super::{Evaluator, open, paths::as_set};
use crate::failure::Failure;
use crate::formula::Formula;
use crate::inequalities::{Problem, check_exact};
use crate::reading::{Choice, Part};

/// Most steps in rationals, and most of them times transitions.
const MOST_STEPS: u64 = 1_000;
const MOST_WORK: u64 = 1_000_000;

/// A value; none where it is infinite.
pub(crate) type Exact = Option<Rational>;

impl Evaluator<'_> {
    /// The probability of a path formula in each state.
    pub(super) fn exact_path(
        &mut self,
        path: &Path,
        maximise: bool,
    ) -> Result<Vec<Exact>, Failure> {
        self.needs_probabilities()?;
        if path.has_time_bound() {
            return Err(open());
        }
        let mut sets = Vec::new();
        let formula = self.formula(path, &mut sets)?;
        let reading = self.reading()?;
        let states = reading.states.len();
        let set = |of: &Formula| as_set(of, &sets, states);
        if let Some(set) = set(&formula) {
            return Ok(indicator(&set));
        }
        match &formula {
            Formula::Next(of) => {
                if let Some(of) = set(of) {
                    return back(
                        &reading.choices,
                        indicator(&of),
                        1,
                        maximise,
                        &|_| true,
                        false,
                    );
                }
            }
            Formula::Until(left, right, first, last) => {
                if let (Some(left), Some(right)) = (set(left), set(right)) {
                    return self.exact_until(&left, &right, (*first, *last), maximise);
                }
            }
            Formula::Release(left, right, first, last) => {
                if let (Some(left), Some(right)) = (set(&left.negated()), set(&right.negated())) {
                    let values = self.exact_until(&left, &right, (*first, *last), !maximise)?;
                    return Ok(values.into_iter().map(contrary).collect());
                }
            }
            _ => {}
        }
        let (product, accepting, is_contrary) = self.product(&formula, &sets, maximise)?;
        let failed = vec![false; accepting.len()];
        let values = self.exactly(Problem {
            choices: &product.choices,
            target: &accepting,
            failed: &failed,
            is_reward: false,
            maximise: true,
        })?;
        let value = |start: &usize| match is_contrary {
            true => contrary(values[*start].clone()),
            false => values[*start].clone(),
        };
        Ok(product.start.iter().map(value).collect())
    }

    fn exact_until(
        &mut self,
        left: &[bool],
        right: &[bool],
        (first, last): (u64, Option<u64>),
        maximise: bool,
    ) -> Result<Vec<Exact>, Failure> {
        let reading = self.reading()?;
        let choices = &reading.choices;
        let mut values = match last {
            None => {
                let failed: Vec<bool> = (left.iter().zip(right)).map(|(l, r)| !l && !r).collect();
                self.exactly(Problem {
                    choices,
                    target: right,
                    failed: &failed,
                    is_reward: false,
                    maximise,
                })?
            }
            Some(last) if last < first => vec![Some(Rational::zero()); right.len()],
            Some(last) => {
                let is_open = |state: usize| left[state] && !right[state];
                back(
                    choices,
                    indicator(right),
                    last - first,
                    maximise,
                    &is_open,
                    false,
                )?
            }
        };
        // At the steps before, `left` must hold, whether `right` does or not.
        for _ in 0..first {
            values = back(choices, values, 1, maximise, &|state| left[state], false)?;
            for (value, left) in values.iter_mut().zip(left) {
                if !left {
                    *value = Some(Rational::zero());
                }
            }
            self.check_cancelled()?;
        }
        Ok(values)
    }

    /// A reward before a target, or within steps.
    pub(super) fn exact_reward(
        &mut self,
        query: &RewardQuery,
        maximise: bool,
    ) -> Result<Vec<Exact>, Failure> {
        let reading = self.earning(Some(query.structure), Part::All)?;
        if query.divisor.is_some() {
            return Err(open());
        }
        match &query.objective {
            RewardObjective::Reach(target) if !reading.loses => {
                let target = self.truths(target)?;
                self.exactly(Problem {
                    choices: &reading.choices,
                    target: &target,
                    failed: &vec![false; target.len()],
                    is_reward: true,
                    maximise,
                })
            }
            RewardObjective::Cumulative(Horizon::Steps(steps)) => {
                let start = vec![Some(Rational::zero()); reading.states.len()];
                back(&reading.choices, start, *steps, maximise, &|_| true, true)
            }
            _ => Err(open()),
        }
    }

    /// A number in each state.
    pub(super) fn exact_numbers(&mut self, quantity: &Quantity) -> Result<Vec<Exact>, Failure> {
        let is_max = |optimum: &Option<Optimum>| *optimum != Some(Optimum::Min);
        match quantity {
            Quantity::Expr(expr) => {
                let reading = self.reading()?;
                let value = |state: &Vec<i64>| {
                    let number: prism_lang::Number = expr.eval_number(state)?;
                    let exact = number.exact().cloned();
                    exact.map(Some).ok_or_else(open)
                };
                reading.states.iter().map(value).collect()
            }
            Quantity::Probability { optimum, path } => self.exact_path(path, is_max(optimum)),
            Quantity::Reward { optimum, reward } => self.exact_reward(reward, is_max(optimum)),
            Quantity::Binary(
                operator @ (BinaryOp::Plus | BinaryOp::Minus | BinaryOp::Times),
                a,
                b,
            ) => {
                let (a, b) = (self.exact_numbers(a)?, self.exact_numbers(b)?);
                let joined = |pair: (Exact, Exact)| match pair {
                    (Some(a), Some(b)) => Ok(Some(match operator {
                        BinaryOp::Plus => a + b,
                        BinaryOp::Minus => a - b,
                        _ => a * b,
                    })),
                    _ => Err(open()),
                };
                a.into_iter().zip(b).map(joined).collect()
            }
            _ => Err(open()),
        }
    }

    /// What an oracle says are the values, if they are.
    pub(crate) fn exactly(&mut self, problem: Problem<'_>) -> Result<Vec<Exact>, Failure> {
        let values = self.oracle.exact(&problem).ok_or_else(open)?;
        let count = check_exact(problem, &values);
        let count = count.map_err(|(state, what)| {
            Failure::Incomplete(format!(
                "the exact value of state {state} of a problem is not shown: {what}"
            ))
        })?;
        self.inequalities += count;
        Ok(values)
    }

    fn check_cancelled(&self) -> Result<(), Failure> {
        match self.oracle.is_cancelled() {
            false => Ok(()),
            true => Err(Failure::Cancelled),
        }
    }
}

/// How two values compare.
pub(super) fn compared(value: &Exact, comparison: Comparison, bound: &Exact) -> bool {
    // Infinite values are greatest.
    let key = |value: &Exact| {
        (
            value.is_none(),
            value.clone().unwrap_or_else(Rational::zero),
        )
    };
    let order = key(value).cmp(&key(bound));
    match comparison {
        Comparison::Less => order.is_lt(),
        Comparison::LessEqual => order.is_le(),
        Comparison::Greater => order.is_gt(),
        Comparison::GreaterEqual => order.is_ge(),
    }
}

fn indicator(set: &[bool]) -> Vec<Exact> {
    let number = |holds: &bool| match holds {
        true => Rational::one(),
        false => Rational::zero(),
    };
    set.iter().map(|holds| Some(number(holds))).collect()
}

fn contrary(value: Exact) -> Exact {
    value.map(|value| Rational::one() - value)
}

/// Values so many steps earlier; states that are not active keep theirs.
fn back(
    choices: &[Vec<Choice>],
    mut values: Vec<Exact>,
    steps: u64,
    maximise: bool,
    active: &dyn Fn(usize) -> bool,
    with_rewards: bool,
) -> Result<Vec<Exact>, Failure> {
    let lengths = choices.iter().flatten().map(|c| c.outcomes.len() as u64);
    if steps > MOST_STEPS || lengths.sum::<u64>().saturating_mul(steps) > MOST_WORK {
        return Err(open());
    }
    for _ in 0..steps {
        let mean = |choice: &Choice| -> Exact {
            let mut sum = match with_rewards {
                true => choice.reward.clone(),
                false => Rational::zero(),
            };
            for (target, p) in &choice.outcomes {
                sum += p * values[*target].as_ref()?;
            }
            Some(sum)
        };
        let key = |value: &Exact| (value.is_none(), value.clone());
        let best = |state: usize| -> Exact {
            let each = choices[state].iter().map(mean);
            let best = each.reduce(|a, b| {
                if (key(&b) > key(&a)) == maximise {
                    b
                } else {
                    a
                }
            });
            best.unwrap_or_else(|| Some(Rational::zero()))
        };
        let next: Vec<Exact> = (0..values.len())
            .map(|state| match active(state) {
                true => best(state),
                false => values[state].clone(),
            })
            .collect();
        if next == values {
            break;
        }
        values = next;
    }
    Ok(values)
}
