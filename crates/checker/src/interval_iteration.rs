//! Reachability within one strongly connected component by iteration from below and from above.
//!
//! With the equations of [`crate::elimination`], let `F(x)_i = (n_i + sum_{j != i} p_ij x_j) / s_i`. `F` is
//! monotone and has one fixed point, since every state can leave. A vector below (above) the fixed point
//! stays below (above) when `F` is applied, so bounds that start on the right side remain bounds at every
//! moment:
//!
//! * the lower one starts with the least value outside, the upper one with the greatest;
//! * each state is updated in place (Gauss-Seidel), forwards and backwards in turn;
//! * rounding is to nearest, then downwards for the lower and upwards for the upper bound by more than the
//!   relative error of a sum of `r` positive terms and a division;
//! * when the lower bound hardly moves any more, an upper bound is guessed just above it; if one round of
//!   `F` moves no component of the guess up, it is inductive, hence a true upper bound. A failed guess
//!   is dropped. This spares most of the work that the upper bound would need on its own.
//!
//! Source: Haddad and Monmege 2018 and Baier, Klein, Leuschner, Parker and Wunderlich 2017 (interval
//! iteration); Hartmanns and Kaminski 2020 (optimistic value iteration: the guess). Deviations: off-diagonal
//! form, Gauss-Seidel rounds, rounding accounted for.
//!
//! Cost: rounds times transitions; the number of rounds depends on how fast the component is left. Guarantee:
//! the bounds always hold, converged or not.

use crate::elimination::System;
use crate::rounding::{Bounds, SMALLEST_VALUE, UNIT};

/// The bounds of one state: lower and upper one of the value, then of the contrary's.
pub(crate) type Enclosure = [f64; 4];

/// Equations in compact form, and the bounds found so far.
pub(crate) struct Iteration {
    row_start: Vec<usize>,
    column: Vec<u32>,
    probability: Vec<f64>,
    /// `1 / s_i`.
    inverse_total: Vec<f64>,
    /// Relative error of one update.
    error: Vec<f64>,
    rhs: Vec<Enclosure>,
    /// The bounds of each state.
    pub bounds: Vec<Enclosure>,
    /// Rounds so far.
    pub rounds: u64,
}

/// What a round has brought.
struct Progress {
    /// Whether some lower bound rose by more than the share that was asked about.
    rising: bool,
    /// Whether any bound moved.
    moved: bool,
    /// Whether all bounds are close enough.
    close: bool,
}

impl Iteration {
    /// Starts with the least and greatest values outside, for the value and for the contrary.
    pub fn new(system: &System<f64, 5>, outside: [Bounds; 2]) -> Self {
        let states = system.rows.len();
        let mut row_start = vec![0];
        let (mut column, mut probability) = (Vec::new(), Vec::new());
        let (mut inverse_total, mut error) = (Vec::new(), Vec::new());
        for (row, rhs) in system.rows.iter().zip(&system.rhs) {
            column.extend(row.iter().map(|(column, _)| *column));
            probability.extend(row.iter().map(|(_, value)| *value));
            row_start.push(column.len());
            inverse_total.push(1.0 / (row.iter().map(|(_, value)| value).sum::<f64>() + rhs[0]));
            // Both sums, the inverse and the product, doubled for the higher orders.
            error.push(2.0 * (2.0 * row.len() as f64 + 7.0) * UNIT);
        }
        let [value, contrary] = outside;
        let start = [value.low, value.high, contrary.low, contrary.high];
        Self {
            row_start,
            column,
            probability,
            inverse_total,
            error,
            rhs: system
                .rhs
                .iter()
                .map(|[_, a, b, c, d]| [*a, *b, *c, *d])
                .collect(),
            bounds: vec![start; states],
            rounds: 0,
        }
    }

    /// Iterates until the relative width is at most `tolerance` everywhere or `max_rounds` have passed;
    /// whether it converged.
    pub fn run(&mut self, tolerance: f64, max_rounds: u64, cancelled: &dyn Fn() -> bool) -> bool {
        let last = self.rounds.saturating_add(max_rounds);
        let mut patience = tolerance / 10.0;
        while self.rounds < last {
            if self.rounds.is_multiple_of(16) && cancelled() {
                return false;
            }
            let progress = self.round(tolerance, patience);
            if progress.close {
                return true;
            }
            if !progress.rising {
                if self.guess(tolerance) {
                    return true;
                }
                patience /= 4.0;
            }
            if !progress.moved {
                return false;
            }
        }
        false
    }

