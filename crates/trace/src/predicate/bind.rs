//! Trees to something fast: signals looked up, types, units and frames checked, names expanded.

use super::error::{PredicateError, PredicateErrorKind};
use super::eval::{Amount, Compared, Truth};
use super::lint::PredicateLint;
use super::parser::{Comparison, MAX_DEPTH, Node, NodeKind, Operator};
use super::scale::{Framed, Misfit, Operand, Scale, Unified, to_si, unify};
use super::{Expression, Source};
use crate::channel::FieldKind;
use crate::signal::{SignalIndex, Trace};
use crate::suggest::nearest;
use crate::units::{Dimension, Unit, UnitErrorKind};

/// The largest number of nodes of an expanded tree.
const MAX_NODES: usize = 100_000;

/// A part of a tree with its type.
pub(super) enum Typed<'t> {
    Truth(Truth),
    Amount(Box<Operand>),
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

/// The truth that `source` means over `trace`, and what was found on the way.
pub(super) fn truth(source: &Source, trace: &Trace) -> Result<(Truth, Findings), PredicateError> {
    let mut binder = Binder::new(source, trace);
    let truth = binder.truth(&source.expression.root, source.context())?;
    Ok((truth, binder.findings))
}

/// The amount that `source` means over `trace`, and what was found on the way.
pub(super) fn amount(
    source: &Source,
    trace: &Trace,
) -> Result<(Operand, Findings), PredicateError> {
    let mut binder = Binder::new(source, trace);
    let operand = binder.amount(&source.expression.root, source.context())?;
    Ok((operand, binder.findings))
}

/// The amount of `node`, which reads no signal.
pub(super) fn constant<'t>(
    source: &'t Source,
    node: &'t Node,
    context: Context<'t>,
) -> Result<Operand, PredicateError> {
    Binder::new(source, &Trace::new()).amount(node, context)
}

/// The amount of `node` over `trace`.
pub(super) fn operand<'t>(
    source: &'t Source,
    trace: &'t Trace,
    node: &'t Node,
    context: Context<'t>,
) -> Result<Operand, PredicateError> {
    Binder::new(source, trace).amount(node, context)
}

/// What is found on the way through a tree.
pub(super) struct Findings {
    /// What should be looked at.
    pub(super) lints: Vec<PredicateLint>,
    /// What the comparisons of numbers compare.
    pub(super) dimensions: Dimensions,
}

/// The dimensions of the comparisons met so far.
pub(super) enum Dimensions {
    /// There was no comparison.
    None,
    /// All have this one.
    One(Dimension),
    /// There are several, or one that is not known.
    Several,
}

pub(super) struct Binder<'t> {
    source: &'t Source,
    trace: &'t Trace,
    nodes: usize,
    depth: usize,
    findings: Findings,
}

impl Source {
    pub(super) fn context(&self) -> Context<'_> {
        Context {
            expression: &self.expression,
            entry: None,
        }
    }
}

/// Whose text a node belongs to.
#[derive(Clone, Copy)]
pub(super) struct Context<'t> {
    pub(super) expression: &'t Expression,
    pub(super) entry: Option<&'t str>,
}

