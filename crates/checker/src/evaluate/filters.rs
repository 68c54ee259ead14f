//! Filters: values over a set of states, joined.
//!
//! A filter's value is the same in all states, except for `argmin` and `argmax` (true where the value is the least or
//! greatest; they list all states where it may be, as far as its bounds tell) and those that print (the operand's own value). `first` is the value in
//! the state that comes first when the variables' values are compared in the order of the text, as PRISM numbers states;
//! without variables, in that of the least number. A filter over no state is an error.

use std::cmp::Ordering;

use prism_lang::property::{Filter, FilterOperand, FilterOperator};

use super::Evaluator;
use crate::amount::Amount;
use crate::answer::{AnswerValue, CheckError};
use crate::engine::Numbers;

impl<E: Numbers> Evaluator<'_, E> {
    /// The states of a filter.
    fn filter_states(&mut self, filter: &Filter) -> Result<Vec<usize>, CheckError> {
        let found = match &filter.states {
            None => self.everywhere(),
            Some(states) => {
                let set = self.set(states)?;
                (0..set.len()).filter(|state| set[*state]).collect()
            }
        };
        if found.is_empty() {
            return Err(CheckError::Filter(
                "the filter's condition holds in no state".to_owned(),
            ));
        }
        if filter.operator == FilterOperator::State && found.len() > 1 {
            let count = found.len();
            return Err(CheckError::Filter(format!(
                "the filter's condition must hold in exactly one state, but holds in {count}; choose how to \
                 join their values, for example with `filter(max, ...)`"
            )));
        }
        if filter.operator == FilterOperator::First {
            let first = found
                .into_iter()
                .min_by_key(|state| self.space.state(*state));
            return Ok(first.into_iter().collect());
        }
        Ok(found)
    }

    /// A filter whose value is a number.
    pub(super) fn filter_numbers(
        &mut self,
        filter: &Filter,
        from: &[usize],
    ) -> Result<Vec<E::Amount>, CheckError> {
        let states = self.filter_states(filter)?;
        let values = match &filter.operand {
            FilterOperand::Truth(truth) => {
                let truths = self.truths(truth, &states)?;
                let count = truths.iter().filter(|holds| **holds).count();
                let count = prism_lang::Number::from_i64(count as i64);
                return Ok(vec![E::Amount::literal(&count); from.len()]);
            }
            FilterOperand::Number(quantity) => self.numbers(quantity, &states)?,
        };
        let joined = match filter.operator {
            FilterOperator::Min => values.into_iter().reduce(|a, b| a.least(&b)),
            FilterOperator::Max => values.into_iter().reduce(|a, b| a.greatest(&b)),
            FilterOperator::Sum => values.into_iter().reduce(|a, b| a.add(&b)),
            FilterOperator::Average => {
                let count = prism_lang::Number::from_i64(values.len() as i64);
                let sum = values.iter().cloned().reduce(|a, b| a.add(&b));
                let mean = sum.map(|sum| sum.div(&E::Amount::literal(&count)));
                match E::floats(&self.space.matrix) {
                    // What rounding adds leads beyond none of the values.
                    Some(_) => {
                        let least = values.iter().cloned().reduce(|a, b| a.least(&b));
                        let greatest = values.into_iter().reduce(|a, b| a.greatest(&b));
                        let ends = least.zip(greatest);
                        mean.zip(ends)
                            .map(|(mean, (least, greatest))| mean.greatest(&least).least(&greatest))
                    }
                    None => mean,
                }
            }
            FilterOperator::Print | FilterOperator::PrintAll => {
                self.print(filter.operator, &states, &values);
                let FilterOperand::Number(quantity) = &filter.operand else {
                    return Ok(Vec::new());
                };
                return self.numbers(quantity, from);
            }
            _ => values.into_iter().next(),
        };
        Ok(vec![
            joined.unwrap_or_else(E::Amount::undefined);
            from.len()
        ])
    }

    fn print(&mut self, operator: FilterOperator, states: &[usize], values: &[E::Amount]) {
        let all = operator == FilterOperator::PrintAll;
        let shown = states
            .iter()
            .zip(values)
            .filter(|(_, v)| all || **v != E::Amount::zero());
        self.printed
            .extend(shown.map(|(state, value)| (*state, value.answer())));
    }

    /// A filter whose value is true or false.
    pub(super) fn filter_truths(
        &mut self,
        filter: &Filter,
        from: &[usize],
    ) -> Result<Vec<bool>, CheckError> {
        let states = self.filter_states(filter)?;
        let truth = match &filter.operand {
            FilterOperand::Number(quantity) => {
                let values = self.numbers(quantity, &states)?;
                return self.extreme(filter.operator, &states, &values, from);
            }
            FilterOperand::Truth(truth) => truth,
        };
        let truths = self.truths(truth, &states)?;
        let joined = match filter.operator {
            FilterOperator::ForAll => truths.iter().all(|holds| *holds),
            FilterOperator::Exists => truths.iter().any(|holds| *holds),
            FilterOperator::Print | FilterOperator::PrintAll => {
                let all = filter.operator == FilterOperator::PrintAll;
                let shown = states
                    .iter()
                    .zip(&truths)
                    .filter(|(_, holds)| all || **holds);
                self.printed
                    .extend(shown.map(|(s, holds)| (*s, AnswerValue::Truth(*holds))));
                return self.truths(truth, from);
            }
            _ => truths[0],
        };
        Ok(vec![joined; from.len()])
    }

    /// Where the value is the least or greatest of those of `states`.
    fn extreme(
        &mut self,
        operator: FilterOperator,
        states: &[usize],
        values: &[E::Amount],
        from: &[usize],
    ) -> Result<Vec<bool>, CheckError> {
        if values.iter().any(Amount::is_undefined) {
            return Err(CheckError::Filter(
                "the filter compares values of which some are not defined: leave their states out"
                    .to_owned(),
            ));
        }
        let maximise = operator == FilterOperator::ArgMax;
        // Whether a value is worse than the other one, if that is known.
        let is_worse = |value: &E::Amount, other: &E::Amount| {
            let (less, more) = if maximise {
                (value, other)
            } else {
                (other, value)
            };
            let (x, y) = (less.bounds(), more.bounds());
            match less.compare(more) {
                Some(order) => Some(order == Ordering::Less),
                None if x.low >= y.high => Some(false),
                None => None,
            }
        };
        let best = values.iter().cloned().reduce(|a, b| a.best(&b, maximise));
        let may_be = |value: &E::Amount| {
            best.as_ref()
                .is_none_or(|best| is_worse(value, best) != Some(true))
        };
        let found = states.iter().zip(values).filter(|(_, value)| may_be(value));
        self.printed
            .extend(found.map(|(state, _)| (*state, AnswerValue::Truth(true))));
        let holds = |state: &usize| {
            let Some(own) = states.iter().position(|other| other == state) else {
                return Ok(false);
            };
            let others = values.iter().enumerate().filter(|(place, _)| *place != own);
            let mut attains = Some(true);
            for (_, other) in others {
                match is_worse(&values[own], other) {
                    Some(true) => return Ok(false),
                    Some(false) => {}
                    None => attains = None,
                }
            }
            attains.ok_or_else(|| CheckError::Undecided {
                comparison: match maximise {
                    true => "the greatest of the filter's states".to_owned(),
                    false => "the least of the filter's states".to_owned(),
                },
                bounds: values[own].bounds(),
                is_whole: false,
            })
        };
        from.iter().map(holds).collect()
    }

    /// The least and the greatest value.
    pub(super) fn filter_range(
        &mut self,
        filter: &Filter,
    ) -> Result<(E::Amount, E::Amount), CheckError> {
        let states = self.filter_states(filter)?;
        let FilterOperand::Number(quantity) = &filter.operand else {
            return Err(CheckError::Filter("a range is of numbers".to_owned()));
        };
        let values = self.numbers(quantity, &states)?;
        let least = values.iter().cloned().reduce(|a, b| a.least(&b));
        let greatest = values.into_iter().reduce(|a, b| a.greatest(&b));
        match (least, greatest) {
            (Some(least), Some(greatest)) => Ok((least, greatest)),
            _ => Ok((E::Amount::undefined(), E::Amount::undefined())),
        }
    }
}
