//! The pages of a column: decompressed, checked, and their values read.
//!
//! # Definition
//! A page is a header (a structure of Thrift) and a body. The body of a page of data has levels, which say where values are and
//! where lists begin, and the values that are there: one after the other (PLAIN), as places in the page of the dictionary, or
//! truth values as runs (RLE). Source: Apache Parquet, *Data pages* (versions 1 and 2), *Encodings*, *Compression*.

use super::levels::{bits_of, numbers};
use super::schema::{Chunk, Leaf};
use super::thrift::{Bytes, Item};
use super::{ColumnValues, Damage, ParquetRows};
use std::borrow::Cow;
use std::io::Read;

/// Times that a page may be larger than it is compressed: no more than Zstandard's empty frames and runs reach in practice.
const MOST_TIMES: usize = 1 << 12;
/// What a small page may have in any case.
const SMALL: usize = 1 << 16;

/// Reads a chunk of a column into its rows.
pub(super) fn chunk(
    file: &[u8],
    leaf: &Leaf,
    chunk: &Chunk,
    into: &mut ParquetRows,
) -> Result<(), Damage> {
    let mut bytes = Bytes::new(&file[chunk.start..chunk.end]);
    let mut dictionary = None;
    let mut seen = 0;
    while seen < chunk.values {
        let at = chunk.start + bytes.read();
        let place = |damage: Damage| damage.at(at).of(leaf);
        let header = bytes.structure().map_err(place)?;
        let compressed = header
            .count(3)
            .ok_or_else(|| place(Damage::new("a page has no size")))?;
        let page = Page {
            header: &header,
            body: bytes.take(compressed).map_err(place)?,
            codec: chunk.codec,
        };
        match header.int(1) {
            Some(0 | 3) => {
                seen += page
                    .values(leaf, dictionary.as_ref(), chunk.values - seen, into)
                    .map_err(place)?;
            }
            Some(2) => dictionary = Some(page.dictionary(leaf).map_err(place)?),
            _ => {}
        }
    }
    Ok(())
}

struct Page<'a> {
    header: &'a Item<'a>,
    body: &'a [u8],
    codec: i64,
}

impl Page<'_> {
    /// The body as it was before compression, of which the first bytes may not be compressed.
    fn plain(&self, plain: usize) -> Result<Cow<'_, [u8]>, Damage> {
        if let Some(stated) = self.header.int(4)
            && crc32fast::hash(self.body) != stated as u32
        {
            return Err(Damage::new("the checksum of a page is another"));
        }
        let whole = self.header.count(2).unwrap_or(0);
        if whole
            > self
                .body
                .len()
                .saturating_mul(MOST_TIMES)
                .saturating_add(SMALL)
        {
            return Err(Damage::new(format!(
                "a page of {} bytes claims to hold {whole}",
                self.body.len()
            )));
        }
        let (head, rest) = self
            .body
            .split_at_checked(plain)
            .ok_or_else(|| Damage::new("a page ends within its levels"))?;
        let wanted = whole.saturating_sub(plain);
        let is_compressed = self
            .header
            .field(8)
            .and_then(|it| it.bool(7))
            .unwrap_or(true);
        if self.codec == 0 || !is_compressed || wanted == 0 && rest.is_empty() {
            return Ok(Cow::Borrowed(self.body));
        }
        let mut body = head.to_vec();
        body.extend(decompressed(self.codec, rest, wanted)?);
        match body.len() == whole {
            true => Ok(Cow::Owned(body)),
            false => Err(Damage::new(format!(
                "a page should hold {whole} bytes, and holds {}",
                body.len()
            ))),
        }
    }

    fn dictionary(&self, leaf: &Leaf) -> Result<ColumnValues, Damage> {
        let about = self.header.field(7);
        let count = about.and_then(|it| it.count(1)).unwrap_or(0);
        let body = self.plain(0)?;
        let mut values = ColumnValues::of_kind(leaf.kind)?;
        plain_values(&mut Bytes::new(&body), count, &mut values)?;
        Ok(values)
    }

    /// Reads the values of a page; gives how many levels it has.
    fn values(
        &self,
        leaf: &Leaf,
        dictionary: Option<&ColumnValues>,
        most: usize,
        into: &mut ParquetRows,
    ) -> Result<usize, Damage> {
        let second = self.header.field(8);
        let about = second
            .or_else(|| self.header.field(5))
            .ok_or_else(|| Damage::new("a page of data does not say what it has"))?;
        let count = about.count(1).unwrap_or(0);
        if count > most {
            return Err(Damage::new(format!(
                "a page claims {count} of the {most} values that are left"
            )));
        }
        let sizes = second.map(|it| (it.count(6).unwrap_or(0), it.count(5).unwrap_or(0)));
        let body =
            self.plain(sizes.map_or(0, |(repeated, defined)| repeated.saturating_add(defined)))?;
        let mut bytes = Bytes::new(&body);
        let repeated = levels(&mut bytes, leaf.repeated, count, sizes.map(|it| it.0))?;
        let defined = levels(&mut bytes, leaf.defined, count, sizes.map(|it| it.1))?;
        let there = defined
            .iter()
            .filter(|it| **it == u32::from(leaf.defined))
            .count();
        // The second version says its encoding behind three counts.
        let encoding = about
            .int(if second.is_some() { 4 } else { 2 })
            .unwrap_or(-1);
        let before = into.values.len();
        match (encoding, dictionary) {
            (0, _) => plain_values(&mut bytes, there, &mut into.values)?,
            (3, _) => runs(&mut bytes, there, &mut into.values)?,
            (2 | 8, Some(dictionary)) => {
                let bits = bytes.byte()?;
                let places = numbers(&mut bytes, u32::from(bits), there)?;
                into.values.extend_from(dictionary, &places)?;
            }
            (2 | 8, None) => {
                return Err(Damage::new(
                    "a page refers to a dictionary that is not there",
                ));
            }
            (other, _) => {
                return Err(Damage::unread(format!(
                    "the encoding {} is not read",
                    encoding_name(other)
                )));
            }
        }
        into.add_rows(before, &repeated, &defined, leaf)?;
        Ok(count)
    }
}

