//! What the techniques have in common: each computes the probabilities of until formulas in all states.

mod numbers;

use prism_lang::{Arithmetic, Bound, Comparison, Number, Rational};

use crate::amount::Amount;
use crate::answer::{AnswerValue, CheckError, Guarantee, Options};
use crate::choices::Choices;
use crate::graph::{Qualitative, qualitative};
use crate::method::Method;
use crate::optimum::classical;
use crate::rounding::{Bounds, LEAST_ENTRY_ERROR};
use crate::sound::Probability;
use crate::state_space::Csr;
use crate::steps::Back;
use crate::{exact, prism_default, sound};

pub(crate) use numbers::Numbers;

/// Why bounds computed from probabilities of unknown accuracy are none.
pub(crate) const UNKNOWN_ENTRY_ERROR: &str = "the model computes probabilities with irrational \
     numbers (roots, logarithms), whose rounding errors are not known";

/// What the techniques need to know besides the problem.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Context<'a> {
    /// As the caller wishes.
    pub options: &'a Options<'a>,
    /// A bound of the relative error of the transition probabilities.
    pub entry_error: f64,
    /// Whether that bound is known to hold.
    pub entry_error_known: bool,
    /// The values of open constants, in the technique that has functions of these.
    pub cell: Option<&'a crate::parametric::optimise::Cell<'a>>,
}

impl<'a> Context<'a> {
    /// With the state space's bound, which is infinite if there is none.
    pub fn new(options: &'a Options<'a>, relative_error: f64) -> Self {
        let entry_error_known = relative_error.is_finite();
        Self {
            options,
            entry_error: if entry_error_known {
                relative_error.max(LEAST_ENTRY_ERROR)
            } else {
                1e-12
            },
            entry_error_known,
            cell: None,
        }
    }
}

/// A technique: a number domain for transitions, one for values, and how to solve reachability.
pub(crate) trait Engine {
    /// Transition probabilities.
    type Entry: Arithmetic;
    /// Probabilities of paths.
    type Value: Clone + PartialEq;

    /// Exactly 1 if `holds`, else exactly 0.
    fn indicator(holds: bool) -> Self::Value;

    /// The probability of the contrary.
    fn contrary(value: &Self::Value) -> Self::Value;

