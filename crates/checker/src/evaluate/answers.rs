//! Values as answers.

use prism_lang::property::{FilterOperator, Property, Quantity};

use super::Evaluator;
use crate::amount::Amount;
use crate::answer::{Answer, AnswerValue, CheckError, Guarantee, InitialValue};
use crate::engine::Numbers;
use crate::method::Method;
use crate::property::{guarantee_of_truths, joint_guarantee, range};
use crate::rounding::Bounds;
use crate::stop::Stop;

impl<E: Numbers> Evaluator<'_, E> {
    /// Probabilities in the initial states.
    pub(super) fn of_probabilities(mut self, values: &[E::Value]) -> Answer {
        let complement = match values {
            [value] => E::complement(value),
            _ => None,
        };
        let amounts: Vec<E::Amount> = values.iter().map(E::amount).collect();
        let guarantee = |value: &E::Value| E::guarantee(value, &self.context, self.iterations);
        let guarantees: Vec<Guarantee> = values.iter().map(guarantee).collect();
        let mut answer = self.of_amounts(&amounts, &guarantees);
        answer.complement = complement.map(|bounds| bounds.middle());
        answer.complement_bounds = complement
            .filter(|b| !b.is_exact())
            .map(|b| (b.low, b.high));
        answer
    }

    /// A quantity in the initial states.
    pub(super) fn of_quantity(
        mut self,
        quantity: &Quantity,
        initial: &[usize],
    ) -> Result<Answer, CheckError> {
        if let Quantity::Probability { optimum, path } = quantity {
            let maximise = *optimum != Some(prism_lang::ast::Optimum::Min);
            let values = self.probability(path, maximise, initial)?;
            return Ok(self.of_probabilities(&values));
        }
        // What is the same everywhere has one value.
        let asked = if is_constant(quantity) {
            &initial[..1]
        } else {
            initial
        };
        let values = self.numbers(quantity, asked)?;
        let is_cut = self.context.options.stop.is_some_and(Stop::is_cut);
        for bounds in values.iter().map(Amount::bounds) {
            let is_finite = bounds.low.is_finite() && bounds.high.is_finite();
            let is_open = !is_finite && !bounds.is_exact() && !bounds.is_undefined();
            if is_cut && is_open {
                let hull = |a: Bounds, b: Bounds| Bounds {
                    low: a.low.min(b.low),
                    high: a.high.max(b.high),
                };
                let reached = values.iter().map(Amount::bounds).reduce(hull);
                return Err(CheckError::Stopped { reached });
            }
            // Something in the middle of these would be no answer.
            if is_open {
                return Err(CheckError::Unsupported(format!(
                    "this value could be bounded by {:e} and {:e} only: use the exact method",
                    bounds.low, bounds.high
                )));
            }
        }
        let guarantee = |value: &E::Amount| E::guarantee_of(value, &self.context, self.iterations);
        let guarantees: Vec<Guarantee> = values.iter().map(guarantee).collect();
        Ok(self.of_amounts(&values, &guarantees))
    }

    pub(super) fn of_amounts(&mut self, values: &[E::Amount], guarantees: &[Guarantee]) -> Answer {
        let states = self.space.initial_states().iter();
        let pairs = values.iter().zip(guarantees);
        let initial: Vec<InitialValue> = (states.zip(pairs))
            .map(|(state, (value, guarantee))| InitialValue {
                state: *state,
                value: value.answer(),
                guarantee: guarantee.clone(),
            })
            .collect();
        let value = range(&initial);
        let mut answer = self.base(value, joint_guarantee(&initial), initial);
        let width = values
            .iter()
            .map(|v| width(&v.bounds()))
            .fold(0.0, f64::max);
        let method = self.method();
        if !method.is_estimate() && width > self.context.options.precision {
            answer.notes.push(format!(
                "the bounds hold, but their relative distance is {width:e}, more than the {:e} asked for",
                self.context.options.precision
            ));
        }
        if method.is_direct() && matches!(answer.guarantee, Guarantee::Bounded { .. }) {
            answer.notes.push(format!(
                "by {}: chains are solved by elimination without subtraction; the bounds allow for its rounding",
                method.term()
            ));
        }
        answer
    }

    /// By which method the answer is computed.
    fn method(&self) -> Method {
        E::method(self.context.options.method)
    }

    pub(super) fn of_range(mut self, low: &E::Amount, high: &E::Amount) -> Answer {
        let guarantees =
            [low, high].map(|value| E::guarantee_of(value, &self.context, self.iterations));
        let end = |value: &E::Amount, guarantee: &Guarantee| InitialValue {
            state: 0,
            value: value.answer(),
            guarantee: guarantee.clone(),
        };
        let ends = [end(low, &guarantees[0]), end(high, &guarantees[1])];
        self.base(range(&ends), joint_guarantee(&ends), Vec::new())
    }

    pub(super) fn of_truths(mut self, holds: &[bool], property: &Property) -> Answer {
        let guarantee = guarantee_of_truths(property, self.method(), &self.context);
        let initial = (self.space.initial_states().iter().zip(holds))
            .map(|(state, holds)| InitialValue {
                state: *state,
                value: AnswerValue::Truth(*holds),
                guarantee: guarantee.clone(),
            })
            .collect();
        let truth = AnswerValue::Truth(holds.iter().all(|holds| *holds));
        self.base(truth, guarantee, initial)
    }

    pub(super) fn base(
        &mut self,
        value: AnswerValue,
        guarantee: Guarantee,
        initial: Vec<InitialValue>,
    ) -> Answer {
        Answer {
            value,
            guarantee,
            method: self.method(),
            complement: None,
            complement_bounds: None,
            iterations: self.iterations,
            product_states: self.product_states,
            initial,
            notes: Vec::new(),
            scheduler: self.found_scheduler(),
            printed: std::mem::take(&mut self.printed),
        }
    }
}

/// Relative distance of the bounds, whatever their sign.
fn width(bounds: &Bounds) -> f64 {
    if bounds.is_exact() || bounds.low.is_nan() {
        return 0.0;
    }
    (bounds.high - bounds.low) / bounds.low.abs().max(bounds.high.abs())
}

/// Whether a quantity has the same value in all states.
fn is_constant(quantity: &Quantity) -> bool {
    match quantity {
        Quantity::Expr(expr) => expr.is_constant(),
        Quantity::Minus(operand) => is_constant(operand),
        Quantity::Binary(_, a, b) => is_constant(a) && is_constant(b),
        Quantity::Call(_, arguments) => arguments.iter().all(is_constant),
        Quantity::Filter(filter) => !matches!(
            filter.operator,
            FilterOperator::Print | FilterOperator::PrintAll
        ),
        _ => false,
    }
}
