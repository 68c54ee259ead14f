//! From the bytes of one topic's messages to rows.

use trace::FieldKind;

use super::bind::{BindError, ColumnPlan, RowPlan, TopicPlan};
use crate::decode::{Extractor, FieldPath, Value, ValueKind};
use crate::reader::TopicInfo;
use crate::transform::TransformBuffer;

/// Where a message holds its stamp.
const STAMP_PATHS: [&str; 2] = ["header.stamp.sec", "header.stamp.nanosec"];
/// Where a message names the frame of its coordinates.
const FRAME_PATH: &str = "header.frame_id";

/// Makes rows of the messages of one topic.
#[derive(Debug)]
pub(super) struct TopicDecoder {
    numbers: Extractor,
    raw: Vec<f64>,
    texts: Option<Extractor>,
    values: Vec<Value>,
    /// Places in `raw` of the stamp's seconds and nanoseconds.
    stamp: Option<[usize; 2]>,
    rows: Vec<Row>,
    /// How many texts were found that are none of the names listed for them.
    unlisted: usize,
}

/// A row as it is made.
#[derive(Debug)]
pub(super) struct Row {
    pub source: usize,
    pub values: Vec<f64>,
    /// Whether the last message has none of the elements that are picked by a key: it is then none
    /// of this row's. Several publishers can share a topic, each with elements of its own.
    pub is_absent: bool,
    /// The places of those elements among the numbers, if all columns are such.
    keyed: Vec<usize>,
    columns: Vec<Column>,
}

/// Indices are into the numbers or the texts that are extracted.
#[derive(Debug)]
enum Column {
    Number {
        at: usize,
        scale: f64,
        offset: f64,
    },
    Bool {
        at: usize,
    },
    /// A number below `count`, which a text has become already.
    Name {
        at: usize,
        count: usize,
    },
    Norm {
        at: Vec<usize>,
        scale: f64,
        offset: f64,
    },
    Fixed(f64),
    Frame {
        at: usize,
    },
}

/// What was in a message beside its rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Decoded {
    /// The stamp in nanoseconds, if the message has one.
    pub stamp_nanos: Option<i64>,
    /// A value that is none of the names that were listed for it.
    pub unknown_name: Option<String>,
}

/// The paths to be extracted, each once, and the names that texts at some of them are.
#[derive(Default)]
struct Paths {
    paths: Vec<FieldPath>,
    names: Vec<Option<Vec<String>>>,
}

impl Paths {
    fn add(&mut self, text: &str, names: Option<&Vec<String>>) -> Result<usize, String> {
        let path = FieldPath::parse(text).map_err(|error| error.to_string())?;
        let mut known = self.paths.iter().zip(&self.names);
        let found = known.position(|(other, others)| *other == path && others.as_ref() == names);
        Ok(found.unwrap_or_else(|| {
            self.paths.push(path);
            self.names.push(names.cloned());
            self.paths.len() - 1
        }))
    }

    fn extractor(self, info: &TopicInfo) -> Result<Extractor, Vec<BindError>> {
        let made = Extractor::new(info, &self.paths);
        let mut extractor = made.map_err(|error| {
            vec![BindError {
                signal: info.name.clone(),
                line: 0,
                message: error.to_string(),
                is_lacking: false,
            }]
        })?;
        for (index, names) in self.names.into_iter().enumerate() {
            if let Some(names) = names {
                extractor.set_names(index, names);
            }
        }
        Ok(extractor)
    }
}

