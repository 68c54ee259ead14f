//! A property of a model with open constants: its value on parts of a region.
//!
//! *Method.* A cell of the region is answered as a whole, or cut in two, the largest first, until the cells without
//! an answer make up at most [`MOST_UNDECIDED`] of the region. Cost: one solution for each cell of a model with
//! choices; chains are solved once. Guarantee: an answer holds at every point strictly within its cell.

use std::collections::VecDeque;

use prism_lang::{Arithmetic, Comparison, Number, Property, Rational};

use super::amount::FunctionAmount;
use super::conditions::Conditions;
use super::engine::too_large;
use super::function::RationalFunction;
use super::optimise::{Cell, Schedulers};
use super::region::{Region, Sign};
use crate::answer::{CheckError, Options};
use crate::evaluate::Evaluator;
use crate::evaluate::parametric::Asked;
use crate::state_space::StateSpace;

/// The share of a region that may stay undecided: one in this many.
const MOST_UNDECIDED: i64 = 20;
/// No more cells than this are tried.
const MOST_CELLS: usize = 1_000;

/// The value of a property in an initial state.
#[derive(Clone, Debug, PartialEq)]
pub enum ParametricValue {
    /// A function of the parameters.
    Function(RationalFunction),
    /// Greater than all numbers.
    Infinite,
    /// Less than all numbers.
    MinusInfinite,
    /// Not a number.
    Undefined,
    /// Whether it holds.
    Truth(bool),
}

/// A part of the region and the values there.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Where.
    pub region: Region,
    /// The value in each initial state.
    pub values: Vec<ParametricValue>,
}

/// The answer to a property.
#[derive(Clone, Debug, PartialEq)]
pub struct ParametricAnswer {
    /// Values on parts of the region.
    pub parts: Vec<Part>,
    /// Parts without an answer: the best choices, or whether a bound is met, are not the same there.
    pub undecided: Vec<Region>,
    /// Parts at no point of which the model is one: some probability is negative there.
    pub ill_defined: Vec<Region>,
    /// What the answer rests on, and whether it holds on the whole region.
    pub conditions: Conditions,
}

/// Solves a property for all points of a region. `space` was explored with the parameters that the region has
/// ranges for, in this order.
///
/// # Errors
/// See [`CheckError`]; also if functions become too large.
pub fn solve(
    space: &StateSpace<RationalFunction>,
    property: &Property,
    region: &Region,
    options: &Options<'_>,
) -> Result<ParametricAnswer, CheckError> {
    let is_chain = !space.kind.has_choices();
    let mut answer = ParametricAnswer {
        parts: Vec::new(),
        undecided: Vec::new(),
        ill_defined: Vec::new(),
        conditions: Conditions::new(space, region),
    };
    let schedulers = Schedulers::default();
    let whole = Cell::new(region, &schedulers);
    let of_chain = match is_chain {
        true => Some(Evaluator::new(space, options)?.functions(property, &whole)?),
        false => None,
    };
    let mut open = VecDeque::from([region.clone()]);
    let mut cells = 0;
    while let Some(cell) = open.pop_front() {
        options.check_cancelled()?;
        cells += 1;
        let conditions = Conditions::new(space, &cell);
        let found = match &of_chain {
            Some(asked) => on(asked, &cell)?,
            None if conditions.hold() => {
                on_cell(space, property, &Cell::new(&cell, &schedulers), options)?
            }
            None => None,
        };
        match found {
            Some(values) => answer.parts.push(Part {
                region: cell,
                values,
            }),
            None if !is_chain && conditions.never_hold() => answer.ill_defined.push(cell),
            None => open.extend(cell.halves(region)),
        }
        let enough = share(&open, region) <= Rational::new(1.into(), MOST_UNDECIDED.into());
        if region.ranges.is_empty() || cells >= MOST_CELLS || (cells > 1 && enough) {
            break;
        }
    }
    answer.undecided = open.into();
    join(&mut answer, region);
    Ok(answer)
}

