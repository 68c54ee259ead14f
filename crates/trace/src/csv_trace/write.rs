//! Traces to CSV tables, in the form that [`super`] describes.
//!
//! Rows of different topics at one time share a line. What the form has no place for is lost:
//! frames, metadata, whether the trace is complete, rows without any value, and the order and the
//! unused ones of an enumeration's names.
//! Guarantee: times and values read back are those that were written, bit for bit; a trace of which
//! names would be misread is refused.
//! Cost: O(n log n) for n rows.

use std::fmt;
use std::path::Path;

use super::{TIME_HEADER, is_missing, split_header};
use crate::channel::{Channel, Field, FieldKind, TraceError};
use crate::file::{FileError, write_file};
use crate::signal::Trace;
use crate::table::finite;

/// Why a trace cannot be written as a table.
#[derive(Debug)]
pub enum CsvWriteError {
    /// The trace is not well-formed.
    Trace(TraceError),
    /// A name would not be read back as it is.
    Name {
        /// The signal, `/topic.field`.
        signal: String,
        /// The name: the signal itself, or one of an enumeration.
        name: String,
    },
    /// The text cannot be put together.
    Format(String),
    /// The file cannot be written.
    File(FileError),
}

impl fmt::Display for CsvWriteError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CsvWriteError::Trace(error) => write!(out, "the trace cannot be written: {error}"),
            CsvWriteError::Name { signal, name } => write!(
                out,
                "{signal} cannot be written to a table, where \"{name}\" would be read as \
                 something else; rename it or write an MCAP file"
            ),
            CsvWriteError::Format(problem) => {
                write!(
                    out,
                    "the trace cannot be written as a table: {problem}; write an MCAP file"
                )
            }
            CsvWriteError::File(error) => error.fmt(out),
        }
    }
}

impl std::error::Error for CsvWriteError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            CsvWriteError::Trace(error) => Some(error),
            CsvWriteError::File(error) => Some(error),
            CsvWriteError::Name { .. } | CsvWriteError::Format(_) => None,
        }
    }
}

/// Writes `trace` as a CSV table to the file at `path`, which appears complete or not at all.
///
/// # Errors
/// [`CsvWriteError`] if the trace does not fit into a table or the file cannot be written.
pub fn write_csv_trace(path: &Path, trace: &Trace) -> Result<(), CsvWriteError> {
    write_file(path, table_of_trace(trace)?.as_bytes()).map_err(CsvWriteError::File)
}

/// The text of `trace` as a CSV table.
///
/// ```
/// use trace::{Field, Trace, table_of_trace};
/// let mut trace = Trace::new();
/// let robot = trace.add_channel("/robot", vec![
///     Field::number("speed", "m/s"),
///     Field::enumeration("state", ["carry", "release"]),
/// ])?;
/// trace.channels[robot].push(0.5, &[0.25, 1.0])?;
/// let text = table_of_trace(&trace)?;
/// assert_eq!(text, "time_secs,/robot.speed [m/s],/robot.state\n0.5,0.25,release\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`CsvWriteError`] if the trace is not well-formed or a name would be misread.
pub fn table_of_trace(trace: &Trace) -> Result<String, CsvWriteError> {
    trace.validate().map_err(CsvWriteError::Trace)?;
    let mut cells = vec![TIME_HEADER.to_owned()];
    for channel in &trace.channels {
        for field in &channel.fields {
            cells.push(header(channel, field)?);
        }
    }
    let format = |error: csv::Error| CsvWriteError::Format(error.to_string());
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(&cells).map_err(format)?;
    for line in lines(trace) {
        cells.clear();
        cells.push(format!("{:?}", line.time_secs));
        for (channel, row) in trace.channels.iter().zip(&line.rows) {
            let width = channel.fields.len();
            match row {
                Some(row) => {
                    let row = channel.fields.iter().zip(channel.row(*row));
                    cells.extend(row.map(|(field, &value)| cell(field, value)));
                }
                None => cells.resize(cells.len() + width, String::new()),
            }
        }
        writer.write_record(&cells).map_err(format)?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| CsvWriteError::Format(error.to_string()))?;
    String::from_utf8(bytes).map_err(|error| CsvWriteError::Format(error.to_string()))
}

/// A line of the table: for each channel the row that stands in it.
struct Line {
    time_secs: f64,
    rows: Vec<Option<usize>>,
}

/// All rows in the order of time and channel; rows of one channel at one time take a line each.
fn lines(trace: &Trace) -> Vec<Line> {
    let mut order: Vec<(f64, usize, usize)> = Vec::new();
    for (index, channel) in trace.channels.iter().enumerate() {
        let rows = channel.times_secs.iter().enumerate();
        let rows = rows.filter(|(row, _)| channel.row(*row).iter().any(|value| !value.is_nan()));
        order.extend(rows.map(|(row, &time_secs)| (time_secs, index, row)));
    }
    // The sort is stable: equal times keep the order of channels and rows.
    order.sort_by(|left, right| left.0.total_cmp(&right.0));
    let mut lines: Vec<Line> = Vec::new();
    // Where the lines of the present time begin.
    let mut first = 0;
    for (time_secs, channel, row) in order {
        let bits = time_secs.to_bits();
        if lines
            .get(first)
            .is_none_or(|line| line.time_secs.to_bits() != bits)
        {
            first = lines.len();
        }
        let free = lines[first..]
            .iter_mut()
            .find(|line| line.rows[channel].is_none());
        match free {
            Some(line) => line.rows[channel] = Some(row),
            None => {
                let mut rows = vec![None; trace.channels.len()];
                rows[channel] = Some(row);
                lines.push(Line { time_secs, rows });
            }
        }
    }
    lines
}

fn header(channel: &Channel, field: &Field) -> Result<String, CsvWriteError> {
    let signal = format!("{}.{}", channel.topic, field.name);
    let text = if field.unit.is_empty() {
        signal.clone()
    } else {
        format!("{signal} [{}]", field.unit)
    };
    let expected = (&channel.topic[..], &field.name[..], &field.unit[..]);
    let misread = |name: &str| CsvWriteError::Name {
        signal: signal.clone(),
        name: name.to_owned(),
    };
    if split_header(&text) != Some(expected) || text != text.trim() {
        return Err(misread(&text));
    }
    if let FieldKind::Enumeration(names) = &field.kind {
        let wrong = names.iter().find(|name| {
            let other_kind = finite(name).is_some() || matches!(&name[..], "true" | "false");
            name.is_empty() || name.trim() != **name || other_kind || is_missing(name)
        });
        if let Some(name) = wrong {
            return Err(misread(name));
        }
    }
    Ok(text)
}

fn cell(field: &Field, value: f64) -> String {
    if value.is_nan() {
        return String::new();
    }
    match &field.kind {
        // The debug form of a double is the shortest that reads back the same.
        FieldKind::Number => format!("{value:?}"),
        FieldKind::Bool => (value != 0.0).to_string(),
        // The trace was validated: the value is an index.
        FieldKind::Enumeration(names) => names.get(value as usize).cloned().unwrap_or_default(),
    }
}
