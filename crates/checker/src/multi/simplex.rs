//! Linear programmes in rational arithmetic, small and dense.
//!
//! *Problem.* Maximise `c x` over `A x = b`, `x >= 0`. *Method.* Simplex in two phases on the tableau, with Bland's
//! rule, which never cycles (Bland 1977, "New finite pivoting rules for the simplex method"). Guarantee: exact.
//! Cost: exponential in the worst case; here there are few rows.

use num_traits::Signed;
use prism_lang::{Arithmetic, Rational};

/// A solution.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Solution {
    /// The greatest value of `c x`.
    pub value: Rational,
    /// An `x` that has it.
    pub point: Vec<Rational>,
    /// `c_j` less the dual's `y A_j`, for each column: not positive.
    pub reduced: Vec<Rational>,
}

/// The tableau: constraints solved for the basic variables.
struct Tableau {
    rows: Vec<Vec<Rational>>,
    rhs: Vec<Rational>,
    basis: Vec<usize>,
}

/// Solves it; nothing if there is no `x`, or no greatest value.
pub(super) fn maximise(c: &[Rational], a: &[Vec<Rational>], b: &[Rational]) -> Option<Solution> {
    let (variables, constraints) = (c.len(), a.len());
    let one = Rational::from_integer(1.into());
    let mut tableau = Tableau {
        rows: Vec::with_capacity(constraints),
        rhs: b.iter().map(Signed::abs).collect(),
        basis: (variables..variables + constraints).collect(),
    };
    for (place, (row, b)) in a.iter().zip(b).enumerate() {
        let sign = |value: &Rational| {
            if b.is_negative() {
                -value
            } else {
                value.clone()
            }
        };
        let mut row: Vec<Rational> = row.iter().map(sign).collect();
        row.extend((0..constraints).map(|i| {
            if i == place {
                one.clone()
            } else {
                Rational::zero()
            }
        }));
        tableau.rows.push(row);
    }
    // First without the artificial variables' sum.
    let mut first = vec![Rational::zero(); variables];
    first.resize(variables + constraints, -one);
    tableau.improve(&first, variables + constraints)?;
    if !tableau.value(&first).is_zero() {
        return None;
    }
    tableau.drive_out(variables);
    let mut cost = c.to_vec();
    cost.resize(variables + constraints, Rational::zero());
    tableau.improve(&cost, variables)?;
    let mut point = vec![Rational::zero(); variables];
    for (column, value) in tableau.basis.iter().zip(&tableau.rhs) {
        // An artificial variable that could not be taken out is 0.
        if let Some(place) = point.get_mut(*column) {
            *place = value.clone();
        }
    }
    Some(Solution {
        value: tableau.value(&cost),
        point,
        reduced: (0..variables).map(|j| tableau.reduced(&cost, j)).collect(),
    })
}

impl Tableau {
    fn value(&self, cost: &[Rational]) -> Rational {
        self.basis
            .iter()
            .zip(&self.rhs)
            .fold(Rational::zero(), |sum, (j, value)| {
                sum.add(&cost[*j].mul(value))
            })
    }

    fn reduced(&self, cost: &[Rational], column: usize) -> Rational {
        let pairs = self.basis.iter().zip(&self.rows);
        let used = pairs.fold(Rational::zero(), |sum, (j, row)| {
            sum.add(&cost[*j].mul(&row[column]))
        });
        cost[column].sub(&used)
    }

    /// Pivots until no column before `columns` improves; nothing if the value has no end.
    fn improve(&mut self, cost: &[Rational], columns: usize) -> Option<()> {
        loop {
            let entering = (0..columns).find(|j| self.reduced(cost, *j).is_positive());
            let Some(entering) = entering else {
                return Some(());
            };
            let mut leaving: Option<(usize, Rational)> = None;
            for (place, row) in self.rows.iter().enumerate() {
                if !row[entering].is_positive() {
                    continue;
                }
                let ratio = &self.rhs[place] / &row[entering];
                let better = leaving.as_ref().is_none_or(|(known, least)| {
                    ratio < *least || (ratio == *least && self.basis[place] < self.basis[*known])
                });
                if better {
                    leaving = Some((place, ratio));
                }
            }
            self.pivot(leaving?.0, entering);
        }
    }

    fn pivot(&mut self, place: usize, entering: usize) {
        let divisor = self.rows[place][entering].clone();
        self.rows[place]
            .iter_mut()
            .for_each(|value| *value /= &divisor);
        self.rhs[place] /= &divisor;
        let (pivot, rhs) = (self.rows[place].clone(), self.rhs[place].clone());
        for (other, row) in self.rows.iter_mut().enumerate() {
            let factor = row[entering].clone();
            if other != place && !factor.is_zero() {
                for (value, of_pivot) in row.iter_mut().zip(&pivot) {
                    *value = value.sub(&factor.mul(of_pivot));
                }
                self.rhs[other] = self.rhs[other].sub(&factor.mul(&rhs));
            }
        }
        self.basis[place] = entering;
    }

    /// Takes artificial variables, which are 0, out of the basis where another can take their place.
    fn drive_out(&mut self, variables: usize) {
        for place in 0..self.basis.len() {
            if self.basis[place] >= variables
                && let Some(column) = (0..variables).find(|j| !self.rows[place][*j].is_zero())
            {
                self.pivot(place, column);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn r(values: &[i64]) -> Vec<Rational> {
        values
            .iter()
            .map(|v| Rational::from_integer((*v).into()))
            .collect()
    }

    #[test]
    fn a_small_programme_has_its_textbook_solution() {
        // max 3x + 5y, x <= 4, 2y <= 12, 3x + 2y <= 18: 36 at (2, 6), duals 0, 3/2, 1.
        let a = [
            r(&[1, 0, 1, 0, 0]),
            r(&[0, 2, 0, 1, 0]),
            r(&[3, 2, 0, 0, 1]),
        ];
        let found = maximise(&r(&[3, 5, 0, 0, 0]), &a, &r(&[4, 12, 18])).unwrap();
        assert_eq!(found.value, r(&[36])[0]);
        assert_eq!(found.point, r(&[2, 6, 2, 0, 0]));
        let half = Rational::new((-3).into(), 2.into());
        assert_eq!(
            found.reduced[2..],
            [r(&[0])[0].clone(), half, r(&[-1])[0].clone()]
        );
        // Nothing satisfies x = -1; x - y has no end.
        assert_eq!(maximise(&r(&[1]), &[r(&[1])], &r(&[-1])), None);
        assert_eq!(maximise(&r(&[1, 0]), &[r(&[1, -1])], &r(&[0])), None);
    }
}
