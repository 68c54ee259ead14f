//! The current values of a stream, where a recording would be looked at through a
//! [`Cursor`](crate::Cursor).
//!
//! Definition: at time t a signal has the value of the last update of its field at or before t, if
//! that is not NaN and not older than the field's staleness s, that is if t - t_update <= s.
//! Without a staleness a value holds until the next update, as in a recording.
//! Cost: an update takes O(fields of the channel), reading a value O(1); no allocation after
//! [`Snapshot::new`].

use crate::channel::{Field, TraceError};
use crate::signal::{SignalIndex, SignalValues, Trace};

/// The latest values of all signals of a stream, with the times of their updates.
///
/// ```
/// use trace::{Field, Predicate, Snapshot, Trace};
/// let mut layout = Trace::new(); // channels without rows say what there is
/// let robot = layout.add_channel("/robot", vec![Field::number("hand_speed", "m/s")])?;
/// let slow = Predicate::parse("/robot.hand_speed < 250 mm/s")?.bind(&layout)?;
///
/// let mut now = Snapshot::new(&layout);
/// now.set_staleness(robot, Some(0.5));
/// assert_eq!(slow.eval(&now), None);
/// now.update(robot, 10.0, &[0.2])?;
/// assert_eq!(slow.eval(&now), Some(true));
/// now.advance(10.5);
/// assert_eq!(slow.eval(&now), Some(true));
/// now.advance(10.6); // nothing was heard for too long
/// assert_eq!(slow.eval(&now), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Snapshot {
    channels: Vec<SnapshotChannel>,
    /// The slots of all channels, one channel after another.
    slots: Vec<Slot>,
    time_secs: f64,
}

#[derive(Debug, Clone)]
struct SnapshotChannel {
    topic: String,
    fields: Vec<Field>,
    /// Index of the first field's slot.
    first: usize,
    /// Time of the last update of any field.
    updated_secs: f64,
}

#[derive(Debug, Clone, Copy)]
struct Slot {
    value: f64,
    updated_secs: f64,
    /// The greatest age at which the value still counts.
    staleness_secs: f64,
}

impl Snapshot {
    /// A snapshot of the signals of `layout`, none of which has a value yet. Rows of `layout` do
    /// not matter.
    #[must_use]
    pub fn new(layout: &Trace) -> Self {
        let empty = Slot {
            value: f64::NAN,
            updated_secs: f64::NEG_INFINITY,
            staleness_secs: f64::INFINITY,
        };
        let mut slots = Vec::new();
        let mut channels = Vec::with_capacity(layout.channels.len());
        for channel in &layout.channels {
            channels.push(SnapshotChannel {
                topic: channel.topic.clone(),
                fields: channel.fields.clone(),
                first: slots.len(),
                updated_secs: f64::NEG_INFINITY,
            });
            slots.resize(slots.len() + channel.fields.len(), empty);
        }
        Snapshot {
            channels,
            slots,
            time_secs: f64::NEG_INFINITY,
        }
    }

    /// Values of channel `channel` count as missing once they are older than `staleness_secs`;
    /// with `None`, and at first, they hold for ever. What is negative or NaN counts as 0. Does
    /// nothing if there is no such channel.
    pub fn set_staleness(&mut self, channel: usize, staleness_secs: Option<f64>) {
        let count = self.channels.get(channel).map_or(0, |it| it.fields.len());
        for field in 0..count {
            self.set_field_staleness(SignalIndex { channel, field }, staleness_secs);
        }
    }

    /// As [`Snapshot::set_staleness`], for one signal.
    pub fn set_field_staleness(&mut self, signal: SignalIndex, staleness_secs: Option<f64>) {
        if let Some(index) = self.slot_index(signal) {
            self.slots[index].staleness_secs =
                staleness_secs.map_or(f64::INFINITY, |it| it.max(0.0));
        }
    }

    /// A row of channel `channel` arrives: one value for each field, NaN where one is missing. The
    /// snapshot's time moves to `time_secs` unless it is past it already. On an error nothing is
    /// changed.
    ///
    /// Unlike in a [`Channel`](crate::Channel) numbers may be infinite, as a range finder reports
    /// them where nothing is in reach.
    ///
    /// # Errors
    /// [`TraceError`] if there is no such channel or the number of values is not that of its
    /// fields, the time is not finite or before the channel's last update, or a truth value or
    /// name is none.
    pub fn update(
        &mut self,
        channel: usize,
        time_secs: f64,
        row: &[f64],
    ) -> Result<(), TraceError> {
        let Some(entry) = self.channels.get(channel) else {
            return Err(no_channel(channel));
        };
        if entry.fields.len() != row.len() {
            return Err(TraceError::RowLength {
                topic: entry.topic.clone(),
                expected: entry.fields.len(),
                found: row.len(),
            });
        }
        entry.check_time(time_secs)?;
        for (field, &value) in entry.fields.iter().zip(row) {
            entry.check_value(field, value)?;
        }
        let first = entry.first;
        for (slot, &value) in self.slots[first..].iter_mut().zip(row) {
            slot.value = value;
            slot.updated_secs = time_secs;
        }
        self.channels[channel].updated_secs = time_secs;
        self.advance(time_secs);
        Ok(())
    }

