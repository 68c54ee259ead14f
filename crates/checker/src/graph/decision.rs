//! Where `left U right` has probability exactly 0 or exactly 1 under some or under every scheduler.
//!
//! ```text
//! Pmax > 0   least set with `right` and the states of `left` with a choice into it
//! Pmin > 0   least set with `right` and the states of `left` all of whose choices lead into it
//! Pmax = 1   greatest set Y from which `right` is reached through choices that stay in Y
//! Pmin = 1   no path through `left & !right` to a state with Pmin = 0
//! ```
//!
//! Source: de Alfaro 1997, "Formal Verification of Probabilistic Systems", section 3; Baier and Katoen 2008,
//! section 10.6.1. Deviation: backward searches over choices instead of repeated sweeps. Cost: linear in
//! entries, except for `Pmax = 1`: linear for each of its rounds, in which at least one state leaves Y.
//! Guarantee: exact.

use super::Qualitative;
use crate::choices::Choices;

/// For each state, the choices that may lead to it.
pub(crate) struct Backward {
    start: Vec<usize>,
    row: Vec<u32>,
    /// The state of each choice.
    pub owner: Vec<u32>,
}

/// No choice.
pub(crate) const NO_ROW: usize = usize::MAX;

impl Backward {
    pub fn new<N>(choices: Choices<'_, N>) -> Self {
        let states = choices.num_states();
        let mut start = vec![0; states + 1];
        for column in &choices.matrix.column {
            start[*column as usize + 1] += 1;
        }
        for state in 0..states {
            start[state + 1] += start[state];
        }
        let mut next = start.clone();
        let mut row = vec![0; choices.matrix.num_entries()];
        for choice in 0..choices.matrix.num_rows() {
            for column in choices.targets(choice) {
                row[next[*column as usize]] = choice as u32;
                next[*column as usize] += 1;
            }
        }
        Self {
            start,
            row,
            owner: choices.owners(),
        }
    }

    fn rows_into(&self, state: usize) -> &[u32] {
        &self.row[self.start[state]..self.start[state + 1]]
    }

    /// The states from which some usable choices of states in `through` lead to `targets`; with, for each state
    /// reached, a choice that leads nearer.
    pub fn reaching(
        &self,
        targets: &[bool],
        through: impl Fn(usize) -> bool,
        usable: impl Fn(usize) -> bool,
    ) -> (Vec<bool>, Vec<usize>) {
        let mut reaches = targets.to_vec();
        let mut towards = vec![NO_ROW; targets.len()];
        let mut queue: Vec<usize> = (0..targets.len()).filter(|s| targets[*s]).collect();
        let mut next = 0;
        while next < queue.len() {
            let state = queue[next];
            next += 1;
            for row in self.rows_into(state) {
                let (row, from) = (*row as usize, self.owner[*row as usize] as usize);
                if !reaches[from] && through(from) && usable(row) {
                    reaches[from] = true;
                    towards[from] = row;
                    queue.push(from);
                }
            }
        }
        (reaches, towards)
    }

    /// The states from which every scheduler has a chance of `right`.
    fn unavoidable<N>(&self, choices: Choices<'_, N>, left: &[bool], right: &[bool]) -> Vec<bool> {
        let mut found = right.to_vec();
        let mut hits = vec![false; choices.matrix.num_rows()];
        let mut missing: Vec<usize> = (0..left.len()).map(|s| choices.rows(s).len()).collect();
        let mut queue: Vec<usize> = (0..left.len()).filter(|s| right[*s]).collect();
        while let Some(state) = queue.pop() {
            for row in self.rows_into(state) {
                let from = self.owner[*row as usize] as usize;
                if found[from] || !left[from] || std::mem::replace(&mut hits[*row as usize], true) {
                    continue;
                }
                missing[from] -= 1;
                if missing[from] == 0 {
                    found[from] = true;
                    queue.push(from);
                }
            }
        }
        found
    }

    /// The states in which some scheduler is sure of `right`, and for each a choice that keeps to it.
    pub fn sure_for_some<N>(
        &self,
        choices: Choices<'_, N>,
        left: &[bool],
        right: &[bool],
    ) -> (Vec<bool>, Vec<usize>) {
        let (mut within, _) = self.reaching(right, |s| left[s], |_| true);
        loop {
            let stays = |row: usize| {
                let inside = |target: &u32| within[*target as usize];
                choices.targets(row).iter().all(inside)
            };
            let (next, towards) = self.reaching(right, |s| left[s] && within[s], stays);
            if next == within {
                return (within, towards);
            }
            within = next;
        }
    }
}

/// The states in which `left U right` has probability 0 and 1: the greatest or least one over schedulers.
pub fn qualitative_optimum<N>(
    choices: Choices<'_, N>,
    left: &[bool],
    right: &[bool],
    maximise: bool,
) -> Qualitative {
    let backward = Backward::new(choices);
    let not = |set: Vec<bool>| set.into_iter().map(|holds| !holds).collect::<Vec<bool>>();
    if maximise {
        let (possible, _) = backward.reaching(right, |s| left[s], |_| true);
        let (surely, _) = backward.sure_for_some(choices, left, right);
        return Qualitative {
            never: not(possible),
            surely,
        };
    }
    let never = not(backward.unavoidable(choices, left, right));
    let (avoidable, _) = backward.reaching(&never, |s| left[s] && !right[s], |_| true);
    Qualitative {
        never,
        surely: not(avoidable),
    }
}
