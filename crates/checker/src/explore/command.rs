//! Commands, compiled for one number domain.
//!
//! A probability is computed exactly and rounded once, whatever the domain; where it depends on the state, the
//! result is remembered for the values of the variables that occur in it.

use prism_lang::resolved::{Command, Model};
use prism_lang::{Arithmetic, EvalError, EvalErrorKind, Expr, Number, Rational, VarIndex};
use rustc_hash::FxHashMap;

use super::code::Code;

/// A probability and by how much it may be off.
#[derive(Clone, Debug)]
pub(super) struct Rounded<N> {
    pub(super) value: N,
    /// How many roundings it went through (0: it is exact); `None`: it is irrational, and its error unknown.
    pub(super) roundings: Option<u32>,
}

/// Why a probability cannot be used.
pub(super) enum BadProbability {
    NoValue(EvalError),
    Negative(f64),
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
    pub(super) fn new(source: &'m Command) -> Self {
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
            sum_known: false,
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
    fn new(expr: &'m Expr) -> Self {
        let variables = expr.variables();
        if variables.is_empty()
            && let Ok(value) = evaluate(expr, &[])
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

    /// The probability in a state. `key` is scratch space.
    pub(super) fn value(
        &mut self,
        state: &[i64],
        key: &mut Vec<i64>,
    ) -> Result<Rounded<N>, BadProbability> {
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
                let value = evaluate(expr, state)?;
                known.insert(key.clone(), value.clone());
                Ok(value)
            }
        }
    }
}

/// Computes a probability exactly (as far as it is rational) and brings it into the domain.
fn evaluate<N: Arithmetic>(expr: &Expr, state: &[i64]) -> Result<Rounded<N>, BadProbability> {
    let number: Number = expr.eval_number(state).map_err(BadProbability::NoValue)?;
    if !number.is_non_negative() {
        return Err(BadProbability::Negative(number.to_f64()));
    }
    let value = N::from_literal(&number).ok_or({
        BadProbability::NoValue(EvalError {
            kind: EvalErrorKind::NotRational,
            span: expr.span,
        })
    })?;
    if !N::EXACT && !Arithmetic::is_zero(&number) && number.to_f64() < f64::MIN_POSITIVE {
        return Err(BadProbability::Underflow);
    }
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

/// All commands, in the order in which choices are made.
pub(super) struct Commands<'m, N> {
    /// Commands without action.
    pub(super) alone: Vec<CompiledCommand<'m, N>>,
    /// For each action, for each module that knows it: the commands of that action.
    pub(super) together: Vec<Vec<Vec<CompiledCommand<'m, N>>>>,
}

impl<'m, N: Arithmetic> Commands<'m, N> {
    pub(super) fn new(model: &'m Model) -> Self {
        let of_action = |action| {
            let mut modules: Vec<Vec<_>> = Vec::new();
            for module in &model.modules {
                let commands = module.commands.iter().filter(|c| c.action == action);
                modules.push(commands.map(CompiledCommand::new).collect());
            }
            modules.retain(|m| !m.is_empty());
            modules
        };
        Self {
            alone: of_action(None).into_iter().flatten().collect(),
            together: (0..model.actions.len())
                .map(|a| of_action(Some(a)))
                .collect(),
        }
    }
}
