//! An upper bound of the largest probability of regions along their boundaries, by branch and bound.
//!
//! # Assumes
//! The regions keep Barnard's condition, so that the corner bounds an interval whose expansion does not.

use super::level::{Expansion, expansion, probability};
use super::region::Region;
use super::{Counts, TOLERANCE};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// What the neglected densities and rounding may add.
const ROUNDING: f64 = 1e-14;

/// What the bound may exceed the supremum by, however small that is.
const LEAST: f64 = 1e-6;

/// Intervals that are bounded before the least bound found is given, whatever its distance.
const MOST_INTERVALS: usize = 200_000;

/// A region with the nuisance parameters that are to be gone through.
pub(super) struct Line {
    pub counts: Counts,
    pub region: Region,
    pub from: f64,
    pub to: f64,
}

/// An interval of a line, with an upper bound of the probability on it.
struct Piece {
    bound: f64,
    line: usize,
    from: f64,
    to: f64,
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Piece {}

impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Piece {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_bound = self.bound.total_cmp(&other.bound);
        let by_place = || (other.line, other.from.to_bits()).cmp(&(self.line, self.from.to_bits()));
        by_bound.then_with(by_place)
    }
}

/// An upper bound of the supremum over all lines, at most [`TOLERANCE`] above it in proportion.
pub(super) fn supremum(lines: &[Line]) -> f64 {
    let mut best = 0.0_f64;
    let mut pieces = BinaryHeap::new();
    for (place, line) in lines.iter().enumerate() {
        pieces.push(bounded(lines, place, (line.from, line.to), &mut best));
    }
    let mut count = 0;
    while let Some(piece) = pieces.pop() {
        count += 1;
        let enough = piece.bound <= best * (1.0 + TOLERANCE) + LEAST;
        if enough || count >= MOST_INTERVALS {
            return (piece.bound.max(best) + ROUNDING).min(1.0);
        }
        let middle = f64::midpoint(piece.from, piece.to);
        for part in [(piece.from, middle), (middle, piece.to)] {
            pieces.push(bounded(lines, piece.line, part, &mut best));
        }
    }
    best
}

/// An interval with its bound; the value at its middle is held against the largest so far.
fn bounded(lines: &[Line], place: usize, (from, to): (f64, f64), best: &mut f64) -> Piece {
    let line = &lines[place];
    let Counts { n, m, margin, .. } = line.counts;
    let middle = f64::midpoint(from, to);
    let (first, second) = ((middle + margin).min(1.0), middle);
    let is_inner = first < 1.0 && second > 0.0;
    let (value, by_expansion) = if is_inner {
        let at = expansion(&line.region, (n, first), (m, second));
        (at.value, on_interval(&at, &line.counts, (from, to)))
    } else {
        let value = probability(&line.region, (n, first), (m, second));
        (value, f64::INFINITY)
    };
    *best = best.max(value);
    let bound = if by_expansion.is_finite() {
        by_expansion
    } else {
        probability(&line.region, (n, (from + margin).min(1.0)), (m, to))
    };
    Piece {
        bound: bound.min(1.0),
        line: place,
        from,
        to,
    }
}

/// The largest value on an interval that the expansion about its middle and the derivatives' bounds allow.
fn on_interval(at: &Expansion, counts: &Counts, (from, to): (f64, f64)) -> f64 {
    let information = |u: f64| {
        let (p, q) = (u + counts.margin, 1.0 - u - counts.margin);
        counts.n as f64 / (p * q) + counts.m as f64 / (u * (1.0 - u))
    };
    let inner = from > 0.0 && to + counts.margin < 1.0;
    if !inner {
        return f64::INFINITY;
    }
    // Convex in `u`, so largest at an end.
    let most = information(from).max(information(to));
    let half = 0.5 * (to - from);
    let reach = half * most.sqrt();
    let angle = at.value.sqrt().min(1.0).asin() + 0.5 * reach;
    if angle >= std::f64::consts::FRAC_PI_2 {
        return 1.0;
    }
    let largest = angle.sin().powi(2);
    // f (1 - f) is largest at one half.
    let spread = if largest < 0.5 {
        largest * (1.0 - largest)
    } else {
        0.25
    };
    let remainder = 6.0_f64.sqrt() * spread.sqrt() * reach.powi(3) / 6.0;
    (quadratic(at, half) + remainder).min(largest)
}

/// The largest value of the expansion within `half` of the middle.
fn quadratic(at: &Expansion, half: f64) -> f64 {
    let value = |s: f64| at.value + at.slope * s + 0.5 * at.curvature * s * s;
    let ends = value(half).max(value(-half));
    let top = -at.slope / at.curvature;
    match at.curvature < 0.0 && top.abs() < half {
        true => ends.max(value(top)),
        false => ends,
    }
}
