//! When a limit of one form is a limit of another, and how it is named.

use super::limits::{Compared, Limit};
use std::collections::BTreeSet;
use trace::Measure;

/// Relative difference below which two limits are the same number, written in
/// other units.
const SAME: f64 = 1e-9;

/// Whether both limit the same: the same quantity, or how long the same
/// proposition is waited for.
pub fn is_of_same(one: &Limit, other: &Limit) -> bool {
    match (&one.compared, &other.compared) {
        (Some(required), Some(found)) => agree(required, found),
        (None, None) => one.awaited.is_some() && one.awaited == other.awaited,
        _ => false,
    }
}

/// Whether both are the same quantity.
pub fn agree(required: &Compared, found: &Compared) -> bool {
    required.measure == found.measure && required.signals == found.signals
        || is_distance_of(required, found)
}

/// Distances are the same in both directions.
fn is_distance_of(required: &Compared, found: &Compared) -> bool {
    match (&required.measure, &found.measure) {
        (
            Measure::Distance {
                first,
                second,
                axes,
            },
            Measure::Distance {
                first: other_first,
                second: other_second,
                axes: other_axes,
            },
        ) => {
            BTreeSet::from_iter(axes) == BTreeSet::from_iter(other_axes)
                && BTreeSet::from([first, second]) == BTreeSet::from([other_first, other_second])
        }
        _ => false,
    }
}

/// Whether what is found reads some of what is required, and nothing else.
pub fn same_signals(required: &Compared, found: &Compared) -> bool {
    found.signals.iter().all(|s| required.signals.contains(s))
}

/// Whether two limits are the same. A number without a unit is in that of the
/// signals, of which all that is known is the unit in which the other is
/// written, and the SI unit.
pub fn is_same_limit(one: &Limit, other: &Limit) -> bool {
    if one.dimension.is_some() == other.dimension.is_some() {
        return is_same(one.si_value, other.si_value);
    }
    is_same(one.number, other.number) || is_same(one.si_value, other.si_value)
}

fn is_same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME * one.abs().max(other.abs())
}

/// A limit for people: `5 s`, `near_distance (0.1 m)`, `released: 2 s`.
pub fn in_words(limit: &Limit) -> String {
    let value = match limit.dimension {
        Some(dimension) => format!("{} {}", rounded(limit.si_value), dimension.si_unit()),
        None => format!("{} without a unit", rounded(limit.number)),
    };
    let same = limit.text == value || limit.dimension.is_none();
    let with_value = match (&limit.parameter, same) {
        (Some(name), _) => format!("{name} = {value}"),
        (None, true) => value,
        (None, false) => format!("{} = {value}", limit.text),
    };
    match (&limit.proposition, &limit.parameter) {
        (Some(name), None) => format!("{with_value} in `{name}`"),
        _ => with_value,
    }
}

/// Without the digits that a conversion of units leaves behind.
fn rounded(value: f64) -> f64 {
    format!("{value:.12e}").parse().unwrap_or(value)
}
