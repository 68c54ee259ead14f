//! Tables in Apache Parquet, read column by column.
//!
//! # Definition
//! The file as [`super`] describes it: the footer says where the values of each column and row group stand. A column of values,
//! or of lists of values, is read by its name; the others are not looked at.
//! Source: Apache Parquet, *File format* and `parquet.thrift`, format version 2.10; pages of both versions.
//!
//! # Deviation
//! Read are the encodings PLAIN, RLE and that of dictionaries, without compression or compressed with Snappy, Zstandard or LZ4
//! (raw): what pyarrow, pandas and polars write if nothing else is asked for. Others are refused by name, as are lists of lists,
//! structures, numbers of 96 bits and encrypted files.
//!
//! # Cost and guarantee
//! Time and memory are linear in the columns that are read. No bytes make it panic, and none make it hold more than
//! [`MOST_ROWS_PER_BYTE`] values a byte: what a file claims is held against its length first. Checksums of pages are checked
//! where there are some.
//!
//! ```
//! use recording::{Cell, ParquetColumn, ParquetTable, ParquetType, ParquetWriter};
//! let columns = vec![ParquetColumn::new("robustness", ParquetType::Double).optional()];
//! let mut table = ParquetWriter::new(Vec::new(), columns, &[])?;
//! table.push(&[Cell::Double(0.25)])?;
//! table.push(&[Cell::Missing])?;
//! let bytes = table.finish()?;
//! let rows = ParquetTable::open(&bytes)?.column("robustness")?;
//! assert_eq!(rows.doubles().expect("numbers"), [Some(0.25), None]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod levels;
mod pages;
mod schema;
mod thrift;
mod values;

use values::ColumnValues;
pub use values::ParquetRows;

use super::MAGIC;
use schema::{Group, Leaf};
use std::fmt;
use thrift::Bytes;

/// Rows that a byte of a file can stand for; a file that claims more is damaged, or holds the same value over and over.
pub const MOST_ROWS_PER_BYTE: usize = 1 << 10;

/// Why a table could not be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParquetReadError {
    /// What is wrong, with the column and the byte where they are known.
    pub message: String,
    /// Whether the file is as the format has it, and holds what is not read here.
    pub is_unread_form: bool,
}

impl fmt::Display for ParquetReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for ParquetReadError {}

/// What is wrong with a file, and where.
#[derive(Debug, Clone)]
struct Damage {
    message: String,
    is_unread_form: bool,
    at: Option<usize>,
    column: Option<String>,
}

impl Damage {
    fn new(message: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            is_unread_form: false,
            at: None,
            column: None,
        }
    }

    /// What the format has and is not read here.
    fn unread(message: impl Into<String>) -> Self {
        Self {
            is_unread_form: true,
            ..Self::new(message)
        }
    }

    fn at(mut self, byte: usize) -> Self {
        self.at.get_or_insert(byte);
        self
    }

    fn of(mut self, leaf: &Leaf) -> Self {
        self.column.get_or_insert_with(|| leaf.path.join("/"));
        self
    }
}

impl From<Damage> for ParquetReadError {
    fn from(damage: Damage) -> Self {
        let column = damage.column.map(|it| format!("column `{it}`"));
        let byte = damage.at.map(|it| format!("byte {it}"));
        let place: Vec<String> = column.into_iter().chain(byte).collect();
        let message = match place.is_empty() {
            true => damage.message,
            false => format!("{}: {}", place.join(", "), damage.message),
        };
        Self {
            message,
            is_unread_form: damage.is_unread_form,
        }
    }
}

/// A table whose footer has been read.
#[derive(Debug)]
pub struct ParquetTable<'a> {
    file: &'a [u8],
    leaves: Vec<Leaf>,
    groups: Vec<Group>,
}

impl<'a> ParquetTable<'a> {
    /// Reads the footer of a table.
    ///
    /// # Errors
    /// If the bytes are no table, or its footer is damaged or encrypted.
    pub fn open(file: &'a [u8]) -> Result<Self, ParquetReadError> {
        let footer = footer(file)?;
        let footer = Bytes::new(footer).structure()?;
        let leaves = schema::leaves(&footer)?;
        let groups = schema::groups(&footer, &leaves, file.len())?;
        let rows = groups
            .iter()
            .fold(0_usize, |sum, it| sum.saturating_add(it.rows));
        if rows > file.len().saturating_mul(MOST_ROWS_PER_BYTE) {
            return Err(
                Damage::new(format!("{} bytes claim to hold {rows} rows", file.len())).into(),
            );
        }
        Ok(Self {
            file,
            leaves,
            groups,
        })
    }

    /// The number of its rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.groups.iter().map(|it| it.rows).sum()
    }

    /// The names of its columns, each once, in their order. A column that holds structures or lists has one name.
    #[must_use]
    pub fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.leaves.iter().map(|it| it.path[0].as_str()).collect();
        names.dedup();
        names
    }

    /// The values of a column in all rows.
    ///
    /// # Errors
    /// If there is no such column, it holds what is not read here, or it is damaged.
    pub fn column(&self, name: &str) -> Result<ParquetRows, ParquetReadError> {
        let mut own = self
            .leaves
            .iter()
            .enumerate()
            .filter(|(_, it)| it.path[0] == name);
        let Some((at, leaf)) = own.next() else {
            return Err(Damage::new(format!("there is no column `{name}`")).into());
        };
        if own.next().is_some() || leaf.repeated > 1 {
            let message = "it holds structures, or lists of lists, which are not read";
            return Err(Damage::unread(message).of(leaf).into());
        }
        let mut rows = ParquetRows::of(ColumnValues::of_kind(leaf.kind).map_err(|it| it.of(leaf))?);
        for group in &self.groups {
            let chunk = &group.chunks[at];
            let most = self.file.len().saturating_mul(MOST_ROWS_PER_BYTE);
            if chunk.values > most {
                return Err(Damage::new(format!("it claims {} values", chunk.values))
                    .of(leaf)
                    .into());
            }
            let before = rows.len();
            pages::chunk(self.file, leaf, chunk, &mut rows)?;
            let read = rows.len() - before;
            if read != group.rows {
                let message = format!("it has {read} rows, and its row group has {}", group.rows);
                return Err(Damage::new(message).of(leaf).into());
            }
        }
        Ok(rows)
    }
}

/// The footer's bytes.
fn footer(file: &[u8]) -> Result<&[u8], Damage> {
    let is_framed = file.len() >= 12 && file.starts_with(MAGIC);
    if !is_framed || !file.ends_with(MAGIC) {
        return Err(match file {
            _ if file.ends_with(b"PARE") => Damage::unread("the table is encrypted"),
            _ if file.starts_with(MAGIC) => Damage::new(
                "the table was not written to its end: its last four bytes are not `PAR1`",
            ),
            _ => Damage::new("this is not a table in Parquet: its first four bytes are not `PAR1`"),
        });
    }
    let (before, end) = file.split_at(file.len() - 8);
    let length = Bytes::new(end).u32()?;
    match before.len().checked_sub(length) {
        Some(start) if start >= MAGIC.len() => Ok(&before[start..]),
        _ => Err(Damage::new(format!(
            "the footer should have {length} bytes, more than the file"
        ))),
    }
}
