//! The one clock of this crate: nanoseconds since 1970 that never go back.
//!
//! Definition: `now = wall clock at the start + monotonic time elapsed since`. Stamps of one [`Clock`] are therefore
//! ordered as things happened even when the system's wall clock is set meanwhile; against other machines they are as
//! right as the wall clock was at the start, plus the drift of the monotonic clock.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// A clock whose stamps never go back. Copies share their origin, so their stamps can be compared.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    origin: Instant,
    origin_unix_nanos: i64,
}

impl Clock {
    /// Starts a clock at the wall clock's present time.
    pub fn start() -> Self {
        Self {
            origin: Instant::now(),
            origin_unix_nanos: wall_nanos(),
        }
    }

    /// The present time in nanoseconds since 1970-01-01 UTC.
    pub fn now_nanos(&self) -> i64 {
        self.origin_unix_nanos
            .saturating_add(nanos(self.origin.elapsed()))
    }

    /// The time on this clock of something that the wall clock stamped `wall_stamp_nanos` a moment ago on this
    /// machine. Only the age is taken from the wall clock, and no more than a second of it, so a clock that was set
    /// in between moves a stamp by at most that.
    pub fn from_recent_wall_stamp(&self, wall_stamp_nanos: i64) -> i64 {
        let age = wall_nanos().saturating_sub(wall_stamp_nanos);
        self.now_nanos() - age.clamp(0, 1_000_000_000)
    }
}

/// The wall clock in nanoseconds since 1970; zero before.
fn wall_nanos() -> i64 {
    SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or(0, nanos)
}

/// A duration in nanoseconds, at most `i64::MAX` (292 years).
pub(crate) fn nanos(duration: Duration) -> i64 {
    i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX)
}

/// The duration of `nanos` nanoseconds; zero if negative.
pub(crate) fn duration(nanos: i64) -> Duration {
    Duration::from_nanos(u64::try_from(nanos).unwrap_or(0))
}

/// The monotonic present, for time limits inside this crate.
pub(crate) fn instant() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_never_go_back_and_are_near_the_wall_clock() {
        let clock = Clock::start();
        let mut last = clock.now_nanos();
        for _ in 0..1000 {
            let now = clock.now_nanos();
            assert!(now >= last);
            last = now;
        }
        assert!((last - wall_nanos()).abs() < 60_000_000_000);
    }

    #[test]
    fn a_wall_stamp_counts_by_its_age_and_by_a_second_at_most() {
        let clock = Clock::start();
        let before = clock.now_nanos();
        let stamped = clock.from_recent_wall_stamp(wall_nanos() - 500_000_000);
        let after = clock.now_nanos();
        // The wall clock may be slewed meanwhile: a millisecond is allowed for it.
        assert!(stamped >= before - 501_000_000 && stamped <= after - 499_000_000);
        // From the far past: the wall clock was set, so the age is not believed.
        assert!(clock.from_recent_wall_stamp(0) >= before - 1_000_000_000);
        // From the future: never later than now.
        assert!(clock.from_recent_wall_stamp(i64::MAX) <= clock.now_nanos());
    }
}
