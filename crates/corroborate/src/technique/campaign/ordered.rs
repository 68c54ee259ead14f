//! Work in parallel whose results are taken in order.
//!
//! # Definition
//! For numbers a, a+1, ... each thread takes the next one and works on it; the results are taken
//! one at a time in the order of the numbers, whichever is done first. Taking may end it: the
//! results behind that are dropped, so what has been taken is the prefix a..=n for some n that does
//! not depend on the number of threads or on their speed.
//!
//! # Assumes
//! Nothing of the data.
//!
//! # Cost and guarantee
//! No number is begun that is [`AHEAD`] or more beyond the next one to be taken, so at most that
//! many results wait: memory does not grow with the count. A failure ends it; if several fail, the
//! one that is met first ends it.

use diagnostic::Problem;
use std::collections::BTreeMap;
use std::ops::{ControlFlow, Range};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// How far work may run ahead of what has been taken.
const AHEAD: u64 = 1024;

/// Works on `numbers` in `threads` threads and gives each result to `take`, in order. Each thread
/// makes a value of its own by `begin`, which `work` may change.
pub fn in_order<S, T: Send>(
    numbers: Range<u64>,
    threads: usize,
    begin: impl Fn() -> S + Sync,
    work: impl Fn(&mut S, u64) -> Result<T, Problem> + Sync,
    take: impl FnMut(u64, T) -> Result<ControlFlow<()>, Problem> + Send,
) -> Result<(), Problem> {
    let line = Line {
        state: Mutex::new(State {
            next: numbers.start,
            end: numbers.end,
            taken: numbers.start,
            waiting: BTreeMap::new(),
            failed: None,
            take,
        }),
        moved: Condvar::new(),
    };
    let one_thread = || {
        let mut own = begin();
        while let Some(number) = line.next() {
            line.done(number, work(&mut own, number));
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads.max(1) {
            scope.spawn(one_thread);
        }
        one_thread();
    });
    let state = line.state.into_inner();
    match state.unwrap_or_else(PoisonError::into_inner).failed {
        Some(problem) => Err(problem),
        None => Ok(()),
    }
}

struct Line<T, F> {
    state: Mutex<State<T, F>>,
    /// Notified when something was taken, or all is over.
    moved: Condvar,
}

struct State<T, F> {
    /// The next number to begin.
    next: u64,
    /// No number from here on is begun or taken.
    end: u64,
    /// The next number to take.
    taken: u64,
    waiting: BTreeMap<u64, T>,
    failed: Option<Problem>,
    take: F,
}

impl<T, F: FnMut(u64, T) -> Result<ControlFlow<()>, Problem>> Line<T, F> {
    fn lock(&self) -> MutexGuard<'_, State<T, F>> {
        // A panic in another thread is passed on when the threads are joined.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next number to work on; waits while work is too far ahead.
    fn next(&self) -> Option<u64> {
        let mut state = self.lock();
        loop {
            if state.next >= state.end {
                return None;
            }
            if state.next - state.taken < AHEAD {
                state.next += 1;
                return Some(state.next - 1);
            }
            state = self
                .moved
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Keeps a result, and takes all whose turn has come.
    fn done(&self, number: u64, result: Result<T, Problem>) {
        let mut state = self.lock();
        match result {
            Ok(value) => {
                state.waiting.insert(number, value);
                state.take_all();
            }
            Err(problem) => state.fail(problem),
        }
        drop(state);
        self.moved.notify_all();
    }
}

impl<T, F: FnMut(u64, T) -> Result<ControlFlow<()>, Problem>> State<T, F> {
    fn take_all(&mut self) {
        while self.taken < self.end {
            let Some(value) = self.waiting.remove(&self.taken) else {
                return;
            };
            let number = self.taken;
            self.taken += 1;
            match (self.take)(number, value) {
                Ok(ControlFlow::Continue(())) => {}
                Ok(ControlFlow::Break(())) => self.end = self.taken,
                Err(problem) => self.fail(problem),
            }
        }
        self.waiting.clear();
    }

    fn fail(&mut self, problem: Problem) {
        // Work beyond the end is of no interest, and so are its failures.
        if self.taken < self.end && self.failed.is_none() {
            self.failed = Some(problem);
        }
        self.end = self.taken;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    /// Lets later numbers be done first.
    fn slowly(number: u64) -> u64 {
        std::thread::sleep(std::time::Duration::from_micros((97 * number) % 301));
        number * number
    }

    #[test]
    fn results_are_taken_in_order_at_any_number_of_threads() {
        for threads in [1, 2, 7] {
            let mut taken = Vec::new();
            let take = |number, square| {
                taken.push((number, square));
                Ok(ControlFlow::Continue(()))
            };
            in_order(5..205, threads, || (), |(), n| Ok(slowly(n)), take).expect("no failure");
            let expected: Vec<(u64, u64)> = (5..205).map(|n| (n, n * n)).collect();
            assert_eq!(taken, expected, "{threads} threads");
        }
    }

    #[test]
    fn taking_may_end_it_at_a_number_that_does_not_depend_on_the_threads() {
        for threads in [1, 2, 5] {
            let mut last = 0;
            let take = |number, _| {
                last = number;
                let is_enough = number == 77;
                Ok(if is_enough {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                })
            };
            in_order(1..1_000_000, threads, || (), |(), n| Ok(slowly(n)), take).expect("ends");
            assert_eq!(last, 77);
        }
    }

    #[test]
    fn work_does_not_run_far_ahead_of_what_is_slow() {
        let furthest = AtomicU64::new(0);
        let at_first = AtomicU64::new(0);
        let work = |(): &mut (), number| {
            if number == 0 {
                // Wait for as long as the others go on.
                let mut before = u64::MAX;
                while furthest.load(Ordering::SeqCst) != before {
                    before = furthest.load(Ordering::SeqCst);
                    std::thread::sleep(std::time::Duration::from_millis(50));
                }
                at_first.store(before, Ordering::SeqCst);
            }
            furthest.fetch_max(number, Ordering::SeqCst);
            Ok(())
        };
        in_order(
            0..5000,
            3,
            || (),
            work,
            |_, ()| Ok(ControlFlow::Continue(())),
        )
        .expect("done");
        assert!(at_first.load(Ordering::SeqCst) < AHEAD);
        assert_eq!(furthest.load(Ordering::SeqCst), 4999);
    }

    #[test]
    fn a_failure_ends_it_and_is_given_back() {
        let taken = AtomicU64::new(0);
        let work = |(): &mut (), number| match number {
            40 => Err(Problem::new("x", "forty")),
            _ => Ok(slowly(number)),
        };
        let take = |_, _| {
            taken.fetch_add(1, Ordering::SeqCst);
            Ok(ControlFlow::Continue(()))
        };
        let problem = in_order(0..1_000_000, 3, || (), work, take).expect_err("it fails");
        assert!(problem.to_string().contains("forty"));
        assert!(taken.load(Ordering::SeqCst) <= 40);
    }
}
