//! How a [`Problem`] becomes `corroborate.Problem`, and a panic `corroborate.InternalError`.

use diagnostic::{Kind, Problem};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The module of the package that has the exceptions.
const EXCEPTIONS: &str = "corroborate._problem";

static PROBLEM: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static INTERNAL_ERROR: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// The exception for a problem: `KeyboardInterrupt` if the user interrupted the work.
pub(crate) fn raised(problem: Problem) -> PyErr {
    Python::attach(|py| {
        if problem.is_interruption() {
            return PyKeyboardInterrupt::new_err(problem.message().to_owned());
        }
        let problem = problem.in_words(&crate::words::in_python);
        instance(py, &problem).map_or_else(|error| error, PyErr::from_value)
    })
}

/// The same for what has a message alone.
pub(crate) fn raised_input(code: &'static str, message: impl ToString, remedy: &str) -> PyErr {
    raised(Problem::new(code, message.to_string()).remedy(remedy))
}

fn instance<'py>(py: Python<'py>, problem: &Problem) -> PyResult<Bound<'py, PyAny>> {
    let class = PROBLEM.import(py, EXCEPTIONS, "Problem")?;
    let related = problem.others().iter().map(|other| instance(py, other));
    let related = related.collect::<PyResult<Vec<_>>>()?;
    let place = problem.place();
    class.call1((
        problem.code,
        problem.message(),
        problem.file(),
        place.map(|place| place.line),
        place.map(|place| place.column),
        problem.what_to_do(),
        related,
        kind(problem.kind()),
        problem.to_string(),
    ))
}

fn kind(kind: Kind) -> &'static str {
    match kind {
        Kind::Input => "input",
        Kind::DataLost => "data-lost",
        Kind::Undecided => "undecided",
        Kind::Interrupted => "interrupted",
    }
}

/// Calls `work`; a panic becomes `corroborate.InternalError`.
pub(crate) fn guarded<T>(work: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|cause| Err(panicked(&*cause)))
}

/// The exception for a panic: it is a mistake of ours, whatever the input was.
pub(crate) fn panicked(cause: &(dyn Any + Send)) -> PyErr {
    let said = (cause.downcast_ref::<&str>().copied())
        .or_else(|| cause.downcast_ref::<String>().map(String::as_str));
    let said = said.unwrap_or("it said nothing");
    Python::attach(|py| {
        let class = INTERNAL_ERROR.import(py, EXCEPTIONS, "InternalError");
        let made = class.and_then(|class| class.call1((said,)));
        made.map_or_else(|error| error, PyErr::from_value)
    })
}
