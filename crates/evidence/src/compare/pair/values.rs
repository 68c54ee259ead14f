//! Values of two sides that are nearest to each other, and the greatest of p-values.

use crate::compare::Belief;
use stats::Interval;

/// The values of two intervals that are nearest to each other.
pub(super) fn nearest(first: Interval, second: Interval) -> (f64, f64) {
    let at = |of: &Interval, other: f64| of.low.max(other.min(of.high));
    if first.low >= first.high {
        return (first.low, at(&second, first.low));
    }
    let nearest = at(&second, at(&first, second.low));
    (at(&first, nearest), nearest)
}

/// The values of a side without its runs that reached no verdict.
pub(super) fn decided(belief: &Belief) -> Interval {
    match belief.has_undecided() {
        true => Interval {
            low: belief.estimate(),
            high: belief.estimate(),
        },
        false => belief.values(),
    }
}

/// The greatest of p-values, `None` of these where one has none; `None` where there are none at all.
pub(super) fn greatest(all: impl Iterator<Item = Option<f64>>) -> Option<Option<f64>> {
    all.reduce(|one, other| Some(one?.max(other?)))
}
