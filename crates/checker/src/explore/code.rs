//! Expressions of integers and truth values in a form that evaluates fast, on packed states.
//!
//! A variable is read by a shift and a mask. Comparisons of a variable with a constant become range tests,
//! chains of `&` and `|` become lists, comparisons of rational numbers go through [`Quotient`]. A code has the
//! value of its expression, or `None` where that has none or where a number outgrew 64 bits on the way:
//! evaluating the expression itself ([`Compiler::slowly`]) then tells which, and why.
//!
//! Deviation: none in values; where the expression's own evaluation has a value, that is used. Cost: one visit
//! of each node that is needed. Guarantee: a value that is given is the expression's.

use prism_lang::ast::{BinaryOp, Type, UnaryOp};
use prism_lang::resolved::Variable;
use prism_lang::{EvalError, EvalErrorKind, Expr, ExprKind, Function};

use super::quotient::Quotient;
use crate::state_space::{Field, Layout, describe};

/// A compiled expression; truth values are 0 and 1.
#[derive(Clone, Debug)]
pub(crate) enum Code {
    Constant(i64),
    Variable(Field),
    /// `low <= variable <= high`
    Within(Field, i64, i64),
    All(Vec<Code>),
    Any(Vec<Code>),
    Not(Box<Code>),
    Operation(BinaryOp, Box<Code>, Box<Code>),
    /// Operands are rational.
    Comparison(BinaryOp, Box<Quotient>, Box<Quotient>),
    Choice(Box<Code>, Box<Code>, Box<Code>),
    Call(Function, Vec<Code>),
    /// `floor`, `ceil` or `round` of a rational number.
    Rounded(Function, Box<Quotient>),
    /// Has no fast form: the expression itself must be evaluated.
    Slow(Vec<Field>),
}

/// Compiles expressions over one layout, and evaluates them where their code gives up.
#[derive(Clone, Copy)]
pub(crate) struct Compiler<'m> {
    pub(crate) variables: &'m [Variable],
    pub(crate) layout: &'m Layout,
}

impl Compiler<'_> {
    /// Compiles a truth value or an integer.
    pub(crate) fn code(self, expr: &Expr) -> Code {
        match &expr.kind {
            ExprKind::Bool(value) => Code::Constant(i64::from(*value)),
            ExprKind::Int(value) => Code::Constant(*value),
            ExprKind::Variable(index) => Code::Variable(self.layout.field(*index)),
            ExprKind::Unary(UnaryOp::Not, a) => Code::Not(Box::new(self.code(a))),
            ExprKind::Unary(UnaryOp::Minus, a) => {
                operation(BinaryOp::Minus, Code::Constant(0), self.code(a))
            }
            ExprKind::Binary(operator, a, b) => self.binary(expr, *operator, a, b),
            ExprKind::IfThenElse(c, a, b) => {
                let [c, a, b] = [c, a, b].map(|e| Box::new(self.code(e)));
                Code::Choice(c, a, b)
            }
            ExprKind::Call(function, arguments) => self.call(expr, *function, arguments),
            ExprKind::Double(_) | ExprKind::Parameter(_) => self.slow(expr),
        }
    }

    fn slow(self, expr: &Expr) -> Code {
        let fields = expr.variables().into_iter();
        Code::Slow(fields.map(|v| self.layout.field(v)).collect())
    }

    fn call(self, expr: &Expr, function: Function, arguments: &[Expr]) -> Code {
        let are_ints = arguments.iter().all(|a| a.ty == Type::Int);
        match (function, arguments) {
            (Function::Min | Function::Max | Function::Mod, _) if are_ints => {
                Code::Call(function, arguments.iter().map(|a| self.code(a)).collect())
            }
            (Function::Floor | Function::Ceil | Function::Round, [of]) => match self.quotient(of) {
                Some(of) => Code::Rounded(function, Box::new(of)),
                None => self.slow(expr),
            },
            _ => self.slow(expr),
        }
    }

    fn binary(self, expr: &Expr, operator: BinaryOp, a: &Expr, b: &Expr) -> Code {
        if a.ty == Type::Double || b.ty == Type::Double {
            return match (self.quotient(a), self.quotient(b)) {
                (Some(a), Some(b)) => Code::Comparison(operator, Box::new(a), Box::new(b)),
                _ => self.slow(expr),
            };
        }
        if operator == BinaryOp::Power {
            return self.slow(expr);
        }
        let (left, right) = (self.code(a), self.code(b));
        match operator {
            BinaryOp::And => Code::All(flatten(left, right, |c| match c {
                Code::All(parts) => Ok(parts),
                other => Err(other),
            })),
            BinaryOp::Or => Code::Any(flatten(left, right, |c| match c {
                Code::Any(parts) => Ok(parts),
                other => Err(other),
            })),
            BinaryOp::Implies => Code::Any(vec![Code::Not(Box::new(left)), right]),
            _ => range_test(operator, &left, &right)
                .unwrap_or_else(|| operation(operator, left, right)),
        }
    }

    /// Whether a truth value holds, by its code or, where that gives up, by the expression itself.
    ///
    /// # Errors
    /// If it has no value.
    #[inline]
    pub(crate) fn holds(self, code: &Code, expr: &Expr, state: &[u64]) -> Result<bool, EvalError> {
        let value = code.value(state);
        value
            .map_or_else(|| self.slowly(expr, state), Ok)
            .map(|v| v != 0)
    }

    /// The value of an expression where its code gives up, or why it has none.
    pub(crate) fn slowly(self, expr: &Expr, state: &[u64]) -> Result<i64, EvalError> {
        let values = self.values(state);
        match expr.ty {
            Type::Bool => expr.eval_bool(&values).map(i64::from),
            Type::Int => expr.eval_int(&values),
            _ => Err(EvalError {
                kind: EvalErrorKind::IllTyped,
                span: expr.span,
            }),
        }
    }

    /// A state, written out.
    pub(crate) fn describe(self, state: &[u64]) -> String {
        describe(self.variables, &self.values(state))
    }

    /// The values of all variables.
    pub(crate) fn values(self, state: &[u64]) -> Vec<i64> {
        let mut values = vec![0; self.layout.len()];
        self.layout.unpack(state, &mut values);
        values
    }
}

