//! A model read anew: its reachable states, by evaluating every command in every state.
//!
//! Definition: the choices of a state are its enabled commands without action and, for each action, every way to take one
//! enabled command of each module that has commands with it. In a `dtmc` they are equally likely, in a `ctmc` they race
//! (probabilities are rates over their sum), in an `mdp` each is a choice. A state without choices stays. Rewards
//! of a step: the state's (in a `ctmc` over the rate of leaving) and the taken transitions'. Source: the semantics of the
//! PRISM language. Cost: commands times states, with rationals throughout. Guarantee: exact; there is no table, no packing
//! and no compilation here on purpose.

use num_traits::{One, Signed, Zero};
use prism_lang::resolved::{Command, Init, Model, ModelType};
use prism_lang::{Rational, rational_to_f64};
use rustc_hash::FxHashMap;

use crate::failure::Failure;
use crate::question::{Question, holds, unsupported};

/// One way to go on, or a chain's only one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choice {
    /// Targets, ascending, with positive probabilities that sum to 1.
    pub outcomes: Vec<(usize, Rational)>,
    /// What is earned by the step.
    pub reward: Rational,
}

impl Choice {
    /// Whether the outcomes are these, to within rounding.
    pub(crate) fn is_like(&self, outcomes: &[(usize, f64)]) -> bool {
        let pairs = || self.outcomes.iter().zip(outcomes);
        let close = |(a, b): (&(usize, Rational), &(usize, f64))| {
            a.0 == b.0 && (rational_to_f64(&a.1) - b.1).abs() < 1e-9
        };
        self.outcomes.len() == outcomes.len() && pairs().all(close)
    }
}

/// The states and their choices.
#[derive(Clone, Debug)]
pub struct Reading {
    /// The values of the variables in each state; initial states come first.
    pub states: Vec<Vec<i64>>,
    /// How many are initial.
    pub num_initial: usize,
    /// The choices of each state.
    pub choices: Vec<Vec<Choice>>,
    /// Where nothing is enabled.
    pub deadlock: Vec<bool>,
    /// The rate of leaving each state, in continuous time (of a deadlock 1); 1 in discrete time.
    pub rate: Vec<Rational>,
    /// Where the target is reached.
    pub target: Vec<bool>,
    /// Where it can no longer be: neither it nor what must hold before holds.
    pub failed: Vec<bool>,
}

/// States between two looks at whether to go on.
const LOOK: usize = 256;

/// What happens at once: the commands taken, with the action if there is one.
struct Event<'m> {
    action: Option<usize>,
    commands: Vec<&'m Command>,
}

/// Targets with probabilities or rates.
type Outcomes = Vec<(Vec<i64>, Rational)>;

impl Reading {
    /// Reads the states of a model that can be reached, and where a question's target is.
    ///
    /// # Errors
    /// If the model is none, or has a construct that is not read here.
    pub fn new(model: &Model, question: &Question) -> Result<Self, Failure> {
        let mut reading = Self::of(model, question.reward, &|| true)?;
        for (number, state) in reading.states.iter().enumerate() {
            let is_deadlock = reading.deadlock[number];
            let is = |formula| holds(formula, model, state, number == 0, is_deadlock);
            let target = is(&question.right)?;
            let waits = question.left.as_ref().map_or(Ok(true), is)?;
            reading.target.push(target);
            reading.failed.push(!target && !waits);
        }
        Ok(reading)
    }

    /// Reads the states of a model that can be reached, with what each step earns of a reward structure.
    ///
    /// # Errors
    /// As [`Reading::new`], and [`Failure::Cancelled`] if `go_on`, which is asked now and then, says no.
    pub fn of(
        model: &Model,
        structure: Option<usize>,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Self, Failure> {
        if model.composition.is_some() {
            return Err(unsupported("a model with `system ... endsystem`"));
        }
        let Init::Single(initial) = &model.init else {
            return Err(unsupported("a model with `init ... endinit`"));
        };
        let mut reading = Self {
            states: vec![initial.clone()],
            num_initial: 1,
            choices: Vec::new(),
            deadlock: Vec::new(),
            rate: Vec::new(),
            target: Vec::new(),
            failed: Vec::new(),
        };
        let mut numbers: FxHashMap<Vec<i64>, usize> = FxHashMap::default();
        numbers.insert(initial.clone(), 0);
        while reading.choices.len() < reading.states.len() {
            let number = reading.choices.len();
            if number.is_multiple_of(LOOK) && !go_on() {
                return Err(Failure::Cancelled);
            }
            let state = reading.states[number].clone();
            let (read, rate) = choices(model, &state, structure)?;
            let mut number_of = |target: Vec<i64>| {
                let next = reading.states.len();
                *numbers.entry(target).or_insert_with_key(|target| {
                    reading.states.push(target.clone());
                    next
                })
            };
            let mut numbered = Vec::with_capacity(read.len());
            for (outcomes, reward) in &read {
                let outcomes = outcomes
                    .iter()
                    .map(|(t, p)| (number_of(t.clone()), p.clone()));
                let outcomes = merged(outcomes.collect());
                let reward = reward.clone();
                numbered.push(Choice { outcomes, reward });
            }
            let is_deadlock = numbered.is_empty();
            if is_deadlock {
                let outcomes = vec![(number, Rational::one())];
                let reward = state_reward(model, &state, structure)?;
                numbered.push(Choice { outcomes, reward });
            }
            reading.choices.push(numbered);
            reading.deadlock.push(is_deadlock);
            reading.rate.push(rate);
        }
        Ok(reading)
    }
}

fn merged<T: Ord>(mut outcomes: Vec<(T, Rational)>) -> Vec<(T, Rational)> {
    outcomes.sort_by(|a, b| a.0.cmp(&b.0));
    outcomes.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += std::mem::take(&mut next.1);
        }
        same
    });
    outcomes.retain(|(_, p)| !p.is_zero());
    outcomes
}

