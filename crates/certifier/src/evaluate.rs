//! From a property to bounds of its value, with nothing taken on trust.
//!
//! *Method.* Bottom-up over the states that were read anew. What happens within steps is computed backward in intervals
//! ([`steps`]); what happens within a time, by uniformisation in intervals ([`timed`]); what is reached, or earned before,
//! is asked of an [`Oracle`], which need not be trusted: its bounds count only if all inequalities hold ([`inequalities`]).
//! Several bounds in time in one formula cut time into segments ([`windows`](crate::windows)).
//! Linear temporal logic becomes reachability in a product with machines ([`product`](super::product)); averages are bounded by gain and bias,
//! totals by inequalities ([`average`], [`total`]); conditions are restarts ([`conditional`](crate::conditional)), and of all
//! or some paths sets of states are the fixpoints of their definitions ([`quantifiers`](crate::quantifiers)); several
//! objectives have bounds by weights and mixtures ([`multi`](crate::multi)). Truth values of nested operators follow from the bounds; where these
//! leave one open, from the values themselves ([`exact`]), or nothing is certified.
//!
//! Guarantee: exact where inequalities are checked, containment where intervals are computed. Nothing is shared with the
//! solver but the parser and the meaning of expressions.
//!
//! [`steps`]: crate::steps
//! [`timed`]: crate::timed
//! [`inequalities`]: crate::inequalities
//! [`average`]: crate::average
//! [`total`]: crate::total

use std::rc::Rc;

use num_traits::Zero;
use prism_lang::ast::BinaryOp;
use prism_lang::property::{Property, StateFormula};
use prism_lang::resolved::{Model, ModelType};
use prism_lang::{Comparison, Number, Rational};

use crate::Certified;
use crate::failure::Failure;
use crate::inequalities::{Bounds, Problem};
use crate::interval::Interval;
use crate::question::{holds, unsupported};
use crate::reading::{Choice, Part, Reading};

mod exact;
mod filters;
mod paths;
mod quantities;
pub(crate) use paths::as_set;

/// Who finds bounds, which need not be right.
pub trait Oracle {
    /// Bounds for a problem, one of each kind for every state; wider ones each time it is asked again about the same
    /// problem (`attempt` counts from 0). Nothing if there are no (more) bounds.
    fn bounds(&mut self, problem: &Problem<'_>, attempt: u32) -> Option<Bounds>;

    /// The values themselves, one for every state, none where it is infinite. Asked only where bounds leave a comparison
    /// open; nothing if they are not to be had.
    fn exact(&mut self, _problem: &Problem<'_>) -> Option<Vec<Option<Rational>>> {
        None
    }

    /// Whether to stop, which is asked now and then.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// How often an oracle is asked about the same problem.
const ATTEMPTS: u32 = 6;

/// A reward structure, and which of its rewards.
type Earned = (Option<usize>, Part);

/// The evaluation of one property.
pub(crate) struct Evaluator<'a> {
    pub(crate) model: &'a Model,
    pub(crate) oracle: &'a mut dyn Oracle,
    readings: Vec<(Earned, Rc<Reading>)>,
    pub(crate) inequalities: u64,
}

impl<'a> Evaluator<'a> {
    pub fn new(model: &'a Model, oracle: &'a mut dyn Oracle) -> Result<Self, Failure> {
        Ok(Self {
            model,
            oracle,
            readings: Vec::new(),
            inequalities: 0,
        })
    }

    /// Without probabilities only sets of states are asked for.
    pub fn needs_probabilities(&self) -> Result<(), Failure> {
        match self.model.model_type {
            ModelType::Lts => Err(unsupported("a number in a model without probabilities")),
            _ => Ok(()),
        }
    }

