//! The faults that a state can show, each written out with the state.

use prism_lang::{Arithmetic, EvalError, Expr, Span, VarIndex};

use super::code::Compiler;
use super::command::BadNumber;
use super::error::ExploreError;

/// How far from 1 the probabilities of a command may sum up, in a domain that is not exact.
const SUM_TOLERANCE: f64 = 1e-12;

pub(super) fn check_sum<N: Arithmetic>(
    sum: &N,
    span: Span,
    state: &[u64],
    compiler: Compiler<'_>,
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
        state: compiler.describe(state),
        span,
    })
}

/// An assignment that takes a variable out of its range.
pub(super) fn out_of_range(
    variable: VarIndex,
    source: &Expr,
    state: &[u64],
    compiler: Compiler<'_>,
) -> ExploreError {
    let declared = &compiler.variables[variable];
    let (low, high) = declared.kind.bounds();
    match compiler.slowly(source, state) {
        Ok(value) => ExploreError::OutOfRange {
            variable: declared.name.clone(),
            value,
            low,
            high,
            state: compiler.describe(state),
            span: source.span,
        },
        Err(error) => no_value(error, state, compiler),
    }
}

pub(super) fn bad_probability(
    bad: BadNumber,
    span: Span,
    state: &[u64],
    compiler: Compiler<'_>,
) -> ExploreError {
    let state = compiler.describe(state);
    match bad {
        BadNumber::NoValue(error) => ExploreError::NoValue { error, state },
        BadNumber::OutOfBounds(value) => ExploreError::NotAProbability { value, state, span },
        BadNumber::Underflow => ExploreError::Underflow { state, span },
    }
}

pub(super) fn bad_reward(
    bad: BadNumber,
    span: Span,
    state: &[u64],
    compiler: Compiler<'_>,
) -> ExploreError {
    let state = compiler.describe(state);
    let value = match bad {
        BadNumber::NoValue(error) => return ExploreError::NoValue { error, state },
        BadNumber::OutOfBounds(value) => value,
        BadNumber::Underflow => 0.0,
    };
    ExploreError::NotAReward { value, state, span }
}

pub(super) fn no_value(error: EvalError, state: &[u64], compiler: Compiler<'_>) -> ExploreError {
    ExploreError::NoValue {
        error,
        state: compiler.describe(state),
    }
}
