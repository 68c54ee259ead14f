//! Numbers in all states: rewards, shares, arithmetic and filters.

use prism_lang::ast::{BinaryOp, Optimum};
use prism_lang::property::{
    Filter, FilterOperand, FilterOperator, Horizon, Path, Quantity, RewardObjective, RewardQuery,
    StateFormula,
};
use prism_lang::{Function, Number};

use super::Evaluator;
use crate::failure::Failure;
use crate::inequalities::Problem;
use crate::interval::Interval;
use crate::question::unsupported;
use crate::reading::state_reward;
use crate::steps::Rows;

impl Evaluator<'_> {
    /// A number in each state.
    pub(crate) fn numbers(&mut self, quantity: &Quantity) -> Result<Vec<Interval>, Failure> {
        let is_max = |optimum: &Option<Optimum>| *optimum != Some(Optimum::Min);
        match quantity {
            Quantity::Expr(expr) => {
                let reading = self.reading(None)?;
                let value = |state: &Vec<i64>| {
                    let number: Number = expr.eval_number(state)?;
                    Ok(Interval::of_number(&number))
                };
                reading.states.iter().map(value).collect()
            }
            Quantity::Probability { optimum, path } => self.path(path, is_max(optimum)),
            Quantity::Conditional {
                path, condition, ..
            } => {
                if !self.is_chain() {
                    return Err(unsupported("a conditional probability over schedulers"));
                }
                let both = Path::And(path.clone(), condition.clone());
                let (both, given) = (self.path(&both, true)?, self.path(condition, true)?);
                let each = both.iter().zip(&given);
                let ratio = |(both, given): (&Interval, &Interval)| {
                    let ratio = both.div(given).unwrap_or(Interval {
                        low: 0.0,
                        high: 1.0,
                    });
                    ratio.at_most(1.0)
                };
                Ok(each.map(ratio).collect())
            }
            Quantity::Reward { optimum, reward } => self.reward(reward, is_max(optimum)),
            Quantity::LongRun(states) => self.share(states),
            Quantity::Minus(a) => {
                let opposite = |a: Interval| Interval {
                    low: -a.high,
                    high: -a.low,
                };
                Ok(self.numbers(a)?.into_iter().map(opposite).collect())
            }
            Quantity::Binary(operator, a, b) => {
                let (a, b) = (self.numbers(a)?, self.numbers(b)?);
                (a.iter().zip(&b))
                    .map(|(a, b)| match operator {
                        BinaryOp::Plus => Ok(a.add(b)),
                        BinaryOp::Minus => Ok(a.sub(b)),
                        BinaryOp::Times => Ok(a.mul(b)),
                        BinaryOp::Divide => a.div(b).ok_or_else(|| unsupported("a division by 0")),
                        _ => Err(unsupported("this arithmetic over properties")),
                    })
                    .collect()
            }
            Quantity::Choice(condition, a, b) => {
                let condition = self.truths(condition)?;
                let (a, b) = (self.numbers(a)?, self.numbers(b)?);
                let each = condition.into_iter().zip(a.into_iter().zip(b));
                Ok(each.map(|(c, (a, b))| if c { a } else { b }).collect())
            }
            Quantity::Call(function @ (Function::Min | Function::Max), arguments) => {
                let mut all = Vec::new();
                for argument in arguments {
                    all.push(self.numbers(argument)?);
                }
                let maximise = *function == Function::Max;
                let best = |state: usize| {
                    let each = all.iter().map(|values| values[state]);
                    each.reduce(|a, b| a.best(&b, maximise))
                        .unwrap_or(Interval::ZERO)
                };
                Ok((0..all.first().map_or(0, Vec::len)).map(best).collect())
            }
            Quantity::Call(..) => Err(unsupported("this function of a property")),
            Quantity::Filter(filter) => self.filtered(filter, false),
        }
    }

    /// The value of a filter over numbers, in all states; of a range, from the least to the greatest.
    pub(super) fn filtered(
        &mut self,
        filter: &Filter,
        is_range: bool,
    ) -> Result<Vec<Interval>, Failure> {
        let selected = self.selected(filter)?;
        let (values, count) = match &filter.operand {
            FilterOperand::Number(quantity) => (self.numbers(quantity)?, None),
            FilterOperand::Truth(formula) => {
                let truths = self.truths(formula)?;
                let count = selected.iter().filter(|state| truths[**state]).count();
                (vec![Interval::ZERO; truths.len()], Some(count as f64))
            }
        };
        let all = || selected.iter().map(|state| values[*state]);
        let sum = || all().fold(Interval::ZERO, |sum, value| sum.add(&value));
        let none = || unsupported("a filter over no state");
        let value = match (filter.operator, count) {
            (FilterOperator::Count, Some(count)) => Interval::exactly(count),
            (_, Some(_)) => return Err(unsupported("this filter")),
            (FilterOperator::Min, _) => all().reduce(|a, b| a.best(&b, false)).ok_or_else(none)?,
            (FilterOperator::Max, _) => all().reduce(|a, b| a.best(&b, true)).ok_or_else(none)?,
            (FilterOperator::Sum, _) => sum(),
            (FilterOperator::Average, _) => {
                let states = Interval::exactly(selected.len() as f64);
                sum().div(&states).ok_or_else(none)?
            }
            (FilterOperator::State, _) if selected.len() == 1 => values[selected[0]],
            (FilterOperator::Range, _) if is_range => {
                let least = all().reduce(|a, b| a.best(&b, false)).ok_or_else(none)?;
                let most = all().reduce(|a, b| a.best(&b, true)).ok_or_else(none)?;
                Interval {
                    low: least.low,
                    high: most.high,
                }
            }
            (FilterOperator::Print | FilterOperator::PrintAll, _) => return Ok(values),
            _ => return Err(unsupported("this filter")),
        };
        Ok(vec![value; values.len()])
    }

    pub(super) fn filter_truths(&mut self, filter: &Filter) -> Result<Vec<bool>, Failure> {
        let FilterOperand::Truth(operand) = &filter.operand else {
            return Err(unsupported("this filter"));
        };
        let truths = self.truths(operand)?;
        let selected = self.selected(filter)?;
        let mut inside = selected.iter().map(|state| truths[*state]);
        let holds = match filter.operator {
            FilterOperator::ForAll => inside.all(|holds| holds),
            FilterOperator::Exists => inside.any(|holds| holds),
            FilterOperator::First | FilterOperator::State => inside.next().unwrap_or(false),
            _ => return Err(unsupported("this filter")),
        };
        Ok(vec![holds; truths.len()])
    }

    fn selected(&mut self, filter: &Filter) -> Result<Vec<usize>, Failure> {
        let states = self.reading(None)?.states.len();
        let inside = match &filter.states {
            None => vec![true; states],
            Some(states) => self.truths(states)?,
        };
        Ok((0..states).filter(|state| inside[*state]).collect())
    }

    pub(super) fn reward(
        &mut self,
        query: &RewardQuery,
        maximise: bool,
    ) -> Result<Vec<Interval>, Failure> {
        let values = self.reward_of(query, query.structure, maximise)?;
        let Some(divisor) = query.divisor else {
            return Ok(values);
        };
        let divisors = self.reward_of(query, divisor, maximise)?;
        (values.iter().zip(&divisors))
            .map(|(a, b)| a.div(b).ok_or_else(|| unsupported("a division by 0")))
            .collect()
    }

    fn reward_of(
        &mut self,
        query: &RewardQuery,
        structure: usize,
        maximise: bool,
    ) -> Result<Vec<Interval>, Failure> {
        let reading = self.reading(Some(structure))?;
        match &query.objective {
            RewardObjective::Reach(target) => {
                let target = self.truths(target)?;
                self.solved(Problem {
                    choices: &reading.choices,
                    target: &target,
                    failed: &vec![false; target.len()],
                    is_reward: true,
                    maximise,
                })
            }
            RewardObjective::Cumulative(Horizon::Steps(steps)) => {
                let start = vec![Interval::ZERO; reading.states.len()];
                let go_on = || self.oracle.go_on();
                Rows::new(&reading.choices).back(start, *steps, maximise, &|_| true, true, &go_on)
            }
            RewardObjective::Instantaneous(Horizon::Steps(steps)) => {
                let start = self.state_rewards(structure)?;
                let go_on = || self.oracle.go_on();
                Rows::new(&reading.choices).back(start, *steps, maximise, &|_| true, false, &go_on)
            }
            RewardObjective::Cumulative(Horizon::Time(time)) => self.earned_within(&reading, time),
            RewardObjective::Instantaneous(Horizon::Time(time)) => {
                let start = self.state_rewards(structure)?;
                self.expected_at(&reading, start, time)
            }
            RewardObjective::Total => self.total(&reading, maximise),
            RewardObjective::LongRun => {
                // What a step earns, in the time that it takes.
                let gain: Vec<Vec<Interval>> = (reading.choices.iter().zip(&reading.rate))
                    .map(|(choices, rate)| {
                        let earned = choices.iter().map(|choice| &choice.reward * rate);
                        earned.map(|earned| Interval::of(&earned)).collect()
                    })
                    .collect();
                self.average(&reading, &gain, maximise)
            }
            RewardObjective::CoSafe(path) => {
                let mut sets = Vec::new();
                let formula = self.formula(path, &mut sets)?;
                self.earned_before(&reading, &formula, &sets, maximise)
            }
        }
    }

    fn state_rewards(&mut self, structure: usize) -> Result<Vec<Interval>, Failure> {
        let reading = self.reading(None)?;
        (reading.states.iter())
            .map(|state| {
                Ok(Interval::of(&state_reward(
                    self.model,
                    state,
                    Some(structure),
                )?))
            })
            .collect()
    }

    /// The share of time that is spent in states.
    pub(super) fn share(&mut self, states: &StateFormula) -> Result<Vec<Interval>, Failure> {
        let inside = self.truths(states)?;
        let reading = self.reading(None)?;
        let gain: Vec<Vec<Interval>> = (inside.iter().zip(&reading.choices))
            .map(|(inside, choices)| {
                let number = if *inside {
                    Interval::ONE
                } else {
                    Interval::ZERO
                };
                vec![number; choices.len()]
            })
            .collect();
        let values = self.average(&reading, &gain, true)?;
        Ok(values
            .iter()
            .map(|v| v.at_least(0.0).at_most(1.0))
            .collect())
    }
}
