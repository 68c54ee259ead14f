//! A recording of raw messages, written as they come: what listens to a running system keeps.
//!
//! # Format
//! MCAP with the profile `ros2` where all types are of ROS 2, chunks without compression (compressing would delay
//! the one who writes), each with its checksum. Topics may be added at any time. A chunk is written whole or not at
//! all and is ended by [`RawRecording::flush`], so a process that is killed leaves a file from which
//! [`open`](crate::open()) gives everything up to the last flush and says that it was cut short.
//!
//! # Example
//! ```
//! use recording::{Format, OpenOptions, RawRecording, open_bytes};
//! let mut recording = RawRecording::new(std::io::Cursor::new(Vec::new()))?;
//! let speed = recording.add_topic("/speed", "std_msgs/msg/Float64", "cdr", Some(("ros2msg", b"float64 data")))?;
//! recording.write(speed, 1_000, 900, &[0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0xf8, 0x3f])?;
//! let bytes = recording.finish("run", &[("lost".to_owned(), "0".to_owned())].into())?.into_inner();
//! let mut reader = open_bytes(bytes, Format::Mcap, &OpenOptions::default())?;
//! assert_eq!(reader.metadata()["run.lost"], "0");
//! let message = reader.next()?.ok_or("no message")?;
//! assert_eq!((message.log_nanos, message.publish_nanos, message.data.len()), (1_000, 900, 12));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeMap;
use std::fmt;
use std::io::{Seek, Write};

use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, WriteOptions, Writer};

/// Size of a chunk in bytes; what a damaged place can cost.
const CHUNK_BYTES: u64 = 256 * 1024;

/// A topic of one [`RawRecording`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawTopicId(usize);

/// A recording cannot be written on.
#[derive(Debug)]
pub enum RawWriteError {
    /// The container or the operating system refuses.
    Format(McapError),
    /// A time before 1970, which the format cannot hold, in nanoseconds.
    Time(i64),
}

impl From<McapError> for RawWriteError {
    fn from(error: McapError) -> Self {
        RawWriteError::Format(error)
    }
}

impl fmt::Display for RawWriteError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RawWriteError::Format(error) => {
                write!(
                    out,
                    "the recording cannot be written: {error}; check the disk"
                )
            }
            RawWriteError::Time(nanos) => write!(
                out,
                "a message has the time {nanos} ns, before 1970, which a recording cannot hold; set the clock"
            ),
        }
    }
}

impl std::error::Error for RawWriteError {}

struct Topic {
    channel_id: u16,
    sequence: u32,
}

/// A recording of raw messages that is being written to `W`.
pub struct RawRecording<W: Write + Seek> {
    writer: Writer<W>,
    topics: Vec<Topic>,
}

impl<W: Write + Seek> fmt::Debug for RawRecording<W> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("RawRecording")
            .field("topics", &self.topics.len())
            .finish_non_exhaustive()
    }
}

