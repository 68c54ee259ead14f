//! Tables as CSV files: a line of headers, then one line for each row.
//!
//! The format is that of RFC 4180 (Shafranovich 2005), with these liberties: lines that begin with
//! `#` are comments, blanks around a cell are dropped, a byte order mark is skipped, and any line
//! ending will do. Every error names the file, the line and the column.

mod error;

use std::path::Path;

pub use error::TableError;

use crate::file::read_text;
use crate::suggest::nearest;

/// A table with named columns of texts.
///
/// ```
/// let table = trace::Table::parse("cohort.csv", "subject,successes\nA,9\nB,10\n")?;
/// assert_eq!(table.len(), 2);
/// assert_eq!(table.column("successes")?.as_integers()?, [9, 10]);
/// assert_eq!(table.column("subject")?.as_texts(), ["A", "B"]);
///
/// let error = table.column("success").unwrap_err();
/// assert_eq!(error.to_string(), "cohort.csv: it has no column \"success\"; did you mean successes?");
/// # Ok::<(), trace::TableError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    name: String,
    headers: Vec<String>,
    /// The cells row by row.
    cells: Vec<String>,
    /// The line in the file at which each row begins, from 1.
    lines: Vec<u64>,
}

/// One column of a [`Table`].
#[derive(Debug, Clone, Copy)]
pub struct Column<'t> {
    table: &'t Table,
    index: usize,
}

impl Table {
    /// Reads the table in the file at `path`.
    ///
    /// # Errors
    /// [`TableError`] if the file cannot be read or is no table.
    pub fn read(path: &Path) -> Result<Self, TableError> {
        let text = read_text(path).map_err(TableError::File)?;
        Table::parse(&path.display().to_string(), &text)
    }

    /// Takes a table from `text`; `name` stands for it in errors.
    ///
    /// # Errors
    /// [`TableError`] if there are no headers, two are the same, or a row does not fit them.
    pub fn parse(name: &str, text: &str) -> Result<Self, TableError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut place = Place {
            text,
            byte: 0,
            line: 1,
        };
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let malformed = |error: csv::Error| TableError::Malformed {
            table: name.to_owned(),
            problem: error.to_string(),
        };
        let mut record = csv::StringRecord::new();
        if !reader.read_record(&mut record).map_err(malformed)? {
            return Err(TableError::Empty {
                table: name.to_owned(),
            });
        }
        let headers: Vec<String> = record.iter().map(str::to_owned).collect();
        check_delimiter(name, &headers)?;
        check_headers(name, &headers)?;
        let mut table = Table {
            name: name.to_owned(),
            headers,
            cells: Vec::new(),
            lines: Vec::new(),
        };
        while reader.read_record(&mut record).map_err(malformed)? {
            let from = record.position().map_or(0, csv::Position::byte);
            table.push(&record, place.line_of_record(from))?;
        }
        Ok(table)
    }

    fn push(&mut self, record: &csv::StringRecord, line: u64) -> Result<(), TableError> {
        if record.len() != self.headers.len() {
            return Err(TableError::Ragged {
                table: self.name.clone(),
                line,
                expected: self.headers.len(),
                found: record.len(),
            });
        }
        self.cells.extend(record.iter().map(str::to_owned));
        self.lines.push(line);
        Ok(())
    }

    /// What stands for this table in errors: its path, if it was read from a file.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The headers of the columns, in order.
    #[must_use]
    pub fn headers(&self) -> &[String] {
        &self.headers
    }

    /// Number of rows, without the headers.
    #[must_use]
    pub fn len(&self) -> usize {
        self.lines.len()
    }

    /// Whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// The line of the file at which row `row` begins, from 1; `None` if there is no such row.
    #[must_use]
    pub fn line(&self, row: usize) -> Option<u64> {
        self.lines.get(row).copied()
    }

    /// The column with the header `header`.
    ///
    /// # Errors
    /// [`TableError::MissingColumn`] if there is none.
    pub fn column(&self, header: &str) -> Result<Column<'_>, TableError> {
        match self.headers.iter().position(|other| other == header) {
            Some(index) => Ok(Column { table: self, index }),
            None => Err(TableError::MissingColumn {
                table: self.name.clone(),
                header: header.to_owned(),
                similar: nearest(header, self.headers.iter().map(String::as_str)),
                headers: self.headers.clone(),
            }),
        }
    }

    /// All columns, in order.
    pub fn columns(&self) -> impl Iterator<Item = Column<'_>> {
        (0..self.headers.len()).map(|index| Column { table: self, index })
    }
}

