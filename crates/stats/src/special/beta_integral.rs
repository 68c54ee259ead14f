//! Tails of beta distributions with large parameters, by integrating the density.
//!
//! # Definition
//! With `f` the density of Beta(a, b), `s` and `k` the slope and the curvature of `-ln f` at `x`,
//!
//! ```text
//! P(X > x) = integral_0^R f(x + t) dt,    s R + k R^2 / 2 = 45
//! ```
//!
//! for `x` above the mean. The logarithm of the density is concave and nearly a parabola over these distances, so that
//! what lies beyond `R` is below 1e-15 of the tail.
//!
//! # Source
//! W. H. Press and others, "Numerical Recipes" (2007), section 6.4, who integrate the density for parameters above
//! 3000 with one Gauss rule from a fixed number of standard deviations. Deviations: the distance follows the density's
//! own slope, so that far tails keep their digits; six pieces of 15 nodes; Loader's form of the density. Cost: 90
//! densities whatever the counts, where the continued fraction takes `O(sqrt(a + b))` terms. Guarantee: relative error
//! near 1e-13, and beside it what a unit in the last place of `x` is worth (1e-12 at counts of 10^8).
//!
//! # Assumes
//! Nothing of the data.

use super::density::{deviance_from, stirling_error};
use crate::quadrature::kronrod;
use std::f64::consts::TAU;

/// Both parameters are at least this.
pub(super) const LARGE: f64 = 3000.0;

/// By how much the logarithm of the density falls over the distance.
const FALL: f64 = 45.0;

/// Pieces of the distance.
const PIECES: u32 = 6;

/// `P(X > x)` for `x` at the mean or above it, given `y = 1 - x` to full precision, and `a, b >=` [`LARGE`].
pub(super) fn upper_tail(a: f64, b: f64, x: f64, y: f64) -> f64 {
    let density = Density::new(a, b);
    // It falls from here on: where it is below all numbers, so is what lies beyond.
    if density.at(x, y) == 0.0 {
        return 0.0;
    }
    let slope = (b - 1.0) / y - (a - 1.0) / x;
    let curvature = (a - 1.0) / (x * x) + (b - 1.0) / (y * y);
    let distance = 2.0 * FALL / (slope + (slope * slope + 2.0 * FALL * curvature).sqrt());
    let piece = distance.min(y) / f64::from(PIECES);
    let at = |t: f64| {
        if x <= y {
            density.at(x + t, 1.0 - (x + t))
        } else {
            density.at(1.0 - (y - t), y - t)
        }
    };
    // From the far end, so that what is small is added first.
    let pieces = (0..PIECES).rev().map(f64::from);
    pieces
        .map(|i| kronrod(&at, i * piece, (i + 1.0) * piece))
        .sum()
}

/// A density whose constant part is computed once.
struct Density {
    a: f64,
    b: f64,
    factor: f64,
}

impl Density {
    fn new(a: f64, b: f64) -> Self {
        let n = a + b;
        let constant = stirling_error(n) - stirling_error(a) - stirling_error(b);
        // a b / n times the binomial density is x^a y^b / B(a, b).
        let factor = (a * (b / n) / TAU).sqrt() * constant.exp();
        Self { a, b, factor }
    }

    fn at(&self, x: f64, y: f64) -> f64 {
        if x <= 0.0 || y <= 0.0 {
            return 0.0;
        }
        let n = self.a + self.b;
        // a - n x from the smaller of x and y, whose rounding error is the smaller one.
        let difference = if x <= y {
            (-n).mul_add(x, self.a)
        } else {
            -(-n).mul_add(y, self.b)
        };
        let exponent =
            deviance_from(self.a, n * x, difference) + deviance_from(self.b, n * y, -difference);
        self.factor * (-exponent).exp() / (x * y)
    }
}

#[cfg(test)]
mod tests {
    use super::super::beta::{beta_cdf, beta_sf};

    /// Tails from the mean to 20 standard deviations, by Gauss-Legendre quadrature of the density in 30 digits (mpmath).
    #[test]
    fn tails_are_those_of_exact_arithmetic() {
        let upper = [
            (5e7, 5e7, 0.500_049_999_999_5, 0.158_655_255_141_552_46),
            (
                1e5,
                1e8 - 1e5,
                0.001_018_969_213_833_641_1,
                1.2338954361394352e-09,
            ),
            (9.9e7, 1e6, 0.990_119_393_620_216, 1.0022647392422392e-33),
            (
                4000.0,
                4500.0,
                0.481_418_166_908_380_46,
                0.022_815_933_596_699_006,
            ),
        ];
        for (successes, failures, x, expected) in upper {
            let found = beta_sf(successes + 0.5, failures + 0.5, x);
            assert!(
                (found / expected - 1.0).abs() < 1e-12,
                "{successes} {failures} {x}: {found}"
            );
        }
        let lower = [
            (
                1e5,
                1e8 - 1e5,
                0.000_990_522_878_083_104_5,
                0.001_312_825_122_546_925_8,
            ),
            (
                1e8 - 5000.0,
                5000.0,
                0.999_935_852_511_610_2,
                9.525_391_807_433_92e-76,
            ),
        ];
        for (successes, failures, x, expected) in lower {
            let found = beta_cdf(successes + 0.5, failures + 0.5, x);
            assert!(
                (found / expected - 1.0).abs() < 1e-12,
                "{successes} {failures} {x}: {found}"
            );
        }
    }

    /// Where integration takes over, the continued fraction says the same.
    #[test]
    fn nothing_jumps_where_integration_takes_over() {
        for other in [3000.0, 1e5, 1e8] {
            let tail = |a: f64| beta_sf(a, other, a / (a + other) * 1.01);
            let below = tail(super::LARGE - 1e-6);
            let above = tail(super::LARGE);
            assert!(
                (above / below - 1.0).abs() < 1e-8,
                "{other}: {below} {above}"
            );
        }
    }
}
