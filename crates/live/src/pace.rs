//! Keeping a test bench's time in step with the wall clock.
//!
//! Definition: with the bench's time `b0` at the clock's time `w0`, bench time `b` is due at `w0 + (b - b0)`. A bench
//! that is late is not allowed to hurry: how late each step was is kept, since results of a part in the loop hold only
//! if the simulated rest was on time.

use crate::Clock;

/// The relation of a bench's time to a clock's, and how well it was kept.
#[derive(Debug, Clone)]
pub struct Pacer {
    clock: Clock,
    clock_start_nanos: i64,
    bench_start_nanos: i64,
    tolerance_nanos: i64,
    punctuality: Punctuality,
}

/// How well a bench kept up with the wall clock.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Punctuality {
    /// Steps that were paced.
    pub steps: u64,
    /// Steps that came later than the tolerance.
    pub late_steps: u64,
    /// The greatest delay, in nanoseconds.
    pub latest_nanos: i64,
}

impl Pacer {
    /// Starts now with the bench's time `bench_start_nanos`. Steps that are more than `tolerance_nanos` late are
    /// counted as late.
    pub fn start(clock: Clock, bench_start_nanos: i64, tolerance_nanos: i64) -> Self {
        Self {
            clock,
            clock_start_nanos: clock.now_nanos(),
            bench_start_nanos,
            tolerance_nanos,
            punctuality: Punctuality::default(),
        }
    }

    /// When bench time `bench_nanos` is due on the clock, in nanoseconds since 1970.
    pub fn due_nanos(&self, bench_nanos: i64) -> i64 {
        bench_nanos
            .saturating_sub(self.bench_start_nanos)
            .saturating_add(self.clock_start_nanos)
    }

    /// The bench time of a clock time, for example of a message's [`received_nanos`](crate::Message::received_nanos).
    pub fn bench_nanos(&self, clock_nanos: i64) -> i64 {
        clock_nanos
            .saturating_sub(self.clock_start_nanos)
            .saturating_add(self.bench_start_nanos)
    }

    /// How long until bench time `bench_nanos` is due, in nanoseconds; negative if it is late already.
    pub fn remaining_nanos(&self, bench_nanos: i64) -> i64 {
        self.due_nanos(bench_nanos)
            .saturating_sub(self.clock.now_nanos())
    }

    /// Takes note that the step to `bench_nanos` begins now; gives how late it is, in nanoseconds.
    pub fn note_step(&mut self, bench_nanos: i64) -> i64 {
        let late = self.remaining_nanos(bench_nanos).saturating_neg().max(0);
        self.punctuality.steps += 1;
        if late > self.tolerance_nanos {
            self.punctuality.late_steps += 1;
        }
        self.punctuality.latest_nanos = self.punctuality.latest_nanos.max(late);
        late
    }

    /// How well the bench kept up so far.
    pub fn punctuality(&self) -> Punctuality {
        self.punctuality
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_go_there_and_back() {
        let pacer = Pacer::start(Clock::start(), 5_000, 0);
        assert_eq!(pacer.due_nanos(6_000) - pacer.due_nanos(5_000), 1_000);
        assert_eq!(pacer.bench_nanos(pacer.due_nanos(123)), 123);
    }

    #[test]
    fn late_steps_are_counted() {
        let mut pacer = Pacer::start(Clock::start(), 0, 1_000_000_000);
        assert_eq!(pacer.note_step(60_000_000_000), 0);
        // A step that was due a minute before the start is late by that at least.
        assert!(pacer.note_step(-60_000_000_000) >= 60_000_000_000);
        let punctuality = pacer.punctuality();
        assert_eq!((punctuality.steps, punctuality.late_steps), (2, 1));
        assert!(punctuality.latest_nanos >= 60_000_000_000);
    }
}