fn share(cells: &VecDeque<Region>, whole: &Region) -> Rational {
    let each = cells.iter().map(|cell| cell.share_of(whole));
    each.fold(Rational::zero(), |sum, share| sum + share)
}

/// One part, if all parts have the same values and make up the whole region.
fn join(answer: &mut ParametricAnswer, region: &Region) {
    let same = |part: &Part| part.values == answer.parts[0].values;
    let is_whole = answer.undecided.is_empty() && answer.ill_defined.is_empty();
    if is_whole && answer.parts.len() > 1 && answer.parts.iter().all(same) {
        answer.parts.truncate(1);
        answer.parts[0].region = region.clone();
    }
}

/// The values of a model with choices on a cell; `None` if the best choices are not known there.
fn on_cell(
    space: &StateSpace<RationalFunction>,
    property: &Property,
    cell: &Cell<'_>,
    options: &Options<'_>,
) -> Result<Option<Vec<ParametricValue>>, CheckError> {
    match Evaluator::new(space, options)?.functions(property, cell) {
        Ok(asked) => on(&asked, cell.region),
        Err(CheckError::OpenChoice) => Ok(None),
        Err(error) => Err(error),
    }
}

/// The values on a cell; `None` if whether a bound is met is not known there.
fn on(asked: &Asked, cell: &Region) -> Result<Option<Vec<ParametricValue>>, CheckError> {
    match asked {
        Asked::Truths(truths) => {
            let truths = truths.iter().map(|t| ParametricValue::Truth(*t));
            Ok(Some(truths.collect()))
        }
        Asked::Amounts(amounts) => amounts.iter().map(value).map(|v| v.map(Some)).collect(),
        Asked::Bounded(amounts, comparison, bound) => {
            let bound = bound.exact().ok_or_else(open_order)?;
            let mut truths = Vec::with_capacity(amounts.len());
            for amount in amounts {
                let value = value(amount)?;
                truths.push(meets(&value, *comparison, bound, cell).map(ParametricValue::Truth));
            }
            Ok(truths.into_iter().collect())
        }
    }
}

fn open_order() -> CheckError {
    CheckError::Unsupported(
        "the value depends on which of two functions of the open constants is greater, or on a number that is \
         not rational"
            .to_owned(),
    )
}

fn value(amount: &FunctionAmount) -> Result<ParametricValue, CheckError> {
    Ok(match amount {
        FunctionAmount::Finite(function) if function.is_too_large() => return Err(too_large()),
        FunctionAmount::Finite(function) => ParametricValue::Function(function.clone()),
        FunctionAmount::Infinite => ParametricValue::Infinite,
        FunctionAmount::MinusInfinite => ParametricValue::MinusInfinite,
        FunctionAmount::Undefined => ParametricValue::Undefined,
        FunctionAmount::Open => return Err(open_order()),
    })
}

/// Whether a value meets a bound at all points of a cell (or misses it at all).
fn meets(
    value: &ParametricValue,
    comparison: Comparison,
    bound: &Rational,
    cell: &Region,
) -> Option<bool> {
    let zero = Rational::zero();
    let one = Rational::from_integer(1.into());
    match value {
        ParametricValue::Function(function) => {
            let literal = RationalFunction::from_literal(&Number::from_rational(bound.clone()))?;
            match cell.sign(&function.sub(&literal)) {
                Sign::Positive => Some(comparison.holds(&one, &zero)),
                Sign::Zero => Some(comparison.holds(&zero, &zero)),
                Sign::Negative => Some(comparison.holds(&-one, &zero)),
                Sign::Unknown => None,
            }
        }
        ParametricValue::Infinite => Some(comparison.holds(&one, &zero)),
        ParametricValue::MinusInfinite => Some(comparison.holds(&-one, &zero)),
        // Not a number meets nothing.
        ParametricValue::Undefined => Some(false),
        ParametricValue::Truth(truth) => Some(*truth),
    }
}
