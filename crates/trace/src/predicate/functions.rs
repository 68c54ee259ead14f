//! Calls of functions, bound.

use super::bind::{Binder, Context, Typed, arithmetic, two};
use super::error::{PredicateError, PredicateErrorKind};
use super::eval::Amount;
use super::parser::{Function, Node, NodeKind, Operator};
use super::scale::{Operand, Scale, Unified};
use crate::units::{Dimension, Factor};

impl<'t> Binder<'t> {
    pub(super) fn call(
        &mut self,
        node: &'t Node,
        function: Function,
        arguments: &'t [Node],
        context: Context<'t>,
    ) -> Result<Operand, PredicateError> {
        if let (Function::Distance, [from, to]) = (function, arguments) {
            return self.distance(from, to, context);
        }
        let unified = self.amounts(arguments, context)?;
        let Unified {
            amounts,
            scale,
            frame,
            constant,
            ..
        } = unified;
        let (amount, frame) = match function {
            Function::Min => (Amount::Min(amounts), frame),
            Function::Max => (Amount::Max(amounts), frame),
            Function::Norm | Function::Distance => (Amount::Norm(amounts), None),
            Function::Abs => {
                let inner = amounts
                    .into_iter()
                    .next()
                    .unwrap_or(Amount::Constant(f64::NAN));
                (Amount::Abs(Box::new(inner)), frame)
            }
            Function::AngleDifference | Function::AngleBetween => {
                let Some(turn) = turn(&scale) else {
                    let found = scale.describe();
                    return Err(context.error(node, PredicateErrorKind::NoAngle { found }));
                };
                let (left, right) = two(amounts);
                let difference = Amount::AngleDifference {
                    left: Box::new(left),
                    right: Box::new(right),
                    turn,
                };
                match function {
                    Function::AngleBetween => (Amount::Abs(Box::new(difference)), None),
                    _ => (difference, None),
                }
            }
        };
        Ok(Operand::computed(amount, scale, frame, constant))
    }

    fn distance(
        &mut self,
        from: &'t Node,
        to: &'t Node,
        context: Context<'t>,
    ) -> Result<Operand, PredicateError> {
        let mut parts = Vec::with_capacity(3);
        for axis in ["x", "y", "z"] {
            let ends = vec![
                self.coordinate(from, axis, context)?,
                self.coordinate(to, axis, context)?,
            ];
            let unified = self.unified(ends, &[from, to], context)?;
            parts.push(arithmetic(Operator::Subtract, unified));
        }
        let unified = self.unified(parts, &[from, from, to], context)?;
        let norm = Amount::Norm(unified.amounts);
        Ok(Operand::computed(norm, unified.scale, None, false))
    }

    /// The signal `node` with `.axis` behind it, which must be a number.
    fn coordinate(
        &mut self,
        node: &Node,
        axis: &str,
        context: Context<'t>,
    ) -> Result<Operand, PredicateError> {
        let NodeKind::Signal(prefix) = &node.kind else {
            return Err(context.error(node, PredicateErrorKind::TooLarge));
        };
        match self.signal(&format!("{prefix}.{axis}"), node, context)? {
            Typed::Amount(amount) => Ok(*amount),
            other => Err(context.type_error(node, &other, "a place with the numbers x, y and z")),
        }
    }
}

/// A whole turn in the unit of an angle; `None` for anything else.
fn turn(scale: &Scale) -> Option<f64> {
    let unit = scale.unit()?;
    let turn = Factor::new(2, 1, 1)?.divided_by(unit.factor())?;
    (unit.dimension() == Dimension::ANGLE).then(|| turn.conversion().apply(1.0))
}