impl TopicDecoder {
    /// A decoder for `plan` on the topic `info`. Frames get their numbers from `frames`.
    pub fn new(
        info: &TopicInfo,
        plan: &TopicPlan,
        frames: &mut TransformBuffer,
    ) -> Result<Self, Vec<BindError>> {
        let (mut numbers, mut texts) = (Paths::default(), Paths::default());
        let mut errors = Vec::new();
        let mut rows = Vec::with_capacity(plan.rows.len());
        for row in &plan.rows {
            let made = Row::new(info, row, &mut numbers, &mut texts, frames);
            rows.extend(made.map_err(|found| errors.extend(found)));
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        let has_stamp = STAMP_PATHS.iter().all(|path| kind_of(info, path).is_ok());
        let stamp = if has_stamp {
            let [secs, nanos] = STAMP_PATHS.map(|path| numbers.add(path, None).ok());
            secs.zip(nanos).map(|(secs, nanos)| [secs, nanos])
        } else {
            None
        };
        let texts = if texts.paths.is_empty() {
            None
        } else {
            Some(texts.extractor(info)?)
        };
        Ok(TopicDecoder {
            raw: vec![f64::NAN; numbers.paths.len()],
            numbers: numbers.extractor(info)?,
            texts,
            values: Vec::new(),
            stamp,
            rows,
            unlisted: 0,
        })
    }

    /// The rows of the message that was decoded last.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Decodes a message into [`TopicDecoder::rows`].
    pub fn decode(&mut self, data: &[u8], frames: &mut TransformBuffer) -> Result<Decoded, String> {
        self.numbers
            .extract(data, &mut self.raw)
            .map_err(|error| error.to_string())?;
        if let Some(texts) = &mut self.texts {
            self.values = texts
                .extract_values(data)
                .map_err(|error| error.to_string())?;
        }
        let mut decoded = Decoded::default();
        if let Some([secs, nanos]) = self.stamp {
            let (secs, nanos) = (self.raw[secs], self.raw[nanos]);
            if !secs.is_nan() && !nanos.is_nan() {
                // Both are whole numbers of 32 bits, which doubles hold.
                let stamp = (secs as i64)
                    .saturating_mul(1_000_000_000)
                    .saturating_add(nanos as i64);
                decoded.stamp_nanos = Some(stamp);
            }
        }
        for row in &mut self.rows {
            for (column, value) in row.columns.iter().zip(&mut row.values) {
                *value = column.value(&self.raw, &self.values, frames, &mut decoded);
            }
            let numbers = &self.numbers;
            row.is_absent =
                !row.keyed.is_empty() && row.keyed.iter().all(|at| numbers.is_missing(*at));
        }
        self.note_unlisted(&mut decoded);
        Ok(decoded)
    }
}

impl TopicDecoder {
    /// Notes a text that is none of its names, if one was found for the first time.
    fn note_unlisted(&mut self, decoded: &mut Decoded) {
        let unlisted = self.numbers.unlisted();
        if unlisted.len() > self.unlisted {
            self.unlisted = unlisted.len();
            let texts: Vec<&str> = unlisted.iter().map(|(_, text)| text.as_str()).collect();
            decoded.unknown_name = Some(texts.join(", "));
        }
    }
}

impl Row {
    fn new(
        info: &TopicInfo,
        plan: &RowPlan,
        numbers: &mut Paths,
        texts: &mut Paths,
        frames: &mut TransformBuffer,
    ) -> Result<Self, Vec<BindError>> {
        let mut errors = Vec::new();
        let mut columns = Vec::with_capacity(plan.columns.len());
        for (column, (signal, line)) in plan.columns.iter().zip(&plan.asked_by) {
            let made = Column::new(info, column, numbers, texts, frames);
            columns.extend(made.map_err(|message| {
                errors.push(BindError {
                    signal: signal.clone(),
                    line: *line,
                    message,
                    is_lacking: column.paths().any(|path| kind_of(info, path).is_err()),
                });
            }));
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        Ok(Row {
            source: plan.source,
            values: vec![f64::NAN; columns.len()],
            is_absent: false,
            keyed: keyed(&columns, numbers),
            columns,
        })
    }
}

impl Column {
    fn new(
        info: &TopicInfo,
        plan: &ColumnPlan,
        numbers: &mut Paths,
        texts: &mut Paths,
        frames: &mut TransformBuffer,
    ) -> Result<Self, String> {
        Ok(match plan {
            ColumnPlan::Number {
                path,
                scale,
                offset,
            } => Column::Number {
                at: numbers.add(number_at(info, path)?, None)?,
                scale: *scale,
                offset: *offset,
            },
            ColumnPlan::Bool { path } => Column::Bool {
                at: numbers.add(number_at(info, path)?, None)?,
            },
            ColumnPlan::Name { path, names } => {
                kind_of(info, path)?;
                Column::Name {
                    at: numbers.add(path, Some(names))?,
                    count: names.len(),
                }
            }
            ColumnPlan::Norm {
                paths,
                scale,
                offset,
            } => {
                let mut at = Vec::with_capacity(paths.len());
                for path in paths {
                    at.push(numbers.add(number_at(info, path)?, None)?);
                }
                Column::Norm {
                    at,
                    scale: *scale,
                    offset: *offset,
                }
            }
            ColumnPlan::Frame { name: Some(name) } => {
                Column::Fixed(f64::from(frames.frame(name).number()))
            }
            ColumnPlan::Frame { name: None } => {
                kind_of(info, FRAME_PATH).map_err(|_| {
                    "the messages have no header that names their frame; give it as frame = \"...\""
                })?;
                Column::Frame {
                    at: texts.add(FRAME_PATH, None)?,
                }
            }
        })
    }

