//! Tables in Apache Parquet, written in one pass; read in [`read`].
//!
//! # Definition
//! A file is `PAR1`, row groups, a footer, the footer's length (4 bytes, little endian), `PAR1`. In
//! a row group each column is one chunk of one data page (version 1): the definition levels, where
//! values may be missing, as runs, then the present values in the encoding PLAIN, compressed
//! together with Zstandard. The footer is a structure of Apache Thrift in its compact protocol.
//! Source: Apache Parquet, *File format* and `parquet.thrift`, format version 2.10; Apache Thrift,
//! *Compact protocol encoding*.
//!
//! # Deviation
//! Only flat tables of truth values, whole numbers, doubles and texts; no dictionaries, statistics,
//! indexes or bloom filters, which no reader needs. Parquet has no place for a column's unit, so it
//! stands in the key-value metadata of each chunk (`unit`, `meaning`) and, where readers of whole
//! files look, in the file's under the key `corroborate.columns` as JSON.
//!
//! # Cost and guarantee
//! One row group is held in memory, of at most 65536 rows and about 16 MiB. The same rows give the
//! same bytes.
//!
//! ```
//! use recording::{Cell, ParquetColumn, ParquetType, ParquetWriter};
//! let columns = vec![
//!     ParquetColumn::new("episode", ParquetType::U64),
//!     ParquetColumn::new("robustness", ParquetType::Double).optional().in_unit("m"),
//! ];
//! let mut table = ParquetWriter::new(Vec::new(), columns, &[("study", "corridor")])?;
//! table.push(&[Cell::U64(1), Cell::Double(0.25)])?;
//! table.push(&[Cell::U64(2), Cell::Missing])?;
//! let bytes = table.finish()?;
//! assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
//! # Ok::<(), recording::ParquetError>(())
//! ```

mod column;
mod footer;
mod read;
mod thrift;

use column::Buffer;
pub use column::{Cell, ParquetColumn, ParquetType};
use footer::{Chunk, Group};
pub use read::{ParquetReadError, ParquetRows, ParquetTable};
use std::fmt;
use std::io::Write;

/// The letters at both ends of a file.
const MAGIC: &[u8; 4] = b"PAR1";

/// Rows of a row group, at most.
const GROUP_ROWS: u64 = 1 << 16;
/// Bytes of a row group before compression at which it is closed.
const GROUP_BYTES: usize = 16 << 20;

/// Why a table could not be written.
#[derive(Debug)]
pub enum ParquetError {
    /// The destination does not take it.
    Write(std::io::Error),
    /// A table has at least one column, and no two of one name.
    Columns(String),
    /// A row does not fit the columns.
    Row {
        /// Its number, from 0.
        row: u64,
        /// What does not fit.
        reason: String,
    },
}

impl fmt::Display for ParquetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Write(error) => write!(f, "the Parquet table cannot be written: {error}"),
            Self::Columns(reason) => write!(f, "no Parquet table has these columns: {reason}"),
            Self::Row { row, reason } => {
                write!(f, "row {row} does not fit the Parquet table: {reason}")
            }
        }
    }
}

impl std::error::Error for ParquetError {}

impl From<std::io::Error> for ParquetError {
    fn from(error: std::io::Error) -> Self {
        Self::Write(error)
    }
}

/// Writes one table.
#[derive(Debug)]
pub struct ParquetWriter<W: Write> {
    out: W,
    /// Bytes written so far.
    position: u64,
    columns: Vec<ParquetColumn>,
    buffers: Vec<Buffer>,
    /// Rows in the buffers.
    rows: u64,
    groups: Vec<Group>,
    metadata: Vec<(String, String)>,
}

