//! Tables in Parquet that others wrote, and damaged ones.

use crate::foreign_readers::{Checked, python_script};
use recording::{Cell, ParquetColumn, ParquetRows, ParquetTable, ParquetType, ParquetWriter};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Tables that are compared.
const TABLES: usize = 300;

fn files() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/parquet")
}

/// What is read of a column, as the scripts say it.
fn said(rows: &ParquetRows, kind: &str) -> Value {
    match kind {
        "bool" => json!(rows.bools().expect("truth values")),
        "int" => json!(rows.ints().expect("whole numbers")),
        "double" => json!(rows.doubles().expect("numbers")),
        "texts" => json!(rows.texts().expect("texts")),
        _ => json!(rows.numbers().expect("numbers")),
    }
}

/// Holds a table against what its writer says of it; gives the number of values that were compared, or the form that is not
/// read.
fn compared(path: &Path) -> Result<usize, String> {
    let bytes = std::fs::read(path).expect("bytes");
    let about = std::fs::read_to_string(path.with_extension("json")).expect("what is in it");
    let about: Value = serde_json::from_str(&about).expect("JSON");
    let table = ParquetTable::open(&bytes).unwrap_or_else(|error| panic!("{path:?}: {error}"));
    assert_eq!(json!(table.rows()), about["rows"]);
    let mut count = 0;
    for (name, column) in about["columns"].as_object().expect("columns") {
        let kind = column["kind"].as_str().expect("a kind");
        let rows = match table.column(name) {
            Ok(rows) => rows,
            Err(error) if error.is_unread_form => return Err(error.to_string()),
            Err(error) => panic!("{path:?}: {error}"),
        };
        assert_eq!(rows.len(), table.rows());
        assert!(
            said(&rows, kind) == column["values"],
            "{path:?}, {name} of {}",
            about["by"]
        );
        count += rows.len();
    }
    Ok(count)
}

#[test]
fn tables_that_pyarrow_wrote_hold_what_it_says() {
    let mut tables = 0;
    for entry in std::fs::read_dir(files()).expect("files") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|it| it == "parquet") {
            compared(&path).expect("read");
            tables += 1;
        }
    }
    assert!(tables >= 4, "{tables}");
}

/// pyarrow, pandas, polars and DuckDB with drawn types, values, pages, dictionaries, compressions.
#[test]
#[ignore = "needs Python with pyarrow, pandas, polars and duckdb"]
fn random_tables_of_others_are_read() -> Checked {
    let folder = tempfile::tempdir()?;
    python_script(
        "write_parquet.py",
        folder.path(),
        &[&TABLES.to_string(), "1"],
    )?;
    let mut values = 0;
    let mut unread = Vec::new();
    for number in 0..TABLES {
        match compared(&folder.path().join(format!("{number}.parquet"))) {
            Ok(count) => values += count,
            Err(form) => unread.push(form),
        }
    }
    println!(
        "{values} values, {} tables are not read: {unread:#?}",
        unread.len()
    );
    assert!(values > 1_000_000, "{values}");
    assert_eq!(unread.len(), 0);
    Ok(())
}

/// A small table of ours.
fn written() -> Vec<u8> {
    let columns = vec![
        ParquetColumn::new("won", ParquetType::Bool).optional(),
        ParquetColumn::new("name", ParquetType::Text),
        ParquetColumn::new("speed", ParquetType::Double),
    ];
    let mut table = ParquetWriter::new(Vec::new(), columns, &[]).expect("columns");
    for row in 0..50_u64 {
        let won = match row % 3 {
            0 => Cell::Missing,
            one => Cell::Bool(one == 1),
        };
        table
            .push(&[won, Cell::Text("hand"), Cell::Double(row as f64)])
            .expect("a row");
    }
    table.finish().expect("written")
}

#[test]
fn what_is_written_here_is_read() {
    let bytes = written();
    let table = ParquetTable::open(&bytes).expect("a table");
    assert_eq!(table.names(), ["won", "name", "speed"]);
    let won = table.column("won").expect("read");
    let expected: Vec<Option<bool>> = (0..50)
        .map(|it| (it % 3 != 0).then_some(it % 3 == 1))
        .collect();
    assert_eq!(won.bools(), Some(expected));
    let speeds = table.column("speed").expect("read");
    assert_eq!(speeds.doubles().expect("numbers")[49], Some(49.0));
    assert_eq!(speeds.bools(), None);
    let error = table.column("wom").expect_err("no such column");
    assert_eq!(error.to_string(), "there is no column `wom`");
}

#[test]
fn what_cannot_be_read_says_what_and_where() {
    let whole = written();
    let error = |bytes: &[u8]| ParquetTable::open(bytes).expect_err("an error").to_string();
    assert!(error(b"").contains("not a table in Parquet"));
    assert!(
        error(b"version https://git-lfs.github.com/spec/v1\n").contains("not a table in Parquet")
    );
    assert!(error(&whole[..whole.len() - 1]).contains("not written to its end"));
    let mut length = whole.clone();
    let at = length.len() - 5;
    length[at] = 0x7F;
    assert!(
        error(&length).contains("the footer should have"),
        "{}",
        error(&length)
    );
    // The first page's body is the first column's.
    let mut page = whole.clone();
    page[30..60].fill(0xFF);
    let said = ParquetTable::open(&page)
        .expect("its footer is whole")
        .column("won");
    let said = said.expect_err("damaged").to_string();
    assert!(said.starts_with("column `won`, byte 4: "), "{said}");
}

/// No byte of a file, changed, makes it panic; of those that pyarrow wrote, too.
#[test]
fn every_changed_byte_is_an_error_or_another_table() {
    let mut tables = vec![written()];
    for entry in std::fs::read_dir(files()).expect("files") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|it| it == "parquet") {
            tables.push(std::fs::read(path).expect("bytes"));
        }
    }
    let (mut errors, mut read) = (0, 0);
    for whole in tables {
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= [0xFF, 0x80, 0x01][at % 3];
            let Ok(table) = ParquetTable::open(&bytes) else {
                errors += 1;
                continue;
            };
            for name in table.names() {
                let Ok(rows) = table.column(name) else {
                    errors += 1;
                    continue;
                };
                assert_eq!(rows.len(), table.rows());
                let _ = (rows.texts(), rows.numbers());
                read += 1;
            }
        }
    }
    assert!(errors > 1000 && read > 1000, "{errors} {read}");
}
