//! Which topics and fields the columns of a table make, and how a row is turned into their bytes.
//!
//! A header of the form `/topic.field [unit]` names a field of a topic; a dot in the field makes a
//! part of a part. All other columns are fields of the topic `/csv`, whose names have `_` for each
//! run of signs that are no letters or digits, so that they can be written in paths: `position[0]`
//! becomes `position_0`.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::schema::{MessageField, MessageType, Primitive, Type};

/// The topic of columns that name none.
pub(crate) const TABLE_TOPIC: &str = "/csv";

/// Before the signal of a column whose header has a unit, in the metadata of a table.
pub(crate) const UNIT_OF: &str = "unit of ";

/// Before the signal of a column without any value, in the metadata of a table.
pub(crate) const NO_VALUE_IN: &str = "no value in ";

/// Of the filled cells of a column of numbers, at least this share must be numbers.
const LEAST_SHARE_OF_NUMBERS: f64 = 0.9;

/// What the cells of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Number,
    Truth,
    Text,
}

/// What was seen in a column.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Census {
    numbers: u64,
    truths: u64,
    texts: u64,
    empty: u64,
}

impl Census {
    pub(crate) fn count(&mut self, cell: &str) {
        let counter = match cell {
            "" => &mut self.empty,
            cell if number(cell).is_some() => &mut self.numbers,
            cell if truth(cell).is_some() => &mut self.truths,
            _ => &mut self.texts,
        };
        *counter += 1;
    }

    /// Whether no row has a value in the column, so that nothing tells its kind.
    pub(crate) fn is_empty(&self) -> bool {
        self.numbers + self.truths + self.texts == 0
    }

    /// The kind of the column. Truth values of which some are missing count as the numbers 0 and 1,
    /// since only a number can be missing.
    pub(crate) fn kind(&self) -> Kind {
        let filled = self.numbers + self.truths + self.texts;
        if self.truths == filled && filled > 0 {
            return if self.empty == 0 {
                Kind::Truth
            } else {
                Kind::Number
            };
        }
        let is_number = self.numbers as f64 >= LEAST_SHARE_OF_NUMBERS * filled as f64;
        if is_number { Kind::Number } else { Kind::Text }
    }
}

/// The number that a cell holds.
pub(crate) fn number(cell: &str) -> Option<f64> {
    cell.parse().ok()
}

/// The truth value that a cell holds.
pub(crate) fn truth(cell: &str) -> Option<bool> {
    match cell {
        "true" | "True" | "TRUE" => Some(true),
        "false" | "False" | "FALSE" => Some(false),
        _ => None,
    }
}

/// A topic that a table has, with its columns in the order in which they are serialised.
#[derive(Debug)]
pub(crate) struct TableTopic {
    pub(crate) name: String,
    pub(crate) message_type: MessageType,
    pub(crate) columns: Vec<(usize, Kind)>,
    /// Whether a row without any filled cell is left out.
    pub(crate) skips_empty_rows: bool,
}

/// What the columns of a table make.
#[derive(Debug, Default)]
pub(crate) struct Layout {
    pub(crate) topics: Vec<TableTopic>,
    /// Units by signal, and the headers of columns that got another name.
    pub(crate) notes: BTreeMap<String, String>,
}

/// A part of a message: a column, or parts with names.
enum Part {
    Column(usize, Kind),
    Parts(Vec<(String, Part)>),
}