    /// Updates all bounds once.
    fn round(&mut self, tolerance: f64, patience: f64) -> Progress {
        let mut progress = Progress {
            rising: false,
            moved: false,
            close: true,
        };
        for position in 0..self.bounds.len() {
            let state = self.in_order(position);
            let new = self.apply(state, &self.bounds);
            let (down, up) = (1.0 - self.error[state], 1.0 + self.error[state]);
            let known = &mut self.bounds[state];
            for (low, high) in [(0, 1), (2, 3)] {
                let (better_low, better_high) = (new[low] * down, new[high] * up);
                progress.rising |= better_low - known[low] > patience * better_low;
                progress.moved |= better_low > known[low] || better_high < known[high];
                known[low] = known[low].max(better_low);
                known[high] = known[high].min(better_high);
                progress.close &= is_close(known[low], known[high], tolerance);
            }
        }
        self.rounds += 1;
        progress
    }

    /// The states forwards in even, backwards in odd rounds.
    fn in_order(&self, position: usize) -> usize {
        if self.rounds.is_multiple_of(2) {
            position
        } else {
            self.bounds.len() - 1 - position
        }
    }

    /// `F(x)` at a state, rounded to nearest.
    fn apply(&self, state: usize, x: &[Enclosure]) -> Enclosure {
        let range = self.row_start[state]..self.row_start[state + 1];
        let mut sum = self.rhs[state];
        for (column, p) in self.column[range.clone()]
            .iter()
            .zip(&self.probability[range])
        {
            let target = &x[*column as usize];
            for (sum, target) in sum.iter_mut().zip(target) {
                *sum += p * target;
            }
        }
        sum.map(|sum| sum * self.inverse_total[state])
    }

    /// Tries upper bounds just above the lower ones; whether both held, so that all bounds are close.
    fn guess(&mut self, tolerance: f64) -> bool {
        const ROUNDS: usize = 8;
        let factor = 1.0 + 0.9 * tolerance;
        let above = |[a, b, c, d]: &Enclosure| [*a, (a * factor).min(*b), *c, (c * factor).min(*d)];
        let mut guess: Vec<Enclosure> = self.bounds.iter().map(above).collect();
        let mut held = [false; 2];
        for _ in 0..ROUNDS {
            let mut inductive = [true; 2];
            for position in 0..guess.len() {
                let state = self.in_order(position);
                let next = self.apply(state, &guess);
                for (problem, high) in [(0, 1), (1, 3)] {
                    let next = next[high] * (1.0 + self.error[state]);
                    inductive[problem] &= next <= guess[state][high];
                    guess[state][high] = next;
                }
            }
            for (problem, high) in [(0, 1), (1, 3)] {
                if inductive[problem] && !held[problem] {
                    held[problem] = true;
                    let pairs = self.bounds.iter_mut().zip(&guess);
                    pairs.for_each(|(known, guess)| known[high] = known[high].min(guess[high]));
                }
            }
            if held == [true; 2] {
                break;
            }
        }
        let close =
            |[a, b, c, d]: &Enclosure| is_close(*a, *b, tolerance) && is_close(*c, *d, tolerance);
        self.bounds.iter().all(close)
    }
}

/// Whether the relative width is at most `tolerance`, or the value so small that it is only known to be below a number.
fn is_close(low: f64, high: f64, tolerance: f64) -> bool {
    high <= SMALLEST_VALUE || high - low <= tolerance * low
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cycle of `states` states that is left upwards with probability `out` at each.
    fn cycle(states: usize, out: f64) -> System<f64, 5> {
        let next = |state: usize| vec![(((state + 1) % states) as u32, 1.0 - out)];
        System {
            rows: (0..states).map(next).collect(),
            // Exits lead to the first target with probability 1/4, else to the second.
            rhs: vec![[out, 0.25 * out, 0.25 * out, 0.75 * out, 0.75 * out]; states],
        }
    }

    #[test]
    fn bounds_meet_around_the_value() {
        let outside = [Bounds {
            low: 0.0,
            high: 1.0,
        }; 2];
        let mut iteration = Iteration::new(&cycle(100, 1e-3), outside);
        assert!(iteration.run(1e-9, 100_000, &|| false));
        for state in 0..100 {
            assert!(iteration.bounds[state][0] <= 0.25 && 0.25 <= iteration.bounds[state][1]);
            assert!(iteration.bounds[state][2] <= 0.75 && 0.75 <= iteration.bounds[state][3]);
            assert!(iteration.bounds[state][1] - iteration.bounds[state][0] < 1e-9);
        }
    }

    #[test]
    fn bounds_hold_when_stopped_early() {
        let outside = [Bounds {
            low: 0.0,
            high: 1.0,
        }; 2];
        let mut iteration = Iteration::new(&cycle(10, 1e-4), outside);
        for _ in 0..50 {
            iteration.run(1e-12, 1, &|| false);
            assert!(iteration.bounds.iter().all(|bounds| bounds[0] <= 0.25));
            assert!(iteration.bounds.iter().all(|bounds| bounds[1] >= 0.25));
        }
        assert!(iteration.bounds[0][0] > 0.0);
    }
}
