//! The best mixture of known vectors, and the weights for which a new vector would tell most.
//!
//! *Problem.* Maximise `sum_k a_k x^k_0` where `a >= 0` sums to 1 and `sum_k a_k x^k_i >= t_i`; its dual variables are the
//! weights. An artificial vector that meets all bounds at a great loss stands for what is not known yet.
//!
//! *Method.* Every basis is tried: there are few objectives, and few vectors. Cost: vectors to the power of the objectives.
//! Guarantee: none for the weights; what is said to be attained is, in rational arithmetic over the lower ends.

use num_traits::Zero;
use prism_lang::{Rational, rational_to_f64};

use super::exact;
use crate::interval::Interval;

/// What the artificial vector loses.
const LOSS: f64 = 1e4;
/// By how much more than the bounds is asked for, one after the other, since lower ends are a little low.
const MARGINS: [f64; 5] = [0.0, 1e-12, 1e-10, 1e-8, 1e-6];

pub(super) struct Mixture {
    /// Of the objectives but the first.
    duals: Vec<f64>,
    /// A number that a mixture of the vectors attains, meeting all bounds.
    pub attained: f64,
    /// Whether the best mixture does without the artificial vector.
    pub feasible: bool,
}

impl Mixture {
    pub fn weights(&self) -> Vec<f64> {
        [&[1.0], &self.duals[..]].concat()
    }
}

/// Nothing where no vector is known yet.
pub(super) fn mixture(shown: &[Vec<Interval>], bounds: &[&(Rational, bool)]) -> Option<Mixture> {
    if shown.is_empty() {
        return None;
    }
    let wanted: Vec<f64> = bounds.iter().map(|(t, _)| rational_to_f64(t)).collect();
    let (shares, duals) = best(shown, &wanted)?;
    let feasible = shares[shown.len()] < 1e-9;
    let attained = MARGINS.iter().filter_map(|margin| {
        let more: Vec<f64> = wanted
            .iter()
            .map(|t| t + margin * t.abs().max(1.0))
            .collect();
        let (shares, _) = best(shown, &more)?;
        attained(shown, &shares[..shown.len()], bounds)
    });
    Some(Mixture {
        duals,
        attained: attained.fold(f64::NEG_INFINITY, f64::max),
        feasible,
    })
}

/// What vectors in these shares attain, if they meet the bounds.
fn attained(shown: &[Vec<Interval>], shares: &[f64], bounds: &[&(Rational, bool)]) -> Option<f64> {
    let shares: Vec<Rational> = shares.iter().map(|share| exact(share.max(0.0))).collect();
    let whole: Rational = shares.iter().sum();
    if whole.is_zero() {
        return None;
    }
    let mean = |number: usize| -> Option<Rational> {
        let mut sum = Rational::zero();
        for (share, vector) in shares
            .iter()
            .zip(shown)
            .filter(|(share, _)| !share.is_zero())
        {
            sum += share * Rational::from_float(vector[number].low)?;
        }
        Some(sum / &whole)
    };
    for (place, (bound, strict)) in bounds.iter().enumerate() {
        let reached = mean(place + 1)?;
        if reached < *bound || (*strict && reached == *bound) {
            return None;
        }
    }
    mean(0).map(|value| Interval::of(&value).low)
}

