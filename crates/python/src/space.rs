//! The states of a model as arrays of NumPy: each is made once, when it is first asked for, and then shared.

use crate::problem::{guarded, raised_input};
use checker::state_space::{StateSpace as Space, TransitionRewards};
use numpy::{PyArray1, PyArrayMethods, ToPyArray};
use prism_lang::resolved::{self, VariableKind};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;

/// The states of a model; use `corroborate.StateSpace`.
#[pyclass(module = "corroborate._engine", frozen)]
pub(crate) struct StateSpace {
    space: Space<f64>,
    labels: Vec<String>,
    rewards: Vec<Option<String>>,
    matrix: PyOnceLock<Matrix>,
}

/// Starts of the rows, columns, values, and starts of the choices of each state (nothing in a chain).
type Matrix = (
    Py<PyArray1<i64>>,
    Py<PyArray1<i64>>,
    Py<PyArray1<f64>>,
    Option<Py<PyArray1<i64>>>,
);

impl StateSpace {
    pub(crate) fn new(space: Space<f64>, model: &resolved::Model) -> Self {
        Self {
            space,
            labels: model.labels.iter().map(|(name, _)| name.clone()).collect(),
            rewards: (model.rewards.iter()).map(|it| it.name.clone()).collect(),
            matrix: PyOnceLock::new(),
        }
    }

    fn state_exists(&self, state: usize) -> PyResult<usize> {
        let count = self.space.num_states();
        (state < count).then_some(state).ok_or_else(|| {
            let message = format!("there is no state {state}");
            raised_input(
                "bad-state",
                message,
                &format!("the states are 0 to {}", count - 1),
            )
        })
    }
}

#[pymethods]
impl StateSpace {
    fn __len__(&self) -> usize {
        self.space.num_states()
    }

    #[getter]
    fn kind(&self) -> &'static str {
        self.space.kind.keyword()
    }

    #[getter]
    fn num_choices(&self) -> usize {
        self.space.num_choices()
    }

    #[getter]
    fn num_transitions(&self) -> usize {
        self.space.num_transitions()
    }

    #[getter]
    fn initial(&self) -> Vec<usize> {
        self.space.initial_states().to_vec()
    }

    #[getter]
    fn deadlocks(&self) -> Vec<usize> {
        self.space.deadlocks().to_vec()
    }

    #[getter]
    fn label_names(&self) -> Vec<String> {
        self.labels.clone()
    }

    #[getter]
    fn reward_names(&self) -> Vec<Option<String>> {
        self.rewards.clone()
    }

    fn matrix(&self, py: Python<'_>) -> Matrix {
        let made = self.matrix.get_or_init(py, || {
            let whole = |numbers: &[usize]| numbers.iter().map(|it| *it as i64).collect::<Vec<_>>();
            let matrix = &self.space.matrix;
            let columns: Vec<i64> = matrix.column.iter().map(|it| i64::from(*it)).collect();
            let starts = &self.space.choice_start;
            let choices = (!starts.is_empty()).then(|| read_only(py, whole(starts)));
            let rows = read_only(py, whole(&matrix.row_start));
            (
                rows,
                read_only(py, columns),
                read_only(py, matrix.value.clone()),
                choices,
            )
        });
        let (rows, columns, values, choices) = made;
        let choices = choices.as_ref().map(|it| it.clone_ref(py));
        (
            rows.clone_ref(py),
            columns.clone_ref(py),
            values.clone_ref(py),
            choices,
        )
    }

    /// The action of each choice, by name; none of a choice without one, and nothing in a chain.
    fn actions(&self) -> Vec<Option<&str>> {
        if self.space.choice_start.is_empty() {
            return Vec::new();
        }
        let name = |choice| {
            self.space
                .action(choice)
                .map(|it| self.space.actions()[it].as_str())
        };
        (0..self.space.num_choices()).map(name).collect()
    }

    /// The values of each variable in all states.
    fn valuations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = PyDict::new(py);
        for (place, variable) in self.space.variables().iter().enumerate() {
            let values = (0..self.space.num_states()).map(|state| self.space.value(state, place));
            match variable.kind {
                VariableKind::Bool => {
                    let values: Vec<bool> = values.map(|value| value != 0).collect();
                    found.set_item(&variable.name, values.to_pyarray(py))?;
                }
                VariableKind::Int { .. } | VariableKind::Unbounded => {
                    let values: Vec<i64> = values.collect();
                    found.set_item(&variable.name, values.to_pyarray(py))?;
                }
            }
        }
        Ok(found)
    }

    fn describe(&self, state: usize) -> PyResult<String> {
        let state = self.state_exists(state)?;
        guarded(|| Ok(self.space.describe(state)))
    }

    /// Whether the label holds, for each state.
    fn label<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let held = guarded(|| {
            let held = self.space.label(name);
            held.map_err(|error| raised_input("unknown-label", error, &self.known_labels()))
        })?;
        Ok(PyArray1::from_vec(py, held))
    }

    /// What each state earns, and each transition in the order of the matrix (nothing if none does).
    #[allow(clippy::type_complexity)]
    fn reward<'py>(
        &self,
        py: Python<'py>,
        place: usize,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Option<Bound<'py, PyArray1<f64>>>)> {
        let rewards = (self.space.rewards(place)).map_err(|error| {
            raised_input("bad-rewards", error, "correct the reward that is named")
        })?;
        let state = rewards.state.to_pyarray(py);
        let transition = match &rewards.transition {
            TransitionRewards::None => None,
            TransitionRewards::Entry(entries) => Some(entries.to_pyarray(py)),
            TransitionRewards::Row(rows) => {
                let starts = &self.space.matrix.row_start;
                let entries = rows.iter().zip(starts.windows(2));
                let entries = entries.flat_map(|(value, ends)| vec![*value; ends[1] - ends[0]]);
                Some(entries.collect::<Vec<f64>>().to_pyarray(py))
            }
        };
        Ok((state, transition))
    }

    /// A random path: the times (steps, or units of time) and the states; nothing of a model with choices.
    #[allow(clippy::type_complexity)]
    fn path<'py>(
        &self,
        py: Python<'py>,
        seed: u64,
        max_steps: u64,
    ) -> PyResult<Option<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<i64>>)>> {
        let path =
            py.detach(|| guarded(|| Ok(checker::sample_path(&self.space, seed, max_steps))))?;
        Ok(path.map(|path| {
            let times: Vec<f64> = path.iter().map(|visit| visit.time).collect();
            let states: Vec<i64> = path.iter().map(|visit| visit.state as i64).collect();
            (
                PyArray1::from_vec(py, times),
                PyArray1::from_vec(py, states),
            )
        }))
    }
}

impl StateSpace {
    fn known_labels(&self) -> String {
        let names = self.labels.iter().map(String::as_str);
        let names: Vec<&str> = names.chain(["init", "deadlock"]).collect();
        format!("the labels are {}", names.join(", "))
    }
}

/// An array that shares the memory of a list and cannot be written: it is given to several callers.
fn read_only<T: numpy::Element>(py: Python<'_>, values: Vec<T>) -> Py<PyArray1<T>> {
    let array = PyArray1::from_vec(py, values);
    array.readwrite().make_nonwriteable();
    array.unbind()
}
