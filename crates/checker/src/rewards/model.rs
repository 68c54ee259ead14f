//! The rewards of a state space as what each choice earns.
//!
//! Positive and negative rewards are kept apart, so that sums have small relative errors. Guarantee: the
//! relative error of each number covers that of the model's rewards and probabilities and of the sums here.

use prism_lang::Arithmetic;

use crate::amount::Amount;
use crate::choices::Choices;
use crate::rounding::UNIT;
use crate::state_space::{Rewards, TransitionRewards};

/// Rewards that are not negative.
#[derive(Debug, Clone)]
pub(crate) struct Part<A> {
    /// What a state earns: per step, or per unit of time in continuous time.
    pub state: Vec<A>,
    /// What a choice earns in all, for each row of the matrix: per step.
    pub row: Vec<A>,
}

impl<A: Amount> Part<A> {
    /// Whether a choice earns exactly nothing.
    pub fn is_free(&self, row: usize) -> bool {
        self.row[row] == A::zero()
    }
}

/// What is earned, less what is lost.
#[derive(Debug, Clone)]
pub(crate) struct RewardModel<A> {
    pub gain: Part<A>,
    /// Missing if no reward is negative.
    pub loss: Option<Part<A>>,
}

impl<A: Amount> RewardModel<A> {
    /// From a reward structure; `choices` has the model's probabilities, or rates.
    ///
    /// In a chain with rates, a row earns what the state and its transitions earn per unit of time.
    pub fn new(
        choices: Choices<'_, A::Entry>,
        rewards: &Rewards<A::Entry>,
        entry_error: f64,
    ) -> Self {
        let zero = <A::Entry as Arithmetic>::zero();
        let is_negative = |value: &A::Entry| *value < zero;
        let transitions = match &rewards.transition {
            TransitionRewards::None => &[][..],
            TransitionRewards::Row(values) | TransitionRewards::Entry(values) => values,
        };
        let loses = rewards.state.iter().chain(transitions).any(is_negative);
        Self {
            gain: part(choices, rewards, false, entry_error),
            loss: loses.then(|| part(choices, rewards, true, entry_error)),
        }
    }

    /// What each choice earns, less what it loses.
    pub fn rows(&self) -> Vec<A> {
        self.difference(|part| &part.row)
    }

    /// What each state earns, less what it loses.
    pub fn states(&self) -> Vec<A> {
        self.difference(|part| &part.state)
    }

    /// The same on a product, of whose states and rows these are the model's; none earns nothing.
    pub fn lifted(&self, state: &[u32], origin: &[Option<usize>]) -> Self {
        let lifted = |part: &Part<A>| Part {
            state: (state.iter())
                .map(|state| part.state[*state as usize].clone())
                .collect(),
            row: (origin.iter())
                .map(|row| row.map_or_else(A::zero, |row| part.row[row].clone()))
                .collect(),
        };
        Self {
            gain: lifted(&self.gain),
            loss: self.loss.as_ref().map(lifted),
        }
    }

    fn difference(&self, of: impl Fn(&Part<A>) -> &Vec<A>) -> Vec<A> {
        let gain = of(&self.gain);
        match &self.loss {
            None => gain.clone(),
            Some(loss) => gain.iter().zip(of(loss)).map(|(a, b)| a.sub(b)).collect(),
        }
    }
}

fn part<A: Amount>(
    choices: Choices<'_, A::Entry>,
    rewards: &Rewards<A::Entry>,
    negative: bool,
    entry_error: f64,
) -> Part<A> {
    let zero = <A::Entry as Arithmetic>::zero();
    let side = |value: &A::Entry| match (*value < zero, negative) {
        (true, true) => zero.sub(value),
        (false, false) => value.clone(),
        _ => zero.clone(),
    };
    let exact = <A::Entry as Arithmetic>::EXACT;
    let of_row = |state: usize, row: usize| {
        let own = side(&rewards.state[state]);
        let (sum, terms) = match &rewards.transition {
            TransitionRewards::None => (own, 0),
            TransitionRewards::Row(values) => (own.add(&side(&values[row])), 1),
            TransitionRewards::Entry(values) => {
                let range = choices.entries(row);
                let pairs = choices.matrix.value[range.clone()]
                    .iter()
                    .zip(&values[range.clone()]);
                let sum = pairs.fold(own, |sum, (p, value)| sum.add(&p.mul(&side(value))));
                (sum, range.len())
            }
        };
        let error = match terms {
            _ if exact => 0.0,
            0 => rewards.relative_error,
            terms => 2.0 * (rewards.relative_error + entry_error + (terms + 2) as f64 * UNIT),
        };
        A::entry(&sum, error)
    };
    let states = 0..choices.num_states();
    Part {
        state: (rewards.state.iter())
            .map(|value| {
                A::entry(
                    &side(value),
                    if exact { 0.0 } else { rewards.relative_error },
                )
            })
            .collect(),
        row: states
            .flat_map(|s| choices.rows(s).map(move |row| (s, row)))
            .map(|(s, r)| of_row(s, r))
            .collect(),
    }
}