fn operation(operator: BinaryOp, a: Code, b: Code) -> Code {
    Code::Operation(operator, Box::new(a), Box::new(b))
}

/// The operands of a chain, in order.
fn flatten(left: Code, right: Code, parts: fn(Code) -> Result<Vec<Code>, Code>) -> Vec<Code> {
    let mut all = Vec::new();
    for side in [left, right] {
        match parts(side) {
            Ok(list) => all.extend(list),
            Err(single) => all.push(single),
        }
    }
    all
}

/// A comparison of a variable with a constant, as a range.
fn range_test(operator: BinaryOp, left: &Code, right: &Code) -> Option<Code> {
    let (variable, constant, operator) = match (left, right) {
        (Code::Variable(v), Code::Constant(c)) => (*v, *c, operator),
        (Code::Constant(c), Code::Variable(v)) => (*v, *c, mirrored(operator)),
        _ => return None,
    };
    let within = |low, high| Some(Code::Within(variable, low, high));
    match operator {
        BinaryOp::Equal | BinaryOp::Iff => within(constant, constant),
        BinaryOp::NotEqual => Some(Code::Not(Box::new(Code::Within(
            variable, constant, constant,
        )))),
        BinaryOp::Less => within(i64::MIN, constant.checked_sub(1)?),
        BinaryOp::LessEqual => within(i64::MIN, constant),
        BinaryOp::Greater => within(constant.checked_add(1)?, i64::MAX),
        BinaryOp::GreaterEqual => within(constant, i64::MAX),
        _ => None,
    }
}

/// The operator that means the same with its operands exchanged.
fn mirrored(operator: BinaryOp) -> BinaryOp {
    match operator {
        BinaryOp::Less => BinaryOp::Greater,
        BinaryOp::LessEqual => BinaryOp::GreaterEqual,
        BinaryOp::Greater => BinaryOp::Less,
        BinaryOp::GreaterEqual => BinaryOp::LessEqual,
        // `-` and `/` are no tests, so that it does not matter.
        other => other,
    }
}

