//! Tools to blame: one model, one property, two methods whose answers cannot both be right.
//!
//! An answer without a bound that lies outside the bounds of another method is wrong by at least
//! that distance. Guarantee: no claim rests on an estimate, only on bounds that hold.
//!
//! # Assumes
//! The bounds of the sound method hold, and both methods were asked the same of one model.

use crate::{Guarantee, MethodAnswer};

/// Answers of two methods may differ by rounding; below this distance from
/// the bounds nothing is reported.
const ROUNDING: f64 = 1e-12;

/// How far an answer lies outside the bounds of a sound one, if it does.
pub(super) fn distance_from_bounds(sound: &MethodAnswer, other: &MethodAnswer) -> Option<f64> {
    let (low, high) = match &sound.guarantee {
        Guarantee::Exact { .. } => (sound.value, sound.value),
        Guarantee::Bounded { low, high } | Guarantee::Schedulers { low, high, .. } => (*low, *high),
        Guarantee::Statistical { .. } | Guarantee::Estimated { .. } => return None,
    };
    let distance = (low - other.value).max(other.value - high);
    let estimated = matches!(other.guarantee, Guarantee::Estimated { .. });
    (estimated && distance > ROUNDING).then_some(distance)
}
