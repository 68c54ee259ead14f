//! A constant for which a model has a counted rate.
//!
//! # Definition
//! `f(c)` is the model's rate of a failure mode with the constant at `c`. Wanted is `c` with `f(c) = k/n`, the counted
//! share. A constant that acts more than once in a run (a chance for each step, a draw that is repeated) is not the share
//! itself. From the present value the log-odds of the constant are moved by 1, 2, 4, ... in either direction until `f`
//! crosses the share; the crossing is then enclosed by regula falsi in the log-odds of both, with the Illinois rule.
//! A rate of a continuous-time model, or another number above 0, is moved by its logarithm in their place ([`Scale`]).
//! The interval of the counted rate, as the evidence shows it ([`crate::Counts::interval`]), is carried over by the same search for its
//! two ends.
//!
//! # Source
//! M. Dowell, P. Jarratt, "A modified regula falsi method for computing the root of an equation", BIT 11 (1971).
//!
//! # Assumes
//! The share that was counted is taken for the rate. Its interval is one of the constant where the rate is monotone in it.
//!
//! # Cost and guarantee
//! Some ten solutions of the model for each value. Where the model's transitions stay the same, `f` is a quotient of
//! polynomials and continuous, so that an enclosed crossing is a solution; of several, the one next to the present
//! value in its direction is taken. What is returned has been solved, and has the share to within [`CLOSE`] of it. A
//! value at which the model is not valid, such as probabilities above 1, is never crossed; up to it is looked.

use crate::model_change::Read;
use crate::number::Number;

/// The relative error of the rate at which the search ends.
pub(crate) const CLOSE: f64 = 1e-4;

/// How far a positive number is moved at most, in its logarithm: by a factor of some thousand, as units differ.
const FARTHEST_LOG: f64 = 7.2;

/// Constants nearer to 0 or 1 than this are not tried.
const LEAST: f64 = 1e-9;

/// How often the step to a value that the model cannot have is halved: to a thousandth of the log-odds.
const HALVINGS: usize = 12;

/// The first step of going along a stretch, and by what the next one is longer.
const FIRST_STEP: f64 = 0.25;
const GROWTH: f64 = 1.5;

/// The part of the first step by which a direction is tried.
const PROBE: f64 = 0.02;

/// Solutions of one search, at most.
const MOST_STEPS: usize = 60;

/// A rate as a function of a constant; `None` where the model cannot be solved.
pub(crate) type Rate<'f> = dyn FnMut(f64) -> Option<f64> + 'f;

/// How a constant is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scale {
    /// A probability, by its log-odds.
    Odds,
    /// A positive number, by its logarithm.
    Log,
}

impl Scale {
    /// Of a constant with this value.
    pub fn of(value: f64, is_rate: bool) -> Self {
        match is_rate || value >= 1.0 {
            true => Self::Log,
            false => Self::Odds,
        }
    }

    fn place(self, value: f64) -> f64 {
        match self {
            Self::Odds => log_odds(value),
            Self::Log => value.max(LEAST).ln(),
        }
    }

    fn value(self, place: f64) -> f64 {
        match self {
            Self::Odds => probability(place),
            Self::Log => place.exp(),
        }
    }

    /// How far two values are apart.
    pub fn distance(self, one: f64, other: f64) -> f64 {
        (self.place(one) - self.place(other)).abs()
    }
}

/// A constant of a model as it is written, and the scale on which it is moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// Its value.
    pub value: f64,
    scale: Scale,
}

impl Moved {
    /// The constant `name` of a model's text; `None` where it has none of that name that is above 0.
    #[must_use]
    pub fn of_model(text: &str, name: &str) -> Option<Self> {
        let read = Read::new(text).ok()?;
        let (value, scale) = Number::Constant(name.to_owned()).value(&read)?;
        Some(Self { value, scale })
    }

    /// The same at another value.
    #[must_use]
    pub fn at(self, value: f64) -> Self {
        Self { value, ..self }
    }
}

