//! Trees to something fast: signals looked up, types checked, names expanded.
//!
//! Cost: evaluation visits each node of the expanded tree at most once. Missing numbers are NaN
//! within; the connectives are Kleene's (see [`super`]).

use super::error::{PredicateError, PredicateErrorKind};
use super::parser::{Comparison, Function, MAX_DEPTH, Node, NodeKind, Operator};
use super::{Expression, Source};
use crate::channel::FieldKind;
use crate::signal::{Cursor, SignalIndex, Trace};
use crate::suggest::nearest;

/// The largest number of nodes of an expanded tree.
const MAX_NODES: usize = 100_000;

/// A predicate whose signals have been found in a trace.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundPredicate(Truth);

/// A quantity whose signals have been found in a trace.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundQuantity(Amount);

impl BoundPredicate {
    /// The value at the cursor's time; `None` where it is unknown. The cursor must be over the
    /// trace that the predicate was bound to, or over one with the same channels and fields.
    #[must_use]
    pub fn eval(&self, cursor: &Cursor<'_>) -> Option<bool> {
        self.0.eval(cursor)
    }
}

impl BoundQuantity {
    /// The value at the cursor's time; `None` where it is missing. The cursor must be over the
    /// trace that the quantity was bound to, or over one with the same channels and fields.
    #[must_use]
    pub fn eval(&self, cursor: &Cursor<'_>) -> Option<f64> {
        let value = self.0.eval(cursor);
        (!value.is_nan()).then_some(value)
    }
}

/// Something true, false or unknown.
#[derive(Debug, Clone, PartialEq)]
enum Truth {
    Constant(bool),
    Signal(SignalIndex),
    Not(Box<Truth>),
    And(Box<Truth>, Box<Truth>),
    Or(Box<Truth>, Box<Truth>),
    Same(Box<Truth>, Box<Truth>),
    Compare(Comparison, Box<Amount>, Box<Amount>),
}

/// A number, NaN where it is missing.
#[derive(Debug, Clone, PartialEq)]
enum Amount {
    Constant(f64),
    Signal(SignalIndex),
    Negate(Box<Amount>),
    Arithmetic(Operator, Box<Amount>, Box<Amount>),
    Abs(Box<Amount>),
    Min(Vec<Amount>),
    Max(Vec<Amount>),
    Norm(Vec<Amount>),
}

impl Truth {
    fn eval(&self, cursor: &Cursor<'_>) -> Option<bool> {
        match self {
            Truth::Constant(value) => Some(*value),
            Truth::Signal(signal) => cursor.value(*signal).map(|value| value != 0.0),
            Truth::Not(inner) => inner.eval(cursor).map(|value| !value),
            Truth::And(left, right) => match left.eval(cursor) {
                Some(false) => Some(false),
                Some(true) => right.eval(cursor),
                None => right.eval(cursor).filter(|&value| !value),
            },
            Truth::Or(left, right) => match left.eval(cursor) {
                Some(true) => Some(true),
                Some(false) => right.eval(cursor),
                None => right.eval(cursor).filter(|&value| value),
            },
            Truth::Same(left, right) => Some(left.eval(cursor)? == right.eval(cursor)?),
            Truth::Compare(comparison, left, right) => {
                let order = left.eval(cursor).partial_cmp(&right.eval(cursor))?;
                Some(match comparison {
                    Comparison::Equal => order.is_eq(),
                    Comparison::NotEqual => order.is_ne(),
                    Comparison::Less => order.is_lt(),
                    Comparison::LessEqual => order.is_le(),
                    Comparison::Greater => order.is_gt(),
                    Comparison::GreaterEqual => order.is_ge(),
                })
            }
        }
    }
}

