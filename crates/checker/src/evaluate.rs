//! From a property to its answer: truth values and numbers in states, bottom-up.
//!
//! State formulas are evaluated to sets of states, quantities to numbers in states, path formulas to
//! probabilities. A path formula with one temporal operator is solved on the model itself, others on the product
//! with a deterministic automaton ([`crate::product`]). Where something is true or false of a number, the method
//! must know it for certain; if not, that is the error [`CheckError::Undecided`], never a guess.
//!
//! Source: Hansson and Jonsson 1994, Bianco and de Alfaro 1995 (PCTL, PCTL*); Baier, Haverkort, Hermanns and
//! Katoen 2003 (CSL); the PRISM manual, "Property specification" (filters, rewards). Guarantee: that of the
//! technique.

mod answers;
pub(crate) mod bounds_of_states;
mod conditional;
mod filters;
mod numbers;
mod objectives;
pub(crate) mod parametric;
mod paths;
mod quantifiers;
mod rewards;
mod schedulers;
mod timed;
mod windows;

pub(crate) use timed::NESTED;

use std::cell::OnceCell;

use prism_lang::property::{Property, StateFormula};
use prism_lang::resolved::ModelType;
use prism_lang::{Arithmetic, Comparison, Number};

use crate::amount::Amount;
use crate::answer::{Answer, AnswerValue, CheckError, Options};
use crate::choices::Choices;
use crate::engine::{Context, Numbers};
use crate::method::Method;
use crate::property::{meets, validate};
use crate::rounding::UNIT;
use crate::shape::negation;
use crate::state_space::{Csr, StateSpace};
use crate::stop::{Stop, after_a_cut};

/// Evaluation of one property.
pub(crate) struct Evaluator<'a, E: Numbers> {
    space: &'a StateSpace<E::Entry>,
    /// The probabilities of the embedded chain of a `ctmc`, once they are needed.
    embedded: OnceCell<Csr<E::Entry>>,
    context: Context<'a>,
    iterations: u64,
    product_states: Option<usize>,
    /// The scheduler of the outermost operator, if it has one.
    scheduler: Option<Vec<usize>>,
    /// What filters print.
    printed: Vec<(usize, AnswerValue)>,
    /// How many comparisons with a bound are around what is being evaluated.
    depth: usize,
}

impl<'a, E: Numbers> Evaluator<'a, E> {
    pub fn new(
        space: &'a StateSpace<E::Entry>,
        options: &'a Options<'a>,
    ) -> Result<Self, CheckError> {
        validate(options)?;
        E::check_entries(&space.matrix)?;
        let choices = Choices::new(&space.matrix, &space.choice_start);
        let has_choice = |state: usize| choices.rows(state).len() > 1;
        if E::method(options.method) == Method::LinearEquations
            && (0..space.num_states()).any(has_choice)
        {
            return Err(CheckError::Unsupported(
                "linear equations are those of a chain: use policy iteration for a model with choices, which solves \
                 the equations of one chain after the other"
                    .to_owned(),
            ));
        }
        if space.initial_states().is_empty() {
            return Err(CheckError::NoInitialState);
        }
        let mut context = Context::new(options, space.relative_error());
        if space.kind == ModelType::Ctmc {
            let lengths = space
                .matrix
                .row_start
                .windows(2)
                .map(|ends| ends[1] - ends[0]);
            context.entry_error += (lengths.max().unwrap_or(0) + 2) as f64 * UNIT;
        }
        Ok(Self {
            space,
            embedded: OnceCell::new(),
            context,
            iterations: 0,
            product_states: None,
            scheduler: None,
            printed: Vec::new(),
            depth: 0,
        })
    }

    /// The answer to a property in the initial states.
    ///
    /// # Errors
    /// See [`CheckError`]; [`CheckError::Stopped`] with the bounds reached if the options' `stop` left out work.
    pub fn answer(self, property: &Property) -> Result<Answer, CheckError> {
        let options = self.context.options;
        let found = self.found(property);
        match options.stop.is_some_and(Stop::is_cut) {
            true => after_a_cut(found, options.precision),
            false => found,
        }
    }

