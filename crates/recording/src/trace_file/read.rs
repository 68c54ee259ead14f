//! Reading; the layout is described in [`super`].

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use mcap::McapError;
use mcap::records::{Channel as ChannelRecord, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::message::Message;
use super::schema::{SchemaText, Shape};
use super::{FORMAT, METADATA_RECORD, TRACE_RECORD, secs_of_nanos};
use trace::Trace;
use trace::{Channel, Field, TraceError};
use trace::{FileError, read_file};

/// The largest record or chunk that is read, in bytes. It bounds what a damaged length can cost.
const RECORD_LIMIT_BYTES: usize = 512 * 1024 * 1024;

/// What could be read of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadOutcome {
    /// The trace, up to the damage if there is any.
    pub trace: Trace,
    /// Whether the trace is the whole of a run: the file is undamaged, and the trace in it had
    /// not been cut short before it was written. The same as `trace.complete`.
    pub complete: bool,
    /// What is lost, and why, if the file is damaged.
    pub lost: Option<String>,
}

/// A recording cannot be read.
#[derive(Debug)]
pub struct TraceReadError {
    /// The file, if it was read from one.
    pub path: Option<PathBuf>,
    /// What is wrong.
    pub problem: TraceReadProblem,
}

/// What is wrong with a recording.
#[derive(Debug)]
pub enum TraceReadProblem {
    /// The file cannot be opened or read.
    File(FileError),
    /// There are no bytes.
    Empty,
    /// It does not begin as MCAP files do.
    NotMcap,
    /// It is damaged before the first topic.
    NothingLeft(String),
    /// It was written by a later version.
    Version(String),
    /// A topic has messages in an encoding that is not readable yet.
    Encoding {
        /// The topic.
        topic: String,
        /// The encoding.
        encoding: String,
    },
    /// A topic has messages in JSON, but without a description of its fields.
    Undescribed {
        /// The topic.
        topic: String,
    },
    /// A message does not fit its topic's description.
    Message {
        /// The topic.
        topic: String,
        /// Which of its messages, from 0.
        row: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// A message belongs to no topic.
    Stray,
    /// The contents do not make a trace.
    Trace(TraceError),
}

impl fmt::Display for TraceReadError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let TraceReadProblem::File(error) = &self.problem {
            return error.fmt(out);
        }
        match &self.path {
            Some(path) => write!(out, "cannot read the recording {}: ", path.display())?,
            None => out.write_str("cannot read the recording: ")?,
        }
        self.problem.fmt(out)
    }
}

impl fmt::Display for TraceReadProblem {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TraceReadProblem::File(error) => error.fmt(out),
            TraceReadProblem::Empty => out.write_str("it is empty; record it again"),
            TraceReadProblem::NotMcap => {
                out.write_str("it is not an MCAP file; give a recording that ends in .mcap")
            }
            TraceReadProblem::NothingLeft(problem) => write!(
                out,
                "{problem}, before its first topic; copy it again from where it was made"
            ),
            TraceReadProblem::Version(version) => write!(
                out,
                "it has layout version \"{version}\", and this program knows version {FORMAT}; \
                 use the program that wrote it, or a later one"
            ),
            TraceReadProblem::Encoding { topic, encoding } => write!(
                out,
                "encoding \"{encoding}\" of topic {topic} is not readable yet; convert the \
                 recording to JSON messages or to a CSV table"
            ),
            TraceReadProblem::Undescribed { topic } => write!(
                out,
                "topic {topic} has no description of its fields (\"x-corroborate\" in its JSON \
                 schema), and such topics are not readable yet; convert the recording to a CSV table"
            ),
            TraceReadProblem::Message {
                topic,
                row,
                problem,
            } => write!(
                out,
                "message {row} of topic {topic} does not fit the topic's schema: {problem}; \
                 record it again"
            ),
            TraceReadProblem::Stray => {
                out.write_str("a message belongs to no topic; record it again")
            }
            TraceReadProblem::Trace(error) => error.fmt(out),
        }
    }
}

