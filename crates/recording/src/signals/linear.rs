//! The samples of a source between which values are interpolated.

use std::collections::VecDeque;

/// Samples from the last one at or before the current time on.
#[derive(Debug, Default)]
pub(super) struct Samples {
    rows: VecDeque<(i64, Box<[f64]>)>,
}

impl Samples {
    pub fn push(&mut self, time_nanos: i64, row: &[f64]) {
        self.rows.push_back((time_nanos, row.into()));
    }

    pub fn newest_nanos(&self) -> Option<i64> {
        self.rows.back().map(|(time, _)| *time)
    }

    /// Forgets what is not needed from `time_nanos` on.
    pub fn advance(&mut self, time_nanos: i64) {
        while self
            .rows
            .get(1)
            .is_some_and(|(time, _)| *time <= time_nanos)
        {
            self.rows.pop_front();
        }
    }

    /// The value of `column` at `time_nanos`, to which the samples were advanced: that of a sample
    /// there, or on the line between two neighbours that are at most `bridged_nanos` apart; else
    /// NaN.
    pub fn value(&self, column: usize, time_nanos: i64, bridged_nanos: i64) -> f64 {
        let Some((from, before)) = self.rows.front() else {
            return f64::NAN;
        };
        if *from == time_nanos {
            return before[column];
        }
        match self.rows.get(1) {
            Some((to, after)) if *from < time_nanos && to - from <= bridged_nanos => {
                let share = (time_nanos - from) as f64 / (to - from) as f64;
                (1.0 - share) * before[column] + share * after[column]
            }
            _ => f64::NAN,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_on_the_line_and_gaps_are_not_bridged() {
        let mut samples = Samples::default();
        for (time, value) in [(0, 1.0), (10, 3.0), (30, 5.0), (30, 6.0)] {
            samples.push(time, &[value]);
        }
        let mut at = |time| {
            samples.advance(time);
            samples.value(0, time, 10)
        };
        assert!(at(-1).is_nan());
        assert_eq!(at(0), 1.0);
        assert_eq!(at(5), 2.0);
        assert_eq!(at(10), 3.0);
        assert!(at(11).is_nan());
        assert_eq!(at(30), 6.0); // the last of two at one time
        assert!(at(31).is_nan()); // nothing is extrapolated
    }
}
