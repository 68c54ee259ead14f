//! What a predicate compares with what: the limits in it, for checking them against each other and
//! against declared parameters.
//!
//! # Definition
//! A constant is a part without signals: a written number, a parameter, or what is computed from
//! those alone. A comparison is listed here if one of its sides is a constant and the other is not;
//! it is turned so that the constant stands on the right. Names are followed into the vocabulary,
//! each entry once for each sign under which it is met.
//! Cost: O(size of the texts that are reached, times their depth).

use std::collections::BTreeSet;
use std::fmt;
use std::ops::Range;

use super::bind::{Context, constant, operand};
use super::eval::Amount;
use super::measure::Measure;
use super::parser::{Comparison as Operator, Function, Node, NodeKind, Operator as Binary};
use super::{Predicate, PredicateError, Source};
use crate::signal::Trace;
use crate::units::{Dimension, QuantityValue, Unit};

/// How the two sides of a comparison are related.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ComparisonOperator {
    /// `=`
    Equal,
    /// `!=`
    NotEqual,
    /// `<`
    Less,
    /// `<=`
    LessEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterEqual,
}

/// A quantity that a predicate compares with a constant.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The quantity as it is written, for example `/hand.x - /object.x`.
    pub quantity: String,
    /// The signals that it reads, directly or through the vocabulary.
    pub signals: BTreeSet<String>,
    /// What kind of quantity it is.
    pub measure: Measure,
    /// How the quantity is compared, where it stands on the left.
    pub operator: ComparisonOperator,
    /// The constant that it is compared with.
    pub threshold: Threshold,
    /// Whether the comparison stands under an odd number of negations (the left side of `=>`
    /// counts as one), so that the predicate speaks of its opposite.
    pub negated: bool,
    /// The text in which the comparison stands.
    pub text: String,
    /// The name of the vocabulary's entry whose text it is, if it is one.
    pub entry: Option<String>,
    /// The place of the whole comparison in `text`: byte offsets, half open.
    pub span: Range<usize>,
}

/// The constant of a [`Comparison`].
#[derive(Debug, Clone, PartialEq)]
pub struct Threshold {
    /// The constant as it is written, for example `5 cm` or `near + 1 cm`.
    pub text: String,
    /// Whether it is a written number, a parameter, or computed.
    pub origin: ThresholdOrigin,
    /// Its value in `unit`.
    pub number: f64,
    /// Its unit; `None` if none is written, so that the number is in that of the signals
    /// ([`Predicate::comparisons_in`] knows it).
    pub unit: Option<Unit>,
    /// Its value in the coherent SI unit, if the unit is known.
    pub si_value: Option<f64>,
    /// Its place in the text of the comparison: byte offsets, half open.
    pub span: Range<usize>,
}

/// Where a [`Threshold`] comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ThresholdOrigin {
    /// A number in the text.
    Literal,
    /// The parameter of this name.
    Parameter(String),
    /// Computed from several numbers and parameters, of which these are the parameters.
    Expression(Vec<String>),
}

/// A written number or a use of a parameter in a predicate.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    /// The parameter's name; `None` for a written number.
    pub parameter: Option<String>,
    /// The value with its unit.
    pub value: QuantityValue,
    /// The text in which it stands.
    pub text: String,
    /// The name of the vocabulary's entry whose text it is, if it is one.
    pub entry: Option<String>,
    /// Its place in `text`: byte offsets, half open.
    pub span: Range<usize>,
}

impl Threshold {
    /// The dimension, if the unit is known.
    #[must_use]
    pub fn dimension(&self) -> Option<Dimension> {
        self.unit.as_ref().map(Unit::dimension)
    }
}

impl fmt::Display for ComparisonOperator {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            ComparisonOperator::Equal => "=",
            ComparisonOperator::NotEqual => "!=",
            ComparisonOperator::Less => "<",
            ComparisonOperator::LessEqual => "<=",
            ComparisonOperator::Greater => ">",
            ComparisonOperator::GreaterEqual => ">=",
        })
    }
}

impl Predicate {
    /// The comparisons of a quantity with a constant, in the order of the text, those of an entry
    /// of the vocabulary where it is first referred to.
    ///
    /// ```
    /// use trace::{Measure, Predicate};
    /// let near = Predicate::parse("!(5 cm < abs(/hand.x - /cup.x))")?;
    /// let comparisons = near.comparisons();
    /// let comparison = &comparisons[0];
    /// assert_eq!(comparison.quantity, "abs(/hand.x - /cup.x)");
    /// assert_eq!(comparison.operator.to_string(), ">");
    /// assert_eq!(comparison.threshold.si_value, Some(0.05));
    /// assert!(comparison.negated);
    /// assert!(matches!(&comparison.measure, Measure::AxisDifference { axis, .. } if axis == "x"));
    /// # Ok::<(), trace::PredicateError>(())
    /// ```
    #[must_use]
    pub fn comparisons(&self) -> Vec<Comparison> {
        Walk::through(&self.0, None)
    }

