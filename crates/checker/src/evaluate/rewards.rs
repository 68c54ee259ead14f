//! Expected rewards and long-run shares.

use std::borrow::Cow;

use prism_lang::Arithmetic;
use prism_lang::property::{Horizon, Path, RewardObjective, RewardQuery, StateFormula};
use prism_lang::resolved::ModelType;

use super::Evaluator;
use super::timed::transient_failed;
use crate::amount::Amount;
use crate::answer::CheckError;
use crate::co_safe::CoSafe;
use crate::engine::{Context, Numbers};
use crate::fairness::not_yet;
use crate::long_run;
use crate::product::co_safe_product;
use crate::quotient::Optimal;
use crate::rewards::{self, Part, RewardModel, by_sign};
use crate::rounding::{Bounds, UNIT};
use crate::shape::{letters, read_path};
use crate::transient::{Sum, Transient};

impl<E: Numbers> Evaluator<'_, E> {
    /// The greatest (or least) expected reward in the states `from`.
    pub(super) fn reward(
        &mut self,
        query: &RewardQuery,
        maximise: bool,
        from: &[usize],
    ) -> Result<Vec<E::Amount>, CheckError> {
        let values = self.structure_reward(query, query.structure, maximise, from)?;
        let Some(divisor) = query.divisor else {
            return Ok(values);
        };
        if !self.choices().is_chain() {
            return Err(CheckError::Unsupported(
                "the ratio of two rewards over schedulers cannot be computed yet: use a model without choices"
                    .to_owned(),
            ));
        }
        let divisors = self.structure_reward(query, divisor, maximise, from)?;
        Ok(values
            .iter()
            .zip(&divisors)
            .map(|(value, divisor)| value.div(divisor))
            .collect())
    }

    fn structure_reward(
        &mut self,
        query: &RewardQuery,
        structure: usize,
        maximise: bool,
        from: &[usize],
    ) -> Result<Vec<E::Amount>, CheckError> {
        let by_time = self.reward_model(structure)?;
        self.check_fair(&query.objective, &by_time, maximise)?;
        let optimal = match &query.objective {
            RewardObjective::Reach(target) => {
                let target = self.set(target)?;
                let model = self.per_step(&by_time);
                let context = &self.context;
                rewards::reach::<E>(self.choices(), &model, &target, maximise, context)?
            }
            RewardObjective::Total => {
                let model = self.per_step(&by_time);
                rewards::total::<E>(self.choices(), &model, maximise, &self.context)?
            }
            RewardObjective::LongRun => {
                let solve = |part: &Part<E::Amount>| self.long_run_of(part, maximise);
                by_sign(self.own_choices(), &by_time, solve, Amount::sub)?
            }
            RewardObjective::CoSafe(path) => {
                return self.co_safe(path, &by_time, maximise, from);
            }
            RewardObjective::Cumulative(Horizon::Steps(steps)) => {
                let start = vec![E::Amount::zero(); self.space.num_states()];
                let model = self.per_step(&by_time);
                self.within_steps(Some(&model), start, *steps, from, maximise)?
            }
            RewardObjective::Instantaneous(Horizon::Steps(step)) => {
                self.within_steps(None, by_time.states(), *step, from, maximise)?
            }
            RewardObjective::Cumulative(Horizon::Time(time)) => {
                self.at_time(&by_time, |part| &part.row, time, Sum::Earned, from)?
            }
            RewardObjective::Instantaneous(Horizon::Time(time)) => {
                self.at_time(&by_time, |part| &part.state, time, Sum::Final, from)?
            }
        };
        self.iterations += optimal.iterations;
        let stationary = matches!(
            query.objective,
            RewardObjective::Reach(_) | RewardObjective::Total
        );
        self.scheduler = (stationary && !self.choices().is_chain()).then_some(optimal.scheduler);
        Ok(from
            .iter()
            .map(|state| optimal.values[*state].clone())
            .collect())
    }

    /// Over fair schedulers the least reward before a target is the same, since one that attains it reaches the target
    /// almost surely and may turn fair there; so is what happens within finitely many steps.
    fn check_fair(
        &self,
        objective: &RewardObjective,
        model: &RewardModel<E::Amount>,
        maximise: bool,
    ) -> Result<(), CheckError> {
        if !self.context.options.fair || self.choices().is_chain() {
            return Ok(());
        }
        match objective {
            RewardObjective::Cumulative(_) | RewardObjective::Instantaneous(_) => Ok(()),
            RewardObjective::Reach(_) | RewardObjective::CoSafe(_)
                if !maximise && model.loss.is_none() =>
            {
                Ok(())
            }
            _ => Err(not_yet("this reward")),
        }
    }

    /// The rewards of the model by row: per step, or per unit of time in a `ctmc`.
    pub(super) fn reward_model(
        &self,
        structure: usize,
    ) -> Result<RewardModel<E::Amount>, CheckError> {
        if structure >= self.space.num_rewards() {
            return Err(CheckError::Unsupported(
                "the model has no such reward structure".to_owned(),
            ));
        }
        let found = self.space.rewards(structure);
        let rewards = found.map_err(|error| CheckError::Reward(error.to_string()))?;
        Ok(RewardModel::new(
            self.own_choices(),
            rewards,
            self.context.entry_error,
        ))
    }

    /// What is earned per step: in a `ctmc`, per unit of time over the rate of leaving.
    pub(super) fn per_step<'m>(
        &self,
        model: &'m RewardModel<E::Amount>,
    ) -> Cow<'m, RewardModel<E::Amount>> {
        if self.space.kind != ModelType::Ctmc {
            return Cow::Borrowed(model);
        }
        let leaving: Vec<E::Amount> = (0..self.space.num_states())
            .map(|state| {
                let rates = self.space.matrix.row(state).map(|(_, rate)| rate);
                let (sum, terms) = rates.fold((E::Entry::zero(), 0), |(sum, n), rate| {
                    (sum.add(rate), n + 1)
                });
                let error = self.context.entry_error + f64::from(terms) * UNIT;
                E::Amount::entry(&sum, if E::Entry::EXACT { 0.0 } else { 2.0 * error })
            })
            .collect();
        let divided = |part: &Part<E::Amount>| Part {
            state: part.state.clone(),
            row: part
                .row
                .iter()
                .zip(&leaving)
                .map(|(row, rate)| row.div(rate))
                .collect(),
        };
        Cow::Owned(RewardModel {
            gain: divided(&model.gain),
            loss: model.loss.as_ref().map(divided),
        })
    }

    fn within_steps(
        &self,
        model: Option<&RewardModel<E::Amount>>,
        start: Vec<E::Amount>,
        steps: u64,
        from: &[usize],
        maximise: bool,
    ) -> Result<Optimal<E::Amount>, CheckError> {
        let context = &self.context;
        let choices = self.choices();
        let values = rewards::steps::<E>(choices, model, start, steps, from, maximise, context)?;
        Ok(plain(values))
    }

    /// Rewards at or within a time.
    fn at_time(
        &self,
        model: &RewardModel<E::Amount>,
        of: impl Fn(&Part<E::Amount>) -> &Vec<E::Amount>,
        time: &prism_lang::Number,
        sum: Sum,
        from: &[usize],
    ) -> Result<Optimal<E::Amount>, CheckError> {
        let solve = |part: &Part<E::Amount>| {
            let rates = E::floats(&self.space.matrix).ok_or_else(transient_failed)?;
            let x: Vec<Bounds> = of(part).iter().map(Amount::bounds).collect();
            let transient = Transient {
                rates,
                active: vec![true; x.len()],
                context: &self.context,
                from,
                keys: &|| self.space.keys(),
            };
            let values = transient.solve(&x, &Bounds::literal(time), sum)?;
            Ok(plain(values.into_iter().map(E::from_bounds).collect()))
        };
        by_sign(self.own_choices(), model, solve, Amount::sub)
    }

    fn long_run_of(
        &self,
        part: &Part<E::Amount>,
        maximise: bool,
    ) -> Result<Optimal<E::Amount>, CheckError> {
        let embedded = || self.choices();
        long_run::average::<E>(
            embedded,
            self.own_choices(),
            || self.space.keys(),
            part,
            maximise,
            &self.context,
        )
    }

    /// The share of time spent in states in the long run.
    pub(super) fn long_run(
        &mut self,
        states: &StateFormula,
        from: &[usize],
    ) -> Result<Vec<E::Amount>, CheckError> {
        let number = |holds: bool| {
            if holds {
                E::Amount::one()
            } else {
                E::Amount::zero()
            }
        };
        let row: Vec<E::Amount> = self.set(states)?.into_iter().map(number).collect();
        let part = Part {
            state: row.clone(),
            row,
        };
        let optimal = self.long_run_of(&part, true)?;
        self.iterations += optimal.iterations;
        let probability = |state: &usize| optimal.values[*state].at_most_one();
        Ok(from.iter().map(probability).collect())
    }

    /// The reward before a co-safe formula is decided to hold: on the product with its automaton.
    fn co_safe(
        &mut self,
        path: &Path,
        by_time: &RewardModel<E::Amount>,
        maximise: bool,
        from: &[usize],
    ) -> Result<Vec<E::Amount>, CheckError> {
        let mut sets = Vec::new();
        let formula = read_path(path, &mut sets, &mut |f| self.set(f))?;
        let mut automaton = CoSafe::new(&formula)?;
        let letters = letters(&sets, self.space.num_states());
        let options = self.context.options;
        let product = co_safe_product(self.choices(), &mut automaton, &letters, from, options)?;
        self.product_states = self.product_states.max(Some(product.accepting.len()));
        let model = self.per_step(by_time);
        let model = model.lifted(&product.state, &product.origin);
        let context: &Context<'_> = &self.context;
        let choices = product.choices();
        let optimal = rewards::reach::<E>(choices, &model, &product.accepting, maximise, context)?;
        self.iterations += optimal.iterations;
        self.scheduler = None;
        Ok(product
            .start
            .iter()
            .map(|state| optimal.values[*state].clone())
            .collect())
    }
}

/// Values without a scheduler that is the same at all times.
fn plain<A>(values: Vec<A>) -> Optimal<A> {
    Optimal {
        values,
        scheduler: Vec::new(),
        iterations: 0,
    }
}