/// The layout of a table with these headers and kinds of columns; the column of times has no kind.
/// `without_values` are the columns in which no row has a value.
///
/// # Errors
/// A clause if two columns have the same name.
pub(crate) fn layout(
    headers: &[String],
    kinds: &[Option<Kind>],
    without_values: &[usize],
) -> Result<Layout, String> {
    let mut layout = Layout::default();
    let mut topics: Vec<(String, Part)> = Vec::new();
    for (column, (header, kind)) in headers.iter().zip(kinds).enumerate() {
        let Some(kind) = *kind else {
            continue;
        };
        let (name, unit) = split_unit(header);
        let (topic, path) = place_of(name, column);
        let signal = format!("{topic}.{}", path.join("."));
        let notes = &mut layout.notes;
        if !unit.is_empty() {
            notes.insert(format!("{UNIT_OF}{signal}"), unit.to_owned());
        }
        if without_values.contains(&column) {
            notes.insert(format!("{NO_VALUE_IN}{signal}"), String::new());
        }
        if topic == TABLE_TOPIC && path[0] != name {
            notes.insert(format!("header of {signal}"), header.clone());
        }
        let place = topics
            .iter()
            .position(|(other, _)| other == topic)
            .unwrap_or_else(|| {
                topics.push((topic.to_owned(), Part::Parts(Vec::new())));
                topics.len() - 1
            });
        topics[place]
            .1
            .insert(&path, Part::Column(column, kind))
            .ok_or_else(|| {
                format!("two columns are called {signal}; give one of them another name")
            })?;
    }
    layout.topics = topics.into_iter().map(table_topic).collect();
    Ok(layout)
}

/// The topic of a column without its unit, and the path of its field.
fn place_of(name: &str, column: usize) -> (&str, Vec<String>) {
    match split_topic(name) {
        Some((topic, field)) => (topic, field.split('.').map(str::to_owned).collect()),
        None => (TABLE_TOPIC, vec![plain_name(name, column)]),
    }
}

fn table_topic((name, part): (String, Part)) -> TableTopic {
    let mut columns = Vec::new();
    TableTopic {
        message_type: part.message_type(&name, &mut columns),
        columns,
        skips_empty_rows: name != TABLE_TOPIC,
        name,
    }
}

impl Part {
    /// Adds a column at a path; `None` if something is there already.
    fn insert(&mut self, path: &[String], column: Part) -> Option<()> {
        let (Part::Parts(parts), [first, rest @ ..]) = (self, path) else {
            return None;
        };
        let found = parts.iter().position(|(name, _)| name == first);
        match (found, rest) {
            (None, []) => parts.push((first.clone(), column)),
            (Some(_), []) => return None,
            (found, rest) => {
                let place = found.unwrap_or_else(|| {
                    parts.push((first.clone(), Part::Parts(Vec::new())));
                    parts.len() - 1
                });
                parts[place].1.insert(rest, column)?;
            }
        }
        Some(())
    }

    fn message_type(self, name: &str, columns: &mut Vec<(usize, Kind)>) -> MessageType {
        let parts = match self {
            Part::Parts(parts) => parts,
            column @ Part::Column(..) => vec![(name.to_owned(), column)],
        };
        let fields = parts.into_iter().map(|(name, part)| {
            let kind = match part {
                Part::Column(column, kind) => {
                    columns.push((column, kind));
                    match kind {
                        Kind::Number => Type::Primitive(Primitive::Float64),
                        Kind::Truth => Type::Primitive(Primitive::Bool),
                        Kind::Text => Type::Text,
                    }
                }
                part => Type::Struct(Arc::new(part.message_type(&name, columns))),
            };
            MessageField { name, kind }
        });
        let fields = fields.collect();
        MessageType {
            name: name.to_owned(),
            fields,
            constants: Vec::new(),
        }
    }
}

/// Appends a cell as its kind is serialised; `false` if it is not of its kind, and missing then.
pub(crate) fn append(cell: &str, kind: Kind, out: &mut Vec<u8>) -> bool {
    match kind {
        Kind::Number => {
            let value = number(cell).or_else(|| truth(cell).map(f64::from));
            out.extend_from_slice(&value.unwrap_or(f64::NAN).to_le_bytes());
            value.is_some() || cell.is_empty()
        }
        Kind::Truth => {
            let value = truth(cell);
            out.push(u8::from(value.unwrap_or(false)));
            value.is_some()
        }
        Kind::Text => {
            // A cell of 4 GiB cannot be: rows are shorter.
            let len = u32::try_from(cell.len()).unwrap_or(u32::MAX);
            out.extend_from_slice(&len.to_le_bytes());
            out.extend_from_slice(&cell.as_bytes()[..len as usize]);
            true
        }
    }
}

