//! From log time to the time of a simulation, by the messages of `/clock`.

use std::collections::VecDeque;

/// The most messages of `/clock` that are kept for messages out of order.
const MAX_POINTS: usize = 10_000;

/// `/clock` went back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ClockReset {
    /// When it was logged.
    pub log_nanos: i64,
    /// What the clock had said before.
    pub from_nanos: i64,
    /// What it says now.
    pub to_nanos: i64,
}

/// The clock of a simulation as far as it was read.
#[derive(Debug, Default)]
pub(crate) struct SimulationClock {
    /// Log time and simulated time, both non-decreasing.
    points: VecDeque<(i64, i64)>,
    forgotten: bool,
}

/// What a clock says of a log time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mapped {
    /// The simulated time.
    Time(i64),
    /// The clock had not begun.
    BeforeFirst,
    /// The next message of the clock has to come first.
    NotYet,
}

impl SimulationClock {
    /// Takes a message of `/clock`. One that is logged before the last one is left out.
    pub fn push(&mut self, log_nanos: i64, sim_nanos: i64) -> Result<(), ClockReset> {
        if let Some(&(last_log, last_sim)) = self.points.back() {
            if sim_nanos < last_sim && log_nanos >= last_log {
                return Err(ClockReset {
                    log_nanos,
                    from_nanos: last_sim,
                    to_nanos: sim_nanos,
                });
            }
            if log_nanos < last_log || sim_nanos < last_sim {
                return Ok(());
            }
            if log_nanos == last_log {
                self.points.pop_back();
            }
        }
        self.points.push_back((log_nanos, sim_nanos));
        if self.points.len() > MAX_POINTS {
            self.points.pop_front();
            self.forgotten = true;
        }
        Ok(())
    }

    /// The simulated time at `log_nanos`.
    pub fn at(&self, log_nanos: i64) -> Mapped {
        let after = self.points.partition_point(|&(log, _)| log <= log_nanos);
        let Some(&(log, sim)) = after
            .checked_sub(1)
            .and_then(|index| self.points.get(index))
        else {
            return match self.points.front() {
                Some(_) if !self.forgotten => Mapped::BeforeFirst,
                // Too far back: the earliest that is still known, so that it counts as late.
                Some(&(_, sim)) => Mapped::Time(sim.saturating_sub(1)),
                None => Mapped::NotYet,
            };
        };
        if log == log_nanos {
            return Mapped::Time(sim);
        }
        match self.points.get(after) {
            Some(&(next_log, next_sim)) => {
                let share = i128::from(log_nanos - log) * i128::from(next_sim - sim);
                let passed = share / i128::from(next_log - log);
                Mapped::Time(sim.saturating_add(passed as i64))
            }
            None => Mapped::NotYet,
        }
    }

    /// What the clock said last; `None` if it never spoke.
    pub fn last(&self) -> Option<i64> {
        self.points.back().map(|&(_, sim)| sim)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_linear_between_messages_of_the_clock() {
        let mut clock = SimulationClock::default();
        assert_eq!(clock.at(5), Mapped::NotYet);
        for (log, sim) in [(1000, 0), (2000, 500), (3000, 500), (4000, 2500)] {
            clock.push(log, sim).unwrap();
        }
        let at = |log| clock.at(log);
        assert_eq!(at(999), Mapped::BeforeFirst);
        assert_eq!(at(1000), Mapped::Time(0));
        assert_eq!(at(1500), Mapped::Time(250)); // half speed
        assert_eq!(at(2700), Mapped::Time(500)); // paused
        assert_eq!(at(3001), Mapped::Time(502)); // double speed
        assert_eq!(at(4000), Mapped::Time(2500));
        assert_eq!(at(4001), Mapped::NotYet);
        assert_eq!(clock.last(), Some(2500));
    }

    #[test]
    fn a_clock_that_goes_back_is_a_reset() {
        let mut clock = SimulationClock::default();
        clock.push(10, 100).unwrap();
        assert_eq!(clock.push(5, 50), Ok(())); // only out of order in the file
        let reset = ClockReset {
            log_nanos: 20,
            from_nanos: 100,
            to_nanos: 0,
        };
        assert_eq!(clock.push(20, 0), Err(reset));
    }

    #[test]
    fn what_was_forgotten_is_not_taken_for_the_beginning() {
        let mut clock = SimulationClock::default();
        for tick in 0..=MAX_POINTS as i64 {
            clock.push(tick, 10 * tick).unwrap();
        }
        assert_eq!(clock.at(0), Mapped::Time(9));
    }
}
