//! The reachable states of a model and the transitions between them, in compact form.
//!
//! States are packed: a variable with range `low..=high` takes the bits that `high - low` needs, and never
//! straddles two 64-bit words. Transitions are a sparse matrix in compressed rows: one row for each state of a
//! chain (`dtmc`, `ctmc`), one for each choice of a state where there are choices (`mdp`, `lts`).
//!
//! Cost: 8 bytes per state and word, plus 4 bytes and one number per transition and one offset per row.

mod induced;
mod layout;
mod matrix;
mod rewards;

use std::fmt;

use prism_lang::resolved::{ActionId, ModelType, Variable, VariableKind};
use prism_lang::{EvalError, Expr, VarIndex};

pub(crate) use layout::{Field, Layout};
pub use matrix::Csr;
pub use rewards::{Rewards, TransitionRewards};

use crate::diagonals::Keys;
use crate::explore::ExploreError;
use crate::explore::code::Compiler;
use crate::rounding::error_of_roundings;

/// The reachable part of a model: states, initial states, deadlocks, transitions, labels and rewards.
///
/// States are numbered in the order of a breadth-first search from the initial states, which come first.
///
/// * `dtmc`: row `s` of the matrix has the probabilities of state `s` and sums to 1 (exactly in an exact domain).
/// * `ctmc`: row `s` has the rates of state `s`; a self-loop keeps its rate.
/// * `mdp`: row `c` has the probabilities of choice `c`; the choices of state `s` are
///   [`StateSpace::choices`]`(s)`, each with its [`StateSpace::action`].
/// * `lts`: as `mdp`, each row with the one target of the choice.
///
/// A state in which nothing is enabled is given a self-loop of probability 1 (of rate 1 in a `ctmc`), as PRISM
/// does, and listed in [`StateSpace::deadlocks`].
#[derive(Clone, Debug)]
pub struct StateSpace<N> {
    /// Which kind of model this is the state space of.
    pub kind: ModelType,
    /// Transition probabilities or rates: columns are state numbers, rows are states (chains) or choices.
    pub matrix: Csr<N>,
    /// Where the choices of each state start: one entry more than there are states. Empty for chains.
    pub choice_start: Vec<usize>,
    /// The action of each row: of a choice; [`NO_ACTION`] if it has none. Empty for chains.
    pub choice_action: Vec<u32>,
    pub(crate) actions: Vec<String>,
    pub(crate) variables: Vec<Variable>,
    pub(crate) layout: Layout,
    pub(crate) packed: Vec<u64>,
    pub(crate) initial: Vec<usize>,
    pub(crate) deadlocks: Vec<usize>,
    pub(crate) labelled_transitions: u64,
    pub(crate) labels: Vec<(String, LabelStates)>,
    pub(crate) rewards: Vec<RewardsOf<N>>,
    /// The greatest number of roundings behind an entry of the matrix; `None` if an error is unknown.
    pub(crate) roundings: Option<u32>,
    pub(crate) represented: Option<Represented>,
}

/// What the states that were explored up to symmetry stand for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Represented {
    /// Reachable states.
    pub states: u64,
    /// Entries that the matrix of all these would have.
    pub transitions: u64,
    /// Initial states.
    pub initial: u64,
    /// States in which nothing is enabled.
    pub deadlocks: u64,
}

impl Represented {
    pub(crate) fn add(&mut self, more: &Self) {
        self.states = self.states.saturating_add(more.states);
        self.transitions = self.transitions.saturating_add(more.transitions);
        self.initial = self.initial.saturating_add(more.initial);
        self.deadlocks = self.deadlocks.saturating_add(more.deadlocks);
    }
}

/// The action of a choice that has none, in [`StateSpace::choice_action`].
pub const NO_ACTION: u32 = u32::MAX;

/// A reward structure's name, and its values or why it has none.
pub(crate) type RewardsOf<N> = (Option<String>, Result<Rewards<N>, ExploreError>);

/// Where a label holds: by its definition, or by a list made beforehand.
#[derive(Clone, Debug)]
pub(crate) enum LabelStates {
    Defined(Expr),
    Listed(Vec<bool>),
}

