//! What a formula means in dense time.
//!
//! # Definition
//! Samples at t_0 < ... < t_n give each atom the value of sample k on [t_k, t_{k+1}), and that of
//! sample n at t_n (with [`Interpolation::Linear`](crate::formula::Interpolation::Linear), what the
//! line through the samples gives). What was seen is [t_0, t_n]; what is said of later times is as in
//! [`super`], with times in place of samples. For a time t:
//!
//! * v(f until_(a,b) g, t) = sup over t' in [t + a, t + b] of min(v(g, t'), inf over [t, t') of v(f));
//! * v(f since_(a,b) g, t) = sup over t' in [t - b, t - a] of min(v(g, t'), inf over (t', t] of v(f)),
//!   with t' >= t_0;
//! * v(rise f, t) = min(v(f, t), -(value of f just before t)), and v(f, t_0) at t_0. (Within a
//!   stretch where f is constant nothing becomes true, but unless f is known, nor is that.)
//! * the other operators follow as in discrete time.
//!
//! # How it is executed
//! Let all times and bounds be whole numbers of ticks (the engine's are nanoseconds). Then on each
//! open interval between two ticks every formula is constant (by induction over the formula: a
//! window seen from anywhere in (k, k + 1) begins somewhere in (k + a, k + a + 1) and ends
//! somewhere in (k + b, k + b + 1)). So time is a sequence of *places*, even ones for ticks and odd
//! ones for the open intervals between them, and a window [a, b] seen from place x is x + 2a ... x +
//! 2b. For until, if t' lies in an open interval beyond that of t, part of that interval is before t'
//! and the left operand must hold there, too.
//!
//! Cost: O(|f| T^3) for T ticks. This is the oracle for the engine, and shares no code with it.

use super::{Beyond, CompileError, FALSE, TRUE, Values, by_definition, fold, zip};
use crate::formula::ast::{Formula, Window};
use crate::formula::report::RobustnessBounds;
use crate::formula::settings::{Ending, TimeModel};

/// A trace in ticks of one second: the tick of each sample, ascending from 0, and bounds on the
/// value of each atom there.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TickWord {
    /// Ticks of the samples; the first one must be 0.
    pub ticks: Vec<usize>,
    /// For each sample the bounds of each atom.
    pub atoms: Vec<Vec<RobustnessBounds>>,
}

/// The value of a formula in dense time at the first sample. The bounds of its intervals must be
/// whole numbers of seconds.
///
/// # Errors
/// [`CompileError`] if the formula makes no sense in dense time.
pub fn value(
    formula: &Formula,
    word: &TickWord,
    ending: Ending,
) -> Result<RobustnessBounds, CompileError> {
    let all = at_all(formula, word, super::beyond(ending))?;
    Ok(all.first().copied().unwrap_or(RobustnessBounds::UNKNOWN))
}

/// Number of places.
fn places(word: &TickWord) -> usize {
    word.ticks.last().map_or(0, |last| 2 * last + 1)
}

