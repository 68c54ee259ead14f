//! What every recording looks like, whatever its format: topics, and raw messages one after another.
//!
//! A [`Reader`] yields messages as bytes; an extractor made for a topic turns
//! them into numbers. Damage never ends in a guess: what could be read is given, what was lost is
//! told by [`Reader::losses`], and [`Reader::complete`] is then false.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use crate::csv_rows::row_time::TimeUnit;
use crate::schema::Schema;
use crate::storage::StoredFile;

/// Which topic of a recording: its place in [`Reader::topics`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TopicId(pub u32);

impl TopicId {
    /// The place in [`Reader::topics`].
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// How the bytes of a topic's messages are to be understood.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Encoding {
    /// ROS 2: common data representation of the OMG, with its header of four bytes.
    Cdr,
    /// ROS 1: little-endian, packed.
    Ros1,
    /// One JSON value.
    Json,
    /// Protocol buffers.
    Protobuf,
    /// One row of a table, made by our own readers: the fields of the schema, serialised as
    /// [`Encoding::Ros1`] would be.
    Columns,
    /// An encoding that is not read here, by its name in the recording.
    Unknown(String),
}

impl fmt::Display for Encoding {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Encoding::Cdr => "cdr",
            Encoding::Ros1 => "ros1",
            Encoding::Json => "json",
            Encoding::Protobuf => "protobuf",
            Encoding::Columns => "columns",
            Encoding::Unknown(name) => name,
        })
    }
}

/// One topic of a recording. A recording may hold several topics of one name, for example of two
/// publishers; each has its own id and its own schema.
#[derive(Debug, Clone)]
pub struct TopicInfo {
    /// Its id.
    pub id: TopicId,
    /// Its name, as recorded, for example `/joint_states`.
    pub name: String,
    /// The name of its messages' type, as recorded, for example `sensor_msgs/msg/JointState`;
    /// empty if there is none.
    pub type_name: String,
    /// How its messages are encoded.
    pub encoding: Encoding,
    /// What its messages hold.
    pub schema: Arc<Schema>,
    /// How many messages it has, where the recording says so.
    pub message_count: Option<u64>,
}

/// One message, as it was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawMessage<'a> {
    /// Its topic.
    pub topic: TopicId,
    /// When it was recorded, in nanoseconds of the recorder's clock.
    pub log_nanos: i64,
    /// When it was published, in nanoseconds; the time of recording where the format has no other.
    pub publish_nanos: i64,
    /// Its bytes.
    pub data: &'a [u8],
    /// Where it stands in the file, in bytes, for errors: the message itself, or the compressed
    /// chunk that holds it.
    pub offset: u64,
}

/// A part of a recording that could not be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Loss {
    /// Where the damage begins, in bytes from the beginning of the file.
    pub offset: u64,
    /// What is wrong, as a clause, for example `a chunk's checksum is wrong`.
    pub message: String,
    /// The first and last time in nanoseconds that the lost part spans, where that is known.
    pub span_nanos: Option<(i64, i64)>,
    /// How many messages are lost, where that is known.
    pub messages: Option<u64>,
}

impl fmt::Display for Loss {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "at byte {}: {}", self.offset, self.message)?;
        match self.messages {
            Some(1) => out.write_str("; 1 message is lost")?,
            Some(messages) => write!(out, "; {messages} messages are lost")?,
            None => {}
        }
        if let Some((from, to)) = self.span_nanos {
            let (from_secs, to_secs) = (from as f64 / 1e9, to as f64 / 1e9);
            write!(out, ", from {from_secs} s to {to_secs} s")?;
        }
        Ok(())
    }
}

/// A recording that is being read.
pub trait Reader {
    /// The topics found so far; a [`TopicId`] is a place here. Topics are only ever appended, and
    /// only by a reader of an unfinished file that was asked not to look ahead.
    fn topics(&self) -> &[TopicInfo];

    /// The next message of a selected topic, or `None` at the end. Damage that can be passed over
    /// is passed over and noted in [`Reader::losses`].
    ///
    /// # Errors
    /// [`ReadError`] if the file can no longer be read at all, for example because the operating
    /// system refuses. The reader is then at its end.
    fn next(&mut self) -> Result<Option<RawMessage<'_>>, ReadError>;

    /// What could not be read so far. Known from the beginning or found on the way; final once
    /// [`Reader::next`] has given `None`.
    fn losses(&self) -> &[Loss];

    /// Whether all that was recorded can be read, as far as known so far: no loss, and the file
    /// was finished by its writer.
    fn complete(&self) -> bool;

    /// Reads only the topics for which `wanted` is true, from the next message on. All are
    /// selected at first. Formats with an index skip what holds no selected topic.
    fn select(&mut self, wanted: &dyn Fn(&TopicInfo) -> bool);