impl<N> StateSpace<N> {
    /// A `dtmc` without variables, from its matrix: for models that were not written in the PRISM language.
    ///
    /// `labels` give each label's states (one flag per state).
    pub fn from_matrix(
        matrix: Csr<N>,
        initial: Vec<usize>,
        labels: Vec<(String, Vec<bool>)>,
    ) -> Self {
        Self::from_parts(ModelType::Dtmc, matrix, Vec::new(), initial, labels)
    }

    /// A model of any kind without variables, from its matrix and (`mdp`, `lts`) where each state's choices
    /// start in it, which must be empty for chains. Its choices have no action; its matrix is taken as exact.
    ///
    /// ```
    /// use checker::state_space::{Csr, StateSpace};
    /// use prism_lang::resolved::ModelType;
    /// // State 0 chooses between staying for sure and a fair coin.
    /// let rows = vec![vec![(0, 1.0)], vec![(0, 0.5), (1, 0.5)], vec![(1, 1.0)]];
    /// let matrix = Csr::from_rows(rows);
    /// let space = StateSpace::from_parts(ModelType::Mdp, matrix, vec![0, 2, 3], vec![0], Vec::new());
    /// assert_eq!((space.num_states(), space.num_choices()), (2, 3));
    /// assert_eq!(space.choices(0), 0..2);
    /// assert_eq!(space.action(0), None);
    /// ```
    pub fn from_parts(
        kind: ModelType,
        matrix: Csr<N>,
        choice_start: Vec<usize>,
        initial: Vec<usize>,
        labels: Vec<(String, Vec<bool>)>,
    ) -> Self {
        let layout = Layout::new(&[]);
        let has_choices = !choice_start.is_empty();
        let states = if has_choices {
            choice_start.len() - 1
        } else {
            matrix.num_rows()
        };
        let choices = if has_choices { matrix.num_rows() } else { 0 };
        let listed = |(name, states)| (name, LabelStates::Listed(states));
        Self {
            kind,
            packed: vec![0; states * layout.words()],
            layout,
            labelled_transitions: matrix.num_entries() as u64,
            matrix,
            choice_start,
            choice_action: vec![NO_ACTION; choices],
            actions: Vec::new(),
            variables: Vec::new(),
            initial,
            deadlocks: Vec::new(),
            labels: labels.into_iter().map(listed).collect(),
            rewards: Vec::new(),
            roundings: Some(0),
            represented: None,
        }
    }

    /// The same with one more reward structure.
    #[must_use]
    pub fn with_rewards(mut self, name: Option<String>, rewards: Rewards<N>) -> Self {
        self.rewards.push((name, Ok(rewards)));
        self
    }

    /// Adds labels with a flag for each state.
    pub(crate) fn list_labels(&mut self, labels: impl IntoIterator<Item = (String, Vec<bool>)>) {
        let listed = |(name, states)| (name, LabelStates::Listed(states));
        self.labels.extend(labels.into_iter().map(listed));
    }

    /// The number of reachable states.
    pub fn num_states(&self) -> usize {
        match self.choice_start.len() {
            0 => self.matrix.num_rows(),
            entries => entries - 1,
        }
    }

    /// What the states stand for, if they were explored up to symmetry
    /// ([`ExploreOptions::symmetry`](crate::explore::ExploreOptions::symmetry)).
    pub fn represented(&self) -> Option<Represented> {
        self.represented
    }

    /// The number of rows of the matrix: choices, or states of a chain.
    pub fn num_choices(&self) -> usize {
        self.matrix.num_rows()
    }

    /// The rows of the matrix that belong to a state: its choices; one row in a chain.
    ///
    /// # Panics
    /// If there is no such state.
    pub fn choices(&self, state: usize) -> std::ops::Range<usize> {
        match self.choice_start.len() {
            0 => state..state + 1,
            _ => self.choice_start[state]..self.choice_start[state + 1],
        }
    }

