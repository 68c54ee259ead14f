//! A topic map as it is written, before its parts are checked against each other.

use serde::Deserialize;
use toml::Spanned;

/// An entry as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EntryText {
    pub(super) from: Option<Spanned<String>>,
    pub(super) norm: Option<Spanned<OneOrMore>>,
    pub(super) point: Option<Spanned<String>>,
    pub(super) vector: Option<Spanned<String>>,
    pub(super) position_of: Option<Spanned<String>>,
    pub(super) orientation_of: Option<Spanned<String>>,
    pub(super) distance_between: Option<Spanned<[String; 2]>>,
    pub(super) speed_of: Option<Spanned<String>>,
    pub(super) in_frame: Option<Spanned<String>>,
    pub(super) frame: Option<Spanned<String>>,
    pub(super) unit: Option<Spanned<String>>,
    pub(super) kind: Option<Spanned<KindText>>,
    pub(super) values: Option<Spanned<Vec<String>>>,
    pub(super) scale: Option<Spanned<f64>>,
    pub(super) offset: Option<Spanned<f64>>,
    pub(super) interpolation: Option<Spanned<InterpolationText>>,
    pub(super) staleness: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum OneOrMore {
    One(String),
    More(Vec<String>),
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "snake_case")]
pub(super) enum KindText {
    Number,
    Bool,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "snake_case")]
pub(super) enum InterpolationText {
    Hold,
    Linear,
}

/// `[time]` as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TimeText {
    pub(super) from: Option<TimeSourceText>,
    pub(super) reorder: Option<Spanned<String>>,
    pub(super) frame_wait: Option<Spanned<String>>,
    pub(super) frame_history: Option<Spanned<String>>,
    pub(super) frame_gap: Option<Spanned<String>>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "snake_case")]
pub(super) enum TimeSourceText {
    Log,
    Publish,
    Header,
    Clock,
}