/// `name [unit]` as name and unit. What is in the brackets must be no index.
fn split_unit(header: &str) -> (&str, &str) {
    let split = header
        .strip_suffix(']')
        .and_then(|rest| rest.rsplit_once('['));
    match split {
        Some((name, unit)) if !name.trim().is_empty() && unit.parse::<u64>().is_err() => {
            (name.trim_end(), unit.trim())
        }
        _ => (header, ""),
    }
}

/// `/topic.field` as topic and field.
fn split_topic(name: &str) -> Option<(&str, &str)> {
    let (topic, field) = name.split_once('.')?;
    let is_path =
        |part: &str| !part.is_empty() && part.chars().all(|c| c.is_alphanumeric() || c == '_');
    let is_topic = topic.starts_with('/') && topic.len() > 1;
    (is_topic && field.split('.').all(is_path)).then_some((topic, field))
}

/// A name that can be part of a path.
fn plain_name(name: &str, column: usize) -> String {
    let words = name.split(|c: char| !c.is_alphanumeric() && c != '_');
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    match words.join("_") {
        empty if empty.is_empty() => format!("column_{}", column + 1),
        name => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(message_type: &MessageType) -> Vec<&str> {
        message_type
            .fields
            .iter()
            .map(|field| field.name.as_str())
            .collect()
    }

    #[test]
    fn headers_make_topics_fields_and_units() {
        let headers = [
            "time_secs",
            "/robot.hand.x [m]",
            "speed [m/s]",
            "/robot.state",
            "position[0]",
            "/robot.hand.y",
            "",
        ];
        let headers: Vec<String> = headers.map(str::to_owned).into();
        let mut kinds = vec![Some(Kind::Number); headers.len()];
        kinds[0] = None;
        kinds[3] = Some(Kind::Text);
        let layout = layout(&headers, &kinds, &[6]).unwrap();
        let [robot, table] = &layout.topics[..] else {
            panic!("there are two topics")
        };
        assert_eq!(
            (robot.name.as_str(), table.name.as_str()),
            ("/robot", "/csv")
        );
        assert_eq!(names(&robot.message_type), ["hand", "state"]);
        assert_eq!(
            robot.columns,
            [(1, Kind::Number), (5, Kind::Number), (3, Kind::Text)]
        );
        assert_eq!(
            names(&table.message_type),
            ["speed", "position_0", "column_7"]
        );
        assert_eq!(layout.notes["unit of /robot.hand.x"], "m");
        assert_eq!(layout.notes["unit of /csv.speed"], "m/s");
        assert!(layout.notes.contains_key("no value in /csv.column_7"));
        assert_eq!(layout.notes["header of /csv.position_0"], "position[0]");
    }

    #[test]
    fn two_columns_of_one_name_are_refused() {
        for headers in [["a b", "a-b"], ["/r.x", "/r.x [m]"], ["/r.x", "/r.x.y"]] {
            let headers = headers.map(str::to_owned);
            assert!(
                layout(&headers, &[Some(Kind::Number); 2], &[]).is_err(),
                "{headers:?}"
            );
        }
    }

    #[test]
    fn kinds_follow_from_all_cells() {
        let kind = |cells: &[&str]| {
            let mut census = Census::default();
            cells.iter().for_each(|cell| census.count(cell));
            census.kind()
        };
        assert_eq!(kind(&["1", "", "-2e3", "nan"]), Kind::Number);
        assert_eq!(kind(&["true", "False"]), Kind::Truth);
        assert_eq!(kind(&["true", ""]), Kind::Number);
        assert_eq!(kind(&["idle", "serve"]), Kind::Text);
        assert_eq!(kind(&["1", "a"]), Kind::Text);
        assert_eq!(kind(&["", ""]), Kind::Number);
        let mut mostly = vec!["1"; 99];
        mostly.push("1.2.3");
        assert_eq!(kind(&mostly), Kind::Number);
    }
}