/// The value of a constant with which the rate is `target`, within a relative error of 1e-4 of the smaller of it and the rest, on the
/// stretch about where the constant is on which the rate rises or falls; where the rate does not reach it there, the value at
/// the end of the stretch. And whether it reaches it. `None` where the rate has no value where the constant is.
///
/// From where the constant is it is moved in the direction that brings the rate nearer, in growing steps, until the rate crosses
/// the target, turns, or has no value. Where it turns within two steps the turning point is sought, so that a crossing before
/// it is not jumped over.
#[must_use]
pub fn nearest_crossing(
    rate: &mut dyn FnMut(f64) -> Option<f64>,
    constant: Moved,
    target: f64,
) -> Option<(f64, bool)> {
    if !(target > 0.0 && target < 1.0) {
        return Some((constant.value, false));
    }
    let scale = constant.scale;
    // Of the rarer outcome, whose relative error is the larger.
    let (wanted, is_rest) = (target.min(1.0 - target), target > 0.5);
    let mut at = |x: f64| {
        let found = rate(scale.value(x))?;
        let found = if is_rest { 1.0 - found } else { found };
        Some(log_odds(found) - log_odds(wanted))
    };
    let origin = scale.place(constant.value);
    let first = at(origin)?;
    if is_close(first, wanted) {
        return Some((constant.value, true));
    }
    // To the ends of the scale, or as far as units differ.
    let last = |sign: f64| match scale {
        Scale::Odds => sign * log_odds(1.0),
        Scale::Log => origin + sign * FARTHEST_LOG,
    };
    let ends = [-1.0, 1.0].map(|sign| {
        along(
            &mut at,
            (origin, first),
            (sign * FIRST_STEP, last(sign)),
            wanted,
        )
    });
    let best = |one: Stretch, other: Stretch| match (one.is_reached, other.is_reached) {
        (true, false) => one,
        (false, true) => other,
        (true, true) if (one.at.0 - origin).abs() <= (other.at.0 - origin).abs() => one,
        (true, true) => other,
        (false, false) if one.at.1.abs() <= other.at.1.abs() => one,
        (false, false) => other,
    };
    let [below, above] = ends;
    let found = best(below, above);
    Some((scale.value(found.at.0), found.is_reached))
}

/// Where going in one direction ends.
struct Stretch {
    at: (f64, f64),
    is_reached: bool,
}

/// Goes on as long as the rate comes nearer to what is wanted.
fn along(
    at: &mut dyn FnMut(f64) -> Option<f64>,
    origin: (f64, f64),
    (step, last): (f64, f64),
    wanted: f64,
) -> Stretch {
    let ends_at = |at: (f64, f64)| Stretch {
        at,
        is_reached: false,
    };
    // Whether this direction leads nearer at all.
    let near = at(origin.0 + PROBE * step);
    let leads_away = |found: f64| found * origin.1 > 0.0 && found.abs() >= origin.1.abs();
    if near.is_none_or(leads_away) {
        return ends_at(origin);
    }
    let (mut before, mut here, mut step) = (origin, origin, step);
    loop {
        if here.0 == last {
            return ends_at(here);
        }
        let next = here.0 + step;
        let next = if step > 0.0 {
            next.min(last)
        } else {
            next.max(last)
        };
        let (next, goes_on) = match at(next) {
            Some(found) => ((next, found), true),
            None => (last_valid(at, here, next), false),
        };
        if next.1 * here.1 <= 0.0 {
            let reached = enclosed(at, here, next, wanted);
            return reached.map_or(ends_at(here), |x| Stretch {
                at: (x, 0.0),
                is_reached: true,
            });
        }
        if next.1.abs() >= here.1.abs() {
            return turned(at, (before, here, next), wanted).unwrap_or(ends_at(here));
        }
        if !goes_on {
            return ends_at(next);
        }
        (before, here) = (here, next);
        step *= GROWTH;
    }
}

