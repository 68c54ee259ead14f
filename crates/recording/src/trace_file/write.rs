//! Writing; the layout is described in [`super`].

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
use std::io::Cursor;
use std::path::Path;

use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, McapError, WriteOptions, Writer};

use super::schema::{Shape, quoted, schema_text};
use super::{FORMAT, METADATA_RECORD, TIME_ENTRY, TRACE_RECORD, nanos_of_secs, secs_of_nanos};
use trace::Trace;
use trace::{Channel, FieldKind, TraceError};
use trace::{FileError, write_file};

/// Size of a chunk before compression, in bytes; what a damaged place can cost.
const CHUNK_BYTES: u64 = 256 * 1024;

/// Why a trace could not be written.
#[derive(Debug)]
pub enum TraceWriteError {
    /// The trace is not well-formed.
    Trace(TraceError),
    /// The trace has more topics, or more text, than the format can hold.
    Format(String),
    /// The file could not be written.
    File(FileError),
}

impl fmt::Display for TraceWriteError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TraceWriteError::Trace(error) => write!(out, "the trace cannot be written: {error}"),
            TraceWriteError::Format(problem) => {
                write!(
                    out,
                    "the trace does not fit into an MCAP file: {problem}; split it"
                )
            }
            TraceWriteError::File(error) => error.fmt(out),
        }
    }
}

impl std::error::Error for TraceWriteError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            TraceWriteError::Trace(error) => Some(error),
            TraceWriteError::Format(_) => None,
            TraceWriteError::File(error) => Some(error),
        }
    }
}

impl From<McapError> for TraceWriteError {
    fn from(error: McapError) -> Self {
        TraceWriteError::Format(error.to_string())
    }
}

/// Writes `trace` to the file at `path`, which appears complete or not at all.
///
/// # Errors
/// [`TraceWriteError`] if the trace is not well-formed or the file cannot be written.
pub fn write_mcap(path: &Path, trace: &Trace) -> Result<(), TraceWriteError> {
    write_file(path, &to_mcap(trace)?).map_err(TraceWriteError::File)
}

/// The bytes of `trace` as an MCAP file; the same trace always gives the same bytes.
///
/// # Errors
/// [`TraceWriteError`] if the trace is not well-formed or has more than 65535 topics.
pub fn to_mcap(trace: &Trace) -> Result<Vec<u8>, TraceWriteError> {
    trace.validate().map_err(TraceWriteError::Trace)?;
    if trace
        .channels
        .iter()
        .any(|channel| channel.field_index(TIME_ENTRY).is_some())
    {
        return Err(TraceWriteError::Trace(TraceError::BadName {
            name: TIME_ENTRY.to_owned(),
            problem: "is the name of a field, but stands for the exact time in files; rename it",
        }));
    }
    let options = WriteOptions::new()
        .library("corroborate")
        .compression(Some(Compression::Zstd))
        // On numbers in text the fastest level is as small as the default, at a third of the time.
        .compression_level(1)
        // Threads would make the bytes depend on the machine.
        .compression_threads(0)
        .chunk_size(Some(CHUNK_BYTES));
    let mut writer = options.create(Cursor::new(Vec::new()))?;
    write_metadata(&mut writer, trace)?;
    let ids = write_channels(&mut writer, trace)?;
    write_messages(&mut writer, trace, &ids)?;
    writer.finish()?;
    Ok(writer.into_inner().into_inner())
}

type Output = Writer<Cursor<Vec<u8>>>;

fn write_metadata(writer: &mut Output, trace: &Trace) -> Result<(), TraceWriteError> {
    let about = BTreeMap::from([
        ("format".to_owned(), FORMAT.to_owned()),
        ("complete".to_owned(), trace.complete.to_string()),
    ]);
    writer.write_metadata(&Metadata {
        name: TRACE_RECORD.to_owned(),
        metadata: about,
    })?;
    let metadata = trace.metadata.clone();
    writer.write_metadata(&Metadata {
        name: METADATA_RECORD.to_owned(),
        metadata,
    })?;
    Ok(())
}

/// Writes the schemas and channels and returns the identifiers of the channels.
fn write_channels(writer: &mut Output, trace: &Trace) -> Result<Vec<u16>, TraceWriteError> {
    let mut ids = Vec::with_capacity(trace.channels.len());
    for channel in &trace.channels {
        let text =
            schema_text(channel).map_err(|error| TraceWriteError::Format(error.to_string()))?;
        let schema = writer.add_schema(&channel.topic, "jsonschema", text.as_bytes())?;
        ids.push(writer.add_channel(schema, &channel.topic, "json", &BTreeMap::new())?);
    }
    // Topics in a chunk of their own are there even if the first messages are lost.
    writer.flush()?;
    Ok(ids)
}

