//! A trace, one sample of its instants after another.
//!
//! # Definition
//! An instant is a time at which any channel has a row. Where a channel has several rows of one
//! time, the instant has several samples, in order: at the i-th one every channel that has an i-th
//! row of that time takes it, and the others keep what they have. So each row counts once, the last
//! one is what holds afterwards, and rows of different channels at one time are seen together.
//!
//! Cost: O(channels) a sample.

use crate::signal::{SignalIndex, SignalValues, Trace};

/// A sample of a trace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Its time in seconds.
    pub time_secs: f64,
    /// Whether another sample of the same instant follows.
    pub more: bool,
}

/// A trace at one sample after another; it gives each signal's value there.
///
/// ```
/// use trace::{Field, Replay, SignalValues, Trace};
/// let mut trace = Trace::new();
/// let robot = trace.add_channel("/robot", vec![Field::number("speed", "m/s")])?;
/// for (time_secs, speed) in [(0.0, 1.0), (1.0, -3.0), (1.0, 2.0)] {
///     trace.channels[robot].push(time_secs, &[speed])?;
/// }
/// let speed = trace.signal("/robot.speed").expect("it was just added");
/// let mut replay = Replay::new(&trace);
/// let mut seen = Vec::new();
/// while let Some(sample) = replay.advance() {
///     seen.push((sample.time_secs, sample.more, replay.raw(speed)));
/// }
/// assert_eq!(seen, [(0.0, false, 1.0), (1.0, true, -3.0), (1.0, false, 2.0)]);
/// # Ok::<(), trace::TraceError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Replay<'a> {
    trace: &'a Trace,
    /// For each channel the number of rows that were taken.
    taken: Vec<usize>,
    changed: Vec<bool>,
}

impl<'a> Replay<'a> {
    /// Before the first sample, where no signal has a value.
    #[must_use]
    pub fn new(trace: &'a Trace) -> Self {
        Replay {
            trace,
            taken: vec![0; trace.channels.len()],
            changed: vec![false; trace.channels.len()],
        }
    }

    /// Goes to the next sample; `None` after the last one.
    pub fn advance(&mut self) -> Option<Sample> {
        let next = |taken: &[usize]| {
            let rows = self.trace.channels.iter().zip(taken);
            let times = rows.filter_map(|(channel, taken)| channel.times_secs.get(*taken));
            times.copied().min_by(f64::total_cmp)
        };
        let time_secs = next(&self.taken)?;
        let rows = self.trace.channels.iter().zip(&mut self.taken);
        for ((channel, taken), changed) in rows.zip(&mut self.changed) {
            // Also of 0 and -0, which are one time.
            *changed = (channel.times_secs.get(*taken)).is_some_and(|time| *time == time_secs);
            *taken += usize::from(*changed);
        }
        let more = next(&self.taken).is_some_and(|next_secs| next_secs == time_secs);
        Some(Sample { time_secs, more })
    }

    /// For each channel, whether it has a row at this sample.
    #[must_use]
    pub fn changed(&self) -> &[bool] {
        &self.changed
    }
}

impl SignalValues for Replay<'_> {
    fn raw(&self, signal: SignalIndex) -> f64 {
        let taken = self.taken.get(signal.channel).copied().unwrap_or(0);
        let Some(row) = taken.checked_sub(1) else {
            return f64::NAN;
        };
        let values = self.trace.channels[signal.channel].row(row);
        values.get(signal.field).copied().unwrap_or(f64::NAN)
    }
}