    /// One field of a channel arrives and the others stay as they are; otherwise as
    /// [`Snapshot::update`].
    ///
    /// # Errors
    /// [`TraceError`] as for [`Snapshot::update`].
    pub fn update_field(
        &mut self,
        signal: SignalIndex,
        time_secs: f64,
        value: f64,
    ) -> Result<(), TraceError> {
        let Some(entry) = self.channels.get_mut(signal.channel) else {
            return Err(no_channel(signal.channel));
        };
        entry.check_time(time_secs)?;
        let Some(field) = entry.fields.get(signal.field) else {
            return Err(TraceError::RowLength {
                topic: entry.topic.clone(),
                expected: entry.fields.len(),
                found: signal.field + 1,
            });
        };
        entry.check_value(field, value)?;
        entry.updated_secs = time_secs;
        let slot = &mut self.slots[entry.first + signal.field];
        slot.value = value;
        slot.updated_secs = time_secs;
        self.advance(time_secs);
        Ok(())
    }

    /// Time passes without an update. A time before the present one, and NaN, change nothing.
    pub fn advance(&mut self, time_secs: f64) {
        self.time_secs = self.time_secs.max(time_secs);
    }

    /// Forgets all values and times, for example because the stream began anew; stalenesses stay.
    pub fn clear(&mut self) {
        self.time_secs = f64::NEG_INFINITY;
        for channel in &mut self.channels {
            channel.updated_secs = f64::NEG_INFINITY;
        }
        for slot in &mut self.slots {
            slot.value = f64::NAN;
            slot.updated_secs = f64::NEG_INFINITY;
        }
    }

    /// The present time in seconds: the latest of all updates and [`Snapshot::advance`]; minus
    /// infinity before the first.
    #[must_use]
    pub fn time_secs(&self) -> f64 {
        self.time_secs
    }

    /// The value of `signal` now; `None` if there was none yet, or it is missing or stale.
    #[must_use]
    pub fn value(&self, signal: SignalIndex) -> Option<f64> {
        SignalValues::value(self, signal)
    }

    /// When `signal` was last updated, in seconds, be the value missing or stale or not.
    #[must_use]
    pub fn updated_secs(&self, signal: SignalIndex) -> Option<f64> {
        let slot = self.slots[self.slot_index(signal)?];
        slot.updated_secs.is_finite().then_some(slot.updated_secs)
    }

    /// Whether `signal` has had an update and that is now older than its staleness.
    #[must_use]
    pub fn is_stale(&self, signal: SignalIndex) -> bool {
        self.slot_index(signal).is_some_and(|index| {
            let slot = self.slots[index];
            slot.updated_secs.is_finite()
                && self.time_secs - slot.updated_secs > slot.staleness_secs
        })
    }

    fn slot_index(&self, signal: SignalIndex) -> Option<usize> {
        let channel = self.channels.get(signal.channel)?;
        (signal.field < channel.fields.len()).then(|| channel.first + signal.field)
    }
}

impl SignalValues for Snapshot {
    fn raw(&self, signal: SignalIndex) -> f64 {
        let Some(index) = self.slot_index(signal) else {
            return f64::NAN;
        };
        let slot = self.slots[index];
        // Before the first update the age is infinite or no number, and the value NaN anyway.
        if self.time_secs - slot.updated_secs > slot.staleness_secs {
            return f64::NAN;
        }
        slot.value
    }
}

impl SnapshotChannel {
    fn check_time(&self, time_secs: f64) -> Result<(), TraceError> {
        if !time_secs.is_finite() {
            return Err(TraceError::TimeNotFinite {
                topic: self.topic.clone(),
                row: 0,
            });
        }
        if time_secs < self.updated_secs {
            return Err(TraceError::TimeBackwards {
                topic: self.topic.clone(),
                previous_secs: self.updated_secs,
                time_secs,
            });
        }
        Ok(())
    }

    fn check_value(&self, field: &Field, value: f64) -> Result<(), TraceError> {
        if value.is_infinite() && field.kind == crate::channel::FieldKind::Number
            || field.admits(value)
        {
            return Ok(());
        }
        Err(field.bad_value(&self.topic, value))
    }
}

fn no_channel(channel: usize) -> TraceError {
    TraceError::BadName {
        name: format!("channel {channel}"),
        problem: "is not one of the snapshot's layout; add the channel to the layout first",
    }
}