    /// What is shown of a property in the initial states.
    pub fn certified(mut self, property: &Property) -> Result<Certified, Failure> {
        let reading = self.reading()?;
        let initial = 0..reading.num_initial;
        let (values, truth) = match property {
            Property::Probability { bound, path } => {
                let maximise = bound.as_ref().is_none_or(|(c, _)| worst(*c));
                let values = self.path(path, maximise)?;
                let truth = match bound {
                    None => None,
                    Some((comparison, bound)) => {
                        let initial = &values[initial.clone()];
                        let exact = |evaluator: &mut Self| evaluator.exact_path(path, maximise);
                        let truths = self.compared(initial, (*comparison, bound), exact)?;
                        Some(truths.iter().all(|holds| *holds))
                    }
                };
                (values, truth)
            }
            Property::State(formula) => {
                // What is greatest need be known of the initial states only.
                let extreme = match formula {
                    StateFormula::Filter(filter) => self.initial_extreme(filter)?,
                    _ => None,
                };
                let truth = match extreme {
                    Some(truth) => truth,
                    None => {
                        let truths = self.truths(formula)?;
                        truths[initial.clone()].iter().all(|holds| *holds)
                    }
                };
                (vec![Interval::ANY; reading.states.len()], Some(truth))
            }
            Property::Number(quantity) => (self.numbers(quantity)?, None),
            Property::Range(filter) => {
                let [least, greatest] = self.range(filter)?;
                return Ok(Certified {
                    low: least.low,
                    high: greatest.high,
                    ends: [least, greatest],
                    truth: None,
                    curve: None,
                    states: reading.states.len(),
                    inequalities: self.inequalities,
                });
            }
            Property::Objectives(objectives) => return self.objectives(objectives),
        };
        let end = |maximise: bool| {
            let values = initial.clone().map(|state| values[state]);
            let best = values.reduce(|a, b| a.best(&b, maximise));
            best.ok_or(Failure::NoInitialState)
        };
        let ends = [end(false)?, end(true)?];
        Ok(Certified {
            low: ends[0].low,
            high: ends[1].high,
            ends,
            truth,
            curve: None,
            states: reading.states.len(),
            inequalities: self.inequalities,
        })
    }

    /// The model without rewards.
    pub fn reading(&mut self) -> Result<Rc<Reading>, Failure> {
        self.earning(None, Part::All)
    }

    /// The model with what its steps earn.
    pub fn earning(
        &mut self,
        structure: Option<usize>,
        part: Part,
    ) -> Result<Rc<Reading>, Failure> {
        let wanted = (structure, part);
        if let Some((_, known)) = self.readings.iter().find(|(of, _)| *of == wanted) {
            return Ok(known.clone());
        }
        let cancelled = || self.oracle.is_cancelled();
        let reading = Rc::new(Reading::of(self.model, structure, part, &cancelled)?);
        self.readings.push((wanted, reading.clone()));
        Ok(reading)
    }

    pub fn is_chain(&self) -> bool {
        matches!(self.model.model_type, ModelType::Dtmc | ModelType::Ctmc)
    }

    /// The states in which a formula holds.
    pub fn truths(&mut self, formula: &StateFormula) -> Result<Vec<bool>, Failure> {
        let pairs = |evaluator: &mut Self,
                     a: &StateFormula,
                     b: &StateFormula,
                     join: fn(bool, bool) -> bool| {
            let (a, b) = (evaluator.truths(a)?, evaluator.truths(b)?);
            Ok(a.into_iter().zip(b).map(|(a, b)| join(a, b)).collect())
        };
        match formula {
            StateFormula::Expr(_) | StateFormula::Label(_) => {
                let reading = self.reading()?;
                (reading.states.iter().enumerate())
                    .map(|(number, state)| {
                        let (first, stuck) =
                            (number < reading.num_initial, reading.deadlock[number]);
                        holds(formula, self.model, state, first, stuck)
                    })
                    .collect()
            }
            StateFormula::Not(a) => Ok(self.truths(a)?.into_iter().map(|a| !a).collect()),
            StateFormula::And(a, b) => pairs(self, a, b, |a, b| a && b),
            StateFormula::Or(a, b) => pairs(self, a, b, |a, b| a || b),
            StateFormula::Implies(a, b) => pairs(self, a, b, |a, b| !a || b),
            StateFormula::Iff(a, b) => pairs(self, a, b, |a, b| a == b),
            StateFormula::Choice(condition, a, b) => {
                let condition = self.truths(condition)?;
                let (a, b) = (self.truths(a)?, self.truths(b)?);
                let each = condition.into_iter().zip(a.into_iter().zip(b));
                Ok(each.map(|(c, (a, b))| if c { a } else { b }).collect())
            }
            StateFormula::Probability { .. }
            | StateFormula::Reward { .. }
            | StateFormula::LongRun { .. } => self.bounded(formula, false),
            StateFormula::SomeScheduler(inner) => self.bounded(inner, true),
            StateFormula::Compare(operator, a, b) => {
                let pairs = (self.numbers(a)?, self.numbers(b)?);
                let each = pairs.0.iter().zip(&pairs.1);
                let truths: Result<Vec<bool>, Failure> = each
                    .map(|(a, b)| match operator {
                        BinaryOp::Less => decided(a, Comparison::Less, b),
                        BinaryOp::LessEqual => decided(a, Comparison::LessEqual, b),
                        BinaryOp::Greater => decided(a, Comparison::Greater, b),
                        BinaryOp::GreaterEqual => decided(a, Comparison::GreaterEqual, b),
                        BinaryOp::NotEqual if a.high < b.low || b.high < a.low => Ok(true),
                        BinaryOp::Equal if a.high < b.low || b.high < a.low => Ok(false),
                        // Both are known exactly.
                        BinaryOp::Equal | BinaryOp::NotEqual if a == b && a.low == a.high => {
                            Ok(*operator == BinaryOp::Equal)
                        }
                        _ => Err(open()),
                    })
                    .collect();
                if truths.is_ok() {
                    return truths;
                }
                let (a, b) = (self.exact_numbers(a)?, self.exact_numbers(b)?);
                let holds = |(a, b): (&exact::Exact, &exact::Exact)| match operator {
                    BinaryOp::Less => exact::compared(a, Comparison::Less, b),
                    BinaryOp::LessEqual => exact::compared(a, Comparison::LessEqual, b),
                    BinaryOp::Greater => exact::compared(a, Comparison::Greater, b),
                    BinaryOp::GreaterEqual => exact::compared(a, Comparison::GreaterEqual, b),
                    BinaryOp::NotEqual => a != b,
                    _ => a == b,
                };
                Ok(a.iter().zip(&b).map(holds).collect())
            }
            StateFormula::Filter(filter) => self.filter_truths(filter),
            StateFormula::Exists(path) => self.some_path(path, false),
            StateFormula::ForAll(path) => {
                let violated = self.some_path(path, true)?;
                Ok(violated.into_iter().map(|violated| !violated).collect())
            }
        }
    }