/// The value at each place.
fn at_all(formula: &Formula, word: &TickWord, beyond: Beyond) -> Result<Values, CompileError> {
    let count = places(word);
    let plain = |formula: &Formula| at_all(formula, word, beyond);
    let opposite = |formula: &Formula| -> Result<Values, CompileError> {
        let inner = at_all(formula, word, beyond.map(RobustnessBounds::negated))?;
        Ok(inner.into_iter().map(RobustnessBounds::negated).collect())
    };
    let constant = |value| vec![value; count];
    Ok(match formula {
        Formula::True => constant(TRUE),
        Formula::False => constant(FALSE),
        Formula::Atom(atom) => (0..count)
            .map(|place| atom_at(word, atom.0, place))
            .collect(),
        Formula::Not(inner) => opposite(inner)?,
        Formula::And(operands) => fold(operands, TRUE, RobustnessBounds::min, count, plain)?,
        Formula::Or(operands) => fold(operands, FALSE, RobustnessBounds::max, count, plain)?,
        Formula::Implies(left, right) => zip(opposite(left)?, plain(right)?, RobustnessBounds::max),
        Formula::Iff(left, right) => {
            let both = zip(plain(left)?, plain(right)?, RobustnessBounds::min);
            let neither = zip(opposite(left)?, opposite(right)?, RobustnessBounds::min);
            zip(both, neither, RobustnessBounds::max)
        }
        Formula::Rise(inner) => becomes(&plain(inner)?, &opposite(inner)?),
        Formula::Fall(inner) => becomes(&opposite(inner)?, &plain(inner)?),
        Formula::Eventually(interval, inner) => until(
            interval.window(TimeModel::Dense)?,
            &constant(TRUE),
            &plain(inner)?,
            beyond,
        ),
        Formula::Until(interval, left, right) => until(
            interval.window(TimeModel::Dense)?,
            &plain(left)?,
            &plain(right)?,
            beyond,
        ),
        Formula::Once(interval, inner) => since(
            interval.window(TimeModel::Dense)?,
            &constant(TRUE),
            &plain(inner)?,
        ),
        Formula::Since(interval, left, right) => since(
            interval.window(TimeModel::Dense)?,
            &plain(left)?,
            &plain(right)?,
        ),
        Formula::Always(..)
        | Formula::Historically(..)
        | Formula::Release(..)
        | Formula::WeakUntil(..) => at_all(&by_definition(formula), word, beyond)?,
        Formula::Next(_) | Formula::Previous(_) => {
            return Err(CompileError::SamplesInDenseTime {
                what: "\"next\" or \"previous\"".to_owned(),
            });
        }
    })
}

/// The value of the last sample at or before a place.
fn atom_at(word: &TickWord, atom: usize, place: usize) -> RobustnessBounds {
    let sample = word.ticks.iter().rposition(|&tick| 2 * tick <= place);
    (sample.and_then(|sample| word.atoms[sample].get(atom).copied()))
        .unwrap_or(RobustnessBounds::UNKNOWN)
}

/// True here, and `not_here` true just before.
fn becomes(here: &[RobustnessBounds], not_here: &[RobustnessBounds]) -> Values {
    let at = |place: usize| match place {
        0 => here[0],
        odd if odd % 2 == 1 => here[odd].min(not_here[odd]),
        even => here[even].min(not_here[even - 1]),
    };
    (0..here.len()).map(at).collect()
}

/// The first and last distance in places.
fn distances(window: Window) -> (usize, Option<usize>) {
    match window {
        Window::Seconds {
            low_secs,
            high_secs,
        } => {
            // Whole numbers, by the contract of `value`.
            let places = |secs: f64| 2 * secs.round() as usize;
            (
                places(low_secs),
                high_secs.is_finite().then(|| places(high_secs)),
            )
        }
        // Refused in dense time before.
        Window::Samples { .. } => (0, None),
    }
}

fn minimum(values: &[RobustnessBounds]) -> RobustnessBounds {
    values.iter().copied().fold(TRUE, RobustnessBounds::min)
}

fn until(
    window: Window,
    left: &[RobustnessBounds],
    right: &[RobustnessBounds],
    beyond: Beyond,
) -> Values {
    let (low, high) = distances(window);
    let count = left.len();
    let at = |at: usize| {
        let last = high.map_or(count, |high| (at + high + 1).min(count));
        let mut best = FALSE;
        for end in at + low..last {
            let partly = end % 2 == 1 && end > at;
            let held = minimum(&left[at..if partly { end + 1 } else { end }]);
            best = best.max(held.min(right[end]));
        }
        match beyond {
            Some(beyond) if high.is_none_or(|high| at + high >= count) => {
                best.max(minimum(&left[at..]).min(beyond))
            }
            _ => best,
        }
    };
    (0..count).map(at).collect()
}

fn since(window: Window, left: &[RobustnessBounds], right: &[RobustnessBounds]) -> Values {
    let (low, high) = distances(window);
    let at = |at: usize| {
        let first = high.map_or(0, |high| at.saturating_sub(high));
        let mut best = FALSE;
        for end in (first..=at).take_while(|end| end + low <= at) {
            let partly = end % 2 == 1 && end < at;
            let held = minimum(&left[if partly { end } else { end + 1 }..=at]);
            best = best.max(held.min(right[end]));
        }
        best
    };
    (0..left.len()).map(at).collect()
}
