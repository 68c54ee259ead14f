//! A number for which a simulator shows the wanted rate.
//!
//! # Definition
//! `f(c)` is the rate in so many episodes with the number at `c`; the seeds are the same for each value (common random
//! numbers), so that `f` is a step function without noise of its own. From the present value the number is multiplied and
//! divided by [`FACTORS`] in turn until `f` crosses the wanted rate; the crossing is then halved in the logarithm
//! [`HALVINGS`] times. Of all values that were tried the one whose rate is nearest is taken; of equal ones the one next to
//! the present value. A rate that comes nearest between two values on the same side of it (a mean that is right in the middle of
//! what is allowed) is looked for between these, by halving the gaps beside the nearest [`ROUNDS`] times.
//!
//! # Source
//! P. Glasserman, D. D. Yao, "Some guidelines and guarantees for common random numbers", Management Science 38 (1992), for
//! the seeds; bisection else.
//!
//! # Assumes
//! The rate crosses the wanted one between two of the values that are tried. The seeds stand for all others.
//!
//! # Cost and guarantee
//! At most [`MOST`] evaluations. The value returned was run, and its rate is the one that is returned with it: it differs
//! from the rate of the system by what chance does to both, which another set of seeds shows.

/// By how much a number is multiplied and divided at most, in turn.
const FACTORS: [f64; 3] = [1.5, 4.0, 16.0];

/// How often a crossing is halved.
const HALVINGS: u32 = 7;

/// How often the gaps on both sides of the nearest value are halved where nothing crosses.
const ROUNDS: u32 = 4;

/// Evaluations of one search, at most.
pub const MOST: u32 = 2 * FACTORS.len() as u32 + 2 * ROUNDS + HALVINGS + 1;

/// A value that was tried, with the rate that it gave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tried {
    /// The value.
    pub value: f64,
    /// The rate.
    pub rate: f64,
}

/// The value of a number with which the rate is nearest to the wanted one, if some value crosses it.
///
/// `now` is the present value, which is above 0, with its rate; `rate` gives none where the simulator does not run.
///
/// # Errors
/// What ended a run that was not its own failure.
pub fn fitted<E>(
    now: Tried,
    wanted: f64,
    rate: &mut dyn FnMut(f64) -> Result<Option<f64>, E>,
) -> Result<Option<Tried>, E> {
    let side = |it: Tried| (it.rate - wanted).signum();
    let mut ends = [Some(now), Some(now)];
    let mut tried = vec![now];
    for factor in FACTORS {
        for (end, value) in ends
            .iter_mut()
            .zip([now.value * factor, now.value / factor])
        {
            let Some(inner) = *end else {
                continue;
            };
            // Beyond a value with which it does not run nothing is looked for.
            *end = rate(value)?.map(|rate| Tried { value, rate });
            tried.extend(*end);
            if let Some(outer) = *end
                && side(outer) != side(inner)
            {
                return halved([inner, outer], now, wanted, rate).map(Some);
            }
        }
    }
    between(tried, now, wanted, rate)
}

/// The value between others of one side whose rate comes nearest, or crosses; none if it is nearest at an end.
fn between<E>(
    mut tried: Vec<Tried>,
    now: Tried,
    wanted: f64,
    rate: &mut dyn FnMut(f64) -> Result<Option<f64>, E>,
) -> Result<Option<Tried>, E> {
    let side = |it: &Tried| (it.rate - wanted).signum();
    let off = |it: &Tried| (it.rate - wanted).abs();
    let first = off(&now);
    let mut nearest = None;
    for _ in 0..ROUNDS {
        tried.sort_by(|a, b| a.value.total_cmp(&b.value));
        let places = 1..tried.len().saturating_sub(1);
        let least = tried.iter().map(off).fold(f64::INFINITY, f64::min);
        let Some(place) = places.into_iter().find(|at| off(&tried[*at]) <= least) else {
            return Ok(None);
        };
        let (best, beside) = (tried[place], [tried[place - 1], tried[place + 1]]);
        nearest = Some(best);
        for other in beside {
            let value = (best.value * other.value).sqrt();
            let Some(rate_there) = rate(value)? else {
                continue;
            };
            let middle = Tried {
                value,
                rate: rate_there,
            };
            if side(&middle) != side(&best) {
                return halved([best, middle], now, wanted, rate).map(Some);
            }
            tried.push(middle);
        }
    }
    let last = tried.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)));
    Ok(last.filter(|it| nearest.is_some() && off(it) < first))
}

fn halved<E>(
    [mut inner, mut outer]: [Tried; 2],
    now: Tried,
    wanted: f64,
    rate: &mut dyn FnMut(f64) -> Result<Option<f64>, E>,
) -> Result<Tried, E> {
    let mut tried = vec![inner, outer];
    for _ in 0..HALVINGS {
        let value = (inner.value * outer.value).sqrt();
        let Some(rate) = rate(value)? else {
            break;
        };
        let middle = Tried { value, rate };
        tried.push(middle);
        if (middle.rate - wanted).signum() == (inner.rate - wanted).signum() {
            inner = middle;
        } else {
            outer = middle;
        }
    }
    let key = |it: &Tried| ((it.rate - wanted).abs(), (it.value / now.value).ln().abs());
    let best = tried.iter().min_by(|a, b| {
        let (a, b) = (key(a), key(b));
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    Ok(best.copied().unwrap_or(now))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn search(start: f64, wanted: f64, rate: impl Fn(f64) -> Option<f64>) -> (Option<Tried>, u32) {
        let mut runs = 0;
        let mut counted = |value: f64| {
            runs += 1;
            Ok::<_, ()>(rate(value))
        };
        let now = Tried {
            value: start,
            rate: rate(start).expect("it runs as it is"),
        };
        (fitted(now, wanted, &mut counted).expect("no error"), runs)
    }

    #[test]
    fn a_step_function_is_brought_to_the_wanted_rate() {
        // The share of 200 fixed draws below the value.
        let draws: Vec<f64> = (0..200)
            .map(|i| (f64::from(i * 37 % 200) + 0.5) / 200.0)
            .collect();
        let share = |value: f64| Some(draws.iter().filter(|d| **d < value).count() as f64 / 200.0);
        let (found, runs) = search(0.3, 0.05, share);
        let found = found.expect("a value");
        assert!(
            (found.rate - 0.05).abs() < 0.006 && (found.value - 0.05).abs() < 0.01,
            "{found:?}"
        );
        assert!(runs <= MOST, "{runs}");
        // The rate may fall with the value.
        let (found, _) = search(2.0, 0.8, |value| Some((-value / 4.0).exp()));
        assert!((found.expect("a value").value - 0.893).abs() < 0.02);
    }

    #[test]
    fn a_rate_that_is_highest_in_between_is_found() {
        // The share that lies within 3 of 10, of what scatters by 2 about the value: highest with 10 itself.
        let inside = |value: f64| Some(0.87 * (-((value - 10.0) / 4.0).powi(2)).exp());
        for start in [8.5, 7.0, 13.0] {
            let (found, runs) = search(start, 0.88, inside);
            let found = found.expect("a value");
            assert!((found.value - 10.0).abs() < 0.7, "{start}: {found:?}");
            assert!(runs <= MOST, "{runs}");
        }
    }

    #[test]
    fn what_moves_nothing_or_does_not_run_is_not_fitted() {
        assert_eq!(search(1.0, 0.5, |_| Some(0.2)).0, None);
        let partial = |value: f64| (value < 1.2).then_some(value / 2.0);
        assert_eq!(search(1.0, 0.9, partial).0, None);
    }
}
