//! From the whole formula down to the atoms that force its value.
//!
//! Until and since are one procedure: since looks along the line backwards. Points are *ahead* if
//! they come later in the direction of looking; they are counted with the sign of the direction.

use super::line::{Line, Reach};
use super::signal::Part;
use crate::formula::ast::{Formula, Interval, Window};

/// The most pieces of an explanation before it is given up.
const MAX_PIECES: usize = 200_000;

/// An atom with its value from one point to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    pub(super) atom: usize,
    pub(super) first: i64,
    pub(super) last: i64,
    pub(super) value: bool,
}

/// What makes `formula` false at the first sample of the trace, if anything known does.
pub(super) fn violation(formula: &Formula, line: &Line<'_>) -> Option<Vec<Piece>> {
    let root = Part::new(formula, false, line)?;
    let mut search = Search {
        line,
        pieces: Vec::new(),
    };
    if line.is_cut() {
        search.cut_off(&root)?;
    } else if root.truth(0) == Some(false) {
        search.explain(&root, 0, 0, false)?;
    } else {
        return None;
    }
    Some(merged(search.pieces))
}

fn merged(mut pieces: Vec<Piece>) -> Vec<Piece> {
    pieces.sort_by_key(|piece| (piece.atom, piece.first));
    let mut merged: Vec<Piece> = Vec::new();
    for piece in pieces {
        match merged.last_mut() {
            Some(last)
                if last.atom == piece.atom
                    && last.value == piece.value
                    && piece.first <= last.last + 1 =>
            {
                last.last = last.last.max(piece.last);
            }
            _ => merged.push(piece),
        }
    }
    merged
}

struct Search<'l, 'r> {
    line: &'l Line<'r>,
    pieces: Vec<Piece>,
}

/// The direction in which an operator looks.
#[derive(Clone, Copy)]
struct Sight<'p, 'f> {
    sign: i64,
    left: &'p Part<'f>,
    right: &'p Part<'f>,
    interval: &'p Interval,
}

impl Sight<'_, '_> {
    fn next(&self, part: &Part<'_>, point: i64, truth: bool) -> Option<i64> {
        if self.sign > 0 {
            part.next(point, truth)
        } else {
            part.previous(-point, truth).map(|found| -found)
        }
    }

    fn run_last(&self, part: &Part<'_>, point: i64) -> i64 {
        if self.sign > 0 {
            part.run_last(point)
        } else {
            -part.run_first(-point)
        }
    }

    fn truth(&self, part: &Part<'_>, point: i64) -> Option<bool> {
        part.truth(self.sign * point)
    }

    fn reach(&self, line: &Line<'_>, point: i64) -> Option<Reach> {
        if self.sign > 0 {
            return line.ahead(self.interval, point);
        }
        let reach = line.behind(self.interval, -point)?;
        Some(Reach {
            first: -reach.first,
            last: -reach.last,
            open: reach.open,
        })
    }

    /// The last point from which the window begins no later than `begin`, but not after `last`,
    /// given that it does from `from`.
    fn last_that_begins_by(&self, line: &Line<'_>, from: i64, last: i64, begin: i64) -> i64 {
        // A window counted in points begins at a fixed distance; others are looked at one by one.
        match self.interval.window(line.time) {
            Ok(Window::Seconds { .. }) if !line.is_dense() => from,
            _ => match self.reach(line, from) {
                Some(reach) => last.min(begin - (reach.first - from)).max(from),
                None => from,
            },
        }
    }
}

impl Search<'_, '_> {
    /// Explains a formula whose first samples are not known: some conjunct `always p` is false
    /// because p is, at a sample that was kept.
    fn cut_off(&mut self, root: &Part<'_>) -> Option<()> {
        match root.formula {
            Formula::And(_) => root
                .operands
                .iter()
                .find_map(|operand| self.cut_off(operand)),
            Formula::Not(_) => {
                let until = root.operands.first()?;
                let (Formula::Until(interval, left, _), [_, broken]) =
                    (until.formula, &until.operands[..])
                else {
                    return None;
                };
                if **left != Formula::True {
                    return None;
                }
                let mut from = self.line.first();
                while let Some(point) = broken.next(from, true) {
                    if self.is_within(interval, point) {
                        return self.explain(broken, point, point, true);
                    }
                    from = point + 1;
                }
                None
            }
            _ => None,
        }
    }

