//! Why a formula is violated: a part of the trace that forces it.
//!
//! # Definition
//! An explanation is a set of pairs (atom, stretch of time) with the truth that the atom has there,
//! such that the formula is violated on every trace of the same times in which these atoms have these
//! values. It is found from the top down: a conjunction is false because of one operand, a
//! disjunction because of all; `eventually` is false because its operand is false throughout the
//! window; `always` is false because of the first place where its operand is; `until` is false
//! because the right is, up to a place where the left is false or the end of the window; and so on.
//! Where several operands would do, the one that stays so longest is taken, and where several places
//! would, the first that is known. What is found is checked: the formula must be violated with
//! everything else unknown; and if it has few parts (an atom over a stretch), those without which
//! it is still violated are left out. So no part is idle, but the segment need not be the shortest of
//! all that force the violation.
//!
//! Source: the idea is that of causes in temporal logic (T. Ferrère, O. Maler and D. Nickovic,
//! "Trace diagnostics using temporal implicants", ATVA 2015); here on places and their runs, with
//! unknown values.
//!
//! # Memory and cost
//! A judge keeps the last [`Settings::explain_samples`](super::Settings::explain_samples) samples,
//! until the verdict is determined. If earlier ones are needed there is no explanation. It is
//! computed once, at the end: O(|f|^2 n log n).

mod core;
mod line;
mod search;
mod signal;

use std::collections::VecDeque;

use self::core::simplest;
use self::line::Line;
use self::search::Piece;
use super::ast::{AtomId, Formula};
use super::report::{Explanation, Responsible, RobustnessBounds};
use super::settings::{Ending, TimeModel};

/// Up to so many pieces, each is left out by way of trial.
const MAX_TRIED: usize = 8;

/// The last samples of a trace, for an explanation.
#[derive(Debug, Clone)]
pub(super) struct Record {
    most: usize,
    atom_count: usize,
    first_secs: Option<f64>,
    /// Number of samples that were forgotten.
    forgotten: u64,
    times_secs: VecDeque<f64>,
    /// The truth of each atom at each sample.
    atoms: VecDeque<Option<bool>>,
}

impl Record {
    pub(super) fn new(most: usize, atom_count: usize) -> Self {
        Record {
            most,
            atom_count,
            first_secs: None,
            forgotten: 0,
            times_secs: VecDeque::new(),
            atoms: VecDeque::new(),
        }
    }

    /// Keeps a sample.
    pub(super) fn push(&mut self, time_secs: f64, atoms: impl Iterator<Item = Option<bool>>) {
        if self.most == 0 {
            return;
        }
        self.first_secs.get_or_insert(time_secs);
        if self.times_secs.len() >= self.most {
            self.times_secs.pop_front();
            self.atoms.drain(..self.atom_count);
            self.forgotten += 1;
        }
        self.times_secs.push_back(time_secs);
        let before = self.atoms.len();
        self.atoms.extend(atoms.take(self.atom_count));
        self.atoms.resize(before + self.atom_count, None);
    }

    /// Keeps samples given in columns; of more than can be kept only the last ones are looked at.
    pub(super) fn push_many(&mut self, times_secs: &[f64], atoms: &[&[f64]]) {
        if let Some(&first_secs) = times_secs.first().filter(|_| self.most > 0) {
            self.first_secs.get_or_insert(first_secs);
        }
        let skipped = times_secs.len().saturating_sub(self.most);
        if skipped > 0 {
            self.forgotten += (skipped + self.times_secs.len()) as u64;
            self.times_secs.clear();
            self.atoms.clear();
        }
        for (at, &time_secs) in times_secs.iter().enumerate().skip(skipped) {
            let truth = |column: &&[f64]| RobustnessBounds::of_value(column[at]).truth();
            self.push(time_secs, atoms.iter().map(truth));
        }
    }

    /// The same, where all is unknown but what the pieces touch.
    fn only(&self, pieces: &[Piece], line: &Line<'_>) -> Record {
        let mut alone = self.clone();
        alone.atoms.iter_mut().for_each(|truth| *truth = None);
        for piece in pieces {
            for sample in line.samples(piece.first, piece.last) {
                let at = sample * self.atom_count + piece.atom;
                alone.atoms[at] = self.atoms[at];
            }
        }
        alone
    }

    /// The truth of an atom at a sample that was kept.
    fn atom(&self, sample: usize, atom: usize) -> Option<bool> {
        if atom >= self.atom_count {
            return None;
        }
        self.atoms
            .get(sample * self.atom_count + atom)
            .copied()
            .flatten()
    }
}

/// Why `formula` is violated, if what was kept shows it.
pub(super) fn explain(
    formula: &Formula,
    record: &Record,
    time: TimeModel,
    ending: Ending,
) -> Option<Explanation> {
    if record.times_secs.is_empty() {
        return None;
    }
    let formula = simplest(formula)?;
    let line = Line::new(record, time, ending);
    let found = search::violation(&formula, &line)?;
    let suffices = |pieces: &[Piece]| {
        let alone = record.only(pieces, &line);
        search::violation(&formula, &Line::new(&alone, time, ending)).is_some()
    };
    // Nothing is reported that would not do by itself.
    let found = suffices(&found).then(|| without_idle(found, suffices))?;
    let mut atoms: Vec<Responsible> = found
        .into_iter()
        .map(|part| Responsible {
            atom: AtomId(part.atom),
            from_secs: line.begins_secs(part.first),
            to_secs: line.ends_secs(part.last),
            value: part.value,
        })
        .collect();
    atoms.sort_by(|left, right| {
        (left.atom.cmp(&right.atom)).then(left.from_secs.total_cmp(&right.from_secs))
    });
    let from_secs = atoms
        .iter()
        .map(|atom| atom.from_secs)
        .fold(f64::INFINITY, f64::min);
    let to_secs = atoms
        .iter()
        .map(|atom| atom.to_secs)
        .fold(f64::NEG_INFINITY, f64::max);
    let nothing = atoms.is_empty();
    Some(Explanation {
        // What is false in any case needs no part of the trace.
        from_secs: if nothing {
            line.begins_secs(line.first())
        } else {
            from_secs
        },
        to_secs: if nothing {
            line.begins_secs(line.first())
        } else {
            to_secs
        },
        atoms,
    })
}

/// The pieces without those that the others can do without, if they are few.
fn without_idle(mut pieces: Vec<Piece>, suffices: impl Fn(&[Piece]) -> bool) -> Vec<Piece> {
    if pieces.len() > MAX_TRIED {
        return pieces;
    }
    let mut at = 0;
    while at < pieces.len() {
        let piece = pieces.remove(at);
        if !suffices(&pieces) {
            pieces.insert(at, piece);
            at += 1;
        }
    }
    pieces
}