    /// What the recording says about itself, by name.
    fn metadata(&self) -> &BTreeMap<String, String>;

    /// Whether messages come in order of their time of recording (`log_nanos`). Otherwise they come
    /// in the order of the file.
    fn in_time_order(&self) -> bool;

    /// When the last message of all topics was logged, selected or not, as far as known: up to then
    /// the recorder was at work. Final once [`Reader::next`] has given `None`.
    fn end_nanos(&self) -> Option<i64>;

    /// Whether every message given so far was guarded by a checksum of the format, and passed. If
    /// not, a flipped bit inside a message cannot be told from data.
    fn checked(&self) -> bool;

    /// How its files are stored, as far as was seen so far; final once [`Reader::next`] has given
    /// `None`. Empty for what does not come from files.
    fn storage(&self) -> Vec<StoredFile>;
}

/// How to open a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OpenOptions {
    /// Whether to give messages in order of time where the format allows it (default), or as they
    /// stand in the file.
    pub time_order: bool,
    /// The most memory, in bytes, that putting messages into order may take; where more would be
    /// needed, they come in the order of the file. Default 512 MiB.
    pub memory_bytes: u64,
    /// The largest single record or chunk, in bytes after decompression, that is believed; a larger
    /// one counts as damage. Default 1 GiB.
    pub record_bytes: u64,
    /// Whether an unfinished file is read once beforehand, so that all its topics are known when it
    /// is open. Default true.
    pub look_ahead: bool,
    /// Folders with `.msg` files, for the types that a recording does not define itself. Default
    /// none.
    pub message_path: Vec<PathBuf>,
    /// The column of a table, or the key of JSON lines, that has the time. By default it is sought
    /// under the usual names.
    pub time_field: Option<String>,
    /// The unit of the times in a table or in JSON lines. By default it is told by the name of the
    /// column or key, or by the times themselves where only one unit makes sense.
    pub time_unit: Option<TimeUnit>,
}

impl Default for OpenOptions {
    fn default() -> Self {
        OpenOptions {
            time_order: true,
            memory_bytes: 512 << 20,
            record_bytes: 1 << 30,
            look_ahead: true,
            message_path: Vec::new(),
            time_field: None,
            time_unit: None,
        }
    }
}

/// A recording cannot be read.
#[derive(Debug)]
pub struct ReadError {
    /// The file, if it was read from one.
    pub path: Option<PathBuf>,
    /// Where it went wrong, in bytes from the beginning, where that makes sense.
    pub offset: Option<u64>,
    /// What is wrong.
    pub problem: ReadProblem,
}

/// What is wrong with a recording.
#[derive(Debug)]
pub enum ReadProblem {
    /// The operating system refuses.
    Io(std::io::Error),
    /// There are no bytes.
    Empty,
    /// It is in none of the known formats.
    UnknownFormat,
    /// It is what it claims to be, but cannot be read: what is wrong, with a remedy.
    Malformed(String),
}

impl ReadError {
    /// The same error, about the file at `path`.
    #[must_use]
    pub fn in_file(mut self, path: &std::path::Path) -> Self {
        self.path.get_or_insert_with(|| path.to_owned());
        self
    }
}

impl From<std::io::Error> for ReadError {
    fn from(error: std::io::Error) -> Self {
        ReadProblem::Io(error).into()
    }
}

impl From<ReadProblem> for ReadError {
    fn from(problem: ReadProblem) -> Self {
        ReadError {
            path: None,
            offset: None,
            problem,
        }
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.path {
            Some(path) => write!(out, "cannot read the recording {}: ", path.display())?,
            None => out.write_str("cannot read the recording: ")?,
        }
        if let Some(offset) = self.offset {
            write!(out, "at byte {offset}: ")?;
        }
        self.problem.fmt(out)
    }
}

impl fmt::Display for ReadProblem {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ReadProblem::Io(error) => {
                let remedy = match error.kind() {
                    std::io::ErrorKind::NotFound => "check the path",
                    std::io::ErrorKind::PermissionDenied => "check its permissions",
                    _ => "check that the place can be used and try again",
                };
                write!(out, "{error}; {remedy}")
            }
            ReadProblem::Empty => out.write_str("it is empty; record it again"),
            ReadProblem::UnknownFormat => out.write_str(
                "it is in no format that is known here; give MCAP, a ROS 1 bag, a rosbag2 folder \
                 or database, CSV or JSON lines",
            ),
            ReadProblem::Malformed(problem) => out.write_str(problem),
        }
    }
}

impl std::error::Error for ReadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &self.problem {
            ReadProblem::Io(error) => Some(error),
            _ => None,
        }
    }
}
