//! What happens within a time in a chain with continuous time, with bounds that hold.
//!
//! *Method.* Uniformisation (Jensen 1953): with a rate `q` above all rates of leaving, `P = I + Q / q` and `w` the
//! Poisson weights of `q t` ([`crate::poisson`]),
//!
//! ```text
//! value at time 0 of x at time t          sum over k of  w_k P^k x
//! reward earned at rates r within t       sum over k of  (1/q) (sum over j > k of w_j) P^k r
//! ```
//!
//! *Guarantee.* Terms are positive and added, so that relative errors add up: of `k` products with `P`, of the
//! weights, and of the rates, whose relative error `e` moves the density of each path with `k` jumps by at most
//! `e (k + q t)`. The sum is cut when what is left, at most its weight times the greatest of `x`, is below
//! [`CUT`] of the least value asked for; it enters the upper bound. So probabilities of 1e-200 have their digits.
//!
//! Cost: about `q t` products of the matrix with a vector, more for tiny probabilities. Where many are needed, states that cannot be
//! told apart are joined before ([`crate::lumping`]).

use crate::answer::CheckError;
use crate::choices::Choices;
use crate::cone::{BlockWalk, Cone, Walk};
use crate::diagonals::Keys;
use crate::engine::Context;
use crate::lumping::{Lumped, lump};
use crate::optimum::sound::widened;
use crate::poisson::Weights;
use crate::rounding::{Bounds, SMALL_SPREAD, UNIT, spread};
use crate::state_space::Csr;

/// What may be cut off, relative to the least value asked for.
const CUT: f64 = 1e-9;
/// What may be left of the weights after the first number of products that is tried.
const FIRST_GUESS: f64 = 1e-18;
/// Jumps beyond which a time is refused.
const MOST_JUMPS: f64 = 1e9;

/// What finding states that cannot be told apart may take: to look at one entry for so many that are multiplied. (On a model of 2664
/// such states that took 240 instructions an entry, where multiplying took 69.)
const LUMPING_SHARE: f64 = 400.0;

/// A chain by its rates, of which only some states move.
pub(crate) struct Transient<'a> {
    pub rates: &'a Csr<f64>,
    /// States that are left; the others keep what they have.
    pub active: Vec<bool>,
    pub context: &'a Context<'a>,
    /// The states whose values are asked for.
    pub from: &'a [usize],
    /// Numbers by which states can be ordered, if there are some.
    pub keys: &'a dyn Fn() -> Option<Keys>,
}

/// How values are carried back.
enum Walker {
    ByBlocks(BlockWalk),
    ByStates(Walk<1>),
}

impl Walker {
    /// One step more; whether anything has changed.
    fn advance(&mut self) -> bool {
        match self {
            Self::ByBlocks(walk) => walk.advance(),
            Self::ByStates(walk) => walk.advance().changed,
        }
    }

    /// The value of a state that is asked for; nothing if it is what it was.
    fn value(&self, state: usize) -> Option<f64> {
        match self {
            Self::ByBlocks(walk) => Some(walk.value(state)),
            Self::ByStates(walk) => walk.value(state).map(|[value]| value),
        }
    }

    fn longest(&self) -> usize {
        match self {
            Self::ByBlocks(walk) => walk.longest(),
            Self::ByStates(walk) => walk.longest(),
        }
    }
}

/// Sums in the states asked for.
#[derive(Debug, Clone)]
struct Found {
    sums: Vec<f64>,
    /// What was cut off at most.
    cut: f64,
    /// Products of the matrix with a vector.
    products: usize,
    /// Entries of the longest row.
    longest: usize,
}

/// What is summed up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sum {
    /// The value at the end.
    Final,
    /// What is earned on the way.
    Earned,
}

