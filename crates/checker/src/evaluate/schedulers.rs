//! The scheduler that attains the value of a question: which technique finds it ([`crate::scheduler::scheduler`]).

use prism_lang::ast::Optimum;
use prism_lang::property::{
    Horizon, Path, Property, Quantity, RewardObjective, RewardQuery, StateFormula,
};
use temporal::automaton::{Automaton, DEFAULT_STATE_LIMIT};
use temporal::ltl::Ltl;

use super::{Evaluator, worst};
use crate::amount::Amount;
use crate::answer::CheckError;
use crate::choices::Choices;
use crate::co_safe::CoSafe;
use crate::engine::Numbers;
use crate::fairness::not_yet;
use crate::graph::NO_ROW;
use crate::product::{Product, co_safe_product, recurring_product};
use crate::reachability;
use crate::rewards::{self, Part, RewardModel};
use crate::rounding::Bounds;
use crate::scheduler::countdown::Countdown;
use crate::scheduler::tour::Tour;
use crate::scheduler::{Meaning, Numbered, Policy, Scheduler, stationary, unfold};
use crate::shape::{Shape, letters, read_path, shape};

impl<E: Numbers> Evaluator<'_, E> {
    /// The scheduler that attains the value of a property.
    pub(crate) fn scheduler_of(mut self, property: &Property) -> Result<Scheduler, CheckError> {
        if self.choices().is_chain() {
            return none("the model leaves nothing to choose");
        }
        if self.context.options.fair {
            return Err(not_yet("schedulers"));
        }
        let is_max = |optimum: &Option<Optimum>| *optimum != Some(Optimum::Min);
        match property {
            Property::Probability { bound, path } => {
                self.path_scheduler(path, bound.as_ref().is_none_or(|(c, _)| worst(*c)))
            }
            Property::State(StateFormula::SomeScheduler(inner)) => {
                self.state_scheduler(inner, true)
            }
            Property::State(formula) => self.state_scheduler(formula, false),
            Property::Number(Quantity::Probability { optimum, path }) => {
                self.path_scheduler(path, is_max(optimum))
            }
            Property::Number(Quantity::Conditional {
                optimum,
                path,
                condition,
            }) => self.conditional_scheduler((path, condition), is_max(optimum)),
            Property::Number(Quantity::Reward { optimum, reward }) => {
                self.reward_scheduler(reward, is_max(optimum))
            }
            Property::Objectives(_) => none(
                "that of several objectives is found in rational arithmetic only: use the exact method",
            ),
            Property::Number(_) | Property::Range(_) => {
                none("the answer is made of several values, each with a scheduler of its own")
            }
        }
    }

    fn state_scheduler(
        &mut self,
        formula: &StateFormula,
        by_some: bool,
    ) -> Result<Scheduler, CheckError> {
        match formula {
            StateFormula::Probability { bound, path } => {
                self.path_scheduler(path, worst(bound.0) != by_some)
            }
            StateFormula::Reward { bound, reward } => {
                self.reward_scheduler(reward, worst(bound.0) != by_some)
            }
            _ => none("no scheduler exists for this outermost operator"),
        }
    }

    fn path_scheduler(&mut self, path: &Path, maximise: bool) -> Result<Scheduler, CheckError> {
        let mut sets = Vec::new();
        let formula = read_path(path, &mut sets, &mut |f| self.set(f))?.simplify();
        match shape(&formula, &sets, self.space.num_states()) {
            None => self.automaton_scheduler(&formula, &sets, maximise),
            Some(Shape::Set(_)) => Ok(Scheduler::ByState(vec![None; self.space.num_states()])),
            Some(Shape::Next { operand, contrary }) => {
                let mut countdown = self.countdown(indicators(&operand), maximise != contrary);
                countdown.steps(1, |_| true, None, self.context.options)?;
                self.unfolded(countdown, |_, _| false, Vec::new())
            }
            Some(Shape::Until {
                left,
                right,
                steps,
                contrary,
            }) => self.until_scheduler(&left, &right, steps, maximise != contrary),
        }
    }

    fn until_scheduler(
        &mut self,
        left: &[bool],
        right: &[bool],
        (first, last): (u64, Option<u64>),
        maximise: bool,
    ) -> Result<Scheduler, CheckError> {
        let values = match last {
            Some(_) => indicators(right),
            None => {
                let values = self.until(left, right, (0, None), None, maximise)?;
                values.iter().map(E::amount).collect()
            }
        };
        let after = match last {
            Some(_) => Vec::new(),
            None => self.found_scheduler().unwrap_or_default(),
        };
        if (first, last) == (0, None) {
            return Ok(Scheduler::ByState(after));
        }
        let options = self.context.options;
        let mut countdown = self.countdown(values, maximise);
        if let Some(last) = last {
            let open = |state: usize| left[state] && !right[state];
            countdown.steps(last.saturating_sub(first), open, None, options)?;
        }
        if first > 0 {
            // `right` counts no sooner; what does not wait has failed.
            countdown.steps(1, |state| left[state], None, options)?;
            countdown.set(&E::Amount::zero(), |state| !left[state]);
            countdown.steps(first - 1, |state| left[state], None, options)?;
        }
        let over = |taken: u64, state: usize| !left[state] || (taken >= first && right[state]);
        self.unfolded(countdown, over, after)
    }

    fn countdown(&self, values: Vec<E::Amount>, maximise: bool) -> Countdown<'_, E::Amount> {
        Countdown::new(self.choices(), values, maximise, self.context.entry_error)
    }

    fn unfolded(
        &self,
        countdown: Countdown<'_, E::Amount>,
        over: impl Fn(u64, usize) -> bool,
        after: Vec<Option<usize>>,
    ) -> Result<Scheduler, CheckError> {
        let mut policy = countdown.policy(over, after);
        self.unfold(&mut policy, Meaning::Steps)
    }

    pub(super) fn unfold(
        &self,
        policy: &mut impl Policy,
        meaning: Meaning,
    ) -> Result<Scheduler, CheckError> {
        let (initial, options) = (self.space.initial_states(), self.context.options);
        unfold(self.choices(), initial, policy, meaning, options).map(Scheduler::WithMemory)
    }

    /// On the product with an automaton, going round in the end components that accept.
    fn automaton_scheduler(
        &mut self,
        formula: &Ltl,
        sets: &[Vec<bool>],
        maximise: bool,
    ) -> Result<Scheduler, CheckError> {
        let formula = match maximise {
            true => formula.clone(),
            false => Ltl::negate(formula.clone()).simplify(),
        };
        let options = self.context.options;
        let limit = options.product_limit.min(DEFAULT_STATE_LIMIT);
        let mut automaton = Automaton::with_state_limit(&formula, limit)?;
        let letters = letters(sets, self.space.num_states());
        let from = self.space.initial_states();
        let (product, recurring) =
            recurring_product(self.choices(), &mut automaton, &letters, from, options)?;
        let tour = Tour::new(product.choices(), recurring);
        let (goal, everywhere) = (tour.goal(), vec![true; product.accepting.len()]);
        let (_, towards, _) = reachability::until::<E>(
            product.choices(),
            &everywhere,
            &goal,
            (0, None),
            None,
            true,
            &self.context,
        )?;
        let mut policy = OnProduct {
            model: self.choices(),
            product: &product,
            towards: towards.unwrap_or_default(),
            tour: Some(tour),
            numbers: Numbered::new(),
        };
        self.unfold(&mut policy, Meaning::Automaton)
    }

    fn reward_scheduler(
        &mut self,
        query: &RewardQuery,
        maximise: bool,
    ) -> Result<Scheduler, CheckError> {
        if query.divisor.is_some() {
            return none("the ratio of two rewards over schedulers cannot be computed yet");
        }
        let model = self.reward_model(query.structure)?;
        let context = &self.context;
        let by_state = |rows: Vec<usize>| {
            let chosen = |row: usize| (row != NO_ROW).then_some(row);
            Scheduler::ByState(rows.into_iter().map(chosen).collect())
        };
        match &query.objective {
            RewardObjective::Reach(target) => {
                let target = self.set(target)?;
                let (choices, context) = (self.choices(), &self.context);
                let found = rewards::reach::<E>(choices, &model, &target, maximise, context)?;
                let mut scheduler = found.scheduler;
                if maximise {
                    stationary::missing(choices, &target, &mut scheduler);
                }
                Ok(by_state(scheduler))
            }
            RewardObjective::Total => {
                let choices = self.choices();
                let found = rewards::total::<E>(choices, &model, maximise, context)?;
                let mut scheduler = found.scheduler;
                match maximise {
                    true => stationary::earning(choices, &model.gain, &mut scheduler),
                    false => stationary::resting(choices, &model.gain, &mut scheduler),
                }
                Ok(by_state(scheduler))
            }
            RewardObjective::CoSafe(path) => self.co_safe_scheduler(path, &model, maximise),
            RewardObjective::LongRun => {
                let Some(matrix) = E::floats(&self.space.matrix) else {
                    return none("averages over schedulers are computed by the sound method only");
                };
                if model.loss.is_some() {
                    return none("negative rewards have no averages over schedulers yet");
                }
                let bounds = |of: &[E::Amount]| of.iter().map(Amount::bounds).collect();
                let part: Part<Bounds> = Part {
                    state: bounds(&model.gain.state),
                    row: bounds(&model.gain.row),
                };
                let choices = Choices::new(matrix, &self.space.choice_start);
                stationary::average(choices, &part, maximise, context).map(by_state)
            }
            RewardObjective::Cumulative(Horizon::Steps(steps)) => {
                let start = vec![E::Amount::zero(); self.space.num_states()];
                let mut countdown = self.countdown(start, maximise);
                countdown.steps(*steps, |_| true, Some(&model.rows()), context.options)?;
                self.unfolded(countdown, |_, _| false, Vec::new())
            }
            RewardObjective::Instantaneous(Horizon::Steps(steps)) => {
                let mut countdown = self.countdown(model.states(), maximise);
                countdown.steps(*steps, |_| true, None, context.options)?;
                self.unfolded(countdown, |_, _| false, Vec::new())
            }
            RewardObjective::Cumulative(Horizon::Time(_))
            | RewardObjective::Instantaneous(Horizon::Time(_)) => {
                none("what happens within a time has no scheduler here")
            }
        }
    }

    fn co_safe_scheduler(
        &mut self,
        path: &Path,
        model: &RewardModel<E::Amount>,
        maximise: bool,
    ) -> Result<Scheduler, CheckError> {
        let mut sets = Vec::new();
        let formula = read_path(path, &mut sets, &mut |f| self.set(f))?;
        let mut automaton = CoSafe::new(&formula)?;
        let letters = letters(&sets, self.space.num_states());
        let (from, options) = (self.space.initial_states(), self.context.options);
        let product = co_safe_product(self.choices(), &mut automaton, &letters, from, options)?;
        let lifted = model.lifted(&product.state, &product.origin);
        let (choices, goal) = (product.choices(), &product.accepting);
        let found = rewards::reach::<E>(choices, &lifted, goal, maximise, &self.context)?;
        let mut towards = found.scheduler;
        if maximise {
            stationary::missing(choices, goal, &mut towards);
        }
        let mut policy = OnProduct {
            model: self.choices(),
            product: &product,
            towards,
            tour: None,
            numbers: Numbered::new(),
        };
        self.unfold(&mut policy, Meaning::Automaton)
    }
}

