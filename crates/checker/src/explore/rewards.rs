//! The rewards of states and transitions while they are explored.
//!
//! Definition: see [`Rewards`]. Deviation: none. Cost: one evaluation of each item's guard for each state, and
//! one of its value where the guard holds. Guarantee: each number is rounded once from its exact value, sums and
//! means are counted as roundings ([`Rewards::relative_error`]).

use prism_lang::resolved::{Model, RewardStructure};
use prism_lang::{Arithmetic, Span};

use super::ExploreError;
use super::code::{Code, Compiler};
use super::command::{Probability, Rounded, reward};
use super::fault::{bad_reward, no_value};
use crate::rounding::error_of_roundings;
use crate::state_space::{NO_ACTION, Rewards, RewardsOf, TransitionRewards};

/// An item, compiled.
struct Item<'m, N> {
    /// `None` for a state reward, else the action ([`NO_ACTION`] for none).
    transition: Option<u32>,
    guard: Code,
    guard_source: &'m prism_lang::Expr,
    value: Probability<'m, N>,
    span: Span,
}

/// A reward structure that is being evaluated.
struct Structure<'m, N> {
    source: &'m RewardStructure,
    items: Vec<Item<'m, N>>,
    has_states: bool,
    has_transitions: bool,
    state: Vec<N>,
    transition: Vec<N>,
    roundings: Option<u32>,
    error: Option<ExploreError>,
}

/// All reward structures of a model.
pub(super) struct Builder<'m, N> {
    compiler: Compiler<'m>,
    structures: Vec<Structure<'m, N>>,
}

impl<'m, N: Arithmetic> Builder<'m, N> {
    pub(super) fn new(model: &'m Model, compiler: Compiler<'m>, wanted: Option<&[usize]>) -> Self {
        let structures = model.rewards.iter().enumerate();
        let is_wanted = |index| wanted.is_none_or(|w| w.contains(&index));
        let structure = |(index, s)| Structure::new(s, is_wanted(index), compiler);
        Self {
            structures: structures.map(structure).collect(),
            compiler,
        }
    }

    /// The bytes that the rewards so far take.
    pub(super) fn bytes(&self) -> usize {
        let numbers = self
            .structures
            .iter()
            .map(|s| s.state.len() + s.transition.len());
        numbers.sum::<usize>() * size_of::<N>()
    }

    /// Whether some transition may have a reward.
    pub(super) fn of_transitions(&self) -> bool {
        self.structures.iter().any(|s| s.has_transitions)
    }

    /// Appends the rewards of a state.
    pub(super) fn state(&mut self, state: &[u64]) {
        for structure in self.structures.iter_mut().filter(|s| s.has_states) {
            let sum = structure.sum(None, state, self.compiler);
            structure.roundings = worst(structure.roundings, sum.roundings);
            structure.state.push(sum.value);
        }
    }

    /// Appends the rewards of a row whose transitions all have this action.
    pub(super) fn row(&mut self, action: u32, state: &[u64]) {
        for structure in &mut self.structures {
            if structure.has_transitions {
                let sum = structure.sum(Some(action), state, self.compiler);
                structure.roundings = worst(structure.roundings, sum.roundings);
                structure.transition.push(sum.value);
            }
        }
    }

    /// Appends the rewards of an entry of a chain's matrix: the mean over the actions merged in it.
    pub(super) fn entry(&mut self, merged: &[(u32, N)], state: &[u64]) {
        for structure in &mut self.structures {
            if structure.has_transitions {
                let mean = structure.mean(merged, state, self.compiler);
                structure.roundings = worst(structure.roundings, mean.roundings);
                structure.transition.push(mean.value);
            }
        }
    }

    /// Appends the rewards of a self-loop that was added: none.
    pub(super) fn deadlock(&mut self) {
        for structure in &mut self.structures {
            if structure.has_transitions {
                structure.transition.push(N::zero());
            }
        }
    }

    pub(super) fn finish(self, states: usize, has_choices: bool) -> Vec<RewardsOf<N>> {
        let structures = self.structures.into_iter();
        structures.map(|s| s.finish(states, has_choices)).collect()
    }
}

impl<'m, N: Arithmetic> Structure<'m, N> {
    fn new(source: &'m RewardStructure, wanted: bool, compiler: Compiler<'_>) -> Self {
        let items = source.items.iter().filter(|_| wanted).map(|item| Item {
            transition: item.transition.map(|a| a.map_or(NO_ACTION, |a| a as u32)),
            guard: compiler.code(&item.guard),
            guard_source: &item.guard,
            value: Probability::new(&item.value, compiler),
            span: item.span,
        });
        let items: Vec<Item<'m, N>> = items.collect();
        Self {
            source,
            has_states: items.iter().any(|i| i.transition.is_none()),
            has_transitions: items.iter().any(|i| i.transition.is_some()),
            items,
            state: Vec::new(),
            transition: Vec::new(),
            roundings: Some(0),
            error: (!wanted).then_some(ExploreError::RewardsLeftOut),
        }
    }

