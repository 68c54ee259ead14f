//! Between which values the numbers of a recording lie.

use recording::{Extractor, FieldPath, FieldValue, Inspection, OpenOptions, ReadError, TopicInfo};
use std::path::Path;

/// How many numbers are looked at.
const MOST_FIELDS: usize = 64;

/// The last parts of paths whose numbers say when or in which order, not what.
const NOT_SIGNALS: [&str; 14] = [
    "time",
    "stamp",
    "sec",
    "secs",
    "nsec",
    "nsecs",
    "nanosec",
    "seq",
    "id",
    "index",
    "timestamp",
    "time_ms",
    "time_s",
    "t",
];

/// A number of a recording.
pub(super) struct Seen {
    pub(super) topic: String,
    pub(super) path: String,
    /// Empty if the recording does not say it.
    pub(super) unit: String,
    /// The least and the greatest finite value; infinite if there was none.
    pub(super) low: f64,
    pub(super) high: f64,
}

/// The numbers of a topic, and how they are read.
struct Topic {
    fields: Vec<Seen>,
    extractor: Extractor,
}

/// The ranges of the first numbers that can be signals, in the recording's order.
pub(super) fn of(
    file: &Path,
    opening: &OpenOptions,
    found: &Inspection,
) -> Result<Vec<Seen>, ReadError> {
    let mut reader = recording::open(file, opening)?;
    let mut left = MOST_FIELDS;
    let infos = reader.topics().to_vec();
    let mut topics: Vec<Option<Topic>> = infos
        .iter()
        .map(|info| topic(info, found, &mut left))
        .collect();
    let mut values = Vec::new();
    // Damage ends the reading; what was seen until then is a range, too.
    while let Ok(Some(message)) = reader.next() {
        if let Some(Some(topic)) = topics.get_mut(message.topic.index()) {
            values.resize(topic.fields.len(), f64::NAN);
            if topic.extractor.extract(message.data, &mut values).is_ok() {
                topic.take(&values);
            }
        }
    }
    Ok(topics
        .into_iter()
        .flatten()
        .flat_map(|topic| topic.fields)
        .collect())
}

/// What of a topic is looked at, if anything.
fn topic(info: &TopicInfo, found: &Inspection, left: &mut usize) -> Option<Topic> {
    let inspected = found.topics.iter().find(|topic| topic.name == info.name)?;
    if matches!(
        info.name.as_str(),
        "/tf" | "/tf_static" | "/clock" | "/rosout"
    ) {
        return None;
    }
    let is_signal = |path: &str| {
        let last = path.rsplit('.').next().unwrap_or(path).to_lowercase();
        !NOT_SIGNALS.contains(&last.as_str())
            && !path.contains("covariance")
            && !path.starts_with("header.")
    };
    let fields: Vec<Seen> = inspected
        .fields
        .iter()
        .filter(|field| {
            matches!(field.first, FieldValue::Number(_))
                && field.elements.is_none()
                && is_signal(&field.path)
        })
        .take(*left)
        .map(|field| Seen {
            topic: info.name.clone(),
            path: field.path.clone(),
            unit: field.unit.clone(),
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
        })
        .collect();
    let paths: Option<Vec<FieldPath>> = fields
        .iter()
        .map(|field| FieldPath::parse(&field.path).ok())
        .collect();
    let extractor = Extractor::new(info, &paths?).ok()?;
    *left -= fields.len();
    (!fields.is_empty()).then_some(Topic { fields, extractor })
}

impl Topic {
    fn take(&mut self, values: &[f64]) {
        for (field, value) in self.fields.iter_mut().zip(values) {
            if value.is_finite() {
                field.low = field.low.min(*value);
                field.high = field.high.max(*value);
            }
        }
    }
}
