//! The reachable states of a model and the transitions between them, in compact form.
//!
//! States are packed: a variable with range `low..=high` takes the bits that `high - low` needs, and never
//! straddles two 64-bit words. Transitions are a sparse matrix in compressed rows.
//!
//! Cost: 8 bytes per state and word, plus 4 bytes and one number per transition and one offset per state.

use std::fmt;

use prism_lang::resolved::{Variable, VariableKind};
use prism_lang::{EvalError, Expr, VarIndex};

/// A square sparse matrix in compressed sparse rows; columns of a row ascend.
#[derive(Clone, Debug, PartialEq)]
pub struct Csr<N> {
    /// Where each row starts in `column` and `value`; one entry more than there are rows.
    pub row_start: Vec<usize>,
    /// Columns of the entries, row by row.
    pub column: Vec<u32>,
    /// Values of the entries, row by row.
    pub value: Vec<N>,
}

impl<N> Csr<N> {
    /// A matrix from rows of `(column, value)`; entries must have distinct columns within a row.
    pub fn from_rows(rows: Vec<Vec<(u32, N)>>) -> Self {
        let mut matrix = Self::with_capacity(rows.len());
        for mut row in rows {
            row.sort_by_key(|(column, _)| *column);
            matrix.push_row(row);
        }
        matrix
    }

    /// A matrix without rows, with room for this many.
    pub(crate) fn with_capacity(rows: usize) -> Self {
        let mut row_start = Vec::with_capacity(rows + 1);
        row_start.push(0);
        Self {
            row_start,
            column: Vec::new(),
            value: Vec::new(),
        }
    }

    /// Appends a row whose columns ascend.
    pub(crate) fn push_row(&mut self, row: impl IntoIterator<Item = (u32, N)>) {
        for (column, value) in row {
            self.column.push(column);
            self.value.push(value);
        }
        self.row_start.push(self.column.len());
    }

    /// The number of rows.
    pub fn num_rows(&self) -> usize {
        self.row_start.len().saturating_sub(1)
    }

    /// The number of entries.
    pub fn num_entries(&self) -> usize {
        self.column.len()
    }

    /// The entries of a row: `(column, value)`, columns ascending.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, &N)> {
        let range = self.row_start[row]..self.row_start[row + 1];
        let columns = self.column[range.clone()].iter().map(|c| *c as usize);
        columns.zip(&self.value[range])
    }
}

/// Where each variable lies in a packed state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layout {
    fields: Vec<Field>,
    words: usize,
}

#[derive(Clone, Copy, Debug)]
struct Field {
    word: usize,
    shift: u32,
    mask: u64,
    low: i64,
}

impl Layout {
    pub(crate) fn new(variables: &[Variable]) -> Self {
        let (mut fields, mut word, mut used) = (Vec::with_capacity(variables.len()), 0, 0);
        for variable in variables {
            let (low, high) = variable.kind.bounds();
            let width = 64 - (high.wrapping_sub(low) as u64).leading_zeros();
            if used + width > 64 {
                (word, used) = (word + 1, 0);
            }
            fields.push(Field {
                word,
                shift: used % 64,
                mask: u64::MAX.checked_shr(64 - width).unwrap_or(0),
                low,
            });
            used += width;
        }
        Self {
            fields,
            words: word + 1,
        }
    }

    /// Words per state.
    pub(crate) fn words(&self) -> usize {
        self.words
    }

    /// Packs values that lie in their ranges.
    pub(crate) fn pack(&self, values: &[i64], packed: &mut [u64]) {
        packed.fill(0);
        for (field, value) in self.fields.iter().zip(values) {
            packed[field.word] |= (value.wrapping_sub(field.low) as u64) << field.shift;
        }
    }

    /// Overwrites one variable with a value that lies in its range.
    pub(crate) fn store(&self, variable: VarIndex, value: i64, packed: &mut [u64]) {
        let field = self.fields[variable];
        let word = &mut packed[field.word];
        *word &= !(field.mask << field.shift);
        *word |= (value.wrapping_sub(field.low) as u64) << field.shift;
    }

    pub(crate) fn unpack(&self, packed: &[u64], values: &mut [i64]) {
        for (field, value) in self.fields.iter().zip(values) {
            *value = field.value(packed);
        }
    }
}

impl Field {
    fn value(&self, packed: &[u64]) -> i64 {
        let bits = (packed[self.word] >> self.shift) & self.mask;
        self.low.wrapping_add(bits as i64)
    }
}

