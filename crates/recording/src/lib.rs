#![doc = include_str!("../README.md")]
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
//! | tables in Parquet, written and read | [`ParquetWriter`], [`ParquetTable`] |
//! | traces as MCAP files, lossless and reproducible to the byte | [`write_mcap`], [`read_mcap`] |
//!
//! | format | topics | order | checked | what is recovered of a damaged file |
//! |---|---|---|---|---|
//! | MCAP | CDR, ROS 1, JSON, protobuf | of time | by its checksums | all but damaged chunks |
//! | others | see [`Format`] | [`Reader::in_time_order`] | no | [`Reader::losses`] |
//!
//! # Speed
//! Two cores of a server, release build, `cargo bench -p corroborate-recording --bench mcap`: joint states of
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

pub use parquet::{
    Cell, ParquetColumn, ParquetError, ParquetReadError, ParquetRows, ParquetTable, ParquetType,
    ParquetWriter,
};
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
