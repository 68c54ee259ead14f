//! Deterministic automata of formulas without an unbounded until in negation normal form.
//!
//! Such a formula is a safety property: a word satisfies it iff the tableau has an infinite run on
//! it, and by König's lemma iff the set of obligations reachable by reading a prefix never becomes
//! empty. So the set of sets of obligations is a deterministic state, with `{}` rejecting for ever,
//! and `{{}}` (nothing required) accepting for ever. Only the minimal sets are kept: a set is
//! reached by all the runs of its supersets. The negation of a formula of this kind is a co-safety
//! property; its automaton is this one with acceptance exchanged.
//!
//! Source: Kupferman and Vardi 2001 ("Model checking of safety properties"), section 4. Cost: at most
//! doubly exponential in the formula. Guarantee: exact.

use rustc_hash::FxHashMap;

use super::AutomatonError;
use super::tableau::{Obligations, Tableau, is_subset};

/// A deterministic safety automaton, built while it is walked.
#[derive(Debug, Clone)]
pub(super) struct SafetyAutomaton {
    tableau: Tableau,
    states: Vec<Vec<Obligations>>,
    index: FxHashMap<Vec<Obligations>, u32>,
}

impl SafetyAutomaton {
    /// State 0 is the initial one.
    pub fn new(tableau: Tableau, start: Obligations) -> Self {
        let mut automaton = Self {
            tableau,
            states: Vec::new(),
            index: FxHashMap::default(),
        };
        let start = if automaton.tableau.is_false(&start) {
            Vec::new()
        } else {
            vec![start]
        };
        automaton.intern(start);
        automaton
    }

    fn intern(&mut self, state: Vec<Obligations>) -> u32 {
        if let Some(id) = self.index.get(&state) {
            return *id;
        }
        let id = self.states.len() as u32;
        self.states.push(state.clone());
        self.index.insert(state, id);
        id
    }

    /// The state after reading `letter`.
    pub fn step(
        &mut self,
        state: u32,
        letter: u64,
        state_limit: usize,
    ) -> Result<u32, AutomatonError> {
        let mut next: Vec<Obligations> = Vec::new();
        for obligations in self.states[state as usize].clone() {
            let moves = self.tableau.successors(&obligations, letter);
            next.extend(moves.into_iter().map(|step| step.obligations));
        }
        let next = minimal_sets(next);
        if !self.index.contains_key(&next) && self.states.len() >= state_limit {
            return Err(AutomatonError::TooManyStates { limit: state_limit });
        }
        Ok(self.intern(next))
    }

    /// Whether the words from here on are all accepted (`Some(true)`) or all rejected.
    pub fn decided(&self, state: u32) -> Option<bool> {
        let sets = &self.states[state as usize];
        if sets.is_empty() {
            Some(false)
        } else if sets.iter().any(|set| set.is_empty()) {
            Some(true)
        } else {
            None
        }
    }
}

/// The sets that contain no other one, sorted.
fn minimal_sets(mut sets: Vec<Obligations>) -> Vec<Obligations> {
    sets.sort_by(|a, b| (a.len(), a).cmp(&(b.len(), b)));
    sets.dedup();
    let mut minimal: Vec<Obligations> = Vec::new();
    for set in sets {
        if !minimal.iter().any(|small| is_subset(small, &set)) {
            minimal.push(set);
        }
    }
    minimal
}
