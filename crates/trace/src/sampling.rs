//! Predicates sampled at the ticks of a clock, as monitors want them.
//!
//! Definition: with a polling rate of f Hz on a trace from time a to time b, tick k is at
//! a + k / f for k = 0, 1, ..., as long as that is not after b; and there is a last tick at b, so
//! that the end of the trace is seen. At each tick each predicate is evaluated with zero-order
//! hold. Deviation from sampling every message: what is true for less than 1 / f between two ticks
//! may be missed; [`Sampling::EveryRow`] takes the time of every row of the trace instead and
//! misses nothing.
//! Cost: O(ticks * (channels + nodes of the predicates) + rows).

use std::fmt;

use crate::predicate::BoundPredicate;
use crate::signal::{Cursor, Trace};

/// The largest number of ticks.
const MAX_TICKS: f64 = 1e8;

/// At which times a trace is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sampling {
    /// At a fixed rate in ticks for each second of the trace's clock.
    PollHz(f64),
    /// At each time at which any channel has a row.
    EveryRow,
}

/// A polling rate that cannot be used.
#[derive(Debug, Clone, PartialEq)]
pub struct SamplingError {
    /// The rate in Hz.
    pub poll_hz: f64,
    /// Length of the trace in seconds.
    pub duration_secs: f64,
}

impl fmt::Display for SamplingError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "cannot poll a trace of {} s at {} Hz; give a rate above 0 with at most 100 million \
             ticks for the trace",
            self.duration_secs, self.poll_hz
        )
    }
}

impl std::error::Error for SamplingError {}

/// The values of some predicates at the ticks of a trace.
///
/// ```
/// use trace::{Field, Predicate, Sampling, Trace, Valuations};
/// let mut trace = Trace::new();
/// let robot = trace.add_channel("/robot", vec![Field::number("speed", "m/s")])?;
/// trace.channels[robot].push(0.0, &[0.1])?;
/// trace.channels[robot].push(0.25, &[0.4])?;
/// let fast = Predicate::parse("/robot.speed > 0.2")?.bind(&trace)?;
///
/// let valuations = Valuations::sample(&trace, &[fast], Sampling::PollHz(10.0))?;
/// assert_eq!(valuations.times_secs, [0.0, 0.1, 0.2, 0.25]);
/// assert_eq!(valuations.value(2, 0), Some(false));
/// assert_eq!(valuations.value(3, 0), Some(true));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Valuations {
    /// The ticks in seconds of the trace's clock, increasing.
    pub times_secs: Vec<f64>,
    /// Number of predicates.
    width: usize,
    /// The values tick by tick.
    values: Vec<Option<bool>>,
}

impl Valuations {
    /// Evaluates `predicates`, which were bound to `trace`, at each tick.
    ///
    /// # Errors
    /// [`SamplingError`] if the rate is not a positive number or gives more than 10^8 ticks.
    pub fn sample(
        trace: &Trace,
        predicates: &[BoundPredicate],
        sampling: Sampling,
    ) -> Result<Self, SamplingError> {
        let times_secs = ticks(trace, sampling)?;
        let mut values = Vec::with_capacity(times_secs.len() * predicates.len());
        let mut cursor = Cursor::new(trace);
        for &time_secs in &times_secs {
            cursor.seek(time_secs);
            values.extend(predicates.iter().map(|predicate| predicate.eval(&cursor)));
        }
        Ok(Valuations {
            times_secs,
            width: predicates.len(),
            values,
        })
    }

    /// The value of predicate `predicate` (its position among those given) at tick `tick`; `None`
    /// where it is unknown, and beyond the last tick or predicate.
    #[must_use]
    pub fn value(&self, tick: usize, predicate: usize) -> Option<bool> {
        if predicate >= self.width {
            return None;
        }
        self.values
            .get(tick * self.width + predicate)
            .copied()
            .flatten()
    }
}

/// The times at which `trace` is looked at, in seconds; none if the trace has no rows.
///
/// # Errors
/// [`SamplingError`] if the rate is not a positive number or gives more than 10^8 ticks.
pub fn ticks(trace: &Trace, sampling: Sampling) -> Result<Vec<f64>, SamplingError> {
    let (Some(start_secs), Some(end_secs)) = (trace.start_secs(), trace.end_secs()) else {
        return Ok(Vec::new());
    };
    match sampling {
        Sampling::PollHz(poll_hz) => poll(start_secs, end_secs, poll_hz),
        Sampling::EveryRow => {
            let all = trace
                .channels
                .iter()
                .flat_map(|channel| &channel.times_secs);
            let mut times_secs: Vec<f64> = all.copied().collect();
            times_secs.sort_by(f64::total_cmp);
            times_secs.dedup();
            Ok(times_secs)
        }
    }
}

fn poll(start_secs: f64, end_secs: f64, poll_hz: f64) -> Result<Vec<f64>, SamplingError> {
    let duration_secs = end_secs - start_secs;
    let count = duration_secs * poll_hz;
    // Also true of a rate that is not a number.
    if !(poll_hz > 0.0 && count <= MAX_TICKS) {
        return Err(SamplingError {
            poll_hz,
            duration_secs,
        });
    }
    let mut times_secs = Vec::with_capacity(count as usize + 2);
    let mut tick = 0_u32;
    loop {
        let time_secs = start_secs + f64::from(tick) / poll_hz;
        if time_secs >= end_secs {
            times_secs.push(end_secs);
            return Ok(times_secs);
        }
        // A rate beyond the resolution of the times would give the same tick twice.
        if times_secs.last().is_none_or(|&last| time_secs > last) {
            times_secs.push(time_secs);
        }
        tick += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channel::Field;

    fn trace_at(times_secs: &[f64]) -> Trace {
        let mut trace = Trace::new();
        trace
            .add_channel("/clock", vec![Field::bool("tick")])
            .unwrap();
        for &time_secs in times_secs {
            trace.channels[0].push(time_secs, &[1.0]).unwrap();
        }
        trace
    }

    #[test]
    fn polls_begin_at_the_first_row_and_end_at_the_last() {
        let polled = |times: &[f64], hz| ticks(&trace_at(times), Sampling::PollHz(hz)).unwrap();
        assert_eq!(polled(&[], 20.0), [0.0; 0]);
        assert_eq!(polled(&[3.0], 20.0), [3.0]);
        assert_eq!(polled(&[1.0, 2.0], 4.0), [1.0, 1.25, 1.5, 1.75, 2.0]);
        assert_eq!(polled(&[1.0, 1.6], 4.0), [1.0, 1.25, 1.5, 1.6]);
        assert_eq!(polled(&[0.0, 60.0], 20.0).len(), 1201);
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e12] {
            let trace = trace_at(&[0.0, 1.0]);
            assert!(ticks(&trace, Sampling::PollHz(bad)).is_err(), "{bad}");
        }
    }

    #[test]
    fn every_row_is_a_tick_once() {
        let mut trace = trace_at(&[0.5, 0.5, 2.0]);
        trace
            .add_channel("/other", vec![Field::bool("tick")])
            .unwrap();
        trace.channels[1].push(-1.0, &[0.0]).unwrap();
        trace.channels[1].push(2.0, &[0.0]).unwrap();
        assert_eq!(ticks(&trace, Sampling::EveryRow).unwrap(), [-1.0, 0.5, 2.0]);
    }
}