impl Transient<'_> {
    /// The values (not negative) of `x` after a time, or earned at rates `x` within it, in the states asked for; others get the
    /// bounds that always hold.
    pub fn solve(&self, x: &[Bounds], time: &Bounds, sum: Sum) -> Result<Vec<Bounds>, CheckError> {
        if *time == Bounds::ZERO {
            let nothing = vec![Bounds::ZERO; x.len()];
            return Ok(if sum == Sum::Final {
                x.to_vec()
            } else {
                nothing
            });
        }
        let speed = self.speed();
        let mean = speed * time.middle();
        if mean == 0.0 {
            let earned = |x: &Bounds| widened(scaled(*x, time.middle()), 8.0 * UNIT, f64::INFINITY);
            let all = x.iter();
            return Ok(if sum == Sum::Final {
                x.to_vec()
            } else {
                all.map(earned).collect()
            });
        }
        if mean.is_nan() || mean > MOST_JUMPS {
            return Err(CheckError::Unsupported(format!(
                "the time times the greatest rate is {mean:e}, more than the {MOST_JUMPS:e} jumps that can \
                 be followed; ask for a shorter time, or for the long run"
            )));
        }
        let weights = Weights::new(mean);
        let coefficients: Vec<f64> = match sum {
            Sum::Final => (0..=weights.last()).map(|k| weights.of(k)).collect(),
            Sum::Earned => weights.tails().iter().map(|tail| tail / speed).collect(),
        };
        let lows: Vec<f64> = x.iter().map(|x| x.low).collect();
        let highs: Vec<f64> = x.iter().map(|x| x.high).collect();
        let budget = mean * self.rates.num_entries() as f64 / LUMPING_SHARE;
        let lumped = lump(self.rates, &self.active, x, budget as usize);
        let run = |x: &[f64]| match &lumped {
            Some(lumped) => self.run_on_classes(lumped, x, &coefficients, speed),
            None => self.run(x, &coefficients, speed),
        };
        let low = run(&lows)?;
        let spread = spread(x.iter());
        let is_close = spread <= SMALL_SPREAD;
        let high = match is_close {
            true => low.clone(),
            false => run(&highs)?,
        };
        let jumps = low.products.max(high.products);
        let off_time = (time.high - time.low) / time.middle();
        let joined = lumped.map_or(0.0, |lumped| lumped.longest as f64 * UNIT);
        let input = self.context.entry_error + joined + off_time + 4.0 * UNIT;
        let longest = low.longest.max(high.longest);
        let error = weights.error * 2.0
            + jumps as f64 * (longest as f64 + 70.0) * UNIT
            + 2.0 * input * (jumps as f64 + mean + 10.0 * mean.sqrt())
            + if is_close { spread } else { 0.0 };
        let unknown = Bounds {
            low: 0.0,
            high: f64::INFINITY,
        };
        let mut bounds: Vec<Bounds> = (x.iter().zip(&self.active))
            .map(|(x, active)| if *active { unknown } else { *x })
            .collect();
        for ((state, low), high_sum) in self.from.iter().zip(&low.sums).zip(&high.sums) {
            let value = Bounds {
                low: *low,
                high: high_sum + high.cut,
            };
            // Sums that stayed 0 may only have been cut off.
            bounds[*state] = widened(value, error, f64::INFINITY);
        }
        Ok(bounds)
    }

    /// A rate above all rates of leaving an active state by 2 %, so that staying has a probability to subtract to.
    fn speed(&self) -> f64 {
        let leaving = |state: usize| {
            let others = self.rates.row(state).filter(|(target, _)| *target != state);
            others.map(|(_, rate)| rate).sum::<f64>()
        };
        let active = (0..self.active.len()).filter(|state| self.active[*state]);
        1.02 * active.map(leaving).fold(0.0, f64::max)
    }

    /// The same as [`Self::run`], on classes of states with the same values.
    fn run_on_classes(
        &self,
        lumped: &Lumped,
        x: &[f64],
        coefficients: &[f64],
        speed: f64,
    ) -> Result<Found, CheckError> {
        let states = lumped.representative.iter();
        let x: Vec<f64> = states.map(|state| x[*state as usize]).collect();
        let class = |state: &usize| lumped.class[*state] as usize;
        let mut from: Vec<usize> = self.from.iter().map(class).collect();
        from.sort_unstable();
        from.dedup();
        let classes = Transient {
            rates: &lumped.rates,
            active: lumped.active.clone(),
            context: self.context,
            from: &from,
            keys: &|| None,
        };
        let found = classes.run(&x, coefficients, speed)?;
        let sum_of = |state: &usize| {
            let place = from.binary_search(&class(state));
            // Every class asked for is in `from`.
            found.sums[place.unwrap_or_else(|place| place)]
        };
        let sums = self.from.iter().map(sum_of).collect();
        Ok(Found { sums, ..found })
    }

    /// `sum over k of c_k P^k x` in the states asked for, what was cut off at most, the number of products, and the longest row.
    ///
    /// How many products are needed shows when the sums are there, but within which cone of states they are to be taken has to
    /// be known before ([`crate::cone`]): a number that proves too small is tried again with a greater one.
    fn run(&self, x: &[f64], coefficients: &[f64], speed: f64) -> Result<Found, CheckError> {
        let greatest = x.iter().copied().fold(0.0, f64::max);
        let mut rest = vec![0.0; coefficients.len() + 1];
        for k in (0..coefficients.len()).rev() {
            rest[k] = rest[k + 1] + coefficients[k];
        }
        let most = coefficients.len() - 1;
        let support: Vec<bool> = x.iter().map(|x| *x > 0.0).collect();
        let mut steps = (rest.iter())
            .position(|rest_of| *rest_of <= FIRST_GUESS * rest[0])
            .map_or(most, |steps| steps.min(most));
        loop {
            let choices = Choices::new(self.rates, &[]);
            let cone = Cone::new(choices, &self.active, self.from, Some(&support), steps);
            let entries = |state: usize, entries: &mut Vec<(u32, f64)>| {
                let others = self.rates.row(state).filter(|(target, _)| *target != state);
                entries.extend(others.map(|(target, rate)| (target as u32, rate / speed)));
                entries.push((state as u32, self.stay(state, speed)));
            };
            let by_blocks = BlockWalk::new(&cone, steps, self.keys, |state| x[state], entries);
            let walk = match by_blocks {
                Some(walk) => Walker::ByBlocks(walk),
                None => {
                    let entries = |state: usize, _: usize, into: &mut _| entries(state, into);
                    let value = |state: usize| [x[state]];
                    Walker::ByStates(Walk::new(cone, steps, choices, [true], value, entries))
                }
            };
            if let Some(found) = self.walk(walk, x, coefficients, &rest, greatest, steps)? {
                return Ok(found);
            }
            steps = (steps + steps / 8 + 16).min(most);
        }
    }

    /// The same within a number of products; nothing if it is too small.
    fn walk(
        &self,
        mut walk: Walker,
        x: &[f64],
        coefficients: &[f64],
        rest: &[f64],
        greatest: f64,
        steps: usize,
    ) -> Result<Option<Found>, CheckError> {
        let value = |walk: &Walker, state: usize| walk.value(state).unwrap_or(x[state]);
        let add = |sums: &mut [f64], walk: &Walker, weight: f64| {
            for (sum, state) in sums.iter_mut().zip(self.from) {
                *sum += weight * value(walk, *state);
            }
        };
        let mut sums = vec![0.0; self.from.len()];
        add(&mut sums, &walk, coefficients[0]);
        let longest = walk.longest();
        let mut k = 0;
        // What does not change will not, as far as the cone reaches.
        let mut still = false;
        while k + 1 < coefficients.len() {
            let least = sums.iter().copied().fold(f64::INFINITY, f64::min);
            if rest[k + 1] * greatest <= CUT * self.context.options.precision / 1e-6 * least {
                break;
            }
            if k == steps {
                return Ok(None);
            }
            if k % 16 == 0 && self.context.options.stops()? {
                break;
            }
            still = still || !walk.advance();
            k += 1;
            if coefficients[k] > 0.0 {
                add(&mut sums, &walk, coefficients[k]);
            }
        }
        Ok(Some(Found {
            sums,
            cut: 2.0 * rest[k + 1] * greatest,
            products: k,
            longest,
        }))
    }

    fn stay(&self, state: usize, speed: f64) -> f64 {
        let others = self.rates.row(state).filter(|(target, _)| *target != state);
        1.0 - others.map(|(_, rate)| rate).sum::<f64>() / speed
    }
}

