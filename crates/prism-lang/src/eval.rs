//! The value of an expression in a state.
//!
//! Definition: the usual one, with PRISM's choices: `/` is real division, `&`, `|`, `=>` and `?:` evaluate
//! only what they need, `round` takes halves up, `mod` is never negative. Integers are 64 bits wide and
//! checked for overflow.
//!
//! Deviation from PRISM: comparisons and roundings of real numbers are decided exactly (`3 * 0.1 = 0.3` holds),
//! in every domain, so that all methods see the same states. Only irrational values are compared as `f64`.
//!
//! Cost: one visit of each node that is needed.

use std::cmp::Ordering;
use std::fmt;

use crate::arithmetic::Arithmetic;
use crate::ast::{BinaryOp, Type, UnaryOp};
use crate::diagnostic::Span;
use crate::expr::{Expr, ExprKind, Function};
use crate::number::Number;

/// Why an expression has no value in a state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EvalError {
    /// What went wrong.
    pub kind: EvalErrorKind,
    /// The subexpression that has no value.
    pub span: Span,
}

/// The ways in which an expression can lack a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EvalErrorKind {
    /// Division by zero.
    DivisionByZero,
    /// An integer beyond 64 bits.
    Overflow,
    /// `mod` by zero or by a negative number.
    NonPositiveModulus,
    /// An integer to a negative power.
    NegativeExponent,
    /// A power or a logarithm that is not a real number, or is too large.
    NotReal,
    /// A logarithm or a root, where an exact value is required.
    NotRational,
    /// A constant that was left open, in a domain that has no parameters or where a state depends on it.
    OpenParameter,
    /// The tree is ill-typed, or a state too short; never happens to trees made by `resolve`.
    IllTyped,
}

impl EvalErrorKind {
    /// What went wrong, without a remedy.
    pub fn problem(self) -> &'static str {
        match self {
            Self::DivisionByZero => "this divides by zero",
            Self::Overflow => "this integer does not fit into 64 bits",
            Self::NonPositiveModulus => "this computes `mod` by zero or by a negative number",
            Self::NegativeExponent => "this raises an integer to a negative exponent",
            Self::NotReal => "this power or logarithm is not a (finite) real number",
            Self::NotRational => {
                "this logarithm, or this power with a fractional exponent, has no exact value in general"
            }
            Self::OpenParameter => "this depends on a constant that was left open",
            Self::IllTyped => "this expression does not have the type that its place requires",
        }
    }

    /// What the author can do about it.
    pub fn remedy(self) -> &'static str {
        match self {
            Self::DivisionByZero => "guard the division, for example with `x>0 & ...`",
            Self::Overflow => "bound the variables, or compute with doubles",
            Self::NonPositiveModulus => "make the second argument positive",
            Self::NegativeExponent => "write the base as a double, such as 2.0",
            Self::NotReal => "check its arguments",
            Self::NotRational => "use a method that is not exact",
            Self::OpenParameter => "give the constant a value",
            Self::IllTyped => "use expressions made by `resolve`",
        }
    }
}

impl fmt::Display for EvalError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.kind.problem(), self.kind.remedy())
    }
}

impl std::error::Error for EvalError {}

type Evaluated<T> = Result<T, EvalError>;

impl Expr {
    /// The truth value in `state` (one value per variable).
    ///
    /// # Errors
    /// If a needed part has no value, or the expression is not a `bool`.
    pub fn eval_bool(&self, state: &[i64]) -> Evaluated<bool> {
        match &self.kind {
            ExprKind::Bool(value) => Ok(*value),
            ExprKind::Variable(index) if self.ty == Type::Bool => {
                Ok(self.look_up(*index, state)? != 0)
            }
            ExprKind::Unary(UnaryOp::Not, a) => Ok(!a.eval_bool(state)?),
            ExprKind::Binary(operator, a, b) => self.eval_relation(*operator, a, b, state),
            ExprKind::IfThenElse(condition, a, b) => {
                let chosen = if condition.eval_bool(state)? { a } else { b };
                chosen.eval_bool(state)
            }
            _ => Err(self.no_value(EvalErrorKind::IllTyped)),
        }
    }

