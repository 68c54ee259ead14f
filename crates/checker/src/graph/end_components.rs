//! Maximal end components: where a scheduler can stay for ever.
//!
//! *Definition.* An end component is a set of states with, for each, some choices that stay in the set, such
//! that they connect all its states with each other. Maximal ones are disjoint. In a chain they are the bottom
//! strongly connected components.
//!
//! Source: de Alfaro 1997, algorithm 3.1; Baier and Katoen 2008, algorithm 47. Method: strongly connected
//! components; choices that may leave theirs are removed; again until none is. Cost: linear for each round; few
//! rounds on most models. Guarantee: exact.

use super::Components;
use crate::choices::Choices;

/// A maximal end component.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EndComponent {
    /// Its states, ascending.
    pub states: Vec<u32>,
    /// The choices that stay in it, ascending.
    pub rows: Vec<usize>,
}

const OUTSIDE: u32 = u32::MAX;

/// The maximal end components of the states `within`, with choices that are `usable`.
pub fn maximal_end_components<N>(
    choices: Choices<'_, N>,
    within: &[bool],
    usable: impl Fn(usize) -> bool,
) -> Vec<EndComponent> {
    let mut search = Search {
        choices,
        within: within.to_vec(),
        row_on: (0..choices.matrix.num_rows()).map(usable).collect(),
        component: vec![OUTSIDE; within.len()],
    };
    search.drop_what_leaves(|_, target, within| within[target]);
    loop {
        let found = search.components();
        search.component.fill(OUTSIDE);
        for (index, states) in found.iter().enumerate() {
            for state in states {
                search.component[*state as usize] = index as u32;
            }
        }
        let component = std::mem::take(&mut search.component);
        let stays = |from: usize, to: usize, within: &[bool]| {
            within[to] && component[from] == component[to]
        };
        let changed = search.drop_what_leaves(stays);
        search.component = component;
        if !changed {
            return search.collect(&found);
        }
    }
}

struct Search<'a, N> {
    choices: Choices<'a, N>,
    within: Vec<bool>,
    row_on: Vec<bool>,
    component: Vec<u32>,
}

impl<N> Search<'_, N> {
    /// Removes choices with a target for which `stays` does not hold, and states without choices.
    fn drop_what_leaves(&mut self, stays: impl Fn(usize, usize, &[bool]) -> bool) -> bool {
        let mut changed = false;
        for state in 0..self.within.len() {
            if !self.within[state] {
                continue;
            }
            let mut left = false;
            for row in self.choices.rows(state) {
                if !self.row_on[row] {
                    continue;
                }
                let keeps = |target: &u32| stays(state, *target as usize, &self.within);
                let on = self.choices.targets(row).iter().all(keeps);
                self.row_on[row] = on;
                changed |= !on;
                left |= on;
            }
            self.within[state] = left;
            changed |= !left;
        }
        changed
    }

    fn components(&self) -> Components {
        if self.row_on.iter().all(|on| *on) {
            return Components::of_choices(self.choices, &self.within, |_| true);
        }
        let mut entry_on = vec![false; self.choices.matrix.num_entries()];
        for (row, on) in self.row_on.iter().enumerate() {
            entry_on[self.choices.entries(row)].fill(*on);
        }
        Components::of_choices(self.choices, &self.within, |entry| entry_on[entry])
    }

    fn collect(&self, found: &Components) -> Vec<EndComponent> {
        let component = |states: &[u32]| {
            let mut states = states.to_vec();
            states.sort_unstable();
            let rows = states.iter().flat_map(|s| self.choices.rows(*s as usize));
            EndComponent {
                rows: rows.filter(|row| self.row_on[*row]).collect(),
                states,
            }
        };
        let mut all: Vec<EndComponent> = found.iter().map(component).collect();
        all.sort_by_key(|component| component.states[0]);
        all
    }
}
