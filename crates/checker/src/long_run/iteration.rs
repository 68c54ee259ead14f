//! Bounds of the gain of an end component by iteration; see [`super`].

use std::ops::Range;

use super::krylov::Equations;
use crate::answer::CheckError;
use crate::engine::Context;
use crate::graph::EndComponent;
use crate::rounding::{Bounds, UNIT};
use crate::state_space::Csr;

/// Rounds after which the bounds reached are taken.
const ROUNDS: u64 = 1_000_000;
/// Rounds in place before rounds by the greatest rate.
const IN_PLACE: u64 = 20_000;
/// The part of the precision that the equations' residual may take up.
const SHARE: f64 = 0.1;
/// Passes over the states after which the state with the greatest share is looked for.
const FLOWS: usize = 4;
/// Solutions of the equations, each of what the one before left.
const SOLUTIONS: usize = 8;
/// Rounds in place between two looks at the bounds.
const SWEEPS: usize = 8;
/// Less than 1, so that periodic chains do not go round for ever.
const RELAXATION: f64 = 0.95;

/// The choices within a component, by position.
pub(super) struct Iteration<'a> {
    choice_start: Vec<usize>,
    row_start: Vec<usize>,
    column: Vec<u32>,
    rate: Vec<f64>,
    rewards: &'a [Bounds],
    /// At least the greatest rate of leaving a state.
    speed: f64,
}

impl<'a> Iteration<'a> {
    /// `rewards` are those of the component's rows; `local` gives the position of each of its states.
    pub fn new(
        matrix: &Csr<f64>,
        rows: impl Fn(u32) -> Range<usize>,
        rewards: &'a [Bounds],
        component: &EndComponent,
        local: &[u32],
    ) -> Self {
        let mut work = Self {
            choice_start: vec![0],
            row_start: vec![0],
            column: Vec::new(),
            rate: Vec::new(),
            rewards,
            speed: 0.0,
        };
        let mut next = 0;
        for (place, state) in component.states.iter().enumerate() {
            let own = rows(*state);
            while component
                .rows
                .get(next)
                .is_some_and(|row| own.contains(row))
            {
                let mut sum = 0.0;
                for (target, p) in matrix.row(component.rows[next]) {
                    if local[target] as usize != place {
                        work.column.push(local[target]);
                        work.rate.push(*p);
                        sum += p;
                    }
                }
                work.speed = work.speed.max(sum);
                work.row_start.push(work.column.len());
                next += 1;
            }
            work.choice_start.push(next);
        }
        work
    }

    /// The number of states.
    pub fn num_states(&self) -> usize {
        self.choice_start.len() - 1
    }

    /// Where a row's entries are.
    pub fn range(&self, row: usize) -> Range<usize> {
        self.row_start[row]..self.row_start[row + 1]
    }

    /// A row's targets, ascending, and their rates.
    pub fn entries(&self, row: usize) -> (&[u32], &[f64]) {
        (&self.column[self.range(row)], &self.rate[self.range(row)])
    }

    /// Bounds of a component without alternatives, and the rounds; `None` if they do not come close soon.
    ///
    /// `x` comes from the equations ([`super::krylov`]): rounds in place would only make what is left to solve larger.
    pub fn quickly(&self, context: &Context<'_>) -> Result<Option<(Bounds, u64)>, CheckError> {
        let states = self.num_states();
        let (mut x, mut drift) = (vec![0.0; states], vec![0.0; states]);
        let mut best = Bounds {
            low: 0.0,
            high: f64::INFINITY,
        };
        let mut rounds = 0;
        let mut equations = None;
        let mut closest = f64::INFINITY;
        let mut solutions = 0;
        loop {
            if context.options.must_stop() {
                return Ok(Some((best, rounds)));
            }
            context.options.check_cancelled()?;
            let now = self.bounds(&x, &mut drift, true, context.entry_error);
            if !(now.low.is_finite() && now.high.is_finite()) {
                return Ok(None);
            }
            best.low = best.low.max(now.low);
            best.high = best.high.min(now.high);
            rounds += 1;
            if best.high - best.low <= context.options.precision / 2.0 * best.low {
                return Ok(Some((best, rounds)));
            }
            let mut gain = now.middle();
            let width = now.high - now.low;
            if solutions == SOLUTIONS || (solutions > 1 && width > closest / 2.0) {
                return Ok(None);
            }
            closest = closest.min(width);
            solutions += 1;
            let equations = equations.get_or_insert_with(|| Equations::new(self, self.reference()));
            let reward = |state: usize| self.rewards[state].middle();
            let goal = SHARE * context.options.precision;
            rounds += equations.improve(&mut x, &mut gain, reward, goal, context)? as u64;
        }
    }

