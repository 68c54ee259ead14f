//! The executions that recordings show: of Nav2's topic of changes of status, or of a table with a row for each execution.

use super::comment;
use behaviour_tree::{Event, Executions, Status};
use diagnostic::{Problem, counted};
use recording::{Extractor, FieldPath, OpenOptions, TopicInfo, Value};
use std::collections::BTreeMap;
use std::path::Path;
use trace::Table;

/// The type of the messages, without the package's part that differs between versions of ROS.
const TYPE: &str = "BehaviorTreeLog";
/// The topic, whatever namespace it is in, where messages have no type.
const TOPIC: &str = "behavior_tree_log";
/// Changes of status in one message, at most.
const MOST_EVENTS: usize = 100_000;

/// The executions by run.
pub(super) struct Runs {
    /// Where they are from.
    pub of: String,
    /// The names of the runs: of the recordings, or as the table has them.
    pub names: Vec<String>,
    pub executions: Vec<Executions>,
    /// What whoever reads the counts has to know.
    pub notes: Vec<String>,
}

/// The executions in a recording, in those of a folder, or in a table.
///
/// # Errors
/// `bad-recording` of what cannot be read, `no-executions` if there are none.
pub(super) fn of(path: &Path) -> Result<Runs, Problem> {
    let trials = recording::trials(path)
        .map_err(|error| Problem::new("bad-recording", error.to_string()))?;
    let mut runs = Runs {
        of: path.display().to_string(),
        names: Vec::new(),
        executions: Vec::new(),
        notes: Vec::new(),
    };
    let mut empty = 0;
    for trial in &trials.trials {
        let found = match table(&trial.path)? {
            Some(table) => of_table(&table, &trial.name)?,
            None => BTreeMap::from([(
                trial.name.clone(),
                of_recording(&trial.path, &mut runs.notes)?,
            )]),
        };
        for (name, executions) in found {
            match executions.is_empty() {
                true => empty += 1,
                false => {
                    runs.names.push(name);
                    runs.executions.push(executions);
                }
            }
        }
    }
    if runs.names.is_empty() {
        let message = format!(
            "no recording in {} has changes of status of a behaviour tree",
            comment(&runs.of)
        );
        return Err(Problem::new("no-executions", message).remedy(
            "record the topic /behavior_tree_log, or name a CSV with the columns node and status",
        ));
    }
    if empty > 0 {
        let many = counted(empty, "recording");
        runs.notes
            .push(format!("{many} without executions left out"));
    }
    Ok(runs)
}

/// The table at a path, if it is one with the columns `node` and `status`.
fn table(path: &Path) -> Result<Option<Table>, Problem> {
    let is_csv = path
        .extension()
        .is_some_and(|ending| ending == "csv" || ending == "tsv");
    if !is_csv {
        return Ok(None);
    }
    let Ok(table) = Table::read(path) else {
        return Ok(None);
    };
    let has = |name: &str| table.headers().iter().any(|header| header == name);
    Ok((has("node") && has("status")).then_some(table))
}

/// A row is an execution that ended with this status; the column `run`, if there is one, says in which run.
fn of_table(table: &Table, name: &str) -> Result<BTreeMap<String, Executions>, Problem> {
    let bad = |error: trace::TableError| {
        let remedy = error.remedy().unwrap_or("correct the table".to_owned());
        Problem::new("bad-recording", error.to_string()).remedy(remedy)
    };
    let nodes = table.column("node").map_err(bad)?.as_texts();
    let statuses = table.column("status").map_err(bad)?.as_texts();
    let runs = table.column("run").ok().map(|column| column.as_texts());
    let mut found: BTreeMap<String, Executions> = BTreeMap::new();
    for (row, (node, status)) in nodes.iter().zip(&statuses).enumerate() {
        let Some(current) = Status::parse(status) else {
            let line = table.line(row).unwrap_or(0);
            let message = format!(
                "{}, line {line}: status is `{}`, not SUCCESS or FAILURE",
                comment(table.name()),
                comment(status)
            );
            return Err(Problem::new("bad-recording", message)
                .remedy("write SUCCESS or FAILURE; IDLE for an execution that was halted"));
        };
        let run = runs.as_ref().map_or(name, |runs| runs[row]);
        let of_run = found.entry(run.to_owned());
        of_run.or_insert_with(Executions::by_label).add(&Event {
            node,
            uid: None,
            previous: Status::Running,
            current,
        });
    }
    Ok(found)
}

