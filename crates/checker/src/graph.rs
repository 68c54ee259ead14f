//! The graph under a Markov chain: components, and which states reach a target surely or never.
//!
//! *Components.* A strongly connected component is a maximal set of states that all reach each other; it
//! is *bottom* when no transition leaves it. Tarjan 1972, with an explicit stack instead of recursion.
//! Components come in reverse topological order: each one after all components that it reaches.
//!
//! *Qualitative sets* for `left U right` (Baier and Katoen 2008, section 10.1.1; PRISM's `prob0`, `prob1`):
//!
//! ```text
//! prob0 = states without a path through `left` to `right`        (probability exactly 0)
//! prob1 = states without a path through `left & !right` to prob0  (probability exactly 1)
//! ```
//!
//! Cost: linear in states and transitions, by one backward search each. Guarantee: exact, since only
//! the existence of transitions matters.

mod decision;
mod end_components;

use std::ops::Range;

use crate::choices::Choices;
use crate::state_space::Csr;
pub use decision::qualitative_optimum;
pub(crate) use decision::{Backward, NO_ROW, Optimum, optimum};
pub(crate) use end_components::end_components_of;
pub use end_components::{EndComponent, maximal_end_components};

/// For each state, its predecessors.
#[derive(Debug, Clone)]
pub struct Predecessors {
    row_start: Vec<usize>,
    state: Vec<u32>,
}

impl Predecessors {
    /// The predecessors in the graph of `matrix`.
    pub fn new<N>(matrix: &Csr<N>) -> Self {
        let states = matrix.num_rows();
        let mut row_start = vec![0; states + 1];
        for column in &matrix.column {
            row_start[*column as usize + 1] += 1;
        }
        for state in 0..states {
            row_start[state + 1] += row_start[state];
        }
        let mut next = row_start.clone();
        let mut state = vec![0; matrix.num_entries()];
        for row in 0..states {
            for column in successors(matrix, row) {
                state[next[*column as usize]] = row as u32;
                next[*column as usize] += 1;
            }
        }
        Self { row_start, state }
    }

    /// The predecessors of a state, ascending.
    fn of(&self, state: usize) -> &[u32] {
        &self.state[self.row_start[state]..self.row_start[state + 1]]
    }

    /// The states from which `targets` can be reached, all states but the last one being in `through`;
    /// `targets` themselves included.
    pub fn reaching(&self, targets: &[bool], through: impl Fn(usize) -> bool) -> Vec<bool> {
        let mut reaches = targets.to_vec();
        let mut stack: Vec<usize> = (0..targets.len()).filter(|s| targets[*s]).collect();
        while let Some(state) = stack.pop() {
            for predecessor in self.of(state) {
                let predecessor = *predecessor as usize;
                if !reaches[predecessor] && through(predecessor) {
                    reaches[predecessor] = true;
                    stack.push(predecessor);
                }
            }
        }
        reaches
    }
}

/// The columns of a row.
pub(crate) fn successors<N>(matrix: &Csr<N>, row: usize) -> &[u32] {
    &matrix.column[matrix.row_start[row]..matrix.row_start[row + 1]]
}

/// The states in which `left U right` has probability exactly 0 and exactly 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Qualitative {
    /// Probability 0.
    pub never: Vec<bool>,
    /// Probability 1.
    pub surely: Vec<bool>,
}

/// Finds the qualitative sets of `left U right`.
pub fn qualitative<N>(matrix: &Csr<N>, left: &[bool], right: &[bool]) -> Qualitative {
    let predecessors = Predecessors::new(matrix);
    let possible = predecessors.reaching(right, |state| left[state]);
    let never: Vec<bool> = possible.iter().map(|possible| !possible).collect();
    let avoidable = predecessors.reaching(&never, |state| left[state] && !right[state]);
    let surely = avoidable.iter().map(|avoidable| !avoidable).collect();
    Qualitative { never, surely }
}

/// Strongly connected components, in reverse topological order; the states of each in the order in which a depth-first search
/// leaves them, so that a state comes after all to which it leads but for those on the way back to it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Components {
    /// States, component by component.
    states: Vec<u32>,
    /// Where each component starts in `states`, and the end.
    start: Vec<usize>,
}

impl Components {
    /// The components of the subgraph of the states for which `within` holds.
    pub fn new<N>(matrix: &Csr<N>, within: &[bool]) -> Self {
        Self::of_choices(Choices::new(matrix, &[]), within, |_| true)
    }

    /// The components of the graph of all choices, of the states for which `within` holds and the entries
    /// that are `usable`.
    pub fn of_choices<N>(
        choices: Choices<'_, N>,
        within: &[bool],
        usable: impl Fn(usize) -> bool,
    ) -> Self {
        let columns = &choices.matrix.column;
        Tarjan::new(columns, |state| choices.all_entries(state), usable, within).run()
    }

