//! Long-run averages, by gain and bias.
//!
//! *Definition.* For any numbers `x` on an end component, with `d_sc = g_sc + e_s sum_t p_ct (x_t - x_s)` over its choices
//! (`g` is earned per unit of time, `e` the rate of steps, 1 in discrete time),
//!
//! ```text
//! greatest average:  min_s max_c d_sc  <=  average  <=  max_s max_c d_sc
//! least average:     min_s min_c d_sc  <=  average  <=  max_s min_c d_sc
//! ```
//!
//! however `x` was found: here by linear equations for small chains, else by value iteration, in floating point. Which
//! component a path stays in is a question of reachability: each may stop in a goal with its average, scaled to a
//! probability (the least average as the greatest of what is missing).
//!
//! Source: Puterman 1994, theorem 8.5.5; de Alfaro 1997. Guarantee: `d` in directed rounding, reachability by inequalities.

use num_traits::{One, Zero};
use prism_lang::{Rational, rational_to_f64};

use crate::evaluate::Evaluator;
use crate::explicit::{end_components, quotient};
use crate::failure::Failure;
use crate::inequalities::Problem;
use crate::interval::Interval;
use crate::reading::{Choice, Reading};

/// States of a component that is solved by elimination.
const SMALL: usize = 300;
const MOST_ROUNDS: usize = 200_000;
/// The relative distance of the bounds that iteration ends with.
const CLOSE: f64 = 1e-10;

/// A component in numbers of its own, in floating point.
struct Component {
    /// For each state its staying choices: their place, targets and probabilities.
    rows: Vec<Vec<Row>>,
    rate: Vec<f64>,
    states: Vec<usize>,
}

struct Row {
    place: usize,
    gain: f64,
    outcomes: Vec<(usize, f64)>,
}

impl Component {
    fn new(reading: &Reading, gain: &[Vec<Interval>], states: Vec<usize>) -> Self {
        let rows = states.iter().map(|state| {
            let choices = reading.choices[*state].iter().enumerate();
            let row = |(place, choice): (usize, &Choice)| {
                let outcome = |(target, p): &(usize, Rational)| {
                    let target = states.binary_search(target).ok()?;
                    Some((target, rational_to_f64(p)))
                };
                let outcomes = choice.outcomes.iter().map(outcome).collect::<Option<_>>()?;
                let gain = gain[*state][place];
                Some(Row {
                    place,
                    gain: 0.5 * (gain.low + gain.high),
                    outcomes,
                })
            };
            choices.filter_map(row).collect()
        });
        Self {
            rows: rows.collect(),
            rate: (states.iter())
                .map(|state| rational_to_f64(&reading.rate[*state]))
                .collect(),
            states,
        }
    }

    fn change(&self, state: usize, row: &Row, x: &[f64]) -> f64 {
        let outcomes = row.outcomes.iter();
        let mean: f64 = outcomes
            .map(|(target, p)| p * (x[*target] - x[state]))
            .sum();
        row.gain + self.rate[state] * mean
    }

    fn best(&self, state: usize, x: &[f64], maximise: bool) -> f64 {
        let changes = self.rows[state]
            .iter()
            .map(|row| self.change(state, row, x));
        match maximise {
            true => changes.fold(f64::NEG_INFINITY, f64::max),
            false => changes.fold(f64::INFINITY, f64::min),
        }
    }

    /// Numbers for which the bounds are close, as far as they are found.
    fn numbers(&self, maximise: bool) -> Vec<f64> {
        let states = self.states.len();
        let is_small_chain = states <= SMALL && self.rows.iter().all(|rows| rows.len() == 1);
        if is_small_chain && let Some(x) = self.eliminated() {
            return x;
        }
        let fastest = self.rate.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let mut x = vec![0.0; states];
        for _ in 0..MOST_ROUNDS.min(2_000_000_000 / states.max(1)) {
            let changes: Vec<f64> = (0..states).map(|s| self.best(s, &x, maximise)).collect();
            let least = changes.iter().copied().fold(f64::INFINITY, f64::min);
            let most = changes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            if most - least <= CLOSE * most.abs().max(least.abs()) {
                break;
            }
            let first = x[0] + changes[0] / (2.0 * fastest);
            for (x, change) in x.iter_mut().zip(&changes) {
                *x += change / (2.0 * fastest) - first;
            }
        }
        x
    }

    /// The bias of a chain, with that of the first state 0: unknowns are the gain, in its place, and the others.
    fn eliminated(&self) -> Option<Vec<f64>> {
        let n = self.states.len();
        let mut matrix = vec![vec![0.0; n + 1]; n];
        for (state, rows) in self.rows.iter().enumerate() {
            let line = &mut matrix[state];
            line[0] = -1.0;
            line[n] = -rows[0].gain;
            for (target, p) in &rows[0].outcomes {
                if *target != 0 {
                    line[*target] += self.rate[state] * p;
                }
                if state != 0 {
                    line[state] -= self.rate[state] * p;
                }
            }
        }
        for column in 0..n {
            let pivot = (column..n).max_by(|a, b| {
                matrix[*a][column]
                    .abs()
                    .total_cmp(&matrix[*b][column].abs())
            })?;
            if matrix[pivot][column] == 0.0 {
                return None;
            }
            matrix.swap(column, pivot);
            let (above, below) = matrix.split_at_mut(column + 1);
            let own = &above[column];
            for line in below {
                let factor = line[column] / own[column];
                if factor != 0.0 {
                    for (entry, own) in line[column..].iter_mut().zip(&own[column..]) {
                        *entry -= factor * own;
                    }
                }
            }
        }
        let mut x = vec![0.0; n];
        for row in (0..n).rev() {
            let known: f64 = (row + 1..n).map(|c| matrix[row][c] * x[c]).sum();
            x[row] = (matrix[row][n] - known) / matrix[row][row];
        }
        x[0] = 0.0;
        x.iter().all(|x| x.is_finite()).then_some(x)
    }

