//! Maximal end components: where a scheduler can stay for ever.
//!
//! *Definition.* An end component is a set of states with, for each, some choices that stay in the set, such
//! that they connect all its states with each other. Maximal ones are disjoint. In a chain they are the bottom
//! strongly connected components.
//!
//! Source: de Alfaro 1997, algorithm 3.1; Baier and Katoen 2008, algorithm 47. Method: strongly connected
//! components; choices that may leave theirs are removed; again until none is. From the second round on, a state that has
//! lost its last choice takes those that lead to it along, and so on backwards, before components are sought again: else
//! a corridor whose end leads out would lose one state a round. Cost: linear for each round; few rounds on most models.
//! Guarantee: exact.

use super::{Backward, Components};
use crate::choices::Choices;
use crate::state_space::Csr;

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
    let (mut is_first, mut backward) = (true, None);
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
        let Some(dropped) = search.drop_what_leaves(stays) else {
            return search.collect(&found);
        };
        search.component = component;
        if !is_first && !dropped.is_empty() {
            let backward = backward.get_or_insert_with(|| Backward::new(choices));
            search.drop_what_leads_to(dropped, backward);
        }
        is_first = false;
    }
}

/// The maximal end components within an end component, with those of its choices (by their places in it) that are `usable`; costs
/// no more than that component.
pub(crate) fn end_components_of<N>(
    choices: Choices<'_, N>,
    component: &EndComponent,
    usable: impl Fn(usize) -> bool,
) -> Vec<EndComponent> {
    let place = |state: &u32| component.states.binary_search(state).unwrap_or(usize::MAX);
    let mut matrix: Csr<()> = Csr::with_capacity(component.rows.len());
    let mut choice_start = Vec::with_capacity(component.states.len() + 1);
    for state in &component.states {
        choice_start.push(matrix.num_rows());
        let first = choices.rows(*state as usize).start;
        let own = component
            .rows
            .iter()
            .skip(component.rows.partition_point(|row| *row < first));
        let end = choices.rows(*state as usize).end;
        for row in own.take_while(|row| **row < end) {
            let targets = choices.targets(*row).iter();
            matrix.push_row(targets.map(|target| (place(target) as u32, ())));
        }
    }
    choice_start.push(matrix.num_rows());
    let everywhere = vec![true; component.states.len()];
    let local = Choices::new(&matrix, &choice_start);
    let global = |found: EndComponent| EndComponent {
        states: (found.states.iter().map(|s| component.states[*s as usize])).collect(),
        rows: found.rows.iter().map(|row| component.rows[*row]).collect(),
    };
    let found = maximal_end_components(local, &everywhere, usable);
    found.into_iter().map(global).collect()
}

struct Search<'a, N> {
    choices: Choices<'a, N>,
    within: Vec<bool>,
    row_on: Vec<bool>,
    component: Vec<u32>,
}

impl<N> Search<'_, N> {
    /// Removes choices with a target for which `stays` does not hold, and states without choices; the states that were removed,
    /// if anything was.
    fn drop_what_leaves(
        &mut self,
        stays: impl Fn(usize, usize, &[bool]) -> bool,
    ) -> Option<Vec<u32>> {
        let (mut changed, mut dropped) = (false, Vec::new());
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
            if !left {
                dropped.push(state as u32);
            }
        }
        (changed || !dropped.is_empty()).then_some(dropped)
    }

    /// Removes choices that lead to removed states, and states that have none left, until all choices stay.
    fn drop_what_leads_to(&mut self, mut dropped: Vec<u32>, backward: &Backward) {
        while let Some(state) = dropped.pop() {
            for row in backward.rows_into(state as usize) {
                let (row, owner) = (*row as usize, backward.owner[*row as usize]);
                let from = owner as usize;
                if std::mem::replace(&mut self.row_on[row], false)
                    && self.within[from]
                    && !self.choices.rows(from).any(|row| self.row_on[row])
                {
                    self.within[from] = false;
                    dropped.push(owner);
                }
            }
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A corridor of which each place may fall back to the first, may go on, and whose last place leads out for good; the first
    /// two places have a choice to go to and fro.
    #[test]
    fn a_corridor_that_leads_out_unravels_from_its_end() {
        const LENGTH: u32 = 40;
        let (mut rows, mut start) = (Vec::new(), vec![0]);
        for place in 0..LENGTH {
            match place {
                0 => rows.push(vec![(1, 1.0)]),
                1 => rows.push(vec![(0, 1.0)]),
                _ => {}
            }
            rows.push(vec![(0, 0.5), (place + 1, 0.5)]);
            start.push(rows.len());
        }
        rows.push(vec![(LENGTH, 1.0)]);
        start.push(rows.len());
        let matrix = Csr::from_rows(rows);
        let everywhere = vec![true; LENGTH as usize + 1];
        let found = maximal_end_components(Choices::new(&matrix, &start), &everywhere, |_| true);
        let of = |states: &[u32], rows: &[usize]| EndComponent {
            states: states.to_vec(),
            rows: rows.to_vec(),
        };
        let last = matrix.num_rows() - 1;
        assert_eq!(found, [of(&[0, 1], &[0, 1, 2]), of(&[LENGTH], &[last])]);
    }
}