    /// As [`Predicate::comparisons`]; and numbers without a unit have the unit of the signals of
    /// `layout` that they are compared with.
    ///
    /// # Errors
    /// [`PredicateError`] if the predicate cannot be bound to `layout`.
    pub fn comparisons_in(&self, layout: &Trace) -> Result<Vec<Comparison>, PredicateError> {
        self.bind(layout)?;
        Ok(Walk::through(&self.0, Some(layout)))
    }

    /// Every written number and every use of a parameter, in the order of the text, those of an
    /// entry of the vocabulary where it is first referred to.
    #[must_use]
    pub fn constants(&self) -> Vec<Constant> {
        let mut found = Vec::new();
        let mut done = BTreeSet::new();
        let root = (&self.0.expression.root, self.0.context());
        let mut waiting = vec![root];
        while let Some((node, context)) = waiting.pop() {
            match &node.kind {
                NodeKind::Number(value) => found.push(written(None, value, node, context)),
                NodeKind::Name(name) => {
                    if let Some(value) = self.0.parameters.get(name) {
                        found.push(written(Some(name), value, node, context));
                    } else if done.insert(name.as_str())
                        && let Some(entry) = self.0.entry(name)
                    {
                        waiting.push((&entry.expression.root, entry));
                    }
                }
                _ => {}
            }
            let children = node.children().into_iter().rev();
            waiting.extend(children.map(|child| (child, context)));
        }
        found
    }
}

fn written(
    parameter: Option<&str>,
    value: &QuantityValue,
    node: &Node,
    context: Context<'_>,
) -> Constant {
    Constant {
        parameter: parameter.map(str::to_owned),
        value: value.clone(),
        text: context.expression.text.clone(),
        entry: context.entry.map(str::to_owned),
        span: node.span.clone(),
    }
}

/// A truth value that is still to be visited, and whether it is negated there.
type Visit<'t> = (&'t Node, Context<'t>, bool);

/// A walk through a text and the entries that it refers to.
struct Walk<'t> {
    source: &'t Source,
    layout: Option<&'t Trace>,
    /// What is still to be visited, the next last.
    waiting: Vec<Visit<'t>>,
    found: Vec<Comparison>,
}

impl<'t> Walk<'t> {
    /// The comparisons of `source`, with the units of `layout` if it is given.
    fn through(source: &'t Source, layout: Option<&'t Trace>) -> Vec<Comparison> {
        let mut walk = Walk {
            source,
            layout,
            waiting: vec![(&source.expression.root, source.context(), false)],
            found: Vec::new(),
        };
        let mut done = BTreeSet::new();
        while let Some((node, context, negated)) = walk.waiting.pop() {
            match &node.kind {
                NodeKind::Name(name) => {
                    if done.insert((name, negated))
                        && let Some(entry) = source.entry(name)
                    {
                        walk.waiting.push((&entry.expression.root, entry, negated));
                    }
                }
                NodeKind::Not(inner) => walk.waiting.push((inner, context, !negated)),
                NodeKind::Binary(Binary::Compare(operator), left, right) => {
                    walk.compare(node, *operator, [left, right], context, negated);
                }
                NodeKind::Binary(operator, left, right) => {
                    let turned = negated != (*operator == Binary::Implies);
                    walk.waiting.push((right, context, negated));
                    walk.waiting.push((left, context, turned));
                }
                _ => {}
            }
        }
        walk.found
    }

