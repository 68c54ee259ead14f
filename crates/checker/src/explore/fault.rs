//! The faults that a state can show, each written out with the state.

use prism_lang::resolved::Model;
use prism_lang::{Arithmetic, EvalError, EvalErrorKind, Expr, Span};

use super::command::BadNumber;
use super::error::ExploreError;
use crate::state_space::describe;

/// How far from 1 the probabilities of a command may sum up, in a domain that is not exact.
const SUM_TOLERANCE: f64 = 1e-12;

pub(super) fn check_sum<N: Arithmetic>(
    sum: &N,
    span: Span,
    values: &[i64],
    model: &Model,
) -> Result<(), ExploreError> {
    let fits = if N::EXACT {
        *sum == N::one()
    } else {
        (sum.to_f64() - 1.0).abs() <= SUM_TOLERANCE
    };
    if fits {
        return Ok(());
    }
    Err(ExploreError::ProbabilitySum {
        sum: sum.to_f64(),
        state: describe(&model.variables, values),
        span,
    })
}

pub(super) fn in_range(
    variable: usize,
    value: i64,
    span: Span,
    values: &[i64],
    model: &Model,
) -> Result<(), ExploreError> {
    let declared = &model.variables[variable];
    let (low, high) = declared.kind.bounds();
    if low <= value && value <= high {
        return Ok(());
    }
    Err(ExploreError::OutOfRange {
        variable: declared.name.clone(),
        value,
        low,
        high,
        state: describe(&model.variables, values),
        span,
    })
}

pub(super) fn bad_probability(
    bad: BadNumber,
    span: Span,
    values: &[i64],
    model: &Model,
) -> ExploreError {
    let state = describe(&model.variables, values);
    match bad {
        BadNumber::NoValue(error) => ExploreError::NoValue { error, state },
        BadNumber::OutOfBounds(value) => ExploreError::NotAProbability { value, state, span },
        BadNumber::Underflow => ExploreError::Underflow { state, span },
    }
}

pub(super) fn bad_reward(
    bad: BadNumber,
    span: Span,
    values: &[i64],
    model: &Model,
) -> ExploreError {
    let state = describe(&model.variables, values);
    let value = match bad {
        BadNumber::NoValue(error) => return ExploreError::NoValue { error, state },
        BadNumber::OutOfBounds(value) => value,
        BadNumber::Underflow => 0.0,
    };
    ExploreError::NotAReward { value, state, span }
}

/// Why an expression has no value: its slow evaluation tells.
pub(super) fn no_value(expr: &Expr, values: &[i64], model: &Model) -> ExploreError {
    let slow = match expr.ty {
        prism_lang::ast::Type::Bool => expr.eval_bool(values).map(i64::from),
        _ => expr.eval_int(values),
    };
    let ill_typed = EvalError {
        kind: EvalErrorKind::IllTyped,
        span: expr.span,
    };
    ExploreError::NoValue {
        error: slow.err().unwrap_or(ill_typed),
        state: describe(&model.variables, values),
    }
}
