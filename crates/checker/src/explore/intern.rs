//! Numbers for packed states: a hash table with open addressing over the states' own storage.
//!
//! Definition: slot `h(s) mod 2^k`, then the following ones (linear probing; Knuth, "The Art of Computer
//! Programming", volume 3, section 6.4, algorithm L); at most half of the slots are taken. Cost: 8 to 16
//! bytes per state beside the packed state itself.

/// A slot that holds no state.
const FREE: u32 = u32::MAX;

/// Packed states, numbered in the order in which they were first seen.
pub(super) struct Interner {
    words: usize,
    pub(super) packed: Vec<u64>,
    slots: Vec<u32>,
    count: usize,
}

impl Interner {
    pub(super) fn new(words: usize) -> Self {
        Self {
            words,
            packed: Vec::new(),
            slots: vec![FREE; 1024],
            count: 0,
        }
    }

    /// The number of states.
    pub(super) fn len(&self) -> usize {
        self.count
    }

    pub(super) fn state(&self, index: usize) -> &[u64] {
        &self.packed[index * self.words..(index + 1) * self.words]
    }

    /// The number of this state; a new number if it is new. There must be fewer than `u32::MAX` states.
    pub(super) fn intern(&mut self, state: &[u64]) -> u32 {
        let mask = self.slots.len() - 1;
        let mut slot = hash(state) as usize & mask;
        loop {
            match self.slots[slot] {
                FREE => break,
                found if self.state(found as usize) == state => return found,
                _ => slot = (slot + 1) & mask,
            }
        }
        let index = self.count as u32;
        self.slots[slot] = index;
        self.packed.extend_from_slice(state);
        self.count += 1;
        if self.count * 2 > self.slots.len() {
            self.grow();
        }
        index
    }

    fn grow(&mut self) {
        let size = self.slots.len() * 2;
        let mask = size - 1;
        let mut slots = vec![FREE; size];
        for index in 0..self.count {
            let mut slot = hash(self.state(index)) as usize & mask;
            while slots[slot] != FREE {
                slot = (slot + 1) & mask;
            }
            slots[slot] = index as u32;
        }
        self.slots = slots;
    }
}

/// Multiply and fold, word by word: the high half of the product mixes all bits.
fn hash(state: &[u64]) -> u64 {
    let mut hash = 0x9E37_79B9_7F4A_7C15_u64;
    for word in state {
        let product = u128::from(hash ^ word) * 0xD6E8_FEB8_6659_FD93_u128;
        hash = (product as u64) ^ ((product >> 64) as u64) ^ hash.rotate_left(29);
    }
    hash ^ (hash >> 32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_keep_their_first_number_while_the_table_grows() {
        let mut interner = Interner::new(2);
        let state = |i: u64| [i % 100, (i / 100) << 40];
        for i in 0..20_000 {
            assert_eq!(interner.intern(&state(i)), i as u32);
        }
        for i in 0..20_000 {
            assert_eq!(interner.intern(&state(i)), i as u32);
            assert_eq!(interner.state(i as usize), state(i));
        }
        assert_eq!(interner.len(), 20_000);
    }
}