    /// The action of a choice (of a row of the matrix), if it has one; an index of [`StateSpace::actions`].
    pub fn action(&self, choice: usize) -> Option<ActionId> {
        let action = *self.choice_action.get(choice)?;
        (action != NO_ACTION).then_some(action as usize)
    }

    /// The names of the model's actions.
    pub fn actions(&self) -> &[String] {
        &self.actions
    }

    /// Numbers that order states by the values of their variables, the last one fastest; nothing if there are no variables,
    /// or one number does not hold them all.
    pub(crate) fn keys(&self) -> Option<Keys> {
        let fields: Vec<Field> = (0..self.layout.len())
            .map(|v| self.layout.field(v))
            .collect();
        let (mut shift, mut cuts, mut parts) = (0, Vec::new(), Vec::new());
        for field in fields.iter().rev() {
            parts.push((*field, shift));
            shift += field.mask.count_ones();
            cuts.push(shift);
        }
        if shift == 0 || shift > 63 {
            return None;
        }
        let key = |state: &[u64]| {
            let bits = parts
                .iter()
                .map(|(field, shift)| field.bits_of(state) << shift);
            bits.fold(0, |key, bits| key | bits)
        };
        Some(Keys {
            of: self
                .packed
                .chunks_exact(self.layout.words())
                .map(key)
                .collect(),
            cuts,
        })
    }

    /// The number of reward structures.
    pub fn num_rewards(&self) -> usize {
        self.rewards.len()
    }

    /// The index of the reward structure of this name.
    pub fn reward_index(&self, name: &str) -> Option<usize> {
        let named = |(n, _): &RewardsOf<N>| n.as_deref() == Some(name);
        self.rewards.iter().position(named)
    }

    /// A reward structure, by its index in the model.
    ///
    /// # Errors
    /// If one of its rewards has no (finite) value in some state, it has none at all; other structures do.
    ///
    /// # Panics
    /// If there is no such structure.
    pub fn rewards(&self, index: usize) -> Result<&Rewards<N>, &ExploreError> {
        self.rewards[index].1.as_ref()
    }

    /// The number of entries of the matrix, self-loops of deadlocks included: in a chain, pairs of states with a
    /// positive probability or rate; otherwise pairs of a choice and a target.
    pub fn num_transitions(&self) -> usize {
        self.matrix.num_entries()
    }

    /// The number of triples of source, target and action (commands without action count as one action): what
    /// PRISM's explicit engine reports as transitions of a chain. With choices, the entries of the matrix.
    pub fn num_labelled_transitions(&self) -> u64 {
        self.labelled_transitions
    }

    /// The initial states, ascending.
    pub fn initial_states(&self) -> &[usize] {
        &self.initial
    }

    /// The states in which no command was enabled, ascending; they were given a self-loop.
    pub fn deadlocks(&self) -> &[usize] {
        &self.deadlocks
    }

    /// The model's variables, in the order of a state's values.
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// The values of all variables in a state.
    ///
    /// # Panics
    /// If there is no such state.
    pub fn state(&self, state: usize) -> Vec<i64> {
        let mut values = vec![0; self.variables.len()];
        self.state_into(state, &mut values);
        values
    }

    /// Writes the values of all variables in a state to `values` (one per variable).
    ///
    /// # Panics
    /// If there is no such state.
    pub fn state_into(&self, state: usize, values: &mut [i64]) {
        let words = self.layout.words();
        let packed = &self.packed[state * words..(state + 1) * words];
        self.layout.unpack(packed, values);
    }

    /// The value of one variable in a state.
    ///
    /// # Panics
    /// If there is no such state or variable.
    pub fn value(&self, state: usize, variable: VarIndex) -> i64 {
        let words = self.layout.words();
        (self.layout).value(variable, &self.packed[state * words..(state + 1) * words])
    }

    /// A state as PRISM writes it: `(name=value,...)`, with `true` and `false` for truth values.
    ///
    /// # Panics
    /// If there is no such state.
    pub fn describe(&self, state: usize) -> String {
        describe(&self.variables, &self.state(state))
    }

