//! Representatives of packed states under the symmetries of a model ([`crate::symmetry`]).
//!
//! Definition: of blocks that may be exchanged in any way, the representative has the sorted order; of the powers of one
//! permutation, the least image. Both are exchanges of bits within the state's words. Cost: reading and sorting the blocks, or an
//! image for each power, for each target of a transition.

use super::batch::Batch;
use crate::state_space::{Field, Layout, Represented};
use crate::symmetry::{Class, Symmetry};

/// Symmetries on packed states.
#[derive(Clone, Debug)]
pub(super) struct Orbits {
    classes: Vec<Compiled>,
    words: usize,
    keys: Vec<u64>,
    image: Vec<u64>,
    least: Vec<u64>,
}

#[derive(Clone, Debug)]
enum Compiled {
    /// For each block, where each piece of its key lies.
    Blocks {
        pieces: Vec<Piece>,
        places: Vec<Vec<Place>>,
    },
    Powers(Vec<Power>),
}

/// Some bits of a block's key.
#[derive(Clone, Copy, Debug)]
struct Piece {
    offset: u32,
    width: u32,
}

#[derive(Clone, Copy, Debug)]
struct Place {
    word: usize,
    shift: u32,
}

/// A permutation: what stays of each word, and the bits that are moved.
#[derive(Clone, Debug)]
struct Power {
    keep: Vec<u64>,
    moves: Vec<(Place, Place, u32)>,
}

/// So many lowest bits.
fn low_bits(width: u32) -> u64 {
    u64::MAX.checked_shr(64 - width).unwrap_or(0)
}

fn place(field: &Field) -> Place {
    Place {
        word: field.word,
        shift: field.shift,
    }
}

fn width(field: &Field) -> u32 {
    field.mask.count_ones()
}

/// Whether bits at `b` follow those at `a`, of which there are `width`.
fn follows(a: Place, width: u32, b: Place) -> bool {
    a.word == b.word && a.shift + width == b.shift
}

impl Orbits {
    /// Nothing if there is no symmetry whose classes fit into words.
    pub fn new(symmetry: &Symmetry, layout: &Layout) -> Option<Self> {
        let compile = |class: &Class| match class {
            Class::Blocks(blocks) => blocks_of(blocks, layout),
            Class::Powers(powers) => {
                let power = |pairs: &Vec<(usize, usize)>| power_of(pairs, layout);
                Some(Compiled::Powers(powers.iter().map(power).collect()))
            }
        };
        let classes: Vec<Compiled> = symmetry.classes.iter().filter_map(compile).collect();
        (!classes.is_empty()).then(|| Self {
            classes,
            words: layout.words(),
            keys: Vec::new(),
            image: Vec::new(),
            least: Vec::new(),
        })
    }

    /// Replaces states, one after the other, with their representatives.
    pub fn represent(&mut self, states: &mut [u64]) {
        for class in &self.classes {
            for state in states.chunks_exact_mut(self.words) {
                match class {
                    Compiled::Blocks { pieces, places } => {
                        sort_blocks(pieces, places, state, &mut self.keys);
                    }
                    Compiled::Powers(powers) => {
                        self.least.clear();
                        self.least.extend_from_slice(state);
                        for power in powers {
                            power.apply(state, &mut self.image);
                            if self.image < self.least {
                                self.least.copy_from_slice(&self.image);
                            }
                        }
                        state.copy_from_slice(&self.least);
                    }
                }
            }
        }
    }

    /// How many states a representative stands for.
    pub fn size(&mut self, state: &[u64]) -> u64 {
        let mut size = 1_u64;
        for class in &self.classes {
            size = size.saturating_mul(match class {
                Compiled::Blocks { pieces, places } => {
                    read_keys(pieces, places, state, &mut self.keys);
                    self.keys.sort_unstable();
                    arrangements(&self.keys)
                }
                Compiled::Powers(powers) => {
                    let stays = powers.iter().filter(|power| {
                        power.apply(state, &mut self.image);
                        self.image == state
                    });
                    let stays = 1 + stays.count();
                    ((powers.len() + 1) / stays) as u64
                }
            });
        }
        size
    }