impl Amount {
    fn eval(&self, cursor: &Cursor<'_>) -> f64 {
        match self {
            Amount::Constant(value) => *value,
            Amount::Signal(signal) => cursor.raw(*signal),
            Amount::Negate(inner) => -inner.eval(cursor),
            Amount::Arithmetic(operator, left, right) => {
                arithmetic(*operator, left.eval(cursor), right.eval(cursor))
            }
            Amount::Abs(inner) => inner.eval(cursor).abs(),
            Amount::Min(list) => fold(list, cursor, f64::INFINITY, f64::min),
            Amount::Max(list) => fold(list, cursor, f64::NEG_INFINITY, f64::max),
            Amount::Norm(list) => fold(list, cursor, 0.0, |sum, value| sum + value * value).sqrt(),
        }
    }
}

fn arithmetic(operator: Operator, left: f64, right: f64) -> f64 {
    match operator {
        Operator::Add => left + right,
        Operator::Subtract => left - right,
        Operator::Multiply => left * right,
        Operator::Divide if right != 0.0 => left / right,
        _ => f64::NAN,
    }
}

/// Combines the values of `list`; NaN if one is missing.
fn fold(list: &[Amount], cursor: &Cursor<'_>, start: f64, combine: fn(f64, f64) -> f64) -> f64 {
    let mut result = start;
    for amount in list {
        let value = amount.eval(cursor);
        if value.is_nan() {
            return f64::NAN;
        }
        result = combine(result, value);
    }
    result
}

/// A part of a tree with its type.
enum Typed<'t> {
    Truth(Truth),
    Amount(Amount),
    /// A signal that holds one of the names.
    Choice(SignalIndex, &'t [String]),
    /// A quoted name.
    Text(String),
}

impl Typed<'_> {
    fn describe(&self) -> String {
        match self {
            Typed::Truth(_) => "a truth value".to_owned(),
            Typed::Amount(_) => "a number".to_owned(),
            Typed::Choice(..) => "a value of an enumeration".to_owned(),
            Typed::Text(text) => format!("the name '{text}'"),
        }
    }
}

pub(crate) fn predicate(source: &Source, trace: &Trace) -> Result<BoundPredicate, PredicateError> {
    let mut binder = Binder {
        source,
        trace,
        nodes: 0,
        depth: 0,
    };
    let context = Context {
        expression: &source.expression,
        entry: None,
    };
    binder
        .truth(&source.expression.root, context)
        .map(BoundPredicate)
}

pub(crate) fn quantity(source: &Source, trace: &Trace) -> Result<BoundQuantity, PredicateError> {
    let mut binder = Binder {
        source,
        trace,
        nodes: 0,
        depth: 0,
    };
    let context = Context {
        expression: &source.expression,
        entry: None,
    };
    binder
        .amount(&source.expression.root, context)
        .map(BoundQuantity)
}

struct Binder<'t> {
    source: &'t Source,
    trace: &'t Trace,
    nodes: usize,
    depth: usize,
}

/// Whose text a node belongs to.
#[derive(Clone, Copy)]
struct Context<'t> {
    expression: &'t Expression,
    entry: Option<&'t str>,
}

impl Context<'_> {
    fn error(self, node: &Node, kind: PredicateErrorKind) -> PredicateError {
        PredicateError {
            text: self.expression.text.clone(),
            entry: self.entry.map(str::to_owned),
            span: node.span.clone(),
            kind,
        }
    }

    fn type_error(self, node: &Node, found: &Typed<'_>, expected: &'static str) -> PredicateError {
        self.error(
            node,
            PredicateErrorKind::Type {
                found: found.describe(),
                expected,
            },
        )
    }
}

impl<'t> Binder<'t> {
    fn truth(&mut self, node: &'t Node, context: Context<'t>) -> Result<Truth, PredicateError> {
        match self.node(node, context)? {
            Typed::Truth(truth) => Ok(truth),
            other => Err(context.type_error(
                node,
                &other,
                "something true or false (for example a comparison)",
            )),
        }
    }

