//! Recordings of robots, read and written.
//!
//! A recording is a stream of messages of topics, in one of several formats. Messages are decoded
//! by the schema that the recording itself holds, and only where it is asked for; nothing has to be
//! generated or installed beforehand.
//!
//! | what | how |
//! |---|---|
//! | open a recording of any format | [`open()`], [`open_bytes`], [`detect`] |
//! | its topics and raw messages, in bounded memory | [`Reader`] |
//! | its compression, chunks and index | [`Reader::storage`], [`StoredFile`] |
//! | places in messages, as text | [`FieldPath`] |
//! | the numbers at these places | [`Extractor`] |
//! | what a schema says | [`Schema`], [`parse_msg`], [`parse_idl`], [`ProtobufSchema`] |
//! | several recordings as trials | [`trials()`] |
//! | signals from topics: units, frames, times | [`TopicMap`], [`SignalStream`] |
//! | frames | [`TransformBuffer`] |
//! | traces as recordings in ROS 2 types | [`Ros2Recording`] |
//! | raw messages as they come, kept | [`RawRecording`], [`TypeDefinitions`] |
//! | moving shapes as a recording for Foxglove | [`SceneFile`] |
//! | verdicts as a recording, beside the original | [`VerdictFile`] |
//! | traces as MCAP files, lossless and reproducible to the byte | [`write_mcap`], [`read_mcap`] |
//!
//! | format | topics | order | checked | what is recovered of a damaged file |
//! |---|---|---|---|---|
//! | MCAP | CDR, ROS 1, JSON, protobuf | of time | by its checksums | all but damaged chunks |
//! | others | see [`Format`] | [`Reader::in_time_order`] | no | [`Reader::losses`] |
//!
//! # Example
//! ```
//! use recording::{Extractor, FieldPath, Format, OpenOptions, open_bytes};
//!
//! # let mut trace = trace::Trace::new();
//! # let robot = trace.add_channel("/robot", vec![
//! #     trace::Field::enumeration("state", ["carry", "release"]),
//! #     trace::Field::number("hand.x", "m"),
//! # ])?;
//! # trace.channels[robot].push(0.0, &[0.0, 0.5])?;
//! # trace.channels[robot].push(0.1, &[1.0, 0.25])?;
//! # let bytes: Vec<u8> = recording::to_mcap(&trace)?;
//! // The bytes of an MCAP file; `open` takes a path.
//! let mut reader = open_bytes(bytes, Format::Mcap, &OpenOptions::default())?;
//!
//! // What is asked of a topic is worked out once.
//! let robot = reader.topics().iter().find(|topic| topic.name == "/robot").ok_or("no topic")?.clone();
//! let paths = [FieldPath::parse("hand.x")?, FieldPath::parse("state")?];
//! let mut extractor = Extractor::new(&robot, &paths)?;
//! extractor.set_names(1, vec!["carry".into(), "release".into()]);
//!
//! // Then each message gives its numbers, NaN for what is missing.
//! reader.select(&|topic| topic.id == robot.id);
//! let mut values = [0.0; 2];
//! let mut rows = Vec::new();
//! while let Some(message) = reader.next()? {
//!     extractor.extract(message.data, &mut values)?;
//!     rows.push((message.log_nanos, values));
//! }
//! assert_eq!(rows, [(0, [0.5, 0.0]), (100_000_000, [0.25, 1.0])]);
//!
//! // Nothing was lost, and every byte was guarded by a checksum.
//! assert!(reader.complete() && reader.checked());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Speed
//! Two cores of a server, release build, `cargo bench -p recording --bench mcap`: joint states of
//! seven joints at 1 kHz, an IMU and transforms, seven values read of them, 390 bytes each, 3 minutes
//! (270,000 messages): 4.2 million messages a second from an MCAP file without compression, 2.4
//! million with zstd. Chunks are read, decompressed and checked on a second thread; on one core it
//! was 3.0 and 1.6 million. On files of this kind and the same machine the Python library `rosbags`
//! 0.11 gives 0.15 and 0.11 million raw messages a second, without reading values.

mod decode;
mod mcap;
mod reader;
mod schema;
mod storage;
mod trace_file;

pub use decode::{DecodeError, Extractor, FieldPath, PathError, Value, ValueKind};
pub use reader::{
    Encoding, Loss, OpenOptions, RawMessage, ReadError, ReadProblem, Reader, TopicId, TopicInfo,
};
pub use schema::{
    Constant, Dialect, MessageField, MessageType, Primitive, ProtoField, ProtoKind, ProtoMessage,
    ProtobufSchema, Schema, SchemaError, Type, parse_idl, parse_msg,
};
pub use storage::{Compressed, IndexState, StoredFile};
pub use trace_file::{
    ReadOutcome, TraceReadError, TraceReadProblem, TraceWriteError, from_mcap, is_trace_file,
    read_mcap, to_mcap, write_mcap,
};

mod ros2_writer;
mod transform;

pub use ros2_writer::{
    Ros2Encoder, Ros2Recording, Ros2Source, Ros2Topic, Ros2TopicId, Ros2TraceOptions,
    Ros2TraceOutcome, Ros2Value, Ros2WriteError, ros2_recording_of, ros2_type_names,
};
pub use transform::{FrameId, LookupError, Transform, TransformBuffer, TransformProblem};

mod parquet;
mod raw_writer;
mod scene_file;
mod type_definitions;

pub use parquet::{Cell, ParquetColumn, ParquetError, ParquetType, ParquetWriter};
pub use raw_writer::{RawRecording, RawTopicId, RawWriteError};
pub use scene_file::{SceneFile, SceneForm, ScenePose, SceneShape};
pub use type_definitions::TypeDefinitions;

mod clock;
mod topic_map;
mod verdict_file;

pub use clock::{TimeSettings, TimeSource};
pub use topic_map::{Interpolation, MappedSignal, SignalSource, TopicMap, TopicMapError};
pub use verdict_file::{ShownRequirement, ShownVerdict, VerdictFile};

mod csv_rows;
mod json_lines;
mod open;
mod ros1_bag;
mod rosbag2;
mod trials;

pub use csv_rows::row_time::{TimeUnit, TimeUnitError};
pub use open::{Format, detect, open, open_bytes};
pub use trials::{SkippedPath, TrialPath, Trials, trials};

mod inspect;
mod signals;

pub use inspect::{
    FieldSummary, FieldValue, FrameInspection, InspectOptions, Inspection, TopicInspection,
    inspect, inspect_reader,
};
pub use signals::{
    BindError, Moment, Polled, SignalStream, StreamError, StreamNote, StreamNoteKind,
};

#[cfg(test)]
mod kept;
