//! One topic of a recording: named fields and their values over time, stored by rows.

use std::fmt;

/// What the values of a field mean.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FieldKind {
    /// A real number in the field's unit.
    Number,
    /// A truth value: 0 is false, 1 is true.
    Bool,
    /// One of the named values; the number stored is the index into this list.
    Enumeration(Vec<String>),
}

/// One column of a [`Channel`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// Name of the field, for example `hand_speed`; dots are allowed (`hand.x`).
    pub name: String,
    /// Unit of the values, for example `m/s`; `1` if dimensionless, empty if not applicable.
    pub unit: String,
    /// Coordinate frame in which the values are expressed, if they have one.
    pub frame: Option<String>,
    /// Whether the values are numbers, truth values or names.
    pub kind: FieldKind,
}

impl Field {
    /// A field of numbers in `unit` (`1` if dimensionless), without a frame.
    pub fn number(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Field {
            name: name.into(),
            unit: unit.into(),
            frame: None,
            kind: FieldKind::Number,
        }
    }

    /// A field of truth values.
    pub fn bool(name: impl Into<String>) -> Self {
        Field {
            name: name.into(),
            unit: String::new(),
            frame: None,
            kind: FieldKind::Bool,
        }
    }

    /// A field whose values are indices into `names`.
    pub fn enumeration<S: Into<String>>(
        name: impl Into<String>,
        names: impl IntoIterator<Item = S>,
    ) -> Self {
        let names = names.into_iter().map(Into::into).collect();
        Field {
            name: name.into(),
            unit: String::new(),
            frame: None,
            kind: FieldKind::Enumeration(names),
        }
    }

    /// The same field, expressed in the coordinate frame `frame`.
    #[must_use]
    pub fn in_frame(mut self, frame: impl Into<String>) -> Self {
        self.frame = Some(frame.into());
        self
    }

    /// The first name of an enumeration that stands in it before.
    fn repeated_name(&self) -> Option<&str> {
        let FieldKind::Enumeration(names) = &self.kind else {
            return None;
        };
        let mut repeated = names.iter().enumerate();
        let found = repeated.find(|(position, name)| names[..*position].contains(name));
        found.map(|(_, name)| name.as_str())
    }

    /// Whether `value` is one that this field can hold: NaN (missing), a finite number, 0 or 1
    /// for a truth value, or an index of a name.
    #[must_use]
    pub fn admits(&self, value: f64) -> bool {
        if value.is_nan() {
            return true;
        }
        match &self.kind {
            FieldKind::Number => value.is_finite(),
            FieldKind::Bool => value == 0.0 || value == 1.0,
            FieldKind::Enumeration(names) => {
                value >= 0.0 && value.fract() == 0.0 && value < names.len() as f64
            }
        }
    }

    /// What is said of `value` of topic `topic` if this field cannot hold it.
    pub(crate) fn bad_value(&self, topic: &str, value: f64) -> TraceError {
        let expected = match &self.kind {
            FieldKind::Number => "finite numbers".to_owned(),
            FieldKind::Bool => "0 for false and 1 for true".to_owned(),
            FieldKind::Enumeration(names) => {
                format!("the index of one of its {} names", names.len())
            }
        };
        TraceError::BadValue {
            topic: topic.to_owned(),
            field: self.name.clone(),
            value,
            expected,
        }
    }
}

/// A topic with its fields and everything recorded on it.
///
/// `values` holds one row of `fields.len()` numbers for each entry of `times_secs`. NaN marks a
/// missing value. Use [`Channel::push`], which keeps these rules; readers of a hand-made channel
/// can ask [`Channel::validate`].
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name of the topic; it begins with `/`, for example `/robot`.
    pub topic: String,
    /// The columns.
    pub fields: Vec<Field>,
    /// Time of each row in seconds of the recording's clock, finite and non-decreasing.
    pub times_secs: Vec<f64>,
    /// The rows one after another, `fields.len()` values for each time.
    pub values: Vec<f64>,
}

/// Why a row, a channel or a trace is not well-formed.
#[derive(Debug, Clone, PartialEq)]
pub enum TraceError {
    /// A row has another number of values than the channel has fields.
    RowLength {
        /// Topic of the channel.
        topic: String,
        /// Number of fields of the channel.
        expected: usize,
        /// Number of values that were given.
        found: usize,
    },
    /// A time is NaN or infinite.
    TimeNotFinite {
        /// Topic of the channel.
        topic: String,
        /// Row at which it happened, from 0.
        row: usize,
    },
    /// A time lies before the time of the row above it.
    TimeBackwards {
        /// Topic of the channel.
        topic: String,
        /// Time of the row above, in seconds.
        previous_secs: f64,
        /// The earlier time that was given after it, in seconds.
        time_secs: f64,
    },
    /// A value is not one that its field can hold.
    BadValue {
        /// Topic of the channel.
        topic: String,
        /// Name of the field.
        field: String,
        /// The value.
        value: f64,
        /// What the field can hold.
        expected: String,
    },
    /// A name of a topic or field is empty, malformed or used twice.
    BadName {
        /// The name.
        name: String,
        /// What is wrong with it.
        problem: &'static str,
    },
}

