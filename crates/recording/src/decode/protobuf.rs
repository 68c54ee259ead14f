//! Places in messages of protocol buffers.
//!
//! Fields are found by their numbers; all others are passed over by their lengths. Of a field that
//! stands several times the last one counts, parts of a nested message that stands several times
//! add up, and elements of repeated numbers may be packed or not, as the format demands. A field
//! whose wire type is not that of its schema is an error. Members of one `oneof` are not compared:
//! a well-formed message holds at most one.

use super::cell::{Cell, Cells};
use super::path::{FieldPath, Key, PathError, Step};
use super::{DecodeError, ValueKind};
use crate::schema::{ProtoField, ProtoKind, ProtobufSchema, Wire, next_field, varint};

/// What to read of a topic's messages.
#[derive(Debug, Clone)]
pub(crate) struct ProtoPlan {
    root: Message,
    pub(crate) slots: usize,
}

/// What to read of a message.
#[derive(Debug, Clone, Default)]
struct Message {
    wanted: Vec<Wanted>,
}

/// One place that is asked for, from this message on.
#[derive(Debug, Clone)]
struct Wanted {
    number: u32,
    kind: ProtoKind,
    repeated: bool,
    defaults_when_absent: bool,
    pick: Pick,
    then: Then,
}

#[derive(Debug, Clone)]
enum Pick {
    /// The field itself.
    Only,
    Index(u64),
    /// The first element whose parts equal keys; the slot says whether it was found already.
    Where(Vec<(Message, usize, Key)>, usize),
    /// The element at the place where the field of this number and kind equals the key.
    Beside(u32, ProtoKind, Key),
    Length,
}

#[derive(Debug, Clone)]
enum Then {
    Slot(usize),
    Message(Message),
}

/// A path, and the steps of it that are still to be followed.
type Rest<'p> = (&'p FieldPath, &'p [Step]);

impl ProtoPlan {
    pub(crate) fn new(
        schema: &ProtobufSchema,
        paths: &[FieldPath],
    ) -> Result<(Self, Vec<ValueKind>), PathError> {
        let mut planner = Planner {
            schema,
            kinds: vec![ValueKind::Unknown; paths.len()],
        };
        let mut root = Message::default();
        for (slot, path) in paths.iter().enumerate() {
            let wanted = planner.wanted(schema.root, (path, &path.steps), slot)?;
            root.wanted.push(wanted);
        }
        let slots = planner.kinds.len();
        let mut kinds = planner.kinds;
        kinds.truncate(paths.len());
        Ok((ProtoPlan { root, slots }, kinds))
    }

    pub(crate) fn read(&self, data: &[u8], cells: &mut Cells) -> Result<(), DecodeError> {
        let mut counts = vec![0; self.root.wanted.len()];
        self.root.read(data, 0, cells, &mut counts)
    }
}

struct Planner<'s> {
    schema: &'s ProtobufSchema,
    kinds: Vec<ValueKind>,
}

