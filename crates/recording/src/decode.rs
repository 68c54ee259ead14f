//! From the bytes of a message to the values that are asked for, and no others.

mod cell;
mod json;
mod path;
mod plan;
mod protobuf;
mod skip;
mod walk;

pub use cell::Value;
pub use path::{FieldPath, PathError};

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;

use crate::reader::{Encoding, TopicInfo};
use crate::schema::{Primitive, Schema};
use cell::{Cell, Cells};
use json::JsonPlan;
use plan::{Plan, plan};
use protobuf::ProtoPlan;
use skip::Layout;
use walk::Walker;

/// What kind of value stands at a place, as far as the schema tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ValueKind {
    /// True or false.
    Bool,
    /// A whole number.
    Integer {
        /// Its size.
        bits: u8,
        /// Whether it may be negative.
        signed: bool,
    },
    /// A floating-point number.
    Float {
        /// Its size.
        bits: u8,
    },
    /// A text.
    Text,
    /// A number that stands for a name.
    Enumeration,
    /// The number of elements of an array.
    Length,
    /// The schema does not tell (JSON).
    Unknown,
}

impl ValueKind {
    fn of(primitive: Primitive) -> Self {
        let bits = (8 * primitive.bytes()) as u8;
        match primitive {
            Primitive::Bool => ValueKind::Bool,
            Primitive::Float32 | Primitive::Float64 => ValueKind::Float { bits },
            Primitive::Int8 | Primitive::Int16 | Primitive::Int32 | Primitive::Int64 => {
                ValueKind::Integer { bits, signed: true }
            }
            _ => ValueKind::Integer {
                bits,
                signed: false,
            },
        }
    }

    /// Whether values may be beyond what a double holds exactly (whole numbers above 2^53). They
    /// then become the nearest double; nanoseconds since 1970 lose up to 128 ns.
    #[must_use]
    pub fn may_round(self) -> bool {
        matches!(self, ValueKind::Integer { bits: 64, .. })
    }
}

impl fmt::Display for ValueKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ValueKind::Bool => out.write_str("a truth value"),
            ValueKind::Integer { bits, signed } => {
                let sign = if *signed { "a signed" } else { "an unsigned" };
                write!(out, "{sign} whole number of {bits} bits")
            }
            ValueKind::Float { bits } => write!(out, "a floating-point number of {bits} bits"),
            ValueKind::Text => out.write_str("a text"),
            ValueKind::Enumeration => out.write_str("an enumeration"),
            ValueKind::Length => out.write_str("a length"),
            ValueKind::Unknown => out.write_str("a value"),
        }
    }
}

/// A message does not fit its topic's schema.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DecodeError {
    /// Where in the message, in bytes from its beginning.
    pub offset_in_message: usize,
    /// What is wrong, as a clause.
    pub message: Cow<'static, str>,
}

impl fmt::Display for DecodeError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "byte {} of the message: {}",
            self.offset_in_message, self.message
        )
    }
}

impl std::error::Error for DecodeError {}

/// Reads certain places of a topic's messages.
///
/// Whatever the path finds becomes a double: whole numbers of 64 bits beyond 2^53 the nearest one
/// ([`ValueKind::may_round`]), truth values 0 or 1, texts the position of the text among the names
/// given to [`Extractor::set_names`]. NaN stands for what is absent, and for a text that is not
/// among the names; such texts are collected in [`Extractor::unlisted`].
///
/// # Guarantee
/// A message that ends before all that is asked for is an error, never a number. Bytes that are not
/// asked for are only passed over; whether the whole message fits its schema tells
/// [`Extractor::verify`].
#[derive(Debug, Clone)]
pub struct Extractor {
    paths: Vec<FieldPath>,
    names: Vec<Option<Vec<String>>>,
    unlisted: BTreeSet<(usize, String)>,
    kinds: Vec<ValueKind>,
    decoder: Decoder,
    cells: Cells,
}

#[derive(Debug, Clone)]
enum Decoder {
    /// The schema, and the plan for CDR2, which is only made when a message needs it.
    Cdr(Arc<Schema>, Box<Plan>, Option<Box<Plan>>),
    Packed(Box<Plan>),
    Json(JsonPlan),
    Protobuf(ProtoPlan),
}

/// How many texts that are not among the names are remembered.
const UNLISTED_LIMIT: usize = 64;

