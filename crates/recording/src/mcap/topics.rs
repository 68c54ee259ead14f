//! Channels and schemas of a file as topics, and messages by topic.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::loader::{Loaded, MessageAt};
use super::record::{ChannelRecord, SchemaRecord, op};
use super::segments::Entry;
use crate::reader::{Encoding, TopicId, TopicInfo};
use crate::schema::{Dialect, ProtobufSchema, Schema, SchemaError, parse_idl, parse_msg};

/// Messages of a segment that are not given.
#[derive(Default)]
struct LeftOut {
    /// How many there are of each channel that nothing describes.
    unknown: BTreeMap<u16, u64>,
    /// How many have times that cannot be held.
    beyond: u64,
}

/// Everything that describes messages, as far as it was found.
#[derive(Default)]
pub(super) struct Topics {
    pub(super) all: Vec<TopicInfo>,
    schemas: BTreeMap<u16, (SchemaRecord, Arc<Schema>)>,
    channels: BTreeMap<u16, (ChannelRecord, TopicId)>,
    /// The topic of each channel, by its id.
    by_channel: Vec<Option<TopicId>>,
    notes: Vec<(String, Option<u64>)>,
    noted: BTreeSet<String>,
    noted_segments: BTreeSet<u64>,
}

impl Topics {
    /// Takes a schema; `false` if it is another one of the same id. Id 0 stands for none.
    pub(super) fn add_schema(&mut self, record: SchemaRecord) -> bool {
        if let Some((known, _)) = self.schemas.get(&record.id) {
            return *known == record;
        }
        let schema = Arc::new(understand(&record));
        self.schemas.insert(record.id, (record, schema));
        true
    }

    /// Takes a channel; `false` if it is another one of the same id.
    pub(super) fn add_channel(&mut self, record: ChannelRecord) -> bool {
        if let Some((known, _)) = self.channels.get(&record.id) {
            return *known == record;
        }
        let id = TopicId(self.all.len() as u32);
        let encoding = match record.message_encoding.as_str() {
            "cdr" => Encoding::Cdr,
            "ros1" => Encoding::Ros1,
            "json" => Encoding::Json,
            "protobuf" => Encoding::Protobuf,
            other => Encoding::Unknown(other.to_owned()),
        };
        let known = self.schemas.get(&record.schema_id);
        let schema = match known {
            _ if encoding == Encoding::Json => Arc::new(Schema::Schemaless),
            Some((_, schema)) => schema.clone(),
            None => Arc::new(Schema::Unknown {
                reason: "the recording has no schema for it".to_owned(),
            }),
        };
        self.all.push(TopicInfo {
            id,
            name: record.topic.clone(),
            type_name: known
                .map(|(record, _)| record.name.clone())
                .unwrap_or_default(),
            encoding,
            schema,
            message_count: None,
        });
        let channel = usize::from(record.id);
        if self.by_channel.len() <= channel {
            self.by_channel.resize(channel + 1, None);
        }
        self.by_channel[channel] = Some(id);
        self.channels.insert(record.id, (record, id));
        true
    }

    pub(super) fn of_channel(&self, channel: u16) -> Option<TopicId> {
        self.by_channel.get(usize::from(channel)).copied().flatten()
    }

    pub(super) fn set_counts(&mut self, counts: &BTreeMap<u16, u64>) {
        for (channel, (_, id)) in &self.channels {
            let count = counts.get(channel).copied().unwrap_or(0);
            self.all[id.index()].message_count = Some(count);
        }
    }

    /// What was noted since the last call, with the number of messages lost.
    pub(super) fn new_notes(&mut self) -> Vec<(String, Option<u64>)> {
        std::mem::take(&mut self.notes)
    }

    /// Drops notes that were made already when the file was read ahead.
    pub(super) fn forget_notes(&mut self) {
        self.notes.clear();
    }

    /// Whether this is the first call for a segment.
    pub(super) fn note_once(&mut self, segment: u64) -> bool {
        self.noted_segments.insert(segment)
    }

