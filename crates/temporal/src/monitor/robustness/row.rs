//! Maxima of minima: linear functions over the lattice of extended reals.
//!
//! A *row* r over variables u_0, u_1, ... stands for the function
//! max(r_0, min(r_1, u_0), min(r_2, u_1), ...), and a *carry* has a row for each variable: what it
//! was, as a function of what the variables are one sample later. Rows put into rows make rows,
//! and doing so is associative, as for matrices (R. A. Cuninghame-Green, "Minimax Algebra", 1979).

/// The most variables.
pub(super) const MAX_VARIABLES: usize = 8;

/// A constant and a coefficient for each of up to `N` variables; those of variables that there are
/// not are minus infinity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Row<const N: usize> {
    pub(super) constant: f64,
    pub(super) of: [f64; N],
}

impl<const N: usize> Row<N> {
    /// The row of a constant.
    pub(super) fn constant(constant: f64) -> Self {
        Row {
            constant,
            of: [f64::NEG_INFINITY; N],
        }
    }

    /// The row of minus infinity.
    pub(super) fn nothing() -> Self {
        Self::constant(f64::NEG_INFINITY)
    }

    /// The minimum of a variable and a number.
    #[inline]
    pub(super) fn variable(variable: usize, limit: f64) -> Self {
        let mut row = Self::nothing();
        row.of[variable] = limit;
        row
    }

    /// The minimum of a row and a number.
    #[inline]
    pub(super) fn at_most(&self, limit: f64) -> Self {
        Row {
            constant: self.constant.min(limit),
            of: self.of.map(|value| value.min(limit)),
        }
    }

    /// The maximum of two rows.
    #[inline]
    pub(super) fn greater(&self, other: &Self) -> Self {
        let mut row = *self;
        row.constant = row.constant.max(other.constant);
        for (value, other) in row.of.iter_mut().zip(&other.of) {
            *value = value.max(*other);
        }
        row
    }

    /// The value where variables are plus infinity if a bit of `corner` is set, else minus infinity.
    #[inline]
    pub(super) fn at_corner(&self, corner: usize) -> f64 {
        let coefficients = self.of.iter().enumerate();
        coefficients
            .filter(|(variable, _)| corner >> variable & 1 == 1)
            .fold(self.constant, |best, (_, value)| best.max(*value))
    }
}

/// The rows of all variables; none at all where each variable stays what it is.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Carry<const N: usize>(Option<[Row<N>; N]>);

impl<const N: usize> Carry<N> {
    /// A function of variables, as one of what they are later.
    #[inline]
    pub(super) fn of_row(&self, row: &Row<N>) -> Row<N> {
        let Some(later) = &self.0 else {
            return *row;
        };
        let mut sum = Row::constant(row.constant);
        for (coefficient, later) in row.of.iter().zip(later) {
            if *coefficient > f64::NEG_INFINITY {
                sum = sum.greater(&later.at_most(*coefficient));
            }
        }
        sum
    }

    /// First this, then `next`.
    #[inline]
    pub(super) fn then(&self, next: &Self) -> Self {
        match (&self.0, &next.0) {
            (None, _) => *next,
            (_, None) => *self,
            (Some(rows), Some(_)) => Carry(Some(rows.map(|row| next.of_row(&row)))),
        }
    }

    /// The same, but `variable` was this row.
    #[inline]
    pub(super) fn with(&self, variable: usize, row: Row<N>) -> Self {
        let same = || std::array::from_fn(|own| Row::variable(own, f64::INFINITY));
        let mut rows = self.0.unwrap_or_else(same);
        rows[variable] = row;
        Carry(Some(rows))
    }

    /// What the variables were, if they are now plus infinity where a bit of `corner` is set, and
    /// else minus infinity; `None` if they stay so.
    #[inline]
    pub(super) fn before_corner(&self, corner: usize) -> Option<[f64; N]> {
        let rows = self.0.as_ref()?;
        Some(rows.each_ref().map(|row| row.at_corner(corner)))
    }
}
