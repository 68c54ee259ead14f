//! Bounds of the gain of an end component by iteration; see [`super`].

use std::ops::Range;

use crate::answer::CheckError;
use crate::engine::Context;
use crate::graph::EndComponent;
use crate::rounding::{Bounds, UNIT};
use crate::state_space::Csr;

/// Rounds after which the bounds reached are taken.
const ROUNDS: u64 = 1_000_000;

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

    /// Iterates until the bounds are close; the bounds and the rounds.
    pub fn run(&self, maximise: bool, context: &Context<'_>) -> Result<(Bounds, u64), CheckError> {
        let states = self.choice_start.len() - 1;
        let mut x = vec![0.0; states];
        let mut drift = vec![0.0; states];
        let mut best = Bounds {
            low: f64::NEG_INFINITY,
            high: f64::INFINITY,
        };
        let pace = 0.9 / self.speed.max(f64::MIN_POSITIVE);
        for round in 1..=ROUNDS {
            if round % 16 == 0 {
                context.options.check_cancelled()?;
            }
            let mut now = Bounds {
                low: f64::INFINITY,
                high: f64::NEG_INFINITY,
            };
            for (state, drift) in drift.iter_mut().enumerate() {
                let d = self.drift(state, &x, maximise, context.entry_error);
                now.low = now.low.min(d.low);
                now.high = now.high.max(d.high);
                *drift = d.middle();
            }
            best.low = best.low.max(now.low).max(0.0);
            best.high = best.high.min(now.high);
            if best.high - best.low <= context.options.precision / 2.0 * best.low || round == ROUNDS
            {
                return Ok((best, round));
            }
            let reference = drift[0];
            let pairs = x.iter_mut().zip(&drift);
            pairs.for_each(|(x, drift)| *x += pace * (drift - reference));
        }
        Ok((best, ROUNDS))
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
