//! From the signals of a trace to the messages of a robot, by a table.

use trace::{FieldKind, SignalIndex, Trace};

use super::definitions::{Primitive, schema_text, short_name};
use super::encode::{Plan, Ros2Value};
use super::error::Ros2WriteError;
use super::writer::Ros2Recording;

/// Where the value of a field comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum Ros2Source {
    /// A signal, `/topic.field`, of the topic whose rows become the messages, or of another one,
    /// whose value is then held. An enumeration becomes its name in a field of text and its index
    /// in one of numbers.
    Signal(String),
    /// A fixed number.
    Number(f64),
    /// A fixed truth value.
    Bool(bool),
    /// A fixed text, for example the name of a frame or of a joint.
    Text(String),
    /// The time of the row, for a field of type `builtin_interfaces/Time`.
    Stamp,
}

/// One topic of the recording to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct Ros2Topic {
    /// Its name, for example `/joint_states`.
    pub name: String,
    /// Its message type, for example `sensor_msgs/msg/JointState`.
    pub type_name: String,
    /// The topic of the trace of which each row becomes one message.
    pub rows_of: String,
    /// What stands in the fields, as (path, source).
    pub fields: Vec<(String, Ros2Source)>,
}

/// How a trace becomes a recording.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ros2TraceOptions {
    /// What is added to the times of the trace, in nanoseconds; time 0 of the trace is then a date
    /// (nanoseconds since 1970).
    pub start_nanos: i64,
}

/// A recording that was written of a trace.
#[derive(Debug, Clone, PartialEq)]
pub struct Ros2TraceOutcome {
    /// The file.
    pub bytes: Vec<u8>,
    /// How many messages it holds.
    pub messages: u64,
    /// How many messages could not be written because a truth value, a whole number or a name was
    /// missing there. Missing real numbers are written as NaN.
    pub left_out: u64,
}

/// Writes `trace` as a ROS 2 recording by the table `topics`. Messages stand in order of time, of
/// equal times in order of the table. Times are rounded to nanoseconds.
///
/// # Errors
/// [`Ros2WriteError`] if the table names what is not there or a value does not fit its field.
pub fn ros2_recording_of(
    trace: &Trace,
    topics: &[Ros2Topic],
    options: &Ros2TraceOptions,
) -> Result<Ros2TraceOutcome, Ros2WriteError> {
    trace.validate().map_err(Ros2WriteError::Trace)?;
    let mut recording = Ros2Recording::new()?;
    if !trace.metadata.is_empty() {
        recording.add_metadata("corroborate.metadata", &trace.metadata)?;
    }
    let (mut plans, mut ids) = (Vec::new(), Vec::new());
    for topic in topics {
        plans.push(Ros2Encoder::new(trace, topic)?);
        ids.push(recording.add_topic(&topic.name, &topic.type_name)?);
    }
    let mut order: Vec<(i64, usize, usize)> = Vec::new();
    for (index, mapped) in plans.iter().enumerate() {
        let times = trace.channels[mapped.channel].times_secs.iter().enumerate();
        order.extend(times.map(|(row, &secs)| (options.nanos_of(secs), index, row)));
    }
    order.sort_unstable();
    let (mut messages, mut left_out) = (0, 0);
    for (nanos, index, row) in order {
        match plans[index].values(trace, row, nanos) {
            Some(values) => {
                let mapped = &plans[index];
                recording.write_planned(ids[index], nanos, &mapped.plan, &values)?;
                messages += 1;
            }
            None => left_out += 1,
        }
    }
    Ok(Ros2TraceOutcome {
        bytes: recording.finish()?,
        messages,
        left_out,
    })
}

impl Ros2TraceOptions {
    fn nanos_of(&self, secs: f64) -> i64 {
        // A conversion from a double saturates.
        ((secs * 1e9).round() as i64).saturating_add(self.start_nanos)
    }
}

/// Makes the messages of one topic of the rows of a trace, one at a time, for those who send them
/// instead of writing a file.
///
/// ```
/// use recording::{Ros2Encoder, Ros2Source, Ros2Topic};
/// use trace::{Field, Trace};
/// let mut trace = Trace::new();
/// let robot = trace.add_channel("/robot", vec![Field::number("speed", "m/s")])?;
/// let topic = Ros2Topic {
///     name: "/speed".into(),
///     type_name: "std_msgs/msg/Float64".into(),
///     rows_of: "/robot".into(),
///     fields: vec![("data".into(), Ros2Source::Signal("/robot.speed".into()))],
/// };
/// let encoder = Ros2Encoder::new(&trace, &topic)?;
/// trace.channels[robot].push(0.5, &[1.5])?;
/// let mut message = Vec::new();
/// assert!(encoder.encode(&trace, 0, 500_000_000, &mut message)?);
/// assert_eq!(message, [0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0xf8, 0x3f]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Ros2Encoder<'t> {
    type_name: &'static str,
    plan: Plan,
    /// Index of the channel whose rows become messages.
    channel: usize,
    sources: Vec<Found<'t>>,
}

