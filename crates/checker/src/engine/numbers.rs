//! What the techniques do with numbers other than probabilities in chains: rewards, and what schedulers prefer.

use prism_lang::Rational;

use super::{Context, Engine, Exact, Plain, Sound, UNKNOWN_ENTRY_ERROR};
use crate::amount::{Amount, Extended};
use crate::answer::{CheckError, Guarantee};
use crate::choices::Choices;
use crate::method::Method;
use crate::optimum::sound::Equations;
use crate::optimum::{self, Problem, Solution};
use crate::rounding::Bounds;
use crate::sound::Probability;
use crate::state_space::Csr;
use crate::steps::Back;

/// A technique that can optimise, and knows more numbers than probabilities.
pub(crate) trait Numbers: Engine {
    /// Rewards and other numbers.
    type Amount: Amount<Entry = Self::Entry>;

    /// By which method it answers if the options name this one.
    fn method(asked: Method) -> Method;

    /// Solves an optimality problem, of whose values `cap` is an upper bound.
    fn solve(
        problem: &Problem<Self::Entry, Self::Amount>,
        cap: f64,
        context: &Context<'_>,
    ) -> Result<Solution<Self::Amount>, CheckError>;

    /// The same on the states of a model as it is, as [`optimum::sound::Equations`] says; nothing if the technique needs a problem.
    fn solve_states(
        _: Choices<'_, Self::Entry>,
        _: &[Self::Amount],
        _: &dyn Fn(usize) -> Option<Self::Amount>,
        _: bool,
        _: f64,
        _: &Context<'_>,
    ) -> Result<Option<Solution<Self::Amount>>, CheckError> {
        Ok(None)
    }

    /// A probability as a number.
    fn amount(value: &Self::Value) -> Self::Amount;

    /// A number that is a probability.
    fn probability(amount: &Self::Amount) -> Self::Value;

    /// The probability that a scheduler prefers.
    fn best(a: &Self::Value, b: &Self::Value, maximise: bool) -> Self::Value;

    /// Probabilities some steps earlier, in the states asked for; nothing if the technique has no faster way than step by step.
    fn probabilities_back(
        _: &Back<'_, Self::Entry>,
        _: &[Self::Value],
        _: &Context<'_>,
    ) -> Result<Option<Vec<Self::Value>>, CheckError> {
        Ok(None)
    }

    /// Numbers some steps earlier, of which each row adds something if that is given; as above.
    fn amounts_back(
        _: &Back<'_, Self::Entry>,
        _: Option<&[Self::Amount]>,
        _: &[Self::Amount],
        _: &Context<'_>,
    ) -> Result<Option<Vec<Self::Amount>>, CheckError> {
        Ok(None)
    }

    /// The matrix in floating point, if that is what it is in.
    fn floats(matrix: &Csr<Self::Entry>) -> Option<&Csr<f64>>;

    /// A number from bounds, in techniques with floating point.
    fn from_bounds(bounds: Bounds) -> Self::Amount;

    /// The lower or upper bound of a finite number.
    fn entry_of(amount: &Self::Amount, high: bool) -> Self::Entry;

    /// A number between these (not negative), of which each is off by at most this relatively.
    fn between(low: &Self::Entry, high: &Self::Entry, error: f64) -> Self::Amount;

    /// What is known of a number.
    fn guarantee_of(amount: &Self::Amount, context: &Context<'_>, iterations: u64) -> Guarantee;
}

impl Numbers for Sound {
    type Amount = Bounds;

    fn method(asked: Method) -> Method {
        if asked.is_direct() {
            asked
        } else {
            Method::Sound
        }
    }

    fn solve(
        problem: &Problem<f64, Bounds>,
        cap: f64,
        context: &Context<'_>,
    ) -> Result<Solution<Bounds>, CheckError> {
        Equations::of(problem, cap).solve(context)
    }

    fn solve_states(
        choices: Choices<'_, f64>,
        reward: &[Bounds],
        known: &dyn Fn(usize) -> Option<Bounds>,
        maximise: bool,
        cap: f64,
        context: &Context<'_>,
    ) -> Result<Option<Solution<Bounds>>, CheckError> {
        let states = 0..choices.num_states();
        let mut open = vec![false; choices.num_states()];
        let value = |state: usize| {
            known(state).unwrap_or_else(|| {
                open[state] = true;
                Bounds::ZERO
            })
        };
        let values = states.map(value).collect();
        let equations = Equations {
            choices,
            reward,
            open,
            values,
            maximise,
            merged: 0,
            cap,
        };
        equations.solve(context).map(Some)
    }

    fn amount(value: &Probability) -> Bounds {
        value.value
    }