    fn compare(
        &mut self,
        node: &'t Node,
        operator: Operator,
        [left, right]: [&'t Node; 2],
        context: Context<'t>,
        negated: bool,
    ) {
        let (quantity, threshold, operator) = match (
            self.source.is_constant(left),
            self.source.is_constant(right),
        ) {
            (false, true) => (left, right, operator),
            (true, false) => (right, left, turned(operator)),
            _ => {
                // An equality of truth values may have comparisons below.
                self.waiting.push((right, context, negated));
                self.waiting.push((left, context, negated));
                return;
            }
        };
        let Some(threshold) = self.threshold(threshold, quantity, context) else {
            return;
        };
        self.found.push(Comparison {
            quantity: context.text_of(quantity),
            signals: self.source.signals_below(quantity),
            measure: self.source.measure(quantity),
            operator: operator.into(),
            threshold,
            negated,
            text: context.expression.text.clone(),
            entry: context.entry.map(str::to_owned),
            span: node.span.clone(),
        });
    }

    /// The constant `node`, which is compared with `quantity`; `None` if it has no value.
    fn threshold(
        &self,
        node: &'t Node,
        quantity: &'t Node,
        context: Context<'t>,
    ) -> Option<Threshold> {
        let found = constant(self.source, node, context).ok()?;
        let Amount::Constant(number) = found.amount else {
            return None;
        };
        let mut unit = found.scale.unit().cloned();
        if let (None, Some(layout)) = (&unit, self.layout) {
            let quantity = operand(self.source, layout, quantity, context).ok()?;
            unit = quantity.scale.unit().cloned();
        }
        let si_value = unit.as_ref().map(|unit| found.in_si(unit));
        Some(Threshold {
            text: context.text_of(node),
            origin: self.source.origin(node),
            number,
            unit,
            si_value,
            span: node.span.clone(),
        })
    }
}

impl From<Operator> for ComparisonOperator {
    fn from(operator: Operator) -> Self {
        match operator {
            Operator::Equal => ComparisonOperator::Equal,
            Operator::NotEqual => ComparisonOperator::NotEqual,
            Operator::Less => ComparisonOperator::Less,
            Operator::LessEqual => ComparisonOperator::LessEqual,
            Operator::Greater => ComparisonOperator::Greater,
            Operator::GreaterEqual => ComparisonOperator::GreaterEqual,
        }
    }
}

/// The operator with its sides exchanged.
fn turned(operator: Operator) -> Operator {
    match operator {
        Operator::Less => Operator::Greater,
        Operator::LessEqual => Operator::GreaterEqual,
        Operator::Greater => Operator::Less,
        Operator::GreaterEqual => Operator::LessEqual,
        same => same,
    }
}

impl Context<'_> {
    fn text_of(self, node: &Node) -> String {
        let text = self.expression.text.get(node.span.clone());
        text.unwrap_or_default().to_owned()
    }
}

impl Source {
    /// The definition of `name`, if it is an entry of the vocabulary.
    fn entry<'t>(&'t self, name: &'t str) -> Option<Context<'t>> {
        let expression = self.definitions.get(name)?;
        Some(Context {
            expression,
            entry: Some(name),
        })
    }

    /// `node`, or what it stands for if it is a name.
    pub(super) fn resolved<'t>(&'t self, mut node: &'t Node) -> &'t Node {
        while let NodeKind::Name(name) = &node.kind
            && let Some(entry) = self.definitions.get(name)
        {
            node = &entry.root;
        }
        node
    }

    /// All nodes at and below `node`, those of each entry once.
    fn all_below<'t>(&'t self, node: &'t Node) -> Vec<&'t Node> {
        let mut found = Vec::new();
        let mut done = BTreeSet::new();
        let mut waiting = vec![node];
        while let Some(node) = waiting.pop() {
            if let NodeKind::Name(name) = &node.kind
                && done.insert(name)
                && let Some(entry) = self.definitions.get(name)
            {
                waiting.push(&entry.root);
            }
            waiting.extend(node.children());
            found.push(node);
        }
        found
    }

    fn signals_below(&self, node: &Node) -> BTreeSet<String> {
        let nodes = self.all_below(node).into_iter();
        nodes.flat_map(Node::own_signals).collect()
    }

    /// Whether `node` is a number that depends on no signal.
    fn is_constant(&self, node: &Node) -> bool {
        self.all_below(node)
            .into_iter()
            .all(|node| match &node.kind {
                NodeKind::Number(_) | NodeKind::Negate(_) | NodeKind::Name(_) => true,
                NodeKind::Call(function, _) => *function != Function::Distance,
                NodeKind::Binary(operator, ..) => matches!(
                    operator,
                    Binary::Add | Binary::Subtract | Binary::Multiply | Binary::Divide
                ),
                _ => false,
            })
    }

    fn origin(&self, node: &Node) -> ThresholdOrigin {
        let node = self.resolved(node);
        match &node.kind {
            NodeKind::Number(_) => ThresholdOrigin::Literal,
            NodeKind::Negate(inner) if matches!(inner.kind, NodeKind::Number(_)) => {
                ThresholdOrigin::Literal
            }
            NodeKind::Name(name) => ThresholdOrigin::Parameter(name.clone()),
            _ => {
                let nodes = self.all_below(node).into_iter();
                let names = nodes.filter_map(|node| match &node.kind {
                    NodeKind::Name(name) => self.parameters.get(name).map(|_| name.clone()),
                    _ => None,
                });
                let names: BTreeSet<String> = names.collect();
                ThresholdOrigin::Expression(names.into_iter().collect())
            }
        }
    }
}
