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
//! entries, except for `Pmax = 1`: linear for each time that a state of Y loses the choice that led it nearer to `right`, though
//! it has others that stay in Y.
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

    /// The choices with this target.
    pub fn rows_into(&self, state: usize) -> &[u32] {
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
        let mut queue: Vec<u32> = Vec::with_capacity(targets.len());
        queue.extend((0..targets.len() as u32).filter(|s| targets[*s as usize]));
        let mut next = 0;
        while next < queue.len() {
            let state = queue[next] as usize;
            next += 1;
            for row in self.rows_into(state) {
                let (row, owner) = (*row as usize, self.owner[*row as usize]);
                let from = owner as usize;
                if !reaches[from] && usable(row) && through(from) {
                    reaches[from] = true;
                    towards[from] = row;
                    queue.push(owner);
                }
            }
        }
        (reaches, towards)
    }

    /// The states from which every scheduler has a chance of `right`.
    pub fn unavoidable<N>(
        &self,
        choices: Choices<'_, N>,
        left: &[bool],
        right: &[bool],
    ) -> Vec<bool> {
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
    ///
    /// Choices that may leave Y are struck out one by one, with the states that have no other; only where this leaves open
    /// whether `right` is still reached, the search for it is begun again.
    pub fn sure_for_some<N>(
        &self,
        choices: Choices<'_, N>,
        left: &[bool],
        right: &[bool],
    ) -> (Vec<bool>, Vec<usize>) {
        let (within, towards) = self.reaching(right, |s| left[s], |_| true);
        self.sure_among(choices, right, within, towards)
    }

    /// The same, given the states that reach `right` and for each a choice that leads nearer.
    fn sure_among<N>(
        &self,
        choices: Choices<'_, N>,
        right: &[bool],
        mut within: Vec<bool>,
        mut towards: Vec<usize>,
    ) -> (Vec<bool>, Vec<usize>) {
        let mut stays = vec![true; choices.matrix.num_rows()];
        let mut open: Vec<u32> = (0..within.len())
            .map(|s| choices.rows(s).len() as u32)
            .collect();
        let mut dropped: Vec<u32> = (0..within.len() as u32)
            .filter(|s| !within[*s as usize])
            .collect();
        while !dropped.is_empty() {
            let mut is_cut = false;
            while let Some(state) = dropped.pop() {
                for row in self.rows_into(state as usize) {
                    let from = self.owner[*row as usize];
                    let at = from as usize;
                    if !within[at] || right[at] || !stays[*row as usize] {
                        continue;
                    }
                    stays[*row as usize] = false;
                    open[at] -= 1;
                    if open[at] == 0 {
                        within[at] = false;
                        dropped.push(from);
                    } else {
                        is_cut |= towards[at] == *row as usize;
                    }
                }
            }
            if !is_cut {
                break;
            }
            let (next, nearer) = self.reaching(right, |s| within[s], |row| stays[row]);
            dropped.extend(
                (0..next.len() as u32).filter(|s| within[*s as usize] != next[*s as usize]),
            );
            (within, towards) = (next, nearer);
        }
        for (towards, within) in towards.iter_mut().zip(&within) {
            if !within {
                *towards = NO_ROW;
            }
        }
        (within, towards)
    }
}

/// Where `left U right` has probability 0 and 1, and where a greatest one is 1, for each state a choice that keeps to it.
pub(crate) struct Optimum {
    pub sets: Qualitative,
    /// [`NO_ROW`] elsewhere; empty for a least probability.
    pub towards: Vec<usize>,
}

/// The states in which `left U right` has probability 0 and 1: the greatest or least one over schedulers.
pub fn qualitative_optimum<N>(
    choices: Choices<'_, N>,
    left: &[bool],
    right: &[bool],
    maximise: bool,
) -> Qualitative {
    optimum(choices, left, right, maximise).sets
}

/// The same with the choices that keep to a sure target.
pub(crate) fn optimum<N>(
    choices: Choices<'_, N>,
    left: &[bool],
    right: &[bool],
    maximise: bool,
) -> Optimum {
    let backward = Backward::new(choices);
    let not = |set: &[bool]| set.iter().map(|holds| !holds).collect::<Vec<bool>>();
    if maximise {
        let (possible, nearer) = backward.reaching(right, |s| left[s], |_| true);
        let never = not(&possible);
        let (surely, towards) = backward.sure_among(choices, right, possible, nearer);
        return Optimum {
            sets: Qualitative { never, surely },
            towards,
        };
    }
    let never = not(&backward.unavoidable(choices, left, right));
    let (avoidable, _) = backward.reaching(&never, |s| left[s] && !right[s], |_| true);
    let surely = not(&avoidable);
    Optimum {
        sets: Qualitative { never, surely },
        towards: Vec::new(),
    }
}