/// The turning point between three places of which the middle one is the nearest to what is wanted, or a crossing before it; `None`
/// where the middle one is the first, and the rate goes away from there.
fn turned(
    at: &mut dyn FnMut(f64) -> Option<f64>,
    (before, here, next): ((f64, f64), (f64, f64), (f64, f64)),
    wanted: f64,
) -> Option<Stretch> {
    let (mut low, mut middle, mut high) = (before, here, next);
    for _ in 0..HALVINGS {
        // The wider of both parts is divided.
        let is_low = (middle.0 - low.0).abs() > (high.0 - middle.0).abs();
        let other = if is_low { low } else { high };
        let x = middle.0 + 0.4 * (other.0 - middle.0);
        let found = (x, at(x)?);
        if found.1 * here.1 <= 0.0 {
            return enclosed(at, middle, found, wanted).map(|x| Stretch {
                at: (x, 0.0),
                is_reached: true,
            });
        }
        match (found.1.abs() < middle.1.abs(), is_low) {
            (true, true) => (middle, high) = (found, middle),
            (true, false) => (low, middle) = (middle, found),
            (false, true) => low = found,
            (false, false) => high = found,
        }
    }
    Some(Stretch {
        at: middle,
        is_reached: false,
    })
}

/// The value of a constant with which the rate is `target`, at most `farthest` away from `start` in its scale.
pub(crate) fn crossing(
    rate: &mut Rate<'_>,
    (start, scale): (f64, Scale),
    target: f64,
    farthest: f64,
) -> Option<f64> {
    if !(target > 0.0 && target < 1.0) {
        return None;
    }
    let origin = scale.place(start);
    let mut at = |x: f64| rate(scale.value(x)).map(|found| log_odds(found) - log_odds(target));
    let first = at(origin)?;
    if is_close(first, target) {
        return Some(start);
    }
    // Solutions in continuous time cost as much as the rate is large.
    let farthest = match scale {
        Scale::Odds => farthest,
        Scale::Log => farthest.min(FARTHEST_LOG),
    };
    // Both directions in turn: which of them raises the rate is not known before.
    let mut ends = [(origin, first, true), (origin, first, true)];
    let mut step = 1.0_f64;
    let mut reached = 0.0_f64;
    while reached < farthest && ends.iter().any(|(.., goes_on)| *goes_on) {
        let next = step.min(farthest);
        for (end, sign) in ends.iter_mut().zip([-1.0, 1.0]) {
            let (low, of_low, goes_on) = *end;
            if !goes_on {
                continue;
            }
            let high = origin + sign * next;
            let (high, of_high) = match at(high) {
                Some(of_high) => (high, of_high),
                None => {
                    // Beyond a value at which the model is not valid nothing is looked for.
                    end.2 = false;
                    last_valid(&mut at, (low, of_low), high)
                }
            };
            if of_low * of_high <= 0.0 {
                return enclosed(&mut at, (low, of_low), (high, of_high), target)
                    .map(|x| scale.value(x));
            }
            (end.0, end.1) = (high, of_high);
        }
        reached = next;
        step *= 2.0;
    }
    None
}

/// The last place, from one that the model can have towards one that it cannot, that it can have.
fn last_valid(
    at: &mut dyn FnMut(f64) -> Option<f64>,
    valid: (f64, f64),
    mut invalid: f64,
) -> (f64, f64) {
    let mut valid = valid;
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(valid.0, invalid);
        match at(middle) {
            Some(found) => valid = (middle, found),
            None => invalid = middle,
        }
    }
    valid
}

