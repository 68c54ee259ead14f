//! Timed signals: read, write, resample, evaluate predicates.
mod channel;
mod file;
mod mcap_file;
mod predicate;
mod signal;
mod suggest;
mod vocabulary;

pub use channel::{Channel, Field, FieldKind, TraceError};
pub use file::{FileError, read_file, read_text, write_file};
pub use mcap_file::{
    ReadError, ReadOutcome, ReadProblem, WriteError, from_mcap, read_mcap, to_mcap, write_mcap,
};
pub use predicate::{
    BoundPredicate, BoundQuantity, Predicate, PredicateError, PredicateErrorKind, Quantity,
};
pub use signal::{Cursor, SignalIndex, Trace};
pub use vocabulary::Vocabulary;