impl fmt::Display for TraceError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TraceError::RowLength {
                topic,
                expected,
                found,
            } => write!(
                out,
                "a row of topic {topic} has {found} values, but the topic has {expected} fields; \
                 give one value for each field, NaN where it is missing"
            ),
            TraceError::TimeNotFinite { topic, row } => write!(
                out,
                "the time of row {row} of topic {topic} is not a finite number of seconds; \
                 drop the row or give it a time"
            ),
            TraceError::TimeBackwards {
                topic,
                previous_secs,
                time_secs,
            } => write!(
                out,
                "topic {topic} goes back in time from {previous_secs} s to {time_secs} s; \
                 sort its rows by time"
            ),
            TraceError::BadValue {
                topic,
                field,
                value,
                expected,
            } => write!(
                out,
                "{topic}.{field} cannot hold {value}; it takes {expected}, or NaN where it is missing"
            ),
            TraceError::BadName { name, problem } => write!(out, "the name \"{name}\" {problem}"),
        }
    }
}

impl std::error::Error for TraceError {}

impl Channel {
    /// An empty channel.
    pub fn new(topic: impl Into<String>, fields: Vec<Field>) -> Self {
        Channel {
            topic: topic.into(),
            fields,
            times_secs: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.times_secs.len()
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.times_secs.is_empty()
    }

    /// Position of the field called `name`.
    #[must_use]
    pub fn field_index(&self, name: &str) -> Option<usize> {
        self.fields.iter().position(|field| field.name == name)
    }

    /// The values of row `row`, one for each field; empty if there is no such row.
    #[must_use]
    pub fn row(&self, row: usize) -> &[f64] {
        let width = self.fields.len();
        let start = row.checked_mul(width);
        let end = start.and_then(|start| start.checked_add(width));
        start
            .zip(end)
            .and_then(|(start, end)| self.values.get(start..end))
            .unwrap_or(&[])
    }

    /// Appends a row at `time_secs`. Costs no allocation beyond the amortised growth of the
    /// columns. On an error nothing is appended.
    ///
    /// # Errors
    /// [`TraceError`] if the number of values is not that of the fields, the time is not finite
    /// or lies before the last one, or a value is infinite or not one that its field can hold.
    pub fn push(&mut self, time_secs: f64, values: &[f64]) -> Result<(), TraceError> {
        if values.len() != self.fields.len() {
            return Err(TraceError::RowLength {
                topic: self.topic.clone(),
                expected: self.fields.len(),
                found: values.len(),
            });
        }
        let previous_secs = self.times_secs.last().copied();
        self.check_time(previous_secs, time_secs, self.len())?;
        self.check_row(values)?;
        self.times_secs.push(time_secs);
        self.values.extend_from_slice(values);
        Ok(())
    }

    fn check_time(
        &self,
        previous_secs: Option<f64>,
        time_secs: f64,
        row: usize,
    ) -> Result<(), TraceError> {
        if !time_secs.is_finite() {
            return Err(TraceError::TimeNotFinite {
                topic: self.topic.clone(),
                row,
            });
        }
        match previous_secs {
            Some(previous_secs) if time_secs < previous_secs => Err(TraceError::TimeBackwards {
                topic: self.topic.clone(),
                previous_secs,
                time_secs,
            }),
            _ => Ok(()),
        }
    }

    fn check_row(&self, values: &[f64]) -> Result<(), TraceError> {
        for (field, &value) in self.fields.iter().zip(values) {
            if !field.admits(value) {
                return Err(field.bad_value(&self.topic, value));
            }
        }
        Ok(())
    }

    /// Checks everything that [`Channel::push`] would have checked, and the names.
    ///
    /// # Errors
    /// The first [`TraceError`] found.
    pub fn validate(&self) -> Result<(), TraceError> {
        self.validate_names()?;
        let width = self.fields.len();
        if self.values.len() != self.times_secs.len() * width {
            let found = self
                .values
                .len()
                .checked_div(self.len())
                .unwrap_or(self.values.len());
            return Err(TraceError::RowLength {
                topic: self.topic.clone(),
                expected: width,
                found,
            });
        }
        let mut previous_secs = None;
        for (row, &time_secs) in self.times_secs.iter().enumerate() {
            self.check_time(previous_secs, time_secs, row)?;
            self.check_row(self.row(row))?;
            previous_secs = Some(time_secs);
        }
        Ok(())
    }

    fn validate_names(&self) -> Result<(), TraceError> {
        let bad = |name: &str, problem| {
            Err(TraceError::BadName {
                name: name.to_owned(),
                problem,
            })
        };
        if !self.topic.starts_with('/') || self.topic.len() < 2 {
            return bad(
                &self.topic,
                "is not a topic; topics begin with a slash, as in /robot",
            );
        }
        if self.fields.is_empty() {
            return bad(
                &self.topic,
                "is a topic without fields; give it at least one",
            );
        }
        for (index, field) in self.fields.iter().enumerate() {
            if field.name.is_empty() {
                return bad(
                    &self.topic,
                    "is a topic with a field without a name; name the field",
                );
            }
            if self.field_index(&field.name) != Some(index) {
                return bad(
                    &field.name,
                    "names two fields of one topic; rename one of them",
                );
            }
            if let Some(name) = field.repeated_name() {
                return bad(name, "is listed twice in one enumeration; remove one");
            }
        }
        Ok(())
    }
}
