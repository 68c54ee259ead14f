//! Linear temporal logic in a product with machines, as reachability.
//!
//! *Definition.* A state of the product is one of the model and one of each machine, after the letters of all states so
//! far. A path almost surely ends in an end component and visits all of its states infinitely often (a scheduler can); it
//! satisfies the formula iff the marks of these states meet some clause of the condition: all that must recur are there, none
//! that must not. So the greatest probability is that of reaching the union, over the clauses, of the maximal end components
//! without what must not recur that have all that must. The least is that of the contrary.
//!
//! Source: de Alfaro 1997, chapter 4; Baier and Katoen 2008, section 10.6.4. Trusted: [`crate::formula`]. Guarantee: that of
//! reachability, which is shown by inequalities.

use rustc_hash::FxHashMap;

use crate::evaluate::Evaluator;
use crate::explicit::end_components;
use crate::failure::Failure;
use crate::formula::{Condition, Formula, Machine};
use crate::inequalities::Problem;
use crate::interval::Interval;
use crate::question::unsupported;
use crate::reading::{Choice, Reading};

const MOST_STATES: usize = 5_000_000;

/// What is reachable of a product from all states of the model.
pub(crate) struct Product {
    /// The state of each machine, in each state.
    machines: Vec<Vec<usize>>,
    /// The model's state, in each state.
    pub state: Vec<usize>,
    pub choices: Vec<Vec<Choice>>,
    /// Where each state of the model starts.
    pub start: Vec<usize>,
}

impl Product {
    pub fn new(
        model: &[Vec<Choice>],
        machines: &mut [Machine],
        sets: &[Vec<bool>],
    ) -> Result<Self, Failure> {
        if sets.len() > 64 {
            return Err(unsupported("a formula over more than 64 sets of states"));
        }
        let letter = |state: usize| {
            let bits = sets.iter().enumerate();
            bits.fold(0u64, |letter, (bit, set)| {
                letter | u64::from(set[state]) << bit
            })
        };
        let mut index: FxHashMap<(usize, Vec<usize>), usize> = FxHashMap::default();
        let mut states: Vec<(usize, Vec<usize>)> = Vec::new();
        let mut enter = |state: usize,
                         before: &[usize],
                         machines: &mut [Machine],
                         states: &mut Vec<(usize, Vec<usize>)>|
         -> Result<usize, Failure> {
            let letter = letter(state);
            let after = (machines.iter_mut().zip(before))
                .map(|(machine, place)| machine.step(*place, letter))
                .collect::<Result<Vec<_>, _>>()?;
            let new = states.len();
            let number = *index.entry((state, after.clone())).or_insert(new);
            if number == new {
                if new >= MOST_STATES {
                    return Err(unsupported(
                        "a product with an automaton as large as this one",
                    ));
                }
                states.push((state, after));
            }
            Ok(number)
        };
        let before = vec![0; machines.len()];
        let start = (0..model.len())
            .map(|state| enter(state, &before, machines, &mut states))
            .collect::<Result<Vec<_>, _>>()?;
        let mut choices = Vec::new();
        while choices.len() < states.len() {
            let (state, before) = states[choices.len()].clone();
            let mut own = Vec::new();
            for choice in &model[state] {
                let mut outcomes = Vec::with_capacity(choice.outcomes.len());
                for (target, p) in &choice.outcomes {
                    let target = enter(*target, &before, machines, &mut states)?;
                    outcomes.push((target, p.clone()));
                }
                outcomes.sort_unstable_by_key(|(target, _)| *target);
                own.push(Choice {
                    outcomes,
                    reward: choice.reward.clone(),
                });
            }
            choices.push(own);
        }
        Ok(Self {
            state: states.iter().map(|(state, _)| *state).collect(),
            machines: states.into_iter().map(|(_, machines)| machines).collect(),
            choices,
            start,
        })
    }

    /// Where almost all paths, by some scheduler that stays, meet the condition.
    pub fn accepting(&self, condition: &Condition, machines: &[Machine]) -> Vec<bool> {
        self.accepting_by(condition, machines, &|_| true)
    }

    /// The same where only some choices may be used to stay.
    pub fn accepting_by(
        &self,
        condition: &Condition,
        machines: &[Machine],
        usable: &dyn Fn(&Choice) -> bool,
    ) -> Vec<bool> {
        let marked = |state: usize, machine: &usize| {
            machines[*machine].is_marked(self.machines[state][*machine])
        };
        let mut accepting = vec![false; self.choices.len()];
        for clause in condition.clauses() {
            let within: Vec<bool> = (0..accepting.len())
                .map(|state| !clause.not_again.iter().any(|m| marked(state, m)))
                .collect();
            for component in end_components(&self.choices, &within, usable) {
                let recurs = |machine: &usize| component.iter().any(|s| marked(*s, machine));
                if clause.again.iter().all(recurs) {
                    component.iter().for_each(|state| accepting[*state] = true);
                }
            }
        }
        accepting
    }
}

impl Evaluator<'_> {
    /// The probability of a formula in each state.
    pub(crate) fn on_product(
        &mut self,
        formula: &Formula,
        sets: &[Vec<bool>],
        maximise: bool,
    ) -> Result<Vec<Interval>, Failure> {
        let (product, accepting, contrary) = self.product(formula, sets, maximise)?;
        let everywhere = vec![true; accepting.len()];
        let values = self.reached(&product.choices, &everywhere, &accepting, true)?;
        let value = |start: &usize| match contrary {
            true => values[*start].contrary(),
            false => values[*start],
        };
        Ok(product.start.iter().map(value).collect())
    }

    /// The product in which a formula holds iff, in the end, certain states are reached, and which; or its contrary.
    pub(crate) fn product(
        &mut self,
        formula: &Formula,
        sets: &[Vec<bool>],
        maximise: bool,
    ) -> Result<(Product, Vec<bool>, bool), Failure> {
        let contrary = !maximise && !self.is_chain();
        let mut machines = Vec::new();
        let condition = match contrary {
            true => Condition::read(&formula.negated(), &mut machines)?,
            false => Condition::read(formula, &mut machines)?,
        };
        let reading = self.reading()?;
        let product = Product::new(&reading.choices, &mut machines, sets)?;
        let accepting = product.accepting(&condition, &machines);
        Ok((product, accepting, contrary))
    }

    /// What is earned before a co-safe formula is decided to hold.
    pub(crate) fn earned_before(
        &mut self,
        reading: &Reading,
        formula: &Formula,
        sets: &[Vec<bool>],
        maximise: bool,
    ) -> Result<Vec<Interval>, Failure> {
        let Some(machine) = Machine::once(formula)? else {
            return Err(unsupported("a reward before a formula that is not co-safe"));
        };
        let mut machines = [machine];
        let product = Product::new(&reading.choices, &mut machines, sets)?;
        let holds = |place: &Vec<usize>| machines[0].is_marked(place[0]);
        let target: Vec<bool> = product.machines.iter().map(holds).collect();
        let values = self.solved(Problem {
            choices: &product.choices,
            target: &target,
            failed: &vec![false; target.len()],
            is_reward: true,
            maximise,
        })?;
        Ok(product.start.iter().map(|start| values[*start]).collect())
    }
}