    /// The mean over a state's transitions.
    fn mean<'a>(
        transitions: impl Iterator<Item = (&'a Self::Entry, &'a Self::Value)>,
        context: &Context<'_>,
    ) -> Self::Value
    where
        Self: 'a;

    /// Reachability of the sure states, in all states, and the rounds of iteration it took.
    fn reachability(
        matrix: &Csr<Self::Entry>,
        sets: &Qualitative,
        context: &Context<'_>,
    ) -> Result<(Vec<Self::Value>, u64), CheckError>;

    /// Whether the value compares so with the bound; `None` if that is not known.
    fn meets(value: &Self::Value, comparison: Comparison, bound: &Bound) -> Option<bool>;

    /// What is known of the value, for error messages.
    fn bounds(value: &Self::Value) -> Bounds;

    /// A value of which this is known; nothing if the technique has no bounds.
    fn within(_: Bounds) -> Option<Self::Value> {
        None
    }

    /// The value as an answer.
    fn answer(value: &Self::Value) -> AnswerValue;

    /// What is known of the value.
    fn guarantee(value: &Self::Value, context: &Context<'_>, iterations: u64) -> Guarantee;

    /// What is known of the contrary's probability, if it was computed on its own.
    fn complement(value: &Self::Value) -> Option<Bounds>;

    /// What the technique needs of the transition probabilities.
    fn check_entries(_: &Csr<Self::Entry>) -> Result<(), CheckError> {
        Ok(())
    }

    /// `left U right` within the steps `first..=last`, in the states `from` (all if not given); and the rounds of iteration.
    /// Other states may have bounds that say nothing.
    ///
    /// From below: the probability within no step is the indicator of `right`; within one step more it is
    /// the mean over the transitions. Then `first` steps back, during which only `left` counts. All terms are
    /// positive, also those of the contrary, so relative errors grow by one mean's rounding for each step.
    fn until(
        matrix: &Csr<Self::Entry>,
        left: &[bool],
        right: &[bool],
        (first, last): (u64, Option<u64>),
        from: Option<&[usize]>,
        context: &Context<'_>,
    ) -> Result<(Vec<Self::Value>, u64), CheckError> {
        let from = from.filter(|_| first == 0);
        let sets = qualitative(matrix, left, right);
        let (mut values, iterations) = match last {
            None => Self::reachability(matrix, &sets, context)?,
            Some(last) => {
                let active: Vec<bool> = (0..left.len())
                    .map(|s| !sets.never[s] && !right[s])
                    .collect();
                let start = right.iter().map(|right| Self::indicator(*right)).collect();
                let steps = last.saturating_sub(first);
                (
                    Self::steps_back(matrix, start, &active, steps, from, context)?,
                    0,
                )
            }
        };
        if first > 0 {
            let outside = left.iter().map(|left| !left);
            values = Self::steps_back(matrix, values, left, 1, None, context)?;
            for (value, outside) in values.iter_mut().zip(outside) {
                if outside {
                    *value = Self::indicator(false);
                }
            }
            values = Self::steps_back(matrix, values, left, first - 1, None, context)?;
        }
        Ok((values, iterations))
    }

    /// Replaces the values of the active states by the mean over their transitions, `steps` times; those that are asked for.
    fn steps_back(
        matrix: &Csr<Self::Entry>,
        values: Vec<Self::Value>,
        active: &[bool],
        steps: u64,
        _: Option<&[usize]>,
        context: &Context<'_>,
    ) -> Result<Vec<Self::Value>, CheckError> {
        let states: Vec<usize> = (0..active.len()).filter(|state| active[*state]).collect();
        step_by_step::<Self>(matrix, values, &states, steps, context)
    }

    /// The probability that the next state is in `operand`, in all states.
    fn next(
        matrix: &Csr<Self::Entry>,
        operand: &[bool],
        context: &Context<'_>,
    ) -> Vec<Self::Value> {
        let values: Vec<Self::Value> = operand.iter().map(|o| Self::indicator(*o)).collect();
        (0..matrix.num_rows())
            .map(|state| {
                Self::mean(
                    matrix.row(state).map(|(target, p)| (p, &values[target])),
                    context,
                )
            })
            .collect()
    }
}

/// One step back at a time, by the technique's mean.
///
/// Ends early when nothing changes any more, since then nothing ever will.
fn step_by_step<E: Engine + ?Sized>(
    matrix: &Csr<E::Entry>,
    mut values: Vec<E::Value>,
    states: &[usize],
    steps: u64,
    context: &Context<'_>,
) -> Result<Vec<E::Value>, CheckError> {
    let mut next = values.clone();
    let grows = start_at_nothing::<E>(&values, states);
    for step in 0..steps {
        if step % 16 == 0 && context.options.stops()? {
            leave_out::<E>(&mut values, states, grows)?;
            break;
        }
        let mut changed = false;
        for state in states {
            let transitions = matrix.row(*state).map(|(target, p)| (p, &values[target]));
            let new = E::mean(transitions, context);
            changed |= new != values[*state];
            next[*state] = new;
        }
        std::mem::swap(&mut values, &mut next);
        if !changed {
            break;
        }
    }
    Ok(values)
}

/// Whether these states begin with 0, the least of all values, so that values grow with the steps.
pub(crate) fn start_at_nothing<E: Engine + ?Sized>(values: &[E::Value], states: &[usize]) -> bool {
    let is_nothing = |state: &usize| E::bounds(&values[*state]) == Bounds::ZERO;
    states.iter().all(is_nothing)
}