    /// The components; a component after all those it reaches.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.start
            .windows(2)
            .map(|ends| &self.states[ends[0]..ends[1]])
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Whether all states are seen to reach each other; if not, they may, where states are not numbered by a search from the first one.
///
/// Every state is reached from the first one, as one pass over the transitions shows, and reaches it.
pub(crate) fn is_seen_to_be_strongly_connected<N>(matrix: &Csr<N>) -> bool {
    let states = matrix.num_rows();
    let mut first = vec![false; states];
    first[..states.min(1)].fill(true);
    let mut reached = first.clone();
    for state in 0..states {
        if reached[state] {
            for target in successors(matrix, state) {
                reached[*target as usize] = true;
            }
        }
    }
    let all = |set: &[bool]| set.iter().all(|holds| *holds);
    states > 0 && all(&reached) && all(&Predecessors::new(matrix).reaching(&first, |_| true))
}

const UNSEEN: u32 = u32::MAX;

struct Tarjan<'a, R, U> {
    columns: &'a [u32],
    entries: R,
    usable: U,
    within: &'a [bool],
    /// Order of discovery; `UNSEEN` before.
    number: Vec<u32>,
    /// Smallest number known to be reachable within the open component.
    low: Vec<u32>,
    open: Vec<bool>,
    /// States that have been left and whose component is not complete.
    left: Vec<u32>,
    /// States being visited, each with the position of its next transition, and how many had been left before.
    visits: Vec<(u32, usize, usize)>,
    found: Components,
}

impl<'a, R: Fn(usize) -> Range<usize>, U: Fn(usize) -> bool> Tarjan<'a, R, U> {
    fn new(columns: &'a [u32], entries: R, usable: U, within: &'a [bool]) -> Self {
        let states = within.len();
        Self {
            columns,
            entries,
            usable,
            within,
            number: vec![UNSEEN; states],
            low: vec![0; states],
            open: vec![false; states],
            left: Vec::new(),
            visits: Vec::new(),
            found: Components {
                states: Vec::new(),
                start: vec![0],
            },
        }
    }

    fn run(mut self) -> Components {
        let mut next_number = 0;
        for root in 0..self.within.len() {
            if self.within[root] && self.number[root] == UNSEEN {
                self.discover(root, &mut next_number);
                while let Some((state, position, before)) = self.visits.pop() {
                    self.continue_visit(state as usize, position, before, &mut next_number);
                }
            }
        }
        self.found
    }

    fn discover(&mut self, state: usize, next_number: &mut u32) {
        self.number[state] = *next_number;
        self.low[state] = *next_number;
        *next_number += 1;
        self.open[state] = true;
        let first = (self.entries)(state).start;
        self.visits.push((state as u32, first, self.left.len()));
    }

    fn continue_visit(
        &mut self,
        state: usize,
        mut position: usize,
        before: usize,
        next_number: &mut u32,
    ) {
        let end = (self.entries)(state).end;
        while position < end {
            let (target, usable) = (self.columns[position] as usize, (self.usable)(position));
            position += 1;
            if !usable || !self.within[target] {
                continue;
            }
            if self.number[target] == UNSEEN {
                self.visits.push((state as u32, position, before));
                self.discover(target, next_number);
                return;
            }
            if self.open[target] {
                self.low[state] = self.low[state].min(self.number[target]);
            }
        }
        self.finish(state, before);
    }

    fn finish(&mut self, state: usize, before: usize) {
        if let Some((parent, ..)) = self.visits.last() {
            let parent = *parent as usize;
            self.low[parent] = self.low[parent].min(self.low[state]);
        }
        self.left.push(state as u32);
        if self.low[state] != self.number[state] {
            return;
        }
        // What has been left since, and does not belong to another component, belongs to this one.
        for member in self.left.drain(before..) {
            self.open[member as usize] = false;
            self.found.states.push(member);
        }
        self.found.start.push(self.found.states.len());
    }
}