    fn found(mut self, property: &Property) -> Result<Answer, CheckError> {
        let initial = self.space.initial_states().to_vec();
        match property {
            Property::Probability { bound: None, path } => {
                let values = self.probability(path, true, &initial)?;
                Ok(self.of_probabilities(&values))
            }
            Property::Probability {
                bound: Some((comparison, bound)),
                path,
            } => {
                let maximise = worst(*comparison);
                let values = self.probability(path, maximise, &initial)?;
                let meets = |value| meets::<E>(value, *comparison, bound);
                let holds = values.iter().map(meets).collect::<Result<Vec<_>, _>>();
                let holds = holds.map_err(of_whole)?;
                Ok(self.of_truths(&holds, property))
            }
            Property::State(formula) => {
                let is_comparison = matches!(
                    formula,
                    StateFormula::Probability { .. }
                        | StateFormula::Reward { .. }
                        | StateFormula::LongRun { .. }
                );
                let holds = self.truths(formula, &initial);
                let holds = holds.map_err(|error| match is_comparison && self.depth == 0 {
                    true => of_whole(error),
                    false => error,
                })?;
                Ok(self.of_truths(&holds, property))
            }
            Property::Number(quantity) => self.of_quantity(quantity, &initial),
            Property::Range(filter) => {
                let (low, high) = self.filter_range(filter)?;
                Ok(self.of_range(&low, &high))
            }
            Property::Objectives(_) => Err(CheckError::Unsupported(
                "several objectives (`multi`) are computed in rational arithmetic only: use the exact method, or \
                 the sound one on a smaller model"
                    .to_owned(),
            )),
        }
    }

    fn choices(&self) -> Choices<'_, E::Entry> {
        Choices::new(self.matrix(), &self.space.choice_start)
    }

    /// Probabilities: the model's own, or those of the embedded chain of a `ctmc`.
    fn matrix(&self) -> &Csr<E::Entry> {
        match self.space.kind {
            ModelType::Ctmc => self.embedded.get_or_init(|| embedded(&self.space.matrix)),
            _ => &self.space.matrix,
        }
    }

    /// The model's own probabilities or rates.
    fn own_choices(&self) -> Choices<'_, E::Entry> {
        Choices::new(&self.space.matrix, &self.space.choice_start)
    }

    fn everywhere(&self) -> Vec<usize> {
        (0..self.space.num_states()).collect()
    }

    /// The states that satisfy a state formula.
    pub(crate) fn set(&mut self, formula: &StateFormula) -> Result<Vec<bool>, CheckError> {
        let everywhere = self.everywhere();
        self.truths(formula, &everywhere)
    }

    /// Whether a state formula holds, in each of the states `from`.
    fn truths(&mut self, formula: &StateFormula, from: &[usize]) -> Result<Vec<bool>, CheckError> {
        let select = |set: Vec<bool>| from.iter().map(|state| set[*state]).collect();
        Ok(match formula {
            StateFormula::Expr(predicate) => select(self.space.evaluate(predicate)?),
            StateFormula::Label(name) => select(self.space.label(name)?),
            StateFormula::Not(inner) => negation(self.truths(inner, from)?),
            StateFormula::And(a, b) => self.combine(a, b, from, |a, b| a & b)?,
            StateFormula::Or(a, b) => self.combine(a, b, from, |a, b| a | b)?,
            StateFormula::Implies(a, b) => self.combine(a, b, from, |a, b| !a | b)?,
            StateFormula::Iff(a, b) => self.combine(a, b, from, |a, b| a == b)?,
            StateFormula::Choice(condition, a, b) => {
                let condition = self.truths(condition, from)?;
                let (a, b) = (self.truths(a, from)?, self.truths(b, from)?);
                chosen(&condition, a, b)
            }
            StateFormula::Probability { .. }
            | StateFormula::Reward { .. }
            | StateFormula::LongRun { .. } => self.bounded(formula, from, false)?,
            StateFormula::SomeScheduler(inner) => self.bounded(inner, from, true)?,
            StateFormula::ForAll(path) => negation(self.some_path(path, true, from)?),
            StateFormula::Exists(path) => self.some_path(path, false, from)?,
            StateFormula::Compare(operator, a, b) => self.compared(*operator, a, b, from)?,
            StateFormula::Filter(filter) => self.filter_truths(filter, from)?,
        })
    }

    fn combine(
        &mut self,
        a: &StateFormula,
        b: &StateFormula,
        from: &[usize],
        operator: fn(bool, bool) -> bool,
    ) -> Result<Vec<bool>, CheckError> {
        let (a, b) = (self.truths(a, from)?, self.truths(b, from)?);
        Ok(a.into_iter().zip(b).map(|(a, b)| operator(a, b)).collect())
    }

    /// An operator with a bound: under every scheduler, or under some.
    fn bounded(
        &mut self,
        formula: &StateFormula,
        from: &[usize],
        by_some: bool,
    ) -> Result<Vec<bool>, CheckError> {
        let maximise = |comparison: Comparison| worst(comparison) != by_some;
        match formula {
            StateFormula::Probability {
                bound: (comparison, bound),
                path,
            } => {
                self.depth += 1;
                let values = self.probability(path, maximise(*comparison), from)?;
                self.depth -= 1;
                values
                    .iter()
                    .map(|value| meets::<E>(value, *comparison, bound))
                    .collect()
            }
            StateFormula::Reward {
                bound: (comparison, bound),
                reward,
            } => {
                self.depth += 1;
                let values = self.reward(reward, maximise(*comparison), from)?;
                self.depth -= 1;
                values
                    .iter()
                    .map(|value| amount_meets(value, *comparison, bound))
                    .collect()
            }
            StateFormula::LongRun {
                bound: (comparison, bound),
                states,
            } => {
                self.depth += 1;
                let values = self.long_run(states, from)?;
                self.depth -= 1;
                values
                    .iter()
                    .map(|value| amount_meets(value, *comparison, bound))
                    .collect()
            }
            _ => Err(CheckError::Unsupported(
                "a strategy can be asked for one operator with a bound only".to_owned(),
            )),
        }
    }
}

