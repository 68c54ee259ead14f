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
use crate::rounding::{Bounds, UNIT};

/// The two problems solved side by side: right-hand sides 1, 2 and 3, 4 of the system.
pub(crate) const PROBLEMS: usize = 2;

/// Equations in compact form, and the bounds found so far.
pub(crate) struct Iteration {
    row_start: Vec<usize>,
    column: Vec<u32>,
    probability: Vec<f64>,
    /// `s_i`.
    total: Vec<f64>,
    /// Relative error of one update.
    error: Vec<f64>,
    rhs: Vec<[f64; 5]>,
    /// For each problem, the bounds of each state.
    pub low: [Vec<f64>; PROBLEMS],
    /// See `low`.
    pub high: [Vec<f64>; PROBLEMS],
    /// Rounds so far.
    pub rounds: u64,
}

impl Iteration {
    /// Starts with the values outside; `outside` holds the least and greatest for each problem.
    pub fn new(system: &System<f64, 5>, outside: [Bounds; PROBLEMS]) -> Self {
        let states = system.rows.len();
        let mut row_start = vec![0];
        let (mut column, mut probability) = (Vec::new(), Vec::new());
        let (mut total, mut error) = (Vec::new(), Vec::new());
        for (row, rhs) in system.rows.iter().zip(&system.rhs) {
            column.extend(row.iter().map(|(column, _)| *column));
            probability.extend(row.iter().map(|(_, value)| *value));
            row_start.push(column.len());
            total.push(row.iter().map(|(_, value)| value).sum::<f64>() + rhs[0]);
            // Both sums and the division, doubled for the higher orders.
            error.push(2.0 * (2.0 * row.len() as f64 + 6.0) * UNIT);
        }
        Self {
            row_start,
            column,
            probability,
            total,
            error,
            rhs: system.rhs.clone(),
            low: outside.map(|bounds| vec![bounds.low; states]),
            high: outside.map(|bounds| vec![bounds.high; states]),
            rounds: 0,
        }
    }

    /// Iterates until the relative width is at most `tolerance` everywhere or `max_rounds` have passed;
    /// whether it converged.
    pub fn run(&mut self, tolerance: f64, max_rounds: u64, cancelled: &dyn Fn() -> bool) -> bool {
        let last = self.rounds + max_rounds;
        let mut patience = tolerance / 10.0;
        while self.rounds < last {
            if self.rounds.is_multiple_of(64) && cancelled() {
                return false;
            }
            let mut change = 0f64;
            let mut moved = false;
            for problem in 0..PROBLEMS {
                let (low_change, high_moved) = self.round(problem);
                change = change.max(low_change);
                moved |= low_change > 0.0 || high_moved;
            }
            self.rounds += 1;
            if self.width() <= tolerance {
                return true;
            }
            if change <= patience {
                (0..PROBLEMS).for_each(|problem| self.guess(problem, tolerance));
                if self.width() <= tolerance {
                    return true;
                }
                patience /= 4.0;
            }
            if !moved {
                return false;
            }
        }
        false
    }

    /// The greatest relative width.
    fn width(&self) -> f64 {
        let pairs = self.low.iter().flatten().zip(self.high.iter().flatten());
        pairs.fold(0.0, |widest, (low, high)| {
            let bounds = Bounds {
                low: *low,
                high: *high,
            };
            widest.max(bounds.relative_width())
        })
    }

    /// One round for both bounds; the greatest relative change of the lower one, and whether the upper moved.
    fn round(&mut self, problem: usize) -> (f64, bool) {
        let mut low = std::mem::take(&mut self.low[problem]);
        let mut high = std::mem::take(&mut self.high[problem]);
        let (mut change, mut moved) = (0f64, false);
        for state in self.order() {
            let better = self.apply(state, 1 + 2 * problem, &low) * (1.0 - self.error[state]);
            if better > low[state] {
                change = change.max((better - low[state]) / better);
                low[state] = better;
            }
            let better = self.apply(state, 2 + 2 * problem, &high) * (1.0 + self.error[state]);
            if better < high[state] {
                high[state] = better;
                moved = true;
            }
        }
        self.low[problem] = low;
        self.high[problem] = high;
        (change, moved)
    }

    /// States forwards in even, backwards in odd rounds.
    fn order(&self) -> Box<dyn Iterator<Item = usize>> {
        let states = self.total.len();
        if self.rounds.is_multiple_of(2) {
            Box::new(0..states)
        } else {
            Box::new((0..states).rev())
        }
    }

    /// `F(x)` at a state, rounded to nearest.
    fn apply(&self, state: usize, rhs: usize, x: &[f64]) -> f64 {
        let range = self.row_start[state]..self.row_start[state + 1];
        let terms = self.column[range.clone()]
            .iter()
            .zip(&self.probability[range]);
        let inside: f64 = terms.map(|(column, p)| p * x[*column as usize]).sum();
        (inside + self.rhs[state][rhs]) / self.total[state]
    }

    /// Tries an upper bound just above the lower one.
    fn guess(&mut self, problem: usize, tolerance: f64) {
        const ROUNDS: usize = 8;
        let factor = 1.0 + 0.9 * tolerance;
        let above = self.low[problem].iter().zip(&self.high[problem]);
        let mut guess: Vec<f64> = above.map(|(low, high)| (low * factor).min(*high)).collect();
        for _ in 0..ROUNDS {
            let mut inductive = true;
            for state in self.order() {
                let next = self.apply(state, 2 + 2 * problem, &guess) * (1.0 + self.error[state]);
                inductive &= next <= guess[state];
                guess[state] = next;
            }
            if inductive {
                let high = self.high[problem].iter_mut();
                high.zip(&guess)
                    .for_each(|(high, guess)| *high = high.min(*guess));
                return;
            }
        }
    }
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
            assert!(iteration.low[0][state] <= 0.25 && 0.25 <= iteration.high[0][state]);
            assert!(iteration.low[1][state] <= 0.75 && 0.75 <= iteration.high[1][state]);
            assert!(iteration.high[0][state] - iteration.low[0][state] < 1e-9);
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
            assert!(iteration.low[0].iter().all(|low| *low <= 0.25));
            assert!(iteration.high[0].iter().all(|high| *high >= 0.25));
        }
        assert!(iteration.low[0][0] > 0.0);
    }
}
