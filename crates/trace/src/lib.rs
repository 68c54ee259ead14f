//! Timed signals: hold, resample, evaluate predicates.
//!
//! A [`Trace`] is what a run of a system left behind: for each topic a [`Channel`] with named
//! [`Field`]s (unit, frame, kind) and rows of values over time. It comes from a simulation, which
//! pushes rows, or from a file:
//!
//! | what | how |
//! |---|---|
//! | record | [`Trace::add_channel`], [`Channel::push`] |
//! | CSV tables of signals | [`read_csv_trace`], [`write_csv_trace`] |
//! | CSV tables of anything | [`Table`] |
//! | values at a time, with zero-order hold | [`Cursor`] |
//! | all samples of a trace in order, several at one instant, too | [`Replay`] |
//! | the latest values of a stream, and which are too old | [`Snapshot`] |
//! | statements about signals, in text, with truth and robustness | [`Predicate`], [`Quantity`] |
//! | names for such statements, and for limits with units | [`Vocabulary`], [`Parameters`] |
//! | which limits a statement has | [`Predicate::comparisons`], [`Predicate::constants`] |
//! | units and dimensions | [`units`] |
//! | statements at the ticks of a clock, for monitors | [`Valuations`] |
//!
//! Signals are named `/topic.field`. NaN marks a missing value; what depends on one is unknown
//! (`None`) and never guessed. Nothing here reads a clock: time is what the trace says. This crate
//! and the command line are the only ones that open files; [`write_file`] writes them so that they
//! appear whole or not at all.
//!
//! # Example
//! A robot is recorded, and afterwards asked whether it was slow near the human.
//! ```
//! use trace::{Field, Sampling, Trace, Valuations, Vocabulary};
//!
//! // A simulation records rows; a topic has its own rate.
//! let mut trace = Trace::new();
//! trace.metadata.insert("seed".into(), "42".into());
//! let robot = trace.add_channel("/robot", vec![
//!     Field::enumeration("state", ["carry", "release"]),
//!     Field::number("hand_speed", "m/s").in_frame("world"),
//! ])?;
//! let human = trace.add_channel("/human", vec![Field::number("distance", "m")])?;
//! for step in 0..=10 {
//!     let time_secs = f64::from(step) / 10.0;
//!     let state = if step < 6 { 0.0 } else { 1.0 };
//!     trace.channels[robot].push(time_secs, &[state, 0.3 - 0.02 * f64::from(step)])?;
//!     if step % 5 == 0 {
//!         trace.channels[human].push(time_secs, &[0.25 - 0.2 * time_secs])?;
//!     }
//! }
//!
//! // Propositions are defined once, looked up in the trace once, and then evaluated at each tick.
//! let vocabulary = Vocabulary::new([
//!     ("near", "/human.distance < 10 cm"),
//!     ("slow_when_near", "near => /robot.hand_speed < 250 mm/s"),
//! ]).map_err(|mut errors| errors.remove(0))?;
//! let slow_when_near = vocabulary.predicate("slow_when_near")?.bind(&trace)?;
//! let valuations = Valuations::sample(&trace, &[slow_when_near], Sampling::PollHz(20.0))?;
//! assert!((0..valuations.times_secs.len()).all(|tick| valuations.value(tick, 0) == Some(true)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Speed
//! On one core of a server, for a minute of two topics at 100 Hz and one at 10 Hz, 27 fields most
//! of which hold random digits, 12,600 rows: recording 1 ms; evaluating 11 propositions at 20 Hz
//! 0.25 ms. `/robot.hand_speed < 250 mm/s` is evaluated 107 million times a second on a
//! [`Snapshot`] and its robustness 90 million times; with the arrival of a row of five values before
//! each evaluation, 23 million; a distance of two points takes 55 ns (`cargo bench -p trace`).

mod channel;
mod csv_trace;
mod file;
mod parameters;
mod predicate;
mod replay;
mod sampling;
mod signal;
mod snapshot;
mod suggest;
mod table;
pub mod units;
mod vocabulary;

pub use channel::{Channel, Field, FieldKind, TraceError};
pub use csv_trace::{
    CsvTraceError, CsvWriteError, read_csv_trace, table_of_trace, trace_of_table, write_csv_trace,
};
pub use file::{FileError, create_folder, read_file, read_text, write_file};
pub use parameters::{ParameterError, ParameterErrorKind, Parameters};
pub use predicate::{
    AxisBox, BoundPredicate, BoundQuantity, Comparison, ComparisonOperator, Constant,
    FrameMismatch, Measure, Predicate, PredicateError, PredicateErrorKind, PredicateLint,
    PredicateLintKind, Quantity, Threshold, ThresholdOrigin, axis_boxes,
};
pub use replay::{Replay, Sample};
pub use sampling::{Sampling, SamplingError, Valuations, ticks};
pub use signal::{Cursor, SignalIndex, SignalValues, Trace};
pub use snapshot::Snapshot;
pub use suggest::nearest;
pub use table::{Column, Table, TableError};
pub use vocabulary::Vocabulary;