    fn value(
        &self,
        raw: &[f64],
        values: &[Value],
        frames: &mut TransformBuffer,
        decoded: &mut Decoded,
    ) -> f64 {
        match self {
            Column::Number { at, scale, offset } => scaled(raw[*at], *scale, *offset),
            Column::Bool { at } => match raw[*at] {
                value if value.is_nan() => f64::NAN,
                value => f64::from(u8::from(value != 0.0)),
            },
            Column::Name { at, count } => {
                let value = raw[*at];
                let fits = value.fract() == 0.0 && (0.0..*count as f64).contains(&value);
                if !fits && !value.is_nan() {
                    decoded.unknown_name = Some(value.to_string());
                }
                if fits { value } else { f64::NAN }
            }
            Column::Norm { at, scale, offset } => {
                let norm = at
                    .iter()
                    .fold(0.0_f64, |norm, index| norm.hypot(raw[*index]));
                // The norm of an infinite and a missing part is not known either.
                let missing = at.iter().any(|index| raw[*index].is_nan());
                scaled(if missing { f64::NAN } else { norm }, *scale, *offset)
            }
            Column::Fixed(value) => *value,
            Column::Frame { at } => match values.get(*at) {
                Some(Value::Text(name)) if !name.is_empty() => {
                    f64::from(frames.frame(name).number())
                }
                _ => f64::NAN,
            },
        }
    }
}

/// The places of what all columns pick by keys; none if a column is not picked so.
fn keyed(columns: &[Column], numbers: &Paths) -> Vec<usize> {
    let mut places = Vec::new();
    for column in columns {
        match column {
            Column::Number { at, .. } | Column::Bool { at } | Column::Name { at, .. } => {
                places.push(*at);
            }
            Column::Norm { at, .. } => places.extend(at),
            Column::Fixed(_) | Column::Frame { .. } => {}
        }
    }
    if places.iter().all(|at| numbers.paths[*at].is_keyed()) {
        places
    } else {
        Vec::new()
    }
}

/// scale * value + offset; values that need neither stay as they are, also -0.
fn scaled(value: f64, scale: f64, offset: f64) -> f64 {
    if scale == 1.0 && offset == 0.0 {
        value
    } else {
        scale * value + offset
    }
}

/// What kind of values stand at a path of a topic's messages; for text an enumeration without
/// names.
pub(super) fn kind_of(info: &TopicInfo, path: &str) -> Result<FieldKind, String> {
    let path = FieldPath::parse(path).map_err(|error| error.to_string())?;
    let extractor = Extractor::new(info, std::slice::from_ref(&path));
    let extractor = extractor.map_err(|error| format!("{}: {error}", info.name))?;
    Ok(match extractor.kinds().first() {
        Some(ValueKind::Bool) => FieldKind::Bool,
        Some(ValueKind::Text) => FieldKind::Enumeration(Vec::new()),
        _ => FieldKind::Number,
    })
}

/// `path`, if a number or truth value stands there.
fn number_at<'p>(info: &TopicInfo, path: &'p str) -> Result<&'p str, String> {
    match kind_of(info, path)? {
        FieldKind::Enumeration(_) => Err(format!(
            "{path} of {} is text; list its values with values = [...]",
            info.name
        )),
        _ => Ok(path),
    }
}
