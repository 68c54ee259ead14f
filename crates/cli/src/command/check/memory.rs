//! A limit of memory, so that a model that is too large ends with a message.
//!
//! What the process holds is looked at between steps of the work, as Linux tells it; elsewhere there is no limit.
//! The last step before a look may go beyond the limit by what it needs.

use crate::problem::Problem;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

/// The limit, and whether it was passed.
#[derive(Debug)]
pub(super) struct Memory {
    limit_gigabytes: Option<f64>,
    is_passed: AtomicBool,
    /// When to look again, in milliseconds since the start.
    next_look: AtomicU64,
    start: Instant,
}

/// Milliseconds between two looks: some work asks after every few operations.
const BETWEEN_LOOKS: u64 = 5;

impl Memory {
    pub fn new(limit_gigabytes: Option<f64>) -> Self {
        Self {
            limit_gigabytes,
            is_passed: AtomicBool::new(false),
            next_look: AtomicU64::new(0),
            start: Instant::now(),
        }
    }

    /// Whether the limit is passed now, or was before.
    pub fn is_passed(&self) -> bool {
        let Some(limit) = self.limit_gigabytes else {
            return false;
        };
        let now = self.start.elapsed().as_millis() as u64;
        if now >= self.next_look.load(Ordering::Relaxed) {
            self.next_look.store(now + BETWEEN_LOOKS, Ordering::Relaxed);
            if resident_gigabytes().is_some_and(|held| held > limit) {
                self.is_passed.store(true, Ordering::Relaxed);
            }
        }
        self.is_passed.load(Ordering::Relaxed)
    }

    /// What ended the work: the limit, if it was passed, in place of an interruption.
    ///
    /// What the interruption says of how far the work came is kept.
    pub fn instead_of(&self, problem: Problem) -> Problem {
        if !(problem.is_interruption() && self.is_passed.load(Ordering::Relaxed)) {
            return problem;
        }
        let limit = self.limit_gigabytes.unwrap_or_default();
        let doing = problem.message().split_once(" while ");
        let doing = doing.map_or(String::new(), |(_, doing)| format!(" while {doing}"));
        let message =
            format!("the work needs more than the {limit} GB of memory that it may take{doing}");
        Problem::new("memory-limit", message)
            .remedy("raise --memory-limit, or make the model smaller, for example by its constants")
    }
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
mod tests {
    use super::*;

    #[test]
    fn a_limit_that_is_passed_is_the_problem() {
        assert!(!Memory::new(None).is_passed());
        let memory = Memory::new(Some(1e-6));
        assert!(memory.is_passed() || !cfg!(target_os = "linux"));
        if cfg!(target_os = "linux") {
            let problem = memory.instead_of(Problem::interrupted());
            assert_eq!(problem.code, "memory-limit");
        }
        let other = memory.instead_of(Problem::new("bad-form", "another"));
        assert_eq!(other.code, "bad-form");
    }
}
