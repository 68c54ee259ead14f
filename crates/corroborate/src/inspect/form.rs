//! The form of an inspection as JSON, for its schema. A test holds what is
//! printed against it.
#![allow(dead_code, reason = "only its schema is used")]

use schemars::JsonSchema;

/// What is in a recording.
#[derive(JsonSchema)]
pub struct InspectionForm {
    /// The topics, in order of their names.
    topics: Vec<TopicForm>,
    /// How each file is stored.
    files: Vec<StoredFileForm>,
    /// Number of messages.
    messages: u64,
    /// Log time of the first message, in nanoseconds.
    first_nanos: Option<i64>,
    /// Log time of the last message, in nanoseconds.
    last_nanos: Option<i64>,
    /// The frames that transforms connect.
    frames: Vec<FrameForm>,
    /// Transforms that cannot be used: what is wrong, and how often.
    frame_problems: Vec<Vec<TextOrCount>>,
    /// What could not be read, each with its place.
    losses: Vec<String>,
    /// Whether everything that was recorded could be read.
    complete: bool,
    /// Why reading ended early, if it did.
    error: Option<String>,
}

/// How one file of a recording is stored.
#[derive(JsonSchema)]
struct StoredFileForm {
    /// Its name within the recording's folder; empty if the recording is one file.
    name: String,
    /// Its format.
    format: String,
    /// What of it is compressed.
    compressed: CompressedForm,
    /// By which methods (zstd, lz4, bz2); empty if nothing is compressed.
    methods: Vec<String>,
    /// How many chunks it has; none if its format has none.
    chunks: Option<u64>,
    /// How many of them are compressed.
    compressed_chunks: Option<u64>,
    /// What its index is worth.
    index: IndexForm,
}

/// What of a file is compressed by itself.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
enum CompressedForm {
    /// Nothing.
    Nothing,
    /// The file as a whole.
    File,
    /// Each chunk, or some of them.
    Chunks,
    /// Each message, or some of them.
    Messages,
}

/// What an index of a file is worth.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
enum IndexForm {
    /// The format has none.
    NotInFormat,
    /// It is there and fits the file.
    Sound,
    /// It is there without a checksum, so it is not believed.
    Unguarded,
    /// It is not there.
    Missing,
    /// It is there, but damaged.
    Damaged,
}

/// One topic of a recording.
#[derive(JsonSchema)]
struct TopicForm {
    /// Its name.
    name: String,
    /// The type of its messages.
    type_name: String,
    /// How they are encoded.
    encoding: String,
    /// Number of messages.
    messages: u64,
    /// Bytes of all messages.
    bytes: u64,
    /// Log time of the first message, in nanoseconds.
    first_nanos: Option<i64>,
    /// Log time of the last message, in nanoseconds.
    last_nanos: Option<i64>,
    /// Messages a second, on average; `None` for fewer than two times.
    rate_hz: Option<f64>,
    /// The middle period in seconds, to within 3 %.
    median_period_secs: Option<f64>,
    /// The standard deviation of the periods in seconds.
    jitter_secs: Option<f64>,
    /// The longest period in seconds.
    longest_gap_secs: Option<f64>,
    /// When that began, in nanoseconds of log time.
    longest_gap_at_nanos: Option<i64>,
    /// How many periods are gaps.
    gaps: u64,
    /// How many messages have an earlier log time than one before them.
    out_of_order: u64,
    /// Least and greatest log time minus stamp, in seconds, if the messages have stamps.
    behind_stamp_secs: Option<Vec<f64>>,
    /// How many messages have the stamp 0.
    unstamped: u64,
    /// Why the messages cannot be decoded at all, if so.
    undecodable: Option<String>,
    /// How many messages do not fit their schema, and what is wrong with the first of them.
    misfits: u64,
    /// What is wrong with the first message that does not fit.
    first_misfit: Option<String>,
    /// The fields with values of their own, as far as the first message shows them.
    fields: Vec<FieldSummaryForm>,
}

/// A frame and its parent.
#[derive(JsonSchema)]
struct FrameForm {
    /// The frame.
    frame: String,
    /// Its last parent.
    parent: String,
    /// Whether it is static.
    is_static: bool,
}

/// A field of a topic's messages.
#[derive(JsonSchema)]
struct FieldSummaryForm {
    /// Its path, as a topic map writes it.
    path: String,
    /// The unit that the type fixes; empty if it fixes none.
    unit: String,
    /// What the first message holds there.
    first: FieldValueForm,
    /// How many elements the array has that this stands for, if it is too long to be listed; the
    /// path is then that of its first element.
    elements: Option<u64>,
}

/// A value of a message, for show.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
enum FieldValueForm {
    /// A number.
    Number(f64),
    /// A truth value.
    Bool(bool),
    /// A text.
    Text(String),
    /// Nothing is there.
    Missing,
}

/// What is wrong, or how often.
#[derive(JsonSchema)]
#[schemars(untagged)]
enum TextOrCount {
    /// What is wrong.
    Text(String),
    /// How often.
    Count(u64),
}
