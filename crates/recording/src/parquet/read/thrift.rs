//! What is written in the compact protocol of Apache Thrift, read without knowing what it should be.
//!
//! # Definition
//! As in [`super::super::thrift`], which writes it. Nothing is held that the bytes do not have: a list claims no more elements
//! than bytes follow, and structures lie at most [`DEEPEST`] within each other.

use super::Damage;

/// How deep structures may lie within each other; Parquet's footer needs six.
const DEEPEST: usize = 32;

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Item<'a> {
    Bool(bool),
    Int(i64),
    Double,
    Bytes(&'a [u8]),
    List(Vec<Item<'a>>),
    Struct(Vec<(i16, Item<'a>)>),
}

impl<'a> Item<'a> {
    /// The field of a structure.
    pub(super) fn field(&self, number: i16) -> Option<&Item<'a>> {
        match self {
            Self::Struct(fields) => {
                let found = fields.iter().find(|(own, _)| *own == number);
                found.map(|(_, item)| item)
            }
            _ => None,
        }
    }

    pub(super) fn int(&self, number: i16) -> Option<i64> {
        match self.field(number) {
            Some(Item::Int(value)) => Some(*value),
            _ => None,
        }
    }

    /// A number of bytes, rows or values, which is not negative.
    pub(super) fn count(&self, number: i16) -> Option<usize> {
        self.int(number).and_then(|it| usize::try_from(it).ok())
    }

    pub(super) fn bool(&self, number: i16) -> Option<bool> {
        match self.field(number) {
            Some(Item::Bool(value)) => Some(*value),
            _ => None,
        }
    }

    pub(super) fn text(&self, number: i16) -> Option<String> {
        match self.field(number) {
            Some(Item::Bytes(bytes)) => Some(String::from_utf8_lossy(bytes).into_owned()),
            _ => None,
        }
    }

    pub(super) fn list(&self, number: i16) -> Option<&[Item<'a>]> {
        match self.field(number) {
            Some(Item::List(items)) => Some(items),
            _ => None,
        }
    }
}

/// Bytes that are read from the front.
#[derive(Debug, Clone)]
pub(super) struct Bytes<'a> {
    left: &'a [u8],
    whole: usize,
}

impl<'a> Bytes<'a> {
    pub(super) fn new(left: &'a [u8]) -> Self {
        let whole = left.len();
        Self { left, whole }
    }

    /// How many bytes have been read.
    pub(super) fn read(&self) -> usize {
        self.whole - self.left.len()
    }

    pub(super) fn rest(&self) -> &'a [u8] {
        self.left
    }

    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], Damage> {
        let ends = || {
            Damage::new(format!(
                "{count} bytes should follow, and {} do",
                self.left.len()
            ))
        };
        let (taken, left) = self.left.split_at_checked(count).ok_or_else(ends)?;
        self.left = left;
        Ok(taken)
    }

    pub(super) fn byte(&mut self) -> Result<u8, Damage> {
        self.take(1).map(|it| it[0])
    }

    /// Four bytes, the lowest first.
    pub(super) fn u32(&mut self) -> Result<usize, Damage> {
        let bytes = self.take(4)?;
        Ok(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as usize)
    }

    /// Seven bits a byte, the lowest first.
    pub(super) fn varint(&mut self) -> Result<u64, Damage> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7F) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err(Damage::new("a whole number has more than ten bytes"))
    }

    fn zigzag(&mut self) -> Result<i64, Damage> {
        let value = self.varint()?;
        Ok((value >> 1) as i64 ^ -((value & 1) as i64))
    }

    /// A structure.
    pub(super) fn structure(&mut self) -> Result<Item<'a>, Damage> {
        self.structure_at(0)
    }

    fn structure_at(&mut self, depth: usize) -> Result<Item<'a>, Damage> {
        if depth > DEEPEST {
            return Err(Damage::new("structures lie too deep within each other"));
        }
        let mut fields = Vec::new();
        let mut last = 0_i16;
        loop {
            let head = self.byte()?;
            if head == 0 {
                return Ok(Item::Struct(fields));
            }
            last = match head >> 4 {
                0 => self.zigzag()? as i16,
                distance => last.wrapping_add(i16::from(distance)),
            };
            let item = match head & 0x0F {
                1 => Item::Bool(true),
                2 => Item::Bool(false),
                kind => self.item(kind, depth)?,
            };
            fields.push((last, item));
        }
    }

    fn item(&mut self, kind: u8, depth: usize) -> Result<Item<'a>, Damage> {
        Ok(match kind {
            // An element of a list.
            1 | 2 => Item::Bool(self.byte()? == 1),
            3 => Item::Int(i64::from(self.byte()? as i8)),
            4..=6 => Item::Int(self.zigzag()?),
            7 => self.take(8).map(|_| Item::Double)?,
            8 => {
                let length = self.varint()?;
                Item::Bytes(self.take(usize::try_from(length).unwrap_or(usize::MAX))?)
            }
            9 | 10 => self.items(depth)?,
            12 => self.structure_at(depth + 1)?,
            other => return Err(Damage::new(format!("no type has the number {other}"))),
        })
    }

    fn items(&mut self, depth: usize) -> Result<Item<'a>, Damage> {
        let head = self.byte()?;
        let length = match head >> 4 {
            15 => self.varint()?,
            few => u64::from(few),
        };
        if length > self.left.len() as u64 {
            return Err(Damage::new(format!(
                "a list claims {length} elements, more than bytes follow"
            )));
        }
        if depth > DEEPEST {
            return Err(Damage::new("lists lie too deep within each other"));
        }
        let items = (0..length).map(|_| self.item(head & 0x0F, depth + 1));
        items.collect::<Result<_, _>>().map(Item::List)
    }
}
