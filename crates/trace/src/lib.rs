#![doc = include_str!("../README.md")]
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
//! # Speed
//! On one core of a server, for a minute of two topics at 100 Hz and one at 10 Hz, 27 fields most
//! of which hold random digits, 12,600 rows: recording 1 ms; evaluating 11 propositions at 20 Hz
//! 0.25 ms. `/robot.hand_speed < 250 mm/s` is evaluated 107 million times a second on a
//! [`Snapshot`] and its robustness 90 million times; with the arrival of a row of five values before
//! each evaluation, 23 million; a distance of two points takes 55 ns (`cargo bench -p corroborate-trace`).

mod channel;
mod csv_trace;
pub mod duration;
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
pub use suggest::{nearest, nearest_few};
pub use table::{Column, Table, TableError};
pub use vocabulary::Vocabulary;
