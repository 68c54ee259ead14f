//! The beta distribution: density, both tails, quantiles.
//!
//! ```text
//! I_x(a, b) = 1/B(a, b) * integral_0^x t^(a-1) (1-t)^(b-1) dt
//! ```
//!
//! Source: the continued fraction of A. R. DiDonato and A. H. Morris, "Algorithm 708" (1992),
//! equation 9, the even part of NIST DLMF 8.17.22, evaluated by Lentz's method (Thompson and
//! Barnett 1986) on the side of the mean where it converges, `x < (a+1)/(a+b+2)`. It is used
//! unless both parameters are large, where the density is integrated (`beta_integral`). Its terms
//! need no difference of nearly equal numbers even when x is near 1.
//! Deviation: the factor `x^a (1-x)^b / B(a, b)` is Loader's saddle-point form (see `density`),
//! which does not lose digits at counts of 10^8. Quantiles: Newton steps for the logarithm of
//! the smaller tail against the logarithm of the smaller of x and 1-x, inside a bracket that
//! only shrinks, with a bisection whenever a step leaves the bracket or fails to halve the
//! residual: they end for every input. Cost: some hundreds of terms or 90 densities for a tail,
//! about eight tails for a quantile. Guarantee: relative error near 1e-13 to 10^6 and 1e-12 to 10^8.
//!
//! # Assumes
//! Nothing of the data.

use super::beta_integral::{LARGE, upper_tail};
use super::density::binomial_density;
use super::gamma::nonzero;
use super::normal::normal_quantile;

/// Lower tail `P(X <= x)` of Beta(a, b), for `a, b > 0`.
#[must_use]
pub fn beta_cdf(a: f64, b: f64, x: f64) -> f64 {
    beta_tails(a, b, x, 1.0 - x).0
}

/// Upper tail `P(X > x)` of Beta(a, b), for `a, b > 0`.
#[must_use]
pub fn beta_sf(a: f64, b: f64, x: f64) -> f64 {
    beta_tails(a, b, x, 1.0 - x).1
}

/// Density of Beta(a, b) at `0 < x < 1`.
#[must_use]
pub fn beta_density(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return 0.0;
    }
    let y = 1.0 - x;
    power_over_beta(a, b, x, y) / (x * y)
}

/// The `x` with `P(X <= x) = p` for Beta(a, b); 0 and 1 at `p = 0` and `p = 1`.
#[must_use]
pub fn beta_quantile(a: f64, b: f64, p: f64) -> f64 {
    quantile(a, b, p, 1.0 - p)
}

/// The `x` with `P(X > x) = q` for Beta(a, b), accurate for tiny `q`.
#[must_use]
pub fn beta_quantile_upper(a: f64, b: f64, q: f64) -> f64 {
    quantile(a, b, 1.0 - q, q)
}

/// Both tails at `x`, given `y = 1 - x` to full precision.
pub(crate) fn beta_tails(a: f64, b: f64, x: f64, y: f64) -> (f64, f64) {
    let valid = a > 0.0 && b > 0.0 && a.is_finite() && b.is_finite() && !x.is_nan();
    if !valid {
        return (f64::NAN, f64::NAN);
    }
    if x <= 0.0 {
        return (0.0, 1.0);
    }
    if y <= 0.0 {
        return (1.0, 0.0);
    }
    if a.min(b) >= LARGE {
        return match (a + b) * x < a {
            true => {
                let lower = upper_tail(b, a, y, x).min(1.0);
                (lower, 1.0 - lower)
            }
            false => {
                let upper = upper_tail(a, b, x, y).min(1.0);
                (1.0 - upper, upper)
            }
        };
    }
    let factor = power_over_beta(a, b, x, y);
    if x < (a + 1.0) / (a + b + 2.0) {
        let lower = (factor * fraction(a, b, x, y)).min(1.0);
        (lower, 1.0 - lower)
    } else {
        let upper = (factor * fraction(b, a, y, x)).min(1.0);
        (1.0 - upper, upper)
    }
}

/// `x^a y^b / B(a, b)`, for `x, y > 0` with `x + y = 1`.
pub(crate) fn power_over_beta(a: f64, b: f64, x: f64, y: f64) -> f64 {
    a * (b / (a + b)) * binomial_density(a, b, x, y)
}