/// Counts lines on the way through a text.
struct Place<'t> {
    text: &'t str,
    byte: usize,
    /// The line in which `byte` lies, from 1.
    line: u64,
}

impl Place<'_> {
    /// The line of the record that begins at byte `from`, or behind the blank lines and comments
    /// that stand there. `from` must not decrease.
    fn line_of_record(&mut self, from: u64) -> u64 {
        let bytes = self.text.as_bytes();
        let from = usize::try_from(from).unwrap_or(usize::MAX);
        let mut in_comment = false;
        while let Some(&byte) = bytes.get(self.byte) {
            let ends_line = matches!(byte, b'\r' | b'\n');
            if self.byte >= from {
                let begins_line =
                    self.byte == from || matches!(bytes[self.byte - 1], b'\r' | b'\n');
                in_comment = (in_comment && !begins_line) || (begins_line && byte == b'#');
                if !ends_line && !in_comment {
                    break;
                }
            }
            let within_pair = byte == b'\r' && bytes.get(self.byte + 1) == Some(&b'\n');
            self.line += u64::from(ends_line && !within_pair);
            self.byte += 1;
        }
        self.line
    }
}

/// Semicolons or tabs in a lone header are those of another dialect.
fn check_delimiter(name: &str, headers: &[String]) -> Result<(), TableError> {
    let [header] = headers else { return Ok(()) };
    let known = [(';', "semicolons"), ('\t', "tabs")];
    match known
        .iter()
        .find(|(delimiter, _)| header.contains(*delimiter))
    {
        Some((_, delimiter)) => Err(TableError::Delimiter {
            table: name.to_owned(),
            delimiter,
        }),
        None => Ok(()),
    }
}

fn check_headers(name: &str, headers: &[String]) -> Result<(), TableError> {
    for (index, header) in headers.iter().enumerate() {
        if header.is_empty() {
            return Err(TableError::EmptyHeader {
                table: name.to_owned(),
                column: index + 1,
            });
        }
        if headers[..index].contains(header) {
            let header = header.clone();
            return Err(TableError::DuplicateHeader {
                table: name.to_owned(),
                header,
            });
        }
    }
    Ok(())
}

impl<'t> Column<'t> {
    /// The header.
    #[must_use]
    pub fn header(&self) -> &'t str {
        &self.table.headers[self.index]
    }

    /// The cells from the first row to the last.
    pub fn cells(&self) -> impl Iterator<Item = &'t str> + use<'t> {
        let Column { table, index } = *self;
        let width = table.headers.len();
        (0..table.len()).map(move |row| table.cells[row * width + index].as_str())
    }

    /// The cells as they are.
    #[must_use]
    pub fn as_texts(&self) -> Vec<&'t str> {
        self.cells().collect()
    }

    /// The cells as whole numbers.
    ///
    /// # Errors
    /// [`TableError::BadCell`] at the first cell that is none, or beyond 64 bits.
    pub fn as_integers(&self) -> Result<Vec<i64>, TableError> {
        self.convert("a whole number", |text| text.parse().ok())
    }

    /// The cells as counts: whole numbers that are not negative.
    ///
    /// # Errors
    /// [`TableError::BadCell`] at the first cell that is none, or beyond 64 bits.
    pub fn as_counts(&self) -> Result<Vec<u64>, TableError> {
        self.convert("a count (0, 1, 2, ...)", |text| text.parse().ok())
    }

    /// The cells as finite numbers.
    ///
    /// # Errors
    /// [`TableError::BadCell`] at the first cell that is none.
    pub fn as_numbers(&self) -> Result<Vec<f64>, TableError> {
        self.convert("a finite number", finite)
    }

    /// The cells as finite numbers, `None` where a cell is empty.
    ///
    /// # Errors
    /// [`TableError::BadCell`] at the first cell that is neither.
    pub fn as_optional_numbers(&self) -> Result<Vec<Option<f64>>, TableError> {
        self.convert("a finite number or empty", |text| {
            if text.is_empty() {
                Some(None)
            } else {
                finite(text).map(Some)
            }
        })
    }

    /// The cells as truth values: `true` and `false`, `yes` and `no`, or `1` and `0`.
    ///
    /// # Errors
    /// [`TableError::BadCell`] at the first cell that is none.
    pub fn as_bools(&self) -> Result<Vec<bool>, TableError> {
        self.convert("true or false", |text| match text {
            "true" | "yes" | "1" => Some(true),
            "false" | "no" | "0" => Some(false),
            _ => None,
        })
    }

    fn convert<T>(
        &self,
        expected: &'static str,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<Vec<T>, TableError> {
        let cells = self.cells().zip(&self.table.lines);
        let convert = |(text, &line): (&str, &u64)| {
            parse(text).ok_or_else(|| TableError::BadCell {
                table: self.table.name.clone(),
                line,
                header: self.header().to_owned(),
                text: text.to_owned(),
                expected,
            })
        };
        cells.map(convert).collect()
    }

    /// The error about the first cell for which `wrong` holds; there must be one.
    pub(crate) fn first_bad_cell(
        &self,
        wrong: impl Fn(&str) -> bool,
        expected: &'static str,
    ) -> TableError {
        let row = self.cells().position(wrong).unwrap_or(0);
        TableError::BadCell {
            table: self.table.name.clone(),
            line: self.line(row),
            header: self.header().to_owned(),
            text: self.cells().nth(row).unwrap_or_default().to_owned(),
            expected,
        }
    }

    /// The line of the file at which row `row` begins, from 1; 0 if there is no such row.
    #[must_use]
    pub fn line(&self, row: usize) -> u64 {
        self.table.lines.get(row).copied().unwrap_or(0)
    }
}