fn scaled(x: Bounds, factor: f64) -> Bounds {
    Bounds {
        low: x.low * factor,
        high: x.high * factor,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::Options;

    #[test]
    fn erlang_tails_keep_their_digits() {
        // Forty stages of rate 1: the probability of all within 0.01 is nearly 0.01^40 / 40!.
        let mut rows: Vec<Vec<(u32, f64)>> = (0..40).map(|s| vec![(s + 1, 1.0)]).collect();
        rows.push(vec![(40, 1.0)]);
        let rates = Csr::from_rows(rows);
        let options = Options::default();
        let context = Context::new(&options, 0.0);
        let mut active = vec![true; 41];
        active[40] = false;
        let transient = Transient {
            rates: &rates,
            active,
            context: &context,
            from: &[0],
            keys: &|| None,
        };
        let mut target = vec![Bounds::ZERO; 41];
        target[40] = Bounds::ONE;
        let found = transient
            .solve(&target, &Bounds::exactly(0.01), Sum::Final)
            .unwrap()[0];
        // The tail of the series, to first order: 1 / (1 - 0.01 / 41), less e^-0.01.
        let factorial: f64 = (1..=40).map(|k| (k as f64).ln()).sum();
        let series = 1.0 / (1.0 - 0.01 / 41.0);
        let expected = (40.0 * 0.01f64.ln() - factorial - 0.01).exp() * series;
        assert!(
            (found.middle() / expected - 1.0).abs() < 1e-6,
            "{found:?} {expected}"
        );
        assert!(found.relative_width() < 1e-6, "{found:?}");
    }

    #[test]
    fn classes_have_the_values_of_their_states() {
        // Seven switches on and off, each on after t with 2/5 + (1 or 0 - 2/5) e^-5t; the first is a thousand times slower.
        let slow = |switch: u32| if switch == 0 { 1e-3 } else { 1.0 };
        let row = |on: u32| -> Vec<(u32, f64)> {
            let rate = |switch: u32| if on >> switch & 1 == 1 { 3.0 } else { 2.0 };
            let to = |switch: u32| (on ^ (1 << switch), rate(switch) * slow(switch));
            (0..7).map(to).collect()
        };
        let rates = Csr::from_rows((0..128).map(row).collect());
        let options = Options::default();
        let context = Context::new(&options, 0.0);
        let from: Vec<usize> = (0..128).collect();
        let transient = Transient {
            rates: &rates,
            active: vec![true; 128],
            context: &context,
            from: &from,
            keys: &|| None,
        };
        let all: Vec<Bounds> = (0..128).map(|on| Bounds::indicator(on == 127)).collect();
        // Only the longer time is worth looking for classes: by the first switch, and the number of the others.
        let budget = |t: f64| (18.0 * t * 896.0 / LUMPING_SHARE) as usize;
        let lumped = |t| lump(&rates, &transient.active, &all, budget(t));
        assert!(lumped(0.3).is_none());
        assert_eq!(lumped(400.0).unwrap().representative.len(), 14);
        for t in [0.3, 400.0] {
            let found = transient
                .solve(&all, &Bounds::exactly(t), Sum::Final)
                .unwrap();
            for (on, found) in found.iter().enumerate() {
                let one = |switch: u32| {
                    let start = if on >> switch & 1 == 1 { 1.0 } else { 0.0 };
                    0.4 + (start - 0.4) * f64::exp(-5.0 * slow(switch) * t)
                };
                let expected: f64 = (0..7).map(one).product();
                let off = 1e-13 * expected;
                assert!(
                    found.low <= expected + off && expected - off <= found.high,
                    "{t} {on} {found:?} {expected}"
                );
                assert!(found.relative_width() < 1e-7, "{t} {found:?}");
            }
        }
    }

    #[test]
    fn a_switch_follows_its_formula() {
        // Off to on with rate 2, back with 3: on after t with 2/5 (1 - e^-5t); on for the integral of that.
        let rates = Csr::from_rows(vec![vec![(1, 2.0)], vec![(0, 3.0)]]);
        let options = Options::default();
        let context = Context::new(&options, 0.0);
        let transient = Transient {
            rates: &rates,
            active: vec![true; 2],
            context: &context,
            from: &[0],
            keys: &|| None,
        };
        let on = [Bounds::ZERO, Bounds::ONE];
        for t in [0.001, 0.7, 40.0, 1000.0] {
            let at = transient
                .solve(&on, &Bounds::exactly(t), Sum::Final)
                .unwrap()[0];
            let expected = 0.4 * -(-5.0 * t).exp_m1();
            assert!(at.low <= expected * (1.0 + 1e-14) && expected <= at.high * (1.0 + 1e-14));
            assert!(at.relative_width() < 1e-7, "{t} {at:?}");
            let earned = transient
                .solve(&on, &Bounds::exactly(t), Sum::Earned)
                .unwrap()[0];
            let expected = 0.4 * t + 0.08 * (-5.0 * t).exp_m1();
            assert!(
                (earned.middle() / expected - 1.0).abs() < 1e-7,
                "{t} {earned:?} {expected}"
            );
            assert!(earned.relative_width() < 1e-7, "{t} {earned:?}");
        }
    }
}