impl Planner<'_> {
    fn field(&self, message: usize, path: &FieldPath, name: &str) -> Result<ProtoField, PathError> {
        let message = &self.schema.messages[message];
        let found = message.fields.iter().find(|field| field.name == name);
        found.cloned().ok_or_else(|| {
            let names: Vec<&str> = message
                .fields
                .iter()
                .map(|f| f.name.as_str())
                .take(30)
                .collect();
            path.error(format!(
                "{} has no field {name}; name one of its fields: {}",
                message.name,
                names.join(", ")
            ))
        })
    }

    fn wanted(
        &mut self,
        message: usize,
        (path, steps): Rest<'_>,
        slot: usize,
    ) -> Result<Wanted, PathError> {
        let Some((Step::Field(name), rest)) = steps.split_first() else {
            return Err(path.error("it leads to a message; name one of its fields"));
        };
        let field = self.field(message, path, name)?;
        let (pick, rest) = match rest.split_first() {
            Some((Step::Index(index), rest)) if field.repeated => (Pick::Index(*index), rest),
            Some((Step::Where(conditions), rest)) if field.repeated => {
                let pick = self.choice(message, &field, path, conditions)?;
                (pick, rest)
            }
            None if path.is_length && field.repeated => (Pick::Length, rest),
            _ if field.repeated => {
                let problem = "it is an array; give an index, as in a[0], or ask for length(a)";
                return Err(path.error(problem));
            }
            _ => (Pick::Only, rest),
        };
        let then = match (&pick, &field.kind) {
            (Pick::Length, _) => {
                self.kinds[slot] = ValueKind::Length;
                Then::Slot(slot)
            }
            (_, ProtoKind::Message(inner)) => {
                let wanted = vec![self.wanted(*inner, (path, rest), slot)?];
                Then::Message(Message { wanted })
            }
            _ if path.is_length => return Err(path.error("only arrays have a length")),
            (_, ProtoKind::Bytes | ProtoKind::Group) => {
                return Err(path.error("it holds bytes, which are not a number"));
            }
            _ if !rest.is_empty() => {
                return Err(path.error("it has no parts; end the path before it"));
            }
            (_, kind) => {
                self.kinds[slot] = value_kind(kind);
                Then::Slot(slot)
            }
        };
        Ok(Wanted {
            number: field.number,
            defaults_when_absent: field.defaults_when_absent,
            repeated: field.repeated,
            kind: field.kind,
            pick,
            then,
        })
    }

    fn choice(
        &mut self,
        message: usize,
        field: &ProtoField,
        path: &FieldPath,
        conditions: &[super::path::Condition],
    ) -> Result<Pick, PathError> {
        if let ProtoKind::Message(inner) = field.kind {
            let mut tests = Vec::new();
            for condition in conditions {
                let names = condition.names.iter().cloned().map(Step::Field);
                let steps: Vec<Step> = names.collect();
                let slot = self.kinds.len();
                self.kinds.push(ValueKind::Unknown);
                // The condition's own end is a value, whatever the path asks for.
                let mut plain = path.clone();
                plain.is_length = false;
                let wanted = vec![self.wanted(inner, (&plain, &steps), slot)?];
                tests.push((Message { wanted }, slot, condition.key.clone()));
            }
            let found = self.kinds.len();
            self.kinds.push(ValueKind::Unknown);
            return Ok(Pick::Where(tests, found));
        }
        let [condition] = conditions else {
            return Err(path.error("only one condition can choose by an array beside it"));
        };
        let other = self.field(message, path, &condition.names[0])?;
        let is_message = matches!(other.kind, ProtoKind::Message(_));
        if condition.names.len() > 1 || !other.repeated || is_message {
            let problem = format!(
                "{} is not an array of texts or numbers beside it",
                other.name
            );
            return Err(path.error(problem));
        }
        Ok(Pick::Beside(
            other.number,
            other.kind,
            condition.key.clone(),
        ))
    }
}

fn value_kind(kind: &ProtoKind) -> ValueKind {
    let integer = |bits, signed| ValueKind::Integer { bits, signed };
    match kind {
        ProtoKind::Double => ValueKind::Float { bits: 64 },
        ProtoKind::Float => ValueKind::Float { bits: 32 },
        ProtoKind::Int32 | ProtoKind::Sint32 | ProtoKind::Sfixed32 => integer(32, true),
        ProtoKind::Int64 | ProtoKind::Sint64 | ProtoKind::Sfixed64 => integer(64, true),
        ProtoKind::Uint32 | ProtoKind::Fixed32 => integer(32, false),
        ProtoKind::Uint64 | ProtoKind::Fixed64 => integer(64, false),
        ProtoKind::Bool => ValueKind::Bool,
        ProtoKind::Text => ValueKind::Text,
        ProtoKind::Enumeration(_) => ValueKind::Enumeration,
        ProtoKind::Bytes | ProtoKind::Message(_) | ProtoKind::Group => ValueKind::Unknown,
    }
}

fn error(offset: usize, message: &'static str) -> DecodeError {
    DecodeError {
        offset_in_message: offset,
        message: message.into(),
    }
}

impl Message {
    /// Reads a message that begins at `offset` of the whole. `counts` has, for each wanted place,
    /// how often its field was seen, so that parts of one message can add up.
    fn read(
        &self,
        data: &[u8],
        offset: usize,
        cells: &mut Cells,
        counts: &mut [u64],
    ) -> Result<(), DecodeError> {
        for (wanted, count) in self.wanted.iter().zip(&*counts) {
            if *count == 0 {
                wanted.prepare(cells);
            }
        }
        let mut at = 0;
        loop {
            let begin = at;
            let field = next_field(data, &mut at).map_err(|m| error(offset + begin, m))?;
            let Some((number, value)) = field else {
                return Ok(());
            };
            for (wanted, count) in self.wanted.iter().zip(&mut *counts) {
                if wanted.number == number {
                    // A value of length-delimited type ends where the field ends.
                    let inner = match value {
                        Wire::Bytes(bytes) => offset + at - bytes.len(),
                        _ => offset + begin,
                    };
                    wanted.take(data, value, inner, cells, count)?;
                }
            }
        }
    }
}

