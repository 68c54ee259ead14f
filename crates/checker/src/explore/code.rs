//! Expressions of integers and truth values in a form that evaluates fast.
//!
//! Comparisons of a variable with a constant become range tests, chains of `&` and `|` become lists. What has
//! no fast form (real numbers, functions) keeps its expression. A code has the value of its expression, or
//! `None` where that has none; evaluating the expression itself then tells why.

use prism_lang::ast::{BinaryOp, Type, UnaryOp};
use prism_lang::{Expr, ExprKind};

/// A compiled expression; truth values are 0 and 1.
#[derive(Clone, Debug)]
pub(super) enum Code {
    Constant(i64),
    Variable(usize),
    /// `low <= variable <= high`
    Within(usize, i64, i64),
    All(Vec<Code>),
    Any(Vec<Code>),
    Not(Box<Code>),
    Operation(BinaryOp, Box<Code>, Box<Code>),
    Choice(Box<Code>, Box<Code>, Box<Code>),
    Expression(Expr),
}

impl Code {
    /// Compiles a truth value or an integer.
    pub(super) fn new(expr: &Expr) -> Self {
        match &expr.kind {
            ExprKind::Bool(value) => Self::Constant(i64::from(*value)),
            ExprKind::Int(value) => Self::Constant(*value),
            ExprKind::Variable(index) => Self::Variable(*index),
            ExprKind::Unary(UnaryOp::Not, a) => Self::Not(Box::new(Self::new(a))),
            ExprKind::Unary(UnaryOp::Minus, a) => {
                Self::operation(BinaryOp::Minus, Self::Constant(0), Self::new(a))
            }
            ExprKind::Binary(operator, a, b) => Self::binary(expr, *operator, a, b),
            ExprKind::IfThenElse(c, a, b) => {
                let [c, a, b] = [c, a, b].map(|e| Box::new(Self::new(e)));
                Self::Choice(c, a, b)
            }
            ExprKind::Double(_) | ExprKind::Parameter(_) | ExprKind::Call(..) => {
                Self::Expression(expr.clone())
            }
        }
    }

    fn operation(operator: BinaryOp, a: Self, b: Self) -> Self {
        Self::Operation(operator, Box::new(a), Box::new(b))
    }

    fn binary(expr: &Expr, operator: BinaryOp, a: &Expr, b: &Expr) -> Self {
        if a.ty == Type::Double || b.ty == Type::Double || operator == BinaryOp::Power {
            return Self::Expression(expr.clone());
        }
        let (left, right) = (Self::new(a), Self::new(b));
        match operator {
            BinaryOp::And => Self::All(Self::flatten(left, right, |c| match c {
                Self::All(parts) => Ok(parts),
                other => Err(other),
            })),
            BinaryOp::Or => Self::Any(Self::flatten(left, right, |c| match c {
                Self::Any(parts) => Ok(parts),
                other => Err(other),
            })),
            BinaryOp::Implies => Self::Any(vec![Self::Not(Box::new(left)), right]),
            _ => Self::range_test(operator, &left, &right)
                .unwrap_or_else(|| Self::operation(operator, left, right)),
        }
    }

    /// The operands of a chain, in order.
    fn flatten(left: Self, right: Self, parts: fn(Self) -> Result<Vec<Self>, Self>) -> Vec<Self> {
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
    fn range_test(operator: BinaryOp, left: &Self, right: &Self) -> Option<Self> {
        let (variable, constant, operator) = match (left, right) {
            (Self::Variable(v), Self::Constant(c)) => (*v, *c, operator),
            (Self::Constant(c), Self::Variable(v)) => (*v, *c, mirrored(operator)),
            _ => return None,
        };
        let within = |low, high| Some(Self::Within(variable, low, high));
        match operator {
            BinaryOp::Equal | BinaryOp::Iff => within(constant, constant),
            BinaryOp::NotEqual => Some(Self::Not(Box::new(Self::Within(
                variable, constant, constant,
            )))),
            BinaryOp::Less => within(i64::MIN, constant.checked_sub(1)?),
            BinaryOp::LessEqual => within(i64::MIN, constant),
            BinaryOp::Greater => within(constant.checked_add(1)?, i64::MAX),
            BinaryOp::GreaterEqual => within(constant, i64::MAX),
            _ => None,
        }
    }

    /// The value in a state.
    #[inline]
    pub(super) fn value(&self, state: &[i64]) -> Option<i64> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Variable(index) => Some(state[*index]),
            Self::Within(index, low, high) => {
                let value = state[*index];
                Some(i64::from(*low <= value && value <= *high))
            }
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
            Self::Not(a) => Some(1 - a.value(state)?),
            Self::Operation(operator, a, b) => operate(*operator, a.value(state)?, b.value(state)?),
            Self::Choice(c, a, b) => {
                if c.value(state)? != 0 {
                    a.value(state)
                } else {
                    b.value(state)
                }
            }
            Self::Expression(expr) => match expr.ty {
                Type::Bool => expr.eval_bool(state).ok().map(i64::from),
                _ => expr.eval_int(state).ok(),
            },
        }
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
