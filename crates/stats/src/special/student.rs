//! Student's t and Fisher's F distributions, through the incomplete beta function.
//!
//! ```text
//! P(T > t) = I_x(n/2, 1/2) / 2,  x = n/(n + t^2),  t >= 0
//! P(F > f) = I_x(d2/2, d1/2),    x = d2/(d2 + d1 f)
//! ```
//!
//! Source: Abramowitz and Stegun 26.7.1 and 26.6.2. Guarantee: that of the beta tails.
//!
//! # Assumes
//! Nothing of the data.

use super::beta::{beta_quantile, beta_quantile_upper, beta_tails};

/// Upper tail `P(T > t)` of Student's t with `degrees > 0` degrees of freedom.
#[must_use]
pub fn student_t_sf(t: f64, degrees: f64) -> f64 {
    if t.is_infinite() {
        return if t > 0.0 { 0.0 } else { 1.0 };
    }
    let square = t * t;
    let scale = degrees + square;
    let tail = 0.5 * beta_tails(0.5 * degrees, 0.5, degrees / scale, square / scale).0;
    if t >= 0.0 { tail } else { 1.0 - tail }
}

/// The `t` with `P(T <= t) = p` for Student's t with `degrees > 0` degrees of freedom.
#[must_use]
pub fn student_t_quantile(p: f64, degrees: f64) -> f64 {
    let tail = p.min(1.0 - p);
    if tail <= 0.0 {
        return if p <= 0.0 {
            f64::NEG_INFINITY
        } else {
            f64::INFINITY
        };
    }
    // 1 - x = t^2/(n + t^2) follows Beta(1/2, n/2): its quantile keeps small t accurate.
    let y = beta_quantile_upper(0.5, 0.5 * degrees, 2.0 * tail);
    let x = beta_quantile(0.5 * degrees, 0.5, 2.0 * tail);
    let magnitude = (degrees
        * if y < 0.5 {
            y / (1.0 - y)
        } else {
            (1.0 - x) / x
        })
    .sqrt();
    if p < 0.5 { -magnitude } else { magnitude }
}

/// Upper tail `P(F > f)` of the F distribution with the two degrees of freedom given.
#[must_use]
pub fn f_sf(f: f64, numerator_degrees: f64, denominator_degrees: f64) -> f64 {
    if f <= 0.0 {
        return 1.0;
    }
    if f.is_infinite() {
        return 0.0;
    }
    let weighted = numerator_degrees * f;
    let scale = denominator_degrees + weighted;
    beta_tails(
        0.5 * denominator_degrees,
        0.5 * numerator_degrees,
        denominator_degrees / scale,
        weighted / scale,
    )
    .0
}