/// The other values of a constant with which the rate is `target`, of such as are at most `farthest` away in its scale from an even
/// chance, or from where a positive number is: the rate need not be monotone. Where it crosses twice between two of the
/// values that are tried, a step of the scale apart, neither is found.
pub(crate) fn other_crossings(
    rate: &mut Rate<'_>,
    (start, scale): (f64, Scale),
    target: f64,
    farthest: f64,
) -> Vec<f64> {
    if !(target > 0.0 && target < 1.0) {
        return Vec::new();
    }
    let (origin, farthest) = match scale {
        Scale::Odds => (0.0, farthest),
        Scale::Log => (scale.place(start), farthest.min(FARTHEST_LOG)),
    };
    let mut at = |x: f64| rate(scale.value(x)).map(|found| log_odds(found) - log_odds(target));
    let steps = farthest.floor() as i32;
    let places = (-steps..=steps).map(|step| origin + f64::from(step));
    let tried: Vec<(f64, f64)> = places.filter_map(|x| Some((x, at(x)?))).collect();
    let now = scale.place(start);
    let crossings = tried.windows(2).filter_map(|pair| {
        let (low, high) = (pair[0], pair[1]);
        // Values that the model cannot have lie between such as are not neighbours.
        let is_found =
            low.1 * high.1 <= 0.0 && high.0 - low.0 < 1.5 && !(low.0..=high.0).contains(&now);
        is_found
            .then(|| enclosed(&mut at, low, high, target))
            .flatten()
    });
    let mut found: Vec<f64> = crossings.filter(|x| (x - now).abs() > 1e-3).collect();
    found.dedup_by(|next, kept| (*next - *kept).abs() < 1e-3);
    found.into_iter().map(|x| scale.value(x)).collect()
}

/// The place of the crossing between two of opposite signs.
fn enclosed(
    at: &mut dyn FnMut(f64) -> Option<f64>,
    mut low: (f64, f64),
    mut high: (f64, f64),
    target: f64,
) -> Option<f64> {
    for end in [low, high] {
        if is_close(end.1, target) {
            return Some(end.0);
        }
    }
    for _ in 0..MOST_STEPS {
        let x = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let found = at(x)?;
        if is_close(found, target) {
            return Some(x);
        }
        if found * high.1 < 0.0 {
            low = high;
        } else {
            // The Illinois rule: the end that stays counts half, so that both ends move.
            low.1 /= 2.0;
        }
        high = (x, found);
    }
    None
}

/// Whether a difference in log-odds is a relative difference of the rate of at most [`CLOSE`].
fn is_close(difference: f64, target: f64) -> bool {
    // d(rate)/rate = (1 - rate) d(log-odds).
    difference.abs() * (1.0 - target) <= CLOSE
}

/// The log-odds of a probability, which is kept away from 0 and 1.
pub(crate) fn log_odds(value: f64) -> f64 {
    let value = value.clamp(LEAST, 1.0 - LEAST);
    (value / (1.0 - value)).ln()
}

