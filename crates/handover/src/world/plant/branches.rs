//! Symmetric positive definite matrices of joints that branch: an entry is 0 unless one of its two joints
//! hangs on the other.
//!
//! Such a matrix is factored from the tips inwards, as `L' L`, which leaves these zeros what they are
//! (Featherstone, "Rigid Body Dynamics Algorithms", 2008, section 6.5). For sixteen joints of an arm and
//! a hand that takes a sixth of what a full factor does.

/// Which joint each one hangs on; it comes before it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Branches(Vec<Option<usize>>);

impl Branches {
    pub(super) fn new(parents: Vec<Option<usize>>) -> Self {
        Self(parents)
    }

    #[inline]
    pub(super) fn count(&self) -> usize {
        self.0.len()
    }

    /// The joint that one hangs on.
    #[inline]
    pub(super) fn parent(&self, joint: usize) -> Option<usize> {
        self.0[joint]
    }

    /// The joints that one hangs on, inwards.
    #[inline]
    pub(super) fn inwards(&self, joint: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(self.0[joint], |joint| self.0[*joint])
    }

    /// A matrix, given by its lower triangle, times a vector.
    pub(super) fn product(&self, matrix: &[f64], vector: &[f64]) -> Vec<f64> {
        let count = self.count();
        let mut product: Vec<f64> = (0..count)
            .map(|i| matrix[i * count + i] * vector[i])
            .collect();
        for i in 0..count {
            for j in self.inwards(i) {
                product[i] += matrix[i * count + j] * vector[j];
                product[j] += matrix[i * count + j] * vector[i];
            }
        }
        product
    }

    /// Replaces the lower triangle of a matrix, by rows, by its factor `L`.
    pub(super) fn factorise(&self, matrix: &mut [f64]) {
        let count = self.count();
        for k in (0..count).rev() {
            let own = matrix[k * count + k].sqrt();
            matrix[k * count + k] = own;
            for i in self.inwards(k) {
                matrix[k * count + i] /= own;
            }
            for i in self.inwards(k) {
                let factor = matrix[k * count + i];
                matrix[i * count + i] -= factor * factor;
                for j in self.inwards(i) {
                    matrix[i * count + j] -= factor * matrix[k * count + j];
                }
            }
        }
    }

    /// Solves with a factor, in place.
    pub(super) fn solve(&self, factor: &[f64], right: &mut [f64]) {
        let count = self.count();
        for i in (0..count).rev() {
            let own = right[i] / factor[i * count + i];
            right[i] = own;
            for j in self.inwards(i) {
                right[j] -= factor[i * count + j] * own;
            }
        }
        for i in 0..count {
            let inner: f64 = self
                .inwards(i)
                .map(|j| factor[i * count + j] * right[j])
                .sum();
            right[i] = (right[i] - inner) / factor[i * count + i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_solved_gives_back_the_right_side() {
        // Two fingers of two joints on an arm of two, and a joint that hangs on nothing.
        let parents = [None, Some(0), Some(1), Some(2), Some(1), Some(4), None];
        let branches = Branches::new(parents.to_vec());
        let count = branches.count();
        let mut matrix = vec![0.0; count * count];
        for i in 0..count {
            matrix[i * count + i] = 4.0 + i as f64;
            for j in branches.inwards(i) {
                matrix[i * count + j] = 0.3 * (i as f64 - 0.7 * j as f64);
            }
        }
        let right: Vec<f64> = (0..count).map(|i| 1.0 - 0.4 * i as f64).collect();
        let mut solution = right.clone();
        let mut factor = matrix.clone();
        branches.factorise(&mut factor);
        branches.solve(&factor, &mut solution);
        let product = branches.product(&matrix, &solution);
        for i in 0..count {
            let entry = |j: usize| matrix[i.max(j) * count + i.min(j)];
            let back: f64 = (0..count).map(|j| entry(j) * solution[j]).sum();
            assert!((back - right[i]).abs() < 1e-12, "{i}: {back}");
            assert!((back - product[i]).abs() < 1e-12, "{i}: {back}");
        }
        assert!(solution.iter().all(|value| value.abs() > 1e-3));
    }
}