    fn bounded(&mut self, formula: &StateFormula, by_some: bool) -> Result<Vec<bool>, Failure> {
        match formula {
            StateFormula::Probability { bound, path } => {
                let maximise = worst(bound.0) != by_some;
                let values = self.path(path, maximise)?;
                let bound = (bound.0, &bound.1);
                self.compared(&values, bound, |evaluator| {
                    evaluator.exact_path(path, maximise)
                })
            }
            StateFormula::Reward { bound, reward } => {
                let maximise = worst(bound.0) != by_some;
                let values = self.reward(reward, maximise)?;
                let bound = (bound.0, &bound.1);
                self.compared(&values, bound, |evaluator| {
                    evaluator.exact_reward(reward, maximise)
                })
            }
            StateFormula::LongRun { bound, states } => {
                let values = self.share(states)?;
                self.compared(&values, (bound.0, &bound.1), |_| Err(open()))
            }
            _ => Err(unsupported("a strategy of several operators")),
        }
    }

    /// Whether values, those of the first states, meet a bound; where intervals cannot tell, by the numbers themselves.
    fn compared(
        &mut self,
        values: &[Interval],
        (comparison, bound): (Comparison, &Number),
        exact: impl FnOnce(&mut Self) -> Result<Vec<exact::Exact>, Failure>,
    ) -> Result<Vec<bool>, Failure> {
        let interval = Interval::of_number(bound);
        let decide = |value: &Interval| decided(value, comparison, &interval);
        let truths: Vec<Option<bool>> = values.iter().map(|value| decide(value).ok()).collect();
        if let Some(truths) = truths.iter().copied().collect() {
            return Ok(truths);
        }
        let bound = Some(bound.exact().cloned().ok_or_else(open)?);
        let exact = exact(self)?;
        let each = truths.iter().zip(&exact);
        let truth = |(truth, value): (&Option<bool>, &exact::Exact)| {
            truth.unwrap_or_else(|| exact::compared(value, comparison, &bound))
        };
        Ok(each.map(truth).collect())
    }
}

/// Whether the greatest value is what a bound must be compared with, so that all schedulers meet it.
fn worst(comparison: Comparison) -> bool {
    matches!(comparison, Comparison::Less | Comparison::LessEqual)
}

/// Whether a number compares so, if that is known.
fn decided(value: &Interval, comparison: Comparison, bound: &Interval) -> Result<bool, Failure> {
    let below = if value.high < bound.low {
        Some(true)
    } else if value.low > bound.high {
        Some(false)
    } else {
        None
    };
    let (no_less, no_more) = (value.low >= bound.high, value.high <= bound.low);
    match comparison {
        Comparison::Less => below.or(no_less.then_some(false)),
        Comparison::GreaterEqual => below.map(|below| !below).or(no_less.then_some(true)),
        Comparison::LessEqual => below.or(no_more.then_some(true)),
        Comparison::Greater => below.map(|below| !below).or(no_more.then_some(false)),
    }
    .ok_or_else(open)
}

pub(crate) fn open() -> Failure {
    Failure::Unsupported("a comparison that the bounds leave open".to_owned())
}

/// Nothing is earned.
pub(crate) fn is_free(choice: &Choice) -> bool {
    choice.reward == Rational::zero()
}
