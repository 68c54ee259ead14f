//! The footer: the columns, where their chunks are, and texts about the table.

use super::column::{PLAIN, ParquetColumn, ParquetType, RUNS};
use super::thrift::Structure;

/// A row group.
#[derive(Debug)]
pub(super) struct Group {
    pub(super) rows: u64,
    pub(super) chunks: Vec<Chunk>,
}

/// A column's part of a row group; bytes include the page's header.
#[derive(Debug)]
pub(super) struct Chunk {
    pub(super) offset: u64,
    pub(super) uncompressed_bytes: u64,
    pub(super) compressed_bytes: u64,
}

/// Numbers that `parquet.thrift` gives to types, repetitions and codecs.
const BOOLEAN: i32 = 0;
const INT64: i32 = 2;
const DOUBLE: i32 = 5;
const BYTE_ARRAY: i32 = 6;
const REQUIRED: i32 = 0;
const OPTIONAL: i32 = 1;
const CONVERTED_UTF8: i32 = 0;
const CONVERTED_UINT_64: i32 = 14;
const ZSTD: i32 = 6;
const FORMAT_VERSION: i32 = 2;

pub(super) fn footer(
    columns: &[ParquetColumn],
    groups: &[Group],
    metadata: &[(String, String)],
) -> Vec<u8> {
    let root = Structure::new()
        .text(4, "schema")
        .i32(5, columns.len() as i32);
    let mut schema = vec![root];
    schema.extend(columns.iter().map(element));
    let groups_of_file = groups.iter().map(|group| row_group(columns, group));
    let texts = metadata.iter().map(|(key, value)| key_value(key, value));
    Structure::new()
        .i32(1, FORMAT_VERSION)
        .structures(2, schema)
        .i64(3, groups.iter().map(|group| group.rows).sum())
        .structures(4, groups_of_file.collect())
        .structures(5, texts.collect())
        .text(
            6,
            concat!("corroborate version ", env!("CARGO_PKG_VERSION")),
        )
        .finish()
}

fn element(column: &ParquetColumn) -> Structure {
    let repetition = if column.optional { OPTIONAL } else { REQUIRED };
    let element = Structure::new()
        .i32(1, physical(column))
        .i32(3, repetition)
        .text(4, &column.name);
    match column.kind {
        ParquetType::Text => {
            let string = Structure::new().structure(1, Structure::new());
            element.i32(6, CONVERTED_UTF8).structure(10, string)
        }
        ParquetType::U64 => {
            let unsigned = Structure::new().i8(1, 64).bool(2, false);
            let integer = Structure::new().structure(10, unsigned);
            element.i32(6, CONVERTED_UINT_64).structure(10, integer)
        }
        ParquetType::Bool | ParquetType::Double => element,
    }
}

fn physical(column: &ParquetColumn) -> i32 {
    match column.kind {
        ParquetType::Bool => BOOLEAN,
        ParquetType::U64 => INT64,
        ParquetType::Double => DOUBLE,
        ParquetType::Text => BYTE_ARRAY,
    }
}

fn row_group(columns: &[ParquetColumn], group: &Group) -> Structure {
    let chunks = columns.iter().zip(&group.chunks);
    let chunks = chunks.map(|(column, chunk)| {
        Structure::new()
            .i64(2, chunk.offset)
            .structure(3, chunk_metadata(column, chunk, group.rows))
    });
    let bytes = group.chunks.iter().map(|chunk| chunk.uncompressed_bytes);
    Structure::new()
        .structures(1, chunks.collect())
        .i64(2, bytes.sum())
        .i64(3, group.rows)
}

fn chunk_metadata(column: &ParquetColumn, chunk: &Chunk, rows: u64) -> Structure {
    let told = [("unit", &column.unit), ("meaning", &column.meaning)];
    let told: Vec<Structure> = told
        .iter()
        .filter_map(|(key, value)| Some(key_value(key, value.as_ref()?)))
        .collect();
    let metadata = Structure::new()
        .i32(1, physical(column))
        .i32s(2, &[PLAIN, RUNS])
        .texts(3, &[&column.name])
        .i32(4, ZSTD)
        .i64(5, rows)
        .i64(6, chunk.uncompressed_bytes)
        .i64(7, chunk.compressed_bytes);
    let metadata = match told.is_empty() {
        true => metadata,
        false => metadata.structures(8, told),
    };
    metadata.i64(9, chunk.offset)
}

fn key_value(key: &str, value: &str) -> Structure {
    Structure::new().text(1, key).text(2, value)
}

/// Units and meanings by column, as JSON.
pub(super) fn columns_json(columns: &[ParquetColumn]) -> String {
    let told = columns.iter().map(|column| {
        let mut about = serde_json::Map::new();
        for (key, value) in [("unit", &column.unit), ("meaning", &column.meaning)] {
            if let Some(value) = value {
                about.insert(key.into(), value.as_str().into());
            }
        }
        (column.name.clone(), about.into())
    });
    serde_json::Value::Object(told.collect()).to_string()
}
