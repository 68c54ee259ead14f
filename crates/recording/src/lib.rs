//! Recordings of robots, read and written.
//!
//! | what | how |
//! |---|---|
//! | traces as MCAP files, lossless and reproducible to the byte | [`write_mcap`], [`read_mcap`] |

mod decode;
mod mcap;
mod reader;
mod schema;
mod trace_file;

pub use decode::{DecodeError, Extractor, FieldPath, PathError, Value, ValueKind};
pub use reader::{
    Encoding, Loss, OpenOptions, RawMessage, ReadError, ReadProblem, Reader, TopicId, TopicInfo,
};
pub use schema::{
    Constant, Dialect, MessageField, MessageType, Primitive, ProtoField, ProtoKind, ProtoMessage,
    ProtobufSchema, Schema, SchemaError, Type, parse_idl, parse_msg,
};
pub use trace_file::{
    ReadOutcome, TraceReadError, TraceReadProblem, TraceWriteError, from_mcap, is_trace_file,
    read_mcap, to_mcap,
    write_mcap,
};

mod ros2_writer;
mod transform;

pub use ros2_writer::{
    Ros2Recording, Ros2Source, Ros2Topic, Ros2TopicId, Ros2TraceOptions, Ros2TraceOutcome,
    Ros2Value, Ros2WriteError, ros2_recording_of, ros2_type_names,
};
pub use transform::{FrameId, LookupError, Transform, TransformBuffer, TransformProblem};

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

pub use signals::{BindError, Moment, SignalStream, StreamError, StreamNote, StreamNoteKind};
pub use inspect::{
    FieldSummary, FieldValue, FrameInspection, InspectOptions, Inspection, TopicInspection, inspect,
    inspect_reader,
};

#[cfg(test)]
mod kept;
