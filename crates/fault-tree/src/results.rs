//! A table of results that forgets: each key has one slot, and a later result takes it. Its size follows what it serves, up
//! to a limit, so it bounds memory and only ever costs time.

/// Entries at first, and at most.
const SIZES: (usize, usize) = (1 << 12, 1 << 22);

/// An operation on two nodes.
pub(crate) type Key = (u32, u32, u8);

#[derive(Clone, Copy)]
struct Entry {
    key: Key,
    result: u32,
}

pub(crate) struct Results {
    entries: Vec<Option<Entry>>,
}

impl Results {
    pub fn new() -> Self {
        Self {
            entries: vec![None; SIZES.0],
        }
    }

    pub fn get(&self, key: Key) -> Option<u32> {
        let entry = self.entries[self.slot(key)]?;
        (entry.key == key).then_some(entry.result)
    }

    /// Keeps a result; `nodes` is how many there are, by which the table grows.
    pub fn put(&mut self, key: Key, result: u32, nodes: usize) {
        if self.entries.len() < SIZES.1 && nodes > self.entries.len() {
            let size = self.entries.len() * 4;
            let old = std::mem::replace(&mut self.entries, vec![None; size]);
            for entry in old.into_iter().flatten() {
                let slot = self.slot(entry.key);
                self.entries[slot] = Some(entry);
            }
        }
        let slot = self.slot(key);
        self.entries[slot] = Some(Entry { key, result });
    }

    fn slot(&self, key: Key) -> usize {
        let mixed = (u64::from(key.0) << 32 | u64::from(key.1)).wrapping_add(u64::from(key.2));
        let mixed = mixed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        (mixed >> 32) as usize & (self.entries.len() - 1)
    }
}