    /// Whether a sample that was kept is in a window seen from the first sample of the trace.
    fn is_within(&self, interval: &Interval, point: i64) -> bool {
        let record = self.line.record;
        match interval.window(self.line.time) {
            Ok(Window::Samples { low, high }) => {
                let number = record.forgotten + point.unsigned_abs();
                number >= low && high.is_none_or(|high| number <= high)
            }
            Ok(Window::Seconds {
                low_secs,
                high_secs,
            }) => {
                let distance_secs = self.line.begins_secs(point) - record.first_secs.unwrap_or(0.0);
                distance_secs >= low_secs && distance_secs <= high_secs
            }
            Err(_) => false,
        }
    }

    /// Adds what makes `part`, which has this value from one point to another, have it.
    fn explain(&mut self, part: &Part<'_>, first: i64, last: i64, value: bool) -> Option<()> {
        if first > last {
            return Some(());
        }
        match part.formula {
            Formula::True | Formula::False => Some(()),
            Formula::Atom(atom) => {
                self.pieces.push(Piece {
                    atom: atom.0,
                    first,
                    last,
                    value,
                });
                (self.pieces.len() <= MAX_PIECES).then_some(())
            }
            Formula::Not(_) => self.explain(part.operands.first()?, first, last, !value),
            Formula::And(_) | Formula::Or(_)
                if matches!(part.formula, Formula::And(_)) == value =>
            {
                part.operands
                    .iter()
                    .try_for_each(|operand| self.explain(operand, first, last, value))
            }
            Formula::And(_) | Formula::Or(_) => self.one_of(&part.operands, first, last, value),
            Formula::Next(_) => {
                let last = (last + 1).min(self.line.end() - 1);
                self.explain(part.operands.first()?, first + 1, last, value)
            }
            Formula::Previous(_) => {
                self.explain(part.operands.first()?, (first - 1).max(0), last - 1, value)
            }
            Formula::Rise(_) => self.rise(part.operands.first()?, first, last, value),
            Formula::Until(interval, ..) => {
                let [left, right] = &part.operands[..] else {
                    return None;
                };
                let sight = Sight {
                    sign: 1,
                    left,
                    right,
                    interval,
                };
                self.look(sight, first, last, value)
            }
            Formula::Since(interval, ..) => {
                let [left, right] = &part.operands[..] else {
                    return None;
                };
                let sight = Sight {
                    sign: -1,
                    left,
                    right,
                    interval,
                };
                self.look(sight, -last, -first, value)
            }
            // The few operators are all.
            _ => None,
        }
    }