impl Extractor {
    /// Prepares reading `paths` from messages of `topic`.
    ///
    /// # Errors
    /// [`PathError`] if a path does not fit the topic's schema, or the topic cannot be decoded.
    pub fn new(topic: &TopicInfo, paths: &[FieldPath]) -> Result<Self, PathError> {
        let (decoder, kinds) = decoder(topic, paths)?;
        let mut made = Extractor {
            names: vec![None; paths.len()],
            paths: paths.to_vec(),
            unlisted: BTreeSet::new(),
            kinds,
            decoder,
            cells: Cells::default(),
        };
        let (slots, places, marks) = match &made.decoder {
            Decoder::Cdr(_, plan, _) | Decoder::Packed(plan) => {
                (plan.slots, plan.places, plan.marks)
            }
            Decoder::Json(plan) => (plan.slots, 0, 0),
            Decoder::Protobuf(plan) => (plan.slots, 0, 0),
        };
        made.cells.cells = vec![Cell::Missing; slots];
        made.cells.places = vec![None; places];
        made.cells.marks = vec![0; marks];
        Ok(made)
    }

    /// The paths, in the order of the values.
    #[must_use]
    pub fn paths(&self) -> &[FieldPath] {
        &self.paths
    }

    /// What stands at each path, as far as the schema tells.
    #[must_use]
    pub fn kinds(&self) -> &[ValueKind] {
        &self.kinds
    }

    /// Says that texts at path `index` stand for numbers: each name for its position. Without a
    /// path of that index nothing happens.
    pub fn set_names(&mut self, index: usize, names: Vec<String>) {
        if let Some(entry) = self.names.get_mut(index) {
            *entry = Some(names);
        }
    }

    /// Texts that were found, but are not among the names given, with the index of their path; the
    /// first 64 of them.
    #[must_use]
    pub fn unlisted(&self) -> &BTreeSet<(usize, String)> {
        &self.unlisted
    }

    /// Reads the values of a message: one for each path, NaN where there is none.
    ///
    /// # Errors
    /// [`DecodeError`] if the message does not fit its schema; `out` is then unspecified. So it is
    /// if `out` has another length than there are paths.
    pub fn extract(&mut self, data: &[u8], out: &mut [f64]) -> Result<(), DecodeError> {
        if out.len() != self.paths.len() {
            return Err(DecodeError {
                offset_in_message: 0,
                message: "the place for the values has another length than there are paths".into(),
            });
        }
        self.fill(data)?;
        for (index, value) in out.iter_mut().enumerate() {
            *value = match self.cells.cells[index] {
                Cell::Number(number) => number,
                Cell::Bool(truth) => f64::from(u8::from(truth)),
                Cell::Missing => f64::NAN,
                Cell::Text { .. } => position(&self.cells, &self.names, &mut self.unlisted, index),
            };
        }
        Ok(())
    }

    /// Whether the last message has nothing at the path with this number.
    #[must_use]
    pub(crate) fn is_missing(&self, path: usize) -> bool {
        matches!(self.cells.cells.get(path), Some(Cell::Missing) | None)
    }

    /// Reads the values of a message as they are, texts as texts.
    ///
    /// # Errors
    /// [`DecodeError`] if the message does not fit its schema.
    pub fn extract_values(&mut self, data: &[u8]) -> Result<Vec<Value>, DecodeError> {
        self.fill(data)?;
        let slots = 0..self.paths.len();
        Ok(slots.map(|slot| self.cells.value(slot)).collect())
    }

    /// Walks through a whole message and checks that it ends where its schema says, up to the
    /// padding of CDR. A recording whose schema is that of another version of the type is found
    /// this way. Self-describing messages are only read.
    ///
    /// # Errors
    /// [`DecodeError`] if the message does not fit its schema.
    pub fn verify(&mut self, data: &[u8]) -> Result<(), DecodeError> {
        self.cells.reset();
        let (end, padding) = match &self.decoder {
            Decoder::Json(_) | Decoder::Protobuf(_) => return self.fill(data),
            Decoder::Packed(plan) => (packed(plan, data, &mut self.cells, true)?, 0),
            Decoder::Cdr(..) => (self.cdr(data, true)?, 7),
        };
        if data.len() > end + padding {
            return Err(DecodeError {
                offset_in_message: end,
                message: format!(
                    "the schema ends here, but the message has {} bytes more, so it is of \
                     another version of its type",
                    data.len() - end
                )
                .into(),
            });
        }
        Ok(())
    }

    fn fill(&mut self, data: &[u8]) -> Result<(), DecodeError> {
        self.cells.reset();
        match &mut self.decoder {
            Decoder::Packed(plan) => packed(plan, data, &mut self.cells, false).map(drop),
            Decoder::Json(plan) => plan.read(data, &mut self.cells),
            Decoder::Protobuf(plan) => plan.read(data, &mut self.cells),
            Decoder::Cdr(..) => self.cdr(data, false).map(drop),
        }
    }

