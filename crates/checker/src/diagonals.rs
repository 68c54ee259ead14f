//! Sparse matrices of models by diagonals of small blocks: products without an index and a number for each entry.
//!
//! *Definition.* States are ordered by the values of their variables, the last one fastest, and rows are taken eight at a time.
//! Entries of such a block whose columns are as far from their rows belong to one diagonal: eight numbers, of which
//! some may be 0, and the column of the first. In a model made of variables a command moves states that differ in the last
//! variables only by the same distance at the same rate, so that there are few different diagonals, each of them often, and most are
//! full. A diagonal takes 8 bytes for up to eight entries instead of 12 bytes for each, and is multiplied without looking
//! entries up one by one.
//!
//! Blocks begin anew where variables other than the last ones change (as few last variables as leave little room unused), so that
//! the same things lie at the same places in their blocks. Where too few entries share a diagonal, or too many diagonals are
//! different, there is no such form.
//!
//! Source: storage by diagonals (Saad 2003, "Iterative methods for sparse linear systems", section 3.4), here block by block,
//! with each different diagonal stored once. Cost: sorting the states and the entries of each block, then 8 bytes for a
//! diagonal. Guarantee: a product is the sum of the row's terms, in another order, and of zeros.

use rustc_hash::FxHashMap;

/// Rows of a block.
pub(crate) const LANES: usize = 8;
/// How many rows may be left unused for each that is used.
const MOST_UNUSED: f64 = 0.2;
/// At least so many entries must share a diagonal on average.
const LEAST_SHARED: usize = 3;
/// At most one of so many diagonals may be another one.
const LEAST_SAME: usize = 8;

/// Numbers by which states are ordered.
#[derive(Debug)]
pub(crate) struct Keys {
    /// Of each state.
    pub of: Vec<u64>,
    /// How many low bits belong to the last one, two, ... variables.
    pub cuts: Vec<u32>,
}

/// Where states are among the rows of the blocks.
#[derive(Debug)]
pub(crate) struct Order {
    /// The state of each row; [`UNUSED`] if there is none.
    pub states: Vec<u32>,
    /// The row of each state; [`UNUSED`] if it is not in the matrix.
    pub row: Vec<u32>,
}

/// No state, or no row.
pub(crate) const UNUSED: u32 = u32::MAX;

impl Order {
    /// Of some states.
    pub fn new(keys: &Keys, states: impl Iterator<Item = u32>) -> Self {
        let mut sorted: Vec<(u64, u32)> = states.map(|s| (keys.of[s as usize], s)).collect();
        sorted.sort_unstable();
        let cut = cut(keys, &sorted);
        let mut order = Self {
            states: Vec::with_capacity(sorted.len() + sorted.len() / 4),
            row: vec![UNUSED; keys.of.len()],
        };
        for same in sorted.chunk_by(|a, b| high(a.0, cut) == high(b.0, cut)) {
            for (_, state) in same {
                order.row[*state as usize] = order.states.len() as u32;
                order.states.push(*state);
            }
            let full = order.states.len().next_multiple_of(LANES);
            order.states.resize(full, UNUSED);
        }
        order
    }
}

fn high(key: u64, cut: u32) -> u64 {
    key.checked_shr(cut).unwrap_or(0)
}

/// After how many low bits blocks begin anew.
fn cut(keys: &Keys, sorted: &[(u64, u32)]) -> u32 {
    let most = sorted.len() + (MOST_UNUSED * sorted.len() as f64) as usize;
    let fits = |cut: &u32| {
        let parts = sorted.chunk_by(|a, b| high(a.0, *cut) == high(b.0, *cut));
        let rows = parts.map(|part| part.len().next_multiple_of(LANES));
        rows.sum::<usize>() <= most
    };
    let wide = keys
        .cuts
        .iter()
        .copied()
        .filter(|cut| 1 << *cut >= LANES as u64);
    wide.into_iter().find(fits).unwrap_or(64)
}

/// A matrix by diagonals.
#[derive(Debug)]
pub(crate) struct Diagonals {
    /// Where the diagonals of each block start; one entry more than there are blocks.
    start: Vec<u32>,
    /// The column of the first entry, with [`LANES`] added, and which diagonal it is.
    tiles: Vec<(u32, u32)>,
    weights: Vec<[f64; LANES]>,
    longest: usize,
}

impl Diagonals {
    /// `entries` gives the entries of a state's row by their target states, which are in the order. Nothing if there is little to be
    /// gained.
    pub fn new(order: &Order, entries: impl Fn(usize, &mut Vec<(u32, f64)>)) -> Option<Self> {
        let mut matrix = Self {
            start: vec![0],
            tiles: Vec::new(),
            weights: Vec::new(),
            longest: 0,
        };
        let mut known: FxHashMap<[u64; LANES], u32> = FxHashMap::default();
        let mut of_row = Vec::new();
        let mut of_block: Vec<(u32, u8, f64)> = Vec::new();
        let mut seen = 0;
        for states in order.states.chunks_exact(LANES) {
            of_block.clear();
            for (lane, state) in states.iter().enumerate().filter(|(_, s)| **s != UNUSED) {
                of_row.clear();
                entries(*state as usize, &mut of_row);
                matrix.longest = matrix.longest.max(of_row.len());
                of_block.extend(of_row.iter().map(|(target, weight)| {
                    let column = order.row[*target as usize] + (LANES - lane) as u32;
                    (column, lane as u8, *weight)
                }));
            }
            of_block.sort_unstable_by_key(|(column, lane, _)| (*column, *lane));
            seen += of_block.len();
            for diagonal in of_block.chunk_by(|a, b| a.0 == b.0) {
                let mut weights = [0.0_f64; LANES];
                for (_, lane, weight) in diagonal {
                    weights[usize::from(*lane)] = *weight;
                }
                let new = matrix.weights.len() as u32;
                let which = *known.entry(weights.map(f64::to_bits)).or_insert(new);
                if which == new {
                    matrix.weights.push(weights);
                }
                matrix.tiles.push((diagonal[0].0, which));
            }
            matrix.start.push(matrix.tiles.len() as u32);
            let tiles = matrix.tiles.len();
            let is_poor = seen < LEAST_SHARED * tiles || matrix.weights.len() * LEAST_SAME > tiles;
            if is_poor && tiles > SAMPLE {
                return None;
            }
        }
        Some(matrix)
    }

