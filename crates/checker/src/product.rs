//! The product of a model with a deterministic automaton.
//!
//! A state `(s, q)` of the product says that the model is in `s` and that the automaton, having read the letters
//! of all states so far including `s`, is in `q`. The choices of `s` lead to `(s', q')` with the probability of
//! moving from `s` to `s'`, where `q'` is the automaton's state after the letter of `s'`.
//!
//! *Without choices* a path almost surely ends up in a bottom component and takes all its transitions infinitely
//! often, so the component accepts or rejects as a whole, and the probability of the formula is that of reaching
//! an accepting one. *With choices* the greatest probability is that of reaching an end component with an
//! accepting set of marks. A maximal one that rejects may contain one that accepts: that one must avoid the
//! least priority of some part of the automaton, since with all the same least priorities it would reject too;
//! so each of them is removed in turn, and what remains is searched again. Over fair schedulers only some count
//! ([`crate::fairness`]).
//!
//! Source: Vardi 1985, Courcoubetis and Yannakakis 1995; Baier and Katoen 2008, sections 10.3 and 10.6.4; de
//! Alfaro 1997. Deviation: where the automaton's verdict is settled, the product stops.
//!
//! Cost: linear in the reachable states and transitions of the product; the search is repeated for each
//! combination of priorities removed. Guarantee: exact; the values are those of the reachability solver.

use prism_lang::Arithmetic;
use rustc_hash::FxHashMap;
use temporal::automaton::Automaton;

use crate::answer::{CheckError, Options};
use crate::choices::Choices;
use crate::co_safe::CoSafe;
use crate::fairness::is_complete;
use crate::graph::{EndComponent, end_components_of, maximal_end_components};
use crate::scheduler::tour::{Recurring, covering};
use crate::state_space::Csr;

/// Automaton states that stand for a settled verdict.
const SETTLED: [u32; 2] = [u32::MAX - 1, u32::MAX];

/// A product as a reachability problem.
#[derive(Debug, Clone)]
pub(crate) struct Product<N> {
    pub matrix: Csr<N>,
    /// Where the choices of each state start; empty for chains.
    pub choice_start: Vec<usize>,
    /// The product state for each of the model's states asked for.
    pub start: Vec<usize>,
    /// States of accepting end components.
    pub accepting: Vec<bool>,
    /// The model's state of each state.
    pub state: Vec<u32>,
    /// The automaton's state of each state; one number each for what is settled.
    pub memory: Vec<u32>,
    /// The model's row of each row; `None` where the verdict is settled and the product stops.
    pub origin: Vec<Option<usize>>,
}

impl<N> Product<N> {
    pub fn choices(&self) -> Choices<'_, N> {
        Choices::new(&self.matrix, &self.choice_start)
    }
}

/// A deterministic automaton that is walked together with the model.
pub(crate) trait Reader {
    /// The state before the first letter.
    fn start(&self) -> u32;
    /// The state after a letter.
    fn read(&mut self, state: u32, letter: u64) -> Result<u32, CheckError>;
    /// The verdict, where no letter can change it.
    fn verdict(&self, state: u32) -> Option<bool>;
}

impl Reader for Automaton {
    fn start(&self) -> u32 {
        self.initial()
    }

    fn read(&mut self, state: u32, letter: u64) -> Result<u32, CheckError> {
        Ok(self.step(state, letter)?.state)
    }

    fn verdict(&self, state: u32) -> Option<bool> {
        self.decided(state)
    }
}

struct Builder<'a, N, R> {
    model: Choices<'a, N>,
    automaton: &'a mut R,
    letters: &'a [u64],
    states: Vec<(u32, u32)>,
    index: FxHashMap<(u32, u32), u32>,
    limit: usize,
}

/// Builds what is reachable of the product from the states `from`; `letters` has one letter per state.
pub(crate) fn product<N: Arithmetic>(
    model: Choices<'_, N>,
    automaton: &mut Automaton,
    letters: &[u64],
    from: &[usize],
    options: &Options<'_>,
) -> Result<Product<N>, CheckError> {
    let mut builder = Builder::new(model, automaton, letters, options);
    let mut product = builder.build(from, options)?;
    product.accepting = builder.accepting(&product, options.fair, None)?;
    Ok(product)
}

