//! The choices of each state, as rows of a matrix.

use std::ops::Range;

use crate::state_space::Csr;

/// Which rows of a matrix are the choices of which state; in a chain, each state has the row of its number.
#[derive(Debug)]
pub struct Choices<'a, N> {
    /// One row for each choice; columns are states.
    pub matrix: &'a Csr<N>,
    start: &'a [usize],
}

impl<N> Clone for Choices<'_, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<N> Copy for Choices<'_, N> {}

impl<'a, N> Choices<'a, N> {
    /// The choices of state `s` are the rows `choice_start[s]..choice_start[s + 1]`; an empty `choice_start`
    /// says that the matrix is that of a chain.
    pub fn new(matrix: &'a Csr<N>, choice_start: &'a [usize]) -> Self {
        Self {
            matrix,
            start: choice_start,
        }
    }

    /// Whether no state has an alternative by construction.
    pub fn is_chain(&self) -> bool {
        self.start.is_empty()
    }

    /// The number of states.
    pub fn num_states(&self) -> usize {
        match self.start.len() {
            0 => self.matrix.num_rows(),
            entries => entries - 1,
        }
    }

    /// The choices of a state.
    pub fn rows(&self, state: usize) -> Range<usize> {
        match self.start.len() {
            0 => state..state + 1,
            _ => self.start[state]..self.start[state + 1],
        }
    }

    /// The places of a choice's entries.
    pub fn entries(&self, row: usize) -> Range<usize> {
        self.matrix.row_start[row]..self.matrix.row_start[row + 1]
    }

    /// The places of all entries of a state.
    pub fn all_entries(&self, state: usize) -> Range<usize> {
        let rows = self.rows(state);
        self.matrix.row_start[rows.start]..self.matrix.row_start[rows.end]
    }

    /// The targets of a choice.
    pub fn targets(&self, row: usize) -> &'a [u32] {
        &self.matrix.column[self.entries(row)]
    }

    /// The state of each choice.
    pub fn owners(&self) -> Vec<u32> {
        let mut owners = vec![0; self.matrix.num_rows()];
        for state in 0..self.num_states() {
            owners[self.rows(state)].fill(state as u32);
        }
        owners
    }
}