/// The executions in one recording; damage ends its reading and is noted.
fn of_recording(path: &Path, notes: &mut Vec<String>) -> Result<Executions, Problem> {
    let bad = |error: recording::ReadError| Problem::new("bad-recording", error.to_string());
    let mut reader = recording::open(path, &OpenOptions::default()).map_err(bad)?;
    let is_log = |topic: &TopicInfo| {
        topic.type_name.ends_with(TYPE)
            || (topic.type_name.is_empty() && topic.name.ends_with(TOPIC))
    };
    reader.select(&is_log);
    let topics = reader.topics().iter().filter(|it| is_log(it));
    let mut logs: BTreeMap<usize, Log> = BTreeMap::new();
    for topic in topics {
        if let Some(log) = Log::new(topic) {
            logs.insert(topic.id.index(), log);
        }
    }
    let mut executions = Executions::default();
    let mut unread = 0;
    while let Some(message) = reader.next().map_err(bad)? {
        let log = logs.get_mut(&message.topic.index());
        let counted = log.and_then(|log| log.take(message.data, &mut executions));
        unread += usize::from(counted.is_none());
    }
    let lost = reader.losses().len() + unread;
    if lost > 0 {
        let file = comment(&path.display().to_string());
        notes.push(format!(
            "{file}: {} could not be read, so executions may be missing",
            counted(lost, "part")
        ));
    }
    Ok(executions)
}

/// The fields of a change of status; the last is not in all versions.
const FIELDS: [&str; 4] = ["node_name", "previous_status", "current_status", "uid"];

/// What reads one topic.
struct Log {
    topic: TopicInfo,
    length: Extractor,
    fields: &'static [&'static str],
    events: Extractor,
    /// How many changes of status `events` asks for.
    capacity: usize,
}

impl Log {
    fn new(topic: &TopicInfo) -> Option<Self> {
        let length = FieldPath::parse("length(event_log)").ok()?;
        let length = Extractor::new(topic, &[length]).ok()?;
        let capacity = 16;
        let with = [&FIELDS[..], &FIELDS[..3]].into_iter();
        let (fields, events) = with
            .filter_map(|fields| Some((fields, events(topic, fields, capacity)?)))
            .next()?;
        Some(Self {
            topic: topic.clone(),
            length,
            fields,
            events,
            capacity,
        })
    }

    /// Counts a message; `None` if it cannot be read.
    fn take(&mut self, data: &[u8], executions: &mut Executions) -> Option<()> {
        let length = match self.length.extract_values(data).ok()?.first()? {
            Value::Number(length) => *length as usize,
            _ => return None,
        };
        if length > MOST_EVENTS {
            return None;
        }
        if length > self.capacity {
            self.capacity = length.next_power_of_two();
            self.events = events(&self.topic, self.fields, self.capacity)?;
        }
        let values = self.events.extract_values(data).ok()?;
        for event in values.chunks(self.fields.len()).take(length) {
            executions.add(&of_values(event)?);
        }
        Some(())
    }
}

fn events(topic: &TopicInfo, fields: &[&str], count: usize) -> Option<Extractor> {
    let names = (0..count).flat_map(|at| {
        let one = move |field: &&str| format!("event_log[{at}].{field}");
        fields.iter().map(one)
    });
    let paths: Option<Vec<FieldPath>> = names.map(|it| FieldPath::parse(&it).ok()).collect();
    Extractor::new(topic, &paths?).ok()
}

fn of_values(values: &[Value]) -> Option<Event<'_>> {
    let text = |at: usize| match values.get(at) {
        Some(Value::Text(text)) => Some(text.as_str()),
        _ => None,
    };
    let uid = match values.get(3) {
        Some(Value::Number(uid)) => Some(*uid as u32),
        _ => None,
    };
    Some(Event {
        node: text(0)?,
        uid,
        previous: Status::parse(text(1)?)?,
        current: Status::parse(text(2)?)?,
    })
}
