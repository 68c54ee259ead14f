//! Chunks: messages and the connections that they came by, compressed together.

use std::io::{self, Read};

use super::record::{Connection, op, split_record};

/// A message within a chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    pub(crate) nanos: i64,
    pub(crate) connection: u32,
    /// Where its data begin in the uncompressed chunk.
    pub(crate) start: usize,
    pub(crate) len: usize,
}

/// What a chunk holds.
#[derive(Debug, Default)]
pub(crate) struct Content {
    /// The uncompressed records.
    pub(crate) bytes: Vec<u8>,
    /// The messages in the order of their times; those of the same time as they were written.
    pub(crate) messages: Vec<Entry>,
    pub(crate) connections: Vec<Connection>,
    /// By what it is compressed; empty if that cannot be told.
    pub(crate) compression: String,
    /// What is wrong with it, and where in the uncompressed bytes.
    pub(crate) problem: Option<String>,
}

/// Uncompresses the data of a chunk. `stated` is what its header tells its length to be,
/// `is_cut` whether the file ended within it: then what could be read counts.
pub(crate) fn content(compression: &str, data: &[u8], stated: u32, is_cut: bool) -> Content {
    let mut content = Content {
        compression: compression.to_owned(),
        ..Content::default()
    };
    let result = match compression {
        "none" => read_all(data, stated, &mut content.bytes),
        "bz2" => read_all(
            bzip2::read::BzDecoder::new(data),
            stated,
            &mut content.bytes,
        ),
        "lz4" => read_all(
            lz4_flex::frame::FrameDecoder::new(data),
            stated,
            &mut content.bytes,
        ),
        other => {
            content.problem = Some(format!("its compression \"{other}\" is not known"));
            return content;
        }
    };
    let len = content.bytes.len();
    match result {
        Err(_) | Ok(()) if is_cut => content.problem = Some("the file ends within it".to_owned()),
        Err(error) => {
            content.problem = Some(format!("it cannot be uncompressed ({error})"));
            content.bytes.clear();
        }
        Ok(()) if len != stated as usize => {
            content.problem = Some(format!(
                "it holds {len} bytes, but its header tells {stated}"
            ));
        }
        Ok(()) => {}
    }
    list(&mut content);
    content
}

/// Reads at most `limit` bytes and one more, so that memory follows what is there, not what is told.
fn read_all(reader: impl Read, limit: u32, out: &mut Vec<u8>) -> io::Result<()> {
    reader
        .take(u64::from(limit) + 1)
        .read_to_end(out)
        .map(|_| ())
}

/// Lists the records of an uncompressed chunk, up to the first that is none.
fn list(content: &mut Content) {
    let whole = content.bytes.len();
    let mut rest = &content.bytes[..];
    let mut broken_at = None;
    while !rest.is_empty() {
        let at = whole - rest.len();
        let Some((header, data, behind)) = split_record(rest) else {
            broken_at = Some(at);
            break;
        };
        let start = whole - behind.len() - data.len();
        match (header.op(), header.u32("conn"), header.nanos("time")) {
            (Some(op::MESSAGE), Some(connection), Some(nanos)) => {
                let len = data.len();
                content.messages.push(Entry {
                    nanos,
                    connection,
                    start,
                    len,
                });
            }
            (Some(op::CONNECTION), ..) => match Connection::of_record(&header, data) {
                Some(connection) => content.connections.push(connection),
                None => broken_at = Some(at),
            },
            _ => broken_at = Some(at),
        }
        if broken_at.is_some() {
            break;
        }
        rest = behind;
    }
    if let Some(at) = broken_at {
        let place = format!("what follows its byte {at} is not a record");
        content.problem = Some(match content.problem.take() {
            Some(problem) => format!("{problem}; {place}"),
            None => place,
        });
    }
    content.messages.sort_by_key(|entry| entry.nanos);
}
