//! Witnesses: the most probable path to a goal, and the shortest.
//!
//! ```text
//! p(s0 .. sn)   = p(s0, s1) * ... * p(sn-1, sn)
//! most probable = the path to a goal state with the greatest p; of equal ones the one that the search
//!                 settles first (smaller state numbers first)
//! shortest      = a path with the fewest transitions; of equal ones the one that a breadth-first search
//!                 in the order of the states finds
//! ```
//!
//! Source: E. W. Dijkstra (1959), with the weights `-ln p(s, t)`, which are not negative; T. Han, J.-P.
//! Katoen and B. Damman, "Counterexample generation in probabilistic model checking" (2009), for the
//! reduction. Deviation: none. Cost: O(t log s) for s states and t transitions. Guarantee: the probability
//! of the path is the product of the matrix's entries (rounded in `f64`, exact in an exact domain); no other
//! path is more probable by a relative factor of more than 1 + 4 n u, where n is the path's length and
//! u = 2^-53, since weights are rounded.
//!
//! [`transition_cover`] makes few paths that take every transition, or one of each class of transitions;
//! [`PathSteps`] says which commands of the model each step of a path takes, and what they change.

mod cover;
mod steps;

pub use cover::{TransitionCover, transition_cover};
pub use steps::{Cause, Change, PathSteps, Step};

use std::cmp::Ordering;
use std::collections::{BinaryHeap, VecDeque};

use prism_lang::Arithmetic;

use crate::state_space::StateSpace;

/// A path from an initial state, by the numbers of its states.
#[derive(Clone, Debug, PartialEq)]
pub struct Path<N> {
    /// The states, from the initial one to the last.
    pub states: Vec<usize>,
    /// The product of its transitions' probabilities; 1 without transitions.
    pub probability: N,
}

impl<N: Arithmetic> Path<N> {
    /// The path through these states.
    fn through(space: &StateSpace<N>, states: Vec<usize>) -> Self {
        let steps = states.windows(2);
        let probability = steps.fold(N::one(), |product, step| {
            match probability(space, step[0], step[1]) {
                Some(factor) => product.mul(factor),
                None => N::zero(),
            }
        });
        Self {
            states,
            probability,
        }
    }
}

/// The probability of one transition, if there is one.
fn probability<N>(space: &StateSpace<N>, from: usize, to: usize) -> Option<&N> {
    let mut row = space.matrix.row(from);
    row.find(|(target, _)| *target == to).map(|(_, p)| p)
}

/// The most probable path from an initial state to a state for which `goal` (one flag per state) holds;
/// `None` if no goal can be reached.
///
/// ```
/// use checker::paths::most_probable_path;
/// use checker::state_space::{Csr, StateSpace};
///
/// // To 3 it is likelier over 2, although that takes more steps.
/// let rows = vec![
///     vec![(1, 0.9), (3, 0.1)],
///     vec![(2, 0.8), (1, 0.2)],
///     vec![(3, 0.5), (0, 0.5)],
///     vec![(3, 1.0)],
/// ];
/// let space = StateSpace::from_matrix(Csr::from_rows(rows), vec![0], Vec::new());
/// let path = most_probable_path(&space, &[false, false, false, true]).unwrap();
/// assert_eq!(path.states, [0, 1, 2, 3]);
/// assert_eq!(path.probability, 0.9 * 0.8 * 0.5);
/// ```
pub fn most_probable_path<N: Arithmetic>(space: &StateSpace<N>, goal: &[bool]) -> Option<Path<N>> {
    let states = space.num_states();
    let mut weight = vec![f64::INFINITY; states];
    let mut before = vec![usize::MAX; states];
    let mut settled = vec![false; states];
    let mut open = BinaryHeap::new();
    for state in space.initial_states() {
        weight[*state] = 0.0;
        open.push(Open {
            weight: 0.0,
            state: *state,
        });
    }
    while let Some(Open { state, .. }) = open.pop() {
        if std::mem::replace(&mut settled[state], true) {
            continue;
        }
        if goal.get(state) == Some(&true) {
            return Some(Path::through(space, back_to_start(&before, state)));
        }
        for (target, probability) in space.matrix.row(state) {
            let through = weight[state] - probability.to_f64().ln();
            if !settled[target] && through < weight[target] {
                weight[target] = through;
                before[target] = state;
                open.push(Open {
                    weight: through,
                    state: target,
                });
            }
        }
    }
    None
}

/// A path with the fewest transitions from an initial state to a state for which `goal` (one flag per state)
/// holds; `None` if no goal can be reached.
///
/// ```
/// use checker::paths::shortest_path;
/// use checker::state_space::{Csr, StateSpace};
///
/// let rows = vec![vec![(1, 0.9), (2, 0.1)], vec![(2, 1.0)], vec![(2, 1.0)]];
/// let space = StateSpace::from_matrix(Csr::from_rows(rows), vec![0], Vec::new());
/// let path = shortest_path(&space, &[false, false, true]).unwrap();
/// assert_eq!((path.states, path.probability), (vec![0, 2], 0.1));
/// ```
pub fn shortest_path<N: Arithmetic>(space: &StateSpace<N>, goal: &[bool]) -> Option<Path<N>> {
    let starts = space.initial_states();
    let states = shortest(space, starts, |state| goal.get(state) == Some(&true))?;
    Some(Path::through(space, states))
}

/// The states of a shortest path from one of `starts` to a state that is `wanted`, both included.
fn shortest<N>(
    space: &StateSpace<N>,
    starts: &[usize],
    wanted: impl Fn(usize) -> bool,
) -> Option<Vec<usize>> {
    let mut before = vec![usize::MAX; space.num_states()];
    let mut seen = vec![false; space.num_states()];
    let mut waiting: VecDeque<usize> = starts.iter().copied().collect();
    starts.iter().for_each(|start| seen[*start] = true);
    while let Some(state) = waiting.pop_front() {
        if wanted(state) {
            return Some(back_to_start(&before, state));
        }
        for (target, _) in space.matrix.row(state) {
            if !std::mem::replace(&mut seen[target], true) {
                before[target] = state;
                waiting.push_back(target);
            }
        }
    }
    None
}

/// Follows `before` back from the last state; a start has none before it.
fn back_to_start(before: &[usize], last: usize) -> Vec<usize> {
    let mut states = vec![last];
    let mut state = last;
    while before[state] != usize::MAX {
        state = before[state];
        states.push(state);
    }
    states.reverse();
    states
}

/// A state that is reached but not settled; the heap gives the least weight first, then the smaller number.
struct Open {
    weight: f64,
    state: usize,
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_weight = other.weight.total_cmp(&self.weight);
        by_weight.then(other.state.cmp(&self.state))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

#[cfg(test)]
mod tests;