    /// A bound of the relative error of every entry of the matrix, against the exact probability of the model.
    ///
    /// 0 if all entries are exact (as in an exact domain, and for [`StateSpace::from_matrix`], where the matrix
    /// is the model); infinite if the model computes probabilities with irrational numbers.
    ///
    /// Entries are products and sums of numbers that are not negative, so that `n` roundings leave a relative
    /// error of at most `n u / (1 - n u)` with `u = 2^-53` (Higham, "Accuracy and Stability of Numerical
    /// Algorithms", 2002, lemma 3.1).
    pub fn relative_error(&self) -> f64 {
        error_of_roundings(self.roundings)
    }

    /// The states in which a predicate holds: one flag per state.
    ///
    /// # Errors
    /// If the predicate has no value in some state.
    pub fn evaluate(&self, predicate: &Expr) -> Result<Vec<bool>, StateError> {
        let compiler = Compiler {
            variables: &self.variables,
            layout: &self.layout,
        };
        let code = compiler.code(predicate);
        let states = self.packed.chunks_exact(self.layout.words());
        let holds = |state: &[u64]| compiler.holds(&code, predicate, state);
        let each = states.map(|state| {
            holds(state).map_err(|error| StateError::NoValue {
                error,
                state: compiler.describe(state),
            })
        });
        each.collect()
    }

    /// The states in which a label holds (`init` and `deadlock` are built in): one flag per state.
    ///
    /// # Errors
    /// If there is no such label, or its definition has no value in some state.
    pub fn label(&self, name: &str) -> Result<Vec<bool>, StateError> {
        if let Some((_, states)) = self.labels.iter().find(|(n, _)| n == name) {
            return match states {
                LabelStates::Defined(predicate) => self.evaluate(predicate),
                LabelStates::Listed(flags) => Ok(flags.clone()),
            };
        }
        match name {
            "init" => Ok(self.flags(&self.initial)),
            "deadlock" => Ok(self.flags(&self.deadlocks)),
            _ => Err(StateError::UnknownLabel(name.to_owned())),
        }
    }

    fn flags(&self, states: &[usize]) -> Vec<bool> {
        let mut flags = vec![false; self.num_states()];
        for &state in states {
            flags[state] = true;
        }
        flags
    }
}

/// A state as PRISM writes it.
pub(crate) fn describe(variables: &[Variable], values: &[i64]) -> String {
    let parts = variables
        .iter()
        .zip(values)
        .map(|(variable, value)| match variable.kind {
            VariableKind::Bool => format!("{}={}", variable.name, *value != 0),
            VariableKind::Int { .. } | VariableKind::Unbounded => {
                format!("{}={value}", variable.name)
            }
        });
    format!("({})", parts.collect::<Vec<_>>().join(","))
}

/// Why a set of states could not be found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StateError {
    /// The model has no such label.
    UnknownLabel(String),
    /// A predicate has no value in a state.
    NoValue {
        /// What went wrong, and in which part of the predicate.
        error: EvalError,
        /// The state, written out.
        state: String,
    },
}

impl fmt::Display for StateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownLabel(name) => write!(
                f,
                "the model has no label \"{name}\": define it with `label \"{name}\" = ...;`"
            ),
            Self::NoValue { error, state } => write!(f, "in state {state}, {error}"),
        }
    }
}

impl std::error::Error for StateError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_a_matrix_are_found() {
        let matrix = Csr::from_rows(vec![vec![(1, 0.5), (0, 0.5)], vec![(1, 1.0)]]);
        assert_eq!(matrix.row(0).collect::<Vec<_>>(), [(0, &0.5), (1, &0.5)]);
        let done = vec![("done".to_owned(), vec![false, true])];
        let space = StateSpace::from_matrix(matrix, vec![0], done);
        assert_eq!(space.label("done"), Ok(vec![false, true]));
        assert_eq!(space.label("init"), Ok(vec![true, false]));
        assert_eq!(space.label("deadlock"), Ok(vec![false, false]));
        let message = space.label("dnoe").unwrap_err().to_string();
        assert!(message.contains("no label \"dnoe\""), "{message}");
    }
}