/// The same, with the accepting end components and what must recur in each.
pub(crate) fn recurring_product<N: Arithmetic>(
    model: Choices<'_, N>,
    automaton: &mut Automaton,
    letters: &[u64],
    from: &[usize],
    options: &Options<'_>,
) -> Result<(Product<N>, Vec<Recurring>), CheckError> {
    let mut builder = Builder::new(model, automaton, letters, options);
    let mut product = builder.build(from, options)?;
    let mut found = Vec::new();
    product.accepting = builder.accepting(&product, options.fair, Some(&mut found))?;
    Ok((product, found))
}

/// The same with the automaton of a co-safe formula; accepting states are those in which it has accepted.
pub(crate) fn co_safe_product<N: Arithmetic>(
    model: Choices<'_, N>,
    automaton: &mut CoSafe,
    letters: &[u64],
    from: &[usize],
    options: &Options<'_>,
) -> Result<Product<N>, CheckError> {
    Builder::new(model, automaton, letters, options).build(from, options)
}

impl<'a, N: Arithmetic, R: Reader> Builder<'a, N, R> {
    fn new(
        model: Choices<'a, N>,
        automaton: &'a mut R,
        letters: &'a [u64],
        options: &Options<'_>,
    ) -> Self {
        Self {
            model,
            automaton,
            letters,
            states: Vec::new(),
            index: FxHashMap::default(),
            limit: options.product_limit.min(SETTLED[0] as usize),
        }
    }

    fn build(&mut self, from: &[usize], options: &Options<'_>) -> Result<Product<N>, CheckError> {
        let initial = self.automaton.start();
        let start = (from.iter())
            .map(|state| Ok(self.enter(*state, initial)? as usize))
            .collect::<Result<Vec<_>, CheckError>>()?;
        let mut matrix = Csr::with_capacity(self.model.num_states());
        let (mut choice_start, mut origin) = (vec![0], Vec::new());
        let mut next = 0;
        while next < self.states.len() {
            if next % 4096 == 0 {
                options.check_cancelled()?;
            }
            self.rows(next, &mut matrix, &mut origin)?;
            choice_start.push(matrix.num_rows());
            next += 1;
        }
        if self.model.is_chain() {
            choice_start.clear();
        }
        let accepted = |(_, q): &(u32, u32)| *q == SETTLED[1];
        Ok(Product {
            matrix,
            choice_start,
            start,
            accepting: self.states.iter().map(accepted).collect(),
            state: self.states.iter().map(|(state, _)| *state).collect(),
            memory: self.states.iter().map(|(_, memory)| *memory).collect(),
            origin,
        })
    }
}

impl<N: Arithmetic, R: Reader> Builder<'_, N, R> {
    /// The product state reached when the model enters `state` while the automaton is in `before`.
    fn enter(&mut self, state: usize, before: u32) -> Result<u32, CheckError> {
        let after = self.automaton.read(before, self.letters[state])?;
        let after = match self.automaton.verdict(after) {
            Some(verdict) => SETTLED[usize::from(verdict)],
            None => after,
        };
        let key = (state as u32, after);
        if let Some(known) = self.index.get(&key) {
            return Ok(*known);
        }
        if self.states.len() >= self.limit {
            return Err(CheckError::ProductTooLarge { limit: self.limit });
        }
        let id = self.states.len() as u32;
        self.states.push(key);
        self.index.insert(key, id);
        Ok(id)
    }

    fn rows(
        &mut self,
        product_state: usize,
        matrix: &mut Csr<N>,
        origin: &mut Vec<Option<usize>>,
    ) -> Result<(), CheckError> {
        let (state, automaton_state) = self.states[product_state];
        if SETTLED.contains(&automaton_state) {
            matrix.push_row([(product_state as u32, N::one())]);
            origin.push(None);
            return Ok(());
        }
        let model = self.model;
        for choice in model.rows(state as usize) {
            let mut row = (model.matrix.row(choice))
                .map(|(target, p)| Ok((self.enter(target, automaton_state)?, p.clone())))
                .collect::<Result<Vec<_>, CheckError>>()?;
            row.sort_unstable_by_key(|(column, _)| *column);
            matrix.push_row(row);
            origin.push(Some(choice));
        }
        Ok(())
    }
}

