//! Numbers for packed states: a hash table with open addressing over the states' own storage.
//!
//! Definition: slot `h(s) >> (32 - k)` of 2^k, then the following ones (linear probing; Knuth, "The Art of
//! Computer Programming", volume 3, section 6.4, algorithm L). A slot has the 32 bits of the hash and the number
//! of its state, so that a different state is hardly ever looked at, and the table doubles without hashing
//! again; at most two thirds of the slots are taken.
//!
//! Deviation: many states are looked up at once, in passes whose memory accesses do not wait for each other: all
//! first slots, then all states that these name, then one by one what is still open. New states get their
//! numbers in the last pass, in order, so that numbers do not depend on the passes. Cost: about two cache misses
//! per look-up, which overlap; 12 to 24 bytes per state beside the packed state itself.

/// A slot that holds no state.
const FREE: u64 = u64::MAX;

/// Packed states, numbered in the order in which they were first seen.
pub(super) struct Interner {
    words: usize,
    pub(super) packed: Vec<u64>,
    /// The hash in the high half, the number in the low half.
    slots: Vec<u64>,
    shift: u32,
    count: usize,
    hashes: Vec<u32>,
    found: Vec<u64>,
}

impl Interner {
    pub(super) fn new(words: usize) -> Self {
        const FIRST_BITS: u32 = 10;
        Self {
            words,
            packed: Vec::new(),
            slots: vec![FREE; 1 << FIRST_BITS],
            shift: 32 - FIRST_BITS,
            count: 0,
            hashes: Vec::new(),
            found: Vec::new(),
        }
    }

    /// The number of states.
    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// The bytes that it takes.
    pub(super) fn bytes(&self) -> usize {
        (self.packed.len() + self.slots.len()) * size_of::<u64>()
    }

    fn state(&self, index: usize) -> &[u64] {
        &self.packed[index * self.words..(index + 1) * self.words]
    }

    /// The states of a range of numbers, one after the other.
    pub(super) fn states(&self, range: std::ops::Range<usize>) -> &[u64] {
        &self.packed[range.start * self.words..range.end * self.words]
    }

    /// The numbers of all these states (one after the other); new ones for those that are new, as long as there
    /// are at most `limit` states; `None` if there are more. The limit is less than `u32::MAX`.
    pub(super) fn intern(
        &mut self,
        states: &[u64],
        limit: usize,
        numbers: &mut Vec<u32>,
    ) -> Option<()> {
        self.look_up_first(states);
        numbers.clear();
        let each = states.chunks_exact(self.words).enumerate();
        for (at, state) in each {
            let slot = self.found[at];
            // A slot with the right hash is nearly always the right one.
            if slot != FREE
                && (slot >> 32) as u32 == self.hashes[at]
                && same(self.state(slot as u32 as usize), state)
            {
                numbers.push(slot as u32);
            } else {
                numbers.push(self.intern_one(state, self.hashes[at]));
                if self.count > limit {
                    return None;
                }
            }
        }
        Some(())
    }

    /// Hashes all states and reads the first slot of each.
    fn look_up_first(&mut self, states: &[u64]) {
        self.hashes.clear();
        let each = states.chunks_exact(self.words);
        self.hashes.extend(each.map(hash));
        self.found.clear();
        let (slots, shift) = (&self.slots, self.shift);
        let first = |hash: &u32| slots[(hash >> shift) as usize];
        self.found.extend(self.hashes.iter().map(first));
        // Reads the named states, so that the next pass finds them near.
        let mut touched = 0;
        for slot in &self.found {
            if *slot != FREE {
                touched ^= self.packed[*slot as u32 as usize * self.words];
            }
        }
        std::hint::black_box(touched);
    }

    fn intern_one(&mut self, state: &[u64], hash: u32) -> u32 {
        let mask = self.slots.len() - 1;
        let mut slot = (hash >> self.shift) as usize;
        loop {
            match self.slots[slot] {
                FREE => break,
                found
                    if (found >> 32) as u32 == hash
                        && same(self.state(found as u32 as usize), state) =>
                {
                    return found as u32;
                }
                _ => slot = (slot + 1) & mask,
            }
        }
        let index = self.count as u32;
        self.slots[slot] = u64::from(hash) << 32 | u64::from(index);
        append(&mut self.packed, state);
        self.count += 1;
        if self.count * 3 > self.slots.len() * 2 && self.shift > 0 {
            self.grow();
        }
        index
    }

    /// Doubles the table. The old slots are in the order of their hashes, but for runs across the end.
    fn grow(&mut self) {
        self.shift -= 1;
        let mask = self.slots.len() * 2 - 1;
        let mut slots = vec![FREE; mask + 1];
        for taken in self.slots.iter().filter(|s| **s != FREE) {
            let mut slot = ((taken >> 32) as u32 >> self.shift) as usize;
            while slots[slot] != FREE {
                slot = (slot + 1) & mask;
            }
            slots[slot] = *taken;
        }
        self.slots = slots;
    }
}

/// Whether two states of the same length are the same; short ones are compared without a call.
#[inline]
fn same(a: &[u64], b: &[u64]) -> bool {
    match (a, b) {
        ([a], [b]) => a == b,
        ([a, c], [b, d]) => (a ^ b) | (c ^ d) == 0,
        _ => a == b,
    }
}

/// Appends a state; short ones without a call.
#[inline]
pub(super) fn append(states: &mut Vec<u64>, state: &[u64]) {
    match *state {
        [word] => states.push(word),
        [first, second] => states.extend([first, second]),
        _ => states.extend_from_slice(state),
    }
}

/// Multiply and fold, word by word: the high half of the product mixes all bits.
#[inline]
fn hash(state: &[u64]) -> u32 {
    let mut hash = 0x9E37_79B9_7F4A_7C15_u64;
    for word in state {
        let product = u128::from(hash ^ word) * 0xD6E8_FEB8_6659_FD93_u128;
        hash = (product as u64) ^ ((product >> 64) as u64) ^ hash.rotate_left(29);
    }
    let mixed = hash.wrapping_mul(0x9FB2_1C65_1E98_DF25);
    (mixed >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_keep_their_first_number_while_the_table_grows() {
        let mut interner = Interner::new(2);
        let state = |i: u64| [i % 100, (i / 100) << 40];
        let mut numbers = Vec::new();
        for round in 0..2 {
            for block in 0..40_u64 {
                // Every state twice, and some of the block before.
                let range = (block * 500).saturating_sub(50)..(block + 1) * 500;
                let twice: Vec<u64> = range.clone().chain(range.clone()).flat_map(state).collect();
                interner.intern(&twice, 1_000_000, &mut numbers).unwrap();
                let expected: Vec<u32> = range.clone().chain(range).map(|i| i as u32).collect();
                assert_eq!(numbers, expected, "round {round}");
            }
        }
        assert_eq!(interner.len(), 20_000);
        assert_eq!(interner.states(777..778), state(777));
        assert!(
            interner
                .intern(&[u64::MAX; 2], 20_000, &mut numbers)
                .is_none()
        );
    }
}
