//! Least and greatest expected reward before absorption: the equations to which all unbounded values reduce.
//!
//! *Problem.* Some states have a fixed value. The others `i` have choices `c` with a reward `r_c >= 0` and
//! probabilities `p_cj` of moving to other states; staying in `i` plays no part, as it is divided out:
//!
//! ```text
//! x_i = opt over c of  (r_c + sum_{j != i} p_cj x_j) / sum_{j != i} p_cj        opt = min or max
//! ```
//!
//! No scheduler can avoid the fixed states for ever, or (min only) it earns infinitely much in doing so. Then
//! there is one solution, and it is the optimum over all schedulers (Bertsekas and Tsitsiklis 1991, "An
//! Analysis of Stochastic Shortest Path Problems"). [`crate::quotient`] brings models into this form by
//! collapsing end components.
//!
//! Ways to solve it: [`sound`] (policy iteration and linear equations, too), [`exact`], [`classical`], [`jacobi`].

pub(crate) mod classical;
pub(crate) mod exact;
pub(crate) mod jacobi;
pub(crate) mod local;
mod policy;
mod search;
pub(crate) mod slack;
pub(crate) mod sound;

use crate::state_space::Csr;

/// A problem as above.
#[derive(Debug, Clone)]
pub(crate) struct Problem<N, V> {
    /// One row for each choice; no entry leads to the choice's own state.
    pub matrix: Csr<N>,
    /// The choices of state `s` are the rows `choice_start[s]..choice_start[s + 1]`.
    pub choice_start: Vec<usize>,
    /// The reward of each choice; none if it is empty.
    pub reward: Vec<V>,
    /// The value of the states without choices.
    pub fixed: Vec<Option<V>>,
    pub maximise: bool,
    /// The greatest number of entries of the model that were added up to one entry of the matrix.
    pub merged: usize,
}

/// Its solution.
#[derive(Debug, Clone)]
pub(crate) struct Solution<V> {
    pub values: Vec<V>,
    /// The choice that is taken in each state; [`crate::graph::NO_ROW`] in fixed ones.
    pub choice: Vec<usize>,
    /// Rounds of iteration.
    pub iterations: u64,
}
