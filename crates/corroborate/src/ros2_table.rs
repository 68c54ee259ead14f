//! `ros2.toml`, the table that says which signals of a simulation go into which
//! fields of which ROS 2 messages. It lies beside the scenario.
//!
//! ```toml
//! [[topic]]
//! name = "/robot/hand_point"                # the topic that is written
//! type = "geometry_msgs/msg/PointStamped"
//! rows_of = "/robot"                        # each row of this topic becomes one message
//! fields = { "header.stamp" = "time", "point.x" = "/robot.hand.x", "header.frame_id" = { text = "world" } }
//! ```
//!
//! A field is given a signal (`/topic.field`; of another topic, its value is
//! held), `"time"` (of the row), a number, a truth value, or `{ text = "…" }`.

use diagnostic::{Problem, Source};
use host::Reach;
use host::files::write_whole;
use recording::{Ros2Source, Ros2Topic, Ros2TraceOptions, ros2_recording_of};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;
use trace::Trace;

/// The file's name, beside the scenario.
const FILE: &str = "ros2.toml";

/// The table, read.
#[derive(Debug)]
pub struct Ros2Table {
    /// What is written, in the order of the file.
    pub topics: Vec<Ros2Topic>,
    /// The file's text, on which the recordings depend.
    pub text: String,
    name: String,
}

/// Which signals of a simulation go into which messages of ROS 2.
#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
struct TableText {
    /// The topics.
    topic: Vec<TopicText>,
}

/// A topic and its messages.
#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
struct TopicText {
    /// Its name.
    name: String,
    /// The type of its messages, for example `std_msgs/msg/Bool`.
    #[serde(rename = "type")]
    type_name: String,
    /// The simulation's topic of whose rows each becomes a message.
    rows_of: String,
    /// What goes into each field: the name of a signal, or a value.
    #[schemars(with = "BTreeMap<String, schemars::Schema>")]
    fields: BTreeMap<String, Spanned<toml::Value>>,
}

/// The JSON Schema of the table.
pub fn schema() -> schemars::Schema {
    schemars::schema_for!(TableText)
}

impl Ros2Table {
    /// Reads the table that lies beside `scenario`.
    pub fn beside(scenario: &Path, reach: &Reach) -> Result<Self, Problem> {
        let path = scenario.with_file_name(FILE);
        reach.check(&path)?;
        if !path.exists() {
            return Err(
                Problem::new("no-ros2-table", format!("there is no {}", path.display())).remedy(
                    "say there which signals go into which ROS 2 messages, or leave out --as",
                ),
            );
        }
        let source = host::files::read_source(&path)?;
        let table: TableText = toml::from_str(&source.text)
            .map_err(|error| study::placed::from_toml(&source, &error))?;
        let topics: Result<Vec<Ros2Topic>, Problem> = table
            .topic
            .into_iter()
            .map(|topic| topic_of(topic, &source))
            .collect();
        Ok(Self {
            topics: topics?,
            name: source.name.clone(),
            text: source.text,
        })
    }

    /// Writes `trace` to `path` and answers how many messages were left out
    /// because a value was missing that cannot be written as missing.
    pub fn write(&self, trace: &Trace, path: &Path) -> Result<u64, Problem> {
        let written = ros2_recording_of(trace, &self.topics, &Ros2TraceOptions::default())
            .map_err(|error| bad(format!("{}: {error}", self.name)))?;
        write_whole(path, &written.bytes)?;
        Ok(written.left_out)
    }
}

/// A table that does not fit the simulation or the types of ROS 2.
pub fn bad(message: String) -> Problem {
    Problem::new("bad-ros2-table", message)
        .remedy("compare the table with the recordings that are made without --as")
}

fn topic_of(text: TopicText, source: &Source) -> Result<Ros2Topic, Problem> {
    let mut fields = Vec::with_capacity(text.fields.len());
    for (path, value) in text.fields {
        let span = value.span();
        let found = source_of(value.into_inner()).ok_or_else(|| {
            bad(format!("`{path}` is given nothing that can be written")).at(source, span)
        })?;
        fields.push((path, found));
    }
    Ok(Ros2Topic {
        name: text.name,
        type_name: text.type_name,
        rows_of: text.rows_of,
        fields,
    })
}

