//! Rough solutions of the linear equations of Markov chains: a Krylov method with incomplete factors.
//!
//! *Problem.* `B y = b` with `(B y)_i = d_i y_i - sum over j of a_ij y_j`, `a_ij >= 0`, `d_i` at least the sum of its row: a
//! nonsingular M-matrix where every state can leave.
//!
//! *Method.* Stabilised biconjugate gradients (van der Vorst 1992), preconditioned on the right by an incomplete factorisation
//! (Meijerink and van der Vorst 1977: it exists for M-matrices), kept in single precision. Of the fill-in, large entries are kept, few
//! for each row (Saad 1994, "ILUT: a dual threshold incomplete LU factorization"): along a cycle each state gets one entry as large
//! as the diagonal, without which the method has to follow the cycle round by round. Where the graph is a tree, a path or a
//! cycle, the factors are complete and one round is enough. Cost: rounds times entries; 8 bytes for each entry, seven vectors.
//!
//! *Guarantee.* None: whoever asks holds the solution against inequalities that imply bounds.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::answer::{CheckError, Options};

/// Rounds without a smaller residual after which a solution is given up.
const PATIENCE: usize = 300;

/// Fill-in up to this, relative to the diagonal, is dropped.
const DROPPED: f64 = 0.1;
/// New entries that a row of the factors may have.
const MOST_FILL: usize = 4;

/// What a Krylov method needs to know of the equations.
pub(crate) trait Operator {
    /// `B v`; `v` is left as it was.
    fn apply(&self, v: &mut [f64], result: &mut [f64]);
    /// An approximation of `B^-1 v`.
    fn precondition(&self, v: &[f64], result: &mut [f64]);
}

/// Incomplete factors of an M-matrix: unit lower triangle, upper triangle, each by rows.
#[derive(Debug, Default)]
pub(crate) struct Factors {
    lower_start: Vec<usize>,
    lower: Vec<(u32, f32)>,
    upper_start: Vec<usize>,
    upper: Vec<(u32, f32)>,
    /// One over the diagonal of the upper triangle.
    inverse: Vec<f64>,
}