impl<W: Write> ParquetWriter<W> {
    /// Begins a table; `metadata` are texts about it as a whole.
    ///
    /// # Errors
    /// [`ParquetError::Columns`] without columns or with two of one name; [`ParquetError::Write`].
    pub fn new(
        mut out: W,
        columns: Vec<ParquetColumn>,
        metadata: &[(&str, &str)],
    ) -> Result<Self, ParquetError> {
        if columns.is_empty() {
            return Err(ParquetError::Columns("there is none".into()));
        }
        let mut names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        names.sort_unstable();
        if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(ParquetError::Columns(format!("two are called {}", pair[0])));
        }
        let mut texts: Vec<(String, String)> = metadata
            .iter()
            .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
            .collect();
        texts.push(("corroborate.columns".into(), footer::columns_json(&columns)));
        out.write_all(MAGIC)?;
        Ok(Self {
            out,
            position: MAGIC.len() as u64,
            buffers: columns.iter().map(|_| Buffer::default()).collect(),
            columns,
            rows: 0,
            groups: Vec::new(),
            metadata: texts,
        })
    }

    /// Adds a row: a cell for each column.
    ///
    /// # Errors
    /// [`ParquetError::Row`] if a cell is of another type than its column, or missing where none
    /// may be; [`ParquetError::Write`].
    pub fn push(&mut self, row: &[Cell<'_>]) -> Result<(), ParquetError> {
        self.check(row)?;
        for ((buffer, column), cell) in self.buffers.iter_mut().zip(&self.columns).zip(row) {
            buffer.push(column, cell);
        }
        self.rows += 1;
        let bytes: usize = self.buffers.iter().map(Buffer::len).sum();
        if self.rows == GROUP_ROWS || bytes >= GROUP_BYTES {
            self.close_group()?;
        }
        Ok(())
    }

    fn check(&self, row: &[Cell<'_>]) -> Result<(), ParquetError> {
        let number = self.groups.iter().map(|group| group.rows).sum::<u64>() + self.rows;
        let unfit = |reason| {
            Err(ParquetError::Row {
                row: number,
                reason,
            })
        };
        if row.len() != self.columns.len() {
            let (cells, columns) = (row.len(), self.columns.len());
            return unfit(format!("it has {cells} cells for {columns} columns"));
        }
        match self
            .columns
            .iter()
            .zip(row)
            .find(|(column, cell)| !column.takes(cell))
        {
            Some((column, cell)) => unfit(format!("column {} does not take {cell:?}", column.name)),
            None => Ok(()),
        }
    }

    fn close_group(&mut self) -> Result<(), ParquetError> {
        let mut group = Group {
            rows: self.rows,
            chunks: Vec::new(),
        };
        for (buffer, column) in self.buffers.iter_mut().zip(&self.columns) {
            let page = buffer.page(column, self.rows)?;
            let chunk = Chunk {
                offset: self.position,
                uncompressed_bytes: page.uncompressed_bytes(),
                compressed_bytes: page.compressed_bytes(),
            };
            self.out.write_all(&page.header)?;
            self.out.write_all(&page.body)?;
            self.position += chunk.compressed_bytes;
            group.chunks.push(chunk);
        }
        self.groups.push(group);
        self.rows = 0;
        Ok(())
    }

    /// Ends the table and gives back the destination.
    ///
    /// # Errors
    /// [`ParquetError::Write`].
    pub fn finish(mut self) -> Result<W, ParquetError> {
        if self.rows > 0 {
            self.close_group()?;
        }
        let footer = footer::footer(&self.columns, &self.groups, &self.metadata);
        self.out.write_all(&footer)?;
        self.out.write_all(&(footer.len() as u32).to_le_bytes())?;
        self.out.write_all(MAGIC)?;
        self.out.flush()?;
        Ok(self.out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> Vec<ParquetColumn> {
        vec![
            ParquetColumn::new("number", ParquetType::U64),
            ParquetColumn::new("name", ParquetType::Text).optional(),
        ]
    }

    #[test]
    fn a_row_that_does_not_fit_is_refused_and_changes_nothing() {
        let mut table = ParquetWriter::new(Vec::new(), columns(), &[]).expect("columns");
        for bad in [
            vec![Cell::U64(1)],
            vec![Cell::Missing, Cell::Text("x")],
            vec![Cell::U64(1), Cell::Double(1.0)],
        ] {
            let error = table.push(&bad).expect_err("it does not fit");
            assert!(matches!(error, ParquetError::Row { row: 0, .. }), "{error}");
        }
        let empty = ParquetWriter::new(Vec::new(), columns(), &[]).expect("columns");
        assert_eq!(
            table.finish().expect("written"),
            empty.finish().expect("written")
        );
    }

    #[test]
    fn columns_that_cannot_be_are_refused() {
        let twice = vec![columns().remove(0), columns().remove(0)];
        for bad in [Vec::new(), twice] {
            let refused = ParquetWriter::new(Vec::new(), bad, &[]);
            assert!(matches!(refused, Err(ParquetError::Columns(_))));
        }
    }

    #[test]
    fn a_destination_that_is_full_is_an_error() {
        struct Full;
        impl Write for Full {
            fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
                Err(std::io::Error::from(std::io::ErrorKind::StorageFull))
            }
            fn flush(&mut self) -> std::io::Result<()> {
                Ok(())
            }
        }
        let refused = ParquetWriter::new(Full, columns(), &[]);
        assert!(matches!(refused, Err(ParquetError::Write(_))));
    }

    #[test]
    fn many_rows_make_several_groups_of_bounded_size() {
        let mut table = ParquetWriter::new(Vec::new(), columns(), &[]).expect("columns");
        for number in 0..GROUP_ROWS + 1 {
            table
                .push(&[Cell::U64(number), Cell::Text("violated")])
                .expect("a row");
        }
        assert_eq!((table.groups.len(), table.rows), (1, 1));
        let bytes = table.finish().expect("written");
        assert!(bytes.len() < 1 << 20, "{} bytes", bytes.len());
    }
}