fn probability(log_odds: f64) -> f64 {
    1.0 / (1.0 + (-log_odds).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chance_for_each_step_is_solved_for() {
        // At least once in n steps: 1 - (1-c)^n, whose inverse is known.
        for (steps, target) in [(1, 0.3), (12, 0.135), (500, 0.02), (40, 0.9)] {
            let mut rate = |c: f64| Some(1.0 - (1.0 - c).powi(steps));
            let exact = 1.0 - (1.0_f64 - target).powf(1.0 / f64::from(steps));
            let found = crossing(&mut rate, (0.03, Scale::Odds), target, 12.0).expect("a crossing");
            assert!(
                (found / exact - 1.0).abs() < 1e-3,
                "{steps} {target}: {found} {exact}"
            );
        }
    }

    #[test]
    fn what_is_tried_again_until_it_succeeds_is_solved_for() {
        let mut rate = |c: f64| Some(c.powi(3));
        let found = crossing(&mut rate, (0.3, Scale::Odds), 0.125, 12.0).expect("a crossing");
        assert!((found - 0.5).abs() < 1e-4, "{found}");
        // A probability of success: the rate falls with the constant.
        let mut falling = |c: f64| Some((1.0 - c).powi(2));
        let found = crossing(&mut falling, (0.9, Scale::Odds), 0.25, 12.0).expect("a crossing");
        assert!((found - 0.5).abs() < 1e-4, "{found}");
    }

    /// Of an even chance that is tried twice and has to come out once, the contrary chance gives the same rate.
    #[test]
    fn the_other_side_of_a_rate_that_turns_is_found() {
        let mut turns = |c: f64| Some(2.0 * c * (1.0 - c));
        let found = other_crossings(&mut turns, (0.1, Scale::Odds), 0.18, 12.0);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!((found[0] - 0.9).abs() < 1e-4, "{found:?}");
        let mut rises = |c: f64| Some(c * c);
        assert_eq!(
            other_crossings(&mut rises, (0.3, Scale::Odds), 0.09, 12.0),
            Vec::<f64>::new()
        );
    }

    /// Where a rate turns, what is on this side of it is found, however near to the turning point, and what it does not reach is there.
    #[test]
    fn a_rate_that_turns_is_followed_to_where_it_turns() {
        let mut turns = |c: f64| Some(2.0 * c * (1.0 - c));
        let from = |value| Moved {
            value,
            scale: Scale::Odds,
        };
        for target in [0.1, 0.3, 0.45, 0.49, 0.4999] {
            let exact = 0.5 - (0.25 - target / 2.0_f64).sqrt();
            let (found, is_reached) =
                nearest_crossing(&mut turns, from(0.342), target).expect("a value");
            assert!(
                is_reached && (found - exact).abs() < 3e-3,
                "{target}: {found} {exact}"
            );
            let (found, is_reached) =
                nearest_crossing(&mut turns, from(0.658), target).expect("a value");
            assert!(
                is_reached && (found - 1.0 + exact).abs() < 3e-3,
                "{target}: {found} {exact}"
            );
        }
        let (found, is_reached) = nearest_crossing(&mut turns, from(0.342), 0.6).expect("a value");
        assert!(!is_reached && (found - 0.5).abs() < 0.02, "{found}");
        // The end of what is valid, and the end of the scale.
        let mut partial = |c: f64| (c < 0.4).then_some(c);
        let (found, is_reached) = nearest_crossing(&mut partial, from(0.1), 0.6).expect("a value");
        assert!(!is_reached && (found - 0.4).abs() < 1e-3, "{found}");
        let mut bounded = |c: f64| Some(0.1 + 0.2 * c);
        let (found, is_reached) = nearest_crossing(&mut bounded, from(0.5), 0.5).expect("a value");
        assert!(!is_reached && found > 0.999, "{found}");
        // From one end of the scale to the other.
        let mut share = |c: f64| Some(0.8 * c);
        let (found, is_reached) =
            nearest_crossing(&mut share, from(0.9999), 0.008).expect("a value");
        assert!(is_reached && (found - 0.01).abs() < 1e-5, "{found}");
        let mut rises = |c: f64| Some(c * c);
        let (found, is_reached) = nearest_crossing(&mut rises, from(0.3), 0.81).expect("a value");
        assert!(is_reached && (found - 0.9).abs() < 1e-4, "{found}");
    }

    #[test]
    fn what_no_value_gives_is_not_found() {
        let mut bounded = |c: f64| Some(0.1 + 0.2 * c);
        assert_eq!(crossing(&mut bounded, (0.5, Scale::Odds), 0.5, 12.0), None);
        // The model is not valid above 0.4, where the crossing would be.
        let mut partial = |c: f64| (c < 0.4).then_some(c);
        assert_eq!(crossing(&mut partial, (0.1, Scale::Odds), 0.6, 12.0), None);
        // Too far away.
        let mut plain = |c: f64| Some(c);
        assert_eq!(crossing(&mut plain, (0.01, Scale::Odds), 0.9, 2.0), None);
        assert_eq!(crossing(&mut plain, (0.01, Scale::Odds), 0.0, 2.0), None);
    }

    #[test]
    fn a_rate_is_solved_for_beyond_one() {
        // Over within a unit of time: 1 - exp(-c).
        let mut over = |c: f64| Some(1.0 - (-c).exp());
        for target in [0.2_f64, 0.5, 0.99] {
            let exact = -(1.0 - target).ln();
            let found = crossing(&mut over, (0.4, Scale::of(0.4, true)), target, 12.0);
            let found = found.expect("a crossing");
            assert!(
                (found / exact - 1.0).abs() < 1e-2,
                "{target}: {found} {exact}"
            );
        }
        assert_eq!(Scale::of(0.4, false), Scale::Odds);
        assert_eq!(Scale::of(3.0, false), Scale::Log);
    }
}
