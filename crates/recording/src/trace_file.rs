//! Traces as MCAP files, which open in Foxglove and other viewers.
//!
//! # Layout
//! MCAP is the container of <https://mcap.dev/spec>. Each [`Channel`](trace::Channel) is one MCAP
//! channel with message encoding `json` and a schema of encoding `jsonschema`. The schema holds,
//! beside what viewers need, the fields in their order with unit, frame and kind under the key
//! `x-corroborate`, so that reading gives back the channel that was written.
//! * A message is an object with one entry for each field that has a value in that row; entries
//!   of missing values (NaN) are left out. Dots in names nest: `hand.x` and `hand.y` are written
//!   `{"hand": {"x": 1.0, "y": 2.0}}`, unless a topic also has a field `hand`.
//! * Numbers are written with the fewest digits that give back the same double.
//! * The time of a message is the row's time rounded to nanoseconds. Where that, divided by 10^9,
//!   is not exactly the row's time, the message holds the exact time in the entry `_time_secs`.
//!   Times on a grid of whole milliseconds, computed as `k / 1000`, need none.
//! * Messages stand in order of time; of equal times, in order of the channels.
//! * Metadata records: `corroborate.trace` holds the version of this layout and whether the trace
//!   was complete, `corroborate.metadata` the trace's own metadata. They come first, so that a
//!   file that was cut short still has them.
//!
//! # Guarantees
//! The same trace gives the same bytes. Reading gives back the same trace, bit for bit (all NaNs
//! count as one). Damage is found by the checksums of the format and reported; what stands before
//! it is kept, and the trace is then marked incomplete. Reading never takes part of a damaged
//! chunk (256 KiB before compression).

mod message;
mod read;
mod schema;
mod write;

pub use read::{ReadOutcome, TraceReadError, TraceReadProblem, from_mcap, read_mcap};
pub use write::{TraceWriteError, to_mcap, write_mcap};

/// The version of the layout.
const FORMAT: &str = "1";
/// Name of the metadata record about the trace as a whole.
const TRACE_RECORD: &str = "corroborate.trace";
/// Name of the metadata record with the trace's own metadata.
const METADATA_RECORD: &str = "corroborate.metadata";
/// The entry of a message that holds the exact time where nanoseconds do not.
const TIME_ENTRY: &str = "_time_secs";

/// How far into a file the record about the trace is looked for, in bytes.
const HEAD_BYTES: u64 = 4096;

/// Whether the file at `path` is a trace that [`write_mcap`] wrote, rather than any other MCAP file.
///
/// # Errors
/// If the file cannot be read.
pub fn is_trace_file(path: &std::path::Path) -> std::io::Result<bool> {
    use std::io::Read;
    let mut head = Vec::new();
    crate::open::open_file(path)?
        .take(HEAD_BYTES)
        .read_to_end(&mut head)?;
    let name = TRACE_RECORD.as_bytes();
    Ok(head.windows(name.len()).any(|window| window == name))
}

/// The time in seconds that a number of nanoseconds stands for.
fn secs_of_nanos(nanos: u64) -> f64 {
    nanos as f64 / 1e9
}

/// The nearest number of nanoseconds; times before 0 and beyond the range become its ends.
fn nanos_of_secs(secs: f64) -> u64 {
    // A conversion from a double saturates.
    (secs * 1e9).round() as u64
}
