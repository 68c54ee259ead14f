//! The robustness of a whole monitor as a function of what its unbounded stages are still to find.
//!
//! Rows are not closed under the minimum over instances, but lattice polynomials are. Such a V is
//! given by its values where each variable is plus or minus infinity (R. L. Goodstein, "The solution
//! of equations in a lattice", Proc. Royal Society of Edinburgh A 67, 1967): 2^v numbers. Elsewhere,
//! with the variables in falling order u_1 >= u_2 >= ..., V(u) is the maximum of V(all -inf) and, for
//! each k, of min(u_k, V(u_1 ... u_k at +inf, else -inf)): of all sets of variables with a given
//! minimum, the largest gives the most, since V is monotone.

use super::row::MAX_VARIABLES;
use super::stage::Given;

/// V at all corners: number c is that where variable j is plus infinity if bit j is set.
#[derive(Debug, Clone)]
pub(super) struct Whole {
    corners: Vec<f64>,
    next: Vec<f64>,
    variables: usize,
}

impl Whole {
    /// Nothing is demanded yet.
    pub(super) fn satisfied(variables: usize) -> Self {
        Whole {
            corners: vec![f64::INFINITY; 1 << variables],
            next: vec![f64::INFINITY; 1 << variables],
            variables,
        }
    }

    /// What the first variable is.
    pub(super) fn first_variable(variables: usize) -> Self {
        let mut whole = Whole::satisfied(variables);
        for (corner, value) in whole.corners.iter_mut().enumerate() {
            if corner & 1 == 0 {
                *value = f64::NEG_INFINITY;
            }
        }
        whole
    }

    /// Number of values kept.
    pub(super) fn stored(&self) -> usize {
        self.corners.len()
    }

    /// Time has passed to the next sample, where `unless` or the row must be.
    pub(super) fn demand<const N: usize>(&mut self, unless: f64, given: &Given<N>) {
        for corner in 0..self.corners.len() {
            let before = match given.carry.before_corner(corner) {
                None => self.corners[corner],
                Some(values) => self.at(&values),
            };
            let now = given.row.at_corner(corner).max(unless);
            self.next[corner] = before.min(now);
        }
        std::mem::swap(&mut self.corners, &mut self.next);
    }

    /// The value at these values of the variables.
    #[inline]
    fn at(&self, values: &[f64]) -> f64 {
        // What the rest comes to, for the many monitors with one variable.
        if let (1, [nothing, all], [value]) = (self.variables, &self.corners[..], values) {
            return nothing.max(all.min(*value));
        }
        let mut order = [0; MAX_VARIABLES];
        let order = &mut order[..self.variables];
        for (place, variable) in order.iter_mut().enumerate() {
            *variable = place;
        }
        order.sort_unstable_by(|left, right| values[*right].total_cmp(&values[*left]));
        let (mut best, mut corner) = (self.corners[0], 0);
        for variable in order {
            corner |= 1 << *variable;
            best = best.max(self.corners[corner].min(values[*variable]));
        }
        best
    }

    /// The value at a corner.
    pub(super) fn corner(&self, corner: usize) -> f64 {
        self.corners
            .get(corner)
            .copied()
            .unwrap_or(f64::NEG_INFINITY)
    }
}
