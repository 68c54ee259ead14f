//! Protocol buffers: message types from a `FileDescriptorSet`, as MCAP keeps them.
//!
//! Source: protobuf.dev, "Encoding" and `google/protobuf/descriptor.proto`. The descriptors are
//! protocol buffers themselves; the few fields needed are walked with [`Wire`], so that no code has
//! to be generated and decoding can stop at the fields that are asked for, which general libraries
//! do not offer: they build the whole message.
//!
//! Presence: a proto3 field without `optional` that is absent has its default (0, false, empty);
//! any other absent field is missing. Editions are followed where they set `field_presence`.

use std::collections::BTreeMap;

use super::SchemaError;

/// All message types that a topic's schema defines, and which of them the topic has.
#[derive(Debug, Clone, PartialEq)]
pub struct ProtobufSchema {
    /// The message types; nested ones are named by their place here.
    pub messages: Vec<ProtoMessage>,
    /// The place of the topic's type.
    pub root: usize,
}

/// A message type.
#[derive(Debug, Clone, PartialEq)]
pub struct ProtoMessage {
    /// Its full name, without a leading dot.
    pub name: String,
    /// Its fields, in the order of the descriptor.
    pub fields: Vec<ProtoField>,
}

/// A field.
#[derive(Debug, Clone, PartialEq)]
pub struct ProtoField {
    /// Its name.
    pub name: String,
    /// Its number on the wire.
    pub number: u32,
    /// Whether it is repeated.
    pub repeated: bool,
    /// Whether it has its default when absent, rather than being missing.
    pub defaults_when_absent: bool,
    /// What it holds.
    pub kind: ProtoKind,
}

/// What a field holds.
#[derive(Debug, Clone, PartialEq)]
pub enum ProtoKind {
    /// 64-bit float.
    Double,
    /// 32-bit float.
    Float,
    /// Signed varint of 32 bits.
    Int32,
    /// Signed varint of 64 bits.
    Int64,
    /// Unsigned varint of 32 bits.
    Uint32,
    /// Unsigned varint of 64 bits.
    Uint64,
    /// Zigzag varint of 32 bits.
    Sint32,
    /// Zigzag varint of 64 bits.
    Sint64,
    /// Unsigned, four bytes.
    Fixed32,
    /// Unsigned, eight bytes.
    Fixed64,
    /// Signed, four bytes.
    Sfixed32,
    /// Signed, eight bytes.
    Sfixed64,
    /// Truth value.
    Bool,
    /// Text.
    Text,
    /// Bytes.
    Bytes,
    /// Enumeration: its names by number.
    Enumeration(BTreeMap<i32, String>),
    /// Nested message, by its place in [`ProtobufSchema::messages`].
    Message(usize),
    /// A group, which proto3 no longer has; passed over.
    Group,
}

/// One field on the wire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Wire<'a> {
    Varint(u64),
    Fixed64([u8; 8]),
    Bytes(&'a [u8]),
    Fixed32([u8; 4]),
}