    /// Reads a message in CDR, whose header of four bytes tells its layout and byte order.
    fn cdr(&mut self, data: &[u8], needs_end: bool) -> Result<usize, DecodeError> {
        let Decoder::Cdr(schema, first, second) = &mut self.decoder else {
            return Ok(0);
        };
        let error = |message: Cow<'static, str>| DecodeError {
            offset_in_message: 0,
            message,
        };
        let Some((header, body)) = data.split_first_chunk::<4>() else {
            return Err(error("a message in CDR begins with four bytes".into()));
        };
        let (layout, big_endian) = match header[..2] {
            [0, 0] => (Layout::Cdr1, true),
            [0, 1] => (Layout::Cdr1, false),
            [0, 6] => (Layout::Cdr2, true),
            [0, 7] => (Layout::Cdr2, false),
            [a, b] => {
                let problem = format!(
                    "the encoding {a:#04x} {b:#04x} of CDR is not supported (only plain CDR and \
                     plain CDR2, as ROS 2 uses them)"
                );
                return Err(error(problem.into()));
            }
            _ => return Err(error("a message in CDR begins with four bytes".into())),
        };
        let plan = match (layout, &**schema) {
            (Layout::Cdr2, Schema::Struct(message)) => {
                if second.is_none() {
                    let made = plan(message, &self.paths, layout);
                    *second = Some(Box::new(made.map_err(|e| error(e.to_string().into()))?));
                }
                second.as_ref().unwrap_or(first)
            }
            _ => first,
        };
        let (header_bytes, cells) = (4, &mut self.cells);
        let end = if big_endian {
            let walker = Walker::<true> {
                data: body,
                header_bytes,
                layout,
            };
            walker.structure(&plan.root, 0, cells, needs_end)
        } else {
            let walker = Walker::<false> {
                data: body,
                header_bytes,
                layout,
            };
            walker.structure(&plan.root, 0, cells, needs_end)
        };
        Ok(end? + header_bytes)
    }
}

fn packed(
    plan: &Plan,
    data: &[u8],
    cells: &mut Cells,
    needs_end: bool,
) -> Result<usize, DecodeError> {
    let walker = Walker::<false> {
        data,
        header_bytes: 0,
        layout: Layout::Packed,
    };
    walker.structure(&plan.root, 0, cells, needs_end)
}

/// The number that a text stands for, or NaN.
fn position(
    cells: &Cells,
    names: &[Option<Vec<String>>],
    unlisted: &mut BTreeSet<(usize, String)>,
    index: usize,
) -> f64 {
    let Some(text) = cells.text(index) else {
        return f64::NAN;
    };
    let names = names[index].as_deref().unwrap_or_default();
    match names.iter().position(|name| name.as_bytes() == text) {
        Some(position) => position as f64,
        None => {
            if unlisted.len() < UNLISTED_LIMIT {
                let text = String::from_utf8_lossy(text).into_owned();
                unlisted.insert((index, text));
            }
            f64::NAN
        }
    }
}

fn decoder(topic: &TopicInfo, paths: &[FieldPath]) -> Result<(Decoder, Vec<ValueKind>), PathError> {
    let refused = |message: String| PathError {
        path: paths.first().map(FieldPath::to_string).unwrap_or_default(),
        message,
    };
    match (&topic.encoding, &*topic.schema) {
        (_, Schema::Unknown { reason }) => Err(refused(format!(
            "the messages of {} cannot be decoded: {reason}",
            topic.name
        ))),
        (Encoding::Cdr, Schema::Struct(message)) => {
            let plan = Box::new(plan(message, paths, Layout::Cdr1)?);
            let kinds = plan.kinds.clone();
            Ok((Decoder::Cdr(topic.schema.clone(), plan, None), kinds))
        }
        (Encoding::Ros1 | Encoding::Columns, Schema::Struct(message)) => {
            let plan = Box::new(plan(message, paths, Layout::Packed)?);
            let kinds = plan.kinds.clone();
            Ok((Decoder::Packed(plan), kinds))
        }
        (Encoding::Json, _) => {
            let kinds = vec![ValueKind::Unknown; paths.len()];
            Ok((Decoder::Json(JsonPlan::new(paths)?), kinds))
        }
        (Encoding::Protobuf, Schema::Protobuf(schema)) => {
            let (plan, kinds) = ProtoPlan::new(schema, paths)?;
            Ok((Decoder::Protobuf(plan), kinds))
        }
        (encoding, _) => Err(refused(format!(
            "the messages of {} cannot be decoded: encoding {encoding} does not go with its schema",
            topic.name
        ))),
    }
}