    /// At each point some operand has the value: the one that keeps it longest.
    fn one_of(&mut self, operands: &[Part<'_>], first: i64, last: i64, value: bool) -> Option<()> {
        let mut point = first;
        while point <= last {
            let having = operands
                .iter()
                .filter(|operand| operand.truth(point) == Some(value));
            // Of several that last to the end, the first.
            let mut longest: Option<(&Part<'_>, i64)> = None;
            for operand in having {
                let end = operand.run_last(point).min(last);
                if longest.is_none_or(|(_, so_far)| end > so_far) {
                    longest = Some((operand, end));
                }
            }
            let (operand, end) = longest?;
            self.explain(operand, point, end, value)?;
            point = end + 1;
        }
        Some(())
    }

    fn rise(&mut self, inner: &Part<'_>, first: i64, last: i64, value: bool) -> Option<()> {
        let before = |point: i64| {
            if self.line.is_dense() && point % 2 != 0 {
                point
            } else {
                point - 1
            }
        };
        let mut point = first;
        while point <= last {
            let now = inner.truth(point);
            let mut end = inner.run_last(point).min(last);
            if value {
                end = point;
                self.explain(inner, point, point, true)?;
                if point > 0 {
                    self.explain(inner, before(point), before(point), false)?;
                }
            } else if now == Some(false) {
                self.explain(inner, point, end, false)?;
            } else {
                // It was true before: here at first, and from here on as long as it stays.
                if now != Some(true) {
                    end = point;
                }
                self.explain(inner, before(point).max(0), before(end), true)?;
            }
            point = end + 1;
        }
        Some(())
    }

    /// Until in the direction of looking.
    fn look(&mut self, sight: Sight<'_, '_>, first: i64, last: i64, value: bool) -> Option<()> {
        let mut point = first;
        while point <= last {
            let done = if value {
                self.found(sight, point, last)?
            } else {
                self.missed(sight, point, last)?
            };
            point = done.max(point) + 1;
        }
        Some(())
    }

    fn add(
        &mut self,
        sight: Sight<'_, '_>,
        part: &Part<'_>,
        first: i64,
        last: i64,
        value: bool,
    ) -> Option<()> {
        if sight.sign > 0 {
            self.explain(part, first, last, value)
        } else {
            self.explain(part, -last, -first, value)
        }
    }

    /// Explains why until is true from `point` on, up to the point returned.
    fn found(&mut self, sight: Sight<'_, '_>, point: i64, last: i64) -> Option<i64> {
        let reach = sight.reach(self.line, point)?;
        let witness = sight
            .next(sight.right, reach.first, true)
            .filter(|&witness| witness <= reach.last);
        let Some(witness) = witness else {
            // What was not seen makes it true, if the left holds up to there.
            let end = if sight.sign > 0 {
                self.line.end() - 1
            } else {
                0
            };
            self.add(sight, sight.left, point, end, true)?;
            return Some(last);
        };
        let run_last = sight.run_last(sight.right, witness);
        let done = sight.last_that_begins_by(self.line, point, last, run_last);
        let begins_here = reach.first == point;
        let witness_last = witness.max(done + (reach.first - point));
        self.add(sight, sight.right, witness, witness_last, true)?;
        let upto = if begins_here { witness } else { witness_last };
        // Within an open interval, part of it lies before the witness.
        let partly = self.line.is_dense() && upto % 2 != 0 && upto > point;
        self.add(
            sight,
            sight.left,
            point,
            if partly { upto } else { upto - 1 },
            true,
        )?;
        Some(done)
    }

    /// Explains why until is false from `point` on, up to the point returned.
    fn missed(&mut self, sight: Sight<'_, '_>, point: i64, last: i64) -> Option<i64> {
        let reach = sight.reach(self.line, point)?;
        let begins_here = reach.first == point;
        if sight.truth(sight.left, point) == Some(false) {
            let only_here = begins_here && reach.last == point && !reach.open;
            let done = match only_here {
                false => sight.run_last(sight.left, point).min(last),
                // In dense time, then, the window of each point is the point itself.
                true if self.line.is_dense() => last,
                true => point,
            };
            if !only_here {
                self.add(sight, sight.left, point, done, false)?;
            }
            if begins_here {
                self.add(sight, sight.right, point, done, false)?;
            }
            return Some(done);
        }
        let broken = sight.next(sight.left, point, false);
        let limit = broken.map(|broken| {
            if self.line.is_dense() && broken % 2 != 0 {
                broken - 1
            } else {
                broken
            }
        });
        let done = match broken {
            Some(broken) => {
                sight.last_that_begins_by(self.line, point, last.min(broken - 1), i64::MAX / 4)
            }
            None => sight.last_that_begins_by(self.line, point, last, i64::MAX / 4),
        };
        let reach_of_last = sight.reach(self.line, done)?;
        let mut end = reach_of_last.last;
        if let (Some(broken), Some(limit)) = (broken, limit)
            && (limit < end || reach_of_last.open)
        {
            self.add(sight, sight.left, broken, broken, false)?;
            end = end.min(limit);
        }
        self.add(sight, sight.right, reach.first, end, false)?;
        Some(done)
    }
}
