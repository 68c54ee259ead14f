//! Motion capture in a scene's file.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use stimulus::Distribution;

use super::{key_of, number_within, within, zero};
use crate::bench::ScenarioError;

/// A recording of a person's motion that is replayed: where points of the body were. `x_m`, `y_m` and `heading_rad` of the person
/// say where the recording's origin lies and where its `forward` points.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Capture {
    /// BVH, C3D or a table (CSV), by its ending, relative to the scene's file.
    pub file: String,
    /// The unit of positions. C3D files say it themselves.
    pub unit: Option<CaptureUnit>,
    /// The file's axis that points up.
    pub up: CaptureAxis,
    /// The file's axis that becomes the person's x axis, forwards.
    pub forward: CaptureAxis,
    /// Which names of the file are which points of the body: `head`, and `left_` and `right_` with `shoulder`, `elbow`, `hand`, `hip` and
    /// `foot`. Of several names the mean.
    pub points: BTreeMap<String, CaptureNames>,
    /// The column of a table that has the times, in seconds.
    #[serde(default = "secs")]
    pub time_column: String,
    /// Where in the recording the replay begins.
    #[serde(default)]
    pub from_secs: f64,
    /// Where it ends; with the recording if left out.
    pub until_secs: Option<f64>,
    /// When the replay begins.
    #[serde(default = "zero")]
    pub begins_secs: Distribution,
    /// How fast it is replayed: 2 is twice as fast.
    #[serde(default = "once")]
    pub rate: Distribution,
    /// The longest time for which a point may be unseen; in between it moves on a straight line.
    #[serde(default = "blink")]
    pub longest_gap_secs: f64,
}

/// The name of a point in a file, or the names of several.
#[derive(Debug, Clone, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(untagged)]
pub enum CaptureNames {
    /// One.
    One(String),
    /// Several, of which the mean counts.
    Mean(Vec<String>),
}

impl CaptureNames {
    /// All of them.
    #[must_use]
    pub fn all(&self) -> &[String] {
        match self {
            Self::One(name) => std::slice::from_ref(name),
            Self::Mean(names) => names,
        }
    }
}

/// A unit of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Deserialize)]
#[allow(missing_docs, reason = "the names say it")]
pub enum CaptureUnit {
    #[serde(rename = "m")]
    Metre,
    #[serde(rename = "cm")]
    Centimetre,
    #[serde(rename = "mm")]
    Millimetre,
    #[serde(rename = "in")]
    Inch,
}

impl CaptureUnit {
    /// In metres.
    #[must_use]
    pub fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 1e-2,
            Self::Millimetre => 1e-3,
            Self::Inch => 0.0254,
        }
    }
}

/// An axis of a file, or against it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Deserialize)]
#[allow(missing_docs, reason = "the names say it")]
pub enum CaptureAxis {
    #[serde(rename = "x")]
    X,
    #[serde(rename = "y")]
    Y,
    #[serde(rename = "z")]
    Z,
    #[serde(rename = "-x")]
    AgainstX,
    #[serde(rename = "-y")]
    AgainstY,
    #[serde(rename = "-z")]
    AgainstZ,
}

impl CaptureAxis {
    /// Its direction in the file's frame.
    #[must_use]
    pub fn direction(self) -> [f64; 3] {
        match self {
            Self::X => [1.0, 0.0, 0.0],
            Self::Y => [0.0, 1.0, 0.0],
            Self::Z => [0.0, 0.0, 1.0],
            Self::AgainstX => [-1.0, 0.0, 0.0],
            Self::AgainstY => [0.0, -1.0, 0.0],
            Self::AgainstZ => [0.0, 0.0, -1.0],
        }
    }
}

fn secs() -> String {
    "time_secs".to_owned()
}
fn once() -> Distribution {
    Distribution::Constant(1.0)
}
fn blink() -> f64 {
    0.1
}

impl Capture {
    /// What is wrong with it, everything at once.
    pub(super) fn check(&self, person: &str) -> Vec<ScenarioError> {
        let key = |field: &str| key_of("person", person, &format!("capture.{field}"));
        let mut wrong = Vec::new();
        let (up, forward) = (self.up.direction(), self.forward.direction());
        if (0..3).any(|axis| up[axis] != 0.0 && forward[axis] != 0.0) {
            let problem = "is along the same axis as `up`";
            wrong.push(ScenarioError::value(&key("forward"), problem));
        }
        let known = crate::scene::capture::POINTS;
        for (point, names) in &self.points {
            let key = key(&format!("points.{point}"));
            if !known.contains(&point.as_str()) {
                let problem = format!("is not a point of the body; there are {}", known.join(", "));
                wrong.push(ScenarioError::value(&key, &problem));
            }
            if names.all().is_empty() {
                wrong.push(ScenarioError::value(&key, "names nothing"));
            }
        }
        wrong.extend(within(&key("begins_secs"), &self.begins_secs, 0.0, 1e6).err());
        wrong.extend(within(&key("rate"), &self.rate, 1e-2, 100.0).err());
        for (field, value) in [
            ("from_secs", Some(self.from_secs)),
            ("until_secs", self.until_secs),
            ("longest_gap_secs", Some(self.longest_gap_secs)),
        ] {
            let value = value.unwrap_or(0.0);
            wrong.extend(number_within(&key(field), value, 0.0, 1e6).err());
        }
        wrong
    }
}
