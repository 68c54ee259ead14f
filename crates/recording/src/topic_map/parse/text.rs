//! A topic map as it is written, before its parts are checked against each other.

use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

/// An entry as it is written.
#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EntryText {
    /// The field of a topic, for example `/odom.twist.twist.linear.x`.
    #[schemars(with = "Option<String>")]
    pub(super) from: Option<Spanned<String>>,
    /// Fields of which the Euclidean norm is taken.
    #[schemars(with = "Option<OneOrMore>")]
    pub(super) norm: Option<Spanned<OneOrMore>>,
    /// Three fields as a point.
    #[schemars(with = "Option<String>")]
    pub(super) point: Option<Spanned<String>>,
    /// Three fields as a vector.
    #[schemars(with = "Option<String>")]
    pub(super) vector: Option<Spanned<String>>,
    /// The position of a frame of the transform tree.
    #[schemars(with = "Option<String>")]
    pub(super) position_of: Option<Spanned<String>>,
    /// The orientation of a frame of the transform tree.
    #[schemars(with = "Option<String>")]
    pub(super) orientation_of: Option<Spanned<String>>,
    /// The distance between two frames of the transform tree.
    #[schemars(with = "Option<[String; 2]>")]
    pub(super) distance_between: Option<Spanned<[String; 2]>>,
    /// The speed of a frame of the transform tree.
    #[schemars(with = "Option<String>")]
    pub(super) speed_of: Option<Spanned<String>>,
    /// The frame in which the value is given.
    #[schemars(with = "Option<String>")]
    pub(super) in_frame: Option<Spanned<String>>,
    /// The frame in which the recording has a point or vector, where its message does not say it.
    #[schemars(with = "Option<String>")]
    pub(super) frame: Option<Spanned<String>>,
    /// The unit in which the recording has the number.
    #[schemars(with = "Option<String>")]
    pub(super) unit: Option<Spanned<String>>,
    /// What the values are: numbers, or true and false.
    #[schemars(with = "Option<KindText>")]
    pub(super) kind: Option<Spanned<KindText>>,
    /// The labels of an enumeration, in the order of their numbers.
    #[schemars(with = "Option<Vec<String>>")]
    pub(super) values: Option<Spanned<Vec<String>>>,
    /// What the number is multiplied with.
    #[schemars(with = "Option<f64>")]
    pub(super) scale: Option<Spanned<f64>>,
    /// What is added after that.
    #[schemars(with = "Option<f64>")]
    pub(super) offset: Option<Spanned<f64>>,
    /// What the value is between samples.
    #[schemars(with = "Option<InterpolationText>")]
    pub(super) interpolation: Option<Spanned<InterpolationText>>,
    /// How long a value holds without a new message, for example `"0.5 s"`.
    #[schemars(with = "Option<String>")]
    pub(super) staleness: Option<Spanned<String>>,
}

#[derive(JsonSchema, Deserialize)]
#[serde(untagged)]
pub(super) enum OneOrMore {
    One(String),
    More(Vec<String>),
}

#[derive(JsonSchema, Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "snake_case")]
pub(super) enum KindText {
    Number,
    Bool,
}

#[derive(JsonSchema, Deserialize, Clone, Copy)]
#[serde(rename_all = "snake_case")]
pub(super) enum InterpolationText {
    Hold,
    Linear,
}

/// `[time]` as it is written.
#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TimeText {
    /// Which time of a message counts.
    pub(super) from: Option<TimeSourceText>,
    /// How far messages may be out of order.
    #[schemars(with = "Option<String>")]
    pub(super) reorder: Option<Spanned<String>>,
    /// How long to wait for a transform.
    #[schemars(with = "Option<String>")]
    pub(super) frame_wait: Option<Spanned<String>>,
    /// How long transforms are remembered.
    #[schemars(with = "Option<String>")]
    pub(super) frame_history: Option<Spanned<String>>,
    /// Over how long a gap transforms are interpolated.
    #[schemars(with = "Option<String>")]
    pub(super) frame_gap: Option<Spanned<String>>,
}

#[derive(JsonSchema, Deserialize, Clone, Copy)]
#[serde(rename_all = "snake_case")]
pub(super) enum TimeSourceText {
    Log,
    Publish,
    Header,
    Clock,
}

/// The whole file: a table for each signal, and `time`. Read table by table, so that every mistake is told at once; this is its
/// form for the schema.
#[derive(JsonSchema)]
pub(super) struct TopicMapText {
    /// Which time of a message counts, and how long to wait for others.
    #[allow(dead_code, reason = "the form of the file; read table by table")]
    time: Option<TimeText>,
    /// A signal: where the recording has it.
    #[allow(dead_code, reason = "the form of the file; read table by table")]
    #[schemars(flatten)]
    signals: std::collections::BTreeMap<String, EntryText>,
}