/// Bounds of what steps that are not taken would make of the values of these states: means, hence between the least and the
/// greatest of all values, and no less than they are if they grow.
pub(crate) fn leave_out<E: Engine + ?Sized>(
    values: &mut [E::Value],
    states: &[usize],
    grows: bool,
) -> Result<(), CheckError> {
    let none = Bounds {
        low: f64::INFINITY,
        high: 0.0,
    };
    let all = values
        .iter()
        .map(E::bounds)
        .fold(none, |all, value| Bounds {
            low: all.low.min(value.low),
            high: all.high.max(value.high),
        });
    for state in states {
        let own = E::bounds(&values[*state]);
        let low = if grows { own.low } else { all.low };
        let value = E::within(Bounds { low, ..all });
        values[*state] = value.ok_or(CheckError::Cancelled)?;
    }
    Ok(())
}

/// [`crate::Method::Sound`], and the direct methods, whose answers have bounds, too.
pub(crate) enum Sound {}

impl Engine for Sound {
    type Entry = f64;
    type Value = Probability;

    fn indicator(holds: bool) -> Probability {
        Probability::indicator(holds)
    }

    fn contrary(value: &Probability) -> Probability {
        value.contrary()
    }

    fn mean<'a>(
        transitions: impl Iterator<Item = (&'a f64, &'a Probability)>,
        context: &Context<'_>,
    ) -> Probability {
        Probability::mean(transitions, context.entry_error)
    }

    fn reachability(
        matrix: &Csr<f64>,
        sets: &Qualitative,
        context: &Context<'_>,
    ) -> Result<(Vec<Probability>, u64), CheckError> {
        sound::reachability(matrix, sets, context)
    }

    fn steps_back(
        matrix: &Csr<f64>,
        values: Vec<Probability>,
        active: &[bool],
        steps: u64,
        from: Option<&[usize]>,
        context: &Context<'_>,
    ) -> Result<Vec<Probability>, CheckError> {
        let back = Back {
            choices: Choices::new(matrix, &[]),
            active,
            steps,
            from,
            maximise: true,
        };
        if let Some(values) = back.probabilities(&values, context)? {
            return Ok(values);
        }
        let states: Vec<usize> = (0..active.len()).filter(|state| active[*state]).collect();
        step_by_step::<Self>(matrix, values, &states, steps, context)
    }

    fn check_entries(matrix: &Csr<f64>) -> Result<(), CheckError> {
        sound::check_entries(matrix)
    }

    fn meets(value: &Probability, comparison: Comparison, bound: &Bound) -> Option<bool> {
        let bound = Bounds::literal(bound);
        let Bounds { low, high } = value.value;
        let (yes, no) = match comparison {
            Comparison::Less => (high < bound.low, low >= bound.high),
            Comparison::LessEqual => (high <= bound.low, low > bound.high),
            Comparison::Greater => (low > bound.high, high <= bound.low),
            Comparison::GreaterEqual => (low >= bound.high, high < bound.low),
        };
        match (yes, no) {
            (true, _) => Some(true),
            (_, true) => Some(false),
            _ => None,
        }
    }

    fn bounds(value: &Probability) -> Bounds {
        value.value
    }

    fn within(bounds: Bounds) -> Option<Probability> {
        Some(Probability::from_value(bounds))
    }

    fn answer(value: &Probability) -> AnswerValue {
        AnswerValue::Number(value.value.middle())
    }

    fn guarantee(value: &Probability, context: &Context<'_>, _: u64) -> Guarantee {
        Self::guarantee_of(&value.value, context, 0)
    }

    fn complement(value: &Probability) -> Option<Bounds> {
        Some(value.complement)
    }
}

/// Plain floating point: [`crate::Method::PrismDefault`] and the other methods whose answers are estimates.
pub(crate) enum Plain {}

impl Engine for Plain {
    type Entry = f64;
    type Value = f64;

