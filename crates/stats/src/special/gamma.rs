//! The gamma function, its incomplete integrals and the chi-squared distribution.
//!
//! ```text
//! P(a, x) = 1/Gamma(a) * integral_0^x t^(a-1) e^-t dt,   Q = 1 - P
//! ```
//!
//! Source: NIST DLMF 8.7.1 (series, used below `x = a + 1`) and 8.9.2 (continued fraction, used
//! above, evaluated by Lentz's method as modified by Thompson and Barnett 1986); 5.7.3 for
//! `ln Gamma` near 1 and 2. Deviation: the common factor `x^a e^-x / Gamma(a+1)` is Loader's
//! saddle-point form. Cost: O(sqrt(a)) terms near `x = a`. Guarantee: about 1e-13 relative.
//!
//! # Assumes
//! Nothing of the data.

use super::density::{deviance, stirling_error};
use std::f64::consts::TAU;

/// `zeta(k) - 1` for k = 2..=20.
const ZETA_MINUS_ONE: [f64; 19] = [
    0.644_934_066_848_226_4,
    0.202_056_903_159_594_3,
    0.082_323_233_711_138_19,
    0.036_927_755_143_369_93,
    0.017_343_061_984_449_14,
    0.008_349_277_381_922_827,
    0.004_077_356_197_944_339,
    0.002_008_392_826_082_214_4,
    0.000_994_575_127_818_085_3,
    0.000_494_188_604_119_464_6,
    0.000_246_086_553_308_048_3,
    0.000_122_713_347_578_489_15,
    6.124_813_505_870_483e-5,
    3.058_823_630_702_049e-5,
    1.528_225_940_865_187e-5,
    7.637_197_637_899_762e-6,
    3.817_293_264_999_84e-6,
    1.908_212_716_553_939e-6,
    9.539_620_338_727_962e-7,
];

/// One minus the Euler-Mascheroni constant.
const ONE_MINUS_EULER: f64 = 0.422_784_335_098_467_14;

/// The logarithm of the gamma function, for `x > 0` (`NaN` otherwise).
#[must_use]
pub fn ln_gamma(x: f64) -> f64 {
    if x.is_nan() || x <= 0.0 {
        return f64::NAN;
    }
    if (x - 1.0).abs() < 0.25 {
        return ln_gamma_two_plus(x - 1.0) - (x - 1.0).ln_1p();
    }
    if (x - 2.0).abs() < 0.25 {
        return ln_gamma_two_plus(x - 2.0);
    }
    (x - 0.5) * x.ln() - x + 0.5 * TAU.ln() + stirling_error(x)
}

/// `ln Gamma(2 + t)` for `|t| <= 1/4`, relatively accurate through its zero at `t = 0`.
fn ln_gamma_two_plus(t: f64) -> f64 {
    let mut power = t;
    let mut sum = ONE_MINUS_EULER * t;
    for (index, zeta) in ZETA_MINUS_ONE.iter().enumerate() {
        power *= -t;
        sum -= zeta * power / (index + 2) as f64;
    }
    sum
}

/// The regularised lower incomplete gamma function `P(a, x)`, for `a > 0` and `x >= 0`.
#[must_use]
pub fn gamma_p(a: f64, x: f64) -> f64 {
    tails(a, x).0
}

/// The regularised upper incomplete gamma function `Q(a, x)`, for `a > 0` and `x >= 0`.
#[must_use]
pub fn gamma_q(a: f64, x: f64) -> f64 {
    tails(a, x).1
}

/// Survival function of the chi-squared distribution with `degrees` degrees of freedom:
/// `P(X > statistic)`.
#[must_use]
pub fn chi_squared_sf(statistic: f64, degrees: f64) -> f64 {
    gamma_q(0.5 * degrees, 0.5 * statistic)
}

/// `P(a, x)` and `Q(a, x)`, each accurate where it is small.
fn tails(a: f64, x: f64) -> (f64, f64) {
    if a.is_nan() || x.is_nan() || a <= 0.0 {
        return (f64::NAN, f64::NAN);
    }
    if x <= 0.0 {
        return (0.0, 1.0);
    }
    if x.is_infinite() {
        return (1.0, 0.0);
    }
    let factor = (-stirling_error(a) - deviance(a, x)).exp() / (TAU * a).sqrt();
    if x < a + 1.0 {
        let lower = factor * lower_series(a, x);
        (lower, 1.0 - lower)
    } else {
        let upper = factor * a * upper_fraction(a, x);
        (1.0 - upper, upper)
    }
}

/// `1 + x/(a+1) + x^2/((a+1)(a+2)) + ...`
fn lower_series(a: f64, x: f64) -> f64 {
    let (mut term, mut sum, mut divisor) = (1.0, 1.0, a);
    while term > sum * f64::EPSILON * 0.25 {
        divisor += 1.0;
        term *= x / divisor;
        sum += term;
    }
    sum
}

/// `1/(x+1-a - 1(1-a)/(x+3-a - 2(2-a)/(x+5-a - ...)))`
fn upper_fraction(a: f64, x: f64) -> f64 {
    const TINY: f64 = 1e-300;
    let limit = 1000.0 + 100.0 * a.sqrt();
    let mut b = x + 1.0 - a;
    let mut c = 1.0 / TINY;
    let mut d = 1.0 / b;
    let mut value = d;
    let mut index = 1.0;
    while index < limit {
        let numerator = -index * (index - a);
        b += 2.0;
        d = 1.0 / nonzero(numerator * d + b);
        c = nonzero(b + numerator / c);
        let change = c * d;
        value *= change;
        if (change - 1.0).abs() < f64::EPSILON {
            break;
        }
        index += 1.0;
    }
    value
}

/// Keeps Lentz's method away from a division by zero.
pub(super) fn nonzero(value: f64) -> f64 {
    if value.abs() < 1e-300 { 1e-300 } else { value }
}