    /// The greatest number of entries of a row.
    pub fn longest(&self) -> usize {
        self.longest
    }

    /// The product of a block's rows with a vector that has [`LANES`] numbers more at both ends.
    #[inline]
    pub fn product(&self, block: usize, vector: &[f64]) -> [f64; LANES] {
        let mut sums = [0.0; LANES];
        let range = self.start[block] as usize..self.start[block + 1] as usize;
        for (column, which) in &self.tiles[range] {
            let weights = &self.weights[*which as usize];
            let numbers = &vector[*column as usize..*column as usize + LANES];
            for lane in 0..LANES {
                sums[lane] += weights[lane] * numbers[lane];
            }
        }
        sums
    }
}

/// Diagonals after which it shows whether the form is worth it.
const SAMPLE: usize = 20_000;

#[cfg(test)]
mod tests {
    use super::*;

    /// A walk on a grid of `side` times `side` places, with a jump from each corner to the opposite one.
    fn grid(side: u32) -> (Keys, Vec<Vec<(u32, f64)>>) {
        let at = |x: u32, y: u32| x * side + y;
        let mut rows = Vec::new();
        for (x, y) in (0..side * side).map(|s| (s / side, s % side)) {
            let mut row = vec![(at(x, y), 0.25)];
            row.extend((x > 0).then(|| (at(x - 1, y), 0.5)));
            row.extend((x + 1 < side).then(|| (at(x + 1, y), 0.125)));
            row.extend((y + 1 < side).then(|| (at(x, y + 1), 0.375)));
            row.extend((x == 0 && y == 0).then(|| (at(side - 1, side - 1), 2.0)));
            rows.push(row);
        }
        let of = (0..side * side).map(|s| u64::from(s / side) << 6 | u64::from(s % side));
        let keys = Keys {
            of: of.collect(),
            cuts: vec![6, 12],
        };
        (keys, rows)
    }

    #[test]
    fn products_are_those_of_the_rows() {
        for (side, all) in [(40, true), (40, false), (61, true)] {
            let (keys, rows) = grid(side);
            let count = side * side;
            // Some states may be left out, with the entries that lead to them.
            let kept = |s: &u32| all || s % 7 != 3;
            let order = Order::new(&keys, (0..count).filter(kept));
            let entries = |state: usize, into: &mut Vec<(u32, f64)>| {
                into.extend(
                    rows[state]
                        .iter()
                        .copied()
                        .filter(|(target, _)| kept(target)),
                );
            };
            let matrix = Diagonals::new(&order, entries).unwrap();
            let mut vector = vec![0.0; order.states.len() + 2 * LANES];
            for (place, state) in order
                .states
                .iter()
                .enumerate()
                .filter(|(_, s)| **s != UNUSED)
            {
                vector[place + LANES] = f64::from(*state % 11);
            }
            for block in 0..order.states.len() / LANES {
                let product = matrix.product(block, &vector);
                for (lane, found) in product.into_iter().enumerate() {
                    let state = order.states[block * LANES + lane];
                    let row = rows.get(state as usize).into_iter().flatten();
                    let row = row.filter(|(target, _)| kept(target));
                    let expected = row
                        .map(|(target, w)| w * f64::from(*target % 11))
                        .sum::<f64>();
                    assert_eq!(found, expected, "{state}");
                }
            }
        }
    }

    #[test]
    fn blocks_begin_anew_where_the_first_variables_change() {
        let (keys, _) = grid(40);
        let order = Order::new(&keys, 0..1600);
        assert_eq!(order.states.len(), 1600);
        // Of 61 places 64 are taken.
        let (keys, _) = grid(61);
        let order = Order::new(&keys, 0..61 * 61);
        assert_eq!(order.states.len(), 61 * 64);
        assert_eq!((order.row[61], order.states[61]), (64, UNUSED));
    }

    #[test]
    fn a_matrix_without_order_has_no_such_form() {
        // Where to go from each state has nothing to do with its number.
        let states = 60_000_u32;
        let keys = Keys {
            of: (0..u64::from(states)).collect(),
            cuts: vec![16],
        };
        let order = Order::new(&keys, 0..states);
        let entries = |state: usize, into: &mut Vec<(u32, f64)>| {
            let target = (state as u32).wrapping_mul(2_654_435_761) % states;
            into.push((target, 1.0));
        };
        assert!(Diagonals::new(&order, entries).is_none());
    }
}
