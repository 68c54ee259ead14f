//! The technique whose numbers are rational functions of the model's open constants.
//!
//! *Method.* The same equations as in rational arithmetic, component by component in topological order, solved by
//! state elimination ([`crate::elimination`]): what is divided by is a sum of transitions, which is positive wherever
//! all transitions are. So one elimination holds for all points at which the model has the same graph. Source: Daws
//! 2004, "Symbolic and Parametric Model Checking of Discrete-Time Markov Chains"; Hahn, Hermanns and Zhang 2010,
//! "Probabilistic Reachability for Parametric Markov Models"; component by component: Jansen et al. 2014. Deviation:
//! the next state is the one with the least product of predecessors and successors, not by a weight of its functions.
//!
//! Guarantee: exact at all points at which every transition's function is positive. What the functions do not decide
//! by being the same everywhere (a bound, the better choice) is not decided here.

use prism_lang::{Arithmetic, Bound, Comparison, Rational};

use super::amount::FunctionAmount;
use super::function::RationalFunction;
use super::optimise;
use crate::amount::Amount;
use crate::answer::{AnswerValue, CheckError, Guarantee};
use crate::elimination::{GivenUp, System};
use crate::engine::{Context, Engine, Numbers};
use crate::graph::{Components, Qualitative};
use crate::method::Method;
use crate::optimum::{Problem, Solution};
use crate::rounding::Bounds;
use crate::state_space::Csr;

/// Rational functions.
pub(crate) enum Parametric {}

/// Functions that exceeded the memory that they may take.
pub(super) fn too_large() -> CheckError {
    CheckError::Unsupported(
        "the rational functions of this model become too large: leave fewer constants open"
            .to_owned(),
    )
}

/// Models in which a scheduler would have to be chosen.
pub(super) fn choices_left() -> CheckError {
    CheckError::Unsupported(
        "which choice is best depends on the open constants in a place where that cannot be found yet: \
         ask for a single probability or reward"
            .to_owned(),
    )
}

impl Engine for Parametric {
    type Entry = RationalFunction;
    type Value = RationalFunction;

    fn indicator(holds: bool) -> RationalFunction {
        match holds {
            true => RationalFunction::one(),
            false => RationalFunction::zero(),
        }
    }

    fn contrary(value: &RationalFunction) -> RationalFunction {
        RationalFunction::one().sub(value)
    }

    fn mean<'a>(
        transitions: impl Iterator<Item = (&'a RationalFunction, &'a RationalFunction)>,
        _: &Context<'_>,
    ) -> RationalFunction {
        transitions.fold(RationalFunction::zero(), |sum, (p, value)| {
            sum.add(&p.mul(value))
        })
    }

    fn reachability(
        matrix: &Csr<RationalFunction>,
        sets: &Qualitative,
        context: &Context<'_>,
    ) -> Result<(Vec<RationalFunction>, u64), CheckError> {
        let surely = sets.surely.iter();
        let mut values: Vec<_> = surely.map(|surely| Self::indicator(*surely)).collect();
        let states = 0..values.len();
        let open: Vec<bool> = states.map(|s| !sets.surely[s] && !sets.never[s]).collect();
        let mut solver = Solver::new(matrix, values.len(), context);
        for component in Components::new(matrix, &open).iter() {
            solver.component(component, &[], &mut values)?;
        }
        Ok((values, 0))
    }

    /// Known where the difference is the same everywhere, and of probabilities that are 0 or 1 nowhere.
    fn meets(value: &RationalFunction, comparison: Comparison, bound: &Bound) -> Option<bool> {
        let bound = bound.exact()?;
        if value.is_too_large() {
            return None;
        }
        if let Some(value) = value.as_constant() {
            return Some(comparison.holds(value, bound));
        }
        // The function is positive and less than 1 where the graph is the same: else it would be constant.
        let between = Rational::new(1.into(), 2.into());
        let is_end = *bound <= Rational::zero() || *bound >= Rational::one();
        is_end.then(|| comparison.holds(&between, bound))
    }

    fn bounds(value: &RationalFunction) -> Bounds {
        Bounds::exactly(value.to_f64())
    }

    fn answer(value: &RationalFunction) -> AnswerValue {
        FunctionAmount::Finite(value.clone()).answer()
    }

    fn guarantee(_: &RationalFunction, _: &Context<'_>, _: u64) -> Guarantee {
        Guarantee::Exact
    }

    fn complement(_: &RationalFunction) -> Option<Bounds> {
        None
    }
}

