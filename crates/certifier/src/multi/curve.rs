//! The curve of what two objectives can have together.
//!
//! *Definition.* Schedulers have a convex set of pairs of numbers, of which more is better. The vectors of some schedulers
//! show that everything below their mixtures is attained; for each weight `w >= 0`, `w x <= V(w)` shows that nothing
//! lies beyond. Where both meet, that is the curve.
//!
//! *Method.* From the best schedulers for each objective alone, the normal of each line between neighbours is the next
//! weight, until nothing lies beyond any line. Source: Forejt, Kwiatkowska and Parker 2012. Guarantee: that of [`super`] for each
//! vector and weight.

use super::{End, Goal, Kind};
use crate::evaluate::Evaluator;
use crate::failure::Failure;
use crate::interval::Interval;
use crate::question::unsupported;

/// Most weights that are tried.
const MOST_WEIGHTS: usize = 200;
/// By how much less than the numbers' size pairs must differ to be told apart.
const NEAR: f64 = 1e-7;

/// What was shown of the pairs of numbers that two objectives can have.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Pairs that schedulers have, and so have their mixtures; of each number more is better.
    attained: Vec<[Interval; 2]>,
    /// Weights, and the greatest weighted sum that any scheduler has.
    beyond: Vec<([f64; 2], f64)>,
    /// How each number is read from the one that was asked for: `sign * number + shift`.
    read: [(f64, f64); 2],
}

impl Curve {
    /// Whether these are the corners of the curve, in the numbers that were asked for: none if that is not shown, but nothing
    /// against it either.
    pub fn has_corners(&self, corners: &[[f64; 2]]) -> Option<bool> {
        let read = |corner: &[f64; 2]| {
            let number = |at: usize| self.read[at].0 * corner[at] + self.read[at].1;
            [number(0), number(1)]
        };
        let corners: Vec<[f64; 2]> = corners.iter().map(read).collect();
        let sizes = corners.iter().flatten().map(|x| x.abs());
        let near = NEAR * sizes.fold(1.0, f64::max);
        let is_beyond = |corner: &[f64; 2]| {
            let mut weights = self.beyond.iter();
            weights
                .any(|(w, most)| w[0] * corner[0] + w[1] * corner[1] > most + near * (w[0] + w[1]))
        };
        let ends = |end: fn(&Interval) -> f64| -> Vec<[f64; 2]> {
            let pairs = self.attained.iter();
            pairs.map(|[a, b]| [end(a), end(b)]).collect()
        };
        let low = ends(|interval| interval.low);
        if corners.iter().any(is_beyond) || low.iter().any(|pair| !is_below(pair, &corners, near)) {
            return Some(false);
        }
        let shown = corners.iter().all(|corner| is_below(corner, &low, near));
        shown.then_some(true)
    }
}

/// Whether a mixture of pairs has at least as much of both numbers, to within so much.
fn is_below(pair: &[f64; 2], pairs: &[[f64; 2]], near: f64) -> bool {
    let has = |other: &[f64; 2], at: usize| other[at] >= pair[at] - near;
    pairs.iter().any(|a| {
        (has(a, 0) && has(a, 1))
            || pairs.iter().any(|b| {
                // One has enough of the first, the other of the second.
                if !(has(a, 0) && has(b, 1)) || has(a, 1) || has(b, 0) {
                    return false;
                }
                // The least share of the first pair that has enough of the first number.
                let share = ((pair[0] - near - b[0]) / (a[0] - b[0])).clamp(0.0, 1.0);
                share * a[1] + (1.0 - share) * b[1] >= pair[1] - near
            })
    })
}

impl Evaluator<'_> {
    pub(super) fn curve(&mut self, goals: &[Goal], end: &End) -> Result<Curve, Failure> {
        let read = |goal: &Goal| match (&goal.kind, goal.contrary) {
            (_, false) => (1.0, 0.0),
            (Kind::Path(_), true) => (-1.0, 1.0),
            (_, true) => (-1.0, 0.0),
        };
        let mut curve = Curve {
            attained: Vec::new(),
            beyond: Vec::new(),
            read: [read(&goals[0]), read(&goals[1])],
        };
        let mut middles = Vec::new();
        for weights in [[1.0, 0.0], [0.0, 1.0]] {
            middles.push(self.next(goals, end, weights, &mut curve)?);
        }
        let mut open = vec![(middles[1], middles[0])];
        while let Some((upper, right)) = open.pop() {
            let normal = [upper[1] - right[1], right[0] - upper[0]];
            let largest = normal[0].max(normal[1]);
            let size = [upper, right]
                .iter()
                .flatten()
                .fold(1.0, |a, x| x.abs().max(a));
            if normal.iter().any(|w| *w < 0.0) || largest <= NEAR * 1e-3 * size {
                continue;
            }
            if curve.beyond.len() > MOST_WEIGHTS {
                return Err(unsupported("a Pareto curve with so many corners"));
            }
            let weights = normal.map(|w| w / largest);
            let next = self.next(goals, end, weights, &mut curve)?;
            let value = |pair: [f64; 2]| weights[0] * pair[0] + weights[1] * pair[1];
            if value(next) > value(upper).max(value(right)) + NEAR * 1e-2 * size {
                open.extend([(upper, next), (next, right)]);
            }
        }
        Ok(curve)
    }

    /// What is shown for some weights; the middle of what a scheduler has.
    fn next(
        &mut self,
        goals: &[Goal],
        end: &End,
        weights: [f64; 2],
        curve: &mut Curve,
    ) -> Result<[f64; 2], Failure> {
        let shown = self.weighted(goals, end, &weights)?;
        let pair = [shown.vector[0], shown.vector[1]];
        curve.attained.push(pair);
        curve.beyond.push((weights, shown.greatest.high));
        Ok(pair.map(|x| 0.5 * (x.low + x.high)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_confirmed_only_where_both_sides_meet() {
        let pairs = |pairs: &[[f64; 2]]| pairs.iter().map(|p| p.map(Interval::exactly)).collect();
        let shown = Curve {
            attained: pairs(&[[1.0, 0.0], [0.0, 1.0], [0.8, 0.6]]),
            beyond: vec![
                ([1.0, 0.0], 1.0),
                ([0.0, 1.0], 1.0),
                ([1.0, 1.0], 1.4),
                ([1.0, 1.0 / 3.0], 1.0),
                ([0.5, 1.0], 1.0),
            ],
            read: [(1.0, 0.0), (-1.0, 1.0)],
        };
        let corners = [[0.0, 0.0], [0.8, 0.4], [1.0, 1.0]];
        assert_eq!(shown.has_corners(&corners), Some(true));
        // One is missing, is too good, or is not as good as it could be.
        assert_eq!(shown.has_corners(&[corners[0], corners[2]]), Some(false));
        for by in [-1e-4, 1e-4] {
            let moved = [corners[0], [0.8, 0.4 + by], corners[2]];
            assert_eq!(shown.has_corners(&moved), Some(false), "{by}");
        }
        // Nothing is shown beyond the line, and nothing on it.
        let coarse = Curve {
            attained: pairs(&[[1.0, 0.0], [0.0, 1.0]]),
            ..shown
        };
        assert_eq!(coarse.has_corners(&corners), None);
    }
}