/// Reads the next field of `data` from `*at`: its number and value. `None` at the end; an error is
/// what is wrong, at `*at`.
pub(crate) fn next_field<'a>(
    data: &'a [u8],
    at: &mut usize,
) -> Result<Option<(u32, Wire<'a>)>, &'static str> {
    const CUT: &str = "the message ends inside a field";
    loop {
        if *at >= data.len() {
            return Ok(None);
        }
        let tag = varint(data, at).ok_or(CUT)?;
        let number = u32::try_from(tag >> 3).map_err(|_| "a field number is out of range")?;
        if number == 0 {
            return Err("a field has number 0");
        }
        let value = match tag & 7 {
            0 => Wire::Varint(varint(data, at).ok_or(CUT)?),
            1 => Wire::Fixed64(take(data, at).ok_or(CUT)?),
            2 => {
                let length = varint(data, at).ok_or(CUT)?;
                let length = usize::try_from(length).map_err(|_| CUT)?;
                let end = at.checked_add(length).filter(|end| *end <= data.len());
                let end = end.ok_or("a length exceeds the message")?;
                let bytes = &data[*at..end];
                *at = end;
                Wire::Bytes(bytes)
            }
            3 => {
                skip_group(data, at, number)?;
                continue;
            }
            5 => Wire::Fixed32(take(data, at).ok_or(CUT)?),
            _ => return Err("a field has an unknown wire type"),
        };
        return Ok(Some((number, value)));
    }
}

/// Passes over a group up to its end; groups may nest.
fn skip_group(data: &[u8], at: &mut usize, number: u32) -> Result<(), &'static str> {
    const CUT: &str = "the message ends inside a group";
    let mut open = vec![u64::from(number)];
    while let Some(&innermost) = open.last() {
        let tag = varint(data, at).ok_or(CUT)?;
        match tag & 7 {
            0 => drop(varint(data, at).ok_or(CUT)?),
            1 => drop(take::<8>(data, at).ok_or(CUT)?),
            2 => {
                let length = varint(data, at).and_then(|length| usize::try_from(length).ok());
                let end = length.and_then(|length| at.checked_add(length));
                *at = end.filter(|end| *end <= data.len()).ok_or(CUT)?;
            }
            3 => open.push(tag >> 3),
            4 if tag >> 3 == innermost => drop(open.pop()),
            5 => drop(take::<4>(data, at).ok_or(CUT)?),
            _ => return Err("a group is malformed"),
        }
    }
    Ok(())
}

fn take<const N: usize>(data: &[u8], at: &mut usize) -> Option<[u8; N]> {
    let bytes = data.get(*at..)?.first_chunk::<N>()?;
    *at += N;
    Some(*bytes)
}

/// Reads a varint of at most ten bytes.
pub(crate) fn varint(data: &[u8], at: &mut usize) -> Option<u64> {
    let mut value = 0_u64;
    for shift in (0..70).step_by(7) {
        let byte = *data.get(*at)?;
        *at += 1;
        if shift == 63 && byte > 1 {
            return None;
        }
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Some(value);
        }
    }
    None
}

impl ProtobufSchema {
    /// Reads the type called `name` from the bytes of a `FileDescriptorSet`.
    ///
    /// # Errors
    /// [`SchemaError`] if the bytes are damaged or the type is missing.
    pub fn parse(name: &str, bytes: &[u8]) -> Result<Self, SchemaError> {
        let mut found = Found::default();
        each(bytes, |number, value| match (number, value) {
            (1, Wire::Bytes(file)) => found.file(file),
            _ => Ok(()),
        })
        .map_err(|problem| {
            SchemaError::new(0, format!("its descriptors are damaged: {problem}"))
        })?;
        found.schema(name)
    }
}

/// Calls `take` with every field of `data`.
fn each<'a>(
    data: &'a [u8],
    mut take: impl FnMut(u32, Wire<'a>) -> Result<(), &'static str>,
) -> Result<(), &'static str> {
    let mut at = 0;
    while let Some((number, value)) = next_field(data, &mut at)? {
        take(number, value)?;
    }
    Ok(())
}

fn text(bytes: &[u8]) -> Result<String, &'static str> {
    String::from_utf8(bytes.to_vec()).map_err(|_| "a name is not UTF-8")
}

/// Descriptors before type names are looked up.
#[derive(Default)]
struct Found {
    messages: Vec<(String, Vec<RawField>)>,
    enumerations: BTreeMap<String, BTreeMap<i32, String>>,
}

/// A `FieldDescriptorProto`.
#[derive(Default)]
struct RawField {
    name: String,
    number: u32,
    label: u64,
    kind: u64,
    type_name: String,
    in_oneof: bool,
    optional: bool,
    presence: Option<u64>,
    implicit_by_file: bool,
}

