//! Densities of counts by Loader's saddle-point form.
//!
//! ```text
//! pmf(k; n, p) = sqrt(n / (2 pi k (n-k)))
//!                * exp(d(n) - d(k) - d(n-k) - D(k, np) - D(n-k, nq))
//! d(z)    = ln Gamma(z+1) - (z + 1/2) ln z + z - ln(2 pi)/2       (error of Stirling's formula)
//! D(x, m) = x ln(x/m) + m - x                                     (deviance)
//! ```
//!
//! Source: C. Loader, "Fast and accurate computation of binomial probabilities" (2000).
//! Deviations: `d` is given for real arguments, by its asymptotic series from 10 upwards and by
//! the recurrence `d(z) = d(z+1) + (z + 1/2) ln(1 + 1/z) - 1` below; the difference `k - np` is
//! formed once with a fused multiply-add and shared by both deviances, so that the result stays
//! accurate when `np` is 10^8. Cost: a few logarithms. Guarantee: relative error near 1e-14
//! times one plus the deviance.
//!
//! # Assumes
//! Nothing of the data.

use std::f64::consts::TAU;

/// Coefficients `B_2k / (2k (2k-1))` of Stirling's series, k = 1..=8.
const STIRLING: [f64; 8] = [
    1.0 / 12.0,
    -1.0 / 360.0,
    1.0 / 1260.0,
    -1.0 / 1680.0,
    1.0 / 1188.0,
    -691.0 / 360_360.0,
    1.0 / 156.0,
    -3617.0 / 122_400.0,
];

/// Where Stirling's series takes over: its eighth term is below 1e-16 from here on.
const SERIES_FROM: f64 = 12.0;

/// The error of Stirling's formula, `ln Gamma(z+1) - (z + 1/2) ln z + z - ln(2 pi)/2`, `z > 0`.
#[must_use]
pub fn stirling_error(z: f64) -> f64 {
    let mut sum = 0.0;
    let mut shifted = z;
    while shifted < SERIES_FROM {
        sum += (shifted + 0.5) * (1.0 / shifted).ln_1p() - 1.0;
        shifted += 1.0;
    }
    let inverse = 1.0 / shifted;
    let square = inverse * inverse;
    let series = STIRLING
        .iter()
        .rev()
        .fold(0.0, |tail, term| tail * square + term);
    sum + series * inverse
}

/// The deviance `x ln(x/m) + m - x`, for `x >= 0` and `m > 0`; zero when `x == m`.
#[must_use]
pub fn deviance(x: f64, m: f64) -> f64 {
    deviance_from(x, m, x - m)
}

/// `deviance(m + k, m)`, to full precision however small `k` is beside `m`.
pub(crate) fn deviance_of_sum(k: f64, m: f64) -> f64 {
    deviance_from(m + k, m, k)
}

/// [`deviance`] for a caller that knows `x - m` better than a subtraction would.
pub(super) fn deviance_from(x: f64, m: f64, difference: f64) -> f64 {
    if x <= 0.0 {
        return m;
    }
    let v = difference / (x + m);
    if v.abs() > 0.1 {
        return x * (x / m).ln() - difference;
    }
    // ln(x/m) = 2 atanh(v), and the leading terms combine to (x - m) v without cancellation.
    let square = v * v;
    let mut power = 2.0 * x * v;
    let mut sum = difference * v;
    let mut order = 1.0;
    loop {
        power *= square;
        order += 2.0;
        let next = sum + power / order;
        // What is no number never settles.
        if next == sum || next.is_nan() {
            return next;
        }
        sum = next;
    }
}

/// `Gamma(a+b+1) / (Gamma(a+1) Gamma(b+1)) x^a y^b` for real `a, b > 0` and `x + y = 1`, the
/// binomial density continued to real counts.
pub(super) fn binomial_density(a: f64, b: f64, x: f64, y: f64) -> f64 {
    let n = a + b;
    // a - n x from the smaller of x and y, whose rounding error is the smaller one.
    let difference = if x <= y {
        (-n).mul_add(x, a)
    } else {
        -(-n).mul_add(y, b)
    };
    let exponent = stirling_error(n)
        - stirling_error(a)
        - stirling_error(b)
        - deviance_from(a, n * x, difference)
        - deviance_from(b, n * y, -difference);
    (n / (TAU * a * b)).sqrt() * exponent.exp()
}

/// Probability of exactly `successes` in `trials` at success probability `p` in `[0, 1]`.
#[must_use]
pub fn binomial_pmf(successes: u64, trials: u64, p: f64) -> f64 {
    if successes > trials {
        return 0.0;
    }
    let (a, b) = (successes as f64, (trials - successes) as f64);
    let q = 1.0 - p;
    match (successes, trials - successes) {
        (0, 0) => 1.0,
        (0, _) => (b * (-p).ln_1p()).exp(),
        (_, 0) => (a * p.ln()).exp(),
        _ if p <= 0.0 || q <= 0.0 => 0.0,
        _ => binomial_density(a, b, p, q),
    }
}

/// Probability of drawing `hits` marked items when `drawn` items are taken without replacement
/// from `total` items of which `marked` are marked.
///
/// Formed from three binomial densities at `p = drawn / total` (Loader 2000, section 5), so that
/// no factorial of the total is ever taken.
#[must_use]
pub fn hypergeometric_pmf(hits: u64, marked: u64, drawn: u64, total: u64) -> f64 {
    let possible = marked <= total
        && drawn <= total
        && hits <= marked
        && hits <= drawn
        && drawn - hits <= total - marked;
    if !possible {
        return 0.0;
    }
    if drawn == 0 || drawn == total {
        return 1.0;
    }
    let p = drawn as f64 / total as f64;
    let from_marked = binomial_pmf(hits, marked, p);
    let from_rest = binomial_pmf(drawn - hits, total - marked, p);
    from_marked * from_rest / binomial_pmf(drawn, total, p)
}
