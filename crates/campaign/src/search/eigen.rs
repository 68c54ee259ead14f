//! Eigenvalues and eigenvectors of a small symmetric matrix.
//!
//! `A = V diag(d) V^T` by cyclic Jacobi rotations: each rotation makes one element off the
//! diagonal zero. Source: C. G. J. Jacobi (1846); G. H. Golub and C. F. Van Loan, "Matrix
//! Computations" (4th edition 2013), section 8.5. Deviation: none. Cost: O(n^3) a sweep, about 6
//! to 10 sweeps. Guarantee: backward stable; vectors are orthogonal to rounding.

/// A square matrix, row by row.
pub(crate) type Matrix = Vec<Vec<f64>>;

const SWEEPS: usize = 60;

/// The identity matrix.
pub(crate) fn identity(size: usize) -> Matrix {
    let row = |i| (0..size).map(|j| f64::from(u8::from(i == j))).collect();
    (0..size).map(row).collect()
}

/// Eigenvalues, and the matrix whose columns are their vectors.
pub(crate) fn symmetric_eigen(matrix: &Matrix) -> (Vec<f64>, Matrix) {
    let size = matrix.len();
    let mut a = matrix.clone();
    let mut vectors = identity(size);
    let scale: f64 = a.iter().flatten().map(|x| x * x).sum::<f64>();
    for _ in 0..SWEEPS {
        let off = |a: &Matrix| -> f64 {
            let pairs = (0..size).flat_map(|i| (0..i).map(move |j| (i, j)));
            pairs.map(|(i, j)| a[i][j] * a[i][j]).sum()
        };
        if off(&a) <= 1e-32 * scale {
            break;
        }
        for p in 0..size {
            for q in p + 1..size {
                rotate(&mut a, &mut vectors, p, q);
            }
        }
    }
    ((0..size).map(|i| a[i][i]).collect(), vectors)
}

/// The rotation in the plane of `p` and `q` that makes `a[p][q]` zero.
fn rotate(a: &mut Matrix, vectors: &mut Matrix, p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let tangent = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;
    for row in a.iter_mut() {
        (row[p], row[q]) = (
            cosine * row[p] - sine * row[q],
            sine * row[p] + cosine * row[q],
        );
    }
    // p < q: one split gives both rows.
    let (upper, lower) = a.split_at_mut(q);
    for (x, y) in upper[p].iter_mut().zip(&mut lower[0]) {
        (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
    }
    for row in vectors.iter_mut() {
        (row[p], row[q]) = (
            cosine * row[p] - sine * row[q],
            sine * row[p] + cosine * row[q],
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn the_matrix_is_put_together_again() {
        let mut random = Random::new(1, "eigen");
        for size in 0..12 {
            let mut matrix = identity(size);
            for (i, j) in (0..size).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                matrix[i][j] = random.standard_normal();
                matrix[j][i] = matrix[i][j];
            }
            let (values, vectors) = symmetric_eigen(&matrix);
            for i in 0..size {
                for j in 0..size {
                    let sum: f64 = (0..size)
                        .map(|k| vectors[i][k] * values[k] * vectors[j][k])
                        .sum();
                    let dot: f64 = (0..size).map(|k| vectors[k][i] * vectors[k][j]).sum();
                    assert!((sum - matrix[i][j]).abs() < 1e-12);
                    assert!((dot - f64::from(u8::from(i == j))).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn known_values_come_out() {
        let (mut values, _) = symmetric_eigen(&vec![vec![2.0, 1.0], vec![1.0, 2.0]]);
        values.sort_by(f64::total_cmp);
        assert!((values[0] - 1.0).abs() < 1e-15 && (values[1] - 3.0).abs() < 1e-15);
    }
}