    fn probability(amount: &Bounds) -> Probability {
        Probability::from_value(*amount)
    }

    fn best(a: &Probability, b: &Probability, maximise: bool) -> Probability {
        Probability {
            value: Amount::best(&a.value, &b.value, maximise),
            complement: Amount::best(&a.complement, &b.complement, !maximise),
        }
    }

    fn probabilities_back(
        back: &Back<'_, f64>,
        values: &[Probability],
        context: &Context<'_>,
    ) -> Result<Option<Vec<Probability>>, CheckError> {
        back.probabilities(values, context)
    }

    fn amounts_back(
        back: &Back<'_, f64>,
        rewards: Option<&[Bounds]>,
        values: &[Bounds],
        context: &Context<'_>,
    ) -> Result<Option<Vec<Bounds>>, CheckError> {
        back.amounts(rewards, values, context)
    }

    fn floats(matrix: &Csr<f64>) -> Option<&Csr<f64>> {
        Some(matrix)
    }

    fn from_bounds(bounds: Bounds) -> Bounds {
        bounds
    }

    fn entry_of(amount: &Bounds, high: bool) -> f64 {
        if high { amount.high } else { amount.low }
    }

    fn between(low: &f64, high: &f64, error: f64) -> Bounds {
        let (low, high) = (*low, *high);
        optimum::sound::widened(Bounds { low, high }, error, f64::INFINITY)
    }

    fn guarantee_of(amount: &Bounds, context: &Context<'_>, _: u64) -> Guarantee {
        if !context.entry_error_known {
            return Guarantee::Estimated {
                reason: UNKNOWN_ENTRY_ERROR.to_owned(),
            };
        }
        if amount.is_exact() || amount.is_undefined() {
            return Guarantee::Exact;
        }
        let Bounds { low, high } = *amount;
        Guarantee::Bounded { low, high }
    }
}

impl Numbers for Plain {
    type Amount = f64;

    fn method(asked: Method) -> Method {
        asked
    }

    fn solve(
        problem: &Problem<f64, f64>,
        _: f64,
        context: &Context<'_>,
    ) -> Result<Solution<f64>, CheckError> {
        match context.options.method {
            Method::PrismDefault => optimum::jacobi::solve(problem, context.options),
            _ => optimum::classical::solve(problem, context.options),
        }
    }

    fn amount(value: &f64) -> f64 {
        *value
    }

    fn probability(amount: &f64) -> f64 {
        *amount
    }

    fn best(a: &f64, b: &f64, maximise: bool) -> f64 {
        Amount::best(a, b, maximise)
    }

    fn floats(matrix: &Csr<f64>) -> Option<&Csr<f64>> {
        Some(matrix)
    }

    fn from_bounds(bounds: Bounds) -> f64 {
        bounds.middle()
    }

    fn entry_of(amount: &f64, _: bool) -> f64 {
        *amount
    }

    fn between(low: &f64, _: &f64, _: f64) -> f64 {
        *low
    }

    fn guarantee_of(amount: &f64, context: &Context<'_>, iterations: u64) -> Guarantee {
        Self::guarantee(amount, context, iterations)
    }
}

impl Numbers for Exact {
    type Amount = Extended;

    fn method(_: Method) -> Method {
        Method::Exact
    }

    fn solve(
        problem: &Problem<Rational, Extended>,
        _: f64,
        context: &Context<'_>,
    ) -> Result<Solution<Extended>, CheckError> {
        optimum::exact::solve(problem, context.options)
    }

    fn amount(value: &Rational) -> Extended {
        Extended::Finite(value.clone())
    }

    fn probability(amount: &Extended) -> Rational {
        match amount {
            Extended::Finite(value) => value.clone(),
            // Probabilities are finite.
            _ => crate::exact::indicator(false),
        }
    }

    fn best(a: &Rational, b: &Rational, maximise: bool) -> Rational {
        match maximise {
            true => a.max(b).clone(),
            false => a.min(b).clone(),
        }
    }

    fn floats(_: &Csr<Rational>) -> Option<&Csr<f64>> {
        None
    }

    fn from_bounds(bounds: Bounds) -> Extended {
        // Only asked of techniques with floating point.
        Rational::from_float(bounds.middle()).map_or(Extended::Undefined, Extended::Finite)
    }

    fn entry_of(amount: &Extended, _: bool) -> Rational {
        Self::probability(amount)
    }

    fn between(low: &Rational, _: &Rational, _: f64) -> Extended {
        Extended::Finite(low.clone())
    }

    fn guarantee_of(_: &Extended, _: &Context<'_>, _: u64) -> Guarantee {
        Guarantee::Exact
    }
}
