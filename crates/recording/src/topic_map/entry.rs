//! One entry of a topic map.

use trace::{Field, FieldKind};

/// Where the values of an entry come from. Paths are written `/topic.path`.
#[derive(Debug, Clone, PartialEq)]
pub enum SignalSource {
    /// One value of a message.
    Value {
        /// Its path.
        from: String,
    },
    /// The Euclidean norm of several numbers of one message.
    Norm {
        /// Their paths.
        of: Vec<String>,
    },
    /// Three coordinates in a message, `x`, `y` and `z` below this path.
    Point {
        /// The path.
        of: String,
        /// The frame in which the point is wanted, if another than the recorded one.
        in_frame: Option<String>,
    },
    /// Three components of a free vector in a message; other frames only turn it.
    Vector {
        /// The path.
        of: String,
        /// The frame in which the vector is wanted, if another than the recorded one.
        in_frame: Option<String>,
    },
    /// Where the origin of a frame is.
    PositionOf {
        /// The frame.
        frame: String,
        /// From where it is seen.
        in_frame: String,
    },
    /// How a frame is turned.
    OrientationOf {
        /// The frame.
        frame: String,
        /// From where it is seen.
        in_frame: String,
    },
    /// How far the origins of two frames are from each other.
    DistanceBetween {
        /// The two frames.
        frames: [String; 2],
    },
    /// How fast the origin of a frame moves.
    SpeedOf {
        /// The frame.
        frame: String,
        /// From where it is seen.
        in_frame: String,
    },
}

/// What a signal's value is between two samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interpolation {
    /// That of the last sample.
    #[default]
    Hold,
    /// On the straight line between the two.
    Linear,
}

/// One entry: a signal, or several parts of one thing.
#[derive(Debug, Clone, PartialEq)]
pub struct MappedSignal {
    /// The key: `/topic.field`, or for entries with parts what their names begin with.
    pub name: String,
    /// The line of the map where the entry begins, from 1; 0 if it is of no file.
    pub line: usize,
    /// Where the values come from.
    pub source: SignalSource,
    /// The unit, if given.
    pub unit: Option<String>,
    /// The frame in which the values were recorded, if given.
    pub frame: Option<String>,
    /// What the values mean.
    pub kind: FieldKind,
    /// Numbers are multiplied by this,
    pub scale: f64,
    /// and then this is added.
    pub offset: f64,
    /// What counts between two samples.
    pub interpolation: Interpolation,
    /// How long a value counts, in seconds; for ever if not given.
    pub staleness_secs: Option<f64>,
}

impl MappedSignal {
    /// An entry that takes numbers as they are, without unit and frame.
    #[must_use]
    pub fn new(name: impl Into<String>, source: SignalSource) -> Self {
        MappedSignal {
            name: name.into(),
            line: 0,
            source,
            unit: None,
            frame: None,
            kind: FieldKind::Number,
            scale: 1.0,
            offset: 0.0,
            interpolation: Interpolation::Hold,
            staleness_secs: None,
        }
    }

    /// What is appended to the key for each part; one empty text if there are no parts.
    #[must_use]
    pub fn parts(&self) -> &'static [&'static str] {
        match self.source {
            SignalSource::Point { .. }
            | SignalSource::Vector { .. }
            | SignalSource::PositionOf { .. } => &[".x", ".y", ".z"],
            SignalSource::OrientationOf { .. } => &[".x", ".y", ".z", ".w"],
            _ => &[""],
        }
    }

    /// The names of the signals, `/topic.field`, one for each part.
    #[must_use]
    pub fn part_names(&self) -> Vec<String> {
        let parts = self.parts().iter();
        parts.map(|part| format!("{}{part}", self.name)).collect()
    }

    /// Topic and field of a signal's name: what is before and behind the first dot.
    #[must_use]
    pub(crate) fn split(name: &str) -> Option<(&str, &str)> {
        let (topic, field) = name.split_once('.')?;
        (topic.len() > 1 && topic.starts_with('/') && !field.is_empty()).then_some((topic, field))
    }

    /// The fields of the signals, one for each part, with unit, frame and kind.
    #[must_use]
    pub fn fields(&self) -> Vec<Field> {
        let field = |name: String| Field {
            name: MappedSignal::split(&name)
                .map_or("", |(_, field)| field)
                .to_owned(),
            unit: self.field_unit(),
            frame: self.field_frame(),
            kind: self.kind.clone(),
        };
        self.part_names().into_iter().map(field).collect()
    }

    fn field_unit(&self) -> String {
        let usual = match self.source {
            SignalSource::Point { .. }
            | SignalSource::PositionOf { .. }
            | SignalSource::DistanceBetween { .. } => "m",
            SignalSource::SpeedOf { .. } => "m/s",
            SignalSource::OrientationOf { .. } => "1",
            _ => "",
        };
        self.unit.clone().unwrap_or_else(|| usual.to_owned())
    }

    fn field_frame(&self) -> Option<String> {
        match &self.source {
            SignalSource::Point { in_frame, .. } | SignalSource::Vector { in_frame, .. } => {
                in_frame.clone().or_else(|| self.frame.clone())
            }
            SignalSource::PositionOf { in_frame, .. }
            | SignalSource::OrientationOf { in_frame, .. }
            | SignalSource::SpeedOf { in_frame, .. } => Some(in_frame.clone()),
            _ => self.frame.clone(),
        }
    }

    /// Whether `/tf` is needed.
    #[must_use]
    pub fn needs_frames(&self) -> bool {
        match &self.source {
            SignalSource::Value { .. } | SignalSource::Norm { .. } => false,
            SignalSource::Point { in_frame, .. } | SignalSource::Vector { in_frame, .. } => {
                in_frame.is_some() && *in_frame != self.frame
            }
            _ => true,
        }
    }
}
