//! What happens within a time, by uniformisation in intervals.
//!
//! *Definition.* With `q` the greatest rate and `P = I + (R - E) / q`, the expectation of `x` after a time `t` is `sum_i w_i
//! P^i x`, `w_i = e^(-qt) (qt)^i / i!`, and what is earned until then at rates `r` is `sum_i (1 - w_0 - ... - w_i) P^i r / q`.
//! The time is cut into pieces with `qt` at most [`PIECE`]. The sums are cut off where the weights vanish, and what is
//! left out is bounded: of the first by the remaining weight times the greatest `x`, of the second by a geometric series.
//! `e^-y` is enclosed by an alternating series for `y` at most 1/2, and squared.
//!
//! Source: Jensen 1953; Baier, Haverkort, Hermanns and Katoen 2003, section 4. Guarantee: containment.

use num_traits::{One, Zero};
use prism_lang::property::{Path, TimedOperator};
use prism_lang::{Number, Rational, rational_to_f64};

use crate::evaluate::{Evaluator, as_set};
use crate::explicit::possible;
use crate::failure::Failure;
use crate::interval::Interval;
use crate::question::unsupported;
use crate::reading::{Choice, Reading};
use crate::steps::Rows;

/// The greatest number of steps that are expected in a piece of time.
const PIECE: f64 = 256.0;
/// Most steps, times transitions.
const MOST_WORK: f64 = 3e9;
/// Weights below this are left out.
const VANISHING: f64 = 1e-24;

/// `left U[begin,end] right`, counted from the start; without `end` for ever.
pub(crate) struct Window {
    pub left: Vec<bool>,
    pub right: Vec<bool>,
    pub begin: Rational,
    pub end: Option<Rational>,
}

impl Evaluator<'_> {
    /// An operator with a bound in time between sets of states, and whether its contrary is meant.
    pub(crate) fn window(&mut self, path: &Path) -> Result<(Window, bool), Failure> {
        let Path::Timed {
            operator,
            left,
            right,
            interval,
        } = path
        else {
            return Err(unsupported("a formula without a bound in time"));
        };
        let states = self.reading()?.states.len();
        let mut sets = Vec::new();
        let several = || unsupported("a bound in time around another temporal operator");
        let mut set = |evaluator: &mut Self, path: &Path| {
            let formula = evaluator.formula(path, &mut sets)?;
            as_set(&formula, &sets, states).ok_or_else(several)
        };
        let right = set(self, right)?;
        let left = match left {
            Some(left) => set(self, left)?,
            None => vec![true; states],
        };
        let not = |set: &[bool]| set.iter().map(|holds| !holds).collect::<Vec<bool>>();
        let pairs = || left.iter().zip(&right);
        let (left, right, contrary) = match operator {
            TimedOperator::Until | TimedOperator::Finally => (left, right, false),
            TimedOperator::Globally => (left, not(&right), true),
            TimedOperator::Release => (not(&left), not(&right), true),
            TimedOperator::WeakUntil => (
                pairs().map(|(l, r)| *l && !r).collect(),
                pairs().map(|(l, r)| !l && !r).collect(),
                true,
            ),
        };
        let time = |bound: &Option<(Number, bool)>| {
            let bound = bound.as_ref().map(|(time, _)| exact(time));
            bound.transpose()
        };
        let window = Window {
            left,
            right,
            begin: time(&interval.lower)?.unwrap_or_else(Rational::zero),
            end: time(&interval.upper)?,
        };
        Ok((window, contrary))
    }

    /// The probability of a formula with a bound in time.
    pub(crate) fn timed_path(&mut self, path: &Path) -> Result<Vec<Interval>, Failure> {
        let (window, contrary) = self.window(path)?;
        let Window {
            left,
            right,
            begin,
            end,
        } = window;
        let reading = self.reading()?;
        let chain = (&reading.choices[..], &reading.rate[..]);
        let mut values = match end {
            None => self.reached(&reading.choices, &left, &right, true)?,
            Some(end) => {
                let time = end - &begin;
                let number = |holds: &bool| match holds {
                    true => Interval::ONE,
                    false => Interval::ZERO,
                };
                let x = right.iter().map(number).collect();
                let is_open = |s: usize| left[s] && !right[s];
                after(chain, &is_open, x, None, &time, &|| {
                    self.oracle.is_cancelled()
                })?
            }
        };
        if !begin.is_zero() {
            for (value, left) in values.iter_mut().zip(&left) {
                if !left {
                    *value = Interval::ZERO;
                }
            }
            let is_open = |s: usize| left[s];
            values = after(chain, &is_open, values, None, &begin, &|| {
                self.oracle.is_cancelled()
            })?;
        }
        let probability = |value: &Interval| {
            let value = value.at_least(0.0).at_most(1.0);
            if contrary { value.contrary() } else { value }
        };
        Ok(values.iter().map(probability).collect())
    }

    /// The expectation of a number at a time.
    pub(crate) fn expected_at(
        &self,
        reading: &Reading,
        start: Vec<Interval>,
        time: &Number,
    ) -> Result<Vec<Interval>, Failure> {
        let chain = (&reading.choices[..], &reading.rate[..]);
        after(chain, &|_| true, start, None, &exact(time)?, &|| {
            self.oracle.is_cancelled()
        })
    }

    /// What is earned within a time.
    pub(crate) fn earned_within(
        &self,
        reading: &Reading,
        time: &Number,
    ) -> Result<Vec<Interval>, Failure> {
        let rates = (reading.choices.iter().zip(&reading.rate))
            .map(|(choices, rate)| Interval::of(&(&choices[0].reward * rate)))
            .collect();
        let start = vec![Interval::ZERO; reading.states.len()];
        let chain = (&reading.choices[..], &reading.rate[..]);
        after(chain, &|_| true, start, Some(rates), &exact(time)?, &|| {
            self.oracle.is_cancelled()
        })
    }
}

