//! Commands, compiled for one number domain.
//!
//! A probability is computed exactly and rounded once, whatever the domain; where it depends on the state, the
//! result is remembered for the values of the variables that occur in it.

use prism_lang::resolved::{Command, Model, ModelType};
use prism_lang::{Arithmetic, EvalError, EvalErrorKind, Expr, Number, Rational, VarIndex};
use rustc_hash::FxHashMap;

use super::code::Code;
use super::events::events;
use crate::state_space::NO_ACTION;

/// A probability and by how much it may be off.
#[derive(Clone, Debug)]
pub(super) struct Rounded<N> {
    pub(super) value: N,
    /// How many roundings it went through (0: it is exact); `None`: it is irrational, and its error unknown.
    pub(super) roundings: Option<u32>,
}

/// Why a number cannot be used.
pub(super) enum BadNumber {
    NoValue(EvalError),
    /// Negative, infinite or not a number where that is not allowed.
    OutOfBounds(f64),
    Underflow,
}

/// When and how a command changes the state.
pub(super) struct CompiledCommand<'m, N> {
    pub(super) source: &'m Command,
    pub(super) guard: Code,
    pub(super) updates: Vec<CompiledUpdate<'m, N>>,
    /// Whether the probabilities are known to sum to 1.
    pub(super) sum_known: bool,
}

/// One outcome of a command.
pub(super) struct CompiledUpdate<'m, N> {
    pub(super) probability: Probability<'m, N>,
    pub(super) assignments: Vec<(VarIndex, Code, &'m Expr)>,
}

/// The probability of an update.
pub(super) enum Probability<'m, N> {
    Constant(Rounded<N>),
    Dependent {
        expr: &'m Expr,
        variables: Vec<VarIndex>,
        known: FxHashMap<Vec<i64>, Rounded<N>>,
    },
}

impl<'m, N: Arithmetic> CompiledCommand<'m, N> {
    pub(super) fn new(source: &'m Command, sum_known: bool) -> Self {
        let updates: Vec<_> = source
            .updates
            .iter()
            .map(|update| CompiledUpdate {
                probability: Probability::new(&update.probability),
                assignments: update
                    .assignments
                    .iter()
                    .map(|(variable, value)| (*variable, Code::new(value), value))
                    .collect(),
            })
            .collect();
        Self {
            guard: Code::new(&source.guard),
            updates,
            source,
            sum_known,
        }
    }

    /// Whether all probabilities are the same in every state.
    pub(super) fn is_constant(&self) -> bool {
        let constant =
            |u: &CompiledUpdate<'_, N>| matches!(u.probability, Probability::Constant(_));
        self.updates.iter().all(constant)
    }
}

impl<'m, N: Arithmetic> Probability<'m, N> {
    pub(super) fn new(expr: &'m Expr) -> Self {
        let variables = expr.variables();
        if variables.is_empty()
            && let Ok(value) = probability(expr, &[])
        {
            return Self::Constant(value);
        }
        // A constant without a value is reported where it is needed.
        Self::Dependent {
            expr,
            variables,
            known: FxHashMap::default(),
        }
    }

    /// The number in a state, which `compute` gets from the expression. `key` is scratch space.
    pub(super) fn value(
        &mut self,
        state: &[i64],
        key: &mut Vec<i64>,
        compute: fn(&Expr, &[i64]) -> Result<Rounded<N>, BadNumber>,
    ) -> Result<Rounded<N>, BadNumber> {
        match self {
            Self::Constant(value) => Ok(value.clone()),
            Self::Dependent {
                expr,
                variables,
                known,
            } => {
                key.clear();
                key.extend(variables.iter().map(|v| state[*v]));
                if let Some(value) = known.get(key.as_slice()) {
                    return Ok(value.clone());
                }
                let value = compute(expr, state)?;
                known.insert(key.clone(), value.clone());
                Ok(value)
            }
        }
    }
}

/// A probability or rate, computed exactly (as far as it is rational) and brought into the domain.
pub(super) fn probability<N: Arithmetic>(
    expr: &Expr,
    state: &[i64],
) -> Result<Rounded<N>, BadNumber> {
    let number: Number = expr.eval_number(state).map_err(BadNumber::NoValue)?;
    if !number.is_non_negative() {
        return Err(BadNumber::OutOfBounds(number.to_f64()));
    }
    if !N::EXACT && !Arithmetic::is_zero(&number) && number.to_f64() < f64::MIN_POSITIVE {
        return Err(BadNumber::Underflow);
    }
    rounded(expr, &number)
}

/// A reward: as a probability, but it may be negative, and is 0 where it is too small for a double.
pub(super) fn reward<N: Arithmetic>(expr: &Expr, state: &[i64]) -> Result<Rounded<N>, BadNumber> {
    let number: Number = expr.eval_number(state).map_err(BadNumber::NoValue)?;
    if !number.to_f64().is_finite() {
        return Err(BadNumber::OutOfBounds(number.to_f64()));
    }
    let mut reward: Rounded<N> = rounded(expr, &number)?;
    if !N::EXACT && !Arithmetic::is_zero(&number) && number.to_f64().abs() < f64::MIN_POSITIVE {
        reward.roundings = None;
    }
    Ok(reward)
}

fn rounded<N: Arithmetic>(expr: &Expr, number: &Number) -> Result<Rounded<N>, BadNumber> {
    let value = N::from_literal(number).ok_or({
        BadNumber::NoValue(EvalError {
            kind: EvalErrorKind::NotRational,
            span: expr.span,
        })
    })?;
    let roundings = if N::EXACT {
        Some(0)
    } else {
        let stored = Rational::from_float(value.to_f64());
        number
            .exact()
            .map(|exact| u32::from(stored.as_ref() != Some(exact)))
    };
    Ok(Rounded { value, roundings })
}

/// An event whose slots' commands are compiled.
pub(super) struct CompiledEvent<'m, N> {
    /// The action; [`NO_ACTION`] if it has none.
    pub(super) action: u32,
    pub(super) slots: Vec<Vec<CompiledCommand<'m, N>>>,
}

/// All events of a model, in the order in which choices are made.
pub(super) fn compile<N: Arithmetic>(model: &Model) -> Vec<CompiledEvent<'_, N>> {
    // Rates need not sum to anything.
    let sum_known = model.model_type == ModelType::Ctmc;
    let compiled = |c| CompiledCommand::new(c, sum_known);
    let mut all = Vec::new();
    for event in events(model) {
        let slots = event.slots.into_iter();
        all.push(CompiledEvent {
            action: event.action.map_or(NO_ACTION, |a| a as u32),
            slots: slots
                .map(|s| s.into_iter().map(compiled).collect())
                .collect(),
        });
    }
    all
}