    fn note(&mut self, key: String, message: String, count: Option<u64>) {
        if self.noted.insert(key) {
            self.notes.push((message, count));
        }
    }

    /// Takes the records of a segment at `offset`: descriptions, and its messages as entries.
    ///
    /// # Errors
    /// What is wrong, as a clause.
    pub(super) fn take(
        &mut self,
        offset: u64,
        loaded: &Loaded,
        entries: &mut Vec<Entry>,
    ) -> Result<(), String> {
        let mut left_out = LeftOut::default();
        let mut contradicts = false;
        let mut from = 0;
        entries.reserve(loaded.messages.len());
        for at in &loaded.descriptions {
            let before = &loaded.messages[from..at.messages_before];
            self.enter(before, entries, &mut left_out);
            from = at.messages_before;
            let content = &loaded.data[at.start..at.end];
            let Some(is_new_or_same) = self.describe(at.kind, content) else {
                return Err("a description inside a chunk is malformed".to_owned());
            };
            contradicts |= !is_new_or_same;
        }
        self.enter(&loaded.messages[from..], entries, &mut left_out);
        if let Some(problem) = &loaded.problem {
            return Err(problem.clone());
        }
        if contradicts {
            return Err(
                "a chunk describes a channel or schema otherwise than it was before".to_owned(),
            );
        }
        self.note_all(offset, left_out);
        Ok(())
    }

    /// Makes entries of messages.
    fn enter(&self, messages: &[MessageAt], entries: &mut Vec<Entry>, left_out: &mut LeftOut) {
        for message in messages {
            let head = &message.head;
            let times = (
                i64::try_from(head.log_nanos),
                i64::try_from(head.publish_nanos),
            );
            match (self.of_channel(head.channel), times) {
                (None, _) => *left_out.unknown.entry(head.channel).or_insert(0) += 1,
                (Some(topic), (Ok(log_nanos), Ok(publish_nanos))) => entries.push(Entry {
                    log_nanos,
                    publish_nanos,
                    topic,
                    start: message.start,
                    end: message.end,
                }),
                _ => left_out.beyond += 1,
            }
        }
    }

    fn describe(&mut self, kind: u8, content: &[u8]) -> Option<bool> {
        Some(match kind {
            op::SCHEMA => self.add_schema(SchemaRecord::read(content)?),
            _ => self.add_channel(ChannelRecord::read(content)?),
        })
    }

    fn note_all(&mut self, offset: u64, left_out: LeftOut) {
        for (channel, count) in left_out.unknown {
            let message = format!("messages of channel {channel}, which nothing describes");
            self.note(format!("{offset} {channel}"), message, Some(count));
        }
        if left_out.beyond > 0 {
            let message = "messages with times beyond the year 2262".to_owned();
            self.note(format!("{offset} beyond"), message, Some(left_out.beyond));
        }
    }
}

/// Reads a schema, whatever its language; what cannot be read says why.
fn understand(record: &SchemaRecord) -> Schema {
    let text = || {
        std::str::from_utf8(&record.data).map_err(|_| SchemaError {
            line: 0,
            message: "it is not UTF-8".to_owned(),
        })
    };
    let name = record.name.as_str();
    let read = match record.encoding.as_str() {
        "ros2msg" => text().and_then(|text| parse_msg(name, text, Dialect::Ros2)),
        "ros1msg" => text().and_then(|text| parse_msg(name, text, Dialect::Ros1)),
        "ros2idl" => text().and_then(|text| parse_idl(name, text)),
        "jsonschema" => return Schema::Schemaless,
        "protobuf" => match ProtobufSchema::parse(name, &record.data) {
            Ok(schema) => return Schema::Protobuf(schema),
            Err(error) => Err(error),
        },
        other => {
            let reason = format!("schemas in \"{other}\" are not supported");
            return Schema::Unknown { reason };
        }
    };
    match read {
        Ok(message) => Schema::Struct(message),
        Err(error) => Schema::Unknown {
            reason: format!("its schema {name} cannot be understood: {error}"),
        },
    }
}