fn exact(time: &Number) -> Result<Rational, Failure> {
    let exact = time.exact().cloned();
    exact.ok_or_else(|| unsupported("a time that is not a rational number"))
}

/// The expectation of `x` after a time in a chain (of each state the only choice, and the rate of its steps), and of what is
/// earned until then, if `rates` are given; states that are not active are left no more.
pub(crate) fn after(
    (steps, rate): (&[Vec<Choice>], &[Rational]),
    active: &dyn Fn(usize) -> bool,
    mut x: Vec<Interval>,
    rates: Option<Vec<Interval>>,
    time: &Rational,
    cancelled: &dyn Fn() -> bool,
) -> Result<Vec<Interval>, Failure> {
    if *time <= Rational::zero() {
        return Ok(x);
    }
    let states = 0..x.len();
    let fastest = states
        .clone()
        .filter(|s| active(*s))
        .map(|s| &rate[s])
        .max();
    let Some(fastest) = fastest.cloned() else {
        return Ok(x);
    };
    let choices: Vec<Vec<Choice>> = states
        .map(|state| {
            let own = (&steps[state][0], &rate[state]);
            vec![uniformised(own, state, active(state), &fastest)]
        })
        .collect();
    let rows = Rows::new(&choices);
    let expected = rational_to_f64(&(&fastest * time));
    let pieces = (expected / PIECE).ceil().max(1.0);
    let entries: usize = choices
        .iter()
        .map(|choices| choices[0].outcomes.len())
        .sum();
    if (expected + 40.0 * pieces) * entries as f64 > MOST_WORK {
        return Err(unsupported("so long a time in so large a model"));
    }
    // Where nothing is ahead the value is 0, and where nothing moves it stays, without rounding.
    let is_ahead = |state: usize| {
        x[state] != Interval::ZERO || rates.iter().any(|r| r[state] != Interval::ZERO)
    };
    let ahead = possible(&choices, &(0..x.len()).map(is_ahead).collect::<Vec<bool>>());
    let kept: Vec<Option<Interval>> = (0..x.len())
        .map(|state| match (ahead[state], active(state)) {
            (false, _) => Some(Interval::ZERO),
            (true, false) if rates.is_none() => Some(x[state]),
            _ => None,
        })
        .collect();
    let number = Rational::from_float(pieces).unwrap_or_else(Rational::one);
    let piece = Interval::of(&(&fastest * time / number));
    let fastest = Interval::of(&fastest);
    for _ in 0..pieces as u64 {
        x = one_piece(&rows, &x, rates.as_deref(), &piece, &fastest, cancelled)?;
        for (x, kept) in x.iter_mut().zip(&kept) {
            *x = kept.unwrap_or(*x);
        }
    }
    Ok(x)
}

