//! CSV tables and traces: what is written comes back, and errors name the right line.

use proptest::prelude::*;
use trace::{Table, TableError, read_csv_trace, trace_of_table};

/// A row of a table with what stands above it in the file.
#[derive(Debug, Clone)]
struct Row {
    above: Vec<String>,
    cells: Vec<String>,
}

fn row(width: usize) -> impl Strategy<Value = Row> {
    let above = prop::collection::vec(prop_oneof![Just(String::new()), "#[a-z\", ]{0,5}"], 0..3);
    let cells = prop::collection::vec("([a-z\",é][a-z\", \n#é]{0,4}[a-z\",é])?", width);
    (above, cells).prop_map(|(above, cells)| Row { above, cells })
}

/// The file, and the line at which each row begins.
fn text(rows: &[Row], end: &str) -> (String, Vec<usize>) {
    let mut text = format!("first,second,third{end}");
    let mut lines = Vec::new();
    for row in rows {
        for line in &row.above {
            text += &format!("{line}{end}");
        }
        lines.push(text.matches('\n').count() + 1);
        let cells = row
            .cells
            .iter()
            .map(|cell| format!("\"{}\"", cell.replace('"', "\"\"")));
        text += &format!("{}{end}", cells.collect::<Vec<_>>().join(","));
    }
    (text, lines)
}

proptest! {
    #[test]
    fn cells_and_lines_come_back(
        rows in prop::collection::vec(row(3), 0..6), crlf in any::<bool>(), bad in any::<prop::sample::Index>(),
    ) {
        let end = if crlf { "\r\n" } else { "\n" };
        let (written, _) = text(&rows, end);
        let table = Table::parse("t", &written).expect("it is a table");
        for (index, header) in ["first", "second", "third"].into_iter().enumerate() {
            let cells: Vec<&str> = rows.iter().map(|row| row.cells[index].as_str()).collect();
            prop_assert_eq!(table.column(header).expect("it is there").as_texts(), cells);
        }
        if !rows.is_empty() {
            // One row with other cells in numbers: it is the one that is named.
            let wrong = bad.index(rows.len());
            let mut rows = rows;
            for (index, row) in rows.iter_mut().enumerate() {
                row.cells[1] = if index == wrong { "x".to_owned() } else { "1".to_owned() };
            }
            let (written, lines) = text(&rows, end);
            let table = Table::parse("t", &written).expect("it is a table");
            let error = table.column("second").expect("it is there").as_integers();
            let Err(TableError::BadCell { line, text, .. }) = error else {
                return Err(TestCaseError::fail("a cell is wrong"));
            };
            prop_assert_eq!((line, text.as_str()), (lines[wrong] as u64, "x"));
        }
    }

    #[test]
    fn numbers_of_traces_come_back_bit_for_bit(
        rows in prop::collection::btree_map(0..1000_i32, (any::<f64>(), any::<f64>()), 0..10),
    ) {
        let cell = |value: f64| if value.is_finite() { format!("{value:?}") } else { String::new() };
        let mut text = "time_secs,/a.x [m],/b.y\n".to_owned();
        for (time, (x, y)) in &rows {
            text += &format!("{},{},{}\n", f64::from(*time) * 0.1, cell(*x), cell(*y));
        }
        let trace = trace_of_table(&Table::parse("t", &text).expect("it is a table"));
        let trace = trace.expect("it is a trace");
        for (index, pick) in [|row: &(f64, f64)| row.0, |row: &(f64, f64)| row.1].iter().enumerate() {
            let kept = rows.iter().filter(|(_, row)| pick(row).is_finite());
            let expected: Vec<(u64, u64)> = kept
                .map(|(time, row)| ((f64::from(*time) * 0.1).to_bits(), pick(row).to_bits()))
                .collect();
            let channel = &trace.channels[index];
            let found = channel.times_secs.iter().zip(&channel.values);
            let found: Vec<(u64, u64)> =
                found.map(|(time, value)| (time.to_bits(), value.to_bits())).collect();
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn any_text_is_read_without_panic(text in "[a-c/.#\", \r\n0-9\\[\\]é]{0,60}") {
        for text in [text.clone(), format!("time_secs,/a.x\n{text}")] {
            if let Ok(table) = Table::parse("t", &text) {
                let _ = trace_of_table(&table);
            }
        }
    }
}

#[test]
fn files_that_cannot_be_read_say_why() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    let error = read_csv_trace(&path).unwrap_err().to_string();
    assert!(
        error.contains("run.csv") && error.contains("check the path"),
        "{error}"
    );
    std::fs::write(&path, b"time_secs,/a.x\n0,\xff\n").unwrap();
    let error = Table::read(&path).unwrap_err().to_string();
    assert!(error.contains("save it as UTF-8 text"), "{error}");
    std::fs::write(&path, "time_secs,/a.x\n0,1\n").unwrap();
    assert_eq!(read_csv_trace(&path).unwrap().channels[0].values, [1.0]);
}
