//! Small numbers as runs and packed bits: levels, and places in a dictionary.
//!
//! # Definition
//! Each run begins with a varint. If it is even, half of it is how often the value follows that stands in the next whole bytes;
//! if it is odd, half of it is how many groups of eight values follow, packed with the lowest bit first.
//! Source: Apache Parquet, *Encodings*, "Run Length Encoding / Bit-Packing Hybrid".

use super::Damage;
use super::thrift::Bytes;

/// The bits that hold numbers up to a largest one.
pub(super) fn bits_of(largest: u16) -> u32 {
    u16::BITS - largest.leading_zeros()
}

/// Reads `count` numbers of so many bits each (at most 32).
pub(super) fn numbers(bytes: &mut Bytes<'_>, bits: u32, count: usize) -> Result<Vec<u32>, Damage> {
    if bits > 32 {
        return Err(Damage::new(format!(
            "numbers of {bits} bits are packed, at most 32 can be"
        )));
    }
    let mut found = Vec::new();
    if bits == 0 {
        found.resize(count, 0);
        return Ok(found);
    }
    while found.len() < count {
        let head = bytes.varint()?;
        let most = (count - found.len()) as u64;
        if head & 1 == 0 {
            let mut value = [0; 4];
            let width = bits.div_ceil(8) as usize;
            value[..width].copy_from_slice(bytes.take(width)?);
            let times = (head >> 1).min(most) as usize;
            if times == 0 {
                return Err(Damage::new("a run has no values"));
            }
            found.resize(found.len() + times, u32::from_le_bytes(value));
        } else {
            let groups = usize::try_from(head >> 1).unwrap_or(usize::MAX);
            // The last group may be cut off behind its last value.
            let wanted = groups.saturating_mul(bits as usize).min(bytes.rest().len());
            let packed = bytes.take(wanted)?;
            let values = (packed.len() * 8 / bits as usize).min(most as usize);
            if values == 0 {
                return Err(Damage::new("packed numbers end before the first"));
            }
            found.extend((0..values).map(|at| unpacked(packed, at * bits as usize, bits)));
        }
    }
    Ok(found)
}

/// The number that begins at a bit.
fn unpacked(packed: &[u8], bit: usize, bits: u32) -> u32 {
    let mut word = [0; 8];
    let from = bit / 8;
    let to = packed.len().min(from + 8);
    word[..to - from].copy_from_slice(&packed[from..to]);
    let value = u64::from_le_bytes(word) >> (bit % 8);
    (value & ((1_u64 << bits) - 1)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the format's description: the numbers 0 to 7 with three bits.
    #[test]
    fn packed_numbers_are_as_the_description_has_them() {
        let packed = [0x03, 0b1000_1000, 0b1100_0110, 0b1111_1010];
        let read = numbers(&mut Bytes::new(&packed), 3, 8).expect("read");
        assert_eq!(read, [0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!([0, 1, 2, 3, 4, 255].map(bits_of), [0, 1, 2, 2, 3, 8]);
    }

    #[test]
    fn a_run_claims_no_more_than_was_asked() {
        let run = [0xFE, 0xFF, 0xFF, 0xFF, 0x0F, 1];
        let read = numbers(&mut Bytes::new(&run), 1, 3).expect("read");
        assert_eq!(read, [1, 1, 1]);
        assert!(numbers(&mut Bytes::new(&[0, 1]), 1, 3).is_err());
        assert!(numbers(&mut Bytes::new(&[3]), 1, 3).is_err());
    }
}
