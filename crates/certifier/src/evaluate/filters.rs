//! Filters: values over a set of states, joined.
//!
//! *Definition.* A filter's value is the same in all states, except for `argmin` and `argmax` (true where the value is the
//! least or greatest) and those that print, which are their operand. `first` is the value in the state that comes first
//! when variables are compared in their order. Guarantee: that of the operand's intervals, joined in directed rounding.

use prism_lang::property::{Filter, FilterOperand, FilterOperator};

use super::{Evaluator, open};
use crate::failure::Failure;
use crate::interval::Interval;
use crate::question::unsupported;

impl Evaluator<'_> {
    /// The value of a filter that is a number, in all states.
    pub(super) fn filtered(&mut self, filter: &Filter) -> Result<Vec<Interval>, Failure> {
        let selected = self.selected(filter)?;
        let values = match &filter.operand {
            FilterOperand::Number(quantity) => self.numbers(quantity)?,
            FilterOperand::Truth(formula) => {
                let truths = self.truths(formula)?;
                let count = selected.iter().filter(|state| truths[**state]).count();
                return match filter.operator {
                    FilterOperator::Count => {
                        Ok(vec![Interval::exactly(count as f64); truths.len()])
                    }
                    _ => Err(unsupported("this filter")),
                };
            }
        };
        let all = || selected.iter().map(|state| values[*state]);
        let best = |maximise: bool| all().reduce(|a, b| a.best(&b, maximise)).ok_or_else(none);
        let sum = || all().fold(Interval::ZERO, |sum, value| sum.add(&value));
        let value = match filter.operator {
            FilterOperator::Min => best(false)?,
            FilterOperator::Max => best(true)?,
            FilterOperator::Sum => sum(),
            FilterOperator::Average => {
                let states = Interval::exactly(selected.len() as f64);
                sum().div(&states).ok_or_else(none)?
            }
            FilterOperator::First | FilterOperator::State => {
                values[self.first(filter, &selected)?]
            }
            FilterOperator::Print | FilterOperator::PrintAll => return Ok(values),
            _ => return Err(unsupported("this filter")),
        };
        Ok(vec![value; values.len()])
    }

    /// The least and the greatest value.
    pub(super) fn range(&mut self, filter: &Filter) -> Result<[Interval; 2], Failure> {
        let selected = self.selected(filter)?;
        let FilterOperand::Number(quantity) = &filter.operand else {
            return Err(unsupported("this filter"));
        };
        let values = self.numbers(quantity)?;
        let best = |maximise: bool| {
            let values = selected.iter().map(|state| values[*state]);
            values.reduce(|a, b| a.best(&b, maximise)).ok_or_else(none)
        };
        Ok([best(false)?, best(true)?])
    }

    /// The value of a filter that is true or false, in all states.
    pub(super) fn filter_truths(&mut self, filter: &Filter) -> Result<Vec<bool>, Failure> {
        let selected = self.selected(filter)?;
        let operand = match &filter.operand {
            FilterOperand::Truth(operand) => operand,
            FilterOperand::Number(quantity) => {
                let values = self.numbers(quantity)?;
                let holds = extreme(filter.operator, &selected, &values)?;
                return holds
                    .into_iter()
                    .map(|holds| holds.ok_or_else(open))
                    .collect();
            }
        };
        let truths = self.truths(operand)?;
        let mut inside = selected.iter().map(|state| truths[*state]);
        let holds = match filter.operator {
            FilterOperator::ForAll => inside.all(|holds| holds),
            FilterOperator::Exists => inside.any(|holds| holds),
            FilterOperator::First | FilterOperator::State => {
                truths[self.first(filter, &selected)?]
            }
            FilterOperator::Print | FilterOperator::PrintAll => return Ok(truths),
            _ => return Err(unsupported("this filter")),
        };
        Ok(vec![holds; truths.len()])
    }

    /// Whether all initial states have the least or greatest value; nothing for other filters.
    pub(super) fn initial_extreme(&mut self, filter: &Filter) -> Result<Option<bool>, Failure> {
        let FilterOperand::Number(quantity) = &filter.operand else {
            return Ok(None);
        };
        let selected = self.selected(filter)?;
        let values = self.numbers(quantity)?;
        let holds = extreme(filter.operator, &selected, &values)?;
        let initial = &holds[..self.reading()?.num_initial];
        match initial.contains(&Some(false)) {
            true => Ok(Some(false)),
            false if initial.contains(&None) => Err(open()),
            false => Ok(Some(true)),
        }
    }

    /// The only state, or the first in the order of the variables' values.
    fn first(&mut self, filter: &Filter, selected: &[usize]) -> Result<usize, Failure> {
        if filter.operator == FilterOperator::State && selected.len() > 1 {
            return Err(unsupported("the value in the only state of several"));
        }
        let reading = self.reading()?;
        let first = selected.iter().min_by_key(|state| &reading.states[**state]);
        first.copied().ok_or_else(none)
    }

    fn selected(&mut self, filter: &Filter) -> Result<Vec<usize>, Failure> {
        let states = self.reading()?.states.len();
        let inside = match &filter.states {
            None => vec![true; states],
            Some(states) => self.truths(states)?,
        };
        Ok((0..states).filter(|state| inside[*state]).collect())
    }
}

/// Where the value is the least or greatest of those of some states, as far as that is known.
fn extreme(
    operator: FilterOperator,
    selected: &[usize],
    values: &[Interval],
) -> Result<Vec<Option<bool>>, Failure> {
    let better = |value: &Interval| match operator {
        FilterOperator::ArgMax => Ok((value.low, value.high)),
        FilterOperator::ArgMin => Ok((-value.high, -value.low)),
        _ => Err(unsupported("this filter")),
    };
    let ends = selected.iter().map(|state| better(&values[*state]));
    let ends: Vec<(f64, f64)> = ends.collect::<Result<_, _>>()?;
    let mut holds = vec![Some(false); values.len()];
    for (place, state) in selected.iter().enumerate() {
        let (low, high) = ends[place];
        let mut others = ends.iter().enumerate().filter(|(other, _)| *other != place);
        let falls_short = ends.iter().any(|other| other.0 > high);
        holds[*state] = match falls_short {
            true => Some(false),
            false => others.all(|(_, other)| other.1 <= low).then_some(true),
        };
    }
    Ok(holds)
}

fn none() -> Failure {
    unsupported("a filter over no state")
}