impl<W: Write + Seek> RawRecording<W> {
    /// Begins a recording.
    ///
    /// # Errors
    /// [`RawWriteError::Format`] if its beginning cannot be written.
    pub fn new(out: W) -> Result<Self, RawWriteError> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library("corroborate")
            .compression(None)
            .compression_threads(0)
            // A chunk is put together in memory, so that no half of one is ever in the file.
            .disable_seeking(true)
            .chunk_size(Some(CHUNK_BYTES));
        Ok(RawRecording {
            writer: options.create(out)?,
            topics: Vec::new(),
        })
    }

    /// Adds a topic; `schema` is the language of its type's definition and the definition, if it is known.
    ///
    /// # Errors
    /// [`RawWriteError::Format`] if there is no room for another topic, or the container refuses.
    pub fn add_topic(
        &mut self,
        name: &str,
        type_name: &str,
        encoding: &str,
        schema: Option<(&str, &[u8])>,
    ) -> Result<RawTopicId, RawWriteError> {
        let schema_id = match schema {
            Some((language, text)) => self.writer.add_schema(type_name, language, text)?,
            None if encoding == "json" => 0,
            // The name of the type is kept although its definition is not known.
            None => self.writer.add_schema(type_name, "", &[])?,
        };
        let channel_id = self
            .writer
            .add_channel(schema_id, name, encoding, &BTreeMap::new())?;
        self.topics.push(Topic {
            channel_id,
            sequence: 0,
        });
        Ok(RawTopicId(self.topics.len() - 1))
    }

    /// Writes a message, received at `log_nanos` and sent at `publish_nanos` (nanoseconds since 1970).
    ///
    /// # Errors
    /// [`RawWriteError`] if a time is before 1970 or the container refuses.
    pub fn write(
        &mut self,
        topic: RawTopicId,
        log_nanos: i64,
        publish_nanos: i64,
        data: &[u8],
    ) -> Result<(), RawWriteError> {
        let time = |nanos: i64| u64::try_from(nanos).map_err(|_| RawWriteError::Time(nanos));
        let topic = &mut self.topics[topic.0];
        let header = MessageHeader {
            channel_id: topic.channel_id,
            sequence: topic.sequence,
            log_time: time(log_nanos)?,
            publish_time: time(publish_nanos)?,
        };
        topic.sequence = topic.sequence.wrapping_add(1);
        Ok(self.writer.write_to_known_channel(&header, data)?)
    }

    /// Ends the chunk and hands everything to `W`, so that it survives the end of the process.
    ///
    /// # Errors
    /// [`RawWriteError::Format`] if it cannot be written.
    pub fn flush(&mut self) -> Result<(), RawWriteError> {
        Ok(self.writer.flush()?)
    }

    /// Ends the recording with facts about it under `name`.
    ///
    /// # Errors
    /// [`RawWriteError::Format`] if its end cannot be written.
    pub fn finish(
        mut self,
        name: &str,
        about: &BTreeMap<String, String>,
    ) -> Result<W, RawWriteError> {
        self.writer.write_metadata(&Metadata {
            name: name.to_owned(),
            metadata: about.clone(),
        })?;
        self.writer.finish()?;
        Ok(self.writer.into_inner())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Format, OpenOptions, open_bytes};
    use std::io::Cursor;
    use std::sync::{Arc, Mutex};

    /// A file whose bytes can be looked at while it is written.
    #[derive(Clone, Default)]
    struct Shared(Arc<Mutex<Cursor<Vec<u8>>>>);

    impl Write for Shared {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().unwrap().write(bytes)
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    impl Seek for Shared {
        fn seek(&mut self, to: std::io::SeekFrom) -> std::io::Result<u64> {
            self.0.lock().unwrap().seek(to)
        }
    }

    #[test]
    fn what_was_flushed_can_be_read_though_the_writer_was_killed() {
        let shared = Shared::default();
        let mut recording = RawRecording::new(shared.clone()).unwrap();
        let one = recording
            .add_topic("/one", "p/msg/T", "cdr", Some(("ros2msg", b"uint8 x")))
            .unwrap();
        recording.write(one, 1, 1, &[0, 1, 0, 0, 7]).unwrap();
        recording.flush().unwrap();
        let two = recording.add_topic("/two", "q/msg/T", "cdr", None).unwrap();
        recording.write(two, 2, 2, &[0, 1, 0, 0, 8]).unwrap();
        recording.flush().unwrap();
        recording.write(one, 3, 3, &[0, 1, 0, 0, 9]).unwrap();
        // What a killed process leaves: the bytes so far, without the end.
        let bytes = shared.0.lock().unwrap().get_ref().clone();
        let mut reader = open_bytes(bytes, Format::Mcap, &OpenOptions::default()).unwrap();
        let mut given = Vec::new();
        while let Some(message) = reader.next().unwrap() {
            given.push((message.topic.index(), message.log_nanos, message.data[4]));
        }
        assert_eq!(given, [(0, 1, 7), (1, 2, 8)]);
        assert!(!reader.complete());
        assert_eq!(reader.topics()[1].type_name, "q/msg/T");
    }

    #[test]
    fn a_time_before_1970_is_refused() {
        let mut recording = RawRecording::new(Cursor::new(Vec::new())).unwrap();
        let topic = recording.add_topic("/t", "", "json", None).unwrap();
        let refused = recording.write(topic, -1, 0, b"{}");
        assert!(matches!(refused, Err(RawWriteError::Time(-1))));
    }
}