    /// The bounds that some numbers show.
    fn shown(
        &self,
        reading: &Reading,
        gain: &[Vec<Interval>],
        x: &[f64],
        maximise: bool,
    ) -> Interval {
        let of = |state: usize| {
            let number = self.states[state];
            let rate = Interval::of(&reading.rate[number]);
            let change = |row: &Row| {
                let mut sum = Interval::ZERO;
                for ((target, _), (_, p)) in row
                    .outcomes
                    .iter()
                    .zip(&reading.choices[number][row.place].outcomes)
                {
                    let by = Interval::exactly(x[*target]).sub(&Interval::exactly(x[state]));
                    sum = sum.add(&Interval::of(p).mul(&by));
                }
                gain[number][row.place].add(&rate.mul(&sum))
            };
            let changes = self.rows[state].iter().map(change);
            changes
                .reduce(|a, b| a.best(&b, maximise))
                .unwrap_or(Interval::ZERO)
        };
        let ends = (0..self.states.len()).map(of);
        let joined = ends.reduce(|a, b| Interval {
            low: a.low.min(b.low),
            high: a.high.max(b.high),
        });
        joined.unwrap_or(Interval::ZERO)
    }
}

impl Evaluator<'_> {
    /// The average of what is earned per unit of time, in each state.
    pub(crate) fn average(
        &mut self,
        reading: &Reading,
        gain: &[Vec<Interval>],
        maximise: bool,
    ) -> Result<Vec<Interval>, Failure> {
        let states = reading.states.len();
        let all = end_components(&reading.choices, &vec![true; states], &|_| true);
        let mut gains = Vec::new();
        for component in &all {
            let component = Component::new(reading, gain, component.clone());
            let x = component.numbers(maximise);
            let shown = component.shown(reading, gain, &x, maximise);
            self.inequalities += component.states.len() as u64;
            // Nothing negative is earned.
            gains.push(shown.at_least(0.0));
        }
        if let [only] = &gains[..] {
            return Ok(vec![*only; states]);
        }
        let most = gains.iter().map(|gain| gain.high).fold(0.0, f64::max);
        if most == 0.0 {
            return Ok(vec![Interval::ZERO; states]);
        }
        let mut ends = [Vec::new(), Vec::new()];
        for (end, is_high) in [false, true].into_iter().enumerate() {
            let share = |gain: &Interval| {
                let gain = if is_high { gain.high } else { gain.low };
                let share = exact(gain) / exact(most);
                match maximise {
                    true => share,
                    false => Rational::one() - share,
                }
            };
            let shares: Vec<Rational> = gains.iter().map(share).collect();
            ends[end] = self.stopping(reading, &all, &shares)?;
        }
        let scale = Interval::exactly(most);
        let value = |state: usize| {
            let (low, high) = (ends[0][state], ends[1][state]);
            let of = |share: Interval| match maximise {
                true => scale.mul(&share),
                false => scale.mul(&share.contrary()),
            };
            Interval {
                low: of(low).low,
                high: of(high).high,
            }
        };
        Ok((0..states).map(value).collect())
    }

    /// The greatest probability of stopping in a goal, where each component may stop there with its share.
    fn stopping(
        &mut self,
        reading: &Reading,
        components: &[Vec<usize>],
        shares: &[Rational],
    ) -> Result<Vec<Interval>, Failure> {
        let states = reading.states.len();
        let (class, mut choices) = quotient(&reading.choices, components);
        let classes = choices.len();
        let (goal, sink) = (classes, classes + 1);
        for (number, share) in shares.iter().enumerate() {
            let outcomes = [(goal, share.clone()), (sink, Rational::one() - share)];
            choices[number].push(Choice {
                outcomes: (outcomes.into_iter().filter(|(_, p)| !p.is_zero())).collect(),
                reward: Rational::zero(),
            });
        }
        for end in [goal, sink] {
            choices.push(vec![Choice {
                outcomes: vec![(end, Rational::one())],
                reward: Rational::zero(),
            }]);
        }
        let of = |end: usize| {
            (0..classes + 2)
                .map(|number| number == end)
                .collect::<Vec<_>>()
        };
        let (target, failed) = (of(goal), of(sink));
        let values = self.solved(Problem {
            choices: &choices,
            target: &target,
            failed: &failed,
            is_reward: false,
            maximise: true,
        })?;
        Ok((0..states).map(|state| values[class[state]]).collect())
    }
}

fn exact(value: f64) -> Rational {
    Rational::from_float(value).unwrap_or_else(Rational::zero)
}
