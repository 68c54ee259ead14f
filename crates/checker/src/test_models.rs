//! Random decision processes with rational probabilities, for tests.

use prism_lang::{Rational, rational_to_f64};
use proptest::prelude::*;

use crate::choices::Choices;
use crate::graph::NO_ROW;
use crate::state_space::Csr;

/// A decision process.
#[derive(Debug, Clone)]
pub(crate) struct Process {
    pub matrix: Csr<Rational>,
    pub choice_start: Vec<usize>,
}

impl Process {
    pub fn choices(&self) -> Choices<'_, Rational> {
        Choices::new(&self.matrix, &self.choice_start)
    }

    pub fn num_states(&self) -> usize {
        self.choice_start.len() - 1
    }

    /// All memoryless schedulers: a row for each state.
    pub fn schedulers(&self) -> impl Iterator<Item = Vec<usize>> + '_ {
        let counts: Vec<usize> = self.choice_start.windows(2).map(|w| w[1] - w[0]).collect();
        (0..counts.iter().product()).map(move |mut number: usize| {
            let choose = |(state, count): (usize, &usize)| {
                let chosen = self.choice_start[state] + number % count;
                number /= count;
                chosen
            };
            counts.iter().enumerate().map(choose).collect()
        })
    }

    /// The scheduler with the first choice where it leaves one open.
    pub fn completed(&self, scheduler: &[usize]) -> Vec<usize> {
        let starts = self.choice_start.iter();
        let pairs = scheduler.iter().zip(starts);
        pairs
            .map(|(row, first)| if *row == NO_ROW { *first } else { *row })
            .collect()
    }

    /// The chain of a scheduler.
    pub fn chain(&self, rows: &[usize]) -> Csr<Rational> {
        let row = |row: &usize| {
            self.matrix
                .row(*row)
                .map(|(to, p)| (to as u32, p.clone()))
                .collect()
        };
        Csr::from_rows(rows.iter().map(row).collect())
    }
}

/// The matrix in floating point.
pub(crate) fn rounded(matrix: &Csr<Rational>) -> Csr<f64> {
    Csr {
        row_start: matrix.row_start.clone(),
        column: matrix.column.clone(),
        value: matrix.value.iter().map(rational_to_f64).collect(),
    }
}

/// Up to `states` states with one to three choices each; many weights are 0, some large.
pub(crate) fn arbitrary_process(states: usize) -> impl Strategy<Value = Process> {
    let weight = prop_oneof![5 => Just(0u32), 3 => 1u32..4, 1 => Just(1000)];
    (2..=states).prop_flat_map(move |states| {
        let row = prop::collection::vec(weight.clone(), states);
        let choices = prop::collection::vec(row, 1..=3);
        prop::collection::vec(choices, states).prop_map(|weights| {
            let mut rows = Vec::new();
            let mut choice_start = vec![0];
            for (state, choices) in weights.iter().enumerate() {
                rows.extend(choices.iter().map(|weights| normalised(state, weights)));
                choice_start.push(rows.len());
            }
            Process {
                matrix: Csr::from_rows(rows),
                choice_start,
            }
        })
    })
}

fn normalised(state: usize, weights: &[u32]) -> Vec<(u32, Rational)> {
    let total: u32 = weights.iter().sum();
    if total == 0 {
        return vec![(state as u32, Rational::from_integer(1.into()))];
    }
    let share = |weight: u32| Rational::new(weight.into(), total.into());
    let entries = weights
        .iter()
        .enumerate()
        .filter(|(_, weight)| **weight > 0);
    entries
        .map(|(to, weight)| (to as u32, share(*weight)))
        .collect()
}
