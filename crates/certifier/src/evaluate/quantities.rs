//! Numbers in all states: rewards, shares and arithmetic.

use prism_lang::ast::{BinaryOp, Optimum};
use prism_lang::property::{Horizon, Path, Quantity, RewardObjective, RewardQuery, StateFormula};
use prism_lang::{Function, Number};

use super::Evaluator;
use crate::failure::Failure;
use crate::inequalities::Problem;
use crate::interval::Interval;
use crate::question::unsupported;
use crate::reading::{Part, state_reward};
use crate::steps::Rows;

impl Evaluator<'_> {
    /// A number in each state.
    pub(crate) fn numbers(&mut self, quantity: &Quantity) -> Result<Vec<Interval>, Failure> {
        let is_max = |optimum: &Option<Optimum>| *optimum != Some(Optimum::Min);
        match quantity {
            Quantity::Expr(expr) => {
                let reading = self.reading()?;
                let value = |state: &Vec<i64>| {
                    let number: Number = expr.eval_number(state)?;
                    Ok(Interval::of_number(&number))
                };
                reading.states.iter().map(value).collect()
            }
            Quantity::Probability { optimum, path } => self.path(path, is_max(optimum)),
            Quantity::Conditional {
                optimum,
                path,
                condition,
            } => {
                if !self.is_chain() {
                    return self.conditional(path, condition, is_max(optimum));
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
                        BinaryOp::Divide => Ok(a.div(b).unwrap_or(Interval::ANY)),
                        _ => power(a, b),
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
            Quantity::Call(Function::Pow, arguments) if arguments.len() == 2 => {
                let (a, b) = (self.numbers(&arguments[0])?, self.numbers(&arguments[1])?);
                a.iter().zip(&b).map(|(a, b)| power(a, b)).collect()
            }
            Quantity::Call(Function::Floor, arguments) if arguments.len() == 1 => {
                Ok(rounded(&self.numbers(&arguments[0])?, f64::floor))
            }
            Quantity::Call(Function::Ceil, arguments) if arguments.len() == 1 => {
                Ok(rounded(&self.numbers(&arguments[0])?, f64::ceil))
            }
            Quantity::Call(Function::Round, arguments) if arguments.len() == 1 => {
                Ok(rounded(&self.numbers(&arguments[0])?, half_up))
            }
            Quantity::Call(Function::Log, _) => Err(unsupported("a logarithm of a property")),
            Quantity::Call(..) => Err(unsupported("this function of a property")),
            Quantity::Filter(filter) => self.filtered(filter),
        }
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
        let pairs = values.iter().zip(&divisors);
        Ok(pairs
            .map(|(a, b)| a.div(b).unwrap_or(Interval::ANY))
            .collect())
    }

    fn reward_of(
        &mut self,
        query: &RewardQuery,
        structure: usize,
        maximise: bool,
    ) -> Result<Vec<Interval>, Failure> {
        self.needs_probabilities()?;
        let within_steps = matches!(
            query.objective,
            RewardObjective::Cumulative(Horizon::Steps(_))
                | RewardObjective::Instantaneous(Horizon::Steps(_))
        );
        if within_steps || !self.earning(Some(structure), Part::All)?.loses {
            return self.part_of(query, (structure, Part::All), maximise);
        }
        if !self.is_chain() {
            return Err(unsupported("a negative reward over schedulers without end"));
        }
        // Without alternatives expectations add up, each part's own being well defined.
        let gains = self.part_of(query, (structure, Part::Gain), maximise)?;
        let losses = self.part_of(query, (structure, Part::Loss), maximise)?;
        // Where a target may be missed the reward is infinite, whatever is lost.
        let is_sum = matches!(query.objective, RewardObjective::Total);
        let difference = |(gain, loss): (&Interval, &Interval)| match gain.low == f64::INFINITY {
            true if !is_sum => *gain,
            _ => gain.sub(loss),
        };
        Ok(gains.iter().zip(&losses).map(difference).collect())
    }

    fn part_of(
        &mut self,
        query: &RewardQuery,
        (structure, part): (usize, Part),
        maximise: bool,
    ) -> Result<Vec<Interval>, Failure> {
        let reading = self.earning(Some(structure), part)?;
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
                let cancelled = || self.oracle.is_cancelled();
                Rows::new(&reading.choices).back(
                    start,
                    *steps,
                    maximise,
                    &|_| true,
                    true,
                    &cancelled,
                )
            }
            RewardObjective::Instantaneous(Horizon::Steps(steps)) => {
                let start = self.state_rewards(structure, part)?;
                let cancelled = || self.oracle.is_cancelled();
                Rows::new(&reading.choices).back(
                    start,
                    *steps,
                    maximise,
                    &|_| true,
                    false,
                    &cancelled,
                )
            }
            RewardObjective::Cumulative(Horizon::Time(time)) => self.earned_within(&reading, time),
            RewardObjective::Instantaneous(Horizon::Time(time)) => {
                let start = self.state_rewards(structure, part)?;
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

    fn state_rewards(&mut self, structure: usize, part: Part) -> Result<Vec<Interval>, Failure> {
        let reading = self.reading()?;
        (reading.states.iter())
            .map(|state| {
                let earned = state_reward(self.model, state, structure, part)?;
                Ok(Interval::of(&earned))
            })
            .collect()
    }

    /// The share of time that is spent in states.
    pub(super) fn share(&mut self, states: &StateFormula) -> Result<Vec<Interval>, Failure> {
        self.needs_probabilities()?;
        let inside = self.truths(states)?;
        let reading = self.reading()?;
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

/// The greatest exponent of a power.
const MOST_FACTORS: f64 = 64.0;

/// A power as a product of the base, or of its root.
fn power(own: &Interval, exponent: &Interval) -> Result<Interval, Failure> {
    let mut times = exponent.low;
    let (is_known, is_whole) = (exponent.high == times, times.fract() == 0.0);
    let root = Interval {
        low: own.low.sqrt().next_down().max(0.0),
        high: own.high.sqrt().next_up(),
    };
    let base = match is_whole {
        true => own,
        false => &root,
    };
    if !is_whole {
        times *= 2.0;
    }
    let has_root = is_whole || own.low >= 0.0;
    if !is_known || !has_root || times.fract() != 0.0 || times.abs() > MOST_FACTORS {
        return Err(unsupported(
            "a power whose exponent is not a small integer or half of one",
        ));
    }
    let product = (0..times.abs() as u32).fold(Interval::ONE, |product, _| product.mul(base));
    Ok(match times < 0.0 {
        true => Interval::ONE.div(&product).unwrap_or(Interval::ANY),
        false => product,
    })
}

/// The nearest integer; the difference to the one below is exact.
fn half_up(x: f64) -> f64 {
    let below = x.floor();
    match x - below >= 0.5 {
        true => below + 1.0,
        false => below,
    }
}

/// The integers to which the ends are rounded.
fn rounded(values: &[Interval], round: fn(f64) -> f64) -> Vec<Interval> {
    let integers = |value: &Interval| Interval {
        low: round(value.low),
        high: round(value.high),
    };
    values.iter().map(integers).collect()
}