/// An undecided comparison that is the whole property.
fn of_whole(error: CheckError) -> CheckError {
    match error {
        CheckError::Undecided {
            comparison, bounds, ..
        } => CheckError::Undecided {
            comparison,
            bounds,
            is_whole: true,
        },
        other => other,
    }
}

/// Whether the greatest value is what a bound must be compared with, so that all schedulers meet it.
fn worst(comparison: Comparison) -> bool {
    matches!(comparison, Comparison::Less | Comparison::LessEqual)
}

/// Whether a number meets a bound.
fn amount_meets<A: Amount>(
    value: &A,
    comparison: Comparison,
    bound: &Number,
) -> Result<bool, CheckError> {
    use std::cmp::Ordering;
    let limit = A::literal(bound);
    let order = value.compare(&limit);
    let (at_most, at_least) = (
        value.bounds().high <= limit.bounds().low,
        value.bounds().low >= limit.bounds().high,
    );
    let known = match (comparison, order) {
        (Comparison::Less | Comparison::LessEqual, Some(Ordering::Less)) => Some(true),
        (Comparison::Greater | Comparison::GreaterEqual, Some(Ordering::Greater)) => Some(true),
        (_, Some(Ordering::Equal)) => Some(matches!(
            comparison,
            Comparison::LessEqual | Comparison::GreaterEqual
        )),
        (_, Some(_)) => Some(false),
        (Comparison::LessEqual, None) if at_most => Some(true),
        (Comparison::Greater, None) if at_most => Some(false),
        (Comparison::GreaterEqual, None) if at_least => Some(true),
        (Comparison::Less, None) if at_least => Some(false),
        // Not a number meets nothing.
        (_, None) if value.is_undefined() => Some(false),
        _ => None,
    };
    known.ok_or_else(|| CheckError::Undecided {
        comparison: format!("{} {bound}", comparison.symbol()),
        bounds: value.bounds(),
        is_whole: false,
    })
}

/// The probabilities of a chain with rates.
pub(crate) fn embedded<N: Arithmetic>(rates: &Csr<N>) -> Csr<N> {
    let mut matrix = rates.clone();
    for state in 0..rates.num_rows() {
        let range = rates.row_start[state]..rates.row_start[state + 1];
        let total = rates.value[range.clone()]
            .iter()
            .fold(N::zero(), |sum, rate| sum.add(rate));
        for value in &mut matrix.value[range] {
            // Rates are positive, and every state has one.
            *value = value.div(&total).unwrap_or_else(N::one);
        }
    }
    matrix
}

/// State by state the first value where the condition holds, else the second.
fn chosen<T>(condition: &[bool], first: Vec<T>, second: Vec<T>) -> Vec<T> {
    let pairs = first.into_iter().zip(second);
    let each = condition.iter().zip(pairs);
    each.map(|(holds, (first, second))| if *holds { first } else { second })
        .collect()
}