    fn amount(&mut self, node: &'t Node, context: Context<'t>) -> Result<Amount, PredicateError> {
        match self.node(node, context)? {
            Typed::Amount(amount) => Ok(amount),
            other => Err(context.type_error(node, &other, "a number")),
        }
    }

    fn amounts(
        &mut self,
        nodes: &'t [Node],
        context: Context<'t>,
    ) -> Result<Vec<Amount>, PredicateError> {
        nodes
            .iter()
            .map(|node| self.amount(node, context))
            .collect()
    }

    fn node(&mut self, node: &'t Node, context: Context<'t>) -> Result<Typed<'t>, PredicateError> {
        self.nodes += 1;
        self.depth += 1;
        if self.nodes > MAX_NODES || self.depth > MAX_DEPTH {
            return Err(context.error(node, PredicateErrorKind::TooLarge));
        }
        let typed = match &node.kind {
            NodeKind::Number(value) => Typed::Amount(Amount::Constant(*value)),
            NodeKind::Bool(value) => Typed::Truth(Truth::Constant(*value)),
            NodeKind::Text(text) => Typed::Text(text.clone()),
            NodeKind::Signal(name) => self.signal(name, node, context)?,
            NodeKind::Name(name) => self.name(name, node, context)?,
            NodeKind::Not(inner) => Typed::Truth(Truth::Not(Box::new(self.truth(inner, context)?))),
            NodeKind::Negate(inner) => {
                Typed::Amount(Amount::Negate(Box::new(self.amount(inner, context)?)))
            }
            NodeKind::Binary(operator, left, right) => {
                self.binary(*operator, left, right, context)?
            }
            NodeKind::Call(function, arguments) => {
                Typed::Amount(self.call(*function, arguments, context)?)
            }
        };
        self.depth -= 1;
        Ok(typed)
    }

    fn signal(
        &self,
        name: &str,
        node: &Node,
        context: Context<'t>,
    ) -> Result<Typed<'t>, PredicateError> {
        let signal = self.trace.signal(name);
        let field = signal.and_then(|signal| Some((signal, self.trace.field(signal)?)));
        let Some((signal, field)) = field else {
            let known: Vec<String> = self.trace.signal_names().collect();
            let similar = nearest(name, known.iter().map(String::as_str));
            let kind = PredicateErrorKind::UnknownSignal {
                name: name.to_owned(),
                similar,
            };
            return Err(context.error(node, kind));
        };
        Ok(match &field.kind {
            FieldKind::Number => Typed::Amount(Amount::Signal(signal)),
            FieldKind::Bool => Typed::Truth(Truth::Signal(signal)),
            FieldKind::Enumeration(names) => Typed::Choice(signal, names),
        })
    }

    fn name(
        &mut self,
        name: &'t str,
        node: &Node,
        context: Context<'t>,
    ) -> Result<Typed<'t>, PredicateError> {
        let Some(expression) = self.source.definitions.get(name) else {
            let known = self.source.definitions.keys().map(String::as_str);
            let similar = nearest(name, known);
            let kind = PredicateErrorKind::UnknownName {
                name: name.to_owned(),
                similar,
            };
            return Err(context.error(node, kind));
        };
        self.node(
            &expression.root,
            Context {
                expression,
                entry: Some(name),
            },
        )
    }

    fn binary(
        &mut self,
        operator: Operator,
        left: &'t Node,
        right: &'t Node,
        context: Context<'t>,
    ) -> Result<Typed<'t>, PredicateError> {
        if let Operator::Compare(comparison) = operator {
            return self
                .compare(comparison, left, right, context)
                .map(Typed::Truth);
        }
        if matches!(operator, Operator::And | Operator::Or | Operator::Implies) {
            let left = Box::new(self.truth(left, context)?);
            let right = Box::new(self.truth(right, context)?);
            return Ok(Typed::Truth(match operator {
                Operator::And => Truth::And(left, right),
                Operator::Or => Truth::Or(left, right),
                _ => Truth::Or(Box::new(Truth::Not(left)), right),
            }));
        }
        let left = Box::new(self.amount(left, context)?);
        let right = Box::new(self.amount(right, context)?);
        Ok(Typed::Amount(Amount::Arithmetic(operator, left, right)))
    }

    fn compare(
        &mut self,
        comparison: Comparison,
        left_node: &'t Node,
        right_node: &'t Node,
        context: Context<'t>,
    ) -> Result<Truth, PredicateError> {
        let left = self.node(left_node, context)?;
        let right = self.node(right_node, context)?;
        let equality = matches!(comparison, Comparison::Equal | Comparison::NotEqual);
        let (left, right) = match (left, right) {
            (Typed::Amount(left), Typed::Amount(right)) => (left, right),
            (Typed::Truth(left), Typed::Truth(right)) if equality => {
                let same = Truth::Same(Box::new(left), Box::new(right));
                let negated = comparison == Comparison::NotEqual;
                return Ok(if negated {
                    Truth::Not(Box::new(same))
                } else {
                    same
                });
            }
            (Typed::Choice(signal, names), Typed::Text(value)) if equality => (
                Amount::Signal(signal),
                position(names, value, right_node, context)?,
            ),
            (Typed::Text(value), Typed::Choice(signal, names)) if equality => (
                position(names, value, left_node, context)?,
                Amount::Signal(signal),
            ),
            (Typed::Choice(left, names), Typed::Choice(right, others))
                if equality && names == others =>
            {
                (Amount::Signal(left), Amount::Signal(right))
            }
            (left, right) => {
                let (left, right) = (left.describe(), right.describe());
                let kind = PredicateErrorKind::Incomparable { left, right };
                let mut error = context.error(left_node, kind);
                error.span.end = right_node.span.end;
                return Err(error);
            }
        };
        Ok(Truth::Compare(comparison, Box::new(left), Box::new(right)))
    }

    fn call(
        &mut self,
        function: Function,
        arguments: &'t [Node],
        context: Context<'t>,
    ) -> Result<Amount, PredicateError> {
        Ok(match (function, arguments) {
            (Function::Abs, [inner]) => Amount::Abs(Box::new(self.amount(inner, context)?)),
            (Function::Min, list) => Amount::Min(self.amounts(list, context)?),
            (Function::Max, list) => Amount::Max(self.amounts(list, context)?),
            (Function::Distance, [from, to]) => {
                let mut parts = Vec::with_capacity(3);
                for axis in ["x", "y", "z"] {
                    let from = Box::new(self.coordinate(from, axis, context)?);
                    let to = Box::new(self.coordinate(to, axis, context)?);
                    parts.push(Amount::Arithmetic(Operator::Subtract, from, to));
                }
                Amount::Norm(parts)
            }
            (_, list) => Amount::Norm(self.amounts(list, context)?),
        })
    }

    /// The signal `node` with `.axis` behind it, which must be a number.
    fn coordinate(
        &mut self,
        node: &Node,
        axis: &str,
        context: Context<'t>,
    ) -> Result<Amount, PredicateError> {
        let NodeKind::Signal(prefix) = &node.kind else {
            return Err(context.error(node, PredicateErrorKind::TooLarge));
        };
        match self.signal(&format!("{prefix}.{axis}"), node, context)? {
            Typed::Amount(amount) => Ok(amount),
            other => Err(context.type_error(node, &other, "a place with the numbers x, y and z")),
        }
    }
}

/// The index of `value` among `names`, as a number.
fn position(
    names: &[String],
    value: String,
    node: &Node,
    context: Context<'_>,
) -> Result<Amount, PredicateError> {
    match names.iter().position(|name| *name == value) {
        Some(index) => Ok(Amount::Constant(index as f64)),
        None => {
            let kind = PredicateErrorKind::UnknownValue {
                value,
                known: names.to_vec(),
            };
            Err(context.error(node, kind))
        }
    }
}
