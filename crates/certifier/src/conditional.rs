//! Conditional probabilities over schedulers, as reachability with restarts.
//!
//! *Definition.* The greatest `P(f and c) / P(c)` over the schedulers under which `c` is possible. In the product with
//! machines, a maximal end component is a goal where a scheduler can stay and satisfy `f and c`; else, where it can stay
//! and violate `c`, it may start again from the beginning, since what is not given does not count; else `c` holds without
//! `f`. The greatest probability of a goal in the process with these restarts is the conditional one; the least is that of
//! the contrary of `f`, less from 1.
//!
//! Source: Baier, Klein, Klüppelholz and Märcker 2014, "Computing Conditional Probabilities in Markovian Models
//! Efficiently", theorem on restarts. Trusted: that theorem and [`crate::formula`]. Cost: one problem for each state; where
//! there are more than [`MOST_STATES`], the initial ones only, and for the others nothing is claimed. Guarantee: that of
//! reachability, which is shown by inequalities.

use num_traits::{One, Zero};
use prism_lang::Rational;
use prism_lang::property::Path;

use crate::evaluate::Evaluator;
use crate::explicit::{end_components, possible, quotient};
use crate::failure::Failure;
use crate::formula::{Condition, Formula};
use crate::inequalities::Problem;
use crate::interval::Interval;
use crate::product::Product;
use crate::question::unsupported;
use crate::reading::Choice;

/// States up to which all are asked about.
const MOST_STATES: usize = 64;

/// The product, its components as classes, and what each may do besides.
struct Restarts {
    class: Vec<usize>,
    choices: Vec<Vec<Choice>>,
    ends: Vec<End>,
}

/// What a scheduler that stays in a component can have.
#[derive(Clone, Copy, PartialEq)]
enum End {
    /// Path and condition.
    Goal,
    /// Not the condition.
    Again,
    /// The condition alone.
    Missed,
}

impl Evaluator<'_> {
    /// The conditional probability in each state, least or greatest over schedulers.
    pub(crate) fn conditional(
        &mut self,
        path: &Path,
        condition: &Path,
        maximise: bool,
    ) -> Result<Vec<Interval>, Failure> {
        self.needs_probabilities()?;
        let mut sets = Vec::new();
        let path = self.formula(path, &mut sets)?;
        let given = self.formula(condition, &mut sets)?;
        let path = if maximise { path } else { path.negated() };
        let mut machines = Vec::new();
        let both = Condition::read(&Formula::And(vec![path, given.clone()]), &mut machines)?;
        let not_given = Condition::read(&given.negated(), &mut machines)?;
        let given = Condition::read(&given, &mut machines)?;
        let reading = self.reading()?;
        let product = Product::new(&reading.choices, &mut machines, &sets)?;
        let both = product.accepting(&both, &machines);
        let not_given = product.accepting(&not_given, &machines);
        let given = possible(&product.choices, &product.accepting(&given, &machines));
        let everywhere = vec![true; given.len()];
        let components = end_components(&product.choices, &everywhere, &|_| true);
        let can = |component: &[usize], set: &[bool]| component.iter().any(|state| set[*state]);
        let end = |component: &Vec<usize>| match can(component, &both) {
            true => End::Goal,
            false if can(component, &not_given) => End::Again,
            false => End::Missed,
        };
        let ends = components.iter().map(end).collect();
        let (class, choices) = quotient(&product.choices, &components);
        let restarts = Restarts {
            class,
            choices,
            ends,
        };
        let is_small = reading.states.len() <= MOST_STATES;
        let mut values = Vec::with_capacity(reading.states.len());
        for (state, start) in product.start.iter().enumerate() {
            let is_initial = state < reading.num_initial;
            values.push(match given[*start] {
                false if is_initial => {
                    return Err(unsupported("a probability under an impossible condition"));
                }
                true if is_initial || is_small => {
                    let value = self.restarting(&restarts, *start)?;
                    if maximise { value } else { value.contrary() }
                }
                _ => Interval {
                    low: 0.0,
                    high: 1.0,
                },
            });
        }
        Ok(values)
    }

    /// The greatest probability of a goal from a state of the product, to which it goes back.
    fn restarting(&mut self, restarts: &Restarts, start: usize) -> Result<Interval, Failure> {
        let start = restarts.class[start];
        let mut choices = restarts.choices.clone();
        let (goal, sink) = (choices.len(), choices.len() + 1);
        let go = |to: usize| Choice {
            outcomes: vec![(to, Rational::one())],
            reward: Rational::zero(),
        };
        for (own, end) in choices.iter_mut().zip(&restarts.ends) {
            own.push(go(match end {
                End::Goal => goal,
                End::Again => start,
                End::Missed => sink,
            }));
        }
        choices.extend([vec![go(goal)], vec![go(sink)]]);
        let of = |end: usize| (0..choices.len()).map(|s| s == end).collect::<Vec<bool>>();
        let (target, failed) = (of(goal), of(sink));
        let values = self.solved(Problem {
            choices: &choices,
            target: &target,
            failed: &failed,
            is_reward: false,
            maximise: true,
        })?;
        Ok(values[start])
    }
}
