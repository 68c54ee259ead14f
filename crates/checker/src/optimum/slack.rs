//! Bounds around an approximate optimum of one strongly connected component, where rounds of iteration would be many.
//!
//! *Candidate.* Policy iteration (Howard 1960): the equations of each scheduler's chain are solved roughly by a Krylov method
//! ([`crate::krylov`]), from the solution of the one before.
//!
//! *Slack.* With `F` the right-hand side of [`super`], `x` the candidate, `w > 0` of its order of magnitude, and `t` such that
//! `t_i >= w_i + (P_c t)_i` for the choices `c` that count, the vectors `u = x + e t` and `l = x - e t` have
//!
//! ```text
//! u_i - F_c(u)_i  >=  x_i - F_c(x)_i + e w_i            F_c(l)_i - l_i  >=  F_c(x)_i - x_i + e w_i
//! ```
//!
//! so that they are inductive as soon as `e w` exceeds what `x` misses, rounding included: then `F(u) <= u` and `F(l) >= l`, which
//! [`super::sound`] shows to be bounds. An `e` that small costs `e t_i`, with `t_i` the expected sum of `w` until the component is left.
//! On the side where one choice of each state is enough (below for max, above for min), the candidate's scheduler counts; on the
//! other all do, but those that are clearly worse have slack of their own: `t` is the greatest over the choices that are nearly
//! as good (again by policy iteration).
//!
//! *Guarantee.* None of the above is trusted: bounds are returned if one application of `F`, computed rounded to nearest and moved
//! against the claim by more than its error, confirms them in every state.
//!
//! Source: Howard 1960; the slack is that of optimistic value iteration (Hartmanns and Kaminski 2020), in the direction in which it
//! arrives everywhere at once. Cost: schedulers times the rounds of their solutions times entries.

use super::local::{Local, Side};
use crate::answer::{CheckError, Options};
use crate::krylov::{Factors, Operator, correct};

/// Schedulers that are tried.
const SCHEDULERS: usize = 60;
/// Rounds of one solution.
const ROUNDS: usize = 3_000;
/// How far a scheduler's equations are solved, relative to the greatest value, before it is improved: until it is no more, roughly
/// first.
const ACCURACIES: [f64; 3] = [1e-4, 1e-8, 1e-13];
/// Choices are nearly as good as the best one up to this relative difference.
const NEARLY: f64 = 1e-5;
/// Rounds in place before a longest scheduler's equations are solved.
const SWEEPS: usize = 8;
/// Least weights, relative to the greatest: with the first, great values have close bounds, with the second small ones.
const SHARES: [f64; 2] = [1e-3, 1e-8];
/// What part of the precision asked for is close enough, wherever the component is.
const ENOUGH: f64 = 0.01;
/// How many times the slack is made larger.
const TRIALS: usize = 6;

/// The chain of a scheduler: `x_i - sum_j p_ij x_j`, each row divided by the probability of leaving the state.
struct Chain {
    row_start: Vec<usize>,
    column: Vec<u32>,
    weight: Vec<f64>,
    factors: Factors,
}

impl Chain {
    fn new(local: &Local, policy: &[usize]) -> Self {
        let (mut row_start, mut column, mut weight) = (vec![0], Vec::new(), Vec::new());
        for row in policy {
            let range = local.row_start[*row]..local.row_start[row + 1];
            column.extend_from_slice(&local.column[range.clone()]);
            weight.extend_from_slice(&local.probability[range]);
            row_start.push(column.len());
        }
        let diagonal = vec![1.0; policy.len()];
        let row = |state: usize| {
            let range = row_start[state]..row_start[state + 1];
            (&column[range.clone()], &weight[range])
        };
        let factors = Factors::new(&diagonal, row, None);
        Self {
            row_start,
            column,
            weight,
            factors,
        }
    }