impl Code {
    /// The value in a state.
    #[inline]
    pub(crate) fn value(&self, state: &[u64]) -> Option<i64> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Variable(field) => Some(field.value(state)),
            Self::Within(field, low, high) => {
                let value = field.value(state);
                Some(i64::from(*low <= value && value <= *high))
            }
            Self::Not(a) => Some(1 - a.value(state)?),
            Self::Operation(operator, a, b) => operate(*operator, a.value(state)?, b.value(state)?),
            other => other.rare_value(state),
        }
    }

    fn rare_value(&self, state: &[u64]) -> Option<i64> {
        match self {
            Self::All(parts) => {
                for part in parts {
                    if part.value(state)? == 0 {
                        return Some(0);
                    }
                }
                Some(1)
            }
            Self::Any(parts) => {
                for part in parts {
                    if part.value(state)? != 0 {
                        return Some(1);
                    }
                }
                Some(0)
            }
            Self::Choice(c, a, b) => {
                let chosen = if c.value(state)? != 0 { a } else { b };
                chosen.value(state)
            }
            Self::Comparison(operator, a, b) => {
                let order = a.value(state)?.compare(b.value(state)?);
                operate(*operator, order as i64, 0)
            }
            Self::Call(function, arguments) => call(*function, arguments, state),
            Self::Rounded(function, of) => of.value(state)?.rounded(*function),
            _ => None,
        }
    }

    /// Calls `visit` with every variable that it reads.
    pub(crate) fn for_each_field(&self, visit: &mut dyn FnMut(Field)) {
        match self {
            Self::Constant(_) => {}
            Self::Variable(field) | Self::Within(field, ..) => visit(*field),
            Self::Slow(fields) => fields.iter().for_each(|f| visit(*f)),
            Self::All(parts) | Self::Any(parts) | Self::Call(_, parts) => {
                parts.iter().for_each(|p| p.for_each_field(visit));
            }
            Self::Not(a) => a.for_each_field(visit),
            Self::Operation(_, a, b) => [a, b].iter().for_each(|p| p.for_each_field(visit)),
            Self::Comparison(_, a, b) => [a, b].iter().for_each(|p| p.for_each_field(visit)),
            Self::Choice(c, a, b) => [c, a, b].iter().for_each(|p| p.for_each_field(visit)),
            Self::Rounded(_, of) => of.for_each_field(visit),
        }
    }

    /// The interval of its values by interval arithmetic; `None` if it may have no value in some state.
    pub(crate) fn range(&self) -> Option<(i64, i64)> {
        match self {
            Self::Constant(value) => Some((*value, *value)),
            Self::Variable(field) => Some(field.bounds()),
            Self::Within(..) => Some((0, 1)),
            Self::All(parts) | Self::Any(parts) => {
                let total = parts.iter().all(|p| p.range().is_some());
                total.then_some((0, 1))
            }
            Self::Not(a) => a.range().map(|_| (0, 1)),
            Self::Operation(operator, a, b) => operation_range(*operator, a.range()?, b.range()?),
            Self::Choice(c, a, b) => {
                c.range()?;
                let (a, b) = (a.range()?, b.range()?);
                Some((a.0.min(b.0), a.1.max(b.1)))
            }
            Self::Call(Function::Min | Function::Max, parts) => {
                let ranges: Vec<_> = parts.iter().map(Self::range).collect::<Option<_>>()?;
                let low = ranges.iter().map(|r| r.0).min()?;
                Some((low, ranges.iter().map(|r| r.1).max()?))
            }
            Self::Call(Function::Mod, parts) => match &parts[..] {
                [a, b] => {
                    a.range()?;
                    b.range().filter(|b| b.0 > 0).map(|b| (0, b.1 - 1))
                }
                _ => None,
            },
            Self::Comparison(..) | Self::Call(..) | Self::Rounded(..) | Self::Slow(_) => None,
        }
    }
}

fn operation_range(operator: BinaryOp, a: (i64, i64), b: (i64, i64)) -> Option<(i64, i64)> {
    match operator {
        BinaryOp::Plus => Some((a.0.checked_add(b.0)?, a.1.checked_add(b.1)?)),
        BinaryOp::Minus => Some((a.0.checked_sub(b.1)?, a.1.checked_sub(b.0)?)),
        BinaryOp::Times => {
            let mut corners = [0; 4];
            for (at, (x, y)) in [(a.0, b.0), (a.0, b.1), (a.1, b.0), (a.1, b.1)]
                .iter()
                .enumerate()
            {
                corners[at] = x.checked_mul(*y)?;
            }
            Some((*corners.iter().min()?, *corners.iter().max()?))
        }
        _ => operate(operator, 0, 0).map(|_| (0, 1)),
    }
}

fn operate(operator: BinaryOp, a: i64, b: i64) -> Option<i64> {
    match operator {
        BinaryOp::Plus => a.checked_add(b),
        BinaryOp::Minus => a.checked_sub(b),
        BinaryOp::Times => a.checked_mul(b),
        BinaryOp::Equal | BinaryOp::Iff => Some(i64::from(a == b)),
        BinaryOp::NotEqual => Some(i64::from(a != b)),
        BinaryOp::Less => Some(i64::from(a < b)),
        BinaryOp::LessEqual => Some(i64::from(a <= b)),
        BinaryOp::Greater => Some(i64::from(a > b)),
        BinaryOp::GreaterEqual => Some(i64::from(a >= b)),
        _ => None,
    }
}

fn call(function: Function, arguments: &[Code], state: &[u64]) -> Option<i64> {
    let (first, rest) = arguments.split_first()?;
    let mut result = first.value(state)?;
    for argument in rest {
        let value = argument.value(state)?;
        result = match function {
            Function::Min => result.min(value),
            Function::Max => result.max(value),
            Function::Mod if value > 0 => result.rem_euclid(value),
            _ => return None,
        };
    }
    Some(result)
}