/// The levels of a page, all zero where a column has none.
fn levels(
    bytes: &mut Bytes<'_>,
    largest: u16,
    count: usize,
    size: Option<usize>,
) -> Result<Vec<u32>, Damage> {
    if largest == 0 {
        bytes.take(size.unwrap_or(0))?;
        return numbers(bytes, 0, count);
    }
    let size = match size {
        Some(size) => size,
        None => bytes.u32()?,
    };
    numbers(&mut Bytes::new(bytes.take(size)?), bits_of(largest), count)
}

/// Values one after the other.
fn plain_values(
    bytes: &mut Bytes<'_>,
    count: usize,
    into: &mut ColumnValues,
) -> Result<(), Damage> {
    match into {
        ColumnValues::Bool(all) => {
            let packed = bytes.take(count.div_ceil(8))?;
            all.extend((0..count).map(|at| packed[at / 8] >> (at % 8) & 1 == 1));
        }
        ColumnValues::Int32(all) => all.extend(each(bytes.take(count.saturating_mul(4))?, |it| {
            i64::from(i32::from_le_bytes(it))
        })),
        ColumnValues::Int64(all) => all.extend(each(
            bytes.take(count.saturating_mul(8))?,
            i64::from_le_bytes,
        )),
        ColumnValues::Float(all) => all.extend(each(bytes.take(count.saturating_mul(4))?, |it| {
            f64::from(f32::from_le_bytes(it))
        })),
        ColumnValues::Double(all) => all.extend(each(
            bytes.take(count.saturating_mul(8))?,
            f64::from_le_bytes,
        )),
        ColumnValues::Bytes(all) => {
            for _ in 0..count {
                let length = bytes.u32()?;
                all.push(bytes.take(length)?.to_vec());
            }
        }
    }
    Ok(())
}

fn each<const N: usize, T>(bytes: &[u8], read: impl Fn([u8; N]) -> T) -> impl Iterator<Item = T> {
    bytes.as_chunks::<N>().0.iter().map(move |it| read(*it))
}

/// Truth values as runs, with their size before them.
fn runs(bytes: &mut Bytes<'_>, count: usize, into: &mut ColumnValues) -> Result<(), Damage> {
    let ColumnValues::Bool(all) = into else {
        return Err(Damage::unread(
            "values other than truth values are written as runs",
        ));
    };
    let size = bytes.u32()?;
    let read = numbers(&mut Bytes::new(bytes.take(size)?), 1, count)?;
    all.extend(read.into_iter().map(|it| it == 1));
    Ok(())
}

fn decompressed(codec: i64, bytes: &[u8], wanted: usize) -> Result<Vec<u8>, Damage> {
    let damaged = |error: String| Damage::new(format!("a page cannot be decompressed: {error}"));
    match codec {
        1 => {
            let stated =
                snap::raw::decompress_len(bytes).map_err(|error| damaged(error.to_string()))?;
            if stated != wanted {
                return Err(damaged(format!(
                    "it holds {stated} bytes, and its header says {wanted}"
                )));
            }
            snap::raw::Decoder::new()
                .decompress_vec(bytes)
                .map_err(|error| damaged(error.to_string()))
        }
        6 => {
            let mut plain = Vec::new();
            let decoder = zstd::Decoder::new(bytes).map_err(|error| damaged(error.to_string()))?;
            // One byte more shows that there are more.
            let most = wanted as u64 + 1;
            decoder
                .take(most)
                .read_to_end(&mut plain)
                .map_err(|error| damaged(error.to_string()))?;
            Ok(plain)
        }
        7 => lz4_flex::block::decompress(bytes, wanted).map_err(|error| damaged(error.to_string())),
        other => Err(Damage::unread(format!(
            "the compression {} is not read",
            codec_name(other)
        ))),
    }
}

fn codec_name(number: i64) -> String {
    match number {
        2 => "GZIP".to_owned(),
        3 => "LZO".to_owned(),
        4 => "BROTLI".to_owned(),
        5 => "LZ4 (the old form)".to_owned(),
        other => format!("number {other}"),
    }
}

fn encoding_name(number: i64) -> String {
    match number {
        4 => "BIT_PACKED".to_owned(),
        5 => "DELTA_BINARY_PACKED".to_owned(),
        6 => "DELTA_LENGTH_BYTE_ARRAY".to_owned(),
        7 => "DELTA_BYTE_ARRAY".to_owned(),
        9 => "BYTE_STREAM_SPLIT".to_owned(),
        other => format!("number {other}"),
    }
}
