//! JSON lines: one JSON object on each line, of which each is a message.
//!
//! ```text
//! {"topic": "/robot", "time": "2024-05-01T12:00:00.25Z", "hand": {"speed": 0.2, "at": [0.1, 0.4]}}
//! ```
//!
//! The key `topic` (or `channel`) has the topic; without it, it is `/json`. The time is under the key
//! that the caller names, or one of those that are usual, at the top of the object; its unit is found
//! as for tables (see [`row_time`](crate::csv_rows::row_time)). The message is the whole object, so a
//! path begins at its top: `hand.speed`, `hand.at[1]`. Blank lines are ignored.
//!
//! The file is read twice: first for the topics, then for the messages. Guarantee: each line is given
//! once, in the order of the file, or is a [`Loss`] with its number. A line that was cut is no JSON
//! object any more, so it is always noticed.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, BufRead, Read, Seek, SeekFrom};
use std::sync::Arc;

use serde::de::{Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;

use crate::csv_rows::row_time::{TimeFormat, find_time};
use crate::reader::{
    Encoding, Loss, OpenOptions, RawMessage, ReadError, ReadProblem, Reader, TopicId, TopicInfo,
};
use crate::ros1_bag::loss;
use crate::schema::Schema;
use crate::storage::StoredFile;

/// The topic of lines that name none.
const LINE_TOPIC: &str = "/json";

/// Keys that name the topic.
const TOPIC_KEYS: [&str; 2] = ["topic", "channel"];

/// More losses than this would not be read by anyone; the last one says that there are more.
const MAX_LOSSES: usize = 1_000;

/// A file that is being read.
pub(crate) struct JsonLinesReader<R> {
    lines: Lines<R>,
    time_key: String,
    time_format: TimeFormat,
    topics: Vec<TopicInfo>,
    by_name: BTreeMap<String, TopicId>,
    selected: Vec<bool>,
    metadata: BTreeMap<String, String>,
    losses: Vec<Loss>,
    has_ended: bool,
    /// The latest time so far.
    end_nanos: Option<i64>,
}

/// The lines of a file.
struct Lines<R> {
    source: R,
    line: Vec<u8>,
    number: u64,
    offset: u64,
    next_offset: u64,
    max_bytes: u64,
}

impl<R: BufRead + Seek> Lines<R> {
    fn new(source: R, max_bytes: u64) -> io::Result<Self> {
        let line = Vec::new();
        let mut lines = Lines {
            source,
            line,
            number: 0,
            offset: 0,
            next_offset: 0,
            max_bytes,
        };
        lines.rewind()?;
        Ok(lines)
    }

    fn rewind(&mut self) -> io::Result<()> {
        (self.number, self.offset, self.next_offset) = (0, 0, 0);
        self.source.seek(SeekFrom::Start(0)).map(|_| ())
    }

    /// Goes to the next line that is not blank; `None` at the end.
    fn advance(&mut self) -> io::Result<Option<()>> {
        loop {
            self.line.clear();
            self.offset = self.next_offset;
            let limit = self.max_bytes.saturating_add(1);
            let count = (&mut self.source)
                .take(limit)
                .read_until(b'\n', &mut self.line)? as u64;
            if count == 0 {
                return Ok(None);
            }
            if count == limit && self.line.last() != Some(&b'\n') {
                let message = format!(
                    "line {} has more than {} bytes",
                    self.number + 1,
                    self.max_bytes
                );
                return Err(io::Error::new(io::ErrorKind::InvalidData, message));
            }
            self.next_offset += count;
            self.number += 1;
            if self.number == 1 && self.line.starts_with(b"\xef\xbb\xbf") {
                self.line.drain(..3);
            }
            if !self.line.trim_ascii().is_empty() {
                return Ok(Some(()));
            }
        }
    }
}

/// What the top of an object tells.
#[derive(Debug, Default)]
struct Top {
    topic: Option<String>,
    /// The text of the time, without quotes.
    time: Option<String>,
}

impl Top {
    /// Reads the top of the object in `line`, looking for the time under `time_key`.
    fn read(line: &[u8], time_key: &str) -> Result<Self, serde_json::Error> {
        let mut deserializer = serde_json::Deserializer::from_slice(line);
        let top = deserializer.deserialize_map(TopVisitor { time_key })?;
        deserializer.end()?;
        Ok(top)
    }
}

struct TopVisitor<'a> {
    time_key: &'a str,
}