    fn eval_relation(
        &self,
        operator: BinaryOp,
        a: &Expr,
        b: &Expr,
        state: &[i64],
    ) -> Evaluated<bool> {
        match operator {
            BinaryOp::And => Ok(a.eval_bool(state)? && b.eval_bool(state)?),
            BinaryOp::Or => Ok(a.eval_bool(state)? || b.eval_bool(state)?),
            BinaryOp::Implies => Ok(!a.eval_bool(state)? || b.eval_bool(state)?),
            BinaryOp::Iff => Ok(a.eval_bool(state)? == b.eval_bool(state)?),
            _ => {
                let order = compare(a, b, state)?;
                compare_holds(operator, order).ok_or_else(|| self.no_value(EvalErrorKind::IllTyped))
            }
        }
    }

    /// The integer value in `state`.
    ///
    /// # Errors
    /// If a needed part has no value, the result does not fit, or the expression is not an `int`.
    pub fn eval_int(&self, state: &[i64]) -> Evaluated<i64> {
        match &self.kind {
            ExprKind::Int(value) => Ok(*value),
            ExprKind::Variable(index) if self.ty == Type::Int => self.look_up(*index, state),
            ExprKind::Unary(UnaryOp::Minus, a) => {
                let negated = a.eval_int(state)?.checked_neg();
                negated.ok_or_else(|| self.no_value(EvalErrorKind::Overflow))
            }
            ExprKind::Binary(operator, a, b) => {
                let (a, b) = (a.eval_int(state)?, b.eval_int(state)?);
                integer_operation(*operator, a, b).map_err(|kind| self.no_value(kind))
            }
            ExprKind::IfThenElse(condition, a, b) => {
                let chosen = if condition.eval_bool(state)? { a } else { b };
                chosen.eval_int(state)
            }
            ExprKind::Call(function, arguments) => self.eval_int_call(*function, arguments, state),
            ExprKind::Parameter(_) => Err(self.no_value(EvalErrorKind::OpenParameter)),
            _ => Err(self.no_value(EvalErrorKind::IllTyped)),
        }
    }

    fn eval_int_call(
        &self,
        function: Function,
        arguments: &[Expr],
        state: &[i64],
    ) -> Evaluated<i64> {
        let ill_typed = || self.no_value(EvalErrorKind::IllTyped);
        match function {
            Function::Min | Function::Max => {
                let mut best: Option<i64> = None;
                for argument in arguments {
                    let value = argument.eval_int(state)?;
                    best = Some(match best {
                        Some(b) if function == Function::Min => b.min(value),
                        Some(b) => b.max(value),
                        None => value,
                    });
                }
                best.ok_or_else(ill_typed)
            }
            Function::Floor | Function::Ceil | Function::Round => {
                let value: Number = arguments
                    .first()
                    .ok_or_else(ill_typed)?
                    .eval_number(state)?;
                round(function, &value).ok_or_else(|| self.no_value(EvalErrorKind::Overflow))
            }
            Function::Pow | Function::Mod => {
                let [a, b] = arguments else {
                    return Err(ill_typed());
                };
                let (a, b) = (a.eval_int(state)?, b.eval_int(state)?);
                let result = if function == Function::Pow {
                    integer_power(a, b)
                } else {
                    modulus(a, b)
                };
                result.map_err(|kind| self.no_value(kind))
            }
            Function::Log => Err(ill_typed()),
        }
    }

