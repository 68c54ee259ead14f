//! A recording that is written message by message.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions, Writer};

use super::definitions::{schema_text, short_name};
use super::encode::{Plan, Ros2Value};
use super::error::Ros2WriteError;

/// Size of a chunk before compression in bytes; what a damaged place can cost.
const CHUNK_BYTES: u64 = 256 * 1024;

/// A topic of one [`Ros2Recording`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ros2TopicId(usize);

struct Topic {
    channel_id: u16,
    type_name: &'static str,
    sequence: u32,
    /// The plan of the last message, for the next one with the same fields.
    last: Option<(Vec<String>, Plan)>,
}

/// A recording in the message types of ROS 2.
pub struct Ros2Recording {
    writer: Writer<Cursor<Vec<u8>>>,
    topics: Vec<Topic>,
    message: Vec<u8>,
}

impl std::fmt::Debug for Ros2Recording {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Ros2Recording")
            .field("topics", &self.topics.len())
            .finish_non_exhaustive()
    }
}

impl Ros2Recording {
    /// An empty recording.
    ///
    /// # Errors
    /// [`Ros2WriteError::Format`] if the container cannot be begun.
    pub fn new() -> Result<Self, Ros2WriteError> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library("corroborate")
            .compression(Some(Compression::Zstd))
            // Threads would make the bytes depend on the machine.
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES));
        Ok(Ros2Recording {
            writer: options.create(Cursor::new(Vec::new()))?,
            topics: Vec::new(),
            message: Vec::new(),
        })
    }

    /// Writes facts about the recording under `name`.
    ///
    /// # Errors
    /// [`Ros2WriteError::Format`] if the container refuses.
    pub fn add_metadata(
        &mut self,
        name: &str,
        metadata: &BTreeMap<String, String>,
    ) -> Result<(), Ros2WriteError> {
        self.writer.write_metadata(&Metadata {
            name: name.to_owned(),
            metadata: metadata.clone(),
        })?;
        Ok(())
    }

    /// Adds the topic `name` with messages of the type `type_name`, as
    /// `geometry_msgs/msg/PoseStamped`.
    ///
    /// # Errors
    /// [`Ros2WriteError::UnknownType`] if messages of that type cannot be written.
    pub fn add_topic(
        &mut self,
        name: &str,
        type_name: &str,
    ) -> Result<Ros2TopicId, Ros2WriteError> {
        let short = short_name(type_name).ok_or_else(|| Ros2WriteError::UnknownType {
            type_name: type_name.to_owned(),
        })?;
        let full_name = short.replacen('/', "/msg/", 1);
        let schema =
            self.writer
                .add_schema(&full_name, "ros2msg", schema_text(short).as_bytes())?;
        let about = BTreeMap::from([("offered_qos_profiles".to_owned(), String::new())]);
        let channel_id = self.writer.add_channel(schema, name, "cdr", &about)?;
        self.topics.push(Topic {
            channel_id,
            type_name: short,
            sequence: 0,
            last: None,
        });
        Ok(Ros2TopicId(self.topics.len() - 1))
    }

    /// Writes a message that was received and sent at `log_nanos`, with the values of some fields.
    ///
    /// # Errors
    /// [`Ros2WriteError`] if there is no such field, a value does not fit, or the time is before 0.
    pub fn write(
        &mut self,
        topic: Ros2TopicId,
        log_nanos: i64,
        fields: &[(&str, Ros2Value<'_>)],
    ) -> Result<(), Ros2WriteError> {
        let Some(state) = self.topics.get_mut(topic.0) else {
            return Err(Ros2WriteError::Format(
                "the topic is of another recording".to_owned(),
            ));
        };
        let same = |paths: &Vec<String>| paths.iter().eq(fields.iter().map(|(path, _)| path));
        let plan = match state.last.take().filter(|(paths, _)| same(paths)) {
            Some((_, plan)) => plan,
            None => {
                let paths: Vec<&str> = fields.iter().map(|(path, _)| *path).collect();
                Plan::new(state.type_name, &paths)?
            }
        };
        let values: Vec<Ros2Value<'_>> = fields.iter().map(|(_, value)| *value).collect();
        let written = self.write_planned(topic, log_nanos, &plan, &values);
        let paths = fields.iter().map(|(path, _)| (*path).to_owned()).collect();
        self.topics[topic.0].last = Some((paths, plan));
        written
    }

    pub(super) fn write_planned(
        &mut self,
        topic: Ros2TopicId,
        log_nanos: i64,
        plan: &Plan,
        values: &[Ros2Value<'_>],
    ) -> Result<(), Ros2WriteError> {
        let log_time = u64::try_from(log_nanos).map_err(|_| {
            Ros2WriteError::Format(format!(
                "a message at {log_nanos} ns lies before 0, which the format cannot hold"
            ))
        })?;
        plan.encode(values, &mut self.message)?;
        let state = &mut self.topics[topic.0];
        let header = MessageHeader {
            channel_id: state.channel_id,
            sequence: state.sequence,
            log_time,
            publish_time: log_time,
        };
        state.sequence = state.sequence.wrapping_add(1);
        self.writer.write_to_known_channel(&header, &self.message)?;
        Ok(())
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// [`Ros2WriteError::Format`] if the container refuses.
    pub fn finish(mut self) -> Result<Vec<u8>, Ros2WriteError> {
        self.writer.finish()?;
        Ok(self.writer.into_inner().into_inner())
    }
}