impl<'de> Visitor<'de> for TopVisitor<'_> {
    type Value = Top;

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("a JSON object")
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Top, M::Error> {
        let mut top = Top::default();
        while let Some(Key(key)) = map.next_key()? {
            // Kept as text: a time in nanoseconds has more digits than a double holds.
            let value: &RawValue = map.next_value()?;
            if key == self.time_key {
                top.time = Some(unquoted(value.get()));
            } else if top.topic.is_none() && TOPIC_KEYS.contains(&&*key) {
                top.topic = serde_json::from_str(value.get()).ok();
            }
        }
        Ok(top)
    }
}

/// A key, borrowed from the line unless it has escapes.
#[derive(serde::Deserialize)]
struct Key<'a>(#[serde(borrow)] Cow<'a, str>);

/// The keys at the top of an object, in their order.
struct Keys(Vec<String>);

impl<'de> serde::Deserialize<'de> for Keys {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct KeysVisitor;
        impl<'de> Visitor<'de> for KeysVisitor {
            type Value = Keys;

            fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                out.write_str("a JSON object")
            }

            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Keys, M::Error> {
                let mut keys = Vec::new();
                while let Some((key, _)) = map.next_entry::<String, serde::de::IgnoredAny>()? {
                    keys.push(key);
                }
                Ok(Keys(keys))
            }
        }
        deserializer.deserialize_map(KeysVisitor)
    }
}

/// A text without its quotes; anything else as it stands.
fn unquoted(raw: &str) -> String {
    if !raw.starts_with('"') {
        return raw.to_owned();
    }
    serde_json::from_str(raw).unwrap_or_else(|_| raw.to_owned())
}

impl<R: BufRead + Seek> JsonLinesReader<R> {
    /// Reads the file once, to learn its topics.
    ///
    /// # Errors
    /// [`ReadError`] if its first object has no time, or the unit of the time is ambiguous.
    pub(crate) fn new(source: R, options: &OpenOptions) -> Result<Self, ReadError> {
        let mut reader = JsonLinesReader {
            lines: Lines::new(source, options.record_bytes)?,
            time_key: String::new(),
            time_format: TimeFormat::Date,
            topics: Vec::new(),
            by_name: BTreeMap::new(),
            selected: Vec::new(),
            metadata: BTreeMap::new(),
            losses: Vec::new(),
            has_ended: false,
            end_nanos: None,
        };
        reader.find_time(options)?;
        reader.lines.rewind()?;
        while reader.lines.advance()?.is_some() {
            if let Ok((_, topic)) = reader.read_line() {
                reader.count(topic);
            }
        }
        reader.lines.rewind()?;
        reader.selected = vec![true; reader.topics.len()];
        Ok(reader)
    }

    /// Finds the key and the unit of the times in the first object.
    fn find_time(&mut self, options: &OpenOptions) -> Result<(), ReadError> {
        let mut first_problem = None;
        while self.lines.advance()?.is_some() {
            let Keys(keys) = match serde_json::from_slice(&self.lines.line) {
                Ok(keys) => keys,
                Err(error) => {
                    let number = self.lines.number;
                    first_problem
                        .get_or_insert_with(|| (number, self.lines.offset, error.to_string()));
                    continue;
                }
            };
            let found = match &options.time_field {
                Some(wanted) => keys.iter().position(|key| key == wanted),
                None => find_time(keys.iter().map(String::as_str)),
            };
            let Some(found) = found else {
                return Err(self.malformed(format!(
                    "the object has no time under its keys \"{}\"; name the key that has the times",
                    keys.join("\", \"")
                )));
            };
            let key = &keys[found];
            let top = Top::read(&self.lines.line, key).unwrap_or_default();
            let text = top.time.unwrap_or_default();
            let Some(format) = TimeFormat::detect(key, &text, options.time_unit) else {
                return Err(self.malformed(format!(
                    "the unit of \"{key}\" cannot be derived from {text}; state the unit (s, ms, us or ns)"
                )));
            };
            (self.time_key, self.time_format) = (key.clone(), format);
            return Ok(());
        }
        let Some((number, offset, problem)) = first_problem else {
            return Err(ReadProblem::Empty.into());
        };
        Err(ReadError {
            path: None,
            offset: Some(offset),
            problem: ReadProblem::Malformed(format!(
                "no line is a JSON object; of line {number}: {problem}"
            )),
        })
    }

