//! Rewards of states and transitions, as numbers.
//!
//! Definition: a reward structure gives a state the sum of its state items whose guards hold there (earned for
//! each step in it; for each unit of time in a `ctmc`), and a transition with action `a` from a state the sum of
//! its items for `a` whose guards hold in that state. Items without action are those of commands without
//! action. A self-loop that was added to a deadlock earns nothing.
//!
//! In a chain, transitions of several actions may be merged into one entry of the matrix. Its reward is then the
//! mean over them, weighted with their probabilities or rates, which keeps every expected value. Source: the
//! PRISM manual, section "Costs and rewards".

/// A reward structure over a state space.
#[derive(Clone, Debug, PartialEq)]
pub struct Rewards<N> {
    /// What each state earns: per step, or per unit of time in a `ctmc`.
    pub state: Vec<N>,
    /// What transitions earn.
    pub transition: TransitionRewards<N>,
    /// A bound of the relative error of every number here, against the model's exact rewards; 0 if all are
    /// exact; infinite if it is not known (irrational rewards, or merged ones of both signs).
    pub relative_error: f64,
}

/// What transitions earn, in addition to states.
#[derive(Clone, Debug, PartialEq)]
pub enum TransitionRewards<N> {
    /// Nothing.
    None,
    /// The same for all transitions of a row of the matrix (a choice): one number for each row.
    Row(Vec<N>),
    /// One number for each entry of the matrix.
    Entry(Vec<N>),
}

impl<N> Rewards<N> {
    /// Rewards of states only, exact.
    pub fn of_states(state: Vec<N>) -> Self {
        Self {
            state,
            transition: TransitionRewards::None,
            relative_error: 0.0,
        }
    }
}

impl<N> TransitionRewards<N> {
    /// The reward of an entry of the matrix, which lies in this row.
    ///
    /// # Panics
    /// If there is no such row or entry.
    pub fn of(&self, row: usize, entry: usize) -> Option<&N> {
        match self {
            Self::None => None,
            Self::Row(of_rows) => Some(&of_rows[row]),
            Self::Entry(of_entries) => Some(&of_entries[entry]),
        }
    }
}