/// Writes all rows in order of time, and for equal times of channel.
fn write_messages(writer: &mut Output, trace: &Trace, ids: &[u16]) -> Result<(), TraceWriteError> {
    let shapes: Vec<Shape> = trace
        .channels
        .iter()
        .map(|channel| Shape::of(&channel.fields))
        .collect();
    let mut order: Vec<(f64, usize, usize)> = Vec::new();
    for (index, channel) in trace.channels.iter().enumerate() {
        let rows = channel.times_secs.iter().enumerate();
        order.extend(rows.map(|(row, &time_secs)| (time_secs, index, row)));
    }
    // Equal times keep the order of channels and rows, as the sort is stable.
    order.sort_by(|left, right| left.0.total_cmp(&right.0));
    let mut text = String::new();
    for (time_secs, index, row) in order {
        text.clear();
        push_message(&mut text, &trace.channels[index], &shapes[index], row);
        let nanos = nanos_of_secs(time_secs);
        let header = MessageHeader {
            channel_id: ids[index],
            sequence: u32::try_from(row).unwrap_or(u32::MAX),
            log_time: nanos,
            publish_time: nanos,
        };
        writer.write_to_known_channel(&header, text.as_bytes())?;
    }
    Ok(())
}

fn push_message(text: &mut String, channel: &Channel, shape: &Shape, row: usize) {
    push_value(text, channel, shape, channel.row(row));
    let time_secs = channel.times_secs[row];
    let stored_secs = secs_of_nanos(nanos_of_secs(time_secs));
    if stored_secs.to_bits() != time_secs.to_bits() {
        text.pop();
        let comma = if text.len() > 1 { "," } else { "" };
        let _ = write!(text, "{comma}\"{TIME_ENTRY}\":{time_secs:?}}}");
    }
}

/// Appends what `shape` holds of `row`.
fn push_value(text: &mut String, channel: &Channel, shape: &Shape, row: &[f64]) {
    match shape {
        Shape::Leaf(index) => push_leaf(text, &channel.fields[*index].kind, row[*index]),
        Shape::Object(entries) => {
            text.push('{');
            let start = text.len();
            for (name, below) in entries {
                if !has_value(below, row) {
                    continue;
                }
                if text.len() > start {
                    text.push(',');
                }
                push_name(text, name);
                push_value(text, channel, below, row);
            }
            text.push('}');
        }
    }
}

fn push_name(text: &mut String, name: &str) {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
    if name.bytes().all(is_plain) {
        text.push('"');
        text.push_str(name);
        text.push_str("\":");
    } else {
        text.push_str(&quoted(name));
        text.push(':');
    }
}

fn push_leaf(text: &mut String, kind: &FieldKind, value: f64) {
    match kind {
        // The debug form of a double is the shortest that reads back the same, and valid JSON. The library writes the
        // same in less time, but for a stretch of numbers that it writes without an exponent.
        FieldKind::Number if (1e-5..1e-4).contains(&value.abs()) => {
            let _ = write!(text, "{value:?}");
        }
        FieldKind::Number => text.push_str(ryu::Buffer::new().format(value)),
        FieldKind::Bool => text.push_str(if value == 0.0 { "false" } else { "true" }),
        FieldKind::Enumeration(names) => {
            // The trace was validated: the value is an index.
            let name = names.get(value as usize).map_or("", String::as_str);
            text.push_str(&quoted(name));
        }
    }
}

fn has_value(shape: &Shape, row: &[f64]) -> bool {
    match shape {
        Shape::Leaf(index) => !row[*index].is_nan(),
        Shape::Object(entries) => entries.iter().any(|(_, below)| has_value(below, row)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_are_written_as_their_debug_form(
            bits in any::<u64>(),
            rounded in -1e6..1e6_f64,
            exponent in -20..20_i32,
        ) {
            let round = rounded.round();
            let power = rounded.signum() * 10_f64.powi(exponent);
            for value in [f64::from_bits(bits), (rounded * 1e3).round() / 1e3, round, power] {
                let mut text = String::new();
                push_leaf(&mut text, &FieldKind::Number, value);
                prop_assert_eq!(text, format!("{value:?}"));
            }
        }
    }
}
