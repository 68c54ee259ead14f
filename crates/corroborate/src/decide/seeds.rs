//! The seeds of a test's trials: one stream, declared by one number.
//!
//! # Definition
//! Trial `n` of stream `s` has the seed `p(n)`, where `p` is a permutation of the numbers below 2^31 that a hash of `s` keys: an
//! exclusive or, and twice a product with an odd constant and a shift, each of which can be undone. Where `p(n)` is 0, which some
//! programs take for "a seed of your choice", `p(0)` stands for it.
//!
//! # Source
//! The constants are those of D. Wellons' `lowbias32` (2018). Cost: constant.
//!
//! # Assumes
//! Fewer than 2^31 trials.
//!
//! # Guarantee
//! Seeds of one stream are positive, below 2^31 (so that programs with signed 32-bit seeds take them) and all different. Neighbouring
//! trials have seeds that look unrelated: a generator that is seeded with neighbouring numbers may begin alike.

use host::store::Inputs;

/// The bits of a seed.
const BITS: u32 = 31;
const MASK: u32 = (1 << BITS) - 1;

/// The seed of a trial, numbered from 1, of a stream.
///
/// ```
/// use corroborate::decide::seed_of;
/// assert_eq!(seed_of(1, 1), seed_of(1, 1));
/// assert_ne!(seed_of(1, 1), seed_of(1, 2));
/// assert_ne!(seed_of(1, 1), seed_of(2, 1));
/// ```
#[must_use]
pub fn seed_of(stream: u64, trial: u64) -> u64 {
    let mut inputs = Inputs::default();
    inputs.add("stream of seeds", &stream.to_le_bytes());
    let key = u32::from_str_radix(&inputs.hash()[..8], 16).unwrap_or_default();
    let number = (trial & u64::from(MASK)) as u32;
    u64::from(match permuted(number, key) {
        0 => permuted(0, key),
        seed => seed,
    })
}

fn permuted(number: u32, key: u32) -> u32 {
    let mut x = (number ^ key) & MASK;
    for constant in [0x7feb_352d_u32, 0x846c_a68b] {
        x = x.wrapping_mul(constant) & MASK;
        x ^= x >> 15;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn seeds_are_positive_different_and_below_two_to_the_31() {
        for stream in [0, 1, 2, u64::MAX] {
            let seeds: BTreeSet<u64> = (1..=20_000).map(|n| seed_of(stream, n)).collect();
            assert_eq!(seeds.len(), 20_000);
            assert!(seeds.iter().all(|seed| (1..1 << 31).contains(seed)));
        }
    }

    #[test]
    fn a_seed_keeps_its_meaning() {
        // Journals and findings name them.
        assert_eq!(
            [1, 2, 3].map(|n| seed_of(1, n)),
            [313_238_505, 954_104_777, 51_831_801]
        );
    }
}