pub(super) fn none(why: &str) -> Result<Scheduler, CheckError> {
    Err(CheckError::Unsupported(format!(
        "no scheduler was written: {why}"
    )))
}

fn indicators<A: Amount>(set: &[bool]) -> Vec<A> {
    let number = |holds: &bool| if *holds { A::one() } else { A::zero() };
    set.iter().map(number).collect()
}

/// A scheduler of a product with an automaton.
struct OnProduct<'a, N> {
    model: Choices<'a, N>,
    product: &'a Product<N>,
    /// The row in each state of the product, outside of the tour.
    towards: Vec<usize>,
    tour: Option<Tour>,
    numbers: Numbered<(u32, u32)>,
}

/// The verdict is settled.
const OVER: u32 = u32::MAX;

impl<N> OnProduct<'_, N> {
    fn key(&self, state: usize, place: u32) -> (u32, u32) {
        match self.product.origin[self.product.choices().rows(state).start] {
            None => (OVER, 0),
            Some(_) => (state as u32, place),
        }
    }

    fn product_row(&self, (state, place): (u32, u32)) -> usize {
        let state = state as usize;
        let touring = self.tour.as_ref().and_then(|tour| tour.row(state, place));
        touring.unwrap_or_else(|| self.towards.get(state).copied().unwrap_or(NO_ROW))
    }
}