impl Factors {
    /// Of the matrix with this diagonal and these entries `a_ij` (columns of a row in any order, none on the diagonal).
    /// Row and column `without`, if any, are left out: there the factors are the identity.
    pub fn new<'a>(
        diagonal: &[f64],
        row: impl Fn(usize) -> (&'a [u32], &'a [f64]),
        without: Option<usize>,
    ) -> Self {
        let states = diagonal.len();
        let mut factors = Self {
            lower_start: vec![0],
            upper_start: vec![0],
            ..Self::default()
        };
        // Where an entry of the row at hand is; 0 for none.
        let mut place = vec![0_u32; states];
        let mut entries: Vec<(u32, f64)> = Vec::new();
        let mut below: BinaryHeap<Reverse<u32>> = BinaryHeap::new();
        let mut fill: Vec<(u32, f64)> = Vec::new();
        for (state, own) in diagonal.iter().enumerate() {
            let mut pivot = *own;
            if without == Some(state) {
                pivot = 1.0;
            } else {
                let (targets, rates) = row(state);
                let kept = targets.iter().zip(rates);
                let kept = kept.filter(|(target, _)| without != Some(**target as usize));
                entries.clear();
                entries.extend(kept.map(|(target, rate)| (*target, -rate)));
                let model = entries.len();
                for (at, (column, _)) in entries.iter().enumerate() {
                    place[*column as usize] = at as u32 + 1;
                    if (*column as usize) < state {
                        below.push(Reverse(*column));
                    }
                }
                let small = DROPPED * own;
                while let Some(Reverse(above)) = below.pop() {
                    let at = place[above as usize] as usize - 1;
                    let above = above as usize;
                    let share = entries[at].1 * factors.inverse[above];
                    entries[at].1 = share;
                    let range = factors.upper_start[above]..factors.upper_start[above + 1];
                    for (target, value) in &factors.upper[range] {
                        let update = share * f64::from(*value);
                        let column = *target as usize;
                        if column == state {
                            pivot -= update;
                            continue;
                        }
                        match place[column] {
                            // Entries stay negative, so that no sum makes large again what was dropped as small.
                            0 if update > small => {
                                entries.push((*target, -update));
                                place[column] = entries.len() as u32;
                                if column < state {
                                    below.push(Reverse(*target));
                                }
                            }
                            0 => {}
                            at => entries[at as usize - 1].1 -= update,
                        }
                    }
                }
                for (column, _) in &entries {
                    place[*column as usize] = 0;
                }
                if entries.len() > model + MOST_FILL {
                    fill.clear();
                    fill.extend(entries.drain(model..));
                    // Lower entries are multiples of a pivot, upper ones have the size of the diagonal.
                    let size = |(column, value): &(u32, f64)| match (*column as usize) < state {
                        true => value.abs() * own,
                        false => value.abs(),
                    };
                    fill.sort_by(|a, b| size(b).total_cmp(&size(a)).then(a.0.cmp(&b.0)));
                    entries.extend_from_slice(&fill[..MOST_FILL]);
                }
                for (column, value) in &entries {
                    match (*column as usize) < state {
                        true => factors.lower.push((*column, *value as f32)),
                        false => factors.upper.push((*column, *value as f32)),
                    }
                }
            }
            factors.lower_start.push(factors.lower.len());
            factors.upper_start.push(factors.upper.len());
            // Rounding may leave nothing of a pivot that is positive.
            let kept = if pivot > 1e-10 * own {
                pivot
            } else {
                own.max(f64::MIN_POSITIVE)
            };
            factors.inverse.push(1.0 / kept);
        }
        factors
    }

    /// What the factors have for `B^-1 v`.
    pub fn solve(&self, v: &[f64], result: &mut [f64]) {
        for (state, v) in v.iter().enumerate() {
            let mut value = *v;
            for (column, factor) in
                &self.lower[self.lower_start[state]..self.lower_start[state + 1]]
            {
                value -= f64::from(*factor) * result[*column as usize];
            }
            result[state] = value;
        }
        for state in (0..v.len()).rev() {
            let mut value = result[state];
            for (column, factor) in
                &self.upper[self.upper_start[state]..self.upper_start[state + 1]]
            {
                value -= f64::from(*factor) * result[*column as usize];
            }
            result[state] = value * self.inverse[state];
        }
    }
}

/// Adds to `y` a correction that brings the residual `b - B y` below a goal (a function of `y`) in each state; what the residual's greatest
/// entry became, and the rounds.
///
/// `residual` is `b - B y` when called. It may be called again with the true residual.
pub(crate) fn correct(
    operator: &impl Operator,
    y: &mut [f64],
    residual: &mut [f64],
    goal: impl Fn(&[f64]) -> f64,
    most: usize,
    options: &Options<'_>,
) -> Result<(f64, usize), CheckError> {
    let states = y.len();
    let mut left = norm(residual);
    let (mut best, mut since) = (left, 0);
    let shadow = residual.to_vec();
    let (mut direction, mut image) = (vec![0.0; states], vec![0.0; states]);
    let (mut near, mut second) = (vec![0.0; states], vec![0.0; states]);
    let (mut rho, mut alpha, mut omega) = (1.0, 1.0, 1.0);
    let mut round = 0;
    while left > goal(y) && round < most && since < PATIENCE {
        if round % 16 == 0 {
            options.check_cancelled()?;
        }
        round += 1;
        let next = dot(&shadow, residual);
        let beta = next / rho * (alpha / omega);
        rho = next;
        for ((direction, residual), image) in direction.iter_mut().zip(&*residual).zip(&image) {
            *direction = residual + beta * (*direction - omega * image);
        }
        operator.precondition(&direction, &mut near);
        operator.apply(&mut near, &mut image);
        alpha = rho / dot(&shadow, &image);
        if !alpha.is_finite() {
            break;
        }
        step(y, residual, alpha, &near, &image);
        operator.precondition(residual, &mut near);
        operator.apply(&mut near, &mut second);
        let (mut along, mut size) = (0.0, 0.0);
        for (second, residual) in second.iter().zip(&*residual) {
            along += second * residual;
            size += second * second;
        }
        omega = if size > 0.0 { along / size } else { 0.0 };
        left = step(y, residual, omega, &near, &second);
        if !omega.is_finite() || omega == 0.0 || rho == 0.0 || !left.is_finite() {
            break;
        }
        since += 1;
        if left < 0.9 * best {
            (best, since) = (left, 0);
        }
    }
    Ok((left, round))
}

