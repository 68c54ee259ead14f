//! Rows: a header of types, then the values.

/// The value of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Value<'a> {
    Null,
    Integer(i64),
    Real(f64),
    /// In the encoding of the database.
    Text(&'a [u8]),
    Blob(&'a [u8]),
}

impl Value<'_> {
    /// The number, if it is a whole one.
    pub(crate) fn integer(&self) -> Option<i64> {
        match self {
            Value::Integer(value) => Some(*value),
            _ => None,
        }
    }
}

/// The type of a column's value and where it is in the row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Field {
    kind: u64,
    pub(crate) start: u64,
    pub(crate) len: u64,
}

impl Field {
    /// Whether it holds bytes or a text.
    pub(crate) fn is_bytes(&self) -> bool {
        self.kind >= 12
    }

    /// Whether its bytes are all in a row of which `available` bytes are known.
    pub(crate) fn is_within(&self, available: usize) -> bool {
        self.start + self.len <= available as u64
    }

    /// Its value in `row`; `None` if it is not within.
    pub(crate) fn value<'a>(&self, row: &'a [u8]) -> Option<Value<'a>> {
        let start = usize::try_from(self.start).ok()?;
        let len = usize::try_from(self.len).ok()?;
        let bytes = row.get(start..start.checked_add(len)?)?;
        Some(match self.kind {
            0 => Value::Null,
            1..=6 => Value::Integer(signed(bytes)),
            7 => Value::Real(f64::from_bits(signed(bytes) as u64)),
            8 => Value::Integer(0),
            9 => Value::Integer(1),
            kind if kind % 2 == 0 => Value::Blob(bytes),
            _ => Value::Text(bytes),
        })
    }
}

/// A big-endian two's complement number of up to 8 bytes.
fn signed(bytes: &[u8]) -> i64 {
    let negative = bytes.first().is_some_and(|byte| byte & 0x80 != 0);
    let start = if negative { -1 } else { 0 };
    bytes
        .iter()
        .fold(start, |value: i64, byte| (value << 8) | i64::from(*byte))
}

/// A variable-length number at the start of `bytes`, and how many bytes it has.
pub(crate) fn varint(bytes: &[u8]) -> Option<(u64, usize)> {
    let mut value = 0_u64;
    for (index, byte) in bytes.iter().enumerate().take(9) {
        if index == 8 {
            return Some(((value << 8) | u64::from(*byte), 9));
        }
        value = (value << 7) | u64::from(byte & 0x7f);
        if byte & 0x80 == 0 {
            return Some((value, index + 1));
        }
    }
    None
}

/// Why a row's header cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HeaderError {
    /// It does not end within the bytes that are known.
    Incomplete,
    /// It contradicts itself or the row's length.
    Wrong,
}

/// Finds the columns of a row of `total` bytes, of which `row` are the first.
pub(crate) fn locate(row: &[u8], total: u64, fields: &mut Vec<Field>) -> Result<(), HeaderError> {
    fields.clear();
    let incomplete = |error: HeaderError| {
        if row.len() as u64 == total {
            HeaderError::Wrong
        } else {
            error
        }
    };
    let (header, mut at) = varint(row).ok_or(incomplete(HeaderError::Incomplete))?;
    if header < at as u64 || header > total {
        return Err(HeaderError::Wrong);
    }
    let Some(types) = row.get(..header as usize) else {
        return Err(incomplete(HeaderError::Incomplete));
    };
    let mut start = header;
    while at < types.len() {
        let (kind, bytes) = varint(&types[at..]).ok_or(HeaderError::Wrong)?;
        let len = content_bytes(kind).ok_or(HeaderError::Wrong)?;
        fields.push(Field { kind, start, len });
        start = start.checked_add(len).ok_or(HeaderError::Wrong)?;
        at += bytes;
    }
    if start == total {
        Ok(())
    } else {
        Err(HeaderError::Wrong)
    }
}

fn content_bytes(kind: u64) -> Option<u64> {
    match kind {
        0 | 8 | 9 => Some(0),
        1..=4 => Some(kind),
        5 => Some(6),
        6 | 7 => Some(8),
        10 | 11 => None,
        _ => Some((kind - 12) / 2),
    }
}
