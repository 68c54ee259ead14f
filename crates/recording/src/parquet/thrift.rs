//! Structures in the compact protocol of Apache Thrift, as far as Parquet's footer needs them.
//!
//! A field is a byte whose high half is the distance from the field before and whose low half is
//! the type, then the value; a structure ends with a zero byte. Integers are zigzag varints.

/// Types of the protocol.
const TRUE: u8 = 1;
const FALSE: u8 = 2;
const I8: u8 = 3;
const I32: u8 = 5;
const I64: u8 = 6;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const STRUCT: u8 = 12;

/// A structure that is being written. Fields come in ascending order of their numbers, less than 16
/// apart.
#[derive(Debug, Default)]
pub(super) struct Structure {
    bytes: Vec<u8>,
    last: u8,
}

impl Structure {
    pub(super) fn new() -> Self {
        Self::default()
    }

    fn field(&mut self, number: u8, kind: u8) {
        let distance = number - self.last;
        self.bytes.push(distance << 4 | kind);
        self.last = number;
    }

    pub(super) fn bool(mut self, number: u8, value: bool) -> Self {
        self.field(number, if value { TRUE } else { FALSE });
        self
    }

    pub(super) fn i8(mut self, number: u8, value: i8) -> Self {
        self.field(number, I8);
        self.bytes.push(value as u8);
        self
    }

    pub(super) fn i32(mut self, number: u8, value: i32) -> Self {
        self.field(number, I32);
        varint(&mut self.bytes, zigzag(i64::from(value)));
        self
    }

    pub(super) fn i64(mut self, number: u8, value: u64) -> Self {
        self.field(number, I64);
        varint(&mut self.bytes, zigzag(value as i64));
        self
    }

    pub(super) fn text(mut self, number: u8, value: &str) -> Self {
        self.field(number, BINARY);
        text(&mut self.bytes, value);
        self
    }

    pub(super) fn structure(mut self, number: u8, value: Self) -> Self {
        self.field(number, STRUCT);
        self.bytes.extend(value.finish());
        self
    }

    pub(super) fn structures(mut self, number: u8, values: Vec<Self>) -> Self {
        self.list(number, STRUCT, values.len());
        for value in values {
            self.bytes.extend(value.finish());
        }
        self
    }

    pub(super) fn texts(mut self, number: u8, values: &[&str]) -> Self {
        self.list(number, BINARY, values.len());
        for value in values {
            text(&mut self.bytes, value);
        }
        self
    }

    pub(super) fn i32s(mut self, number: u8, values: &[i32]) -> Self {
        self.list(number, I32, values.len());
        for value in values {
            varint(&mut self.bytes, zigzag(i64::from(*value)));
        }
        self
    }

    fn list(&mut self, number: u8, kind: u8, length: usize) {
        self.field(number, LIST);
        if length < 15 {
            self.bytes.push((length as u8) << 4 | kind);
        } else {
            self.bytes.push(0xF0 | kind);
            varint(&mut self.bytes, length as u64);
        }
    }

    pub(super) fn finish(mut self) -> Vec<u8> {
        self.bytes.push(0);
        self.bytes
    }
}

fn text(bytes: &mut Vec<u8>, value: &str) {
    varint(bytes, value.len() as u64);
    bytes.extend_from_slice(value.as_bytes());
}

/// Whole numbers such that small ones of either sign are small.
fn zigzag(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)) as u64
}

/// Seven bits a byte, the lowest first.
pub(super) fn varint(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_the_protocol_has_them() {
        let bytes = |value: u64| {
            let mut bytes = Vec::new();
            varint(&mut bytes, value);
            bytes
        };
        assert_eq!(bytes(50_399), [0xDF, 0x89, 0x03]);
        assert_eq!([0, -1, 1, -2, i64::MIN].map(zigzag), [0, 1, 2, 3, u64::MAX]);
    }

    #[test]
    fn a_structure_counts_the_distance_of_its_fields() {
        let inner = Structure::new().bool(1, true).bool(2, false);
        let written = Structure::new()
            .i32(1, -1)
            .text(4, "ab")
            .structure(5, inner)
            .finish();
        assert_eq!(
            written,
            [0x15, 1, 0x38, 2, b'a', b'b', 0x1C, 0x11, 0x12, 0, 0]
        );
    }
}
