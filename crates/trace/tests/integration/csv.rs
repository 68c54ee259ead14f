//! CSV tables and traces: what is written comes back, and errors name the right line.

use proptest::prelude::*;
use trace::{
    CsvWriteError, Field, Table, TableError, Trace, read_csv_trace, table_of_trace, trace_of_table,
    write_csv_trace,
};

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
    fn traces_come_back_from_tables(
        arm in prop::collection::vec((0..5_u8, any::<f64>(), 0..3_u8), 0..8),
        state in prop::collection::vec((0..5_u8, 0..3_u8), 0..8),
    ) {
        let mut trace = layout();
        let missing = |flag: u8| if flag == 2 { f64::NAN } else { f64::from(flag) };
        let (mut arm, mut state) = (arm, state);
        arm.sort_by_key(|row| row.0);
        state.sort_by_key(|row| row.0);
        for (time, x, ready) in arm {
            let x = if x.is_finite() { x } else { f64::NAN };
            // Rows without any value are not written.
            if !x.is_nan() || ready < 2 {
                trace.channels[0].push(f64::from(time) * 0.1, &[x, missing(ready)]).expect("it fits");
            }
        }
        for (time, state) in state {
            if state < 2 {
                trace.channels[1].push(f64::from(time) * 0.1, &[missing(state)]).expect("it fits");
            }
        }
        let text = table_of_trace(&trace).expect("it can be written");
        let back = trace_of_table(&Table::parse("t", &text).expect("it is a table"));
        let back = back.expect("it is a trace");
        let bits = |values: &[f64]| values.iter().map(|it| it.to_bits()).collect::<Vec<u64>>();
        for (index, (was, is)) in trace.channels.iter().zip(&back.channels).enumerate() {
            prop_assert_eq!(&was.topic, &is.topic);
            prop_assert_eq!(bits(&was.times_secs), bits(&is.times_secs));
            // Of an enumeration only the names that occur come back.
            let names = |channel: &trace::Channel| -> Vec<Option<String>> {
                let value = |row: usize| channel.row(row)[0];
                let name = |value: f64| match &channel.fields[0].kind {
                    trace::FieldKind::Enumeration(names) => names.get(value as usize).cloned(),
                    _ => None,
                };
                (0..channel.len()).map(|row| name(value(row))).collect()
            };
            if index == 1 {
                prop_assert_eq!(names(was), names(is));
            } else {
                prop_assert_eq!(bits(&was.values), bits(&is.values));
                prop_assert_eq!(&was.fields[0], &is.fields[0]);
            }
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

fn layout() -> Trace {
    let mut trace = Trace::new();
    let arm = vec![Field::number("q[2]", "mm, or \"so\""), Field::bool("ready")];
    trace.add_channel("/arm", arm).expect("it is well-formed");
    let state = vec![Field::enumeration("state", ["open, wide", "closed"])];
    trace
        .add_channel("/state", state)
        .expect("it is well-formed");
    trace
}

#[test]
fn what_would_be_misread_is_not_written() {
    let refused = |topic: &str, field: Field| {
        let mut trace = Trace::new();
        trace
            .add_channel(topic, vec![field])
            .expect("it is well-formed");
        matches!(table_of_trace(&trace), Err(CsvWriteError::Name { .. }))
    };
    assert!(refused("/a.b", Field::number("x", "m")));
    assert!(refused("/a", Field::number("x", "[m]")));
    assert!(refused("/a", Field::number("x ", "")));
    assert!(refused("/a", Field::number("x [3]", "")));
    for name in ["1", "true", "", " open", "nan", "1e3"] {
        assert!(
            refused("/a", Field::enumeration("x", ["open", name])),
            "{name}"
        );
    }
    assert!(!refused("/a", Field::enumeration("x", ["open", "it's"])));
    assert!(!refused("/a", Field::number("x.y[3]", "m/s")));
    let mut broken = layout();
    broken.channels[0].times_secs.push(0.0);
    assert!(matches!(
        table_of_trace(&broken),
        Err(CsvWriteError::Trace(_))
    ));

    let folder = tempfile::tempdir().unwrap();
    let error = write_csv_trace(&folder.path().join("no/such/run.csv"), &layout()).unwrap_err();
    assert!(
        error.to_string().contains("create the folder first"),
        "{error}"
    );
    let path = folder.path().join("run.csv");
    let mut trace = layout();
    trace.channels[0].push(0.5, &[1.5, 1.0]).unwrap();
    trace.channels[1].push(0.5, &[0.0]).unwrap();
    write_csv_trace(&path, &trace).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.ends_with("0.5,1.5,true,\"open, wide\"\n"), "{text}");
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