/// The steps of a state at the fastest rate.
fn uniformised(
    (own, rate): (&Choice, &Rational),
    state: usize,
    is_active: bool,
    fastest: &Rational,
) -> Choice {
    let stay = match is_active {
        true => Rational::one() - rate / fastest,
        false => Rational::one(),
    };
    let mut outcomes = Vec::new();
    if is_active {
        let p = |p: &Rational| p * rate / fastest;
        outcomes.extend(own.outcomes.iter().map(|(target, own)| (*target, p(own))));
    }
    match outcomes.iter_mut().find(|(target, _)| *target == state) {
        Some((_, p)) => *p += stay,
        None => outcomes.push((state, stay)),
    }
    outcomes.retain(|(_, p)| !p.is_zero());
    outcomes.sort_unstable_by_key(|(target, _)| *target);
    Choice {
        outcomes,
        reward: Rational::zero(),
    }
}

fn one_piece(
    rows: &Rows,
    x: &[Interval],
    rates: Option<&[Interval]>,
    piece: &Interval,
    fastest: &Interval,
    cancelled: &dyn Fn() -> bool,
) -> Result<Vec<Interval>, Failure> {
    let most = |of: &[Interval]| of.iter().map(|x| x.high).fold(0.0, f64::max);
    let back = |x: Vec<Interval>| rows.back(x, 1, true, &|_| true, false, cancelled);
    let mut weight = vanishing_exponential(piece);
    let mut sum = weight;
    let (mut x, most_x) = (x.to_vec(), most(x));
    let mut rates: Option<(Vec<Interval>, f64)> = rates.map(|r| (r.to_vec(), most(r)));
    let add = |total: &mut Vec<Interval>, weight: &Interval, x: &[Interval]| {
        for (total, x) in total.iter_mut().zip(x) {
            *total = total.add(&weight.mul(x));
        }
    };
    let remaining = |sum: &Interval| Interval::ONE.sub(sum).at_least(0.0).at_most(1.0);
    let mut total = vec![Interval::ZERO; x.len()];
    let mut step = 0u32;
    loop {
        add(&mut total, &weight, &x);
        if let (Some((rates, _)), Some(time)) = (&rates, remaining(&sum).div(fastest)) {
            add(&mut total, &time, rates);
        }
        if f64::from(step) > 2.0 * piece.high && weight.high < VANISHING {
            break;
        }
        step += 1;
        let number = Interval::exactly(f64::from(step));
        weight = weight.mul(piece).div(&number).unwrap_or(Interval::ONE);
        sum = sum.add(&weight);
        x = back(x)?;
        rates = match rates {
            Some((rates, most)) => Some((back(rates)?, most)),
            None => None,
        };
    }
    // The weights that are left out, of which the ratio is at most 1/2 by now.
    let rest = remaining(&sum).high.min(2.0 * weight.high).next_up();
    let left_out = Interval {
        low: 0.0,
        high: rest,
    };
    let mut missing = left_out.mul(&Interval::exactly(most_x));
    if let (Some((_, most)), Some(time)) =
        (&rates, left_out.mul(&Interval::exactly(4.0)).div(fastest))
    {
        missing = missing.add(&time.mul(&Interval::exactly(*most)));
    }
    missing.low = 0.0;
    Ok(total.iter().map(|total| total.add(&missing)).collect())
}

/// `e^-y` for `y` at least 0.
fn vanishing_exponential(y: &Interval) -> Interval {
    let of = |y: f64| {
        let mut halvings = 0;
        let mut small = y;
        while small > 0.5 {
            // Exact: a power of two.
            small *= 0.5;
            halvings += 1;
        }
        let small = Interval::exactly(small);
        let (mut term, mut sum) = (Interval::ONE, Interval::ONE);
        // Alternating, with falling terms: the value lies between any two neighbouring sums.
        for number in 1..=20 {
            let divisor = Interval::exactly(f64::from(number));
            term = term.mul(&small).div(&divisor).unwrap_or(Interval::ONE);
            sum = if number % 2 == 1 {
                sum.sub(&term)
            } else {
                sum.add(&term)
            };
        }
        sum.low = (sum.low - term.high).next_down();
        for _ in 0..halvings {
            sum = sum.mul(&sum);
        }
        sum
    };
    Interval {
        low: of(y.high).low,
        high: of(y.low).high,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_is_enclosed() {
        for y in [0.0, 0.1, 0.5, 1.0, 3.7, 40.0, 256.0] {
            let found = vanishing_exponential(&Interval::exactly(y));
            let near = (-y).exp();
            assert!(found.low <= near * (1.0 + 1e-15) && near * (1.0 - 1e-15) <= found.high);
            assert!(found.high - found.low <= 2e-11 * near, "{y}: {found:?}");
        }
    }
}
