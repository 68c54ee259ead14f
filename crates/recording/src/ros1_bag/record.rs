//! Records: a header of named fields, then data.

/// The fields of a record's header.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Header<'a>(&'a [u8]);

impl<'a> Header<'a> {
    /// Takes `bytes` as a header; `None` if they are no sequence of `name=value`.
    pub(crate) fn new(bytes: &'a [u8]) -> Option<Self> {
        let mut rest = bytes;
        while !rest.is_empty() {
            let (field, behind) = split_block(rest)?;
            field.iter().position(|byte| *byte == b'=')?;
            rest = behind;
        }
        Some(Header(bytes))
    }

    /// The value of a field.
    pub(crate) fn bytes(&self, name: &str) -> Option<&'a [u8]> {
        let mut rest = self.0;
        while let Some((field, behind)) = split_block(rest) {
            let value = field
                .strip_prefix(name.as_bytes())
                .and_then(|rest| rest.strip_prefix(b"="));
            if value.is_some() {
                return value;
            }
            rest = behind;
        }
        None
    }

    /// The kind of record.
    pub(crate) fn op(&self) -> Option<u8> {
        match self.bytes("op")? {
            [op] => Some(*op),
            _ => None,
        }
    }

    /// A number of four bytes.
    pub(crate) fn u32(&self, name: &str) -> Option<u32> {
        Some(u32::from_le_bytes(self.bytes(name)?.try_into().ok()?))
    }

    /// A number of eight bytes.
    pub(crate) fn u64(&self, name: &str) -> Option<u64> {
        Some(u64::from_le_bytes(self.bytes(name)?.try_into().ok()?))
    }

    /// A time in nanoseconds: seconds and nanoseconds of four bytes each.
    pub(crate) fn nanos(&self, name: &str) -> Option<i64> {
        let [a, b, c, d, e, f, g, h] = *self.bytes(name)? else {
            return None;
        };
        let secs = i64::from(u32::from_le_bytes([a, b, c, d]));
        let nanos = i64::from(u32::from_le_bytes([e, f, g, h]));
        Some(secs * 1_000_000_000 + nanos)
    }

    /// A text; characters that are none are replaced.
    pub(crate) fn text(&self, name: &str) -> Option<String> {
        Some(String::from_utf8_lossy(self.bytes(name)?).into_owned())
    }
}

/// A block that begins with its length in four bytes, and what follows it.
pub(crate) fn split_block(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (len, rest) = bytes.split_first_chunk::<4>()?;
    rest.split_at_checked(u32::from_le_bytes(*len) as usize)
}

/// The record at the start of `bytes`: header, data, and what follows.
pub(crate) fn split_record(bytes: &[u8]) -> Option<(Header<'_>, &[u8], &[u8])> {
    let (header, rest) = split_block(bytes)?;
    let (data, rest) = split_block(rest)?;
    Some((Header::new(header)?, data, rest))
}

/// The kinds of records.
pub(crate) mod op {
    pub(crate) const MESSAGE: u8 = 2;
    pub(crate) const BAG_HEADER: u8 = 3;
    pub(crate) const INDEX: u8 = 4;
    pub(crate) const CHUNK: u8 = 5;
    pub(crate) const CHUNK_INFO: u8 = 6;
    pub(crate) const CONNECTION: u8 = 7;
}

/// What publishes on a topic; several can publish on one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Connection {
    pub(crate) id: u32,
    pub(crate) topic: String,
    pub(crate) type_name: String,
    /// The text that defines the type and all that it consists of.
    pub(crate) definition: String,
}

impl Connection {
    /// The connection that a record describes. The topic of the record is the one that the bag was
    /// asked to record; that in the data is what the publisher called it.
    pub(crate) fn of_record(header: &Header<'_>, data: &[u8]) -> Option<Self> {
        let details = Header::new(data)?;
        Some(Connection {
            id: header.u32("conn")?,
            topic: header.text("topic")?,
            type_name: details.text("type")?,
            definition: details.text("message_definition").unwrap_or_default(),
        })
    }
}
