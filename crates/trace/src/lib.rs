//! Timed signals: read, write, resample, evaluate predicates.
mod channel;
mod predicate;
mod signal;
mod suggest;
mod vocabulary;

pub use channel::{Channel, Field, FieldKind, TraceError};
pub use predicate::{
    BoundPredicate, BoundQuantity, Predicate, PredicateError, PredicateErrorKind, Quantity,
};
pub use signal::{Cursor, SignalIndex, Trace};
pub use vocabulary::Vocabulary;
