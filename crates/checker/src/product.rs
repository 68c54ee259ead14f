//! The product of a Markov chain with a deterministic automaton.
//!
//! A state `(s, q)` of the product says that the chain is in `s` and that the automaton, having read the
//! letters of all states so far including `s`, is in `q`. It moves to `(s', q')` with the probability of
//! moving from `s` to `s'`, where `q'` is the automaton's state after the letter of `s'`. Almost surely a path
//! ends up in a bottom component and takes all its transitions infinitely often, so the component accepts
//! or rejects as a whole, and the probability of the formula is that of reaching an accepting one.
//!
//! Source: Vardi 1985, Courcoubetis and Yannakakis 1995; Baier and Katoen 2008, section 10.3. Deviation: where
//! the automaton's verdict is settled, the product stops.
//!
//! Cost: linear in the reachable states and transitions of the product. Guarantee: exact; the values are those
//! of the reachability solver.

use prism_lang::Arithmetic;
use rustc_hash::FxHashMap;
use temporal::automaton::Automaton;

use crate::answer::{CheckError, Options};
use crate::graph::{bottom_components, successors};
use crate::state_space::Csr;

/// Automaton states that stand for a settled verdict.
const SETTLED: [u32; 2] = [u32::MAX - 1, u32::MAX];

/// A product as a reachability problem.
#[derive(Debug, Clone)]
pub(crate) struct Product<N> {
    pub matrix: Csr<N>,
    /// The product state for each of the chain's states asked for.
    pub start: Vec<usize>,
    /// States of accepting bottom components.
    pub accepting: Vec<bool>,
}

struct Builder<'a, N> {
    chain: &'a Csr<N>,
    automaton: &'a mut Automaton,
    letters: &'a [u64],
    states: Vec<(u32, u32)>,
    index: FxHashMap<(u32, u32), u32>,
    limit: usize,
}

/// Builds what is reachable of the product from the states `from`; `letters` has one letter per state.
pub(crate) fn product<N: Arithmetic>(
    chain: &Csr<N>,
    automaton: &mut Automaton,
    letters: &[u64],
    from: &[usize],
    options: &Options<'_>,
) -> Result<Product<N>, CheckError> {
    let mut builder = Builder {
        chain,
        automaton,
        letters,
        states: Vec::new(),
        index: FxHashMap::default(),
        limit: options.product_limit.min(SETTLED[0] as usize),
    };
    let initial = builder.automaton.initial();
    let start = (from.iter())
        .map(|state| Ok(builder.enter(*state, initial)? as usize))
        .collect::<Result<Vec<_>, CheckError>>()?;
    let mut matrix = Csr::with_capacity(chain.num_rows());
    let mut next = 0;
    while next < builder.states.len() {
        if next % 4096 == 0 {
            options.check_cancelled()?;
        }
        matrix.push_row(builder.row(next)?);
        next += 1;
    }
    let accepting = builder.accepting(&matrix)?;
    Ok(Product {
        matrix,
        start,
        accepting,
    })
}

impl<N: Arithmetic> Builder<'_, N> {
    /// The product state reached when the chain enters `state` while the automaton is in `before`.
    fn enter(&mut self, state: usize, before: u32) -> Result<u32, CheckError> {
        let after = self.automaton.step(before, self.letters[state])?.state;
        let after = match self.automaton.decided(after) {
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

    fn row(&mut self, product_state: usize) -> Result<Vec<(u32, N)>, CheckError> {
        let (state, automaton_state) = self.states[product_state];
        if SETTLED.contains(&automaton_state) {
            return Ok(vec![(product_state as u32, N::one())]);
        }
        let chain = self.chain;
        let mut row = (chain.row(state as usize))
            .map(|(target, p)| Ok((self.enter(target, automaton_state)?, p.clone())))
            .collect::<Result<Vec<_>, CheckError>>()?;
        row.sort_unstable_by_key(|(column, _)| *column);
        Ok(row)
    }

    fn accepting(&mut self, matrix: &Csr<N>) -> Result<Vec<bool>, CheckError> {
        let mut accepting = vec![false; matrix.num_rows()];
        for component in bottom_components(matrix) {
            if self.accepts(matrix, &component)? {
                component
                    .iter()
                    .for_each(|state| accepting[*state as usize] = true);
            }
        }
        Ok(accepting)
    }

    fn accepts(&mut self, matrix: &Csr<N>, component: &[u32]) -> Result<bool, CheckError> {
        let mut marks = Vec::new();
        for state in component {
            let (_, automaton_state) = self.states[*state as usize];
            if SETTLED.contains(&automaton_state) {
                return Ok(automaton_state == SETTLED[1]);
            }
            for target in successors(matrix, *state as usize) {
                let (chain_state, _) = self.states[*target as usize];
                let letter = self.letters[chain_state as usize];
                marks.push(self.automaton.step(automaton_state, letter)?.mark);
            }
        }
        marks.sort_unstable();
        marks.dedup();
        Ok(self.automaton.accepts(marks))
    }
}
