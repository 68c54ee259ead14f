//! Transition coverage: few paths that together take every transition that can be taken.
//!
//! A path goes on to the nearest transition that no path has taken yet; where none can be reached any more,
//! a new path begins in an initial state. Transitions may be put into classes, of which one each is taken.
//!
//! Source: the greedy tour for the transition coverage of state machines (B. Beizer, "Software Testing
//! Techniques", 1990; the exact shortest tour is the rural postman problem of M.-K. Kuan, 1962, which
//! restarts and unconnected parts make NP-hard). Deviation: nearest first. Cost: O(c (s + t)) for c classes,
//! s states and t transitions, in practice far less, since the nearest is near. Guarantee: every class that
//! can be reached is taken; the number of paths and their length are not the least possible.

use std::collections::BTreeMap;

use super::{Arithmetic, Path, shortest};
use crate::state_space::StateSpace;

/// Paths that take every class of transitions that can be taken.
#[derive(Clone, Debug, PartialEq)]
pub struct TransitionCover<N> {
    /// The paths, each from an initial state.
    pub paths: Vec<Path<N>>,
    /// How many classes of transitions there are; all are taken.
    pub classes: usize,
    /// How many transitions all paths have together.
    pub length: usize,
}

/// Covers the classes that `class` puts transitions (from, to) into; transitions without a class need not be
/// taken. A path of `longest` or more transitions is not gone on with. Stops early, with the paths so far,
/// when `cancelled` says so.
///
/// ```
/// use checker::paths::transition_cover;
/// use checker::state_space::{Csr, StateSpace};
///
/// let rows = vec![vec![(1, 0.5), (2, 0.5)], vec![(0, 1.0)], vec![(2, 1.0)]];
/// let space = StateSpace::from_matrix(Csr::from_rows(rows), vec![0], Vec::new());
/// let cover = transition_cover(&space, |from, to| Some((from, to)), 100, &|| false);
/// let states: Vec<_> = cover.paths.iter().map(|path| path.states.clone()).collect();
/// assert_eq!(states, [[0, 1, 0, 2, 2]]);
/// assert_eq!((cover.classes, cover.length), (4, 4));
/// ```
pub fn transition_cover<N: Arithmetic, K: Ord>(
    space: &StateSpace<N>,
    class: impl Fn(usize, usize) -> Option<K>,
    longest: usize,
    cancelled: &dyn Fn() -> bool,
) -> TransitionCover<N> {
    let mut todo = Todo::new(space, class);
    let classes = todo.taken.len();
    let mut paths = Vec::new();
    let mut length = 0;
    while todo.open > 0 && !cancelled() {
        let Some(states) = todo.tour(space, longest.max(1), cancelled) else {
            // What is left has no path: that cannot be, since a state space holds reachable states only.
            break;
        };
        length += states.len() - 1;
        paths.push(Path::through(space, states));
    }
    TransitionCover {
        paths,
        classes,
        length,
    }
}

/// Which classes are still to be taken.
struct Todo {
    /// The class of each entry of the matrix, in its order.
    class_of: Vec<Option<usize>>,
    taken: Vec<bool>,
    open: usize,
    /// For each state the number of its transitions whose class is open.
    open_from: Vec<usize>,
    /// For each class the states that its transitions leave.
    sources: Vec<Vec<usize>>,
}

impl Todo {
    fn new<N, K: Ord>(space: &StateSpace<N>, class: impl Fn(usize, usize) -> Option<K>) -> Self {
        let mut numbers: BTreeMap<K, usize> = BTreeMap::new();
        let mut todo = Self {
            class_of: Vec::with_capacity(space.num_transitions()),
            taken: Vec::new(),
            open: 0,
            open_from: vec![0; space.num_states()],
            sources: Vec::new(),
        };
        for from in 0..space.num_states() {
            for (to, _) in space.matrix.row(from) {
                let number = class(from, to).map(|key| {
                    let next = numbers.len();
                    *numbers.entry(key).or_insert(next)
                });
                if let Some(number) = number {
                    if number == todo.sources.len() {
                        todo.sources.push(Vec::new());
                    }
                    todo.sources[number].push(from);
                    todo.open_from[from] += 1;
                }
                todo.class_of.push(number);
            }
        }
        todo.open = numbers.len();
        todo.taken = vec![false; numbers.len()];
        todo
    }

    /// One path: to the nearest open transition, over it, and on; `None` if there is none to go to.
    fn tour<N>(
        &mut self,
        space: &StateSpace<N>,
        longest: usize,
        cancelled: &dyn Fn() -> bool,
    ) -> Option<Vec<usize>> {
        let starts = space.initial_states();
        let mut states = shortest(space, starts, |state| self.open_from[state] > 0)?;
        for step in 1..states.len() {
            self.take(space, states[step - 1], states[step]);
        }
        let way_there = states.len();
        // The way to the first one may be long already: it is taken all the same.
        while states.len() <= longest.max(way_there) && !cancelled() {
            let here = states[states.len() - 1];
            let Some(way) = shortest(space, &[here], |state| self.open_from[state] > 0) else {
                break;
            };
            let end = way[way.len() - 1];
            let Some(next) = self.first_open(space, end) else {
                break;
            };
            for state in way.into_iter().skip(1).chain([next]) {
                self.take(space, states[states.len() - 1], state);
                states.push(state);
            }
        }
        Some(states)
    }

    /// The target of the first open transition of a state.
    fn first_open<N>(&self, space: &StateSpace<N>, from: usize) -> Option<usize> {
        let first = space.matrix.row_start[from];
        let mut row = space.matrix.row(from).enumerate();
        let open = row.find(|(place, _)| {
            self.class_of[first + place].is_some_and(|class| !self.taken[class])
        });
        open.map(|(_, (target, _))| target)
    }

    /// Marks the class of a transition as taken.
    fn take<N>(&mut self, space: &StateSpace<N>, from: usize, to: usize) {
        let mut row = space.matrix.row(from);
        let Some(place) = row.position(|(target, _)| target == to) else {
            return;
        };
        let Some(class) = self.class_of[space.matrix.row_start[from] + place] else {
            return;
        };
        if !std::mem::replace(&mut self.taken[class], true) {
            self.open -= 1;
            for source in std::mem::take(&mut self.sources[class]) {
                self.open_from[source] -= 1;
            }
        }
    }
}