    fn malformed(&self, message: String) -> ReadError {
        ReadError {
            path: None,
            offset: Some(self.lines.offset),
            problem: ReadProblem::Malformed(format!("line {}: {message}", self.lines.number)),
        }
    }

    /// Time and topic of the present line, or what is wrong with it.
    fn read_line(&self) -> Result<(i64, String), String> {
        let number = self.lines.number;
        let top = Top::read(&self.lines.line, &self.time_key)
            .map_err(|error| format!("line {number} is not a JSON object ({error})"))?;
        let time = top
            .time
            .ok_or_else(|| format!("line {number} has no \"{}\"", self.time_key))?;
        let nanos = self.time_format.nanos(&time);
        let nanos = nanos.ok_or_else(|| format!("line {number}: {time} is not a valid time"))?;
        Ok((nanos, top.topic.unwrap_or_else(|| LINE_TOPIC.to_owned())))
    }

    /// Counts a message of the topic `name`.
    fn count(&mut self, name: String) {
        let topics = &mut self.topics;
        let id = *self.by_name.entry(name).or_insert_with_key(|name| {
            let id = TopicId(topics.len() as u32);
            topics.push(TopicInfo {
                id,
                name: name.clone(),
                type_name: String::new(),
                encoding: Encoding::Json,
                schema: Arc::new(Schema::Schemaless),
                message_count: None,
            });
            id
        });
        let count = &mut topics[id.index()].message_count;
        *count = Some(count.unwrap_or(0) + 1);
    }

    fn note(&mut self, message: String) {
        let offset = self.lines.offset;
        match self.losses.len() {
            len if len < MAX_LOSSES => {
                self.losses.push(Loss {
                    messages: Some(1),
                    ..loss(offset, message)
                });
            }
            MAX_LOSSES => self
                .losses
                .push(loss(offset, "here and behind there is more damage")),
            _ => {}
        }
    }

    /// Time and topic of the next line of a selected topic.
    fn find_next(&mut self) -> Result<Option<(i64, TopicId)>, ReadError> {
        while self.lines.advance()?.is_some() {
            match self.read_line() {
                Ok((nanos, topic)) => {
                    self.end_nanos = self.end_nanos.max(Some(nanos));
                    match self.by_name.get(&topic) {
                        Some(&topic) if self.selected[topic.index()] => {
                            return Ok(Some((nanos, topic)));
                        }
                        Some(_) => {}
                        None => self.note("the file changed while it was read".to_owned()),
                    }
                }
                Err(problem) => self.note(problem),
            }
        }
        Ok(None)
    }
}

impl<R: BufRead + Seek> Reader for JsonLinesReader<R> {
    fn topics(&self) -> &[TopicInfo] {
        &self.topics
    }

    fn next(&mut self) -> Result<Option<RawMessage<'_>>, ReadError> {
        if self.has_ended {
            return Ok(None);
        }
        let found = self.find_next();
        self.has_ended = !matches!(found, Ok(Some(_)));
        let Some((nanos, topic)) = found? else {
            return Ok(None);
        };
        Ok(Some(RawMessage {
            topic,
            log_nanos: nanos,
            publish_nanos: nanos,
            data: self.lines.line.trim_ascii(),
            offset: self.lines.offset,
        }))
    }

    fn losses(&self) -> &[Loss] {
        &self.losses
    }

    fn end_nanos(&self) -> Option<i64> {
        self.end_nanos
    }

    fn complete(&self) -> bool {
        self.losses.is_empty()
    }

    fn select(&mut self, wanted: &dyn Fn(&TopicInfo) -> bool) {
        self.selected = self.topics.iter().map(wanted).collect();
    }

    fn metadata(&self) -> &BTreeMap<String, String> {
        &self.metadata
    }

    /// The format has no checksums.
    fn checked(&self) -> bool {
        false
    }

    fn storage(&self) -> Vec<StoredFile> {
        vec![StoredFile::plain("JSON lines")]
    }

    fn in_time_order(&self) -> bool {
        false
    }
}