impl<N: Arithmetic> Builder<'_, N, Automaton> {
    /// The states of accepting end components; only of those in which a scheduler can be `fair`, if it must.
    /// `found` is given the components, if they are asked for.
    fn accepting(
        &mut self,
        product: &Product<N>,
        fair: bool,
        mut found: Option<&mut Vec<Recurring>>,
    ) -> Result<Vec<bool>, CheckError> {
        let choices = product.choices();
        let owner = choices.owners();
        let mut accepting = vec![false; choices.num_states()];
        let everywhere = vec![true; accepting.len()];
        let mut open = maximal_end_components(choices, &everywhere, |_| true);
        while let Some(component) = open.pop() {
            let state = |s: usize| product.state[s] as usize;
            let must_be_complete = fair && !choices.is_chain();
            if must_be_complete && !is_complete(self.model, &component, state, &product.origin) {
                continue;
            }
            let marks = self.marks(choices, &owner, &component)?;
            if self.accepts(&component, &marks) {
                for state in &component.states {
                    accepting[*state as usize] = true;
                }
                if let Some(found) = &mut found {
                    let recurring = covering(self.automaton, &component.rows, &marks);
                    found.push((component, recurring));
                }
            } else if !choices.is_chain() {
                open.extend(self.within(choices, &component, &marks));
            }
        }
        Ok(accepting)
    }

    /// The marks of each choice of a component.
    fn marks(
        &mut self,
        choices: Choices<'_, N>,
        owner: &[u32],
        component: &EndComponent,
    ) -> Result<Vec<Vec<u32>>, CheckError> {
        let mut all = Vec::with_capacity(component.rows.len());
        for row in &component.rows {
            let (_, automaton_state) = self.states[owner[*row] as usize];
            let mut marks = Vec::new();
            if !SETTLED.contains(&automaton_state) {
                for target in choices.targets(*row) {
                    let (model_state, _) = self.states[*target as usize];
                    let letter = self.letters[model_state as usize];
                    marks.push(self.automaton.step(automaton_state, letter)?.mark);
                }
                marks.sort_unstable();
                marks.dedup();
            }
            all.push(marks);
        }
        Ok(all)
    }

    fn accepts(&self, component: &EndComponent, marks: &[Vec<u32>]) -> bool {
        let (_, automaton_state) = self.states[component.states[0] as usize];
        if SETTLED.contains(&automaton_state) {
            return automaton_state == SETTLED[1];
        }
        let mut all: Vec<u32> = marks.iter().flatten().copied().collect();
        all.sort_unstable();
        all.dedup();
        self.automaton.accepts(all)
    }

    /// The maximal end components of a component that avoid the least priority of some part.
    fn within(
        &self,
        choices: Choices<'_, N>,
        component: &EndComponent,
        marks: &[Vec<u32>],
    ) -> Vec<EndComponent> {
        let mut found = Vec::new();
        let parts = marks
            .iter()
            .flatten()
            .map(|m| self.automaton.priorities(*m).len())
            .max();
        for part in 0..parts.unwrap_or(0) {
            let priority = |mark: &u32| self.automaton.priorities(*mark)[part];
            let Some(least) = marks.iter().flatten().map(priority).min() else {
                continue;
            };
            let avoids = |marks: &Vec<u32>| marks.iter().all(|mark| priority(mark) > least);
            if !marks.iter().any(avoids) {
                continue;
            }
            let usable = |at: usize| avoids(&marks[at]);
            found.extend(end_components_of(choices, component, usable));
        }
        found
    }
}