    /// Brings `x` closer to the solution for the right-hand side `b`, until no state misses more than a goal that may depend on `x`.
    fn solve(
        &self,
        b: &[f64],
        x: &mut [f64],
        goal: impl Fn(&[f64]) -> f64,
        options: &Options<'_>,
    ) -> Result<(), CheckError> {
        let mut residual = vec![0.0; b.len()];
        // Solutions that went astray are begun again from where they are.
        for _ in 0..3 {
            self.apply(x, &mut residual);
            let mut missing = 0.0_f64;
            for (residual, b) in residual.iter_mut().zip(b) {
                *residual = b - *residual;
                missing = missing.max(residual.abs());
            }
            if missing <= goal(x) || missing.is_nan() {
                break;
            }
            correct(self, x, &mut residual, &goal, ROUNDS, options)?;
        }
        // Where the solution is 0, or nearly so, roughly may be below.
        let below = -goal(x).max(1e-9 * greatest(x));
        for x in x.iter_mut().filter(|x| below < **x && **x < 0.0) {
            *x = 0.0;
        }
        Ok(())
    }
}

impl Operator for Chain {
    fn apply(&self, v: &mut [f64], result: &mut [f64]) {
        for (state, result) in result.iter_mut().enumerate() {
            let range = self.row_start[state]..self.row_start[state + 1];
            let mut value = v[state];
            for (column, weight) in self.column[range.clone()].iter().zip(&self.weight[range]) {
                value -= weight * v[*column as usize];
            }
            *result = value;
        }
    }

    fn precondition(&self, v: &[f64], result: &mut [f64]) {
        self.factors.solve(v, result);
    }
}

/// The search for bounds of a component.
pub(crate) struct Slack<'a> {
    pub local: &'a Local,
    pub maximise: bool,
    /// The relative distance from the candidate that bounds may have.
    pub tolerance: f64,
    pub options: &'a Options<'a>,
}

/// What was found.
#[derive(Debug, Default)]
pub(crate) struct Confirmed {
    /// Approximations with the lower values outside.
    pub candidate: Vec<f64>,
    /// Bounds that are confirmed, if any are; those with the lower and with the upper values outside.
    pub lower: Option<Vec<f64>>,
    pub upper: Option<Vec<f64>>,
    /// Whether both are within the tolerance of their candidates.
    pub is_close: bool,
}

impl Confirmed {
    /// Adds bounds that hold beside those known.
    fn add(known: &mut Option<Vec<f64>>, more: Option<Vec<f64>>, best: fn(f64, f64) -> f64) {
        match (known, more) {
            (known @ None, more) => *known = more,
            (Some(known), Some(more)) => {
                let pairs = known.iter_mut().zip(more);
                pairs.for_each(|(known, more)| *known = best(*known, more));
            }
            (Some(_), None) => {}
        }
    }
}