impl<N> Policy for OnProduct<'_, N> {
    type Key = (u32, u32);

    fn first(&mut self, place: usize, _: usize) -> (u32, u32) {
        self.key(self.product.start[place], 0)
    }

    fn row(&mut self, _: usize, key: (u32, u32)) -> Option<usize> {
        if key.0 == OVER {
            return None;
        }
        match self.product_row(key) {
            NO_ROW => None,
            row => self.product.origin[row],
        }
    }

    fn next(&mut self, state: usize, key: (u32, u32), row: usize, target: usize) -> (u32, u32) {
        if key.0 == OVER {
            return key;
        }
        let from = key.0 as usize;
        let place = row - self.model.rows(state).start;
        let row = self.product.choices().rows(from).start + place;
        let to = (self.product.choices().targets(row).iter())
            .find(|to| self.product.state[**to as usize] as usize == target);
        let to = *to.expect("the product has all targets of the model") as usize;
        let next = match &self.tour {
            None => 0,
            Some(tour) => tour.next(from, key.1, row),
        };
        self.key(to, next)
    }

    fn number(&mut self, key: (u32, u32)) -> u32 {
        let memory = match key.0 {
            OVER => OVER,
            state => self.product.memory[state as usize],
        };
        self.numbers.of((memory, key.1))
    }
}