    /// The numeric value in `state`, in the domain `N`; for an `int` or a `double`.
    ///
    /// # Errors
    /// If a needed part has no value, is irrational in an exact domain, or the expression is a `bool`.
    pub fn eval_number<N: Arithmetic>(&self, state: &[i64]) -> Evaluated<N> {
        if self.ty == Type::Int {
            match self.eval_int(state) {
                // Goes on in the domain, which may have parameters.
                Err(error) if error.kind == EvalErrorKind::OpenParameter => {}
                value => return value.map(N::from_i64),
            }
        }
        match &self.kind {
            ExprKind::Parameter(index) => {
                N::parameter(*index).ok_or_else(|| self.no_value(EvalErrorKind::OpenParameter))
            }
            ExprKind::Double(number) => {
                N::from_literal(number).ok_or_else(|| self.no_value(EvalErrorKind::NotRational))
            }
            ExprKind::Unary(UnaryOp::Minus, a) => Ok(N::zero().sub(&a.eval_number(state)?)),
            ExprKind::Binary(operator, a, b) => {
                let (a, b): (N, N) = (a.eval_number(state)?, b.eval_number(state)?);
                self.number_operation(*operator, &a, &b)
            }
            ExprKind::IfThenElse(condition, a, b) => {
                let chosen = if condition.eval_bool(state)? { a } else { b };
                chosen.eval_number(state)
            }
            ExprKind::Call(function, arguments) => {
                self.eval_number_call(*function, arguments, state)
            }
            _ => Err(self.no_value(EvalErrorKind::IllTyped)),
        }
    }

    fn number_operation<N: Arithmetic>(&self, operator: BinaryOp, a: &N, b: &N) -> Evaluated<N> {
        match operator {
            BinaryOp::Plus => Ok(a.add(b)),
            BinaryOp::Minus => Ok(a.sub(b)),
            BinaryOp::Times => Ok(a.mul(b)),
            BinaryOp::Divide => a
                .div(b)
                .ok_or_else(|| self.no_value(EvalErrorKind::DivisionByZero)),
            BinaryOp::Power => self.real_power(a, b),
            _ => Err(self.no_value(EvalErrorKind::IllTyped)),
        }
    }

    fn real_power<N: Arithmetic>(&self, base: &N, exponent: &N) -> Evaluated<N> {
        base.pow(exponent).ok_or_else(|| {
            // The inexact domain tells a root from what is no real number at all.
            let real = Arithmetic::pow(&base.to_f64(), &exponent.to_f64()).is_some();
            self.no_value(if real {
                EvalErrorKind::NotRational
            } else {
                EvalErrorKind::NotReal
            })
        })
    }

    fn eval_number_call<N: Arithmetic>(
        &self,
        function: Function,
        arguments: &[Expr],
        state: &[i64],
    ) -> Evaluated<N> {
        let mut values = Vec::with_capacity(arguments.len());
        for argument in arguments {
            values.push(argument.eval_number::<N>(state)?);
        }
        let ill_typed = || self.no_value(EvalErrorKind::IllTyped);
        if matches!(function, Function::Min | Function::Max) && !are_ordered(&values) {
            return Err(self.no_value(EvalErrorKind::OpenParameter));
        }
        match (function, &values[..]) {
            (Function::Min, _) => least(values, Ordering::Less).ok_or_else(ill_typed),
            (Function::Max, _) => least(values, Ordering::Greater).ok_or_else(ill_typed),
            (Function::Pow, [a, b]) => self.real_power(a, b),
            (Function::Log, [a, b]) => a.log(b).ok_or_else(|| {
                let real = Arithmetic::log(&a.to_f64(), &b.to_f64()).is_some();
                self.no_value(if real {
                    EvalErrorKind::NotRational
                } else {
                    EvalErrorKind::NotReal
                })
            }),
            _ => Err(ill_typed()),
        }
    }

    fn look_up(&self, index: usize, state: &[i64]) -> Evaluated<i64> {
        let value = state.get(index).copied();
        value.ok_or_else(|| self.no_value(EvalErrorKind::IllTyped))
    }