    fn indicator(holds: bool) -> f64 {
        f64::from(u8::from(holds))
    }

    fn contrary(value: &f64) -> f64 {
        1.0 - value
    }

    fn mean<'a>(transitions: impl Iterator<Item = (&'a f64, &'a f64)>, _: &Context<'_>) -> f64 {
        transitions.map(|(p, value)| p * value).sum()
    }

    fn reachability(
        matrix: &Csr<f64>,
        sets: &Qualitative,
        context: &Context<'_>,
    ) -> Result<(Vec<f64>, u64), CheckError> {
        match context.options.method {
            Method::PrismDefault => prism_default::reachability(matrix, sets, context.options),
            _ => classical::reachability(matrix, sets, context.options),
        }
    }

    fn meets(value: &f64, comparison: Comparison, bound: &Bound) -> Option<bool> {
        let bound = bound.to_f64();
        Some(match comparison {
            Comparison::Less => *value < bound,
            Comparison::LessEqual => *value <= bound,
            Comparison::Greater => *value > bound,
            Comparison::GreaterEqual => *value >= bound,
        })
    }

    fn bounds(value: &f64) -> Bounds {
        Bounds::exactly(*value)
    }

    fn answer(value: &f64) -> AnswerValue {
        AnswerValue::Number(*value)
    }

    fn guarantee(_: &f64, context: &Context<'_>, iterations: u64) -> Guarantee {
        if iterations == 0 {
            return Guarantee::Estimated {
                reason: "plain floating point, whose rounding is not accounted for".to_owned(),
            };
        }
        Guarantee::Estimated {
            reason: format!(
                "{}, stopped after {iterations} iterations when no value changed by \
                 more than {} ({}); this does not bound the error",
                capitalised(context.options.method.term()),
                context.options.epsilon,
                context.options.termination.word()
            ),
        }
    }

    fn complement(_: &f64) -> Option<Bounds> {
        None
    }
}

fn capitalised(words: &str) -> String {
    let mut letters = words.chars();
    let first = letters.next().map(|letter| letter.to_ascii_uppercase());
    first.into_iter().chain(letters).collect()
}

/// [`crate::Method::Exact`].
pub(crate) enum Exact {}

impl Engine for Exact {
    type Entry = Rational;
    type Value = Rational;

    fn indicator(holds: bool) -> Rational {
        exact::indicator(holds)
    }

    fn contrary(value: &Rational) -> Rational {
        exact::indicator(true).sub(value)
    }

    fn mean<'a>(
        transitions: impl Iterator<Item = (&'a Rational, &'a Rational)>,
        _: &Context<'_>,
    ) -> Rational {
        transitions.fold(exact::indicator(false), |sum, (p, value)| {
            sum.add(&p.mul(value))
        })
    }

    fn reachability(
        matrix: &Csr<Rational>,
        sets: &Qualitative,
        context: &Context<'_>,
    ) -> Result<(Vec<Rational>, u64), CheckError> {
        Ok((exact::reachability(matrix, sets, context.options)?, 0))
    }

    fn meets(value: &Rational, comparison: Comparison, bound: &Bound) -> Option<bool> {
        let bound = bound.exact()?;
        Some(match comparison {
            Comparison::Less => value < bound,
            Comparison::LessEqual => value <= bound,
            Comparison::Greater => value > bound,
            Comparison::GreaterEqual => value >= bound,
        })
    }

    fn bounds(value: &Rational) -> Bounds {
        Bounds::literal(&Number::from_rational(value.clone()))
    }

    fn answer(value: &Rational) -> AnswerValue {
        AnswerValue::Exact(value.clone())
    }

    fn guarantee(_: &Rational, _: &Context<'_>, _: u64) -> Guarantee {
        Guarantee::Exact
    }

    fn complement(value: &Rational) -> Option<Bounds> {
        Some(Self::bounds(&Self::contrary(value)))
    }
}