/// The reachable part of a model: states, initial states, deadlocks and the transition matrix.
///
/// Each row of `matrix` sums to 1 (exactly in an exact domain). States are numbered in the order of a
/// breadth-first search from the initial states, which come first.
#[derive(Clone, Debug)]
pub struct StateSpace<N> {
    /// Transition probabilities: row and column are state numbers.
    pub matrix: Csr<N>,
    pub(crate) variables: Vec<Variable>,
    pub(crate) layout: Layout,
    pub(crate) packed: Vec<u64>,
    pub(crate) initial: Vec<usize>,
    pub(crate) deadlocks: Vec<usize>,
    pub(crate) labelled_transitions: u64,
    pub(crate) labels: Vec<(String, LabelStates)>,
    /// The greatest number of roundings behind an entry of the matrix; `None` if an error is unknown.
    pub(crate) roundings: Option<u32>,
}

/// Where a label holds: by its definition, or by a list made beforehand.
#[derive(Clone, Debug)]
pub(crate) enum LabelStates {
    Defined(Expr),
    Listed(Vec<bool>),
}

impl<N> StateSpace<N> {
    /// A state space without variables, from its matrix: for models that were not written in the PRISM language.
    ///
    /// `labels` give each label's states (one flag per state).
    pub fn from_matrix(
        matrix: Csr<N>,
        initial: Vec<usize>,
        labels: Vec<(String, Vec<bool>)>,
    ) -> Self {
        let layout = Layout::new(&[]);
        let packed = vec![0; matrix.num_rows() * layout.words()];
        let labelled_transitions = matrix.num_entries() as u64;
        let listed = |(name, states)| (name, LabelStates::Listed(states));
        Self {
            matrix,
            variables: Vec::new(),
            layout,
            packed,
            initial,
            deadlocks: Vec::new(),
            labelled_transitions,
            labels: labels.into_iter().map(listed).collect(),
            roundings: Some(0),
        }
    }

    /// The number of reachable states.
    pub fn num_states(&self) -> usize {
        self.matrix.num_rows()
    }

    /// The number of pairs of states with a positive probability, self-loops of deadlocks included.
    pub fn num_transitions(&self) -> usize {
        self.matrix.num_entries()
    }

    /// The number of triples of source, target and action (commands without action count as one action): what
    /// PRISM's explicit engine reports as transitions.
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
        self.layout.fields[variable].value(&self.packed[state * words..(state + 1) * words])
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
        match self.roundings {
            None => f64::INFINITY,
            Some(0) => 0.0,
            Some(n) => {
                let nu = f64::from(n) * f64::EPSILON / 2.0;
                (nu / (1.0 - nu)).next_up().next_up()
            }
        }
    }

    /// The states in which a predicate holds: one flag per state.
    ///
    /// # Errors
    /// If the predicate has no value in some state.
    pub fn evaluate(&self, predicate: &Expr) -> Result<Vec<bool>, StateError> {
        let mut values = vec![0; self.variables.len()];
        (0..self.num_states())
            .map(|state| {
                self.state_into(state, &mut values);
                let holds = predicate.eval_bool(&values);
                holds.map_err(|error| StateError::NoValue {
                    error,
                    state: self.describe(state),
                })
            })
            .collect()
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
    use prism_lang::Span;

    fn variable(name: &str, low: i64, high: i64) -> Variable {
        Variable {
            name: name.to_owned(),
            module: None,
            kind: VariableKind::Int { low, high },
            init: low,
            span: Span::default(),
        }
    }

    #[test]
    fn packing_keeps_values_at_the_ends_of_every_range() {
        let variables = [
            variable("fixed", 7, 7),
            variable("small", -3, 4),
            variable("wide", i64::MIN, i64::MAX),
            variable("half", 0, i64::MAX),
            variable("last", -1, 0),
        ];
        let layout = Layout::new(&variables);
        assert_eq!(layout.words(), 3);
        let lows: Vec<i64> = variables.iter().map(|v| v.kind.bounds().0).collect();
        let highs: Vec<i64> = variables.iter().map(|v| v.kind.bounds().1).collect();
        for values in [lows, highs, vec![7, 0, -1, 1, -1]] {
            let mut packed = vec![u64::MAX; layout.words()];
            layout.pack(&values, &mut packed);
            let mut unpacked = vec![0; values.len()];
            layout.unpack(&packed, &mut unpacked);
            assert_eq!(unpacked, values);
        }
    }

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
