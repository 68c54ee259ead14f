//! From a property to its answer: which states satisfy a state formula, which probability a path formula has.
//!
//! State formulas are evaluated bottom-up to sets of states. A path formula is read as a formula of linear
//! temporal logic whose atomic propositions are the sets of its maximal state subformulas. If it has one
//! temporal operator, it is a next or until formula or the contrary of one, and solved on the chain itself;
//! otherwise on the product with a deterministic automaton ([`crate::product`]).
//!
//! Source: Hansson and Jonsson 1994, Aziz, Singhal, Balarin, Brayton and Sangiovanni-Vincentelli 1995 (PCTL,
//! PCTL*); Baier and Katoen 2008, chapter 10. Guarantee: that of the technique; a comparison that its bounds
//! leave open is an error and never a guess.

use prism_lang::resolved::ModelType;
use prism_lang::{Bound, Comparison, Path, Property, Rational, StateFormula};
use temporal::automaton::{Automaton, DEFAULT_STATE_LIMIT};
use temporal::ltl::Ltl;

use crate::answer::{Answer, AnswerValue, CheckError, Guarantee, InitialValue, Options};
use crate::choices::Choices;
use crate::engine::{Context, Engine, UNKNOWN_ENTRY_ERROR};
use crate::method::Method;
use crate::not_yet::unsupported_over_intervals;
use crate::product::product;
use crate::shape::{Shape, letters, negation, read_path, shape};
use crate::state_space::StateSpace;

/// Evaluation of one property of an interval model (others: [`crate::evaluate`]).
pub(crate) struct Checker<'a, E: Engine> {
    space: &'a StateSpace<E::Entry>,
    context: Context<'a>,
    iterations: u64,
    product_states: Option<usize>,
}

impl<'a, E: Engine> Checker<'a, E> {
    pub fn new(
        space: &'a StateSpace<E::Entry>,
        options: &'a Options<'a>,
    ) -> Result<Self, CheckError> {
        validate(options)?;
        if space.kind != ModelType::Dtmc {
            let kind = space.kind.keyword();
            return Err(CheckError::Unsupported(format!(
                "properties of models of type `{kind}` cannot be computed yet: only those of a `dtmc` can"
            )));
        }
        E::check_entries(&space.matrix)?;
        if space.initial_states().is_empty() {
            return Err(CheckError::NoInitialState);
        }
        Ok(Self {
            space,
            context: Context::new(options, space.relative_error()),
            iterations: 0,
            product_states: None,
        })
    }

    /// The answer to a property in the initial states.
    pub fn answer(mut self, property: &Property, method: Method) -> Result<Answer, CheckError> {
        if let Some(refused) = unsupported_over_intervals(property) {
            return Err(CheckError::Unsupported(refused));
        }
        let initial = match property {
            Property::Probability { bound: None, path } => {
                let values = self.path(path, self.space.initial_states())?;
                return Ok(self.quantitative(&values, method));
            }
            Property::Probability {
                bound: Some((comparison, bound)),
                path,
            } => {
                let values = self.path(path, self.space.initial_states())?;
                let meets = |value| meets::<E>(value, *comparison, bound);
                values.iter().map(meets).collect::<Result<Vec<_>, _>>()?
            }
            Property::State(formula) => {
                let holds = self.states(formula)?;
                self.space
                    .initial_states()
                    .iter()
                    .map(|state| holds[*state])
                    .collect()
            }
            Property::Number(_) | Property::Range(_) | Property::Objectives(_) => {
                return Err(not_yet());
            }
        };
        Ok(self.qualitative(&initial, property, method))
    }

    fn quantitative(self, values: &[E::Value], method: Method) -> Answer {
        let guarantee = |value| E::guarantee(value, &self.context, self.iterations);
        let initial: Vec<InitialValue> = (self.space.initial_states().iter().zip(values))
            .map(|(state, value)| InitialValue {
                state: *state,
                value: E::answer(value),
                guarantee: guarantee(value),
            })
            .collect();
        let complement = match values {
            [value] => E::complement(value),
            _ => None,
        };
        let mut answer = Answer {
            value: range(&initial),
            guarantee: joint_guarantee(&initial),
            method,
            complement: complement.map(|bounds| bounds.middle()),
            complement_bounds: complement
                .filter(|b| !b.is_exact())
                .map(|b| (b.low, b.high)),
            iterations: self.iterations,
            product_states: self.product_states,
            initial,
            notes: Vec::new(),
            scheduler: None,
            printed: Vec::new(),
        };
        let width = values
            .iter()
            .map(|v| E::bounds(v).relative_width())
            .fold(0.0, f64::max);
        if width > self.context.options.precision {
            answer.notes.push(format!(
                "the bounds hold, but their relative distance is {width:e}, more than the {:e} asked for",
                self.context.options.precision
            ));
        }
        answer
    }

