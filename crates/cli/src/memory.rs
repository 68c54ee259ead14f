//! A limit of memory, so that a model that is too large ends with a message and is not killed.
//!
//! A thread looks every few milliseconds at what the process holds, as Linux tells it; elsewhere there is no limit. Of the limit
//! [`TO_STOP`] may be taken before the work is asked to stop, the rest is for what it takes to give the bounds reached.
//! Halfway through the rest it is asked to give up without bounds. Some steps of the work ask nobody, and may take more than is
//! left: at the limit the thread itself says so and ends the process, since the other end is to be killed without a
//! message. Files are written whole or not at all, so nothing is left half done.

mod allocator;
mod available;

use crate::shown_problem::{exit_code, rendered};
use crate::terminal::to_stderr;
use available::available_bytes;
use diagnostic::Problem;
use host::MemoryBudget;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// The limit, and how near it is.
#[derive(Debug)]
pub struct Memory {
    limit: Option<Limit>,
    state: Arc<State>,
}

/// What the watching thread and the work tell each other.
#[derive(Debug, Default)]
struct State {
    must_stop: AtomicBool,
    must_give_up: AtomicBool,
    is_over: AtomicBool,
}

/// A limit, in units of 10^9 bytes.
#[derive(Clone, Copy, Debug)]
struct Limit {
    gigabytes: f64,
    is_default: bool,
}

/// Time between two looks.
const BETWEEN_LOOKS: Duration = Duration::from_millis(5);
/// The part of what is free that may be taken by default.
const PART: f64 = 0.9;
/// The part of the limit at which the work is asked to stop.
const TO_STOP: f64 = 0.8;
/// Gigabytes that there are at least between that and the end of the process.
const LEAST_REST: f64 = 0.1;

impl Memory {
    /// Without a limit.
    pub fn unlimited() -> Self {
        Self {
            limit: None,
            state: Arc::default(),
        }
    }

    /// With a limit, in units of 10^9 bytes; by default what is held now and a part of what is free.
    pub fn new(asked: Option<f64>) -> Self {
        let by_default = || {
            let free = available_bytes()? as f64 / 1e9;
            Some(resident_gigabytes()? + PART * free)
        };
        let limit = asked.or_else(by_default).map(|gigabytes| Limit {
            gigabytes,
            is_default: asked.is_none(),
        });
        let state = Arc::<State>::default();
        let is_told = |limit: &Limit| look(*limit, &state).is_some();
        let limit = limit.filter(is_told);
        if let Some(limit) = limit {
            let state = state.clone();
            // Without the thread the work could not be ended; it goes on without a limit, as elsewhere.
            let _ = std::thread::Builder::new().spawn(move || watch(limit, &state));
        }
        Self { limit, state }
    }

    /// Whether there is a limit.
    pub fn is_watched(&self) -> bool {
        self.limit.is_some()
    }
}

impl MemoryBudget for Memory {
    fn must_stop(&self) -> bool {
        self.state.must_stop.load(Ordering::Relaxed)
    }

    fn must_give_up(&self) -> bool {
        self.state.must_give_up.load(Ordering::Relaxed)
    }

    fn physics_begins(&self) {
        // Elsewhere than on Linux with its usual C library there is nothing to set.
        let _ = allocator::give_large_blocks_back();
    }

    fn problem(&self, doing: &str) -> Problem {
        match self.limit {
            Some(limit) => limit.problem(doing),
            None => host::Unlimited.problem(doing),
        }
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        self.state.is_over.store(true, Ordering::Relaxed);
    }
}

impl Limit {
    /// What may be held before the work is asked to stop.
    fn stop(self) -> f64 {
        TO_STOP * self.gigabytes
    }

    /// What may be held before the process is ended.
    fn end(self) -> f64 {
        self.gigabytes.max(self.stop() + LEAST_REST)
    }

    fn problem(self, doing: &str) -> Problem {
        let gigabytes = self.gigabytes;
        let limit = match self.is_default {
            true => format!("{gigabytes:.1} GB of memory that were free"),
            false => format!("{gigabytes} GB of memory that it may take"),
        };
        let message = format!("the work needs more than the {limit}{doing}");
        Problem::undecided("memory-limit", message)
            .remedy("raise --memory-limit, or make the model smaller, for example by its constants")
    }
}

/// Looks at what is held until the command is over.
fn watch(limit: Limit, state: &State) {
    while !state.is_over.load(Ordering::Relaxed) {
        let Some(held) = look(limit, state) else {
            return;
        };
        if held > limit.end() {
            let doing = " in a step that could not be stopped";
            let problem = limit.problem(doing);
            to_stderr(&rendered(&problem, false));
            std::process::exit(i32::from(exit_code(&problem)));
        }
        std::thread::sleep(BETWEEN_LOOKS);
    }
}

/// What is held, if that is told; the work is asked to stop if it is too much.
fn look(limit: Limit, state: &State) -> Option<f64> {
    let held = resident_gigabytes()?;
    if held > limit.stop() {
        state.must_stop.store(true, Ordering::Relaxed);
    }
    if held > 0.5 * (limit.stop() + limit.end()) {
        state.must_give_up.store(true, Ordering::Relaxed);
    }
    Some(held)
}

/// What the process holds in memory, in units of 10^9 bytes.
fn resident_gigabytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024.0 / 1e9)
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use super::*;

    #[test]
    fn a_limit_that_is_passed_stops_the_work() {
        let memory = Memory::new(Some(1e6));
        assert!(memory.is_watched() && !memory.must_stop());
        memory.state.must_stop.store(true, Ordering::Relaxed);
        assert!(memory.must_stop());
        let problem = memory.problem("");
        assert_eq!((problem.code, exit_code(&problem)), ("memory-limit", 3));
        let by_default = Memory::new(None).limit.expect("Linux tells what is free");
        assert!(by_default.is_default && by_default.gigabytes > 0.0);
    }
}
