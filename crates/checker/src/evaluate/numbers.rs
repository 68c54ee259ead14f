//! Arithmetic over quantities.

use std::cmp::Ordering;

use prism_lang::ast::{BinaryOp, Optimum, Type};
use prism_lang::property::Quantity;
use prism_lang::{EvalError, EvalErrorKind, Expr, ExprKind, Function, Number};

use super::{Evaluator, chosen};
use crate::amount::Amount;
use crate::answer::CheckError;
use crate::engine::Numbers;
use crate::state_space::StateError;

impl<E: Numbers> Evaluator<'_, E> {
    /// The values of a quantity in the states `from`.
    pub(super) fn numbers(
        &mut self,
        quantity: &Quantity,
        from: &[usize],
    ) -> Result<Vec<E::Amount>, CheckError> {
        Ok(match quantity {
            Quantity::Expr(expr) => self.expression(expr, from)?,
            Quantity::Probability { optimum, path } => {
                let maximise = *optimum != Some(Optimum::Min);
                let values = self.probability(path, maximise, from)?;
                values.iter().map(E::amount).collect()
            }
            Quantity::Conditional {
                optimum,
                path,
                condition,
            } => self.conditional((path, condition), *optimum != Some(Optimum::Min), from)?,
            Quantity::Reward { optimum, reward } => {
                self.reward(reward, *optimum != Some(Optimum::Min), from)?
            }
            Quantity::LongRun(states) => self.long_run(states, from)?,
            Quantity::Minus(operand) => {
                let values = self.numbers(operand, from)?;
                values.iter().map(Amount::negative).collect()
            }
            Quantity::Binary(operator, a, b) => {
                let integers = a.ty() == Type::Int && b.ty() == Type::Int;
                let (a, b) = (self.numbers(a, from)?, self.numbers(b, from)?);
                let pairs = a.iter().zip(&b);
                pairs
                    .map(|(a, b)| binary(*operator, a, b, integers))
                    .collect::<Result<_, _>>()?
            }
            Quantity::Choice(condition, a, b) => {
                let condition = self.truths(condition, from)?;
                let (a, b) = (self.numbers(a, from)?, self.numbers(b, from)?);
                chosen(&condition, a, b)
            }
            Quantity::Call(function, arguments) => {
                let arguments: Vec<Vec<E::Amount>> = (arguments.iter())
                    .map(|argument| self.numbers(argument, from))
                    .collect::<Result<_, _>>()?;
                let at = |place: usize| {
                    arguments
                        .iter()
                        .map(|values| values[place].clone())
                        .collect()
                };
                let call = |place| call(*function, at(place));
                (0..from.len()).map(call).collect::<Result<_, _>>()?
            }
            Quantity::Filter(filter) => self.filter_numbers(filter, from)?,
        })
    }

    fn expression(
        &self,
        expr: &prism_lang::Expr,
        from: &[usize],
    ) -> Result<Vec<E::Amount>, CheckError> {
        let value = |state: &usize| {
            let values = self.space.state(*state);
            match expr.eval_number::<Number>(&values) {
                Ok(number) => Ok(E::Amount::literal(&number)),
                Err(error) if has_limit(&error) => {
                    limit::<E::Amount>(expr, &values).map_err(|error| self.no_value(error, *state))
                }
                Err(error) => Err(self.no_value(error, *state)),
            }
        };
        from.iter().map(value).collect()
    }

    fn no_value(&self, error: EvalError, state: usize) -> CheckError {
        let state = self.space.describe(state);
        CheckError::State(StateError::NoValue { error, state })
    }

    /// Whether two quantities compare so, in the states `from`.
    pub(super) fn compared(
        &mut self,
        operator: BinaryOp,
        a: &Quantity,
        b: &Quantity,
        from: &[usize],
    ) -> Result<Vec<bool>, CheckError> {
        let (a, b) = (self.numbers(a, from)?, self.numbers(b, from)?);
        a.iter()
            .zip(&b)
            .map(|(a, b)| compare(operator, a, b))
            .collect()
    }
}

/// Whether arithmetic with infinities, as in PRISM's properties, has an answer where that of models has none.
fn has_limit(error: &EvalError) -> bool {
    matches!(
        error.kind,
        EvalErrorKind::DivisionByZero | EvalErrorKind::NotReal
    )
}