    /// A state in which the chain seems to be often.
    ///
    /// Jumps are followed from everywhere, state by state in place, half of what is in a state at a time; a share of time is that of
    /// jumps over the rate of leaving.
    fn reference(&self) -> usize {
        let states = self.num_states();
        let leaving = |state: usize| self.entries(state).1.iter().sum::<f64>();
        let mut visits = vec![1.0; states];
        for flow in 0..FLOWS {
            for place in 0..states {
                let state = match flow % 2 {
                    0 => place,
                    _ => states - 1 - place,
                };
                let (columns, rates) = self.entries(state);
                let moved = visits[state] / 2.0;
                visits[state] -= moved;
                let part = moved / rates.iter().sum::<f64>();
                for (column, rate) in columns.iter().zip(rates) {
                    visits[*column as usize] += rate * part;
                }
            }
        }
        let share = |state: usize| visits[state] / leaving(state);
        let greatest = |best: (usize, f64), state: usize| match share(state) {
            share if share > best.1 => (state, share),
            _ => best,
        };
        (0..states).fold((0, 0.0), greatest).0
    }

    /// Iterates until the bounds are close; the bounds and the rounds.
    ///
    /// Without alternatives, rounds in place, each state by its own rate of leaving (Gauss-Seidel), are far faster
    /// where rates differ; where they do not bring the bounds together, rounds by the greatest rate follow, which always do in the end. The
    /// bounds hold for any `x`.
    pub fn run(&self, maximise: bool, context: &Context<'_>) -> Result<(Bounds, u64), CheckError> {
        let states = self.choice_start.len() - 1;
        let mut x = vec![0.0; states];
        let mut drift = vec![0.0; states];
        let mut best = Bounds {
            low: 0.0,
            high: f64::INFINITY,
        };
        let precision = context.options.precision / 2.0;
        let pace = 0.9 / self.speed.max(f64::MIN_POSITIVE);
        // With alternatives, rounds in place may diverge.
        let mut in_place = self.row_start.len() == self.choice_start.len();
        let mut round = 0;
        loop {
            if context.options.must_stop() {
                return Ok((best, round));
            }
            context.options.check_cancelled()?;
            let now = self.bounds(&x, &mut drift, maximise, context.entry_error);
            if !(now.low.is_finite() && now.high.is_finite()) {
                (in_place, round) = (false, round + 1);
                x.fill(0.0);
                continue;
            }
            best.low = best.low.max(now.low);
            best.high = best.high.min(now.high);
            round += 1;
            if best.high - best.low <= precision * best.low || round >= ROUNDS {
                return Ok((best, round));
            }
            if in_place && round < IN_PLACE {
                let gain = now.middle();
                for _ in 0..SWEEPS {
                    self.sweep(&mut x, gain, round.is_multiple_of(2));
                    round += 1;
                }
                let reference = x[0];
                x.iter_mut().for_each(|x| *x -= reference);
            } else {
                let reference = drift[0];
                let pairs = x.iter_mut().zip(&drift);
                pairs.for_each(|(x, drift)| *x += pace * (drift - reference));
            }
        }
    }

    /// The least and the greatest `d`; and `d` in the middle of its bounds, for each state.
    fn bounds(&self, x: &[f64], drift: &mut [f64], maximise: bool, entry_error: f64) -> Bounds {
        let mut all = Bounds {
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
        };
        for (state, drift) in drift.iter_mut().enumerate() {
            let d = self.drift(state, x, maximise, entry_error);
            all.low = all.low.min(d.low);
            all.high = all.high.max(d.high);
            // Not `middle`: numbers that overflow are told by the bounds of all.
            *drift = d.low + (d.high - d.low) / 2.0;
        }
        all
    }

    /// One round in place of a chain: each state's `d` becomes nearly `gain`.
    fn sweep(&self, x: &mut [f64], gain: f64, forwards: bool) {
        let states = x.len();
        for position in 0..states {
            let state = match forwards {
                true => position,
                false => states - 1 - position,
            };
            let range = self.row_start[state]..self.row_start[state + 1];
            let (mut value, mut leaving) = (self.rewards[state].high, 0.0);
            for (column, rate) in self.column[range.clone()].iter().zip(&self.rate[range]) {
                value += rate * (x[*column as usize] - x[state]);
                leaving += rate;
            }
            if leaving > 0.0 {
                x[state] += RELAXATION * (value - gain) / leaving;
            }
        }
    }

    /// `d` at a state, with its rounding error.
    fn drift(&self, state: usize, x: &[f64], maximise: bool, entry_error: f64) -> Bounds {
        let mut best: Option<Bounds> = None;
        for row in self.choice_start[state]..self.choice_start[state + 1] {
            let range = self.row_start[row]..self.row_start[row + 1];
            let Bounds { mut low, mut high } = self.rewards[row];
            let (mut moved, mut size) = (0.0, high);
            let terms = range.len() + 2;
            for (column, rate) in self.column[range.clone()].iter().zip(&self.rate[range]) {
                let term = rate * (x[*column as usize] - x[state]);
                moved += term;
                size += term.abs();
            }
            let margin = size * (2.0 * entry_error + 2.0 * (terms + 2) as f64 * UNIT);
            low += moved - margin;
            high += moved + margin;
            best = Some(match best {
                None => Bounds { low, high },
                Some(known) if maximise => Bounds {
                    low: low.max(known.low),
                    high: high.max(known.high),
                },
                Some(known) => Bounds {
                    low: low.min(known.low),
                    high: high.min(known.high),
                },
            });
        }
        best.unwrap_or(Bounds::ZERO)
    }
}
