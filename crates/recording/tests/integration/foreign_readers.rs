//! What is written here, read by libraries that are not ours.
//!
//! Needs Python with what `python/requirements.txt` names (`pip install --requirement` it), and the
//! interpreter's path in `CORROBORATE_PYTHON`. Then `cargo test -p corroborate-recording --test integration -- foreign_readers --ignored`.

use std::path::Path;
use std::process::Command;

use recording::{
    Cell, ParquetColumn, ParquetType, ParquetWriter, Ros2Recording, Ros2Source, Ros2Topic,
    Ros2TraceOptions, Ros2Value, ShownVerdict, VerdictFile, ros2_recording_of, ros2_type_names,
};
use trace::{Field, Trace};

pub(crate) type Checked = Result<(), Box<dyn std::error::Error>>;

/// Runs a script of `tests/python` on a file and gives what it prints.
fn python(script: &str, file: &Path) -> Result<String, Box<dyn std::error::Error>> {
    python_script(script, file, &[])
}

/// The same with arguments behind the file.
pub(crate) fn python_script(
    script: &str,
    file: &Path,
    arguments: &[&str],
) -> Result<String, Box<dyn std::error::Error>> {
    let interpreter = std::env::var("CORROBORATE_PYTHON").unwrap_or("python3".to_owned());
    let script = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/python")
        .join(script);
    let output = Command::new(interpreter)
        .arg(script)
        .arg(file)
        .args(arguments)
        .output()?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into());
    }
    Ok(String::from_utf8(output.stdout)?)
}

/// `mcap-ros2-support` reads each message with the schema in the file, `rosbags` with its own
/// definition of the type; `rosbags` also writes it again, which must give the same bytes.
#[test]
#[ignore = "needs Python with mcap-ros2-support and rosbags"]
fn every_type_is_read_and_written_again_by_others() -> Checked {
    let mut recording = Ros2Recording::new()?;
    let mut topics = Vec::new();
    for (index, name) in ros2_type_names().enumerate() {
        topics.push(recording.add_topic(&format!("/topic_{index}"), &name)?);
    }
    let filled = recording.add_topic("/filled", "sensor_msgs/msg/JointState")?;
    let frames = recording.add_topic("/tf", "tf2_msgs/msg/TFMessage")?;
    for step in 0..10_i64 {
        let nanos = 1_700_000_000_000_000_000 + step * 10_000_001;
        for topic in &topics {
            recording.write(*topic, nanos, &[])?;
        }
        recording.write(
            filled,
            nanos,
            &[
                ("header.stamp", Ros2Value::Nanos(nanos)),
                ("header.frame_id", Ros2Value::Text("base")),
                ("name[1]", Ros2Value::Text("elbow")),
                ("position[0]", Ros2Value::Number(0.1 * step as f64)),
                ("effort[2]", Ros2Value::Number(-3.5)),
            ],
        )?;
        recording.write(
            frames,
            nanos,
            &[
                ("transforms[0].child_frame_id", Ros2Value::Text("hand")),
                ("transforms[1].transform.rotation.w", Ros2Value::Number(1.0)),
            ],
        )?;
    }
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("all.mcap");
    std::fs::write(&path, recording.finish()?)?;
    let count = 10 * (topics.len() + 2);
    let printed = python("read_ros2.py", &path)?;
    assert!(
        printed.contains(&format!("{count} messages are the same")),
        "{printed}"
    );
    let joint = "/filled sec=1700000000 nanosec=10000001 frame_id=base name=['', 'elbow'] \
                 position=[0.1] effort=[0.0, 0.0, -3.5]";
    assert!(printed.contains(joint), "{printed}");
    Ok(())
}