/// A real expression in which a division by zero is an infinity, or undefined.
fn limit<A: Amount>(expr: &Expr, state: &[i64]) -> Result<A, EvalError> {
    match expr.eval_number::<Number>(state) {
        Ok(number) => return Ok(A::literal(&number)),
        Err(error) if !has_limit(&error) => return Err(error),
        Err(_) => {}
    }
    let undefined = |_| EvalError {
        kind: EvalErrorKind::NotReal,
        span: expr.span,
    };
    match &expr.kind {
        ExprKind::Unary(_, a) => Ok(limit::<A>(a, state)?.negative()),
        ExprKind::Binary(operator, a, b) => {
            let integers = a.ty == Type::Int && b.ty == Type::Int && *operator == BinaryOp::Power;
            let (a, b) = (limit::<A>(a, state)?, limit::<A>(b, state)?);
            binary(*operator, &a, &b, integers).map_err(undefined)
        }
        ExprKind::IfThenElse(condition, a, b) => match condition.eval_bool(state)? {
            true => limit(a, state),
            false => limit(b, state),
        },
        ExprKind::Call(function, arguments) => {
            let arguments = arguments.iter().map(|a| limit::<A>(a, state));
            call(*function, arguments.collect::<Result<_, _>>()?).map_err(undefined)
        }
        _ => Err(EvalError {
            kind: EvalErrorKind::NotReal,
            span: expr.span,
        }),
    }
}

fn compare<A: Amount>(operator: BinaryOp, a: &A, b: &A) -> Result<bool, CheckError> {
    if a.is_undefined() || b.is_undefined() {
        return Ok(operator == BinaryOp::NotEqual);
    }
    let holds = |order: Ordering| match operator {
        BinaryOp::Equal => order == Ordering::Equal,
        BinaryOp::NotEqual => order != Ordering::Equal,
        BinaryOp::Less => order == Ordering::Less,
        BinaryOp::LessEqual => order != Ordering::Greater,
        BinaryOp::Greater => order == Ordering::Greater,
        _ => order != Ordering::Less,
    };
    let (x, y) = (a.bounds(), b.bounds());
    match a.compare(b) {
        Some(order) => Ok(holds(order)),
        // Known up to equality.
        None if x.high <= y.low && holds(Ordering::Less) == holds(Ordering::Equal) => {
            Ok(holds(Ordering::Less))
        }
        None if x.low >= y.high && holds(Ordering::Greater) == holds(Ordering::Equal) => {
            Ok(holds(Ordering::Greater))
        }
        None => Err(CheckError::Undecided {
            comparison: format!(
                "{} a number between {} and {}",
                operator.symbol(),
                y.low,
                y.high
            ),
            bounds: x,
            is_whole: false,
        }),
    }
}

fn binary<A: Amount>(operator: BinaryOp, a: &A, b: &A, integers: bool) -> Result<A, CheckError> {
    match operator {
        BinaryOp::Plus => Ok(a.add(b)),
        BinaryOp::Minus => Ok(a.sub(b)),
        BinaryOp::Times => Ok(a.mul(b)),
        BinaryOp::Divide => Ok(a.div(b)),
        _ => power(a, b, integers),
    }
}

fn power<A: Amount>(a: &A, b: &A, integers: bool) -> Result<A, CheckError> {
    if integers && b.bounds().high < 0.0 {
        return Err(CheckError::Unsupported(
            "an integer is raised to a negative exponent: write the base as a real number, such as `2.0`"
                .to_owned(),
        ));
    }
    a.pow(b).ok_or_else(irrational)
}

fn irrational() -> CheckError {
    CheckError::Unsupported(
        "this power or logarithm has no value that the method can represent: use the sound method"
            .to_owned(),
    )
}

fn call<A: Amount>(function: Function, arguments: Vec<A>) -> Result<A, CheckError> {
    let half = || A::one().div(&A::one().add(&A::one()));
    let rounded = |value: A| {
        value.floor().ok_or_else(|| CheckError::Undecided {
            comparison: "below or above the next integer".to_owned(),
            bounds: value.bounds(),
            is_whole: false,
        })
    };
    let mut given = arguments.into_iter();
    let (first, second) = (given.next().unwrap_or_else(A::undefined), given.next());
    let other = || second.clone().unwrap_or_else(A::undefined);
    match function {
        Function::Min => Ok(second
            .iter()
            .chain(given.as_slice())
            .fold(first, |a, b| a.least(b))),
        Function::Max => Ok(second
            .iter()
            .chain(given.as_slice())
            .fold(first, |a, b| a.greatest(b))),
        Function::Floor => rounded(first),
        Function::Ceil => rounded(first.negative()).map(|value| value.negative()),
        Function::Round => rounded(first.add(&half())),
        Function::Pow => power(&first, &other(), false),
        Function::Mod => {
            let quotient = rounded(first.div(&other()))?;
            Ok(first.sub(&quotient.mul(&other())))
        }
        Function::Log => first.log(&other()).ok_or_else(irrational),
    }
}