    fn qualitative(self, holds: &[bool], property: &Property, method: Method) -> Answer {
        let guarantee = guarantee_of_truths(property, method, &self.context);
        let initial = (self.space.initial_states().iter().zip(holds))
            .map(|(state, holds)| InitialValue {
                state: *state,
                value: AnswerValue::Truth(*holds),
                guarantee: guarantee.clone(),
            })
            .collect();
        Answer {
            value: AnswerValue::Truth(holds.iter().all(|holds| *holds)),
            guarantee,
            method,
            complement: None,
            complement_bounds: None,
            iterations: self.iterations,
            product_states: self.product_states,
            initial,
            notes: Vec::new(),
            scheduler: None,
            printed: Vec::new(),
        }
    }

    /// The states that satisfy a state formula.
    fn states(&mut self, formula: &StateFormula) -> Result<Vec<bool>, CheckError> {
        Ok(match formula {
            StateFormula::Expr(predicate) => self.space.evaluate(predicate)?,
            StateFormula::Label(name) => self.space.label(name)?,
            StateFormula::Not(inner) => negation(self.states(inner)?),
            StateFormula::And(left, right) => self.combine(left, right, |l, r| l & r)?,
            StateFormula::Or(left, right) => self.combine(left, right, |l, r| l | r)?,
            StateFormula::Implies(left, right) => self.combine(left, right, |l, r| !l | r)?,
            StateFormula::Iff(left, right) => self.combine(left, right, |l, r| l == r)?,
            StateFormula::Probability {
                bound: (comparison, bound),
                path,
            } => {
                let everywhere: Vec<usize> = (0..self.space.num_states()).collect();
                let values = self.path(path, &everywhere)?;
                let meets = |value| meets::<E>(value, *comparison, bound);
                values.iter().map(meets).collect::<Result<_, _>>()?
            }
            _ => return Err(not_yet()),
        })
    }

    fn combine(
        &mut self,
        left: &StateFormula,
        right: &StateFormula,
        operator: fn(bool, bool) -> bool,
    ) -> Result<Vec<bool>, CheckError> {
        let (left, right) = (self.states(left)?, self.states(right)?);
        Ok(left
            .into_iter()
            .zip(right)
            .map(|(l, r)| operator(l, r))
            .collect())
    }

    /// The probabilities of a path formula in the states `from`.
    fn path(&mut self, path: &Path, from: &[usize]) -> Result<Vec<E::Value>, CheckError> {
        let mut propositions = Vec::new();
        let formula = read_path(path, &mut propositions, &mut |f| self.states(f))?.simplify();
        let everywhere = match self.simple(&formula, &propositions)? {
            Some(values) => values,
            None => return self.on_product(&formula, &propositions, from),
        };
        Ok(from
            .iter()
            .map(|state| everywhere[*state].clone())
            .collect())
    }

    /// The values in all states if the formula has at most one temporal operator.
    fn simple(
        &mut self,
        formula: &Ltl,
        sets: &[Vec<bool>],
    ) -> Result<Option<Vec<E::Value>>, CheckError> {
        let matrix = &self.space.matrix;
        let (values, contrary) = match shape(formula, sets, self.space.num_states()) {
            None => return Ok(None),
            Some(Shape::Set(holds)) => (holds.into_iter().map(E::indicator).collect(), false),
            Some(Shape::Next { operand, contrary }) => {
                (E::next(matrix, &operand, &self.context), contrary)
            }
            Some(Shape::Until {
                left,
                right,
                steps,
                contrary,
            }) => {
                let (values, rounds) = E::until(matrix, &left, &right, steps, None, &self.context)?;
                self.iterations += rounds;
                (values, contrary)
            }
        };
        Ok(Some(match contrary {
            true => values.iter().map(E::contrary).collect(),
            false => values,
        }))
    }

    fn on_product(
        &mut self,
        formula: &Ltl,
        sets: &[Vec<bool>],
        from: &[usize],
    ) -> Result<Vec<E::Value>, CheckError> {
        let limit = self.context.options.product_limit.min(DEFAULT_STATE_LIMIT);
        let mut automaton = Automaton::with_state_limit(formula, limit)?;
        let letters = letters(sets, self.space.num_states());
        let matrix = &self.space.matrix;
        let model = Choices::new(matrix, &[]);
        let product = product(model, &mut automaton, &letters, from, self.context.options)?;
        let everywhere = vec![true; product.accepting.len()];
        let steps = (0, None);
        let (values, iterations) = E::until(
            &product.matrix,
            &everywhere,
            &product.accepting,
            steps,
            None,
            &self.context,
        )?;
        self.iterations += iterations;
        self.product_states = self.product_states.max(Some(product.accepting.len()));
        Ok(product
            .start
            .iter()
            .map(|state| values[*state].clone())
            .collect())
    }
}

