//! Loads segments a little ahead of those that are read, on a second thread.
//!
//! Segments are loaded in the order in which they are queued, and each is taken when it would have
//! been loaded without the thread: what is read, what is lost and when that is noted do not depend
//! on it. The thread ends with its [`Ahead`]. Where no thread can be had, or there is but one segment to
//! load, segments are loaded when they are taken.
//!
//! Memory: at most [`MOST_SEGMENTS`] segments, and [`MOST_BYTES`] unless one alone is larger.

use std::collections::VecDeque;
use std::io::{self, Read, Seek};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};

use super::loader::{Loaded, Loader};
use super::walk::Segment;

/// The most segments that are loaded ahead.
const MOST_SEGMENTS: usize = 3;
/// The most bytes, decompressed, that are loaded ahead.
const MOST_BYTES: u64 = 64 << 20;

/// Segments that are loaded, or will be.
pub(super) struct Ahead<R> {
    /// Loads in this thread, until there is another one.
    here: Option<Loader<R>>,
    worker: Option<Worker>,
    /// Whether starting another thread was not tried yet.
    may_start: bool,
    queue: VecDeque<Queued>,
    /// How many of the queue are to be loaded, and their bytes.
    wanted: usize,
    wanted_bytes: u64,
    /// Memory for segments to come.
    spare: Vec<Loaded>,
}

/// A segment in the queue.
struct Queued {
    segment: Segment,
    /// Whether it is to be loaded; others are only kept in their place.
    is_wanted: bool,
}

/// The second thread.
struct Worker {
    jobs: Option<Sender<(Segment, Loaded)>>,
    done: Receiver<io::Result<Loaded>>,
    thread: Option<JoinHandle<()>>,
}

impl<R: Read + Seek + Send + 'static> Ahead<R> {
    pub(super) fn new(loader: Loader<R>) -> Self {
        Ahead {
            here: Some(loader),
            worker: None,
            may_start: true,
            queue: VecDeque::new(),
            wanted: 0,
            wanted_bytes: 0,
            spare: Vec::new(),
        }
    }

    /// Loads on a second thread from now on, if one can be had.
    pub(super) fn start(&mut self) {
        if !self.may_start || !self.queue.is_empty() {
            return;
        }
        self.may_start = false;
        let (handover, begin) = channel::<Loader<R>>();
        let (jobs, asked) = channel();
        let (answer, done) = channel();
        let spawned = thread::Builder::new()
            .name("mcap reader".to_owned())
            .spawn(move || {
                if let Ok(loader) = begin.recv() {
                    serve(loader, &asked, &answer);
                }
            });
        if let (Ok(thread), Some(loader)) = (spawned, self.here.take()) {
            // The thread waits for it, so it cannot be gone.
            let _ = handover.send(loader);
            self.worker = Some(Worker {
                jobs: Some(jobs),
                done,
                thread: Some(thread),
            });
        }
    }

    /// Never starts a thread.
    #[cfg(test)]
    pub(super) fn stay_here(&mut self) {
        self.may_start = false;
    }

    /// Whether `next` may be queued now.
    pub(super) fn has_room(&self, next: &Segment) -> bool {
        match (&self.worker, self.wanted) {
            (_, 0) => true,
            (None, _) => false,
            (Some(_), wanted) => {
                let bytes = self.wanted_bytes.saturating_add(next.memory_bytes());
                wanted < MOST_SEGMENTS && bytes <= MOST_BYTES
            }
        }
    }

    /// Puts a segment at the end of the queue.
    pub(super) fn push(&mut self, segment: Segment, is_wanted: bool) {
        if is_wanted {
            self.wanted += 1;
            self.wanted_bytes = self.wanted_bytes.saturating_add(segment.memory_bytes());
            if let Some(jobs) = self.worker.as_ref().and_then(|worker| worker.jobs.as_ref()) {
                let memory = self.spare.pop().unwrap_or_default();
                // A thread that is gone is noticed where its answer is waited for.
                let _ = jobs.send((segment.clone(), memory));
            }
        }
        self.queue.push_back(Queued { segment, is_wanted });
    }

    /// The segment that was queued first.
    pub(super) fn front(&self) -> Option<&Segment> {
        self.queue.front().map(|queued| &queued.segment)
    }

    /// Takes the segment that was queued first, with what it holds if it is wanted.
    ///
    /// # Errors
    /// What the operating system says.
    pub(super) fn pop(&mut self) -> io::Result<Option<(Segment, Option<Loaded>)>> {
        let Some(Queued { segment, is_wanted }) = self.queue.pop_front() else {
            return Ok(None);
        };
        if !is_wanted {
            return Ok(Some((segment, None)));
        }
        self.wanted -= 1;
        self.wanted_bytes = self.wanted_bytes.saturating_sub(segment.memory_bytes());
        let loaded = match (&mut self.worker, &mut self.here) {
            (Some(worker), _) => worker.answer()?,
            (None, Some(loader)) => {
                let mut loaded = self.spare.pop().unwrap_or_default();
                loader.load(&segment, &mut loaded)?;
                loaded
            }
            (None, None) => Loaded::default(),
        };
        Ok(Some((segment, Some(loaded))))
    }

    /// Empties the queue; what was loaded is forgotten.
    pub(super) fn clear(&mut self) -> Vec<Segment> {
        let mut segments = Vec::new();
        while let Some(Queued { segment, is_wanted }) = self.queue.pop_front() {
            if let (true, Some(worker)) = (is_wanted, &mut self.worker) {
                // An error will come again when the segment is loaded again.
                self.spare.extend(worker.answer().ok());
            }
            segments.push(segment);
        }
        (self.wanted, self.wanted_bytes) = (0, 0);
        segments
    }

    /// Takes memory back to use it again.
    pub(super) fn reuse(&mut self, loaded: Loaded) {
        if self.spare.len() <= MOST_SEGMENTS {
            self.spare.push(loaded);
        }
    }
}

fn serve<R: Read + Seek>(
    mut loader: Loader<R>,
    asked: &Receiver<(Segment, Loaded)>,
    answer: &Sender<io::Result<Loaded>>,
) {
    while let Ok((segment, mut loaded)) = asked.recv() {
        let done = loader.load(&segment, &mut loaded).map(|()| loaded);
        if answer.send(done).is_err() {
            return;
        }
    }
}

impl Worker {
    /// Waits for the next answer. A fault of the thread becomes one of this thread.
    fn answer(&mut self) -> io::Result<Loaded> {
        match self.done.recv() {
            Ok(answer) => answer,
            Err(_) => match self.thread.take().map(JoinHandle::join) {
                Some(Err(fault)) => std::panic::resume_unwind(fault),
                _ => Err(io::Error::other("the thread that reads the file has ended")),
            },
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.jobs = None;
        if let Some(thread) = self.thread.take() {
            // Nobody waits for an answer any more, so a fault changes nothing.
            let _ = thread.join();
        }
    }
}