/// What a field is given; `None` if that is none of the forms.
fn source_of(value: toml::Value) -> Option<Ros2Source> {
    match value {
        toml::Value::String(text) if text == "time" => Some(Ros2Source::Stamp),
        toml::Value::String(text) if text.starts_with('/') => Some(Ros2Source::Signal(text)),
        toml::Value::Float(number) => Some(Ros2Source::Number(number)),
        toml::Value::Integer(number) => {
            let exact = i32::try_from(number).ok()?;
            Some(Ros2Source::Number(f64::from(exact)))
        }
        toml::Value::Boolean(value) => Some(Ros2Source::Bool(value)),
        toml::Value::Table(table) if table.len() == 1 => {
            let text = table.get("text")?.as_str()?;
            Some(Ros2Source::Text(text.to_owned()))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reach(folder: &tempfile::TempDir) -> Reach {
        Reach::of(folder.path(), &host::Trust::default())
    }
    use trace::Field;

    fn table(text: &str) -> (tempfile::TempDir, Result<Ros2Table, Problem>) {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join(FILE), text).expect("written");
        let table = Ros2Table::beside(&folder.path().join("scenario.toml"), &reach(&folder));
        (folder, table)
    }

    fn topic(fields: &str) -> String {
        format!(
            "[[topic]]\nname = \"/speed\"\ntype = \"std_msgs/msg/Float64\"\nrows_of = \"/robot\"\nfields = {fields}\n"
        )
    }

    #[test]
    fn what_is_written_is_read_back() {
        let (folder, table) = table(&topic("{ data = \"/robot.speed\" }"));
        let mut trace = Trace::new();
        let robot = trace.add_channel("/robot", vec![Field::number("speed", "m/s")]);
        let channel = robot.expect("a channel");
        trace.channels[channel].push(0.5, &[0.25]).expect("a row");
        let path = folder.path().join("one.mcap");
        let left_out = table.expect("a table").write(&trace, &path);
        assert_eq!(left_out.expect("written"), 0);
        let mut reader = recording::open(&path, &recording::OpenOptions::default()).expect("open");
        let message = reader.next().expect("read").expect("a message");
        assert_eq!(message.log_nanos, 500_000_000);
        assert_eq!(message.data[4..], 0.25_f64.to_le_bytes());
    }

    /// A missing number stays missing; a truth value cannot, so its message is left out and counted.
    #[test]
    fn what_is_missing_is_written_as_missing_or_counted() {
        let text = topic("{ data = \"/robot.speed\" }")
            + &topic("{ data = \"/robot.ready\" }")
                .replace("Float64", "Bool")
                .replace("\"/speed\"", "\"/ready\"");
        let (folder, table) = table(&text);
        let mut trace = Trace::new();
        let fields = vec![Field::number("speed", "m/s"), Field::bool("ready")];
        let channel = trace.add_channel("/robot", fields).expect("a channel");
        let row = [f64::NAN, f64::NAN];
        trace.channels[channel].push(0.5, &row).expect("a row");
        let path = folder.path().join("one.mcap");
        let left_out = table.expect("a table").write(&trace, &path);
        assert_eq!(left_out.expect("written"), 1);
        let mut reader = recording::open(&path, &recording::OpenOptions::default()).expect("open");
        let message = reader.next().expect("read").expect("a message");
        let bytes = message.data[4..].try_into().expect("eight bytes");
        assert!(f64::from_le_bytes(bytes).is_nan());
        assert!(reader.next().expect("read").is_none());
    }

    #[test]
    fn what_cannot_be_written_is_refused_at_its_place() {
        for fields in [
            "{ data = \"speed\" }",
            "{ data = [1] }",
            "{ data = { txt = \"a\" } }",
        ] {
            let (_folder, table) = table(&topic(fields));
            assert_eq!(
                table.expect_err("refused").code,
                "bad-ros2-table",
                "{fields}"
            );
        }
        let (folder, table) = table(&topic("{ data = \"/robot.sped\" }"));
        let mut trace = Trace::new();
        let added = trace.add_channel("/robot", vec![Field::number("speed", "m/s")]);
        added.expect("a channel");
        let written = table
            .expect("a table")
            .write(&trace, &folder.path().join("one.mcap"));
        let problem = written.expect_err("no such signal");
        assert!(problem.to_string().contains("/robot.sped"), "{problem}");
    }

    #[test]
    fn a_study_without_a_table_is_told_so() {
        let folder = tempfile::tempdir().expect("a folder");
        let none = Ros2Table::beside(&folder.path().join("scenario.toml"), &reach(&folder));
        assert_eq!(none.expect_err("refused").code, "no-ros2-table");
    }
}