enum Found<'t> {
    Signal(SignalIndex),
    Fixed(Ros2Value<'t>),
    Stamp,
}

impl<'t> Ros2Encoder<'t> {
    /// The encoder of `topic` for traces with the channels of `trace`, which need no rows yet.
    ///
    /// # Errors
    /// [`Ros2WriteError`] if the table names a type, field or signal that is not there.
    pub fn new(trace: &Trace, topic: &'t Ros2Topic) -> Result<Self, Ros2WriteError> {
        let type_name =
            short_name(&topic.type_name).ok_or_else(|| Ros2WriteError::UnknownType {
                type_name: topic.type_name.clone(),
            })?;
        let unknown = |name: &str| Ros2WriteError::UnknownSignal {
            name: name.to_owned(),
        };
        let mut channels = trace.channels.iter();
        let channel = channels
            .position(|channel| channel.topic == topic.rows_of)
            .ok_or_else(|| unknown(&topic.rows_of))?;
        let mut sources = Vec::with_capacity(topic.fields.len());
        for (_, source) in &topic.fields {
            sources.push(match source {
                Ros2Source::Signal(name) => {
                    Found::Signal(trace.signal(name).ok_or_else(|| unknown(name))?)
                }
                Ros2Source::Number(number) => Found::Fixed(Ros2Value::Number(*number)),
                Ros2Source::Bool(value) => Found::Fixed(Ros2Value::Bool(*value)),
                Ros2Source::Text(text) => Found::Fixed(Ros2Value::Text(text)),
                Ros2Source::Stamp => Found::Stamp,
            });
        }
        let paths: Vec<&str> = topic.fields.iter().map(|(path, _)| path.as_str()).collect();
        let plan = Plan::new(type_name, &paths)?;
        Ok(Ros2Encoder {
            type_name,
            plan,
            channel,
            sources,
        })
    }

    /// The definition of the messages' type, in `ros2msg`.
    #[must_use]
    pub fn schema_text(&self) -> String {
        schema_text(self.type_name)
    }

    /// Index of the channel whose rows become messages.
    #[must_use]
    pub fn channel(&self) -> usize {
        self.channel
    }

    /// Writes the message of row `row` to `out`, replacing what is there, with `nanos` where the
    /// table wants the time. `false`, and no message, if a value is missing that cannot be NaN.
    ///
    /// # Errors
    /// [`Ros2WriteError`] if a value does not fit its field.
    pub fn encode(
        &self,
        trace: &Trace,
        row: usize,
        nanos: i64,
        out: &mut Vec<u8>,
    ) -> Result<bool, Ros2WriteError> {
        match self.values(trace, row, nanos) {
            Some(values) => self.plan.encode(&values, out).map(|()| true),
            None => Ok(false),
        }
    }

    /// The values for the message of row `row`; `None` if one is missing that cannot be NaN.
    fn values<'v>(&'v self, trace: &'v Trace, row: usize, nanos: i64) -> Option<Vec<Ros2Value<'v>>>
    where
        't: 'v,
    {
        let time_secs = *trace.channels[self.channel].times_secs.get(row)?;
        let mut values = Vec::with_capacity(self.sources.len());
        for (index, source) in self.sources.iter().enumerate() {
            values.push(match source {
                Found::Fixed(value) => *value,
                Found::Stamp => Ros2Value::Nanos(nanos),
                Found::Signal(signal) => {
                    let channel = &trace.channels[signal.channel];
                    let row = if signal.channel == self.channel {
                        Some(row)
                    } else {
                        let seen = channel.times_secs.partition_point(|&t| t <= time_secs);
                        seen.checked_sub(1)
                    };
                    let values = row.map_or(&[][..], |row| channel.row(row));
                    let value = values.get(signal.field).copied().unwrap_or(f64::NAN);
                    let kind = &channel.fields[signal.field].kind;
                    value_of(kind, value, self.plan.primitive_of(index))?
                }
            });
        }
        Some(values)
    }
}

fn value_of(kind: &FieldKind, value: f64, into: Option<Primitive>) -> Option<Ros2Value<'_>> {
    match kind {
        FieldKind::Number if matches!(into, Some(Primitive::Float32 | Primitive::Float64)) => {
            Some(Ros2Value::Number(value))
        }
        _ if value.is_nan() => None,
        FieldKind::Number => Some(Ros2Value::Number(value)),
        FieldKind::Bool => Some(Ros2Value::Bool(value != 0.0)),
        FieldKind::Enumeration(names) if into == Some(Primitive::Text) => {
            names.get(value as usize).map(|name| Ros2Value::Text(name))
        }
        FieldKind::Enumeration(_) => Some(Ros2Value::Number(value)),
    }
}
