//! Timed signals: read, write, resample, evaluate predicates.
mod channel;
mod csv_trace;
mod file;
mod mcap_file;
mod predicate;
mod sampling;
mod signal;
mod suggest;
mod table;
mod vocabulary;

pub use channel::{Channel, Field, FieldKind, TraceError};
pub use csv_trace::{CsvTraceError, read_csv_trace, trace_of_table};
pub use file::{FileError, read_file, read_text, write_file};
pub use mcap_file::{
    ReadError, ReadOutcome, ReadProblem, WriteError, from_mcap, read_mcap, to_mcap, write_mcap,
};
pub use predicate::{
    BoundPredicate, BoundQuantity, Predicate, PredicateError, PredicateErrorKind, Quantity,
};
pub use sampling::{Sampling, SamplingError, Valuations, ticks};
pub use signal::{Cursor, SignalIndex, Trace};
pub use table::{Column, Table, TableError};
pub use vocabulary::Vocabulary;
