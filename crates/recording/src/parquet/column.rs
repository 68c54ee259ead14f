//! A column: what it holds, and its values in the encoding PLAIN.

use super::thrift::{Structure, varint};

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParquetType {
    /// Truth values.
    Bool,
    /// Whole numbers from 0.
    U64,
    /// Numbers of double precision.
    Double,
    /// Texts in UTF-8.
    Text,
}

/// One value of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell<'a> {
    /// No value.
    Missing,
    /// A truth value.
    Bool(bool),
    /// A whole number.
    U64(u64),
    /// A number, which may be infinite or none (NaN).
    Double(f64),
    /// A text.
    Text(&'a str),
}

/// A column's name, type, unit and meaning.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParquetColumn {
    /// Its name, once in a table.
    pub name: String,
    /// What it holds.
    pub kind: ParquetType,
    /// Whether values may be missing.
    pub optional: bool,
    /// The unit of its values, for example `m/s`.
    pub unit: Option<String>,
    /// What it is, for readers.
    pub meaning: Option<String>,
}

impl ParquetColumn {
    /// A column in which no value is missing, without a unit.
    #[must_use]
    pub fn new(name: impl Into<String>, kind: ParquetType) -> Self {
        Self {
            name: name.into(),
            kind,
            optional: false,
            unit: None,
            meaning: None,
        }
    }

    /// The same column, of which values may be missing.
    #[must_use]
    pub fn optional(mut self) -> Self {
        self.optional = true;
        self
    }

    /// The same column in a unit.
    #[must_use]
    pub fn in_unit(mut self, unit: impl Into<String>) -> Self {
        self.unit = Some(unit.into());
        self
    }

    /// The same column with a meaning.
    #[must_use]
    pub fn meaning(mut self, meaning: impl Into<String>) -> Self {
        self.meaning = Some(meaning.into());
        self
    }

    /// Whether a value fits.
    pub(super) fn takes(&self, cell: &Cell<'_>) -> bool {
        match cell {
            Cell::Missing => self.optional,
            Cell::Bool(_) => self.kind == ParquetType::Bool,
            Cell::U64(_) => self.kind == ParquetType::U64,
            Cell::Double(_) => self.kind == ParquetType::Double,
            Cell::Text(_) => self.kind == ParquetType::Text,
        }
    }
}

/// Level of compression: the default of Zstandard.
const ZSTD_LEVEL: i32 = 3;

/// The values of a column in a row group.
#[derive(Debug, Default)]
pub(super) struct Buffer {
    values: Vec<u8>,
    /// Truth values that were added; eight share a byte.
    bits: usize,
    /// Whether each row has a value, as runs: value and length.
    levels: Vec<(bool, u64)>,
}

/// One data page, ready to be written.
pub(super) struct Page {
    pub(super) header: Vec<u8>,
    pub(super) body: Vec<u8>,
    plain_bytes: usize,
}

impl Page {
    pub(super) fn uncompressed_bytes(&self) -> u64 {
        (self.header.len() + self.plain_bytes) as u64
    }

    pub(super) fn compressed_bytes(&self) -> u64 {
        (self.header.len() + self.body.len()) as u64
    }
}

impl Buffer {
    /// Bytes held.
    pub(super) fn len(&self) -> usize {
        self.values.len() + self.levels.len() * size_of::<(bool, u64)>()
    }

    /// Adds a value that fits the column.
    pub(super) fn push(&mut self, column: &ParquetColumn, cell: &Cell<'_>) {
        if column.optional {
            let present = *cell != Cell::Missing;
            match self.levels.last_mut() {
                Some((level, length)) if *level == present => *length += 1,
                _ => self.levels.push((present, 1)),
            }
        }
        match cell {
            Cell::Missing => {}
            Cell::Bool(value) => {
                if self.bits.is_multiple_of(8) {
                    self.values.push(0);
                }
                let place = self.bits / 8;
                self.values[place] |= u8::from(*value) << (self.bits % 8);
                self.bits += 1;
            }
            Cell::U64(value) => self.values.extend(value.to_le_bytes()),
            Cell::Double(value) => self.values.extend(value.to_le_bytes()),
            Cell::Text(value) => {
                self.values.extend((value.len() as u32).to_le_bytes());
                self.values.extend(value.as_bytes());
            }
        }
    }

    /// The values as a page; the buffer is empty then.
    pub(super) fn page(&mut self, column: &ParquetColumn, rows: u64) -> std::io::Result<Page> {
        let buffer = std::mem::take(self);
        let mut plain = Vec::with_capacity(buffer.len());
        if column.optional {
            let mut runs = Vec::new();
            for (present, length) in buffer.levels {
                varint(&mut runs, length << 1);
                runs.push(u8::from(present));
            }
            plain.extend((runs.len() as u32).to_le_bytes());
            plain.extend(runs);
        }
        plain.extend(buffer.values);
        let body = zstd::bulk::compress(&plain, ZSTD_LEVEL)?;
        Ok(Page {
            header: page_header(rows, plain.len(), body.len()),
            body,
            plain_bytes: plain.len(),
        })
    }
}

/// Numbers that `parquet.thrift` gives to encodings.
pub(super) const PLAIN: i32 = 0;
pub(super) const RUNS: i32 = 3;

fn page_header(rows: u64, plain_bytes: usize, body_bytes: usize) -> Vec<u8> {
    const DATA_PAGE: i32 = 0;
    let data_page = Structure::new()
        .i32(1, rows as i32)
        .i32(2, PLAIN)
        .i32(3, RUNS)
        .i32(4, RUNS);
    Structure::new()
        .i32(1, DATA_PAGE)
        .i32(2, plain_bytes as i32)
        .i32(3, body_bytes as i32)
        .structure(5, data_page)
        .finish()
}
