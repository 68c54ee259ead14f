//! How unevenly points fill the unit cube: the centred L2 discrepancy.
//!
//! ```text
//! CD^2 = (13/12)^d - 2/n sum_i prod_j (1 + |z_ij|/2 - z_ij^2/2)
//!        + 1/n^2 sum_ik prod_j (1 + |z_ij|/2 + |z_kj|/2 - |x_ij - x_kj|/2),   z = x - 1/2
//! ```
//!
//! Source: F. J. Hickernell, "A generalized discrepancy and quadrature error bound" (1998),
//! equation 5.5. Deviation: none. Cost: O(n^2 d). Guarantee: exact up to rounding; the error of a
//! mean over the points is at most this times the variation of what is averaged.

/// The centred L2 discrepancy of rows of the unit cube; `None` without points or with rows of
/// different lengths.
#[must_use]
pub fn centred_discrepancy(rows: &[Vec<f64>]) -> Option<f64> {
    let dimensions = rows.first()?.len();
    if rows.iter().any(|row| row.len() != dimensions) {
        return None;
    }
    let n = rows.len() as f64;
    let single: f64 = rows.iter().map(|row| of_one(row)).sum();
    let mut double = 0.0;
    for a in rows {
        double += rows.iter().map(|b| of_pair(a, b)).sum::<f64>();
    }
    let exponent = i32::try_from(dimensions).unwrap_or(i32::MAX);
    let square = (13.0_f64 / 12.0).powi(exponent) - 2.0 / n * single + double / (n * n);
    Some(square.max(0.0).sqrt())
}

fn of_one(row: &[f64]) -> f64 {
    let factor = |x: &f64| {
        let z = (x - 0.5).abs();
        1.0 + 0.5 * z - 0.5 * z * z
    };
    row.iter().map(factor).product()
}

fn of_pair(a: &[f64], b: &[f64]) -> f64 {
    let factor =
        |(x, y): (&f64, &f64)| 1.0 + 0.5 * ((x - 0.5).abs() + (y - 0.5).abs() - (x - y).abs());
    a.iter().zip(b).map(factor).product()
}
