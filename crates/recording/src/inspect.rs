//! What is in a recording: topics, rates, gaps, clocks, frames; and a draft of its topic map.
//!
//! The recording is read once, in memory that does not grow with it. Every message of the topics
//! whose encoding is known is walked through against its schema, so that a topic whose messages do
//! not fit is found here and not in the middle of a judgement.
//!
//! * Rate: (n - 1) / (last - first) in log time.
//! * Jitter: the standard deviation of the periods between neighbouring messages.
//! * A gap: a period longer than `gap_factor` (5) times the middle period, which is known to 3 %.
//!
//! # Example
//! ```
//! use recording::{InspectOptions, OpenOptions, Ros2Recording, Ros2Value, inspect};
//! let mut recording = Ros2Recording::new()?;
//! let odometry = recording.add_topic("/speed", "geometry_msgs/msg/TwistStamped")?;
//! for step in 0..100_i64 {
//!     recording.write(odometry, 20_000_000 * step, &[("twist.linear.x", Ros2Value::Number(0.5))])?;
//! }
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("run.mcap");
//! std::fs::write(&path, recording.finish()?)?;
//!
//! let found = inspect(&path, &OpenOptions::default(), &InspectOptions::default())?;
//! let speed = &found.topics[0];
//! assert_eq!((speed.messages, speed.gaps), (100, 0));
//! assert!((speed.rate_hz.unwrap_or(0.0) - 50.0).abs() < 1e-9);
//! assert!(found.draft_map().contains("from = \"/speed.twist.linear.x\"\nunit = \"m/s\""));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod collect;
mod draft;
mod fields;
mod periods;
mod text;
mod units;

use std::path::Path;

use serde::Serialize;

use crate::open::Format;
use crate::reader::{OpenOptions, ReadError, Reader};
use crate::storage::{Compressed, StoredFile};

pub use fields::{FieldSummary, FieldValue};
pub(crate) use units::usual_unit;

/// What counts as conspicuous.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InspectOptions {
    /// A period this many times as long as the middle one is a gap.
    pub gap_factor: f64,
}

impl Default for InspectOptions {
    fn default() -> Self {
        InspectOptions { gap_factor: 5.0 }
    }
}

/// What is in a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inspection {
    /// The topics, in order of their names.
    pub topics: Vec<TopicInspection>,
    /// How each file is stored.
    pub files: Vec<StoredFile>,
    /// Number of messages.
    pub messages: u64,
    /// Log time of the first message, in nanoseconds.
    pub first_nanos: Option<i64>,
    /// Log time of the last message, in nanoseconds.
    pub last_nanos: Option<i64>,
    /// The frames that transforms connect.
    pub frames: Vec<FrameInspection>,
    /// Transforms that cannot be used: what is wrong, and how often.
    pub frame_problems: Vec<(String, u64)>,
    /// What could not be read, each with its place.
    pub losses: Vec<String>,
    /// Whether everything that was recorded could be read.
    pub complete: bool,
    /// Why reading ended early, if it did.
    pub error: Option<String>,
}

/// One topic of a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TopicInspection {
    /// Its name.
    pub name: String,
    /// The type of its messages.
    pub type_name: String,
    /// How they are encoded.
    pub encoding: String,
    /// Number of messages.
    pub messages: u64,
    /// Bytes of all messages.
    pub bytes: u64,
    /// Log time of the first message, in nanoseconds.
    pub first_nanos: Option<i64>,
    /// Log time of the last message, in nanoseconds.
    pub last_nanos: Option<i64>,
    /// Messages a second, on average; `None` for fewer than two times.
    pub rate_hz: Option<f64>,
    /// The middle period in seconds, to within 3 %.
    pub median_period_secs: Option<f64>,
    /// The standard deviation of the periods in seconds.
    pub jitter_secs: Option<f64>,
    /// The longest period in seconds.
    pub longest_gap_secs: Option<f64>,
    /// When that began, in nanoseconds of log time.
    pub longest_gap_at_nanos: Option<i64>,
    /// How many periods are gaps.
    pub gaps: u64,
    /// How many messages have an earlier log time than one before them.
    pub out_of_order: u64,
    /// Least and greatest log time minus stamp, in seconds, if the messages have stamps.
    pub behind_stamp_secs: Option<(f64, f64)>,
    /// How many messages have the stamp 0.
    pub unstamped: u64,
    /// Why the messages cannot be decoded at all, if so.
    pub undecodable: Option<String>,
    /// How many messages do not fit their schema, and what is wrong with the first of them.
    pub misfits: u64,
    /// What is wrong with the first message that does not fit.
    pub first_misfit: Option<String>,
    /// The fields with values of their own, as far as the first message shows them.
    pub fields: Vec<FieldSummary>,
}

/// A frame and its parent.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FrameInspection {
    /// The frame.
    pub frame: String,
    /// Its last parent.
    pub parent: String,
    /// Whether it is static.
    pub is_static: bool,
}

/// Reads the recording at `path` once and says what is in it. Damage is part of the answer.
///
/// # Errors
/// [`ReadError`] if it cannot be opened at all.
pub fn inspect(
    path: &Path,
    open: &OpenOptions,
    options: &InspectOptions,
) -> Result<Inspection, ReadError> {
    let mut found = inspect_reader(crate::open(path, open)?.as_mut(), options);
    if crate::detect(path)? == Format::Compressed {
        for file in &mut found.files {
            *file = std::mem::take(file).compressed_by(Compressed::File, "zstd");
        }
    }
    Ok(found)
}

/// As [`inspect`], for what is open already.
pub fn inspect_reader(reader: &mut dyn Reader, options: &InspectOptions) -> Inspection {
    collect::collect(reader, options)
}

impl Inspection {
    /// The time from the first to the last message in seconds.
    #[must_use]
    pub fn duration_secs(&self) -> Option<f64> {
        let (first, last) = (self.first_nanos?, self.last_nanos?);
        Some(last.saturating_sub(first) as f64 / 1e9)
    }

    /// A topic map in which every number, truth value and text of the recording is an entry, with
    /// comments where something has to be filled in. What is not needed can be deleted.
    #[must_use]
    pub fn draft_map(&self) -> String {
        draft::draft_map(self)
    }
}

#[cfg(test)]
mod tests;
