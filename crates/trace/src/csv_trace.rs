//! Traces as CSV tables: a column `time_secs`, and one for each signal.
//!
//! A signal's header is `/topic.field`, with the unit behind it in square brackets if it has one:
//! `/robot.hand_speed [m/s]`. The topic ends at the first dot. A topic gets a row at each line
//! where any of its cells is filled; empty cells of such a row are missing values. A column whose
//! filled cells are all numbers holds numbers, where `nan` is a missing one; if all are `true` or
//! `false`, truth values; otherwise, an enumeration with the names in alphabetical order. A column
//! in which only some cells are numbers, or which has a unit but other cells than numbers, is
//! refused, as is any other column, so that neither a decimal comma nor a misspelt header is
//! overlooked.

mod write;

use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;

pub use write::{CsvWriteError, table_of_trace, write_csv_trace};

use crate::channel::{Channel, Field, FieldKind, TraceError};
use crate::signal::Trace;
use crate::table::{Column, Table, TableError, finite};

/// The header of the column of times.
const TIME_HEADER: &str = "time_secs";

/// Why a table is no trace.
#[derive(Debug)]
pub enum CsvTraceError {
    /// The table itself is wrong.
    Table(TableError),
    /// A header is neither `time_secs` nor a signal.
    Header {
        /// The table.
        table: String,
        /// The header.
        header: String,
    },
    /// The values do not make a trace.
    Trace {
        /// The table.
        table: String,
        /// The line of the file, from 1.
        line: u64,
        /// What is wrong.
        error: TraceError,
    },
}

impl fmt::Display for CsvTraceError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CsvTraceError::Table(error) => error.fmt(out),
            CsvTraceError::Header { table, header } => write!(
                out,
                "{table}: the header \"{header}\" is neither {TIME_HEADER} nor a signal; write it \
                 as /topic.field or /topic.field [unit]"
            ),
            CsvTraceError::Trace { table, line, error } => {
                write!(out, "{table}, line {line}: {error}")
            }
        }
    }
}

impl std::error::Error for CsvTraceError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            CsvTraceError::Table(error) => Some(error),
            CsvTraceError::Header { .. } => None,
            CsvTraceError::Trace { error, .. } => Some(error),
        }
    }
}

impl From<TableError> for CsvTraceError {
    fn from(error: TableError) -> Self {
        CsvTraceError::Table(error)
    }
}

/// Reads the CSV table at `path` as a trace.
///
/// # Errors
/// [`CsvTraceError`] with the file and the line.
pub fn read_csv_trace(path: &Path) -> Result<Trace, CsvTraceError> {
    trace_of_table(&Table::read(path)?)
}

/// Takes a table as a trace.
///
/// ```
/// let table = trace::Table::parse("run.csv", "time_secs,/robot.speed [m/s]\n0.0,0.1\n0.5,0.2\n")?;
/// let trace = trace::trace_of_table(&table)?;
/// assert_eq!(trace.channels[0].fields[0].unit, "m/s");
/// assert_eq!(trace.channels[0].values, [0.1, 0.2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`CsvTraceError`] if there is no column `time_secs`, a header is no signal, or the times are
/// not numbers in order.
pub fn trace_of_table(table: &Table) -> Result<Trace, CsvTraceError> {
    let time_column = table.column(TIME_HEADER)?;
    let times_secs = time_column.as_numbers()?;
    let at_line = |row: usize, error| CsvTraceError::Trace {
        table: table.name().to_owned(),
        line: time_column.line(row).max(1),
        error,
    };
    let mut trace = Trace::new();
    for (topic, signals) in topics(table)? {
        let fields = signals.iter().map(|signal| signal.field.clone()).collect();
        let mut channel = Channel::new(topic, fields);
        for (row, &time_secs) in times_secs.iter().enumerate() {
            let values: Vec<f64> = signals.iter().map(|signal| signal.values[row]).collect();
            if values.iter().any(|value| !value.is_nan()) {
                channel
                    .push(time_secs, &values)
                    .map_err(|error| at_line(row, error))?;
            }
        }
        channel
            .validate()
            .map_err(|error| at_line(usize::MAX, error))?;
        trace.channels.push(channel);
    }
    Ok(trace)
}

/// A column with its type and values.
struct Signal {
    field: Field,
    values: Vec<f64>,
}

/// The topics in the order of their first columns, with their signals.
fn topics(table: &Table) -> Result<Vec<(String, Vec<Signal>)>, CsvTraceError> {
    let mut topics: Vec<(String, Vec<Signal>)> = Vec::new();
    for column in table
        .columns()
        .filter(|column| column.header() != TIME_HEADER)
    {
        let Some((topic, field, unit)) = split_header(column.header()) else {
            let header = column.header().to_owned();
            return Err(CsvTraceError::Header {
                table: table.name().to_owned(),
                header,
            });
        };
        let (kind, values) = typed(&column, unit)?;
        let field = Field {
            name: field.to_owned(),
            unit: unit.to_owned(),
            frame: None,
            kind,
        };
        let signal = Signal { field, values };
        match topics.iter_mut().find(|(other, _)| other == topic) {
            Some((_, signals)) => signals.push(signal),
            None => topics.push((topic.to_owned(), vec![signal])),
        }
    }
    Ok(topics)
}

/// `/topic.field [unit]` as topic, field and unit. An index right behind the name, as in
/// `/arm.position[3]`, belongs to the field.
fn split_header(header: &str) -> Option<(&str, &str, &str)> {
    let bracket = header
        .strip_suffix(']')
        .and_then(|rest| rest.rsplit_once('['));
    let is_index = |(name, unit): (&str, &str)| {
        !name.ends_with(' ') && unit.bytes().all(|byte| byte.is_ascii_digit())
    };
    let (name, unit) = match bracket.filter(|&bracket| !is_index(bracket)) {
        Some((name, unit)) => (name.trim_end(), unit.trim()),
        None => (header, ""),
    };
    let (topic, field) = name.split_once('.')?;
    (topic.starts_with('/') && topic.len() > 1 && !field.is_empty()).then_some((topic, field, unit))
}

