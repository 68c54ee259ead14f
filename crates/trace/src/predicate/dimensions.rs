//! What is wrong with a predicate whatever recording it is judged on.
//!
//! # Definition
//! Units of signals are known once there is a recording; those of written numbers and of parameters are known now. An amount
//! has a known unit if it is a number with one, a parameter, a product or quotient of amounts with known units, or a sum with
//! one of these. Amounts with known units that are added or compared must have one dimension. The whole must be something
//! true or false.
//!
//! # Cost
//! One visit for each node, and at most [`MAX_NODES`] of those that the names stand for.

use super::Source;
use super::bind::Context;
use super::error::{PredicateError, PredicateErrorKind};
use super::parser::{MAX_DEPTH, Node, NodeKind, Operator};
use super::scale::Scale;
use crate::units::Unit;

/// How many nodes are visited; what is larger is looked at with its recording.
const MAX_NODES: usize = 100_000;

/// The first mistake that no recording can mend.
pub(super) fn check(source: &Source) -> Result<(), PredicateError> {
    let mut walk = Walk { source, nodes: 0 };
    let (root, context) = (&source.expression.root, source.context());
    walk.unit(root, context, 0)?;
    match is_number(root) {
        false => Ok(()),
        true => {
            let kind = PredicateErrorKind::Type {
                found: "a number".to_owned(),
                expected: "something true or false (for example a comparison)",
            };
            Err(context.error(root, kind))
        }
    }
}

fn is_number(node: &Node) -> bool {
    match &node.kind {
        NodeKind::Number(_) | NodeKind::Negate(_) | NodeKind::Call(..) => true,
        NodeKind::Binary(operator, ..) => is_arithmetic(*operator),
        NodeKind::Bool(_)
        | NodeKind::Text(_)
        | NodeKind::Signal(_)
        | NodeKind::Name(_)
        | NodeKind::Not(_) => false,
    }
}

fn is_arithmetic(operator: Operator) -> bool {
    match operator {
        Operator::Add | Operator::Subtract | Operator::Multiply | Operator::Divide => true,
        Operator::And | Operator::Or | Operator::Implies | Operator::Compare(_) => false,
    }
}

struct Walk<'s> {
    source: &'s Source,
    nodes: usize,
}

impl<'s> Walk<'s> {
    /// The unit of an amount as far as it is known without a recording.
    fn unit(
        &mut self,
        node: &'s Node,
        context: Context<'s>,
        depth: usize,
    ) -> Result<Option<Unit>, PredicateError> {
        self.nodes += 1;
        if self.nodes > MAX_NODES || depth > MAX_DEPTH {
            return Ok(None);
        }
        let depth = depth + 1;
        match &node.kind {
            NodeKind::Number(value) => Ok(value.unit().cloned()),
            NodeKind::Bool(_) | NodeKind::Text(_) | NodeKind::Signal(_) => Ok(None),
            NodeKind::Name(name) => self.named(name, depth),
            NodeKind::Not(inner) => self.unit(inner, context, depth).map(|_| None),
            NodeKind::Negate(inner) => self.unit(inner, context, depth),
            NodeKind::Call(_, arguments) => {
                for argument in arguments {
                    self.unit(argument, context, depth)?;
                }
                Ok(None)
            }
            NodeKind::Binary(operator, left_node, right_node) => {
                let left = self.unit(left_node, context, depth)?;
                let right = self.unit(right_node, context, depth)?;
                match operator {
                    Operator::And | Operator::Or | Operator::Implies => Ok(None),
                    Operator::Multiply => Ok(left.zip(right).and_then(|(l, r)| l.times(&r))),
                    Operator::Divide => Ok(left.zip(right).and_then(|(l, r)| l.divided_by(&r))),
                    Operator::Add | Operator::Subtract | Operator::Compare(_) => {
                        if let (Some(left), Some(right)) = (&left, &right)
                            && left.dimension() != right.dimension()
                        {
                            let mut error = context.error(left_node, misfit(left, right));
                            error.span.end = right_node.span.end;
                            return Err(error);
                        }
                        Ok(left.or(right).filter(|_| is_arithmetic(*operator)))
                    }
                }
            }
        }
    }

    fn named(&mut self, name: &'s str, depth: usize) -> Result<Option<Unit>, PredicateError> {
        if let Some(parameter) = self.source.parameters.get(name) {
            return Ok(parameter.unit().cloned());
        }
        let Some(expression) = self.source.definitions.get(name) else {
            return Ok(None);
        };
        let entry = Some(name);
        self.unit(&expression.root, Context { expression, entry }, depth)
    }
}

fn misfit(left: &Unit, right: &Unit) -> PredicateErrorKind {
    PredicateErrorKind::Dimensions {
        left: Scale::Unit(left.clone()).describe(),
        right: Scale::Unit(right.clone()).describe(),
    }
}

#[cfg(test)]
mod tests {
    use crate::{Parameters, Predicate, Vocabulary};

    fn said(text: &str) -> Option<String> {
        let predicate = Predicate::parse(text).expect("a predicate");
        predicate.check().err().map(|error| error.kind.to_string())
    }

    #[test]
    fn written_units_that_do_not_go_together_are_told_without_a_recording() {
        for text in [
            "3 N + 2 m/s > 0",
            "/a.x + 3 N > 2 m/s",
            "/a.x > 2 m & 1 s < 2 m",
            "!(3 N = 2 kg)",
            "abs(3 N - 2 m) > /a.x",
        ] {
            assert!(
                said(text).is_some_and(|it| it.contains("go together")),
                "{text}"
            );
        }
        for text in ["3 N + 2 N", "-(/a.x)", "abs(/a.x)", "3"] {
            assert!(
                said(text).is_some_and(|it| it.contains("true or false")),
                "{text}"
            );
        }
    }

    #[test]
    fn what_some_recording_can_satisfy_is_left_to_it() {
        for text in [
            "/a.x + 3 N > 2",
            "/a.x * 2 s > 3 m",
            "3 N * 2 m > 1 J",
            "/a.on",
            "/a.mode = 'fast'",
            "10 cm < 1 m",
        ] {
            assert_eq!(said(text), None, "{text}");
        }
    }

    #[test]
    fn names_stand_for_what_they_mean() {
        let parameters = Parameters::new([("near", "10 cm")]).expect("parameters");
        let entries = [("close", "/d.x < near"), ("odd", "near > 2 s")];
        let vocabulary = Vocabulary::with_parameters(entries, parameters).expect("a vocabulary");
        let check = |text: &str| vocabulary.predicate(text).expect("a predicate").check();
        assert!(check("close").is_ok());
        let error = check("odd").expect_err("a length and a time");
        assert_eq!((error.entry.as_deref(), error.span), (Some("odd"), 0..10));
    }
}
