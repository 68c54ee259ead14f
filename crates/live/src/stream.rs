//! A listening thread and its queue, as one [`Source`]. Both transports give this type.

use crate::queue::Queue;
use crate::{Clock, Incoming, LiveError, Source, Topic, Totals};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

/// A live connection: see [`Source`].
pub struct LiveStream {
    queue: Arc<Queue>,
    stop: Arc<AtomicBool>,
    worker: Option<JoinHandle<()>>,
}

/// What a worker needs: where to put things, and whether to go on.
pub(crate) struct Outlet {
    pub(crate) queue: Arc<Queue>,
    stop: Arc<AtomicBool>,
}

impl Outlet {
    /// Whether the caller wants the worker to end.
    pub(crate) fn stopped(&self) -> bool {
        self.stop.load(Ordering::Acquire)
    }
}

impl Drop for Outlet {
    /// However the worker ends, the caller must not wait for ever. An end that was reported before counts.
    fn drop(&mut self) {
        let reason = if self.stopped() {
            "it was stopped"
        } else {
            "its thread ended unexpectedly"
        };
        self.queue.end(LiveError::Transport(reason.to_owned()));
    }
}

impl LiveStream {
    /// Runs `work` in a thread called `name` until it returns.
    pub(crate) fn start(
        name: &str,
        queue: Arc<Queue>,
        work: impl FnOnce(Outlet) + Send + 'static,
    ) -> Result<Self, LiveError> {
        let stop = Arc::new(AtomicBool::new(false));
        let outlet = Outlet {
            queue: queue.clone(),
            stop: stop.clone(),
        };
        let worker = std::thread::Builder::new()
            .name(name.to_owned())
            .spawn(move || work(outlet))
            .map_err(|error| {
                LiveError::Transport(format!("no thread could be started: {error}"))
            })?;
        Ok(Self {
            queue,
            stop,
            worker: Some(worker),
        })
    }
}

impl Source for LiveStream {
    fn next(&mut self, timeout: Duration) -> Result<Option<Incoming>, LiveError> {
        self.queue.pop(timeout)
    }

    fn topics(&self) -> Vec<Arc<Topic>> {
        self.queue.topics()
    }

    fn totals(&self) -> Totals {
        self.queue.totals()
    }

    fn clock(&self) -> Clock {
        self.queue.clock
    }

    fn stop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(worker) = self.worker.take() {
            // A worker that panicked has already ended the queue with an error.
            let _ = worker.join();
        }
    }
}

impl Drop for LiveStream {
    fn drop(&mut self) {
        self.stop();
    }
}