impl Numbers for Parametric {
    type Amount = FunctionAmount;

    fn method(_: Method) -> Method {
        Method::Exact
    }

    fn solve(
        problem: &Problem<RationalFunction, FunctionAmount>,
        _: f64,
        context: &Context<'_>,
    ) -> Result<Solution<FunctionAmount>, CheckError> {
        optimise::solve(problem, context)
    }

    fn amount(value: &RationalFunction) -> FunctionAmount {
        FunctionAmount::Finite(value.clone())
    }

    fn probability(amount: &FunctionAmount) -> RationalFunction {
        match amount {
            FunctionAmount::Finite(value) => value.clone(),
            // Probabilities are finite.
            _ => RationalFunction::TOO_LARGE,
        }
    }

    fn best(a: &RationalFunction, b: &RationalFunction, maximise: bool) -> RationalFunction {
        let [a, b] = [a, b].map(|value| FunctionAmount::Finite(value.clone()));
        Self::probability(&a.best(&b, maximise))
    }

    fn floats(_: &Csr<RationalFunction>) -> Option<&Csr<f64>> {
        None
    }

    fn from_bounds(_: Bounds) -> FunctionAmount {
        // Only asked of techniques with floating point.
        FunctionAmount::Open
    }

    fn entry_of(amount: &FunctionAmount, _: bool) -> RationalFunction {
        Self::probability(amount)
    }

    fn between(low: &RationalFunction, _: &RationalFunction, _: f64) -> FunctionAmount {
        FunctionAmount::Finite(low.clone())
    }

    fn guarantee_of(_: &FunctionAmount, _: &Context<'_>, _: u64) -> Guarantee {
        Guarantee::Exact
    }
}

/// Solves the equations of one component after the other.
pub(super) struct Solver<'a> {
    matrix: &'a Csr<RationalFunction>,
    context: &'a Context<'a>,
    position: Vec<u32>,
}

impl<'a> Solver<'a> {
    pub(super) fn new(
        matrix: &'a Csr<RationalFunction>,
        states: usize,
        context: &'a Context<'a>,
    ) -> Self {
        Self {
            matrix,
            context,
            position: vec![u32::MAX; states],
        }
    }

    /// Sets the values of a component's states; those outside are known.
    pub(super) fn component(
        &mut self,
        component: &[u32],
        rewards: &[FunctionAmount],
        values: &mut [RationalFunction],
    ) -> Result<(), CheckError> {
        self.context.options.check_cancelled()?;
        for (place, state) in component.iter().enumerate() {
            self.position[*state as usize] = place as u32;
        }
        let mut system: System<RationalFunction, 2> = System {
            rows: Vec::with_capacity(component.len()),
            rhs: Vec::with_capacity(component.len()),
        };
        for (place, state) in component.iter().enumerate() {
            let (entries, rhs) = self.equation(place, *state as usize, rewards, values)?;
            system.rows.push(entries);
            system.rhs.push(rhs);
        }
        let cancelled = || self.context.options.is_cancelled();
        let solution = system
            .solve(u64::MAX, &cancelled)
            .map_err(|why| match why {
                GivenUp::Cancelled => CheckError::Cancelled,
                _ => choices_left(),
            })?;
        for (state, [_, value]) in component.iter().zip(solution.values) {
            if value.is_too_large() {
                return Err(too_large());
            }
            values[*state as usize] = value;
            self.position[*state as usize] = u32::MAX;
        }
        Ok(())
    }

    /// The entries of a row inside the component, and what leads out of it.
    #[allow(clippy::type_complexity)] // The form that a system of equations has.
    fn equation(
        &self,
        place: usize,
        row: usize,
        rewards: &[FunctionAmount],
        values: &[RationalFunction],
    ) -> Result<(Vec<(u32, RationalFunction)>, [RationalFunction; 2]), CheckError> {
        let mut value = match rewards.get(row) {
            None => RationalFunction::zero(),
            Some(FunctionAmount::Finite(reward)) => reward.clone(),
            Some(_) => return Err(choices_left()),
        };
        let (mut entries, mut exit) = (Vec::new(), RationalFunction::zero());
        for (target, p) in self.matrix.row(row) {
            match self.position[target] {
                u32::MAX => {
                    exit = exit.add(p);
                    value = value.add(&p.mul(&values[target]));
                }
                position if position as usize == place => {}
                position => entries.push((position, p.clone())),
            }
        }
        entries.sort_unstable_by_key(|(column, _)| *column);
        Ok((entries, [exit, value]))
    }
}