/// The shares of the vectors and of the artificial one, and the dual variables of the bounds.
fn best(shown: &[Vec<Interval>], wanted: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
    let rows = wanted.len() + 1;
    let middle = |x: &Interval| 0.5 * (x.low + x.high);
    // Columns: what is gained, and the entries of the rows (the sum of shares, then each bound).
    let mut columns: Vec<(f64, Vec<f64>)> = (shown.iter())
        .map(|vector| {
            let entries = vector[1..].iter().map(middle);
            (
                middle(&vector[0]),
                std::iter::once(1.0).chain(entries).collect(),
            )
        })
        .collect();
    let least = columns.iter().map(|(gain, _)| *gain).fold(0.0, f64::min);
    let met = wanted.iter().map(|t| t + 1.0);
    columns.push((least - LOSS, std::iter::once(1.0).chain(met).collect()));
    let vectors = columns.len();
    for slack in 1..rows {
        let entry = |row: usize| if row == slack { -1.0 } else { 0.0 };
        columns.push((0.0, (0..rows).map(entry).collect()));
    }
    let right: Vec<f64> = std::iter::once(1.0).chain(wanted.iter().copied()).collect();
    let mut found: Option<(f64, f64, Vec<f64>, Vec<f64>)> = None;
    let mut basis: Vec<usize> = (0..rows).collect();
    loop {
        if let Some((gain, wrong, shares, duals)) = solved(&columns, &basis, &right) {
            // Of equally good ones the one whose weights are least wrong.
            let better = found.as_ref().is_none_or(|(most, least_wrong, ..)| {
                gain > most + 1e-9 || (gain > most - 1e-9 && wrong < *least_wrong)
            });
            if better {
                found = Some((gain, wrong, shares, duals));
            }
        }
        // The next set of columns.
        let last = (0..rows).rfind(|place| basis[*place] < columns.len() - rows + place);
        let Some(place) = last else { break };
        basis[place] += 1;
        for next in place + 1..rows {
            basis[next] = basis[next - 1] + 1;
        }
    }
    let (.., shares, duals) = found?;
    Some((shares[..vectors].to_vec(), duals))
}

/// What a basis gains, by how much its weights are wrong, the shares of all columns and the dual variables.
fn solved(
    columns: &[(f64, Vec<f64>)],
    basis: &[usize],
    right: &[f64],
) -> Option<(f64, f64, Vec<f64>, Vec<f64>)> {
    let rows = right.len();
    let matrix = |row: usize, place: usize| columns[basis[place]].1[row];
    let shares = eliminated(rows, &matrix, right)?;
    if shares.iter().any(|share| *share < -1e-9) {
        return None;
    }
    let gains: Vec<f64> = basis.iter().map(|column| columns[*column].0).collect();
    let prices = eliminated(rows, &|row, place| matrix(place, row), &gains)?;
    let reduced = columns.iter().map(|(gain, entries)| {
        let cost: f64 = entries.iter().zip(&prices).map(|(a, b)| a * b).sum();
        gain - cost
    });
    let wrong = reduced.fold(0.0, f64::max);
    let gain = gains.iter().zip(&shares).map(|(a, b)| a * b).sum();
    let mut all = vec![0.0; columns.len()];
    for (column, share) in basis.iter().zip(&shares) {
        all[*column] = share.max(0.0);
    }
    let duals = prices[1..].iter().map(|price| (-price).max(0.0)).collect();
    Some((gain, wrong, all, duals))
}

/// The solution of equations, by elimination with pivots.
fn eliminated(
    rows: usize,
    matrix: &dyn Fn(usize, usize) -> f64,
    right: &[f64],
) -> Option<Vec<f64>> {
    let mut lines: Vec<Vec<f64>> = (0..rows)
        .map(|row| {
            let entries = (0..rows).map(|place| matrix(row, place));
            entries.chain([right[row]]).collect()
        })
        .collect();
    for column in 0..rows {
        let size = |row: &usize| lines[*row][column].abs();
        let pivot = (column..rows).reduce(|a, b| if size(&b) > size(&a) { b } else { a })?;
        if size(&pivot) < 1e-12 {
            return None;
        }
        lines.swap(column, pivot);
        let own = lines[column].clone();
        for (row, line) in lines.iter_mut().enumerate() {
            let factor = line[column] / own[column];
            if row != column && factor != 0.0 {
                line.iter_mut()
                    .zip(&own)
                    .for_each(|(a, b)| *a -= factor * b);
            }
        }
    }
    Some(
        (0..rows)
            .map(|row| lines[row][rows] / lines[row][row])
            .collect(),
    )
}