impl Wanted {
    /// Sets what holds if the field is absent.
    fn prepare(&self, cells: &mut Cells) {
        if let Pick::Where(_, found) = self.pick {
            cells.set(&[found], Cell::Missing);
        }
        let Then::Slot(slot) = self.then else {
            return;
        };
        if matches!(self.pick, Pick::Length) {
            cells.set(&[slot], Cell::Number(0.0));
        } else if self.defaults_when_absent {
            match self.kind {
                ProtoKind::Bool => cells.set(&[slot], Cell::Bool(false)),
                ProtoKind::Text => cells.set_text(&[slot], b""),
                _ => cells.set(&[slot], Cell::Number(0.0)),
            }
        }
    }

    fn take(
        &self,
        message: &[u8],
        value: Wire<'_>,
        offset: usize,
        cells: &mut Cells,
        count: &mut u64,
    ) -> Result<(), DecodeError> {
        if self.repeated
            && let Wire::Bytes(packed) = value
            && is_packable(&self.kind)
        {
            let mut at = 0;
            while at < packed.len() {
                let begin = at;
                let element = unpack(&self.kind, packed, &mut at).ok_or_else(|| {
                    error(offset + begin, "a packed array ends inside an element")
                })?;
                self.element(message, element, offset + begin, cells, *count)?;
                *count += 1;
            }
            return Ok(());
        }
        self.element(message, value, offset, cells, *count)?;
        *count += 1;
        Ok(())
    }

    /// Takes the element of number `index`, or the field itself.
    fn element(
        &self,
        message: &[u8],
        value: Wire<'_>,
        offset: usize,
        cells: &mut Cells,
        index: u64,
    ) -> Result<(), DecodeError> {
        let is_chosen = match &self.pick {
            Pick::Only => true,
            Pick::Index(wanted) => index == *wanted,
            Pick::Length => {
                if let Then::Slot(slot) = self.then {
                    cells.set(&[slot], Cell::Number((index + 1) as f64));
                }
                false
            }
            Pick::Where(tests, found) => {
                // The first that fits counts: once it was found, the rest is passed over.
                let is_first =
                    cells.cells[*found] == Cell::Missing && all_hold(tests, value, offset, cells)?;
                if is_first {
                    cells.set(&[*found], Cell::Bool(true));
                }
                is_first
            }
            Pick::Beside(number, kind, key) => {
                place_of(message, *number, kind, key, cells)? == Some(index)
            }
        };
        if !is_chosen {
            return Ok(());
        }
        match &self.then {
            Then::Slot(slot) => set(&self.kind, value, *slot, offset, cells),
            Then::Message(inner) => {
                let Wire::Bytes(bytes) = value else {
                    return Err(error(
                        offset,
                        "a field has another wire type than its schema",
                    ));
                };
                // Parts add up only outside arrays; `index` then counts the parts before.
                let before = u64::from(matches!(self.pick, Pick::Only) && index > 0);
                let mut counts = vec![before; inner.wanted.len()];
                inner.read(bytes, offset, cells, &mut counts)
            }
        }
    }
}