/// `text` as a finite number.
pub(crate) fn finite(text: &str) -> Option<f64> {
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        Table::parse("t.csv", text).unwrap_err().to_string()
    }

    #[test]
    fn quotes_comments_blanks_and_line_endings() {
        let text = "\u{feff}# who\r\nname , note\r\n a ,\"x, \"\"y\"\"\nz\"\r\n\r\nb,\r\n";
        let table = Table::parse("t.csv", text).unwrap();
        assert_eq!(table.headers(), ["name", "note"]);
        assert_eq!(table.column("name").unwrap().as_texts(), ["a", "b"]);
        assert_eq!(
            table.column("note").unwrap().as_texts(),
            ["x, \"y\"\nz", ""]
        );
        assert_eq!(table.column("name").unwrap().line(0), 3);
        assert_eq!(table.column("name").unwrap().line(1), 6);
    }

    #[test]
    fn malformed_tables_are_refused_with_their_place() {
        assert!(error("").contains("t.csv: it is empty"));
        assert!(error("# nothing\n\n").contains("t.csv: it is empty"));
        assert!(error("a,,b\n").contains("column 2 has no header"));
        assert!(error("a,b,a\n").contains("two columns \"a\""));
        assert!(error("a,b\n1,2\n3\n").contains("line 3: found 1 cells under 2 headers"));
        assert!(error("a\n1,2\n").contains("line 2: found 2 cells under 1 headers"));
    }

    #[test]
    fn columns_are_typed() {
        let text = "i,x,o,b\n-3,0.5,,yes\n4,1e3,2,0\n";
        let table = Table::parse("t.csv", text).unwrap();
        let column = |header| table.column(header).unwrap();
        assert_eq!(column("i").as_integers().unwrap(), [-3, 4]);
        assert_eq!(column("x").as_numbers().unwrap(), [0.5, 1000.0]);
        assert_eq!(
            column("o").as_optional_numbers().unwrap(),
            [None, Some(2.0)]
        );
        assert_eq!(column("b").as_bools().unwrap(), [true, false]);
        let message = column("i").as_counts().unwrap_err().to_string();
        assert!(
            message.contains("line 2, column \"i\": \"-3\" is not a count"),
            "{message}"
        );
        let message = column("x").as_integers().unwrap_err().to_string();
        assert!(
            message.contains("\"0.5\" is not a whole number"),
            "{message}"
        );
        assert!(column("o").as_numbers().is_err());
        for bad in ["inf", "NaN", "1e999", "1,000"] {
            let table = Table::parse("t.csv", &format!("x\n\"{bad}\"\n")).unwrap();
            assert!(table.column("x").unwrap().as_numbers().is_err(), "{bad}");
        }
        assert!(
            table
                .column("zebra")
                .unwrap_err()
                .to_string()
                .contains("it has i, x, o, b")
        );
    }
}