    fn no_value(&self, kind: EvalErrorKind) -> EvalError {
        EvalError {
            kind,
            span: self.span,
        }
    }
}

/// The order of two operands of one type, or of two numbers; `None` if one is not a number.
fn compare(a: &Expr, b: &Expr, state: &[i64]) -> Evaluated<Option<Ordering>> {
    Ok(match (a.ty, b.ty) {
        (Type::Bool, Type::Bool) => Some(a.eval_bool(state)?.cmp(&b.eval_bool(state)?)),
        (Type::Int, Type::Int) => Some(a.eval_int(state)?.cmp(&b.eval_int(state)?)),
        _ => {
            let (a, b): (Number, Number) = (a.eval_number(state)?, b.eval_number(state)?);
            a.partial_cmp(&b)
        }
    })
}

/// Whether a comparison holds of an order; `None` if the operator is no comparison.
fn compare_holds(operator: BinaryOp, order: Option<Ordering>) -> Option<bool> {
    Some(match operator {
        BinaryOp::Equal => order == Some(Ordering::Equal),
        BinaryOp::NotEqual => order != Some(Ordering::Equal),
        BinaryOp::Less => order == Some(Ordering::Less),
        BinaryOp::LessEqual => matches!(order, Some(Ordering::Less | Ordering::Equal)),
        BinaryOp::Greater => order == Some(Ordering::Greater),
        BinaryOp::GreaterEqual => matches!(order, Some(Ordering::Greater | Ordering::Equal)),
        _ => return None,
    })
}

fn integer_operation(operator: BinaryOp, a: i64, b: i64) -> Result<i64, EvalErrorKind> {
    let result = match operator {
        BinaryOp::Plus => a.checked_add(b),
        BinaryOp::Minus => a.checked_sub(b),
        BinaryOp::Times => a.checked_mul(b),
        BinaryOp::Power => return integer_power(a, b),
        _ => return Err(EvalErrorKind::IllTyped),
    };
    result.ok_or(EvalErrorKind::Overflow)
}

fn integer_power(base: i64, exponent: i64) -> Result<i64, EvalErrorKind> {
    if exponent < 0 {
        return Err(EvalErrorKind::NegativeExponent);
    }
    match base {
        // Exponents beyond 32 bits only make sense for these bases.
        0 | 1 => Ok(if exponent == 0 { 1 } else { base }),
        -1 => Ok(if exponent % 2 == 0 { 1 } else { -1 }),
        _ => u32::try_from(exponent)
            .ok()
            .and_then(|e| base.checked_pow(e))
            .ok_or(EvalErrorKind::Overflow),
    }
}

fn modulus(a: i64, b: i64) -> Result<i64, EvalErrorKind> {
    if b <= 0 {
        return Err(EvalErrorKind::NonPositiveModulus);
    }
    Ok(a.rem_euclid(b))
}

fn round(function: Function, value: &Number) -> Option<i64> {
    let negated = |v: &Number| Number::from_i64(0).sub(v);
    match function {
        Function::Floor => value.floor(),
        Function::Ceil => negated(value).floor()?.checked_neg(),
        _ => {
            let half = Number::from_rational(num_rational::BigRational::new(1.into(), 2.into()));
            value.add(&half).floor()
        }
    }
}

/// Whether all values of an exact domain compare with each other: functions of open constants need not.
fn are_ordered<N: Arithmetic>(values: &[N]) -> bool {
    let pairs = |a: &N| values.iter().all(|b| a.partial_cmp(b).is_some());
    !N::EXACT || values.iter().all(pairs)
}

/// The first extreme value: less (or greater) than all others.
fn least<N: Arithmetic>(values: Vec<N>, wanted: Ordering) -> Option<N> {
    values.into_iter().reduce(|best, value| {
        if value.partial_cmp(&best) == Some(wanted) {
            value
        } else {
            best
        }
    })
}