/// The bottom components of the whole graph: those that no transition leaves.
pub fn bottom_components<N>(matrix: &Csr<N>) -> Vec<Vec<u32>> {
    let everywhere = vec![true; matrix.num_rows()];
    let components = Components::new(matrix, &everywhere);
    let mut member_of = vec![0; matrix.num_rows()];
    for (index, component) in components.iter().enumerate() {
        component
            .iter()
            .for_each(|state| member_of[*state as usize] = index);
    }
    let is_bottom = |(index, component): &(usize, &[u32])| {
        (component.iter())
            .flat_map(|state| successors(matrix, *state as usize))
            .all(|target| member_of[*target as usize] == *index)
    };
    (components.iter().enumerate())
        .filter(is_bottom)
        .map(|(_, component)| component.to_vec())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn graph(edges: &[(usize, usize)], states: usize) -> Csr<f64> {
        let mut rows = vec![Vec::new(); states];
        for (from, to) in edges {
            if !rows[*from].contains(&(*to as u32, 1.0)) {
                rows[*from].push((*to as u32, 1.0));
            }
        }
        Csr::from_rows(rows)
    }

    /// Which states reach which, by Warshall's closure; every state reaches itself.
    fn closure(matrix: &Csr<f64>) -> Vec<Vec<bool>> {
        let states = matrix.num_rows();
        let mut reaches = vec![vec![false; states]; states];
        for (from, row) in reaches.iter_mut().enumerate() {
            row[from] = true;
            successors(matrix, from)
                .iter()
                .for_each(|to| row[*to as usize] = true);
        }
        for via in 0..states {
            let through = reaches[via].clone();
            for row in reaches.iter_mut().filter(|row| row[via]) {
                row.iter_mut()
                    .zip(&through)
                    .for_each(|(known, more)| *known |= more);
            }
        }
        reaches
    }

    #[test]
    fn a_long_chain_needs_no_recursion() {
        let states = 300_000;
        let edges: Vec<_> = (0..states).map(|s| (s, (s + 1).min(states - 1))).collect();
        let matrix = graph(&edges, states);
        assert_eq!(Components::new(&matrix, &vec![true; states]).len(), states);
        assert_eq!(bottom_components(&matrix), vec![vec![states as u32 - 1]]);
    }

    #[test]
    fn states_of_a_component_are_in_the_order_in_which_they_are_left() {
        // A circle with a short cut back, from which two more states are reached that lead back into it.
        let edges = [
            (0, 1),
            (1, 2),
            (2, 0),
            (2, 3),
            (3, 4),
            (4, 2),
            (3, 5),
            (5, 5),
        ];
        let matrix = graph(&edges, 6);
        let components = Components::new(&matrix, &[true; 6]);
        let found: Vec<&[u32]> = components.iter().collect();
        assert_eq!(found, [&[5][..], &[4, 3, 2, 1, 0]]);
    }

    #[test]
    fn strong_connection_is_seen_where_numbers_go_up_and_back() {
        let states = 1000;
        let mut edges: Vec<_> = (0..states).map(|s| (s, (s + 1) % states)).collect();
        edges.extend((1..states).map(|s| (s, s / 2)));
        let connected = |edges: &[_]| is_seen_to_be_strongly_connected(&graph(edges, states));
        assert!(connected(&edges));
        // One state that is never left, one that is never reached.
        let left = edges.iter().copied().filter(|(from, _)| *from != 700);
        assert!(!connected(&left.collect::<Vec<_>>()));
        let reached = edges.iter().copied().filter(|(_, to)| *to != 700);
        assert!(!connected(&reached.collect::<Vec<_>>()));
    }

    proptest! {
        #[test]
        fn components_and_qualitative_sets_agree_with_the_closure(
            edges in prop::collection::vec((0usize..9, 0usize..9), 0..24),
            left in prop::collection::vec(any::<bool>(), 9),
            right in prop::collection::vec(prop::bool::weighted(0.3), 9),
        ) {
            let matrix = graph(&edges, 9);
            let reaches = closure(&matrix);
            let components = Components::new(&matrix, &[true; 9]);
            let mut order = [0; 9];
            for (index, component) in components.iter().enumerate() {
                component.iter().for_each(|state| order[*state as usize] = index);
            }
            let connected = reaches.iter().all(|row| row.iter().all(|reached| *reached));
            prop_assert!(connected || !is_seen_to_be_strongly_connected(&matrix));
            for (a, row) in reaches.iter().enumerate() {
                for b in 0..9 {
                    prop_assert_eq!(order[a] == order[b], row[b] && reaches[b][a]);
                    prop_assert!(!row[b] || order[b] <= order[a]);
                }
            }
            let restricted: Vec<_> = edges.iter().copied().filter(|(s, _)| left[*s] && !right[*s]).collect();
            let paths = closure(&graph(&restricted, 9));
            let sets = qualitative(&matrix, &left, &right);
            for (state, paths) in paths.iter().enumerate() {
                let meets = |set: &[bool]| (0..9).any(|to| set[to] && paths[to]);
                prop_assert_eq!(sets.never[state], !meets(&right));
                prop_assert_eq!(sets.surely[state], !meets(&sets.never));
            }
        }
    }
}