fn all_hold(
    tests: &[(Message, usize, Key)],
    value: Wire<'_>,
    offset: usize,
    cells: &mut Cells,
) -> Result<bool, DecodeError> {
    let Wire::Bytes(bytes) = value else {
        return Err(error(
            offset,
            "a field has another wire type than its schema",
        ));
    };
    for (message, slot, key) in tests {
        let kept = cells.texts.len();
        cells.cells[*slot] = Cell::Missing;
        let mut counts = vec![0; message.wanted.len()];
        message.read(bytes, offset, cells, &mut counts)?;
        let holds = cells.matches(*slot, key);
        cells.texts.truncate(kept);
        if !holds {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The place of the first element of a field that equals a key.
fn place_of(
    message: &[u8],
    number: u32,
    kind: &ProtoKind,
    key: &Key,
    cells: &mut Cells,
) -> Result<Option<u64>, DecodeError> {
    let (mut at, mut index) = (0, 0_u64);
    // A slot behind all others, only for the comparison.
    let slot = cells.cells.len();
    cells.cells.push(Cell::Missing);
    let mut found = None;
    while let Ok(Some((field, value))) = next_field(message, &mut at) {
        if field != number || found.is_some() {
            continue;
        }
        let mut elements = Vec::new();
        match value {
            Wire::Bytes(packed) if is_packable(kind) => {
                let mut inner = 0;
                while inner < packed.len() {
                    let Some(element) = unpack(kind, packed, &mut inner) else {
                        break;
                    };
                    elements.push(element);
                }
            }
            value => elements.push(value),
        }
        for element in elements {
            let kept = cells.texts.len();
            let result = set(kind, element, slot, at, cells);
            let holds = result.is_ok() && cells.matches(slot, key);
            cells.texts.truncate(kept);
            if holds && found.is_none() {
                found = Some(index);
            }
            index += 1;
        }
    }
    cells.cells.pop();
    Ok(found)
}

fn is_packable(kind: &ProtoKind) -> bool {
    !matches!(
        kind,
        ProtoKind::Text | ProtoKind::Bytes | ProtoKind::Message(_) | ProtoKind::Group
    )
}

fn unpack<'a>(kind: &ProtoKind, packed: &'a [u8], at: &mut usize) -> Option<Wire<'a>> {
    match kind {
        ProtoKind::Double | ProtoKind::Fixed64 | ProtoKind::Sfixed64 => {
            let bytes = packed.get(*at..)?.first_chunk::<8>()?;
            *at += 8;
            Some(Wire::Fixed64(*bytes))
        }
        ProtoKind::Float | ProtoKind::Fixed32 | ProtoKind::Sfixed32 => {
            let bytes = packed.get(*at..)?.first_chunk::<4>()?;
            *at += 4;
            Some(Wire::Fixed32(*bytes))
        }
        _ => varint(packed, at).map(Wire::Varint),
    }
}

/// Puts a value on the wire into a slot.
fn set(
    kind: &ProtoKind,
    value: Wire<'_>,
    slot: usize,
    offset: usize,
    cells: &mut Cells,
) -> Result<(), DecodeError> {
    let zigzag = |value: u64| (value >> 1) as i64 ^ -((value & 1) as i64);
    let number = match (kind, value) {
        (ProtoKind::Double, Wire::Fixed64(bytes)) => f64::from_le_bytes(bytes),
        (ProtoKind::Float, Wire::Fixed32(bytes)) => f64::from(f32::from_le_bytes(bytes)),
        (ProtoKind::Int32 | ProtoKind::Enumeration(_), Wire::Varint(value)) => {
            f64::from(value as i32)
        }
        (ProtoKind::Int64, Wire::Varint(value)) => value as i64 as f64,
        (ProtoKind::Uint32, Wire::Varint(value)) => f64::from(value as u32),
        (ProtoKind::Uint64, Wire::Varint(value)) => value as f64,
        (ProtoKind::Sint32, Wire::Varint(value)) => f64::from(zigzag(value & 0xffff_ffff) as i32),
        (ProtoKind::Sint64, Wire::Varint(value)) => zigzag(value) as f64,
        (ProtoKind::Fixed32, Wire::Fixed32(bytes)) => f64::from(u32::from_le_bytes(bytes)),
        (ProtoKind::Sfixed32, Wire::Fixed32(bytes)) => f64::from(i32::from_le_bytes(bytes)),
        (ProtoKind::Fixed64, Wire::Fixed64(bytes)) => u64::from_le_bytes(bytes) as f64,
        (ProtoKind::Sfixed64, Wire::Fixed64(bytes)) => i64::from_le_bytes(bytes) as f64,
        (ProtoKind::Bool, Wire::Varint(value)) => {
            cells.set(&[slot], Cell::Bool(value != 0));
            return Ok(());
        }
        (ProtoKind::Text, Wire::Bytes(text)) => {
            cells.set_text(&[slot], text);
            return Ok(());
        }
        _ => {
            return Err(error(
                offset,
                "a field has another wire type than its schema",
            ));
        }
    };
    cells.set(&[slot], Cell::Number(number));
    Ok(())
}