impl Slack<'_> {
    /// Bounds near the optimum, from approximations `x`.
    pub fn search(&self, mut x: Vec<f64>) -> Result<Confirmed, CheckError> {
        let (policy, chain) = self.improve(&mut x)?;
        let mut found = Confirmed::default();
        if !is_plain(&x) {
            return Ok(found);
        }
        let near = (!self.local.is_chain()).then(|| self.near(&x, &policy));
        let mut high = x.clone();
        for share in SHARES {
            let scale = share * greatest(&x);
            let weights: Vec<f64> = x.iter().map(|x| x.max(scale)).collect();
            let of_one = self.times(&policy, &weights, None)?;
            let of_all = match &near {
                None => None,
                Some(near) => Some(self.times(&policy, &weights, Some(near))?),
            };
            let of_all = of_all.as_ref().unwrap_or(&of_one);
            if !is_plain(&of_one) || !is_plain(of_all) {
                break;
            }
            let pairs = weights.iter().zip(of_all);
            let allowed = pairs.fold(f64::INFINITY, |least: f64, (weight, time)| {
                least.min(weight * weight / time)
            });
            let goal = |x: &[f64]| (allowed * self.tolerance / 16.0).max(2e-16 * greatest(x));
            chain.solve(&self.earned(&policy, Side::Low), &mut x, goal, self.options)?;
            if self.local.is_one_sided(0.0) {
                high.copy_from_slice(&x);
            } else {
                let earned = self.earned(&policy, Side::High);
                chain.solve(&earned, &mut high, goal, self.options)?;
            }
            if !is_plain(&x) || !is_plain(&high) {
                break;
            }
            let (below, above) = match self.maximise {
                true => (&of_one, of_all),
                false => (of_all, &of_one),
            };
            let lower = self.confirm(&x, below, &weights, Side::Low);
            let upper = self.confirm(&high, above, &weights, Side::High);
            Confirmed::add(&mut found.lower, lower, f64::max);
            Confirmed::add(&mut found.upper, upper, f64::min);
            found.is_close = self.is_close(&found, &x, &high);
            if found.is_close || weights.iter().all(|weight| *weight > scale) {
                break;
            }
        }
        found.candidate = x;
        Ok(found)
    }

    /// Whether bounds are within the tolerance of the candidates.
    fn is_close(&self, found: &Confirmed, low: &[f64], high: &[f64]) -> bool {
        let (Some(lower), Some(upper)) = (&found.lower, &found.upper) else {
            return false;
        };
        let distance = self.tolerance.max(self.options.precision * ENOUGH);
        let mut below = lower.iter().zip(low);
        let mut above = upper.iter().zip(high);
        below.all(|(bound, x)| x - bound <= 0.5 * distance * x)
            && above.all(|(bound, x)| bound - x <= 0.5 * distance * x)
    }

    /// Policy iteration from `x`, which becomes the solution for the last scheduler.
    fn improve(&self, x: &mut [f64]) -> Result<(Vec<usize>, Chain), CheckError> {
        let mut policy = self.greedy(x, None, 0.0);
        let mut chain = Chain::new(self.local, &policy);
        for accuracy in ACCURACIES {
            for _ in 0..SCHEDULERS {
                let earned = self.earned(&policy, Side::Low);
                chain.solve(&earned, x, |x| accuracy * greatest(x), self.options)?;
                if !is_plain(x) {
                    return Ok((policy, chain));
                }
                if self.local.is_chain() {
                    break;
                }
                let better = self.greedy(x, Some(&policy), 4.0 * accuracy * greatest(x));
                if better == policy {
                    break;
                }
                policy = better;
                chain = Chain::new(self.local, &policy);
            }
        }
        Ok((policy, chain))
    }

    /// What the rows of a scheduler earn, divided as the chain's rows.
    fn earned(&self, policy: &[usize], side: Side) -> Vec<f64> {
        let sums = match side {
            Side::Low => &self.local.low,
            Side::High => &self.local.high,
        };
        policy.iter().map(|row| sums[*row]).collect()
    }

    fn rows(&self, place: usize) -> std::ops::Range<usize> {
        self.local.choice_start[place]..self.local.choice_start[place + 1]
    }

    /// The best choices for `x`; known ones stay where no other is better by more than this.
    fn greedy(&self, x: &[f64], known: Option<&[usize]>, than: f64) -> Vec<usize> {
        let best = |place: usize| {
            let (row, value) = self.local.best(place, x, Side::Low, self.maximise);
            let Some(known) = known.map(|known| known[place]) else {
                return row;
            };
            let before = self.local.row_value(known, x, Side::Low);
            if (value - before).abs() > than {
                row
            } else {
                known
            }
        };
        (0..self.local.len()).map(best).collect()
    }

    /// Which choices are nearly as good as the best one; the scheduler's are.
    fn near(&self, x: &[f64], policy: &[usize]) -> Vec<bool> {
        let mut near = vec![false; self.local.exit.len()];
        let distance = NEARLY * greatest(x);
        for (place, chosen) in policy.iter().enumerate() {
            let best = self.local.best(place, x, Side::Low, self.maximise).1;
            for row in self.rows(place) {
                let value = self.local.row_value(row, x, Side::Low);
                near[row] = row == *chosen || (value - best).abs() <= distance;
            }
        }
        near
    }

    /// `t`: of the scheduler, or of the one among those choices for which it is greatest.
    fn times(
        &self,
        policy: &[usize],
        weights: &[f64],
        among: Option<&[bool]>,
    ) -> Result<Vec<f64>, CheckError> {
        let mut policy = policy.to_vec();
        let mut times = weights.to_vec();
        let least = weights.iter().copied().fold(f64::INFINITY, f64::min);
        for _ in 0..SCHEDULERS {
            if let Some(among) = among {
                // In place, what takes longer in one state reaches others at once.
                for sweep in 0..SWEEPS {
                    self.sweep(&mut policy, weights, &mut times, among, sweep % 2 == 0);
                }
                if !self.takes_longer(weights, &times, among) {
                    break;
                }
            }
            let chain = Chain::new(self.local, &policy);
            // A part of the weights is all that may be missing.
            chain.solve(weights, &mut times, |_| 0.1 * least, self.options)?;
            if among.is_none() || !is_plain(&times) {
                break;
            }
        }
        Ok(times)
    }

    /// The expected sum in the states after a choice.
    fn onwards(&self, row: usize, times: &[f64]) -> f64 {
        let range = self.local.row_start[row]..self.local.row_start[row + 1];
        let columns = &self.local.column[range.clone()];
        let entries = columns.iter().zip(&self.local.probability[range]);
        entries.map(|(column, p)| p * times[*column as usize]).sum()
    }

    /// One round in place: the choices for which `t` is greatest, and it.
    fn sweep(
        &self,
        policy: &mut [usize],
        weights: &[f64],
        times: &mut [f64],
        among: &[bool],
        forwards: bool,
    ) {
        let states = policy.len();
        for position in 0..states {
            let place = if forwards {
                position
            } else {
                states - 1 - position
            };
            let mut best = (policy[place], f64::NEG_INFINITY);
            for row in self.rows(place).filter(|row| among[*row]) {
                let time = weights[place] + self.onwards(row, times);
                if time > best.1 {
                    best = (row, time);
                }
            }
            policy[place] = best.0;
            times[place] = times[place].max(best.1);
        }
    }

    /// Whether some choice misses half of the slack that it should have.
    fn takes_longer(&self, weights: &[f64], times: &[f64], among: &[bool]) -> bool {
        (0..weights.len()).any(|place| {
            let most = times[place] - 0.5 * weights[place];
            let mut rows = self.rows(place).filter(|row| among[*row]);
            rows.any(|row| self.onwards(row, times) > most)
        })
    }

    /// The vector at the least distance along `t` that proves inductive.
    fn confirm(&self, x: &[f64], times: &[f64], weights: &[f64], side: Side) -> Option<Vec<f64>> {
        let local = self.local;
        let sign = if side == Side::High { 1.0 } else { -1.0 };
        let mut missing = 0.0_f64;
        for (place, (x_here, weight)) in x.iter().zip(weights).enumerate() {
            let value = local.best(place, x, side, self.maximise).1;
            let off = (value - x_here) * sign;
            missing = missing.max((off.max(0.0) + 2.0 * local.error * x_here) / weight);
        }
        let mut distance = 1.25 * missing;
        for _ in 0..TRIALS {
            let pairs = x.iter().zip(times);
            let guess: Vec<f64> = pairs
                .map(|(x, time)| (x + sign * distance * time).max(0.0))
                .collect();
            if (0..local.len()).all(|place| self.holds(place, &guess, side)) {
                return Some(guess);
            }
            distance *= 4.0;
        }
        None
    }

    /// Whether a state's value by `F` is on the right side of the guess, rounding included.
    fn holds(&self, place: usize, guess: &[f64], side: Side) -> bool {
        let value = self.local.best(place, guess, side, self.maximise).1;
        match side {
            Side::High => value * (1.0 + self.local.error) <= guess[place],
            Side::Low => value * (1.0 - self.local.error) >= guess[place],
        }
    }
}

/// Whether all are numbers, and none is negative.
fn is_plain(x: &[f64]) -> bool {
    x.iter().all(|x| (0.0..f64::INFINITY).contains(x))
}

fn greatest(x: &[f64]) -> f64 {
    x.iter().copied().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
