//! Robust means, and reachability by iteration from both sides.

use super::range::Range;
use crate::answer::{AnswerValue, CheckError, Guarantee};
use crate::engine::{Context, Engine};
use crate::graph::{Components, Qualitative};
use crate::rounding::{Bounds, UNIT};
use crate::state_space::Csr;
use prism_lang::{Bound, Comparison};

/// Rounds of iteration of one component, after which its bounds are taken as they are.
const MOST_ROUNDS: usize = 200_000;

/// A change below this ends the iteration of a component.
const SMALLEST_CHANGE: f64 = 1e-12;

/// The engine of interval models: values are bounds over all chains within.
pub(crate) enum Robust {}

impl Engine for Robust {
    type Entry = Range;
    type Value = Bounds;

    fn indicator(holds: bool) -> Bounds {
        Bounds::indicator(holds)
    }

    fn contrary(value: &Bounds) -> Bounds {
        if value.is_exact() && (value.low == 0.0 || value.low == 1.0) {
            return Bounds::exactly(1.0 - value.low);
        }
        Bounds {
            low: (1.0 - value.high).next_down().max(0.0),
            high: (1.0 - value.low).next_up().min(1.0),
        }
    }

    fn mean<'a>(
        transitions: impl Iterator<Item = (&'a Range, &'a Bounds)>,
        _: &Context<'_>,
    ) -> Bounds {
        let row: Vec<(Range, Bounds)> =
            transitions.map(|(range, value)| (*range, *value)).collect();
        robust_mean(&row)
    }

    fn reachability(
        matrix: &Csr<Range>,
        sets: &Qualitative,
        context: &Context<'_>,
    ) -> Result<(Vec<Bounds>, u64), CheckError> {
        reachability(matrix, sets, context)
    }

    fn meets(value: &Bounds, comparison: Comparison, bound: &Bound) -> Option<bool> {
        let bound = bound.to_f64();
        // One step outwards each: the bound may lie between two floating-point numbers.
        let (below, above) = (bound.next_down(), bound.next_up());
        let (yes, no) = match comparison {
            Comparison::Less => (value.high < below, value.low > above),
            Comparison::LessEqual => (value.high < below, value.low > above),
            Comparison::Greater => (value.low > above, value.high < below),
            Comparison::GreaterEqual => (value.low > above, value.high < below),
        };
        match (yes, no) {
            (true, _) => Some(true),
            (_, true) => Some(false),
            _ => None,
        }
    }

    fn bounds(value: &Bounds) -> Bounds {
        *value
    }

    fn answer(value: &Bounds) -> AnswerValue {
        AnswerValue::Number(value.middle())
    }

    fn guarantee(value: &Bounds, _: &Context<'_>, _: u64) -> Guarantee {
        match value.is_exact() {
            true => Guarantee::Exact,
            false => Guarantee::Bounded {
                low: value.low,
                high: value.high,
            },
        }
    }

    fn complement(_: &Bounds) -> Option<Bounds> {
        None
    }
}

/// The least and largest mean over rows within the ranges, widened by more than its rounding.
fn robust_mean(row: &[(Range, Bounds)]) -> Bounds {
    let all = |value: f64| row.iter().all(|(_, b)| b.low == value && b.high == value);
    if all(0.0) || all(1.0) {
        return row.first().map_or(Bounds::ZERO, |(_, bounds)| *bounds);
    }
    let error = 4.0 * (row.len() as f64 + 4.0) * UNIT;
    let mut lows: Vec<(Range, f64)> = row.iter().map(|(range, b)| (*range, b.low)).collect();
    lows.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut highs: Vec<(Range, f64)> = row.iter().map(|(range, b)| (*range, b.high)).collect();
    highs.sort_by(|a, b| b.1.total_cmp(&a.1));
    Bounds {
        low: (extreme(&lows) - error).max(0.0),
        high: (extreme(&highs) + error).min(1.0),
    }
}

/// The mean that gives the free mass to the first values first.
fn extreme(row: &[(Range, f64)]) -> f64 {
    let least: f64 = row.iter().map(|(range, _)| range.low).sum();
    let mut free = (1.0 - least).max(0.0);
    let mut mean = 0.0;
    for (range, value) in row {
        let more = (range.high - range.low).max(0.0).min(free);
        free -= more;
        mean += (range.low + more) * value;
    }
    mean
}

/// Bounds of reaching the sure states.
fn reachability(
    matrix: &Csr<Range>,
    sets: &Qualitative,
    context: &Context<'_>,
) -> Result<(Vec<Bounds>, u64), CheckError> {
    let open: Vec<bool> = sets
        .surely
        .iter()
        .zip(&sets.never)
        .map(|(surely, never)| !surely && !never)
        .collect();
    let start = |state: usize| match (sets.surely[state], open[state]) {
        (true, _) => Bounds::ONE,
        (_, true) => Bounds {
            low: 0.0,
            high: 1.0,
        },
        _ => Bounds::ZERO,
    };
    let mut values: Vec<Bounds> = (0..open.len()).map(start).collect();
    let mut rounds = 0;
    for component in Components::new(matrix, &open).iter() {
        context.options.check_cancelled()?;
        let loops = |state: u32| {
            matrix
                .row(state as usize)
                .any(|(target, _)| target == state as usize)
        };
        let most = match component {
            [only] if !loops(*only) => 1,
            _ => MOST_ROUNDS,
        };
        for round in 0..most {
            if round % 64 == 63 {
                context.options.check_cancelled()?;
            }
            rounds += 1;
            if !improve(matrix, component, &mut values) {
                break;
            }
        }
    }
    Ok((values, rounds))
}

/// One round over a component; whether any bound moved by more than the smallest change.
fn improve(matrix: &Csr<Range>, component: &[u32], values: &mut [Bounds]) -> bool {
    let mut moved = false;
    for state in component {
        let state = *state as usize;
        let row: Vec<(Range, Bounds)> = matrix
            .row(state)
            .map(|(target, range)| (*range, values[target]))
            .collect();
        let new = robust_mean(&row);
        let known = &mut values[state];
        moved |= new.low > known.low + SMALLEST_CHANGE || new.high < known.high - SMALLEST_CHANGE;
        known.low = known.low.max(new.low);
        known.high = known.high.min(new.high);
    }
    moved
}