/// A trace by a table of topics, as others read it.
#[test]
#[ignore = "needs Python with mcap-ros2-support and rosbags"]
fn a_trace_by_a_table_is_read_by_others() -> Checked {
    let mut trace = Trace::new();
    let robot = trace.add_channel(
        "/robot",
        vec![
            Field::number("wrist", "rad"),
            Field::enumeration("state", ["idle", "serve"]),
        ],
    )?;
    trace.channels[robot].push(0.0, &[0.25, 0.0])?;
    trace.channels[robot].push(0.5, &[f64::NAN, 1.0])?;
    let topic = |name: &str, type_name: &str, fields: &[(&str, Ros2Source)]| Ros2Topic {
        name: name.to_owned(),
        type_name: type_name.to_owned(),
        rows_of: "/robot".to_owned(),
        fields: fields
            .iter()
            .map(|(path, source)| ((*path).to_owned(), source.clone()))
            .collect(),
    };
    let signal = |name: &str| Ros2Source::Signal(name.to_owned());
    let topics = [
        topic(
            "/filled",
            "sensor_msgs/msg/JointState",
            &[
                ("header.stamp", Ros2Source::Stamp),
                ("header.frame_id", Ros2Source::Text("base".to_owned())),
                ("name[0]", Ros2Source::Text("wrist".to_owned())),
                ("position[0]", signal("/robot.wrist")),
            ],
        ),
        topic(
            "/state",
            "std_msgs/msg/String",
            &[("data", signal("/robot.state"))],
        ),
    ];
    let options = Ros2TraceOptions {
        start_nanos: 1_700_000_000_000_000_000,
    };
    let outcome = ros2_recording_of(&trace, &topics, &options)?;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("trace.mcap");
    std::fs::write(&path, &outcome.bytes)?;
    let printed = python("read_ros2.py", &path)?;
    assert!(printed.contains("4 messages are the same"), "{printed}");
    for line in [
        "/filled sec=1700000000 nanosec=0 frame_id=base name=['wrist'] position=[0.25] effort=[]",
        "/filled sec=1700000000 nanosec=500000000 frame_id=base name=['wrist'] position=[nan] effort=[]",
        "/state serve",
    ] {
        assert!(printed.contains(line), "{line} is not in {printed}");
    }
    Ok(())
}

/// Rerun takes log entries for text with a level, and keeps the numbers.
#[test]
#[ignore = "needs Python with rerun-sdk"]
fn verdicts_are_shown_by_rerun() -> Checked {
    let mut file = VerdictFile::new()?;
    let slow = file.add_requirement("R1.slow", "The hand is slow.")?;
    let start = 1_700_000_000_000_000_000;
    for step in 0..100_i64 {
        file.robustness(slow, start + step * 10_000_000, 0.5 - step as f64 * 0.01)?;
    }
    file.verdict(
        slow,
        start + 510_000_000,
        ShownVerdict::Violated,
        "/robot.hand_speed is 0.26 m/s",
    )?;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("verdicts.mcap");
    std::fs::write(&path, file.finish()?)?;
    let printed = python("read_rerun.py", &path)?;
    for line in [
        "with 100 rows",
        "/corroborate/R1_slow/robustness - data columns: [std_msgs.msg.Float64:message]",
        "TextLog:level",
        "TextDocument:text",
    ] {
        assert!(printed.contains(line), "{line} is not in {printed}");
    }
    Ok(())
}

/// pyarrow, pandas, polars and DuckDB read each type, missing values and several row groups.
#[test]
#[ignore = "needs Python with pyarrow, pandas, polars and duckdb"]
fn tables_in_parquet_are_read_by_others() -> Checked {
    let folder = tempfile::tempdir()?;
    for (name, rows) in [("empty", 0), ("small", 3), ("large", 150_000)] {
        let path = folder.path().join(format!("{name}.parquet"));
        write_parquet(&path, rows)?;
    }
    let said = python("read_parquet.py", folder.path())?;
    assert_eq!(said.lines().count(), 12, "{said}");
    Ok(())
}

/// The table whose values `read_parquet.py` computes again.
fn write_parquet(path: &Path, rows: u64) -> Checked {
    let columns = vec![
        ParquetColumn::new("number", ParquetType::U64).meaning("the row's number, from 0"),
        ParquetColumn::new("seed", ParquetType::U64),
        ParquetColumn::new("even", ParquetType::Bool),
        ParquetColumn::new("maybe", ParquetType::Bool).optional(),
        ParquetColumn::new("third", ParquetType::Double).in_unit("m/s"),
        ParquetColumn::new("gaps", ParquetType::Double).optional(),
        ParquetColumn::new("name", ParquetType::Text),
        ParquetColumn::new("never", ParquetType::Text).optional(),
    ];
    let file = std::io::BufWriter::new(std::fs::File::create(path)?);
    let mut table = ParquetWriter::new(file, columns, &[("study", "a \"test\"")])?;
    for number in 0..rows {
        let text = format!("näme {}", number % 7);
        let maybe = match number % 3 {
            0 => Cell::Missing,
            rest => Cell::Bool(rest == 1),
        };
        let gaps = match number {
            0 => Cell::Double(f64::NEG_INFINITY),
            _ if number % 5 == 4 => Cell::Missing,
            _ => Cell::Double(-(number as f64)),
        };
        table.push(&[
            Cell::U64(number),
            Cell::U64(u64::MAX - number),
            Cell::Bool(number % 2 == 0),
            maybe,
            Cell::Double(number as f64 / 3.0),
            gaps,
            Cell::Text(&text),
            Cell::Missing,
        ])?;
    }
    table.finish()?;
    Ok(())
}