pub(crate) fn validate(options: &Options<'_>) -> Result<(), CheckError> {
    let fraction = |value: f64| value > 0.0 && value < 1.0;
    let invalid = |name: &str, value: f64| {
        Err(CheckError::InvalidOption(format!(
            "the {name} must lie between 0 and 1, but is {value}"
        )))
    };
    if !fraction(options.precision) {
        return invalid("precision", options.precision);
    }
    if !fraction(options.epsilon) {
        return invalid("epsilon", options.epsilon);
    }
    Ok(())
}

pub(crate) fn meets<E: Engine>(
    value: &E::Value,
    comparison: Comparison,
    bound: &Bound,
) -> Result<bool, CheckError> {
    E::meets(value, comparison, bound).ok_or_else(|| CheckError::Undecided {
        comparison: format!("{} {bound}", comparison.symbol()),
        bounds: E::bounds(value),
        is_whole: false,
    })
}

/// What [`unsupported_over_intervals`] has refused before.
fn not_yet() -> CheckError {
    CheckError::Unsupported("this kind of property cannot be computed yet".to_owned())
}

/// What is known of whether a property holds, once it was decided by a method.
pub(crate) fn guarantee_of_truths(
    property: &Property,
    method: Method,
    context: &Context<'_>,
) -> Guarantee {
    let doubt = match method {
        _ if !mentions_probability(property) => None,
        Method::Exact => None,
        method if method.is_estimate() => Some(
            "numbers were compared with their bounds as they are, by a method that does not bound \
             its error",
        ),
        _ if !context.entry_error_known => Some(UNKNOWN_ENTRY_ERROR),
        _ => None,
    };
    doubt.map_or(Guarantee::Exact, |reason| Guarantee::Estimated {
        reason: reason.to_owned(),
    })
}

fn mentions_probability(property: &Property) -> bool {
    fn in_state(formula: &StateFormula) -> bool {
        match formula {
            StateFormula::Expr(_) | StateFormula::Label(_) => false,
            StateFormula::Not(inner) => in_state(inner),
            StateFormula::And(left, right)
            | StateFormula::Or(left, right)
            | StateFormula::Implies(left, right)
            | StateFormula::Iff(left, right) => in_state(left) || in_state(right),
            _ => true,
        }
    }
    match property {
        Property::State(formula) => in_state(formula),
        _ => true,
    }
}

/// One value for all initial states: the value itself, or a range.
pub(crate) fn range(initial: &[InitialValue]) -> AnswerValue {
    if let [only] = initial {
        return only.value.clone();
    }
    let numbers = initial.iter().filter_map(|initial| match initial.value {
        AnswerValue::Number(value) => Some(value),
        _ => None,
    });
    if numbers.clone().any(f64::is_nan) {
        let (low, high) = (f64::NAN, f64::NAN);
        return AnswerValue::Range { low, high };
    }
    let low = numbers.clone().fold(f64::INFINITY, f64::min);
    let high = numbers.fold(f64::NEG_INFINITY, f64::max);
    let mut exact: Vec<_> = (initial.iter())
        .filter_map(|initial| match &initial.value {
            AnswerValue::Exact(value) => Some(value.clone()),
            _ => None,
        })
        .collect();
    exact.sort();
    let (Some(least), Some(greatest)) = (exact.first(), exact.last()) else {
        return AnswerValue::Range { low, high };
    };
    // Beside exact values stand infinite ones only.
    if low == f64::NEG_INFINITY || high == f64::INFINITY {
        let end = |is_infinite: bool, infinite: f64, finite: &Rational| match is_infinite {
            true => AnswerValue::Number(infinite),
            false => AnswerValue::Exact(finite.clone()),
        };
        return AnswerValue::Ends {
            low: Box::new(end(low == f64::NEG_INFINITY, low, least)),
            high: Box::new(end(high == f64::INFINITY, high, greatest)),
        };
    }
    let (low, high) = (least.clone(), greatest.clone());
    AnswerValue::ExactRange { low, high }
}

/// What is known of the values in all initial states.
pub(crate) fn joint_guarantee(initial: &[InitialValue]) -> Guarantee {
    let estimated =
        |initial: &&InitialValue| matches!(initial.guarantee, Guarantee::Estimated { .. });
    if let Some(estimated) = initial.iter().find(estimated) {
        return estimated.guarantee.clone();
    }
    if initial
        .iter()
        .all(|initial| initial.guarantee == Guarantee::Exact)
    {
        return Guarantee::Exact;
    }
    let number = |initial: &InitialValue| match initial.value {
        AnswerValue::Number(value) => Some((value, value)),
        _ => None,
    };
    let ends = initial
        .iter()
        .filter_map(|initial| match initial.guarantee == Guarantee::Exact {
            true => number(initial),
            false => initial.guarantee.bounds(),
        });
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (l, h)| {
        (low.min(l), high.max(h))
    });
    Guarantee::Bounded { low, high }
}