impl std::error::Error for TraceReadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &self.problem {
            TraceReadProblem::File(error) => Some(error),
            TraceReadProblem::Trace(error) => Some(error),
            _ => None,
        }
    }
}

/// Reads the recording at `path`, or what can be recovered of it.
///
/// # Errors
/// [`TraceReadError`] if there is nothing to recover, or it is not a recording that can be read.
pub fn read_mcap(path: &Path) -> Result<ReadOutcome, TraceReadError> {
    let error = |problem| TraceReadError {
        path: Some(path.to_owned()),
        problem,
    };
    let bytes = read_file(path).map_err(|source| error(TraceReadProblem::File(source)))?;
    read(&bytes).map_err(error)
}

/// Reads a recording from the bytes of an MCAP file.
///
/// # Errors
/// [`TraceReadError`] if there is nothing to recover, or it is not a recording that can be read.
pub fn from_mcap(bytes: &[u8]) -> Result<ReadOutcome, TraceReadError> {
    read(bytes).map_err(|problem| TraceReadError {
        path: None,
        problem,
    })
}

fn read(bytes: &[u8]) -> Result<ReadOutcome, TraceReadProblem> {
    if bytes.is_empty() {
        return Err(TraceReadProblem::Empty);
    }
    if !bytes.starts_with(mcap::MAGIC) {
        return Err(TraceReadProblem::NotMcap);
    }
    let mut builder = Builder::default();
    let lost = match feed(bytes, &mut builder) {
        Ok(()) => None,
        Err(Stop::Damage(problem)) => Some(problem),
        Err(Stop::Problem(problem)) => return Err(problem),
    };
    let mut trace = builder.trace;
    if let Some(problem) = lost {
        if trace.channels.is_empty() {
            return Err(TraceReadProblem::NothingLeft(problem));
        }
        trace.complete = false;
        let lost = Some(match trace.end_secs() {
            Some(end_secs) => format!("{problem}; what was recorded after {end_secs} s is lost"),
            None => format!("{problem}; all messages are lost"),
        });
        return Ok(ReadOutcome {
            trace,
            complete: false,
            lost,
        });
    }
    Ok(ReadOutcome {
        complete: trace.complete,
        trace,
        lost: None,
    })
}

/// Why reading ends early.
enum Stop {
    /// The bytes are damaged; what came before is good.
    Damage(String),
    /// The contents are not what can be read.
    Problem(TraceReadProblem),
}

impl From<TraceReadProblem> for Stop {
    fn from(problem: TraceReadProblem) -> Self {
        Stop::Problem(problem)
    }
}

impl From<McapError> for Stop {
    fn from(error: McapError) -> Self {
        Stop::Damage(match error {
            McapError::UnexpectedEof | McapError::UnexpectedEoc => "it is cut short".to_owned(),
            error => format!("it is damaged ({error})"),
        })
    }
}

/// Takes every record of `bytes` to `builder`.
fn feed(bytes: &[u8], builder: &mut Builder) -> Result<(), Stop> {
    let options = LinearReaderOptions::default()
        .with_prevalidate_chunk_crcs(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true)
        .with_record_length_limit(RECORD_LIMIT_BYTES);
    let mut reader = LinearReader::new_with_options(options);
    let mut rest = bytes;
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(wanted) => {
                let length = wanted.min(rest.len());
                reader.insert(length).copy_from_slice(&rest[..length]);
                reader.notify_read(length);
                rest = &rest[length..];
            }
            LinearReadEvent::Record { opcode, data } => {
                if matches!(
                    opcode,
                    op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA
                ) {
                    builder.take(mcap::parse_record(opcode, data)?)?;
                }
            }
        }
    }
    Ok(())
}

