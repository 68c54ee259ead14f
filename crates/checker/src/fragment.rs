//! The part of a model that can matter for `left U right` from some states.
//!
//! *Definition.* The states that are reached from those asked for through states of `left` that are not in `right`. A path that comes
//! to another state is decided there; such a state keeps nothing but a self-loop. The other states have the choices that they
//! have in the model, and so the same probabilities of `left U right`, within any number of steps.
//!
//! Many formulas are decided early in a model, and then all that is done to solve them is done on a small part of it. Where
//! that is not so, nothing is copied.
//!
//! Cost: linear in the part's transitions, plus a flag for each state. Guarantee: exact.

use prism_lang::Arithmetic;

use crate::choices::Choices;
use crate::graph::NO_ROW;
use crate::state_space::Csr;

/// A part of a model, as a model of its own.
#[derive(Debug)]
pub(crate) struct Fragment<N> {
    matrix: Csr<N>,
    choice_start: Vec<usize>,
    /// The model's state of each, ascending.
    states: Vec<u32>,
    /// The model's first choice of each; none where the formula is decided.
    first_row: Vec<usize>,
}

impl<N: Arithmetic> Fragment<N> {
    /// What matters from these states; `None` if that is more than half of the model.
    pub fn new(
        choices: Choices<'_, N>,
        left: &[bool],
        right: &[bool],
        from: &[usize],
    ) -> Option<Self> {
        let is_open = |state: usize| left[state] && !right[state];
        let states = within(choices, is_open, from)?;
        let mut place = vec![0_u32; choices.num_states()];
        for (at, state) in states.iter().enumerate() {
            place[*state as usize] = at as u32;
        }
        let mut matrix = Csr::with_capacity(states.len());
        let (mut choice_start, mut first_row) = (Vec::new(), Vec::new());
        for (at, state) in states.iter().enumerate() {
            let rows = choices.rows(*state as usize);
            choice_start.push(matrix.num_rows());
            if is_open(*state as usize) {
                first_row.push(rows.start);
                for row in rows {
                    let entries = choices.matrix.row(row);
                    matrix.push_row(entries.map(|(target, p)| (place[target], p.clone())));
                }
            } else {
                first_row.push(NO_ROW);
                matrix.push_row([(at as u32, N::one())]);
            }
        }
        choice_start.push(matrix.num_rows());
        if choices.is_chain() {
            choice_start.clear();
        }
        Some(Self {
            matrix,
            choice_start,
            states,
            first_row,
        })
    }

    pub fn choices(&self) -> Choices<'_, N> {
        Choices::new(&self.matrix, &self.choice_start)
    }

    /// A set of the model's states, here.
    pub fn set(&self, of_model: &[bool]) -> Vec<bool> {
        let each = self.states.iter();
        each.map(|state| of_model[*state as usize]).collect()
    }

    /// The place of a state of the part.
    pub fn place(&self, state: usize) -> usize {
        let at = self.states.binary_search(&(state as u32));
        at.unwrap_or_else(|at| at)
    }

    /// A scheduler of the part on the model; it says nothing of other states.
    pub fn scheduler(&self, own: &[usize], states: usize) -> Vec<usize> {
        let mut scheduler = vec![NO_ROW; states];
        for (at, state) in self.states.iter().enumerate() {
            if own[at] != NO_ROW && self.first_row[at] != NO_ROW {
                let alternative = own[at] - self.choices().rows(at).start;
                scheduler[*state as usize] = self.first_row[at] + alternative;
            }
        }
        scheduler
    }
}

/// The states reached through those that are open, ascending; `None` if they are more than half of all.
fn within<N>(
    choices: Choices<'_, N>,
    is_open: impl Fn(usize) -> bool,
    from: &[usize],
) -> Option<Vec<u32>> {
    let most = choices.num_states() / 2;
    let mut seen = vec![false; choices.num_states()];
    let mut found = Vec::new();
    let mut enter = |state: u32, found: &mut Vec<u32>| {
        if !std::mem::replace(&mut seen[state as usize], true) {
            found.push(state);
        }
    };
    from.iter()
        .for_each(|state| enter(*state as u32, &mut found));
    let mut next = 0;
    while next < found.len() {
        if found.len() > most {
            return None;
        }
        let state = found[next] as usize;
        next += 1;
        if is_open(state) {
            for target in &choices.matrix.column[choices.all_entries(state)] {
                enter(*target, &mut found);
            }
        }
    }
    if found.len() > most {
        return None;
    }
    found.sort_unstable();
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_decided_keeps_a_self_loop_and_what_lies_behind_is_left_out() {
        // 0 chooses between 2 and 3; 2 may go on to 4, where the formula is violated; 3 satisfies it. From 4 on a long way.
        let mut rows = vec![
            vec![(2, 1.0)],
            vec![(3, 1.0)],
            vec![(1, 1.0)],
            vec![(3, 0.5), (4, 0.5)],
            vec![(5, 1.0)],
        ];
        rows.extend((4..12).map(|s| vec![((s + 1).min(11), 1.0)]));
        let matrix = Csr::from_rows(rows);
        let mut start = vec![0, 2];
        start.extend(3..=13);
        let choices = Choices::new(&matrix, &start);
        let left: Vec<bool> = (0..12).map(|s| s != 4).collect();
        let right: Vec<bool> = (0..12).map(|s| s == 3).collect();
        let part = Fragment::new(choices, &left, &right, &[0]).unwrap();
        assert_eq!(part.states, [0, 2, 3, 4]);
        assert_eq!(part.set(&right), [false, false, true, false]);
        let rows = [
            vec![(1, 1.0)],
            vec![(2, 1.0)],
            vec![(2, 0.5), (3, 0.5)],
            vec![(2, 1.0)],
            vec![(3, 1.0)],
        ];
        assert_eq!(part.matrix, Csr::from_rows(rows.to_vec()));
        assert_eq!(part.choice_start, [0, 2, 3, 4, 5]);
        let scheduler = part.scheduler(&[1, 2, 3, 4], 12);
        assert_eq!(scheduler[..3], [1, NO_ROW, 3]);
        assert!(scheduler[3..].iter().all(|row| *row == NO_ROW));
        assert!(Fragment::new(choices, &left, &right, &[0, 5]).is_none());
    }
}