/// The continued fraction `1/(beta_1 + alpha_2/(beta_2 + alpha_3/(beta_3 + ...)))` with
///
/// ```text
/// alpha_(n+1) = (a+n-1)(a+b+n-1) n (b-n) x^2 / (a+2n-1)^2
/// beta_(n+1)  = n + n(b-n)x/(a+2n-1) + (a+n)/(a+2n+1) (lambda + 1 + n(1+y))
/// lambda      = a - (a+b)x = (a+b)y - b
/// ```
fn fraction(a: f64, b: f64, x: f64, y: f64) -> f64 {
    let limit = 1000.0 + 20.0 * a.max(b).sqrt();
    // lambda from the smaller of x and y, whose rounding error is the smaller one.
    let lambda = if x <= y {
        (-(a + b)).mul_add(x, a)
    } else {
        (a + b).mul_add(y, -b)
    };
    let mut c = nonzero(a / (a + 1.0) * (lambda + 1.0));
    let mut d = 0.0;
    let mut value = c;
    let mut n = 1.0;
    while n < limit {
        let centre = a + 2.0 * n - 1.0;
        let numerator = (a + n - 1.0) / centre * ((a + b + n - 1.0) / centre) * n * (b - n) * x * x;
        let denominator = n
            + n * (b - n) * x / centre
            + (a + n) / (centre + 2.0) * (lambda + 1.0 + n * (1.0 + y));
        d = 1.0 / nonzero(denominator + numerator * d);
        c = nonzero(denominator + numerator / c);
        let change = c * d;
        value *= change;
        if (change - 1.0).abs() < f64::EPSILON {
            break;
        }
        n += 1.0;
    }
    1.0 / value
}

/// The quantile at lower tail `p` and upper tail `q = 1 - p`, whichever is the accurate one.
fn quantile(a: f64, b: f64, p: f64, q: f64) -> f64 {
    if !(a > 0.0 && b > 0.0 && (0.0..=1.0).contains(&p)) {
        return f64::NAN;
    }
    if p <= 0.0 {
        return 0.0;
    }
    if q <= 0.0 {
        return 1.0;
    }
    let (below_half, above_half) = beta_tails(a, b, 0.5, 0.5);
    let left = if p <= q {
        p <= below_half
    } else {
        q >= above_half
    };
    if left {
        small_quantile(a, b, p, q)
    } else {
        1.0 - small_quantile(b, a, q, p)
    }
}

/// The quantile in `(0, 1/2]`, by guarded Newton steps in the logarithm of x.
fn small_quantile(a: f64, b: f64, p: f64, q: f64) -> f64 {
    let (mut low, mut high) = (f64::MIN_POSITIVE.ln(), 0.5_f64.ln());
    let mut log_x = initial_log(a, b, p, q).clamp(low, high);
    let mut previous = f64::INFINITY;
    for _ in 0..200 {
        let x = log_x.exp();
        let (residual, slope) = log_residual(a, b, x, p, q);
        if residual == 0.0 {
            return x;
        }
        if residual > 0.0 {
            high = log_x
        } else {
            low = log_x
        }
        let step = log_x - residual / slope;
        let newton = step > low && step < high && residual.abs() < 0.5 * previous;
        let next = if newton { step } else { 0.5 * (low + high) };
        previous = if newton {
            residual.abs()
        } else {
            f64::INFINITY
        };
        if (next - log_x).abs() <= 2.0 * f64::EPSILON || high - low <= f64::EPSILON {
            return next.exp();
        }
        log_x = next;
    }
    log_x.exp()
}

/// How far the smaller tail at `x` is from its target on a logarithmic scale (positive when `x`
/// is too large), and the slope of that against `ln x`.
fn log_residual(a: f64, b: f64, x: f64, p: f64, q: f64) -> (f64, f64) {
    let y = 1.0 - x;
    let (lower, upper) = beta_tails(a, b, x, y);
    let density_times_x = power_over_beta(a, b, x, y) / y;
    if p <= q {
        ((lower / p).ln(), density_times_x / lower)
    } else {
        (-(upper / q).ln(), density_times_x / upper)
    }
}

/// A first guess of `ln x`: a normal approximation of the logit, or the leading power of x where
/// `a` is too small for one.
fn initial_log(a: f64, b: f64, p: f64, q: f64) -> f64 {
    if a < 1.0 {
        // I_x ~ x^a / (a B(a, b)), with the constant read off the density at a small x.
        let probe = 1e-3 / (a + b);
        let scale = power_over_beta(a, b, probe, 1.0 - probe) / a;
        return probe.ln() + (p / scale).ln() / a;
    }
    let z = if p <= q {
        normal_quantile(p)
    } else {
        -normal_quantile(q)
    };
    let logit = (a / b).ln() + z * (1.0 / a + 1.0 / b).sqrt();
    -(-logit).exp().ln_1p()
}