/// `y += factor near`, `residual -= factor image`; the greatest entry of the residual.
fn step(y: &mut [f64], residual: &mut [f64], factor: f64, near: &[f64], image: &[f64]) -> f64 {
    let mut greatest = 0.0;
    let pairs = y.iter_mut().zip(near).zip(residual.iter_mut().zip(image));
    for ((y, near), (residual, image)) in pairs {
        *y += factor * near;
        *residual -= factor * image;
        let size = residual.abs();
        greatest = if size > greatest { size } else { greatest };
    }
    greatest
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The greatest absolute value; not a number if one is not.
pub(crate) fn norm(v: &[f64]) -> f64 {
    v.iter()
        .fold(0.0, |norm: f64, v| match v.is_nan() || norm.is_nan() {
            true => f64::NAN,
            false => norm.max(v.abs()),
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walkers on a torus of `side` times `side` places, each of which is left with probability 1/100.
    struct Torus {
        columns: Vec<u32>,
        diagonal: Vec<f64>,
        factors: Factors,
    }

    const RATES: [f64; 4] = [0.1, 0.2, 0.3, 0.39];

    impl Torus {
        fn new(side: usize) -> Self {
            let at = |x: usize, y: usize| (x % side * side + y % side) as u32;
            let around = |place: usize| {
                let (x, y) = (place / side + side, place % side + side);
                [at(x - 1, y), at(x + 1, y), at(x, y - 1), at(x, y + 1)]
            };
            let columns: Vec<u32> = (0..side * side).flat_map(around).collect();
            let diagonal = vec![1.0; side * side];
            let row = |state: usize| (&columns[4 * state..4 * state + 4], &RATES[..]);
            let factors = Factors::new(&diagonal, row, None);
            Self {
                columns,
                diagonal,
                factors,
            }
        }
    }

    impl Operator for Torus {
        fn apply(&self, v: &mut [f64], result: &mut [f64]) {
            for (state, result) in result.iter_mut().enumerate() {
                let columns = &self.columns[4 * state..4 * state + 4];
                let moved = columns.iter().zip(RATES).map(|(c, r)| r * v[*c as usize]);
                *result = self.diagonal[state] * v[state] - moved.sum::<f64>();
            }
        }

        fn precondition(&self, v: &[f64], result: &mut [f64]) {
            self.factors.solve(v, result);
        }
    }

    #[test]
    fn the_residual_comes_down_and_is_that_of_the_equations() {
        let torus = Torus::new(40);
        let b: Vec<f64> = (0..1600).map(|state| f64::from(state % 7)).collect();
        let (mut y, mut residual) = (vec![0.0; 1600], b.clone());
        let options = Options::default();
        let (left, rounds) =
            correct(&torus, &mut y, &mut residual, |_| 1e-9, 1000, &options).unwrap();
        assert!(left <= 1e-9 && rounds < 100, "{left} {rounds}");
        let mut image = vec![0.0; 1600];
        torus.apply(&mut y, &mut image);
        let difference: Vec<f64> = b.iter().zip(&image).map(|(b, image)| b - image).collect();
        assert!(norm(&difference) < 1e-8, "{}", norm(&difference));
    }

    #[test]
    fn factors_of_a_path_are_complete() {
        // Entry by entry, `B y` for the solution is `v` up to single precision.
        let row = |state: usize| match state {
            0 => (&[1][..], &[0.5][..]),
            1 => (&[0, 2][..], &[0.25, 0.5][..]),
            _ => (&[1][..], &[0.75][..]),
        };
        let factors = Factors::new(&[1.0; 3], row, None);
        let mut y = [0.0; 3];
        factors.solve(&[1.0, 2.0, 3.0], &mut y);
        let b = [
            y[0] - 0.5 * y[1],
            y[1] - 0.25 * y[0] - 0.5 * y[2],
            y[2] - 0.75 * y[1],
        ];
        for (b, v) in b.iter().zip([1.0, 2.0, 3.0]) {
            assert!((b - v).abs() < 1e-6, "{b} {v}");
        }
    }
}
