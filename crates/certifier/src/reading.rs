//! A model read anew: its reachable states, by evaluating every command in every state.
//!
//! Definition: the choices of a state are the events of its modules ([`process`](crate::process)). In a `dtmc` they are
//! equally likely, in a `ctmc` they race (probabilities are rates over their sum), in an `mdp` each is a choice. A state
//! without choices stays. Rewards of a step: the state's (in a `ctmc` over the rate of leaving) and the taken transitions'.
//! It starts in the state of the declarations, or in all valuations that satisfy `init ... endinit`. Source: the semantics
//! of the PRISM language. Cost: commands times states, with rationals throughout. Guarantee: exact; there is no table, no
//! packing and no compilation here on purpose.

use num_traits::{One, Signed, Zero};
use prism_lang::resolved::{Init, Model, ModelType};
use prism_lang::{Rational, rational_to_f64};
use rustc_hash::FxHashMap;

use crate::failure::Failure;
use crate::process::{Event, Process};
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

/// Which rewards are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// What is earned, less what is lost.
    All,
    /// What states and transitions earn.
    Gain,
    /// What they lose, as numbers that are not negative.
    Loss,
}

impl Part {
    fn of(self, value: Rational) -> Rational {
        match (self, value.is_negative()) {
            (Self::All, _) | (Self::Gain, false) => value,
            (Self::Loss, true) => -value,
            _ => Rational::zero(),
        }
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
    /// Whether some state or transition earns less than nothing.
    pub loses: bool,
}

/// Most valuations that `init ... endinit` is tried on.
const MOST_CANDIDATES: f64 = 1e7;
/// States between two looks at whether to go on.
const LOOK: usize = 256;

/// Targets with probabilities or rates.
type Outcomes = Vec<(Vec<i64>, Rational)>;

impl Reading {
    /// Reads the states of a model that can be reached, and where a question's target is.
    ///
    /// # Errors
    /// If the model is none, or has a construct that is not read here.
    pub fn new(model: &Model, question: &Question) -> Result<Self, Failure> {
        let mut reading = Self::of(model, question.reward, Part::All, &|| false)?;
        if reading.loses {
            return Err(unsupported("a negative reward"));
        }
        for (number, state) in reading.states.iter().enumerate() {
            let is_deadlock = reading.deadlock[number];
            let is_initial = number < reading.num_initial;
            let is = |formula| holds(formula, model, state, is_initial, is_deadlock);
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
    /// As [`Reading::new`], and [`Failure::Cancelled`] if `cancelled`, which is asked now and then, says so.
    pub fn of(
        model: &Model,
        structure: Option<usize>,
        part: Part,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Self, Failure> {
        let initial = initial_states(model, cancelled)?;
        let process = Process::new(model);
        let mut numbers: FxHashMap<Vec<i64>, usize> = FxHashMap::default();
        for (number, state) in initial.iter().enumerate() {
            numbers.insert(state.clone(), number);
        }
        let mut reading = Self {
            num_initial: initial.len(),
            states: initial,
            choices: Vec::new(),
            deadlock: Vec::new(),
            rate: Vec::new(),
            target: Vec::new(),
            failed: Vec::new(),
            loses: false,
        };
        let mut earned = Earned {
            model,
            structure,
            part,
            loses: false,
        };
        while reading.choices.len() < reading.states.len() {
            let number = reading.choices.len();
            if number.is_multiple_of(LOOK) && cancelled() {
                return Err(Failure::Cancelled);
            }
            let state = reading.states[number].clone();
            let (read, rate) = choices(model, &process, &state, &mut earned)?;
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
                let reward = earned.of(&state, None)?;
                numbered.push(Choice { outcomes, reward });
            }
            reading.choices.push(numbered);
            reading.deadlock.push(is_deadlock);
            reading.rate.push(rate);
        }
        reading.loses = earned.loses;
        Ok(reading)
    }
}

/// Where a model starts; those of a predicate in the order of the variables' values.
fn initial_states(model: &Model, cancelled: &dyn Fn() -> bool) -> Result<Vec<Vec<i64>>, Failure> {
    let predicate = match &model.init {
        Init::Single(state) => return Ok(vec![state.clone()]),
        Init::Predicate(predicate) => predicate,
    };
    let bounds = model.variables.iter().map(|v| v.kind.bounds());
    let bounds: Vec<(i64, i64)> = bounds.collect();
    let size = |(low, high): &(i64, i64)| (*high as f64) - (*low as f64) + 1.0;
    if bounds.iter().map(size).product::<f64>() > MOST_CANDIDATES {
        return Err(unsupported(
            "`init ... endinit` over more than ten million valuations",
        ));
    }
    let mut found = Vec::new();
    let mut state: Vec<i64> = bounds.iter().map(|(low, _)| *low).collect();
    for candidate in 0usize.. {
        if candidate.is_multiple_of(LOOK) && cancelled() {
            return Err(Failure::Cancelled);
        }
        if predicate.eval_bool(&state)? {
            found.push(state.clone());
        }
        // The last variable counts up first.
        let next = (0..state.len()).rfind(|v| state[*v] < bounds[*v].1);
        let Some(next) = next else { break };
        state[next] += 1;
        for (value, (low, _)) in state.iter_mut().zip(&bounds).skip(next + 1) {
            *value = *low;
        }
    }
    match found.is_empty() {
        true => Err(Failure::NoInitialState),
        false => Ok(found),
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
    process: &Process<'_>,
    state: &[i64],
    earned: &mut Earned<'_>,
) -> Result<(Vec<(Outcomes, Rational)>, Rational), Failure> {
    let mut found = Vec::new();
    for event in process.events(state)? {
        let outcomes = outcomes(model, state, &event)?;
        if outcomes.iter().any(|(_, p)| !p.is_zero()) {
            found.push((outcomes, earned.of(state, Some(event.action))?));
        }
    }
    let own = earned.of(state, None)?;
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
    structure: usize,
    part: Part,
) -> Result<Rational, Failure> {
    let mut earned = Earned {
        model,
        structure: Some(structure),
        part,
        loses: false,
    };
    earned.of(state, None)
}

/// What is read of a reward structure.
struct Earned<'m> {
    model: &'m Model,
    structure: Option<usize>,
    part: Part,
    loses: bool,
}

impl Earned<'_> {
    /// What the state earns (`None`), or a transition with this action.
    fn of(&mut self, state: &[i64], of: Option<Option<usize>>) -> Result<Rational, Failure> {
        let mut sum = Rational::zero();
        let items = self
            .structure
            .and_then(|index| self.model.rewards.get(index));
        for item in items.iter().flat_map(|structure| &structure.items) {
            if item.transition == of && item.guard.eval_bool(state)? {
                let value: Rational = item.value.eval_number(state)?;
                sum += value;
            }
        }
        self.loses |= sum.is_negative();
        Ok(self.part.of(sum))
    }
}
