//! Messages as bytes: nothing is decoded on the way in or encoded on the way out.
//!
//! A serialised payload of RTPS is four bytes of encapsulation header (two of representation, two of options) and the
//! encoded message. The stack takes the header off; it is put before the bytes again, because recordings have it and
//! its representation says how to decode what follows. The two bytes of options are lost; they hold only the number of
//! padding bytes at the end.

use rustdds::RepresentationIdentifier as Representation;
use rustdds::bytes::Bytes;
use rustdds::no_key::{Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter};
use std::convert::Infallible;

/// The adapter for raw bytes.
pub(crate) struct RawAdapter;

/// Puts the header before the bytes.
#[derive(Clone, Copy)]
pub(crate) struct RawDecoder;

/// Every representation that the stack knows: what cannot be decoded later is said then, with the topic.
const REPRESENTATIONS: [Representation; 12] = [
    Representation::CDR_LE,
    Representation::CDR_BE,
    Representation::PL_CDR_LE,
    Representation::PL_CDR_BE,
    Representation::XCDR2_LE,
    Representation::XCDR2_BE,
    Representation::D_CDR2_LE,
    Representation::D_CDR2_BE,
    Representation::PL_XCDR2_LE,
    Representation::PL_XCDR2_BE,
    Representation::CDR2_LE,
    Representation::CDR2_BE,
];

impl DeserializerAdapter<Vec<u8>> for RawAdapter {
    type Error = Infallible;
    type Decoded = Vec<u8>;

    fn supported_encodings() -> &'static [Representation] {
        &REPRESENTATIONS
    }

    fn transform_decoded(decoded: Vec<u8>) -> Vec<u8> {
        decoded
    }
}

impl DefaultDecoder<Vec<u8>> for RawAdapter {
    type Decoder = RawDecoder;
    const DECODER: RawDecoder = RawDecoder;
}

impl<'de> Decode<'de, Vec<u8>> for RawDecoder {
    type Error = Infallible;

    fn decode_bytes(
        self,
        bytes: &'de [u8],
        representation: Representation,
    ) -> Result<Vec<u8>, Infallible> {
        let mut data = Vec::with_capacity(bytes.len() + 4);
        data.extend_from_slice(&representation.to_bytes());
        data.extend_from_slice(&[0, 0]);
        data.extend_from_slice(bytes);
        Ok(data)
    }
}

impl SerializerAdapter<Vec<u8>> for RawAdapter {
    type Error = Infallible;

    fn output_encoding() -> Representation {
        Representation::CDR_LE
    }

    /// The bytes have no header here; [`without_header`] has taken it off.
    fn to_bytes(value: &Vec<u8>) -> Result<Bytes, Infallible> {
        Ok(Bytes::copy_from_slice(value))
    }
}

/// The message behind its encapsulation header, if that says little-endian CDR, the one form that is sent.
pub(crate) fn without_header(data: &[u8]) -> Option<&[u8]> {
    match data {
        [0, 1, _, _, message @ ..] => Some(message),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_stands_before_the_bytes() {
        let Ok(data) = RawDecoder.decode_bytes(&[7, 8], Representation::CDR_LE);
        assert_eq!(data, [0, 1, 0, 0, 7, 8]);
        assert_eq!(without_header(&data), Some(&[7, 8][..]));
        let Ok(data) = RawDecoder.decode_bytes(&[], Representation::XCDR2_BE);
        assert_eq!(data, [0, 6, 0, 0]);
        assert_eq!(without_header(&data), None);
        assert_eq!(without_header(&[0, 1, 0]), None);
    }
}