    /// The sum of the items for states, or for an action, in a state.
    fn sum(&mut self, of: Option<u32>, state: &[u64], compiler: Compiler<'_>) -> Rounded<N> {
        let mut sum = Rounded {
            value: N::zero(),
            roundings: Some(0),
        };
        if self.error.is_some() {
            return sum;
        }
        for item in self.items.iter_mut().filter(|i| i.transition == of) {
            match item.earned(state, compiler) {
                Ok(None) => {}
                Ok(Some(more)) => sum = plus(sum, more),
                Err(error) => self.error = Some(error),
            }
        }
        sum
    }

    /// The mean reward over actions, weighted with their probabilities.
    fn mean(&mut self, merged: &[(u32, N)], state: &[u64], compiler: Compiler<'_>) -> Rounded<N> {
        if let [(action, _)] = merged {
            return self.sum(Some(*action), state, compiler);
        }
        let of_each: Vec<Rounded<N>> = (merged.iter())
            .map(|(action, _)| self.sum(Some(*action), state, compiler))
            .collect();
        let Some(first) = of_each.first() else {
            return Rounded {
                value: N::zero(),
                roundings: Some(0),
            };
        };
        if of_each.iter().all(|r| r.value == first.value) {
            return first.clone();
        }
        let mut total = N::zero();
        let mut weighted = Rounded {
            value: N::zero(),
            roundings: Some(0),
        };
        for (reward, (_, weight)) in of_each.iter().zip(merged) {
            total = total.add(weight);
            let part = Rounded {
                value: reward.value.mul(weight),
                roundings: reward.roundings.map(|r| r + u32::from(!N::EXACT)),
            };
            weighted = plus(weighted, part);
        }
        // Each weight's own rounding is the matrix's error; the total's and the quotient's come on top.
        let more = 2 * u32::from(!N::EXACT) * (merged.len() as u32 + 2);
        Rounded {
            value: weighted.value.div(&total).unwrap_or_else(N::zero),
            roundings: weighted.roundings.map(|r| r + more),
        }
    }

    fn finish(mut self, states: usize, has_choices: bool) -> RewardsOf<N> {
        let name = self.source.name.clone();
        if let Some(error) = self.error {
            return (name, Err(error));
        }
        let transition = match (self.has_transitions, has_choices) {
            (false, _) => TransitionRewards::None,
            (true, true) => TransitionRewards::Row(self.transition),
            (true, false) => TransitionRewards::Entry(self.transition),
        };
        self.state.resize(states, N::zero());
        let rewards = Rewards {
            state: self.state,
            transition,
            relative_error: error_of_roundings(self.roundings),
        };
        (name, Ok(rewards))
    }
}

impl<N: Arithmetic> Item<'_, N> {
    /// What it earns in a state, if its guard holds.
    fn earned(
        &mut self,
        state: &[u64],
        compiler: Compiler<'_>,
    ) -> Result<Option<Rounded<N>>, ExploreError> {
        let holds = compiler.holds(&self.guard, self.guard_source, state);
        if !holds.map_err(|error| no_value(error, state, compiler))? {
            return Ok(None);
        }
        let value = self.value.value(state, compiler, reward);
        value
            .map(Some)
            .map_err(|bad| bad_reward(bad, self.span, state, compiler))
    }
}

/// A sum; of integers, of a number and 0, or in an exact domain it needs no rounding.
fn plus<N: Arithmetic>(a: Rounded<N>, b: Rounded<N>) -> Rounded<N> {
    if a.value.is_zero() {
        return b;
    }
    if b.value.is_zero() {
        return a;
    }
    let value = a.value.add(&b.value);
    let (x, y) = (a.value.to_f64(), b.value.to_f64());
    let both = worst(a.roundings, b.roundings);
    let is_small = |v: f64| v.fract() == 0.0 && v.abs() < 4.5e15;
    let roundings = if N::EXACT || both == Some(0) && is_small(x) && is_small(y) {
        both
    } else if x.signum() == y.signum() {
        both.map(|r| r + 1)
    } else {
        // Digits may cancel.
        None
    };
    Rounded { value, roundings }
}

fn worst(a: Option<u32>, b: Option<u32>) -> Option<u32> {
    a.zip(b).map(|(a, b)| a.max(b))
}
