//! Which commands are enabled in a state, by tables over pieces of the packed state.
//!
//! Definition: a guard is a conjunction of parts. The packed state is cut into pieces of up to [`PIECE_BITS`]
//! bits along the borders of variables. For each piece and each of its contents, a table has one bit for each
//! command: whether all parts of its guard that read only this piece hold. The conjunction of the pieces'
//! entries leaves the commands whose remaining parts (over several pieces) must be evaluated.
//!
//! Source: the bit-parallel evaluation of conjunctions over columns (Li and Patel, "BitWeaving: Fast scans for
//! main memory data processing", SIGMOD 2013), with the roles of rows and predicates exchanged. Deviation:
//! entries are computed when they are first needed. Cost: one look-up for each piece and 64 commands;
//! 2^PIECE_BITS words for each piece and 64 commands at most. Guarantee: parts behind one that may have no value
//! are evaluated after it, in the order of the text, so that what has no value is reported as by evaluation.

use super::code::Code;
use crate::state_space::{Field, Layout};

/// Bits of a piece of the state.
const PIECE_BITS: u32 = 12;

/// Marks an entry that has been computed; no command has this bit of the last word.
const KNOWN: u64 = 1 << 63;

/// A piece of the packed state with its table.
#[derive(Clone, Debug)]
struct Piece {
    word: usize,
    shift: u32,
    mask: u64,
    /// Parts of guards that read only this piece, with their commands.
    parts: Vec<(usize, Code)>,
    /// For each content, the commands that it does not disable, and [`KNOWN`] in the last word once that has
    /// been computed; empty if there are no parts.
    table: Vec<u64>,
}

/// The guards of all commands.
#[derive(Clone, Debug)]
pub(super) struct Guards {
    pieces: Vec<Piece>,
    /// For each command, what the tables do not decide, in order.
    pub(super) rest: Vec<Vec<Code>>,
    /// The commands with a rest, and all commands, as bits.
    pub(super) has_rest: Vec<u64>,
    all: Vec<u64>,
}

impl Guards {
    /// The guards, compiled, one for each command.
    pub(super) fn new(guards: Vec<Code>, layout: &Layout) -> Self {
        // One bit more than there are commands, for the mark.
        let words = guards.len() / 64 + 1;
        let mut made = Self {
            pieces: pieces(layout),
            rest: Vec::new(),
            has_rest: vec![0; words],
            all: vec![0; words],
        };
        for (command, guard) in guards.into_iter().enumerate() {
            made.all[command / 64] |= 1 << (command % 64);
            let rest = made.divide(command, guard);
            if !rest.is_empty() {
                made.has_rest[command / 64] |= 1 << (command % 64);
            }
            made.rest.push(rest);
        }
        made.all[words - 1] |= KNOWN;
        made.pieces.retain(|p| !p.parts.is_empty());
        for piece in &mut made.pieces {
            let contents = piece.mask as usize + 1;
            piece.table = vec![0; contents * words];
        }
        made
    }

    /// Gives the parts of a guard to the pieces, as far as possible; returns the others.
    fn divide(&mut self, command: usize, guard: Code) -> Vec<Code> {
        let parts = match guard {
            Code::All(parts) => parts,
            other => vec![other],
        };
        let mut rest = Vec::new();
        let mut may_fail = false;
        for part in parts {
            may_fail |= part.range().is_none();
            match self.home(&part) {
                Some(piece) if !may_fail => self.pieces[piece].parts.push((command, part)),
                _ => rest.push(part),
            }
        }
        rest
    }

    /// The piece that has all variables of a part.
    fn home(&self, part: &Code) -> Option<usize> {
        let mut fields: Vec<Field> = Vec::new();
        part.for_each_field(&mut |f| fields.push(f));
        let holds = |piece: &Piece| fields.iter().all(|f| piece.holds(f));
        self.pieces.iter().position(holds)
    }

    /// Words for one bit for each command (and one more).
    pub(super) fn words(&self) -> usize {
        self.all.len()
    }

    /// The commands that the tables do not disable, as bits, in `enabled`.
    #[inline]
    pub(super) fn tabulated(&mut self, state: &[u64], enabled: &mut [u64]) {
        enabled.copy_from_slice(&self.all);
        let words = enabled.len();
        for piece in &mut self.pieces {
            let content = (state[piece.word] >> piece.shift & piece.mask) as usize;
            let range = content * words..(content + 1) * words;
            if piece.table[range.end - 1] & KNOWN == 0 {
                piece.fill(content, state, &self.all);
            }
            let entry = &piece.table[range];
            for (enabled, entry) in enabled.iter_mut().zip(entry) {
                *enabled &= entry;
            }
        }
    }
}

impl Piece {
    fn holds(&self, field: &Field) -> bool {
        let bits = field.mask << field.shift;
        field.word == self.word && bits & !(self.mask << self.shift) == 0
    }

    /// Computes the entry of a content, which `state` has.
    #[cold]
    fn fill(&mut self, content: usize, state: &[u64], all: &[u64]) {
        let entry = &mut self.table[content * all.len()..(content + 1) * all.len()];
        entry.copy_from_slice(all);
        for (command, part) in &self.parts {
            // Every part here has a value in every state.
            if part.value(state) == Some(0) {
                entry[command / 64] &= !(1 << (command % 64));
            }
        }
    }
}

/// Cuts the packed state into pieces; a variable with more bits than a piece is in none.
fn pieces(layout: &Layout) -> Vec<Piece> {
    let mut pieces: Vec<Piece> = Vec::new();
    for variable in 0..layout.len() {
        let field = layout.field(variable);
        let width = 64 - field.mask.leading_zeros();
        if width == 0 || width > PIECE_BITS {
            continue;
        }
        let end = field.shift + width;
        match pieces.last_mut() {
            Some(piece) if piece.word == field.word && end - piece.shift <= PIECE_BITS => {
                piece.mask |= field.mask << (field.shift - piece.shift);
            }
            _ => pieces.push(Piece {
                word: field.word,
                shift: field.shift,
                mask: field.mask,
                parts: Vec::new(),
                table: Vec::new(),
            }),
        }
    }
    pieces
}
