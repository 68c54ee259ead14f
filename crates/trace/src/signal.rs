//! Traces, and looking up signals in them with zero-order hold.
//!
//! Definition: a channel with rows (t_1, v_1), ..., (t_n, v_n), t_1 <= ... <= t_n, has at time t
//! the value v_k with k = max { i : t_i <= t }. It has no value before t_1. Of several rows with
//! one time the last counts. A value holds until the next row, however far away that is.
//!
//! Cost: [`Cursor::seek`] takes amortised O(1) per channel while time advances, O(log n) when it
//! goes back.

use std::collections::BTreeMap;

use crate::channel::{Channel, Field, TraceError};

/// A recording: topics with timed values, and what is known about how they came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// The topics, each at most once.
    pub channels: Vec<Channel>,
    /// Facts about the recording, for example the seed and the version of the simulator.
    pub metadata: BTreeMap<String, String>,
    /// False if the recording was cut short, so that its end is not the end of the run.
    pub complete: bool,
}

/// Where a signal is within one trace: the index of its channel and of its field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SignalIndex {
    /// Index into [`Trace::channels`].
    pub channel: usize,
    /// Index into [`Channel::fields`].
    pub field: usize,
}

/// Something that knows the value of each signal at one moment: a [`Cursor`] in a recording, or a
/// [`Snapshot`](crate::Snapshot) of a stream. Predicates and quantities are evaluated on it.
///
/// ```
/// use trace::{Field, Predicate, SignalIndex, SignalValues, Trace};
/// /// Everything measures the same.
/// struct Constant(f64);
/// impl SignalValues for Constant {
///     fn raw(&self, _: SignalIndex) -> f64 {
///         self.0
///     }
/// }
/// let mut layout = Trace::new();
/// layout.add_channel("/robot", vec![Field::number("speed", "m/s")])?;
/// let slow = Predicate::parse("/robot.speed < 250 mm/s")?.bind(&layout)?;
/// assert_eq!(slow.eval(&Constant(0.2)), Some(true));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait SignalValues {
    /// The value of `signal` as it is stored, in the unit of its [`Field`]: a number, 0 or 1 for a
    /// truth value, the index of a name. NaN where there is none, and for a signal that is not
    /// known here.
    fn raw(&self, signal: SignalIndex) -> f64;

    /// As [`SignalValues::raw`], with `None` for a value that is not there.
    fn value(&self, signal: SignalIndex) -> Option<f64> {
        let value = self.raw(signal);
        (!value.is_nan()).then_some(value)
    }
}

impl Default for Trace {
    fn default() -> Self {
        Trace::new()
    }
}

impl Trace {
    /// An empty, complete trace.
    #[must_use]
    pub fn new() -> Self {
        Trace {
            channels: Vec::new(),
            metadata: BTreeMap::new(),
            complete: true,
        }
    }

    /// Adds an empty channel and returns its index in [`Trace::channels`].
    ///
    /// # Errors
    /// [`TraceError::BadName`] if the topic does not begin with `/`, is there already, or two
    /// fields have one name.
    pub fn add_channel(
        &mut self,
        topic: impl Into<String>,
        fields: Vec<Field>,
    ) -> Result<usize, TraceError> {
        let channel = Channel::new(topic, fields);
        channel.validate()?;
        if self.channel(&channel.topic).is_some() {
            return Err(duplicate_topic(&channel.topic));
        }
        self.channels.push(channel);
        Ok(self.channels.len() - 1)
    }