/// Whether a cell stands for a missing value.
fn is_missing(text: &str) -> bool {
    text.is_empty() || text.eq_ignore_ascii_case("nan")
}

/// The kind that fits all filled cells of `column`, and its values; `unit` is that of its header.
fn typed(column: &Column<'_>, unit: &str) -> Result<(FieldKind, Vec<f64>), TableError> {
    let filled = || column.cells().filter(|text| !is_missing(text));
    if filled().all(|text| finite(text).is_some()) {
        let values = column.cells().map(|text| finite(text).unwrap_or(f64::NAN));
        return Ok((FieldKind::Number, values.collect()));
    }
    let expected = "a finite number, as its unit or other cells of its column say";
    if !unit.is_empty() || filled().any(is_like_a_number) {
        let wrong = |text: &str| !is_missing(text) && finite(text).is_none();
        return Err(column.first_bad_cell(wrong, expected));
    }
    if filled().all(|text| matches!(text, "true" | "false")) {
        let value = |text: &str| match text {
            "true" => 1.0,
            "false" => 0.0,
            _ => f64::NAN,
        };
        return Ok((FieldKind::Bool, column.cells().map(value).collect()));
    }
    let names: BTreeSet<&str> = filled().collect();
    let names: Vec<String> = names.into_iter().map(str::to_owned).collect();
    let value = |text: &str| {
        let index = names.binary_search_by(|name| name.as_str().cmp(text));
        index.map_or(f64::NAN, |index| index as f64)
    };
    let values = column.cells().map(value).collect();
    Ok((FieldKind::Enumeration(names), values))
}

/// Whether `text` is a number, or would be one with a decimal point for its comma.
fn is_like_a_number(text: &str) -> bool {
    text.replace(',', ".").parse::<f64>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Trace, CsvTraceError> {
        trace_of_table(&Table::parse("run.csv", text)?)
    }

    #[test]
    fn kinds_units_and_rates() {
        let trace = parse(
            "/robot.hand.x [m],time_secs,/human.ready,/robot.state\n\
             0.5,0.0,,idle\n,0.1,false,\n-1,0.2,true,\n,0.3,,grasp\n",
        )
        .unwrap();
        let [robot, human] = &trace.channels[..] else {
            panic!("there are two topics")
        };
        assert_eq!(robot.fields[0], Field::number("hand.x", "m"));
        assert_eq!(
            robot.fields[1],
            Field::enumeration("state", ["grasp", "idle"])
        );
        assert_eq!(robot.times_secs, [0.0, 0.2, 0.3]);
        assert_eq!(robot.values[..3], [0.5, 1.0, -1.0]);
        assert!(robot.values[3].is_nan() && robot.values[4].is_nan());
        assert_eq!(robot.values[5], 0.0);
        assert_eq!(human.fields[0], Field::bool("ready"));
        assert_eq!(
            (&human.times_secs[..], &human.values[..]),
            (&[0.1, 0.2][..], &[0.0, 1.0][..])
        );
        assert!(trace.complete);
    }

    #[test]
    fn indices_and_missing_values() {
        let trace =
            parse("time_secs,/a.q[3],/a.q[4] [rad],/a.n [1]\n0,1,NaN,2\n1,nan,0.5,\n").unwrap();
        let fields = &trace.channels[0].fields;
        assert_eq!(fields[0], Field::number("q[3]", ""));
        assert_eq!(fields[1], Field::number("q[4]", "rad"));
        assert_eq!(fields[2], Field::number("n", "1"));
        assert!(trace.channels[0].values[1].is_nan() && trace.channels[0].values[3].is_nan());
    }

    #[test]
    fn tables_that_are_no_traces_are_refused() {
        let message = |text| parse(text).unwrap_err().to_string();
        assert!(message("time,/a.x\n0,1\n").contains("no column \"time_secs\""));
        assert!(message("time_secs,speed\n0,1\n").contains("the header \"speed\" is neither"));
        assert!(message("time_secs,/a.x\nsoon,1\n").contains("line 2, column \"time_secs\""));
        assert!(message("time_secs,/a.x\n1,1\n0,1\n").contains("line 3: topic /a goes back"));
        assert!(message("time_secs,/a.x,/a.x [m]\n0,1,1\n").contains("names two fields"));
        let said = message("time_secs;/a.x\n0;1\n");
        assert!(said.contains("separated by semicolons"), "{said}");
        let said = message("time_secs\t/a.x\n0\t1\n");
        assert!(said.contains("separated by tabs"), "{said}");
        let said = message("time_secs,/a.x\n0,\"0,5\"\n1,\"0,6\"\n");
        assert!(
            said.contains("line 2, column \"/a.x\": \"0,5\" is not a finite"),
            "{said}"
        );
        assert!(said.contains("a decimal point"), "{said}");
        let said = message("time_secs,/a.x\n0,0,5\n");
        assert!(said.contains("a decimal point"), "{said}");
        let said = message("time_secs,/a.x [m]\n0,off\n");
        assert!(said.contains("\"off\" is not a finite number"), "{said}");
        let said = message("time_secs,/a.x\n0,1\n1,inf\n");
        assert!(
            said.contains("line 3") && said.contains("\"inf\""),
            "{said}"
        );
        let said = message("time_secs,/a.x\n0,1\n1,error\n");
        assert!(
            said.contains("line 3") && said.contains("\"error\""),
            "{said}"
        );
    }
}