    /// Counts what the expanded states of a batch stand for, and replaces their targets with representatives.
    ///
    /// `rows` says whether each choice is a row of its own.
    pub fn fold(&mut self, batch: &mut Batch<impl Sized>, rows: bool) {
        let words = self.words;
        let (mut choice, mut outcome) = (0, 0);
        let mut sum = Represented::default();
        for (end, state) in batch.ends.iter().zip(batch.states.chunks_exact(words)) {
            let choices = &batch.choices[choice..*end as usize];
            let mut transitions = 0;
            let mut first = outcome;
            for (place, (stop, _)) in choices.iter().enumerate() {
                outcome = *stop as usize;
                if rows || place + 1 == choices.len() {
                    transitions += distinct(&batch.targets[first * words..outcome * words], words);
                    first = outcome;
                }
            }
            let size = self.size(state);
            sum.states = sum.states.saturating_add(size);
            sum.transitions =
                (sum.transitions).saturating_add(size.saturating_mul(transitions.max(1)));
            if transitions == 0 {
                sum.deadlocks = sum.deadlocks.saturating_add(size);
            }
            choice = *end as usize;
        }
        batch.represented = sum;
        self.represent(&mut batch.targets);
    }
}

/// The number of different states.
fn distinct(states: &[u64], words: usize) -> u64 {
    let mut all: Vec<&[u64]> = states.chunks_exact(words).collect();
    all.sort_unstable();
    all.dedup();
    all.len() as u64
}

/// In how many orders these sorted keys can be: the factorial of their number over those of the numbers of equal ones.
fn arrangements(keys: &[u64]) -> u64 {
    let (mut count, mut equal) = (1_u128, 0);
    for (place, key) in keys.iter().enumerate() {
        equal = match place > 0 && keys[place - 1] == *key {
            true => equal + 1,
            false => 1,
        };
        // An integer at each step: a binomial coefficient times what was before.
        count = count.saturating_mul(place as u128 + 1) / equal;
    }
    u64::try_from(count).unwrap_or(u64::MAX)
}

/// Nothing if a block does not fit into a word.
fn blocks_of(blocks: &[Vec<usize>], layout: &Layout) -> Option<Compiled> {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut places: Vec<Vec<Place>> = vec![Vec::new(); blocks.len()];
    let mut offset = 0;
    for at in 0..blocks[0].len() {
        let fields: Vec<Field> = blocks.iter().map(|block| layout.field(block[at])).collect();
        let width = width(&fields[0]);
        if width == 0 {
            continue;
        }
        let goes_on = pieces.last().is_some_and(|piece| {
            let pairs = fields.iter().zip(&places);
            pairs.into_iter().all(|(field, of_block)| {
                (of_block.last()).is_some_and(|last| follows(*last, piece.width, place(field)))
            })
        });
        match pieces.last_mut() {
            Some(piece) if goes_on => piece.width += width,
            _ => {
                pieces.push(Piece { offset, width });
                for (of_block, field) in places.iter_mut().zip(&fields) {
                    of_block.push(place(field));
                }
            }
        }
        offset += width;
    }
    (offset <= 64 && offset > 0).then_some(Compiled::Blocks { pieces, places })
}

fn power_of(pairs: &[(usize, usize)], layout: &Layout) -> Power {
    let mut power = Power {
        keep: vec![u64::MAX; layout.words()],
        moves: Vec::new(),
    };
    for (from, to) in pairs {
        let (from, to) = (layout.field(*from), layout.field(*to));
        power.keep[to.word] &= !(to.mask << to.shift);
        let own = width(&from);
        match power.moves.last_mut() {
            Some((before, after, width))
                if follows(*before, *width, place(&from))
                    && follows(*after, *width, place(&to)) =>
            {
                *width += own;
            }
            _ if own > 0 => power.moves.push((place(&from), place(&to), own)),
            _ => {}
        }
    }
    power
}

impl Power {
    fn apply(&self, state: &[u64], image: &mut Vec<u64>) {
        image.clear();
        image.extend(state.iter().zip(&self.keep).map(|(word, keep)| word & keep));
        for (from, to, width) in &self.moves {
            let bits = (state[from.word] >> from.shift) & low_bits(*width);
            image[to.word] |= bits << to.shift;
        }
    }
}

fn read_keys(pieces: &[Piece], places: &[Vec<Place>], state: &[u64], keys: &mut Vec<u64>) {
    keys.clear();
    keys.extend(places.iter().map(|places| {
        let parts = pieces.iter().zip(places);
        parts.fold(0, |key, (piece, place)| {
            key | ((state[place.word] >> place.shift) & low_bits(piece.width)) << piece.offset
        })
    }));
}

fn sort_blocks(pieces: &[Piece], places: &[Vec<Place>], state: &mut [u64], keys: &mut Vec<u64>) {
    read_keys(pieces, places, state, keys);
    if keys.is_sorted() {
        return;
    }
    keys.sort_unstable();
    for (key, places) in keys.iter().zip(places) {
        for (piece, place) in pieces.iter().zip(places) {
            let mask = low_bits(piece.width);
            let word = &mut state[place.word];
            *word = *word & !(mask << place.shift) | ((key >> piece.offset) & mask) << place.shift;
        }
    }
}