    /// The channel of `topic`.
    #[must_use]
    pub fn channel(&self, topic: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.topic == topic)
    }

    /// Finds the signal that is written `/topic.field`, for example `/robot.hand_speed`. Topics
    /// and fields may themselves contain dots; the longest topic that fits wins.
    #[must_use]
    pub fn signal(&self, name: &str) -> Option<SignalIndex> {
        let splits = name
            .char_indices()
            .rev()
            .filter(|&(_, letter)| letter == '.');
        for (dot, _) in splits {
            let (topic, field) = (&name[..dot], &name[dot + 1..]);
            for (index, channel) in self.channels.iter().enumerate() {
                if channel.topic == topic
                    && let Some(field) = channel.field_index(field)
                {
                    return Some(SignalIndex {
                        channel: index,
                        field,
                    });
                }
            }
        }
        None
    }

    /// The field that `signal` refers to, if it belongs to this trace.
    #[must_use]
    pub fn field(&self, signal: SignalIndex) -> Option<&Field> {
        self.channels.get(signal.channel)?.fields.get(signal.field)
    }

    /// The names of all signals as `/topic.field`, in the order of the channels.
    pub fn signal_names(&self) -> impl Iterator<Item = String> + '_ {
        self.channels.iter().flat_map(|channel| {
            channel
                .fields
                .iter()
                .map(move |field| format!("{}.{}", channel.topic, field.name))
        })
    }

    /// The earliest time of any row, in seconds; `None` if there are no rows.
    #[must_use]
    pub fn start_secs(&self) -> Option<f64> {
        let firsts = self
            .channels
            .iter()
            .filter_map(|channel| channel.times_secs.first());
        firsts.copied().min_by(f64::total_cmp)
    }

    /// The latest time of any row, in seconds; `None` if there are no rows.
    #[must_use]
    pub fn end_secs(&self) -> Option<f64> {
        let lasts = self
            .channels
            .iter()
            .filter_map(|channel| channel.times_secs.last());
        lasts.copied().max_by(f64::total_cmp)
    }

    /// Checks that every channel is well-formed and no topic occurs twice.
    ///
    /// # Errors
    /// The first [`TraceError`] found.
    pub fn validate(&self) -> Result<(), TraceError> {
        for (index, channel) in self.channels.iter().enumerate() {
            channel.validate()?;
            if self.channels[..index]
                .iter()
                .any(|other| other.topic == channel.topic)
            {
                return Err(duplicate_topic(&channel.topic));
            }
        }
        Ok(())
    }
}

fn duplicate_topic(topic: &str) -> TraceError {
    TraceError::BadName {
        name: topic.to_owned(),
        problem: "names two topics of one trace; rename one of them or join their fields",
    }
}

/// A point in time within a trace, which gives each signal's value there.
///
/// ```
/// use trace::{Cursor, Field, Trace};
/// let mut trace = Trace::new();
/// let robot = trace.add_channel("/robot", vec![Field::number("hand_speed", "m/s")])?;
/// trace.channels[robot].push(1.0, &[0.2])?;
/// trace.channels[robot].push(2.0, &[0.3])?;
/// let speed = trace.signal("/robot.hand_speed").expect("it was just added");
/// let mut cursor = Cursor::new(&trace);
/// cursor.seek(0.5);
/// assert_eq!(cursor.value(speed), None); // nothing was recorded yet
/// cursor.seek(1.9);
/// assert_eq!(cursor.value(speed), Some(0.2));
/// # Ok::<(), trace::TraceError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Cursor<'a> {
    trace: &'a Trace,
    /// For each channel the number of rows at or before the current time.
    seen: Vec<usize>,
    time_secs: f64,
}

impl<'a> Cursor<'a> {
    /// A cursor before the beginning of `trace`, where no signal has a value.
    #[must_use]
    pub fn new(trace: &'a Trace) -> Self {
        Cursor {
            trace,
            seen: vec![0; trace.channels.len()],
            time_secs: f64::NEG_INFINITY,
        }
    }

    /// Moves to `time_secs`, forwards or backwards. NaN counts as before the beginning.
    pub fn seek(&mut self, time_secs: f64) {
        let forwards = time_secs >= self.time_secs;
        for (channel, seen) in self.trace.channels.iter().zip(&mut self.seen) {
            let times = &channel.times_secs;
            if forwards {
                while times.get(*seen).is_some_and(|&next| next <= time_secs) {
                    *seen += 1;
                }
            } else {
                *seen = times.partition_point(|&time| time <= time_secs);
            }
        }
        self.time_secs = if time_secs.is_nan() {
            f64::NEG_INFINITY
        } else {
            time_secs
        };
    }

    /// The time that was last sought, in seconds.
    #[must_use]
    pub fn time_secs(&self) -> f64 {
        self.time_secs
    }

    /// The value of `signal` now; `None` before its first row or where it is missing.
    #[must_use]
    pub fn value(&self, signal: SignalIndex) -> Option<f64> {
        SignalValues::value(self, signal)
    }
}

impl SignalValues for Cursor<'_> {
    fn raw(&self, signal: SignalIndex) -> f64 {
        let Some(row) = self
            .seen
            .get(signal.channel)
            .and_then(|seen| seen.checked_sub(1))
        else {
            return f64::NAN;
        };
        let values = self.trace.channels[signal.channel].row(row);
        values.get(signal.field).copied().unwrap_or(f64::NAN)
    }
}
