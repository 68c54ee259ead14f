//! Maxima of minima: linear functions over the lattice of extended reals.
//!
//! A *row* r over variables u_0, u_1, ... stands for the function
//! max(r_0, min(r_1, u_0), min(r_2, u_1), ...), and a *carry* has a row for each variable: what it
//! was, as a function of what the variables are one sample later. Rows put into rows make rows,
//! and doing so is associative, as for matrices (R. A. Cuninghame-Green, "Minimax Algebra", 1979).

/// The most variables.
pub(super) const MAX_VARIABLES: usize = 8;

/// A constant and a coefficient for each variable.
pub(super) type Row = [f64; MAX_VARIABLES + 1];

/// The row of minus infinity.
pub(super) const NOTHING: Row = [f64::NEG_INFINITY; MAX_VARIABLES + 1];

/// The row of a constant.
pub(super) fn constant(value: f64) -> Row {
    let mut row = NOTHING;
    row[0] = value;
    row
}

/// The minimum of a row and a number.
#[inline]
pub(super) fn at_most(row: &Row, limit: f64) -> Row {
    row.map(|value| value.min(limit))
}

/// The maximum of two rows.
#[inline]
pub(super) fn greater(left: &Row, right: &Row) -> Row {
    let mut row = *left;
    for (value, other) in row.iter_mut().zip(right) {
        *value = value.max(*other);
    }
    row
}

/// The rows of all variables; none at all where each variable stays what it is.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Carry(Vec<Row>);

impl Carry {
    /// A function of variables, as one of what they are later.
    #[inline]
    pub(super) fn of_row(&self, row: &Row) -> Row {
        if self.0.is_empty() {
            return *row;
        }
        let mut sum = constant(row[0]);
        for (coefficient, later) in row[1..].iter().zip(&self.0) {
            if *coefficient > f64::NEG_INFINITY {
                sum = greater(&sum, &at_most(later, *coefficient));
            }
        }
        sum
    }

    /// First this, then `next`.
    #[inline]
    pub(super) fn then(&self, next: &Carry) -> Carry {
        match (self.0.is_empty(), next.0.is_empty()) {
            (true, _) => next.clone(),
            (_, true) => self.clone(),
            _ => Carry(self.0.iter().map(|row| next.of_row(row)).collect()),
        }
    }

    /// The same, but `variable`, one of `count`, was this row.
    pub(super) fn with(&self, variable: usize, count: usize, row: Row) -> Carry {
        let mut rows = self.0.clone();
        for own in rows.len()..count {
            let mut identity = NOTHING;
            identity[own + 1] = f64::INFINITY;
            rows.push(identity);
        }
        rows[variable] = row;
        Carry(rows)
    }

    /// What the variables were, if they are now plus infinity where a bit of `corner` is set, and
    /// else minus infinity; `None` if they stay so.
    #[inline]
    pub(super) fn before_corner(&self, corner: usize) -> Option<Row> {
        if self.0.is_empty() {
            return None;
        }
        let mut values = NOTHING;
        for (value, row) in values.iter_mut().zip(&self.0) {
            *value = at_corner(row, corner);
        }
        Some(values)
    }
}

/// The value of a row at a corner.
#[inline]
pub(super) fn at_corner(row: &Row, corner: usize) -> f64 {
    let coefficients = row[1..].iter().enumerate();
    coefficients
        .filter(|(variable, _)| corner >> variable & 1 == 1)
        .fold(row[0], |best, (_, value)| best.max(*value))
}