/// A trace as it comes in.
#[derive(Default)]
struct Builder {
    trace: Trace,
    schemas: BTreeMap<u16, Vec<u8>>,
    topics: BTreeMap<u16, Topic>,
}

/// A channel of the file and where it goes.
struct Topic {
    record: ChannelRecord,
    channel: usize,
    shape: Shape,
    row: Vec<f64>,
}

impl Builder {
    fn take(&mut self, record: Record<'_>) -> Result<(), Stop> {
        match record {
            Record::Schema { header, data } => {
                self.schemas.insert(header.id, data.into_owned());
                Ok(())
            }
            Record::Channel(record) => self.take_channel(record),
            Record::Message { header, data } => {
                self.take_message(header.channel_id, header.log_time, &data)
            }
            Record::Metadata(record) => self.take_metadata(record),
            _ => Ok(()),
        }
    }

    fn take_metadata(&mut self, record: mcap::records::Metadata) -> Result<(), Stop> {
        if record.name == METADATA_RECORD {
            self.trace.metadata = record.metadata;
        } else if record.name == TRACE_RECORD {
            match record.metadata.get("format") {
                Some(version) if version == FORMAT => {}
                version => {
                    let version = version.cloned().unwrap_or_default();
                    return Err(TraceReadProblem::Version(version).into());
                }
            }
            self.trace.complete = record
                .metadata
                .get("complete")
                .is_some_and(|it| it == "true");
        }
        Ok(())
    }

    fn take_channel(&mut self, record: ChannelRecord) -> Result<(), Stop> {
        if let Some(known) = self.topics.get(&record.id) {
            // The summary at the end repeats the channels.
            if known.record == record {
                return Ok(());
            }
            return Err(TraceReadProblem::Trace(TraceError::BadName {
                name: record.topic,
                problem: "is described twice, in different ways; record it again",
            })
            .into());
        }
        let fields = self.fields_of(&record)?;
        let shape = Shape::of(&fields);
        let row = vec![f64::NAN; fields.len()];
        let topic = record.topic.clone();
        let channel = self
            .trace
            .add_channel(topic, fields)
            .map_err(TraceReadProblem::Trace)?;
        self.topics.insert(
            record.id,
            Topic {
                record,
                channel,
                shape,
                row,
            },
        );
        Ok(())
    }

    /// The fields of a channel as its schema describes them.
    fn fields_of(&self, record: &ChannelRecord) -> Result<Vec<Field>, TraceReadProblem> {
        let topic = record.topic.clone();
        if record.message_encoding != "json" {
            let encoding = record.message_encoding.clone();
            return Err(TraceReadProblem::Encoding { topic, encoding });
        }
        let schema = self
            .schemas
            .get(&record.schema_id)
            .map(Vec::as_slice)
            .unwrap_or_default();
        match serde_json::from_slice::<SchemaText>(schema) {
            Ok(schema) => Ok(schema
                .description
                .fields
                .into_iter()
                .map(Field::from)
                .collect()),
            Err(_) => Err(TraceReadProblem::Undescribed { topic }),
        }
    }

    fn take_message(&mut self, id: u16, nanos: u64, data: &[u8]) -> Result<(), Stop> {
        let Some(topic) = self.topics.get_mut(&id) else {
            return Err(TraceReadProblem::Stray.into());
        };
        let channel: &mut Channel = &mut self.trace.channels[topic.channel];
        topic.row.fill(f64::NAN);
        let message = Message {
            fields: &channel.fields,
            shape: &topic.shape,
            row: &mut topic.row,
        };
        let exact_secs = message
            .read(data)
            .map_err(|error| TraceReadProblem::Message {
                topic: channel.topic.clone(),
                row: channel.len(),
                problem: error.to_string(),
            })?;
        let time_secs = exact_secs.unwrap_or_else(|| secs_of_nanos(nanos));
        channel
            .push(time_secs, &topic.row)
            .map_err(TraceReadProblem::Trace)?;
        Ok(())
    }
}
