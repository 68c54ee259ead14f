//! Timed signals: read, write, resample, evaluate predicates.
mod channel;
mod signal;

pub use channel::{Channel, Field, FieldKind, TraceError};
pub use signal::{Cursor, SignalIndex, Trace};
