//! Long work: on a thread of its own and without the interpreter's lock, so that other threads of Python go on, while the
//! calling thread looks for signals, so that Ctrl-C ends the work through [`Cancel`](host::Cancel).

use crate::problem::{panicked, raised};
use diagnostic::Problem;
use host::{Event, Events, Host};
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How often the calling thread looks for signals.
const LOOK_EVERY: Duration = Duration::from_millis(20);
/// The stack of the working thread: as large as that of a main thread.
const STACK_BYTES: usize = 8 << 20;

/// What the callback of Python raised first.
type Raised = Arc<Mutex<Option<PyErr>>>;

/// Carries out `work` with a host whose events go to `progress`, called with a dictionary each. What the callback raises ends
/// the work and is raised by it.
pub(crate) fn carried_out<T: Send>(
    py: Python<'_>,
    host: Host,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&Host) -> Result<T, Problem> + Send,
) -> PyResult<T> {
    let raised_by_callback = Raised::default();
    let host = Host {
        events: events(&host, progress, &raised_by_callback),
        ..host
    };
    let (outcome, interrupt) = py.detach(|| waited_for(&host, work));
    let first = (raised_by_callback.lock()).unwrap_or_else(PoisonError::into_inner);
    let first = { first }.take();
    match (first.or(interrupt), outcome) {
        (Some(error), _) => Err(error),
        (None, Ok(Ok(done))) => Ok(done),
        (None, Ok(Err(problem))) => Err(raised(problem)),
        (None, Err(error)) => Err(error),
    }
}

/// What the work gave, and what a signal raised meanwhile.
fn waited_for<T: Send>(
    host: &Host,
    work: impl FnOnce(&Host) -> Result<T, Problem> + Send,
) -> (PyResult<Result<T, Problem>>, Option<PyErr>) {
    let (done, outcome) = channel();
    let mut interrupt = None;
    let found = std::thread::scope(|scope| {
        let worker = std::thread::Builder::new().stack_size(STACK_BYTES);
        let begun = worker.spawn_scoped(scope, || {
            let found = catch_unwind(AssertUnwindSafe(|| work(host)));
            // The receiver waits for it as long as this thread is there.
            let _ = done.send(found);
        });
        if let Err(error) = begun {
            let message = format!("no thread could be started: {error}");
            return Ok(Err(Problem::undecided("no-thread", message)));
        }
        loop {
            match outcome.recv_timeout(LOOK_EVERY) {
                Ok(Ok(found)) => return Ok(found),
                Ok(Err(cause)) => return Err(panicked(&*cause)),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Err(panicked(&"a thread ended")),
            }
            if interrupt.is_none() {
                interrupt = Python::attach(|py| py.check_signals()).err();
                if interrupt.is_some() {
                    host.cancel.cancel();
                }
            }
        }
    });
    (found, interrupt)
}

fn events(host: &Host, progress: Option<Py<PyAny>>, raised: &Raised) -> Events {
    let Some(progress) = progress else {
        return Events::none();
    };
    let (cancel, raised) = (host.cancel.clone(), raised.clone());
    Events::new(move |event| {
        let told = Python::attach(|py| tell(py, &progress, &event));
        if let Err(error) = told {
            cancel.cancel();
            let mut first = raised.lock().unwrap_or_else(PoisonError::into_inner);
            first.get_or_insert(error);
        }
    })
}

fn tell(py: Python<'_>, progress: &Py<PyAny>, event: &Event) -> PyResult<()> {
    let event = pythonize::pythonize(py, event)?;
    progress.call1(py, (event,)).map(drop)
}