impl Context<'_> {
    pub(super) fn error(self, node: &Node, kind: PredicateErrorKind) -> PredicateError {
        PredicateError {
            text: self.expression.text.clone(),
            entry: self.entry.map(str::to_owned),
            span: node.span.clone(),
            kind,
        }
    }

    pub(super) fn type_error(
        self,
        node: &Node,
        found: &Typed<'_>,
        expected: &'static str,
    ) -> PredicateError {
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
    fn new(source: &'t Source, trace: &'t Trace) -> Self {
        Binder {
            source,
            trace,
            nodes: 0,
            depth: 0,
            findings: Findings {
                lints: Vec::new(),
                dimensions: Dimensions::None,
            },
        }
    }

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

    pub(super) fn amount(
        &mut self,
        node: &'t Node,
        context: Context<'t>,
    ) -> Result<Operand, PredicateError> {
        match self.node(node, context)? {
            Typed::Amount(amount) => Ok(*amount),
            other => Err(context.type_error(node, &other, "a number")),
        }
    }

    /// Brings `operands`, of the nodes `nodes`, to one unit.
    pub(super) fn unified(
        &mut self,
        operands: Vec<Operand>,
        nodes: &[&Node],
        context: Context<'t>,
    ) -> Result<Unified, PredicateError> {
        let span = |first: usize, last: usize| {
            // There is a node for each operand.
            let start = nodes.get(first).map_or(0, |node| node.span.start);
            let end = nodes.get(last).map_or(start, |node| node.span.end);
            start..end.max(start)
        };
        let mut unified =
            unify(operands).map_err(|(kind, first, last): Misfit| PredicateError {
                text: context.expression.text.clone(),
                entry: context.entry.map(str::to_owned),
                span: span(first, last),
                kind,
            })?;
        for (position, kind) in unified.lints.drain(..) {
            let lint = PredicateLint {
                text: context.expression.text.clone(),
                entry: context.entry.map(str::to_owned),
                span: span(position, position),
                kind,
            };
            // An entry that is referred to twice is expanded twice.
            if !self.findings.lints.contains(&lint) {
                self.findings.lints.push(lint);
            }
        }
        Ok(unified)
    }

    /// The amounts of `nodes` in one unit.
    pub(super) fn amounts(
        &mut self,
        nodes: &'t [Node],
        context: Context<'t>,
    ) -> Result<Unified, PredicateError> {
        let operands: Result<Vec<Operand>, PredicateError> = nodes
            .iter()
            .map(|node| self.amount(node, context))
            .collect();
        let nodes: Vec<&Node> = nodes.iter().collect();
        self.unified(operands?, &nodes, context)
    }

    fn node(&mut self, node: &'t Node, context: Context<'t>) -> Result<Typed<'t>, PredicateError> {
        self.nodes += 1;
        self.depth += 1;
        if self.nodes > MAX_NODES || self.depth > MAX_DEPTH {
            return Err(context.error(node, PredicateErrorKind::TooLarge));
        }
        let typed = match &node.kind {
            NodeKind::Number(value) => Typed::Amount(Box::new(Operand::constant(value))),
            NodeKind::Bool(value) => Typed::Truth(Truth::Constant(*value)),
            NodeKind::Text(text) => Typed::Text(text.clone()),
            NodeKind::Signal(name) => self.signal(name, node, context)?,
            NodeKind::Name(name) => self.name(name, node, context)?,
            NodeKind::Not(inner) => Typed::Truth(Truth::Not(Box::new(self.truth(inner, context)?))),
            NodeKind::Negate(inner) => {
                Typed::Amount(Box::new(self.amount(inner, context)?.negated()))
            }
            NodeKind::Binary(operator, left, right) => {
                self.binary(node, *operator, left, right, context)?
            }
            NodeKind::Call(function, arguments) => {
                Typed::Amount(Box::new(self.call(node, *function, arguments, context)?))
            }
        };
        self.depth -= 1;
        Ok(typed)
    }

    pub(super) fn signal(
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
            FieldKind::Number => Typed::Amount(Box::new(Operand {
                amount: Amount::Signal(signal),
                scale: Scale::of_field(field, name),
                frame: field.frame.clone().map(|frame| Framed {
                    frame,
                    signal: name.to_owned(),
                }),
                constant: false,
                written: None,
            })),
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
        if let Some(parameter) = self.source.parameters.get(name) {
            return Ok(Typed::Amount(Box::new(Operand::constant(parameter))));
        }
        let Some(expression) = self.source.definitions.get(name) else {
            let known = self.source.definitions.keys().map(String::as_str);
            let similar = nearest(name, known.chain(self.source.parameters.names()));
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
        node: &'t Node,
        operator: Operator,
        left: &'t Node,
        right: &'t Node,
        context: Context<'t>,
    ) -> Result<Typed<'t>, PredicateError> {
        match operator {
            Operator::Compare(comparison) => {
                let truth = self.compare(comparison, left, right, context)?;
                Ok(Typed::Truth(truth))
            }
            Operator::And | Operator::Or | Operator::Implies => {
                let left = Box::new(self.truth(left, context)?);
                let right = Box::new(self.truth(right, context)?);
                Ok(Typed::Truth(match operator {
                    Operator::And => Truth::And(left, right),
                    Operator::Or => Truth::Or(left, right),
                    _ => Truth::Or(Box::new(Truth::Not(left)), right),
                }))
            }
            Operator::Add | Operator::Subtract => {
                let operands = vec![self.amount(left, context)?, self.amount(right, context)?];
                let unified = self.unified(operands, &[left, right], context)?;
                Ok(Typed::Amount(Box::new(arithmetic(operator, unified))))
            }
            Operator::Multiply | Operator::Divide => {
                let (left, right) = (self.amount(left, context)?, self.amount(right, context)?);
                let product = product(operator, left, right);
                let too_large = PredicateErrorKind::Unit(UnitErrorKind::TooLarge);
                let product = product.ok_or_else(|| context.error(node, too_large))?;
                Ok(Typed::Amount(Box::new(product)))
            }
        }
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
        let same = match (left, right) {
            (Typed::Amount(left), Typed::Amount(right)) => {
                let unified =
                    self.unified(vec![*left, *right], &[left_node, right_node], context)?;
                return Ok(self.compared(comparison, unified));
            }
            (Typed::Truth(left), Typed::Truth(right)) if equality => {
                Truth::Same(Box::new(left), Box::new(right))
            }
            (Typed::Choice(signal, names), Typed::Text(value)) if equality => Truth::SameName(
                Amount::Signal(signal),
                position(names, value, right_node, context)?,
            ),
            (Typed::Text(value), Typed::Choice(signal, names)) if equality => Truth::SameName(
                position(names, value, left_node, context)?,
                Amount::Signal(signal),
            ),
            (Typed::Choice(left, names), Typed::Choice(right, others))
                if equality && names == others =>
            {
                Truth::SameName(Amount::Signal(left), Amount::Signal(right))
            }
            (left, right) => {
                let (left, right) = (left.describe(), right.describe());
                let kind = PredicateErrorKind::Incomparable { left, right };
                let mut error = context.error(left_node, kind);
                error.span.end = right_node.span.end;
                return Err(error);
            }
        };
        Ok(match comparison {
            Comparison::NotEqual => Truth::Not(Box::new(same)),
            _ => same,
        })
    }

    /// A comparison of two amounts, whose dimension is noted.
    fn compared(&mut self, comparison: Comparison, unified: Unified) -> Truth {
        let dimension = unified.scale.unit().map(Unit::dimension);
        self.findings.dimensions = match (&self.findings.dimensions, dimension) {
            (Dimensions::None, Some(found)) => Dimensions::One(found),
            (Dimensions::One(one), Some(found)) if *one == found => Dimensions::One(found),
            _ => Dimensions::Several,
        };
        let to_si = to_si(&unified.scale);
        let (left, right) = two(unified.amounts);
        Truth::Compare(Box::new(Compared {
            comparison,
            left,
            right,
            to_si,
        }))
    }
}

/// The first two of `amounts`; there are two wherever this is used.
pub(super) fn two(amounts: Vec<Amount>) -> (Amount, Amount) {
    let mut amounts = amounts.into_iter();
    let mut next = || amounts.next().unwrap_or(Amount::Constant(f64::NAN));
    (next(), next())
}

/// The sum or difference of two amounts in one unit.
pub(super) fn arithmetic(operator: Operator, unified: Unified) -> Operand {
    let (left, right) = two(unified.amounts);
    let amount = Amount::Arithmetic(operator, Box::new(left), Box::new(right));
    Operand::computed(amount, unified.scale, unified.frame, unified.constant)
}

/// The product or quotient of two amounts; `None` if its unit is out of range. A component times
/// a constant is still a component.
fn product(operator: Operator, left: Operand, right: Operand) -> Option<Operand> {
    let scale = left
        .scale
        .product(&right.scale, operator == Operator::Divide)?;
    let frame = match operator {
        Operator::Multiply if left.constant => right.frame,
        _ if right.constant => left.frame,
        _ => None,
    };
    let constant = left.constant && right.constant;
    let amount = Amount::Arithmetic(operator, Box::new(left.amount), Box::new(right.amount));
    Some(Operand::computed(amount, scale, frame, constant))
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
