//! What can be wrong with a table, and where.

use std::fmt;

use crate::file::FileError;

/// Something wrong with a table.
#[derive(Debug)]
pub enum TableError {
    /// The file cannot be read.
    File(FileError),
    /// There is not even a line of headers.
    Empty {
        /// The table.
        table: String,
    },
    /// The cells are separated by something else than commas.
    Delimiter {
        /// The table.
        table: String,
        /// What they are separated by.
        delimiter: &'static str,
    },
    /// A header is empty.
    EmptyHeader {
        /// The table.
        table: String,
        /// Its column, from 1.
        column: usize,
    },
    /// Two columns have the same header.
    DuplicateHeader {
        /// The table.
        table: String,
        /// The header.
        header: String,
    },
    /// A row has more or fewer cells than there are headers.
    Ragged {
        /// The table.
        table: String,
        /// The line of the file, from 1.
        line: u64,
        /// Number of headers.
        expected: usize,
        /// Number of cells.
        found: usize,
    },
    /// The text cannot be taken apart into cells.
    Malformed {
        /// The table.
        table: String,
        /// What is wrong.
        problem: String,
    },
    /// There is no such column.
    MissingColumn {
        /// The table.
        table: String,
        /// The header that was asked for.
        header: String,
        /// A header with a similar name.
        similar: Option<String>,
        /// All headers.
        headers: Vec<String>,
    },
    /// A cell is not of the type that was asked for.
    BadCell {
        /// The table.
        table: String,
        /// The line of the file, from 1.
        line: u64,
        /// The header of the column.
        header: String,
        /// The text of the cell.
        text: String,
        /// What it should be.
        expected: &'static str,
    },
}

impl fmt::Display for TableError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TableError::File(error) => error.fmt(out),
            TableError::Empty { table } => {
                write!(
                    out,
                    "{table} is empty; begin it with a line of column headers"
                )
            }
            TableError::Delimiter { table, delimiter } => write!(
                out,
                "{table}: the cells seem to be separated by {delimiter}; save it separated by \
                 commas, with decimal points"
            ),
            TableError::EmptyHeader { table, column } => {
                write!(
                    out,
                    "{table}: column {column} has no header; name it in the first line"
                )
            }
            TableError::DuplicateHeader { table, header } => {
                write!(
                    out,
                    "{table} has two columns \"{header}\"; rename one of them"
                )
            }
            TableError::Ragged {
                table,
                line,
                expected,
                found,
            } => write!(
                out,
                "{table}, line {line}: found {found} cells under {expected} headers; give each \
                 row one cell for each header, and numbers a decimal point where they have a comma"
            ),
            TableError::Malformed { table, problem } => {
                write!(
                    out,
                    "{table}: {problem}; save it as comma-separated UTF-8 text"
                )
            }
            TableError::MissingColumn {
                table,
                header,
                similar: Some(similar),
                ..
            } => {
                write!(
                    out,
                    "{table} has no column \"{header}\"; did you mean {similar}?"
                )
            }
            TableError::MissingColumn {
                table,
                header,
                headers,
                ..
            } => write!(
                out,
                "{table} has no column \"{header}\"; it has {}",
                headers.join(", ")
            ),
            TableError::BadCell {
                table,
                line,
                header,
                text,
                expected,
            } => {
                let remedy = if text.contains(',') && text.replace(',', "").parse::<f64>().is_ok() {
                    "write numbers with a decimal point and without other separators"
                } else {
                    "correct the cell"
                };
                write!(
                    out,
                    "{table}, line {line}, column \"{header}\": \"{text}\" is not {expected}; \
                     {remedy}"
                )
            }
        }
    }
}

impl std::error::Error for TableError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            TableError::File(error) => Some(error),
            _ => None,
        }
    }
}
