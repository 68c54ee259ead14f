//! The processor time of programs that an episode starts.
//!
//! A robot's program is part of what an episode costs, so it counts in "times real time", as the
//! thread's own time does. The system keeps it for each process, with that of the children whose end it
//! has seen, and forgets it when we are told of the process's end: it is read before that.

use crate::group::Group;
use std::cell::Cell;
use std::ops::{Deref, DerefMut};

/// What `/proc` counts processor time in: `USER_HZ`, which is 100 on every Linux of x86-64 and ARM.
const TICKS_PER_SEC: f64 = 100.0;

thread_local! {
    /// Of all processes whose end this thread has waited for.
    static OF_PROCESSES: Cell<f64> = const { Cell::new(0.0) };
}

/// Processor seconds of this thread, and of the processes whose end it has waited for; `None` where the system is not asked.
pub fn used_secs() -> Option<f64> {
    Some(of_thread()? + OF_PROCESSES.get())
}

#[cfg(unix)]
fn of_thread() -> Option<f64> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Some(time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9)
}

/// Elsewhere a thread's time cannot be had without unsafe code of ours.
#[cfg(not(unix))]
fn of_thread() -> Option<f64> {
    None
}

/// A program of ours, whose processor time counts for the thread that drops it. Programs that were started elsewhere, and
/// children whose end nobody has waited for, do not count: the system does not tell.
pub(crate) struct Counted(pub(crate) Group);

impl Deref for Counted {
    type Target = Group;

    fn deref(&self) -> &Group {
        &self.0
    }
}

impl DerefMut for Counted {
    fn deref_mut(&mut self) -> &mut Group {
        &mut self.0
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        OF_PROCESSES.set(OF_PROCESSES.get() + self.0.processor_secs());
    }
}

/// Processor seconds of a process and its ended children so far; `None` if the system does not tell, as all but Linux.
pub(crate) fn of_process(id: u32) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    ticks(&text).map(|ticks| ticks as f64 / TICKS_PER_SEC)
}

/// The fields `utime`, `stime`, `cutime` and `cstime` of proc(5): the 12th to the 15th after the name, which stands in
/// parentheses and may hold anything.
fn ticks(stat: &str) -> Option<u64> {
    let (_, fields) = stat.rsplit_once(')')?;
    let times: Vec<u64> = fields
        .split_whitespace()
        .skip(11)
        .take(4)
        .filter_map(|field| field.parse().ok())
        .collect();
    (times.len() == 4).then(|| times.iter().sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_found_after_a_name_with_parentheses() {
        let stat = "7 (a ) b) S 1 7 7 0 -1 4194304 10 20 30 40 12 3 40 5 20 0 1 0 99 1 2";
        assert_eq!(ticks(stat), Some(60));
        assert_eq!(ticks("7 (a"), None);
        assert_eq!(
            of_process(std::process::id()).is_some(),
            cfg!(target_os = "linux")
        );
    }
}
