//! The equations of one strongly connected component, in compact form.
//!
//! Rows are divided by the probability `s` of leaving their state, which is a sum, so that one application of a row is a sum of products.
//! That rounds each number once more; [`Local::error`] and the callers' bounds of the errors of entries allow for it.

use super::sound::Equations;
use crate::elimination::System;
use crate::rounding::{Bounds, UNIT};

/// No position.
pub(super) const OUTSIDE: u32 = u32::MAX;

/// Which of the two sides of every number that comes from outside is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Low,
    High,
}

/// Rows are choices, columns are positions in the component; what leads out is in the right-hand sides.
#[derive(Debug, Default)]
pub(crate) struct Local {
    /// The choices of each position.
    pub choice_start: Vec<usize>,
    pub row_start: Vec<usize>,
    pub column: Vec<u32>,
    pub probability: Vec<f64>,
    /// Probability of leaving the component.
    pub exit: Vec<f64>,
    /// What leads out and is earned, with the lower and the upper values outside.
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    /// The problem's row of each choice.
    pub origin: Vec<usize>,
    /// Relative error of one application of a row.
    pub error: f64,
    /// Entries of the longest row that lead out.
    pub longest_exit: usize,
}

impl Local {
    /// The equations of a component, given the values outside.
    pub fn new(equations: &Equations<'_>, component: &[u32], position: &mut [u32]) -> Self {
        for (place, state) in component.iter().enumerate() {
            position[*state as usize] = place as u32;
        }
        let mut local = Self {
            choice_start: vec![0],
            row_start: vec![0],
            ..Self::default()
        };
        let mut longest = 0;
        for state in component {
            let state = *state as usize;
            for row in equations.choices.rows(state) {
                longest = longest.max(local.push(equations, state, row, position));
            }
            local.choice_start.push(local.exit.len());
        }
        for state in component {
            position[*state as usize] = OUTSIDE;
        }
        // The sum, the inverse of another, and the product; doubled for the higher orders.
        local.error = 2.0 * (2.0 * longest as f64 + 8.0) * UNIT;
        local
    }

    /// The equations of a chain for one of two problems, whose right-hand sides are these two (0 is the probability of leaving).
    pub fn of_chain(system: &System<f64, 5>, [low, high]: [usize; 2]) -> Self {
        let mut local = Self {
            choice_start: (0..=system.rows.len()).collect(),
            row_start: vec![0],
            ..Self::default()
        };
        let mut longest = 0;
        for (row, rhs) in system.rows.iter().zip(&system.rhs) {
            longest = longest.max(row.len());
            let inside: f64 = row.iter().map(|(_, p)| p).sum();
            local.column.extend(row.iter().map(|(column, _)| *column));
            local.probability.extend(row.iter().map(|(_, p)| *p));
            local.finish_row(rhs[0], [rhs[low], rhs[high]], inside);
        }
        local.error = 2.0 * (2.0 * longest as f64 + 8.0) * UNIT;
        local
    }

    /// Adds a choice, unless it is left out; returns its length.
    fn push(
        &mut self,
        equations: &Equations<'_>,
        state: usize,
        row: usize,
        position: &[u32],
    ) -> usize {
        let mut sum = (equations.reward.get(row).copied()).unwrap_or(Bounds::ZERO);
        let (mut exit, mut inside, mut length, mut exits) = (0.0, 0.0, 0, 0);
        for (target, p) in equations.choices.matrix.row(row) {
            if target == state {
                continue;
            }
            length += 1;
            match position[target] {
                OUTSIDE => {
                    exit += p;
                    exits += 1;
                    sum.low += p * equations.values[target].low;
                    sum.high += p * equations.values[target].high;
                }
                place => {
                    inside += p;
                    self.column.push(place);
                    self.probability.push(*p);
                }
            }
        }
        if length == 0 || sum.low == f64::INFINITY {
            let kept = self.row_start[self.row_start.len() - 1];
            self.column.truncate(kept);
            self.probability.truncate(kept);
            return 0;
        }
        self.finish_row(exit, [sum.low, sum.high], inside);
        self.origin.push(row);
        self.longest_exit = self.longest_exit.max(exits);
        length
    }

    /// Ends a row whose entries are there, and divides it by the probability of leaving the state.
    pub(super) fn finish_row(&mut self, exit: f64, [low, high]: [f64; 2], inside: f64) {
        let start = self.row_start.last().copied().unwrap_or(0);
        let inverse = 1.0 / (exit + inside);
        for p in &mut self.probability[start..] {
            *p *= inverse;
        }
        self.row_start.push(self.column.len());
        self.exit.push(exit * inverse);
        self.low.push(low * inverse);
        self.high.push(high * inverse);
    }

    pub fn len(&self) -> usize {
        self.choice_start.len() - 1
    }

    pub fn entries(&self) -> usize {
        self.column.len()
    }

    /// How many entries lead to a position behind their own.
    pub fn entries_back(&self) -> usize {
        let rows = |place: usize| self.choice_start[place]..self.choice_start[place + 1];
        let of_place = |place: usize| {
            let rows = rows(place);
            let entries = &self.column[self.row_start[rows.start]..self.row_start[rows.end]];
            let back = |column: &&u32| **column as usize > place;
            entries.iter().filter(back).count()
        };
        (0..self.len()).map(of_place).sum()
    }

    /// Whether no state has an alternative.
    pub fn is_chain(&self) -> bool {
        self.exit.len() == self.len()
    }

    /// Whether both sides are the same problem but for this relative difference.
    pub fn is_one_sided(&self, but_for: f64) -> bool {
        let pairs = self.low.iter().zip(&self.high);
        pairs
            .into_iter()
            .all(|(low, high)| high - low <= but_for * low)
    }

    /// The value of a choice.
    #[inline]
    pub fn row_value(&self, row: usize, x: &[f64], side: Side) -> f64 {
        let range = self.row_start[row]..self.row_start[row + 1];
        let mut sum = match side {
            Side::Low => self.low[row],
            Side::High => self.high[row],
        };
        for (column, p) in self.column[range.clone()]
            .iter()
            .zip(&self.probability[range])
        {
            sum += p * x[*column as usize];
        }
        sum
    }

    /// The best choice at a position and its value.
    #[inline]
    pub fn best(&self, place: usize, x: &[f64], side: Side, maximise: bool) -> (usize, f64) {
        let rows = self.choice_start[place]..self.choice_start[place + 1];
        let mut best = (rows.start, self.row_value(rows.start, x, side));
        for row in rows.start + 1..rows.end {
            let value = self.row_value(row, x, side);
            if (value > best.1) == maximise && value != best.1 {
                best = (row, value);
            }
        }
        best
    }

    /// The equations of the chain in which these choices are taken: right-hand sides are the probability of
    /// leaving, the lower and the upper side.
    pub fn system(&self, policy: &[usize]) -> System<f64, 3> {
        let row = |row: &usize| {
            let range = self.row_start[*row]..self.row_start[*row + 1];
            let columns = self.column[range.clone()].iter().copied();
            let mut entries: Vec<_> = columns
                .zip(self.probability[range].iter().copied())
                .collect();
            entries.sort_unstable_by_key(|(column, _)| *column);
            entries
        };
        let rhs = |row: &usize| [self.exit[*row], self.low[*row], self.high[*row]];
        System {
            rows: policy.iter().map(row).collect(),
            rhs: policy.iter().map(rhs).collect(),
        }
    }
}