const REPEATED: u64 = 3;
/// `FeatureSet.FieldPresence.IMPLICIT`.
const IMPLICIT: u64 = 2;
/// The deepest nesting of message types inside message types that is believed.
const DEPTH_LIMIT: usize = 64;

impl Found {
    fn file(&mut self, file: &[u8]) -> Result<(), &'static str> {
        let (mut package, mut syntax, mut presence) = (String::new(), String::new(), None);
        each(file, |number, value| {
            match (number, value) {
                (2, Wire::Bytes(bytes)) => package = text(bytes)?,
                (12, Wire::Bytes(bytes)) => syntax = text(bytes)?,
                // FileOptions.features
                (8, Wire::Bytes(options)) => presence = field_presence(options, 50)?.or(presence),
                _ => {}
            }
            Ok(())
        })?;
        let implicit = match presence {
            Some(presence) => presence == IMPLICIT,
            None => syntax == "proto3",
        };
        each(file, |number, value| match (number, value) {
            (4, Wire::Bytes(message)) => self.message(&package, message, implicit, 0),
            (5, Wire::Bytes(enumeration)) => self.enumeration(&package, enumeration),
            _ => Ok(()),
        })
    }

    fn message(
        &mut self,
        scope: &str,
        message: &[u8],
        implicit: bool,
        depth: usize,
    ) -> Result<(), &'static str> {
        if depth > DEPTH_LIMIT {
            return Err("types are nested too deeply");
        }
        let (mut name, mut fields) = (String::new(), Vec::new());
        each(message, |number, value| {
            match (number, value) {
                (1, Wire::Bytes(bytes)) => name = text(bytes)?,
                (2, Wire::Bytes(bytes)) => fields.push(raw_field(bytes, implicit)?),
                _ => {}
            }
            Ok(())
        })?;
        let full = joined(scope, &name);
        each(message, |number, value| match (number, value) {
            (3, Wire::Bytes(nested)) => self.message(&full, nested, implicit, depth + 1),
            (4, Wire::Bytes(nested)) => self.enumeration(&full, nested),
            _ => Ok(()),
        })?;
        self.messages.push((full, fields));
        Ok(())
    }

    fn enumeration(&mut self, scope: &str, bytes: &[u8]) -> Result<(), &'static str> {
        let (mut name, mut values) = (String::new(), BTreeMap::new());
        each(bytes, |number, value| {
            match (number, value) {
                (1, Wire::Bytes(bytes)) => name = text(bytes)?,
                (2, Wire::Bytes(bytes)) => {
                    let (value_name, value) = enumeration_value(bytes)?;
                    // An alias does not replace the first name.
                    values.entry(value).or_insert(value_name);
                }
                _ => {}
            }
            Ok(())
        })?;
        self.enumerations.insert(joined(scope, &name), values);
        Ok(())
    }

    fn schema(self, name: &str) -> Result<ProtobufSchema, SchemaError> {
        let place = |name: &str| {
            let name = name.trim_start_matches('.');
            self.messages.iter().position(|(known, _)| known == name)
        };
        let Some(root) = place(name) else {
            let problem = format!("its descriptors do not define the message type {name}");
            return Err(SchemaError::new(0, problem));
        };
        let mut messages = Vec::new();
        for (message, raw) in &self.messages {
            let mut fields = Vec::new();
            for field in raw {
                fields.push(self.field(message, field, place(&field.type_name))?);
            }
            messages.push(ProtoMessage {
                name: message.clone(),
                fields,
            });
        }
        Ok(ProtobufSchema { messages, root })
    }

    fn field(
        &self,
        message: &str,
        raw: &RawField,
        place: Option<usize>,
    ) -> Result<ProtoField, SchemaError> {
        let missing = || {
            let problem = format!(
                "the field {} of {message} has the type {}, which is not defined",
                raw.name, raw.type_name
            );
            SchemaError::new(0, problem)
        };
        let kind = match raw.kind {
            11 => ProtoKind::Message(place.ok_or_else(missing)?),
            14 => {
                let name = raw.type_name.trim_start_matches('.');
                let names = self.enumerations.get(name).ok_or_else(missing)?;
                ProtoKind::Enumeration(names.clone())
            }
            other => scalar(other).ok_or_else(|| {
                let problem = format!("the field {} of {message} has no known type", raw.name);
                SchemaError::new(0, problem)
            })?,
        };
        let repeated = raw.label == REPEATED;
        let implicit = match raw.presence {
            Some(presence) => presence == IMPLICIT,
            None => raw.implicit_by_file,
        };
        let nested = matches!(kind, ProtoKind::Message(_) | ProtoKind::Group);
        Ok(ProtoField {
            name: raw.name.clone(),
            number: raw.number,
            repeated,
            defaults_when_absent: implicit
                && !raw.optional
                && !raw.in_oneof
                && !repeated
                && !nested,
            kind,
        })
    }
}

