//! Properties whose values are rational functions of open constants.

use prism_lang::property::{Property, StateFormula};
use prism_lang::{Comparison, Number};

use super::{Evaluator, worst};
use crate::answer::CheckError;
use crate::parametric::amount::FunctionAmount;
use crate::parametric::engine::Parametric;
use crate::parametric::optimise::Cell;

/// What a property asks for, in each initial state.
pub(crate) enum Asked {
    /// Numbers.
    Amounts(Vec<FunctionAmount>),
    /// Numbers that must meet a bound.
    Bounded(Vec<FunctionAmount>, Comparison, Number),
    /// Whether it holds, which is the same everywhere.
    Truths(Vec<bool>),
}

impl<'a> Evaluator<'a, Parametric> {
    /// The answer in the initial states, for all points of a region.
    pub fn functions(
        mut self,
        property: &Property,
        cell: &'a Cell<'a>,
    ) -> Result<Asked, CheckError> {
        self.context.cell = Some(cell);
        let from = self.space.initial_states().to_vec();
        let finite = |values: Vec<_>| values.into_iter().map(FunctionAmount::Finite).collect();
        match property {
            Property::Probability { bound: None, path } => {
                Ok(Asked::Amounts(finite(self.probability(path, true, &from)?)))
            }
            Property::Probability {
                bound: Some((comparison, bound)),
                path,
            } => {
                let values = self.probability(path, worst(*comparison), &from)?;
                Ok(Asked::Bounded(finite(values), *comparison, bound.clone()))
            }
            Property::State(StateFormula::Reward {
                bound: (comparison, bound),
                reward,
            }) => {
                let values = self.reward(reward, worst(*comparison), &from)?;
                Ok(Asked::Bounded(values, *comparison, bound.clone()))
            }
            Property::State(StateFormula::LongRun {
                bound: (comparison, bound),
                states,
            }) => {
                let values = self.long_run(states, &from)?;
                Ok(Asked::Bounded(values, *comparison, bound.clone()))
            }
            Property::State(formula) => Ok(Asked::Truths(self.truths(formula, &from)?)),
            Property::Number(quantity) => Ok(Asked::Amounts(self.numbers(quantity, &from)?)),
            Property::Range(_) | Property::Objectives(_) => Err(CheckError::Unsupported(
                "ranges and several objectives cannot be computed with open constants yet: ask for each \
                 value on its own"
                    .to_owned(),
            )),
        }
    }
}