/// The choices of a state, with what each step earns; none in a deadlock.
fn choices(
    model: &Model,
    state: &[i64],
    structure: Option<usize>,
) -> Result<(Vec<(Outcomes, Rational)>, Rational), Failure> {
    let mut found = Vec::new();
    for event in events(model, state)? {
        let outcomes = outcomes(model, state, &event)?;
        let earned = reward(model, state, structure, Some(event.action))?;
        if outcomes.iter().any(|(_, p)| !p.is_zero()) {
            found.push((outcomes, earned));
        }
    }
    let own = state_reward(model, state, structure)?;
    match model.model_type {
        _ if found.is_empty() => Ok((found, Rational::one())),
        ModelType::Mdp | ModelType::Lts => {
            found.iter_mut().for_each(|(_, earned)| *earned += &own);
            Ok((found, Rational::one()))
        }
        kind => {
            // Rates race; in discrete time all choices are equally likely.
            let total: Rational = match kind {
                ModelType::Ctmc => found
                    .iter()
                    .flat_map(|(o, _)| o)
                    .map(|(_, rate)| rate)
                    .sum(),
                _ => Rational::from_integer(found.len().into()),
            };
            let mut sum = match kind {
                ModelType::Ctmc => own / &total,
                _ => own,
            };
            let mut all = Vec::new();
            for (outcomes, earned) in found {
                for (target, p) in outcomes {
                    let p = p / &total;
                    sum += &p * &earned;
                    all.push((target, p));
                }
            }
            let rate = match kind {
                ModelType::Ctmc => total,
                _ => Rational::one(),
            };
            Ok((vec![(all, sum)], rate))
        }
    }
}

/// What can happen in a state.
fn events<'m>(model: &'m Model, state: &[i64]) -> Result<Vec<Event<'m>>, Failure> {
    let mut events = Vec::new();
    for command in model.modules.iter().flat_map(|m| &m.commands) {
        if command.action.is_none() && command.guard.eval_bool(state)? {
            events.push(Event {
                action: None,
                commands: vec![command],
            });
        }
    }
    for action in 0..model.actions.len() {
        let mut ways: Vec<Vec<&Command>> = vec![Vec::new()];
        let mut taking_part = 0;
        for module in &model.modules {
            let own = |c: &&'m Command| c.action == Some(action);
            let commands: Vec<&Command> = module.commands.iter().filter(own).collect();
            if commands.is_empty() {
                continue;
            }
            taking_part += 1;
            let mut longer = Vec::new();
            for command in commands {
                if command.guard.eval_bool(state)? {
                    for way in &ways {
                        let mut way = way.clone();
                        way.push(command);
                        longer.push(way);
                    }
                }
            }
            ways = longer;
        }
        if taking_part > 0 {
            let event = |commands| Event {
                action: Some(action),
                commands,
            };
            events.extend(ways.into_iter().map(event));
        }
    }
    Ok(events)
}

/// The products of the updates of an event's commands.
fn outcomes(model: &Model, state: &[i64], event: &Event<'_>) -> Result<Outcomes, Failure> {
    let mut outcomes: Outcomes = vec![(state.to_vec(), Rational::one())];
    for command in &event.commands {
        let mut longer = Vec::new();
        let mut total = Rational::zero();
        for update in &command.updates {
            let p: Rational = update.probability.eval_number(state)?;
            if p.is_negative() {
                return Err(Failure::Model(format!(
                    "in the state {state:?} a probability is negative"
                )));
            }
            total += &p;
            for (target, before) in &outcomes {
                let mut target = target.clone();
                for (variable, value) in &update.assignments {
                    let value = match value.ty {
                        prism_lang::ast::Type::Bool => i64::from(value.eval_bool(state)?),
                        _ => value.eval_int(state)?,
                    };
                    let (low, high) = model.variables[*variable].kind.bounds();
                    if value < low || value > high {
                        let name = &model.variables[*variable].name;
                        let what = format!("in the state {state:?}, `{name}` leaves its range");
                        return Err(Failure::Model(what));
                    }
                    target[*variable] = value;
                }
                longer.push((target, before * &p));
            }
        }
        if model.model_type != ModelType::Ctmc && !total.is_one() {
            let what = format!("in the state {state:?} probabilities do not sum to 1");
            return Err(Failure::Model(what));
        }
        outcomes = longer;
    }
    Ok(merged(outcomes))
}

pub(crate) fn state_reward(
    model: &Model,
    state: &[i64],
    structure: Option<usize>,
) -> Result<Rational, Failure> {
    reward(model, state, structure, None)
}

/// What the state earns (`None`), or a transition with this action.
fn reward(
    model: &Model,
    state: &[i64],
    structure: Option<usize>,
    of: Option<Option<usize>>,
) -> Result<Rational, Failure> {
    let mut sum = Rational::zero();
    let items = structure.and_then(|index| model.rewards.get(index));
    for item in items.iter().flat_map(|structure| &structure.items) {
        if item.transition == of && item.guard.eval_bool(state)? {
            let value: Rational = item.value.eval_number(state)?;
            if value.is_negative() {
                return Err(unsupported("a negative reward"));
            }
            sum += value;
        }
    }
    Ok(sum)
}
