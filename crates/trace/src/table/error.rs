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

impl TableError {
    /// The line of the file that is wrong, from 1; `None` where it is the headers or the whole.
    #[must_use]
    pub fn line(&self) -> Option<u64> {
        match self {
            TableError::Ragged { line, .. } | TableError::BadCell { line, .. } => Some(*line),
            TableError::File(_)
            | TableError::Empty { .. }
            | TableError::Delimiter { .. }
            | TableError::EmptyHeader { .. }
            | TableError::DuplicateHeader { .. }
            | TableError::Malformed { .. }
            | TableError::MissingColumn { .. } => None,
        }
    }

    /// What is wrong, without the table and its line.
    #[must_use]
    pub fn what(&self) -> String {
        match self {
            TableError::File(error) => error.to_string(),
            TableError::Empty { .. } => "it is empty".to_owned(),
            TableError::Delimiter { delimiter, .. } => {
                format!("the cells seem to be separated by {delimiter}")
            }
            TableError::EmptyHeader { column, .. } => format!("column {column} has no header"),
            TableError::DuplicateHeader { header, .. } => {
                format!("it has two columns \"{header}\"")
            }
            TableError::Ragged {
                expected, found, ..
            } => format!("found {found} cells under {expected} headers"),
            TableError::Malformed { problem, .. } => problem.clone(),
            TableError::MissingColumn { header, .. } => format!("it has no column \"{header}\""),
            TableError::BadCell {
                header,
                text,
                expected,
                ..
            } => format!("column \"{header}\": \"{text}\" is not {expected}"),
        }
    }

    /// What to do about it.
    #[must_use]
    pub fn remedy(&self) -> Option<String> {
        let remedy = match self {
            TableError::File(_) => return None,
            TableError::Empty { .. } => "begin it with a line of column headers",
            TableError::Delimiter { .. } => "save it separated by commas, with decimal points",
            TableError::EmptyHeader { .. } => "name it in the first line",
            TableError::DuplicateHeader { .. } => "rename one of them",
            TableError::Ragged { .. } => {
                "give each row one cell for each header, and numbers a decimal point where they have a comma"
            }
            TableError::Malformed { .. } => "save it as comma-separated UTF-8 text",
            TableError::MissingColumn {
                similar, headers, ..
            } => {
                return Some(match similar {
                    Some(similar) => format!("did you mean {similar}?"),
                    None => format!("it has {}", headers.join(", ")),
                });
            }
            TableError::BadCell { text, .. } => {
                if text.contains(',') && text.replace(',', "").parse::<f64>().is_ok() {
                    "write numbers with a decimal point and without other separators"
                } else {
                    "correct the cell"
                }
            }
        };
        Some(remedy.to_owned())
    }

    /// What stands for the table: its path, if it was read from a file; `None` if that cannot be read.
    #[must_use]
    pub fn table(&self) -> Option<&str> {
        match self {
            TableError::File(_) => None,
            TableError::Empty { table }
            | TableError::Delimiter { table, .. }
            | TableError::EmptyHeader { table, .. }
            | TableError::DuplicateHeader { table, .. }
            | TableError::Ragged { table, .. }
            | TableError::Malformed { table, .. }
            | TableError::MissingColumn { table, .. }
            | TableError::BadCell { table, .. } => Some(table),
        }
    }
}

impl fmt::Display for TableError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        // What is wrong with a cell begins with its column.
        let then = match self {
            TableError::BadCell { .. } => ", ",
            _ => ": ",
        };
        match (self.table(), self.line()) {
            (Some(table), Some(line)) => write!(out, "{table}, line {line}{then}")?,
            (Some(table), None) => write!(out, "{table}: ")?,
            (None, _) => {}
        }
        write!(out, "{}", self.what())?;
        self.remedy()
            .map_or(Ok(()), |remedy| write!(out, "; {remedy}"))
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