fn joined(scope: &str, name: &str) -> String {
    if scope.is_empty() {
        name.to_owned()
    } else {
        format!("{scope}.{name}")
    }
}

fn raw_field(bytes: &[u8], implicit_by_file: bool) -> Result<RawField, &'static str> {
    let mut field = RawField {
        implicit_by_file,
        ..RawField::default()
    };
    each(bytes, |number, value| {
        match (number, value) {
            (1, Wire::Bytes(bytes)) => field.name = text(bytes)?,
            (3, Wire::Varint(value)) => {
                field.number =
                    u32::try_from(value).map_err(|_| "a field number is out of range")?;
            }
            (4, Wire::Varint(value)) => field.label = value,
            (5, Wire::Varint(value)) => field.kind = value,
            (6, Wire::Bytes(bytes)) => field.type_name = text(bytes)?,
            // FieldOptions.features
            (8, Wire::Bytes(options)) => field.presence = field_presence(options, 21)?,
            (9, Wire::Varint(_)) => field.in_oneof = true,
            (17, Wire::Varint(value)) => field.optional = value != 0,
            _ => {}
        }
        Ok(())
    })?;
    Ok(field)
}

/// `features.field_presence` in options whose features have the number `features`.
fn field_presence(options: &[u8], features: u32) -> Result<Option<u64>, &'static str> {
    let mut found = None;
    each(options, |number, value| match value {
        Wire::Bytes(bytes) if number == features => each(bytes, |number, value| {
            if let (1, Wire::Varint(presence)) = (number, value) {
                found = Some(presence);
            }
            Ok(())
        }),
        _ => Ok(()),
    })?;
    Ok(found)
}

fn enumeration_value(bytes: &[u8]) -> Result<(String, i32), &'static str> {
    let (mut name, mut number) = (String::new(), 0);
    each(bytes, |field, value| {
        match (field, value) {
            (1, Wire::Bytes(bytes)) => name = text(bytes)?,
            // Negative numbers are extended to 64 bits on the wire.
            (2, Wire::Varint(value)) => number = value as i32,
            _ => {}
        }
        Ok(())
    })?;
    Ok((name, number))
}

fn scalar(kind: u64) -> Option<ProtoKind> {
    Some(match kind {
        1 => ProtoKind::Double,
        2 => ProtoKind::Float,
        3 => ProtoKind::Int64,
        4 => ProtoKind::Uint64,
        5 => ProtoKind::Int32,
        6 => ProtoKind::Fixed64,
        7 => ProtoKind::Fixed32,
        8 => ProtoKind::Bool,
        9 => ProtoKind::Text,
        10 => ProtoKind::Group,
        12 => ProtoKind::Bytes,
        13 => ProtoKind::Uint32,
        15 => ProtoKind::Sfixed32,
        16 => ProtoKind::Sfixed64,
        17 => ProtoKind::Sint32,
        18 => ProtoKind::Sint64,
        _ => return None,
    })
}
